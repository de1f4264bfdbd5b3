//! Push-back and fairing: exact interpolation of any mesh, also where the limit operator is singular.

use std::ops::ControlFlow;
use std::sync::Arc;

use crate::common::{assert_near, assorted, random_mesh};
use fairform::interpolate::{Fit, Interpolator, Method, Options, fit_mesh, interpolate};
use fairform::pushback::{PushBack, singular_components};
use fairform::refine::{refine, refine_mesh};
use fairform::{Border, Corners, Creases, Error, Faces, Mesh, Rules, Scheme, Vec3, limit, shapes};
use proptest::prelude::*;

const EXACT: Options = Options {
    method: Method::Auto,
    norm: fairform::interpolate::Norm::Diagonal,
    tolerance: Some(1e-6),
    iterations: 10_000,
    exact: true,
    fair: None,
    energy: fairform::fair::Energy { bending: 1.0, stretching: 0.001 },
};

fn fit(target: &Mesh, rules: &Rules, options: &Options) -> Fit {
    let mut go_on = |_, _| ControlFlow::Continue(());
    fit_mesh(target, rules, options, &mut go_on).unwrap()
}

fn catmull_clark() -> Rules {
    Rules::from(Scheme::CatmullClark)
}

fn prism(n: u32) -> Mesh {
    let corner = |i: u32, z| {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
        Vec3::new(angle.cos(), angle.sin(), z)
    };
    let positions = (0..n).map(|i| corner(i, 0.0)).chain((0..n).map(|i| corner(i, 1.0))).collect();
    let mut faces = Faces::new();
    faces.push(&(0..n).rev().collect::<Vec<_>>());
    faces.push(&(n..2 * n).collect::<Vec<_>>());
    for i in 0..n {
        let j = (i + 1) % n;
        faces.push(&[i, j, j + n, i + n]);
    }
    Mesh::new(positions, &faces).unwrap()
}

/// Every vertex moved by up to `size`, the same way each time.
fn shaken(mesh: &Mesh, size: f64) -> Mesh {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        size * ((state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)
    };
    let shake = |&p: &Vec3| p + Vec3::new(random(), random(), random());
    mesh.with_positions(mesh.positions().iter().map(shake).collect())
}

/// Two meshes beside each other.
fn both(a: &Mesh, b: &Mesh) -> Mesh {
    let positions = [a.positions(), b.positions()].concat();
    let mut faces = a.topology().to_faces();
    for f in b.topology().to_faces().iter() {
        faces.push(&f.iter().map(|v| v + a.positions().len() as u32).collect::<Vec<_>>());
    }
    Mesh::new(positions, &faces).unwrap()
}

fn quads(mesh: &Mesh) -> Mesh {
    refine_mesh(mesh, &catmull_clark(), 1).unwrap().0
}

/// Largest distance of the surface from the target's vertices, over the diagonal: by the limit rows
/// of the control mesh, and for Doo–Sabin by the means of images.
fn error(target: &Mesh, rules: &Rules, fit: &Fit) -> f64 {
    let control = &fit.control;
    let limit = if rules.scheme == Scheme::DooSabin && fit.level == 1 {
        let pushback = PushBack::new(target.topology(), rules).unwrap();
        assert_eq!(&pushback.step().topology, &**control.topology());
        pushback.limit_stencils().apply(control.positions())
    } else {
        limit::limit_points(control.topology(), control.positions(), &fit.rules).unwrap()
    };
    let used = target.topology().vertices().filter(|&v| !target.topology().is_isolated(v));
    let distance =
        |v: fairform::VertexId| (limit[v.index()] - target.positions()[v.index()]).length();
    used.map(distance).fold(0.0, f64::max) / target.bounds().diagonal().max(1e-300)
}

#[track_caller]
fn check(target: &Mesh, rules: &Rules, options: &Options, name: &str) -> Fit {
    let fit = fit(target, rules, options);
    assert_eq!(fit.level, 1, "{name}");
    let error = error(target, rules, &fit);
    assert!(error < 1e-14, "{name} {}: {error:e}", rules.scheme);
    assert!(fit.report.max < 1e-14 && fit.report.is_converged(), "{name}: {:e}", fit.report.max);
    assert!(fit.report.pushed_back.is_some(), "{name}");
    fit
}

