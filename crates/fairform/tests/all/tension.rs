//! Shape parameters of Loop and Catmull–Clark: a first step in two phases.

use crate::common::{
    assert_near, assorted, check_fit, check_step, limit_points, polygons, prism, quad_sheet,
    quad_torus, random_creases, random_mesh, smallest_pivot,
};
use fairform::interpolate::{Method, Options, fit_mesh, interpolate};
use fairform::pushback::singular_components;
use fairform::refine::{refine, refine_mesh};
use fairform::scheme::{catmull_clark, loop_scheme};
use fairform::{Corners, Error, Mesh, Rules, Scheme, Topology, Vec3, VertexId, limit, shapes};
use proptest::prelude::*;
use std::ops::ControlFlow;

const SPLIT: [Scheme; 2] = [Scheme::Loop, Scheme::CatmullClark];

fn with(rules: impl Into<Rules>, lambda: Vec<f64>) -> Rules {
    Rules { tension: Some(lambda.into()), ..rules.into() }
}

fn uniform(scheme: Scheme, mesh: &Mesh, lambda: f64) -> Rules {
    with(scheme, vec![lambda; mesh.topology().face_count()])
}

/// A parameter in `[low, 1]` for each face, both ends among them.
fn random_tension(topology: &Topology, seed: u64, low: f64) -> Vec<f64> {
    let random = |f: usize| {
        let hash = (f as u64 + 1).wrapping_mul(seed | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
        (hash % 9) as f64 / 8.0
    };
    (0..topology.face_count()).map(|f| low + (1.0 - low) * random(f)).collect()
}

/// Triangle and polygon meshes with the schemes that they suit.
fn suited() -> Vec<(Scheme, &'static str, Mesh)> {
    let triangles = assorted().into_iter().map(|(name, mesh)| (Scheme::Loop, name, mesh));
    let polygons = polygons().into_iter().map(|(name, mesh)| (Scheme::CatmullClark, name, mesh));
    triangles.chain(polygons).collect()
}

/// With and without sharp corners and creases.
fn variants(scheme: Scheme, topology: &Topology, seed: u64) -> Vec<Rules> {
    let creases = Some(random_creases(topology, seed, 30).into());
    let smooth = Rules::from(scheme);
    vec![
        smooth.clone(),
        Rules { corners: Corners::Sharp, ..smooth.clone() },
        Rules { creases, ..smooth },
    ]
}

/// Two faces of a mesh glued on all sides; their inner edges have the same ends after a step.
fn is_odd(name: &str) -> bool {
    name == "back to back"
}

#[test]
fn one_half_is_the_plain_scheme() {
    for (scheme, name, mesh) in suited() {
        let topology = mesh.topology();
        for plain in variants(scheme, topology, 5) {
            let half = with(plain.clone(), vec![0.5; topology.face_count()]);
            let apply = |rules| refine(topology, rules).unwrap().apply(mesh.positions());
            assert_near(&apply(&half), &apply(&plain), 4e-15, name);
            assert_near(&limit_points(&mesh, &half), &limit_points(&mesh, &plain), 4e-15, name);
            let normals = |rules| limit::limit_normals(topology, mesh.positions(), rules).unwrap();
            for (v, (a, b)) in normals(&half).iter().zip(normals(&plain)).enumerate() {
                // The convention for two faces of a Loop boundary depends on the level.
                let v = VertexId(v as u32);
                let is_convention = is_odd(name)
                    || scheme == Scheme::Loop
                        && topology.is_boundary(v)
                        && topology.fan_size(v) == 2;
                assert!(is_convention || (*a - b).length() < 1e-12, "{name} vertex {v}");
            }
        }
    }
}

#[test]
fn one_is_linear_subdivision_in_the_first_step() {
    for (scheme, name, mesh) in suited() {
        let topology = mesh.topology();
        for rules in variants(scheme, topology, 6) {
            let rules = with(rules, vec![1.0; topology.face_count()]);
            let found = refine(topology, &rules).unwrap().apply(mesh.positions());
            let at = |v: VertexId| mesh.positions()[v.index()];
            let mut expected = mesh.positions().to_vec();
            expected.extend(topology.edges().map(|e| {
                let h = topology.edge_halfedge(e);
                0.5 * (at(topology.origin(h)) + at(topology.target(h)))
            }));
            if scheme == Scheme::CatmullClark {
                expected.extend(topology.faces().map(|f| {
                    let corners = topology.face_vertices(f);
                    corners.iter().map(|&v| at(v)).sum::<Vec3>() / corners.len() as f64
                }));
            }
            assert_near(&found, &expected, 1e-15, name);
        }
    }
}

/// The closed forms of the limit rows are phase one and then the plain limit rows: where semi-sharp
/// creases have none, too.
#[test]
fn a_step_keeps_the_limit_points() {
    for seed in 1..6 {
        for (scheme, name, mesh) in suited() {
            for rules in variants(scheme, mesh.topology(), seed) {
                if is_odd(name) && rules.creases.is_some() {
                    continue;
                }
                let tension = random_tension(mesh.topology(), seed, 0.5);
                check_step(&mesh, &with(rules, tension), name);
            }
        }
    }
}

/// Limit points are what many steps tend to.
#[test]
fn refined_vertices_tend_to_the_limit_points() {
    for (scheme, name, mesh) in [
        (Scheme::Loop, "bipyramid", shapes::bipyramid(5)),
        (Scheme::Loop, "fan", shapes::fan(5)),
        (Scheme::CatmullClark, "prism", prism(5)),
        (Scheme::CatmullClark, "sheet", quad_sheet(3, 4)),
    ] {
        let rules = with(scheme, random_tension(mesh.topology(), 3, 0.5));
        let limit = limit_points(&mesh, &rules);
        let off = |levels| {
            let (fine, _) = refine_mesh(&mesh, &rules, levels).unwrap();
            let pairs = limit.iter().zip(fine.positions());
            pairs.map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max)
        };
        let (rough, fine) = (off(2), off(6));
        assert!(fine < 1e-3 && fine < rough / 32.0, "{name}: {rough:e}, {fine:e}");
    }
}

