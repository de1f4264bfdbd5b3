//! Streamline models on their way to surfaces.

use std::fmt::Display;

use fairform::sphere::{Ends, Step};
use fairform::streamline::{Grid, InitialCurve, Model, Order, Surface};
use fairform::{Faces, Mesh, Vec3, fairness};
use fairform_io::streamline::{Contents, Curve, Models, Patch};
use fairform_io::{Labels, MeshData};
use serde_json::{Value, json};

use crate::console::{Console, count};
use crate::failure::Failure;
use crate::input::Source;
use crate::surface::available_memory;

/// Says a warning about a model.
pub(crate) fn warn(source: &Source, warning: &dyn Display, console: &Console) {
    console.note(format!("warning: {source}: {warning}"));
}

/// Vectors as JSON.
pub(crate) fn vectors(list: &[Vec3]) -> Value {
    list.iter().map(|&v| json!(<[f64; 3]>::from(v))).collect()
}

fn vector_rows(grid: &Grid<Vec3>) -> Value {
    grid.rows().map(vectors).collect()
}

/// What to say before an error of one model of several.
fn place(source: &Source, models: &Models, i: usize) -> String {
    match models.patches.len() {
        1 => source.to_string(),
        _ => format!("{source}: patches[{i}]"),
    }
}

/// Refines and integrates all models, with their warnings.
pub(crate) fn surfaces(
    models: &Models,
    source: &Source,
    console: &Console,
) -> Result<Vec<Surface>, Failure> {
    let all = models.patches.iter().enumerate();
    all.map(|(i, patch)| {
        let place = place(source, models, i);
        check_memory(&patch.model, &place)?;
        for warning in patch.model.warnings() {
            console.note(format!("warning: {place}: {warning}"));
        }
        Surface::new(patch.model.clone()).map_err(|e| Failure::new(format!("{place}: {e}")))
    })
    .collect()
}

/// Rows and columns of the refined tangents; none where the scheme takes no such grid.
pub(crate) fn refined_size(model: &Model) -> Option<[usize; 2]> {
    let rule = model.rule().ok()?;
    let mut size = [model.tangents.row_count(), model.tangents.column_count()];
    for _ in 0..model.depth {
        for count in &mut size {
            *count = Step::new(rule, model.ends, *count).ok()?.refined_count();
        }
        // The kernel says what is too large.
        size[0].checked_mul(size[1]).filter(|n| *n < 1 << 40)?;
    }
    Some(size)
}

fn check_memory(model: &Model, place: &str) -> Result<(), Failure> {
    /// All grids, the mesh and its topology, and the copy that is written, generously.
    const BYTES_EACH: u64 = 500;
    let Some([rows, columns]) = refined_size(model) else { return Ok(()) };
    let points = rows * columns;
    match available_memory() {
        Some(available) if points as u64 * BYTES_EACH > available => Err(Failure::new(format!(
            "{place}: a depth of {} makes {} points, which take about {:.1} GB; {:.1} GB are free",
            model.depth,
            count(points),
            points as f64 * BYTES_EACH as f64 / 1e9,
            available as f64 / 1e9
        ))
        .help("use a smaller --depth; each step makes four times as many")),
        _ => Ok(()),
    }
}

/// Refined tangents, parameters and points.
pub(crate) fn json(surfaces: &[Surface]) -> Value {
    let one = |surface: &Surface| {
        json!({
            "tangents": vector_rows(surface.tangents()),
            "s": surface.s().rows().collect::<Vec<_>>(),
            "t": surface.t(),
            "points": vector_rows(surface.points()),
        })
    };
    match surfaces {
        [surface] => one(surface),
        several => json!({ "patches": several.iter().map(one).collect::<Vec<_>>() }),
    }
}

/// The mesh of all surfaces, with normals and $`(s, t)`$ as texture coordinates. Where the last
/// streamline of one is the first of the next, to the bit, they share its vertices.
pub(crate) fn mesh(surfaces: &[Surface], patches: &[Patch]) -> Result<MeshData, fairform::Error> {
    let mut builder = Builder::default();
    for surface in surfaces {
        builder.add(surface);
    }
    let mesh = Mesh::new(builder.positions, &builder.faces)?;
    let normals = fairness::vertex_normals(mesh.topology(), mesh.positions());
    let corner_uvs = builder.seam.then_some(builder.corner_uvs);
    let groups = (patches.len() > 1).then(|| Labels {
        names: (1..).zip(patches).map(|(i, patch)| name(patches, i, patch)).collect(),
        of_face: builder.patch_of_face,
    });
    Ok(MeshData {
        normals: Some(normals),
        uvs: corner_uvs.is_none().then_some(builder.uvs),
        corner_uvs,
        groups,
        positions: mesh.into_positions(),
        faces: builder.faces,
        ..MeshData::default()
    })
}

