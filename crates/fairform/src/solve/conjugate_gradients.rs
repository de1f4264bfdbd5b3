//! Conjugate gradients on the symmetrised system, with the diagonal as preconditioner.

use core::ops::ControlFlow;

use super::{Lengths, LinearOperator, Observer, Progress, Report, Stop, residuals};
use crate::error::Error;
use crate::{Vec3, par};

/// Solves `B x = target` from the start values in `x`: unknowns first, then known values, which
/// stay.
///
/// Works on $`S x = D^{-1} p`$ preconditioned by $`D`$: the preconditioned residual is the error
/// vector itself, and the first direction is the progressive update. The three coordinates run
/// separately. Needs no bound of the spectrum. \[HestenesStiefel1952\]
///
/// # Errors
/// [`Error::Interrupted`], [`Error::Overflow`].
///
/// # Panics
/// If there is not one target per unknown.
pub fn conjugate_gradients<A: LinearOperator>(
    operator: &A,
    target: &[Vec3],
    x: &mut [Vec3],
    stop: Stop,
    observer: &mut Observer<'_>,
) -> Result<Report, Error> {
    let n = operator.unknown_count();
    assert_eq!(target.len(), n, "one target per unknown");
    let mut progress = Progress::new(stop, operator.smallest_eigenvalue_bound(), observer);
    let mut error = alloc::vec![Vec3::ZERO; n];
    let mut image = alloc::vec![Vec3::ZERO; n];
    // The direction has no part in the known values.
    let mut direction = alloc::vec![Vec3::ZERO; x.len()];
    let mut updates = 0;
    let mut residual = residuals(operator, target, x, &mut error);
    let mut energy = Vec3::ZERO;
    let outcome = loop {
        if let ControlFlow::Break(outcome) = progress.take(updates, residual)? {
            break outcome;
        }
        let before = energy;
        energy = scaled_dot(operator, &error, &error);
        let beta = quotient(energy, before);
        par::for_blocks(&mut direction[..n], |start, block| {
            for (i, p) in block.iter_mut().enumerate() {
                *p = error[start + i] + beta.scale(*p);
            }
        });
        par::fill(&mut image, |i| operator.row(i, &direction));
        let alpha = quotient(energy, scaled_dot(operator, &direction, &image));
        par::for_blocks(&mut x[..n], |start, block| {
            for (i, x) in block.iter_mut().enumerate() {
                *x += alpha.scale(direction[start + i]);
            }
        });
        let blocks = par::for_blocks(&mut error, |start, block| {
            let mut lengths = Lengths::default();
            for (i, z) in block.iter_mut().enumerate() {
                *z -= alpha.scale(image[start + i]);
                lengths.add(*z);
            }
            lengths
        });
        residual = Lengths::total(&blocks, n);
        updates += 1;
        let met = stop.tolerance.is_some_and(|tolerance| residual.max / stop.unit <= tolerance);
        if met || updates % RENEW == 0 {
            // The recurrence drifts from the truth by rounding; what is reported is the truth.
            residual = residuals(operator, target, x, &mut error);
            energy = Vec3::ZERO;
        }
    };
    let root = libm::sqrt(operator.smallest_eigenvalue_bound());
    let predicted = progress.predict(2.0, (1.0 - root) / (1.0 + root));
    Ok(Report { history: progress.history, outcome, predicted })
}

/// Updates after which the residual is computed afresh, and the directions start anew.
const RENEW: u32 = 50;

/// $`\sum_i a_i b_i / d_i`$ for each coordinate, block by block in order.
fn scaled_dot<A: LinearOperator>(operator: &A, a: &[Vec3], b: &[Vec3]) -> Vec3 {
    let blocks = par::blocks(operator.unknown_count(), |range| {
        range.map(|i| a[i].scale(b[i]) / operator.scale(i)).sum::<Vec3>()
    });
    blocks.into_iter().sum()
}

/// Coordinate-wise quotient; zero where the divisor is zero, since a coordinate that has nothing
/// left to solve must rest.
fn quotient(a: Vec3, b: Vec3) -> Vec3 {
    let one = |a: f64, b: f64| if b == 0.0 { 0.0 } else { a / b };
    Vec3::new(one(a.x, b.x), one(a.y, b.y), one(a.z, b.z))
}
