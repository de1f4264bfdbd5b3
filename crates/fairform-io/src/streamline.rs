//! Model files of streamline surfaces, `*.streamline.json`: what a surface is designed by.
//!
//! ```json
//! {
//!   "version": 1,
//!   "kind": "surface",
//!   "tangents": [
//!     [[0.8, 0, 0.6], [1, 0, 0], [0.8, 0, -0.6]],
//!     [[0.6, 0, 0.8], [1, 0, 0], [0.6, 0, -0.8]]
//!   ],
//!   "lengths": [4, 5],
//!   "t": [0, 1],
//!   "scheme": "kobbelt",
//!   "depth": 3,
//!   "initial": {"type": "polyline", "points": [[0, 0, 0], [0, 2, 0]], "t": [0, 1]}
//! }
//! ```
//!
//! A row of `tangents` is a streamline. The JSON Schema in `docs/streamline.schema.json` describes all
//! fields. A file may also hold several `patches`, stitched if
//! `stitch` says so, or one [`Curve`].
//!
//! ```
//! use fairform_io::streamline;
//!
//! let text = br#"{"tangents": [[[1, 0, 0]], [[1, 0, 1]]], "lengths": [1, 1], "t": [0, 1],
//!     "initial": {"type": "polyline", "points": [[0, 0, 0], [0, 1, 0]], "t": [0, 1]}}"#;
//! let error = streamline::parse(text).unwrap_err();
//! assert!(error.to_string().starts_with("tangents[1][0]: a tangent of length 1.414"));
//! ```

use std::io::Write;

use fairform::Vec3;
use fairform::sphere::Knots;
use fairform::streamline::{self, BsplineSurface, Model};
use serde_json::Value;

use crate::error::{Error, ParseError};
use crate::gzip;

mod bspline;
mod node;
mod reader;
mod writer;

/// The version of the format that is written, and the only one so far.
pub const VERSION: u32 = 1;

/// Most points of a QI curve that a file may ask for.
pub const MAX_SAMPLES: u32 = 1 << 20;

/// Highest degree or order of a curve in a file.
pub const MAX_ORDER: u32 = 64;

/// What the name of a model file ends in.
pub const EXTENSION: &str = ".streamline.json";

/// What a model file holds.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum Contents {
    /// A surface.
    Surface(Models),
    /// A curve.
    Curve(Curve),
}

/// The models in a file: one, or several that share streamlines.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Models {
    /// A name for all of them together; only with several.
    pub name: Option<String>,
    /// How to show all of them together; only with several.
    pub display: Option<Value>,
    /// The models.
    pub patches: Vec<Patch>,
    /// Whether each but the first begins where the one before ends; only with several.
    pub stitch: Stitch,
}

/// Whether patches are made to share streamlines, see [`stitch`](streamline::stitch).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Stitch {
    /// They are as they are.
    #[default]
    None,
    /// Each takes over the last streamline of the one before.
    Shared,
    /// Each also goes on from it smoothly.
    Smooth,
}

impl Models {
    /// The models as they are used: stitched, if the file says so.
    ///
    /// # Errors
    /// With the number of the patch that cannot be stitched to the one before.
    pub fn stitched(&self) -> Result<Vec<Model>, (usize, streamline::Error)> {
        let mut models: Vec<Model> = self.patches.iter().map(|p| p.model.clone()).collect();
        if self.stitch == Stitch::None {
            return Ok(models);
        }
        for i in 1..models.len() {
            let (before, rest) = models.split_at_mut(i);
            streamline::stitch(&before[i - 1], &mut rest[0], self.stitch == Stitch::Smooth)
                .map_err(|error| (i, error))?;
        }
        Ok(models)
    }
}

/// A model, and what a file says beside it.
#[derive(Clone, PartialEq, Debug)]
pub struct Patch {
    /// The surface.
    pub model: Model,
    /// What it is called.
    pub name: Option<String>,
    /// How to show it: an object that is kept as it is, such as view, colours, title.
    pub display: Option<Value>,
}

