//! [`StreamSession`]: a model of streamline surfaces while it is edited.

use fairform::sphere::{self, blend};
use fairform::streamline::{Model, Surface, curvature, join};
use fairform::{Bounds, Mesh, Vec3, fairness};
use fairform_io::streamline::{self, Models, Patch, Stitch};
use fairform_io::{Format, Labels, MeshData, WriteOptions, encode};
use serde::{Deserialize, Serialize};

use crate::drawing::single;
use crate::values::{Colouring, Values};
use crate::{Geometry, Problem};

/// Most points of a patch that is drawn.
const MOST_POINTS: usize = 8_000_000;

/// A model file, opened.
#[derive(Debug)]
pub struct StreamSession {
    models: Models,
    /// One per patch, of the models as they are used.
    surfaces: Vec<Surface>,
}

/// What there is to know about a patch.
#[derive(Clone, PartialEq, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct PatchInfo {
    /// Its name, or its number.
    pub name: String,
    /// Rows of control tangents: streamlines.
    pub row_count: usize,
    /// Columns of control tangents.
    pub column_count: usize,
    /// Refinement steps.
    pub depth: u32,
    /// The scheme.
    pub scheme: &'static str,
    /// What may surprise.
    pub warnings: Vec<String>,
}

/// A patch to draw.
#[derive(Clone, PartialEq, Debug)]
pub struct PatchGeometry {
    /// The surface: vertex $`(r, c)`$ is $`r \cdot \mathit{columns} + c`$.
    pub geometry: Geometry,
    /// Rows of points.
    pub row_count: usize,
    /// Columns of points.
    pub column_count: usize,
    /// Where the control tangents stand.
    pub feet: Vec<[f32; 3]>,
    /// The control tangents.
    pub tangents: Vec<[f32; 3]>,
    /// The refined tangent at each point.
    pub fine_tangents: Vec<[f32; 3]>,
    /// The patches that moved with it, for they are stitched.
    pub others: Vec<u32>,
}

/// A change of the structure of a model.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum ModelChange {
    /// A streamline between two others.
    InsertRow {
        /// Of this patch.
        patch: usize,
        /// The number that it has then.
        index: usize,
    },
    /// A tangent more on every streamline, between two others.
    InsertColumn {
        /// Of this patch.
        patch: usize,
        /// The number that it has then.
        index: usize,
    },
    /// A streamline less.
    DeleteRow {
        /// Of this patch.
        patch: usize,
        /// Its number.
        index: usize,
    },
    /// A tangent less on every streamline.
    DeleteColumn {
        /// Of this patch.
        patch: usize,
        /// Its number.
        index: usize,
    },
    /// The mirror image, in a plane through the origin.
    Mirror {
        /// Of this patch.
        patch: usize,
        /// Across the plane.
        normal: [f64; 3],
    },
}

/// Refines and integrates models; those that did not change are kept.
fn surfaces(models: &Models, mut old: Vec<Surface>) -> Result<Vec<Surface>, Problem> {
    let stitched = models.stitched().map_err(|(i, error)| {
        Problem::at(format_args!("patches[{i}] cannot be stitched to patches[{}]", i - 1), error)
    })?;
    let several = stitched.len() > 1;
    let mut made = Vec::with_capacity(stitched.len());
    for (i, model) in stitched.into_iter().enumerate() {
        if let Some(same) = old.iter().position(|surface| *surface.model() == model) {
            made.push(old.swap_remove(same));
            continue;
        }
        let at = |e: &dyn std::fmt::Display| match several {
            true => Problem::at(format_args!("patches[{i}]"), e),
            false => Problem::new(e.to_string()),
        };
        if refined_count(&model).is_none_or(|points| points > MOST_POINTS) {
            let message = format!("depth: {} makes too many points to be drawn", model.depth);
            return Err(at(&message).help("choose a smaller depth"));
        }
        made.push(Surface::new(model).map_err(|e| at(&e))?);
    }
    Ok(made)
}

/// Number of refined tangents; none where the scheme takes no such grid, which is said elsewhere, or they
/// are too many to count.
fn refined_count(model: &Model) -> Option<usize> {
    let Ok(rule) = model.rule() else { return Some(0) };
    let mut size = [model.tangents.row_count(), model.tangents.column_count()];
    for _ in 0..model.depth {
        for count in &mut size {
            match sphere::Step::new(rule, model.ends, *count) {
                Ok(step) => *count = step.refined_count(),
                Err(_) => return Some(0),
            }
        }
        if size[0].checked_mul(size[1])? > MOST_POINTS {
            return None;
        }
    }
    size[0].checked_mul(size[1])
}

impl StreamSession {
    /// Opens a model file.
    ///
    /// # Errors
    /// With the field and what should be there; for a model that cannot be refined.
    pub fn open(bytes: &[u8], name: &str) -> Result<Self, Problem> {
        let models = streamline::parse(bytes).map_err(|e| Problem::at(name, e))?;
        let surfaces = surfaces(&models, Vec::new())?;
        Ok(Self { models, surfaces })
    }

