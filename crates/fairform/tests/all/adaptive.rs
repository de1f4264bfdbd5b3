//! Adaptive tessellation: within the tolerance, without cracks, no finer than it must be.

use std::sync::Arc;

use crate::common::{quad_sheet, quad_torus, random_creases, random_mesh};
use fairform::tessellate::{Adaptive, Eye, Points, Tessellation, Tolerance};
use fairform::{Error, FaceId, Mesh, Rules, Scheme, Topology, Vec3, fairness, shapes};
use proptest::prelude::*;

fn whole(mesh: &Mesh, rules: &Rules, levels: u32) -> Tessellation {
    Tessellation::new(mesh.topology(), rules, levels, Points::Limit).unwrap()
}

fn within(mesh: &Mesh, rules: &Rules, levels: u32, chord: f64) -> Adaptive {
    let tolerance = Tolerance { chord, eye: None };
    let all = whole(mesh, rules, levels);
    all.surface(mesh.positions()).unwrap().adaptive(&tolerance).unwrap()
}

/// As connected as the mesh itself, so without a crack.
fn check_connected(mesh: &Mesh, adaptive: &Adaptive, name: &str) -> Topology {
    let made = Topology::from_faces(adaptive.positions.len(), &adaptive.faces)
        .unwrap_or_else(|e| panic!("{name}: {e}"));
    let given = mesh.topology();
    assert_eq!(made.is_closed(), given.is_closed(), "{name}");
    assert_eq!(made.boundary_loops().len(), given.boundary_loops().len(), "{name}");
    let euler = |t: &Topology| {
        let used = t.vertex_count() - t.isolated_count();
        let count = |n: usize| i64::try_from(n).unwrap();
        count(used + t.face_count()) - count(t.edge_count())
    };
    assert_eq!(euler(&made), euler(given), "{name}");
    assert_eq!(made.isolated_count(), given.isolated_count(), "{name}: every point is used");
    assert_eq!(adaptive.normals.len(), adaptive.positions.len());
    assert_eq!(adaptive.origin.len(), adaptive.faces.len());
    made
}

fn largest_distance(points: &[Vec3], adaptive: &Adaptive) -> f64 {
    let mesh = Mesh::new(adaptive.positions.clone(), &adaptive.faces).unwrap();
    fairness::deviation(points, &mesh).max
}

/// Finely curved at one end and nearly flat at the other.
fn horn(n: u32) -> Mesh {
    shapes::sheet(n, n, |x, y| 0.4 * libm::exp(-8.0 * (x * x + y * y)))
}

fn cases() -> Vec<(&'static str, Mesh, Rules)> {
    let creases = |mesh: &Mesh, scheme: Scheme| Rules {
        creases: Some(Arc::new(random_creases(mesh.topology(), 7, 20))),
        ..scheme.into()
    };
    let (torus, quads) = (shapes::torus(5, 8), quad_torus(5, 8));
    let creased = creases(&torus, Scheme::Loop);
    let creased_quads = creases(&quads, Scheme::CatmullClark);
    vec![
        ("octahedron", shapes::octahedron(), Rules::LOOP),
        ("horn", horn(6), Rules::LOOP),
        ("torus", torus.clone(), Rules::LOOP),
        ("creased torus", torus, creased),
        ("fan", shapes::fan(9), Rules::LOOP),
        ("cube", shapes::cube(), Scheme::CatmullClark.into()),
        ("quads", quads.clone(), Scheme::CatmullClark.into()),
        ("creased quads", quads, creased_quads),
        ("open quads", quad_sheet(4, 6), Scheme::CatmullClark.into()),
    ]
}

#[test]
fn no_cracks_at_any_tolerance() {
    for (name, mesh, rules) in cases() {
        let unit = mesh.bounds().diagonal();
        let counts: Vec<usize> = [1e-5, 1e-4, 5e-4, 2e-3, 1e-2, 1.0]
            .into_iter()
            .map(|tolerance| {
                let adaptive = within(&mesh, &rules, 4, tolerance * unit);
                check_connected(&mesh, &adaptive, name);
                adaptive.faces.len()
            })
            .collect();
        assert!(counts.is_sorted_by(|a, b| a >= b), "{name}: {counts:?}");
        let base = whole(&mesh, &rules, 4).base().face_count();
        assert_eq!(*counts.last().unwrap(), base, "{name}: as coarse as it gets");
    }
}

