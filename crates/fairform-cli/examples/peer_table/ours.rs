//! fairform as a peer: flat arrays to flat arrays, and one line of JSON.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

#[cfg(feature = "direct")]
use fairform::interpolate::Method;
use fairform::interpolate::{Interpolator, Options};
use fairform::onepass::{self, OnePass};
use fairform::tessellate::{Point, Points, Tessellation};
use fairform::{Bounds, Faces, Mesh, Rules, Scheme, Vec3, refine};
use serde_json::json;

/// `MESH SCHEME LEVELS REPEATS THREADS [f32 | steps | limit | limit-f32 | fit | fit-12 | exact | direct]`
pub(crate) fn main(args: &[String]) {
    let [path, scheme, levels, repeats, threads, how @ ..] = args else {
        panic!("ours MESH SCHEME LEVELS REPEATS THREADS [HOW]")
    };
    let number = |text: &String| text.parse::<u32>().expect("a number");
    let data = fairform_io::read(Path::new(path), None).expect("a mesh");
    let task = Task {
        points: data.positions,
        faces: data.faces,
        rules: scheme.parse::<Scheme>().expect("a scheme").into(),
        levels: number(levels),
        how: how.first().map_or("", String::as_str),
    };
    let threads = number(threads) as usize;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("threads can be started").install(|| run(&task, number(repeats)));
}

struct Task<'a> {
    points: Vec<Vec3>,
    faces: Faces,
    rules: Rules,
    levels: u32,
    how: &'a str,
}

/// A result as flat arrays.
type Arrays = (Vec<Vec3>, Faces);

fn run(task: &Task<'_>, repeats: u32) {
    let before = status_bytes("VmRSS:");
    // Starts the peak of resident memory anew.
    let _ = fs::write("/proc/self/clear_refs", "5");
    let (mut samples, mut cpu, mut rest) = (Vec::new(), Vec::new(), None);
    for _ in 0..repeats {
        let mut laps = Laps::start();
        let (points, faces) = match task.how {
            "" | "limit" => at_once::<Vec3>(task, &mut laps),
            "f32" | "limit-f32" => at_once::<[f32; 3]>(task, &mut laps),
            "steps" => step_by_step(task, &mut laps),
            "exact" => exact(task, &mut laps),
            _ => fitted(task, &mut laps),
        };
        cpu.push(laps.cpu);
        samples.push(laps.parts);
        rest.get_or_insert_with(|| {
            let bytes = status_bytes("VmHWM:").saturating_sub(before);
            let bounds = Bounds::of(points.iter().copied());
            let count = points.len() as f64;
            let mean = points.iter().fold(Vec3::ZERO, |sum, &p| sum + p) / count;
            let square = points.iter().map(|p| p.dot(*p)).sum::<f64>() / count;
            let triple = |p: Vec3| [p.x, p.y, p.z];
            json!({
                "library": "fairform", "vertices": points.len(), "faces": faces.len(),
                "mean": triple(mean), "min": triple(bounds.min), "max": triple(bounds.max),
                "square": [square], "bytes": bytes,
            })
        });
    }
    let mut line = rest.expect("one repeat at least");
    line["samples"] = json!(samples);
    line["cpu"] = json!(cpu);
    println!("{line}");
}

/// All steps of the scheme at once, to the limit if that is asked for, with normals.
fn at_once<P: Point + Default + Clone + Into<Triple>>(task: &Task<'_>, laps: &mut Laps) -> Arrays {
    let mesh = Mesh::new(task.points.clone(), &task.faces).expect("a manifold");
    laps.lap();
    let is_limit = task.how.starts_with("limit");
    let kind = if is_limit { Points::Limit } else { Points::Control };
    let all = Tessellation::new(mesh.topology(), &task.rules, task.levels, kind).expect("fits");
    let surface = match is_limit {
        true => all.surface(mesh.positions()),
        false => all.field(mesh.positions()),
    }
    .expect("a surface");
    let mut points = vec![P::default(); all.vertex_count()];
    let mut normals = if is_limit { points.clone() } else { Vec::new() };
    surface.fill(&mut points, is_limit.then_some(normals.as_mut_slice()));
    laps.lap();
    let faces = all.faces();
    laps.lap();
    laps.end();
    (points.into_iter().map(|p| p.into().0).collect(), faces)
}

