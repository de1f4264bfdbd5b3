//! Catmull–Clark and Doo–Sabin, shape parameters and creases: what must hold on any mesh.

use crate::common::{
    assert_near, assorted, back_to_back, check_fit, check_step, limit_points, polygons, quad_sheet,
    quad_torus, random_creases, random_mesh,
};
use fairform::interpolate::{Method, Options, interpolate};
use fairform::refine::{refine, refine_mesh};
use fairform::{
    Border, Corners, Creases, Error, Faces, Mesh, Rules, Scheme, Topology, Vec3, VertexId, limit,
};
use proptest::prelude::*;

fn catmull_clark(corners: Corners) -> Rules {
    Rules { corners, ..Scheme::CatmullClark.into() }
}

/// The faces that the definition of Doo–Sabin names: of each face, edge and vertex, in this order.
fn doo_sabin_faces(coarse: &Topology, border: Border) -> (usize, Faces) {
    let bspline = border == Border::Bspline;
    let halfedges = coarse.halfedge_count() as u32;
    let boundary: Vec<_> = coarse.halfedges().filter(|&h| coarse.twin(h).is_none()).collect();
    let at_start = |h| halfedges + 2 * boundary.iter().position(|&b| b == h).unwrap() as u32;
    let mut faces: Faces =
        coarse.faces().map(|f| coarse.face_halfedges(f).map(|h| h.0).collect::<Vec<_>>()).collect();
    for e in coarse.edges() {
        let mut h = coarse.edge_halfedge(e);
        if let Some(t) = coarse.twin(h).filter(|_| coarse.origin(h) > coarse.target(h)) {
            h = t;
        }
        let (a, b) = (h.0, coarse.next(h).0);
        match coarse.twin(h) {
            Some(t) => faces.push(&[b, a, coarse.next(t).0, t.0]),
            None if bspline => faces.push(&[b, a, at_start(h), at_start(h) + 1]),
            None => {}
        }
    }
    for v in coarse.vertices() {
        let mut corners: Vec<u32> = coarse.fan(v).map(|h| h.0).collect();
        if coarse.is_boundary(v) {
            if !bspline {
                continue;
            }
            corners.insert(0, at_start(coarse.outgoing(v).unwrap()));
            let last = coarse.fan(v).last().unwrap();
            corners.push(at_start(coarse.prev(last)) + 1);
        }
        if corners.len() > 2 {
            faces.push(&corners);
        }
    }
    let extra = if bspline { 2 * boundary.len() } else { 0 };
    (halfedges as usize + extra, faces)
}

/// The closed form is what the search finds, also for the step after.
fn check_doo_sabin_topology(mesh: &Mesh, name: &str) {
    for border in [Border::Bspline, Border::Drop] {
        let rules = Rules { border, ..Scheme::DooSabin.into() };
        let mut coarse = mesh.topology().clone();
        for step in 0..2 {
            let (count, faces) = doo_sabin_faces(&coarse, border);
            let found = Topology::from_faces(count, &faces).unwrap();
            let finer = refine(&coarse, &rules).unwrap().topology;
            assert_eq!(finer, found, "{name}, {border:?}, step {step}");
            coarse = finer.into();
        }
    }
}

#[test]
fn doo_sabin_in_closed_form_is_what_the_search_finds() {
    for (name, mesh) in polygons().into_iter().chain(assorted()) {
        check_doo_sabin_topology(&mesh, name);
        // Without some of its faces.
        let list = mesh.topology().to_faces();
        for keep in [2, 3, 5] {
            let faces = list.iter().enumerate().filter(|(f, _)| f % keep != 1).map(|(_, f)| f);
            if let Ok(some) = Mesh::new(mesh.positions().to_vec(), &faces.collect()) {
                check_doo_sabin_topology(&some, name);
            }
        }
    }
    // So large that several threads share the work.
    check_doo_sabin_topology(&quad_torus(40, 80), "large, closed");
    check_doo_sabin_topology(&quad_sheet(40, 80), "large, open");
    // Several edges with the same ends.
    let (doubled, _) = refine_mesh(&back_to_back(), &Scheme::CatmullClark.into(), 1).unwrap();
    check_doo_sabin_topology(&doubled, "doubled edges");
    check_doo_sabin_topology(&Mesh::new(Vec::new(), &Faces::new()).unwrap(), "nothing");
    check_doo_sabin_topology(&Mesh::new(vec![Vec3::ZERO; 3], &Faces::new()).unwrap(), "isolated");
}

