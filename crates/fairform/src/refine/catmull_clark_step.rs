//! Catmull–Clark refinement in closed form: each corner becomes a quadrilateral.
//!
//! ```text
//!            f ───── e(prev)        corner h of a face, at vertex v, becomes face h with half-edges
//!            │          │             4h    v → e(h)        4h+1  e(h) → f
//!            │    h     │             4h+2  f → e(prev h)   4h+3  e(prev h) → v
//!           e(h) ────── v           where e(h) is the new point on its edge and f the one in its face
//! ```

use alloc::vec::Vec;

use crate::crease::{Kind, Sharpness};
use crate::ids::{EdgeId, FaceId, HalfedgeId, NONE, VertexId};
use crate::rows::Rows;
use crate::scheme::Rules;
use crate::scheme::catmull_clark::{CURVE_VERTEX, vertex_weights};
use crate::tension::Shares;
use crate::topology::Parts;
use crate::{Topology, Vec3, par};

pub(super) fn finer_topology(coarse: &Topology) -> Topology {
    let halfedges = coarse.halfedge_count();
    let vertices = coarse.vertex_count() as u32;
    let first_face_point = vertices + coarse.edge_count() as u32;
    let mut origin = alloc::vec![0; 4 * halfedges];
    let mut twin = alloc::vec![0; 4 * halfedges];
    let (corners, sides) = (origin.as_chunks_mut::<4>().0, twin.as_chunks_mut::<4>().0);
    par::for_blocks2(corners, sides, |start, corners, sides| {
        for (i, (corner, side)) in corners.iter_mut().zip(sides).enumerate() {
            let h = HalfedgeId((start + i) as u32);
            let (next, prev) = (coarse.next(h), coarse.prev(h));
            *corner = [
                coarse.origin(h).0,
                vertices + coarse.edge(h).0,
                first_face_point + coarse.face(h).0,
                vertices + coarse.edge(prev).0,
            ];
            *side = [
                coarse.twin(h).map_or(NONE, |t| 4 * coarse.next(t).0 + 3),
                4 * next.0 + 2,
                4 * prev.0 + 1,
                coarse.twin(prev).map_or(NONE, |t| 4 * t.0),
            ];
        }
    });

    let finer = first_face_point as usize + coarse.face_count();
    let mut outgoing = alloc::vec![NONE; finer];
    let mut fan = alloc::vec![0; finer];
    par::for_blocks2(&mut outgoing, &mut fan, |start, outgoing, fan| {
        for (i, (outgoing, fan)) in outgoing.iter_mut().zip(fan).enumerate() {
            let v = (start + i) as u32;
            (*outgoing, *fan) = if v < vertices {
                let h = coarse.outgoing(VertexId(v));
                (h.map_or(NONE, |h| 4 * h.0), coarse.fan_size(VertexId(v)))
            } else if v < first_face_point {
                let h = coarse.edge_halfedge(EdgeId(v - vertices));
                let next = coarse.next(h);
                match coarse.twin(h) {
                    // The boundary goes on through the second half.
                    None => (4 * next.0 + 3, 2),
                    Some(_) => ((4 * h.0 + 1).min(4 * next.0 + 3), 4),
                }
            } else {
                let corners = coarse.face_halfedges(FaceId(v - first_face_point));
                let count = corners.len() as u32;
                (corners.map(|h| 4 * h.0 + 2).min().unwrap_or(NONE), count)
            };
        }
    });
    Topology::from_quadrilaterals(Parts { origin, twin, outgoing, fan })
}

/// The half-edges with which the halves of the edge of `h` begin and end.
pub(super) fn halves(coarse: &Topology, h: u32) -> [u32; 2] {
    [4 * h, 4 * coarse.next(HalfedgeId(h)).0 + 3]
}

/// The finer values: vertices by their rule, points on edges, points in faces.
pub(crate) struct CatmullClarkRows<'t> {
    sharp: Sharpness<'t>,
    shares: Option<Shares<'t>>,
}

impl<'t> CatmullClarkRows<'t> {
    pub(crate) fn new(topology: &'t Topology, rules: &'t Rules) -> Self {
        Self { sharp: rules.sharpness(topology), shares: rules.shares(topology) }
    }