/// A point as all are compared.
struct Triple(Vec3);

impl From<Vec3> for Triple {
    fn from(p: Vec3) -> Self {
        Self(p)
    }
}

impl From<[f32; 3]> for Triple {
    fn from([x, y, z]: [f32; 3]) -> Self {
        Self(Vec3::new(x.into(), y.into(), z.into()))
    }
}

/// Mesh after mesh, with their connectivity.
fn step_by_step(task: &Task<'_>, laps: &mut Laps) -> Arrays {
    let mesh = Mesh::new(task.points.clone(), &task.faces).expect("a manifold");
    laps.lap();
    let (mesh, _) = refine::refine_mesh(&mesh, &task.rules, task.levels).expect("fits");
    laps.lap();
    let faces = mesh.topology().to_faces();
    laps.lap();
    laps.end();
    (mesh.into_positions(), faces)
}

/// Points of level 1 whose limit points are the given ones up to rounding.
fn exact(task: &Task<'_>, laps: &mut Laps) -> Arrays {
    let mesh = Mesh::new(task.points.clone(), &task.faces).expect("a manifold");
    let options = onepass::Options::default();
    let one = OnePass::new(mesh.topology(), &task.rules, &options).expect("a scheme for it");
    laps.lap();
    let (mut points, _) = one.fit(mesh.positions()).expect("fits");
    // So that times are per vertex of the mesh.
    points.truncate(mesh.positions().len());
    laps.lap();
    let faces = mesh.topology().to_faces();
    laps.lap();
    laps.end();
    (points, faces)
}

/// Control points whose limit points are the given ones.
fn fitted(task: &Task<'_>, laps: &mut Laps) -> Arrays {
    let mesh = Mesh::new(task.points.clone(), &task.faces).expect("a manifold");
    let interpolator = Interpolator::new(mesh.topology(), &task.rules).expect("a scheme for it");
    laps.lap();
    let options = match task.how {
        "fit" => Options::default(),
        "fit-12" => Options { tolerance: Some(1e-12), ..Options::default() },
        #[cfg(feature = "direct")]
        "direct" => Options { method: Method::Direct, ..Options::default() },
        how => panic!("{how}: no such work"),
    };
    let mut ignore = |_, _| ControlFlow::Continue(());
    let (points, report) = interpolator.fit(mesh.positions(), &options, &mut ignore).expect("fits");
    assert!(report.is_converged(), "the fit converges");
    laps.lap();
    let faces = mesh.topology().to_faces();
    laps.lap();
    laps.end();
    (points, faces)
}

/// Seconds of the parts of one run.
struct Laps {
    parts: Vec<f64>,
    cpu_start: f64,
    /// Seconds that all threads ran, in the end.
    cpu: f64,
    last: Instant,
}

impl Laps {
    fn start() -> Self {
        Self { parts: Vec::new(), cpu_start: cpu_seconds(), cpu: 0.0, last: Instant::now() }
    }

    /// Ends a part.
    fn lap(&mut self) {
        let now = Instant::now();
        self.parts.push((now - self.last).as_secs_f64());
        self.last = now;
    }

    /// Ends the run.
    fn end(&mut self) {
        self.cpu = cpu_seconds() - self.cpu_start;
    }
}

/// Seconds that the threads of this process have run; 0 where the system does not tell.
fn cpu_seconds() -> f64 {
    // The system brings a thread's time up to date when it stops, and else only now and then.
    thread::sleep(Duration::from_micros(1));
    let tasks = fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let run = |task: fs::DirEntry| -> Option<f64> {
        let times = fs::read_to_string(task.path().join("schedstat")).ok()?;
        times.split_whitespace().next()?.parse().ok()
    };
    tasks.filter_map(run).sum::<f64>() / 1e9
}

/// Bytes that `/proc/self/status` names, or 0.
fn status_bytes(name: &str) -> u64 {
    let find = || -> Option<u64> {
        let status = fs::read_to_string("/proc/self/status").ok()?;
        let line = status.lines().find(|line| line.starts_with(name))?;
        line.split_whitespace().nth(1)?.parse().ok()
    };
    find().map_or(0, |kibibytes| 1024 * kibibytes)
}
