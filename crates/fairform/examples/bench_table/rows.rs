//! What is measured, and the bytes that each step cannot do without.
//!
//! On a closed triangle mesh of V vertices there are about 3 V edges, 2 V faces and 6 V half-edges.
//! Bytes are per vertex: every array that the step takes is read once, every array that it makes is
//! written once, as if caches were perfect. What it makes is new memory, which costs more.

use std::ops::ControlFlow;

use fairform::interpolate::{FitReport, Interpolator, Method, Options};
use fairform::onepass::{self, Level, OnePass};
use fairform::{Rules, Topology, Vec3, limit, refine};

use crate::Samples;
use crate::meshes::Subject;

/// A position or another triple.
const POINT: f64 = 24.0;
/// One index per half-edge.
const PER_HALFEDGE: f64 = 6.0 * 4.0;
/// One index per edge.
const PER_EDGE: f64 = 3.0 * 4.0;
/// One index per vertex.
const INDEX: f64 = 4.0;
/// Origins, twins and edges of half-edges; a half-edge per edge; a half-edge and a fan per vertex.
const TOPOLOGY: f64 = 3.0 * PER_HALFEDGE + PER_EDGE + 2.0 * INDEX;
/// What walking around vertices takes: origins, twins; a half-edge and a fan per vertex.
const RINGS: f64 = 2.0 * PER_HALFEDGE + 2.0 * INDEX;
/// The limit operator: where rows begin, and the neighbours.
const OPERATOR: f64 = INDEX + PER_HALFEDGE;

/// Patches with halos, as [`OnePass::patch_bytes`] tells.
const PATCHES: f64 = 47.0;

/// One line of the table, for one mesh and one number of threads.
#[derive(Clone)]
pub(crate) struct Row {
    pub(crate) what: What,
    pub(crate) samples: Samples,
    /// Updates made by a fit.
    pub(crate) updates: u32,
}

/// What is timed.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum What {
    Topology,
    Refine,
    Limit,
    Normals,
    Prepare,
    /// Cutting into patches for exact fits.
    PreparePass,
    /// An exact fit in one pass, into new memory or into memory that there is.
    ExactFit {
        is_new: bool,
    },
    /// A fit of level 0 in one pass, into memory that there is.
    ControlFit,
    /// Fitting to the usual tolerance, prepared already.
    Fit(Method),
    /// From a list of faces and their vertices: topology, preparation and a fit to the usual tolerance, or an
    /// exact one in one pass.
    FromArrays(Option<Method>),
    /// So many updates: the difference of two counts has no set-up in it.
    Updates(Method, u32),
}

/// The counts whose difference makes the time of an update.
pub(crate) const COUNTS: [u32; 2] = [2, 8];

/// The methods with updates of their own; the others make those of the first with other numbers.
pub(crate) const UPDATES: [Method; 2] = [Method::Auto, Method::ConjugateGradients];

/// Steps that bring the targets, noise of a tenth of an edge, to 1e-6 of the diagonal on the largest mesh.
const CONTROL_STEPS: u32 = 13;

/// Bytes per vertex that are taken or changed, and that are made anew.
#[derive(Clone, Copy)]
pub(crate) struct Bytes {
    pub(crate) moved: f64,
    pub(crate) new: f64,
}

impl Bytes {
    fn plus(self, other: Self) -> Self {
        Self { moved: self.moved + other.moved, new: self.new + other.new }
    }
}

/// All lines for a mesh, not measured yet.
pub(crate) fn all(subject: &Subject) -> Vec<Row> {
    let steps = [
        What::Topology,
        What::Refine,
        What::Limit,
        What::Normals,
        What::Prepare,
        What::PreparePass,
        What::ExactFit { is_new: true },
        What::ExactFit { is_new: false },
        What::ControlFit,
    ];
    let updates = UPDATES.into_iter().flat_map(|m| COUNTS.map(|count| What::Updates(m, count)));
    // The order of memory is the same to all methods, and the worst one takes long.
    let methods = if subject.name == "shuffled" { &Method::ALL[..1] } else { &Method::ALL };
    // Factors of large meshes do not fit into memory.
    let is_small = |method: &Method| method.name() != "direct" || subject.target.len() < 200_000;
    let fits = methods.iter().copied().filter(is_small).map(What::Fit);
    let compared = [Method::Plain, Method::ConjugateGradients, Method::Auto].map(Some);
    let from_arrays = [None].into_iter().chain(compared).map(What::FromArrays);
    steps
        .into_iter()
        .chain(updates)
        .chain(fits)
        .chain(from_arrays)
        .map(|what| Row { what, samples: Samples::default(), updates: 0 })
        .collect()
}

