//! Progressive interpolation, the front door: the control mesh whose limit surface passes through
//! every vertex.

use alloc::vec::Vec;
use core::fmt;
use core::ops::ControlFlow;
use core::str::FromStr;

use crate::crease::Kind;
use crate::error::Error;
use crate::fair::{Energy, Fairing};
use crate::ids::{NONE, VertexId};
use crate::limit::operator::{RingOperator, RowOperator};
use crate::limit::{self, LimitRows, limit_points};
use crate::mesh::Bounds;
use crate::refine::DooSabinRows;
use crate::rows::Rows as _;
use crate::rules::BoundaryKinds;
use crate::scheme::loop_scheme::{BoundaryKind, boundary_scale};
use crate::scheme::{Border, Rules, Scheme, catmull_clark, doo_sabin, loop_scheme};
use crate::solve::{Interval, LinearOperator, Outcome, Report, Step, Stop};
use crate::tension::Shares;
use crate::{Mesh, Topology, Vec3, order, par, rows, solve};

#[cfg(not(feature = "direct"))]
use crate::solve::LinearOperator as Operator;
#[cfg(feature = "direct")]
use crate::solve::direct::Entries as Operator;

mod level_one;
mod one_pass;

pub use level_one::{ExactFit, Fit, fit_mesh};
pub use one_pass::{Certificate, MOST_STEPS};

/// How control points are found. All methods have the same answer.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Method {
    /// The fastest that is safe on any mesh: Chebyshev for the spectrum that meshes have in
    /// practice, falling back to the guaranteed bounds where that turns out too hopeful.
    #[default]
    Auto,
    /// Progressive interpolation as published. \[ChengEtAl2009\]
    Plain,
    /// Progressive interpolation with the best constant weight.
    Weighted,
    /// Chebyshev's recurrence for the spectrum that the valences guarantee.
    Chebyshev,
    /// Conjugate gradients.
    ConjugateGradients,
    /// Factorising, with the feature `direct`.
    #[cfg(feature = "direct")]
    Direct,
    /// Chebyshev's recurrence patch by patch, in one pass over memory, for the spectrum that meshes have
    /// in practice, see [`crate::onepass`]; then [`Auto`](Self::Auto) from there, if the
    /// tolerance was missed. Makes at most [`MOST_STEPS`] updates.
    OnePass,
}

impl Method {
    /// All methods.
    pub const ALL: [Self; 6 + cfg!(feature = "direct") as usize] = [
        Self::Auto,
        Self::Plain,
        Self::Weighted,
        Self::Chebyshev,
        Self::ConjugateGradients,
        #[cfg(feature = "direct")]
        Self::Direct,
        Self::OnePass,
    ];

    /// Whether it needs a symmetric operator, see [`Error::NotSymmetric`].
    fn is_for_symmetric(self) -> bool {
        match self {
            Self::ConjugateGradients => true,
            #[cfg(feature = "direct")]
            Self::Direct => true,
            _ => false,
        }
    }

    /// Its name on the command line and in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Plain => "plain",
            Self::Weighted => "weighted",
            Self::Chebyshev => "chebyshev",
            Self::ConjugateGradients => "cg",
            #[cfg(feature = "direct")]
            Self::Direct => "direct",
            Self::OnePass => "one-pass",
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// What residuals are measured against.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Norm {
    /// The diagonal of the bounding box of the target mesh.
    #[default]
    Diagonal,
    /// The longest side of the bounding box.
    LongestSide,
    /// The units of the coordinates.
    Absolute,
}

impl Norm {
    /// All norms.
    pub const ALL: [Self; 3] = [Self::Diagonal, Self::LongestSide, Self::Absolute];

    /// Its name on the command line and in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Diagonal => "diagonal",
            Self::LongestSide => "longest-side",
            Self::Absolute => "absolute",
        }
    }

    /// The length that residuals are divided by; 1 where the box has no size.
    #[must_use]
    pub fn unit(self, bounds: &Bounds) -> f64 {
        let unit = match self {
            Self::Diagonal => bounds.diagonal(),
            Self::LongestSide => bounds.longest_side(),
            Self::Absolute => 1.0,
        };
        if unit > 0.0 { unit } else { 1.0 }
    }
}

impl fmt::Display for Norm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

macro_rules! from_name {
    ($($type:ident: $names:expr),*) => {$(
        impl FromStr for $type {
            type Err = UnknownName;

            fn from_str(name: &str) -> Result<Self, UnknownName> {
                Self::ALL.into_iter().find(|one| one.name() == name).ok_or(UnknownName($names))
            }
        }
    )*};
}
#[cfg(not(feature = "direct"))]
const METHODS: &str = "auto, plain, weighted, chebyshev, cg, one-pass";
#[cfg(feature = "direct")]
const METHODS: &str = "auto, plain, weighted, chebyshev, cg, direct, one-pass";

