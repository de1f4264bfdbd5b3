//! Solving `B x = p` for control points, with `B` the limit operator.
//!
//! Every operator here is $`B = D S`$ with $`D`$ positive diagonal and $`S`$ symmetric positive
//! definite, and its eigenvalues lie in $`(0, 1]`$: that is what the methods rely on.

use alloc::vec::Vec;
use core::ops::ControlFlow;

use crate::error::Error;
use crate::{Vec3, par};

mod conjugate_gradients;
#[cfg(feature = "direct")]
pub(crate) mod direct;
mod stationary;

pub use conjugate_gradients::conjugate_gradients;
pub(crate) use stationary::chebyshev_steps;
pub use stationary::{Interval, stationary};

/// Rows that are gathered one by one. Unknowns come first, then values that are known.
pub trait LinearOperator: Sync {
    /// Number of rows, which is the number of unknowns.
    fn unknown_count(&self) -> usize;

    /// Row `i` applied to unknowns and known values.
    fn row(&self, i: usize, x: &[Vec3]) -> Vec3;

    /// The diagonal of $`D`$ in $`B = D S`$, up to a common factor.
    fn scale(&self, i: usize) -> f64;

    /// A lower bound for the eigenvalues; the upper bound is 1. Not positive where nothing is known.
    fn smallest_eigenvalue_bound(&self) -> f64;

    /// The smallest eigenvalue to expect in practice; at least the bound.
    fn usual_smallest_eigenvalue(&self) -> f64;
}

/// When to stop.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Stop {
    /// Largest residual that is good enough, in units of [`unit`](Self::unit). With `None` the
    /// solver makes exactly [`max_updates`](Self::max_updates) updates.
    pub tolerance: Option<f64>,
    /// What residuals are divided by, for example the diagonal of the bounding box. Positive.
    pub unit: f64,
    /// Most updates.
    pub max_updates: u32,
}

/// Residual of the vertices that are solved for, after some updates.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Step {
    /// Updates made so far; 0 is the unmodified mesh.
    pub updates: u32,
    /// Largest distance of a limit point from its target, in the unit of [`Stop`].
    pub max: f64,
    /// Mean distance, likewise.
    pub mean: f64,
}

/// How a solve ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Outcome {
    /// The tolerance was met.
    Converged,
    /// The number of updates that was asked for was made, and no tolerance was set.
    CountReached,
    /// The tolerance was not met within the most updates allowed.
    TooManyUpdates,
    /// The residual does not get smaller any more: rounding is all that is left.
    Stalled,
}

/// What a solve did.
#[derive(Clone, PartialEq, Debug)]
pub struct Report {
    /// One entry per residual, the first for the unmodified input.
    pub history: Vec<Step>,
    /// How it ended.
    pub outcome: Outcome,
    /// Number of updates to expect from the first residual and the bounds of the spectrum. Mostly
    /// fewer are needed, since the data excite the slow modes little. `None` without a tolerance.
    pub predicted: Option<u32>,
}

impl Report {
    /// The last residual.
    ///
    /// # Panics
    /// Never: there is at least one.
    #[must_use]
    pub fn last(&self) -> Step {
        *self.history.last().expect("a report has a residual")
    }
}

/// Told every step; breaks to stop the solve.
pub type Observer<'a> = dyn FnMut(Step) -> ControlFlow<()> + 'a;

/// Keeps the history, and decides.
struct Progress<'a, 'o> {
    stop: Stop,
    history: Vec<Step>,
    observer: &'a mut Observer<'o>,
    /// The best residual and when it was last clearly better than before.
    best: (f64, u32),
    /// Most updates without a clear gain.
    most: u32,
}

/// Updates without a clear gain after which a solve has stalled: near the limits of rounding soon,
/// otherwise only when even the slowest spectrum would have shown one.
const PATIENCE: [(f64, u32); 2] = [(1e-11, 300), (f64::INFINITY, 3000)];