/// How far the normals of the next level are from those of a mesh.
fn normals_after_a_step(mesh: &Mesh, rules: &Rules) -> Vec<f64> {
    let here = limit::limit_normals(mesh.topology(), mesh.positions(), rules).unwrap();
    let (fine, next) = refine_mesh(mesh, rules, 1).unwrap();
    let there = limit::limit_normals(fine.topology(), fine.positions(), &next).unwrap();
    here.iter().zip(there).map(|(a, b)| (*a - b).length()).collect()
}

/// Normals belong to the surface: wherever a step of the plain scheme keeps them (not where they are a
/// convention), phase one does.
#[test]
fn a_step_keeps_the_normals() {
    let (mut kept, mut all) = (0, 0);
    for (scheme, name, mesh) in suited() {
        let topology = mesh.topology();
        // Without symmetries, by which wrong normals may be right.
        let shake = |(i, &p): (usize, &Vec3)| {
            let t = i as f64;
            p + 0.1 * Vec3::new(libm::sin(3.0 * t), libm::cos(5.0 * t), libm::sin(7.0 * t))
        };
        let mesh = mesh.with_positions(mesh.positions().iter().enumerate().map(shake).collect());
        for rules in variants(scheme, topology, 9) {
            let plain = normals_after_a_step(&mesh, &rules);
            let rules = with(rules, random_tension(topology, 9, 0.5));
            let tense = normals_after_a_step(&mesh, &rules);
            for (v, off) in tense.iter().enumerate().filter(|(v, _)| plain[*v] < 1e-9) {
                assert!(*off < 1e-9, "{name} vertex {v}: {off:e}");
                kept += 1;
            }
            all += tense.len();
        }
    }
    assert!(kept * 10 > all * 9, "{kept} of {all}");
}

