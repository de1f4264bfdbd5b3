//! `fairform refine`.

use std::process::ExitCode;

use serde_json::json;

use crate::args::Refine;
use crate::console::{Console, count};
use crate::failure::Failure;
use crate::input::{self, Source};
use crate::rules;
use crate::surface::{Surface, check_memory};

pub(crate) fn run(args: &Refine, console: &Console) -> Result<ExitCode, Failure> {
    input::check_mesh(&args.output, &args.writing)?;
    input::check_outputs(&[&args.output], console)?;
    let source = Source::from(&args.input);
    let mut surface = Surface::new(input::read(&source, console)?, &source)?;
    rules::set(args.scheme.scheme, &args.rules, &mut surface, console)?;
    surface.warn_of_no_faces(&source, console);
    check_memory(&surface, args.levels, &source)?;
    let at = |e| surface.failure(&source, &e);
    let progress = console.progress();
    let mut fine = surface.refine(args.levels, &progress).map_err(at)?;
    if args.limit {
        fine.move_to_limit().map_err(at)?;
    }
    progress.say("writing");
    let is_control = args.levels == 0 && !args.limit;
    let data = if is_control { fine.into_control() } else { fine.into_surface() };
    input::write(&args.output, &args.writing, &data, console)?;
    drop(progress);
    let (vertices, faces) = (data.positions.len(), data.faces.len());
    console.detail(format!("{} vertices, {} faces", count(vertices), count(faces)));
    console.result(&json!({ "vertices": vertices, "faces": faces }))?;
    Ok(ExitCode::SUCCESS)
}
