//! [`Topology`]: the connectivity of a polygon mesh as index arrays.

use alloc::vec::Vec;

use crate::Faces;
use crate::ids::{EdgeId, FaceId, HalfedgeId, NONE, VertexId};

mod build;
mod partition;
mod rings;

/// Most half-edges a topology can have.
pub const MAX_HALFEDGES: u64 = (1 << 31) - 1;

/// The connectivity of an oriented polygon mesh, a manifold with or without boundary. Immutable.
///
/// A half-edge *is* a face corner, so next and previous need no arrays:
///
/// ```text
///            p                 half-edge h runs v → q inside face f,
///           ╱ ╲                prev(h) runs p → v, next(h) runs q → p;
///    prev  ╱   ╲  next         twin(h) runs q → v in the face on the other side,
///         ╱  f  ╲              and is missing on the boundary.
///        v ─────▶ q
///            h
/// ```
///
/// All numbering follows from the input: half-edges face by face, edges by first appearance.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Topology {
    polygons: Polygons,
    origin: Vec<u32>,
    twin: Vec<u32>,
    edge: Vec<u32>,
    edge_halfedge: Vec<u32>,
    outgoing: Vec<u32>,
    fan: Vec<u32>,
}

/// Where each face begins. Meshes of one face size, the usual case, need no arrays for it.
#[derive(Clone, PartialEq, Eq, Debug)]
enum Polygons {
    Uniform { size: u32 },
    Varied { start: Vec<u32>, face: Vec<u32> },
}

impl Polygons {
    #[inline]
    fn range(&self, f: FaceId) -> (u32, u32) {
        match self {
            Self::Uniform { size } => (f.0 * size, (f.0 + 1) * size),
            Self::Varied { start, .. } => (start[f.index()], start[f.index() + 1]),
        }
    }

    #[inline]
    fn face(&self, h: HalfedgeId) -> FaceId {
        match self {
            Self::Uniform { size: 3 } => FaceId(h.0 / 3),
            Self::Uniform { size } => FaceId(h.0 / size),
            Self::Varied { face, .. } => FaceId(face[h.index()]),
        }
    }

    #[inline]
    fn next(&self, h: HalfedgeId) -> HalfedgeId {
        match self {
            // A constant divisor is several times faster, and triangles are the common case.
            Self::Uniform { size: 3 } => HalfedgeId(if h.0 % 3 == 2 { h.0 - 2 } else { h.0 + 1 }),
            Self::Uniform { size: 4 } => HalfedgeId((h.0 & !3) | ((h.0 + 1) & 3)),
            _ => {
                let (start, end) = self.range(self.face(h));
                HalfedgeId(if h.0 + 1 == end { start } else { h.0 + 1 })
            }
        }
    }

    #[inline]
    fn prev(&self, h: HalfedgeId) -> HalfedgeId {
        match self {
            Self::Uniform { size: 3 } => {
                HalfedgeId(if h.0.is_multiple_of(3) { h.0 + 2 } else { h.0 - 1 })
            }
            Self::Uniform { size: 4 } => HalfedgeId((h.0 & !3) | (h.0.wrapping_sub(1) & 3)),
            _ => {
                let (start, end) = self.range(self.face(h));
                HalfedgeId(if h.0 == start { end - 1 } else { h.0 - 1 })
            }
        }
    }
}

/// The index arrays of a topology that is known to be consistent, for [`Topology::from_parts`].
pub(crate) struct Triangles {
    pub(crate) origin: Vec<u32>,
    pub(crate) twin: Vec<u32>,
    pub(crate) edge: Vec<u32>,
    pub(crate) edge_halfedge: Vec<u32>,
    pub(crate) outgoing: Vec<u32>,
    pub(crate) fan: Vec<u32>,
}

/// The index arrays of a topology that is known to be consistent, but for those of its edges.
pub(crate) struct Parts {
    pub(crate) origin: Vec<u32>,
    pub(crate) twin: Vec<u32>,
    pub(crate) outgoing: Vec<u32>,
    pub(crate) fan: Vec<u32>,
}