/// Rules of all schemes that a mesh allows, with and without what they have besides.
fn all_rules(mesh: &Mesh) -> Vec<Rules> {
    let topology = mesh.topology();
    let mut all: Vec<Rules> = Vec::new();
    for &scheme in Scheme::ALL {
        for corners in [Corners::Smooth, Corners::Sharp] {
            let plain = Rules { scheme, corners, ..Rules::LOOP };
            if scheme == Scheme::DooSabin {
                let tension =
                    (0..topology.face_count()).map(|f| 0.2 + 0.2 * (f % 5) as f64).collect();
                all.push(Rules { tension: Some(tension), ..plain.clone() });
            } else {
                // Every third edge or so, darts and junctions included, some for a while only.
                let mut creases = Creases::smooth(topology);
                for e in topology.edges().filter(|e| e.0 % 7 < 2) {
                    creases.set_edge(e, [f64::INFINITY, 0.5, 1.0, 2.3][e.index() % 4]).unwrap();
                }
                for v in topology.vertices().filter(|v| v.0 % 11 == 3) {
                    creases.set_vertex(v, [f64::INFINITY, 1.5][v.index() % 2]).unwrap();
                }
                let creased = Rules { creases: Some(Arc::new(creases)), ..plain.clone() };
                if !scheme.is_interpolating() {
                    let tension: Arc<[f64]> =
                        (0..topology.face_count()).map(|f| 0.6 + 0.1 * (f % 5) as f64).collect();
                    let tension = Some(tension);
                    all.push(Rules { tension: tension.clone(), ..plain.clone() });
                    all.push(Rules { tension, ..creased.clone() });
                }
                all.push(creased);
            }
            all.push(plain);
        }
    }
    all.retain(|rules| limit::limit_stencils(topology, rules).is_ok());
    all
}

/// Whether the limit surface is one whose energy is known.
fn can_be_fair(rules: &Rules) -> bool {
    !rules.scheme.is_interpolating()
}

fn polygons() -> Vec<(&'static str, Mesh)> {
    let mut all = assorted();
    all.extend([
        ("cube", shapes::cube()),
        ("shaken cube", shaken(&shapes::cube(), 0.3)),
        ("hexagonal prism", shaken(&prism(6), 0.2)),
        ("pentagonal prism", prism(5)),
        ("cube and prism", both(&shapes::cube(), &shaken(&prism(8), 0.1))),
        ("quads", shaken(&quads(&shapes::octahedron()), 0.1)),
        ("open quads", shaken(&quads(&shapes::fan(5)), 0.1)),
    ]);
    all
}