/// The name of a patch, or its number where that would not tell it from the others.
fn name(patches: &[Patch], number: usize, patch: &Patch) -> String {
    let namesakes = patches.iter().filter(|other| other.name == patch.name).count();
    match &patch.name {
        Some(name) if namesakes == 1 => name.clone(),
        _ => format!("patch {number}"),
    }
}

#[derive(Default)]
struct Builder {
    positions: Vec<Vec3>,
    uvs: Vec<[f64; 2]>,
    faces: Faces,
    corner_uvs: Vec<[f64; 2]>,
    patch_of_face: Vec<u32>,
    /// Whether a shared vertex has different parameters in its patches.
    seam: bool,
    patch_count: u32,
    /// Points of the last streamline of the patch before.
    last: Vec<Vec3>,
}

impl Builder {
    fn add(&mut self, surface: &Surface) {
        let (points, uvs) = (surface.points(), surface.parameters());
        let (rows, columns) = (points.row_count(), points.column_count());
        let shared = self.last.as_slice() == points.row(0);
        let first = self.positions.len() - if shared { columns } else { 0 };
        if shared {
            self.seam |= self.uvs[first..] != *uvs.row(0);
        }
        let new = usize::from(shared) * columns;
        self.positions.extend_from_slice(&points.values()[new..]);
        self.uvs.extend_from_slice(&uvs.values()[new..]);
        for k in 1..rows {
            for i in 1..columns {
                let corners = [(k - 1, i - 1), (k - 1, i), (k, i), (k, i - 1)];
                self.faces.push(&corners.map(|(k, i)| (first + k * columns + i) as u32));
                self.corner_uvs.extend(corners.map(|place| uvs[place]));
                self.patch_of_face.push(self.patch_count);
            }
        }
        self.patch_count += 1;
        self.last = points.row(rows - 1).to_vec();
    }
}

/// Numbers of streamline surfaces, over all patches.
pub(crate) struct Statistics {
    streamlines: usize,
    tangents: usize,
    length: [f64; 2],
    asked: [f64; 2],
    curvature_max: f64,
    curvature_mean: f64,
    variation_max: f64,
    bending_energy: f64,
}

impl Statistics {
    pub(crate) fn new(surfaces: &[Surface]) -> Self {
        const NONE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];
        let widen = |range: &mut [f64; 2], x: f64| *range = [range[0].min(x), range[1].max(x)];
        let mut all = Self {
            streamlines: 0,
            tangents: 0,
            length: NONE,
            asked: NONE,
            curvature_max: 0.0,
            curvature_mean: 0.0,
            variation_max: 0.0,
            bending_energy: 0.0,
        };
        let (mut turn, mut total) = (0.0, 0.0);
        for surface in surfaces {
            all.streamlines += surface.t().len();
            all.tangents += surface.tangents().values().len();
            for row in 0..surface.t().len() {
                let length = surface.length(row);
                total += length;
                widen(&mut all.length, length);
            }
            asked(surface).into_iter().for_each(|x| widen(&mut all.asked, x));
            let curvature = fairform::streamline::curvature(surface);
            for (vectors, s) in curvature.vector.rows().zip(surface.s().rows()) {
                for (vector, s) in vectors.iter().zip(s.windows(2)) {
                    turn += vector.length() * (s[1] - s[0]);
                    all.curvature_max = all.curvature_max.max(vector.length());
                }
            }
            let variation = curvature.variation.values().iter().map(|x| x.abs());
            all.variation_max = variation.fold(all.variation_max, f64::max);
            all.bending_energy += curvature.bending_energy(surface);
        }
        all.curvature_mean = if total > 0.0 { turn / total } else { 0.0 };
        all
    }

    pub(crate) fn json(&self) -> Value {
        json!({
            "streamlines": self.streamlines,
            "tangents": self.tangents,
            "length": { "min": self.length[0], "max": self.length[1] },
            "length_asked_for": { "min": self.asked[0], "max": self.asked[1] },
            "curvature": { "max": self.curvature_max, "mean": self.curvature_mean },
            "variation_max": self.variation_max,
            "bending_energy": self.bending_energy,
        })
    }

    pub(crate) fn rows(&self) -> Vec<(&'static str, String)> {
        let range = |[from, to]: [f64; 2]| match (short(from), short(to)) {
            (from, to) if from == to => from,
            (from, to) => format!("{from} to {to}"),
        };
        vec![
            ("streamlines", count(self.streamlines)),
            ("tangents", count(self.tangents)),
            ("lengths", format!("{}; asked for were {}", range(self.length), range(self.asked))),
            (
                "curvature",
                format!(
                    "at most {}, {} on average along the streamlines",
                    short(self.curvature_max),
                    short(self.curvature_mean)
                ),
            ),
            ("variation", format!("at most {}", short(self.variation_max))),
            ("bending", short(self.bending_energy)),
        ]
    }
}

/// Lengths that the model gives.
fn asked(surface: &Surface) -> Vec<f64> {
    let model = surface.model();
    match &model.length {
        // It has been used already.
        Some(length) => length.lengths(surface.t()).unwrap_or_default(),
        None => model.s.rows().map(|s| s[s.len() - 1] - s[0]).collect(),
    }
}