from_name!(Method: METHODS, Norm: "diagonal, longest-side, absolute");

/// None of the names there are, which it lists.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("expected one of: {0}")]
pub struct UnknownName(&'static str);

/// How to fit.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Options {
    /// The solver.
    pub method: Method,
    /// Unit of the tolerance and of the residuals in the report.
    pub norm: Norm,
    /// Largest distance of a limit point from its vertex. With `None`, exactly
    /// [`iterations`](Self::iterations) updates are made per stage.
    pub tolerance: Option<f64>,
    /// Most updates per stage.
    pub iterations: u32,
    /// Whether [`fit_mesh`] is to end with a push-back, see [`pushback`](crate::pushback), which makes
    /// the interpolation exact up to rounding and the control mesh one level finer. Where nothing else
    /// interpolates it does so anyway.
    pub exact: bool,
    /// How fair [`fit_mesh`] is to make the surface, from 0 (the plain interpolant) to 1 (the
    /// fairest), see [`fair`](crate::fair). Implies [`exact`](Self::exact).
    pub fair: Option<f64>,
    /// What [`fair`](Self::fair) minimises.
    pub energy: Energy,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            method: Method::default(),
            norm: Norm::default(),
            tolerance: Some(1e-6),
            iterations: 10_000,
            exact: false,
            fair: None,
            energy: Energy::default(),
        }
    }
}

impl Options {
    fn check(&self) -> Result<(), Error> {
        if let Some(value) = self.fair.filter(|weight| !(0.0..=1.0).contains(weight)) {
            let (what, expected) = ("the fairness", "between 0 and 1");
            return Err(Error::BadOption { what, expected, value });
        }
        self.energy.check()?;
        match self.tolerance {
            Some(value) if !(value > 0.0 && value.is_finite()) => Err(Error::BadOption {
                what: "the tolerance",
                expected: "a positive finite number",
                value,
            }),
            _ => Ok(()),
        }
    }
}

/// Which vertices a stage solves for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum StageName {
    /// All vertices of a mesh without boundary.
    Closed,
    /// The vertices on the boundary, and on creases that run from corner to corner or around: their
    /// limit curves depend on nothing else.
    Boundary,
    /// All others, with the boundary known.
    Interior,
    /// All vertices at once, whatever they lie on.
    Whole,
    /// Fairing, which comes last and is no stage of a report. Its errors are about how far points still
    /// have to go.
    Fairing,
}

impl StageName {
    /// Its name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::Boundary => "boundary",
            Self::Interior => "interior",
            Self::Whole => "whole",
            Self::Fairing => "fairing",
        }
    }
}

impl fmt::Display for StageName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// What one stage did.
#[derive(Clone, PartialEq, Debug)]
pub struct StageReport {
    /// Which vertices it solved for.
    pub name: StageName,
    /// How many they are.
    pub vertex_count: usize,
    /// What the solver says.
    pub solve: Report,
}

/// What a fit did.
#[derive(Clone, PartialEq, Debug)]
pub struct FitReport {
    /// The stages in order.
    pub stages: Vec<StageReport>,
    /// Largest distance of a limit point from its vertex, in the chosen norm, measured on the
    /// result. Isolated vertices do not count.
    pub max: f64,
    /// Mean distance.
    pub mean: f64,
    /// What distances were divided by.
    pub unit: f64,
    /// Largest distance, in the chosen norm, that the push-back had to move a limit point after the
    /// stages were done; `None` if there was none. [`max`](Self::max) is what is left after it.
    pub pushed_back: Option<f64>,
    /// What fairing did, if it was asked for. Its energies are in units of [`unit`](Self::unit) squared.
    pub fairing: Option<Fairing>,
    /// What is known of a fit in one pass, before and after it.
    pub certificate: Option<Certificate>,
}

impl FitReport {
    /// Whether no stage missed its tolerance.
    #[must_use]
    pub fn is_converged(&self) -> bool {
        self.stages
            .iter()
            .all(|s| matches!(s.solve.outcome, Outcome::Converged | Outcome::CountReached))
    }
}

/// Told every step of every stage; breaks to stop the fit.
pub type Observer<'a> = dyn FnMut(StageName, Step) -> ControlFlow<()> + 'a;

