//! Project files, `*.fairform.json`: a mesh or a streamline model with all that was decided about it,
//! so that the studio and the command make the same surface of it.
//!
//! ```json
//! {
//!   "fairform": 1,
//!   "workspace": "interpolation",
//!   "mesh": {
//!     "name": "cube.obj",
//!     "bytes": "…base64…",
//!     "repairs": ["orient"],
//!     "design": {"scheme": "catmull-clark", "exact": true, "moves": [[0, 0, 0, 1]]},
//!     "fineness": {"levels": 3, "limit": true}
//!   }
//! }
//! ```
//!
//! The mesh is kept as the bytes of its file. What a project does not say is as by default. `studio` may
//! hold anything and is kept as it is.
//!
//! ```
//! use fairform_io::project::{self, Project, MeshPart};
//!
//! let mut mesh = MeshPart::new("corner.off", b"OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n".to_vec());
//! mesh.design.moves.push((2, 0.0, 2.0, 0.0));
//! let project = Project { mesh: Some(mesh), ..Project::default() };
//! let back = project::parse(&project::encode(&project))?;
//! assert_eq!(back, project);
//! let data = back.mesh.unwrap().data()?;
//! assert_eq!(data.positions[2].y, 2.0);
//!
//! let error = project::parse(br#"{"fairform": 1, "mesh": {"name": 7}}"#).unwrap_err();
//! assert!(error.to_string().contains("mesh.name: "), "{error}");
//! # Ok::<(), fairform_io::ParseError>(())
//! ```

use std::path::Path;
use std::sync::Arc;

use fairform::interpolate::{Method, Options};
use fairform::{Border, Corners, Creases, Mesh, Rules, Scheme, Vec3, crease};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::error::{ParseError, Place};
use crate::repair::{self, Steps};
use crate::{CreaseList, Format, MeshData, gzip, streamline};

mod names;

/// The version of the format that is written, and the only one so far.
pub const VERSION: u32 = 1;

/// What the name of a project file ends in.
pub const EXTENSION: &str = ".fairform.json";

/// Most subdivision steps that a project may ask for.
pub const MOST_LEVELS: u32 = 6;

/// Sharpness of an edge that stays sharp for ever, as JSON can say it.
pub const FOR_EVER: f64 = -1.0;

/// What a project file holds.
#[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Project {
    /// [`VERSION`].
    #[serde(rename = "fairform")]
    pub version: Version,
    /// Where it was worked on.
    #[serde(default)]
    pub workspace: Workspace,
    /// A mesh to interpolate.
    #[serde(default)]
    pub mesh: Option<MeshPart>,
    /// A streamline model, as [`streamline::parse`] reads it.
    #[serde(default)]
    pub model: Option<Value>,
    /// From where it was looked at.
    #[serde(default)]
    pub camera: Option<Camera>,
    /// What only the studio knows.
    #[serde(default)]
    pub studio: Value,
}

/// The version of a project: [`VERSION`].
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct Version(u32);

impl Default for Version {
    fn default() -> Self {
        Self(VERSION)
    }
}

/// Where a project was worked on.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Workspace {
    /// Meshes and the surfaces through their vertices.
    #[default]
    Interpolation,
    /// Streamline models.
    Streamline,
}

/// A mesh, and what was decided about it.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshPart {
    /// The name of its file, which says the format.
    pub name: String,
    /// The bytes of its file.
    #[serde(with = "names::base64")]
    pub bytes: Vec<u8>,
    /// Steps that are made on it first, see [`Steps::ask`].
    #[serde(default)]
    pub repairs: Vec<String>,
    /// How the surface is made.
    #[serde(default)]
    pub design: Design,
    /// How finely it is drawn.
    #[serde(default)]
    pub fineness: Fineness,
    /// Selected faces.
    #[serde(default)]
    pub faces: Vec<u32>,
    /// Selected vertices.
    #[serde(default)]
    pub vertices: Vec<u32>,
}

