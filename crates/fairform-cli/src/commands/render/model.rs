//! Streamline models and curves in `fairform render`.

use std::path::Path;

use fairform::streamline::{self, Model};
use fairform::{Vec3, fairness};
use fairform_io::MeshData;
use fairform_io::streamline::{Contents, Curve, EXTENSION};
use fairform_render::{Directions, Line, ModelView, Part, Show, SphereView, View};

use crate::args::{Render, Sphere};
use crate::console::Console;
use crate::failure::Failure;
use crate::input::Source;
use crate::models;

/// What is drawn in one panel.
pub(crate) struct Sheet<'a> {
    pub(crate) path: &'a Path,
    /// The surface.
    pub(crate) data: MeshData,
    /// Whether the surface itself is drawn.
    pub(crate) shown: bool,
    /// Lines on it.
    pub(crate) strokes: Vec<([u32; 2], Line)>,
    /// What else is drawn.
    pub(crate) parts: Vec<Part>,
    /// Of a model that is drawn at several.
    pub(crate) depth: Option<u32>,
    is_model: bool,
}

impl<'a> Sheet<'a> {
    pub(crate) fn of_mesh(path: &'a Path, data: MeshData) -> Self {
        Self { data, shown: true, is_model: false, ..Self::of_model(path) }
    }

    fn of_model(path: &'a Path) -> Self {
        Self {
            path,
            data: MeshData::default(),
            shown: false,
            strokes: Vec::new(),
            parts: Vec::new(),
            depth: None,
            is_model: true,
        }
    }
}

/// Whether the name is that of a model.
pub(crate) fn is_model(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase());
    name.is_some_and(|name| name.strip_suffix(".gz").unwrap_or(&name).ends_with(EXTENSION))
}

/// Refuses options for meshes on models, and the other way round.
pub(crate) fn check(args: &Render, sheets: &[Sheet]) -> Result<(), Failure> {
    let model = &args.model;
    let of_models = [
        ("--depth", !model.depth.is_empty()),
        ("--show", !model.show.is_empty()),
        ("--sphere", model.sphere.is_some()),
    ];
    let option = of_models.into_iter().find(|(_, given)| *given);
    if let (Some((option, _)), Some(mesh)) = (option, sheets.iter().find(|sheet| !sheet.is_model)) {
        let what = format!("{option} is for models, and {} is none", mesh.path.display());
        return Err(Failure::usage(what).help(format!("models end in {EXTENSION}")));
    }
    let of_meshes = [("--scheme", args.scheme.is_some()), ("--fit", args.fit)];
    let option = of_meshes.into_iter().find(|(_, given)| *given);
    if let Some((option, _)) = option.filter(|_| sheets.iter().any(|sheet| sheet.is_model)) {
        return Err(Failure::usage(format!("{option} is for meshes; a model says its own scheme"))
            .help(format!("leave out {option}")));
    }
    if model.sphere.is_some() && args.colour.is_some() {
        let what = "--colour is for surfaces, and --sphere shows none";
        return Err(Failure::usage(what).help("leave out one of them"));
    }
    Ok(())
}

/// The view that a file asks for.
pub(crate) fn view(path: &Path, contents: &Contents, console: &Console) -> Option<View> {
    let Contents::Surface(models) = contents else { return None };
    let displays = models.patches.iter().map(|patch| &patch.display);
    let mut displays = std::iter::once(&models.display).chain(displays).flatten();
    let said = displays.find_map(|display| display.get("view"))?;
    // It may be meant for another viewer.
    let view = said.as_str().and_then(|text| text.parse().ok());
    if view.is_none() {
        let path = path.display();
        console.note(format!("warning: {path}: display.view: {said} is no view as --view takes"));
    }
    view
}

/// What is drawn of the models or the curve in a file: a sheet for each depth.
pub(crate) fn sheets<'a>(
    path: &'a Path,
    contents: &Contents,
    args: &Render,
    view: &View,
) -> Result<Vec<Sheet<'a>>, Failure> {
    let depths: Vec<Option<u32>> = match args.model.depth.as_slice() {
        [] => vec![None],
        depths => depths.iter().copied().map(Some).collect(),
    };
    let several = depths.len() > 1;
    let sheet = |depth: Option<u32>| {
        let mut sheet = match &args.model.sphere {
            Some(choice) => on_sphere(path, contents, choice, depth, view)?,
            None => in_space(path, contents, depth, args)?,
        };
        sheet.depth = depth.filter(|_| several);
        Ok(sheet)
    };
    depths.into_iter().map(sheet).collect()
}

