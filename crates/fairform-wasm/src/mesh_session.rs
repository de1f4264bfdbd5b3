//! [`MeshSession`]: one mesh, from its bytes to its surface.

use std::ops::ControlFlow;
use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;

use fairform::edit::Editor;
use fairform::interpolate::{Fit, FitReport, Interpolator, StageName, fit_mesh};
use fairform::select::{self, Context, Selection};
use fairform::solve::{Outcome, Step};
use fairform::tessellate::{MOST_AT_ONCE, Points, Tessellation};
use fairform::{FaceId, Mesh, Rules, Scheme, Topology, Vec3, VertexId, fairness, limit, refine};
use fairform_io::project::{Design, FOR_EVER, Fineness, MOST_LEVELS};
use fairform_io::repair::{self, Steps};
use fairform_io::{
    CreaseList, Format, InterpolateBoundary, Labels, MeshData, WriteOptions, encode, parse,
};
use serde::{Deserialize, Serialize};

use crate::drag::Grabbed;
use crate::values::{Colouring, Values};
use crate::{Geometry, Problem};

/// Most points of a surface that is drawn: the memory of a page has an end.
const MOST_POINTS: u64 = 4_000_000;

/// One mesh, what was last decided about it, and the surface that follows.
#[derive(Debug)]
pub struct MeshSession {
    name: String,
    format: Format,
    /// As it was read and repaired.
    pub(crate) data: MeshData,
    /// The data as a mesh, with the vertices where they have been moved.
    pub(crate) mesh: Mesh,
    notes: Vec<String>,
    pub(crate) fitted: Option<Fitted>,
    pub(crate) drawn: Option<Drawn>,
    /// Of the control points of the last fit, once vertices were dragged.
    pub(crate) editor: Option<Editor>,
    pub(crate) grabbed: Option<Grabbed>,
}

/// A control mesh whose surface passes through the vertices.
#[derive(Debug, Clone)]
pub(crate) struct Fitted {
    pub(crate) design: Design,
    pub(crate) target: Mesh,
    pub(crate) rules: Rules,
    pub(crate) level: u32,
    /// Mesh and rules of the control mesh, `level` steps finer than the target.
    pub(crate) control: Mesh,
    pub(crate) control_rules: Rules,
    /// The unit of residuals.
    pub(crate) unit: f64,
    /// All updates, counted through the stages.
    pub(crate) updates: u32,
    /// How many updates each stage makes, where that is not for a tolerance to say.
    pub(crate) each: Option<u32>,
    /// Which faces of the given mesh have a surface, if not all have.
    pub(crate) shown: Option<Vec<bool>>,
}

/// A surface that was drawn.
#[derive(Debug)]
pub(crate) struct Drawn {
    pub(crate) fineness: Fineness,
    /// After how many updates, if not all.
    pub(crate) iteration: Option<u32>,
    pub(crate) fine: Tessellation,
    /// The control points that it was made of, and their level.
    pub(crate) control: Vec<Vec3>,
    pub(crate) level: u32,
    /// The face of the given mesh that each face of the base is a part of.
    pub(crate) origin: Vec<u32>,
}

/// What there is to know about an opened mesh.
#[derive(Clone, PartialEq, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct MeshInfo {
    /// The name of the file.
    pub name: String,
    /// `obj`, `off`, `ply`, `stl`, `gltf` or `glb`.
    pub format: String,
    /// Number of vertices.
    pub vertex_count: usize,
    /// Number of edges.
    pub edge_count: usize,
    /// Number of faces.
    pub face_count: usize,
    /// Corners of the largest face.
    pub most_corners: usize,
    /// Corners of the smallest face.
    pub least_corners: usize,
    /// Number of closed curves that the boundary consists of.
    pub boundary_loop_count: usize,
    /// Number of connected parts.
    pub component_count: usize,
    /// Groups and materials.
    pub groups: Vec<Group>,
    /// The lowest coordinates.
    pub min: [f64; 3],
    /// The highest coordinates.
    pub max: [f64; 3],
    /// What there is to say about the file.
    pub notes: Vec<String>,
    /// Sharp edges of the file, as in [`Design::creases`].
    pub creases: Vec<(u32, u32, f64)>,
    /// The scheme that suits it.
    pub scheme: &'static str,
}

