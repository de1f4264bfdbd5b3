//! Streamline models on their way to surfaces.

use std::fmt::Display;

use fairform::sphere::{Ends, Step};
use fairform::streamline::{
    self, BsplineSurface, Grid, InitialCurve, Joined, Model, Order, Surface, join,
};
use fairform::{Bounds, Mesh, Vec3, fairness};
use fairform_io::streamline::{Contents, Curve, Models, Patch, Stitch};
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
    let stitched = stitched(models, source)?;
    let all = stitched.into_iter().enumerate();
    let made = all.map(|(i, model)| {
        let place = place(source, models, i);
        check_memory(&model, &place)?;
        for warning in model.warnings() {
            console.note(format!("warning: {place}: {warning}"));
        }
        Surface::new(model).map_err(|e| Failure::new(format!("{place}: {e}")))
    });
    let surfaces = made.collect::<Result<Vec<_>, _>>()?;
    if models.stitch != Stitch::None {
        let tolerance = join_tolerance(&surfaces);
        for seam in Seam::of_neighbours(&surfaces) {
            if seam.of.gap > tolerance {
                console.note(format!(
                    "warning: {}: stitched to patches[{}], but up to {} away from it, for length or \
                     details differ",
                    place(source, models, seam.to),
                    seam.from,
                    short(seam.of.gap)
                ));
            }
        }
    }
    Ok(surfaces)
}

/// All models, stitched as the file says.
pub(crate) fn stitched(models: &Models, source: &Source) -> Result<Vec<Model>, Failure> {
    models.stitched().map_err(|(i, error)| {
        let place = place(source, models, i);
        Failure::new(format!("{place}: cannot be stitched to patches[{}]: {error}", i - 1))
    })
}

/// Length of the diagonal of the box around all surfaces.
pub(crate) fn diagonal(surfaces: &[Surface]) -> f64 {
    Bounds::of(surfaces.iter().flat_map(|s| s.points().values()).copied()).diagonal()
}

/// All surfaces, with the vertices of shared streamlines in common.
pub(crate) fn joined(surfaces: &[Surface]) -> Joined {
    join(surfaces, join_tolerance(surfaces))
}

/// How far apart points of two streamlines may be to be the same.
fn join_tolerance(surfaces: &[Surface]) -> f64 {
    1e-12 * diagonal(surfaces)
}

/// Where a patch ends and another, or the first again, begins.
pub(crate) struct Seam {
    from: usize,
    to: usize,
    of: streamline::Seam,
}

impl Seam {
    fn between(surfaces: &[Surface], from: usize, to: usize) -> Option<Self> {
        streamline::seam(&surfaces[from], &surfaces[to]).map(|of| Self { from, to, of })
    }

    /// Between one patch and the next.
    fn of_neighbours(surfaces: &[Surface]) -> Vec<Self> {
        (1..surfaces.len()).filter_map(|to| Self::between(surfaces, to - 1, to)).collect()
    }

    /// Also from the last to the first where they join.
    fn all(surfaces: &[Surface]) -> Vec<Self> {
        let mut seams = Self::of_neighbours(surfaces);
        let joined = joined(surfaces);
        if let (Some(first), Some(last)) = (joined.vertices.first(), joined.vertices.last())
            && last.row_count() > 1
            && first.row(0) == last.row(last.row_count() - 1)
        {
            seams.extend(Self::between(surfaces, surfaces.len() - 1, 0));
        }
        seams
    }

    fn json(&self) -> Value {
        json!({
            "patches": [self.from, self.to],
            "gap": self.of.gap,
            "tangent_degrees": self.of.tangent_angle.to_degrees(),
            "plane_degrees": self.of.plane_angle.to_degrees(),
        })
    }

    fn text(&self) -> String {
        format!(
            "patches {} and {}: gap {}, tangents {}°, planes {}°",
            self.from,
            self.to,
            short(self.of.gap),
            short(self.of.tangent_angle.to_degrees()),
            short(self.of.plane_angle.to_degrees())
        )
    }
}

/// Exchanges the roles of s and t in all models; how far the new surfaces are from the old ones.
pub(crate) fn swap(
    models: &mut Models,
    surfaces: &mut Vec<Surface>,
    [rows, columns]: [usize; 2],
    source: &Source,
    console: &Console,
) -> Result<f64, Failure> {
    let given = joined(surfaces).into_mesh().map_err(|e| Failure::new(format!("{source}: {e}")))?;
    let size = diagonal(surfaces);
    for (i, patch) in models.patches.iter_mut().enumerate() {
        patch.model = streamline::swap(&surfaces[i], rows, columns)
            .map_err(|e| Failure::new(format!("{source}: {e}")))?;
        let tangents = &patch.model.tangents;
        let made = [tangents.row_count(), tangents.column_count()];
        if made != [rows, columns] {
            console.note(format!(
                "warning: {source}: {} × {} tangents, for the refined surface has no more points; \
                 refine it with --depth",
                made[0], made[1]
            ));
        }
    }
    models.stitch = Stitch::None;
    *surfaces = self::surfaces(models, source, console)?;
    let points: Vec<Vec3> = surfaces.iter().flat_map(|s| s.points().values()).copied().collect();
    let distance = fairness::deviation(&points, &given).max;
    console.note(format!(
        "swapped: the points of the new surface are at most {} from the mesh of the given one, {} of \
         the diagonal",
        short(distance),
        short(if size > 0.0 { distance / size } else { 0.0 })
    ));
    Ok(distance)
}

