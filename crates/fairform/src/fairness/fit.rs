//! Fitting the graph of a polynomial to the neighbours of a vertex.

use alloc::vec::Vec;

use libm::sqrt;

use crate::ids::VertexId;
use crate::{Topology, Vec3};

/// The vertices of the faces around `v`.
pub(super) fn first_ring(topology: &Topology, v: VertexId) -> Vec<VertexId> {
    let mut near = Vec::with_capacity(12);
    visit_faces(topology, v, &mut |q| near.push(q));
    near
}

/// Visits the vertices at most two steps away round the faces of `v`: all of them up to
/// pentagons, and no more than four of a large face, so that the time stays linear.
fn visit_faces(topology: &Topology, v: VertexId, visit: &mut impl FnMut(VertexId)) {
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
pub(super) fn second_ring(topology: &Topology, v: VertexId, first: &[VertexId]) -> Vec<VertexId> {
    // On the rim of a large fan the ring of the hub would cost the square of its size.
    const MOST: u32 = 32;
    let mut all: Vec<(VertexId, usize)> = first.iter().enumerate().map(|(i, &q)| (q, i)).collect();
    for &q in first.iter().filter(|&&q| topology.fan_size(q) <= MOST) {
        visit_faces(topology, q, &mut |r| {
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

/// Coordinates in the tangent plane of a vertex and above it, in units of the mean distance of its
/// neighbours.
pub(super) struct Chart {
    origin: Vec3,
    normal: Vec3,
    pub(super) axes: [Vec3; 2],
    pub(super) scale: f64,
}

impl Chart {
    /// `None` if all neighbours are at the origin.
    pub(super) fn new(
        origin: Vec3,
        normal: Vec3,
        neighbours: impl Iterator<Item = Vec3>,
    ) -> Option<Self> {
        let distances = neighbours.map(|q| (q - origin).length()).filter(|d| *d > 0.0);
        let (count, sum) = distances.fold((0, 0.0), |(n, sum), d| (n + 1, sum + d));
        let scale = sum / f64::from(count);
        let axes = tangent_frame(normal);
        (scale > 0.0 && scale.is_finite()).then_some(Self { origin, normal, axes, scale })
    }

    pub(super) fn coordinates(&self, p: Vec3) -> [f64; 3] {
        self.components((p - self.origin) / self.scale)
    }

    pub(super) fn components(&self, d: Vec3) -> [f64; 3] {
        [d.dot(self.axes[0]), d.dot(self.axes[1]), d.dot(self.normal)]
    }
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

/// The powers of `x` from 0 to 4.
pub(super) fn powers(x: f64) -> [f64; 5] {
    let square = x * x;
    [1.0, x, square, square * x, square * square]
}

/// The normal equations of a least squares problem.
pub(super) struct LeastSquares<const N: usize> {
    matrix: [[f64; N]; N],
    right: [f64; N],
}

impl<const N: usize> LeastSquares<N> {
    pub(super) fn new() -> Self {
        Self { matrix: [[0.0; N]; N], right: [0.0; N] }
    }

    /// Adds an equation; one with a number that is not finite is left out.
    pub(super) fn add(&mut self, row: [f64; N], right: f64) {
        if !(right.is_finite() && row.iter().all(|x| x.is_finite())) {
            return;
        }
        for i in 0..N {
            for j in 0..=i {
                self.matrix[i][j] += row[i] * row[j];
            }
            self.right[i] += row[i] * right;
        }
    }

    /// The solution in the first unknowns, as many of `counts`, which ascend, as the equations
    /// determine, by Cholesky factorisation; the others are zero. `None` if they do not even
    /// determine the first count.
    ///
    /// They determine an unknown if its column makes an angle with the span of those before it
    /// whose sine has a square above `independent`.
    pub(super) fn solve<const C: usize>(
        &self,
        counts: [usize; C],
        independent: f64,
    ) -> Option<[f64; N]> {
        let mut l = [[0.0; N]; N];
        let mut rank = 0;
        while rank < N {
            for j in 0..=rank {
                let dot: f64 = (0..j).map(|k| l[rank][k] * l[j][k]).sum();
                let rest = self.matrix[rank][j] - dot;
                l[rank][j] = if j < rank { rest / l[j][j] } else { rest };
            }
            let pivot = l[rank][rank];
            let is_independent = pivot > independent * self.matrix[rank][rank];
            if !is_independent {
                break;
            }
            l[rank][rank] = sqrt(pivot);
            rank += 1;
        }
        let count = counts.into_iter().rfind(|&count| count <= rank)?;
        let mut x = [0.0; N];
        for i in 0..count {
            let dot: f64 = (0..i).map(|k| l[i][k] * x[k]).sum();
            x[i] = (self.right[i] - dot) / l[i][i];
        }
        for i in (0..count).rev() {
            let dot: f64 = (i + 1..count).map(|k| l[k][i] * x[k]).sum();
            x[i] = (x[i] - dot) / l[i][i];
        }
        x.iter().all(|x| x.is_finite()).then_some(x)
    }
}
