//! How long does each step of the straight line take per vertex, and how near is that to what
//! moving its data through memory takes? Prints Markdown; `cargo xtask bench` runs it.

use std::time::{Duration, Instant};

mod bandwidth;
mod meshes;
mod rows;
mod table;

use bandwidth::Bandwidth;
use meshes::Subject;
use rows::Row;

/// Numbers of threads that are compared.
const THREADS: [usize; 2] = [1, 2];

/// Sizes, as sides of the torus and refinement steps of the icosahedron, and how long each may take.
const SIZES: [(u32, u32, Duration); 3] = [
    (100, 5, Duration::from_secs(3)),
    (400, 7, Duration::from_secs(15)),
    (1600, 9, Duration::from_secs(80)),
];

/// Fewest times that anything is measured.
const FEWEST: usize = 2;

/// Seconds of everything measured once or more, for one number of threads.
#[derive(Clone, Default)]
struct Samples(Vec<f64>);

impl Samples {
    fn time<R>(&mut self, f: impl FnOnce() -> R) -> R {
        let start = Instant::now();
        let result = std::hint::black_box(f());
        self.0.push(start.elapsed().as_secs_f64());
        result
    }

    /// The shortest time: what is left when nothing else ran.
    fn best(&self) -> f64 {
        self.0.iter().copied().fold(f64::INFINITY, f64::min)
    }

    fn median(&self) -> f64 {
        let mut sorted = self.0.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
    }
}

fn main() {
    let pools = THREADS.map(|threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads can be started")
    });
    let mut bandwidth = THREADS.map(|_| Bandwidth::default());
    let mut results = Vec::new();
    for (side, levels, allowed) in SIZES {
        let mut subjects = meshes::subjects(side, levels);
        let mut rows: Vec<_> =
            subjects.iter().map(|subject| THREADS.map(|_| rows::all(subject))).collect();
        // Everything once, then everything again: a disturbance hits one sample of many things and
        // not all samples of one.
        let start = Instant::now();
        for pass in 0.. {
            if pass >= FEWEST && start.elapsed() > allowed {
                break;
            }
            for (t, pool) in pools.iter().enumerate() {
                if pass < FEWEST {
                    pool.install(|| bandwidth[t].measure(THREADS[t]));
                }
                for (subject, rows) in subjects.iter_mut().zip(&mut rows) {
                    pool.install(|| rows::measure(subject, &mut rows[t]));
                }
            }
        }
        results.push(subjects.into_iter().zip(rows).map(Measured::new).collect());
    }
    table::print(&bandwidth, &results);
}

/// What was measured on one mesh.
struct Measured {
    name: &'static str,
    vertex_count: usize,
    /// Vertices after a refinement step.
    finer_count: usize,
    /// The same rows for each number of threads.
    rows: [Vec<Row>; THREADS.len()],
}

impl Measured {
    fn new((subject, rows): (Subject, [Vec<Row>; THREADS.len()])) -> Self {
        let topology = subject.mesh.topology();
        let vertex_count = topology.vertex_count();
        let finer_count = vertex_count + topology.edge_count();
        Self { name: subject.name, vertex_count, finer_count, rows }
    }
}