fn at(path: &Path) -> impl Fn(streamline::Error) -> Failure + '_ {
    |error| Failure::new(format!("{}: {error}", path.display()))
}

fn in_space<'a>(
    path: &'a Path,
    contents: &Contents,
    depth: Option<u32>,
    args: &Render,
) -> Result<Sheet<'a>, Failure> {
    let mut view = ModelView::default();
    if !args.model.show.is_empty() {
        view.show.clone_from(&args.model.show);
    }
    let models: Vec<Model> = match contents {
        Contents::Surface(all) => models::stitched(all, &Source { path, format: None })?,
        _ => {
            return Err(Failure::new(format!("{}: a curve is no surface", path.display()))
                .help("draw its tangents, with --sphere"));
        }
    };
    let mut sheet = Sheet { shown: view.shows(Show::Surface), ..Sheet::of_model(path) };
    let refined = models.into_iter().map(|model| {
        let depth = depth.unwrap_or(model.depth);
        streamline::Surface::new(Model { depth, ..model }).map_err(at(path))
    });
    let surfaces = refined.collect::<Result<Vec<_>, _>>()?;
    let joined = models::joined(&surfaces);
    let mut normals = vec![Vec3::ZERO; joined.positions.len()];
    for (surface, vertices) in surfaces.iter().zip(&joined.vertices) {
        let mut parts = view.parts(surface);
        let mesh = parts.remove(0);
        let number = |v: u32| vertices.values()[v as usize];
        for (v, normal) in (0..).zip(whole_normals(surface, &mesh, path)?) {
            normals[number(v) as usize] += normal;
        }
        let strokes = mesh.strokes.into_iter();
        sheet.strokes.extend(strokes.map(|(ends, line)| (ends.map(number), line)));
        sheet.parts.extend(parts);
    }
    // On both sides of a seam the same.
    normals.iter_mut().for_each(|n| *n = n.normalized());
    sheet.data.positions = joined.positions;
    sheet.data.faces = joined.faces;
    sheet.data.normals = Some(normals);
    Ok(sheet)
}

/// The normals of the surface, and where streamlines meet those of its faces.
fn whole_normals(
    surface: &streamline::Surface,
    mesh: &Part,
    path: &Path,
) -> Result<Vec<Vec3>, Failure> {
    let mut normals = mesh.normals.clone().unwrap_or_default();
    if normals.contains(&Vec3::ZERO) && !mesh.faces.is_empty() {
        let mesh = surface.mesh().map_err(|e| Failure::new(format!("{}: {e}", path.display())))?;
        let fitted = fairness::fitted_normals(mesh.topology(), mesh.positions());
        let none = normals.iter_mut().zip(fitted).filter(|(n, _)| **n == Vec3::ZERO);
        none.for_each(|(normal, fitted)| *normal = fitted);
    }
    Ok(normals)
}

fn on_sphere<'a>(
    path: &'a Path,
    contents: &Contents,
    choice: &Sphere,
    depth: Option<u32>,
    view: &View,
) -> Result<Sheet<'a>, Failure> {
    let mut all = Vec::new();
    let wrong = |error| at(path)(streamline::Error::Sphere { field: "tangents", error });
    match contents {
        Contents::Surface(models) => {
            for model in models::stitched(models, &Source { path, format: None })? {
                let depth = depth.unwrap_or(model.depth);
                let model = Model { depth, ..model };
                all.extend(match choice {
                    Sphere::Columns => Directions::columns(&model).map_err(at(path))?,
                    _ => Directions::rows(&model).map_err(at(path))?,
                });
            }
        }
        Contents::Curve(Curve::Subdivided(curve)) => {
            let (control, depth) = (curve.tangents.clone(), depth.unwrap_or(curve.depth));
            let made = Directions::subdivided(control, curve.rule, curve.ends, depth);
            all.push(made.map_err(wrong)?);
        }
        Contents::Curve(Curve::Qi { tangents, order, knots, .. }) => {
            const PLACES: usize = 400;
            all.push(Directions::qi(tangents.clone(), *order, *knots, PLACES).map_err(wrong)?);
        }
        _ => {}
    }
    if let Sphere::Some(rows) = choice {
        if let Some(row) = rows.iter().find(|row| **row >= all.len()) {
            let (path, count) = (path.display(), all.len());
            return Err(Failure::usage(format!("{path}: there is no row {row}; it has {count}"))
                .help("rows count from 0"));
        }
        all = rows.iter().map(|&row| all[row].clone()).collect();
    }
    let view = SphereView { up: view.up, ..SphereView::default() };
    Ok(Sheet { parts: view.parts(&all), ..Sheet::of_model(path) })
}
