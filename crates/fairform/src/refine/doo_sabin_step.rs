//! Doo–Sabin refinement: each corner has an image; faces, edges and vertices become faces.
//!
//! The image of half-edge `h` is vertex `h` of the finer mesh. After them come, for every boundary
//! half-edge `a → b` in order, the images of `a` and of `b` in the edge, which counts as a face with
//! two corners.

use alloc::vec::Vec;

use crate::error::Error;
use crate::ids::{FaceId, HalfedgeId, NONE, VertexId};
use crate::rows::Rows;
use crate::scheme::doo_sabin::{CHAIKIN, image_weight, phase_one_weights};
use crate::scheme::{Border, Rules};
use crate::{Faces, Topology};

/// Numbers the boundary half-edges in order; [`NONE`] for inner ones.
pub(crate) fn boundary_numbers(topology: &Topology) -> (Vec<u32>, u32) {
    let mut count = 0;
    let numbers = topology
        .halfedges()
        .map(|h| {
            if topology.twin(h).is_some() {
                return NONE;
            }
            count += 1;
            count - 1
        })
        .collect();
    (numbers, count)
}

pub(super) fn finer_topology(coarse: &Topology, border: Border) -> Result<Topology, Error> {
    let halfedges = coarse.halfedge_count() as u32;
    let bspline = border == Border::Bspline;
    let (boundary, count) = boundary_numbers(coarse);
    // The images, in the edge, of the vertex where a boundary half-edge begins, and where it ends.
    let at_start = |h: HalfedgeId| halfedges + 2 * boundary[h.index()];
    let at_end = |h: HalfedgeId| at_start(h) + 1;

    let mut faces =
        Faces::with_capacity(coarse.face_count() + coarse.edge_count(), 4 * halfedges as usize);
    let mut corners: Vec<u32> = Vec::new();
    for f in coarse.faces() {
        corners.clear();
        corners.extend(coarse.face_halfedges(f).map(|h| h.0));
        faces.push(&corners);
    }
    for e in coarse.edges() {
        let mut h = coarse.edge_halfedge(e);
        // From the lower end to the higher, wherever there are faces on both sides.
        if let Some(t) = coarse.twin(h).filter(|_| coarse.origin(h) > coarse.target(h)) {
            h = t;
        }
        let (a, b) = (h.0, coarse.next(h).0);
        match coarse.twin(h) {
            Some(t) => faces.push(&[b, a, coarse.next(t).0, t.0]),
            None if bspline => faces.push(&[b, a, at_start(h), at_end(h)]),
            None => {}
        }
    }
    for v in coarse.vertices() {
        corners.clear();
        if let (true, Some(first)) = (coarse.is_boundary(v), coarse.outgoing(v)) {
            if !bspline {
                continue;
            }
            corners.push(at_start(first));
            corners.extend(coarse.fan(v).map(|h| h.0));
            let last = HalfedgeId(corners[corners.len() - 1]);
            corners.push(at_end(coarse.prev(last)));
        } else {
            corners.extend(coarse.fan(v).map(|h| h.0));
        }
        // Two images have no face between them: the faces of the two edges meet there.
        if corners.len() >= 3 {
            faces.push(&corners);
        }
    }
    let extra = if bspline { 2 * count } else { 0 };
    Topology::from_faces((halfedges + extra) as usize, &faces)
}

/// The face, or the first face of the edge or vertex, that a finer face came from.
pub(super) fn parent(coarse: &Topology, finer: &Topology, face: FaceId) -> FaceId {
    let halfedges = coarse.halfedge_count() as u32;
    let images = finer.face_vertices(face).iter().filter(|v| v.0 < halfedges);
    let faces = images.map(|v| coarse.face(HalfedgeId(v.0)));
    faces.min().expect("a face has an image of a corner")
}

/// The images of the corners, then those in the boundary edges.
pub(crate) struct DooSabinRows<'t> {
    topology: &'t Topology,
    tension: Option<&'t [f64]>,
    border: Border,
    /// The boundary half-edges in order.
    boundary: Vec<HalfedgeId>,
}

impl<'t> DooSabinRows<'t> {
    pub(crate) fn new(topology: &'t Topology, rules: &'t Rules) -> Self {
        let boundary = topology.halfedges().filter(|&h| topology.twin(h).is_none()).collect();
        Self { topology, tension: rules.tension.as_deref(), border: rules.border, boundary }
    }

    /// The image of a corner in its face.
    pub(crate) fn image(&self, h: HalfedgeId, share: f64, entry: &mut impl FnMut(u32, f64)) {
        let f = self.topology.face(h);
        let corners = self.topology.face_halfedges(f);
        let count = corners.len() as u32;
        let phase_one = self.tension.map(|t| phase_one_weights(count, t[f.index()]));
        for q in corners {
            let weight = match phase_one {
                Some([own, other]) => {
                    if q == h {
                        own
                    } else {
                        other
                    }
                }
                None => image_weight(count, q.0.abs_diff(h.0)),
            };
            entry(self.topology.origin(q).0, share * weight);
        }
    }

    /// The image, in a boundary edge, of its end `v`.
    pub(crate) fn edge_image(
        &self,
        h: HalfedgeId,
        v: VertexId,
        share: f64,
        entry: &mut impl FnMut(u32, f64),
    ) {
        let [own, other] = phase_one_weights(2, self.edge_parameter(h));
        let (a, b) = (self.topology.origin(h), self.topology.target(h));
        entry(v.0, share * own);
        entry(if v == a { b.0 } else { a.0 }, share * other);
    }

    /// The parameter of a boundary edge is that of the face behind it.
    pub(crate) fn edge_parameter(&self, h: HalfedgeId) -> f64 {
        self.tension.map_or(CHAIKIN, |t| t[self.topology.face(h).index()])
    }
}

impl Rows for DooSabinRows<'_> {
    fn len(&self) -> usize {
        let extra = if self.border == Border::Bspline { 2 * self.boundary.len() } else { 0 };
        self.topology.halfedge_count() + extra
    }

    #[inline]
    fn visit(&self, row: usize, mut entry: impl FnMut(u32, f64)) {
        match row.checked_sub(self.topology.halfedge_count()) {
            None => self.image(HalfedgeId(row as u32), 1.0, &mut entry),
            Some(extra) => {
                let h = self.boundary[extra / 2];
                let is_start = extra.is_multiple_of(2);
                let v = if is_start { self.topology.origin(h) } else { self.topology.target(h) };
                self.edge_image(h, v, 1.0, &mut entry);
            }
        }
    }
}