/// The control mesh whose limit surface passes through every vertex of `target`.
///
/// ```
/// use fairform::{Rules, interpolate, limit, shapes};
/// let target = shapes::icosahedron();
/// let options = interpolate::Options::default();
/// let (control, report) = interpolate::interpolate(&target, &Rules::LOOP, &options)?;
/// assert!(report.is_converged() && report.max <= 1e-6);
/// let surface = limit::limit_points(control.topology(), control.positions(), &Rules::LOOP)?;
/// assert!((surface[0] - target.positions()[0]).length() <= 1e-6 * target.bounds().diagonal());
/// # Ok::<(), fairform::Error>(())
/// ```
///
/// # Errors
/// As [`Interpolator::new`] and [`Interpolator::fit`]. Not converging is no error: the report says
/// so.
pub fn interpolate(
    target: &Mesh,
    rules: &Rules,
    options: &Options,
) -> Result<(Mesh, FitReport), Error> {
    let interpolator = Interpolator::near(target.topology(), rules, target.positions())?;
    let mut ignore = |_, _| ControlFlow::Continue(());
    let (control, report) = interpolator.fit(target.positions(), options, &mut ignore)?;
    Ok((target.with_positions(control), report))
}

/// A topology made ready for fitting: as many sets of values per vertex as one likes, positions,
/// colours, frames of an animation.
#[derive(Clone, Debug)]
pub struct Interpolator<'t> {
    topology: &'t Topology,
    rules: &'t Rules,
    stages: Vec<Stage>,
}

#[derive(Clone, Debug)]
struct Stage {
    name: StageName,
    operator: StageOperator,
    /// The vertices of the unknowns, and then those of the known values that the rows need.
    vertices: Vec<u32>,
}

#[derive(Clone, Debug)]
enum StageOperator {
    Ring(RingOperator),
    Rows(RowOperator),
}

impl<'t> Interpolator<'t> {
    /// Prepares the limit operator of a topology. For an interpolating scheme there is nothing to
    /// solve: no stages, and the control values are the targets.
    ///
    /// # Errors
    /// [`Error::NoVertices`]; as [`limit_points`].
    pub fn new(topology: &'t Topology, rules: &'t Rules) -> Result<Self, Error> {
        Self::prepare(topology, rules, None)
    }

    /// As [`new`](Self::new); where numbers of neighbours are far apart, the unknowns lie in memory as
    /// `positions` lie in space, which is faster to find out than by asking the topology. The control
    /// values are the same.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    ///
    /// # Panics
    /// If there is not one position per vertex.
    pub fn near(
        topology: &'t Topology,
        rules: &'t Rules,
        positions: &[Vec3],
    ) -> Result<Self, Error> {
        assert_eq!(positions.len(), topology.vertex_count(), "one position per vertex");
        Self::prepare(topology, rules, Some(positions))
    }

    /// [`new`](Self::new), or [`near`](Self::near) positions.
    pub(crate) fn prepare(
        topology: &'t Topology,
        rules: &'t Rules,
        positions: Option<&[Vec3]>,
    ) -> Result<Self, Error> {
        let unprepared = Self::unprepared(topology, rules)?;
        if rules.scheme.is_interpolating() {
            return Ok(unprepared);
        }
        let parts = Parts::new(topology, rules);
        let closed = parts.curves.is_empty() && parts.known.is_empty();
        let mut stages = Vec::new();
        if !parts.curves.is_empty() {
            let bound = curve_bound(topology, rules);
            let vertices = [parts.curves.as_slice(), &parts.known].concat();
            let count = parts.curves.len();
            stages.push(row_stage(topology, rules, StageName::Boundary, vertices, count, bound));
        }
        if !parts.others.is_empty() {
            let name = if closed { StageName::Closed } else { StageName::Interior };
            let mut known = [parts.known, parts.curves].concat();
            known.sort_unstable();
            stages.push(
                if rules.scheme == Scheme::Loop
                    && rules.creases.is_none()
                    && rules.tension.is_none()
                {
                    let vertices = order::by_locality(topology, parts.others, positions);
                    ring_stage(topology, name, vertices, &known)
                } else {
                    let bound = interior_bound(topology, rules, &parts.others);
                    let mut vertices = order::by_locality(topology, parts.others, positions);
                    let count = vertices.len();
                    vertices.extend(known);
                    row_stage(topology, rules, name, vertices, count, bound)
                },
            );
        }
        Ok(Self { topology, rules, stages })
    }

    /// Without stages: what fits in one pass do with.
    fn unprepared(topology: &'t Topology, rules: &'t Rules) -> Result<Self, Error> {
        limit::check(topology, rules)?;
        if topology.vertex_count() == 0 {
            return Err(Error::NoVertices);
        }
        Ok(Self { topology, rules, stages: Vec::new() })
    }

    /// The stages in order: which vertices, how many, and a lower bound for the eigenvalues of the
    /// limit operator among them, of which the upper bound is 1. Where the bound is not positive,
    /// nothing is known.
    pub fn stages(&self) -> impl Iterator<Item = (StageName, usize, f64)> {
        self.stages.iter().map(|stage| {
            let bound = match &stage.operator {
                StageOperator::Ring(operator) => operator.smallest_eigenvalue_bound(),
                StageOperator::Rows(operator) => operator.smallest_eigenvalue_bound(),
            };
            (stage.name, stage.unknown_count(), bound)
        })
    }

