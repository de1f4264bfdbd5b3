//! Exact interpolation in one pass: exact on every mesh, and the same bits however it is cut up.

use std::ops::ControlFlow;
use std::sync::Arc;

use crate::common::{assert_near, assorted, polygons, random_creases, random_mesh};
use fairform::interpolate::{self, Interpolator};
use fairform::onepass::{Level, OnePass, Options};
use fairform::pushback::{PushBack, is_not_definite};
use fairform::refine::refine_mesh;
use fairform::{Border, Corners, Creases, Mesh, Rules, Scheme, Vec3, limit, shapes};
use proptest::prelude::*;

/// Rules of all schemes that a mesh allows, with and without what they have besides.
fn all_rules(mesh: &Mesh) -> Vec<Rules> {
    let topology = mesh.topology();
    let mut all: Vec<Rules> = Vec::new();
    for &scheme in Scheme::ALL {
        for corners in [Corners::Smooth, Corners::Sharp] {
            let plain = Rules { scheme, corners, ..Rules::LOOP };
            let from = |lowest: f64| -> Arc<[f64]> {
                let step = (1.0 - lowest) / 5.0;
                (0..topology.face_count()).map(|f| lowest + step * (f % 5) as f64).collect()
            };
            let lowest = if scheme == Scheme::DooSabin { 0.2 } else { 0.5 };
            all.push(Rules { tension: Some(from(lowest)), ..plain.clone() });
            for seed in [1, 2] {
                let creases: Creases = random_creases(topology, seed, 15);
                let creases = Some(Arc::new(creases));
                all.push(Rules { creases: creases.clone(), ..plain.clone() });
                all.push(Rules { creases, tension: Some(from(0.5)), ..plain.clone() });
            }
            all.push(Rules { border: Border::None, ..plain.clone() });
            all.push(Rules { border: Border::Drop, ..plain.clone() });
            all.push(plain);
        }
    }
    all.retain(|rules| limit::limit_stencils(topology, rules).is_ok());
    all
}

fn meshes() -> Vec<(&'static str, Mesh)> {
    let mut all = assorted();
    all.extend(polygons());
    all.push(("open and closed", crate::common::random_mesh(5, 30, 4)));
    all
}

/// The vertices that are to be met, and what to meet there: support is where its control points take it.
fn wanted(mesh: &Mesh, rules: &Rules) -> Vec<Option<Vec3>> {
    let topology = mesh.topology();
    let surface = rules.has_surface(topology);
    let plain = limit::limit_points(topology, mesh.positions(), rules).unwrap();
    let one = |v: fairform::VertexId| {
        let is_support = rules.border == Border::None
            && topology.is_boundary(v)
            && topology.fan(v).all(|h| !surface[topology.face(h).index()]);
        if rules.scheme == Scheme::DooSabin && topology.is_isolated(v) {
            return None;
        }
        if is_support {
            // A vertex between creases may be either.
            return rules.creases.is_none().then_some(plain[v.index()]);
        }
        Some(mesh.positions()[v.index()])
    };
    topology.vertices().map(one).collect()
}

#[track_caller]
fn check(mesh: &Mesh, rules: &Rules, name: &str) {
    let options = Options { steps: Some(6), ..Options::default() };
    let prepared = OnePass::new(mesh.topology(), rules, &options).unwrap();
    assert_eq!(prepared.is_patched(), !rules.scheme.is_interpolating(), "{name}");
    let (finer, summary) = prepared.fit(mesh.positions()).unwrap();
    let pushback = PushBack::new(mesh.topology(), rules).unwrap();
    let met = pushback.limit_points(&finer);
    let unit = mesh.bounds().diagonal().max(1e-300);
    for (v, goal) in wanted(mesh, rules).into_iter().enumerate() {
        if let Some(goal) = goal {
            let error = (met[v] - goal).length() / unit;
            assert!(error < 1e-13, "{name} {} vertex {v}: {error:e}", rules.scheme);
        }
    }
    // The sweeps do the same, but for rounding to f32 and what they solve first.
    let interpolator = Interpolator::new(mesh.topology(), rules).unwrap();
    let options = interpolate::Options { iterations: 6, tolerance: None, ..Default::default() };
    let mut go_on = |_, _| ControlFlow::Continue(());
    let swept = interpolator.fit_exactly(&pushback, mesh.positions(), &options, &mut go_on);
    let (swept, report) = swept.unwrap();
    let single = report.stages.len() < 2 && !is_not_definite(mesh.topology(), rules);
    let tolerance = if single { 2e-6 } else { 0.3 };
    assert_near(&finer, &swept, tolerance, name);
    if single && !rules.scheme.is_interpolating() {
        let pushed = report.pushed_back.unwrap() * report.unit;
        assert!(
            (summary.largest - pushed).abs() < 1e-5 * unit,
            "{name}: {} {pushed}",
            summary.largest
        );
    }
}

#[test]
fn every_mesh_is_met_with_every_scheme() {
    for (name, mesh) in meshes() {
        // Every third, so that it is quick.
        for rules in all_rules(&mesh).into_iter().step_by(3) {
            check(&mesh, &rules, name);
        }
    }
}