    /// Takes another state of the model, whole; keeps what did not change.
    ///
    /// # Errors
    /// As [`open`](Self::open). The model is as it was then.
    pub fn set(&mut self, text: &[u8]) -> Result<(), Problem> {
        let models = streamline::parse(text)?;
        // Copies, for an error must leave the old ones.
        self.surfaces = surfaces(&models, self.surfaces.clone())?;
        self.models = models;
        Ok(())
    }

    /// The model as text, complete: what a file holds.
    ///
    /// # Errors
    /// As [`streamline::encode`].
    pub fn text(&self) -> Result<Vec<u8>, Problem> {
        text(&self.models)
    }

    /// What there is to know about each patch.
    #[must_use]
    pub fn info(&self) -> Vec<PatchInfo> {
        let all = self.models.patches.iter().zip(&self.surfaces).enumerate();
        let info = |(i, (patch, surface)): (usize, (&Patch, &Surface))| {
            let model = surface.model();
            PatchInfo {
                name: patch_name(i, patch),
                row_count: model.tangents.row_count(),
                column_count: model.tangents.column_count(),
                depth: model.depth,
                scheme: model.scheme.name(),
                warnings: model.warnings().iter().map(ToString::to_string).collect(),
            }
        };
        all.map(info).collect()
    }

    fn surface(&self, patch: usize) -> Result<&Surface, Problem> {
        let count = self.surfaces.len();
        self.surfaces.get(patch).ok_or_else(|| {
            Problem::new(format!("there is no patch {patch}: the model has {count}"))
        })
    }

    /// A patch to draw.
    ///
    /// # Errors
    /// If there is no such patch.
    pub fn patch(&self, patch: usize) -> Result<PatchGeometry, Problem> {
        let surface = self.surface(patch)?;
        let points = surface.points();
        let (rows, columns) = (points.row_count(), points.column_count());
        let faces = surface.faces();
        let quads = faces.corners().as_chunks::<4>().0;
        let halves = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let at = |k: usize, i: usize| (k * columns + i) as u32;
        let along = (0..rows).flat_map(|k| (1..columns).map(move |i| [at(k, i - 1), at(k, i)]));
        let across = (1..rows).flat_map(|k| (0..columns).map(move |i| [at(k - 1, i), at(k, i)]));
        let geometry = Geometry {
            positions: single(points.values()),
            normals: single(surface.normals().values()),
            triangles: halves.collect(),
            face_of_triangle: (0..quads.len() as u32).flat_map(|f| [f, f]).collect(),
            edges: along.chain(across).collect(),
        };
        Ok(PatchGeometry {
            geometry,
            row_count: rows,
            column_count: columns,
            feet: single(surface.feet().values()),
            tangents: single(surface.model().tangents.values()),
            fine_tangents: single(surface.point_tangents().values()),
            others: Vec::new(),
        })
    }

    /// Sets one control tangent, which is scaled to length one, and says what became of its patch.
    ///
    /// # Errors
    /// If there is no such patch or tangent, or the direction has no length. Nothing is changed then.
    pub fn set_tangent(
        &mut self,
        patch: usize,
        row: usize,
        column: usize,
        tangent: Vec3,
    ) -> Result<PatchGeometry, Problem> {
        self.surface(patch)?;
        let unit = unit(tangent)?;
        if self.models.stitch == Stitch::None {
            self.surfaces[patch].set_tangent(0, row, column, unit)?;
            self.models.patches[patch].model.tangents[(row, column)] = unit;
            return self.patch(patch);
        }
        let tangents = &self.models.patches[patch].model.tangents;
        if row >= tangents.row_count() || column >= tangents.column_count() {
            let level = 0;
            return Err(fairform::streamline::Error::NoSuchPlace { level, row, column }.into());
        }
        let mut models = self.models.clone();
        models.patches[patch].model.tangents[(row, column)] = unit;
        let old: Vec<Model> = self.surfaces.iter().map(|s| s.model().clone()).collect();
        self.surfaces = surfaces(&models, self.surfaces.clone())?;
        self.models = models;
        let moved = |&i: &usize| i != patch && *self.surfaces[i].model() != old[i];
        let others = (0..old.len()).filter(moved).map(|i| i as u32).collect();
        Ok(PatchGeometry { others, ..self.patch(patch)? })
    }

    /// Great arcs between consecutive control tangents of each row, or of each column: so many points per
    /// arc, both ends among them.
    ///
    /// # Errors
    /// If there is no such patch.
    pub fn arcs(&self, patch: usize, rows: bool, steps: usize) -> Result<Vec<[f32; 3]>, Problem> {
        let tangents = &self.surface(patch)?.model().tangents;
        let lines = if rows { tangents.clone() } else { tangents.transposed() };
        let last = steps.saturating_sub(1).max(1) as f64;
        let mut points = Vec::new();
        for line in lines.rows() {
            for pair in line.windows(2) {
                let along = (0..steps).map(|i| blend(pair[0], pair[1], i as f64 / last));
                points.extend(along.map(<[f32; 3]>::from));
            }
        }
        Ok(points)
    }

