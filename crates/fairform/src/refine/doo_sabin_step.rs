//! Doo–Sabin refinement: each corner has an image; faces, edges and vertices become faces.
//!
//! The image of half-edge `h` is vertex `h` of the finer mesh. After them come, for every boundary
//! half-edge `a → b` in order, the images of `a` and of `b` in the edge, which counts as a face with
//! two corners.
//!
//! The finer topology is found in closed form.

use alloc::vec::Vec;

use crate::ids::{EdgeId, FaceId, HalfedgeId, NONE, VertexId};
use crate::rows::Rows;
use crate::scheme::doo_sabin::{CHAIKIN, image_weight, phase_one_weights};
use crate::scheme::{Border, Rules};
use crate::topology::Parts;
use crate::{Topology, par};

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

pub(super) fn finer_topology(coarse: &Topology, border: Border) -> Topology {
    let numbers = Numbers::new(coarse, border);
    let (origin, twin) = numbers.halfedges();
    let (outgoing, fan) = numbers.vertices();
    Topology::from_polygons(&numbers.face_starts(), Parts { origin, twin, outgoing, fan })
}

/// The numbering of the finer half-edges: those of the faces keep their numbers, after them come the
/// faces of the edges, then those of the vertices. `h` runs from `a` to `b`, on the border of face `f`,
/// and `t` is its twin; their edge has face `e`, and `4e` is counted from the first face of an edge.
///
/// ```text
///                  b
///          next(h) ─── t          4e    next(h) → h      4e+1  h → next(t)
///        f       │  e  │  g       4e+2  next(t) → t      4e+3  t → next(h)
///                h ─── next(t)
///                  a
/// ```
struct Numbers<'t> {
    coarse: &'t Topology,
    /// The number of each boundary half-edge among them, and the half-edges with these numbers.
    boundary: Vec<u32>,
    boundary_halfedges: Vec<HalfedgeId>,
    /// The number of the face of each edge and the edge of each such face, if some edge has none.
    edge_faces: Option<(Vec<u32>, Vec<EdgeId>)>,
    edge_face_count: usize,
    /// Where the face of each vertex begins, and the end of all; empty where there is none.
    vertex_start: Vec<u32>,
}

impl<'t> Numbers<'t> {
    fn new(coarse: &'t Topology, border: Border) -> Self {
        let bspline = border == Border::Bspline;
        let is_closed = coarse.is_closed();
        let (mut boundary, mut boundary_halfedges) = (Vec::new(), Vec::new());
        let mut edge_faces = None;
        if !is_closed && bspline {
            boundary = boundary_numbers(coarse).0;
            boundary_halfedges = coarse.halfedges().filter(|&h| coarse.twin(h).is_none()).collect();
        } else if !is_closed {
            let mut kept = Vec::new();
            let number = |e| {
                if coarse.is_boundary_edge(e) {
                    return NONE;
                }
                kept.push(e);
                kept.len() as u32 - 1
            };
            let numbers = coarse.edges().map(number).collect();
            edge_faces = Some((numbers, kept));
        }
        let edge_face_count = edge_faces.as_ref().map_or(coarse.edge_count(), |(_, e)| e.len());

        let mut end = (coarse.halfedge_count() + 4 * edge_face_count) as u32;
        let mut vertex_start = Vec::with_capacity(coarse.vertex_count() + 1);
        vertex_start.push(end);
        vertex_start.extend(coarse.vertices().map(|v| {
            end += match coarse.fan_size(v) {
                0 => 0,
                count if coarse.is_boundary(v) => {
                    if bspline {
                        count + 2
                    } else {
                        0
                    }
                }
                // Two images have no face between them: the faces of the two edges meet there.
                count => {
                    if count == 2 {
                        0
                    } else {
                        count
                    }
                }
            };
            end
        }));
        Self { coarse, boundary, boundary_halfedges, edge_faces, edge_face_count, vertex_start }
    }

    /// The images, in the edge, of the ends of a boundary half-edge.
    fn edge_images(&self, h: HalfedgeId) -> [u32; 2] {
        let start = self.coarse.halfedge_count() as u32 + 2 * self.boundary[h.index()];
        [start, start + 1]
    }