/// Faces of one name.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Group {
    /// `group` or `material`.
    pub kind: &'static str,
    /// The name, as the selection language has it.
    pub name: String,
    /// Number of faces.
    pub face_count: usize,
}

/// One update of a fit.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Progress {
    /// The stage.
    pub stage: &'static str,
    /// Updates so far, counted through all stages.
    pub iteration: u32,
    /// Largest distance of limit points from their vertices, relative to the diagonal.
    pub max: f64,
    /// Mean distance.
    pub mean: f64,
}

/// What a fit did.
#[derive(Clone, PartialEq, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct FitResult {
    /// Every update of every stage, and what each stage began with.
    pub history: Vec<Progress>,
    /// Whether no stage missed the tolerance.
    pub converged: bool,
    /// What there is to say.
    pub notes: Vec<String>,
    /// Largest distance of the result, relative to the diagonal.
    pub max: f64,
    /// Mean distance.
    pub mean: f64,
    /// How many steps the control mesh is finer than the given one.
    pub control_level: u32,
    /// Number of control points.
    pub control_vertex_count: usize,
    /// Number of faces of the control mesh.
    pub control_face_count: usize,
}

/// The given mesh.
#[derive(Clone, PartialEq, Debug)]
pub struct Given {
    /// How it is drawn; its edges are in the order of the kernel.
    pub geometry: Geometry,
    /// The vertices on the boundary.
    pub boundary: Vec<u32>,
}

/// A question about faces.
#[derive(Clone, PartialEq, Eq, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Query {
    /// Those that a text describes.
    Expression {
        /// In the language of [`fairform::select`].
        text: String,
    },
    /// The selected and their neighbours.
    Grow,
    /// The selected without those at the rim.
    Shrink,
    /// Those that are not selected.
    Invert,
    /// The parts that hold a selected face.
    Connected,
}

/// What can be saved.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum What {
    /// The surface as it was last drawn.
    Surface,
    /// The control mesh.
    Control,
    /// The given mesh, with the vertices where they have been moved.
    Given,
}

impl FromStr for What {
    type Err = Problem;

    fn from_str(name: &str) -> Result<Self, Problem> {
        match name {
            "surface" => Ok(Self::Surface),
            "control" => Ok(Self::Control),
            "given" => Ok(Self::Given),
            _ => Err(Problem::new(format!("there is no {name:?} to save"))),
        }
    }
}

impl MeshSession {
    /// Reads a mesh in the format that its name says, and makes repair steps on it first.
    ///
    /// # Errors
    /// For bytes that are no such mesh; for a mesh that is no manifold, with the repairs that help.
    pub fn open<S: AsRef<str>>(bytes: &[u8], name: &str, repairs: &[S]) -> Result<Self, Problem> {
        let (format, _) = Format::from_path(Path::new(name)).ok_or_else(|| {
            Problem::new(format!("{name}: the name tells no format that is known"))
                .help("open an .obj, .off, .ply, .stl, .gltf or .glb file, also gzipped")
        })?;
        let mut data = parse(bytes, format).map_err(|e| Problem::at(name, e))?;
        let steps = Steps::named(repairs).map_err(|e| Problem::new(e.to_string()))?;
        let mut notes = std::mem::take(&mut data.notes);
        if steps != Steps::default() {
            let (repaired, done) = repair::run(data, &steps).map_err(|e| Problem::at(name, e))?;
            notes.extend(done.iter().map(ToString::to_string));
            notes.extend_from_slice(&repaired.notes);
            data = repaired;
        }
        let mesh = Mesh::new(data.positions.clone(), &data.faces)
            .map_err(|e| Problem::in_mesh(name, &e, &data))?;
        if mesh.topology().face_count() == 0 {
            return Err(Problem::new(format!("{name}: no faces, so there is no surface"))
                .help("open a file with polygons"));
        }
        if let Some(list) = &data.creases {
            notes.extend(crease_notes(list));
        }
        let isolated = mesh.topology().isolated_count();
        if isolated > 0 {
            notes.push(format!("{isolated} vertices belong to no face and do not matter"));
        }
        let name = name.into();
        Ok(Self {
            name,
            format,
            data,
            mesh,
            notes,
            fitted: None,
            drawn: None,
            editor: None,
            grabbed: None,
        })
    }

