//! Shape parameters found from the mesh: how tight each face should be.

use alloc::vec::Vec;

use crate::fairness::face_normal;
use crate::{Mesh, Vec3, par};

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
#[must_use]
pub fn automatic(mesh: &Mesh) -> Vec<f64> {
    const SMALLEST: f64 = 0.05;
    let (topology, points) = (mesh.topology(), mesh.positions());
    let normals = par::collect(topology.face_count(), |f| {
        face_normal(topology, crate::FaceId(f as u32), |v| points[v.index()])
    });
    let around = par::collect(points.len(), |v| {
        let fan = topology.fan(crate::VertexId(v as u32));
        fan.map(|h| normals[topology.face(h).index()]).sum::<Vec3>().normalized()
    });
    par::collect(normals.len(), |f| {
        let face = topology.face_vertices(crate::FaceId(f as u32));
        let cosines = face.iter().map(|v| normals[f].dot(around[v.index()]));
        let c = cosines.sum::<f64>() / face.len() as f64;
        f64::max(SMALLEST, c / (1.0 + c.max(0.0)))
    })
}
