//! What Loop's rules distinguish on the boundary of a topology.

use alloc::vec::Vec;

use crate::ids::VertexId;
use crate::scheme::Corners;
use crate::scheme::loop_scheme::{BoundaryKind, boundary_edge_weights, boundary_limit_weight};
use crate::{Topology, par};

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
pub(crate) fn by_valence(topology: &Topology, f: impl Fn(u32) -> f64) -> Vec<f64> {
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
