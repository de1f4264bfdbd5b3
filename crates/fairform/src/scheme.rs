//! The subdivision schemes, each a module of pure functions from valence to weights, and [`Rules`]: a
//! scheme with its choices.

use alloc::sync::Arc;
use alloc::vec::Vec;
use core::fmt;
use core::str::FromStr;

use crate::Topology;
use crate::crease::{Creases, INFINITE, Sharpness};
use crate::error::Error;
use crate::ids::{FaceId, VertexId};

pub mod butterfly;
pub mod catmull_clark;
pub mod doo_sabin;
pub mod kobbelt;
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
    /// The modified butterfly scheme for triangles, which passes through the vertices by itself, see
    /// [`butterfly`].
    Butterfly,
    /// Kobbelt's scheme for quadrilaterals, which passes through the vertices by itself, see
    /// [`kobbelt`].
    Kobbelt,
}

impl Scheme {
    /// All schemes.
    pub const ALL: &'static [Self] =
        &[Self::Loop, Self::CatmullClark, Self::DooSabin, Self::Butterfly, Self::Kobbelt];

    /// Its name on the command line and in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Loop => "loop",
            Self::CatmullClark => "catmull-clark",
            Self::DooSabin => "doo-sabin",
            Self::Butterfly => "butterfly",
            Self::Kobbelt => "kobbelt",
        }
    }

    /// Whether vertices stay where they are, so that every mesh is its own control mesh.
    #[must_use]
    pub const fn is_interpolating(self) -> bool {
        matches!(self, Self::Butterfly | Self::Kobbelt)
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
#[error("no such scheme; there are loop, catmull-clark, doo-sabin, butterfly, kobbelt")]
pub struct UnknownScheme;

/// What happens at a corner of the boundary: a boundary vertex with one face. Doo–Sabin and butterfly
/// treat it like any other.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Corners {
    /// The boundary curve rounds it like any other vertex, as published. OpenSubdiv's "edge only".
    #[default]
    Smooth,
    /// The vertex stays where it is, and is its own limit point. OpenSubdiv's "edge and corner".
    Sharp,
}

/// What becomes of the boundary.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Border {
    /// The boundary becomes a B-spline of its own vertices: cubic, and for Doo and Sabin's scheme,
    /// where a boundary edge counts as a face with two corners, quadratic.
    #[default]
    Bspline,
    /// Doo–Sabin: only inner edges and vertices make faces; the mesh shrinks by half a face per step.
    Drop,
    /// Faces at the boundary are support: they are refined as with [`Bspline`](Self::Bspline), but no
    /// surface corresponds to them, see [`Rules::has_surface`]. Interpolation keeps the control points
    /// of their boundary vertices as given. OpenSubdiv's "none"; not for Doo–Sabin.
    None,
}

/// A scheme with its choices, and what it needs to know of a mesh besides the connectivity.
#[derive(Clone, PartialEq, Debug)]
pub struct Rules {
    /// The scheme.
    pub scheme: Scheme,
    /// What happens at corners of the boundary.
    pub corners: Corners,
    /// What becomes of the boundary.
    pub border: Border,
    /// Shape parameter of each face in $`(0, 1]`$, for a first Doo–Sabin step in two phases: near 1
    /// the surface hugs the mesh, around 1/2 it is roundest. `None` is the plain scheme.
    pub tension: Option<Arc<[f64]>>,
    /// Sharp edges and vertices; for Loop and Catmull–Clark.
    pub creases: Option<Arc<Creases>>,
    /// Tension of Kobbelt's scheme, 1 as published; smooth between 0 and
    /// [`kobbelt::SMOOTH_BELOW`], see [`warnings`](Self::warnings).
    pub kobbelt_weight: f64,
}

impl Default for Rules {
    fn default() -> Self {
        Self::LOOP
    }
}

impl From<Scheme> for Rules {
    /// The scheme with its usual choices: corners are smooth as published, but sharp for Kobbelt's,
    /// where an open grid then is a tensor product.
    fn from(scheme: Scheme) -> Self {
        let corners = if scheme == Scheme::Kobbelt { Corners::Sharp } else { Corners::Smooth };
        Self { scheme, corners, ..Self::default() }
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
        kobbelt_weight: 1.0,
    };

