//! Connectivity: every defect by name, and what a sound mesh promises.

use crate::common::{assorted, random_mesh, several};
use fairform::{Defect, Error, FaceId, Faces, Mesh, Topology, Vec3, VertexId, shapes};
use proptest::prelude::*;

fn faces(list: &[&[u32]]) -> Faces {
    list.iter().collect()
}

fn defects(vertex_count: usize, list: &[&[u32]]) -> Vec<Defect> {
    match Topology::from_faces(vertex_count, &faces(list)) {
        Err(Error::NotManifold(defects)) => defects.0,
        other => panic!("expected defects, not {other:?}"),
    }
}

#[test]
fn bad_faces_are_named() {
    assert_eq!(
        defects(3, &[&[0, 1, 7], &[0, 1], &[], &[2, 1, 2]]),
        [
            Defect::NoSuchVertex { face: FaceId(0), vertex: 7, vertex_count: 3 },
            Defect::TooFewCorners { face: FaceId(1), count: 2 },
            Defect::TooFewCorners { face: FaceId(2), count: 0 },
            Defect::RepeatedCorner { face: FaceId(3), vertex: VertexId(2) },
        ]
    );
    let mut long: Vec<u32> = (0..40).collect();
    long.push(17);
    let repeated = Defect::RepeatedCorner { face: FaceId(0), vertex: VertexId(17) };
    assert_eq!(defects(40, &[&long]), [repeated]);
}

#[test]
fn bad_edges_are_named() {
    let ends = [VertexId(0), VertexId(1)];
    assert_eq!(
        defects(5, &[&[0, 1, 2], &[1, 0, 3], &[0, 1, 4]]),
        [Defect::NonManifoldEdge { ends, faces: vec![FaceId(0), FaceId(1), FaceId(2)] }]
    );
    assert_eq!(
        defects(4, &[&[2, 0, 1], &[0, 1, 3]]),
        [Defect::InconsistentOrientation {
            from: VertexId(0),
            to: VertexId(1),
            faces: [FaceId(0), FaceId(1)],
        }]
    );
}

#[test]
fn bow_ties_are_named() {
    let vertex = VertexId(0);
    assert_eq!(
        defects(5, &[&[0, 1, 2], &[0, 3, 4]]),
        [Defect::NonManifoldVertex { vertex, fan_count: 2, face_count: 2 }]
    );
    // Two closed fans and an open one of two faces.
    let tet = |a: u32| [[0, a, a + 1], [0, a + 1, a + 2], [0, a + 2, a], [a + 2, a + 1, a]];
    let mut list: Faces = [tet(1), tet(4)].iter().flatten().collect();
    list.push(&[0, 7, 8]);
    list.push(&[0, 8, 9]);
    let Err(Error::NotManifold(found)) = Topology::from_faces(10, &list) else { panic!("bow-tie") };
    assert_eq!(found.0, [Defect::NonManifoldVertex { vertex, fan_count: 3, face_count: 8 }]);
}

/// A defect does not hide those elsewhere.
#[test]
fn all_defects_are_found_at_once() {
    let list = [[0, 1, 2], [3, 4, 4], [5, 6, 7], [5, 8, 9], [10, 11, 12], [10, 11, 13]];
    let found = defects(14, &list.each_ref().map(<[u32; 3]>::as_slice));
    assert_eq!(found.len(), 3, "{found:?}");
    assert!(matches!(found[0], Defect::RepeatedCorner { face: FaceId(1), .. }));
    assert!(matches!(found[1], Defect::InconsistentOrientation { from: VertexId(10), .. }));
    assert!(matches!(found[2], Defect::NonManifoldVertex { vertex: VertexId(5), .. }));
}

#[test]
fn coordinates_must_be_finite() {
    let mut positions = shapes::tetrahedron().into_positions();
    positions[2].y = f64::NAN;
    positions[3].z = f64::INFINITY;
    let list = shapes::tetrahedron().topology().to_faces();
    let Err(Error::NotManifold(found)) = Mesh::new(positions, &list) else { panic!("not finite") };
    let not_finite = |v| Defect::NotFinite { vertex: VertexId(v) };
    assert_eq!(found.0, [not_finite(2), not_finite(3)]);
    assert!(found.to_string().contains("vertex 2"), "{found}");
}

/// A hub of very many faces, where anything quadratic would never end.
#[test]
fn a_huge_valence_is_fast() {
    let mesh = shapes::bipyramid(300_000);
    assert_eq!(mesh.topology().valence(VertexId(300_000)), 300_000);
    let mut list = mesh.topology().to_faces();
    list.push(&[300_000, 1, 0]);
    let Err(Error::NotManifold(found)) = Topology::from_faces(mesh.positions().len(), &list) else {
        panic!("three faces at an edge")
    };
    assert!(found.0.iter().any(|d| matches!(d, Defect::NonManifoldEdge { .. })), "{found}");
}

