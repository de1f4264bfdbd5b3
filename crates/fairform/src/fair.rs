//! Fairing: among all surfaces that interpolate, one with less bending.
//!
//! One level down, where limit points are held by push-back (see [`pushback`](crate::pushback)), the
//! new points are free. The thin-plate energy of the finer mesh in its discrete form,
//!
//! ```math
//! E(x) = \sum_i \Bigl| \frac{1}{n_i} \sum_j x_j - x_i \Bigr|^2
//! ```
//!
//! with the sum over the vertices off boundaries and creases and their neighbours $`j`$, is then
//! minimised by conjugate gradients: since every second vertex is held, their number does not grow
//! with the mesh. Curves stay as they are: cubic splines through given points bend least already.
//! \[Halstead1993\]

use alloc::vec::Vec;

use crate::pushback::{Freedom, PushBack};
use crate::rows::{self, Rows};
use crate::{Stencils, Topology, Vec3, par};

/// What fairing did.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Fairing {
    /// Updates of conjugate gradients.
    pub updates: u32,
    /// Thin-plate energy of the interpolant before, the square of a length: of the unit of the
    /// coordinates from [`fair()`], of that of the report from a fit.
    pub before: f64,
    /// And after; never larger but for rounding.
    pub after: f64,
}

/// Reduction of the gradient at which the solve ends.
const ENOUGH: f64 = 1e-8;

/// Most updates; some twenty to forty are needed.
const MOST: u32 = 200;

/// Moves `x`, finer values whose limit points interpolate, along what push-back leaves free, to the
/// minimum of
///
/// ```math
/// w E(x) + (1 - w) |y - y_0|^2
/// ```
///
/// with $`y`$ the free values, $`y_0`$ where they are now, and the `weight` $`w`$ between 0 (which
/// changes nothing) and 1 (the fairest). Both terms are squares of lengths, so `weight` means the same
/// at any scale.
///
/// # Panics
/// If there is not one value per finer vertex.
pub fn fair(pushback: &PushBack<'_>, x: &mut [Vec3], weight: f64) -> Fairing {
    let finer = &pushback.step().topology;
    assert_eq!(x.len(), finer.vertex_count(), "one value per finer vertex");
    let Freedom { stencils, smooth } = pushback.freedom();
    let laplacian = Laplacian { topology: finer, smooth: &smooth, stencils: &stencils };
    let bending = rows::stencils(&laplacian, stencils.source_count());
    let bent = par::collect(smooth.len(), |i| laplacian.apply(i, x));
    let before = dot(&bent, &bent);
    let system = System { transposed: bending.transposed(), bending, weight };
    let (change, updates) = system.solve(&bent);
    let moved = stencils.apply(&change);
    par::for_blocks(x, |start, block| {
        block.iter_mut().zip(&moved[start..]).for_each(|(x, &by)| *x += by);
    });
    let bent = par::collect(smooth.len(), |i| laplacian.apply(i, x));
    Fairing { updates, before, after: dot(&bent, &bent) }
}

/// How the bending at each smooth vertex changes with the free values.
struct Laplacian<'a> {
    topology: &'a Topology,
    smooth: &'a [crate::VertexId],
    stencils: &'a Stencils,
}

impl Laplacian<'_> {
    fn apply(&self, i: usize, x: &[Vec3]) -> Vec3 {
        let v = self.smooth[i];
        let sum: Vec3 = self.topology.ring(v).map(|q| x[q.index()]).sum();
        sum / f64::from(self.topology.valence(v)) - x[v.index()]
    }
}

impl Rows for Laplacian<'_> {
    fn len(&self) -> usize {
        self.smooth.len()
    }

    fn visit(&self, row: usize, mut entry: impl FnMut(u32, f64)) {
        let v = self.smooth[row];
        let share = 1.0 / f64::from(self.topology.valence(v));
        let mut add = |q: crate::VertexId, weight: f64| {
            self.stencils.row(q.index()).for_each(|(free, w)| entry(free.0, weight * w));
        };
        self.topology.ring(v).for_each(|q| add(q, share));
        add(v, -1.0);
    }
}

/// The normal equations $`(w A^T A + (1 - w) I) y = -w A^T c`$.
struct System {
    bending: Stencils,
    transposed: Stencils,
    weight: f64,
}

impl System {
    fn apply(&self, y: &[Vec3]) -> Vec<Vec3> {
        let bent = self.transposed.apply(&self.bending.apply(y));
        par::collect(y.len(), |i| self.weight * bent[i] + (1.0 - self.weight) * y[i])
    }

    /// The diagonal; 1 where it vanishes, and so does all that belongs to it.
    fn diagonal(&self) -> Vec<f64> {
        par::collect(self.transposed.row_count(), |i| {
            let squares: f64 = self.transposed.row(i).map(|e| e.1 * e.1).sum();
            let sum = self.weight * squares + (1.0 - self.weight);
            if sum > 0.0 { sum } else { 1.0 }
        })
    }

    /// The change of the free values for the bending `c` of the mesh as it is, and the updates made:
    /// conjugate gradients with the diagonal as preconditioner, on all coordinates at once, so that
    /// the result turns with the mesh. \[HestenesStiefel1952\]
    fn solve(&self, c: &[Vec3]) -> (Vec<Vec3>, u32) {
        let diagonal = self.diagonal();
        let gradient = self.transposed.apply(c);
        let mut residual = par::collect(gradient.len(), |i| -self.weight * gradient[i]);
        let mut y = alloc::vec![Vec3::ZERO; residual.len()];
        let mut direction = y.clone();
        let scaled = |r: &[Vec3]| par::collect(r.len(), |i| r[i] / diagonal[i]);
        let (mut energy, mut first) = (0.0, None);
        for updates in 0..MOST {
            let z = scaled(&residual);
            let before = core::mem::replace(&mut energy, dot(&residual, &z));
            let first = *first.get_or_insert(energy);
            if !(energy > ENOUGH * ENOUGH * first) {
                return (y, updates);
            }
            let beta = if before == 0.0 { 0.0 } else { energy / before };
            par::for_blocks(&mut direction, |start, block| {
                for (i, p) in block.iter_mut().enumerate() {
                    *p = z[start + i] + beta * *p;
                }
            });
            let image = self.apply(&direction);
            let curvature = dot(&direction, &image);
            if !(curvature > 0.0) {
                return (y, updates);
            }
            let alpha = energy / curvature;
            par::for_blocks2(&mut y, &mut residual, |start, y, residual| {
                for (i, (y, r)) in y.iter_mut().zip(residual).enumerate() {
                    *y += alpha * direction[start + i];
                    *r += -alpha * image[start + i];
                }
            });
        }
        (y, MOST)
    }
}

/// The sum of the scalar products, block by block in order.
fn dot(a: &[Vec3], b: &[Vec3]) -> f64 {
    let blocks = par::blocks(a.len(), |range| range.map(|i| a[i].dot(b[i])).sum::<f64>());
    blocks.into_iter().sum()
}