    fn vertex(&self, v: VertexId, entry: &mut impl FnMut(u32, f64)) {
        let topology = self.sharp.topology;
        if topology.is_isolated(v) {
            return entry(v.0, 1.0);
        }
        if let Some(shares) = self.shares {
            return super::two_phase_vertex(self.sharp, shares, v, entry, |share, entry| {
                let n = f64::from(topology.fan_size(v));
                let each = share / (n * n);
                entry(v.0, share - 2.0 * each * shares.around(v));
                for h in topology.fan(v) {
                    let f = topology.face(h);
                    let plain = shares.face(f) * each;
                    entry(topology.target(h).0, 0.5 * plain);
                    entry(topology.origin(topology.prev(h)).0, 0.5 * plain);
                    centroid(topology, f, plain, entry);
                }
            });
        }
        for (kind, share) in self.sharp.blend(v).into_iter().filter(|b| b.1 > 0.0) {
            match kind {
                Kind::Corner => entry(v.0, share),
                Kind::Crease(ends) => {
                    entry(v.0, CURVE_VERTEX[0] * share);
                    ends.iter().for_each(|q| entry(q.0, CURVE_VERTEX[1] * share));
                }
                Kind::Smooth => {
                    let [own, edge, face] = vertex_weights(topology.fan_size(v));
                    entry(v.0, own * share);
                    topology.ring(v).for_each(|q| entry(q.0, edge * share));
                    for h in topology.fan(v) {
                        centroid(topology, topology.face(h), face * share, entry);
                    }
                }
            }
        }
    }

    fn edge(&self, e: EdgeId, entry: &mut impl FnMut(u32, f64)) {
        let topology = self.sharp.topology;
        let h = topology.edge_halfedge(e);
        let smooth = 1.0 - self.sharp.edge(e).min(1.0);
        if let (Some(shares), Some(t)) = (self.shares, topology.twin(h)) {
            let faces = [h, t].map(|h| topology.face(h));
            let plain = faces.map(|f| shares.face(f) * smooth);
            let end = 0.5 - 0.125 * (plain[0] + plain[1]);
            entry(topology.origin(h).0, end);
            entry(topology.target(h).0, end);
            for (f, plain) in faces.into_iter().zip(plain).filter(|p| p.1 > 0.0) {
                centroid(topology, f, 0.25 * plain, entry);
            }
            return;
        }
        let end = 0.5 - 0.25 * smooth;
        entry(topology.origin(h).0, end);
        entry(topology.target(h).0, end);
        if let Some(t) = topology.twin(h).filter(|_| smooth > 0.0) {
            centroid(topology, topology.face(h), 0.25 * smooth, entry);
            centroid(topology, topology.face(t), 0.25 * smooth, entry);
        }
    }
}

/// The mean of the corners of a face, with a weight.
pub(crate) fn centroid(
    topology: &Topology,
    f: FaceId,
    weight: f64,
    entry: &mut impl FnMut(u32, f64),
) {
    let corners = topology.face_vertices(f);
    let each = weight / corners.len() as f64;
    corners.iter().for_each(|q| entry(q.0, each));
}

impl Rows for CatmullClarkRows<'_> {
    fn len(&self) -> usize {
        let t = self.sharp.topology;
        t.vertex_count() + t.edge_count() + t.face_count()
    }

    #[inline]
    fn visit(&self, row: usize, mut entry: impl FnMut(u32, f64)) {
        let t = self.sharp.topology;
        let (vertices, edges) = (t.vertex_count(), t.edge_count());
        if row < vertices {
            self.vertex(VertexId(row as u32), &mut entry);
        } else if row < vertices + edges {
            self.edge(EdgeId((row - vertices) as u32), &mut entry);
        } else {
            centroid(t, FaceId((row - vertices - edges) as u32), 1.0, &mut entry);
        }
    }
}

/// Bilinear interpolation within each face.
pub(super) fn apply_to_corners(coarse: &Topology, values: &[Vec3]) -> Vec<Vec3> {
    let mut finer = alloc::vec![Vec3::ZERO; 4 * values.len()];
    let value = |h: HalfedgeId| values[h.index()];
    par::fill(finer.as_chunks_mut().0, |h| {
        let h = HalfedgeId(h as u32);
        let corners = coarse.face_halfedges(coarse.face(h));
        let count = corners.len() as f64;
        let centre = corners.map(value).sum::<Vec3>() / count;
        let (own, next, prev) = (value(h), value(coarse.next(h)), value(coarse.prev(h)));
        [own, 0.5 * (own + next), centre, 0.5 * (prev + own)]
    });
    finer
}
