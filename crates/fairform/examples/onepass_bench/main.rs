//! scratch
use fairform::interpolate::{Interpolator, Method};
use fairform::onepass::{Level, OnePass, Options};
use fairform::{Rules, Vec3, refine, shapes};
use std::ops::ControlFlow;
use std::time::Instant;
fn best<R>(n: usize, mut f: impl FnMut() -> R) -> f64 {
    let mut b = f64::INFINITY;
    for _ in 0..n {
        let t = cpu();
        let r = std::hint::black_box(f());
        b = b.min(cpu() - t);
        drop(r);
    }
    b
}
fn cpu() -> f64 {
    if std::env::var("WALL").is_ok() {
        static START: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);
        return START.elapsed().as_secs_f64();
    }
    let s = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    s.split(' ').next().unwrap().parse::<f64>().unwrap() * 1e-9
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let threads: usize = args.get(1).map_or(1, |s| s.parse().unwrap());
    let side: u32 = args.get(2).map_or(800, |s| s.parse().unwrap());
    let what = args.get(3).cloned().unwrap_or_default();
    let reps: usize = args.get(4).map_or(7, |s| s.parse().unwrap());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let mesh = if what.contains("sphere") { refine::refine_mesh(&shapes::icosahedron(), &Rules::LOOP, 8).unwrap().0 } else { shapes::torus(side, side) };
        let t = mesh.topology();
        let n = t.vertex_count() as f64;
        let points = mesh.positions().to_vec();
        let ns = |s: f64| s * 1e9 / n;
        let sizes: Vec<usize> = if what.contains("sizes") { vec![2048, 4096, 8192, 12288, 16384, 24576, 32768] } else { vec![8192] };
        for size in sizes {
            for (level, steps) in [(Level::Finer, 6), (Level::Finer, 1), (Level::Control, 13)] {
                if what.contains("finer") && level == Level::Control { continue; }
                let o = Options { patch_size: size, steps, level };
                let prep = best(2, || OnePass::new(t, &Rules::LOOP, &o).unwrap());
                let p = OnePass::new(t, &Rules::LOOP, &o).unwrap();
                let mut out = vec![Vec3::splat(1.0); p.result_count()];
                let reused = best(reps, || p.fit_into(&points, &mut out).unwrap());
                let fresh = if what.contains("perf") {0.0} else {best(3, || p.fit(&points).unwrap())};
                let fill = best(reps, || out.fill(Vec3::splat(2.0)));
                let copy = { let src = vec![Vec3::splat(1.0); out.len()]; best(reps, || out.copy_from_slice(&src)) };
                println!("fill {:.1} copy {:.1}", ns(fill), ns(copy));
                let (bytes, copies) = p.patch_bytes();
                println!("{level:?} size {size}: prep {:.1} fit_into {:.1} fit {:.1}; {:.1} B/v, halo {copies:.3}", ns(prep), ns(reused), ns(fresh), bytes as f64 / n);
            }
        }
        if what.contains("ref") {
            let prep = best(2, || Interpolator::new(t, &Rules::LOOP).unwrap());
            let i = Interpolator::new(t, &Rules::LOOP).unwrap();
            println!("interpolator prep {:.1}", ns(prep));
            for method in [Method::Auto, Method::Plain, Method::ConjugateGradients] {
                let options = fairform::interpolate::Options { method, ..Default::default() };
                let s = best(3, || i.fit(&points, &options, &mut |_, _| ControlFlow::Continue(())).unwrap());
                println!("{method}: {:.1}", ns(s));
            }
        }
    });
}
