//! The subdivision schemes: each a module of pure functions from valence to weights.

use core::fmt;
use core::str::FromStr;

use crate::Topology;
use crate::error::Error;
use crate::ids::FaceId;

pub mod loop_scheme;

/// A subdivision scheme.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[non_exhaustive]
pub enum Scheme {
    /// Loop's scheme for triangles, see [`loop_scheme`].
    #[default]
    Loop,
}

impl Scheme {
    /// All schemes.
    pub const ALL: &'static [Self] = &[Self::Loop];

    /// Its name on the command line and in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Loop => "loop",
        }
    }

    /// Whether the scheme can refine such a mesh.
    ///
    /// # Errors
    /// [`Error::NotTriangles`] if a face is not a triangle.
    pub fn check(self, topology: &Topology) -> Result<(), Error> {
        match self {
            Self::Loop => check_triangles(topology, self.name()),
        }
    }
}

fn check_triangles(topology: &Topology, scheme: &'static str) -> Result<(), Error> {
    let size = |f: &FaceId| topology.face_halfedges(*f).len();
    let odd = match topology.uniform_face_size() {
        Some(3) => None,
        _ => topology.faces().find(|f| size(f) != 3),
    };
    odd.map_or(Ok(()), |face| Err(Error::NotTriangles { face, count: size(&face), scheme }))
}

impl fmt::Display for Scheme {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Scheme {
    type Err = UnknownScheme;

    fn from_str(name: &str) -> Result<Self, UnknownScheme> {
        Self::ALL.iter().copied().find(|s| s.name() == name).ok_or(UnknownScheme)
    }
}

/// There is no scheme of that name.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("no such scheme; there is `loop`")]
pub struct UnknownScheme;

/// What happens at a corner of the boundary: a boundary vertex with one face.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Corners {
    /// The boundary curve rounds it like any other vertex, as published.
    #[default]
    Smooth,
    /// The vertex stays where it is, and is its own limit point.
    Sharp,
}
