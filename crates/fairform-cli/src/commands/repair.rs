//! `fairform repair`.

use std::fmt::Display;
use std::process::ExitCode;

use fairform::repair::Soup;
use fairform::{Mesh, NONE, Vec3};
use fairform_io::{Labels, MeshData};
use serde_json::json;

use crate::args::Repair;
use crate::console::Console;
use crate::failure::Failure;
use crate::input;

pub(crate) fn run(args: &Repair, console: &Console) -> Result<ExitCode, Failure> {
    input::check_output(&args.output, &args.writing)?;
    let steps = Steps::new(args);
    if steps == Steps::default() {
        return Err(Failure::new("no repair step is asked for")
            .help("name steps, for example --weld 0 --orient --split; or --all"));
    }
    let name = input::name(&args.input.input);
    let data = input::read(&args.input, console)?;
    let mut soup = Soup::new(data.positions.clone(), data.faces.clone());
    let done = steps.run(&mut soup)?;
    for line in &done {
        console.note(line);
    }
    let repaired = follow(data, soup);
    let verdict = Mesh::new(repaired.positions.clone(), &repaired.faces);
    match &verdict {
        Ok(_) => console.note("the result is a manifold mesh"),
        Err(error) => console.note(format!("warning: {name}, repaired: {error}")),
    }
    input::write(&args.output, &args.writing, &repaired, console)?;
    console.result(&json!({
        "steps": done,
        "vertices": repaired.positions.len(),
        "faces": repaired.faces.len(),
        "manifold": verdict.is_ok(),
    }))?;
    Ok(ExitCode::SUCCESS)
}

/// The steps, in the order in which they are made.
#[expect(clippy::struct_excessive_bools, reason = "one switch per step")]
#[derive(Default, PartialEq)]
struct Steps {
    weld: Option<f64>,
    drop_degenerate: bool,
    drop_duplicates: bool,
    orient: bool,
    split: bool,
    fill_holes: Option<usize>,
    outward: bool,
    triangulate: bool,
    drop_isolated: bool,
}

impl Steps {
    fn new(args: &Repair) -> Self {
        Self {
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

    /// What each step did, in words.
    fn run(&self, soup: &mut Soup) -> Result<Vec<String>, Failure> {
        let mut done = Vec::new();
        let mut say = |step: &str, report: &dyn Display| done.push(format!("{step}: {report}"));
        if let Some(distance) = self.weld {
            let report = soup.weld(distance).map_err(|e| Failure::new(e.to_string()))?;
            say("weld", &report);
        }
        if self.drop_degenerate {
            say("drop degenerate", &soup.drop_degenerate());
        }
        if self.drop_duplicates {
            say("drop duplicates", &soup.drop_duplicates());
        }
        if self.orient {
            say("orient", &soup.orient());
        }
        if self.split {
            say("split", &soup.split_non_manifold());
        }
        if let Some(edges) = self.fill_holes {
            say("fill holes", &soup.fill_holes(edges));
        }
        if self.outward {
            say("outward", &soup.orient_outward());
        }
        if self.triangulate {
            say("triangulate", &soup.triangulate());
        }
        if self.drop_isolated {
            say("drop isolated", &soup.drop_isolated());
        }
        Ok(done)
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
        corner_uvs: gather(data.corner_uvs, &soup.corner_source, &[0.0; 2]),
        groups: labels(data.groups),
        materials: labels(data.materials),
        material_library: data.material_library,
        notes: Vec::new(),
        positions: soup.positions,
        faces: soup.faces,
    }
}
