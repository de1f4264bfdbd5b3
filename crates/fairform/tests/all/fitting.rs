//! Interpolation: it interpolates, at the speed that theory promises, whatever the numbering, the
//! affine frame or the number of threads.

use std::ops::ControlFlow;

use crate::common::{assert_near, assorted, random_mesh};
use fairform::interpolate::{
    FitReport, Interpolator, Method, Norm, Options, StageName, interpolate,
};
use fairform::refine::refine_mesh;
use fairform::solve::{Outcome, Step};
use fairform::{Corners, Error, FaceId, Faces, Mesh, Rules, Topology, Vec3, limit, shapes};
use proptest::prelude::*;

fn fit(target: &Mesh, options: &Options) -> (Mesh, FitReport) {
    interpolate(target, &Rules::LOOP, options).expect("a triangle mesh")
}

fn check_fit(target: &Mesh, rules: &Rules, options: &Options, name: &str) {
    let (control, report) = interpolate(target, rules, options).expect("a triangle mesh");
    assert!(report.is_converged(), "{name} {}: {:?}", options.method, report.stages);
    let limit = limit::limit_points(control.topology(), control.positions(), rules).unwrap();
    let worst =
        limit.iter().zip(target.positions()).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
    let tolerance = options.tolerance.unwrap();
    assert!(worst <= 1.01 * tolerance * report.unit, "{name} {}: {worst:e}", options.method);
    for stage in &report.stages {
        let predicted = stage.solve.predicted.unwrap();
        let made = stage.solve.last().updates;
        if options.method != Method::Auto {
            // The prediction is of the asymptotic phase, from bounds.
            assert!(made <= predicted + predicted / 2 + 10, "{name}: {made} against {predicted}");
        }
    }
}

