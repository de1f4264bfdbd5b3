//! `fairform fit`, the main job.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use fairform::fair::Energy;
use fairform::interpolate::{self, FitReport, Interpolator, Observer, Options, StageName};
use fairform::solve::{Outcome, Step};
use fairform::{Mesh, Rules, Topology};
use fairform_io::project::MeshPart;
use fairform_io::{Format, MeshData, repair};
use fairform_render::{Body, Colour, Dot, Line, Panel, Series, View};
use serde_json::{Value, json};

use crate::args::Fit;
use crate::console::{Console, Progress, count};
use crate::failure::Failure;
use crate::input::{self, Source};
use crate::rules;
use crate::surface::{Finish, Made, Surface, check_memory};

/// The sample that is fitted when there is no input.
const SAMPLE: &[u8] = include_bytes!("../../../../data/sample/spot.obj");
const SAMPLE_SURFACE: &str = "fairform-sample.ply";
/// Refinement steps, if nobody says how many.
const LEVELS: u32 = 3;
const SAMPLE_PICTURE: &str = "fairform-sample.png";

pub(crate) fn run(args: &Fit, console: &Console) -> Result<ExitCode, Failure> {
    let output = args.output.clone().unwrap_or_else(|| PathBuf::from(SAMPLE_SURFACE));
    let meshes = [Some(&output), args.control.as_ref()];
    for path in meshes.into_iter().flatten() {
        input::check_mesh(path, &args.writing)?;
    }
    let outputs = meshes.into_iter().chain([args.report.as_ref(), args.plot.as_ref()]);
    let outputs: Vec<&Path> = outputs.flatten().map(PathBuf::as_path).collect();
    input::check_outputs(&outputs, console)?;

    let mut clock = Clock::start();
    let progress = console.progress();
    progress.say("reading");
    let given = args.input.input.as_deref();
    let source = Source { path: given.unwrap_or(Path::new("the sample")), format: args.input.from };
    let project = if given.is_some() { input::project(&source)? } else { None };
    let data = match (&project, given) {
        (Some(part), _) => input::data(part, &source, console)?,
        (None, Some(_)) => input::read(&source, console)?,
        (None, None) => sample()?,
    };
    let mut target = Surface::new(data, &source)?;
    clock.lap("read");
    let args = &match &project {
        Some(part) => as_designed(args, part),
        None => args.clone(),
    };
    match &project {
        Some(part) => rules::design(part, args, &mut target, console)?,
        None => rules::set(args.scheme.chosen(), &args.rules, &mut target, console)?,
    }
    let levels = args.levels.unwrap_or(LEVELS);
    let finish = finish(args, &target);
    // The sample's surface is drawn too.
    let streams = |surface: &Surface, levels| {
        args.output.is_some() && surface.can_stream(levels, finish, &output, &args.writing)
    };
    let stored = target.stored(levels, finish, streams(&target, levels));
    check_memory(&target, levels, stored, &source)?;
    target.warn_of_losses(levels, console);
    target.warn_of_no_faces(&source, console);
    warn_of_seams(&target.mesh, &source, console);

    progress.say("preparing");
    let at = |e| target.failure(&source, &e);
    let topology = target.mesh.topology().clone();
    clock.lap("prepare");
    let options = options(args);
    let mut observe = |stage: StageName, step: Step| {
        let what = match stage {
            StageName::Fairing => "points to move by",
            _ => "largest error",
        };
        progress.say(format!("{stage}: {} updates, {what} {:.2e}", step.updates, step.max));
        ControlFlow::Continue(())
    };
    let Fitted { control, level, report, singular } =
        fitted(&target, &options, &mut observe, &progress).map_err(at)?;
    clock.lap("solve");

    let finer = levels.saturating_sub(level);
    let tessellation = match streams(&control, finer) {
        true => Some(control.tessellation(finer, finish).map_err(at)?),
        false => None,
    };
    let made = control.made(finer, finish, tessellation.as_ref(), &progress).map_err(at)?;
    clock.lap("refine");

    progress.say("writing");
    if let Some(path) = &args.control {
        input::write(path, &args.writing, &control.clone().into_control(), console)?;
    }
    let counts = made.write(&output, &args.writing, console)?;
    if let (None, Made::Whole(data)) = (&args.output, &made) {
        input::save(Path::new(SAMPLE_PICTURE), &picture(&target.mesh, data)?)?;
    }
    clock.lap("write");
    drop(progress);

    let summary = summary(args, &options, &target.rules, &topology, counts, &report, &clock);
    if let Some(path) = &args.report {
        input::save(path, format!("{summary:#}\n").as_bytes())?;
    }
    if let Some(path) = &args.plot {
        input::save(path, plot(&report, &options, &target.rules).as_bytes())?;
    }
    tell(args, &output, counts, &report, &clock, console);
    tell_certificate(&report, console);
    tell_of_level(args, level, singular, &report, console);
    console.result(&summary)?;
    Ok(if report.is_converged() { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

/// What a project says, where the command line does not.
fn as_designed(args: &Fit, part: &MeshPart) -> Fit {
    let mut args = args.clone();
    let design = &part.design;
    let named = (args.tolerance, args.iterations);
    if named == (None, None) {
        args.tolerance = Some(design.tolerance);
        args.iterations = Some(design.iterations);
    }
    args.scheme.scheme = args.scheme.scheme.or(Some(design.scheme));
    args.method = args.method.or(Some(design.method));
    args.fair = args.fair.or(design.fair);
    args.exact |= design.exact;
    args.levels = args.levels.or(Some(part.fineness.levels));
    args.limit |= part.fineness.limit;
    args
}

/// What is asked for of the surface.
fn finish(args: &Fit, target: &Surface) -> Finish {
    match args.limit || args.output.is_none() {
        true => Finish::Limit,
        false if target.normals.is_some() => Finish::LimitNormals,
        false => Finish::Control,
    }
}

/// A control surface, and how it was found.
pub(crate) struct Fitted {
    pub(crate) control: Surface,
    /// How often it is refined from the connectivity of the target.
    pub(crate) level: u32,
    pub(crate) report: FitReport,
    /// Number of parts without a control mesh of level 0.
    singular: usize,
}

/// The control surface whose limit passes through the vertices of a target, with its colours and texture
/// coordinates.
pub(crate) fn fitted(
    target: &Surface,
    options: &Options,
    observer: &mut Observer<'_>,
    progress: &Progress,
) -> Result<Fitted, fairform::Error> {
    let fit = fit(target, options, observer)?;
    let (level, report, singular) = (fit.level, fit.report.clone(), fit.singular.len());
    let control = if level == 0 {
        let mut control = target.clone();
        control.mesh = fit.control;
        control.fit_fields(options)?;
        control
    } else {
        target.pushed_back(fit, options, progress)?
    };
    Ok(Fitted { control, level, report, singular })
}

/// Solves, and pushes back where that is asked for or nothing else interpolates.
fn fit(
    target: &Surface,
    options: &Options,
    observer: &mut Observer<'_>,
) -> Result<interpolate::Fit, fairform::Error> {
    let (mesh, rules) = (&target.mesh, &target.rules);
    if options.tolerance.is_none() && !options.exact && options.fair.is_none() {
        // A number of updates is asked for, so these are what is to be seen.
        let interpolator = Interpolator::near(mesh.topology(), rules, mesh.positions())?;
        let (control, report) = interpolator.fit(mesh.positions(), options, observer)?;
        let control = mesh.with_positions(control);
        let rules = rules.clone();
        return Ok(interpolate::Fit { control, rules, level: 0, report, singular: vec![] });
    }
    interpolate::fit_mesh(mesh, rules, options, observer)
}

fn sample() -> Result<MeshData, Failure> {
    fairform_io::parse(SAMPLE, Format::Obj).map_err(|e| Failure::new(format!("the sample: {e}")))
}

fn options(args: &Fit) -> Options {
    let usual = Options::default();
    Options {
        method: args.method.unwrap_or_default(),
        norm: args.norm,
        // A count alone is to be made exactly.
        tolerance: match (args.tolerance, args.iterations) {
            (None, None) => usual.tolerance,
            (given, _) => given,
        },
        iterations: args.iterations.unwrap_or(usual.iterations),
        exact: args.exact,
        fair: args.fair,
        energy: Energy { stretching: args.fair_stretch, ..Energy::default() },
    }
}

/// Vertices that were split, by texture seams say, leave gaps in the surface.
fn warn_of_seams(mesh: &Mesh, source: &Source, console: &Console) {
    if let Some(steps) = repair::joining(mesh) {
        console.note(format!(
            "warning: {source}: {} vertices lie exactly on others, where the surface may gape; \
             to join them:\n  {}",
            count(repair::coincident(mesh.positions())),
            source.repair(&steps)
        ));
    }
}

fn outcome(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Converged => "converged",
        Outcome::CountReached => "count reached",
        Outcome::TooManyUpdates => "not converged within the iterations",
        Outcome::Stalled => "stalled at the limit of rounding",
    }
}

fn tell(
    args: &Fit,
    output: &Path,
    (vertices, faces): (usize, usize),
    report: &FitReport,
    clock: &Clock,
    console: &Console,
) {
    for stage in &report.stages {
        let (last, solve) = (stage.solve.last(), &stage.solve);
        let predicted = solve.predicted.map_or(String::new(), |k| format!(" (about {k} expected)"));
        console.note(format!(
            "{}: {} vertices, {} iterations{predicted}, {}; error max {:.3e}, mean {:.3e}",
            stage.name,
            count(stage.vertex_count),
            last.updates,
            outcome(solve.outcome),
            last.max,
            last.mean
        ));
    }
    for (phase, seconds) in &clock.laps {
        console.detail(format!("{phase}: {seconds:.3} s"));
    }
    if !input::is_dash(output) {
        let (vertices, faces) = (count(vertices), count(faces));
        console.note(format!("{}: {vertices} vertices, {faces} faces", output.display()));
    }
    if args.output.is_none() {
        console.note(format!(
            "{SAMPLE_PICTURE}: the given mesh, and the surface through its vertices. Open it."
        ));
    }
    if !report.is_converged() {
        let wanted = args.tolerance.unwrap_or(1e-6);
        console.note(format!(
            "warning: not converged: the largest error is {:.3e} ({}), not {wanted:e}; allow more \
             --iterations or a larger --tolerance",
            report.max, args.norm
        ));
    }
}

/// What is known of a fit in one pass.
fn tell_certificate(report: &FitReport, console: &Console) {
    let Some(certificate) = report.certificate else { return };
    let bound = match (certificate.condition(), certificate.predicted) {
        (Some(condition), Some(predicted)) => {
            format!(
                "condition number at most {condition:.2}, error at most {predicted:.1e} by that"
            )
        }
        _ => "no bound of the condition number".into(),
    };
    console.note(format!(
        "one pass of {} iterations: {bound}; error max {:.3e} before, {:.3e} after",
        certificate.steps, certificate.first, certificate.residual
    ));
}

/// Says when the control mesh is one level finer than the mesh, and why.
fn tell_of_level(args: &Fit, level: u32, singular: usize, report: &FitReport, console: &Console) {
    if level == 0 {
        return;
    }
    let moved = report.pushed_back.unwrap_or_default();
    let why = match singular {
        0 => String::new(),
        1 => {
            ", since one part with valence 3 everywhere has no control mesh of its own level".into()
        }
        n => format!(
            ", since {n} parts with valence 3 everywhere have no control mesh of their level"
        ),
    };
    console.note(format!(
        "interpolated exactly by moving limit points by up to {moved:.1e} after one refinement \
         step{why}; the control mesh is one level finer; error max {:.1e}",
        report.max
    ));
    if let Some(fairing) = report.fairing {
        console.note(format!(
            "fairing: energy of the limit surface {:.4e} before, {:.4e} after, {} iterations",
            fairing.before, fairing.after, fairing.updates
        ));
    }
    if args.levels == Some(0) {
        console.note("note: so --levels 0 wrote the mesh of level 1");
    }
}

fn summary(
    args: &Fit,
    options: &Options,
    rules: &Rules,
    topology: &Topology,
    (vertices, faces): (usize, usize),
    report: &FitReport,
    clock: &Clock,
) -> Value {
    let stages: Vec<Value> = report
        .stages
        .iter()
        .map(|stage| {
            let solve = &stage.solve;
            json!({
                "name": stage.name.name(),
                "vertices": stage.vertex_count,
                "iterations": solve.last().updates,
                "predicted_iterations": solve.predicted,
                "outcome": outcome(solve.outcome),
                "history": solve.history.iter()
                    .map(|s| json!([s.updates, s.max, s.mean])).collect::<Vec<_>>(),
            })
        })
        .collect();
    json!({
        "scheme": rules.scheme.name(),
        "corners": format!("{:?}", rules.corners).to_lowercase(),
        "lambda": rules.tension.as_deref(),
        "method": options.method.name(),
        "norm": options.norm.name(),
        "unit": report.unit,
        "tolerance": options.tolerance,
        "levels": args.levels.unwrap_or(LEVELS),
        "control_level": u32::from(report.pushed_back.is_some()),
        "pushed_back": report.pushed_back,
        "fair": options.fair,
        "fairing": report.fairing.map(|fairing| json!({
            "energy": {
                "of": "the limit surface",
                "bending": options.energy.bending,
                "stretching": options.energy.stretching,
            },
            "iterations": fairing.updates,
            "before": fairing.before,
            "after": fairing.after,
        })),
        "certificate": report.certificate.map(|certificate| json!({
            "iterations": certificate.steps,
            "smallest_eigenvalue": certificate.smallest_eigenvalue,
            "condition": certificate.condition(),
            "first": certificate.first,
            "predicted": certificate.predicted,
            "residual": certificate.residual,
        })),
        "stages": stages,
        "max": report.max,
        "mean": report.mean,
        "converged": report.is_converged(),
        "counts": {
            "input": {
                "vertices": topology.vertex_count(),
                "faces": topology.face_count(),
                "edges": topology.edge_count(),
                "boundary_loops": topology.boundary_loops().len(),
                "isolated_vertices": topology.isolated_count(),
            },
            "output": { "vertices": vertices, "faces": faces },
        },
        "seconds": clock.laps.iter().map(|&(phase, s)| (phase.to_string(), json!(s)))
            .collect::<serde_json::Map<_, _>>(),
    })
}

fn plot(report: &FitReport, options: &Options, rules: &Rules) -> String {
    let mut series = Vec::new();
    for stage in &report.stages {
        let history = &stage.solve.history;
        let pick = |f: fn(&Step) -> f64| {
            history.iter().map(|s| (f64::from(s.updates), f(s))).collect::<Vec<_>>()
        };
        let name = |what: &str| format!("{}, {what}", stage.name);
        series.push(Series { name: name("max"), points: pick(|s| s.max), dashed: false });
        series.push(Series { name: name("mean"), points: pick(|s| s.mean), dashed: true });
    }
    let title = format!("Progressive interpolation: {}, {}", rules.scheme, options.method);
    let y = format!("distance to the vertices ({})", options.norm);
    fairform_render::plot_svg(&series, &title, "iterations", &y, true)
}

/// The given mesh and the surface side by side.
fn picture(target: &Mesh, surface: &MeshData) -> Result<Vec<u8>, Failure> {
    let faces = target.topology().to_faces();
    let dot = Dot::default();
    let mut given = Body::new(target.positions(), &faces);
    given.style.smooth = false;
    given.style.wireframe = Some(Line::default());
    given.style.points = Some(dot);
    let mut smooth = Body::new(&surface.positions, &surface.faces);
    smooth.normals = surface.normals.as_deref();
    // The same points on the surface show that it passes through them.
    let none = fairform::Faces::new();
    let mut points = Body::new(target.positions(), &none);
    points.style.fill = None;
    points.style.points = Some(Dot { colour: Colour::RED, ..dot });
    let panels = [
        Panel { bodies: vec![given], title: Some("the mesh".into()) },
        Panel {
            bodies: vec![smooth, points],
            title: Some("the surface through its vertices".into()),
        },
    ];
    let options = fairform_render::Options::default();
    // Spot looks towards −z.
    let view = View { azimuth: 145.0, elevation: 15.0, ..View::default() };
    let picture = fairform_render::render(&panels, &view, (1800, 1000), &options)?;
    Ok(picture.to_png())
}

/// Seconds by phase.
struct Clock {
    since: Instant,
    laps: Vec<(&'static str, f64)>,
}

impl Clock {
    fn start() -> Self {
        Self { since: Instant::now(), laps: Vec::new() }
    }

    fn lap(&mut self, phase: &'static str) {
        self.laps.push((phase, self.since.elapsed().as_secs_f64()));
        self.since = Instant::now();
    }
}