    /// Whether the rules can be applied to such a mesh.
    ///
    /// # Errors
    /// [`Error::NotTriangles`] and [`Error::NotQuadrilaterals`] if the scheme needs such faces and one
    /// is not; [`Error::BadOption`] for a tension that is not finite or not above −8, where the
    /// rules end; [`Error::BadTension`] and [`Error::WrongCount`] for shape parameters and creases that do not
    /// fit; [`Error::NotForScheme`] for a choice that the scheme does not know.
    pub fn check(&self, topology: &Topology) -> Result<(), Error> {
        let scheme = self.scheme.name();
        match self.scheme {
            Scheme::Loop | Scheme::Butterfly => {
                if let Some((face, count)) = odd_face(topology, 3) {
                    return Err(Error::NotTriangles { face, count, scheme });
                }
            }
            Scheme::Kobbelt => {
                if let Some((face, count)) = odd_face(topology, 4) {
                    return Err(Error::NotQuadrilaterals { face, count, scheme });
                }
                let value = self.kobbelt_weight;
                if !(value.is_finite() && value > -8.0) {
                    let what = "the tension of Kobbelt's scheme";
                    return Err(Error::BadOption { what, expected: "finite and above -8", value });
                }
            }
            Scheme::CatmullClark | Scheme::DooSabin => {}
        }
        match (self.border, self.scheme) {
            (Border::Drop, Scheme::DooSabin) | (Border::Bspline, _) => {}
            (Border::Drop, _) => {
                return Err(Error::NotForScheme { what: "a boundary that is dropped", scheme });
            }
            (Border::None, Scheme::DooSabin) => {
                return Err(Error::NotForScheme { what: "a boundary that is support", scheme });
            }
            (Border::None, _) => {}
        }
        if let Some(tension) = &self.tension {
            if self.scheme != Scheme::DooSabin {
                return Err(Error::NotForScheme { what: "a shape parameter per face", scheme });
            }
            check_tension(tension, topology.face_count())?;
        }
        if let Some(creases) = &self.creases {
            if !matches!(self.scheme, Scheme::Loop | Scheme::CatmullClark) {
                return Err(Error::NotForScheme { what: "a crease", scheme });
            }
            if !creases.fits(topology) {
                let (what, expected) = ("sharpness of edges", topology.edge_count());
                return Err(Error::WrongCount { what, expected });
            }
        }
        Ok(())
    }

    /// What is allowed, but does not give a smooth surface.
    #[must_use]
    pub fn warnings(&self, topology: &Topology) -> Vec<Warning> {
        let mut warnings = Vec::new();
        if self.scheme != Scheme::Kobbelt {
            return warnings;
        }
        let weight = self.kobbelt_weight;
        if !(weight > 0.0 && weight < kobbelt::SMOOTH_BELOW) {
            warnings.push(Warning::TensionOutside { weight });
        }
        if weight > kobbelt::VALENCE_3_SMOOTH_UP_TO {
            let is_three = |v: &VertexId| topology.fan_size(*v) == 3 && !topology.is_boundary(*v);
            let rough = topology.vertices().find(is_three);
            warnings.extend(rough.map(|vertex| Warning::ValenceThree { vertex, weight }));
        }
        warnings
    }

    /// Whether a surface corresponds to each face: to all but those at the boundary with
    /// [`Border::None`]. As in OpenSubdiv, a boundary vertex takes the surface from its faces unless both
    /// its boundary edges are creases of infinite sharpness.
    #[must_use]
    pub fn has_surface(&self, topology: &Topology) -> Vec<bool> {
        let mut has_surface = alloc::vec![true; topology.face_count()];
        for v in topology.vertices().filter(|&v| self.is_support(topology, v)) {
            topology.fan(v).for_each(|h| has_surface[topology.face(h).index()] = false);
        }
        has_surface
    }

    /// Whether a vertex has control points but no surface.
    pub(crate) fn is_support(&self, topology: &Topology, v: VertexId) -> bool {
        let is_sharp =
            |h| self.creases.as_ref().is_some_and(|c| c.edge(topology.edge(h)) >= INFINITE);
        self.border == Border::None
            && topology.is_boundary(v)
            && !topology.fan(v).all(|h| {
                let back = topology.prev(h);
                (topology.twin(h).is_some() || is_sharp(h))
                    && (topology.twin(back).is_some() || is_sharp(back))
            })
    }

    pub(crate) fn sharpness<'a>(&'a self, topology: &'a Topology) -> Sharpness<'a> {
        Sharpness { topology, corners: self.corners, creases: self.creases.as_deref() }
    }
}

/// The first face with another number of corners, and its number.
fn odd_face(topology: &Topology, size: u32) -> Option<(FaceId, usize)> {
    if topology.uniform_face_size() == Some(size) {
        return None;
    }
    let with_count = |f| (f, topology.face_halfedges(f).len());
    topology.faces().map(with_count).find(|(_, count)| *count != size as usize)
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

/// Something that [`Rules`] allow, but that does not give a smooth surface.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// A tension of Kobbelt's scheme for which smoothness is not proved, even of curves.
    #[error(
        "a tension of {weight} may not give a smooth surface; it should be above 0 and below 2.472"
    )]
    TensionOutside {
        /// The tension.
        weight: f64,
    },
    /// A tension of Kobbelt's scheme for which normals at vertices of valence 3 do not converge.
    #[error(
        "with a tension of {weight}, above 1.66, the surface has no normal at vertex {vertex}, \
         which has three faces"
    )]
    ValenceThree {
        /// The first such vertex.
        vertex: VertexId,
        /// The tension.
        weight: f64,
    },
}