    /// The control values whose limit values are `target`, and what it took.
    ///
    /// # Errors
    /// [`Error::BadOption`]; [`Error::NotSymmetric`] for conjugate gradients and factorising beside
    /// creases that end or fade, and on boundaries of Loop's scheme in two phases where shape parameters
    /// differ; [`Error::NotDefinite`] and [`Error::FactorTooLarge`] for factorising; [`Error::Interrupted`] if the observer breaks. Not converging is no error: the
    /// report says so.
    ///
    /// # Panics
    /// If there is not one target per vertex, or one is not finite.
    pub fn fit(
        &self,
        target: &[Vec3],
        options: &Options,
        observer: &mut Observer<'_>,
    ) -> Result<(Vec<Vec3>, FitReport), Error> {
        let scaled = self.scaled(target, options)?;
        if options.method == Method::OnePass && !self.stages.is_empty() {
            return self.fit_in_one_pass(scaled, options, observer);
        }
        let solver = Solver::Method(options.method);
        let (control, stages) = self.solve(&scaled, solver, scaled.stop, observer)?;
        let limit = limit_points(self.topology, &control, self.rules)?;
        let report = self.report(&scaled, &limit, stages);
        Ok((scaled.back(&control), report))
    }

    /// The control values that [`fit`](Self::fit) has after so many updates, counted through all stages:
    /// those it begins with after none, its result if it makes no more. Of [`Method::OnePass`] those of
    /// [`Method::Auto`].
    ///
    /// # Errors
    /// As [`fit`](Self::fit).
    ///
    /// # Panics
    /// As [`fit`](Self::fit).
    pub fn after(
        &self,
        target: &[Vec3],
        options: &Options,
        mut updates: u32,
    ) -> Result<Vec<Vec3>, Error> {
        let scaled = self.scaled(target, options)?;
        let mut control = scaled.start.as_ref().unwrap_or(&scaled.target).clone();
        let solver = Solver::Method(options.method);
        for stage in &self.stages {
            let stop = Stop { max_updates: scaled.stop.max_updates.min(updates), ..scaled.stop };
            let mut go_on = |_| ControlFlow::Continue(());
            let report = stage.fit(&scaled.target, &mut control, solver, stop, &mut go_on)?;
            updates -= report.last().updates;
        }
        Ok(scaled.back(&control))
    }

    fn scaled(&self, target: &[Vec3], options: &Options) -> Result<Scaled, Error> {
        options.check()?;
        assert_eq!(target.len(), self.topology.vertex_count(), "one target per vertex");
        // A power of two: scaling loses nothing, and no square can over- or underflow after it.
        let exponent = exponent(target)?;
        let target: Vec<Vec3> = par::collect(target.len(), |v| ldexp(target[v], -exponent));
        let used = self.topology.vertices().filter(|&v| !self.topology.is_isolated(v));
        let bounds = Bounds::of(used.map(|v| target[v.index()]));
        let unit = match options.norm {
            Norm::Absolute => libm::ldexp(1.0, -exponent),
            norm => norm.unit(&bounds),
        };
        let stop = Stop { tolerance: options.tolerance, unit, max_updates: options.iterations };
        if self.rules.border != Border::None {
            return Ok(Scaled { start: None, target, exponent, stop });
        }
        // Support is to stay as given: its limit points, which depend on the boundary alone, then are
        // what the given points make of it.
        let start = target;
        let rows = LimitRows::new(self.topology, self.rules);
        let target = par::collect(start.len(), |v| {
            if !self.rules.is_support(self.topology, VertexId(v as u32)) {
                return start[v];
            }
            let mut sum = Vec3::ZERO;
            rows.visit(v, |q, weight| sum += weight * start[q as usize]);
            sum
        });
        Ok(Scaled { start: Some(start), target, exponent, stop })
    }

    /// Control values for scaled targets, all stages one after the other.
    fn solve(
        &self,
        scaled: &Scaled,
        solver: Solver,
        stop: Stop,
        observer: &mut Observer<'_>,
    ) -> Result<(Vec<Vec3>, Vec<StageReport>), Error> {
        let mut control = scaled.start.as_ref().unwrap_or(&scaled.target).clone();
        let mut stages = Vec::new();
        for stage in &self.stages {
            let name = stage.name;
            let mut observe = |step| observer(name, step);
            let solve = stage.fit(&scaled.target, &mut control, solver, stop, &mut observe)?;
            stages.push(StageReport { name, vertex_count: stage.unknown_count(), solve });
        }
        Ok((control, stages))
    }