#[test]
fn a_tolerance_of_nothing_gives_everything() {
    // Straight creases need no points, nor do straight boundaries.
    let is_curved =
        |name: &str| !["fan", "open quads"].contains(&name) && !name.contains("creased");
    for (name, mesh, rules) in cases().into_iter().filter(|c| is_curved(c.0)) {
        let all = whole(&mesh, &rules, 3);
        let surface = all.surface(mesh.positions()).unwrap();
        let adaptive = surface.adaptive(&Tolerance::default()).unwrap();
        let (positions, normals) = surface.points_and_normals();
        assert!(adaptive.positions == positions && adaptive.normals == normals, "{name}");
        let triangles = |faces: &fairform::Faces| faces.iter().map(|f| f.len() - 2).sum::<usize>();
        assert_eq!(triangles(&adaptive.faces), triangles(&all.faces()), "{name}");
        assert_eq!(adaptive.at_limit, all.base().face_count(), "{name}");
    }
}

#[test]
fn the_surface_is_within_the_tolerance() {
    for (name, mesh, rules) in cases() {
        let points = whole(&mesh, &rules, 4).surface(mesh.positions()).unwrap().points();
        for tolerance in [3e-4, 2e-3, 1e-2] {
            let chord = tolerance * mesh.bounds().diagonal();
            let adaptive = within(&mesh, &rules, 4, chord);
            let error = largest_distance(&points, &adaptive);
            assert!(error <= chord * (1.0 + 1e-9), "{name}: {error:e} for {chord:e}");
        }
    }
}

#[test]
fn what_is_flat_stays_coarse() {
    let flat = shapes::sheet(12, 17, |_, _| 0.0);
    let all = whole(&flat, &Rules::LOOP, 4);
    let adaptive = within(&flat, &Rules::LOOP, 4, 1e-9);
    // The outline is curved at the corners, and beside it points move within the plane.
    assert!(adaptive.faces.len() < all.face_count() / 4);
    let mesh = horn(12);
    let adaptive = within(&mesh, &Rules::LOOP, 4, 1e-3);
    let fine = adaptive.faces.len();
    assert!(fine < whole(&mesh, &Rules::LOOP, 4).face_count() / 2, "{fine}");
    assert_eq!(adaptive.at_limit, 0);
}

#[test]
fn faces_keep_their_side() {
    for (name, mesh, rules) in cases().into_iter().filter(|c| !c.0.contains("creased")) {
        let adaptive = within(&mesh, &rules, 4, 1e-3 * mesh.bounds().diagonal());
        for (f, face) in adaptive.faces.iter().enumerate() {
            let [a, b, c] = [0, 1, 2].map(|i| adaptive.positions[face[i] as usize]);
            let normal = (b - a).cross(c - a);
            let own: Vec3 = face.iter().map(|&v| adaptive.normals[v as usize]).sum();
            assert!(normal.dot(own) > 0.0, "{name}: face {f}");
        }
    }
}

#[test]
fn vertices_stay_and_origins_are_told() {
    let mesh = horn(6);
    let all = whole(&mesh, &Rules::LOOP, 3);
    let adaptive = within(&mesh, &Rules::LOOP, 3, 1e-3);
    let limit =
        fairform::limit::limit_points(mesh.topology(), mesh.positions(), &Rules::LOOP).unwrap();
    for (v, p) in limit.iter().enumerate() {
        assert!((adaptive.positions[v] - *p).length() < 1e-13);
    }
    // A corner of the base that a face of the result has belongs to the face of the base it says.
    for (face, &origin) in adaptive.faces.iter().zip(&adaptive.origin) {
        let corners = all.base().face_vertices(FaceId(origin));
        let of_base = face.iter().filter(|&&v| (v as usize) < all.base().vertex_count());
        of_base.for_each(|v| assert!(corners.iter().any(|c| c.0 == *v)));
    }
}

