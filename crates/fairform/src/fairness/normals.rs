//! Normals of a surface of which only the vertices are known.

use alloc::vec::Vec;

use super::fit::{Chart, LeastSquares, first_ring, powers, second_ring};
use super::frame::Unit;
use crate::ids::{FaceId, HalfedgeId, VertexId};
use crate::{Topology, Vec3, par};

/// Unit normals of the smooth surface that a fine mesh samples: those of the cubic polynomial that
/// fits two rings of neighbours best \[Cazals2005\], over the plane of [`vertex_normals`]. Of
/// third order in the edge length, at the boundary of second; zero where those are.
///
/// # Panics
/// If there is not one position per vertex.
#[must_use]
pub fn fitted_normals(topology: &Topology, positions: &[Vec3]) -> Vec<Vec3> {
    let estimates = vertex_normals(topology, positions);
    let unit = Unit::of(positions);
    let points = par::collect(positions.len(), |v| unit.point(positions[v]));
    par::collect(points.len(), |v| {
        let slopes = slopes(topology, VertexId(v as u32), &points, estimates[v]);
        slopes.unwrap_or(estimates[v])
    })
}

/// `None` if the neighbours do not determine a plane.
fn slopes(topology: &Topology, v: VertexId, points: &[Vec3], estimate: Vec3) -> Option<Vec3> {
    if estimate == Vec3::ZERO {
        return None;
    }
    let near = second_ring(topology, v, &first_ring(topology, v));
    let chart = Chart::new(points[v.index()], estimate, near.iter().map(|&q| points[q.index()]))?;
    let mut fit = LeastSquares::new();
    for &q in &near {
        let [u, v, z] = chart.coordinates(points[q.index()]);
        let (pu, pv) = (powers(u), powers(v));
        fit.add(POWERS.map(|[i, j]| pu[i] * pv[j]), z);
    }
    let [p, q, ..] = fit.solve(TERM_COUNTS, 1e-2)?;
    let [x, y] = chart.axes;
    Some((estimate + (-p) * x + (-q) * y).normalized())
}

/// Powers of `u` and `v` by degree.
const POWERS: [[usize; 2]; 9] =
    [[1, 0], [0, 1], [2, 0], [1, 1], [0, 2], [3, 0], [2, 1], [1, 2], [0, 3]];
/// Number of terms up to each degree.
const TERM_COUNTS: [usize; 3] = [2, 5, 9];

/// Unit normals from the faces around each vertex, weighted by their angles \[Thürmer1998\]; zero at
/// isolated vertices and where all faces are without area.
///
/// # Panics
/// If there is not one position per vertex.
#[must_use]
pub fn vertex_normals(topology: &Topology, positions: &[Vec3]) -> Vec<Vec3> {
    assert_eq!(positions.len(), topology.vertex_count(), "one position per vertex");
    let unit = Unit::of(positions);
    let face_normals = par::collect(topology.face_count(), |f| {
        face_normal(topology, FaceId(f as u32), |v| unit.point(positions[v.index()]))
    });
    let point = |v: VertexId| unit.point(positions[v.index()]);
    par::collect(positions.len(), |v| {
        let v = VertexId(v as u32);
        let here = point(v);
        let weighted = |h: HalfedgeId| {
            let normal = face_normals[topology.face(h).index()];
            if normal == Vec3::ZERO {
                return Vec3::ZERO;
            }
            let a = (point(topology.target(h)) - here).normalized();
            let b = (point(topology.origin(topology.prev(h))) - here).normalized();
            let angle = libm::atan2(a.cross(b).dot(normal), a.dot(b));
            // A reflex corner has an angle beyond π.
            let angle = if angle < 0.0 { angle + 2.0 * core::f64::consts::PI } else { angle };
            angle * normal
        };
        topology.fan(v).map(weighted).sum::<Vec3>().normalized()
    })
}

/// The unit normal of a polygon (Newell's sum of cross products); zero if it has no area.
pub(crate) fn face_normal(
    topology: &Topology,
    f: FaceId,
    point: impl Fn(VertexId) -> Vec3,
) -> Vec3 {
    let corners = topology.face_vertices(f);
    let first = point(corners[0]);
    // Small faces are enlarged, so that no product underflows.
    let reach = corners.iter().map(|&v| (point(v) - first).max_abs()).fold(0.0, f64::max);
    if reach == 0.0 {
        return Vec3::ZERO;
    }
    let side = |v: VertexId| (point(v) - first) / reach;
    corners.windows(2).map(|w| side(w[0]).cross(side(w[1]))).sum::<Vec3>().normalized()
}
