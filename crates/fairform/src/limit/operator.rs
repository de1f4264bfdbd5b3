//! The limit operator in the forms that the solvers iterate on: rings of one weight, and rows.
//!
//! The same rows as [`limit_stencils`](super::limit_stencils), held to them by tests; a ring takes a
//! third of the memory.

use alloc::vec::Vec;

use crate::scheme::loop_scheme::{limit_weight, smallest_eigenvalue_bound};
use crate::solve::LinearOperator;
use crate::{Vec3, par};

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

    fn usual_smallest_eigenvalue(&self) -> f64 {
        self.smallest.max(0.2)
    }
}

#[cfg(feature = "direct")]
impl crate::solve::direct::Entries for RingOperator {
    fn entries(&self, i: usize) -> impl Iterator<Item = (usize, f64)> {
        let ring = &self.neighbour[self.start[i] as usize..self.start[i + 1] as usize];
        let [centre, each] = self.weights[ring.len()];
        let own = core::iter::once((i, centre));
        own.chain(ring.iter().map(move |&q| (q as usize, each)))
    }
}

/// Relative difference of entries that are equal but for rounding, which adds up along a curve.
const SAME: f64 = 1e-10;

/// Limit rows written out.
#[derive(Clone, Debug)]
pub(crate) struct RowOperator {
    start: Vec<u32>,
    /// Local number and weight.
    entries: Vec<(u32, f64)>,
    scale: Vec<f64>,
    guaranteed: f64,
    usual: f64,
}

impl RowOperator {
    /// Rows told by `row(i, entries)` with the numbers of the mesh, which `local` translates.
    pub(crate) fn new(
        count: usize,
        row: impl Fn(usize, &mut Vec<(u32, f64)>) + Sync,
        local: &[u32],
        scale: Vec<f64>,
        guaranteed: f64,
        usual: f64,
    ) -> Self {
        let blocks = par::blocks(count, |range| {
            let (mut lengths, mut entries) = (Vec::with_capacity(range.len()), Vec::new());
            for i in range {
                let before = entries.len();
                row(i, &mut entries);
                lengths.push((entries.len() - before) as u32);
            }
            entries.iter_mut().for_each(|e: &mut (u32, f64)| e.0 = local[e.0 as usize]);
            (lengths, entries)
        });
        let mut start = Vec::with_capacity(count + 1);
        let mut entries = Vec::with_capacity(blocks.iter().map(|b| b.1.len()).sum());
        let mut end = 0;
        start.push(end);
        for (lengths, block) in blocks {
            start.extend(lengths.into_iter().map(|length| {
                end += length;
                end
            }));
            entries.extend(block);
        }
        Self { start, entries, scale, guaranteed, usual }
    }

    /// Finds the `D` for which $`D^{-1} B`$ is symmetric, if there is one, by going from unknown to
    /// unknown: $`d_j = d_i b_{ji} / b_{ij}`$. For short rows.
    pub(crate) fn find_scale(&mut self) {
        let n = self.scale.len();
        let mut scale = alloc::vec![0.0; n];
        let mut queue = Vec::new();
        for seed in 0..n {
            if scale[seed] == 0.0 {
                scale[seed] = 1.0;
                queue.push(seed);
            }
            while let Some(i) = queue.pop() {
                for &(j, weight) in self.entries(i).iter().filter(|e| (e.0 as usize) < n) {
                    let j = j as usize;
                    let back = self.entries(j).iter().find(|e| e.0 as usize == i);
                    if let Some(&(_, back)) = back.filter(|_| scale[j] == 0.0) {
                        // Exactly one where the two agree.
                        scale[j] = scale[i] * (back / weight);
                        queue.push(j);
                    }
                }
            }
        }
        self.scale = scale;
    }

    fn entries(&self, i: usize) -> &[(u32, f64)] {
        &self.entries[self.start[i] as usize..self.start[i + 1] as usize]
    }

    /// Whether $`D^{-1} B`$ is symmetric among the unknowns.
    pub(crate) fn is_symmetric(&self) -> bool {
        let n = self.scale.len();
        let entry = |i: usize, j: usize| {
            let found = self.entries(i).iter().find(|e| e.0 as usize == j);
            found.map_or(0.0, |e| e.1) / self.scale[i]
        };
        let agrees = |i: usize| {
            self.entries(i).iter().filter(|e| (e.0 as usize) < n).all(|&(j, w)| {
                let (a, b) = (w / self.scale[i], entry(j as usize, i));
                (a - b).abs() <= SAME * a.abs().max(b.abs())
            })
        };
        par::blocks(n, |mut range| range.all(agrees)).into_iter().all(|ok| ok)
    }
}

impl LinearOperator for RowOperator {
    fn unknown_count(&self) -> usize {
        self.scale.len()
    }

    #[inline]
    fn row(&self, i: usize, x: &[Vec3]) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for &(q, weight) in self.entries(i) {
            sum += weight * x[q as usize];
        }
        sum
    }

    fn scale(&self, i: usize) -> f64 {
        self.scale[i]
    }

    fn smallest_eigenvalue_bound(&self) -> f64 {
        self.guaranteed
    }

    fn usual_smallest_eigenvalue(&self) -> f64 {
        self.usual.max(self.guaranteed)
    }
}

#[cfg(feature = "direct")]
impl crate::solve::direct::Entries for RowOperator {
    fn entries(&self, i: usize) -> impl Iterator<Item = (usize, f64)> {
        self.entries(i).iter().map(|&(q, weight)| (q as usize, weight))
    }
}
