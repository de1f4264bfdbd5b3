//! Fits in one pass over memory, and what is known of them.

use alloc::vec::Vec;

use super::{FitReport, Interpolator, Method, Observer, Options, Scaled, Solver, StageName};
use super::{StageReport, whole_bound};
use crate::Vec3;
use crate::error::Error;
use crate::limit::limit_points;
use crate::onepass::{self, Level, OnePass};
use crate::solve::{Interval, Outcome, Report, Step};

/// Most updates in one pass: with more, the halos of patches make more work than they save.
pub const MOST_STEPS: u32 = 32;

/// What is known of a fit in one pass, in the unit of its report.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Certificate {
    /// Updates made in the pass.
    pub steps: u32,
    /// A lower bound for the eigenvalues of the limit operator, from the valences; the upper bound is 1. Not
    /// positive where nothing is known.
    pub smallest_eigenvalue: f64,
    /// The largest distance of a limit point from its vertex before the first update.
    pub first: f64,
    /// What the updates leave of that by the bound, in the mean over all vertices that makes the operator
    /// symmetric; `None` where nothing is known.
    pub predicted: Option<f64>,
    /// What they left, measured.
    pub residual: f64,
}

impl Certificate {
    /// An upper bound for the condition number of the limit operator, if one is known.
    #[must_use]
    pub fn condition(&self) -> Option<f64> {
        (self.smallest_eigenvalue > 0.0).then(|| 1.0 / self.smallest_eigenvalue)
    }
}

/// What so many steps of Chebyshev's recurrence for eigenvalues from `usual` to 1 leave at most where the
/// smallest is `smallest`: $`T_k((\theta - \lambda)/\delta) / T_k(\theta/\delta)`$.
fn left_by(steps: u32, usual: f64, smallest: f64) -> f64 {
    let (theta, delta) = (f64::midpoint(1.0, usual), (1.0 - usual) / 2.0);
    if delta == 0.0 {
        return 0.0;
    }
    let polynomial = |x: f64| libm::cosh(f64::from(steps) * libm::acosh(x.max(1.0)));
    polynomial((theta - smallest) / delta) / polynomial(theta / delta)
}

impl Interpolator<'_> {
    pub(super) fn fit_in_one_pass(
        &self,
        scaled: Scaled,
        options: &Options,
        observer: &mut Observer<'_>,
    ) -> Result<(Vec<Vec3>, FitReport), Error> {
        let [guaranteed, usual] = whole_bound(self.topology, self.rules);
        let given = scaled.start.as_ref().unwrap_or(&scaled.target);
        let before = limit_points(self.topology, given, self.rules)?;
        let first = self.step(&scaled, &before, 0);
        if observer(StageName::Whole, first).is_break() {
            return Err(Error::Interrupted);
        }
        let needed = options.tolerance.map(|tolerance| updates(usual, tolerance, first.max));
        let steps = needed.unwrap_or(options.iterations).min(options.iterations).min(MOST_STEPS);
        let how = onepass::Options {
            steps: Some(steps),
            level: Level::Control,
            ..onepass::Options::default()
        };
        let (control, _) = OnePass::new(self.topology, self.rules, &how)?.fit(given)?;
        let limit = limit_points(self.topology, &control, self.rules)?;
        let last = self.step(&scaled, &limit, steps);
        if observer(StageName::Whole, last).is_break() {
            return Err(Error::Interrupted);
        }
        let certificate = Certificate {
            steps,
            smallest_eigenvalue: guaranteed,
            first: first.max,
            predicted: (guaranteed > 0.0)
                .then(|| first.max * left_by(steps, usual.max(guaranteed), guaranteed)),
            residual: last.max,
        };
        if options.tolerance.is_some_and(|tolerance| last.max > tolerance || last.max.is_nan()) {
            // From where the pass has come to, unless it went astray.
            let is_better = last.max < first.max;
            let start = if is_better { Some(control) } else { scaled.start.clone() };
            let scaled = Scaled { start, ..scaled };
            let solver = Solver::Method(Method::Auto);
            let (control, stages) = self.solve(&scaled, solver, scaled.stop, observer)?;
            let limit = limit_points(self.topology, &control, self.rules)?;
            let mut report = self.report(&scaled, &limit, stages);
            report.certificate = Some(certificate);
            return Ok((scaled.back(&control), report));
        }
        let outcome = match options.tolerance {
            Some(_) => Outcome::Converged,
            None => Outcome::CountReached,
        };
        let history = if steps == 0 { [first].into() } else { [first, last].into() };
        let solve = Report { history, outcome, predicted: needed };
        let mut report = self.report(&scaled, &limit, [self.whole_stage(solve)].into());
        report.certificate = Some(certificate);
        Ok((scaled.back(&control), report))
    }

    /// What was done for all vertices at once.
    pub(super) fn whole_stage(&self, solve: Report) -> StageReport {
        let vertex_count = self.topology.vertex_count() - self.topology.isolated_count();
        StageReport { name: StageName::Whole, vertex_count, solve }
    }

    fn step(&self, scaled: &Scaled, limit: &[Vec3], updates: u32) -> Step {
        let (max, mean) = self.residual(&scaled.target, limit);
        let unit = scaled.stop.unit;
        Step { updates, max: max / unit, mean: mean / unit }
    }
}

/// Updates after which so much is left at most of a residual.
fn updates(usual: f64, tolerance: f64, first: f64) -> u32 {
    if first <= tolerance {
        return 0;
    }
    let contraction = Interval::Chebyshev { smallest: usual }.contraction(usual);
    if contraction <= 0.0 {
        return 1;
    }
    // A float out of range is clamped by the cast.
    libm::ceil(libm::log(tolerance / (2.0 * first)) / libm::log(contraction)) as u32
}
