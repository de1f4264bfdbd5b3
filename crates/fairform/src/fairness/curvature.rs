//! Curvature at the vertices, by fitting a small polynomial surface to each vertex.

use alloc::vec::Vec;

use libm::sqrt;

use super::frame::{Unit, finite};
use crate::ids::{HalfedgeId, VertexId};
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
    /// squared: what a surface of minimal curvature variation keeps small \[MoretonSequin1992\].
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
/// three equations per neighbour, one degree more than \[GoldfeatherInterrante2004\]. The error is
/// of order $`h^3`$ in the edge length $`h`$, of order $`h^4`$ where neighbours lie opposite each
/// other, at the boundary and for any valence alike. Neighbours are the vertices of the faces around,
/// and theirs again where these are too few. If the neighbours do not determine the fourth degree,
/// the third or second is fitted.
///
/// With normals that are only estimates, such as [`vertex_normals`], nothing converges: their error
/// is divided by $`h`$.
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
        let estimates = vertex_normals(topology, positions);
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
        face_normal(topology, crate::FaceId(f as u32), |v| unit.point(positions[v.index()]))
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
pub(super) fn face_normal(
    topology: &Topology,
    f: crate::FaceId,
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
        let here = self.points[v.index()];
        let normal = self.normals[v.index()];
        if normal == Vec3::ZERO {
            return None;
        }
        let mut near = Vec::with_capacity(12);
        self.gather(v, &mut |q| near.push(q));
        if near.len() < ENOUGH || self.topology.is_boundary(v) {
            near = self.second_ring(v, &near);
        }
        let offset = |q: VertexId| self.points[q.index()] - here;
        let mut distances = near.iter().map(|&q| offset(q).length()).filter(|d| *d > 0.0);
        let scale = mean(&mut distances)?;
        let [x, y] = tangent_frame(normal);
        let mut fit = Fit::default();
        for &q in &near {
            let (d, n) = (offset(q) / scale, self.normals[q.index()]);
            let local = |d: Vec3| [d.dot(x), d.dot(y), d.dot(normal)];
            fit.add(local(d), local(n));
        }
        let c = fit.solve()?;
        Some(principal(&c, scale, [x, y]))
    }

    /// Visits the vertices at most two steps away round the faces of `v`: all of them up to
    /// pentagons, and no more than four of a large face, so that the time stays linear.
    fn gather(&self, v: VertexId, visit: &mut impl FnMut(VertexId)) {
        let topology = self.topology;
        for h in topology.fan(v) {
            let ahead = topology.next(h);
            let back = topology.prev(h);
            visit(topology.origin(ahead));
            let size = topology.face_halfedges(topology.face(h)).len();
            if size >= 4 {
                visit(topology.target(ahead));
            }
            if size >= 5 {
                visit(topology.origin(topology.prev(back)));
            }
            if topology.twin(back).is_none() {
                visit(topology.origin(back));
            }
        }
    }

    /// The neighbours and their neighbours, each once and in the order in which they are met.
    fn second_ring(&self, v: VertexId, first: &[VertexId]) -> Vec<VertexId> {
        // On the rim of a large fan the ring of the hub would cost the square of its size.
        const MOST: u32 = 32;
        let mut all: Vec<(VertexId, usize)> =
            first.iter().enumerate().map(|(i, &q)| (q, i)).collect();
        for &q in first.iter().filter(|&&q| self.topology.fan_size(q) <= MOST) {
            self.gather(q, &mut |r| {
                let place = all.len();
                all.push((r, place));
            });
        }
        all.sort_unstable();
        all.dedup_by_key(|(q, _)| *q);
        all.retain(|(q, _)| *q != v);
        // In order of meeting rather than of number: so the numbering does not change the sums.
        all.sort_unstable_by_key(|(_, place)| *place);
        all.into_iter().map(|(q, _)| q).collect()
    }
}

fn mean(values: &mut impl Iterator<Item = f64>) -> Option<f64> {
    let (count, sum) = values.fold((0, 0.0), |(n, sum), x| (n + 1, sum + x));
    let mean = sum / f64::from(count);
    (mean > 0.0 && mean.is_finite()).then_some(mean)
}