    /// What there is to know about it.
    #[must_use]
    pub fn info(&self) -> MeshInfo {
        let topology = self.mesh.topology();
        let corners = || topology.faces().map(|f| topology.face_vertices(f).len());
        let (most_corners, least_corners) =
            (corners().max().unwrap_or(0), corners().min().unwrap_or(0));
        let bounds = self.mesh.bounds();
        let labels = [("group", &self.data.groups), ("material", &self.data.materials)];
        let groups = labels.into_iter().flat_map(|(kind, labels)| groups_of(kind, labels.as_ref()));
        let edges = self.data.creases.iter().flat_map(|list| &list.edges);
        let scheme = if most_corners == 3 { Scheme::Loop } else { Scheme::CatmullClark };
        MeshInfo {
            name: self.name.clone(),
            format: self.format.to_string(),
            vertex_count: topology.vertex_count(),
            edge_count: topology.edge_count(),
            face_count: topology.face_count(),
            most_corners,
            least_corners,
            boundary_loop_count: topology.boundary_loops().len(),
            component_count: topology.components().list.len(),
            groups: groups.collect(),
            min: bounds.min.into(),
            max: bounds.max.into(),
            notes: self.notes.clone(),
            creases: edges.map(|&([a, b], s)| (a, b, written_sharpness(s))).collect(),
            scheme: scheme.name(),
        }
    }

    /// The given mesh, with the vertices where they have been moved.
    #[must_use]
    pub fn given(&self) -> Given {
        let topology = self.mesh.topology();
        let boundary = topology.vertices().filter(|&v| topology.is_boundary(v)).map(|v| v.0);
        Given { geometry: Geometry::of_mesh(&self.mesh, |f| f), boundary: boundary.collect() }
    }

