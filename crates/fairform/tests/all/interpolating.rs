//! The schemes that pass through the vertices by themselves: butterfly and Kobbelt's.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use crate::common::{assert_near, assorted, golden, random_mesh};
use fairform::interpolate::{Interpolator, Method, Options};
use fairform::refine::{check_size, refine, refine_mesh};
use fairform::scheme::{Warning, butterfly, kobbelt};
use fairform::{
    Corners, Creases, Error, FaceId, Faces, Mesh, Rules, Scheme, Topology, Vec3, VertexId, limit,
    shapes,
};
use proptest::prelude::*;
use serde_json::Value;

fn butterfly() -> Rules {
    Scheme::Butterfly.into()
}

fn kobbelt(w: f64, corners: Corners) -> Rules {
    Rules { corners, kobbelt_weight: w, ..Scheme::Kobbelt.into() }
}

/// Each polygon cut into quadrilaterals, the new vertices moved about.
fn quads(mesh: &Mesh) -> Mesh {
    let mut fine = refine_mesh(mesh, &Scheme::CatmullClark.into(), 1).unwrap().0.into_positions();
    for (i, p) in fine.iter_mut().enumerate() {
        let wave = |k: f64| 0.07 * (k * i as f64).sin();
        *p += Vec3::new(wave(1.0), wave(2.0), wave(3.0));
    }
    let rules = Rules::from(Scheme::CatmullClark);
    let topology = refine(mesh.topology(), &rules).unwrap().topology;
    Mesh::from_parts(topology.into(), fine)
}

/// An open grid over integer points, with heights.
fn grid(rows: u32, columns: u32, f: impl Fn(f64, f64) -> f64) -> Mesh {
    let mut positions = Vec::new();
    let mut faces = Faces::new();
    for i in 0..rows {
        for j in 0..columns {
            let (x, y) = (f64::from(j), f64::from(i));
            positions.push(Vec3::new(x, y, f(x, y)));
            if i + 1 < rows && j + 1 < columns {
                let a = i * columns + j;
                faces.push(&[a, a + 1, a + columns + 1, a + columns]);
            }
        }
    }
    Mesh::new(positions, &faces).unwrap()
}

fn fraction(value: &Value) -> f64 {
    let text = value.as_str().unwrap();
    let (a, b) = text.split_once('/').unwrap_or((text, "1"));
    a.parse::<f64>().unwrap() / b.parse::<f64>().unwrap()
}

#[test]
fn virtual_points() {
    let masks = golden("masks");
    for n in [3, 5] {
        let expected = &masks[format!("kobbelt_virtual_n{n}_w1")];
        for j in 0..n {
            let l = kobbelt::virtual_neighbour_weight(n, j);
            let k = kobbelt::virtual_corner_weight(n, j, 1.0);
            assert!((l - fraction(&expected["l"][j as usize])).abs() < 1e-15, "{n} l {j}");
            assert!((k - fraction(&expected["k"][j as usize])).abs() < 1e-15, "{n} k {j}");
        }
    }
    let opposite =
        |j| [kobbelt::virtual_neighbour_weight(4, j), kobbelt::virtual_corner_weight(4, j, 0.7)];
    assert_eq!([0, 1, 2, 3].map(opposite), [[0.0; 2], [0.0; 2], [1.0, 0.0], [0.0; 2]]);
    for n in 2..50 {
        let l: f64 = (0..n).map(|j| kobbelt::virtual_neighbour_weight(n, j)).sum();
        let k: f64 = (0..n).map(|j| kobbelt::virtual_corner_weight(n, j, 1.3)).sum();
        assert!((l - 1.0).abs() < 1e-13 && k.abs() < 1e-13, "valence {n}");
    }
}