impl Topology {
    /// A quadrilateral topology from arrays that a refinement step computed in closed form.
    pub(crate) fn from_quadrilaterals(parts: Parts) -> Self {
        let Parts { origin, twin, outgoing, fan } = parts;
        let polygons = match origin.is_empty() {
            // As for any list of no faces.
            true => Polygons::Varied { start: alloc::vec![0], face: Vec::new() },
            false => Polygons::Uniform { size: 4 },
        };
        let (edge, edge_halfedge) = (Vec::new(), Vec::new());
        Self { polygons, origin, twin, edge, edge_halfedge, outgoing, fan }.with_edges()
    }

    /// The topology of any polygons from such arrays and where each face begins, with the end of all.
    pub(crate) fn from_polygons(start: &[u32], parts: Parts) -> Self {
        let Parts { origin, twin, outgoing, fan } = parts;
        let polygons = Polygons::from_starts(start);
        let (edge, edge_halfedge) = (Vec::new(), Vec::new());
        Self { polygons, origin, twin, edge, edge_halfedge, outgoing, fan }.with_edges()
    }

    /// A triangle topology from arrays that a refinement step computed in closed form.
    pub(crate) fn from_triangles(parts: Triangles) -> Self {
        let Triangles { origin, twin, edge, edge_halfedge, outgoing, fan } = parts;
        let polygons = Polygons::Uniform { size: 3 };
        Self { polygons, origin, twin, edge, edge_halfedge, outgoing, fan }
    }

