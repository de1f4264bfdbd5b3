//! The results as Markdown.

use fairform::interpolate::Method;

use crate::bandwidth::Bandwidth;
use crate::rows::{Bytes, COUNTS, Row, UPDATES, What, update_bytes};
use crate::{Measured, Samples, THREADS};

/// Sizes from which the targets count.
const LARGE: usize = 100_000;

/// Nanoseconds per vertex on one thread that are to be kept below: 1.2 s for 5.2 million triangles,
/// 80 per vertex made, 40 per vertex and update.
const TOPOLOGY_TARGET: f64 = 1.2e9 / 2.6e6;
const REFINE_TARGET: f64 = 80.0;
const UPDATE_TARGET: f64 = 40.0;
/// For an exact fit, refinement included, a fifth of what conjugate gradients take.
const EXACT_TARGET: f64 = 42.0;

const INTRODUCTION: &str = "\
Nanoseconds per vertex of the mesh, for a refinement step per vertex made: the best of several runs,
and their median in brackets. The best is what the step takes, the median what a machine that also
does other things makes of it. The meshes are a *torus* numbered row by row, a *sphere* numbered as
subdivision makes it, and that sphere *shuffled*, vertices and faces in random order.

*Bytes* are what a step cannot do without per vertex: every array that it takes read once, and, after
the plus sign, every array that it makes written once. *× memory* is how many times longer the step
took than that takes: the former at the speed of the triad, the latter at that of writing new
memory, which is slow since the system has to find its pages. Small meshes live in the caches and
can beat it.

A fit goes to a largest error of 1e-6 of the diagonal, on a topology that is prepared, or *from
arrays*: building the topology and preparing it are counted as well. The vertices
lie off the smooth shape by up to a tenth of an edge in each coordinate. An update is timed as the
difference of runs with different counts, so that nothing else is in it; `auto`, `plain`, `weighted`
and `chebyshev` make the same update with different numbers.
";

const HEAD: &str = "\
| step | mesh | seconds | 1 thread, ns | × memory | 2 threads, ns | × memory | bytes | target, ns |
|---|---|--:|--:|--:|--:|--:|--:|---|";

pub(crate) fn print(bandwidth: &[Bandwidth; THREADS.len()], sizes: &[Vec<Measured>]) {
    println!("\n{INTRODUCTION}");
    println!("| threads | copy, GB/s | triad, GB/s | writing new memory, GB/s |");
    println!("|--:|--:|--:|--:|");
    for (threads, b) in THREADS.iter().zip(bandwidth) {
        println!("| {threads} | {:.1} | {:.1} | {:.1} |", b.copy(), b.triad(), b.fresh());
    }
    for meshes in sizes {
        let counts: Vec<usize> = meshes.iter().map(|mesh| mesh.vertex_count).collect();
        println!("\n## {} vertices\n\n{HEAD}", spaced(counts[0]));
        for i in 0..lines(&meshes[0]).len() {
            for mesh in meshes {
                if let Some(line) = lines(mesh).get(i) {
                    line.print(mesh.name, bandwidth);
                }
            }
        }
    }
}

/// One line of a table.
struct Line {
    what: String,
    /// How many vertices the time is shared by.
    count: usize,
    /// Best and median seconds, for each number of threads.
    seconds: [[f64; 2]; THREADS.len()],
    bytes: Bytes,
    target: Option<f64>,
}

impl Line {
    fn print(&self, mesh: &str, bandwidth: &[Bandwidth; THREADS.len()]) {
        let ns = 1e9 / self.count as f64;
        let Bytes { moved, new } = self.bytes;
        let cells: Vec<String> = self
            .seconds
            .iter()
            .zip(bandwidth)
            .map(|(&[best, median], memory)| {
                let ratio = best * ns / (moved / memory.triad() + new / memory.fresh());
                format!("{:.1} ({:.1}) | {ratio:.1}", best * ns, median * ns)
            })
            .collect();
        let best = self.seconds[0][0];
        let target = self.target.map_or(String::new(), |target| {
            let verdict = if best * ns < target { "met" } else { "**missed**" };
            format!("{target:.0}: {verdict}")
        });
        let cells = cells.join(" | ");
        println!(
            "| {} | {mesh} | {best:.4} | {cells} | {moved:.0} + {new:.0} | {target} |",
            self.what
        );
    }
}