    /// Fits, telling every update; the observer may break. Keeps the result for what follows.
    ///
    /// # Errors
    /// For a design that does not fit the mesh; if the observer breaks. What was there stays then.
    pub fn fit(
        &mut self,
        design: &Design,
        observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<FitResult, Problem> {
        let (target, rules, mut notes) = self.prepare(design)?;
        let mut history: Vec<Progress> = Vec::new();
        let (mut before, mut last): (u32, Option<(StageName, u32)>) = (0, None);
        let mut observe = |stage: StageName, step: Step| {
            // Another stage, or the same anew.
            if let Some((_, updates)) =
                last.filter(|&(name, updates)| name != stage || step.updates < updates)
            {
                before += updates;
            }
            last = Some((stage, step.updates));
            let iteration = before + step.updates;
            let progress =
                Progress { stage: stage.name(), iteration, max: step.max, mean: step.mean };
            let flow = observer(&progress);
            history.push(progress);
            flow
        };
        let fit = fit_mesh(&target, &rules, &design.options(), &mut observe)
            .map_err(|e| self.problem(&e, design))?;
        let updates = history.last().map_or(0, |p| p.iteration);
        notes.extend(notes_on(&fit, &rules));
        let Fit { control, rules: control_rules, level, report, .. } = fit;
        let result = FitResult {
            history,
            converged: report.is_converged(),
            notes,
            max: report.max,
            mean: report.mean,
            control_level: level,
            control_vertex_count: control.topology().vertex_count(),
            control_face_count: control.topology().face_count(),
        };
        let counted = report.stages.iter().filter(|s| s.solve.outcome == Outcome::CountReached);
        let each = counted.map(|stage| stage.solve.last().updates).max();
        let shown = self.shown(&rules, target.topology());
        self.mesh = target.clone();
        (self.drawn, self.editor, self.grabbed) = (None, None, None);
        self.fitted = Some(Fitted {
            design: design.clone(),
            target,
            rules,
            level,
            control,
            control_rules,
            unit: report.unit,
            updates,
            each,
            shown,
        });
        Ok(result)
    }

    /// The mesh with vertices moved, and the rules, and what is to be said about them.
    fn prepare(&self, design: &Design) -> Result<(Mesh, Rules, Vec<String>), Problem> {
        design.check("design").map_err(Problem::from)?;
        let mut positions = self.data.positions.clone();
        design.apply_moves(&mut positions).map_err(Problem::new)?;
        let target = self.mesh.with_positions(positions);
        let (rules, notes) = design
            .rules(&target, self.data.creases.as_ref())
            .map_err(|message| Problem { help: self.advice(design), ..Problem::new(message) })?;
        Ok((target, rules, notes))
    }

    /// A kernel error about a fit.
    fn problem(&self, error: &fairform::Error, design: &Design) -> Problem {
        let problem = Problem::from(error.clone());
        let help = match error {
            fairform::Error::NotSymmetric => Some("choose the method auto".into()),
            fairform::Error::Interrupted | fairform::Error::Overflow { .. } => None,
            _ => self.advice(design),
        };
        Problem { help, ..problem }
    }

    /// What to do if the scheme does not suit the mesh.
    fn advice(&self, design: &Design) -> Option<String> {
        let size = self.mesh.topology().uniform_face_size();
        match design.scheme {
            Scheme::Loop | Scheme::Butterfly if size != Some(3) => Some(
                "choose Catmull–Clark or Doo–Sabin, or open it with the repair triangulate".into(),
            ),
            Scheme::Kobbelt if size != Some(4) => {
                Some("choose Catmull–Clark or Doo–Sabin, which take all polygons".into())
            }
            _ => None,
        }
    }

    /// Which faces have a surface, if not all have.
    fn shown(&self, rules: &Rules, topology: &Topology) -> Option<Vec<bool>> {
        let mut shown = rules.has_surface(topology);
        if matches!(rules.scheme, Scheme::Loop | Scheme::CatmullClark) {
            for &hole in self.data.creases.iter().flat_map(|list| &list.holes) {
                if let Some(shown) = shown.get_mut(hole as usize) {
                    *shown = false;
                }
            }
        }
        shown.contains(&false).then_some(shown)
    }

    fn fitted(&self) -> Result<&Fitted, Problem> {
        self.fitted
            .as_ref()
            .ok_or_else(|| Problem::new("there is no surface yet").help("fit the mesh first"))
    }

    /// The control mesh of the last fit, or after so many updates of it.
    ///
    /// # Errors
    /// If nothing was fitted.
    pub fn control(&self, iteration: Option<u32>) -> Result<Geometry, Problem> {
        let fitted = self.fitted()?;
        let (control, level) = fitted.control_after(iteration)?;
        let origin = fitted.parents(level)?;
        let (topology, _) = fitted.finer(level);
        let mesh = Mesh::from_parts(topology, control);
        Ok(Geometry::of_mesh(&mesh, |f| origin[f as usize]))
    }

    /// The surface of the last fit, or of the control mesh after so many updates of it. Kept for values,
    /// drags and saving.
    ///
    /// # Errors
    /// If nothing was fitted, or it would take too much memory.
    pub fn surface(
        &mut self,
        fineness: Fineness,
        iteration: Option<u32>,
    ) -> Result<Geometry, Problem> {
        let fitted = self.fitted()?;
        let drawn = fitted.draw(fineness, iteration)?;
        let surface = drawn.fine.surface(&drawn.control)?;
        let geometry = Geometry::of_surface(&surface, &drawn.origin, fitted.shown.as_deref());
        self.drawn = Some(drawn);
        self.grabbed = None;
        Ok(geometry)
    }

    pub(crate) fn drawn(&self) -> Result<(&Fitted, &Drawn), Problem> {
        let fitted = self.fitted()?;
        let drawn = self.drawn.as_ref().ok_or_else(|| {
            Problem::new("no surface has been drawn yet").help("ask for the surface first")
        })?;
        Ok((fitted, drawn))
    }

    /// One value per point of the surface as it was last drawn.
    ///
    /// # Errors
    /// If none was drawn.
    pub fn values(&self, colouring: Colouring) -> Result<Values, Problem> {
        let (fitted, drawn) = self.drawn()?;
        let surface = drawn.fine.surface(&drawn.control)?;
        let values: Vec<f64> = match colouring {
            Colouring::Gaussian | Colouring::Mean | Colouring::MaxAbs => {
                let (points, normals) = surface.points_and_normals();
                let mesh = Mesh::new(points, &drawn.fine.faces())?;
                let curvatures = fairness::curvatures(mesh.topology(), mesh.positions(), &normals);
                curvatures.iter().filter_map(|c| colouring.of_curvature(c)).collect()
            }
            Colouring::Deviation => fairness::distances(&surface.points(), &self.mesh),
            Colouring::Error => drawn.spread(fitted, &fitted.errors(drawn)?)?,
            Colouring::Tension => drawn.spread(fitted, &fitted.tension_at_vertices())?,
        };
        Ok(Values::new(colouring, &values))
    }

    /// The faces that answer a question.
    ///
    /// # Errors
    /// For a text that is not in the language, or names what the mesh does not have; if there is not one
    /// byte per face.
    pub fn query(&self, selected: &[u8], query: &Query) -> Result<Vec<u8>, Problem> {
        let topology = self.mesh.topology();
        let selected = self.selection(selected)?;
        let found = match query {
            Query::Expression { text } => {
                let mut context = Context::new(&self.mesh);
                context.groups = self.data.groups.as_ref().map(of_labels);
                context.materials = self.data.materials.as_ref().map(of_labels);
                let selection: Selection =
                    text.parse().map_err(|e: select::SelectError| Problem::new(e.to_string()))?;
                selection.faces(&context).map_err(|e| Problem::new(e.to_string()))?
            }
            Query::Grow => select::grow(topology, &selected, 1),
            Query::Shrink => select::shrink(topology, &selected, 1),
            Query::Invert => selected.iter().map(|s| !s).collect(),
            Query::Connected => select::grow(topology, &selected, u32::MAX),
        };
        Ok(found.into_iter().map(u8::from).collect())
    }

    fn selection(&self, selected: &[u8]) -> Result<Vec<bool>, Problem> {
        let expected = self.mesh.topology().face_count();
        if selected.len() != expected {
            let count = selected.len();
            return Err(Problem::new(format!("{count} faces are asked about, of {expected}")));
        }
        Ok(selected.iter().map(|&s| s != 0).collect())
    }

    /// The parameters of faces, those that differ from the design's own for all, after `value` was set on
    /// the selected. It fades over `rings` times the mean length of an edge.
    ///
    /// # Errors
    /// As [`query`](Self::query); for a distance that is negative.
    pub fn spread_tension(
        &self,
        design: &Design,
        selected: &[u8],
        value: f64,
        rings: f64,
    ) -> Result<Vec<(u32, f64)>, Problem> {
        let selected = self.selection(selected)?;
        let plain = design.tension.unwrap_or(0.5);
        let mut tension = vec![plain; selected.len()];
        for &(f, value) in &design.tensions {
            if let Some(slot) = tension.get_mut(f as usize) {
                *slot = value;
            }
        }
        let weights = if rings == 0.0 {
            selected.iter().map(|&s| f64::from(u8::from(s))).collect()
        } else {
            select::falloff(&self.mesh, &selected, rings * mean_edge(&self.mesh))?
        };
        select::blend(&mut tension, &weights, value);
        Ok((0..).zip(tension).filter(|t| t.1 != plain).collect())
    }

    /// A mesh as the bytes of a file.
    ///
    /// # Errors
    /// If there is nothing to save yet, or the format has no place for it.
    pub fn save(&self, what: What, format: Format) -> Result<Vec<u8>, Problem> {
        let data = match what {
            What::Given => {
                MeshData { positions: self.mesh.positions().to_vec(), ..self.data.clone() }
            }
            What::Control => self.fitted()?.control_data(&self.data)?,
            What::Surface => {
                let (fitted, drawn) = self.drawn()?;
                drawn.data(fitted, &self.data)?
            }
        };
        let mut out = Vec::new();
        encode(format, &data, &WriteOptions::default(), &mut out)?;
        Ok(out)
    }
}

impl Fitted {
    /// The topology and rules some steps finer than the target: 0 or as much as the control mesh.
    fn finer(&self, level: u32) -> (Arc<Topology>, Rules) {
        if level == self.level {
            return (Arc::clone(self.control.topology()), self.control_rules.clone());
        }
        (Arc::clone(self.target.topology()), self.rules.clone())
    }