/// What a person decides about a mesh. Numbers of vertices and faces are those after repairs.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Design {
    /// The scheme.
    #[serde(with = "names::by_name")]
    pub scheme: Scheme,
    /// How control points are found.
    #[serde(with = "names::by_name")]
    pub method: Method,
    /// Largest distance of the surface from a vertex, relative to the diagonal of the box.
    pub tolerance: f64,
    /// Most updates per stage.
    pub iterations: u32,
    /// Whether to push back, see [`Options::exact`].
    pub exact: bool,
    /// Fairness from 0 to 1, see [`Options::fair`].
    pub fair: Option<f64>,
    /// What becomes of corners of the boundary.
    #[serde(with = "names::corners")]
    pub corners: Corners,
    /// What becomes of the boundary.
    #[serde(with = "names::border")]
    pub border: Border,
    /// The shape parameter of faces that are not in [`tensions`](Self::tensions).
    pub tension: Option<f64>,
    /// Faces with a parameter of their own.
    pub tensions: Vec<(u32, f64)>,
    /// Ends and sharpness of edges; [`FOR_EVER`] is beyond all numbers.
    pub creases: Vec<(u32, u32, f64)>,
    /// Vertices that are not where the file has them, and where they are.
    pub moves: Vec<(u32, f64, f64, f64)>,
}

/// How finely a surface is drawn.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Fineness {
    /// Subdivision steps from the given mesh, at most [`MOST_LEVELS`].
    pub levels: u32,
    /// Whether points lie on the limit surface, instead of those of the refined control mesh.
    pub limit: bool,
}

/// From where a project was looked at.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Where the camera is.
    pub position: [f64; 3],
    /// What it looks at.
    pub target: [f64; 3],
    /// What is up.
    pub up: [f64; 3],
    /// How much larger than usual things are.
    pub zoom: f64,
}

impl Default for Design {
    fn default() -> Self {
        let options = Options::default();
        Self {
            scheme: Scheme::default(),
            method: options.method,
            tolerance: 1e-6,
            iterations: options.iterations,
            exact: options.exact,
            fair: options.fair,
            corners: Corners::default(),
            border: Border::default(),
            tension: None,
            tensions: Vec::new(),
            creases: Vec::new(),
            moves: Vec::new(),
        }
    }
}

impl Default for Fineness {
    fn default() -> Self {
        Self { levels: 3, limit: true }
    }
}

/// The project in the bytes of a file, which may be gzipped.
///
/// # Errors
/// With the field and what should be there, or for what is no JSON the line and column; for another
/// version. Numbers of vertices and faces are compared with the mesh by [`MeshPart::data`] and
/// [`Design::rules`] only.
pub fn parse(bytes: &[u8]) -> Result<Project, ParseError> {
    if gzip::is_gzip(bytes) {
        return parse_plain(&gzip::unpack(bytes)?);
    }
    parse_plain(bytes)
}

fn parse_plain(bytes: &[u8]) -> Result<Project, ParseError> {
    /// All but the version is left for later.
    #[derive(Deserialize)]
    struct Head {
        fairform: Option<Value>,
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let head: Head = read(bytes)?;
    match head.fairform {
        Some(version) if version.as_u64() == Some(VERSION.into()) => {}
        Some(version) => {
            return Err(ParseError::file(format!("fairform: version {version}"))
                .expected(format!("{VERSION}, the version that this program knows")));
        }
        None => {
            return Err(ParseError::file("fairform: missing")
                .expected(format!("\"fairform\": {VERSION}, as in every project file")));
        }
    }
    let project: Project = read(bytes)?;
    project.check()?;
    Ok(project)
}

/// A value from JSON, or what is wrong with which field.
fn read<'b, T: Deserialize<'b>>(bytes: &'b [u8]) -> Result<T, ParseError> {
    let mut json = serde_json::Deserializer::from_slice(bytes);
    let value = serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let path = error.path().to_string();
        let inner = error.into_inner();
        let message = inner.to_string();
        let message = message.rsplit_once(" at line ").map_or(message.as_str(), |(m, _)| m);
        let place = Place::Character { line: inner.line() as u64, column: inner.column() as u64 };
        let is_field = inner.is_data() && path != ".";
        let message = if is_field { format!("{path}: {message}") } else { message.into() };
        ParseError::new(place, message)
    })?;
    json.end().map_err(|e| {
        let place = Place::Character { line: e.line() as u64, column: e.column() as u64 };
        ParseError::new(place, "more after the end of the project")
    })?;
    Ok(value)
}

