//! `fairform repair`.

use std::process::ExitCode;

use fairform::{Error, Mesh};
use fairform_io::MeshData;
use fairform_io::repair::{self, Steps};
use serde_json::json;

use crate::args::Repair;
use crate::console::Console;
use crate::failure::Failure;
use crate::input::{self, Source};

pub(crate) fn run(args: &Repair, console: &Console) -> Result<ExitCode, Failure> {
    input::check_mesh(&args.output, &args.writing)?;
    input::check_outputs(&[&args.output], console)?;
    let steps = steps(args);
    if steps == Steps::default() {
        return Err(Failure::usage("no repair step is asked for")
            .help("name steps, for example --weld 0 --orient --split; or --all"));
    }
    let data = input::read(&Source::from(&args.input), console)?;
    let (repaired, done) = repair::run(data, &steps).map_err(|e| Failure::new(e.to_string()))?;
    let done: Vec<String> = done.iter().map(ToString::to_string).collect();
    for line in &done {
        console.note(line);
    }
    for note in &repaired.notes {
        console.note(format!("note: {note}"));
    }
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
    let more = || repair::remedy(&repaired.positions, &repaired.faces, true);
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