    /// Number of vertices, isolated ones too.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.outgoing.len()
    }

    /// Number of half-edges, which is the number of face corners.
    #[must_use]
    pub fn halfedge_count(&self) -> usize {
        self.origin.len()
    }

    /// Number of edges.
    #[must_use]
    pub fn edge_count(&self) -> usize {
        self.edge_halfedge.len()
    }

    /// Number of faces.
    #[must_use]
    pub fn face_count(&self) -> usize {
        match &self.polygons {
            Polygons::Uniform { size } => self.origin.len() / *size as usize,
            Polygons::Varied { start, .. } => start.len() - 1,
        }
    }

    /// All vertices in order.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = VertexId> + use<> {
        (0..self.outgoing.len() as u32).map(VertexId)
    }

    /// All edges in order.
    pub fn edges(&self) -> impl ExactSizeIterator<Item = EdgeId> + use<> {
        (0..self.edge_halfedge.len() as u32).map(EdgeId)
    }

    /// All half-edges in order.
    pub fn halfedges(&self) -> impl ExactSizeIterator<Item = HalfedgeId> + use<> {
        (0..self.origin.len() as u32).map(HalfedgeId)
    }

    /// All faces in order.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = FaceId> + use<> {
        (0..self.face_count() as u32).map(FaceId)
    }

    /// The half-edges of a face, in order.
    ///
    /// # Panics
    /// If there is no such face.
    pub fn face_halfedges(
        &self,
        f: FaceId,
    ) -> impl ExactSizeIterator<Item = HalfedgeId> + DoubleEndedIterator + use<> {
        let (start, end) = self.face_range(f);
        (start..end).map(HalfedgeId)
    }

    /// The vertices of a face, in order.
    ///
    /// # Panics
    /// If there is no such face.
    #[must_use]
    pub fn face_vertices(&self, f: FaceId) -> &[VertexId] {
        let (start, end) = self.face_range(f);
        bytemuck::cast_slice(&self.origin[start as usize..end as usize])
    }

    fn face_range(&self, f: FaceId) -> (u32, u32) {
        self.polygons.range(f)
    }

    /// The faces as a plain list.
    #[must_use]
    pub fn to_faces(&self) -> Faces {
        match &self.polygons {
            Polygons::Uniform { size } => Faces::uniform(*size, self.origin.clone()),
            Polygons::Varied { start, .. } => {
                start.windows(2).map(|w| &self.origin[w[0] as usize..w[1] as usize]).collect()
            }
        }
    }

    /// The number of corners of every face, if it is the same; `None` without faces.
    #[must_use]
    pub fn uniform_face_size(&self) -> Option<u32> {
        match self.polygons {
            Polygons::Uniform { size } => Some(size),
            Polygons::Varied { .. } => None,
        }
    }

    /// The vertex that a half-edge starts from.
    #[must_use]
    #[inline]
    pub fn origin(&self, h: HalfedgeId) -> VertexId {
        VertexId(self.origin[h.index()])
    }

    /// The vertex that a half-edge runs to.
    #[must_use]
    #[inline]
    pub fn target(&self, h: HalfedgeId) -> VertexId {
        self.origin(self.next(h))
    }

    /// The half-edge in the opposite direction, in the face across; `None` on the boundary.
    #[must_use]
    #[inline]
    pub fn twin(&self, h: HalfedgeId) -> Option<HalfedgeId> {
        match self.twin[h.index()] {
            NONE => None,
            t => Some(HalfedgeId(t)),
        }
    }

    /// The edge of a half-edge.
    #[must_use]
    #[inline]
    pub fn edge(&self, h: HalfedgeId) -> EdgeId {
        EdgeId(self.edge[h.index()])
    }

    /// The first half-edge of an edge; it has no twin exactly if the edge is on the boundary.
    #[must_use]
    #[inline]
    pub fn edge_halfedge(&self, e: EdgeId) -> HalfedgeId {
        HalfedgeId(self.edge_halfedge[e.index()])
    }

    /// The face that a half-edge belongs to.
    #[must_use]
    #[inline]
    pub fn face(&self, h: HalfedgeId) -> FaceId {
        self.polygons.face(h)
    }

    /// The next half-edge around the face.
    #[must_use]
    #[inline]
    pub fn next(&self, h: HalfedgeId) -> HalfedgeId {
        self.polygons.next(h)
    }

    /// The previous half-edge around the face.
    #[must_use]
    #[inline]
    pub fn prev(&self, h: HalfedgeId) -> HalfedgeId {
        self.polygons.prev(h)
    }

    /// A half-edge from `v`: on the boundary the clockwise-most one, which has no twin, otherwise
    /// the first one. `None` at an isolated vertex.
    #[must_use]
    #[inline]
    pub fn outgoing(&self, v: VertexId) -> Option<HalfedgeId> {
        match self.outgoing[v.index()] {
            NONE => None,
            h => Some(HalfedgeId(h)),
        }
    }

    /// The half-edges from `v`, counter-clockwise, beginning with [`outgoing`](Self::outgoing).
    #[must_use]
    #[inline]
    pub fn fan(&self, v: VertexId) -> Fan<'_> {
        Fan { topology: self, next: self.outgoing[v.index()], left: self.fan[v.index()] }
    }

    /// The neighbours of `v`, counter-clockwise: `q_0, q_1, …`, where face `i` of the fan lies
    /// between `q_i` and `q_{i+1}`. At a boundary vertex the first and the last are its
    /// neighbours on the boundary.
    #[must_use]
    #[inline]
    pub fn ring(&self, v: VertexId) -> Ring<'_> {
        Ring { fan: self.fan(v), last: NONE }
    }

    /// Number of faces at `v`.
    #[must_use]
    #[inline]
    pub fn fan_size(&self, v: VertexId) -> u32 {
        self.fan[v.index()]
    }

    /// Number of edges at `v`.
    #[must_use]
    #[inline]
    pub fn valence(&self, v: VertexId) -> u32 {
        self.fan[v.index()] + u32::from(self.is_boundary(v))
    }

    /// Whether `v` lies on the boundary. An isolated vertex does not.
    #[must_use]
    #[inline]
    pub fn is_boundary(&self, v: VertexId) -> bool {
        match self.outgoing[v.index()] {
            NONE => false,
            h => self.twin[h as usize] == NONE,
        }
    }

    /// Whether `v` belongs to no face.
    #[must_use]
    #[inline]
    pub fn is_isolated(&self, v: VertexId) -> bool {
        self.outgoing[v.index()] == NONE
    }

    /// Whether an edge has only one face.
    #[must_use]
    pub fn is_boundary_edge(&self, e: EdgeId) -> bool {
        self.twin[self.edge_halfedge(e).index()] == NONE
    }

    /// Number of vertices that belong to no face.
    #[must_use]
    pub fn isolated_count(&self) -> usize {
        self.outgoing.iter().filter(|&&h| h == NONE).count()
    }

    /// Whether no edge lies on the boundary.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        !self.twin.contains(&NONE)
    }

    /// The boundary loops, each with the mesh on its left; ordered by, and beginning with, their
    /// lowest-numbered vertex.
    #[must_use]
    pub fn boundary_loops(&self) -> Vec<Vec<VertexId>> {
        let mut seen = alloc::vec![false; self.vertex_count()];
        let mut loops = Vec::new();
        for v in self.vertices() {
            if seen[v.index()] || !self.is_boundary(v) {
                continue;
            }
            let mut one = Vec::new();
            let mut at = v;
            while !seen[at.index()] {
                seen[at.index()] = true;
                one.push(at);
                at = self.target(HalfedgeId(self.outgoing[at.index()]));
            }
            loops.push(one);
        }
        loops
    }

    /// The connected components, numbered by their lowest vertex. Isolated vertices are none.
    #[must_use]
    pub fn components(&self) -> Components {
        let mut of_vertex = alloc::vec![NONE; self.vertex_count()];
        let mut list: Vec<Component> = Vec::new();
        let mut queue = Vec::new();
        for v in self.vertices() {
            if of_vertex[v.index()] != NONE || self.is_isolated(v) {
                continue;
            }
            let id = list.len() as u32;
            let mut one = Component::default();
            of_vertex[v.index()] = id;
            queue.push(v);
            while let Some(at) = queue.pop() {
                one.vertex_count += 1;
                one.corner_count += self.fan_size(at) as usize;
                one.boundary_vertex_count += usize::from(self.is_boundary(at));
                for q in self.ring(at) {
                    if of_vertex[q.index()] == NONE {
                        of_vertex[q.index()] = id;
                        queue.push(q);
                    }
                }
            }
            list.push(one);
        }
        for f in self.faces() {
            list[of_vertex[self.face_vertices(f)[0].index()] as usize].face_count += 1;
        }
        for one in self.boundary_loops() {
            list[of_vertex[one[0].index()] as usize].loop_count += 1;
        }
        for one in &mut list {
            // Each corner is a half-edge; every boundary vertex starts exactly one that has no twin.
            one.edge_count = usize::midpoint(one.corner_count, one.boundary_vertex_count);
        }
        Components { of_vertex, list }
    }
}

