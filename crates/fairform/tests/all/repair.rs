//! Repair makes a manifold of any soup, says what it did, and leaves a manifold alone.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use fairform::repair::Soup;
use fairform::{FaceId, Faces, NONE, Vec3, VertexId};
use proptest::prelude::*;

// ---------------------------------------------------------------------------------------------
// An independent judge

/// Whether faces are an oriented manifold: proper faces, every directed edge at most once, and the
/// faces at each vertex one fan. Written without the code under test.
fn judge(vertex_count: usize, faces: &Faces) -> Result<(), String> {
    let mut directed = BTreeSet::new();
    let mut corners_at: BTreeMap<u32, Vec<(u32, u32)>> = BTreeMap::new();
    for (f, face) in faces.iter().enumerate() {
        let distinct: BTreeSet<_> = face.iter().collect();
        if face.len() < 3 || distinct.len() < face.len() {
            return Err(format!("face {f} is {face:?}"));
        }
        for i in 0..face.len() {
            let (p, v, n) =
                (face[(i + face.len() - 1) % face.len()], face[i], face[(i + 1) % face.len()]);
            if v as usize >= vertex_count {
                return Err(format!("face {f} lists {v} of {vertex_count}"));
            }
            if !directed.insert((v, n)) {
                return Err(format!("{v} -> {n} twice"));
            }
            corners_at.entry(v).or_default().push((p, n));
        }
    }
    for (v, corners) in corners_at {
        // A face that leaves v along an edge is followed by the one that arrives along it.
        let arriving: BTreeMap<u32, usize> =
            corners.iter().enumerate().map(|(i, &(p, _))| (p, i)).collect();
        let start = (0..corners.len())
            .find(|&i| corners.iter().all(|&(_, n)| n != corners[i].0))
            .unwrap_or(0);
        let (mut seen, mut at) = (1, start);
        while let Some(&next) = arriving.get(&corners[at].1) {
            if next == start {
                break;
            }
            seen += 1;
            at = next;
        }
        if seen != corners.len() {
            return Err(format!("vertex {v} has {} faces, one fan {seen}", corners.len()));
        }
    }
    Ok(())
}

#[track_caller]
fn assert_manifold(soup: &Soup) {
    if let Err(defect) = judge(soup.positions.len(), &soup.faces) {
        panic!("not a manifold: {defect}\n{soup:?}");
    }
}

/// Undirected edges with how many faces each has.
fn edge_uses(faces: &Faces) -> BTreeMap<(u32, u32), usize> {
    let mut uses = BTreeMap::new();
    for face in faces.iter() {
        for (&a, &b) in face.iter().zip(face.iter().cycle().skip(1)) {
            *uses.entry((a.min(b), a.max(b))).or_default() += 1;
        }
    }
    uses
}

fn boundary_edge_count(faces: &Faces) -> usize {
    edge_uses(faces).values().filter(|&&n| n == 1).count()
}

fn used_vertex_count(faces: &Faces) -> usize {
    faces.corners().iter().collect::<BTreeSet<_>>().len()
}

/// V − E + F over the used vertices.
fn euler(faces: &Faces) -> i64 {
    let signed = |n: usize| i64::try_from(n).unwrap();
    signed(used_vertex_count(faces) + faces.len()) - signed(edge_uses(faces).len())
}

/// Sources are in range, and positions and vertices are those of the sources.
fn assert_sources(soup: &Soup, input: &Soup) {
    assert_eq!(soup.vertex_source.len(), soup.positions.len());
    assert_eq!(soup.face_source.len(), soup.faces.len());
    assert_eq!(soup.corner_source.len(), soup.faces.corners().len());
    let bits = |p: Vec3| [p.x, p.y, p.z].map(f64::to_bits);
    for (&p, &v) in soup.positions.iter().zip(&soup.vertex_source) {
        assert_eq!(bits(p), bits(input.positions[v as usize]));
    }
    let kept: BTreeSet<u32> = soup.vertex_source.iter().copied().collect();
    let start = soup.faces.starts();
    for (f, &from) in soup.face_source.iter().enumerate() {
        let corners = &soup.corner_source[start[f] as usize..start[f + 1] as usize];
        if from == NONE {
            assert!(corners.iter().all(|&c| c == NONE));
        } else {
            let whole =
                input.faces.starts()[from as usize]..input.faces.starts()[from as usize + 1];
            assert!(corners.iter().all(|c| whole.contains(c)));
        }
    }
    for (&v, &c) in soup.faces.corners().iter().zip(&soup.corner_source) {
        if c != NONE && (v as usize) < soup.positions.len() {
            let (now, then) = (soup.vertex_source[v as usize], input.faces.corners()[c as usize]);
            assert!(now == then || !kept.contains(&then), "only a welded vertex changes its name");
        }
    }
}

/// Twice the area vector of a polygon.
fn area(positions: &[Vec3], face: &[u32]) -> Vec3 {
    let at = |i: usize| positions[face[i % face.len()] as usize];
    (0..face.len()).map(|i| at(i).cross(at(i + 1))).sum()
}

/// Six times the signed volume.
fn volume(soup: &Soup) -> f64 {
    let at = |v: u32| soup.positions[v as usize];
    let of = |face: &[u32]| -> f64 {
        face[1..].windows(2).map(|w| at(face[0]).dot(at(w[0]).cross(at(w[1])))).sum()
    };
    soup.faces.iter().map(of).sum()
}

// ---------------------------------------------------------------------------------------------
// Meshes

fn points(list: &[[f64; 3]]) -> Vec<Vec3> {
    list.iter().map(|&p| p.into()).collect()
}

/// A soup whose positions do not matter: points of a moment curve, no four in a plane.
fn soup(vertex_count: u32, faces: &[&[u32]]) -> Soup {
    let at = |t: f64| Vec3::new(t, t * t, t * t * t);
    Soup::new(
        (0..vertex_count).map(|v| at(f64::from(v) / f64::from(vertex_count))).collect(),
        faces.iter().collect(),
    )
}

fn cube_points(low: f64) -> Vec<Vec3> {
    let at = |i: usize, bit: usize| low + f64::from(u8::from(i >> bit & 1 == 1));
    (0..8).map(|i| Vec3::new(at(i, 0), at(i, 1), at(i, 2))).collect()
}

