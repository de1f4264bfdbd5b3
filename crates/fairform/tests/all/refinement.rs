//! Refinement and limit: what must hold on any mesh.

use crate::common::{assert_near, assorted, random_mesh};
use fairform::refine::{check_size, refine, refine_mesh};
use fairform::{Corners, Error, Mesh, Rules, Topology, Vec3, limit, shapes};
use proptest::prelude::*;

const BOTH: [Corners; 2] = [Corners::Smooth, Corners::Sharp];

fn smooth(corners: Corners) -> Rules {
    Rules { corners, ..Rules::LOOP }
}

fn limit_points(mesh: &Mesh, corners: Corners) -> Vec<Vec3> {
    limit::limit_points(mesh.topology(), mesh.positions(), &smooth(corners)).unwrap()
}

/// Faces that share two edges have children whose inner edges have the same ends: fine as half-edges,
/// but not to be told apart in a face list.
fn has_valence_two(topology: &Topology) -> bool {
    topology.vertices().any(|v| !topology.is_boundary(v) && topology.fan_size(v) == 2)
}

fn check_step(mesh: &Mesh, name: &str) {
    let coarse = mesh.topology();
    for corners in BOTH {
        let rules = smooth(corners);
        let step = refine(coarse, &rules).unwrap();
        let expected = check_size(coarse, &Rules::LOOP, 1).unwrap();
        assert_eq!(step.topology.vertex_count() as u64, expected.vertex_count, "{name}");
        assert_eq!(step.topology.edge_count() as u64, expected.edge_count, "{name}");
        assert_eq!(step.topology.face_count() as u64, expected.face_count, "{name}");
        // The closed form is what the search would have found.
        if !has_valence_two(coarse) {
            let faces = step.topology.to_faces();
            let found = Topology::from_faces(step.topology.vertex_count(), &faces).unwrap();
            assert_eq!(step.topology, found, "{name}");
        }

        let stencils = step.stencils();
        let positions = step.apply(mesh.positions());
        assert_near(&stencils.apply(mesh.positions()), &positions, 1e-15, name);
        for row in 0..stencils.row_count() {
            let sum: f64 = stencils.row(row).map(|(_, w)| w).sum();
            let rounding = 1e-15 * (stencils.row(row).len() as f64 / 8.0).max(1.0);
            assert!((sum - 1.0).abs() < rounding, "{name} row {row}");
        }
        let rows = limit::limit_stencils(coarse, &smooth(corners)).unwrap();
        let before = limit_points(mesh, corners);
        assert_near(&rows.apply(mesh.positions()), &before, 1e-14, name);

        // Going to the limit from the refined mesh or from the coarse one is the same.
        let finer = Mesh::from_parts(step.topology.clone().into(), positions);
        let after = limit_points(&finer, corners);
        assert_near(&after[..before.len()], &before, 1e-14, name);
    }
}

