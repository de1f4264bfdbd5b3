//! Progressive interpolation, the front door: the control mesh whose limit surface passes through
//! every vertex.

use alloc::vec::Vec;
use core::fmt;
use core::ops::ControlFlow;
use core::str::FromStr;

use crate::error::Error;
use crate::ids::{NONE, VertexId};
use crate::limit::limit_points;
use crate::limit::operator::{CurveOperator, CurveRow, RingOperator};
use crate::mesh::Bounds;
use crate::rules::{BoundaryKinds, boundary_neighbours};
use crate::scheme::loop_scheme::{BoundaryKind, boundary_scale};
use crate::scheme::{Corners, Scheme};
use crate::solve::{Interval, LinearOperator, Outcome, Report, Step, Stop};
use crate::{Mesh, Topology, Vec3, order, par, solve};

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
}

impl Method {
    /// All methods.
    pub const ALL: [Self; 5] =
        [Self::Auto, Self::Plain, Self::Weighted, Self::Chebyshev, Self::ConjugateGradients];

    /// Its name on the command line and in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Plain => "plain",
            Self::Weighted => "weighted",
            Self::Chebyshev => "chebyshev",
            Self::ConjugateGradients => "cg",
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
    ($($type:ident: $names:literal),*) => {$(
        impl FromStr for $type {
            type Err = UnknownName;

            fn from_str(name: &str) -> Result<Self, UnknownName> {
                Self::ALL.into_iter().find(|one| one.name() == name).ok_or(UnknownName($names))
            }
        }
    )*};
}
from_name!(Method: "auto, plain, weighted, chebyshev, cg", Norm: "diagonal, longest-side, absolute");

/// None of the names there are, which it lists.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
#[error("expected one of: {0}")]
pub struct UnknownName(&'static str);

/// How to fit.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Options {
    /// The subdivision scheme whose limit surface interpolates.
    pub scheme: Scheme,
    /// What happens at corners of the boundary.
    pub corners: Corners,
    /// The solver.
    pub method: Method,
    /// Unit of the tolerance and of the residuals in the report.
    pub norm: Norm,
    /// Largest distance of a limit point from its vertex. With `None`, exactly
    /// [`iterations`](Self::iterations) updates are made per stage.
    pub tolerance: Option<f64>,
    /// Most updates per stage.
    pub iterations: u32,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            scheme: Scheme::default(),
            corners: Corners::default(),
            method: Method::default(),
            norm: Norm::default(),
            tolerance: Some(1e-6),
            iterations: 10_000,
        }
    }
}

impl Options {
    fn check(&self) -> Result<(), Error> {
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
    /// The boundary vertices, whose limit curves depend on nothing else.
    Boundary,
    /// The interior vertices, with the boundary known.
    Interior,
}

impl StageName {
    /// Its name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::Boundary => "boundary",
            Self::Interior => "interior",
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
/// use fairform::{interpolate, limit, shapes};
/// let target = shapes::icosahedron();
/// let options = interpolate::Options::default();
/// let (control, report) = interpolate::interpolate(&target, &options)?;
/// assert!(report.is_converged() && report.max <= 1e-6);
/// let surface = limit::limit_points(
///     control.topology(), control.positions(), options.scheme, options.corners,
/// )?;
/// assert!((surface[0] - target.positions()[0]).length() <= 1e-6 * target.bounds().diagonal());
/// # Ok::<(), fairform::Error>(())
/// ```
///
/// # Errors
/// [`Error::NoVertices`], [`Error::BadOption`], and as [`Scheme::check`]. Not converging is no
/// error: the report says so.
pub fn interpolate(target: &Mesh, options: &Options) -> Result<(Mesh, FitReport), Error> {
    let interpolator = Interpolator::new(target.topology(), options.scheme, options.corners)?;
    let mut ignore = |_, _| ControlFlow::Continue(());
    let (control, report) = interpolator.fit(target.positions(), options, &mut ignore)?;
    Ok((target.with_positions(control), report))
}

/// A topology made ready for fitting: as many sets of values per vertex as one likes, positions,
/// colours, frames of an animation.
#[derive(Clone, Debug)]
pub struct Interpolator<'t> {
    topology: &'t Topology,
    scheme: Scheme,
    corners: Corners,
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
    Curve(CurveOperator),
}

impl<'t> Interpolator<'t> {
    /// Prepares the limit operator of a topology.
    ///
    /// # Errors
    /// [`Error::NoVertices`], and as [`Scheme::check`].
    pub fn new(topology: &'t Topology, scheme: Scheme, corners: Corners) -> Result<Self, Error> {
        scheme.check(topology)?;
        if topology.vertex_count() == 0 {
            return Err(Error::NoVertices);
        }
        let kinds = BoundaryKinds { topology, corners };
        let (mut boundary, mut interior, mut known) = (Vec::new(), Vec::new(), Vec::new());
        for v in topology.vertices() {
            match kinds.of(v) {
                Some(BoundaryKind::Corner) => known.push(v.0),
                Some(_) => boundary.push(v.0),
                None if topology.is_isolated(v) => {}
                None => interior.push(v.0),
            }
        }
        let closed = boundary.is_empty() && known.is_empty();
        let mut stages = Vec::new();
        if !boundary.is_empty() {
            stages.push(boundary_stage(kinds, &boundary, &known));
        }
        if !interior.is_empty() {
            known.extend(boundary);
            known.sort_unstable();
            let name = if closed { StageName::Closed } else { StageName::Interior };
            stages.push(ring_stage(topology, name, interior, &known));
        }
        Ok(Self { topology, scheme, corners, stages })
    }

