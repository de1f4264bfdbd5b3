//! What an edit changes.

use alloc::sync::Arc;
use alloc::vec::Vec;

use crate::ids::{FaceId, VertexId};
use crate::{Rules, Scheme, Topology};

/// What an edit changed; all else has the same bits as before.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Change {
    pub(super) vertices: Vec<VertexId>,
    pub(super) faces: Vec<FaceId>,
}

impl Change {
    /// What changed, as a drag tells it.
    #[must_use]
    pub fn changed(&self) -> Changed<'_> {
        Changed { vertices: &self.vertices, faces: &self.faces }
    }
}

/// What an edit changed; all else has the same bits as before.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Changed<'d> {
    /// The vertices whose control points moved, sorted.
    pub vertices: &'d [VertexId],
    /// The faces of the mesh whose part of the surface moved, at any level of refinement (see
    /// [`Refined::parent`](crate::refine::Refined::parent)), sorted: those that share a vertex with a
    /// face that has such a control point.
    pub faces: &'d [FaceId],
}

/// Grabbed vertices, and how the control points follow them.
#[derive(Clone, PartialEq, Debug)]
pub struct Drag {
    pub(super) grabbed: Vec<VertexId>,
    pub(super) vertices: Vec<VertexId>,
    /// Move of each control point for a move of the grabbed data by 1.
    pub(super) column: Vec<f64>,
    pub(super) faces: Vec<FaceId>,
    pub(super) generation: u64,
}

impl Drag {
    /// The vertices whose data move, sorted, each once.
    #[must_use]
    pub fn grabbed(&self) -> &[VertexId] {
        &self.grabbed
    }

    /// What every drag changes.
    #[must_use]
    pub fn changed(&self) -> Changed<'_> {
        Changed { vertices: &self.vertices, faces: &self.faces }
    }
}

/// The faces whose surface depends on control points of some vertices.
///
/// A limit surface over a face depends on the faces that share a vertex with it, whatever the valences: so
/// does the face's part of every refined mesh, and for Doo–Sabin what is new on its edges and vertices.
pub(super) fn faces_around(topology: &Topology, vertices: &[VertexId]) -> Vec<FaceId> {
    let faces = |vertices: &[VertexId]| {
        let around = |&v: &VertexId| topology.fan(v).map(|h| topology.face(h));
        let mut faces: Vec<FaceId> = vertices.iter().flat_map(around).collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    };
    let corners = |&f: &FaceId| topology.face_vertices(f).iter().copied();
    let mut near: Vec<VertexId> = faces(vertices).iter().flat_map(corners).collect();
    near.sort_unstable();
    near.dedup();
    faces(&near)
}

/// The vertices whose limit rows are others under other rules of the same scheme, sorted: those at faces
/// with another shape parameter and at edges with another sharpness, and those of another sharpness.
pub(super) fn beside_changes(topology: &Topology, old: &Rules, new: &Rules) -> Vec<VertexId> {
    let mut beside = Vec::new();
    let is_plain_half = new.scheme != Scheme::DooSabin;
    match (&old.tension, &new.tension) {
        (None, None) => {}
        (Some(_), None) | (None, Some(_)) if !is_plain_half => {
            return topology.vertices().collect();
        }
        (a, b) => {
            let parameter =
                |t: &Option<Arc<[f64]>>, f: FaceId| t.as_ref().map_or(0.5, |t| t[f.index()]);
            for f in topology.faces().filter(|&f| parameter(a, f) != parameter(b, f)) {
                beside.extend_from_slice(topology.face_vertices(f));
            }
        }
    }
    let (a, b) = (old.sharpness(topology), new.sharpness(topology));
    if old.creases.is_some() || new.creases.is_some() {
        for e in topology.edges().filter(|&e| a.edge(e) != b.edge(e)) {
            let h = topology.edge_halfedge(e);
            beside.extend([topology.origin(h), topology.target(h)]);
        }
        beside.extend(topology.vertices().filter(|&v| a.vertex(v) != b.vertex(v)));
    }
    beside.sort_unstable();
    beside.dedup();
    beside
}