/// Measures every line once more.
pub(crate) fn measure(subject: &mut Subject, rows: &mut [Row]) {
    let (topology, points) = (subject.mesh.topology(), subject.mesh.positions());
    let prepare = || Interpolator::new(topology, &Rules::LOOP).expect("triangles");
    let prepared = prepare();
    let cut = |options: &onepass::Options| {
        OnePass::near(topology, &Rules::LOOP, options, points).expect("triangles")
    };
    let exact = onepass::Options::default();
    let control = onepass::Options { steps: Some(CONTROL_STEPS), level: Level::Control, ..exact };
    for Row { what, samples, updates } in rows {
        match *what {
            What::Topology => {
                let built = samples.time(|| Topology::from_faces(points.len(), &subject.faces));
                assert!(built.is_ok_and(|built| built == **topology), "the same mesh");
            }
            What::Refine => {
                samples.time(|| {
                    let step = refine::refine(topology, &Rules::LOOP).expect("triangles");
                    let points = step.apply(points);
                    (step.topology, points)
                });
            }
            What::Limit => {
                let limit = || limit::limit_points(topology, points, &Rules::LOOP);
                samples.time(limit).expect("triangles");
            }
            What::Normals => {
                let normals = || limit::limit_normals(topology, points, &Rules::LOOP);
                samples.time(normals).expect("triangles");
            }
            What::Prepare => {
                samples.time(prepare);
            }
            What::PreparePass => {
                samples.time(|| cut(&exact));
            }
            What::ExactFit { is_new: true } => {
                let pass = cut(&exact);
                samples.time(|| pass.fit(&subject.target)).expect("ordinary coordinates");
            }
            What::ExactFit { is_new: false } | What::ControlFit => {
                let pass = cut(if *what == What::ControlFit { &control } else { &exact });
                let mut out = vec![Vec3::splat(1.0); pass.result_count()];
                let summary = samples.time(|| pass.fit_into(&subject.target, &mut out));
                let largest = summary.expect("ordinary coordinates").largest;
                let diagonal = subject.mesh.bounds().diagonal();
                assert!(*what != What::ControlFit || largest <= 1e-6 * diagonal, "converges");
            }
            What::Fit(method) => {
                let options = Options { method, ..Options::default() };
                let report = samples.time(|| fit(&prepared, &subject.target, &options));
                assert!(report.is_converged(), "{method} converges");
                *updates = report.stages[0].solve.last().updates;
            }
            What::FromArrays(None) => {
                let target = &subject.target;
                samples.time(|| {
                    let topology = Topology::from_faces(points.len(), &subject.faces);
                    let topology = topology.expect("the same mesh");
                    let pass = OnePass::near(&topology, &Rules::LOOP, &exact, target);
                    pass.expect("triangles").fit(target).expect("ordinary coordinates")
                });
            }
            What::FromArrays(Some(method)) => {
                let (target, options) = (&subject.target, Options { method, ..Options::default() });
                let report = samples.time(|| {
                    let topology = Topology::from_faces(points.len(), &subject.faces);
                    let topology = topology.expect("the same mesh");
                    let prepared = Interpolator::near(&topology, &Rules::LOOP, target);
                    fit(&prepared.expect("triangles"), target, &options)
                });
                assert!(report.is_converged(), "{method} converges");
                *updates = report.stages[0].solve.last().updates;
            }
            What::Updates(method, iterations) => {
                let options = Options { method, iterations, tolerance: None, ..Options::default() };
                if points.len() < 1_000_000 {
                    // Small arrays lie in memory that the process has already, once it has it.
                    fit(&prepared, &subject.target, &Options { iterations: 0, ..options });
                }
                samples.time(|| fit(&prepared, &subject.target, &options));
            }
        }
    }
}

fn fit(interpolator: &Interpolator, target: &[Vec3], options: &Options) -> FitReport {
    let mut ignore = |_, _| ControlFlow::Continue(());
    interpolator.fit(target, options, &mut ignore).expect("ordinary coordinates").1
}

impl What {
    /// What a step moves per vertex: of the output for a refinement step, of the input otherwise.
    pub(crate) fn bytes(self, updates: u32) -> Bytes {
        let bytes = |moved, new| Bytes { moved, new };
        match self {
            // Corners become a topology.
            Self::Topology => bytes(PER_HALFEDGE, TOPOLOGY),
            // A coarser mesh has a quarter of the vertices.
            Self::Refine => bytes((TOPOLOGY + POINT) / 4.0, TOPOLOGY + POINT),
            Self::Limit | Self::Normals => bytes(RINGS + POINT, POINT),
            // The operator, and the vertices of its rows.
            Self::Prepare => bytes(RINGS, OPERATOR + INDEX),
            // Rings are walked once; patches hold about as much as the operator, halos included.
            Self::PreparePass => bytes(RINGS + PER_HALFEDGE, PATCHES),
            // Four values for each vertex are written, into memory that there is or not.
            Self::ExactFit { is_new: true } => bytes(POINT + PATCHES, 4.0 * POINT),
            Self::ExactFit { is_new: false } => bytes(5.0 * POINT + PATCHES, 0.0),
            Self::ControlFit => bytes(2.0 * POINT + PATCHES, 0.0),
            Self::Fit(method) => {
                // The last residual is a pass over the mesh as well, and so is the check of the
                // result; x, the next x and the update are new.
                let residual = OPERATOR + 3.0 * POINT;
                let check = Self::Limit.bytes(0);
                let all = f64::from(updates) * update_bytes(method) + residual + check.moved;
                bytes(all, 3.0 * POINT + check.new)
            }
            Self::FromArrays(None) => Self::Topology
                .bytes(0)
                .plus(Self::PreparePass.bytes(0))
                .plus(Self::ExactFit { is_new: true }.bytes(0)),
            Self::FromArrays(Some(method)) => Self::Topology
                .bytes(0)
                .plus(Self::Prepare.bytes(0))
                .plus(Self::Fit(method).bytes(updates)),
            Self::Updates(method, count) => bytes(f64::from(count) * update_bytes(method), 0.0),
        }
    }
}

/// Bytes per vertex and update.
pub(crate) fn update_bytes(method: Method) -> f64 {
    match method {
        Method::ConjugateGradients => {
            // e·e; p from e and p; B p; p·Bp; x from x and p; e from e and Bp. Products need the
            // valence.
            let (dot, combination) = (INDEX, 3.0 * POINT);
            (dot + POINT)
                + combination
                + (OPERATOR + 2.0 * POINT)
                + (dot + 2.0 * POINT)
                + 2.0 * combination
        }
        // Reads target, update and x; writes update and the next x.
        _ => OPERATOR + 5.0 * POINT,
    }
}