/// The connected components of a [`Topology`].
#[derive(Clone, Debug)]
pub struct Components {
    /// The component of each vertex; [`NONE`] for isolated ones.
    pub of_vertex: Vec<u32>,
    /// What each component counts.
    pub list: Vec<Component>,
}

/// The counts of one connected component.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Component {
    /// Vertices.
    pub vertex_count: usize,
    /// Edges.
    pub edge_count: usize,
    /// Faces.
    pub face_count: usize,
    /// Face corners.
    pub corner_count: usize,
    /// Vertices on the boundary.
    pub boundary_vertex_count: usize,
    /// Boundary loops.
    pub loop_count: usize,
}

impl Component {
    /// Number of handles, from Euler's formula `V − E + F = 2 − 2g − b` with `b` boundary loops.
    #[must_use]
    pub fn genus(&self) -> usize {
        let euler = self.vertex_count + self.face_count + self.loop_count;
        (2 + self.edge_count - euler.min(2 + self.edge_count)) / 2
    }
}

/// Iterator over the half-edges from a vertex, see [`Topology::fan`].
#[derive(Clone, Debug)]
pub struct Fan<'t> {
    topology: &'t Topology,
    next: u32,
    left: u32,
}

impl Iterator for Fan<'_> {
    type Item = HalfedgeId;

    #[inline]
    fn next(&mut self) -> Option<HalfedgeId> {
        if self.left == 0 {
            return None;
        }
        self.left -= 1;
        let h = HalfedgeId(self.next);
        if self.left > 0 {
            self.next = self.topology.twin[self.topology.prev(h).index()];
        }
        Some(h)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.left as usize, Some(self.left as usize))
    }
}

impl ExactSizeIterator for Fan<'_> {}

/// Iterator over the neighbours of a vertex, see [`Topology::ring`].
#[derive(Clone, Debug)]
pub struct Ring<'t> {
    fan: Fan<'t>,
    /// The last neighbour of an open fan, once it is known.
    last: u32,
}

impl Iterator for Ring<'_> {
    type Item = VertexId;

    #[inline]
    fn next(&mut self) -> Option<VertexId> {
        let topology = self.fan.topology;
        if let Some(h) = self.fan.next() {
            if self.fan.left == 0 {
                let back = topology.prev(h);
                if topology.twin[back.index()] == NONE {
                    self.last = topology.origin[back.index()];
                }
            }
            return Some(topology.target(h));
        }
        match core::mem::replace(&mut self.last, NONE) {
            NONE => None,
            v => Some(VertexId(v)),
        }
    }
}
