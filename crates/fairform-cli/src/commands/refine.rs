//! `fairform refine`.

use std::process::ExitCode;

use serde_json::json;

use crate::args::Refine;
use crate::console::{Console, count};
use crate::failure::Failure;
use crate::input::{self, Source};
use crate::rules;
use crate::surface::{Finish, Nearness, Stored, Surface, check_memory};

pub(crate) fn run(args: &Refine, console: &Console) -> Result<ExitCode, Failure> {
    input::check_mesh(&args.output, &args.writing)?;
    input::check_outputs(&[&args.output], console)?;
    let source = Source::from(&args.input);
    let mut surface = Surface::new(input::read(&source, console)?, &source)?;
    rules::set(args.scheme.chosen(), &args.rules, &mut surface, console)?;
    surface.warn_of_no_faces(&source, console);
    if let Some(tolerance) = args.adaptive {
        let nearness = Nearness { tolerance, eye: args.eye };
        return adaptive(args, &surface, nearness, &source, console);
    }
    let finish = if args.limit { Finish::Limit } else { Finish::Control };
    let streams = surface.can_stream(args.levels, finish, &args.output, &args.writing);
    let stored = surface.stored(args.levels, finish, streams);
    check_memory(&surface, args.levels, stored, &source)?;
    let at = |e| surface.failure(&source, &e);
    let progress = console.progress();
    progress.say("refining");
    let tessellation = match streams {
        true => Some(surface.tessellation(args.levels, finish).map_err(at)?),
        false => None,
    };
    let made = surface.made(args.levels, finish, tessellation.as_ref(), &progress).map_err(at)?;
    progress.say("writing");
    let (vertices, faces) = made.write(&args.output, &args.writing, console)?;
    drop(progress);
    console.detail(format!("{} vertices, {} faces", count(vertices), count(faces)));
    console.result(&json!({ "vertices": vertices, "faces": faces }))?;
    Ok(ExitCode::SUCCESS)
}

/// Writes a mesh that is fine where the surface is curved.
fn adaptive(
    args: &Refine,
    surface: &Surface,
    nearness: Nearness,
    source: &Source,
    console: &Console,
) -> Result<ExitCode, Failure> {
    // If it must be fine everywhere.
    check_memory(surface, args.levels, Stored::Result, source)?;
    if surface.has_fields() {
        console.note("note: colours and texture coordinates left out by --adaptive");
    }
    let progress = console.progress();
    progress.say("refining where it is curved");
    let made = surface.adaptive(args.levels, nearness).map_err(|e| surface.failure(source, &e))?;
    progress.say("writing");
    input::write(&args.output, &args.writing, &made.data, console)?;
    drop(progress);
    let (vertices, faces) = (made.data.positions.len(), made.data.faces.len());
    console.detail(format!("{} vertices, {} faces", count(vertices), count(faces)));
    if made.at_limit > 0.0 {
        let share = match 100.0 * made.at_limit {
            percent if percent < 0.1 => "less than 0.1".into(),
            percent => format!("{percent:.1}"),
        };
        console.note(format!(
            "note: {share} % of the surface is as fine as {} levels make it, and may be farther off \
             than asked for; more --levels help",
            args.levels
        ));
    }
    console.result(&json!({
        "vertices": vertices, "faces": faces, "share_at_limit": made.at_limit,
    }))?;
    Ok(ExitCode::SUCCESS)
}