/// The rule and the virtual points that it is made of are the same.
#[test]
fn the_step_uses_the_virtual_points() {
    let w = 0.7;
    for n in [3, 5, 9] {
        let mesh = quads(&shapes::bipyramid(n));
        let topology = mesh.topology();
        let pole = topology.vertices().find(|&v| topology.fan_size(v) == n).unwrap();
        let point = |v: VertexId| mesh.positions()[v.index()];
        let fan: Vec<_> = topology.fan(pole).collect();
        let mut expected = Vec3::ZERO;
        for (j, &h) in (0..).zip(&fan) {
            let (l, k) = (topology.target(h), topology.target(topology.next(h)));
            expected += kobbelt::virtual_neighbour_weight(n, j) * point(l);
            expected += kobbelt::virtual_corner_weight(n, j, w) * point(k);
        }
        // Behind the neighbour, a regular edge point, lies the vertex opposite.
        let l = topology.target(fan[0]);
        let across = topology.twin(topology.next(fan[0])).unwrap();
        let behind = topology.target(topology.next(across));
        assert_eq!((topology.fan_size(l), topology.origin(topology.next(across))), (4, l));
        let [near, far] = kobbelt::edge_weights(w);
        let expected = near * (point(pole) + point(l)) + far * (expected + point(behind));
        let finer = refine(topology, &kobbelt(w, Corners::Sharp)).unwrap().apply(mesh.positions());
        let actual = finer[topology.vertex_count() + topology.edge(fan[0]).index()];
        assert!((actual - expected).length() < 1e-15, "valence {n}: {actual:?} {expected:?}");
    }
}

/// The means and first two waves round a vertex shrink to 1/4, 1/2, 1/4: the design of the weights.
#[test]
fn butterfly_rings() {
    let exact =
        [(3, 0, 5.0 / 12.0), (3, 2, -1.0 / 12.0), (4, 0, 0.375), (4, 1, 0.0), (4, 2, -0.125)];
    for (n, j, expected) in exact {
        assert_eq!(butterfly::ring_weight(n, j), expected);
    }
    for n in 2..60 {
        let wave = |k: u32| -> f64 {
            let angle = |j: u32| 2.0 * PI * f64::from(k * j) / f64::from(n);
            (0..n).map(|j| butterfly::ring_weight(n, j) * angle(j).cos()).sum()
        };
        assert!((wave(0) - 0.25).abs() < 1e-14, "valence {n}");
        assert!((wave(1) - 0.5).abs() < 1e-14, "valence {n}");
        let second = if n < 4 { wave(2) } else { wave(2) - 0.25 };
        assert!(n < 4 || second.abs() < 1e-14, "valence {n}");
    }
}

fn check_step(mesh: &Mesh, rules: &Rules, name: &str) {
    let coarse = mesh.topology();
    let step = refine(coarse, rules).unwrap();
    let size = check_size(coarse, rules, 1).unwrap();
    assert_eq!(step.topology.vertex_count() as u64, size.vertex_count, "{name}");
    assert_eq!(step.topology.edge_count() as u64, size.edge_count, "{name}");
    assert_eq!(step.topology.face_count() as u64, size.face_count, "{name}");
    let finer = step.apply(mesh.positions());
    assert_eq!(finer.len(), step.topology.vertex_count(), "{name}");
    assert_eq!(finer[..coarse.vertex_count()], *mesh.positions(), "{name}: old vertices stay");
    let stencils = step.stencils();
    assert_near(&stencils.apply(mesh.positions()), &finer, 2e-14, name);
    for i in 0..stencils.row_count() {
        let sum: f64 = stencils.row(i).map(|(_, weight)| weight).sum();
        assert!((sum - 1.0).abs() < 1e-13, "{name} row {i}: {sum}");
    }
    // A part of each old face is at each of its corners.
    for f in step.topology.faces() {
        let parent = coarse.face_vertices(step.parent(f));
        let old = step.topology.face_vertices(f).iter().find(|v| v.index() < coarse.vertex_count());
        assert!(old.is_none_or(|v| parent.contains(v)), "{name} face {f}");
    }
    // Values at corners that agree at vertices are bilinear: the mean of the ends on an edge.
    let values: Vec<Vec3> =
        coarse.halfedges().map(|h| mesh.positions()[coarse.origin(h).index()]).collect();
    let corners = step.apply_to_corners(&values).unwrap();
    for h in step.topology.halfedges() {
        let v = step.topology.origin(h).index();
        if v < coarse.vertex_count() {
            assert_eq!(corners[h.index()], mesh.positions()[v], "{name} corner {h}");
        }
    }
    // Normals exist or are zero.
    let normals = limit::limit_normals(coarse, mesh.positions(), rules).unwrap();
    for n in normals {
        assert!(n == Vec3::ZERO || (n.length() - 1.0).abs() < 1e-14, "{name}: {n:?}");
    }
    let limit = limit::limit_points(coarse, mesh.positions(), rules).unwrap();
    assert_eq!(limit, mesh.positions(), "{name}");
}