/// A number in at most six digits.
pub(crate) fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    if rounded == 0.0 || (1e-4..1e7).contains(&rounded.abs()) {
        format!("{}", rounded + 0.0)
    } else {
        format!("{rounded:e}")
    }
}

/// What is in a file, for people.
pub(crate) fn contents_rows(contents: &Contents) -> Vec<(&'static str, String)> {
    match contents {
        Contents::Surface(models) => {
            let several = models.patches.len() > 1;
            let mut rows = vec![];
            if let Some(name) = models.name.as_ref().filter(|_| several) {
                rows.push(("name", name.clone()));
            }
            if several {
                rows.push(("patches", count(models.patches.len())));
            }
            for (i, patch) in models.patches.iter().enumerate() {
                if several {
                    rows.push(("", format!("patches[{i}]")));
                }
                rows.extend(patch_rows(patch));
            }
            rows
        }
        Contents::Curve(curve) => curve_rows(curve),
        _ => vec![],
    }
}

fn patch_rows(patch: &Patch) -> Vec<(&'static str, String)> {
    let model = &patch.model;
    let (rows, columns) = (model.tangents.row_count(), model.tangents.column_count());
    let lengths = model.s.rows().map(|s| s[s.len() - 1] - s[0]);
    let range = lengths.fold([f64::INFINITY, 0.0], |[a, b], x| [x.min(a), x.max(b)]);
    let size = match refined_size(model) {
        Some([r, c]) => format!("{} streamlines of {} tangents", count(r), count(c)),
        None => "too few tangents for the scheme, or too many in the end".into(),
    };
    let scheme = format!(
        "{}, {} first, {} ends",
        model.scheme.name(),
        if model.order == Order::St { "along" } else { "across" },
        if model.ends == Ends::Clamped { "clamped" } else { "natural" },
    );
    let t = [model.t[0], model.t[model.t.len() - 1]];
    let mut list = vec![
        ("model", format!("{} streamlines of {} tangents", count(rows), count(columns))),
        ("lengths", format!("{} to {}", short(range[0]), short(range[1]))),
        ("t", format!("{} to {}", short(t[0]), short(t[1]))),
        ("scheme", scheme),
        ("depth", format!("{}: {size}", model.depth)),
        ("initial", initial(model).into()),
    ];
    if let Some(name) = &patch.name {
        list.insert(0, ("name", name.clone()));
    }
    if !model.details.is_empty() {
        list.push(("details", count(model.details.len())));
    }
    list.extend(model.warnings().iter().map(|w| ("warning", w.to_string())));
    list
}

fn initial(model: &Model) -> &'static str {
    match &model.initial {
        InitialCurve::Polyline { .. } => "polyline",
        InitialCurve::Bspline { weights: None, .. } => "B-spline",
        InitialCurve::Bspline { .. } => "NURBS curve",
        InitialCurve::Qi { .. } => "QI curve",
        _ => "curve",
    }
}

fn curve_rows(curve: &Curve) -> Vec<(&'static str, String)> {
    match curve {
        Curve::Subdivided(curve) => {
            let points = if curve.s.is_some() { "" } else { ", without parameters: no points" };
            vec![
                ("curve", format!("{} tangents{points}", count(curve.tangents.len()))),
                ("scheme", curve.rule.name().into()),
                ("depth", curve.depth.to_string()),
            ]
        }
        Curve::Qi { tangents, order, length, u, .. } => vec![
            ("curve", format!("QI of order {order} on {} tangents", count(tangents.len()))),
            ("length", short(*length)),
            ("points", count(u.len())),
        ],
    }
}

/// What is in a file, for machines.
pub(crate) fn contents_json(contents: &Contents) -> Value {
    match contents {
        Contents::Surface(models) => {
            let patch = |patch: &Patch| {
                let model = &patch.model;
                json!({
                    "name": patch.name,
                    "rows": model.tangents.row_count(),
                    "columns": model.tangents.column_count(),
                    "scheme": model.scheme.name(),
                    "depth": model.depth,
                    "refined": refined_size(model),
                    "details": model.details.len(),
                    "warnings": model.warnings().iter().map(ToString::to_string)
                        .collect::<Vec<_>>(),
                })
            };
            let patches: Vec<_> = models.patches.iter().map(patch).collect();
            json!({ "kind": "surface", "name": models.name, "patches": patches })
        }
        Contents::Curve(Curve::Subdivided(curve)) => json!({
            "kind": "curve",
            "scheme": curve.rule.name(),
            "tangents": curve.tangents.len(),
            "depth": curve.depth,
        }),
        Contents::Curve(Curve::Qi { tangents, order, length, u, .. }) => json!({
            "kind": "curve",
            "scheme": "qi",
            "tangents": tangents.len(),
            "order": order,
            "length": length,
            "points": u.len(),
        }),
        _ => Value::Null,
    }
}
