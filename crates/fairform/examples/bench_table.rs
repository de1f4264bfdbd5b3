//! How long does each step of the straight line take, per vertex, and what is the limit?
use std::hint::black_box;
use std::time::Instant;

use fairform::interpolate::{Interpolator, Method, Options};
use fairform::{Corners, Scheme, Topology, Vec3, limit, refine, shapes};

fn time<R>(mut f: impl FnMut() -> R) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let t = Instant::now();
        black_box(f());
        best = best.min(t.elapsed().as_secs_f64());
    }
    best
}

fn main() {
    let arg = std::env::args().nth(1);
    let kinds: &[&str] = if arg.is_some() { &["torus", "ico"] } else { &["torus"] };
    for kind in kinds {
        for side in [100_u32, 400, 1600] {
            let mesh = match *kind {
                "torus" => shapes::torus(side, side),
                _ => {
                    let levels = match side {
                        100 => 5,
                        400 => 7,
                        _ => 9,
                    };
                    refine::refine_mesh(
                        &shapes::icosahedron(),
                        Scheme::Loop,
                        Corners::Smooth,
                        levels,
                    )
                    .unwrap()
                }
            };
            let faces = mesh.topology().to_faces();
            let n = mesh.positions().len();
            let ns = 1e9 / n as f64;
            let t = time(|| Topology::from_faces(n, &faces).unwrap());
            println!("{kind} {n}: topology {:.3} s, {:.1} ns/v", t, t * ns);
            let mut out = 0;
            let t = time(|| {
                let r = refine::refine(mesh.topology(), Scheme::Loop, Corners::Smooth).unwrap();
                let p = r.apply(mesh.positions());
                out = p.len();
                (r.topology, p)
            });
            println!("  refine {:.3} s, {:.1} ns per output v", t, t * 1e9 / out as f64);
            let t = time(|| {
                limit::limit_points(
                    mesh.topology(),
                    mesh.positions(),
                    Scheme::Loop,
                    Corners::Smooth,
                )
            });
            println!("  limit {:.3} s, {:.1} ns/v", t, t * ns);
            let t =
                time(|| Interpolator::new(mesh.topology(), Scheme::Loop, Corners::Smooth).unwrap());
            println!("  prepare {:.3} s, {:.1} ns/v", t, t * ns);
            let it = Interpolator::new(mesh.topology(), Scheme::Loop, Corners::Smooth).unwrap();
            let noisy: Vec<Vec3> = mesh
                .positions()
                .iter()
                .enumerate()
                .map(|(i, &p)| {
                    let r = (i as f64 * 12.9898).sin() * 43758.5453;
                    p + Vec3::splat(0.3 / f64::from(side) * (r - r.floor() - 0.5))
                })
                .collect();
            for method in Method::ALL {
                let options = Options { method, ..Options::default() };
                let mut k = 0;
                let t = time(|| {
                    let (c, r) = it
                        .fit(&noisy, &options, &mut |_, _| std::ops::ControlFlow::Continue(()))
                        .unwrap();
                    k = r.stages[0].solve.last().updates;
                    c
                });
                println!(
                    "  {method}: {k} updates, {:.3} s, {:.1} ns/v, {:.1} per update",
                    t,
                    t * ns,
                    t * ns / f64::from(k + 1)
                );
            }
        }
    }
}