#[test]
fn a_step_keeps_vertices() {
    for (name, mesh) in assorted() {
        check_step(&mesh, &butterfly(), name);
        for corners in [Corners::Smooth, Corners::Sharp] {
            check_step(&quads(&mesh), &kobbelt(1.3, corners), name);
        }
    }
    // Valences so high that the ring is summed in another way.
    check_step(&shapes::bipyramid(300), &butterfly(), "bipyramid 300");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn a_step_keeps_vertices_of_random_meshes(
        seed: u64, splits in 0..60_usize, holes in 0..12_usize, w in -7.0..20.0, sharp: bool,
    ) {
        let mesh = random_mesh(seed, splits, holes);
        check_step(&mesh, &butterfly(), "random");
        let corners = if sharp { Corners::Sharp } else { Corners::Smooth };
        let quads = quads(&mesh);
        check_step(&quads, &kobbelt(w, corners), "random");
    }

    /// Affine maps go through a step, whatever the mesh.
    #[test]
    fn steps_commute_with_affine_maps(seed: u64, splits in 0..30_usize, holes in 0..8_usize) {
        let map = |p: &Vec3| {
            Vec3::new(2.0 * p.x - p.y + 3.0, p.z - 0.5 * p.x, p.x + p.y + 4.0 * p.z - 1.0)
        };
        let mesh = random_mesh(seed, splits, holes);
        for (mesh, rules) in
            [(quads(&mesh), kobbelt(1.0, Corners::Sharp)), (mesh, butterfly())]
        {
            let step = refine(mesh.topology(), &rules).unwrap();
            let moved: Vec<Vec3> = mesh.positions().iter().map(map).collect();
            let expected: Vec<Vec3> = step.apply(mesh.positions()).iter().map(map).collect();
            assert_near(&step.apply(&moved), &expected, 2e-14, "affine");
        }
    }
}

fn cubic(x: f64, y: f64) -> f64 {
    1.0 + x - 2.0 * y + 0.5 * x * x - x * y + 0.25 * y * y + 0.3 * x * x * x - 0.2 * x * x * y
        + 0.1 * x * y * y
        - 0.4 * y * y * y
}

fn cubic_normal(x: f64, y: f64) -> Vec3 {
    let by_x = 1.0 + x - y + 0.9 * x * x - 0.4 * x * y + 0.1 * y * y;
    let by_y = -2.0 - x + 0.5 * y - 0.2 * x * x + 0.2 * x * y - 1.2 * y * y;
    Vec3::new(-by_x, -by_y, 1.0).normalized()
}

/// Away from the boundary both schemes reproduce cubics, with their normals; affine functions
/// everywhere on a grid with sharp corners, and beside straight boundaries.
#[test]
fn cubics_are_reproduced() {
    let sheet = shapes::sheet(9, 10, |_, _| 0.0);
    let unit = |p: &Vec3| Vec3::new(9.0 * p.x, 8.0 * p.y, 0.0);
    let flat = sheet.with_positions(sheet.positions().iter().map(unit).collect());
    let quads = grid(9, 10, |_, _| 0.0);
    let cases = [
        (&flat, butterfly(), false),
        (&quads, kobbelt(1.0, Corners::Sharp), true),
        (&quads, kobbelt(1.0, Corners::Smooth), false),
    ];
    for (mesh, rules, to_the_corner) in cases {
        let scheme = rules.scheme;
        let lift = |f: &dyn Fn(f64, f64) -> f64| {
            let up = |p: &Vec3| Vec3::new(p.x, p.y, f(p.x, p.y));
            mesh.with_positions(mesh.positions().iter().map(up).collect())
        };
        let from_edge = |p: Vec3| p.x.min(9.0 - p.x).min(p.y).min(8.0 - p.y);
        let from_corner = |p: Vec3| p.x.min(9.0 - p.x).max(p.y.min(8.0 - p.y));

        let lifted = lift(&cubic);
        let mut inside = 0;
        let fine = refine_mesh(&lifted, &rules, 1).unwrap().0;
        let normals = limit::limit_normals(mesh.topology(), lifted.positions(), &rules).unwrap();
        for (i, &p) in fine.positions().iter().enumerate() {
            let error = (p.z - cubic(p.x, p.y)).abs();
            if from_edge(p) < 1.0 {
                continue;
            }
            assert!(error < 2e-13, "{scheme} {p:?}: {error:e}");
            inside += 1;
            if from_edge(p) >= 3.0
                && let Some(&normal) = normals.get(i)
            {
                let error = (normal - cubic_normal(p.x, p.y)).length();
                assert!(error < 1e-12, "{scheme} {p:?}: {normal:?} {error:e}");
            }
        }
        assert!(inside > 100, "{scheme}: {inside}");

        let affine = |x: f64, y: f64| 3.0 * x - y + 2.0;
        let fine = refine_mesh(&lift(&affine), &rules, 1).unwrap().0;
        let half = |x: f64| (2.0 * x - (2.0 * x).round()).abs() < 1e-14;
        for &p in fine.positions() {
            if to_the_corner || from_corner(p) >= 2.0 {
                assert!((p.z - affine(p.x, p.y)).abs() < 1e-13, "{scheme} {p:?}");
                assert!(half(p.x) && half(p.y), "{scheme} {p:?} lies in the middle");
            }
        }
    }
}