    /// What a fit did whose limit points, scaled, are `limit`.
    fn report(&self, scaled: &Scaled, limit: &[Vec3], stages: Vec<StageReport>) -> FitReport {
        let (max, mean) = self.residual(&scaled.target, limit);
        let unit = scaled.stop.unit;
        FitReport {
            stages,
            max: max / unit,
            mean: mean / unit,
            unit: libm::ldexp(unit, scaled.exponent),
            pushed_back: None,
            fairing: None,
            certificate: None,
        }
    }

    /// Largest and mean distance of the limit points from their targets.
    fn residual(&self, target: &[Vec3], limit: &[Vec3]) -> (f64, f64) {
        let blocks = par::blocks(limit.len(), |range| {
            range.fold((0.0_f64, 0.0, 0_usize), |(max, sum, count), v| {
                let id = VertexId(v as u32);
                if self.topology.is_isolated(id) || self.rules.is_support(self.topology, id) {
                    return (max, sum, count);
                }
                let distance = (target[v] - limit[v]).length();
                (max.max(distance), sum + distance, count + 1)
            })
        });
        let (max, sum, count) =
            blocks.into_iter().fold((0.0_f64, 0.0, 0), |a, b| (a.0.max(b.0), a.1 + b.1, a.2 + b.2));
        (max, sum / (count as f64).max(1.0))
    }
}

/// Targets divided by a power of two, and when to stop in that scale.
struct Scaled {
    /// The given values, if some of them are support.
    start: Option<Vec<Vec3>>,
    /// The limit values to reach.
    target: Vec<Vec3>,
    exponent: i32,
    stop: Stop,
}

impl Scaled {
    /// Values in the scale of the mesh.
    fn back(&self, values: &[Vec3]) -> Vec<Vec3> {
        par::collect(values.len(), |v| ldexp(values[v], self.exponent))
    }
}

/// How a stage is solved.
#[derive(Clone, Copy)]
enum Solver {
    Method(Method),
    /// Chebyshev for the spectrum that meshes have in practice, come what may.
    Usual,
}

/// The exponent of the power of two that is to be divided out, so that all is about one.
pub(crate) fn exponent(target: &[Vec3]) -> Result<i32, Error> {
    let blocks = par::blocks(target.len(), |range| {
        range.fold(0.0_f64, |largest, v| {
            assert!(target[v].is_finite(), "target {v} is finite");
            largest.max(target[v].max_abs())
        })
    });
    let largest = blocks.into_iter().fold(0.0, f64::max);
    if largest > f64::MAX / 1024.0 {
        // The control points are up to some ten times as far out as the targets.
        return Err(Error::Overflow { largest });
    }
    Ok(if largest == 0.0 { 0 } else { libm::ilogb(largest) })
}

pub(crate) fn ldexp(v: Vec3, exponent: i32) -> Vec3 {
    if exponent == 0 {
        return v;
    }
    Vec3::new(libm::ldexp(v.x, exponent), libm::ldexp(v.y, exponent), libm::ldexp(v.z, exponent))
}

impl Stage {
    fn unknown_count(&self) -> usize {
        match &self.operator {
            StageOperator::Ring(operator) => operator.unknown_count(),
            StageOperator::Rows(operator) => operator.unknown_count(),
        }
    }

    fn fit(
        &self,
        target: &[Vec3],
        control: &mut [Vec3],
        solver: Solver,
        stop: Stop,
        observer: &mut solve::Observer<'_>,
    ) -> Result<Report, Error> {
        let gather =
            |from: &[Vec3], count: usize| par::collect(count, |i| from[self.vertices[i] as usize]);
        let n = self.unknown_count();
        let goal = gather(target, n);
        let mut x = gather(control, self.vertices.len());
        let report = match &self.operator {
            StageOperator::Ring(operator) => run(operator, &goal, &mut x, solver, stop, observer),
            StageOperator::Rows(operator) => {
                let is_picky = matches!(solver, Solver::Method(m) if m.is_for_symmetric());
                if is_picky && !operator.is_symmetric() {
                    return Err(Error::NotSymmetric);
                }
                run(operator, &goal, &mut x, solver, stop, observer)
            }
        }?;
        for (&v, &x) in self.vertices[..n].iter().zip(&x) {
            control[v as usize] = x;
        }
        Ok(report)
    }
}

