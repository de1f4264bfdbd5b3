//! `fairform convert`.

use std::process::ExitCode;

use serde_json::json;

use crate::args::Convert;
use crate::console::{Console, count};
use crate::failure::Failure;
use crate::input::{self, Source};

pub(crate) fn run(args: &Convert, console: &Console) -> Result<ExitCode, Failure> {
    input::check_mesh(&args.output, &args.writing)?;
    input::check_outputs(&[&args.output], console)?;
    let data = input::read(&Source::from(&args.input), console)?;
    input::write(&args.output, &args.writing, &data, console)?;
    let (vertices, faces) = (data.positions.len(), data.faces.len());
    console.detail(format!("{} vertices, {} faces", count(vertices), count(faces)));
    console.result(&json!({ "vertices": vertices, "faces": faces }))?;
    Ok(ExitCode::SUCCESS)
}
