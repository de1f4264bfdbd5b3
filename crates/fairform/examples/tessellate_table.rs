//! How long do all points, normals and faces of a mesh refined many times take per fine vertex, and
//! how near is that to what writing them to memory takes?
//!
//! `cargo run --release -p fairform --example tessellate_table [LEVELS [THREADS [MESH.off]]]`

use std::time::Instant;

use fairform::tessellate::{Points, Tessellation};
use fairform::{Mesh, Rules, Scheme, Vec3, limit, refine, shapes};

/// Fewest runs of anything; the best counts.
const RUNS: usize = 4;

const INTRODUCTION: &str = "\
Nanoseconds per vertex of the fine mesh, three levels, best of four. The meshes have some 160 000 vertices
for Loop and 98 000 for the others. *Prepare* is to find what each face draws on, *base* the one mesh between,
*faces* their indices; *f64 p+n* are positions on the surface and unit normals in double precision, into *new*
memory or *again* into memory there is, *p* positions alone, *f32* both in single precision. *All new* is
everything together, from a topology and points to arrays. *Step by step* is the same through mesh after mesh.
*Write* is what plain writing of positions and normals, 48 bytes, takes.
";

fn best<R>(mut f: impl FnMut() -> R) -> (f64, R) {
    let mut fastest = f64::INFINITY;
    let mut result = None;
    for _ in 0..RUNS {
        drop(result.take());
        let start = Instant::now();
        result = Some(std::hint::black_box(f()));
        fastest = fastest.min(start.elapsed().as_secs_f64());
    }
    (fastest, result.expect("there are runs"))
}

fn main() {
    let number = |i: usize, usual: usize| {
        std::env::args().nth(i).map_or(usual, |a| a.parse().expect("a number"))
    };
    let (levels, most) = (number(1, 3) as u32, number(2, 2));
    // A built-in mesh by its name, or a file.
    let meshes = match std::env::args().nth(3) {
        Some(path) if std::path::Path::new(&path).exists() => {
            vec![("file", Scheme::Loop, read(&path))]
        }
        name => {
            let is_wanted = |s: &Subject| name.as_ref().is_none_or(|n| s.0 == n);
            subjects().into_iter().filter(is_wanted).collect()
        }
    };
    println!("{INTRODUCTION}");
    println!(
        "| Mesh | Threads | Classes | Prepare | Base | Faces | f64 p+n new | again | p again | f32 p+n new | again | All new | Step by step | Write new | Write again |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for (name, scheme, mesh) in meshes {
        for threads in 1..=most {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("threads can be started")
                .install(|| row(name, scheme, &mesh, levels, threads));
        }
    }
}

fn row(name: &str, scheme: Scheme, mesh: &Mesh, levels: u32, threads: usize) {
    let rules = Rules::from(scheme);
    let new = || Tessellation::new(mesh.topology(), &rules, levels, Points::Limit).expect("fits");
    let (prepare, fine) = best(new);
    let (base, surface) = best(|| fine.surface(mesh.positions()).expect("has a limit"));
    let (faces, _) = best(|| fine.faces());
    let (fresh, mut pair) = best(|| surface.points_and_normals());
    let (again, ()) = best(|| surface.fill(&mut pair.0, Some(&mut pair.1)));
    let (points, ()) = best(|| surface.fill(&mut pair.0, None::<&mut [Vec3]>));
    let single = |pair: &mut [Vec<[f32; 3]>; 2]| {
        let [p, n] = pair;
        surface.fill(p, Some(n));
    };
    let count = fine.vertex_count();
    let (single_fresh, mut pair) = best(|| {
        let mut pair = [vec![[0.0; 3]; count], vec![[0.0; 3]; count]];
        single(&mut pair);
        pair
    });
    let (single_again, ()) = best(|| single(&mut pair));
    drop(pair);
    let (all, _) = best(|| {
        let fine = new();
        let all = fine.surface(mesh.positions()).expect("has a limit").points_and_normals();
        (all, fine.faces())
    });
    let start = Instant::now();
    std::hint::black_box(stepped(mesh, &rules, levels));
    let stepped = start.elapsed().as_secs_f64();
    let (write_new, mut memory) = best(|| written(count));
    let (write_again, ()) = best(|| write(&mut memory));
    let ns = |seconds: f64| format!("{:.1}", 1e9 * seconds / count as f64);
    let cells = [
        prepare,
        base,
        faces,
        fresh,
        again,
        points,
        single_fresh,
        single_again,
        all,
        stepped,
        write_new,
        write_again,
    ]
    .map(ns);
    println!("| {name} {scheme} | {threads} | {} | {} |", fine.class_count(), cells.join(" | "));
}

/// The same, one level after the other.
fn stepped(mesh: &Mesh, rules: &Rules, levels: u32) -> (Mesh, Vec<Vec3>, Vec<Vec3>) {
    let (mesh, rules) = refine::refine_mesh(mesh, rules, levels).expect("fits");
    let (topology, points) = (mesh.topology(), mesh.positions());
    let positions = limit::limit_points(topology, points, &rules).expect("has a limit");
    let normals = limit::limit_normals(topology, points, &rules).expect("has a limit");
    (mesh, positions, normals)
}

/// Positions and normals of nothing.
fn written(count: usize) -> Vec<f64> {
    let mut memory = vec![0.0; 6 * count];
    write(&mut memory);
    memory
}

fn write(memory: &mut [f64]) {
    use rayon::prelude::*;
    memory.par_chunks_mut(1 << 16).for_each(|part| part.fill(1.0));
}

type Subject = (&'static str, Scheme, Mesh);

fn subjects() -> Vec<Subject> {
    let sphere = refine::refine_mesh(&shapes::icosahedron(), &Rules::LOOP, 7).expect("small").0;
    let rules = Scheme::CatmullClark.into();
    let quads = refine::refine_mesh(&shapes::cube(), &rules, 7).expect("small").0;
    vec![
        ("torus", Scheme::Loop, shapes::torus(400, 400)),
        ("sphere", Scheme::Loop, sphere),
        ("cube", Scheme::CatmullClark, quads.clone()),
        ("cube dual", Scheme::DooSabin, quads),
    ]
}

/// An OFF file.
fn read(path: &str) -> Mesh {
    let text = std::fs::read_to_string(path).expect("a file");
    let mut words = text.split_whitespace().skip(1);
    let mut next = || words.next().expect("more").parse::<f64>().expect("a number");
    let [vertices, faces, _] = [0; 3].map(|_| next() as usize);
    let positions = (0..vertices).map(|_| Vec3::new(next(), next(), next())).collect();
    let faces = (0..faces).map(|_| {
        let count = next() as usize;
        (0..count).map(|_| next() as u32).collect::<Vec<_>>()
    });
    Mesh::new(positions, &faces.collect()).expect("a manifold")
}