/// B-spline surfaces within a tolerance, a fraction of the diagonal.
pub(crate) fn bsplines(
    models: &Models,
    surfaces: &[Surface],
    tolerance: f64,
    source: &Source,
    console: &Console,
) -> Result<Vec<BsplineSurface>, Failure> {
    let size = diagonal(surfaces);
    let progress = console.progress();
    let all = surfaces.iter().enumerate();
    let all = all.map(|(i, surface)| {
        let place = place(source, models, i);
        if surface.points().row_count() < 2 {
            return Err(Failure::new(format!("{place}: one streamline is no surface")));
        }
        progress.say(format!("{place}: fitting a B-spline surface"));
        BsplineSurface::fit(surface.model(), tolerance * size).map_err(|error| match error {
            streamline::Error::Tolerance { best } => Failure::new(format!(
                "{place}: not within {tolerance:e} of the diagonal: the nearest B-spline surface found \
                 deviates by {:.3e}",
                best / size
            )),
            other => Failure::new(format!("{place}: {other}")),
        })
    });
    let splines = all.collect::<Result<Vec<_>, _>>()?;
    drop(progress);
    for (i, spline) in splines.iter().enumerate() {
        console.note(format!(
            "{}: {} × {} control points, at most {:.3e} of the diagonal away",
            place(source, models, i),
            spline.points.column_count(),
            spline.points.row_count(),
            spline.deviation / size
        ));
    }
    Ok(splines)
}

/// B-spline surfaces with names of their patches.
pub(crate) fn bsplines_obj(
    splines: &[BsplineSurface],
    patches: &[Patch],
) -> Result<Vec<u8>, Failure> {
    let names: Vec<String> = match patches {
        [one] => vec![one.name.clone().unwrap_or_default()],
        several => (1..).zip(several).map(|(i, patch)| name(several, i, patch)).collect(),
    };
    let named: Vec<_> = names.iter().map(String::as_str).zip(splines).collect();
    let mut out = Vec::new();
    fairform_io::streamline::encode_bsplines(&named, &mut out)?;
    Ok(out)
}

/// Degrees, knots, control points and deviations.
pub(crate) fn bsplines_json(splines: &[BsplineSurface]) -> Value {
    let one = |spline: &BsplineSurface| {
        let [u, v] = spline.knots();
        json!({
            "degree": [3, 3],
            "knots": { "u": u, "v": v },
            "points": vector_rows(&spline.points),
            "deviation": spline.deviation,
        })
    };
    one_or_patches(splines.iter().map(one).collect())
}

/// The value of one surface by itself, those of several as patches.
fn one_or_patches(mut all: Vec<Value>) -> Value {
    if all.len() == 1 { all.remove(0) } else { json!({ "patches": all }) }
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
    one_or_patches(surfaces.iter().map(one).collect())
}

/// The mesh of all surfaces, with normals and $`(s, t)`$ as texture coordinates. Where the last
/// streamline of one is the first of the next, or of the first, they share its vertices.
pub(crate) fn mesh(surfaces: &[Surface], patches: &[Patch]) -> Result<MeshData, fairform::Error> {
    let Joined { positions, faces, vertices } = joined(surfaces);
    let mut uvs: Vec<Option<[f64; 2]>> = vec![None; positions.len()];
    let (mut corner_uvs, mut patch_of_face) = (Vec::new(), Vec::new());
    // Whether a shared vertex has different parameters on its two sides.
    let mut seam = false;
    for ((surface, vertices), patch) in surfaces.iter().zip(&vertices).zip(0..) {
        let parameters = surface.parameters();
        for (&v, &uv) in vertices.values().iter().zip(parameters.values()) {
            seam |= *uvs[v as usize].get_or_insert(uv) != uv;
        }
        for k in 1..parameters.row_count() {
            for i in 1..parameters.column_count() {
                let corners = [(k - 1, i - 1), (k - 1, i), (k, i), (k, i - 1)];
                corner_uvs.extend(corners.map(|place| parameters[place]));
                patch_of_face.push(patch);
            }
        }
    }
    let mesh = Mesh::new(positions, &faces)?;
    let normals = fairness::vertex_normals(mesh.topology(), mesh.positions());
    let groups = (patches.len() > 1).then(|| Labels {
        names: (1..).zip(patches).map(|(i, patch)| name(patches, i, patch)).collect(),
        of_face: patch_of_face,
    });
    Ok(MeshData {
        normals: Some(normals),
        uvs: (!seam).then(|| uvs.into_iter().map(Option::unwrap_or_default).collect()),
        corner_uvs: seam.then_some(corner_uvs),
        groups,
        positions: mesh.into_positions(),
        faces,
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
    seams: Vec<Seam>,
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
            seams: Seam::all(surfaces),
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
            "seams": self.seams.iter().map(Seam::json).collect::<Vec<_>>(),
        })
    }

    pub(crate) fn rows(&self) -> Vec<(&'static str, String)> {
        let range = |[from, to]: [f64; 2]| match (short(from), short(to)) {
            (from, to) if from == to => from,
            (from, to) => format!("{from} to {to}"),
        };
        let mut rows = vec![
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
        ];
        rows.extend(self.seams.iter().map(|seam| ("seam", seam.text())));
        rows
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
                let stitch = match models.stitch {
                    Stitch::None => "",
                    Stitch::Shared => ", stitched",
                    Stitch::Smooth => ", stitched smoothly",
                };
                rows.push(("patches", count(models.patches.len()) + stitch));
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
