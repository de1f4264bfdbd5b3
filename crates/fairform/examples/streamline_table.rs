//! How long do curves and surfaces of tangents take? The paper's table 1, as nanoseconds per tangent
//! and as ratios, and the edits of a modeller. Prints Markdown; `cargo xtask bench streamlines` runs it.

use std::hint::black_box;
use std::time::{Duration, Instant};

use fairform::sphere::{Ends, Knots, QiCurve, Rule, Step};
use fairform::streamline::{Grid, InitialCurve, Model, Surface};
use fairform::{Scheme, Vec3};

/// How long each thing is repeated for.
const LONG: Duration = Duration::from_millis(400);

/// Best and median seconds of a call, of many runs of many calls each.
fn time<R>(mut f: impl FnMut() -> R) -> [f64; 2] {
    let start = Instant::now();
    black_box(f());
    // A run of half a millisecond or one call, whichever is longer.
    let once = start.elapsed().as_secs_f64().max(1e-9);
    let calls = (5e-4 / once).ceil().max(1.0) as u32;
    let mut runs = Vec::new();
    let begin = Instant::now();
    while begin.elapsed() < LONG || runs.len() < 5 {
        let start = Instant::now();
        for _ in 0..calls {
            black_box(f());
        }
        runs.push(start.elapsed().as_secs_f64() / f64::from(calls));
    }
    runs.sort_by(f64::total_cmp);
    [runs[0], runs[runs.len() / 2]]
}

fn curve(rule: Rule, depth: u32, tangents: &[Vec3]) -> Vec<Vec3> {
    let mut tangents = black_box(tangents).to_vec();
    for _ in 0..depth {
        let step = Step::new(rule, Ends::Natural, tangents.len()).expect("enough tangents");
        tangents = step.directions(&tangents);
    }
    tangents
}

fn main() {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    one.install(|| {
        table_1();
        surfaces();
    });
}

fn table_1() {
    // Five tangents that turn by 30 to 60 degrees, not in a plane.
    let five =
        [[1.0, 0.0, 0.0], [0.8, 0.5, 0.2], [0.2, 0.9, 0.5], [-0.4, 0.6, 0.8], [-0.7, -0.2, 0.6]]
            .map(|t| Vec3::from(t).normalized());
    let mut rows: Vec<(String, usize, [f64; 2])> = Vec::new();
    for (name, rule, depth) in [
        ("Chaikin", Rule::Chaikin, 7),
        ("cubic B-spline", Rule::Cubic, 7),
        ("four-point", Rule::FourPoint { w: 1.0 }, 6),
    ] {
        let count = curve(rule, depth, &five).len();
        rows.push((format!("{name}, depth {depth}"), count, time(|| curve(rule, depth, &five))));
    }
    for order in [3, 4, 5] {
        let u: Vec<f64> = (0..257).map(|i| f64::from(i) / 256.0).collect();
        let sample = || {
            let curve =
                QiCurve::new(black_box(&five), order, Knots::Clamped).expect("five tangents");
            u.iter().map(|&u| curve.tangent(u)).collect::<Vec<_>>()
        };
        rows.push((format!("QI, order {order}"), u.len(), time(sample)));
    }
    println!("\n## Curves on the sphere\n");
    println!(
        "Five control tangents, as in table 1 of the paper: best time of many runs, median in brackets, \
         one thread. Ratios are of whole curves, as there; the paper has 4.3 to 4.7 for the four-point \
         rule and 15 to 17 for Chaikin's, against a QI curve of its own. Here the QI curve begins at \
         the last tangent that it has passed, and turns by as many rotations as its degree.\n"
    );
    println!(
        "| curve | tangents | µs | ns per tangent | QI 3 / this | QI 4 / this | QI 5 / this |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|");
    let qi: Vec<f64> = rows[3..].iter().map(|row| row.2[0]).collect();
    for (name, count, [best, median]) in &rows {
        let ratios: Vec<String> = qi.iter().map(|qi| format!("{:.1}", qi / best)).collect();
        println!(
            "| {name} | {count} | {:.2} ({:.2}) | {:.1} | {} |",
            best * 1e6,
            median * 1e6,
            best * 1e9 / *count as f64,
            ratios.join(" | ")
        );
    }
}

/// 6 streamlines of 9 tangents each.
fn model(scheme: Scheme, depth: u32) -> Model {
    let tangent = |k: usize, i: usize| {
        let (x, y) = (i as f64 / 8.0, k as f64 / 5.0);
        Vec3::new(1.0, 0.4 * (3.0 * y - 1.5) * (x - 0.5), 0.9 - 2.0 * x + 0.3 * (5.0 * x).sin() * y)
    };
    let rows = (0..6).map(|k| (0..9).map(move |i| tangent(k, i).normalized()));
    let tangents = Grid::from_rows(rows).expect("a grid");
    let t: Vec<f64> = (0..6).map(f64::from).collect();
    let points = t.iter().map(|&y| Vec3::new(0.0, y, 0.0)).collect();
    let initial = InitialCurve::Polyline { points, t: t.clone() };
    Model { scheme, depth, ..Model::new(tangents, &[8.0; 6], t, initial) }
}

fn surfaces() {
    println!("\n## Surfaces of 6 streamlines with 9 tangents\n");
    println!(
        "Milliseconds, best (median), one thread. *Whole*: refined and integrated from the model. \
         *Moved*: after one control tangent in the middle moved, all points that follow it. Targets: \
         4 ms for a tangent moved at depth 5, 30 ms for a whole surface at depth 6.\n"
    );
    println!(
        "| scheme | depth | tangents | whole | ns per tangent | a tangent moved | points moved |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|");
    for scheme in [Scheme::DooSabin, Scheme::CatmullClark, Scheme::Kobbelt] {
        for depth in [4, 5, 6] {
            let model = model(scheme, depth);
            let whole = time(|| Surface::new(black_box(model.clone())).expect("a surface"));
            let mut surface = Surface::new(model).expect("a surface");
            let count = surface.tangents().values().len();
            let (mut turn, mut points) = (0.0, 0);
            let moved = time(|| {
                turn += 0.01;
                let to = Vec3::new(1.0, 0.1 * f64::sin(turn), 0.1).normalized();
                let changed = surface.set_tangent(0, 2, 4, to).expect("a tangent");
                points = changed.points.rows.len() * changed.points.columns.len();
            });
            println!(
                "| {scheme} | {depth} | {count} | {:.2} ({:.2}) | {:.1} | {:.3} ({:.3}) | {points} |",
                whole[0] * 1e3,
                whole[1] * 1e3,
                whole[0] * 1e9 / count as f64,
                moved[0] * 1e3,
                moved[1] * 1e3
            );
        }
    }
}
