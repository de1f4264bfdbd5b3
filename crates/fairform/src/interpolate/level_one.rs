//! Fits that end one level down: push-back and fairing.

use alloc::sync::Arc;
use alloc::vec::Vec;

use super::{FitReport, Interpolator, MOST_STEPS, Method, Observer, Options, Scaled, Solver};
use super::{StageName, StageReport};
use crate::error::Error;
use crate::fair::{self, Fairing};
use crate::ids::VertexId;
use crate::onepass::{self, OnePass};
use crate::pushback::{PushBack, is_not_definite, singular_components};
use crate::solve::{Outcome, Report, Step, Stop};
use crate::{Mesh, Rules, Topology, Vec3};

/// Updates before a push-back. What they leave over moves the surface between the vertices by less
/// than one can see: its curvature energy is within a percent of that of the converged surface.
const UPDATES: u32 = 6;

/// Vertices from which on one pass over memory is faster than sweeps over the whole mesh, preparation
/// included.
const LARGE: usize = 20_000;

/// A residual, in the unit of the report, that only an iteration leaves that diverges.
const ASTRAY: f64 = 1.0;

/// A control mesh whose limit surface passes through the vertices of a target mesh.
#[derive(Clone, PartialEq, Debug)]
pub struct Fit {
    /// The control mesh, refined [`level`](Self::level) times from the connectivity of the target.
    /// Its first vertices are those of the target, except for Doo–Sabin at level 1, where
    /// [`PushBack::limit_stencils`] tells the limit points of the target's vertices.
    pub control: Mesh,
    /// The rules with which to refine the control mesh further.
    pub rules: Rules,
    /// 0, or 1 after a push-back.
    pub level: u32,
    /// What it took.
    pub report: FitReport,
    /// One vertex of each connected component that no control mesh of level 0 interpolates, see
    /// [`singular_components`].
    pub singular: Vec<VertexId>,
}

/// The control mesh whose limit surface passes through every vertex of `target`: by solving, if that
/// is enough, otherwise by solving a little and then pushing back. That is where the limit operator is
/// known to be singular or not definite, and where a solve diverges or comes to rest before it is done (the observer then sees the
/// stages begin anew).
///
/// ```
/// use core::ops::ControlFlow;
/// use fairform::{Rules, Scheme, interpolate, shapes};
/// // No control cube has the alternately dented cube as its Catmull–Clark limit.
/// let cube = shapes::cube();
/// let dent = |(i, &p): (usize, &fairform::Vec3)| if i == 0 { 0.2 * p + p } else { p };
/// let dented = cube.with_positions(cube.positions().iter().enumerate().map(dent).collect());
/// let mut go_on = |_, _| ControlFlow::Continue(());
/// let options = interpolate::Options::default();
/// let rules = Rules::from(Scheme::CatmullClark);
/// let fit = interpolate::fit_mesh(&dented, &rules, &options, &mut go_on)?;
/// assert_eq!((fit.level, fit.singular.len()), (1, 1));
/// assert!(fit.report.max < 1e-15);
/// # Ok::<(), fairform::Error>(())
/// ```
///
/// # Errors
/// As [`Interpolator::new`], [`Interpolator::fit`] and [`PushBack::new`].
pub fn fit_mesh(
    target: &Mesh,
    rules: &Rules,
    options: &Options,
    observer: &mut Observer<'_>,
) -> Result<Fit, Error> {
    let topology = target.topology();
    let unprepared = Interpolator::unprepared(topology, rules)?;
    let singular = singular_components(topology, rules);
    let is_hopeless = is_not_definite(topology, rules);
    let mut interpolator = None;
    if !is_hopeless && !options.exact && options.fair.is_none() {
        let interpolator =
            interpolator.insert(Interpolator::near(topology, rules, target.positions())?);
        match interpolator.fit(target.positions(), options, observer) {
            Ok((control, report)) if !is_stuck(&report) => {
                let control = target.with_positions(control);
                return Ok(Fit { control, rules: rules.clone(), level: 0, report, singular });
            }
            // The iteration diverged; targets that are too large are seen again below.
            Ok(_) | Err(Error::Overflow { .. } | Error::NotDefinite) => {}
            Err(other) => return Err(other),
        }
    }
    let pushback = PushBack::new(topology, rules)?;
    let positions = Some(target.positions());
    let mut exact = ExactFit { unprepared, pushback, positions, interpolator, one_pass: None };
    let (control, report) = exact.fit(target.positions(), options, observer)?;
    let step = exact.pushback.into_step();
    let control = Mesh::from_parts(Arc::new(step.topology), control);
    Ok(Fit { control, rules: step.next, level: 1, report, singular })
}

