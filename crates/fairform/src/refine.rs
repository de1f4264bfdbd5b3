//! One refinement step: a topology goes to a finer one and the rows that carry values over.

use alloc::sync::Arc;
use alloc::vec::Vec;

use crate::crease::{Kind, Sharpness};
use crate::error::Error;
use crate::ids::{FaceId, HalfedgeId, VertexId};
use crate::rows::{self, Rows};
use crate::scheme::catmull_clark::CURVE_VERTEX;
use crate::scheme::{Border, Rules, Scheme};
use crate::tension::Shares;
use crate::{Mesh, Stencils, Topology, Vec3};

mod butterfly_step;
mod catmull_clark_step;
mod doo_sabin_step;
mod kobbelt_step;
mod loop_step;

pub(crate) use butterfly_step::ButterflyRows;
pub(crate) use catmull_clark_step::CatmullClarkRows;
pub(crate) use catmull_clark_step::centroid;
pub(crate) use doo_sabin_step::{DooSabinRows, boundary_numbers};
pub(crate) use kobbelt_step::KobbeltRows;
pub(crate) use loop_step::LoopRows;

/// One refinement step: the finer topology, and how values are carried over to it.
#[derive(Clone, PartialEq, Debug)]
pub struct Refined<'t> {
    coarse: &'t Topology,
    rules: &'t Rules,
    /// The finer topology, in the canonical order of its scheme.
    pub topology: Topology,
    /// The rules for the next step: creases lose their sharpness, shape parameters act only once.
    pub next: Rules,
}

/// One step of a scheme.
///
/// # Errors
/// As [`Rules::check`]; [`Error::TooLarge`] if the result has too many half-edges.
pub fn refine<'t>(topology: &'t Topology, rules: &'t Rules) -> Result<Refined<'t>, Error> {
    check_size(topology, rules, 1)?;
    let finer = match rules.scheme {
        Scheme::Loop | Scheme::Butterfly => loop_step::finer_topology(topology),
        Scheme::CatmullClark | Scheme::Kobbelt => catmull_clark_step::finer_topology(topology),
        Scheme::DooSabin => doo_sabin_step::finer_topology(topology, rules.border),
    };
    let halves = |e| {
        let h = topology.edge_halfedge(e).0;
        let [a, b] = match rules.scheme {
            Scheme::CatmullClark => catmull_clark_step::halves(topology, h),
            _ => loop_step::halves(h),
        };
        [finer.edge(HalfedgeId(a)), finer.edge(HalfedgeId(b))]
    };
    let creases = rules.creases.as_ref().map(|c| Arc::new(c.refined(&finer, halves)));
    // The faces at the finer boundary are not all that were support.
    let border = if rules.border == Border::None { Border::Bspline } else { rules.border };
    let next = Rules { tension: None, creases, border, ..rules.clone() };
    Ok(Refined { coarse: topology, rules, topology: finer, next })
}

/// Phase one at a vertex: its rules blended by sharpness, each blended with linear subdivision, which
/// leaves the vertex where it is. `smooth(share, entry)` tells the smooth rule.
fn two_phase_vertex<E: FnMut(u32, f64)>(
    sharp: Sharpness<'_>,
    shares: Shares<'_>,
    v: VertexId,
    entry: &mut E,
    smooth: impl Fn(f64, &mut E),
) {
    for (steps, (kind, share)) in (0..).zip(sharp.blend(v)).filter(|(_, b)| b.1 > 0.0) {
        match kind {
            Kind::Corner => entry(v.0, share),
            Kind::Crease(_) => {
                let mut own = share;
                for (e, q) in sharp.sharp_edges(v, steps) {
                    let weight = CURVE_VERTEX[1] * shares.edge(e) * share;
                    own -= weight;
                    entry(q.0, weight);
                }
                entry(v.0, own);
            }
            Kind::Smooth => smooth(share, entry),
        }
    }
}

