//! `fairform streamline`.

use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;

use fairform::Vec3;
use fairform::sphere::blend;
use fairform::streamline::{BsplineSurface, Grid, InitialCurve, Model, Surface};
use fairform_io::Format;
use fairform_io::streamline::{self, Models, Patch};
use serde_json::{Value, json};

use crate::args::{Starter, Streamline};
use crate::console::{Console, count};
use crate::failure::Failure;
use crate::input::{self, Source};
use crate::models::{self, Statistics};

/// An example to edit.
const CAR: &[u8] = include_bytes!("../../../../data/streamline/car.streamline.json");

/// What is written.
#[derive(Clone, Copy, PartialEq)]
enum Output {
    Mesh,
    /// Refined tangents, parameters and points.
    Result,
    Model,
    /// B-spline surfaces as OBJ.
    SplinesObj,
    /// B-spline surfaces as JSON.
    SplinesJson,
}

pub(crate) fn run(args: &Streamline, console: &Console) -> Result<ExitCode, Failure> {
    let named = |path| what(args, path).map(|what| (path, what));
    let output = args.output.as_deref().map(named).transpose()?;
    if let Some((path, _)) = output {
        input::check_outputs(&[path], console)?;
        if args.stats && input::is_dash(path) {
            return Err(Failure::usage("--stats and `-o -` both want standard output"));
        }
    }
    let source = Source {
        path: args.input.as_deref().unwrap_or_else(|| "the new model".as_ref()),
        format: None,
    };
    let mut models = match (&args.input, args.new) {
        (Some(path), _) => streamline::read(path)?,
        (None, Some(starter)) => new(starter)?,
        (None, None) => return Err(Failure::usage("no model: name one, or take --new")),
    };
    models.patches.iter_mut().for_each(|patch| change(args, &mut patch.model));
    let mut surfaces = models::surfaces(&models, &source, console)?;
    let swap = |size| models::swap(&mut models, &mut surfaces, size, &source, console);
    let swapped = args.swap.map(swap).transpose()?;
    let fit = |tolerance| models::bsplines(&models, &surfaces, tolerance, &source, console);
    let splines = args.bspline.map(fit).transpose()?.unwrap_or_default();
    let (vertices, faces) = match output {
        Some((path, Output::Mesh)) => {
            let mesh = models::mesh(&surfaces, &models.patches)
                .map_err(|e| Failure::new(format!("{source}: {e}")))?;
            if mesh.faces.is_empty() {
                console.note(format!("warning: {source}: one streamline has no faces"));
            }
            input::write(path, &args.writing, &mesh, console)?;
            (mesh.positions.len(), mesh.faces.len())
        }
        Some((path, kind)) => {
            let save = |value: Value| input::save(path, value.to_string().as_bytes());
            match kind {
                Output::Model => streamline::write(path, &models)?,
                Output::SplinesObj => {
                    input::save(path, &models::bsplines_obj(&splines, &models.patches)?)?;
                }
                Output::SplinesJson => save(models::bsplines_json(&splines))?,
                _ => save(models::json(&surfaces))?,
            }
            sizes(&surfaces)
        }
        None => sizes(&surfaces),
    };
    let mut result = json!({ "vertices": vertices, "faces": faces });
    if let Some(distance) = swapped {
        result["swap"] = json!({ "distance": distance });
    }
    if args.bspline.is_some() {
        let one = |spline: &BsplineSurface| {
            let size = [spline.points.row_count(), spline.points.column_count()];
            json!({ "control_points": size, "deviation": spline.deviation })
        };
        result["bspline"] = splines.iter().map(one).collect();
    }
    report(args, &surfaces, [vertices, faces], result, console)?;
    Ok(ExitCode::SUCCESS)
}

/// What a name asks for.
fn what(args: &Streamline, path: &Path) -> Result<Output, Failure> {
    let name = path.to_string_lossy().to_ascii_lowercase();
    let plain = name.strip_suffix(".gz").unwrap_or(&name);
    let is_result = input::is_json(path) || input::is_dash(path);
    if args.bspline.is_some() {
        let is_model = name.ends_with(streamline::EXTENSION);
        return match args.writing.to {
            Some(Format::Obj) => Ok(Output::SplinesObj),
            None if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj")) => {
                Ok(Output::SplinesObj)
            }
            None if is_result && !is_model => Ok(Output::SplinesJson),
            _ => Err(Failure::usage("a B-spline surface is written as OBJ or JSON")
                .help("let the name end in .obj or .json, but not in .streamline.json")),
        };
    }
    if args.writing.to.is_some() || Format::from_path(path).is_some() {
        return Ok(Output::Mesh);
    }
    if plain.ends_with(streamline::EXTENSION) || (args.input.is_none() && is_result) {
        return Ok(Output::Model);
    }
    if is_result {
        return Ok(Output::Result);
    }
    input::check_mesh(path, &args.writing).map(|()| Output::Mesh)
}