#[test]
fn push_back_is_exact_with_every_scheme_on_every_mesh() {
    for (name, mesh) in polygons() {
        for rules in all_rules(&mesh) {
            let weights = [None, Some(0.5), Some(1.0)];
            for fair in weights.into_iter().filter(|w| w.is_none() || can_be_fair(&rules)) {
                check(&mesh, &rules, &Options { fair, ..EXACT }, name);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn push_back_is_exact_on_random_meshes(
        seed: u64, splits in 0..50_usize, holes in 0..10_usize, quadrilaterals: bool,
    ) {
        let mesh = random_mesh(seed, splits, holes);
        let mesh = if quadrilaterals { shaken(&quads(&mesh), 0.5) } else { mesh };
        for rules in all_rules(&mesh) {
            let fair = can_be_fair(&rules).then_some(0.7);
            check(&mesh, &rules, &Options { fair, ..EXACT }, "random");
        }
    }
}

#[test]
fn singular_components_are_found() {
    let rules = catmull_clark();
    let find = |mesh: &Mesh| singular_components(mesh.topology(), &rules);
    let v = |v: &[u32]| v.iter().map(|&v| fairform::VertexId(v)).collect::<Vec<_>>();
    assert_eq!(find(&shapes::cube()), v(&[0]));
    assert_eq!(find(&prism(6)), v(&[0]));
    assert_eq!(find(&prism(5)), v(&[]), "odd faces");
    assert_eq!(find(&shapes::tetrahedron()), v(&[]), "triangles");
    assert_eq!(find(&quads(&shapes::cube())), v(&[]), "valence 4");
    assert_eq!(find(&both(&both(&prism(4), &prism(3)), &prism(10))), v(&[0, 14]));
    let cube = shapes::cube();
    let mut faces = cube.topology().to_faces();
    faces = faces.iter().skip(1).collect();
    assert_eq!(find(&Mesh::new(cube.positions().to_vec(), &faces).unwrap()), v(&[]), "open");
    let mut creases = Creases::smooth(cube.topology());
    let with =
        |creases: &Creases| Rules { creases: Some(Arc::new(creases.clone())), ..rules.clone() };
    assert_eq!(singular_components(cube.topology(), &with(&creases)), v(&[0]), "nothing sharp");
    creases.set_edge(fairform::EdgeId(5), 3.0).unwrap();
    assert_eq!(singular_components(cube.topology(), &with(&creases)), v(&[]), "a crease");
    assert_eq!(singular_components(cube.topology(), &Rules::from(Scheme::DooSabin)), v(&[]));
}

/// What is found is singular: the alternating vector has no limit; and what is not found is not.
#[test]
fn the_alternating_vector_vanishes_on_the_cube() {
    let cube = shapes::cube();
    let sign = |i: u32| if i.count_ones().is_multiple_of(2) { 1.0 } else { -1.0 };
    let alternating: Vec<Vec3> = (0..8).map(|i| Vec3::splat(sign(i))).collect();
    let limit = limit::limit_points(cube.topology(), &alternating, &catmull_clark()).unwrap();
    assert!(limit.iter().all(|p| p.max_abs() < 1e-16));

    // So a dented cube is out of reach without push-back, and no method hangs with it.
    let target = shaken(&cube, 0.2);
    let few = Options { iterations: 50, ..Options::default() };
    let (_, report) = interpolate(&target, &catmull_clark(), &few).unwrap();
    assert!(report.max > 1e-3, "{}", report.max);
    for method in Method::ALL {
        for tolerance in [Some(1e-6), None] {
            let options = Options { method, tolerance, iterations: 50, ..Options::default() };
            let fit = check(&target, &catmull_clark(), &options, "dented cube");
            assert_eq!(fit.singular, [fairform::VertexId(0)]);
            let size = fit.control.bounds().diagonal() / target.bounds().diagonal();
            assert!(size < 2.0, "{method}: {size}");
        }
    }
}

/// Two squares glued on all sides: four vertices with two faces, and an operator that is not definite,
/// so that the iteration runs away from the control mesh there is.
#[test]
fn where_the_iteration_diverges_it_is_pushed_back() {
    let mut faces = Faces::new();
    faces.push(&[0, 1, 2, 3]);
    faces.push(&[3, 2, 1, 0]);
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [1.0, 1.0, 0.0], [0.1, 1.0, 0.2]];
    let mesh = Mesh::new(positions.map(Vec3::from).to_vec(), &faces).unwrap();
    assert_eq!(singular_components(mesh.topology(), &catmull_clark()), []);
    for method in Method::ALL {
        for tolerance in [Some(1e-6), None] {
            for exact in [false, true] {
                let options = Options { method, tolerance, exact, ..Options::default() };
                let fit = fit(&mesh, &catmull_clark(), &options);
                assert!(
                    fit.report.max < 1e-6,
                    "{method} {tolerance:?} {exact}: {:?}",
                    fit.report.max
                );
                assert!(fit.control.positions().iter().all(|p| p.is_finite()));
            }
        }
    }
}

/// Factorising finds the control mesh that the iterations tend to, in one update or two.
#[cfg(feature = "direct")]
#[test]
fn factorising_is_exact() {
    let options = Options { method: Method::Direct, tolerance: Some(1e-13), ..Options::default() };
    for (name, mesh) in polygons() {
        for rules in all_rules(&mesh) {
            let interpolator = Interpolator::new(mesh.topology(), &rules).unwrap();
            let mut go_on = |_, _| ControlFlow::Continue(());
            let iterated = Options { method: Method::Auto, ..options };
            let expected = interpolator.fit(mesh.positions(), &iterated, &mut go_on);
            match interpolator.fit(mesh.positions(), &options, &mut go_on) {
                Ok((control, report)) => {
                    assert!(report.max < 1e-12, "{name} {}: {:e}", rules.scheme, report.max);
                    let updates = report.stages.iter().map(|s| s.solve.last().updates);
                    assert!(updates.max().unwrap_or(0) <= 5, "{name}");
                    assert_near(&control, &expected.unwrap().0, 1e-10, name);
                }
                Err(Error::NotSymmetric) => {
                    let is_tense = rules.scheme == Scheme::Loop && rules.tension.is_some();
                    let is_open = !mesh.topology().is_closed();
                    assert!(rules.creases.is_some() || (is_tense && is_open), "{name}");
                }
                Err(Error::NotDefinite) => {
                    let singular = singular_components(mesh.topology(), &rules);
                    let two = |v| mesh.topology().fan_size(v) == 2;
                    assert!(!singular.is_empty() || mesh.topology().vertices().any(two), "{name}");
                }
                Err(other) => panic!("{name} {}: {other}", rules.scheme),
            }
        }
    }
}

/// A vertex with very many faces costs no more than its share.
#[test]
fn high_valences_are_no_burden() {
    let mesh = shapes::bipyramid(10_000);
    for rules in [Rules::LOOP, catmull_clark(), Rules::from(Scheme::DooSabin)] {
        let fit = fit(&mesh, &rules, &Options { fair: Some(1.0), ..EXACT });
        // Sums of so many terms round.
        assert!(fit.report.max < 1e-12, "{}: {:e}", rules.scheme, fit.report.max);
    }
}

/// Where push-back is not needed nothing changes, unless it is wanted.
#[test]
fn other_meshes_stay_at_level_0() {
    let mesh = shaken(&quads(&shapes::cube()), 0.1);
    let options = Options::default();
    let fit = fit(&mesh, &catmull_clark(), &options);
    let (control, report) = interpolate(&mesh, &catmull_clark(), &options).unwrap();
    assert_eq!((&fit.control, &fit.report, fit.level), (&control, &report, 0));
    assert_eq!((fit.rules, report.pushed_back), (catmull_clark(), None));
}

/// The more updates, the less there is to push back: in the end it is the refined control mesh.
#[test]
fn many_updates_leave_nothing_to_push_back() {
    for (name, mesh) in polygons() {
        for rules in all_rules(&mesh) {
            if !singular_components(mesh.topology(), &rules).is_empty() {
                continue;
            }
            let fully = Options { tolerance: Some(1e-13), ..Options::default() };
            let (control, report) = interpolate(&mesh, &rules, &fully).unwrap();
            if report.max > 1e-12 {
                continue;
            }
            let step = refine(mesh.topology(), &rules).unwrap();
            let expected = step.apply(control.positions());
            let updates = report.stages.iter().map(|s| s.solve.last().updates).max().unwrap_or(0);
            let many = Options { tolerance: None, iterations: 2 * updates + 20, ..EXACT };
            let fit = check(&mesh, &rules, &many, name);
            assert_near(fit.control.positions(), &expected, 1e-10, name);
            assert_eq!(fit.rules, step.next, "{name}");
            let few = check(&mesh, &rules, &EXACT, name).report.pushed_back.unwrap();
            assert!(few < 0.2 && fit.report.pushed_back.unwrap() < 1e-11, "{name} {few}");
        }
    }
}

/// The closed forms of the correction, by hand.
#[test]
fn corrections_are_as_derived() {
    // Catmull–Clark: V := [n(n+5) P − 4 ΣE − ΣF] / n²; Loop: V + r/β.
    let cube = shaken(&shapes::cube(), 0.3);
    let fit = check(&cube, &catmull_clark(), &EXACT, "cube");
    let (topology, x) = (fit.control.topology(), fit.control.positions());
    for v in cube.topology().vertices() {
        let edges: Vec3 = topology.fan(v).map(|h| x[topology.target(h).index()]).sum();
        let opposite = |h| topology.target(topology.next(h)).index();
        let faces: Vec3 = topology.fan(v).map(|h| x[opposite(h)]).sum();
        let p = (24.0 * cube.positions()[v.index()] + -4.0 * edges - faces) / 9.0;
        assert!((x[v.index()] - p).length() < 1e-14);
    }
    let mesh = shaken(&shapes::icosahedron(), 0.1);
    let pushback = PushBack::new(mesh.topology(), &Rules::LOOP).unwrap();
    let plain = pushback.step().apply(mesh.positions());
    let mut pushed = plain.clone();
    let largest = pushback.correct(mesh.positions(), &mut pushed);
    let limit = limit::limit_points(mesh.topology(), mesh.positions(), &Rules::LOOP).unwrap();
    let beta = fairform::scheme::loop_scheme::limit_weight(5);
    let mut worst: f64 = 0.0;
    for v in 0..12 {
        let r = mesh.positions()[v] - limit[v];
        worst = worst.max(r.length());
        assert!((pushed[v] - (plain[v] + r / beta)).length() < 1e-14);
    }
    assert_eq!(pushed[12..], plain[12..]);
    assert!((largest - worst).abs() < 1e-14);
}

/// In Doo and Sabin's scheme the limit point of a face is its centroid, and vertices become faces: the
/// last ones.
#[test]
fn faces_of_vertices_have_their_centroid_there() {
    for mesh in [shapes::cube(), shaken(&prism(5), 0.2), shaken(&shapes::icosahedron(), 0.1)] {
        let fit = check(&mesh, &Rules::from(Scheme::DooSabin), &EXACT, "closed");
        let (topology, x) = (fit.control.topology(), fit.control.positions());
        let first = mesh.topology().face_count() + mesh.topology().edge_count();
        for v in mesh.topology().vertices() {
            let face = topology.face_vertices(fairform::FaceId(first as u32 + v.0));
            let centroid = face.iter().map(|q| x[q.index()]).sum::<Vec3>() / face.len() as f64;
            assert!((centroid - mesh.positions()[v.index()]).length() < 1e-14);
        }
    }
}

/// Deep refinement goes to the vertices, also where the rows were not asked.
#[test]
fn refined_vertices_converge_to_the_target() {
    for mesh in [shaken(&prism(6), 0.2), shaken(&shapes::sheet(4, 5, |x, y| x * y), 0.1)] {
        for rules in all_rules(&mesh).into_iter().filter(|r| r.scheme != Scheme::DooSabin) {
            let fit = check(&mesh, &rules, &EXACT, "deep");
            let deep = refine_mesh(&fit.control, &fit.rules, 4).unwrap().0;
            let distance = |(a, b): (&Vec3, &Vec3)| (*a - *b).length();
            let pairs = || deep.positions().iter().zip(mesh.positions());
            let worst = pairs().map(distance).fold(0.0, f64::max);
            let before = fit.control.positions().iter().zip(mesh.positions());
            let before = before.map(distance).fold(0.0, f64::max);
            assert!(worst < 0.05 * before + 1e-12, "{}: {worst:e} {before:e}", rules.scheme);
        }
    }
}

/// Other values per vertex come along on the same finer mesh.
#[test]
fn colours_are_pushed_back_like_positions() {
    let cube = shapes::cube();
    let rules = catmull_clark();
    let interpolator = Interpolator::new(cube.topology(), &rules).unwrap();
    let pushback = PushBack::new(cube.topology(), &rules).unwrap();
    let colours: Vec<Vec3> =
        (0..8).map(|i| Vec3::new(f64::from(i % 2), f64::from(i % 3), f64::from(i % 5))).collect();
    let mut go_on = |_, _| ControlFlow::Continue(());
    let (finer, report) =
        interpolator.fit_exactly(&pushback, &colours, &EXACT, &mut go_on).unwrap();
    assert!(report.max < 1e-15);
    assert_near(&pushback.limit_points(&finer), &colours, 1e-15, "colours");
    let options = Options::default();
    let mut stop = |_, _| ControlFlow::Break(());
    let end = interpolator.fit_exactly(&pushback, &colours, &options, &mut stop);
    assert_eq!(end.unwrap_err(), Error::Interrupted);
}

/// ∫ H² over the refined surface, by the cotangent formula on triangles.
fn willmore(fit: &Fit) -> f64 {
    let mesh = refine_mesh(&fit.control, &fit.rules, 2).unwrap().0;
    let (topology, x) = (mesh.topology(), mesh.positions());
    let mut normal = vec![Vec3::ZERO; x.len()];
    let mut area = vec![0.0; x.len()];
    for f in topology.faces() {
        let corners = topology.face_vertices(f);
        for k in 1..corners.len() - 1 {
            let t = [corners[0], corners[k], corners[k + 1]].map(fairform::VertexId::index);
            for i in 0..3 {
                let (a, b, c) = (t[i], t[(i + 1) % 3], t[(i + 2) % 3]);
                let (u, v) = (x[b] - x[a], x[c] - x[a]);
                let twice = u.cross(v).length().max(1e-300);
                area[a] += twice / 6.0;
                let edge = (u.dot(v) / twice) * (x[b] - x[c]);
                normal[b] += 0.25 * edge;
                normal[c] += -0.25 * edge;
            }
        }
    }
    let inner = topology.vertices().filter(|&v| !topology.is_boundary(v));
    inner.map(|v| normal[v.index()].dot(normal[v.index()]) / area[v.index()]).sum()
}

fn with_fairness(target: &Mesh, rules: &Rules, weight: f64) -> Fit {
    fit(target, rules, &Options { fair: Some(weight), ..EXACT })
}

#[test]
fn fairing_lowers_the_energy_of_rough_surfaces_only() {
    let sphere = |mesh: &Mesh| {
        let fine = refine_mesh(mesh, &catmull_clark(), 2).unwrap().0;
        let middle = Vec3::splat(0.5);
        fine.with_positions(fine.positions().iter().map(|&p| (p - middle).normalized()).collect())
    };
    let ball = {
        let fine = refine_mesh(&shapes::icosahedron(), &Rules::LOOP, 2).unwrap().0;
        fine.with_positions(fine.positions().iter().map(|p| p.normalized()).collect())
    };
    for (rules, smooth) in [(Rules::LOOP, ball), (catmull_clark(), sphere(&shapes::cube()))] {
        let energy = |mesh: &Mesh, weight| willmore(&with_fairness(mesh, &rules, weight));
        let ratio = energy(&smooth, 1.0) / energy(&smooth, 0.0);
        assert!((0.95..1.02).contains(&ratio), "smooth {}: {ratio}", rules.scheme);
        let rough = shaken(&smooth, 0.1);
        let ratio = energy(&rough, 1.0) / energy(&rough, 0.0);
        assert!(ratio < 0.97, "rough {}: {ratio}", rules.scheme);
    }
}

#[test]
fn fairing_goes_from_the_plain_interpolant_to_the_fairest() {
    for (name, mesh) in polygons() {
        for rules in all_rules(&mesh).into_iter().filter(can_be_fair) {
            let plain = check(&mesh, &rules, &EXACT, name);
            let mut energies = Vec::new();
            for weight in [0.0, 0.3, 0.7, 1.0] {
                let fit = with_fairness(&mesh, &rules, weight);
                let fairing = fit.report.fairing.unwrap();
                // Rounding in the second correction only.
                if weight == 0.0 {
                    let control = fit.control.positions();
                    assert_near(control, plain.control.positions(), 1e-14, name);
                }
                assert!(fairing.updates < 100, "{name}: {fairing:?}");
                energies.push(fairing.after);
            }
            let falls = energies.windows(2).all(|w| w[1] <= w[0] * (1.0 + 1e-9) + 1e-20);
            assert!(falls, "{name} {}: {energies:?}", rules.scheme);
        }
    }
}

/// The number of updates does not grow with the mesh.
#[test]
fn fairing_is_well_conditioned() {
    for (rules, base) in [(Rules::LOOP, shapes::icosahedron()), (catmull_clark(), shapes::cube())] {
        let updates = |levels| {
            let mesh = shaken(&refine_mesh(&base, &rules, levels).unwrap().0, 0.05);
            with_fairness(&mesh, &rules, 1.0).report.fairing.unwrap().updates
        };
        let (small, large) = (updates(2), updates(4));
        assert!(large <= small + 6 && large < 50, "{}: {small} {large}", rules.scheme);
    }
}

/// Boundaries of patches that share their vertices stay together, whatever lies between.
#[test]
fn boundary_curves_do_not_depend_on_fairing_or_on_the_interior() {
    let mesh = shaken(&shapes::sheet(5, 6, |x, y| x * y), 0.1);
    let mut other = mesh.positions().to_vec();
    let inner = mesh.topology().vertices().filter(|&v| !mesh.topology().is_boundary(v));
    inner.for_each(|v| other[v.index()] += Vec3::splat(0.3));
    let other = mesh.with_positions(other);
    let smooth = |r: &Rules| r.creases.is_none() && can_be_fair(r);
    for rules in all_rules(&mesh).into_iter().filter(smooth) {
        let plain = check(&mesh, &rules, &EXACT, "sheet");
        let fair = with_fairness(&other, &rules, 1.0);
        let topology = plain.control.topology();
        for v in topology.vertices().filter(|&v| topology.is_boundary(v)) {
            let [a, b] = [&plain, &fair].map(|fit| fit.control.positions()[v.index()]);
            assert!((a - b).length() < 1e-13, "{}", rules.scheme);
        }
    }
}

#[test]
fn exact_and_fair_fits_have_the_same_bits_on_any_number_of_threads() {
    let mesh = shaken(&refine_mesh(&shapes::cube(), &catmull_clark(), 5).unwrap().0, 0.02);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| with_fairness(&mesh, &catmull_clark(), 0.8))
    };
    let one = run(1);
    assert!(one.control.positions().len() > 8192, "several blocks of work");
    assert_eq!(one, run(3));
}

