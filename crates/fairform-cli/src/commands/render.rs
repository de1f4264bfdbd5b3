//! `fairform render`.

use std::ops::ControlFlow;
use std::path::Path;
use std::process::ExitCode;

use fairform::interpolate;
use fairform::{Scheme, fairness};
use fairform_io::MeshData;
use fairform_render::{
    Body, Colour, ColourMap, Dot, Line, Options, Panel, Part, Surface as SurfaceLook, Values, View,
};
use serde_json::json;

use crate::args::{ColourChoice, Panels, Render};
use crate::commands::fit::fitted;
use crate::console::Console;
use crate::failure::Failure;
use crate::input::{self, Source};
use crate::rules;
use crate::surface::{Finish, Surface, check_memory};

mod model;

use model::Sheet;

pub(crate) fn run(args: &Render, console: &Console) -> Result<ExitCode, Failure> {
    check_picture(&args.output)?;
    input::check_outputs(&[&args.output], console)?;
    let mut models = Vec::new();
    for path in args.inputs.iter().filter(|path| model::is_model(path)) {
        models.push((path, fairform_io::streamline::read_any(path)?));
    }
    let said = || models.iter().find_map(|(path, contents)| model::view(path, contents, console));
    let view = args.view.or_else(said).unwrap_or_default();
    let mut models = models.iter();
    let mut sheets = Vec::new();
    for path in &args.inputs {
        if model::is_model(path) {
            let contents = models.next().map(|(_, contents)| contents);
            sheets.extend(contents.map_or(Ok(vec![]), |c| model::sheets(path, c, args, &view))?);
        } else {
            let data = input::read(&Source { path, format: args.from }, console)?;
            sheets.push(Sheet::of_mesh(path, data));
        }
    }
    let mut meshes: Vec<MeshData> =
        sheets.iter_mut().map(|sheet| std::mem::take(&mut sheet.data)).collect();
    model::check(args, &sheets)?;
    let mut tensions = vec![None; meshes.len()];
    if let Some(scheme) = args.scheme.or(args.fit.then_some(Scheme::Loop)) {
        let all = meshes.iter_mut().zip(&mut tensions).zip(&sheets);
        for ((data, tension), sheet) in all {
            let source = Source { path: sheet.path, format: args.from };
            (*data, *tension) = surface_of(args, scheme, std::mem::take(data), &source, console)?;
        }
    } else if let Some(option) = args.rules.made().or(args.levels.map(|_| "--levels")) {
        return Err(Failure::usage(format!("{option} is for a surface that is made here"))
            .help("name the --scheme, or --fit"));
    } else if args.colour == Some(ColourChoice::Tension) {
        for ((data, tension), sheet) in meshes.iter().zip(&mut tensions).zip(&sheets) {
            let surface =
                Surface::new(data.clone(), &Source { path: sheet.path, format: args.from })?;
            *tension = rules::tension(&args.rules.tension, &surface)?;
        }
    }
    let values = values(args, &meshes, &sheets, tensions, console)?;
    let panels: Vec<Panel> = meshes
        .iter()
        .enumerate()
        .map(|(i, data)| panel(args, i, data, &sheets[i], values[i].as_ref()))
        .collect();
    let background = if args.transparent { Colour::TRANSPARENT } else { Colour::WHITE };
    // A sphere stands on no ground, and nothing is in its light.
    let solid = args.model.sphere.is_none();
    let shared = !args.separate;
    let options =
        Options { background, shared, ground: solid, shadows: solid, ..Options::default() };
    let view = View { zoom: args.zoom, ..view };
    let progress = console.progress();
    progress.say("drawing");
    let picture = fairform_render::render(&panels, &view, args.size, &options)?;
    input::save(&args.output, &picture.to_png())?;
    drop(progress);
    console.result(&json!({ "width": picture.width, "height": picture.height }))?;
    Ok(ExitCode::SUCCESS)
}

/// The limit surface that a scheme makes of a mesh, as its control mesh or fitted to it; and the shape
/// parameters of its faces.
fn surface_of(
    args: &Render,
    scheme: Scheme,
    data: MeshData,
    source: &Source,
    console: &Console,
) -> Result<(MeshData, Option<Vec<f64>>), Failure> {
    let levels = args.levels.unwrap_or(3);
    let mut surface = Surface::new(data, source)?;
    rules::set(scheme, &args.rules, &mut surface, console)?;
    check_memory(&surface, levels, surface.stored(levels, Finish::Limit, false), source)?;
    let at = |e| surface.failure(source, &e);
    let progress = console.progress();
    let (control, levels) = if args.fit {
        let options =
            interpolate::Options { exact: args.exact, fair: args.fair, ..Default::default() };
        progress.say("fitting");
        let mut go_on = |_, _| ControlFlow::Continue(());
        let fitted = fitted(&surface, &options, &mut go_on, &progress).map_err(at)?;
        if !fitted.report.is_converged() {
            let error = fitted.report.max;
            console.note(format!(
                "warning: {source}: not converged: the largest error is {error:.3e}"
            ));
        }
        (fitted.control, levels.saturating_sub(fitted.level))
    } else {
        (surface.clone(), levels)
    };
    let mut origins = Vec::new();
    let data = control.refined(levels, Finish::Limit, &progress, Some(&mut origins)).map_err(at)?;
    let of_face = |tension: &[f64]| origins.iter().map(|&f| tension[f as usize]).collect();
    Ok((data, surface.rules.tension.as_deref().map(of_face)))
}

