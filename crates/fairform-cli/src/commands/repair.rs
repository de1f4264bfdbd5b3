//! `fairform repair`.

use std::process::ExitCode;

use fairform::repair::Soup;
use fairform::{Error, Mesh, NONE, Vec3};
use fairform_io::{Labels, MeshData};
use serde_json::json;

use crate::args::Repair;
use crate::console::Console;
use crate::failure::Failure;
use crate::input::{self, Source};
use crate::steps::{self, Steps};

pub(crate) fn run(args: &Repair, console: &Console) -> Result<ExitCode, Failure> {
    input::check_mesh(&args.output, &args.writing)?;
    input::check_outputs(&[&args.output], console)?;
    let steps = steps(args);
    if steps == Steps::default() {
        return Err(Failure::usage("no repair step is asked for")
            .help("name steps, for example --weld 0 --orient --split; or --all"));
    }
    let data = input::read(&Source::from(&args.input), console)?;
    let mut soup = Soup::new(data.positions.clone(), data.faces.clone());
    let done = steps.run(&mut soup).map_err(|e| Failure::new(e.to_string()))?;
    let done: Vec<String> = done.into_iter().map(|step| step.words).collect();
    for line in &done {
        console.note(line);
    }
    let keeps_numbers = soup.vertex_source.iter().copied().eq(0..data.positions.len() as u32);
    let mut creases = data.creases.clone().filter(|_| keeps_numbers);
    if let Some(creases) = &mut creases {
        let keeps_faces = soup.face_source.iter().copied().eq(0..data.faces.len() as u32);
        creases.holes.retain(|_| keeps_faces);
    }
    if creases != data.creases {
        console.note("note: crease tags left out where vertices or faces have new numbers");
    }
    let repaired = MeshData { creases, ..follow(data, soup) };
    let sound = Mesh::new(repaired.positions.clone(), &repaired.faces);
    judge(&repaired, sound.as_ref(), console);
    input::write(&args.output, &args.writing, &repaired, console)?;
    console.result(&json!({
        "steps": done,
        "vertices": repaired.positions.len(),
        "faces": repaired.faces.len(),
        "manifold": sound.is_ok(),
    }))?;
    Ok(ExitCode::SUCCESS)
}

fn steps(args: &Repair) -> Steps {
    Steps {
        weld: args.weld.or(args.all.then_some(0.0)),
        drop_degenerate: args.drop_degenerate || args.all,
        drop_duplicates: args.drop_duplicates || args.all,
        orient: args.orient || args.all,
        split: args.split || args.all,
        fill_holes: args.fill_holes,
        outward: args.outward,
        triangulate: args.triangulate,
        drop_isolated: args.drop_isolated || args.all,
    }
}

/// Says what the result is good for.
fn judge(repaired: &MeshData, sound: Result<&Mesh, &Error>, console: &Console) {
    let more = || steps::remedy(&repaired.positions, &repaired.faces);
    match sound {
        _ if repaired.faces.is_empty() => console.note("warning: no face is left"),
        Ok(mesh) if mesh.topology().uniform_face_size() == Some(3) => {
            console.note("the result is a manifold mesh of triangles");
        }
        Ok(_) => console.note(
            "the result is a manifold mesh of polygons; --triangulate would cut them for \
             `fairform fit`",
        ),
        Err(error) => {
            console.note(format!("warning: still not a manifold: {error} [counted from 0]"));
            if let Some(steps) = more() {
                console.note(format!("help: add {steps}"));
            }
        }
    }
}

/// Lets attributes and labels follow the vertices, corners and faces.
fn follow(data: MeshData, soup: Soup) -> MeshData {
    fn gather<T: Clone>(values: Option<Vec<T>>, source: &[u32], new: &T) -> Option<Vec<T>> {
        let values = values?;
        let one = |&s: &u32| if s == NONE { new.clone() } else { values[s as usize].clone() };
        Some(source.iter().map(one).collect())
    }
    let labels = |labels: Option<Labels>| {
        let mut labels = labels?;
        if soup.face_source.contains(&NONE) {
            labels.names.push("filled".into());
        }
        let filled = labels.names.len() as u32 - 1;
        let of_face = gather(Some(labels.of_face), &soup.face_source, &filled)?;
        Some(Labels { names: labels.names, of_face })
    };
    MeshData {
        normals: gather(data.normals, &soup.vertex_source, &Vec3::ZERO),
        colours: gather(data.colours, &soup.vertex_source, &[1.0; 4]),
        uvs: gather(data.uvs, &soup.vertex_source, &[0.0; 2]),
        corner_normals: gather(data.corner_normals, &soup.corner_source, &Vec3::ZERO),
        corner_uvs: gather(data.corner_uvs, &soup.corner_source, &[0.0; 2]),
        groups: labels(data.groups),
        materials: labels(data.materials),
        material_library: data.material_library,
        creases: None,
        notes: Vec::new(),
        positions: soup.positions,
        faces: soup.faces,
    }
}
