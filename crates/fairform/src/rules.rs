//! Where masks meet a topology: which rule a vertex follows, and its row.

use alloc::vec::Vec;

use crate::ids::VertexId;
use crate::scheme::Corners;
use crate::scheme::loop_scheme::{
    BoundaryKind, boundary_edge_weights, boundary_limit_weight, limit_weight, ring_weight,
};
use crate::{Topology, Vec3, par};

/// A rule that makes one value per vertex from the vertex and its neighbours: on the boundary from
/// the two along it, inside from the whole ring with one weight.
pub(crate) struct VertexRule<'t> {
    pub(crate) kinds: BoundaryKinds<'t>,
    /// Weight of the vertex by valence; the ring has the rest.
    centre: Vec<f64>,
    /// Weights of a boundary vertex, its left and its right neighbour.
    boundary: fn(BoundaryKinds<'t>, VertexId) -> [f64; 3],
}

impl<'t> VertexRule<'t> {
    /// The new positions of the vertices in a refinement step.
    pub(crate) fn refined(topology: &'t Topology, corners: Corners) -> Self {
        Self {
            kinds: BoundaryKinds { topology, corners },
            centre: by_valence(topology, |n| 1.0 - ring_weight(n)),
            boundary: |_, _| [0.75, 0.125, 0.125],
        }
    }

    /// The limit positions of the vertices.
    pub(crate) fn limit(topology: &'t Topology, corners: Corners) -> Self {
        Self {
            kinds: BoundaryKinds { topology, corners },
            centre: by_valence(topology, limit_weight),
            boundary: BoundaryKinds::limit_weights,
        }
    }

    /// Number of entries in the row of a vertex.
    pub(crate) fn row_len(&self, v: VertexId) -> u32 {
        match self.kinds.of(v) {
            Some(BoundaryKind::Corner) => 1,
            Some(_) => 3,
            None => 1 + self.kinds.topology.fan_size(v),
        }
    }

    /// Writes the row of a vertex into slices of its length.
    pub(crate) fn row(&self, v: VertexId, source: &mut [u32], weight: &mut [f64]) {
        let topology = self.kinds.topology;
        source[0] = v.0;
        let n = source.len() - 1;
        if n == 0 {
            weight[0] = 1.0;
        } else if topology.is_boundary(v) {
            let (left, right) = boundary_neighbours(topology, v);
            source[1..].copy_from_slice(&[left.0, right.0]);
            weight.copy_from_slice(&(self.boundary)(self.kinds, v));
        } else {
            let centre = self.centre[n];
            weight[0] = centre;
            weight[1..].fill((1.0 - centre) / n as f64);
            for (slot, q) in source[1..].iter_mut().zip(topology.ring(v)) {
                *slot = q.0;
            }
        }
    }

    /// The row of a vertex, applied; `ring` is that of the vertex.
    pub(crate) fn apply(&self, v: VertexId, ring: &[u32], points: &[Vec3]) -> Vec3 {
        let topology = self.kinds.topology;
        let here = points[v.index()];
        if topology.is_boundary(v) {
            if self.kinds.of(v) == Some(BoundaryKind::Corner) {
                return here;
            }
            let (left, right) = boundary_neighbours(topology, v);
            let [c, l, r] = (self.boundary)(self.kinds, v);
            return c * here + l * points[left.index()] + r * points[right.index()];
        }
        if ring.is_empty() {
            return here;
        }
        let sum: Vec3 = ring.iter().map(|&q| points[q as usize]).sum();
        let centre = self.centre[ring.len()];
        centre * here + ((1.0 - centre) / ring.len() as f64) * sum
    }
}

/// What kind each boundary vertex is.
#[derive(Clone, Copy)]
pub(crate) struct BoundaryKinds<'t> {
    pub(crate) topology: &'t Topology,
    pub(crate) corners: Corners,
}

impl BoundaryKinds<'_> {
    /// The kind of a boundary vertex; `None` off the boundary.
    pub(crate) fn of(self, v: VertexId) -> Option<BoundaryKind> {
        self.topology.is_boundary(v).then(|| match (self.topology.fan_size(v), self.corners) {
            (3, _) => BoundaryKind::Regular,
            (1, Corners::Sharp) => BoundaryKind::Corner,
            _ => BoundaryKind::Extraordinary,
        })
    }

    fn on_boundary(self, v: VertexId) -> BoundaryKind {
        self.of(v).unwrap_or(BoundaryKind::Extraordinary)
    }

    /// Weights of the ends of a boundary edge in its new point.
    pub(crate) fn edge_weights(self, a: VertexId, b: VertexId) -> [f64; 2] {
        boundary_edge_weights(self.on_boundary(a), self.on_boundary(b))
    }

    /// Weights of a boundary vertex, its left and its right neighbour in its limit point.
    pub(crate) fn limit_weights(self, v: VertexId) -> [f64; 3] {
        let (left, right) = boundary_neighbours(self.topology, v);
        let own = self.on_boundary(v);
        let l = boundary_limit_weight(own, self.on_boundary(left));
        let r = boundary_limit_weight(own, self.on_boundary(right));
        [1.0 - l - r, l, r]
    }
}

/// The two neighbours of a boundary vertex along the boundary: the one before and the one after,
/// with the mesh on the left.
pub(crate) fn boundary_neighbours(topology: &Topology, v: VertexId) -> (VertexId, VertexId) {
    let first = topology.outgoing(v).expect("a boundary vertex has a face");
    let last = topology.fan(v).last().expect("a boundary vertex has a face");
    (topology.origin(topology.prev(last)), topology.target(first))
}

/// A function of the valence, tabulated for all fans of a mesh; zero below 2.
fn by_valence(topology: &Topology, f: impl Fn(u32) -> f64) -> Vec<f64> {
    (0..=largest_fan(topology)).map(|n| if n < 2 { 0.0 } else { f(n) }).collect()
}

/// Most faces at a vertex.
pub(crate) fn largest_fan(topology: &Topology) -> u32 {
    par::blocks(topology.vertex_count(), |range| {
        range.map(|v| topology.fan_size(VertexId(v as u32))).max().unwrap_or(0)
    })
    .into_iter()
    .max()
    .unwrap_or(0)
}
