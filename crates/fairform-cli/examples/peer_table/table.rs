//! The results as Markdown.

use crate::peers::Run;
use crate::{Case, Measured, Work};

const INTRODUCTION: &str = "\
Nanoseconds per vertex made, from flat arrays to flat arrays in one process: best and, in brackets,
median of all repeats. *CPU* is the time that the threads ran, in the repeat with least of it: what is
left of the former on a machine that is busy with other things. *× fairform* is the best time by that
of the first row. The parts, of the best repeat, are to *build* the library's own structure, to *refine*,
and to *extract* points and faces again. *Bytes* are the peak of memory per vertex made, above what the
process had with the mesh read. Everything but *2 threads* runs on one. Numbers are double precision but
where `f32` is said, and in OpenSubdiv where `f64` is not.

*Difference* compares mean, mean square and box of the points with those of the first row, in parts of
the diagonal: rounding where the rules are the same, else another rule. What the programs do, and what
is not comparable, is in `benches/peers/README.md`.
";

const HEAD: &str = "\
| library | ns per vertex | × fairform | CPU, ns | × fairform | build | refine | extract | bytes | difference |
|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|";

pub(crate) fn print_introduction(absent: &[&str]) {
    println!("\n{INTRODUCTION}");
    if !absent.is_empty() {
        println!("Not installed here: {}.\n", absent.join(", "));
    }
}

pub(crate) fn print(case: &Case<'_>, measured: &[Measured<'_>], left_out: &[String]) {
    let Case { subject, scheme, levels, work } = case;
    let scheme = match *scheme {
        "loop" => "Loop",
        "catmull-clark" => "Catmull–Clark",
        _ => "Doo–Sabin",
    };
    let steps = if *levels == 1 { "1 level".into() } else { format!("{levels} levels") };
    let what = match work {
        Work::Refine => format!("{scheme}, {steps}"),
        Work::Limit => format!("{scheme}, {steps}, limit points and normals"),
        Work::Fit => format!("{scheme}, fit"),
    };
    let Some(first) = measured.first().filter(|first| first.peer.is_ours()) else {
        eprintln!("{what}, {}: {}", subject.name, left_out.join("; "));
        return;
    };
    let ours = &first.runs[0];
    println!(
        "## {what}: {}, {} → {} vertices\n",
        subject.name,
        spaced(subject.vertex_count),
        spaced(ours.summary.vertices as usize)
    );
    println!("{HEAD}");
    let base = [best(&first.runs).0, least_cpu(&first.runs)];
    for one in measured {
        println!("{}", row(one, ours, base));
    }
    println!("\nLoad after: {}.", load());
    left_out.iter().for_each(|line| println!("{line}."));
    println!();
}

fn row(one: &Measured<'_>, ours: &Run, base: [f64; 2]) -> String {
    let run = &one.runs[0];
    let label = one.peer.label.replace("{}", &run.library);
    let ns = 1e9 / run.summary.vertices as f64;
    let (total, parts) = best(&one.runs);
    let mut totals: Vec<f64> =
        one.runs.iter().flat_map(|run| &run.samples).map(|parts| parts.iter().sum()).collect();
    totals.sort_by(f64::total_cmp);
    let median = totals[totals.len() / 2];
    let cpu = least_cpu(&one.runs);
    let [build, refine, extract] = parts.map(|part| part * ns);
    let difference = match run.summary.difference(&ours.summary) {
        Some(0.0) => "0".into(),
        Some(difference) => format!("{difference:.0e}"),
        None => format!("**{} vertices**", run.summary.vertices),
    };
    let bytes = run.bytes / run.summary.vertices as f64;
    format!(
        "| {label} | {:.1} ({:.1}) | {:.2} | {:.1} | {:.2} | {build:.1} | {refine:.1} | {extract:.1} \
         | {bytes:.0} | {difference} |",
        total * ns,
        median * ns,
        total / base[0],
        cpu * ns,
        cpu / base[1]
    )
}

/// Least seconds that the threads of a repeat ran.
fn least_cpu(runs: &[Run]) -> f64 {
    runs.iter().flat_map(|run| &run.cpu).copied().fold(f64::INFINITY, f64::min)
}

/// The shortest of all repeats: its seconds, and those of its parts.
fn best(runs: &[Run]) -> (f64, [f64; 3]) {
    let totals = runs.iter().flat_map(|run| &run.samples).map(|&parts| (parts.iter().sum(), parts));
    totals.min_by(|a: &(f64, _), b| a.0.total_cmp(&b.0)).expect("measured at least once")
}

/// Processes that wanted to run in the last minute, on average.
fn load() -> String {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    load.split_whitespace().next().unwrap_or("unknown").into()
}

/// A count in groups of three digits.
fn spaced(count: usize) -> String {
    let digits = count.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().map(|g| std::str::from_utf8(g).unwrap_or("")).collect();
    groups.join(" ")
}
