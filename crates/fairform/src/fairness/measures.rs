//! Integrals over a whole surface.

use alloc::vec::Vec;

use libm::sqrt;

use super::curvature::Curvature;
use super::frame::Unit;
use crate::ids::{FaceId, HalfedgeId, NONE, VertexId};
use crate::{Topology, Vec3, par};

/// The shares of the area that [`Measures::mean_percentiles`] are for.
pub const PERCENTILES: [f64; 5] = [0.5, 0.9, 0.95, 0.99, 1.0];

/// Measures of a whole surface. Those called *scale-invariant* are the same for a surface and its
/// enlargement; the others are given in the unit of length `L` of the positions.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Measures {
    /// Area, `L²`. This is also the membrane energy.
    pub area: f64,
    /// Volume enclosed by the closed components, `L³`; negative where normals point inwards.
    pub volume: f64,
    /// $`V - E + F`$, without isolated vertices.
    pub euler_characteristic: i64,
    /// $`\int H\,dA`$, `L`.
    pub mean: f64,
    /// $`\int H^2\,dA`$, the Willmore energy; scale-invariant. At least 4π if closed.
    pub willmore: f64,
    /// $`\int k_1^2 + k_2^2\,dA`$, the bending energy of a thin plate; scale-invariant.
    pub bending: f64,
    /// $`\int K\,dA`$; scale-invariant. On a closed surface it is 2π times the Euler
    /// characteristic (Gauss–Bonnet), so that the difference tells how far to trust the sampling.
    pub gaussian: f64,
    /// $`\int \tfrac12(|k_1| + |k_2|)\,dA`$, `L`: how much it bends in all, see
    /// [`Undulation`](super::Undulation).
    pub turning: f64,
    /// $`\int |\nabla H|^2\,dA`$, `L⁻²`, with `H` linear on each triangle.
    pub mean_variation: f64,
    /// $`\int (\partial k_1/\partial e_1)^2 + (\partial k_2/\partial e_2)^2\,dA`$, `L⁻²`: what
    /// surfaces of minimal curvature variation minimise \[Moreton1992\].
    pub principal_variation: f64,
    /// The values that `|H|` does not exceed on the shares [`PERCENTILES`] of the area, `L⁻¹`.
    pub mean_percentiles: [f64; 5],
}

impl Measures {
    /// $`\int|\nabla H|^2\,dA`$ times the area; scale-invariant.
    #[must_use]
    pub fn relative_mean_variation(&self) -> f64 {
        super::frame::finite(self.mean_variation * self.area)
    }

    /// [`principal_variation`](Self::principal_variation) times the area; scale-invariant.
    #[must_use]
    pub fn relative_principal_variation(&self) -> f64 {
        super::frame::finite(self.principal_variation * self.area)
    }

    /// $`36 π V^2 / A^3`$; scale-invariant, 1 for the sphere and less for any other closed surface.
    #[must_use]
    pub fn sphericity(&self) -> f64 {
        let length = sqrt(self.area);
        let ratio = self.volume / length / length / length;
        super::frame::finite(36.0 * core::f64::consts::PI * ratio * ratio)
    }
}

