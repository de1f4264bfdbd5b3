//! Curvature at the vertices, by fitting the graph of a polynomial round each.

use alloc::vec::Vec;

use super::fit::{Chart, LeastSquares, first_ring, powers, second_ring};
use super::frame::{Unit, finite};
use super::normals::fitted_normals;
use crate::ids::VertexId;
use crate::{Topology, Vec3, par};

/// The principal curvatures at a point.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Curvature {
    /// Largest and smallest normal curvature, in that order, per unit of length; positive where the
    /// surface bends away from its normal.
    pub principal: [f64; 2],
    /// Their unit directions, which with the normal form a right-handed frame; either may be
    /// turned round. Zero where the curvature is undefined.
    pub directions: [Vec3; 2],
    /// How fast each principal curvature changes along its own direction, per unit of length
    /// squared: what a surface of minimal curvature variation keeps small \[Moreton1992\].
    pub variation: [f64; 2],
}

impl Curvature {
    /// Gaussian curvature, the product of the principal ones.
    #[must_use]
    pub fn gaussian(&self) -> f64 {
        finite(self.principal[0] * self.principal[1])
    }

    /// Mean curvature, half the sum of the principal ones.
    #[must_use]
    pub fn mean(&self) -> f64 {
        f64::midpoint(self.principal[0], self.principal[1])
    }
}

/// The curvature at every vertex of a surface with exact unit normals.
///
/// In the tangent plane of a vertex the surface is the graph of
///
/// ```math
/// h(u, v) = \sum_{2 \le i + j \le 4} c_{ij}\, u^i v^j ,
/// ```
///
/// whose coefficients come from the heights *and* slopes of the vertices around by least squares:
/// three equations per neighbour, as \[Goldfeather2004\] have it for the third degree.
/// Neighbours are the vertices of the faces around, and theirs again on the boundary and where there
/// are fewer than five. If they do not determine the fourth degree, the third or second is fitted.
///
/// The error is of order $`h^3`$ in the edge length $`h`$, of order $`h^4`$ where neighbours lie
/// opposite each other. On a mesh of waves with mixed valences, perturbed, 64 edges along a side of
/// length 2, boundary included, the largest error of `H` is 2·10⁻⁴; with the third degree it is
/// 2·10⁻³ at best, and 4·10⁻² if tensors of the faces are averaged \[Rusinkiewicz2004\], which is of first
/// order there. The error of normals that are only estimates is divided by $`h`$: with those of
/// [`fitted_normals`] the curvature is of order $`h^2`$, at the boundary of order $`h`$, and with
/// [`vertex_normals`] it does not converge.
///
/// The limit surface at an extraordinary vertex may have no curvature; what is found there is that
/// of the samples around.
///
/// [`vertex_normals`]: super::vertex_normals
///
/// # Panics
/// If there is not one position and one normal per vertex.
#[must_use]
pub fn curvatures(topology: &Topology, positions: &[Vec3], normals: &[Vec3]) -> Vec<Curvature> {
    assert_eq!(positions.len(), topology.vertex_count(), "one position per vertex");
    assert_eq!(normals.len(), topology.vertex_count(), "one normal per vertex");
    let unit = Unit::of(positions);
    let points = par::collect(positions.len(), |v| unit.point(positions[v]));
    let mut normals = par::collect(normals.len(), |v| normals[v].normalized());
    if normals.contains(&Vec3::ZERO) {
        let estimates = fitted_normals(topology, positions);
        for (normal, estimate) in normals.iter_mut().zip(estimates) {
            if *normal == Vec3::ZERO {
                *normal = estimate;
            }
        }
    }
    let surface = Surface { topology, points: &points, normals: &normals };
    par::collect(points.len(), |v| {
        let c = surface.curvature(VertexId(v as u32)).unwrap_or_default();
        Curvature {
            principal: c.principal.map(|k| unit.restore(k, -1)),
            directions: c.directions,
            variation: c.variation.map(|k| unit.restore(k, -2)),
        }
    })
}