    /// Control points after so many updates, and how many steps they are finer than the target.
    fn control_after(&self, iteration: Option<u32>) -> Result<(Vec<Vec3>, u32), Problem> {
        let updates = match iteration {
            Some(updates) if updates < self.updates => updates,
            _ => return Ok((self.control.positions().to_vec(), self.level)),
        };
        let (topology, positions) = (self.target.topology(), self.target.positions());
        let interpolator = Interpolator::near(topology, &self.rules, positions)?;
        let mut options = self.design.options();
        if let Some(each) = self.each {
            (options.tolerance, options.iterations) = (None, each);
        }
        Ok((interpolator.after(positions, &options, updates)?, 0))
    }

    /// The face of the target that each face of the control mesh is a part of.
    fn parents(&self, level: u32) -> Result<Vec<u32>, Problem> {
        if level == 0 {
            return Ok((0..self.target.topology().face_count() as u32).collect());
        }
        let step = refine::refine(self.target.topology(), &self.rules)?;
        Ok(step.topology.faces().map(|f| step.parent(f).0).collect())
    }

    pub(crate) fn draw(
        &self,
        fineness: Fineness,
        iteration: Option<u32>,
    ) -> Result<Drawn, Problem> {
        if fineness.levels > MOST_LEVELS {
            return Err(Problem::new(format!("at most {MOST_LEVELS} levels are drawn")));
        }
        let (control, level) = self.control_after(iteration)?;
        let (topology, rules) = self.finer(level);
        let steps = fineness.levels.saturating_sub(level);
        let size = refine::check_size(&topology, &rules, steps)?;
        if size.vertex_count > MOST_POINTS {
            let message =
                format!("{} levels would make {} points", fineness.levels, size.vertex_count);
            return Err(
                Problem::new(message).help("choose fewer levels; each makes four times as many")
            );
        }
        let points = if fineness.limit { Points::Limit } else { Points::Control };
        let fine = if level == 0 {
            Tessellation::new(&topology, &rules, steps, points)?
        } else {
            let first = steps.saturating_sub(MOST_AT_ONCE);
            Tessellation::from_level(&topology, &rules, first, steps, points)?
        };
        let parents = self.parents(level)?;
        let origin = fine.parents().into_iter().map(|f| parents[f as usize]).collect();
        let iteration = iteration.filter(|&updates| updates < self.updates);
        Ok(Drawn { fineness, iteration, fine, control, level, origin })
    }