/// The measures of a surface with known curvature at its vertices.
///
/// Polygons are fans round their centroid, where values are the mean of those at the corners.
/// Integrals take values as linear on each triangle, so that their error is of second order in the
/// edge length.
///
/// # Panics
/// If there is not one position and one curvature per vertex.
#[must_use]
pub fn measures(topology: &Topology, positions: &[Vec3], curvatures: &[Curvature]) -> Measures {
    assert_eq!(positions.len(), topology.vertex_count(), "one position per vertex");
    assert_eq!(curvatures.len(), topology.vertex_count(), "one curvature per vertex");
    let unit = Unit::of(positions);
    let points = par::collect(positions.len(), |v| unit.point(positions[v]));
    let k =
        par::collect(curvatures.len(), |v| curvatures[v].principal.map(|k| unit.convert(k, -1)));
    let fans = Fans::new(topology, &points);
    let weights = par::collect(points.len(), |v| fans.vertex_area(VertexId(v as u32)));
    let integral = |f: &(dyn Fn(usize) -> f64 + Sync)| {
        let weighted = |v: usize| if weights[v] == 0.0 { 0.0 } else { weights[v] * f(v) };
        par::blocks(points.len(), |range| range.map(weighted).sum::<f64>()).into_iter().sum::<f64>()
    };
    let variation = |v: usize| -> f64 {
        curvatures[v].variation.map(|b| unit.convert(b, -2)).map(|b| b * b).iter().sum()
    };
    let mean: Vec<f64> = par::collect(points.len(), |v| f64::midpoint(k[v][0], k[v][1]));
    Measures {
        area: unit.restore(integral(&|_| 1.0), 2),
        volume: unit.restore(fans.volume(), 3),
        euler_characteristic: euler_characteristic(topology),
        mean: unit.restore(integral(&|v| mean[v]), 1),
        willmore: unit.restore(integral(&|v| mean[v] * mean[v]), 0),
        bending: unit.restore(integral(&|v| k[v][0] * k[v][0] + k[v][1] * k[v][1]), 0),
        gaussian: unit.restore(integral(&|v| k[v][0] * k[v][1]), 0),
        turning: unit.restore(integral(&|v| f64::midpoint(k[v][0].abs(), k[v][1].abs())), 1),
        mean_variation: unit.restore(fans.gradient_energy(&mean), -2),
        principal_variation: unit.restore(integral(&variation), -2),
        mean_percentiles: percentiles(&mean, &weights).map(|h| unit.restore(h, -1)),
    }
}

fn euler_characteristic(topology: &Topology) -> i64 {
    let vertices = topology.vertex_count() - topology.isolated_count();
    let signed = |count: usize| (count as u64).cast_signed();
    signed(vertices + topology.face_count()) - signed(topology.edge_count())
}

/// The faces as fans of triangles round their centroids.
struct Fans<'a> {
    topology: &'a Topology,
    points: &'a [Vec3],
    centroids: Vec<Vec3>,
    /// Signed area of the triangle on each half-edge: negative where the fan folds over, as it may
    /// in a face that is not star-shaped, so that the sum is still the area of the face.
    areas: Vec<f64>,
    face_areas: Vec<f64>,
}

impl<'a> Fans<'a> {
    fn new(topology: &'a Topology, points: &'a [Vec3]) -> Self {
        let centroids = par::collect(topology.face_count(), |f| {
            let corners = topology.face_vertices(FaceId(f as u32));
            let sum: Vec3 = corners.iter().map(|v| points[v.index()]).sum();
            sum / corners.len() as f64
        });
        let mut fans =
            Self { topology, points, centroids, areas: Vec::new(), face_areas: Vec::new() };
        let area_vectors = par::collect(topology.face_count(), |f| {
            let sides = topology.face_halfedges(FaceId(f as u32));
            sides.map(|h| fans.area_vector(h)).sum::<Vec3>()
        });
        let areas = par::collect(topology.halfedge_count(), |h| {
            let h = HalfedgeId(h as u32);
            let vector = fans.area_vector(h);
            let outwards = vector.dot(area_vectors[topology.face(h).index()]);
            let area = vector.length();
            // A face with a coordinate that is not finite has no area.
            if area.is_finite() { libm::copysign(area, outwards) } else { 0.0 }
        });
        fans.face_areas = par::collect(topology.face_count(), |f| {
            topology.face_halfedges(FaceId(f as u32)).map(|h| areas[h.index()]).sum()
        });
        fans.areas = areas;
        fans
    }

    /// Half the vector product of the sides of the triangle on a half-edge.
    fn area_vector(&self, h: HalfedgeId) -> Vec3 {
        let [c, a, b] = self.triangle(h);
        0.5 * (a - c).cross(b - c)
    }

    fn triangle(&self, h: HalfedgeId) -> [Vec3; 3] {
        let point = |v: VertexId| self.points[v.index()];
        let centroid = self.centroids[self.topology.face(h).index()];
        [centroid, point(self.topology.origin(h)), point(self.topology.target(h))]
    }