fn run<A: Operator>(
    operator: &A,
    target: &[Vec3],
    x: &mut Vec<Vec3>,
    solver: Solver,
    stop: Stop,
    observer: &mut solve::Observer<'_>,
) -> Result<Report, Error> {
    let usual = operator.usual_smallest_eigenvalue();
    // Where nothing is guaranteed, the process still converges, only nobody knows how fast.
    let guaranteed = operator.smallest_eigenvalue_bound().max(LEAST);
    let Solver::Method(method) = solver else {
        let interval = Interval::Chebyshev { smallest: usual };
        return solve::stationary(operator, target, x, interval, stop, observer);
    };
    let interval = match method {
        Method::Auto | Method::OnePass => Interval::Hopeful { usual, guaranteed },
        Method::Plain => Interval::Plain,
        Method::Weighted => Interval::Weighted { smallest: guaranteed },
        Method::Chebyshev => Interval::Chebyshev { smallest: guaranteed },
        Method::ConjugateGradients => {
            return solve::conjugate_gradients(operator, target, x, stop, observer);
        }
        #[cfg(feature = "direct")]
        Method::Direct => return solve::direct::direct(operator, target, x, stop, observer),
    };
    solve::stationary(operator, target, x, interval, stop, observer)
}

/// Lower end of a spectrum of which only its sign is known.
pub(crate) const LEAST: f64 = 0.01;

/// Numbers for some vertices from 0 up, in their order; [`NONE`] for all others.
fn numbering(vertex_count: usize, vertices: &[u32]) -> Vec<u32> {
    let mut local = alloc::vec![NONE; vertex_count];
    for (i, &v) in vertices.iter().enumerate() {
        local[v as usize] = i as u32;
    }
    local
}

/// Which vertices are known from the start, which lie on curves that depend on nothing else, and the
/// others. Isolated vertices are none of them.
struct Parts {
    known: Vec<u32>,
    curves: Vec<u32>,
    others: Vec<u32>,
}

impl Parts {
    fn new(topology: &Topology, rules: &Rules) -> Self {
        let (mut known, mut curves, mut others) = (Vec::new(), Vec::new(), Vec::new());
        if rules.creases.is_none() {
            let sharp = rules.sharpness(topology);
            for v in topology.vertices().filter(|&v| !topology.is_isolated(v)) {
                let is_known = rules.scheme != Scheme::DooSabin
                    && (sharp.vertex(v) > 0.0 || rules.is_support(topology, v));
                let list = match topology.is_boundary(v) {
                    true if is_known => &mut known,
                    true => &mut curves,
                    false => &mut others,
                };
                list.push(v.0);
            }
            return Self { known, curves, others };
        }
        // Where a crease ends, its curve depends on the surface: such curves are no stage of their
        // own. Drop vertices whose rows reach beyond, until none does.
        let rows = LimitRows::new(topology, rules);
        let row = |v: u32| {
            let mut row = Vec::new();
            rows::gather(&rows, v as usize, &mut row);
            row
        };
        let mut on_curve = alloc::vec![false; topology.vertex_count()];
        let sharp = rules.sharpness(topology);
        for v in topology.vertices() {
            on_curve[v.index()] =
                !topology.is_isolated(v) && row(v.0).len() <= 3 && sharp.kind(v, 0) != Kind::Smooth;
        }
        let is_support = |v: VertexId| rules.is_support(topology, v);
        loop {
            let outside = |v: &VertexId| {
                on_curve[v.index()]
                    && !is_support(*v)
                    && row(v.0).iter().any(|e| !on_curve[e.0 as usize])
            };
            let dropped: Vec<VertexId> = topology.vertices().filter(outside).collect();
            if dropped.is_empty() {
                break;
            }
            dropped.iter().for_each(|v| on_curve[v.index()] = false);
        }
        for v in topology.vertices().filter(|&v| !topology.is_isolated(v)) {
            let list = match on_curve[v.index()] {
                _ if is_support(v) => &mut known,
                true if row(v.0).len() == 1 => &mut known,
                true => &mut curves,
                false => &mut others,
            };
            list.push(v.0);
        }
        Self { known, curves, others }
    }
}

/// Lower bounds of the spectrum: what is guaranteed, and what meshes have in practice.
#[derive(Clone, Copy)]
struct Bound {
    guaranteed: f64,
    usual: f64,
}

/// Lower bounds for the eigenvalues of the limit operator on all vertices at once, guaranteed (not positive
/// where nothing is known) and usual: the operator is block triangular, so its spectrum is that of the stages.
pub(crate) fn whole_bound(topology: &Topology, rules: &Rules) -> [f64; 2] {
    if rules.creases.is_none() && rules.tension.is_none() {
        return plain_bound(topology, rules);
    }
    let parts = Parts::new(topology, rules);
    bound_of(topology, rules, !parts.curves.is_empty(), &parts.others)
}