/// Only PNG is written.
pub(crate) fn check_picture(path: &Path) -> Result<(), Failure> {
    let is_png = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    if is_png || input::is_dash(path) {
        return Ok(());
    }
    Err(Failure::usage(format!("{}: pictures are PNG", path.display()))
        .help("let the name end in .png"))
}

/// Numbers to colour a mesh by.
struct Numbers {
    of: Vec<f64>,
    per_face: bool,
    map: ColourMap,
    legend: &'static str,
}

/// The numbers of each mesh that the colouring asks for.
fn values(
    args: &Render,
    meshes: &[MeshData],
    sheets: &[Sheet],
    tensions: Vec<Option<Vec<f64>>>,
    console: &Console,
) -> Result<Vec<Option<Numbers>>, Failure> {
    let reference = match (&args.reference, args.colour) {
        (Some(path), _) => {
            let source = Source { path, format: None };
            Some(Surface::new(input::read(&source, console)?, &source)?.mesh)
        }
        (None, Some(ColourChoice::Error)) => {
            return Err(Failure::usage("--colour error needs a mesh to compare with")
                .help("name it with --reference MESH"));
        }
        _ => None,
    };
    let one = |((data, sheet), tension): ((&MeshData, &Sheet), Option<Vec<f64>>)| {
        let Some(choice) = args.colour else { return Ok(None) };
        let source = Source { path: sheet.path, format: args.from };
        let (of, per_face, map, legend) = match choice {
            ColourChoice::Zebra | ColourChoice::Reflection => return Ok(None),
            ColourChoice::Curvature | ColourChoice::Mean | ColourChoice::Gaussian => {
                let mesh = Surface::new(data.clone(), &source)?.mesh;
                let (topology, points) = (mesh.topology(), mesh.positions());
                let normals = match &data.normals {
                    Some(given) => given.clone(),
                    None => fairness::fitted_normals(topology, points),
                };
                let curvatures = fairness::curvatures(topology, points, &normals);
                let is_gaussian = choice == ColourChoice::Gaussian;
                let number = |c: &fairness::Curvature| {
                    if is_gaussian { c.gaussian() } else { c.mean() }
                };
                let legend = if is_gaussian { "Gaussian curvature" } else { "mean curvature" };
                (curvatures.iter().map(number).collect(), false, ColourMap::CoolWarm, legend)
            }
            ColourChoice::Error => {
                let reference = reference.as_ref().expect("checked above");
                let distances = fairness::distances(&data.positions, reference);
                (distances, false, ColourMap::Viridis, "distance to the mesh")
            }
            ColourChoice::Tension => {
                let Some(tension) = tension else {
                    return Err(Failure::usage("--colour tension needs shape parameters")
                        .help("give them with --lambda or --tension-where"));
                };
                (tension, true, ColourMap::Viridis, "tension")
            }
        };
        Ok(Some(Numbers { of, per_face, map, legend }))
    };
    meshes.iter().zip(sheets).zip(tensions).map(one).collect()
}

fn panel<'a>(
    args: &Render,
    i: usize,
    data: &'a MeshData,
    sheet: &'a Sheet,
    numbers: Option<&'a Numbers>,
) -> Panel<'a> {
    let mut body = Body::new(&data.positions, &data.faces);
    body.normals = data.normals.as_deref();
    body.corner_normals = data.corner_normals.as_deref();
    body.colours = data.colours.as_deref();
    let wants = |choice: &Option<Panels>| Panels::has(choice.as_ref(), i);
    body.style.smooth = !wants(&args.flat);
    body.style.wireframe = wants(&args.wireframe).then(Line::default);
    body.style.points = wants(&args.points).then(Dot::default);
    let red = Line { colour: Colour::RED, width: 5.0 };
    body.style.boundary = wants(&args.draw_boundary).then_some(red);
    body.values = numbers.map(|n| {
        let values = if n.per_face { Values::per_face(&n.of) } else { Values::per_vertex(&n.of) };
        Values { map: n.map, range: args.range, legend: Some(n.legend), ..values }
    });
    match args.colour {
        Some(ColourChoice::Zebra) => body.style.surface = SurfaceLook::ZEBRA,
        Some(ColourChoice::Reflection) => body.style.surface = SurfaceLook::REFLECTION,
        _ => {}
    }
    body.strokes = &sheet.strokes;
    if !sheet.shown {
        body.style.fill = None;
    }
    let name = || sheet.path.file_name().map(|name| name.to_string_lossy().into_owned());
    let file = if args.inputs.len() > 1 { name() } else { None };
    let depth = sheet.depth.map(|depth| format!("depth {depth}"));
    let title = match (args.title.get(i), file, depth) {
        (Some(title), _, _) => Some(title.clone()),
        (None, Some(file), Some(depth)) => Some(format!("{file}\n{depth}")),
        (None, file, depth) => file.or(depth),
    };
    let parts = sheet.parts.iter().map(Part::body);
    Panel { bodies: std::iter::once(body).chain(parts).collect(), title }
}
