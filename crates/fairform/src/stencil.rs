//! [`Stencils`]: sparse rows of weights, where rules meet data.

use alloc::vec::Vec;

use crate::ids::VertexId;
use crate::{Vec3, par};

/// Sparse rows of weights: result `i` is the weighted sum of the sources that row `i` names.
///
/// A refinement step, a limit map or a tangent map is a table of such rows; applying them is one
/// gather loop, for positions as for colours or any other triple per vertex.
#[derive(Clone, PartialEq, Debug)]
pub struct Stencils {
    source_count: usize,
    row_start: Vec<u32>,
    source: Vec<u32>,
    weight: Vec<f64>,
}

impl Stencils {
    /// Rows that lie one behind the other.
    pub(crate) fn from_arrays(
        source_count: usize,
        row_start: Vec<u32>,
        source: Vec<u32>,
        weight: Vec<f64>,
    ) -> Self {
        debug_assert!(source.iter().all(|&s| (s as usize) < source_count), "sources exist");
        Self { source_count, row_start, source, weight }
    }

    /// Number of rows, which is the number of results.
    #[must_use]
    pub fn row_count(&self) -> usize {
        self.row_start.len() - 1
    }

    /// Number of values that a row can draw on.
    #[must_use]
    pub fn source_count(&self) -> usize {
        self.source_count
    }

    /// The entries of a row.
    ///
    /// # Panics
    /// If there is no such row.
    #[must_use]
    pub fn row(&self, i: usize) -> impl ExactSizeIterator<Item = (VertexId, f64)> + '_ {
        let range = self.row_start[i] as usize..self.row_start[i + 1] as usize;
        self.source[range.clone()]
            .iter()
            .map(|&s| VertexId(s))
            .zip(self.weight[range].iter().copied())
    }

    /// The weighted sums of all rows.
    ///
    /// One thread gathers a whole row, in row order, so the bits do not depend on how many run.
    ///
    /// # Panics
    /// If `points` does not have one value per source.
    #[must_use]
    pub fn apply(&self, points: &[Vec3]) -> Vec<Vec3> {
        assert_eq!(points.len(), self.source_count, "one point per source");
        par::collect(self.row_count(), |i| {
            let range = self.row_start[i] as usize..self.row_start[i + 1] as usize;
            let mut sum = Vec3::ZERO;
            for (&s, &w) in self.source[range.clone()].iter().zip(&self.weight[range]) {
                sum += w * points[s as usize];
            }
            sum
        })
    }

    /// The rows that take values back: entry `(i, j)` becomes `(j, i)`.
    #[must_use]
    pub fn transposed(&self) -> Self {
        let mut row_start = alloc::vec![0; self.source_count + 1];
        for &s in &self.source {
            row_start[s as usize + 1] += 1;
        }
        for i in 0..self.source_count {
            row_start[i + 1] += row_start[i];
        }
        let mut end = row_start.clone();
        let mut source = alloc::vec![0; self.source.len()];
        let mut weight = alloc::vec![0.0; self.source.len()];
        for i in 0..self.row_count() {
            for (s, w) in self.row(i) {
                let at = &mut end[s.index()];
                source[*at as usize] = i as u32;
                weight[*at as usize] = w;
                *at += 1;
            }
        }
        Self::from_arrays(self.row_count(), row_start, source, weight)
    }
}