/// [`whole_bound`] without creases and shape parameters, where one vertex tells of all: an inner one with
/// the fewest faces.
fn plain_bound(topology: &Topology, rules: &Rules) -> [f64; 2] {
    let sharp = rules.sharpness(topology);
    let blocks = par::blocks(topology.vertex_count(), |range| {
        let (mut has_curves, mut fewest) = (false, None);
        for v in range.map(|v| VertexId(v as u32)).filter(|&v| !topology.is_isolated(v)) {
            if !topology.is_boundary(v) {
                let fan = (topology.fan_size(v), v.0);
                fewest = Some(fewest.map_or(fan, |fewest: (u32, u32)| fewest.min(fan)));
            } else if !has_curves {
                has_curves = rules.scheme == Scheme::DooSabin
                    || sharp.vertex(v) == 0.0 && !rules.is_support(topology, v);
            }
        }
        (has_curves, fewest)
    });
    let has_curves = blocks.iter().any(|block| block.0);
    let fewest = blocks.into_iter().filter_map(|block| block.1).min();
    let others: Vec<u32> = fewest.into_iter().map(|(_, v)| v).collect();
    bound_of(topology, rules, has_curves, &others)
}

/// [`whole_bound`] of some vertices only, without asking which of them make stages of their own.
pub(crate) fn bound_among(topology: &Topology, rules: &Rules, vertices: &[u32]) -> [f64; 2] {
    let used = vertices.iter().copied().filter(|&v| !topology.is_isolated(VertexId(v)));
    let (curves, others): (Vec<u32>, Vec<u32>) =
        used.partition(|&v| topology.is_boundary(VertexId(v)));
    bound_of(topology, rules, !curves.is_empty(), &others)
}

fn bound_of(topology: &Topology, rules: &Rules, has_curves: bool, others: &[u32]) -> [f64; 2] {
    let curves = has_curves.then(|| curve_bound(topology, rules));
    let others = (!others.is_empty()).then(|| interior_bound(topology, rules, others));
    let mut whole = [1.0_f64; 2];
    for bound in curves.into_iter().chain(others) {
        let usual = bound.usual.max(bound.guaranteed);
        whole = [whole[0].min(bound.guaranteed), whole[1].min(usual)];
    }
    whole
}

fn curve_bound(topology: &Topology, rules: &Rules) -> Bound {
    let guaranteed = match (rules.scheme, &rules.tension) {
        (Scheme::Loop, None) => loop_scheme::BOUNDARY_SMALLEST_EIGENVALUE,
        (Scheme::CatmullClark, None) => catmull_clark::CURVE_SMALLEST_EIGENVALUE,
        (Scheme::Loop, Some(_)) => {
            let largest = largest_share(topology, rules);
            // What an even loop of extraordinary vertices has at one share for all.
            return Bound { guaranteed: 0.6 - 0.4 * largest, usual: 0.6 - 0.3 * largest };
        }
        (Scheme::CatmullClark, Some(_)) => (2.0 - largest_share(topology, rules)) / 3.0,
        // Nothing is solved for: all vertices are known.
        (Scheme::Butterfly | Scheme::Kobbelt, _) => 1.0,
        (Scheme::DooSabin, None) => doo_sabin::CHAIKIN,
        (Scheme::DooSabin, Some(_)) => {
            let images = DooSabinRows::new(topology, rules);
            // The mean of the parameters of the two edges.
            let mean = |v: VertexId| {
                let first = topology.outgoing(v)?;
                let last = topology.fan(v).last()?;
                let (a, b) = (first, topology.prev(last));
                Some(f64::midpoint(images.edge_parameter(a), images.edge_parameter(b)))
            };
            let boundary = topology.vertices().filter(|&v| topology.is_boundary(v));
            boundary.filter_map(mean).fold(1.0, f64::min)
        }
    };
    Bound { guaranteed, usual: guaranteed }
}

fn interior_bound(topology: &Topology, rules: &Rules, vertices: &[u32]) -> Bound {
    let fans = || vertices.iter().map(|&v| topology.fan_size(VertexId(v)));
    let smallest = fans().min().unwrap_or(6);
    match (rules.scheme, &rules.tension) {
        // Beside creases the bounds of the smooth rules hold in practice.
        (Scheme::Loop, None) => Bound {
            guaranteed: loop_scheme::smallest_eigenvalue_bound(smallest.max(2)),
            usual: LOOP_USUAL,
        },
        (Scheme::CatmullClark, None) => Bound {
            guaranteed: catmull_clark::smallest_eigenvalue_bound(smallest),
            usual: CATMULL_CLARK_USUAL,
        },
        (Scheme::Loop, Some(_)) => {
            let bound = |n: u32, share| loop_scheme::two_phase_eigenvalue_bound(n.max(2), share);
            two_phase_bound(topology, rules, vertices, LOOP_USUAL, bound)
        }
        (Scheme::CatmullClark, Some(_)) => {
            let bound = catmull_clark::two_phase_eigenvalue_bound;
            two_phase_bound(topology, rules, vertices, CATMULL_CLARK_USUAL, bound)
        }
        (Scheme::Butterfly | Scheme::Kobbelt, _) => Bound { guaranteed: 1.0, usual: 1.0 },
        (Scheme::DooSabin, None) => {
            let guaranteed = doo_sabin::SMALLEST_EIGENVALUE;
            Bound { guaranteed, usual: guaranteed }
        }
        (Scheme::DooSabin, Some(tension)) => {
            let mean = |&v: &u32| {
                let faces = topology.fan(VertexId(v)).map(|h| tension[topology.face(h).index()]);
                faces.sum::<f64>() / f64::from(topology.fan_size(VertexId(v)))
            };
            let guaranteed = vertices.iter().map(mean).fold(1.0, f64::min);
            Bound { guaranteed, usual: guaranteed }
        }
    }
}