/// Fewest neighbours that determine the fit well; below it, and on the boundary, a second ring is taken.
const ENOUGH: usize = 5;

struct Surface<'a> {
    topology: &'a Topology,
    points: &'a [Vec3],
    normals: &'a [Vec3],
}

impl Surface<'_> {
    /// `None` where it is undefined.
    fn curvature(&self, v: VertexId) -> Option<Curvature> {
        let (here, normal) = (self.points[v.index()], self.normals[v.index()]);
        if normal == Vec3::ZERO {
            return None;
        }
        let mut near = first_ring(self.topology, v);
        if near.len() < ENOUGH || self.topology.is_boundary(v) {
            near = second_ring(self.topology, v, &near);
        }
        let chart = Chart::new(here, normal, near.iter().map(|&q| self.points[q.index()]))?;
        let mut fit = LeastSquares::new();
        for &q in &near {
            let d = chart.coordinates(self.points[q.index()]);
            add_neighbour(&mut fit, d, chart.components(self.normals[q.index()]));
        }
        let c = fit.solve(TERM_COUNTS, 1e-6)?;
        Some(principal(&c, chart.scale, chart.axes))
    }
}

/// Powers of `u` and `v` by degree, two to four: so the fit of a lower degree is a leading block.
const POWERS: [[usize; 2]; 12] = [
    [2, 0],
    [1, 1],
    [0, 2],
    [3, 0],
    [2, 1],
    [1, 2],
    [0, 3],
    [4, 0],
    [3, 1],
    [2, 2],
    [1, 3],
    [0, 4],
];
/// Number of terms up to each degree.
const TERM_COUNTS: [usize; 3] = [3, 7, 12];

/// Adds the equations of one neighbour at `(u, v)` and height `z`, with normal `n`, all in the frame
/// of the vertex.
fn add_neighbour(fit: &mut LeastSquares<12>, [u, v, z]: [f64; 3], n: [f64; 3]) {
    let (pu, pv) = (powers(u), powers(v));
    let slope = |p: &[f64; 5], i: usize| if i == 0 { 0.0 } else { i as f64 * p[i - 1] };
    // A neighbour whose normal lies flat is beyond the fold of the graph: it counts less and less.
    let has_normal = n != [0.0; 3];
    let weight = if has_normal { n[2].max(0.0) } else { 1.0 };
    fit.add(POWERS.map(|[i, j]| weight * (pu[i] * pv[j])), weight * z);
    if has_normal {
        fit.add(POWERS.map(|[i, j]| weight * (slope(&pu, i) * pv[j])), -n[0]);
        fit.add(POWERS.map(|[i, j]| weight * (pu[i] * slope(&pv, j))), -n[1]);
    }
}

/// The curvature at the origin of a graph with coefficients `c`, its unit of length being `scale`.
fn principal(c: &[f64; 12], scale: f64, [x, y]: [Vec3; 2]) -> Curvature {
    // The shape operator is minus the matrix [[a, b], [b, d]] of second derivatives.
    let [a, b, d] = [-2.0 * c[0], -c[1], -2.0 * c[2]];
    let half = 0.5 * (a - d);
    let radius = libm::hypot(half, b);
    let mean = 0.5 * (a + d);
    // The eigenvector of the larger eigenvalue, from the row without cancellation.
    let [cos, sin] = match (radius > 0.0, half >= 0.0) {
        (false, _) => [1.0, 0.0],
        (true, true) => [radius + half, b],
        (true, false) => [b, radius - half],
    };
    let length = libm::hypot(cos, sin);
    let [cos, sin] = [cos / length, sin / length];
    let third = |u: f64, v: f64| {
        -6.0 * (c[3] * u * u * u + c[4] * u * u * v + c[5] * u * v * v + c[6] * v * v * v)
    };
    Curvature {
        principal: [(mean + radius) / scale, (mean - radius) / scale],
        directions: [cos * x + sin * y, cos * y + (-sin) * x],
        variation: [third(cos, sin), third(-sin, cos)].map(|t| t / scale / scale),
    }
}