/// The dual of a random mesh, without the faces that its boundary would cut: polygons, three or fewer
/// at a vertex.
fn random_polygons(seed: u64, splits: usize, holes: usize) -> Mesh {
    let mesh = random_mesh(seed, splits, holes);
    let topology = mesh.topology();
    let faces: Faces = topology
        .vertices()
        .filter(|&v| !topology.is_boundary(v) && topology.fan_size(v) > 2)
        .map(|v| topology.fan(v).map(|h| topology.face(h).0).collect::<Vec<_>>())
        .collect();
    Mesh::new(vec![Vec3::ZERO; topology.face_count()], &faces).unwrap()
}

#[test]
fn a_step_keeps_the_limit_points() {
    for (name, mesh) in polygons() {
        for corners in [Corners::Smooth, Corners::Sharp] {
            check_step(&mesh, &catmull_clark(corners), name);
        }
        check_step(&mesh, &Scheme::DooSabin.into(), name);
    }
}

#[test]
fn a_step_keeps_the_limit_points_beside_creases() {
    for seed in 1..12 {
        for (name, mesh) in polygons() {
            let creases = Some(random_creases(mesh.topology(), seed, 35).into());
            check_step(&mesh, &Rules { creases, ..catmull_clark(Corners::Smooth) }, name);
        }
        for (name, mesh) in assorted() {
            if name == "back to back" {
                continue;
            }
            let creases = Some(random_creases(mesh.topology(), seed, 35).into());
            check_step(&mesh, &Rules { creases, ..Rules::LOOP }, name);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn a_step_keeps_the_limit_points_of_random_meshes(
        seed: u64, splits in 0..40_usize, holes in 0..9_usize, share in 0..80_u64,
    ) {
        let mesh = random_mesh(seed, splits, holes);
        let creases = Some(random_creases(mesh.topology(), seed, share).into());
        for scheme in [Scheme::Loop, Scheme::CatmullClark] {
            check_step(&mesh, &Rules { creases: creases.clone(), ..scheme.into() }, "random");
        }
        check_step(&mesh, &Scheme::DooSabin.into(), "random");
    }

    #[test]
    fn doo_sabin_in_closed_form_is_what_the_search_finds_on_random_meshes(
        seed: u64, splits in 0..40_usize, holes in 0..20_usize,
    ) {
        check_doo_sabin_topology(&random_mesh(seed, splits, holes), "random");
        check_doo_sabin_topology(&random_polygons(seed, splits, holes), "random polygons");
    }

    /// Whatever the parameters, the two-phase process interpolates, and as fast as promised.
    #[test]
    fn two_phases_interpolate_for_any_parameters(
        seed: u64, splits in 0..30_usize, holes in 0..6_usize, low in 0.05..0.9_f64,
    ) {
        let mesh = random_mesh(seed, splits, holes);
        let count = mesh.topology().face_count();
        let spread = |f: usize| low + (1.0 - low) * ((f * 7 + 3) % 10) as f64 / 10.0;
        let tension: Vec<f64> = (0..count).map(spread).collect();
        let rules = Rules { tension: Some(tension.into()), ..Scheme::DooSabin.into() };
        check_step(&mesh, &rules, "two phases");
        for method in Method::ALL {
            check_fit(&mesh, &rules, method, "two phases");
        }
    }
}

#[test]
fn every_method_interpolates_every_mesh() {
    for (name, mesh) in polygons() {
        for method in Method::ALL {
            check_fit(&mesh, &Scheme::DooSabin.into(), method, name);
            // Closed, 3-valent, bipartite: the operator is singular.
            if !["cube", "prism 6"].contains(&name) {
                check_fit(&mesh, &catmull_clark(Corners::Sharp), method, name);
            }
        }
    }
}

/// The limit curve of a crease passes through the crease's vertices, and the surface through all.
#[test]
fn creases_are_interpolated() {
    for seed in 1..8 {
        for (name, mesh) in polygons() {
            if name == "cube" || name == "prism 6" {
                continue;
            }
            let creases = Some(random_creases(mesh.topology(), seed, 25).into());
            let rules = Rules { creases, ..catmull_clark(Corners::Smooth) };
            check_fit(&mesh, &rules, Method::Auto, name);
        }
        for (name, mesh) in assorted() {
            let creases = Some(random_creases(mesh.topology(), seed, 25).into());
            let rules = Rules { creases, ..Rules::LOOP };
            check_fit(&mesh, &rules, Method::Auto, name);
            check_fit(&mesh, &rules, Method::Chebyshev, name);
        }
    }
}

/// The smallest eigenvalue on 2-coloured quadrilateral tori, by its eigenvector.
#[test]
fn eigenvalues_of_regular_tori() {
    let torus = quad_torus(4, 6);
    let checks: Vec<Vec3> =
        (0..24).map(|i| Vec3::splat(if (i / 6 + i % 6) % 2 == 0 { 1.0 } else { -1.0 })).collect();
    let count = torus.topology().face_count();
    let with = |lambda: f64| Rules {
        tension: Some(vec![lambda; count].into()),
        ..Scheme::DooSabin.into()
    };
    for (rules, expected) in [
        (catmull_clark(Corners::Smooth), 1.0 / 9.0),
        (Scheme::DooSabin.into(), 1.0 / 4.0),
        (with(0.3), 0.3),
        (with(0.8), 0.8),
        (with(1.0), 1.0),
    ] {
        let image = limit::limit_points(torus.topology(), &checks, &rules).unwrap();
        let scaled: Vec<Vec3> = checks.iter().map(|&p| expected * p).collect();
        assert_near(&image, &scaled, 1e-14, rules.scheme.name());
    }
}

/// The uniform B-spline of one unit value, as a product of its univariate values.
#[test]
fn regular_regions_are_b_splines() {
    let (rows, columns, levels) = (9, 11, 3);
    let sheet = quad_sheet(rows, columns);
    let mut positions: Vec<Vec3> =
        sheet.positions().iter().map(|p| Vec3::new(10.0 * p.x, 8.0 * p.y, 0.0)).collect();
    positions[(4 * columns + 5) as usize].z = 1.0;
    let peak = sheet.with_positions(positions);
    let cubic = |x: f64| match x.abs() {
        x if x < 1.0 => 2.0 / 3.0 - x * x + x * x * x / 2.0,
        x if x < 2.0 => (2.0 - x).powf(3.0) / 6.0,
        _ => 0.0,
    };
    let quadratic = |x: f64| match x.abs() {
        x if x < 0.5 => 0.75 - x * x,
        x if x < 1.5 => (1.5 - x).powf(2.0) / 2.0,
        _ => 0.0,
    };
    let (fine, rules) = refine_mesh(&peak, &catmull_clark(Corners::Smooth), levels).unwrap();
    check_spline(&limit_points(&fine, &rules), cubic, 400);
    let (fine, rules) = refine_mesh(&peak, &Scheme::DooSabin.into(), levels).unwrap();
    check_spline(&limit_points(&fine, &rules), quadratic, 400);
}

fn check_spline(points: &[Vec3], basis: impl Fn(f64) -> f64, at_least: usize) {
    let mut checked = 0;
    for p in points.iter().filter(|p| p.x > 2.5 && p.x < 7.5 && p.y > 2.5 && p.y < 5.5) {
        let expected = basis(p.x - 5.0) * basis(p.y - 4.0);
        assert!((p.z - expected).abs() < 1e-14, "at {}, {}: {} not {expected}", p.x, p.y, p.z);
        checked += 1;
    }
    assert!(checked >= at_least, "{checked}");
}

/// Chords of a deep refinement from the limit point become orthogonal to the normal.
#[test]
fn normals_are_orthogonal_to_the_surface() {
    let with_tension = |mesh: &Mesh| Rules {
        tension: Some(vec![0.7; mesh.topology().face_count()].into()),
        ..Scheme::DooSabin.into()
    };
    for (name, mesh) in polygons() {
        let schemes = [
            catmull_clark(Corners::Smooth),
            catmull_clark(Corners::Sharp),
            Scheme::DooSabin.into(),
            with_tension(&mesh),
        ];
        for rules in schemes {
            let (rough, fine) = (spread(&mesh, &rules, 2), spread(&mesh, &rules, 6));
            let what = format!("{name} {} {:?}", rules.scheme, rules.corners);
            assert!(fine < 0.3 && (fine < 0.6 * rough || fine < 1e-12), "{what}: {rough}, {fine}");
        }
    }
}

/// The largest cosine between normals and chords to the nearest limit points.
fn spread(mesh: &Mesh, rules: &Rules, levels: u32) -> f64 {
    let topology = mesh.topology();
    let normals = limit::limit_normals(topology, mesh.positions(), rules).unwrap();
    let at = limit_points(mesh, rules);
    let (fine, next) = refine_mesh(mesh, rules, levels).unwrap();
    let points = limit_points(&fine, &next);
    let size = mesh.bounds().diagonal();
    let mut worst = 0.0_f64;
    for v in topology.vertices().filter(|&v| !topology.is_isolated(v)) {
        if rules.scheme == Scheme::DooSabin {
            // Vertices are not kept: look around the limit point.
            let near = |p: &&Vec3| {
                let far = (**p - at[v.index()]).length() / size;
                far > 1e-9 && far < 0.35 / f64::from(1 << levels)
            };
            for p in points.iter().filter(near) {
                worst = worst.max((*p - at[v.index()]).normalized().dot(normals[v.index()]).abs());
            }
        } else {
            for q in fine.topology().ring(VertexId(v.0)) {
                let chord = (points[q.index()] - at[v.index()]).normalized();
                worst = worst.max(chord.dot(normals[v.index()]).abs());
            }
        }
    }
    worst
}

/// A parameter acts near its face only: the control points far away hardly move.
#[test]
fn a_parameter_acts_locally() {
    let torus = quad_torus(24, 24);
    let fit = |one: f64| {
        let mut tension = vec![0.5; torus.topology().face_count()];
        tension[0] = one;
        let rules = Rules { tension: Some(tension.into()), ..Scheme::DooSabin.into() };
        let options = Options { tolerance: Some(1e-13), ..Options::default() };
        interpolate(&torus, &rules, &options).unwrap().0.into_positions()
    };
    let (a, b) = (fit(0.5), fit(0.9));
    let ring = |v: usize| {
        let (i, j) = (v / 24, v % 24);
        let far = |k: usize| if k == 0 { 0 } else { (k - 1).min(24 - k) };
        far(i).max(far(j))
    };
    let change = |at: usize| {
        let of = (0..576).filter(|&v| ring(v) == at).map(|v| (a[v] - b[v]).length());
        of.fold(0.0, f64::max)
    };
    let near = change(0);
    assert!(near > 1e-4, "{near}");
    for at in 1..8 {
        // The inverse falls by 0.163 and more per ring; so does its effect.
        assert!(change(at) < near * 0.3_f64.powf(at as f64), "ring {at}: {}", change(at));
    }
}

/// Exact fractions for a cube with one sharp edge, by hand.
#[test]
fn creases_by_hand() {
    let cube = fairform::shapes::cube();
    let topology = cube.topology();
    let edge = topology.edges().find(|&e| {
        let h = topology.edge_halfedge(e);
        [topology.origin(h).0, topology.target(h).0].iter().all(|v| *v < 2)
    });
    let edge = edge.expect("the edge between vertices 0 and 1");
    for (sharpness, point) in
        [(0.0, [0.5, 0.125, 0.125]), (0.5, [0.5, 0.0625, 0.0625]), (1.0, [0.5, 0.0, 0.0])]
    {
        let mut creases = Creases::smooth(topology);
        creases.set_edge(edge, sharpness).unwrap();
        let rules = Rules { creases: Some(creases.into()), ..catmull_clark(Corners::Smooth) };
        let step = refine(topology, &rules).unwrap();
        let points = step.apply(cube.positions());
        assert_eq!(points[8 + edge.index()], Vec3::from(point), "sharpness {sharpness}");
        // A single sharp edge makes a dart, which follows the smooth rule: 5/9 of the way out from
        // the centre, that is 2/9 from the corner at the origin.
        assert!((points[0] - Vec3::splat(2.0 / 9.0)).length() < 1e-15, "{:?}", points[0]);
    }
    // Two sharp edges at the origin make a crease: 3/4, 1/8, 1/8. Three, a corner.
    let at_origin: Vec<_> = topology
        .edges()
        .filter(|&e| {
            let h = topology.edge_halfedge(e);
            topology.origin(h).0 == 0 || topology.target(h).0 == 0
        })
        .collect();
    for (count, expected) in [(2, None), (3, Some(Vec3::ZERO))] {
        let mut creases = Creases::smooth(topology);
        at_origin[..count].iter().for_each(|&e| creases.set_edge(e, 10.0).unwrap());
        let rules = Rules { creases: Some(creases.into()), ..catmull_clark(Corners::Smooth) };
        let points = refine(topology, &rules).unwrap().apply(cube.positions());
        if let Some(p) = expected {
            assert_eq!(points[0], p);
        } else {
            let sum = points[0].x + points[0].y + points[0].z;
            assert!((sum - 0.25).abs() < 1e-15, "two neighbours, an eighth each: {sum}");
        }
    }
}

#[test]
fn choices_that_do_not_fit_are_errors() {
    let cube = fairform::shapes::cube();
    let topology = cube.topology();
    let tension =
        |values: Vec<f64>| Rules { tension: Some(values.into()), ..Scheme::DooSabin.into() };
    for bad in [0.0, -0.5, 1.5, f64::NAN] {
        let mut values = vec![0.5; 6];
        values[4] = bad;
        let error = limit::limit_points(topology, cube.positions(), &tension(values)).unwrap_err();
        assert!(error.to_string().contains("face 4"), "{error}");
    }
    let error = tension(vec![0.5; 5]).check(topology).unwrap_err();
    assert!(matches!(error, Error::WrongCount { expected: 6, .. }), "{error}");
    let rules = Rules { scheme: Scheme::Kobbelt, ..tension(vec![0.5; 6]) };
    assert!(matches!(rules.check(topology).unwrap_err(), Error::NotForScheme { .. }));
    let sheet = quad_sheet(3, 3);
    let rules = Rules { border: Border::Drop, ..Scheme::DooSabin.into() };
    let error = limit::limit_points(sheet.topology(), sheet.positions(), &rules).unwrap_err();
    assert!(matches!(error, Error::NoLimit { .. }), "{error}");
    let mut creases = Creases::smooth(topology);
    let edge = topology.edges().next().expect("an edge");
    assert!(creases.set_edge(edge, f64::NAN).is_err());
    assert!(creases.set_edge(edge, -1.0).is_err());
}

/// `B = D S` with nonnegative rows that sum to one and `S` symmetric positive definite: so all
/// eigenvalues lie in (0, 1], whatever the parameters.
#[test]
fn eigenvalues_lie_between_0_and_1_for_any_parameters() {
    for seed in 1..40_u64 {
        let mesh = random_mesh(seed * 7919, (seed % 20) as usize, 0);
        let topology = mesh.topology();
        let random = |f: usize| ((f as u64 * 2_654_435_761 + seed * 97) % 1000 + 1) as f64 / 1001.0;
        let tension: Vec<f64> = (0..topology.face_count()).map(random).collect();
        let rules = Rules { tension: Some(tension.into()), ..Scheme::DooSabin.into() };
        let rows = limit::limit_stencils(topology, &rules).unwrap();
        let n = rows.row_count();
        let mut s = vec![vec![0.0; n]; n];
        for (i, line) in s.iter_mut().enumerate() {
            let scale = f64::from(topology.fan_size(VertexId(i as u32)));
            let mut sum = 0.0;
            for (v, w) in rows.row(i) {
                assert!(w >= 0.0, "no negative weight");
                sum += w;
                line[v.index()] = scale * w;
            }
            assert!((sum - 1.0).abs() < 1e-13);
        }
        assert!((0..n).all(|i| (0..i).all(|j| (s[i][j] - s[j][i]).abs() < 1e-12)), "symmetric");
        let pivot = crate::common::smallest_pivot(s);
        assert!(pivot > 1e-9, "seed {seed}: pivot {pivot}");
    }
}

/// As in OpenSubdiv: faces at a boundary vertex are support, unless both its boundary edges are sharp for
/// ever; their finer faces are those that descend from them.
#[test]
fn faces_at_the_boundary_may_be_support() {
    let sheet = quad_sheet(5, 6);
    let topology = sheet.topology();
    let none = Rules { border: Border::None, ..Scheme::CatmullClark.into() };
    let count = |rules: &Rules| rules.has_surface(topology).iter().filter(|has| **has).count();
    assert_eq!(count(&Scheme::CatmullClark.into()), 20);
    assert_eq!(count(&none), 6);
    let mut creases = Creases::smooth(topology);
    for e in topology.edges().filter(|&e| topology.is_boundary_edge(e)) {
        let h = topology.edge_halfedge(e);
        let on_side = [topology.origin(h), topology.target(h)].iter().all(|v| v.0 < 6);
        creases.set_edge(e, if on_side { 10.0 } else { 9.9 }).unwrap();
    }
    // The four inner vertices of one side take part again; its ends do not.
    assert_eq!(count(&Rules { creases: Some(creases.into()), ..none.clone() }), 9);
    for scheme in [Scheme::DooSabin, Scheme::CatmullClark] {
        let wrong = if scheme == Scheme::DooSabin { Border::None } else { Border::Drop };
        let error = Rules { border: wrong, ..scheme.into() }.check(topology).unwrap_err();
        assert!(matches!(error, Error::NotForScheme { .. }), "{scheme}");
    }
    let step = refine(topology, &none).unwrap();
    assert_eq!(step.next.border, Border::Bspline);
}

/// A cube whose edges are sharp is flat on each side, and its corners know that.
#[test]
fn each_side_of_a_crease_has_its_normal() {
    let cube = fairform::shapes::cube();
    let topology = cube.topology();
    let creases = Creases::by_angle(topology, cube.positions(), 30.0, 10.0).unwrap();
    let rules = Rules { creases: Some(creases.into()), ..Scheme::CatmullClark.into() };
    let (fine, rules) = refine_mesh(&cube, &rules, 2).unwrap();
    let (topology, points) = (fine.topology(), fine.positions());
    let normals = limit::limit_corner_normals(topology, points, &rules).unwrap();
    for h in topology.halfedges() {
        let corners: Vec<Vec3> =
            topology.face_vertices(topology.face(h)).iter().map(|v| points[v.index()]).collect();
        let flat = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
        assert!((normals[h.index()] - flat).length() < 1e-12, "{h}");
    }
}

/// Where nothing is parted, the normals of corners are those of their vertices; and the mean of the sides
/// is the vertex's anyway.
#[test]
fn normals_of_corners_agree_with_those_of_vertices() {
    for (name, mesh) in polygons() {
        let topology = mesh.topology();
        for share in [0, 40] {
            let creases = random_creases(topology, 7, share);
            let rules = Rules { creases: Some(creases.into()), ..Scheme::CatmullClark.into() };
            let corners = limit::limit_corner_normals(topology, mesh.positions(), &rules).unwrap();
            let normals = limit::limit_normals(topology, mesh.positions(), &rules).unwrap();
            for v in topology.vertices() {
                let mut sides: Vec<Vec3> = Vec::new();
                for n in topology.fan(v).map(|h| corners[h.index()]) {
                    if sides.last() != Some(&n) {
                        sides.push(n);
                    }
                }
                if !topology.is_boundary(v) && sides.len() > 1 && sides.first() == sides.last() {
                    sides.pop();
                }
                let mean = sides.iter().copied().sum::<Vec3>().normalized();
                let off = (mean - normals[v.index()]).length();
                assert!(sides.len() < 2 || off < 1e-12, "{name} {v}: {off}");
                assert!(share > 0 || sides.len() < 2, "{name} {v}");
            }
        }
    }
}