/// One step of the open four-point scheme, ends reflected.
fn four_point(line: &[Vec3], w: f64) -> Vec<Vec3> {
    let n = line.len();
    let at = |i: usize| -> Vec3 {
        match i.checked_sub(1) {
            None => 2.0 * line[0] - line[1],
            Some(i) if i == n => 2.0 * line[n - 1] - line[n - 2],
            Some(i) => line[i],
        }
    };
    let mut finer = Vec::new();
    for i in 0..n {
        finer.push(line[i]);
        if i + 1 < n {
            let near = (8.0 + w) / 16.0 * (line[i] + line[i + 1]);
            finer.push(near - w / 16.0 * (at(i) + at(i + 3)));
        }
    }
    finer
}

#[test]
fn an_open_grid_is_a_tensor_product() {
    let (rows, columns, w) = (5_usize, 6_usize, 0.8);
    let mesh = grid(5, 6, |x, y| (x * x + 1.3 * y).sin());
    let mesh = mesh.with_positions(
        mesh.positions()
            .iter()
            .map(|&p| p + Vec3::new(0.1 * p.z, 0.2 * (p.x * p.y).cos(), 0.0))
            .collect(),
    );
    let wide: Vec<Vec<Vec3>> = (0..rows)
        .map(|i| four_point(&mesh.positions()[columns * i..columns * (i + 1)], w))
        .collect();
    let mut expected = Vec::new();
    for j in 0..2 * columns - 1 {
        let column: Vec<Vec3> = wide.iter().map(|row| row[j]).collect();
        expected.extend(four_point(&column, w));
    }
    let mut actual = refine_mesh(&mesh, &kobbelt(w, Corners::Sharp), 1).unwrap().0.into_positions();
    assert_eq!(actual.len(), expected.len());
    for e in expected {
        let nearest = (0..actual.len())
            .min_by(|&a, &b| (actual[a] - e).length().total_cmp(&(actual[b] - e).length()));
        let found = actual.swap_remove(nearest.unwrap());
        assert!((found - e).length() < 1e-14, "{found:?} {e:?}");
    }
}

/// Whether the limit surface has a tangent plane there.
fn has_plane(topology: &Topology, v: VertexId, rules: &Rules) -> bool {
    let k = topology.fan_size(v);
    match (topology.is_boundary(v), rules.scheme) {
        (false, _) => k > 2,
        (true, Scheme::Butterfly) => k == 2 || k == 3,
        (true, _) => k == 2 || k == 1 && rules.corners == Corners::Sharp,
    }
}