#[test]
fn a_step_keeps_the_limit_points() {
    for (name, mesh) in assorted() {
        check_step(&mesh, name);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn a_step_keeps_the_limit_points_of_random_meshes(
        seed: u64, splits in 0..60_usize, holes in 0..12_usize,
    ) {
        check_step(&random_mesh(seed, splits, holes), "random");
    }
}

/// Normals are checked by finite differences: chords of a deep refinement from the limit point
/// become orthogonal to it. Boundary vertices of valence 3 have no normal, those of higher ones
/// converge slowly.
#[test]
fn normals_are_orthogonal_to_the_surface() {
    for (name, mesh) in assorted() {
        if name == "back to back" {
            continue;
        }
        for corners in BOTH {
            let topology = mesh.topology();
            let normals =
                limit::limit_normals(topology, mesh.positions(), &smooth(corners)).unwrap();
            let at = limit_points(&mesh, corners);
            let worst = |levels: u32| {
                let fine = refine_mesh(&mesh, &smooth(corners), levels).unwrap().0;
                let points = limit_points(&fine, corners);
                let mut worst = 0.0_f64;
                for v in topology.vertices() {
                    let k = topology.fan_size(v);
                    if topology.is_boundary(v) && k == 2 || topology.is_isolated(v) {
                        continue;
                    }
                    for q in fine.topology().ring(v) {
                        let chord = (points[q.index()] - at[v.index()]).normalized();
                        worst = worst.max(chord.dot(normals[v.index()]).abs());
                    }
                }
                worst
            };
            let (rough, fine) = (worst(2), worst(6));
            assert!(
                fine < 0.15 && (fine < 0.6 * rough || fine < 1e-12),
                "{name} {corners:?}: {rough} to {fine}"
            );
        }
    }
}

#[test]
fn normals_point_outwards() {
    for mesh in [shapes::tetrahedron(), shapes::octahedron(), shapes::icosahedron()] {
        let (topology, points) = (mesh.topology(), mesh.positions());
        let normals = limit::limit_normals(topology, points, &Rules::LOOP).unwrap();
        for (n, p) in normals.iter().zip(points) {
            assert!((*n - p.normalized()).length() < 1e-14, "a platonic solid");
        }
    }
    let flat = shapes::sheet(4, 5, |x, y| x - 2.0 * y);
    for corners in BOTH {
        let expected = Vec3::new(-1.0, 2.0, 1.0).normalized();
        let normals =
            limit::limit_normals(flat.topology(), flat.positions(), &smooth(corners)).unwrap();
        assert!(normals.iter().all(|n| (*n - expected).length() < 1e-13), "a plane {normals:?}");
    }
}

#[test]
fn sharp_corners_stay() {
    let sheet = shapes::sheet(4, 4, |x, y| x * y);
    let corner = sheet.topology().vertices().filter(|&v| sheet.topology().fan_size(v) == 1);
    let fine = refine_mesh(&sheet, &smooth(Corners::Sharp), 3).unwrap().0;
    let limit = limit_points(&sheet, Corners::Sharp);
    for v in corner {
        assert_eq!(fine.positions()[v.index()], sheet.positions()[v.index()]);
        assert_eq!(limit[v.index()], sheet.positions()[v.index()]);
    }
    let smooth = limit_points(&sheet, Corners::Smooth);
    assert_ne!(smooth[3], limit[3], "the option changes something");
}

/// Over a regular triangle next to it, the surface of one unit control value is the quartic box
/// spline: the function of its own corner in Stam's basis.
#[test]
fn regular_regions_are_quartic_box_splines() {
    let basis = |u: f64, v: f64, w: f64| {
        (6.0 * u * u * u * u
            + 24.0 * u * u * u * (v + w)
            + 24.0 * u * u * (v * v + w * w)
            + 60.0 * u * u * v * w
            + 8.0 * u * (v * v * v + w * w * w)
            + 36.0 * u * v * w * (v + w)
            + v * v * v * v
            + w * w * w * w
            + 6.0 * v * w * (v * v + w * w)
            + 12.0 * v * v * w * w)
            / 12.0
    };
    // An affine image of the regular lattice, so parameters are read off x and y.
    let n = 9;
    let sheet = shapes::sheet(n, n, |_, _| 0.0);
    let mut positions = sheet.positions().to_vec();
    positions[(4 * n + 4) as usize].z = 1.0;
    let peak = sheet.with_positions(positions);
    let fine = refine_mesh(&peak, &Rules::LOOP, 3).unwrap().0;
    let mut checked = 0;
    for p in limit_points(&fine, Corners::Smooth) {
        let (x, y) = (8.0 * (p.x - 0.5), 8.0 * (p.y - 0.5));
        // The triangle (0,0), (1,0), (1,1).
        let (u, v, w) = (1.0 - x, x - y, y);
        if u > -1e-12 && v > -1e-12 && w > -1e-12 {
            assert!((p.z - basis(u, v, w)).abs() < 1e-14, "at {x}, {y}: {} ", p.z);
            checked += 1;
        }
    }
    assert_eq!(checked, 45, "all of the triangle's 8 by 8 grid");
}

#[test]
fn what_a_scheme_cannot_refine_is_said() {
    let cube = shapes::cube();
    let error = refine_mesh(&cube, &Rules::LOOP, 1).unwrap_err();
    assert!(matches!(error, Error::NotTriangles { count: 4, .. }), "{error}");
    let error = refine_mesh(&shapes::octahedron(), &Rules::LOOP, 30).unwrap_err();
    assert!(matches!(error, Error::TooLarge { .. }), "{error}");
    let error = refine_mesh(&shapes::octahedron(), &Rules::LOOP, u32::MAX).unwrap_err();
    assert!(matches!(error, Error::TooLarge { .. }), "{error}");
}

/// Values at corners stay within their face: a seam stays a seam, and linear data stay linear.
#[test]
fn corner_values_are_linear_in_each_face() {
    let mesh = shapes::octahedron();
    let topology = mesh.topology();
    let step = refine(topology, &Rules::LOOP).unwrap();
    let offset = |f: u32| Vec3::splat(10.0 * f64::from(f));
    let values: Vec<Vec3> = topology
        .halfedges()
        .map(|h| mesh.positions()[topology.origin(h).index()] + offset(topology.face(h).0))
        .collect();
    let finer = step.apply_to_corners(&values).unwrap();
    for h in step.topology.halfedges() {
        let parent = step.parent(step.topology.face(h));
        let v = step.topology.origin(h).index();
        let expected = match v.checked_sub(topology.vertex_count()) {
            None => mesh.positions()[v],
            Some(e) => {
                let h = topology.edge_halfedge(fairform::EdgeId(e as u32));
                let [a, b] = [topology.origin(h), topology.target(h)];
                0.5 * (mesh.positions()[a.index()] + mesh.positions()[b.index()])
            }
        };
        assert!((finer[h.index()] - expected - offset(parent.0)).length() < 1e-13);
    }
}

/// Large meshes are numbered in blocks.
#[test]
fn many_edges_are_numbered_as_few() {
    for mesh in [shapes::torus(60, 50), shapes::sheet(60, 50, |x, y| x * y)] {
        let finer = refine(mesh.topology(), &Rules::LOOP).unwrap().topology;
        let found = Topology::from_faces(finer.vertex_count(), &finer.to_faces()).unwrap();
        assert_eq!(finer, found);
        let leads = finer.halfedges().filter(|&h| finer.twin(h).is_none_or(|t| t > h));
        for (e, h) in finer.edges().zip(leads) {
            assert_eq!((finer.edge_halfedge(e), finer.edge(h)), (h, e));
        }
    }
}
