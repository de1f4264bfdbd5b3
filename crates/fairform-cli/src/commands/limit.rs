//! `fairform limit`.

use std::process::ExitCode;

use fairform::{Vec3, limit};
use serde_json::json;

use crate::args::Limit;
use crate::console::{Console, count};
use crate::failure::{Failure, in_file};
use crate::input;
use crate::surface::Surface;

pub(crate) fn run(args: &Limit, console: &Console) -> Result<ExitCode, Failure> {
    let as_json = args.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    if !as_json {
        input::check_output(&args.output, &args.writing)?;
    }
    let name = input::name(&args.input.input);
    let (scheme, corners) = (args.rules.scheme, args.rules.corners());
    let mut surface = Surface::new(input::read(&args.input, console)?, &name)?;
    let vertices = surface.mesh.positions().len();
    if as_json {
        let (topology, control) = (surface.mesh.topology(), surface.mesh.positions());
        let at = |e| in_file(&name, &e);
        let points = limit::limit_points(topology, control, scheme, corners).map_err(at)?;
        let normals = limit::limit_normals(topology, control, scheme, corners).map_err(at)?;
        let list = |values: Vec<Vec3>| values.into_iter().map(<[f64; 3]>::from).collect::<Vec<_>>();
        let text = json!({ "points": list(points), "normals": list(normals) }).to_string();
        input::save(&args.output, text.as_bytes())?;
    } else {
        surface.to_limit(scheme, corners).map_err(|e| in_file(&name, &e))?;
        input::write(&args.output, &args.writing, &surface.into_data(), console)?;
    }
    console.detail(format!("{} limit points", count(vertices)));
    console.result(&json!({ "vertices": vertices }))?;
    Ok(ExitCode::SUCCESS)
}