/// Whether a stage came to rest far from the limits of rounding, as it may where the limit operator is
/// nearly singular or, beside inner vertices with two faces, not definite.
fn is_stuck(report: &FitReport) -> bool {
    let stalled = report.stages.iter().any(|s| s.solve.outcome == Outcome::Stalled);
    stalled && report.max > ROUNDING
}

/// Residual, in the unit of the report, that a stalled solve may well leave.
const ROUNDING: f64 = 1e-10;

/// What comes of a solve, a refinement and a push-back.
struct Passed {
    finer: Vec<Vec3>,
    pushed_back: f64,
    stages: Vec<StageReport>,
}

/// A topology made ready for fits one level down: as many sets of values per vertex as one likes,
/// positions, colours, frames of an animation. What a fit needs is prepared when it is first asked for, and
/// kept.
///
/// ```
/// use core::ops::ControlFlow;
/// use fairform::{Rules, interpolate, shapes};
/// let target = shapes::torus(20, 30);
/// let mut exact = interpolate::ExactFit::near(target.topology(), &Rules::LOOP, target.positions())?;
/// for frame in 0..3 {
///     let points: Vec<_> = target.positions().iter().map(|&p| f64::from(1 + frame) * p).collect();
///     let mut go_on = |_, _| ControlFlow::Continue(());
///     let (finer, report) = exact.fit(&points, &interpolate::Options::default(), &mut go_on)?;
///     assert_eq!(finer.len(), exact.pushback().step().topology.vertex_count());
///     assert!(report.max < 1e-13);
/// }
/// # Ok::<(), fairform::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct ExactFit<'t> {
    unprepared: Interpolator<'t>,
    pushback: PushBack<'t>,
    positions: Option<&'t [Vec3]>,
    interpolator: Option<Interpolator<'t>>,
    one_pass: Option<Prepared<'t>>,
}

/// Patches for some number of steps; none where they do not pay.
#[derive(Clone, Debug)]
struct Prepared<'t> {
    steps: u32,
    one_pass: Option<OnePass<'t>>,
}

impl<'t> ExactFit<'t> {
    /// Refines a topology once.
    ///
    /// # Errors
    /// As [`Interpolator::new`] and [`PushBack::new`].
    pub fn new(topology: &'t Topology, rules: &'t Rules) -> Result<Self, Error> {
        let unprepared = Interpolator::unprepared(topology, rules)?;
        let pushback = PushBack::new(topology, rules)?;
        Ok(Self { unprepared, pushback, positions: None, interpolator: None, one_pass: None })
    }

    /// As [`new`](Self::new), prepared as [`Interpolator::near`] and [`OnePass::near`] are.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    ///
    /// # Panics
    /// If there is not one position per vertex.
    pub fn near(
        topology: &'t Topology,
        rules: &'t Rules,
        positions: &'t [Vec3],
    ) -> Result<Self, Error> {
        assert_eq!(positions.len(), topology.vertex_count(), "one position per vertex");
        Ok(Self { positions: Some(positions), ..Self::new(topology, rules)? })
    }