/// A project as text; [`parse`] gives the same. The same project gives the same bytes.
///
/// # Panics
/// Never: a project is always JSON. Numbers that are not finite become null, which [`parse`] refuses.
#[must_use]
pub fn encode(project: &Project) -> Vec<u8> {
    let mut out = serde_json::to_vec_pretty(project).expect("a project is JSON");
    out.push(b'\n');
    out
}

/// A field that is not as it should be.
fn bad(path: &str, found: impl std::fmt::Display, expected: &str) -> ParseError {
    ParseError::file(format!("{path}: {found}")).expected(expected)
}

impl Project {
    /// Whether all numbers are in range, as far as that can be said without the mesh.
    fn check(&self) -> Result<(), ParseError> {
        if let Some(mesh) = &self.mesh {
            mesh.check()?;
        }
        if let Some(model) = &self.model {
            let text = model.to_string();
            streamline::parse(text.as_bytes()).map_err(|e| ParseError {
                place: Place::File,
                message: format!("model.{}", e.message),
                expected: e.expected,
            })?;
        }
        Ok(())
    }
}

impl MeshPart {
    /// The mesh of a file, as by default.
    #[must_use]
    pub fn new(name: impl Into<String>, bytes: Vec<u8>) -> Self {
        Self {
            name: name.into(),
            bytes,
            repairs: Vec::new(),
            design: Design::default(),
            fineness: Fineness::default(),
            faces: Vec::new(),
            vertices: Vec::new(),
        }
    }

    fn check(&self) -> Result<(), ParseError> {
        self.format()?;
        Steps::named(&self.repairs).map_err(|e| ParseError::file(format!("mesh.repairs: {e}")))?;
        if self.fineness.levels > MOST_LEVELS {
            let expected = format!("0 to {MOST_LEVELS}");
            return Err(bad("mesh.fineness.levels", self.fineness.levels, &expected));
        }
        self.design.check("mesh.design")
    }

    fn format(&self) -> Result<Format, ParseError> {
        let format = Format::from_path(Path::new(&self.name)).map(|(format, _)| format);
        format.ok_or_else(|| {
            let known = "a name that tells a format: ".to_owned() + Format::KNOWN;
            bad("mesh.name", format_args!("{:?}", self.name), &known)
        })
    }

    /// The mesh as it was read and repaired, before vertices were moved.
    ///
    /// # Errors
    /// Where the bytes are no mesh; if a repair cannot be made.
    pub fn given(&self) -> Result<MeshData, ParseError> {
        let data = crate::parse(&self.bytes, self.format()?).map_err(|e| ParseError {
            message: format!("mesh.bytes, {}: {}", self.name, e.message),
            ..e
        })?;
        let at = |e: &dyn std::fmt::Display| ParseError::file(format!("mesh.repairs: {e}"));
        let steps = Steps::named(&self.repairs).map_err(|e| at(&e))?;
        if steps == Steps::default() {
            return Ok(data);
        }
        Ok(repair::run(data, &steps).map_err(|e| at(&e))?.0)
    }

    /// The mesh with repairs made and vertices moved: what the surface is to pass through.
    ///
    /// # Errors
    /// As [`given`](Self::given); if there is no vertex of a number that is moved.
    pub fn data(&self) -> Result<MeshData, ParseError> {
        let mut data = self.given()?;
        self.design.apply_moves(&mut data.positions).map_err(ParseError::file)?;
        Ok(data)
    }
}

