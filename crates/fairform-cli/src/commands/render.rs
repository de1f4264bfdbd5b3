//! `fairform render`.

use std::path::Path;
use std::process::ExitCode;

use fairform_io::MeshData;
use fairform_render::{Body, Colour, Dot, Line, Options, Panel, View};
use serde_json::json;

use crate::args::{Panels, Render};
use crate::console::Console;
use crate::failure::Failure;
use crate::input;

pub(crate) fn run(args: &Render, console: &Console) -> Result<ExitCode, Failure> {
    check_picture(&args.output)?;
    let read = |path: &std::path::PathBuf| input::read_file(path, args.from, console);
    let meshes = args.inputs.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let panels: Vec<Panel> =
        meshes.iter().enumerate().map(|(i, data)| panel(args, i, data)).collect();
    let background = if args.transparent { Colour::TRANSPARENT } else { Colour::WHITE };
    let options = Options { background, shared: !args.separate, ..Options::default() };
    let view = View { zoom: args.zoom, ..args.view };
    let progress = console.progress();
    progress.say("drawing");
    let picture = fairform_render::render(&panels, &view, args.size, &options)?;
    input::save(&args.output, &picture.to_png())?;
    drop(progress);
    console.result(&json!({ "width": picture.width, "height": picture.height }))?;
    Ok(ExitCode::SUCCESS)
}

/// Only PNG is written.
pub(crate) fn check_picture(path: &Path) -> Result<(), Failure> {
    let is_png = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    if is_png || input::is_dash(path) {
        return Ok(());
    }
    Err(Failure::new(format!("{}: pictures are PNG", path.display()))
        .help("let the name end in .png"))
}

fn panel<'a>(args: &Render, i: usize, data: &'a MeshData) -> Panel<'a> {
    let mut body = Body::new(&data.positions, &data.faces);
    body.normals = data.normals.as_deref();
    body.colours = data.colours.as_deref();
    let wants = |choice: &Option<Panels>| Panels::has(choice.as_ref(), i);
    body.style.smooth = !wants(&args.flat);
    body.style.wireframe = wants(&args.wireframe).then(Line::default);
    body.style.points = wants(&args.points).then(Dot::default);
    let red = Line { colour: Colour::RED, width: 5.0 };
    body.style.boundary = wants(&args.boundary).then_some(red);
    let title = match args.title.get(i) {
        Some(title) => Some(title.clone()),
        None if args.inputs.len() > 1 => {
            args.inputs[i].file_name().map(|name| name.to_string_lossy().into_owned())
        }
        None => None,
    };
    Panel { bodies: vec![body], title }
}