    /// Whether the face of the edge of `h` begins with it: it runs from the lower end to the higher,
    /// wherever there are faces on both sides.
    fn leads(&self, h: HalfedgeId) -> bool {
        self.coarse.twin(h).is_none() || self.coarse.origin(h) < self.coarse.target(h)
    }

    /// The half-edge of the face of an edge that runs along `h`, back; [`NONE`] without a face.
    fn across(&self, h: HalfedgeId) -> u32 {
        let e = self.coarse.edge(h);
        let number = match &self.edge_faces {
            None => e.0,
            Some((numbers, _)) => numbers[e.index()],
        };
        if number == NONE {
            return NONE;
        }
        self.coarse.halfedge_count() as u32 + 4 * number + if self.leads(h) { 0 } else { 2 }
    }

    /// The half-edge of the face of an edge that runs from the image of `h` to the image of the same
    /// vertex on the other side. There is a face.
    fn side(&self, h: HalfedgeId) -> u32 {
        self.across(h) + 1
    }

    fn has_face(&self, v: VertexId) -> bool {
        self.vertex_start[v.index()] < self.vertex_start[v.index() + 1]
    }

    fn face_starts(&self) -> Vec<u32> {
        let coarse = self.coarse;
        let count = coarse.face_count() + self.edge_face_count + coarse.vertex_count();
        let mut starts = Vec::with_capacity(count + 1);
        let mut end = 0;
        starts.extend(coarse.faces().map(|f| {
            let start = end;
            end += coarse.face_halfedges(f).len() as u32;
            start
        }));
        starts.extend((0..self.edge_face_count as u32).map(|e| end + 4 * e));
        // The end of each face of a vertex is where the next one begins.
        let mut last = self.vertex_start[0];
        starts.push(last);
        for &end in &self.vertex_start[1..] {
            if end > last {
                starts.push(end);
                last = end;
            }
        }
        starts
    }

    /// The origins and twins.
    fn halfedges(&self) -> (Vec<u32>, Vec<u32>) {
        let coarse = self.coarse;
        let halfedges = coarse.halfedge_count();
        let total = self.vertex_start[coarse.vertex_count()] as usize;
        let (mut origin, mut twin) = (alloc::vec![0; total], alloc::vec![NONE; total]);
        let (own_origin, rest_origin) = origin.split_at_mut(halfedges);
        let (own_twin, rest_twin) = twin.split_at_mut(halfedges);
        par::for_blocks2(own_origin, own_twin, |start, origin, twin| {
            for (i, (origin, twin)) in origin.iter_mut().zip(twin).enumerate() {
                let h = (start + i) as u32;
                *origin = h;
                *twin = self.across(HalfedgeId(h));
            }
        });

        let (edge_origin, vertex_origin) = rest_origin.split_at_mut(4 * self.edge_face_count);
        let (edge_twin, vertex_twin) = rest_twin.split_at_mut(4 * self.edge_face_count);
        let (corners, sides) = (edge_origin.as_chunks_mut().0, edge_twin.as_chunks_mut().0);
        par::for_blocks2(corners, sides, |start, corners, sides| {
            for (i, (corners, sides)) in corners.iter_mut().zip(sides).enumerate() {
                (*corners, *sides) = self.edge_face(start + i);
            }
        });

        let starts = &self.vertex_start;
        par::fill_rows(starts, vertex_origin, vertex_twin, &|v, origin, twin| {
            if !origin.is_empty() {
                self.vertex_face(VertexId(v as u32), origin, twin);
            }
        });
        for h in starts[0]..total as u32 {
            let t = twin[h as usize];
            if t != NONE {
                twin[t as usize] = h;
            }
        }
        for v in coarse.vertices().filter(|&v| coarse.fan_size(v) == 2 && !coarse.is_boundary(v)) {
            for h in coarse.fan(v) {
                let back = coarse.twin(coarse.prev(h)).expect("an inner vertex");
                twin[self.side(h) as usize] = self.side(back);
            }
        }
        (origin, twin)
    }