/// The first step of Loop's or Catmull and Clark's scheme in two phases: vertices, points on edges, and
/// for Catmull–Clark those in faces.
pub(crate) enum PhaseOne<'t> {
    Loop(LoopRows<'t>),
    CatmullClark(CatmullClarkRows<'t>),
}

impl<'t> PhaseOne<'t> {
    /// `None` if there is no second phase, or the scheme is another.
    pub(crate) fn new(topology: &'t Topology, rules: &'t Rules) -> Option<Self> {
        rules.shares(topology)?;
        Some(match rules.scheme {
            Scheme::Loop => Self::Loop(LoopRows::new(topology, rules)),
            _ => Self::CatmullClark(CatmullClarkRows::new(topology, rules)),
        })
    }
}

impl Rows for PhaseOne<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Loop(rows) => rows.len(),
            Self::CatmullClark(rows) => rows.len(),
        }
    }

    fn visit(&self, row: usize, entry: impl FnMut(u32, f64)) {
        match self {
            Self::Loop(rows) => rows.visit(row, entry),
            Self::CatmullClark(rows) => rows.visit(row, entry),
        }
    }
}

/// The values after a step, see [`Refined::apply`]; for rules that fit the topology.
pub(crate) fn apply(coarse: &Topology, rules: &Rules, values: &[Vec3]) -> Vec<Vec3> {
    assert_eq!(values.len(), coarse.vertex_count(), "one value per vertex");
    match rules.scheme {
        Scheme::Loop => rows::apply(&LoopRows::new(coarse, rules), values),
        Scheme::CatmullClark => rows::apply(&CatmullClarkRows::new(coarse, rules), values),
        Scheme::DooSabin => rows::apply(&DooSabinRows::new(coarse, rules), values),
        Scheme::Butterfly => ButterflyRows::new(coarse).apply(values),
        Scheme::Kobbelt => KobbeltRows::new(coarse, rules).apply(values),
    }
}

/// The coarser face that a finer face is a part of, see [`Refined::parent`].
pub(crate) fn parent(scheme: Scheme, coarse: &Topology, finer: &Topology, face: FaceId) -> FaceId {
    match scheme {
        Scheme::Loop | Scheme::Butterfly => FaceId(face.0 / 4),
        Scheme::CatmullClark | Scheme::Kobbelt => coarse.face(HalfedgeId(face.0)),
        Scheme::DooSabin => doo_sabin_step::parent(coarse, finer, face),
    }
}

/// The values of finer corners, see [`Refined::apply_to_corners`].
pub(crate) fn apply_to_corners(
    scheme: Scheme,
    coarse: &Topology,
    values: &[Vec3],
) -> Option<Vec<Vec3>> {
    assert_eq!(values.len(), coarse.halfedge_count(), "one value per corner");
    match scheme {
        Scheme::Loop | Scheme::Butterfly => Some(loop_step::apply_to_corners(values)),
        Scheme::CatmullClark | Scheme::Kobbelt => {
            Some(catmull_clark_step::apply_to_corners(coarse, values))
        }
        Scheme::DooSabin => None,
    }
}