/// Vertices and faces of the mesh of all surfaces.
fn sizes(surfaces: &[Surface]) -> (usize, usize) {
    let joined = models::joined(surfaces);
    (joined.positions.len(), joined.faces.len())
}

fn report(
    args: &Streamline,
    surfaces: &[Surface],
    [vertices, faces]: [usize; 2],
    mut result: Value,
    console: &Console,
) -> Result<(), Failure> {
    let size = format!("{} vertices, {} faces", count(vertices), count(faces));
    let statistics = args.stats.then(|| Statistics::new(surfaces));
    if console.json() {
        if let Some(statistics) = &statistics {
            let warnings = surfaces.iter().flat_map(|s| s.model().warnings());
            result["stats"] = statistics.json();
            result["stats"]["warnings"] = warnings.map(|w| Value::from(w.to_string())).collect();
        }
        return console.result(&result);
    }
    let Some(statistics) = &statistics else {
        console.detail(size);
        return Ok(());
    };
    let mut text = String::new();
    for (what, value) in statistics.rows().into_iter().chain([("mesh", size)]) {
        let _ = writeln!(text, "{what:<13}{value}");
    }
    console.print(&text)
}

/// Applies the options.
fn change(args: &Streamline, model: &mut Model) {
    fn set<T, U: Into<T>>(field: &mut T, option: Option<U>) {
        if let Some(value) = option {
            *field = value.into();
        }
    }
    set(&mut model.depth, args.depth);
    set(&mut model.scheme, args.scheme);
    set(&mut model.order, args.order);
    set(&mut model.ends, args.ends);
    set(&mut model.w, args.w);
    set(&mut model.integration, args.integration);
}

/// A model to begin with.
fn new(starter: Starter) -> Result<Models, Failure> {
    let (name, slopes): (_, [[f64; 7]; 5]) = match starter {
        Starter::Car => {
            return streamline::parse(CAR).map_err(|e| Failure::new(format!("the example: {e}")));
        }
        Starter::Flat => ("flat", [[0.0; 7]; 5]),
        Starter::Arc => return Ok(named("arc", &arc())),
        Starter::Wave => {
            let wave = |height: f64| [0.0, 1.0, 0.0, -1.0, 0.0, 1.0, 0.0].map(|s| height * s);
            ("wave", [0.2, 0.4, 0.5, 0.4, 0.2].map(wave))
        }
    };
    let tangents = slopes.map(|row| row.map(|slope| Vec3::new(1.0, slope, 0.0).normalized()));
    Ok(named(name, &tangents))
}

/// Streamlines that rise, bend over and come down again, each a half circle or less.
fn arc() -> [[Vec3; 7]; 5] {
    let (up, along) = (Vec3::new(0.0, 1.0, 0.0), Vec3::new(1.0, 0.0, 0.0));
    [0.6, 0.8, 0.9, 0.8, 0.6].map(|share| {
        let turned = |i: f64| blend(along, up, share * i);
        [1.0, 2.0 / 3.0, 1.0 / 3.0, 0.0, -1.0 / 3.0, -2.0 / 3.0, -1.0].map(turned)
    })
}

/// A model of streamlines along x, side by side along z, so that y is up.
fn named<const R: usize, const C: usize>(name: &str, tangents: &[[Vec3; C]; R]) -> Models {
    let t: Vec<f64> = (0..R).map(|k| k as f64).collect();
    let width = (R - 1) as f64;
    let points = vec![Vec3::ZERO, Vec3::new(0.0, 0.0, -width)];
    let initial = InitialCurve::Polyline { points, t: vec![0.0, width] };
    let grid = Grid::from_rows(*tangents).expect("rows of one length");
    let model = Model { depth: 3, ..Model::new(grid, &[(C - 1) as f64; R], t, initial) };
    Models {
        patches: vec![Patch { name: Some(name.into()), ..Patch::from(model) }],
        ..Models::default()
    }
}
