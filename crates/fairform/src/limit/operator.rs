//! The limit operator in the lean form that the solvers iterate on: rings of one weight, and curves.
//!
//! The same rows as [`limit_stencils`](super::limit_stencils), held to them by tests, at a third of
//! the memory.

use alloc::vec::Vec;

use crate::Vec3;
use crate::scheme::loop_scheme::{
    BOUNDARY_SMALLEST_EIGENVALUE, limit_weight, smallest_eigenvalue_bound,
};
use crate::solve::LinearOperator;

/// Limit rows of interior vertices: the vertex and the mean of its ring.
#[derive(Clone, Debug)]
pub(crate) struct RingOperator {
    /// Where the ring of each row begins, and the end.
    pub(crate) start: Vec<u32>,
    /// Local numbers of the neighbours.
    pub(crate) neighbour: Vec<u32>,
    /// For each valence: weight of the vertex, and of each neighbour.
    weights: Vec<[f64; 2]>,
    smallest: f64,
}

impl RingOperator {
    pub(crate) fn new(start: Vec<u32>, neighbour: Vec<u32>) -> Self {
        let valences = || start.windows(2).map(|w| w[1] - w[0]);
        let largest = valences().max().unwrap_or(0);
        let weights = (0..=largest)
            .map(|n| {
                if n < 2 {
                    return [1.0, 0.0];
                }
                let centre = limit_weight(n);
                [centre, (1.0 - centre) / f64::from(n)]
            })
            .collect();
        // The bound grows with the valence.
        let smallest = valences().min().map_or(1.0, |n| smallest_eigenvalue_bound(n.max(2)));
        Self { start, neighbour, weights, smallest }
    }
}

impl LinearOperator for RingOperator {
    fn unknown_count(&self) -> usize {
        self.start.len() - 1
    }

    #[inline]
    fn row(&self, i: usize, x: &[Vec3]) -> Vec3 {
        let ring = &self.neighbour[self.start[i] as usize..self.start[i + 1] as usize];
        let [centre, each] = self.weights[ring.len()];
        let mut sum = Vec3::ZERO;
        for &q in ring {
            sum += x[q as usize];
        }
        centre * x[i] + each * sum
    }

    fn scale(&self, i: usize) -> f64 {
        self.weights[(self.start[i + 1] - self.start[i]) as usize][1]
    }

    fn smallest_eigenvalue_bound(&self) -> f64 {
        self.smallest
    }
}

/// Limit rows of boundary vertices: the vertex and its two neighbours on the boundary.
#[derive(Clone, Debug)]
pub(crate) struct CurveOperator {
    pub(crate) rows: Vec<CurveRow>,
}

/// One row of a [`CurveOperator`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct CurveRow {
    /// Local numbers of the neighbours.
    pub(crate) neighbours: [u32; 2],
    /// Weights of the vertex and of its neighbours.
    pub(crate) weights: [f64; 3],
    /// The entry of $`D`$.
    pub(crate) scale: f64,
}

impl LinearOperator for CurveOperator {
    fn unknown_count(&self) -> usize {
        self.rows.len()
    }

    #[inline]
    fn row(&self, i: usize, x: &[Vec3]) -> Vec3 {
        let CurveRow { neighbours: [l, r], weights, .. } = self.rows[i];
        weights[0] * x[i] + weights[1] * x[l as usize] + weights[2] * x[r as usize]
    }

    fn scale(&self, i: usize) -> f64 {
        self.rows[i].scale
    }

    fn smallest_eigenvalue_bound(&self) -> f64 {
        BOUNDARY_SMALLEST_EIGENVALUE
    }
}