/// The neighbourhood of a vertex by itself, which becomes vertex 0 at the origin.
fn around(mesh: &Mesh, v: VertexId, rings: u32) -> Mesh {
    let topology = mesh.topology();
    let mut number = std::collections::BTreeMap::from([(v, 0_u32)]);
    let mut list = vec![v];
    let mut faces = std::collections::BTreeSet::new();
    for _ in 0..rings {
        for v in list.clone() {
            for f in topology.fan(v).map(|h| topology.face(h)).filter(|f| faces.insert(*f)) {
                for &q in topology.face_vertices(f) {
                    number.entry(q).or_insert_with(|| {
                        list.push(q);
                        list.len() as u32 - 1
                    });
                }
            }
        }
    }
    let numbers =
        |&f: &FaceId| -> Vec<u32> { topology.face_vertices(f).iter().map(|q| number[q]).collect() };
    let (faces, here) = (faces.iter().map(numbers).collect(), mesh.positions()[v.index()]);
    // The in-plane part about halves in a step.
    let positions = list.iter().map(|q| 2.0 * (mesh.positions()[q.index()] - here)).collect();
    Mesh::new(positions, &faces).unwrap()
}

/// Normals are checked by finite differences: deep in the neighbourhood of a vertex all chords are
/// orthogonal to its normal.
#[test]
fn normals_are_orthogonal_to_the_surface() {
    let mut cases: Vec<(String, Mesh, Rules)> = Vec::new();
    for (name, mesh) in assorted() {
        for (w, corners) in [(0.8, Corners::Smooth), (1.0, Corners::Sharp), (1.4, Corners::Sharp)] {
            let name = format!("{name}, quads, w = {w}, {corners:?}");
            cases.push((name, quads(&mesh), kobbelt(w, corners)));
        }
        cases.push((name.to_string(), mesh, butterfly()));
    }
    let mut kinds = std::collections::BTreeSet::new();
    for (name, mesh, rules) in cases {
        let topology = mesh.topology();
        let normals = limit::limit_normals(topology, mesh.positions(), &rules).unwrap();
        let mut seen = std::collections::BTreeSet::new();
        for v in topology.vertices().filter(|&v| !topology.is_isolated(v)) {
            let kind = (topology.is_boundary(v), topology.fan_size(v));
            if !has_plane(topology, v, &rules) || !seen.insert(kind) {
                continue;
            }
            kinds.insert((rules.scheme.name(), kind));
            // Two steps with all neighbours, so that what is cut off no longer matters.
            let mut deep = around(&refine_mesh(&mesh, &rules, 2).unwrap().0, v, 4);
            for _ in 0..100 {
                deep = around(&refine_mesh(&deep, &rules, 1).unwrap().0, VertexId(0), 4);
            }
            let ring: Vec<Vec3> =
                deep.topology().ring(VertexId(0)).map(|q| deep.positions()[q.index()]).collect();
            // Many faces have eigenvalues close to each other: look at the first wave round the
            // vertex only, which spans the tangent plane.
            let wave = |f: fn(f64) -> f64| -> Vec3 {
                let step = 2.0 * PI / ring.len() as f64;
                ring.iter().enumerate().map(|(j, &q)| f(step * j as f64) * q).sum()
            };
            let chords = if kind.1 > 12 { vec![wave(f64::cos), wave(f64::sin)] } else { ring };
            let slope = |chord: Vec3| chord.normalized().dot(normals[v.index()]).abs();
            let worst = chords.into_iter().map(slope).fold(0.0, f64::max);
            assert!(worst < 1e-3, "{name} vertex {v} {kind:?}: {worst}");
        }
    }
    let expected = [("butterfly", (false, 6)), ("kobbelt", (true, 2)), ("kobbelt", (false, 40))];
    assert!(expected.iter().all(|e| kinds.contains(e)) && kinds.len() > 15, "{kinds:?}");
}

#[test]
fn normals_point_outwards() {
    for mesh in [shapes::tetrahedron(), shapes::octahedron(), shapes::icosahedron()] {
        let normals =
            limit::limit_normals(mesh.topology(), mesh.positions(), &butterfly()).unwrap();
        for (n, p) in normals.iter().zip(mesh.positions()) {
            assert!((*n - p.normalized()).length() < 1e-13, "{n:?}");
        }
    }
    let cube = shapes::cube();
    let rules = Scheme::Kobbelt.into();
    let normals = limit::limit_normals(cube.topology(), cube.positions(), &rules).unwrap();
    for (n, p) in normals.iter().zip(cube.positions()) {
        assert!((*n - (*p - Vec3::splat(0.5)).normalized()).length() < 1e-13, "{n:?}");
    }
    let plane = |x: f64, y: f64| x - 2.0 * y;
    let expected = Vec3::new(-1.0, 2.0, 1.0).normalized();
    let sheet = shapes::sheet(4, 5, plane);
    let cases = [
        (sheet, butterfly()),
        (grid(4, 5, plane), kobbelt(1.0, Corners::Sharp)),
        (grid(4, 5, plane), kobbelt(1.0, Corners::Smooth)),
    ];
    for (mesh, rules) in cases {
        let normals = limit::limit_normals(mesh.topology(), mesh.positions(), &rules).unwrap();
        for (v, n) in normals.iter().enumerate() {
            assert!(
                (*n - expected).length() < 1e-13,
                "{} {:?} {v}: {n:?}",
                rules.scheme,
                rules.corners
            );
        }
    }
}