/// The smallest eigenvalues on 2-coloured quadrilateral and 3-coloured triangle tori.
#[test]
fn eigenvalues_of_regular_tori() {
    let colours = |count: usize, f: &dyn Fn(usize) -> f64| -> Vec<Vec3> {
        (0..count).map(|i| Vec3::splat(f(i))).collect()
    };
    let quads = quad_torus(4, 6);
    let checks = colours(24, &|i| if (i / 6 + i % 6) % 2 == 0 { 1.0 } else { -1.0 });
    let triangles = shapes::torus(6, 6);
    let thirds = colours(36, &|i| [1.0, -1.0, 0.0][(i / 6 + i % 6) % 3]);
    for lambda in [0.5, 0.6, 0.75, 1.0] {
        let share = 2.0 * (1.0 - lambda);
        for (scheme, torus, vector, expected, bound) in [
            (
                Scheme::CatmullClark,
                &quads,
                &checks,
                (4.0 - 3.0 * share) / 9.0,
                catmull_clark::two_phase_eigenvalue_bound(4, share),
            ),
            (
                Scheme::Loop,
                &triangles,
                &thirds,
                0.625 - 0.375 * share,
                loop_scheme::two_phase_eigenvalue_bound(6, share),
            ),
        ] {
            let rules = uniform(scheme, torus, lambda);
            let image = limit::limit_points(torus.topology(), vector, &rules).unwrap();
            let scaled: Vec<Vec3> = vector.iter().map(|&p| expected * p).collect();
            assert_near(&image, &scaled, 1e-14, scheme.name());
            assert!((expected - bound).abs() < 1e-15, "the bound is sharp");
        }
    }
    for n in 3..40 {
        let plain = catmull_clark::smallest_eigenvalue_bound(n);
        assert!((catmull_clark::two_phase_eigenvalue_bound(n, 1.0) - plain).abs() < 1e-15);
        let plain = loop_scheme::smallest_eigenvalue_bound(n);
        assert!((loop_scheme::two_phase_eigenvalue_bound(n, 1.0) - plain).abs() < 1e-15);
    }
}

fn is_inner(topology: &Topology, v: VertexId) -> bool {
    !topology.is_boundary(v) && !topology.is_isolated(v)
}

/// Of the interior vertices, `S` with `B = D S`, row by row, and the diagonal of `1/D`.
fn symmetric(mesh: &Mesh, rules: &Rules) -> (Vec<Vec<f64>>, Vec<f64>) {
    let topology = mesh.topology();
    let rows = limit::limit_stencils(topology, rules).unwrap();
    let interior: Vec<_> = topology.vertices().filter(|&v| is_inner(topology, v)).collect();
    let mut matrix = vec![vec![0.0; interior.len()]; interior.len()];
    let mut inverse = Vec::new();
    for (line, &v) in matrix.iter_mut().zip(&interior) {
        let n = topology.fan_size(v);
        let size = f64::from(n);
        inverse.push(match rules.scheme {
            Scheme::Loop => size / (1.0 - loop_scheme::limit_weight(n)),
            _ => size * (size + 5.0),
        });
        let mut sum = 0.0;
        for (q, w) in rows.row(v.index()) {
            assert!(w >= 0.0, "no negative weight");
            sum += w;
            if let Ok(j) = interior.binary_search(&q) {
                line[j] = w * inverse[inverse.len() - 1];
            }
        }
        assert!((sum - 1.0).abs() < 1e-13);
    }
    (matrix, inverse)
}

/// The bound that the documentation proves, of interior vertices.
fn bound(mesh: &Mesh, rules: &Rules) -> f64 {
    let (topology, tension) = (mesh.topology(), rules.tension.as_ref().unwrap());
    let one = |v| {
        let n = topology.fan_size(v);
        let shares = topology.fan(v).map(|h| 2.0 * (1.0 - tension[topology.face(h).index()]));
        let mean = shares.sum::<f64>() / f64::from(n);
        match rules.scheme {
            Scheme::Loop => loop_scheme::two_phase_eigenvalue_bound(n, mean),
            _ => catmull_clark::two_phase_eigenvalue_bound(n, mean),
        }
    };
    topology.vertices().filter(|&v| is_inner(topology, v)).map(one).fold(1.0, f64::min)
}