/// Two unit vectors that with the unit `normal` form a right-handed frame.
fn tangent_frame(normal: Vec3) -> [Vec3; 2] {
    let [x, y, z] = <[f64; 3]>::from(normal).map(f64::abs);
    let axis = if x <= y && x <= z {
        Vec3::new(1.0, 0.0, 0.0)
    } else if y <= z {
        Vec3::new(0.0, 1.0, 0.0)
    } else {
        Vec3::new(0.0, 0.0, 1.0)
    };
    let first = axis.cross(normal).normalized();
    [first, normal.cross(first)]
}

/// Number of coefficients up to the second, third and fourth degree.
const TERM_COUNTS: [usize; 3] = [3, 7, 12];
const TERMS: usize = 12;
/// Powers of `u` and `v`, by degree: so the fit of a lower degree is a leading block.
const POWERS: [[usize; 2]; TERMS] = [
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

/// The normal equations of a least squares fit.
#[derive(Default)]
struct Fit {
    matrix: [[f64; TERMS]; TERMS],
    right: [f64; TERMS],
}

impl Fit {
    /// Adds the equations of one neighbour at `(u, v)` and height `z`, with normal `n`, all in the
    /// frame of the vertex.
    fn add(&mut self, [u, v, z]: [f64; 3], n: [f64; 3]) {
        if !(u.is_finite() && v.is_finite() && z.is_finite()) {
            return;
        }
        let mut pu = [1.0; 5];
        let mut pv = [1.0; 5];
        for i in 1..5 {
            pu[i] = pu[i - 1] * u;
            pv[i] = pv[i - 1] * v;
        }
        let slope = |p: &[f64; 5], i: usize| if i == 0 { 0.0 } else { i as f64 * p[i - 1] };
        // A neighbour whose normal lies flat is beyond the fold of the graph: it counts less and less.
        let has_normal = n != [0.0; 3];
        let weight = if has_normal { n[2].max(0.0) } else { 1.0 };
        self.add_row(POWERS.map(|[i, j]| weight * (pu[i] * pv[j])), weight * z);
        if has_normal {
            self.add_row(POWERS.map(|[i, j]| weight * (slope(&pu, i) * pv[j])), -n[0]);
            self.add_row(POWERS.map(|[i, j]| weight * (pu[i] * slope(&pv, j))), -n[1]);
        }
    }

    fn add_row(&mut self, row: [f64; TERMS], right: f64) {
        for i in 0..TERMS {
            for j in 0..=i {
                self.matrix[i][j] += row[i] * row[j];
            }
            self.right[i] += row[i] * right;
        }
    }

    /// The coefficients of the highest degree that the equations determine, by Cholesky
    /// factorisation; zero beyond. `None` if not even the second degree is.
    fn solve(&self) -> Option<[f64; TERMS]> {
        // Squared sine of the least angle between a column and those before it.
        const INDEPENDENT: f64 = 1e-6;
        let mut l = [[0.0; TERMS]; TERMS];
        let mut rank = 0;
        while rank < TERMS {
            for j in 0..=rank {
                let dot: f64 = (0..j).map(|k| l[rank][k] * l[j][k]).sum();
                let rest = self.matrix[rank][j] - dot;
                l[rank][j] = if j < rank { rest / l[j][j] } else { rest };
            }
            let pivot = l[rank][rank];
            if !(pivot > INDEPENDENT * self.matrix[rank][rank]) {
                break;
            }
            l[rank][rank] = sqrt(pivot);
            rank += 1;
        }
        let count = TERM_COUNTS.into_iter().rfind(|&count| count <= rank)?;
        let mut c = [0.0; TERMS];
        for i in 0..count {
            let dot: f64 = (0..i).map(|k| l[i][k] * c[k]).sum();
            c[i] = (self.right[i] - dot) / l[i][i];
        }
        for i in (0..count).rev() {
            let dot: f64 = (i + 1..count).map(|k| l[k][i] * c[k]).sum();
            c[i] = (c[i] - dot) / l[i][i];
        }
        c.iter().all(|x| x.is_finite()).then_some(c)
    }
}

/// The curvature at the origin of a graph with coefficients `c`, its unit of length being `scale`.
fn principal(c: &[f64; TERMS], scale: f64, [x, y]: [Vec3; 2]) -> Curvature {
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
