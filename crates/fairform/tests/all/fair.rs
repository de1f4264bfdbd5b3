//! Fairing: the least energy of the limit surface among all that interpolate.

use std::ops::ControlFlow;

use crate::common::{assert_near, random_mesh};
use fairform::fair::{Energy, energy, fair};
use fairform::interpolate::{Fit, Options, StageName, fit_mesh};
use fairform::pushback::PushBack;
use fairform::refine::refine_mesh;
use fairform::{Corners, Error, Faces, Mesh, Rules, Scheme, Vec3, shapes};
use proptest::prelude::*;

const SCHEMES: [Scheme; 3] = [Scheme::Loop, Scheme::CatmullClark, Scheme::DooSabin];

fn fairest(target: &Mesh, rules: &Rules) -> Fit {
    let options = Options { fair: Some(1.0), ..Options::default() };
    fit_mesh(target, rules, &options, &mut |_, _| ControlFlow::Continue(())).unwrap()
}

/// Every vertex moved by up to `size`, the same way each time.
fn shaken(mesh: &Mesh, size: f64) -> Mesh {
    let shake = |(i, &p): (usize, &Vec3)| {
        let t = 1.0 + i as f64;
        p + size * Vec3::new((37.0 * t).sin(), (53.0 * t).sin(), (71.0 * t).sin())
    };
    mesh.with_positions(mesh.positions().iter().enumerate().map(shake).collect())
}

fn scheme_rules(mesh: &Mesh) -> Vec<Rules> {
    let tension = Some((0..mesh.topology().face_count()).map(|f| 0.3 + 0.1 * (f % 5) as f64));
    let two_phase =
        Rules { tension: tension.map(Iterator::collect), ..Rules::from(Scheme::DooSabin) };
    SCHEMES.map(Rules::from).into_iter().chain([two_phase]).collect()
}

/// At the minimum the energy is level in every direction that keeps the limit points, and grows both
/// ways; the limit points are kept.
fn is_minimum(mesh: &Mesh, rules: &Rules) {
    let fit = fairest(mesh, rules);
    let fairing = fit.report.fairing.unwrap();
    assert!(fairing.after <= fairing.before * (1.0 + 1e-12), "{} {fairing:?}", rules.scheme);
    assert!(fit.report.max < 1e-12, "{} {:e}", rules.scheme, fit.report.max);
    let pushback = PushBack::new(mesh.topology(), rules).unwrap();
    let best = fit.control.positions();
    let mut other: Vec<Vec3> = best.to_vec();
    let topology = &pushback.step().topology;
    for v in topology.vertices().filter(|&v| !topology.is_boundary(v)) {
        other[v.index()] += 0.1 * Vec3::new(f64::from(v.0).sin(), f64::from(v.0 * v.0).cos(), 0.3);
    }
    pushback.correct(mesh.positions(), &mut other);
    let of = |t: f64| {
        let x: Vec<Vec3> = best.iter().zip(&other).map(|(&a, &b)| a + t * (b - a)).collect();
        energy(&pushback, &x, Energy::default()).unwrap()
    };
    let (here, ahead, behind) = (of(0.0), of(1.0), of(-1.0));
    // E(±1) = E(0) ± slope + curvature.
    let (slope, curvature) = (0.5 * (ahead - behind), f64::midpoint(ahead, behind) - here);
    let name = rules.scheme;
    assert!(curvature >= -1e-12 * here, "{name}: {curvature:e}");
    // The gradient was to fall by 1e-8.
    assert!(slope.abs() <= 1e-6 * (curvature * here).sqrt() + 1e-12 * here, "{name}: {slope:e}");
}

#[test]
fn fairing_finds_the_minimum() {
    for mesh in [
        shapes::icosahedron(),
        shapes::bipyramid(20),
        shapes::bipyramid(3),
        shapes::fan(7),
        shapes::sheet(4, 5, |x, y| x * y),
        shapes::cube(),
    ] {
        let mesh = shaken(&mesh, 0.1);
        let is_of_triangles = mesh.topology().uniform_face_size() == Some(3);
        for rules in scheme_rules(&mesh) {
            if rules.scheme != Scheme::Loop || is_of_triangles {
                is_minimum(&mesh, &rules);
            }
        }
    }
}

