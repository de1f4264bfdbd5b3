//! [`Parts`]: what the surface is cut into, and which neighbourhood each part has.

use alloc::vec::Vec;

use super::graph::Graph;
use super::neighbourhood::Gatherer;
use crate::Topology;
use crate::error::Error;
use crate::ids::{HalfedgeId, NONE, VertexId};
use crate::scheme::{Border, Rules, Scheme};

/// The parts of a surface: faces of a mesh that was refined at least once, or for Doo–Sabin its
/// vertices. Parts with the same node of the graph are alike, each in its own vertices.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    pub(crate) graph: Graph,
    /// The node of each part; [`NONE`] if it was not looked at, or has no surface.
    pub(crate) node: Vec<u32>,
    /// The vertices that each part depends on, one after the other.
    pub(crate) start: Vec<u32>,
    pub(crate) vertices: Vec<VertexId>,
}

impl Parts {
    /// Looks at all parts that at most `most_faces` faces surround, in time and memory in proportion
    /// to the mesh.
    pub(crate) fn new(finer: &Topology, next: &Rules, most_faces: u32) -> Result<Self, Error> {
        let part_count = match next.scheme {
            Scheme::DooSabin => finer.vertex_count(),
            _ => finer.face_count(),
        };
        let (mut graph, mut gatherer) = (Graph::default(), Gatherer::new(finer, next));
        let mut node = alloc::vec![NONE; part_count];
        let (mut start, mut vertices) = (Vec::with_capacity(part_count + 1), Vec::new());
        start.push(0);
        for (part, node) in node.iter_mut().enumerate() {
            let h = beginning(finer, next.scheme, part);
            let is_seen = |&h: &HalfedgeId| {
                is_covered(finer, next, h) && face_count(finer, next, h) <= u64::from(most_faces)
            };
            if let Some(h) = h.filter(is_seen) {
                let found = gatherer.gather(h);
                vertices.extend(&found.vertices[..found.value_count]);
                *node = graph.node(found, next)?;
            }
            let end = u32::try_from(vertices.len())
                .map_err(|_| Error::TooLarge { halfedges: vertices.len() as u64 })?;
            start.push(end);
        }
        Ok(Self { graph, node, start, vertices })
    }

    /// The vertices that a part depends on.
    pub(crate) fn vertices(&self, part: usize) -> &[VertexId] {
        &self.vertices[self.start[part] as usize..self.start[part + 1] as usize]
    }
}

/// The half-edge that a part begins with.
pub(super) fn beginning(finer: &Topology, scheme: Scheme, part: usize) -> Option<HalfedgeId> {
    match scheme {
        Scheme::Loop | Scheme::Butterfly => Some(HalfedgeId(3 * part as u32)),
        Scheme::CatmullClark | Scheme::Kobbelt => Some(HalfedgeId(4 * part as u32)),
        Scheme::DooSabin => {
            let v = VertexId(part as u32);
            // The face that is the image of a face comes first.
            if finer.is_boundary(v) { finer.outgoing(v) } else { Some(HalfedgeId(v.0)) }
        }
    }
}

/// Whether there is a surface at a part.
pub(super) fn is_covered(finer: &Topology, next: &Rules, h: HalfedgeId) -> bool {
    if next.scheme != Scheme::DooSabin {
        return true;
    }
    let v = finer.origin(h);
    if finer.is_boundary(v) {
        next.border == Border::Bspline && finer.fan_size(v) == 2
    } else {
        finer.fan_size(v) == 4
    }
}

/// How many faces surround a part, those at two corners counted twice.
pub(crate) fn face_count(finer: &Topology, next: &Rules, h: HalfedgeId) -> u64 {
    let face = finer.face_vertices(finer.face(h));
    let around = |v: VertexId| -> u64 {
        let own = u64::from(finer.fan_size(v));
        if next.scheme != Scheme::Loop || !finer.is_boundary(v) {
            return own;
        }
        let (a, b) = crate::rules::boundary_neighbours(finer, v);
        own + u64::from(finer.fan_size(a)) + u64::from(finer.fan_size(b))
    };
    match next.scheme {
        Scheme::DooSabin => finer
            .fan(finer.origin(h))
            .map(|g| finer.face_halfedges(finer.face(g)).len() as u64)
            .sum(),
        _ => face.iter().map(|&v| around(v)).sum(),
    }
}