fn lines(mesh: &Measured) -> Vec<Line> {
    let (steps, fits): (Vec<usize>, Vec<usize>) = (0..mesh.rows[0].len())
        .filter(|&i| !matches!(mesh.rows[0][i].what, What::Updates(..)))
        .partition(|&i| !matches!(mesh.rows[0][i].what, What::Fit(_) | What::FromArrays(_)));
    let updates = UPDATES.map(|method| update_line(mesh, method));
    let step = |i: usize| line(mesh, i);
    steps.into_iter().map(step).chain(updates).chain(fits.into_iter().map(step)).collect()
}

fn line(mesh: &Measured, i: usize) -> Line {
    let Row { what, updates, .. } = mesh.rows[0][i];
    let large = |target| (mesh.vertex_count >= LARGE).then_some(target);
    let (name, count, target) = match what {
        What::Topology => ("topology from faces".into(), mesh.vertex_count, large(TOPOLOGY_TARGET)),
        What::Refine => ("refinement step".into(), mesh.finer_count, large(REFINE_TARGET)),
        What::Limit => ("limit points".into(), mesh.vertex_count, None),
        What::Normals => ("limit normals".into(), mesh.vertex_count, None),
        What::Prepare => ("preparing a fit".into(), mesh.vertex_count, None),
        What::PreparePass => ("preparing one pass".into(), mesh.vertex_count, None),
        What::ExactFit { is_new: true } => ("exact fit, one pass".into(), mesh.vertex_count, None),
        What::ExactFit { is_new: false } => {
            let target = large(EXACT_TARGET);
            ("exact fit, one pass, output reused".into(), mesh.vertex_count, target)
        }
        What::ControlFit => ("level 0, one pass, output reused".into(), mesh.vertex_count, None),
        What::FromArrays(None) => {
            ("exact fit, one pass, from arrays".into(), mesh.vertex_count, None)
        }
        What::FromArrays(Some(method)) => {
            (format!("fit, {method}, from arrays"), mesh.vertex_count, None)
        }
        What::Fit(method) => (format!("fit, {method}, {updates} updates"), mesh.vertex_count, None),
        What::Updates(..) => unreachable!("updates are taken together"),
    };
    let seconds = mesh.rows.each_ref().map(|rows| both(&rows[i].samples));
    Line { what: name, count, seconds, bytes: what.bytes(updates), target }
}

/// The difference of two counts of updates, per update.
fn update_line(mesh: &Measured, method: Method) -> Line {
    let seconds = mesh.rows.each_ref().map(|rows| {
        let of = |count| {
            let row = rows.iter().find(|row| row.what == What::Updates(method, count));
            row.map_or([f64::NAN; 2], |row| both(&row.samples))
        };
        let [few, many] = COUNTS.map(of);
        let updates = f64::from(COUNTS[1] - COUNTS[0]);
        [(many[0] - few[0]) / updates, (many[1] - few[1]) / updates]
    });
    // The default method is what the target is for.
    let target = (method == Method::Auto && mesh.vertex_count >= LARGE).then_some(UPDATE_TARGET);
    Line {
        what: format!("one update, {method}"),
        count: mesh.vertex_count,
        seconds,
        bytes: Bytes { moved: update_bytes(method), new: 0.0 },
        target,
    }
}

fn both(samples: &Samples) -> [f64; 2] {
    [samples.best(), samples.median()]
}

/// A number with thin gaps between thousands.
fn spaced(number: usize) -> String {
    let digits = number.to_string();
    let first = digits.len() % 3;
    let (head, tail) = digits.split_at(first);
    let mut groups: Vec<&str> = if head.is_empty() { Vec::new() } else { vec![head] };
    groups.extend((0..tail.len() / 3).map(|i| &tail[3 * i..3 * i + 3]));
    groups.join(" ")
}
