//! `fairform refine`.

use std::process::ExitCode;

use serde_json::json;

use crate::args::Refine;
use crate::console::{Console, count};
use crate::failure::{Failure, in_file};
use crate::input;
use crate::surface::{Surface, check_memory};

pub(crate) fn run(args: &Refine, console: &Console) -> Result<ExitCode, Failure> {
    input::check_output(&args.output, &args.writing)?;
    let name = input::name(&args.input.input);
    let (scheme, corners) = (args.rules.scheme, args.rules.corners());
    let surface = Surface::new(input::read(&args.input, console)?, &name)?;
    check_memory(&surface.mesh, scheme, args.levels, &name)?;
    let progress = console.progress();
    let mut fine =
        surface.refine(scheme, corners, args.levels, &progress).map_err(|e| in_file(&name, &e))?;
    if args.limit {
        fine.to_limit(scheme, corners).map_err(|e| in_file(&name, &e))?;
    }
    progress.say("writing");
    let data = fine.into_data();
    input::write(&args.output, &args.writing, &data, console)?;
    drop(progress);
    let (vertices, faces) = (data.positions.len(), data.faces.len());
    console.detail(format!("{} vertices, {} faces", count(vertices), count(faces)));
    console.result(&json!({ "vertices": vertices, "faces": faces }))?;
    Ok(ExitCode::SUCCESS)
}