/// The same where a negative bound says that eigenvalues need not be positive (Catmull–Clark beside
/// inner vertices with two faces): more than a spectrum down to 0.01, which is what the methods then
/// assume, takes to halve the residual, 70 updates for the plainest. Whoever calls has push-back.
const DOUBTFUL_PATIENCE: u32 = 100;

impl<'a, 'o> Progress<'a, 'o> {
    /// For eigenvalues with a lower bound.
    fn new(stop: Stop, smallest: f64, observer: &'a mut Observer<'o>) -> Self {
        let most = if smallest < 0.0 { DOUBTFUL_PATIENCE } else { u32::MAX };
        Self { stop, history: Vec::new(), observer, best: (f64::INFINITY, 0), most }
    }

    /// Takes the residual after so many updates. Breaks with the outcome when that was the last.
    fn take(&mut self, updates: u32, residual: Residual) -> Result<ControlFlow<Outcome>, Error> {
        let step = Step {
            updates,
            max: residual.max / self.stop.unit,
            mean: residual.mean / self.stop.unit,
        };
        if !step.max.is_finite() {
            return Err(Error::Overflow { largest: residual.max });
        }
        self.history.push(step);
        if (self.observer)(step).is_break() {
            return Err(Error::Interrupted);
        }
        if step.max < 0.5 * self.best.0 {
            self.best = (step.max, updates);
        }
        let patience = PATIENCE.iter().find(|p| step.max < p.0).map_or(0, |p| p.1).min(self.most);
        Ok(match self.stop.tolerance {
            Some(tolerance) if step.max <= tolerance => ControlFlow::Break(Outcome::Converged),
            None if updates >= self.stop.max_updates => ControlFlow::Break(Outcome::CountReached),
            Some(_) if updates >= self.stop.max_updates => {
                ControlFlow::Break(Outcome::TooManyUpdates)
            }
            Some(_) if updates - self.best.1 > patience => ControlFlow::Break(Outcome::Stalled),
            _ => ControlFlow::Continue(()),
        })
    }

    /// Updates needed when `k` of them leave `constant * contraction^k` of the first residual.
    fn predict(&self, constant: f64, contraction: f64) -> Option<u32> {
        let (tolerance, first) = (self.stop.tolerance?, self.history.first()?.max);
        if contraction >= 1.0 {
            return None;
        }
        if first <= tolerance {
            return Some(0);
        }
        let updates =
            libm::ceil(libm::log(tolerance / (constant * first)) / libm::log(contraction));
        // A float out of range is clamped by the cast.
        Some(updates as u32)
    }
}

/// Largest and mean length of the residual vectors.
#[derive(Clone, Copy, Debug)]
struct Residual {
    max: f64,
    mean: f64,
}

/// Largest length and sum of lengths over a block of rows.
#[derive(Clone, Copy, Default)]
struct Lengths {
    max: f64,
    sum: f64,
}

impl Lengths {
    #[inline]
    fn add(&mut self, residual: Vec3) {
        let length = residual.length();
        // `f64::max` would drop a NaN, and with it an overflow.
        if length > self.max || length.is_nan() {
            self.max = length;
        }
        self.sum += length;
    }

    /// The blocks taken together, in order.
    fn total(blocks: &[Self], count: usize) -> Residual {
        let mut total = Self::default();
        for block in blocks {
            if block.max > total.max || block.max.is_nan() {
                total.max = block.max;
            }
            total.sum += block.sum;
        }
        Residual { max: total.max, mean: total.sum / (count as f64).max(1.0) }
    }
}

/// The residual `target − B x` of every unknown.
fn residuals<A: LinearOperator>(
    operator: &A,
    target: &[Vec3],
    x: &[Vec3],
    out: &mut [Vec3],
) -> Residual {
    let blocks = par::for_blocks(out, |start, block| {
        let mut lengths = Lengths::default();
        for (i, slot) in block.iter_mut().enumerate() {
            *slot = target[start + i] - operator.row(start + i, x);
            lengths.add(*slot);
        }
        lengths
    });
    Lengths::total(&blocks, target.len())
}