#[test]
fn every_method_interpolates_every_mesh() {
    for (name, mesh) in assorted() {
        for corners in [Corners::Smooth, Corners::Sharp] {
            for method in Method::ALL {
                let rules = Rules { corners, ..Rules::LOOP };
                check_fit(&mesh, &rules, &Options { method, ..Options::default() }, name);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn every_method_interpolates_random_meshes(
        seed: u64, splits in 0..80_usize, holes in 0..12_usize,
    ) {
        let mesh = random_mesh(seed, splits, holes);
        for method in Method::ALL {
            check_fit(&mesh, &Rules::LOOP, &Options { method, ..Options::default() }, "random");
        }
    }
}

/// The slowest mode of a 3-coloured torus has eigenvalue 1/4, so the plain process leaves 3/4 of it.
#[test]
fn the_regular_torus_contracts_by_three_quarters() {
    let torus = shapes::torus(6, 9);
    let wave = |i: usize| {
        let (row, column) = (i / 9, i % 9);
        let colour = (row + column) % 3;
        Vec3::splat(if colour == 0 { 1.0 } else { -0.5 })
    };
    let slow: Vec<Vec3> = (0..54).map(wave).collect();
    let image = limit::limit_points(torus.topology(), &slow, &Rules::LOOP).unwrap();
    let quarter: Vec<Vec3> = slow.iter().map(|&p| 0.25 * p).collect();
    assert_near(&image, &quarter, 1e-15, "eigenvector");

    let target: Vec<Vec3> = torus.positions().iter().zip(&slow).map(|(&p, &s)| p + s).collect();
    let options =
        Options { method: Method::Plain, tolerance: None, iterations: 60, ..Options::default() };
    let (_, report) = fit(&torus.with_positions(target), &options);
    let history = &report.stages[0].solve.history;
    let factor = history[60].max / history[59].max;
    assert!((factor - 0.75).abs() < 1e-6, "{factor}");
}

#[test]
fn stages_are_as_published() {
    let names = |mesh: &Mesh| {
        let (_, report) = fit(mesh, &Options::default());
        report.stages.iter().map(|s| (s.name, s.vertex_count)).collect::<Vec<_>>()
    };
    assert_eq!(names(&shapes::icosahedron()), [(StageName::Closed, 12)]);
    assert_eq!(names(&shapes::fan(5)), [(StageName::Boundary, 5), (StageName::Interior, 1)]);
    assert_eq!(names(&crate::common::triangle()), [(StageName::Boundary, 3)]);
    assert_eq!(
        names(&crate::common::several()),
        [(StageName::Boundary, 5), (StageName::Interior, 13)]
    );
    let points = Mesh::new(vec![Vec3::ZERO, Vec3::splat(1.0)], &Faces::new()).unwrap();
    assert_eq!(names(&points), []);
}

#[test]
fn isolated_vertices_stay() {
    let several = crate::common::several();
    let (control, _) = fit(&several, &Options::default());
    for v in several.topology().vertices().filter(|&v| several.topology().is_isolated(v)) {
        assert_eq!(control.positions()[v.index()], several.positions()[v.index()]);
    }
}

/// Fitting commutes with affine maps, and with renumbering.
#[test]
fn neither_frame_nor_numbering_matters() {
    let map =
        |p: Vec3| Vec3::new(3.0 * p.x - p.y + 7.0, 0.5 * p.z + p.x, 1e3 - 2.0 * p.y + 0.1 * p.z);
    // A count, not a tolerance: the norm is not affine invariant.
    let options = Options { tolerance: None, iterations: 60, ..Options::default() };
    for (name, mesh) in assorted() {
        let (control, _) = fit(&mesh, &options);
        let mapped = mesh.with_positions(mesh.positions().iter().map(|&p| map(p)).collect());
        let (other, _) = fit(&mapped, &options);
        let expected: Vec<Vec3> = control.positions().iter().map(|&p| map(p)).collect();
        assert_near(other.positions(), &expected, 1e-12, name);

        let n = mesh.positions().len() as u32;
        let relabel = |v: u32| (v * 7 + 3) % n;
        if n.is_multiple_of(7) {
            continue;
        }
        let mut positions = vec![Vec3::ZERO; n as usize];
        for (v, &p) in mesh.positions().iter().enumerate() {
            positions[relabel(v as u32) as usize] = p;
        }
        let list = mesh.topology().to_faces();
        let faces: Faces = list
            .iter()
            .rev_by_rotation()
            .map(|f| f.iter().map(|&v| relabel(v)).collect::<Vec<_>>())
            .collect();
        let (other, _) = fit(&Mesh::new(positions, &faces).unwrap(), &options);
        for v in 0..n {
            let (a, b) = (other.positions()[relabel(v) as usize], control.positions()[v as usize]);
            assert!((a - b).length() < 1e-11, "{name} vertex {v}");
        }
    }
}

/// Faces in the opposite order, each begun at its second corner.
trait Rotate {
    fn rev_by_rotation(self) -> std::vec::IntoIter<Vec<u32>>;
}

impl<'a, I: Iterator<Item = &'a [u32]>> Rotate for I {
    fn rev_by_rotation(self) -> std::vec::IntoIter<Vec<u32>> {
        let mut all: Vec<Vec<u32>> = self
            .map(|f| {
                let mut f = f.to_vec();
                f.rotate_left(1);
                f
            })
            .collect();
        all.reverse();
        all.into_iter()
    }
}

fn fingerprint(points: &[Vec3]) -> u64 {
    let bits = points.iter().flat_map(|p| [p.x, p.y, p.z]).map(f64::to_bits);
    // FNV-1a over whole words.
    bits.fold(0xcbf2_9ce4_8422_2325, |hash, word| (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3))
}

/// The same bits on any number of threads, and those that were stored.
#[test]
fn bits_do_not_depend_on_threads() {
    // Larger than several blocks of work, closed and open.
    let closed = refine_mesh(&shapes::icosahedron(), &Rules::LOOP, 5).unwrap().0;
    let open = shapes::sheet(90, 110, |x, y| 0.1 * libm::sin(9.0 * x) * libm::cos(7.0 * y));
    let run = |mesh: &Mesh, method| {
        let positions = mesh.positions();
        let rough = |i: usize| f64::from((i as u32).wrapping_mul(2_654_435_761) >> 20) * 1e-6;
        let target: Vec<Vec3> =
            positions.iter().enumerate().map(|(i, &p)| p + Vec3::splat(rough(i))).collect();
        let mesh = Mesh::new(target, &mesh.topology().to_faces()).unwrap();
        let (control, report) = fit(&mesh, &Options { method, ..Options::default() });
        let surface = refine_mesh(&control, &Rules::LOOP, 1).unwrap().0;
        let (topology, points) = (surface.topology(), surface.positions());
        let normals = limit::limit_normals(topology, points, &Rules::LOOP).unwrap();
        let residuals = Vec3::new(report.max, report.mean, 0.0);
        fingerprint(&[points, &normals, &[residuals]].concat())
    };
    let stored = [
        (&closed, Method::Auto, 0x708d_5288_dcc3_ea1c),
        (&closed, Method::ConjugateGradients, 0x6cff_58ed_5768_3307),
        (&open, Method::Auto, 0x21c5_e5d8_c876_cba2),
        (&open, Method::Plain, 0x8b38_42b7_4489_899a),
    ];
    let expected: Vec<u64> = stored.iter().map(|s| s.2).collect();
    for threads in [1, 2, 3, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let found: Vec<u64> =
            stored.iter().map(|&(mesh, method, _)| pool.install(|| run(mesh, method))).collect();
        assert_eq!(found, expected, "{threads} threads");
    }
}

#[test]
fn not_converging_is_an_answer() {
    let mesh = shapes::icosahedron();
    let options = Options { method: Method::Plain, iterations: 3, ..Options::default() };
    let (_, report) = fit(&mesh, &options);
    assert!(!report.is_converged());
    assert_eq!(report.stages[0].solve.outcome, Outcome::TooManyUpdates);
    assert_eq!(report.stages[0].solve.history.len(), 4);
    assert!(report.max > 1e-6);
    // A tolerance below rounding: the solve sees that nothing gets better, and stops.
    for method in Method::ALL {
        let options = Options { method, tolerance: Some(1e-300), ..Options::default() };
        let (_, report) = fit(&shapes::bipyramid(9), &options);
        assert_eq!(report.stages[0].solve.outcome, Outcome::Stalled, "{method}");
        assert!(report.max < 1e-15, "{method} {}", report.max);
    }
}

#[test]
fn a_fit_can_be_interrupted() {
    let mesh = shapes::torus(5, 7);
    let interpolator = Interpolator::new(mesh.topology(), &Rules::LOOP).unwrap();
    // Factorising is done before the second update.
    for method in &Method::ALL[..5] {
        let method = *method;
        let mut seen = Vec::new();
        let mut stop_at_2 = |_, step: Step| {
            seen.push(step.updates);
            if step.updates == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let options = Options { method, ..Options::default() };
        let end = interpolator.fit(mesh.positions(), &options, &mut stop_at_2);
        assert_eq!(end.unwrap_err(), Error::Interrupted);
        assert_eq!(seen, [0, 1, 2]);
    }
}

#[test]
fn bad_options_are_errors() {
    let mesh = shapes::icosahedron();
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = Options { tolerance: Some(tolerance), ..Options::default() };
        let error = interpolate(&mesh, &Rules::LOOP, &options).unwrap_err();
        assert!(matches!(error, Error::BadOption { .. }), "{tolerance}: {error}");
    }
    let nothing = Mesh::new(vec![], &Faces::new()).unwrap();
    assert_eq!(
        interpolate(&nothing, &Rules::LOOP, &Options::default()).unwrap_err(),
        Error::NoVertices
    );
    let cube = interpolate(&shapes::cube(), &Rules::LOOP, &Options::default()).unwrap_err();
    assert!(cube.to_string().contains("face 0 has 4 corners"), "{cube}");
}

/// Sizes from the smallest to the largest that a double holds.
#[test]
fn scale_does_not_matter() {
    let mesh = shapes::bipyramid(5);
    let (control, _) = fit(&mesh, &Options::default());
    for scale in [1e-300, 1e-40, 1e-7, 1e30, 1e154, 1e300] {
        let scaled = mesh.with_positions(mesh.positions().iter().map(|&p| scale * p).collect());
        for method in Method::ALL {
            let (other, report) = fit(&scaled, &Options { method, ..Options::default() });
            assert!(report.is_converged(), "{method} at {scale:e}");
            let back: Vec<Vec3> = other.positions().iter().map(|&p| p / scale).collect();
            assert_near(&back, control.positions(), 1e-5, "scaled");
        }
    }
    let beyond = mesh.with_positions(mesh.positions().iter().map(|&p| 1e307 * p).collect());
    let error = interpolate(&beyond, &Rules::LOOP, &Options::default()).unwrap_err();
    assert!(matches!(error, Error::Overflow { .. }), "{error}");
}

/// A mesh without extent has residuals of zero in every norm.
#[test]
fn a_mesh_of_one_point_is_its_own_surface() {
    let mesh = shapes::tetrahedron();
    let point = mesh.with_positions(vec![Vec3::new(1.0, 2.0, 3.0); 4]);
    for norm in Norm::ALL {
        let (control, report) = fit(&point, &Options { norm, ..Options::default() });
        assert!(report.is_converged(), "{norm}");
        assert_near(control.positions(), point.positions(), 1e-6, "one point");
    }
}

/// Several sets of values on one topology, prepared once.
#[test]
fn colours_are_fitted_like_positions() {
    let mesh = shapes::tube(5, 9);
    let colours: Vec<Vec3> =
        (0..45).map(|i| Vec3::new(f64::from(i % 3), f64::from(i % 5), f64::from(i % 7))).collect();
    let interpolator = Interpolator::new(mesh.topology(), &Rules::LOOP).unwrap();
    let mut go_on = |_, _| ControlFlow::Continue(());
    let options = Options { norm: Norm::Absolute, tolerance: Some(1e-9), ..Options::default() };
    let (control, _) = interpolator.fit(&colours, &options, &mut go_on).unwrap();
    let limit = limit::limit_points(mesh.topology(), &control, &Rules::LOOP).unwrap();
    assert_near(&limit, &colours, 1e-9, "colours");
}

#[test]
fn names_round_trip() {
    assert!(Method::ALL.into_iter().all(|m| m.name().parse() == Ok(m)));
    assert!(Norm::ALL.into_iter().all(|n| n.name().parse() == Ok(n)));
    assert!("fastest".parse::<Method>().unwrap_err().to_string().contains("plain"));
}

#[test]
fn the_order_in_memory_does_not_matter() {
    let torus = shapes::torus(200, 201);
    let n = torus.positions().len();
    let number = |v: usize| v * 7_919 % n;
    let faces = torus.topology().to_faces();
    let count = faces.len();
    let shuffled: Faces = (0..count)
        .map(|f| faces.get(FaceId((f * 7_919 % count) as u32)))
        .map(|f| f.iter().map(|&v| number(v as usize) as u32).collect::<Vec<_>>())
        .collect();
    let mut positions = vec![Vec3::ZERO; n];
    torus.positions().iter().enumerate().for_each(|(v, &p)| positions[number(v)] = p);
    let topology = Topology::from_faces(n, &shuffled).expect("a torus");
    let options = Options { tolerance: None, iterations: 3, ..Options::default() };
    let mut go_on = |_, _| ControlFlow::Continue(());
    let near = Interpolator::near(&topology, &Rules::LOOP, &positions).expect("triangles");
    let plain = Interpolator::new(&topology, &Rules::LOOP).expect("triangles");
    let (a, _) = near.fit(&positions, &options, &mut go_on).expect("a fit");
    let (b, _) = plain.fit(&positions, &options, &mut go_on).expect("a fit");
    assert!(a == b, "the same bits");
}

/// The iterates of a fit are told by the number of updates, through the stages one after the other.
#[test]
fn iterates_are_counted_through_the_stages() {
    let mesh = shapes::sheet(5, 6, |x, y| (3.0 * x).sin() * y);
    let (topology, target) = (mesh.topology(), mesh.positions());
    let interpolator = Interpolator::new(topology, &Rules::LOOP).unwrap();
    for method in Method::ALL.into_iter().filter(|m| m.name() != "direct") {
        let options = Options { method, tolerance: Some(1e-6), ..Options::default() };
        assert_eq!(interpolator.after(target, &options, 0).unwrap(), target, "{method}");
        let after = |k| interpolator.after(target, &options, k).unwrap();
        let error = |control: &[Vec3], boundary: bool| {
            let limit = limit::limit_points(topology, control, &Rules::LOOP).unwrap();
            let of = topology.vertices().filter(|&v| topology.is_boundary(v) == boundary);
            of.map(|v| (limit[v.index()] - target[v.index()]).length()).fold(0.0, f64::max)
        };
        if method == Method::OnePass {
            // It makes all at once; its iterates are those of another method.
            let auto = Options { method: Method::Auto, ..options };
            assert_eq!(after(3), interpolator.after(target, &auto, 3).unwrap());
            continue;
        }
        let mut go_on = |_, _| ControlFlow::Continue(());
        let (control, report) = interpolator.fit(target, &options, &mut go_on).unwrap();
        let [boundary, interior] = &report.stages[..] else { panic!("two stages") };
        let first = boundary.solve.last().updates;
        assert_eq!(after(first + interior.solve.last().updates), control, "{method}");
        assert_eq!(after(u32::MAX), control, "{method}");
        for (stage, before, is_boundary) in [(boundary, 0, true), (interior, first, false)] {
            for step in &stage.solve.history {
                let error = error(&after(before + step.updates), is_boundary) / report.unit;
                assert!((error - step.max).abs() < 1e-12, "{method} {step:?} {error:e}");
            }
        }
    }
}