#[test]
fn fairness_is_between_0_and_1_at_any_scale() {
    let cube = shaken(&shapes::cube(), 0.1);
    let mut go_on = |_, _| ControlFlow::Continue(());
    for fair in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
        let options = Options { fair: Some(fair), ..Options::default() };
        let error = fit_mesh(&cube, &catmull_clark(), &options, &mut go_on).unwrap_err();
        assert!(matches!(error, Error::BadOption { .. }), "{fair}");
    }
    let expected = with_fairness(&cube, &catmull_clark(), 0.5);
    for scale in [1e-300, 1e-30, 1e100, 1e300] {
        let scaled = cube.with_positions(cube.positions().iter().map(|&p| scale * p).collect());
        let fit = with_fairness(&scaled, &catmull_clark(), 0.5);
        let back: Vec<Vec3> = fit.control.positions().iter().map(|&p| p / scale).collect();
        assert_near(&back, expected.control.positions(), 1e-12, "scaled");
    }
    let point = cube.with_positions(vec![Vec3::splat(3.0); 8]);
    let fit = with_fairness(&point, &catmull_clark(), 1.0);
    assert_near(fit.control.positions(), &vec![Vec3::splat(3.0); 26], 1e-15, "a point");
}

/// Two polygons glued on all sides, with a bumpy rim: `n` vertices with two faces.
fn pillow(n: u32) -> Mesh {
    let mut faces = Faces::new();
    faces.push(&(0..n).collect::<Vec<_>>());
    faces.push(&(0..n).rev().collect::<Vec<_>>());
    let rim = prism(n).positions()[..n as usize].to_vec();
    shaken(&Mesh::new(rim, &faces).unwrap(), 0.2)
}