    /// The integral of the function that is one at a vertex and zero at the others.
    fn vertex_area(&self, v: VertexId) -> f64 {
        let corner = |h: HalfedgeId| {
            let f = self.topology.face(h);
            let sides = self.areas[h.index()] + self.areas[self.topology.prev(h).index()];
            let n = self.topology.face_halfedges(f).len() as f64;
            sides / 3.0 + self.face_areas[f.index()] / (3.0 * n)
        };
        self.topology.fan(v).map(corner).sum()
    }

    /// Volume of the closed components, each measured from one of its own vertices, which keeps the
    /// digits of a small one far away.
    fn volume(&self) -> f64 {
        let components = self.topology.components();
        let mut apex = alloc::vec![NONE; components.list.len()];
        for (v, &id) in (0..).zip(&components.of_vertex) {
            if id != NONE && apex[id as usize] == NONE {
                apex[id as usize] = v;
            }
        }
        let volume = |h: HalfedgeId| {
            let id = components.of_vertex[self.topology.origin(h).index()] as usize;
            if components.list[id].boundary_vertex_count > 0 {
                return 0.0;
            }
            let apex = self.points[apex[id] as usize];
            let [a, b, c] = self.triangle(h).map(|p| p - apex);
            let volume = a.dot(b.cross(c)) / 6.0;
            if volume.is_nan() { 0.0 } else { volume }
        };
        self.sum_over_halfedges(volume)
    }

    /// $`\int|\nabla f|^2\,dA`$ for values at the vertices.
    fn gradient_energy(&self, values: &[f64]) -> f64 {
        let centre_values = par::collect(self.topology.face_count(), |f| {
            let corners = self.topology.face_vertices(FaceId(f as u32));
            corners.iter().map(|v| values[v.index()]).sum::<f64>() / corners.len() as f64
        });
        // On the three parts of a triangle the function is the same as on the whole.
        self.sum_over_halfedges(|h| {
            let centre = centre_values[self.topology.face(h).index()];
            let [a, b] = [self.topology.origin(h), self.topology.target(h)];
            triangle_energy(self.triangle(h), [centre, values[a.index()], values[b.index()]])
        })
    }

    fn sum_over_halfedges(&self, f: impl Fn(HalfedgeId) -> f64 + Sync) -> f64 {
        let sums = par::blocks(self.topology.halfedge_count(), |range| {
            range.map(|h| f(HalfedgeId(h as u32))).sum::<f64>()
        });
        sums.into_iter().sum()
    }
}

/// $`\int|\nabla f|^2\,dA`$ for the linear function on a triangle; zero if it has no area to speak of.
fn triangle_energy([a, b, c]: [Vec3; 3], [fa, fb, fc]: [f64; 3]) -> f64 {
    let (u, v) = (b - a, c - a);
    let (du, dv) = (fb - fa, fc - fa);
    let double_area = u.cross(v).length();
    let largest = u.dot(u).max(v.dot(v));
    // Thinner ones have rounding errors for their heights.
    if !(double_area > 1e-12 * largest && double_area.is_finite()) {
        return 0.0;
    }
    // Differences first over the height, since the squares of small lengths could underflow.
    let gradient = (du * v - dv * u) / double_area;
    0.5 * double_area * gradient.dot(gradient)
}

/// The least values that `|f|` does not exceed on given shares of the area.
fn percentiles(values: &[f64], weights: &[f64]) -> [f64; 5] {
    let mut sorted: Vec<(f64, f64)> = values
        .iter()
        .zip(weights)
        .filter(|&(_, &weight)| weight > 0.0)
        .map(|(value, &weight)| (value.abs(), weight))
        .collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let total: f64 = sorted.iter().map(|(_, weight)| weight).sum();
    let mut found = [sorted.last().map_or(0.0, |(value, _)| *value); 5];
    let (mut sum, mut next) = (0.0, 0);
    for (value, weight) in sorted {
        sum += weight;
        while next < PERCENTILES.len() - 1 && sum >= PERCENTILES[next] * total {
            found[next] = value;
            next += 1;
        }
    }
    found
}
