//! `fairform limit`.

use std::process::ExitCode;

use fairform::{Vec3, limit};
use serde_json::json;

use crate::args::Limit;
use crate::console::{Console, count};
use crate::failure::Failure;
use crate::input::{self, Source};
use crate::rules;
use crate::surface::Surface;

pub(crate) fn run(args: &Limit, console: &Console) -> Result<ExitCode, Failure> {
    let named_json = input::is_json(&args.output);
    let as_json = args.writing.to.is_none() && (named_json || input::is_dash(&args.output));
    if !as_json {
        input::check_mesh(&args.output, &args.writing)?;
    }
    input::check_outputs(&[&args.output], console)?;
    let source = Source::from(&args.input);
    let mut surface = Surface::new(input::read(&source, console)?, &source)?;
    rules::set(args.scheme.chosen(), &args.rules, &mut surface, console)?;
    let vertices = surface.mesh.positions().len();
    let at = |e| surface.failure(&source, &e);
    if as_json {
        let (topology, control) = (surface.mesh.topology(), surface.mesh.positions());
        let points = limit::limit_points(topology, control, &surface.rules).map_err(at)?;
        let normals = limit::limit_normals(topology, control, &surface.rules).map_err(at)?;
        let list = |values: Vec<Vec3>| values.into_iter().map(<[f64; 3]>::from).collect::<Vec<_>>();
        let text = json!({ "points": list(points), "normals": list(normals) }).to_string();
        input::save(&args.output, text.as_bytes())?;
    } else {
        let mut limit = surface.clone();
        limit.move_to_limit().map_err(at)?;
        input::write(&args.output, &args.writing, &limit.into_surface(), console)?;
    }
    console.detail(format!("{} limit points", count(vertices)));
    console.result(&json!({ "vertices": vertices }))?;
    Ok(ExitCode::SUCCESS)
}