    /// How far the surface of a drawing is from each vertex of the target, relative to the diagonal.
    fn errors(&self, drawn: &Drawn) -> Result<Vec<f64>, Problem> {
        let limit = if drawn.level == 0 {
            limit::limit_points(self.target.topology(), &drawn.control, &self.rules)?
        } else {
            fairform::pushback::PushBack::new(self.target.topology(), &self.rules)?
                .limit_points(&drawn.control)
        };
        let topology = self.target.topology();
        let distance = |(v, (p, q)): (u32, (&Vec3, &Vec3))| match topology.is_isolated(VertexId(v))
        {
            true => 0.0,
            false => (*p - *q).length() / self.unit,
        };
        Ok((0..).zip(limit.iter().zip(self.target.positions())).map(distance).collect())
    }

    /// The mean parameter of the faces at each vertex.
    fn tension_at_vertices(&self) -> Vec<f64> {
        let topology = self.target.topology();
        let plain = self.design.tension.unwrap_or(0.5);
        let Some(tension) = &self.rules.tension else {
            return vec![plain; topology.vertex_count()];
        };
        let mean = |v| {
            let faces = topology.fan(v).map(|h| tension[topology.face(h).index()]);
            let count = f64::from(topology.fan_size(v));
            if count == 0.0 { plain } else { faces.sum::<f64>() / count }
        };
        topology.vertices().map(mean).collect()
    }

    /// The control mesh as a file holds it: with the creases and the support that make its surface.
    fn control_data(&self, given: &MeshData) -> Result<MeshData, Problem> {
        let topology = self.control.topology();
        let rules = &self.control_rules;
        let parents = self.parents(self.level)?;
        let is_shown =
            |f: FaceId| self.shown.as_ref().is_none_or(|shown| shown[parents[f.index()] as usize]);
        let creases = CreaseList::of_control(topology, rules, rules.creases.is_some(), is_shown);
        let mut data = MeshData {
            positions: self.control.positions().to_vec(),
            faces: topology.to_faces(),
            creases,
            ..MeshData::default()
        };
        self.attributes(given, &parents, &mut data)?;
        Ok(data)
    }
}

impl Drawn {
    /// Values of the vertices of the target, carried to the points of the surface as colours would be.
    fn spread(&self, fitted: &Fitted, values: &[f64]) -> Result<Vec<f64>, Problem> {
        let mut field: Vec<Vec3> = values.iter().map(|&x| Vec3::new(x, 0.0, 0.0)).collect();
        if self.level > 0 {
            field = refine::refine(fitted.target.topology(), &fitted.rules)?.apply(&field);
        }
        Ok(self.fine.field(&field)?.points().into_iter().map(|p| p.x).collect())
    }