/// Triangles, quadrilaterals, and polygons of many sizes with valence 4.
fn random_meshes(seed: u64, splits: usize, holes: usize) -> Vec<(Scheme, Mesh)> {
    let triangles = random_mesh(seed, splits, holes);
    let finer = |scheme: Scheme| refine_mesh(&triangles, &scheme.into(), 1).unwrap().0;
    let mut all = vec![
        (Scheme::Loop, triangles.clone()),
        (Scheme::CatmullClark, triangles.clone()),
        (Scheme::CatmullClark, finer(Scheme::CatmullClark)),
        (Scheme::CatmullClark, finer(Scheme::DooSabin)),
    ];
    all.retain(|(_, mesh)| mesh.positions().len() < 300);
    all
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// `B = D S` with nonnegative rows that sum to one, `S` symmetric, and all eigenvalues above the
    /// bound: `S - bound / D` is positive semidefinite.
    #[test]
    fn eigenvalues_keep_their_bounds_for_any_parameters(
        seed: u64, splits in 0..24_usize, holes in 0..5_usize, low in 0.5..0.95_f64,
    ) {
        for (scheme, mesh) in random_meshes(seed, splits, holes) {
            let tension = random_tension(mesh.topology(), seed, low);
            let rules = with(scheme, tension.clone());
            let (matrix, inverse) = symmetric(&mesh, &rules);
            let n = inverse.len();
            let agrees = |i: usize, j: usize| (matrix[i][j] - matrix[j][i]).abs() < 1e-12;
            assert!((0..n).all(|i| (0..i).all(|j| agrees(i, j))), "symmetric");
            let mut rest = matrix.clone();
            let bound = bound(&mesh, &rules);
            for (i, line) in rest.iter_mut().enumerate() {
                line[i] -= (bound - 1e-9) * inverse[i];
            }
            assert!(smallest_pivot(rest) > 0.0, "{scheme}: an eigenvalue below {bound}");

            // More tension on some faces lowers no eigenvalue.
            let tighter = (0..).zip(&tension).map(|(f, &x)| if f % 3 == 0 { 1.0 } else { x });
            let (mut more, _) = symmetric(&mesh, &with(scheme, tighter.collect()));
            for (i, (line, before)) in more.iter_mut().zip(&matrix).enumerate() {
                line.iter_mut().zip(before).for_each(|(x, b)| *x -= b);
                line[i] += 1e-9 * inverse[i];
            }
            assert!(smallest_pivot(more) > 0.0, "{scheme}: tension lowered an eigenvalue");
        }
    }

    #[test]
    fn every_method_interpolates_for_any_parameters(
        seed: u64, splits in 0..24_usize, holes in 0..5_usize, low in 0.55..0.95_f64,
    ) {
        for (scheme, mesh) in random_meshes(seed, splits, holes) {
            let rules = with(scheme, random_tension(mesh.topology(), seed, low));
            check_step(&mesh, &rules, "random");
            for method in Method::ALL {
                let is_refused = scheme == Scheme::Loop && !mesh.topology().is_closed() && {
                    let options = Options { method, ..Options::default() };
                    interpolate(&mesh, &rules, &options).err() == Some(Error::NotSymmetric)
                };
                if !is_refused {
                    check_fit(&mesh, &rules, method, "random");
                }
            }
            // One parameter for all is symmetric on every boundary.
            let rules = uniform(scheme, &mesh, low);
            Method::ALL.iter().for_each(|&m| check_fit(&mesh, &rules, m, "random, uniform"));
        }
    }
}

#[test]
fn every_method_interpolates_every_mesh() {
    for (scheme, name, mesh) in suited() {
        for lambda in [0.6, 0.75, 1.0] {
            let rules = uniform(scheme, &mesh, lambda);
            for method in Method::ALL {
                for corners in [Corners::Smooth, Corners::Sharp] {
                    check_fit(&mesh, &Rules { corners, ..rules.clone() }, method, name);
                }
            }
        }
        // Beside creases that end there is no symmetric operator.
        for seed in 1..5 {
            let creases = Some(random_creases(mesh.topology(), seed, 25).into());
            let rules = Rules { creases, ..scheme.into() };
            let rules = with(rules, random_tension(mesh.topology(), seed, 0.6));
            for method in [Method::Auto, Method::Plain, Method::Chebyshev] {
                check_fit(&mesh, &rules, method, name);
            }
        }
    }
}

/// Conjugate gradients and factorising are refused where no scale makes the rows symmetric, and only
/// there.
#[test]
fn boundaries_with_changing_parameters_are_not_symmetric() {
    let mesh = shapes::sheet(5, 6, |x, y| x * y);
    let topology = mesh.topology();
    let options = Options { method: Method::ConjugateGradients, ..Options::default() };
    let error = |lambda: Vec<f64>| interpolate(&mesh, &with(Rules::LOOP, lambda), &options).err();
    assert_eq!(error(random_tension(topology, 77, 0.5)), Some(Error::NotSymmetric));
    // Only inside.
    let inside = topology.faces().map(|f| {
        let touches = topology.face_vertices(f).iter().any(|&v| topology.is_boundary(v));
        if touches { 0.7 } else { 0.9 }
    });
    assert_eq!(error(inside.collect()), None);
    // On quadrilaterals always.
    let mesh = quad_sheet(5, 6);
    let rules = with(Scheme::CatmullClark, random_tension(mesh.topology(), 77, 0.5));
    check_fit(&mesh, &rules, Method::ConjugateGradients, "quads");
}