    /// The origins of the face of an edge, and the twins beside its faces.
    fn edge_face(&self, number: usize) -> ([u32; 4], [u32; 4]) {
        let coarse = self.coarse;
        let e = self.edge_faces.as_ref().map_or(EdgeId(number as u32), |(_, edges)| edges[number]);
        let mut h = coarse.edge_halfedge(e);
        let twin = coarse.twin(h);
        let Some(mut t) = twin else {
            let [a, b] = self.edge_images(h);
            return ([coarse.next(h).0, h.0, a, b], [h.0, NONE, NONE, NONE]);
        };
        if !self.leads(h) {
            (h, t) = (t, h);
        }
        ([coarse.next(h).0, h.0, coarse.next(t).0, t.0], [h.0, NONE, t.0, NONE])
    }

    /// The origins and twins of the face of a vertex.
    fn vertex_face(&self, v: VertexId, origin: &mut [u32], twin: &mut [u32]) {
        let coarse = self.coarse;
        let count = coarse.fan_size(v) as usize;
        if !coarse.is_boundary(v) {
            for (i, h) in coarse.fan(v).enumerate() {
                origin[i] = h.0;
                twin[if i == 0 { count - 1 } else { i - 1 }] = self.side(h);
            }
            return;
        }
        for (i, h) in coarse.fan(v).enumerate() {
            if i == 0 {
                origin[0] = self.edge_images(h)[0];
            }
            origin[i + 1] = h.0;
            twin[i] = self.side(h);
        }
        let back = coarse.prev(HalfedgeId(origin[count]));
        origin[count + 1] = self.edge_images(back)[1];
        twin[count] = self.across(back) + 3;
    }

    /// A half-edge from each vertex and the number of its faces.
    fn vertices(&self) -> (Vec<u32>, Vec<u32>) {
        let halfedges = self.coarse.halfedge_count();
        let total = halfedges + 2 * self.boundary_halfedges.len();
        let (mut outgoing, mut fan) = (alloc::vec![NONE; total], alloc::vec![0; total]);
        par::for_blocks2(&mut outgoing, &mut fan, |start, outgoing, fan| {
            for (i, (outgoing, fan)) in outgoing.iter_mut().zip(fan).enumerate() {
                (*outgoing, *fan) = match (start + i).checked_sub(halfedges) {
                    None => self.image(HalfedgeId((start + i) as u32)),
                    Some(extra) => (self.at_boundary(extra), 2),
                };
            }
        });
        (outgoing, fan)
    }

    fn image(&self, h: HalfedgeId) -> (u32, u32) {
        let coarse = self.coarse;
        let v = coarse.origin(h);
        let around = u32::from(self.has_face(v));
        if self.edge_faces.is_none() {
            return (h.0, 3 + around);
        }
        let has_face = |h| coarse.twin(h).is_some();
        let fan = 1 + around + u32::from(has_face(h)) + u32::from(has_face(coarse.prev(h)));
        // The clockwise-most: the edge's, if it has a face, else the face's own.
        let is_edge = has_face(h) && coarse.is_boundary(v);
        (if is_edge { self.side(h) } else { h.0 }, fan)
    }

    /// The boundary half-edge from an image in a boundary edge: along the edge from its first, along
    /// the face of its end from its second.
    fn at_boundary(&self, extra: usize) -> u32 {
        let h = self.boundary_halfedges[extra / 2];
        if extra.is_multiple_of(2) {
            return self.across(h) + 2;
        }
        self.vertex_start[self.coarse.target(h).index() + 1] - 1
    }
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

    /// The vertex that a row makes an image of.
    pub(crate) fn vertex(&self, row: usize) -> VertexId {
        match row.checked_sub(self.topology.halfedge_count()) {
            None => self.topology.origin(HalfedgeId(row as u32)),
            Some(extra) if extra.is_multiple_of(2) => {
                self.topology.origin(self.boundary[extra / 2])
            }
            Some(extra) => self.topology.target(self.boundary[extra / 2]),
        }
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