    /// The surface as a file holds it.
    fn data(&self, fitted: &Fitted, given: &MeshData) -> Result<MeshData, Problem> {
        let surface = self.fine.surface(&self.control)?;
        let (positions, normals) = surface.points_and_normals();
        let mut faces = self.fine.faces();
        let mut origin = self.fine.base_of_faces();
        origin.iter_mut().for_each(|f| *f = self.origin[*f as usize]);
        if let Some(shown) = &fitted.shown {
            let kept = |f: &u32| shown[*f as usize];
            faces = faces.iter().zip(&origin).filter(|f| kept(f.1)).map(|f| f.0).collect();
            origin.retain(kept);
        }
        let mut data = MeshData { positions, normals: Some(normals), faces, ..MeshData::default() };
        self.attributes(fitted, given, &origin, &mut data)?;
        Ok(data)
    }
}

fn of_labels(labels: &Labels) -> select::Labels<'_> {
    select::Labels::new(&labels.names, &labels.of_face)
}

fn groups_of(kind: &'static str, labels: Option<&Labels>) -> Vec<Group> {
    let Some(labels) = labels else { return Vec::new() };
    let mut counts = vec![0; labels.names.len()];
    labels.of_face.iter().for_each(|&i| counts[i as usize] += 1);
    let named = labels.names.iter().zip(counts);
    named.map(|(name, face_count)| Group { kind, name: name.clone(), face_count }).collect()
}

fn written_sharpness(sharpness: f64) -> f64 {
    if sharpness >= fairform::crease::INFINITE { FOR_EVER } else { sharpness }
}

/// What is in a file besides the mesh.
fn crease_notes(list: &CreaseList) -> Option<String> {
    let mut parts = Vec::new();
    let mut say = |count: usize, one: &str, many: &str| match count {
        0 => {}
        1 => parts.push(format!("1 {one}")),
        n => parts.push(format!("{n} {many}")),
    };
    say(list.edges.len(), "sharp edge", "sharp edges");
    say(list.vertices.len(), "sharp vertex", "sharp vertices");
    say(list.holes.len(), "hole", "holes");
    match list.boundary {
        Some(InterpolateBoundary::None) => parts.push("no surface at the boundary".into()),
        Some(InterpolateBoundary::EdgeAndCorner) => parts.push("sharp corners".into()),
        _ => {}
    }
    (!parts.is_empty()).then(|| format!("the file has {}", parts.join(", ")))
}

/// What is to be said about a fit.
fn notes_on(fit: &Fit, rules: &Rules) -> Vec<String> {
    let mut notes = Vec::new();
    let FitReport { stages, pushed_back, fairing, .. } = &fit.report;
    for stage in stages {
        let steps = stage.solve.last().updates;
        let why = match stage.solve.outcome {
            Outcome::TooManyUpdates => format!("the tolerance was not met in {steps} updates"),
            Outcome::Stalled => format!("after {steps} updates only rounding is left"),
            _ => continue,
        };
        notes.push(format!("{}: {why}", stage.name));
    }
    if rules.scheme.is_interpolating() {
        notes.push(format!("{} passes through the vertices by itself", rules.scheme));
    }
    if !fit.singular.is_empty() {
        let count = fit.singular.len();
        notes.push(format!(
            "no control mesh of the given connectivity interpolates {count} of the parts, so the \
             control mesh is one level finer"
        ));
    }
    if let Some(distance) = pushed_back {
        notes
            .push(format!("pushed back by at most {distance:.1e} of the diagonal, which is exact"));
    }
    if let Some(fairing) = fairing {
        let share = if fairing.before > 0.0 { fairing.after / fairing.before } else { 1.0 };
        notes.push(format!("fairing left {:.1} % of the energy", 100.0 * share));
    }
    notes
}

/// The mean length of the edges.
fn mean_edge(mesh: &Mesh) -> f64 {
    let (topology, points) = (mesh.topology(), mesh.positions());
    let length = |e| {
        let h = topology.edge_halfedge(e);
        (points[topology.origin(h).index()] - points[topology.target(h).index()]).length()
    };
    let count = topology.edge_count().max(1) as f64;
    topology.edges().map(length).sum::<f64>() / count
}