    /// The push-back, with the refinement step.
    #[must_use]
    pub fn pushback(&self) -> &PushBack<'t> {
        &self.pushback
    }

    /// The values on the mesh refined once whose limit values at the vertices are `target` up to rounding,
    /// see [`Interpolator::fit_exactly`].
    ///
    /// # Errors
    /// As [`Interpolator::fit`].
    ///
    /// # Panics
    /// As [`Interpolator::fit`].
    pub fn fit(
        &mut self,
        target: &[Vec3],
        options: &Options,
        observer: &mut Observer<'_>,
    ) -> Result<(Vec<Vec3>, FitReport), Error> {
        let of = &self.unprepared;
        let scaled = of.scaled(target, options)?;
        let passed = match of.is_for_one_pass(options) {
            true => of.pass(&scaled, options, self.positions, &mut self.one_pass, observer)?,
            false => None,
        };
        let passed = if let Some(passed) = passed {
            passed
        } else {
            let interpolator = match self.interpolator.take() {
                Some(interpolator) => interpolator,
                None => Interpolator::prepare(of.topology, of.rules, self.positions)?,
            };
            self.interpolator.insert(interpolator).sweep(
                &scaled,
                &self.pushback,
                options,
                observer,
            )?
        };
        of.finish(&scaled, passed, &self.pushback, options, observer)
    }
}

impl<'t> Interpolator<'t> {
    /// The values on the mesh refined once, by `pushback` of the same topology and rules, whose limit
    /// values at the vertices are `target` up to rounding. [`ExactFit`] keeps what it prepares for many of
    /// them.
    ///
    /// The solve before the push-back makes six updates of Chebyshev's recurrence, after which nobody
    /// sees a difference; or exactly [`Options::iterations`] if there is no tolerance. On large meshes and
    /// with [`Method::OnePass`], which makes at most [`MOST_STEPS`] updates, all is done in one pass, see
    /// [`crate::onepass`]. With other methods it runs as [`fit`](Self::fit) does, except where the limit operator
    /// is known to be singular or not definite, since it would not end, or if it diverges.
    ///
    /// # Errors
    /// As [`fit`](Self::fit).
    ///
    /// # Panics
    /// As [`fit`](Self::fit); if `pushback` is of another topology.
    pub fn fit_exactly(
        &self,
        pushback: &PushBack<'_>,
        target: &[Vec3],
        options: &Options,
        observer: &mut Observer<'_>,
    ) -> Result<(Vec<Vec3>, FitReport), Error> {
        if self.is_for_one_pass(options) {
            let scaled = self.scaled(target, options)?;
            if let Some(passed) = self.pass(&scaled, options, None, &mut None, observer)? {
                return self.finish(&scaled, passed, pushback, options, observer);
            }
        }
        self.sweep_exactly(pushback, target, options, observer)
    }

    /// [`fit_exactly`](Self::fit_exactly) in sweeps over the whole mesh.
    pub(crate) fn sweep_exactly(
        &self,
        pushback: &PushBack<'_>,
        target: &[Vec3],
        options: &Options,
        observer: &mut Observer<'_>,
    ) -> Result<(Vec<Vec3>, FitReport), Error> {
        let scaled = self.scaled(target, options)?;
        let passed = self.sweep(&scaled, pushback, options, observer)?;
        self.finish(&scaled, passed, pushback, options, observer)
    }

    fn is_for_one_pass(&self, options: &Options) -> bool {
        let is_large = self.topology.vertex_count() >= LARGE;
        let is_wanted =
            options.method == Method::OnePass || options.method == Method::Auto && is_large;
        is_wanted && !self.rules.scheme.is_interpolating()
    }

    /// Solve, refinement and push-back, one after the other.
    fn sweep(
        &self,
        scaled: &Scaled,
        pushback: &PushBack<'_>,
        options: &Options,
        observer: &mut Observer<'_>,
    ) -> Result<Passed, Error> {
        let is_hopeless = is_not_definite(self.topology, self.rules);
        let few = Stop {
            tolerance: None,
            max_updates: match options.tolerance {
                Some(_) => UPDATES.min(options.iterations),
                None => options.iterations,
            },
            ..scaled.stop
        };
        let (control, stages) = self.solve_first(scaled, options, few, is_hopeless, observer)?;
        let mut finer = pushback.step().apply(&control);
        let pushed_back = pushback.correct(&scaled.target, &mut finer);
        Ok(Passed { finer, pushed_back, stages })
    }