const CUBE: [[u32; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

/// A flat n × n grid of quads without those for which `without` is true.
fn grid(n: u32, without: impl Fn(u32, u32) -> bool) -> Soup {
    let at = |i, j| j * (n + 1) + i;
    let mut faces = Faces::new();
    for j in 0..n {
        for i in (0..n).filter(|&i| !without(i, j)) {
            faces.push(&[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    let positions = (0..=n)
        .flat_map(|j| (0..=n).map(move |i| Vec3::new(f64::from(i), f64::from(j), 0.0)))
        .collect();
    Soup::new(positions, faces)
}

/// A throwaway reader, good enough for the files of this test.
fn read(name: &str) -> Soup {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/meshes").join(name);
    let text = std::fs::read_to_string(&path).unwrap();
    let mut positions = Vec::new();
    let mut faces = Faces::new();
    let number = |w: &str| w.parse::<f64>().unwrap();
    if path.extension().is_some_and(|e| e == "obj") {
        for line in text.lines() {
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => {
                    let c: Vec<f64> = words.map(number).collect();
                    positions.push(Vec3::new(c[0], c[1], c[2]));
                }
                Some("f") => {
                    let first = |w: &str| w.split('/').next().unwrap().parse::<u32>().unwrap();
                    faces.push(&words.map(|w| first(w) - 1).collect::<Vec<_>>());
                }
                _ => {}
            }
        }
    } else {
        let mut words = text
            .lines()
            .map(|line| line.split('#').next().unwrap())
            .flat_map(str::split_whitespace)
            .skip(1);
        let mut next = || words.next().unwrap();
        let [v, f, _] = [next(), next(), next()].map(|w| w.parse::<u32>().unwrap());
        for _ in 0..v {
            positions.push(Vec3::from([next(), next(), next()].map(number)));
        }
        for _ in 0..f {
            let n = next().parse::<u32>().unwrap();
            faces.push(&(0..n).map(|_| next().parse::<u32>().unwrap()).collect::<Vec<_>>());
        }
    }
    Soup::new(positions, faces)
}

// ---------------------------------------------------------------------------------------------
// Welding

#[test]
fn welding_joins_equal_positions_only() {
    let corners: Vec<u32> = CUBE.concat();
    let apart: Vec<Vec3> = corners.iter().map(|&v| cube_points(0.0)[v as usize]).collect();
    let input = Soup::new(apart, Faces::uniform(4, (0..24).collect()));
    let mut soup = input.clone();
    let report = soup.weld(0.0).unwrap();
    assert_eq!((report.joined.count, report.survivor_count), (16, 8));
    assert_eq!(report.joined.first[..3], [8, 9, 10].map(VertexId));
    assert_eq!(
        report.to_string(),
        "joined 16 vertices (8, 9, 10, 11, 12, 13, 14, 15, …) into 8 others"
    );
    assert_eq!(soup.positions.len(), 8);
    assert_eq!(boundary_edge_count(&soup.faces), 0);
    assert_manifold(&soup);
    assert!(volume(&soup) > 5.9);
    assert_eq!(soup.corner_source, (0..24).collect::<Vec<_>>());
}

#[test]
fn a_jittered_soup_needs_a_distance() {
    let wobble = |i: usize| 1e-7 * ((i as f64 * 0.754_877).fract() - 0.5);
    let corners: Vec<u32> = CUBE.concat();
    let jittered = |(i, &v): (usize, &u32)| {
        cube_points(0.0)[v as usize] + Vec3::new(wobble(i), wobble(i + 5), wobble(i + 9))
    };
    let input = Soup::new(
        corners.iter().enumerate().map(jittered).collect(),
        Faces::uniform(4, (0..24).collect()),
    );
    let mut soup = input.clone();
    assert_eq!(soup.weld(0.0).unwrap().joined.count, 0);
    assert_eq!(soup, input);
    assert_eq!(soup.weld(1e-6).unwrap().joined.count, 16);
    assert_manifold(&soup);
    assert_eq!(soup.positions[0], input.positions[0], "the survivor keeps its position");
    // From the far ends of the world, everything is one point.
    assert_eq!(soup.weld(1e9).unwrap().survivor_count, 1);
}

#[test]
fn welding_stands_odd_numbers() {
    let (inf, nan) = (f64::INFINITY, f64::NAN);
    let list = [
        [0.0, 0.0, 0.0],
        [-0.0, 0.0, -0.0],
        [nan, 0.0, 0.0],
        [nan, 0.0, 0.0],
        [inf, 1.0, 1.0],
        [inf, 1.0, 1.0],
        [-inf, 1.0, 1.0],
        [1e308, -1e308, 1e308],
        [-1e308, 1e308, -1e308],
        [5e-324, 0.0, 0.0],
    ];
    for (distance, expected) in [
        (0.0, &[0, 2, 3, 4, 6, 7, 8, 9][..]),
        (-0.0, &[0, 2, 3, 4, 6, 7, 8, 9]),
        (5e-324, &[0, 2, 3, 4, 6, 7, 8]),
        (1e300, &[0, 2, 3, 4, 6, 7, 8]),
        (inf, &[0, 2, 3, 4, 6]),
    ] {
        let mut soup = Soup::new(points(&list), Faces::uniform(5, (0..10).collect()));
        let _ = soup.weld(distance).unwrap();
        assert_eq!(soup.vertex_source, expected, "{distance:e}");
    }
    for bad in [-1.0, -1e-300, nan, -inf] {
        let input = Soup::new(points(&list), Faces::new());
        let mut soup = input;
        let error = soup.weld(bad).unwrap_err();
        assert!(error.to_string().contains("zero or more"), "{error}");
        assert_eq!(soup.positions.len(), list.len());
    }
}

/// Dense clusters, planes just further apart than the distance and long rows, where looking at all
/// pairs would take minutes.
#[test]
fn welding_is_fast_where_points_are_dense() {
    let n = 60_000_u32;
    let unit = |i: u32, k: u32| {
        f64::from(i.wrapping_mul(2_654_435_761).rotate_left(k) >> 8) / 16_777_216.0
    };
    let cluster =
        |x: f64| move |i| Vec3::new(x + 0.4 * unit(i, 3), 0.4 * unit(i, 11), 0.4 * unit(i, 19));
    let plane = |x: f64| move |i| Vec3::new(x + 1e-3 * unit(i, 3), unit(i, 11), unit(i, 19));
    let row = |i| Vec3::new(f64::from(i), 0.0, 0.0);
    for (positions, left) in [
        ((0..n).map(cluster(0.0)).collect::<Vec<_>>(), 1),
        ((0..n).map(cluster(0.0)).chain((0..n).map(cluster(1.5))).collect(), 2),
        ((0..n).map(plane(0.0)).chain((0..n).map(plane(1.01))).collect(), 2),
        ((0..n).map(row).collect(), 1),
        ((0..n).map(|i| 1.01 * row(i)).collect(), n as usize),
    ] {
        let mut soup = Soup::new(positions, Faces::new());
        let _ = soup.weld(1.0).unwrap();
        assert_eq!(soup.positions.len(), left);
    }
}

// ---------------------------------------------------------------------------------------------
// Degenerate and duplicate faces

/// The faces left of one face, and the report's text.
fn mended(face: &[u32]) -> (Vec<Vec<u32>>, String) {
    let input = soup(8, &[face]);
    let mut soup = input.clone();
    let report = soup.drop_degenerate();
    assert_sources(&soup, &input);
    assert_eq!(report.changed(), soup != input);
    (soup.faces.iter().map(<[u32]>::to_vec).collect(), report.to_string())
}

#[test]
fn degenerate_faces_are_mended_or_dropped() {
    for (face, left, text) in [
        (&[][..], &[][..], "dropped 1 face of fewer than 3 corners (0)"),
        (&[1], &[], "dropped 1 face of fewer than 3 corners (0)"),
        (&[1, 2], &[], "dropped 1 face of fewer than 3 corners (0)"),
        (&[1, 1, 1, 1], &[], "dropped 1 face of fewer than 3 corners (0)"),
        (&[1, 2, 1], &[], "dropped 1 face of fewer than 3 corners (0)"),
        (&[1, 2, 3, 2], &[], "dropped 1 face of fewer than 3 corners (0)"),
        (&[2, 1, 2, 3], &[], "dropped 1 face of fewer than 3 corners (0)"),
        (&[0, 1, 8], &[], "dropped 1 face with a vertex out of range (0)"),
        (&[0, 1, NONE], &[], "dropped 1 face with a vertex out of range (0)"),
        (&[0, 1, 2], &[&[0, 1, 2][..]], "no degenerate faces"),
        (&[0, 1, 2, 2], &[&[0, 1, 2]], "shortened 1 face with repeated corners (0)"),
        (&[0, 1, 2, 0], &[&[0, 1, 2]], "shortened 1 face with repeated corners (0)"),
        (&[0, 1, 2, 3, 2], &[&[0, 1, 2]], "shortened 1 face with repeated corners (0)"),
        (&[3, 2, 0, 1, 2], &[&[2, 0, 1]], "shortened 1 face with repeated corners (0)"),
        (&[0, 1, 2, 0, 3], &[&[0, 1, 2]], "shortened 1 face with repeated corners (0)"),
        (&[0, 1, 2, 3, 4, 3, 2], &[&[0, 1, 2]], "shortened 1 face with repeated corners (0)"),
        (
            &[0, 1, 2, 0, 3, 4, 5],
            &[&[0, 1, 2], &[0, 3, 4, 5]],
            "divided 1 face that met itself (0)",
        ),
        // Twice around is twice the same face.
        (&[0, 1, 2, 0, 1, 2], &[&[0, 1, 2], &[0, 1, 2]], "divided 1 face that met itself (0)"),
        // Out along three loops and back.
        (
            &[0, 1, 2, 3, 4, 2, 5, 6, 2],
            &[&[2, 3, 4], &[2, 5, 6], &[0, 1, 2]],
            "divided 1 face that met itself (0)",
        ),
        // A walk to and fro between two triangles encloses nothing that ears could fill.
        (&[0, 1, 2, 0, 3, 4, 5, 3], &[], "dropped 1 tangled face (0)"),
    ] {
        let (mut found, said) = mended(face);
        let mut left: Vec<Vec<u32>> = left.iter().map(|f| f.to_vec()).collect();
        found.sort();
        left.sort();
        assert_eq!(found, left, "{face:?}");
        assert_eq!(said, text, "{face:?}");
    }
}

#[test]
fn faces_without_finite_coordinates_go() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut positions = cube_points(0.0);
        positions[7].y = bad;
        let mut soup = Soup::new(positions, CUBE.iter().collect());
        let report = soup.drop_degenerate();
        assert_eq!((report.not_finite.count, soup.faces.len()), (3, 3));
        assert_eq!(soup.face_source, [0, 2, 4]);
    }
}

/// Files hold a polygon with a hole as one that goes in and out along a slit.
#[test]
fn a_polygon_with_a_slit_becomes_triangles_around_the_hole() {
    let square = |r: f64| [[-r, -r, 0.0], [r, -r, 0.0], [r, r, 0.0], [-r, r, 0.0]];
    let positions = points(&[square(2.0), square(1.0)].concat());
    // Around, in, around the hole the other way, and out.
    let slit: &[u32] = &[0, 1, 2, 3, 0, 4, 7, 6, 5, 4];
    let input = Soup::new(positions, [slit].into_iter().collect());
    let mut soup = input.clone();
    let report = soup.drop_degenerate();
    assert_eq!(report.to_string(), "divided 1 face that met itself (0)");
    assert_eq!(soup.faces.len(), 8);
    assert_manifold(&soup);
    assert_sources(&soup, &input);
    assert_eq!(euler(&soup.faces), 0, "a ring");
    let areas: Vec<f64> = soup.faces.iter().map(|f| area(&soup.positions, f).z).collect();
    assert!(areas.iter().all(|&a| a > 0.0));
    assert!((areas.iter().sum::<f64>() - 2.0 * 12.0).abs() < 1e-12);
}

/// Here ears exist, but two of the triangles would run along the same edge in the same direction.
#[test]
fn a_slit_that_ears_do_not_resolve_is_dropped() {
    let xy = [[5.0, 5.0], [0.0, 4.0], [5.0, 1.0], [2.0, 4.0], [4.0, 4.0]];
    let polygon: &[u32] = &[3, 0, 4, 3, 1, 0, 2, 1];
    let mut soup = Soup::new(points(&xy.map(|[x, y]| [x, y, 0.0])), [polygon].iter().collect());
    assert_eq!(soup.drop_degenerate().to_string(), "dropped 1 tangled face (0)");
}

#[test]
fn duplicates_go_in_either_winding() {
    let tetrahedron: Vec<&[u32]> = TETRAHEDRON.iter().map(|f| &f[..]).collect();
    for copy in [&[1, 3, 0][..], &[3, 1, 0]] {
        let mut faces = tetrahedron.clone();
        faces.insert(0, copy);
        let mut soup = soup(4, &faces);
        let report = soup.drop_duplicates();
        assert_eq!(report.dropped.first, [FaceId(2)], "the first copy stays");
        assert_eq!(soup.face_source, [0, 1, 3, 4]);
    }
    let mut same_vertices = soup(4, &[&[0, 1, 2, 3], &[0, 2, 1, 3], &[3, 2, 1, 0], &[3, 4, 5]]);
    assert_eq!(same_vertices.drop_duplicates().dropped.first, [FaceId(2)], "the order matters");
}

#[test]
fn a_closed_pair_of_faces_stays() {
    let pair: [&[u32]; 2] = [&[0, 1, 2], &[0, 2, 1]];
    let mut alone = soup(3, &pair);
    let report = alone.drop_duplicates();
    assert_eq!(report.to_string(), "kept 1 closed pair of faces back to back");
    assert_eq!(alone.faces.len(), 2);
    assert_manifold(&alone);

    let mut same_way = soup(3, &[&[0, 1, 2], &[1, 2, 0]]);
    assert_eq!(same_way.drop_duplicates().dropped.count, 1);
    let mut touched = soup(4, &[pair[0], pair[1], &[1, 0, 3]]);
    assert_eq!(touched.drop_duplicates().dropped.count, 1);
    let mut three = soup(3, &[pair[0], pair[1], pair[1]]);
    assert_eq!(three.drop_duplicates().dropped.count, 2);
}

// ---------------------------------------------------------------------------------------------
// Orientation

#[test]
fn the_majority_decides_the_direction() {
    let mut faces = CUBE;
    faces[1].reverse();
    faces[4].reverse();
    let input = Soup::new(cube_points(0.0), faces.iter().collect());
    let mut soup = input.clone();
    let report = soup.orient();
    assert_eq!(report.to_string(), "turned 2 faces (1, 4)");
    assert_eq!(report.component_count, 1);
    assert_manifold(&soup);
    assert_sources(&soup, &input);
    assert!((volume(&soup) - 6.0).abs() < 1e-12);
    assert_eq!(soup.faces.get(FaceId(1))[0], faces[1][0], "a turned face keeps its first corner");
}

#[test]
fn the_first_face_decides_a_tie() {
    let mut mixed = soup(6, &[&[0, 1, 2], &[2, 1, 3], &[3, 2, 4], &[3, 4, 5]]);
    assert_eq!(mixed.orient().flipped.count, 2);
    assert_eq!(mixed.faces.corners()[..6], [0, 1, 2, 2, 1, 3]);
    assert_manifold(&mixed);
}

#[test]
fn closed_surfaces_are_turned_outwards() {
    for place in [0.0, 1e6] {
        for scale in [1.0, 1e200, 1e-200] {
            let positions = cube_points(place).into_iter().map(|p| scale * p).collect();
            let inward = CUBE.iter().map(|f| f.iter().rev().copied().collect::<Vec<_>>());
            let mut soup = Soup::new(positions, inward.collect());
            let report = soup.orient_outward();
            assert_eq!(report.to_string(), "turned 1 closed surface that faced inwards (0)");
            assert!(area(&cube_points(0.0), soup.faces.get(FaceId(0))).z < 0.0);
            assert!(!soup.orient_outward().changed());
        }
    }
    let mut open = Soup::new(cube_points(0.0), CUBE[1..].iter().rev().collect());
    assert_eq!(open.orient_outward().closed_count, 0);
    let mut flat = soup(3, &[&[0, 1, 2], &[2, 1, 0]]);
    assert!(!flat.orient_outward().changed());
}

/// A Möbius strip of `n` quads.
fn moebius(n: u32) -> Soup {
    let faces: Vec<[u32; 4]> = (0..n)
        .map(|i| {
            let (a, b) = (2 * i, 2 * i + 1);
            if i + 1 < n { [a, a + 2, b + 2, b] } else { [a, 1, 0, b] }
        })
        .collect();
    soup(2 * n, &faces.iter().map(|f| &f[..]).collect::<Vec<_>>())
}

#[test]
fn a_one_sided_strip_is_reported_and_cut_at_one_seam() {
    for turned in [&[][..], &[2, 3], &[0, 2, 4, 6]] {
        let mut input = moebius(9);
        input.faces = (0..)
            .zip(input.faces.iter())
            .map(|(f, face)| {
                let mut face = face.to_vec();
                if turned.contains(&f) {
                    face.reverse();
                }
                face
            })
            .collect();
        let mut soup = Soup::new(input.positions, input.faces);
        let report = soup.orient();
        assert_eq!(report.one_sided.count, 1);
        assert!(!turned.is_empty() || !report.changed(), "one seam is as good as another");
        let report = soup.split_non_manifold();
        assert_eq!((report.edges.count, report.new_vertex_count), (1, 2), "{turned:?}");
        assert_manifold(&soup);
        assert_eq!(euler(&soup.faces), 1, "a strip with two ends is a disc");
    }
}

// ---------------------------------------------------------------------------------------------
// Splitting

#[test]
fn three_faces_at_an_edge_keep_the_flat_pair() {
    let positions = points(&[
        [0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 0.5, 0.0],
        [-1.0, 0.5, 0.1],
        [-0.1, 0.5, 1.0],
    ]);
    // The fin comes first in the input, yet the sheet stays together.
    let faces: [&[u32]; 3] = [&[0, 1, 4], &[1, 0, 2], &[0, 1, 3]];
    let input = Soup::new(positions, faces.iter().collect());
    let mut soup = input.clone();
    let report = soup.split_non_manifold();
    assert_eq!(
        report.to_string(),
        "parted the faces at 1 edge (0–1); divided 2 vertices (0, 1); added 2 vertices"
    );
    assert_manifold(&soup);
    assert_sources(&soup, &input);
    assert_eq!(soup.faces.get(FaceId(0)), [0, 1, 4], "the first fan keeps the vertex");
    assert_eq!(soup.faces.get(FaceId(1)), [5, 6, 2]);
    assert_eq!(soup.faces.get(FaceId(2)), [6, 5, 3]);
    assert_eq!(soup.vertex_source[5..], [1, 0]);
}

#[test]
fn boxes_that_touch_along_an_edge_come_apart() {
    let mut positions = cube_points(0.0);
    positions.extend(cube_points(0.0).iter().map(|&p| p + Vec3::new(1.0, 1.0, 0.0)));
    let faces = CUBE.iter().copied().chain(CUBE.iter().map(|f| f.map(|v| v + 8)));
    for backwards in [false, true] {
        let mut faces: Vec<[u32; 4]> = faces.clone().collect();
        if backwards {
            faces = faces.iter().map(|&[a, b, c, d]| [d, c, b, a]).collect();
            faces.reverse();
        }
        let mut soup = Soup::new(positions.clone(), faces.iter().collect());
        assert_eq!(soup.weld(0.0).unwrap().joined.count, 2);
        let report = soup.split_non_manifold();
        assert_eq!((report.edges.count, report.new_vertex_count), (1, 2));
        assert_manifold(&soup);
        assert_eq!(euler(&soup.faces), 4, "two spheres");
    }
}

/// Four pages of a book, a right angle apart, are two thin solids' edges or the gaps between them:
/// their fronts decide.
#[test]
fn faces_that_bend_alike_pair_away_from_their_fronts() {
    let page = |x: f64, y: f64| Vec3::new(x, y, 0.5);
    let positions = vec![
        Vec3::ZERO,
        Vec3::new(0.0, 0.0, 1.0),
        page(1.0, 0.0),
        page(0.0, 1.0),
        page(-1.0, 0.0),
        page(0.0, -1.0),
    ];
    for turned in [false, true] {
        let faces = [[0, 1, 2], [1, 0, 3], [0, 1, 4], [1, 0, 5]];
        let faces = faces.map(|[a, b, c]| if turned { [b, a, c] } else { [a, b, c] });
        let mut soup = Soup::new(positions.clone(), faces.iter().collect());
        let _ = soup.split_non_manifold();
        assert_manifold(&soup);
        // The first page looks along y, or along −y when turned.
        let (partner, other) = if turned { (1, 3) } else { (3, 1) };
        let shares = |f: u32| soup.faces.get(FaceId(f)).contains(&0);
        assert!(shares(0) && shares(partner) && !shares(other), "{soup:?}");
    }
}

#[test]
fn vertices_with_several_fans_are_divided() {
    let tetrahedra: Vec<[u32; 3]> =
        TETRAHEDRON.iter().flat_map(|&f| [f, f.map(|v| if v == 0 { 0 } else { v + 3 })]).collect();
    let mut closed = soup(7, &tetrahedra.iter().map(|f| &f[..]).collect::<Vec<_>>());
    assert_eq!(closed.split_non_manifold().to_string(), "divided 1 vertex (0); added 1 vertex");
    assert_eq!((closed.positions.len(), euler(&closed.faces)), (8, 4));
    assert_manifold(&closed);

    let mut open = soup(5, &[&[0, 1, 2], &[0, 3, 4]]);
    assert_eq!(open.split_non_manifold().new_vertex_count, 1);
    assert_eq!(open.faces.get(FaceId(1)), [5, 3, 4]);
}

/// Four faces meet at an edge, in pairs that are joined with each other by ways around both ends;
/// cutting the fans at the ends alone would not part them.
#[test]
fn pairs_at_an_edge_joined_around_its_ends_come_apart() {
    // Around 0 and around 1 the fans are 2 3 4 5 6 7 and close; all four of 2, 4, 5, 7 … touch 0–1.
    let faces: [&[u32]; 8] = [
        &[0, 1, 2],
        &[1, 0, 3],
        &[0, 1, 4],
        &[1, 0, 5],
        // From the pair 2|3 to the pair 4|5 and back, around 0 …
        &[0, 2, 5],
        &[0, 4, 3],
        // … and around 1.
        &[2, 1, 5],
        &[4, 1, 3],
    ];
    let input = soup(6, &faces);
    let mut soup = input.clone();
    let _ = soup.split_non_manifold();
    assert_manifold(&soup);
    assert_sources(&soup, &input);
    assert_eq!(soup.faces.len(), faces.len());
}

/// An edge in so many faces that looking at all pairs would take minutes.
#[test]
fn a_book_of_many_pages_is_split_quickly() {
    let n = 50_000_u32;
    let faces = (0..n).map(|i| if i % 2 == 0 { [0, 1, i + 2] } else { [1, 0, i + 2] });
    let positions = (0..n + 2).map(|i| Vec3::splat(f64::from(i))).collect();
    let mut soup = Soup::new(positions, faces.collect());
    let report = soup.split_non_manifold();
    assert_eq!(report.new_vertex_count, 2 * (n as usize / 2 - 1));
    assert_eq!(judge(soup.positions.len(), &soup.faces), Ok(()));
}

#[test]
fn indices_out_of_range_do_not_become_new_vertices() {
    let mut soup = soup(5, &[&[0, 1, 2], &[0, 3, 4], &[5, 1, 2], &[0, 1, 77]]);
    assert_eq!(soup.split_non_manifold().new_vertex_count, 1);
    assert_eq!(soup.drop_degenerate().out_of_range.count, 2);
}

// ---------------------------------------------------------------------------------------------
// Triangles

/// Cuts one polygon, checks what always holds, and gives the areas of the triangles along the
/// polygon's own area vector.
fn cut(list: &[[f64; 3]]) -> (Soup, Vec<f64>) {
    let n = list.len() as u32;
    let polygon: Vec<u32> = (0..n).collect();
    let input = Soup::new(points(list), [&polygon].into_iter().collect());
    let mut soup = input.clone();
    let report = soup.triangulate();
    assert_eq!(report.cut.count, 1);
    assert_eq!(soup.faces.len(), list.len() - 2);
    assert_manifold(&soup);
    assert_sources(&soup, &input);
    let whole = area(&input.positions, &polygon);
    let parts: Vec<Vec3> = soup.faces.iter().map(|t| area(&soup.positions, t)).collect();
    let sum: Vec3 = parts.iter().copied().sum();
    assert!((sum - whole).max_abs() <= 1e-12 * whole.max_abs().max(1.0));
    (soup, parts.iter().map(|a| a.dot(whole)).collect())
}

#[test]
fn quads_get_the_better_diagonal() {
    let diagonal = |soup: &Soup| {
        let sides = edge_uses(&soup.faces);
        if sides.contains_key(&(0, 2)) { (0, 2) } else { (1, 3) }
    };
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(diagonal(&cut(&square).0), (0, 2), "of equals the first");
    let kite = [[-2.0, 0.0, 0.0], [0.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(diagonal(&cut(&kite).0), (1, 3), "the shorter");
    // The diagonal 1–3 is shorter, but outside.
    let dart = [[0.0, 0.0, 0.0], [2.0, -0.4, 0.0], [0.5, 0.0, 0.0], [2.0, 0.4, 0.0]];
    let (soup, areas) = cut(&dart);
    assert_eq!(diagonal(&soup), (0, 2));
    assert!(areas.iter().all(|&a| a > 0.0));
    for scale in [1e300, 1e-300] {
        let scaled = points(&kite).into_iter().map(|p| scale * p).collect();
        let mut soup = Soup::new(scaled, Faces::uniform(4, vec![0, 1, 2, 3]));
        assert!(soup.triangulate().rough.is_empty());
        assert_eq!(diagonal(&soup), (1, 3));
    }
}

#[test]
fn concave_polygons_are_cut_inside() {
    // A comb with ten teeth, in a plane across all axes.
    let mut comb = vec![[20.0, -1.0], [0.0, -1.0]];
    comb.extend((0..10).flat_map(|i| {
        let x = 2.0 * f64::from(i);
        [[x, 5.0], [x + 1.0, 0.0]]
    }));
    let tilt = |[x, y]: [f64; 2]| [x + y, x - y + 3.0, 0.5 * x + 0.25 * y];
    let tilted: Vec<[f64; 3]> = comb.iter().map(|&p| tilt(p)).collect();
    let (_, areas) = cut(&tilted);
    assert!(areas.iter().all(|&a| a > 0.0), "{areas:?}");

    // A spiral, where most corners see little.
    let arm = |r: f64| {
        move |i: i32| {
            let t = 0.2 * f64::from(i);
            [(r + t) * t.cos(), (r + t) * t.sin(), 0.0]
        }
    };
    let spiral: Vec<[f64; 3]> =
        (0..100).map(arm(1.0)).chain((0..100).rev().map(arm(0.5))).collect();
    let (_, areas) = cut(&spiral);
    assert!(areas.iter().all(|&a| a > 0.0));
}

#[test]
fn corners_on_straight_sides_do_not_hurt() {
    let mut list = Vec::new();
    for (from, to) in [([0.0, 0.0], [4.0, 0.0]), ([4.0, 0.0], [4.0, 4.0]), ([4.0, 4.0], [0.0, 0.0])]
    {
        for i in 0..4 {
            let t = f64::from(i) / 4.0;
            list.push([from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1]), 1.0]);
        }
    }
    let (_, areas) = cut(&list);
    assert!(areas.iter().all(|&a| a > 0.0), "{areas:?}");
}

#[test]
fn flat_and_crossed_polygons_still_become_triangles() {
    let line: Vec<[f64; 3]> = (0..9).map(|i| [f64::from(i), 0.0, 0.0]).collect();
    let _ = cut(&line);
    let _ = cut(&[[1.0, 1.0, 1.0]; 6]);
    let star: Vec<[f64; 3]> = (0..5)
        .map(|i| f64::from(i) * 2.0 * std::f64::consts::TAU / 5.0)
        .map(|t| [t.cos(), t.sin(), 0.0])
        .collect();
    let _ = cut(&star);
    let mut infinite =
        Soup::new(vec![Vec3::splat(f64::NAN); 7], Faces::uniform(7, (0..7).collect()));
    assert_eq!(infinite.triangulate().rough.count, 1);
    assert_eq!(infinite.faces.len(), 5);
}

#[test]
fn a_huge_polygon_is_cut_in_bounded_time() {
    let n = 40_000_u32;
    let zigzag: Vec<Vec3> = (0..n)
        .map(|i| {
            let t = f64::from(i) * std::f64::consts::TAU / f64::from(n);
            let r = 1.0 + 0.1 * f64::from(i % 2);
            Vec3::new(r * t.cos(), r * t.sin(), 0.0)
        })
        .collect();
    let mut soup = Soup::new(zigzag, Faces::uniform(n, (0..n).collect()));
    assert!(soup.triangulate().rough.is_empty());
    assert_eq!(soup.faces.len(), n as usize - 2);
    assert_eq!(judge(soup.positions.len(), &soup.faces), Ok(()));
}

/// Two quads back to back may not have the same diagonal.
#[test]
fn triangulating_keeps_a_pillow_manifold() {
    let mut pillow = soup(4, &[&[0, 1, 2, 3], &[0, 3, 2, 1]]);
    let report = pillow.triangulate();
    assert!(report.doubled.is_empty());
    assert_manifold(&pillow);
    // Between three quads on four vertices there is no choice left.
    let mut tangle = soup(4, &[&[0, 1, 2, 3], &[0, 2, 1, 3]]);
    assert_eq!(tangle.triangulate().doubled.count, 2);
}

// ---------------------------------------------------------------------------------------------
// Holes

#[test]
fn holes_are_filled_up_to_a_size() {
    let input = grid(8, |i, j| (2..4).contains(&i) && (2..4).contains(&j) || (i, j) == (6, 6));
    let mut soup = input.clone();
    let report = soup.fill_holes(8);
    assert_eq!((report.filled.count, report.too_large.count), (2, 1));
    assert_eq!(report.new_face_count, 2 + 6);
    assert_manifold(&soup);
    assert_sources(&soup, &input);
    assert_eq!(boundary_edge_count(&soup.faces), 32);
    assert_eq!(soup.face_source[input.faces.len()..], [NONE; 8]);
    let areas: Vec<f64> = soup.faces.iter().map(|f| area(&soup.positions, f).z).collect();
    assert!(areas.iter().all(|&a| a > 0.0), "oriented like the sheet");
    assert!((areas.iter().sum::<f64>() - 64.0 * 2.0).abs() < 1e-12);
}

/// The smallest surface over a square that is folded along one diagonal is the fold itself.
#[test]
fn a_hole_gets_the_smallest_area() {
    let rim = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 0.0]];
    let below = rim.map(|[x, y, _]| [3.0 * x - 1.0, 3.0 * y - 1.0, -3.0]);
    let walls = (0..4).map(|i| [i, i + 4, (i + 1) % 4 + 4, (i + 1) % 4]);
    for twist in [0, 1] {
        let mut rim = rim.to_vec();
        // Stretching one diagonal makes the other fold smaller.
        rim[twist] = rim[twist].map(|x| 3.0 * x - 1.0);
        let mut soup = Soup::new(points(&[rim, below.to_vec()].concat()), walls.clone().collect());
        assert_eq!(soup.fill_holes(4).filled.count, 2);
        assert_manifold(&soup);
        let area_of = |quad: [[u32; 3]; 2]| -> f64 {
            quad.iter().map(|t| area(&soup.positions, t).length()).sum()
        };
        let (first, second) = (area_of([[0, 1, 2], [0, 2, 3]]), area_of([[0, 1, 3], [1, 2, 3]]));
        let has = |a, b| edge_uses(&soup.faces).contains_key(&(a, b));
        assert!((first - second).abs() > 1e-3);
        assert_eq!(has(0, 2), first < second);
        assert_eq!(has(1, 3), second < first);
    }
}

#[test]
fn a_hole_never_doubles_an_edge() {
    let walls = (0..4_u32).map(|i| [i, i + 4, (i + 1) % 4 + 4, (i + 1) % 4].to_vec());
    for (flaps, resisting) in [(vec![vec![0, 2, 8]], 0), (vec![vec![0, 2, 8], vec![1, 3, 9]], 1)] {
        let count = flaps.len();
        let faces: Faces = walls.clone().chain(flaps).collect();
        let mut soup = Soup::new(soup(10, &[]).positions, faces);
        let report = soup.fill_holes(4);
        assert_eq!(report.resisting.count, resisting);
        assert_eq!(report.filled.count, 2 - resisting + count);
        assert!(edge_uses(&soup.faces).values().all(|&n| n <= 2));
        let again = soup.clone();
        assert!(!soup.fill_holes(4).changed());
        assert_eq!(soup, again);
    }
}

/// The walk that turns faces may not depend on how they are turned.
#[test]
fn orienting_a_one_sided_tangle_twice_is_orienting_it_once() {
    let mut tangle = soup(5, &[&[1, 0, 2], &[2, 4, 0], &[1, 3, 2], &[4, 1, 0, 3], &[3, 4, 2]]);
    let _ = tangle.orient();
    assert!(!tangle.orient().changed());
}

/// A strip bent around until its ends share a vertex has one rim, which is no simple polygon.
#[test]
fn a_rim_that_meets_itself_stays_open() {
    let faces = (0..8).map(|i| if i % 2 == 0 { [i, i + 1, i + 2] } else { [i + 1, i, i + 2] });
    let faces: Vec<[u32; 3]> = faces.map(|f| f.map(|v| v % 9)).collect();
    let mut strip = soup(9, &faces.iter().map(|f| &f[..]).collect::<Vec<_>>());
    let report = strip.fill_holes(10);
    assert_eq!((report.filled.count, report.resisting.count), (0, 1));
}

#[test]
fn large_holes_are_filled_too() {
    let mut soup = grid(100, |i, j| (10..90).contains(&i) && (10..90).contains(&j));
    let report = soup.fill_holes(399);
    assert_eq!((report.filled.count, report.new_face_count), (1, 318));
    assert_manifold(&soup);
    assert!(soup.faces.iter().all(|f| area(&soup.positions, f).z > 0.0));
}

// ---------------------------------------------------------------------------------------------
// Found meshes

/// The usual order, with the counts of faces dropped on the way.
fn mend(soup: &mut Soup) -> [usize; 2] {
    let dropped = [soup.drop_degenerate().dropped_count(), soup.drop_duplicates().dropped.count];
    let _ = soup.orient();
    let _ = soup.split_non_manifold();
    dropped
}

#[test]
fn found_meshes_become_manifolds() {
    // Name, faces, one-sided parts, edges parted, vertices added. The strip is 4 quads wide and
    // the bottle 8 quads around.
    for (name, faces, one_sided, edges, added) in [
        ("bad_real/cow_bowtie.obj", 5804, 0, 0, 1),
        ("bad_real/beetle_nonmanifold.obj", 2053, 0, 47, 48),
        ("bad_real/conrod_nonmanifold.off", 6442, 0, 3, 6),
        ("bad_real/elephant_106loops.off", 4463, 0, 0, 0),
        ("bad_real/blobby_shuffled.off", 4050, 0, 0, 0),
        ("bad_real/catmark_nonman_edges.obj", 85, 0, 5, 7),
        ("bad_real/moebius_quads.obj", 224, 1, 4, 5),
        ("bad/klein_bottle_quads.obj", 96, 1, 8, 8),
    ] {
        let input = read(name);
        assert_eq!(input.faces.len(), faces, "{name}");
        let mut soup = input.clone();
        let _ = (soup.drop_degenerate(), soup.drop_duplicates());
        assert_eq!(soup.orient().one_sided.count, one_sided, "{name}");
        let split = soup.split_non_manifold();
        assert_eq!((split.edges.count, split.new_vertex_count), (edges, added), "{name}");
        assert_manifold(&soup);
        assert_sources(&soup, &input);
        let once = soup.clone();
        assert_eq!(mend(&mut soup), [0, 0]);
        assert_eq!(soup, once, "{name}");
        let _ = soup.triangulate();
        let _ = soup.fill_holes(60);
        assert_manifold(&soup);
    }
}

#[test]
fn shuffled_windings_come_back() {
    let mut soup = read("bad_real/blobby_shuffled.off");
    let _ = soup.orient();
    let _ = soup.orient_outward();
    assert_manifold(&soup);
    assert_eq!((boundary_edge_count(&soup.faces), euler(&soup.faces)), (0, 2));
    assert!(volume(&soup) > 0.0);
}

#[test]
fn an_elephant_of_many_loops_is_closed() {
    let mut soup = read("bad_real/elephant_106loops.off");
    let report = soup.fill_holes(usize::MAX);
    assert_eq!((report.filled.count, boundary_edge_count(&soup.faces)), (106, 0));
    assert_manifold(&soup);
}

// ---------------------------------------------------------------------------------------------
// Any soup

fn any_soup() -> impl Strategy<Value = Soup> {
    let coordinate = prop_oneof![
        8 => (-3_i32..=3).prop_map(f64::from),
        4 => -1.0..1.0,
        1 => prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(1e308), Just(-1e-310), Just(-0.0)],
    ];
    let position = [coordinate.clone(), coordinate.clone(), coordinate].prop_map(Vec3::from);
    // Few vertices make many collisions; some numbers are out of range.
    (1_u32..14).prop_flat_map(move |n| {
        let vertex = prop_oneof![60 => 0..n, 1 => n..n + 3, 1 => Just(NONE)];
        let face = prop_oneof![
            6 => prop::collection::vec(vertex.clone(), 3),
            3 => prop::collection::vec(vertex.clone(), 4),
            2 => prop::collection::vec(vertex, 0..10),
        ];
        let positions = prop::collection::vec(position.clone(), n as usize);
        (positions, prop::collection::vec(face, 0..40))
            .prop_map(|(positions, faces)| Soup::new(positions, faces.iter().collect()))
    })
}

