//! Any face list is a topology or a list of defects; the usual repair makes a topology of it, and
//! leaves a topology alone. What is a topology can be refined and fitted.
#![no_main]

use fairform::interpolate::{self, Options};
use fairform::repair::Soup;
use fairform::{Error, Faces, Mesh, NONE, Rules, Topology, Vec3, VertexId, refine};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((&[vertex_count, ref at @ ..], rest)) = bytes.split_first_chunk::<4>() else { return };
    let soup = soup(usize::from(vertex_count), *at, rest);

    let vertex_count = soup.positions.len();
    let is_sound = match Topology::from_faces(vertex_count, &soup.faces) {
        Ok(topology) => {
            check(&topology, &soup.faces);
            true
        }
        Err(Error::NotManifold(defects)) => {
            assert!(!defects.0.is_empty());
            false
        }
        Err(other) => panic!("{other}"),
    };

    let mut mended = soup.clone();
    let changed = repair(&mut mended);
    assert!(!(is_sound && changed), "repair leaves a topology alone");
    let topology = Topology::from_faces(mended.positions.len(), &mended.faces)
        .expect("the usual repair makes a topology of anything");
    check(&topology, &mended.faces);
    assert!(!repair(&mut mended), "repair has nothing left to do");

    let _ = mended.fill_holes(20);
    let _ = mended.orient_outward();
    let _ = mended.triangulate();
    // Diagonals can have met an edge.
    let Ok(mesh) = Mesh::new(mended.positions, &mended.faces) else { return };
    fit(&mesh);
});

/// The first byte of a face says how many corners it has, the others are its vertices.
fn soup(vertex_count: usize, at: [u8; 3], mut bytes: &[u8]) -> Soup {
    // Few different places, so that some vertices meet and some faces are flat.
    let [a, b, c] = at.map(usize::from);
    let place = |i: usize, step: usize| ((i * (step | 1)) % 16) as f64;
    let positions =
        (0..vertex_count).map(|i| Vec3::new(place(i, a), place(i, b), place(i * i, c))).collect();
    let mut faces = Faces::new();
    while let Some((&size, rest)) = bytes.split_first() {
        let (face, rest) = rest.split_at(rest.len().min(usize::from(size % 8)));
        faces.push(&face.iter().map(|&v| u32::from(v)).collect::<Vec<_>>());
        bytes = rest;
    }
    Soup::new(positions, faces)
}

/// The usual steps; whether faces changed.
fn repair(soup: &mut Soup) -> bool {
    let degenerate = soup.drop_degenerate().changed();
    let duplicates = soup.drop_duplicates().changed();
    let orient = soup.orient().changed();
    let split = soup.split_non_manifold().changed();
    degenerate || duplicates || orient || split
}

/// Twins, edges and fans agree with each other and with the faces.
fn check(topology: &Topology, faces: &Faces) {
    assert_eq!(topology.to_faces().corners(), faces.corners());
    for h in topology.halfedges() {
        assert_eq!(topology.next(topology.prev(h)), h);
        if let Some(t) = topology.twin(h) {
            assert_eq!(topology.twin(t), Some(h));
            assert_eq!(topology.origin(t), topology.target(h));
            assert_eq!(topology.edge(t), topology.edge(h));
        }
    }
    let mut corner_count = 0;
    for v in topology.vertices() {
        corner_count += topology.fan(v).filter(|&h| topology.origin(h) == v).count();
        assert_eq!(topology.ring(v).count(), topology.valence(v) as usize);
    }
    assert_eq!(corner_count, topology.halfedge_count());
    let components = topology.components();
    let isolated = |v: VertexId| topology.is_isolated(v);
    assert!(topology.vertices().all(|v| (components.of_vertex[v.index()] == NONE) == isolated(v)));
}

fn fit(mesh: &Mesh) {
    let options = Options { iterations: 300, ..Options::default() };
    match interpolate::interpolate(mesh, &Rules::LOOP, &options) {
        Ok((control, report)) => {
            assert!(control.positions().iter().all(|p| p.is_finite()));
            assert!(report.is_converged(), "{report:?}");
            let (finer, _) = refine::refine_mesh(&control, &Rules::LOOP, 1)
                .expect("what is fitted can be refined");
            check(finer.topology(), &finer.topology().to_faces());
        }
        Err(Error::NoVertices | Error::NotTriangles { .. }) => {}
        Err(other) => panic!("{other}"),
    }
}