impl Design {
    /// Whether all numbers are in range, as far as that can be said without the mesh.
    ///
    /// # Errors
    /// With the field, below `path`, and what should be there.
    pub fn check(&self, path: &str) -> Result<(), ParseError> {
        let at = |field: &str| format!("{path}.{field}");
        if !(self.tolerance > 0.0 && self.tolerance.is_finite()) {
            return Err(bad(&at("tolerance"), self.tolerance, "a positive number"));
        }
        if let Some(fair) = self.fair.filter(|fair| !(0.0..=1.0).contains(fair)) {
            return Err(bad(&at("fair"), fair, "0 to 1, or null"));
        }
        let is_tension = |t: f64| t > 0.0 && t <= 1.0;
        if let Some(tension) = self.tension.filter(|&t| !is_tension(t)) {
            return Err(bad(&at("tension"), tension, "above 0 and at most 1, or null"));
        }
        if let Some(i) = self.tensions.iter().position(|t| !is_tension(t.1)) {
            let path = at(&format!("tensions[{i}]"));
            return Err(bad(&path, self.tensions[i].1, "above 0 and at most 1"));
        }
        let is_sharpness = |s: f64| s == FOR_EVER || s >= 0.0;
        if let Some(i) = self.creases.iter().position(|c| !is_sharpness(c.2)) {
            let path = at(&format!("creases[{i}]"));
            return Err(bad(&path, self.creases[i].2, "a sharpness from 0 up, or -1 for ever"));
        }
        let is_place = |m: &(u32, f64, f64, f64)| Vec3::new(m.1, m.2, m.3).is_finite();
        if let Some(i) = self.moves.iter().position(|m| !is_place(m)) {
            return Err(bad(&at(&format!("moves[{i}]")), "not a place", "[vertex, x, y, z]"));
        }
        Ok(())
    }

    /// How to fit.
    #[must_use]
    pub fn options(&self) -> Options {
        Options {
            method: self.method,
            tolerance: Some(self.tolerance),
            iterations: self.iterations,
            exact: self.exact,
            fair: self.fair,
            ..Options::default()
        }
    }

    /// Moves the vertices that are moved.
    ///
    /// # Errors
    /// If there is no such vertex.
    pub fn apply_moves(&self, positions: &mut [Vec3]) -> Result<(), String> {
        let count = positions.len();
        for &(v, x, y, z) in &self.moves {
            let slot = positions.get_mut(v as usize).ok_or_else(|| {
                format!("moves: vertex {v} is moved, but the mesh has {count} vertices, from 0")
            })?;
            *slot = Vec3::new(x, y, z);
        }
        Ok(())
    }

    /// The rules for a mesh, and what is to be said about them. What the scheme does not know is left out
    /// and named: shape parameters with the interpolating schemes, creases with all but Loop and
    /// Catmull–Clark. Of the creases of a file only sharp vertices count here; its edges are expected
    /// among [`creases`](Self::creases), if they are wanted.
    ///
    /// # Errors
    /// If there is no such face or edge; as [`Rules::check`].
    pub fn rules(
        &self,
        mesh: &Mesh,
        file: Option<&CreaseList>,
    ) -> Result<(Rules, Vec<String>), String> {
        let topology = mesh.topology();
        let scheme = self.scheme;
        let mut notes = Vec::new();
        let (corners, border) = (self.corners, self.border);
        let mut rules = Rules { corners, border, ..Rules::from(scheme) };
        if self.tension.is_some() || !self.tensions.is_empty() {
            let count = topology.face_count();
            let mut tension = vec![self.tension.unwrap_or(0.5); count];
            for &(face, value) in &self.tensions {
                *tension.get_mut(face as usize).ok_or_else(|| {
                    format!("tensions: there is no face {face}; the mesh has {count}, from 0")
                })? = value;
            }
            match scheme.is_interpolating() {
                true => notes.push(format!("{scheme} knows no shape parameters: left out")),
                false => rules.tension = Some(tension.into()),
            }
        }
        let vertices = file.map_or_else(Vec::new, |list| list.vertices.clone());
        if !self.creases.is_empty() || !vertices.is_empty() {
            let sharpness = |s: f64| if s == FOR_EVER { crease::INFINITE } else { s };
            let edges = self.creases.iter().map(|&(a, b, s)| ([a, b], sharpness(s))).collect();
            let list = CreaseList { edges, vertices, ..CreaseList::default() };
            let mut creases = Creases::smooth(topology);
            list.apply(topology, &mut creases).map_err(|e| format!("creases: {e}"))?;
            match scheme {
                _ if creases.is_smooth() => {}
                Scheme::Loop | Scheme::CatmullClark => rules.creases = Some(Arc::new(creases)),
                _ => notes.push(format!("{scheme} knows no creases: left out")),
            }
        }
        rules.check(topology).map_err(|e| e.to_string())?;
        notes.extend(rules.warnings(topology).iter().map(ToString::to_string));
        Ok((rules, notes))
    }
}
