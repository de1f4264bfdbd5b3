//! What can go wrong, with the ids of where it did.

use alloc::vec::Vec;
use core::fmt;

use crate::ids::{FaceId, VertexId};

/// One thing that keeps a face list from being an oriented manifold with boundary.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Defect {
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} has a coordinate that is not a finite number")]
    NotFinite {
        /// The vertex.
        vertex: VertexId,
    },
    /// A face lists a vertex that the mesh does not have.
    #[error("face {face} lists vertex {vertex}, but the mesh has {vertex_count} vertices")]
    NoSuchVertex {
        /// The face.
        face: FaceId,
        /// The number it lists.
        vertex: u32,
        /// How many vertices there are.
        vertex_count: usize,
    },
    /// A face with fewer than three corners.
    #[error("face {face} has {count} corner{}; a face needs at least 3", plural(*count))]
    TooFewCorners {
        /// The face.
        face: FaceId,
        /// How many corners it has.
        count: usize,
    },
    /// A face that visits a vertex twice.
    #[error("face {face} lists vertex {vertex} more than once")]
    RepeatedCorner {
        /// The face.
        face: FaceId,
        /// The vertex it repeats.
        vertex: VertexId,
    },
    /// Two faces that run through their common edge in the same direction.
    #[error("faces {} and {} both run from vertex {from} to vertex {to}, so one of them is turned \
        over", faces[0], faces[1])]
    InconsistentOrientation {
        /// Where the edge begins in both faces.
        from: VertexId,
        /// Where it ends.
        to: VertexId,
        /// The two faces.
        faces: [FaceId; 2],
    },
    /// An edge with more than two faces.
    #[error("the edge between vertices {} and {} has {} faces ({}); a manifold edge has at most 2",
        ends[0], ends[1], faces.len(), list(faces))]
    NonManifoldEdge {
        /// The ends of the edge.
        ends: [VertexId; 2],
        /// All faces at the edge, in order.
        faces: Vec<FaceId>,
    },
    /// A vertex whose faces form more than one fan (a bow-tie).
    #[error("the {face_count} faces at vertex {vertex} form {fan_count} separate fans, not one")]
    NonManifoldVertex {
        /// The vertex.
        vertex: VertexId,
        /// How many fans there are.
        fan_count: usize,
        /// How many faces they have together.
        face_count: usize,
    },
}

/// The ending of a noun of which there are so many.
fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

fn list(faces: &[FaceId]) -> impl fmt::Display + '_ {
    struct List<'a>(&'a [FaceId]);
    impl fmt::Display for List<'_> {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            for (i, face) in self.0.iter().take(6).enumerate() {
                if i > 0 {
                    f.write_str(", ")?;
                }
                write!(f, "{face}")?;
            }
            if self.0.len() > 6 { f.write_str(", …") } else { Ok(()) }
        }
    }
    List(faces)
}

/// All defects that were found, at least one.
///
/// Shown as the first of them and the number of the others.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Defects(pub Vec<Defect>);

impl fmt::Display for Defects {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.as_slice() {
            [] => f.write_str("no defects"),
            [one] => one.fmt(f),
            [first, rest @ ..] => {
                write!(f, "{first} (and {} more defect{})", rest.len(), plural(rest.len()))
            }
        }
    }
}

impl core::error::Error for Defects {}

/// Why the kernel could not do what was asked.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The faces or positions are not an oriented manifold mesh.
    #[error("{0}")]
    NotManifold(#[from] Defects),
    /// There is nothing to work on.
    #[error("the mesh has no vertices")]
    NoVertices,
    /// A scheme for triangles met another polygon.
    #[error("face {face} has {count} corners, but the {scheme} scheme needs triangles")]
    NotTriangles {
        /// The first such face.
        face: FaceId,
        /// Its number of corners.
        count: usize,
        /// The scheme's name.
        scheme: &'static str,
    },
    /// A scheme for quadrilaterals met another polygon.
    #[error(
        "face {face} has {count} corners, but the {scheme} scheme needs quadrilaterals; one \
         Catmull–Clark step makes them of any polygons"
    )]
    NotQuadrilaterals {
        /// The first such face.
        face: FaceId,
        /// Its number of corners.
        count: usize,
        /// The scheme's name.
        scheme: &'static str,
    },
    /// More half-edges than the 31-bit ids can number.
    #[error(
        "the mesh would have {halfedges} half-edges; at most {} can be numbered",
        crate::topology::MAX_HALFEDGES
    )]
    TooLarge {
        /// How many half-edges it would have.
        halfedges: u64,
    },
    /// Conjugate gradients and factorising need a symmetric operator.
    #[error(
        "this method does not work beside creases that end or fade, nor on a boundary of Loop's \
         scheme along which shape parameters change; use another one"
    )]
    NotSymmetric,
    /// Factorising needs a positive definite operator.
    #[error("no factors: the limit operator is singular, or not definite, on this mesh")]
    NotDefinite,
    /// Control points do not follow the data.
    #[error(
        "around vertex {vertex} the limit operator is singular or not definite, so control points do not \
         follow the data"
    )]
    Singular {
        /// The first vertex of the singular part, or the first that was grabbed.
        vertex: VertexId,
    },
    /// A vertex that the mesh does not have.
    #[error("there is no vertex {vertex}: the mesh has {vertex_count} vertices")]
    NoSuchVertex {
        /// Its number.
        vertex: VertexId,
        /// How many vertices there are.
        vertex_count: usize,
    },
    /// The factors would not fit into memory.
    #[error("the factors are too large to be stored; use another method")]
    FactorTooLarge,
    /// An option is out of its range.
    #[error("{what} must be {expected}, not {value}")]
    BadOption {
        /// Which option.
        what: &'static str,
        /// Its range in words.
        expected: &'static str,
        /// What was given.
        value: f64,
    },
    /// A shape parameter is out of its range.
    #[error(
        "the shape parameter of face {face} is {value}; for the {scheme} scheme it must be {expected}"
    )]
    BadTension {
        /// The first such face.
        face: FaceId,
        /// Its parameter.
        value: f64,
        /// The scheme's name.
        scheme: &'static str,
        /// The range in words.
        expected: &'static str,
    },
    /// A list of the wrong length.
    #[error("expected {expected} values, one for each: {what}")]
    WrongCount {
        /// What the list holds.
        what: &'static str,
        /// How many there should be.
        expected: usize,
    },
    /// A choice that a scheme does not know.
    #[error("the {scheme} scheme does not know {what}")]
    NotForScheme {
        /// The choice.
        what: &'static str,
        /// The scheme's name.
        scheme: &'static str,
    },
    /// A vertex whose limit point no rule gives.
    #[error("vertex {vertex} has no limit point in the {scheme} scheme: {reason}")]
    NoLimit {
        /// The vertex.
        vertex: VertexId,
        /// The scheme's name.
        scheme: &'static str,
        /// Why.
        reason: &'static str,
    },
    /// The coordinates are so large that sums of them overflow.
    #[error("coordinates up to {largest:e} overflow when they are added; scale the mesh down")]
    Overflow {
        /// Largest absolute coordinate.
        largest: f64,
    },
    /// The observer asked to stop.
    #[error("interrupted")]
    Interrupted,
}