/// Lower ends of the spectrum that meshes have in practice, of interior vertices.
const LOOP_USUAL: f64 = 0.2;
const CATMULL_CLARK_USUAL: f64 = 0.1;

/// The largest share of the plain scheme in two phases.
fn largest_share(topology: &Topology, rules: &Rules) -> f64 {
    rules.shares(topology).map_or(1.0, Shares::largest)
}

/// The bounds in two phases, from that of one vertex by its valence and the share of the plain scheme.
fn two_phase_bound(
    topology: &Topology,
    rules: &Rules,
    vertices: &[u32],
    usual: f64,
    bound: impl Fn(u32, f64) -> f64,
) -> Bound {
    let smallest = |share: &dyn Fn(VertexId, u32) -> f64| {
        let one = |&v: &u32| {
            let v = VertexId(v);
            let n = topology.fan_size(v);
            bound(n, share(v, n))
        };
        vertices.iter().map(one).fold(1.0, f64::min)
    };
    let shares = rules.shares(topology);
    let mean = |v, n| shares.map_or(1.0, |s| s.around(v) / f64::from(n));
    // The smallest eigenvalue falls with every share, and is concave: at one share for all it is not
    // below what lies between the plain scheme and linear subdivision.
    let largest = largest_share(topology, rules);
    let usual = largest * usual + (1.0 - largest) * smallest(&|_, _| 0.0);
    Bound { guaranteed: smallest(&mean), usual }
}

/// A stage on the limit rows as they are, of the first `count` of `vertices`; the others are known.
fn row_stage(
    topology: &Topology,
    rules: &Rules,
    name: StageName,
    vertices: Vec<u32>,
    count: usize,
    bound: Bound,
) -> Stage {
    let local = numbering(topology.vertex_count(), &vertices);
    let rows = LimitRows::new(topology, rules);
    let kinds = BoundaryKinds { topology, corners: rules.corners };
    let scale = |v: VertexId| match (rules.scheme, name) {
        (Scheme::Loop, StageName::Boundary) => {
            boundary_scale(kinds.of(v).unwrap_or(BoundaryKind::Extraordinary))
        }
        (Scheme::Loop, _) if !topology.is_boundary(v) => {
            let n = topology.fan_size(v).max(2);
            (1.0 - loop_scheme::limit_weight(n)) / f64::from(n)
        }
        (Scheme::CatmullClark, StageName::Closed | StageName::Interior) => {
            let n = f64::from(topology.fan_size(v));
            1.0 / (n * (n + 5.0))
        }
        (Scheme::DooSabin, StageName::Closed | StageName::Interior) => {
            1.0 / f64::from(topology.fan_size(v))
        }
        _ => 1.0,
    };
    let row = |i: usize, entries: &mut Vec<(u32, f64)>| {
        rows::gather(&rows, vertices[i] as usize, entries);
    };
    let scales = vertices[..count].iter().map(|&v| scale(VertexId(v))).collect();
    let mut operator = RowOperator::new(count, row, &local, scales, bound.guaranteed, bound.usual);
    if rules.scheme == Scheme::Loop && rules.tension.is_some() && name == StageName::Boundary {
        operator.find_scale();
    }
    Stage { name, operator: StageOperator::Rows(operator), vertices }
}

fn ring_stage(
    topology: &Topology,
    name: StageName,
    mut vertices: Vec<u32>,
    known: &[u32],
) -> Stage {
    let n = vertices.len();
    vertices.extend(known);
    let local = numbering(topology.vertex_count(), &vertices);
    let mut start = Vec::with_capacity(n + 1);
    let mut end = 0;
    start.push(end);
    for &v in &vertices[..n] {
        end += topology.fan_size(VertexId(v));
        start.push(end);
    }
    let mut neighbour = alloc::vec![0; end as usize];
    let mut nothing = alloc::vec![(); end as usize];
    par::fill_row_blocks(&start, &mut neighbour, &mut nothing, &|rows, block, _: &mut [()]| {
        topology.rings(vertices[rows].iter().map(|&v| VertexId(v)), block);
        for q in block {
            *q = local[*q as usize];
        }
    });
    let operator = StageOperator::Ring(RingOperator::new(start, neighbour));
    Stage { name, operator, vertices }
}