/// On any number of threads, with any size of the patches.
fn assert_same_bits(mesh: &Mesh, rules: &Rules, sizes: &[usize], name: &str) {
    for (level, steps) in [(Level::Finer, 6), (Level::Control, 9)] {
        let run = |threads: usize, patch_size, is_near: bool| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let options = Options { steps: Some(steps), patch_size, level };
                let topology = mesh.topology();
                let prepared = match is_near {
                    true => OnePass::near(topology, rules, &options, mesh.positions()).unwrap(),
                    false => OnePass::new(topology, rules, &options).unwrap(),
                };
                assert_eq!(prepared.is_patched(), !rules.scheme.is_interpolating());
                let (values, summary) = prepared.fit(mesh.positions()).unwrap();
                (values, summary.largest)
            })
        };
        let expected = run(1, usize::MAX, false);
        for &size in sizes {
            for threads in [1, 2, 3] {
                for is_near in [false, true] {
                    let found = run(threads, size, is_near);
                    assert!(found == expected, "{name} {} {size} {is_near}", rules.scheme);
                }
            }
        }
    }
}

#[test]
fn results_are_the_same_bits_however_the_mesh_is_cut() {
    for (name, mesh) in meshes().into_iter().step_by(3) {
        for rules in all_rules(&mesh).into_iter().step_by(5) {
            assert_same_bits(&mesh, &rules, &[1, 7], name);
        }
    }
    let torus = shapes::torus(40, 60);
    let quads = refine_mesh(&shapes::cube(), &Rules::from(Scheme::CatmullClark), 4).unwrap().0;
    let sheet = shapes::sheet(40, 30, |x, y| x * y);
    for mesh in [torus, quads, sheet] {
        for rules in all_rules(&mesh).into_iter().step_by(7) {
            assert_same_bits(&mesh, &rules, &[64, 1000], "large");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4))]
    #[test]
    fn random_meshes_are_met(seed: u64, splits in 0..50_usize, holes in 0..10_usize, quads: bool) {
        let mesh = random_mesh(seed, splits, holes);
        let rules = Rules::from(Scheme::CatmullClark);
        let mesh = if quads { refine_mesh(&mesh, &rules, 1).unwrap().0 } else { mesh };
        for rules in all_rules(&mesh) {
            check(&mesh, &rules, "random");
        }
    }
}

/// A vertex with very many faces: sweeps, and as exact.
#[test]
fn very_high_valences_are_met_too() {
    let mesh = shapes::bipyramid(70_000);
    for scheme in [Scheme::Loop, Scheme::CatmullClark] {
        let rules = Rules::from(scheme);
        let prepared = OnePass::new(mesh.topology(), &rules, &Options::default()).unwrap();
        assert!(!prepared.is_patched());
        let (finer, _) = prepared.fit(mesh.positions()).unwrap();
        let met = PushBack::new(mesh.topology(), &rules).unwrap().limit_points(&finer);
        // Sums of so many terms round.
        assert_near(&met, mesh.positions(), 1e-10, "hub");
    }
}

/// Level 0 in one pass agrees with the default method, and says beforehand how well it will do.
#[test]
fn level_0_agrees_with_auto_and_is_certified() {
    use fairform::interpolate::{Method, Options};
    let interpolate = interpolate::interpolate;
    let quads = refine_mesh(&shapes::cube(), &Rules::from(Scheme::CatmullClark), 3).unwrap().0;
    for (name, mesh) in meshes().into_iter().chain([("quads", quads)]) {
        for rules in all_rules(&mesh).into_iter().step_by(3) {
            if rules.scheme.is_interpolating() || is_not_definite(mesh.topology(), &rules) {
                continue;
            }
            let auto = interpolate(&mesh, &rules, &Options::default()).unwrap();
            let one_pass = Options { method: Method::OnePass, ..Options::default() };
            let (control, report) = interpolate(&mesh, &rules, &one_pass).unwrap();
            if !auto.1.is_converged() || auto.1.stages.is_empty() {
                continue;
            }
            assert!(report.is_converged() && report.max <= 1.001e-6, "{name}: {:e}", report.max);
            assert_near(control.positions(), auto.0.positions(), 1e-3, name);
            let certificate = report.certificate.unwrap();
            assert!(certificate.steps <= fairform::interpolate::MOST_STEPS);
            if let Some(condition) = certificate.condition() {
                assert!((1.0..1e6).contains(&condition), "{name}: {condition}");
                // In another norm, and for rounding to f32.
                let bound = 30.0 * certificate.predicted.unwrap() + 1e-6;
                assert!(certificate.residual <= bound, "{name} {}: {certificate:?}", rules.scheme);
            }
        }
    }
}