    /// Fairing and a report.
    fn finish(
        &self,
        scaled: &Scaled,
        Passed { mut finer, pushed_back, stages }: Passed,
        pushback: &PushBack<'_>,
        options: &Options,
        observer: &mut Observer<'_>,
    ) -> Result<(Vec<Vec3>, FitReport), Error> {
        let mut fairing = None;
        if let Some(weight) = options.fair {
            let unit = scaled.stop.unit;
            let mut observe = |step: Step| {
                let (max, mean) = (step.max / unit, step.mean / unit);
                observer(StageName::Fairing, Step { max, mean, ..step })
            };
            let done = fair::fair(pushback, &mut finer, weight, options.energy, &mut observe)?;
            // Twice, since the square of a small unit may be zero.
            let [before, after] = [done.before, done.after].map(|energy| energy / unit / unit);
            fairing = Some(Fairing { before, after, ..done });
            // Fairing keeps the limit points up to rounding; this rounds once, not in every update.
            pushback.correct(&scaled.target, &mut finer);
        }
        let mut report = self.report(scaled, &pushback.limit_points(&finer), stages);
        report.pushed_back = Some(pushed_back / scaled.stop.unit);
        report.fairing = fairing;
        Ok((scaled.back(&finer), report))
    }

    /// The solve before a push-back.
    fn solve_first(
        &self,
        scaled: &Scaled,
        options: &Options,
        few: Stop,
        is_hopeless: bool,
        observer: &mut Observer<'_>,
    ) -> Result<(Vec<Vec3>, Vec<StageReport>), Error> {
        let is_usual = matches!(options.method, Method::Auto | Method::OnePass) || is_hopeless;
        let solved = if is_usual {
            self.solve(scaled, Solver::Usual, few, observer)
        } else {
            self.solve(scaled, Solver::Method(options.method), scaled.stop, observer)
        };
        match solved {
            // The iteration diverged; a few updates cannot.
            Err(Error::Overflow { .. } | Error::NotDefinite) => {
                let few = Stop { max_updates: UPDATES, ..few };
                self.solve(scaled, Solver::Usual, few, observer)
            }
            other => other,
        }
    }

    /// Solve, refinement and push-back in one pass, if the topology can be cut into patches: the finer
    /// values, how far they were pushed, and a report.
    fn pass(
        &self,
        scaled: &Scaled,
        options: &Options,
        positions: Option<&[Vec3]>,
        prepared: &mut Option<Prepared<'t>>,
        observer: &mut Observer<'_>,
    ) -> Result<Option<Passed>, Error> {
        let is_hopeless = is_not_definite(self.topology, self.rules);
        let unit = scaled.stop.unit;
        let given = scaled.start.as_ref().unwrap_or(&scaled.target);
        let few = onepass::usual_steps(self.rules.scheme);
        let wanted = if options.tolerance.is_some() { few } else { MOST_STEPS };
        let mut steps = options.iterations.min(if is_hopeless { few } else { wanted });
        loop {
            let ready = match prepared.take() {
                Some(ready) if ready.steps == steps => ready,
                _ => {
                    let how =
                        onepass::Options { steps: Some(steps), ..onepass::Options::default() };
                    let (topology, rules) = (self.topology, self.rules);
                    let one_pass = OnePass::patched(topology, rules, &how, positions)?;
                    Prepared { steps, one_pass }
                }
            };
            let Some(one_pass) = &prepared.insert(ready).one_pass else { return Ok(None) };
            let (finer, onepass::Summary { largest, mean }) = one_pass.fit(given)?;
            if (largest > ASTRAY * unit || largest.is_nan()) && steps > few {
                // The iteration diverged; a few updates cannot.
                steps = few;
                continue;
            }
            let step = Step { updates: steps, max: largest / unit, mean: mean / unit };
            if observer(StageName::Whole, step).is_break() {
                return Err(Error::Interrupted);
            }
            let solve =
                Report { history: [step].into(), outcome: Outcome::CountReached, predicted: None };
            let stages = [self.whole_stage(solve)].into();
            return Ok(Some(Passed { finer, pushed_back: largest, stages }));
        }
    }
}
