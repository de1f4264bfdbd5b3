//! `fairform convert`.

use std::process::ExitCode;

use serde_json::json;

use crate::args::Convert;
use crate::console::{Console, count};
use crate::failure::Failure;
use crate::input;

pub(crate) fn run(args: &Convert, console: &Console) -> Result<ExitCode, Failure> {
    input::check_output(&args.output, &args.writing)?;
    let data = input::read(&args.input, console)?;
    input::write(&args.output, &args.writing, &data, console)?;
    let (vertices, faces) = (data.positions.len(), data.faces.len());
    console.detail(format!("{} vertices, {} faces", count(vertices), count(faces)));
    console.result(&json!({ "vertices": vertices, "faces": faces }))?;
    Ok(ExitCode::SUCCESS)
}