#[test]
fn size_and_place_do_not_matter() {
    let mesh = shapes::torus(20, 30);
    let prepared = OnePass::new(mesh.topology(), &Rules::LOOP, &Options::default()).unwrap();
    let (expected, summary) = prepared.fit(mesh.positions()).unwrap();
    for scale in [1e-300, 1e-30, 1e30, 1e300] {
        let scaled: Vec<Vec3> = mesh.positions().iter().map(|&p| scale * p).collect();
        let (finer, other) = prepared.fit(&scaled).unwrap();
        let back: Vec<Vec3> = finer.iter().map(|&p| p / scale).collect();
        assert_near(&back, &expected, 1e-7, "scaled");
        assert!((other.largest / scale - summary.largest).abs() < 1e-6, "{scale}");
    }
    for exponent in [-900, 500] {
        let scaled: Vec<Vec3> =
            mesh.positions().iter().map(|&p| libm::ldexp(1.0, exponent) * p).collect();
        let finer = prepared.fit(&scaled).unwrap().0;
        let back: Vec<Vec3> = finer.iter().map(|&p| libm::ldexp(1.0, -exponent) * p).collect();
        assert!(back == expected, "a power of two");
    }
    let far = Vec3::new(1e6, -3e5, 7e4);
    let moved: Vec<Vec3> = mesh.positions().iter().map(|&p| p + far).collect();
    let back: Vec<Vec3> = prepared.fit(&moved).unwrap().0.iter().map(|&p| p - far).collect();
    assert_near(&back, &expected, 1e-7, "moved");
    let mut one = mesh.positions().to_vec();
    one[3].y = f64::MAX;
    assert!(matches!(prepared.fit(&one), Err(fairform::Error::Overflow { .. })));
}

/// Where positions tell nothing of who is whose neighbour, they are not used.
#[test]
fn patches_are_cut_by_any_positions() {
    let mesh = shapes::torus(60, 50);
    let options = Options { patch_size: 300, ..Options::default() };
    let prepared = OnePass::new(mesh.topology(), &Rules::LOOP, &options).unwrap();
    let (expected, copies) = (prepared.fit(mesh.positions()).unwrap().0, prepared.patch_bytes().1);
    let one_place = vec![Vec3::ZERO; 3000];
    let scattered: Vec<Vec3> = (0..3000_usize)
        .map(|i| Vec3::new((i * 7919 % 3001) as f64, (i * 104_729 % 2999) as f64, 0.0))
        .collect();
    let mut broken = mesh.positions().to_vec();
    broken[7] = Vec3::splat(f64::NAN);
    broken[8].x = f64::INFINITY;
    let places = [mesh.positions(), &one_place, &scattered, &broken];
    for (i, positions) in places.into_iter().enumerate() {
        let near = OnePass::near(mesh.topology(), &Rules::LOOP, &options, positions).unwrap();
        assert!(near.fit(mesh.positions()).unwrap().0 == expected, "{i}");
        assert!(near.patch_bytes().1 < 2.0 * copies, "{i}: {}", near.patch_bytes().1);
    }
}

/// A large mesh through the front door, which takes one pass, against sweeps.
#[test]
fn large_meshes_are_fitted_in_one_pass() {
    use fairform::interpolate::{ExactFit, Method, Options, fit_mesh};
    let plain = shapes::torus(160, 130);
    let noisy = |(i, &p): (usize, &Vec3)| (1.0 + 0.002 * libm::sin(i as f64)) * p;
    let mesh = plain.with_positions(plain.positions().iter().enumerate().map(noisy).collect());
    let mut go_on = |_, _| ControlFlow::Continue(());
    let options = Options { exact: true, ..Options::default() };
    let fit = fit_mesh(&mesh, &Rules::LOOP, &options, &mut go_on).unwrap();
    assert_eq!((fit.level, fit.report.stages[0].name.name()), (1, "whole"));
    let surface =
        limit::limit_points(fit.control.topology(), fit.control.positions(), &fit.rules).unwrap();
    let unit = mesh.bounds().diagonal();
    let largest = mesh.positions().iter().zip(&surface).map(|(a, b)| (*a - *b).length());
    let largest = largest.fold(0.0, f64::max) / unit;
    assert!(largest <= 1e-12 && fit.report.max <= 1e-12, "{largest:e} {:e}", fit.report.max);
    // Six updates of the same recurrence.
    let chebyshev = Options { method: Method::Auto, iterations: 6, tolerance: None, ..options };
    let pushback = PushBack::new(mesh.topology(), &Rules::LOOP).unwrap();
    let interpolator = Interpolator::new(mesh.topology(), &Rules::LOOP).unwrap();
    let control = interpolator.fit(mesh.positions(), &chebyshev, &mut go_on).unwrap().0;
    let mut swept = pushback.step().apply(&control);
    pushback.correct(mesh.positions(), &mut swept);
    assert_near(fit.control.positions(), &swept, 1e-6 * unit, "sweeps");
    // Prepared once, for many targets.
    let topology = mesh.topology();
    let mut exact = ExactFit::near(topology, &Rules::LOOP, mesh.positions()).unwrap();
    for targets in [mesh.positions(), plain.positions(), mesh.positions()] {
        let (finer, report) = exact.fit(targets, &options, &mut go_on).unwrap();
        assert!(report.max <= 1e-12);
        assert_eq!(finer == fit.control.positions(), targets == mesh.positions());
    }
}