/// The rim of even polygons can be coloured, and then the form is negative: no update is wasted. That of
/// odd ones cannot, though the form is as bad; the solve gives up soon.
#[test]
fn valence_2_costs_few_updates() {
    for (n, most) in [(4, 7), (6, 7), (5, 200), (7, 200), (9, 200)] {
        let mut seen = 0;
        let mut count = |_, _| {
            seen += 1;
            ControlFlow::Continue(())
        };
        let target = pillow(n);
        let fit = fit_mesh(&target, &catmull_clark(), &Options::default(), &mut count).unwrap();
        assert!(fit.report.max < 1e-13 && fit.level == 1, "{n}: {}", fit.report.max);
        assert!(seen <= most, "{n}: {seen}");
    }
}

/// Support keeps its control points; vertices inside are met, exactly after a push-back.
#[test]
fn support_stays_as_given_and_the_inside_is_met() {
    for (name, mesh) in polygons().into_iter().chain(assorted()) {
        for scheme in [Scheme::CatmullClark, Scheme::Loop] {
            let rules = Rules { border: Border::None, ..scheme.into() };
            if rules.check(mesh.topology()).is_err() {
                continue;
            }
            let target = shaken(&mesh, 0.05);
            let (topology, given) = (target.topology(), target.positions());
            let inside = |v: &fairform::VertexId| !topology.is_boundary(*v);
            let (control, report) = interpolate(&target, &rules, &Options::default()).unwrap();
            let limit = limit::limit_points(topology, control.positions(), &rules).unwrap();
            for v in topology.vertices() {
                let v = (v, v.index());
                if inside(&v.0) && report.is_converged() {
                    let off = (limit[v.1] - given[v.1]).length() / report.unit;
                    assert!(off <= 1e-6, "{name} {scheme} {}: {off}", v.0);
                } else if !inside(&v.0) {
                    assert_eq!(control.positions()[v.1], given[v.1], "{name} {scheme}");
                }
            }
            let pushed = fit(&target, &rules, &EXACT);
            let fine = limit::limit_points(
                pushed.control.topology(),
                pushed.control.positions(),
                &pushed.rules,
            )
            .unwrap();
            let plain = limit::limit_points(topology, given, &rules).unwrap();
            for v in topology.vertices() {
                let expected = if inside(&v) { given[v.index()] } else { plain[v.index()] };
                assert!((fine[v.index()] - expected).length() < 1e-13, "{name} {scheme} {v}");
            }
        }
    }
}
