//! How much more a surface turns than the mesh it was made for.

use super::frame::Unit;
use super::measures::Measures;
use crate::ids::{EdgeId, FaceId};
use crate::{Mesh, par};

/// The total turning of a surface and of the mesh it was made for.
///
/// Turning is $`\int\tfrac12(|k_1| + |k_2|)\,dA`$. A mesh bends only in its edges, each a sharp
/// cylinder, so that its turning is $`\tfrac12\sum_e \ell_e\,|\theta_e|`$ with lengths and dihedral
/// angles: the same measure of the polyhedron, by its normal cycle \[Morvan2003\].
/// For a profile drawn out along a line it is the total absolute turning angle of the profile, and
/// a curve never turns less than a polygon inscribed in it \[Milnor1950\]; a closed convex one turns
/// exactly as much. So the ratio counts the bends that are not in the data, in developable regions
/// too, where `K` is blind, and on saddles, where `H` is.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Undulation {
    /// Turning of the surface, in the unit of length of its positions.
    pub surface: f64,
    /// Turning of the mesh.
    pub mesh: f64,
}

impl Undulation {
    /// Turning of the surface over that of the mesh: about 1 for a fair surface, a few tenths more
    /// where it bulges evenly, much more where it ripples. `None` if the mesh is flat.
    #[must_use]
    pub fn ratio(&self) -> Option<f64> {
        let ratio = self.surface / self.mesh;
        ratio.is_finite().then_some(ratio)
    }
}

/// The turning of a surface, of which these are the measures, beside that of `mesh`.
#[must_use]
pub fn undulation(surface: &Measures, mesh: &Mesh) -> Undulation {
    Undulation { surface: surface.turning, mesh: turning(mesh) }
}

/// $`\tfrac12\sum_e \ell_e\,|\theta_e|`$. The normal of a face that is not planar is that of its area
/// vector; an edge beside a face without area does not bend.
fn turning(mesh: &Mesh) -> f64 {
    let topology = mesh.topology();
    let unit = Unit::of(mesh.positions());
    let point = |v: crate::VertexId| unit.point(mesh.positions()[v.index()]);
    let normals = par::collect(topology.face_count(), |f| {
        super::normals::face_normal(topology, FaceId(f as u32), point)
    });
    let turning = |e: usize| {
        let h = topology.edge_halfedge(EdgeId(e as u32));
        let Some(twin) = topology.twin(h) else { return 0.0 };
        let [a, b] = [h, twin].map(|h| normals[topology.face(h).index()]);
        let length = (point(topology.target(h)) - point(topology.origin(h))).length();
        // Beside a face without a normal this is atan2(0, 0), which is zero.
        let length = if length.is_finite() { length } else { 0.0 };
        0.5 * length * libm::atan2(a.cross(b).length(), a.dot(b))
    };
    let sums = par::blocks(topology.edge_count(), |range| range.map(turning).sum::<f64>());
    unit.restore(sums.into_iter().sum(), 1)
}
