//! Progressive interpolation and what grows out of it: the methods whose every update is
//! $`s_k = a_k s_{k-1} + b_k (p - B x_k),\; x_{k+1} = x_k + s_k`$ with numbers $`a_k, b_k`$ known
//! beforehand.

use alloc::vec::Vec;
use core::ops::ControlFlow;

use super::{Lengths, LinearOperator, Observer, Progress, Report, Stop};
use crate::error::Error;
use crate::{Vec3, par};

/// The part of the spectrum that an update is made for.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Interval {
    /// The process as published: $`x_{k+1} = x_k + (p - B x_k)`$. \[ChengEtAl2009\]
    Plain,
    /// The best constant weight $`2/(\lambda_{\min} + 1)`$ for eigenvalues in $`[\lambda_{\min}, 1]`$.
    Weighted {
        /// Lower end.
        smallest: f64,
    },
    /// Chebyshev's three-term recurrence for eigenvalues in $`[\lambda_{\min}, 1]`$. It converges
    /// for eigenvalues below the lower end too, only more slowly. \[Saad2003, algorithm 12.1\]
    Chebyshev {
        /// Lower end.
        smallest: f64,
    },
    /// Chebyshev for the eigenvalues that meshes have in practice, begun anew with a lower end that is
    /// farther down whenever the residual does not fall as hoped.
    Hopeful {
        /// Lower end to begin with.
        usual: f64,
        /// Lower end beyond which nothing is to be found.
        guaranteed: f64,
    },
}

impl Interval {
    /// What stands before the powers of the contraction: 2 for Chebyshev polynomials.
    fn constant(self) -> f64 {
        match self {
            Self::Plain | Self::Weighted { .. } => 1.0,
            Self::Chebyshev { .. } | Self::Hopeful { .. } => 2.0,
        }
    }

    /// The factor by which an update shrinks the residual in the long run.
    #[must_use]
    pub fn contraction(self, smallest: f64) -> f64 {
        match self {
            Self::Plain => 1.0 - smallest,
            Self::Weighted { smallest } => (1.0 - smallest) / (1.0 + smallest),
            Self::Hopeful { usual, .. } => {
                Self::Chebyshev { smallest: usual }.contraction(smallest)
            }
            Self::Chebyshev { smallest } => {
                let root = libm::sqrt(smallest);
                (1.0 - root) / (1.0 + root)
            }
        }
    }
}

/// The numbers $`(a_k, b_k)`$ of the updates.
struct Coefficients {
    interval: Interval,
    /// Chebyshev's $`\rho_k`$, once there is one.
    rho: Option<f64>,
    /// Largest residuals since the recurrence began.
    seen: Vec<f64>,
}

impl Coefficients {
    fn new(interval: Interval) -> Self {
        Self { interval, rho: None, seen: Vec::new() }
    }

    /// The numbers for the next update, after a largest residual was seen.
    fn next(&mut self, residual: f64) -> (f64, f64) {
        if let Interval::Hopeful { usual, guaranteed } = self.interval {
            self.seen.push(residual);
            if guaranteed < usual && self.is_disappointing(usual) {
                let usual = guaranteed.max(usual / 4.0);
                self.interval = Interval::Hopeful { usual, guaranteed };
                self.rho = None;
                self.seen.clear();
            }
        }
        match self.interval {
            Interval::Plain => (0.0, 1.0),
            Interval::Weighted { smallest } => (0.0, 2.0 / (1.0 + smallest)),
            Interval::Chebyshev { smallest } => self.chebyshev(smallest),
            Interval::Hopeful { usual, .. } => self.chebyshev(usual),
        }
    }

    fn chebyshev(&mut self, smallest: f64) -> (f64, f64) {
        let (theta, delta) = (f64::midpoint(1.0, smallest), (1.0 - smallest) / 2.0);
        if delta == 0.0 {
            return (0.0, 1.0 / theta);
        }
        let sigma = theta / delta;
        let Some(before) = self.rho else {
            self.rho = Some(1.0 / sigma);
            return (0.0, 1.0 / theta);
        };
        let now = 1.0 / (2.0 * sigma - before);
        self.rho = Some(now);
        (now * before, 2.0 * now / delta)
    }

    /// Whether the residual fell, over the last half of the updates, by less than the square root of
    /// what the interval promises.
    fn is_disappointing(&self, smallest: f64) -> bool {
        let contraction = Interval::Chebyshev { smallest }.contraction(smallest);
        // Enough updates for a promise of at least a factor of 100.
        let needed = libm::ceil(libm::log(0.01) / libm::log(contraction)) as usize;
        let Some(before) = self.seen.len().checked_sub(needed + 1) else { return false };
        if before < 2 {
            return false;
        }
        self.seen[self.seen.len() - 1] > 0.1 * self.seen[before]
    }
}

/// The first numbers $`(a_k, b_k)`$ of Chebyshev's recurrence for eigenvalues from `smallest` to 1.
pub(crate) fn chebyshev_steps(smallest: f64, count: u32) -> Vec<(f64, f64)> {
    let mut coefficients = Coefficients::new(Interval::Chebyshev { smallest });
    (0..count).map(|_| coefficients.next(0.0)).collect()
}

/// Solves `B x = target` from the start values in `x`: unknowns first, then known values, which
/// stay. One pass over memory per update.
///
/// # Errors
/// [`Error::Interrupted`], [`Error::Overflow`].
///
/// # Panics
/// If there is not one target per unknown.
pub fn stationary<A: LinearOperator>(
    operator: &A,
    target: &[Vec3],
    x: &mut Vec<Vec3>,
    interval: Interval,
    stop: Stop,
    observer: &mut Observer<'_>,
) -> Result<Report, Error> {
    let n = operator.unknown_count();
    assert_eq!(target.len(), n, "one target per unknown");
    let mut progress = Progress::new(stop, operator.smallest_eigenvalue_bound(), observer);
    let mut update = alloc::vec![Vec3::ZERO; n];
    let mut next = x.clone();
    let mut updates = 0;
    let mut coefficients = Coefficients::new(interval);
    let mut residual = f64::INFINITY;
    loop {
        let (a, b) = coefficients.next(residual);
        // One pass: residual of x, its size, the update, and x after it into the other array.
        let now: &[Vec3] = x;
        let blocks = par::for_blocks2(&mut update, &mut next[..n], |start, update, next| {
            let mut lengths = Lengths::default();
            for (i, (s, out)) in update.iter_mut().zip(next).enumerate() {
                let row = start + i;
                let residual = target[row] - operator.row(row, now);
                lengths.add(residual);
                *s = a * *s + b * residual;
                *out = now[row] + *s;
            }
            lengths
        });
        let total = Lengths::total(&blocks, n);
        if let ControlFlow::Break(outcome) = progress.take(updates, total)? {
            let contraction = interval.contraction(operator.smallest_eigenvalue_bound());
            let predicted = progress.predict(interval.constant(), contraction);
            return Ok(Report { history: progress.history, outcome, predicted });
        }
        core::mem::swap(x, &mut next);
        residual = total.max;
        updates += 1;
    }
}