    /// One value per point of a patch.
    ///
    /// # Errors
    /// If there is no such patch, or it is coloured by what only meshes have.
    pub fn values(&self, patch: usize, colouring: Colouring) -> Result<Values, Problem> {
        let surface = self.surface(patch)?;
        let mesh = surface.mesh()?;
        let normals = surface.normals();
        let curvatures = fairness::curvatures(mesh.topology(), mesh.positions(), normals.values());
        let values: Option<Vec<f64>> =
            curvatures.iter().map(|c| colouring.of_curvature(c)).collect();
        let values = values.ok_or_else(|| {
            Problem::new("streamline surfaces are coloured by curvature only")
                .help("choose Gaussian, mean or largest curvature")
        })?;
        Ok(Values::new(colouring, &values))
    }

    /// Curvature combs of all streamlines: for each point its place, and a tip away from the centre of
    /// curvature, `scale` times the curvature from it.
    ///
    /// # Errors
    /// If there is no such patch.
    pub fn combs(&self, patch: usize, scale: f64) -> Result<Vec<[[f32; 3]; 2]>, Problem> {
        let surface = self.surface(patch)?;
        let vectors = curvature(surface).at_points(surface);
        let pairs = surface.points().values().iter().zip(vectors.values());
        Ok(pairs.map(|(&p, &k)| [p.into(), (p - scale * k).into()]).collect())
    }

    /// The joined surface as the bytes of a file.
    ///
    /// # Errors
    /// If the format has no place for it.
    pub fn save(&self, format: Format) -> Result<Vec<u8>, Problem> {
        let points = self.surfaces.iter().flat_map(|s| s.points().values()).copied();
        let tolerance = 1e-12 * Bounds::of(points).diagonal();
        let joined = join(&self.surfaces, tolerance);
        let counts = self.surfaces.iter().map(|surface| surface.faces().len());
        let of_face = (0..).zip(counts).flat_map(|(i, n)| std::iter::repeat_n(i, n)).collect();
        let names = self.models.patches.iter().enumerate().map(|(i, p)| patch_name(i, p)).collect();
        let groups = (self.surfaces.len() > 1).then_some(Labels { names, of_face });
        let mesh = Mesh::new(joined.positions, &joined.faces)?;
        let normals = fairness::vertex_normals(mesh.topology(), mesh.positions());
        let data = MeshData {
            normals: Some(normals),
            groups,
            positions: mesh.into_positions(),
            faces: joined.faces,
            ..MeshData::default()
        };
        let mut out = Vec::new();
        encode(format, &data, &WriteOptions::default(), &mut out)?;
        Ok(out)
    }
}

fn patch_name(i: usize, patch: &Patch) -> String {
    patch.name.clone().unwrap_or_else(|| format!("patch {}", i + 1))
}

fn text(models: &Models) -> Result<Vec<u8>, Problem> {
    let mut out = Vec::new();
    streamline::encode(models, &mut out)?;
    Ok(out)
}

fn unit(tangent: Vec3) -> Result<Vec3, Problem> {
    let unit = tangent.normalized();
    match unit.is_finite() && unit != Vec3::ZERO {
        true => Ok(unit),
        false => Err(Problem::new("a tangent without length has no direction")),
    }
}

/// A model with its structure changed, as text.
///
/// # Errors
/// For a text that is no model; if there is no such patch, row or column, or the change leaves no surface.
pub fn edit(text_of_model: &[u8], change: &ModelChange) -> Result<Vec<u8>, Problem> {
    let mut models = streamline::parse(text_of_model)?;
    let (ModelChange::InsertRow { patch, .. }
    | ModelChange::InsertColumn { patch, .. }
    | ModelChange::DeleteRow { patch, .. }
    | ModelChange::DeleteColumn { patch, .. }
    | ModelChange::Mirror { patch, .. }) = *change;
    let count = models.patches.len();
    let model = match models.patches.get_mut(patch) {
        Some(patch) => &mut patch.model,
        None => {
            return Err(Problem::new(format!("there is no patch {patch}: the model has {count}")));
        }
    };
    match *change {
        ModelChange::InsertRow { index, .. } => model.insert_row(index)?,
        ModelChange::InsertColumn { index, .. } => model.insert_column(index)?,
        ModelChange::DeleteRow { index, .. } => model.delete_row(index)?,
        ModelChange::DeleteColumn { index, .. } => model.delete_column(index)?,
        ModelChange::Mirror { normal, .. } => model.mirror(unit(normal.into())?),
    }
    text(&models)
}

/// A unit tangent of which one component is `value` and the others keep their proportion.
///
/// # Errors
/// If the tangent has no length.
pub fn set_component(tangent: Vec3, axis: usize, value: f64) -> Result<Vec3, Problem> {
    if axis > 2 {
        return Err(Problem::new(format!("there is no axis {axis}")));
    }
    Ok(sphere::with_component(unit(tangent)?, axis, value))
}

/// A unit tangent turned about an axis.
///
/// # Errors
/// If tangent or axis have no length.
pub fn rotate(tangent: Vec3, axis: Vec3, degrees: f64) -> Result<Vec3, Problem> {
    Ok(sphere::rotated(unit(axis)?, degrees.to_radians(), unit(tangent)?).normalized())
}