/// Soups of finite points whose faces are proper.
fn proper_soup() -> impl Strategy<Value = Soup> {
    any_soup().prop_map(|mut soup| {
        for p in &mut soup.positions {
            let tame = |x: f64| if x.abs() < 10.0 { x } else { 0.5 };
            *p = Vec3::new(tame(p.x), tame(p.y), tame(p.z));
        }
        let _ = soup.drop_degenerate();
        Soup::new(soup.positions, soup.faces)
    })
}

/// Runs a step twice, checks what every step promises, and returns what the first run reported.
fn twice<R>(soup: &mut Soup, input: &Soup, step: impl Fn(&mut Soup) -> R) -> R {
    let before = soup.clone();
    let mut again = before.clone();
    let report = step(soup);
    let _ = step(&mut again);
    assert!(same(&again, soup), "the same input gives the same result");
    let _ = step(&mut again);
    assert!(same(&again, soup), "a second time changes nothing\n{before:?}\n{soup:?}\n{again:?}");
    assert_sources(soup, input);
    report
}

/// Equality where NaN equals itself.
fn same(a: &Soup, b: &Soup) -> bool {
    let bits = |s: &Soup| -> Vec<[u64; 3]> {
        s.positions.iter().map(|p| [p.x, p.y, p.z].map(f64::to_bits)).collect()
    };
    bits(a) == bits(b)
        && a.faces == b.faces
        && a.vertex_source == b.vertex_source
        && a.face_source == b.face_source
        && a.corner_source == b.corner_source
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_soup_becomes_a_manifold(input in any_soup(), holes in 0_usize..12) {
        let mut soup = input.clone();
        let _ = twice(&mut soup, &input, Soup::drop_degenerate);
        let faces = soup.faces.len();
        let duplicates = twice(&mut soup, &input, Soup::drop_duplicates).dropped.count;
        prop_assert_eq!(soup.faces.len() + duplicates, faces);
        let oriented = twice(&mut soup, &input, Soup::orient);
        prop_assert!(oriented.flipped.count < soup.faces.len().max(1));
        let vertices = soup.positions.len();
        let split = twice(&mut soup, &input, Soup::split_non_manifold);
        prop_assert_eq!(soup.positions.len(), vertices + split.new_vertex_count);
        prop_assert_eq!(soup.faces.len() + duplicates, faces);
        assert_manifold(&soup);

        let _ = twice(&mut soup, &input, Soup::orient_outward);
        let _ = twice(&mut soup, &input, Soup::drop_isolated);
        prop_assert_eq!(soup.positions.len(), used_vertex_count(&soup.faces));
        let filled = twice(&mut soup, &input, |soup| soup.fill_holes(holes));
        prop_assert!(filled.too_large.is_empty() || holes < 60);
        assert_manifold(&soup);
        let cut = twice(&mut soup, &input, Soup::triangulate);
        if cut.doubled.is_empty() {
            assert_manifold(&soup);
        }
        prop_assert!(soup.faces.iter().all(|f| f.len() == 3));
        let _ = twice(&mut soup, &input, |soup| soup.weld(0.0));
    }

    /// No step needs another one before it.
    #[test]
    fn no_step_minds_what_it_gets(input in any_soup(), order in prop::collection::vec(0..9, 1..8)) {
        let mut soup = input.clone();
        for step in order {
            match step {
                0 => drop(twice(&mut soup, &input, |s| s.weld(0.5)).unwrap()),
                1 => drop(twice(&mut soup, &input, Soup::drop_degenerate)),
                2 => drop(twice(&mut soup, &input, Soup::drop_duplicates)),
                3 => drop(twice(&mut soup, &input, Soup::orient)),
                4 => drop(twice(&mut soup, &input, Soup::orient_outward)),
                5 => drop(twice(&mut soup, &input, Soup::split_non_manifold)),
                6 => drop(twice(&mut soup, &input, Soup::triangulate)),
                7 => drop(twice(&mut soup, &input, Soup::drop_isolated)),
                _ => drop(twice(&mut soup, &input, |s| s.fill_holes(9))),
            }
        }
    }

    #[test]
    fn welding_agrees_with_all_pairs(
        list in prop::collection::vec([-9_i32..9, -9..9, -2..2], 0..200),
        distance in prop_oneof![Just(0.0), Just(1.0), Just(1.5), Just(2.0), 0.0..4.0],
        scale in prop_oneof![Just(1.0), Just(0.37), Just(1e-200), Just(1e200)],
    ) {
        let at = |p: &[i32; 3]| scale * Vec3::from(p.map(f64::from));
        let positions: Vec<Vec3> = list.iter().map(at).collect();
        let reach = scale * distance;
        let mut root: Vec<usize> = (0..list.len()).collect();
        for i in 0..list.len() {
            for j in 0..i {
                if (positions[i] - positions[j]).length() <= reach && root[i] != root[j] {
                    let (keep, lose) = (root[i].min(root[j]), root[i].max(root[j]));
                    root.iter_mut().filter(|r| **r == lose).for_each(|r| *r = keep);
                }
            }
        }
        let survivors: Vec<u32> =
            (0..list.len()).filter(|&i| root[i] == i).map(|i| i as u32).collect();
        let input = Soup::new(positions, (0..list.len() as u32).map(|v| [v]).collect());
        let mut soup = input.clone();
        let _ = twice(&mut soup, &Soup::new(input.positions.clone(), Faces::new()), |s| {
            s.corner_source.fill(NONE);
            s.face_source.fill(NONE);
            s.weld(reach).unwrap()
        });
        prop_assert_eq!(&soup.vertex_source, &survivors);
        for (i, face) in soup.faces.iter().enumerate() {
            prop_assert_eq!(soup.vertex_source[face[0] as usize] as usize, root[i]);
        }
    }

    #[test]
    fn triangulating_keeps_corner_counts_and_areas(input in proper_soup()) {
        let mut soup = input.clone();
        let report = twice(&mut soup, &input, Soup::triangulate);
        prop_assert_eq!(report.cut.count, input.faces.iter().filter(|f| f.len() > 3).count());
        prop_assert_eq!(soup.faces.len(), input.faces.iter().map(|f| f.len() - 2).sum::<usize>());
        for (f, face) in input.faces.iter().enumerate() {
            let parts = soup.faces.iter().zip(&soup.face_source).filter(|(_, from)| **from == f as u32);
            let sum: Vec3 = parts.map(|(t, _)| area(&soup.positions, t)).sum();
            prop_assert!((sum - area(&input.positions, face)).max_abs() < 1e-11);
        }
    }

    /// Mending single faces keeps the total area vector, unless faces are dropped.
    #[test]
    fn mending_polygons_keeps_the_area(corners in prop::collection::vec(0_u32..7, 3..12)) {
        let input = soup(7, &[&corners]);
        let mut soup = input.clone();
        let report = twice(&mut soup, &input, Soup::drop_degenerate);
        let sum: Vec3 = soup.faces.iter().map(|f| area(&soup.positions, f)).sum();
        if report.tangled.is_empty() {
            prop_assert!((sum - area(&input.positions, &corners)).max_abs() < 1e-12);
        }
    }
}