#[test]
fn far_from_the_eye_less_is_enough() {
    let mesh = shapes::torus(12, 24);
    let all = whole(&mesh, &Rules::LOOP, 4);
    let surface = all.surface(mesh.positions()).unwrap();
    let position = 1.2 * mesh.bounds().max;
    let seen = |per_distance| {
        let eye = Some(Eye { position, per_distance });
        surface.adaptive(&Tolerance { chord: 0.0, eye }).unwrap()
    };
    let adaptive = seen(1e-3);
    check_connected(&mesh, &adaptive, "seen");
    let mut near_and_far = [(0, 0.0), (0, 0.0)];
    for face in adaptive.faces.iter() {
        let middle = face.iter().map(|&v| adaptive.positions[v as usize]).sum::<Vec3>() / 3.0;
        let area = {
            let [a, b, c] = [0, 1, 2].map(|i| adaptive.positions[face[i] as usize]);
            (b - a).cross(c - a).length()
        };
        let is_far = (middle - position).length() > position.length();
        let slot = &mut near_and_far[usize::from(is_far)];
        *slot = (slot.0 + 1, slot.1 + area);
    }
    let [near, far] = near_and_far.map(|(count, area)| area / f64::from(count));
    assert!(far > 1.5 * near, "{far} against {near}");
    assert!(seen(3e-3).faces.len() < adaptive.faces.len());
}

#[test]
fn threads_do_not_change_the_bits() {
    let mesh = shapes::torus(40, 60);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| within(&mesh, &Rules::LOOP, 3, 1e-3))
    };
    let one = on(1);
    assert!(one.faces.len() > 20_000);
    for threads in [2, 3] {
        assert!(on(threads) == one, "{threads} threads");
    }
}

#[test]
fn errors_say_what_is_wrong() {
    let mesh = shapes::octahedron();
    let all = whole(&mesh, &Rules::LOOP, 3);
    let surface = all.surface(mesh.positions()).unwrap();
    for chord in [-1.0, f64::NAN, f64::INFINITY] {
        let error = surface.adaptive(&Tolerance { chord, eye: None }).unwrap_err();
        assert!(matches!(error, Error::BadOption { what: "the chord error", .. }), "{error}");
    }
    let eye = Eye { position: Vec3::new(f64::NAN, 0.0, 0.0), per_distance: 1.0 };
    assert!(surface.adaptive(&Tolerance { chord: 0.0, eye: Some(eye) }).is_err());
    let eye = Eye { position: Vec3::ZERO, per_distance: -1.0 };
    assert!(surface.adaptive(&Tolerance { chord: 0.0, eye: Some(eye) }).is_err());
    let all = whole(&mesh, &Scheme::Butterfly.into(), 3);
    let error = all.surface(mesh.positions()).unwrap().adaptive(&Tolerance::default());
    assert!(matches!(error, Err(Error::NotForScheme { .. })));
    // Nothing to cut: the mesh itself.
    let adaptive = within(&mesh, &Rules::LOOP, 0, 0.1);
    assert_eq!(adaptive.faces, mesh.topology().to_faces());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn any_mesh_at_any_tolerance(
        seed in 0_u64..1 << 40, splits in 0_usize..30, holes in 0_usize..6, sharp in 0_u64..20,
        tolerance in 1e-5..0.1_f64, levels in 1_u32..5,
    ) {
        let mesh = random_mesh(seed, splits, holes);
        let creases = Some(Arc::new(random_creases(mesh.topology(), seed, sharp)));
        let chord = tolerance * mesh.bounds().diagonal();
        for scheme in [Scheme::Loop, Scheme::CatmullClark] {
            let rules = Rules { creases: creases.clone(), ..scheme.into() };
            let adaptive = within(&mesh, &rules, levels, chord);
            check_connected(&mesh, &adaptive, "random");
        }
    }
}
