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

use crate::ids::VertexId;
use crate::pushback::{Freedom, PushBack};
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
    let topology = &pushback.step().topology;
    assert_eq!(x.len(), topology.vertex_count(), "one value per finer vertex");
    let Freedom { stencils, is_smooth } = pushback.freedom();
    let transposed = stencils.transposed();
    let system = System { pushback, topology, is_smooth, stencils, transposed, weight };
    let bending = system.bending(x);
    let before = dot(&bending, &bending);
    let (change, updates) = system.solve(&bending);
    let moved = system.spread(&change);
    par::for_blocks(x, |start, block| {
        block.iter_mut().zip(&moved[start..]).for_each(|(x, &by)| *x += by);
    });
    let bending = system.bending(x);
    Fairing { updates, before, after: dot(&bending, &bending) }
}

/// The normal equations $`(w Z^T L^T L Z + (1 - w) I) y = -w Z^T L^T L x_0`$ of the free values: `Z`
/// spreads them over all values, `L` is the bending.
struct System<'a> {
    pushback: &'a PushBack<'a>,
    topology: &'a Topology,
    is_smooth: Vec<bool>,
    stencils: Stencils,
    transposed: Stencils,
    weight: f64,
}

impl System<'_> {
    fn spread(&self, y: &[Vec3]) -> Vec<Vec3> {
        let mut change = self.stencils.apply(y);
        self.pushback.centre(&mut change);
        change
    }

    /// From each vertex to the mean of its neighbours; zero on boundaries and creases.
    fn bending(&self, x: &[Vec3]) -> Vec<Vec3> {
        par::collect(x.len(), |i| {
            if !self.is_smooth[i] {
                return Vec3::ZERO;
            }
            let v = VertexId(i as u32);
            let sum: Vec3 = self.topology.ring(v).map(|q| x[q.index()]).sum();
            sum / f64::from(self.topology.valence(v)) - x[i]
        })
    }

    /// Half of how the energy changes with the free values, for a bending.
    fn gradient(&self, bending: &[Vec3]) -> Vec<Vec3> {
        let share = |q: VertexId| bending[q.index()] / f64::from(self.topology.valence(q));
        let mut of_all = par::collect(bending.len(), |i| {
            let ring = self.topology.ring(VertexId(i as u32));
            ring.filter(|q| self.is_smooth[q.index()]).map(share).sum::<Vec3>() - bending[i]
        });
        self.pushback.centre(&mut of_all);
        self.transposed.apply(&of_all)
    }

    fn apply(&self, y: &[Vec3]) -> Vec<Vec3> {
        let gradient = self.gradient(&self.bending(&self.spread(y)));
        par::collect(y.len(), |i| self.weight * gradient[i] + (1.0 - self.weight) * y[i])
    }

    /// The diagonal, as it is if the vertices that a free value moves were no neighbours: exact enough
    /// for a preconditioner, and of linear cost whatever the valences. 1 where nothing is left of it.
    fn diagonal(&self) -> Vec<f64> {
        let squares = par::collect(self.is_smooth.len(), |i| {
            let ring = self.topology.ring(VertexId(i as u32));
            let smooth = ring.filter(|q| self.is_smooth[q.index()]);
            let others = smooth.map(|q| f64::from(self.topology.valence(q))).map(|n| 1.0 / (n * n));
            others.sum::<f64>() + f64::from(u8::from(self.is_smooth[i]))
        });
        par::collect(self.transposed.row_count(), |i| {
            let row = self.transposed.row(i);
            let sum: f64 = row.map(|(v, w)| w * w * squares[v.index()]).sum();
            let diagonal = self.weight * sum + (1.0 - self.weight);
            if diagonal > 0.0 { diagonal } else { 1.0 }
        })
    }

    /// The change of the free values for the bending of the mesh as it is, and the updates made:
    /// conjugate gradients with the diagonal as preconditioner, on all coordinates at once, so that
    /// the result turns with the mesh. \[HestenesStiefel1952\]
    fn solve(&self, bending: &[Vec3]) -> (Vec<Vec3>, u32) {
        let diagonal = self.diagonal();
        let gradient = self.gradient(bending);
        let mut residual = par::collect(gradient.len(), |i| -self.weight * gradient[i]);
        let mut y = alloc::vec![Vec3::ZERO; residual.len()];
        let mut direction = y.clone();
        let (mut energy, mut enough) = (0.0, None);
        for updates in 0..MOST {
            let z = par::collect(residual.len(), |i| residual[i] / diagonal[i]);
            let before = core::mem::replace(&mut energy, dot(&residual, &z));
            if energy <= *enough.get_or_insert(ENOUGH * ENOUGH * energy) {
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
            if curvature <= 0.0 {
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
