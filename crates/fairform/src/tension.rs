//! Shape parameters of faces: found from the mesh for Doo–Sabin, and as shares of the plain scheme for
//! Loop and Catmull–Clark.

use alloc::vec::Vec;

use crate::fairness::face_normal;
use crate::ids::{EdgeId, FaceId, VertexId};
use crate::{Mesh, Topology, Vec3, par};

/// A parameter for each face, near which the two-phase surface puts the middle of the face on the
/// sphere that its vertices suggest:
///
/// ```math
/// \lambda_f = \frac{c_f}{1 + c_f}, \qquad c_f = \text{mean over its corners of } \cos\angle(n_f, n_v)
/// ```
///
/// with $`n_f`$ the normal of the face and $`n_v`$ the mean of the normals around the vertex. A flat
/// region gives 1/2, which alone is of fourth order there; a cube 0.366, the parameter for which all
/// its face centres lie on the sphere through its vertices. Where faces fold over, the parameter stays
/// above 0.05.
///
/// For Doo–Sabin. No parameter exceeds 1/2, since $`c_f \le 1`$, so for Loop and Catmull–Clark it would
/// be the plain scheme everywhere.
#[must_use]
pub fn automatic(mesh: &Mesh) -> Vec<f64> {
    const SMALLEST: f64 = 0.05;
    let (topology, points) = (mesh.topology(), mesh.positions());
    let normals = par::collect(topology.face_count(), |f| {
        face_normal(topology, FaceId(f as u32), |v| points[v.index()])
    });
    let around = par::collect(points.len(), |v| {
        let fan = topology.fan(VertexId(v as u32));
        fan.map(|h| normals[topology.face(h).index()]).sum::<Vec3>().normalized()
    });
    par::collect(normals.len(), |f| {
        let face = topology.face_vertices(FaceId(f as u32));
        let cosines = face.iter().map(|v| normals[f].dot(around[v.index()]));
        let c = cosines.sum::<f64>() / face.len() as f64;
        f64::max(SMALLEST, c / (1.0 + c.max(0.0)))
    })
}

/// What share the plain rule of Loop's or Catmull and Clark's scheme has in a first step in two phases,
/// $`w = 2(1 - \lambda)`$; the rest is linear subdivision.
#[derive(Clone, Copy)]
pub(crate) struct Shares<'a> {
    pub(crate) topology: &'a Topology,
    pub(crate) lambda: &'a [f64],
}

impl Shares<'_> {
    pub(crate) fn face(self, f: FaceId) -> f64 {
        2.0 * (1.0 - self.lambda[f.index()])
    }

    /// On a curve: the share of the face behind the edge, or the mean of both.
    pub(crate) fn edge(self, e: EdgeId) -> f64 {
        let h = self.topology.edge_halfedge(e);
        let own = self.face(self.topology.face(h));
        self.topology.twin(h).map_or(own, |t| f64::midpoint(own, self.face(self.topology.face(t))))
    }

    /// The sum over the faces at a vertex.
    pub(crate) fn around(self, v: VertexId) -> f64 {
        self.topology.fan(v).map(|h| self.face(self.topology.face(h))).sum()
    }

    pub(crate) fn largest(self) -> f64 {
        2.0 * (1.0 - self.lambda.iter().copied().fold(1.0, f64::min))
    }
}
