//! The subdivision schemes, each a module of pure functions from valence to weights, and [`Rules`]: a
//! scheme with its choices.

use alloc::sync::Arc;
use core::fmt;
use core::str::FromStr;

use crate::Topology;
use crate::crease::{Creases, Sharpness};
use crate::error::Error;
use crate::ids::FaceId;

pub mod catmull_clark;
pub mod doo_sabin;
pub mod loop_scheme;

/// A subdivision scheme.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[non_exhaustive]
pub enum Scheme {
    /// Loop's scheme for triangles, see [`loop_scheme`].
    #[default]
    Loop,
    /// Catmull and Clark's scheme for polygons, see [`catmull_clark`].
    CatmullClark,
    /// Doo and Sabin's scheme for polygons, see [`doo_sabin`].
    DooSabin,
}

impl Scheme {
    /// All schemes.
    pub const ALL: &'static [Self] = &[Self::Loop, Self::CatmullClark, Self::DooSabin];

    /// Its name on the command line and in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Loop => "loop",
            Self::CatmullClark => "catmull-clark",
            Self::DooSabin => "doo-sabin",
        }
    }
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
#[error("no such scheme; there are loop, catmull-clark, doo-sabin")]
pub struct UnknownScheme;

/// What happens at a corner of the boundary: a boundary vertex with one face.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Corners {
    /// The boundary curve rounds it like any other vertex, as published. OpenSubdiv's "edge only".
    #[default]
    Smooth,
    /// The vertex stays where it is, and is its own limit point. OpenSubdiv's "edge and corner".
    Sharp,
}

/// What Doo and Sabin's scheme does at the boundary.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Border {
    /// A boundary edge counts as a face with two corners, so the boundary becomes a quadratic
    /// B-spline of its own vertices.
    #[default]
    Bspline,
    /// Only inner edges and vertices make faces; the mesh shrinks by half a face per step.
    Drop,
}

/// A scheme with its choices, and what it needs to know of a mesh besides the connectivity.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Rules {
    /// The scheme.
    pub scheme: Scheme,
    /// What happens at corners of the boundary.
    pub corners: Corners,
    /// What Doo and Sabin's scheme does at the boundary.
    pub border: Border,
    /// Shape parameter of each face in $`(0, 1]`$, for a first Doo–Sabin step in two phases: near 1
    /// the surface hugs the mesh, around 1/2 it is roundest. `None` is the plain scheme.
    pub tension: Option<Arc<[f64]>>,
    /// Sharp edges and vertices; for Loop and Catmull–Clark.
    pub creases: Option<Arc<Creases>>,
}

impl From<Scheme> for Rules {
    fn from(scheme: Scheme) -> Self {
        Self { scheme, ..Self::default() }
    }
}

impl Rules {
    /// Loop's scheme.
    pub const LOOP: Self = Self {
        scheme: Scheme::Loop,
        corners: Corners::Smooth,
        border: Border::Bspline,
        tension: None,
        creases: None,
    };

    /// Whether the rules can be applied to such a mesh.
    ///
    /// # Errors
    /// [`Error::NotTriangles`] if the scheme needs triangles and a face is none;
    /// [`Error::BadTension`] and [`Error::WrongCount`] for shape parameters and creases that do not
    /// fit; [`Error::NotForScheme`] for a choice that the scheme does not know.
    pub fn check(&self, topology: &Topology) -> Result<(), Error> {
        let scheme = self.scheme.name();
        if self.scheme == Scheme::Loop {
            check_triangles(topology, scheme)?;
        }
        if let Some(tension) = &self.tension {
            if self.scheme != Scheme::DooSabin {
                return Err(Error::NotForScheme { what: "a shape parameter per face", scheme });
            }
            check_tension(tension, topology.face_count())?;
        }
        if let Some(creases) = &self.creases {
            if self.scheme == Scheme::DooSabin {
                return Err(Error::NotForScheme { what: "a crease", scheme });
            }
            if !creases.fits(topology) {
                let (what, expected) = ("sharpness of edges", topology.edge_count());
                return Err(Error::WrongCount { what, expected });
            }
        }
        Ok(())
    }

    pub(crate) fn sharpness<'a>(&'a self, topology: &'a Topology) -> Sharpness<'a> {
        Sharpness { topology, corners: self.corners, creases: self.creases.as_deref() }
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

fn check_tension(tension: &[f64], face_count: usize) -> Result<(), Error> {
    if tension.len() != face_count {
        let what = "shape parameters of faces";
        return Err(Error::WrongCount { what, expected: face_count });
    }
    match tension.iter().position(|&x| !(x > 0.0 && x <= 1.0)) {
        Some(f) => Err(Error::BadTension { face: FaceId(f as u32), value: tension[f] }),
        None => Ok(()),
    }
}
