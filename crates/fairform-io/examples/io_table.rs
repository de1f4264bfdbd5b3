//! How fast is each format read and written, on one thread and on two? Prints Markdown;
//! `cargo xtask bench io` runs it.
//!
//! An argument is another side of the torus than 1000, or the name of the one format to measure.

use std::hint::black_box;
use std::path::Path;
use std::time::{Duration, Instant};

use fairform::{Faces, Vec3};
use fairform_io::{Format, MeshData, WriteOptions, encode, parse, read, write};
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Numbers of threads that are compared.
const THREADS: [usize; 2] = [1, 2];

/// How long each row may take, and the fewest times that anything is measured.
const ALLOWED: Duration = Duration::from_secs(6);
const FEWEST: usize = 3;

/// A format as it is measured.
struct Case {
    name: &'static str,
    format: Format,
    options: WriteOptions,
    mesh: &'static str,
}

fn cases() -> Vec<Case> {
    let case = |name, format, ascii, single_precision, mesh| Case {
        name,
        format,
        options: WriteOptions { ascii, single_precision },
        mesh,
    };
    vec![
        case("OBJ", Format::Obj, true, false, "triangles"),
        case("OBJ", Format::Obj, true, false, "quads"),
        case("OBJ, float", Format::Obj, true, true, "triangles"),
        case("OBJ, float", Format::Obj, true, true, "with normals"),
        case("OFF", Format::Off, true, false, "triangles"),
        case("PLY, text", Format::Ply, true, false, "triangles"),
        case("PLY, double", Format::Ply, false, false, "triangles"),
        case("PLY, double", Format::Ply, false, false, "quads"),
        case("PLY, float", Format::Ply, false, true, "with normals"),
        case("STL, text", Format::Stl, true, true, "triangles"),
        case("STL", Format::Stl, false, false, "triangles"),
        case("GLB", Format::Glb, false, false, "triangles"),
        case("GLB", Format::Glb, false, false, "with normals"),
    ]
}

/// A torus of `side²` vertices, and what is wanted of it.
fn torus(side: u32, kind: &str) -> MeshData {
    let mesh = fairform::shapes::torus(side, side);
    let positions = mesh.positions().to_vec();
    let at = |i: u32, j: u32| i % side * side + j % side;
    let cells = (0..side).flat_map(|i| (0..side).map(move |j| (i, j)));
    let quads = cells.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
    let faces = if kind == "quads" {
        Faces::uniform(4, quads.flatten().collect())
    } else {
        Faces::uniform(3, quads.flat_map(|[a, b, c, d]| [a, b, c, a, c, d]).collect())
    };
    let normal = |p: &Vec3| {
        let ring = Vec3::new(p.x, p.y, 0.0).normalized();
        (*p - ring).normalized()
    };
    let normals = (kind == "with normals").then(|| positions.iter().map(normal).collect());
    MeshData { positions, faces, normals, ..MeshData::default() }
}

/// The shortest time of anything measured once or more.
#[derive(Clone, Copy)]
struct Best(f64);

impl Best {
    fn time<R>(&mut self, f: impl FnOnce() -> R) {
        let start = Instant::now();
        let made = black_box(f());
        self.0 = self.0.min(start.elapsed().as_secs_f64());
        drop(made);
    }

    fn rate(self, bytes: usize) -> String {
        format!("{:.0}", bytes as f64 / (1e6 * self.0))
    }
}

fn measure(case: &Case, data: &MeshData, pools: &[ThreadPool], folder: &Path) -> String {
    let mut bytes = Vec::new();
    encode(case.format, data, &case.options, &mut bytes).expect("a torus can be written");
    let path = folder.join(format!("torus.{}", case.format));
    write(&path, None, data, &case.options).expect("the folder can be written");
    let mut out: Vec<u8> = Vec::with_capacity(bytes.len());
    let none = [Best(f64::INFINITY); THREADS.len()];
    let (mut parsed, mut encoded, mut loaded, mut saved) = (none, none, none, none);
    let start = Instant::now();
    for pass in 0.. {
        if pass >= FEWEST && start.elapsed() > ALLOWED {
            break;
        }
        for (t, pool) in pools.iter().enumerate() {
            pool.install(|| {
                parsed[t].time(|| parse(&bytes, case.format));
                out.clear();
                encoded[t].time(|| encode(case.format, data, &case.options, &mut out));
                loaded[t].time(|| read(&path, None));
                saved[t].time(|| write(&path, None, data, &case.options));
            });
        }
    }
    assert_eq!(out, bytes, "the same bytes every time");
    let rates = [parsed, encoded, loaded, saved]
        .map(|best| best.map(|best| best.rate(bytes.len())).join(" | "));
    let megabytes = bytes.len() as f64 / 1e6;
    format!("| {} | {} | {megabytes:.0} | {} |", case.name, case.mesh, rates.join(" | "))
}

fn main() {
    let pools = THREADS.map(|threads| {
        ThreadPoolBuilder::new().num_threads(threads).build().expect("threads can be started")
    });
    let mut side = 1000;
    let mut only = None;
    for argument in std::env::args().skip(1) {
        match argument.parse() {
            Ok(number) => side = number,
            Err(_) => only = Some(argument),
        }
    }
    let folder = tempfile::tempdir().expect("there is a folder for temporary files");
    println!(
        "\nMegabytes of the file per second, the best of several runs, on 1 and on 2 threads. *Parse* and\n\
         *encode* are from and to memory (encoding into memory that was written before), *read* and *write*\n\
         from and to files in the system's cache. The mesh is a torus of {side} × {side} vertices.\n"
    );
    println!(
        "| format | mesh | MB | parse, 1 | 2 | encode, 1 | 2 | read, 1 | 2 | write, 1 | 2 |\n\
         |---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|"
    );
    for case in cases() {
        if only.as_ref().is_some_and(|only| !case.name.eq_ignore_ascii_case(only)) {
            continue;
        }
        println!("{}", measure(&case, &torus(side, case.mesh), &pools, folder.path()));
    }
}