    /// The control values whose limit values are `target`, and what it took.
    ///
    /// Scheme and corners are those of [`new`](Self::new); the fields of `options` are not looked
    /// at for them.
    ///
    /// # Errors
    /// [`Error::BadOption`]; [`Error::Interrupted`] if the observer breaks. Not converging is no
    /// error: the report says so.
    ///
    /// # Panics
    /// If there is not one target per vertex, or one is not finite.
    pub fn fit(
        &self,
        target: &[Vec3],
        options: &Options,
        observer: &mut Observer<'_>,
    ) -> Result<(Vec<Vec3>, FitReport), Error> {
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

        let mut control = target.clone();
        let mut stages = Vec::new();
        for stage in &self.stages {
            let name = stage.name;
            let mut observe = |step| observer(name, step);
            let solve = stage.fit(&target, &mut control, options.method, stop, &mut observe)?;
            stages.push(StageReport { name, vertex_count: stage.unknown_count(), solve });
        }
        let (max, mean) = self.residual(&target, &control)?;
        let control = par::collect(control.len(), |v| ldexp(control[v], exponent));
        let (max, mean) = (max / unit, mean / unit);
        Ok((control, FitReport { stages, max, mean, unit: libm::ldexp(unit, exponent) }))
    }

    /// Largest and mean distance of the limit points from their targets.
    fn residual(&self, target: &[Vec3], control: &[Vec3]) -> Result<(f64, f64), Error> {
        let limit = limit_points(self.topology, control, self.scheme, self.corners)?;
        let blocks = par::blocks(limit.len(), |range| {
            range.fold((0.0_f64, 0.0, 0_usize), |(max, sum, count), v| {
                if self.topology.is_isolated(VertexId(v as u32)) {
                    return (max, sum, count);
                }
                let distance = (target[v] - limit[v]).length();
                (max.max(distance), sum + distance, count + 1)
            })
        });
        let (max, sum, count) =
            blocks.into_iter().fold((0.0_f64, 0.0, 0), |a, b| (a.0.max(b.0), a.1 + b.1, a.2 + b.2));
        Ok((max, sum / (count as f64).max(1.0)))
    }
}

/// The exponent of the power of two that is to be divided out, so that all is about one.
fn exponent(target: &[Vec3]) -> Result<i32, Error> {
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

fn ldexp(v: Vec3, exponent: i32) -> Vec3 {
    if exponent == 0 {
        return v;
    }
    Vec3::new(libm::ldexp(v.x, exponent), libm::ldexp(v.y, exponent), libm::ldexp(v.z, exponent))
}

impl Stage {
    fn unknown_count(&self) -> usize {
        match &self.operator {
            StageOperator::Ring(operator) => operator.unknown_count(),
            StageOperator::Curve(operator) => operator.unknown_count(),
        }
    }

    fn fit(
        &self,
        target: &[Vec3],
        control: &mut [Vec3],
        method: Method,
        stop: Stop,
        observer: &mut solve::Observer<'_>,
    ) -> Result<Report, Error> {
        let gather =
            |from: &[Vec3], count: usize| par::collect(count, |i| from[self.vertices[i] as usize]);
        let n = self.unknown_count();
        let goal = gather(target, n);
        let mut x = gather(control, self.vertices.len());
        let report = match &self.operator {
            StageOperator::Ring(operator) => run(operator, &goal, &mut x, method, stop, observer),
            StageOperator::Curve(operator) => run(operator, &goal, &mut x, method, stop, observer),
        }?;
        for (&v, &x) in self.vertices[..n].iter().zip(&x) {
            control[v as usize] = x;
        }
        Ok(report)
    }
}

fn run<A: LinearOperator>(
    operator: &A,
    target: &[Vec3],
    x: &mut Vec<Vec3>,
    method: Method,
    stop: Stop,
    observer: &mut solve::Observer<'_>,
) -> Result<Report, Error> {
    let guaranteed = operator.smallest_eigenvalue_bound();
    let interval = match method {
        Method::Auto => Interval::Hopeful { guaranteed },
        Method::Plain => Interval::Plain,
        Method::Weighted => Interval::Weighted { smallest: guaranteed },
        Method::Chebyshev => Interval::Chebyshev { smallest: guaranteed },
        Method::ConjugateGradients => {
            return solve::conjugate_gradients(operator, target, x, stop, observer);
        }
    };
    solve::stationary(operator, target, x, interval, stop, observer)
}

/// Numbers for some vertices from 0 up, in their order; [`NONE`] for all others.
fn numbering(vertex_count: usize, vertices: &[u32]) -> Vec<u32> {
    let mut local = alloc::vec![NONE; vertex_count];
    for (i, &v) in vertices.iter().enumerate() {
        local[v as usize] = i as u32;
    }
    local
}

fn boundary_stage(kinds: BoundaryKinds<'_>, boundary: &[u32], corners: &[u32]) -> Stage {
    let vertices = [boundary, corners].concat();
    let local = numbering(kinds.topology.vertex_count(), &vertices);
    let row = |&v: &u32| {
        let v = VertexId(v);
        let (left, right) = boundary_neighbours(kinds.topology, v);
        CurveRow {
            neighbours: [local[left.index()], local[right.index()]],
            weights: kinds.limit_weights(v),
            scale: boundary_scale(kinds.of(v).unwrap_or(BoundaryKind::Extraordinary)),
        }
    };
    let operator = CurveOperator { rows: boundary.iter().map(row).collect() };
    Stage { name: StageName::Boundary, operator: StageOperator::Curve(operator), vertices }
}

fn ring_stage(topology: &Topology, name: StageName, interior: Vec<u32>, known: &[u32]) -> Stage {
    let mut vertices = order::by_locality(topology, interior);
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