#[test]
fn every_mesh_is_its_own_control_mesh() {
    let cases = [(shapes::icosahedron(), butterfly()), (shapes::cube(), Scheme::Kobbelt.into())];
    for (mesh, rules) in cases {
        let interpolator = Interpolator::new(mesh.topology(), &rules).unwrap();
        for method in Method::ALL {
            let options = Options { method, ..Options::default() };
            let mut go_on = |_, _| ControlFlow::Continue(());
            let (control, report) =
                interpolator.fit(mesh.positions(), &options, &mut go_on).unwrap();
            assert_eq!(control, mesh.positions());
            assert!(report.is_converged() && report.stages.is_empty());
            assert_eq!((report.max, report.mean), (0.0, 0.0));
        }
    }
}

#[test]
fn what_the_schemes_cannot_do_is_said() {
    let (cube, octahedron) = (shapes::cube(), shapes::octahedron());
    let error = butterfly().check(cube.topology()).unwrap_err();
    assert!(matches!(error, Error::NotTriangles { count: 4, scheme: "butterfly", .. }), "{error}");
    let error = Rules::from(Scheme::Kobbelt).check(octahedron.topology()).unwrap_err();
    assert!(matches!(error, Error::NotQuadrilaterals { count: 3, .. }), "{error}");
    assert!(error.to_string().contains("Catmull–Clark step"), "{error}");
    for w in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -8.0, -9.0] {
        let error = kobbelt(w, Corners::Sharp).check(cube.topology()).unwrap_err();
        assert!(matches!(error, Error::BadOption { .. }), "{error}");
        // Others do not look at it.
        let other = Rules { kobbelt_weight: w, ..Scheme::CatmullClark.into() };
        assert_eq!(other.check(cube.topology()), Ok(()));
    }
    let creases = Some(Creases::smooth(octahedron.topology()).into());
    let error = Rules { creases, ..butterfly() }.check(octahedron.topology()).unwrap_err();
    assert!(matches!(error, Error::NotForScheme { scheme: "butterfly", .. }), "{error}");
    let error = refine_mesh(&cube, &Scheme::Kobbelt.into(), 30).unwrap_err();
    assert!(matches!(error, Error::TooLarge { .. }), "{error}");
}

#[test]
fn tensions_that_are_not_smooth_are_told() {
    let cube = shapes::cube();
    let warnings = |w: f64| kobbelt(w, Corners::Sharp).warnings(cube.topology());
    assert_eq!((warnings(1.0), warnings(1.66)), (vec![], vec![]));
    assert!(matches!(warnings(1.67)[..], [Warning::ValenceThree { .. }]));
    assert!(matches!(warnings(0.0)[..], [Warning::TensionOutside { .. }]));
    assert!(matches!(warnings(-1.0)[..], [Warning::TensionOutside { .. }]));
    let both = warnings(2.0 * (5.0_f64.sqrt() - 1.0) + 1e-12);
    assert!(matches!(both[..], [Warning::TensionOutside { .. }, Warning::ValenceThree { .. }]));
    let grid = grid(3, 3, |_, _| 0.0);
    assert_eq!(kobbelt(2.0, Corners::Sharp).warnings(grid.topology()), []);
    assert_eq!(Rules { kobbelt_weight: 9.0, ..butterfly() }.warnings(grid.topology()), []);
}

#[test]
fn names() {
    for &scheme in Scheme::ALL {
        assert_eq!(scheme.name().parse(), Ok(scheme));
        let error = "loops".parse::<Scheme>().unwrap_err().to_string();
        assert!(error.contains(scheme.name()), "{error}");
    }
}