/// A cube has no Catmull–Clark control mesh, but one with the slightest tension anywhere.
#[test]
fn tension_makes_the_cube_regular() {
    let cube = shapes::cube();
    let dent = |(i, &p): (usize, &Vec3)| if i == 0 { p - Vec3::splat(0.3) } else { p };
    let dented = cube.with_positions(cube.positions().iter().enumerate().map(dent).collect());
    let mut go_on = |_, _| ControlFlow::Continue(());
    let mut fit =
        |rules: &Rules| fit_mesh(&dented, rules, &Options::default(), &mut go_on).unwrap();
    assert_eq!(fit(&uniform(Scheme::CatmullClark, &dented, 0.5)).level, 1);
    let found = fit(&uniform(Scheme::CatmullClark, &dented, 0.6));
    assert_eq!((found.level, found.singular.len()), (0, 0));
    assert!(found.report.is_converged() && found.report.max <= 1e-6);

    let mut one = vec![0.5; 6];
    let singular = |one: &[f64]| {
        singular_components(cube.topology(), &with(Scheme::CatmullClark, one.to_vec())).len()
    };
    assert_eq!(singular(&one), 1);
    one[2] = 0.9;
    assert_eq!(singular(&one), 0);
    let (matrix, _) = symmetric(&cube, &with(Scheme::CatmullClark, one));
    assert!(smallest_pivot(matrix) > 0.1);
}

/// A parameter acts near its face only: control points far away hardly move.
#[test]
fn a_parameter_acts_locally() {
    for scheme in SPLIT {
        let torus = if scheme == Scheme::Loop { shapes::torus(24, 24) } else { quad_torus(24, 24) };
        let fit = |one: f64| {
            let mut tension = vec![0.5; torus.topology().face_count()];
            tension[0] = one;
            let options = Options { tolerance: Some(1e-13), ..Options::default() };
            interpolate(&torus, &with(scheme, tension), &options).unwrap().0.into_positions()
        };
        let (a, b) = (fit(0.5), fit(0.9));
        let ring = |v: usize| {
            let far = |k: usize| if k == 0 { 0 } else { (k - 1).min(24 - k) };
            far(v / 24).max(far(v % 24))
        };
        let change = |at: usize| {
            let of = (0..576).filter(|&v| ring(v) == at).map(|v| (a[v] - b[v]).length());
            of.fold(0.0, f64::max)
        };
        let near = change(0);
        assert!(near > 1e-4, "{scheme}: {near}");
        for at in 1..8 {
            // The plain inverse falls by 0.263 (Loop) and 0.268 (Catmull–Clark) per ring.
            let most = near * 0.4_f64.powf(at as f64);
            assert!(change(at) < most, "{scheme}, ring {at}: {} of {near}", change(at));
        }
    }
}

/// The tighter, the nearer the surface is to the mesh.
#[test]
fn tension_draws_the_surface_to_the_mesh() {
    for (scheme, mesh) in [(Scheme::Loop, shapes::icosahedron()), (Scheme::CatmullClark, prism(5))]
    {
        let off = |lambda: f64| {
            let rules = uniform(scheme, &mesh, lambda);
            let (control, report) = interpolate(&mesh, &rules, &Options::default()).unwrap();
            assert!(report.is_converged());
            let (fine, next) = refine_mesh(&control, &rules, 3).unwrap();
            fairform::fairness::deviation(&limit_points(&fine, &next), &mesh).max
        };
        let found = [0.55, 0.7, 0.85, 1.0].map(off);
        assert!(found.windows(2).all(|w| w[1] < w[0]), "{scheme}: {found:?}");
    }
}

#[test]
fn parameters_out_of_range_are_named() {
    for (scheme, mesh) in
        [(Scheme::Loop, shapes::octahedron()), (Scheme::CatmullClark, shapes::cube())]
    {
        let topology = mesh.topology();
        for bad in [0.0, 0.49, 1.01, f64::NAN] {
            let mut lambda = vec![0.7; topology.face_count()];
            lambda[4] = bad;
            let error = with(scheme, lambda).check(topology).unwrap_err();
            assert!(matches!(error, Error::BadTension { face, .. } if face.0 == 4));
            let text = error.to_string();
            let words = ["face 4", &bad.to_string(), scheme.name(), "from 0.5 to 1"];
            assert!(words.iter().all(|word| text.contains(word)), "{text}");
        }
        let error = with(scheme, vec![0.5; 3]).check(topology).unwrap_err();
        assert!(matches!(error, Error::WrongCount { .. }), "{error}");
    }
}