impl From<Model> for Patch {
    fn from(model: Model) -> Self {
        Self { model, name: None, display: None }
    }
}

impl From<Model> for Models {
    fn from(model: Model) -> Self {
        Self { patches: vec![model.into()], ..Self::default() }
    }
}

/// A curve of directions, and the space curve that it integrates to.
#[derive(Clone, PartialEq, Debug)]
pub enum Curve {
    /// A sequence of tangents, refined by subdivision.
    Subdivided(streamline::Curve),
    /// A QI curve, see [`QiCurve`](fairform::sphere::QiCurve).
    Qi {
        /// Control tangents.
        tangents: Vec<Vec3>,
        /// Degree plus one.
        order: usize,
        /// Where its knots lie.
        knots: Knots,
        /// Its length.
        length: f64,
        /// Its first point.
        start: Vec3,
        /// The parameters at which it is wanted, in $`[0, 1]`$, ascending.
        u: Vec<f64>,
    },
}

/// The models in the bytes of a file, which may be gzipped; all are checked.
///
/// # Errors
/// With the field and what should be there, or for what is no JSON the line and column. A file that
/// holds a curve is an error.
pub fn parse(bytes: &[u8]) -> Result<Models, ParseError> {
    match parse_any(bytes)? {
        Contents::Surface(models) => Ok(models),
        Contents::Curve(_) => {
            Err(ParseError::file("a curve").expected("a surface; `fairform curve` takes curves"))
        }
    }
}

/// The curve in the bytes of a file, which may be gzipped.
///
/// # Errors
/// As [`parse`]; a file that holds a surface is an error.
pub fn parse_curve(bytes: &[u8]) -> Result<Curve, ParseError> {
    match parse_any(bytes)? {
        Contents::Curve(curve) => Ok(curve),
        Contents::Surface(_) => {
            Err(ParseError::file("a surface")
                .expected("a curve; `fairform streamline` takes surfaces"))
        }
    }
}

/// The surface or curve in the bytes of a file, which may be gzipped.
///
/// # Errors
/// As [`parse`].
pub fn parse_any(bytes: &[u8]) -> Result<Contents, ParseError> {
    if gzip::is_gzip(bytes) {
        return reader::contents(&node::parse(&gzip::unpack(bytes)?)?);
    }
    reader::contents(&node::parse(bytes)?)
}

/// Writes models as text, one row of the grids per line; [`parse`] gives the same bits. The same
/// models give the same bytes.
///
/// # Errors
/// [`Error::Unwritable`] for a scheme that knows no tangents, closed ends, or numbers that are not
/// finite; if the writer fails.
pub fn encode(models: &Models, out: &mut dyn Write) -> Result<(), Error> {
    out.write_all(writer::models(models)?.as_bytes())?;
    Ok(())
}

/// Writes a curve as text; [`parse_curve`] gives the same bits.
///
/// # Errors
/// As [`encode`].
pub fn encode_curve(curve: &Curve, out: &mut dyn Write) -> Result<(), Error> {
    out.write_all(writer::curve(curve)?.as_bytes())?;
    Ok(())
}

/// Writes B-spline surfaces, each with a name that may be empty, as free-form surfaces of OBJ: the
/// control points as vertices, then `cstype bspline`, `deg 3 3`, `surf`, `parm u`, `parm v`, `end`.
/// \[Wavefront, The Advanced Visualizer, appendix B1\]
///
/// # Errors
/// [`Error::Unwritable`] for control points that are not finite; if the writer fails.
pub fn encode_bsplines(
    surfaces: &[(&str, &BsplineSurface)],
    out: &mut dyn Write,
) -> Result<(), Error> {
    let finite = |s: &BsplineSurface| s.points.values().iter().all(|p| p.is_finite());
    if !surfaces.iter().all(|(_, surface)| finite(surface)) {
        return Err(Error::Unwritable("a control point is not finite".into()));
    }
    out.write_all(bspline::obj(surfaces).as_bytes())?;
    Ok(())
}

#[cfg(feature = "files")]
pub use crate::file::streamline::{read, read_any, read_curve, write};