/// Where more faces than are looked at surround a vertex or a face, fairing still is one.
#[test]
fn hubs_are_fair() {
    for n in [64, 65, 300] {
        let mesh = shaken(&shapes::bipyramid(n), 0.05);
        for rules in scheme_rules(&mesh) {
            let fit = fairest(&mesh, &rules);
            let fairing = fit.report.fairing.unwrap();
            assert!(fairing.after < fairing.before && fairing.updates < 200, "{n}: {fairing:?}");
            assert!(fit.report.max < 1e-12);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn fairing_finds_the_minimum_on_random_meshes(
        seed: u64, splits in 0..20_usize, holes in 0..6_usize,
    ) {
        let mesh = random_mesh(seed, splits, holes);
        for scheme in [Scheme::Loop, Scheme::CatmullClark] {
            is_minimum(&mesh, &Rules::from(scheme));
        }
    }
}

/// A plane lattice is the limit surface of itself, and has no bending.
#[test]
fn planes_have_no_bending() {
    let place = |k: u32| Vec3::new(f64::from(k / 5), f64::from(k % 5), f64::from(k / 5));
    let corners = (0..16).flat_map(|k| {
        let at = 5 * (k / 4) + k % 4;
        [at, at + 5, at + 6, at + 1]
    });
    let faces = Faces::uniform(4, corners.collect());
    let mesh = Mesh::new((0..25).map(place).collect(), &faces).unwrap();
    let rules = Rules { corners: Corners::Sharp, ..Rules::from(Scheme::CatmullClark) };
    let pushback = PushBack::new(mesh.topology(), &rules).unwrap();
    let x = pushback.step().apply(mesh.positions());
    let of = |bending, stretching| energy(&pushback, &x, Energy { bending, stretching }).unwrap();
    assert!(of(1.0, 0.0).abs() < 1e-13, "{:e}", of(1.0, 0.0));
    // On each of 64 faces the squares of two slopes, of half an edge each.
    assert!((of(0.0, 1.0) - 64.0 * (0.5 + 0.25)).abs() < 1e-11);
}

#[test]
fn fair_surfaces_turn_with_the_mesh_and_do_not_know_numbers() {
    let (sin, cos) = (0.6, 0.8);
    let turn = |&p: &Vec3| Vec3::new(cos * p.x - sin * p.y, p.z, -(sin * p.x + cos * p.y));
    let mesh = shaken(&refine_mesh(&shapes::bipyramid(5), &Rules::LOOP, 1).unwrap().0, 0.1);
    let turned = mesh.with_positions(mesh.positions().iter().map(turn).collect());
    let count = mesh.positions().len() as u32;
    // The vertices in the opposite order, each face begun at another corner.
    let mut faces = Faces::new();
    for f in mesh.topology().to_faces().iter() {
        faces.push(&[f[1], f[2], f[0]].map(|v| count - 1 - v));
    }
    let renumbered = Mesh::new(mesh.positions().iter().rev().copied().collect(), &faces).unwrap();
    for rules in SCHEMES.map(Rules::from) {
        let fit = fairest(&mesh, &rules);
        let expected: Vec<Vec3> = fit.control.positions().iter().map(turn).collect();
        assert_near(fairest(&turned, &rules).control.positions(), &expected, 1e-9, "turned");
        let [a, b] = [fit, fairest(&renumbered, &rules)].map(|fit| fit.report.fairing.unwrap());
        assert!((a.before / b.before - 1.0).abs() < 1e-10, "{} {a:?} {b:?}", rules.scheme);
        assert!((a.after / b.after - 1.0).abs() < 1e-10, "{} {a:?} {b:?}", rules.scheme);
    }
}

#[test]
fn fairing_can_be_interrupted() {
    let mesh = shaken(&shapes::icosahedron(), 0.2);
    let options = Options { fair: Some(1.0), ..Options::default() };
    let mut seen = Vec::new();
    let end = fit_mesh(&mesh, &Rules::LOOP, &options, &mut |stage, step| {
        if stage == StageName::Fairing {
            seen.push(step.max);
        }
        if seen.len() == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert_eq!(end.unwrap_err(), Error::Interrupted);
    assert!(seen[1] < seen[0], "{seen:?}");
}

#[test]
fn what_has_no_such_energy_is_an_error() {
    let mesh = shapes::icosahedron();
    let of = |scheme, energy: Energy| {
        let rules = Rules::from(scheme);
        let pushback = PushBack::new(mesh.topology(), &rules).unwrap();
        let mut x = pushback.step().apply(mesh.positions());
        fair(&pushback, &mut x, 1.0, energy, &mut |_| ControlFlow::Continue(())).unwrap_err()
    };
    let error = of(Scheme::Butterfly, Energy::default());
    assert!(matches!(error, Error::NotForScheme { what: "fairing", .. }), "{error}");
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        let error = of(Scheme::Loop, Energy { bending: 1.0, stretching: bad });
        assert!(matches!(error, Error::BadOption { .. }), "{error}");
    }
}
