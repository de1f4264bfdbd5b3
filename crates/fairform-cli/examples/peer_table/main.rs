//! How does fairform compare with the established libraries on the same meshes, on this machine, now?
//! Prints Markdown; `cargo xtask bench peers` builds the programs in `benches/peers` and runs it.
//!
//! Every measurement is a process of its own, ours as theirs: `peer_table ours MESH SCHEME LEVELS
//! REPEATS THREADS` is what `benches/peers` has for the others. Ours and theirs take turns, since
//! other work on the machine comes and goes.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

mod meshes;
mod ours;
mod peers;
mod table;

use meshes::Subject;
use peers::{Peer, Run};

/// Fewest turns, and how long a case is given more of them.
const FEWEST: usize = 2;
const ALLOWED: Duration = Duration::from_secs(2);

/// Seconds that repeats in one process are to fill, and their most.
const FILL: f64 = 0.3;
const MOST_REPEATS: usize = 10;

/// Seconds beyond which a peer is left out, judged by its last case, and beyond which it runs only once.
const TOO_LONG: f64 = 4.0;
const LONG: f64 = 1.5;

/// What is to be done with a mesh.
#[derive(Clone, Copy, PartialEq)]
enum Work {
    /// So many steps of the scheme.
    Refine,
    /// So many steps, and the limit points and normals of the vertices they make.
    Limit,
    /// The control mesh whose limit surface passes through the vertices.
    Fit,
}

/// One table.
struct Case<'s> {
    subject: &'s Subject,
    scheme: &'static str,
    levels: u32,
    work: Work,
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    if args.first().is_some_and(|first| first == "ours") {
        return ours::main(&args[1..]);
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let paths: Vec<PathBuf> = args.iter().map(PathBuf::from).collect();
    let subjects = meshes::subjects(&root, &paths);
    let (present, absent) = peers::all(&root);
    table::print_introduction(&absent);
    let mut pace = HashMap::new();
    for case in cases(&subjects) {
        let contenders = present.iter().filter(|peer| peer.does(case.scheme, case.work));
        let (measured, left_out) = measure(&case, contenders, &mut pace);
        table::print(&case, &measured, &left_out);
    }
}

/// All tables, small levels before large ones.
fn cases(subjects: &[Subject]) -> Vec<Case<'_>> {
    let mut cases = Vec::new();
    for (work, scheme) in [
        (Work::Refine, "loop"),
        (Work::Refine, "catmull-clark"),
        (Work::Refine, "doo-sabin"),
        (Work::Limit, "loop"),
        (Work::Limit, "catmull-clark"),
        (Work::Fit, "loop"),
    ] {
        for subject in subjects.iter().filter(|subject| subject.triangles == (scheme == "loop")) {
            let levels = match work {
                Work::Refine => subject.levels.clone(),
                Work::Limit => 2..=3,
                Work::Fit => 0..=0,
            };
            if work == Work::Refine || subject.is_made {
                cases.extend(levels.map(|levels| Case { subject, scheme, levels, work }));
            }
        }
    }
    cases
}

/// What was measured of one peer.
struct Measured<'p> {
    peer: &'p Peer,
    runs: Vec<Run>,
}

/// Runs the contenders in turns. `pace` keeps the seconds per vertex made of each one's last case.
fn measure<'p>(
    case: &Case<'_>,
    contenders: impl Iterator<Item = &'p Peer>,
    pace: &mut HashMap<String, f64>,
) -> (Vec<Measured<'p>>, Vec<String>) {
    let (mut measured, mut left_out) = (Vec::new(), Vec::new());
    let key = |peer: &Peer| format!("{} {} {}", peer.id(), case.scheme, case.work as u8);
    let mut made = 0.0;
    let start = Instant::now();
    for peer in contenders {
        if pace.get(&key(peer)).is_some_and(|pace| pace * made > TOO_LONG) {
            left_out.push(format!("{}: takes too long", peer.id()));
            continue;
        }
        match peer.run(case, 1) {
            Ok(run) => {
                made = run.summary.vertices as f64;
                pace.insert(key(peer), run.best() / made);
                measured.push(Measured { peer, runs: vec![run] });
            }
            Err(why) => left_out.push(format!("{}: {why}", peer.id())),
        }
    }
    for turn in 1.. {
        if turn >= FEWEST && start.elapsed() > ALLOWED {
            break;
        }
        for Measured { peer, runs } in &mut measured {
            let seconds = runs[0].best();
            if seconds < LONG {
                let repeats = ((FILL / seconds) as usize).clamp(1, MOST_REPEATS);
                runs.extend(peer.run(case, repeats));
            }
        }
    }
    (measured, left_out)
}