impl Refined<'_> {
    /// The values at the finer vertices, from one value per coarser vertex: positions, or whatever
    /// else is to be as smooth.
    ///
    /// # Panics
    /// If there is not one value per coarser vertex.
    #[must_use]
    pub fn apply(&self, values: &[Vec3]) -> Vec<Vec3> {
        apply(self.coarse, self.rules, values)
    }

    /// The rows that [`apply`](Self::apply) stands for, one per finer vertex.
    #[must_use]
    pub fn stencils(&self) -> Stencils {
        let count = self.coarse.vertex_count();
        match self.rules.scheme {
            Scheme::Loop => rows::stencils(&LoopRows::new(self.coarse, self.rules), count),
            Scheme::CatmullClark => {
                rows::stencils(&CatmullClarkRows::new(self.coarse, self.rules), count)
            }
            Scheme::DooSabin => rows::stencils(&DooSabinRows::new(self.coarse, self.rules), count),
            Scheme::Butterfly => rows::stencils(&ButterflyRows::new(self.coarse), count),
            Scheme::Kobbelt => rows::stencils(&KobbeltRows::new(self.coarse, self.rules), count),
        }
    }

    /// The coarser face that a finer face is a part of, or the first of those that it lies between.
    ///
    /// # Panics
    /// If there is no such face.
    #[must_use]
    pub fn parent(&self, face: FaceId) -> FaceId {
        parent(self.rules.scheme, self.coarse, &self.topology, face)
    }

    /// Carries one value per face corner over to the finer corners, within each face by linear
    /// interpolation: the right thing for texture coordinates with seams, which stay seams. `None`
    /// for Doo–Sabin, whose new faces lie across the old edges.
    ///
    /// # Panics
    /// If there is not one value per coarser corner.
    #[must_use]
    pub fn apply_to_corners(&self, values: &[Vec3]) -> Option<Vec<Vec3>> {
        apply_to_corners(self.rules.scheme, self.coarse, values)
    }
}

/// Several steps of a scheme, on the positions of a mesh, and the rules for the next one.
///
/// # Errors
/// As [`refine`].
pub fn refine_mesh(mesh: &Mesh, rules: &Rules, levels: u32) -> Result<(Mesh, Rules), Error> {
    check_size(mesh.topology(), rules, levels)?;
    let (mut mesh, mut rules) = (mesh.clone(), rules.clone());
    for _ in 0..levels {
        let step = refine(mesh.topology(), &rules)?;
        let positions = step.apply(mesh.positions());
        let (topology, next) = (step.topology, step.next);
        mesh = Mesh::from_parts(Arc::new(topology), positions);
        rules = next;
    }
    Ok((mesh, rules))
}

/// How many vertices, edges and faces there will be after so many steps.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Size {
    /// Vertices.
    pub vertex_count: u64,
    /// Edges.
    pub edge_count: u64,
    /// Faces.
    pub face_count: u64,
    /// Half-edges.
    pub halfedge_count: u64,
}

/// The size of a mesh after refinement, without refining. For Doo–Sabin an upper bound.
///
/// # Errors
/// [`Error::TooLarge`] if the half-edges could not be numbered; as [`Rules::check`].
pub fn check_size(topology: &Topology, rules: &Rules, levels: u32) -> Result<Size, Error> {
    rules.check(topology)?;
    let mut size = Size {
        vertex_count: topology.vertex_count() as u64,
        edge_count: topology.edge_count() as u64,
        face_count: topology.face_count() as u64,
        halfedge_count: topology.halfedge_count() as u64,
    };
    if size.face_count == 0 {
        return Ok(size);
    }
    for _ in 0..levels {
        size = match rules.scheme {
            Scheme::Loop | Scheme::Butterfly => Size {
                vertex_count: size.vertex_count + size.edge_count,
                edge_count: 2 * size.edge_count + 3 * size.face_count,
                face_count: 4 * size.face_count,
                halfedge_count: 4 * size.halfedge_count,
            },
            Scheme::CatmullClark | Scheme::Kobbelt => Size {
                vertex_count: size.vertex_count + size.edge_count + size.face_count,
                edge_count: 2 * size.edge_count + size.halfedge_count,
                face_count: size.halfedge_count,
                halfedge_count: 4 * size.halfedge_count,
            },
            Scheme::DooSabin => {
                // Boundary edges count as faces with two corners.
                let border = 2 * size.edge_count - size.halfedge_count;
                Size {
                    vertex_count: size.halfedge_count + 2 * border,
                    edge_count: 2 * size.halfedge_count + 3 * border,
                    face_count: size.face_count + size.edge_count + size.vertex_count,
                    halfedge_count: 4 * size.halfedge_count + 4 * border,
                }
            }
        };
        if size.halfedge_count > crate::topology::MAX_HALFEDGES {
            return Err(Error::TooLarge { halfedges: size.halfedge_count });
        }
    }
    Ok(size)
}