#[test]
fn no_faces_and_no_vertices_are_fine() {
    for vertex_count in [0, 3] {
        let topology = Topology::from_faces(vertex_count, &Faces::new()).unwrap();
        assert_eq!(topology.isolated_count(), vertex_count);
        assert_eq!(topology.face_count(), 0);
        assert!(topology.components().list.is_empty() && topology.boundary_loops().is_empty());
    }
}

#[test]
fn loops_components_and_genus() {
    let counts = |mesh: &Mesh| {
        let components = mesh.topology().components().list;
        let genus: Vec<usize> =
            components.iter().map(fairform::topology::Component::genus).collect();
        (mesh.topology().boundary_loops().len(), genus)
    };
    assert_eq!(counts(&shapes::torus(4, 5)), (0, vec![1]));
    assert_eq!(counts(&shapes::cube()), (0, vec![0]));
    assert_eq!(counts(&shapes::tube(3, 8)), (2, vec![0]));
    assert_eq!(counts(&shapes::sheet(3, 3, |_, _| 0.0)), (1, vec![0]));
    assert_eq!(counts(&several()), (1, vec![0, 0]));
    let sheet = shapes::sheet(3, 3, |_, _| 0.0);
    let corner = sheet.topology().boundary_loops().remove(0);
    assert_eq!(corner.iter().map(|v| v.0).collect::<Vec<_>>(), [0, 1, 2, 5, 8, 7, 6, 3]);
}

/// What the arrays promise each other.
fn check(topology: &Topology, list: &Faces) {
    assert_eq!(topology.to_faces(), *list);
    let mut first_seen = 0;
    for h in topology.halfedges() {
        assert_eq!(topology.next(topology.prev(h)), h);
        assert_eq!(topology.face(topology.next(h)), topology.face(h));
        if let Some(t) = topology.twin(h) {
            assert_eq!(topology.twin(t), Some(h));
            assert_eq!(topology.edge(t), topology.edge(h));
            assert_eq!(topology.origin(t), topology.target(h));
        }
        if topology.edge_halfedge(topology.edge(h)) == h {
            assert_eq!(topology.edge(h).0, first_seen, "edges are numbered by first appearance");
            first_seen += 1;
        }
    }
    assert_eq!(first_seen as usize, topology.edge_count());
    for v in topology.vertices() {
        let fan: Vec<_> = topology.fan(v).collect();
        assert!(fan.iter().all(|&h| topology.origin(h) == v));
        let faces = topology.halfedges().filter(|&h| topology.origin(h) == v).count();
        assert_eq!(fan.len(), faces);
        assert_eq!(fan.len(), topology.fan_size(v) as usize);
        let ring: Vec<_> = topology.ring(v).collect();
        assert_eq!(ring.len(), topology.valence(v) as usize);
        if topology.is_boundary(v) {
            assert_eq!(topology.twin(fan[0]), None, "an open fan starts on the boundary");
        }
        // Face i lies between neighbours i and i + 1, counter-clockwise.
        for (i, &h) in fan.iter().enumerate() {
            assert_eq!(topology.target(h), ring[i]);
            assert_eq!(topology.origin(topology.prev(h)), ring[(i + 1) % ring.len()]);
        }
    }
}

#[test]
fn sound_meshes_keep_their_promises() {
    for (_, mesh) in assorted() {
        check(mesh.topology(), &mesh.topology().to_faces());
    }
    check(shapes::cube().topology(), &shapes::cube().topology().to_faces());
    let mixed = faces(&[&[0, 1, 2], &[1, 3, 4, 2], &[4, 3, 5, 6, 7]]);
    check(&Topology::from_faces(9, &mixed).unwrap(), &mixed);
}

proptest! {
    #[test]
    fn random_meshes_keep_their_promises(seed: u64, splits in 0..40_usize, holes in 0..9_usize) {
        let mesh = random_mesh(seed, splits, holes);
        check(mesh.topology(), &mesh.topology().to_faces());
    }

    /// Any face list is a mesh or a list of defects: never a panic. And what passes keeps its
    /// promises.
    #[test]
    fn any_face_list_is_judged(
        list in prop::collection::vec(prop::collection::vec(0..9_u32, 0..6), 0..12),
        vertex_count in 0..9_usize,
    ) {
        let list: Faces = list.iter().collect();
        match Topology::from_faces(vertex_count, &list) {
            Ok(topology) => check(&topology, &list),
            Err(Error::NotManifold(defects)) => prop_assert!(!defects.0.is_empty()),
            Err(other) => prop_assert!(false, "{other}"),
        }
    }
}

#[test]
fn bounds_leave_out_nothing() {
    let mesh = shapes::tube(3, 4);
    assert_eq!(mesh.bounds().max.z, 1.0);
    assert!((mesh.bounds().diagonal() - 12.0_f64.sqrt()).abs() < 1e-15);
    assert!((Vec3::new(3e200, 4e200, 0.0).length() / 5e200 - 1.0).abs() < 1e-15);
}
