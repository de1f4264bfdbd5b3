//! A small base and what its faces stand for: the same surface as from one step after the other.

use crate::common::{assorted, mixed, polygons, random_creases, random_mesh};
use fairform::refine::refine;
use fairform::tessellate::{MOST_WITH_SMALL_BASE, Part, Points, Tessellation, base_level};
use fairform::{Faces, Mesh, Rules, Scheme, Topology, Vec3, limit, shapes};
use std::collections::BTreeMap;
use std::sync::Arc;

/// For each corner of each face where it lies in the control mesh: coordinates that are linear within
/// the face, and its number.
fn places(topology: &Topology) -> Vec<Vec3> {
    let place = |f| {
        let n = topology.face_halfedges(f).len() as f64;
        (0..).zip(topology.face_halfedges(f)).map(move |(i, _)| {
            let angle = std::f64::consts::TAU * f64::from(i) / n;
            Vec3::new(angle.cos(), angle.sin(), f64::from(f.0))
        })
    };
    topology.faces().flat_map(place).collect()
}

type Key = [i64; 3];

fn key(place: Vec3) -> Key {
    let whole = |x: f64| (x * f64::from(1 << 24)).round() as i64;
    [place.x, place.y, place.z].map(whole)
}

/// Points and normals by the places of corners, and the faces as lists of such.
type Surface = (BTreeMap<Key, (Vec3, Vec3)>, Vec<Vec<Key>>);

fn by_place(faces: &Faces, places: &[Vec3], points: &[Vec3], normals: &[Vec3]) -> Surface {
    let mut at = BTreeMap::new();
    let corners = faces.corners().iter().zip(places);
    for (&v, &place) in corners {
        let value = (points[v as usize], normals[v as usize]);
        let known = at.insert(key(place), value);
        assert!(known.is_none_or(|known| known == value), "one place, one vertex");
    }
    let mut keys = places.iter().map(|&place| key(place));
    let mut lists: Vec<Vec<Key>> = faces
        .iter()
        .map(|f| {
            let mut list: Vec<Key> = keys.by_ref().take(f.len()).collect();
            let first = (0..list.len()).min_by_key(|&i| list[i]).unwrap();
            list.rotate_left(first);
            list
        })
        .collect();
    lists.sort();
    (at, lists)
}

/// All by ordinary steps; the last is the parent of each face.
fn stepped(mesh: &Mesh, rules: &Rules, levels: u32, points: Points) -> (Surface, Vec<u32>) {
    let (mut topology, mut rules) = (Arc::clone(mesh.topology()), rules.clone());
    let (mut values, mut places) = (mesh.positions().to_vec(), places(&topology));
    let mut parents: Vec<u32> = (0..topology.face_count() as u32).collect();
    for _ in 0..levels {
        let step = refine(&topology, &rules).unwrap();
        values = step.apply(&values);
        places = step.apply_to_corners(&places).unwrap();
        parents = step.topology.faces().map(|f| parents[step.parent(f).index()]).collect();
        (topology, rules) = (Arc::new(step.topology.clone()), step.next.clone());
    }
    let normals = limit::limit_normals(&topology, &values, &rules).unwrap();
    if points == Points::Limit {
        values = limit::limit_points(&topology, &values, &rules).unwrap();
    }
    (by_place(&topology.to_faces(), &places, &values, &normals), parents)
}

/// Compares, and tells how many steps were made at once.
fn check(mesh: &Mesh, rules: &Rules, levels: u32, points: Points, name: &str) -> u32 {
    let ((expected, faces), parents) = stepped(mesh, rules, levels, points);
    let fine = Tessellation::with_base(mesh.topology(), rules, levels, 0, points).unwrap();
    let surface = fine.surface(mesh.positions()).unwrap();
    let (positions, normals) = surface.points_and_normals();
    let base_faces = fine.base().face_count();
    let base_places = fine.base_corners(&places(mesh.topology())).unwrap();
    let own = fine.corners_in(0..base_faces, &base_places);
    let (actual, own_faces) = by_place(&fine.faces(), &own, &positions, &normals);
    assert!(faces == own_faces, "{name}: faces");
    let diagonal = mesh.bounds().diagonal();
    for (at, (p, n)) in &expected {
        let (q, m) = actual[at];
        assert!((*p - q).length() <= 1e-13 * diagonal, "{name} {at:?}: {p:?} is not {q:?}");
        assert!((*n - m).length() <= 1e-9, "{name} {at:?}: {n:?} is not {m:?}");
    }
    // Parents: of each face of the base, and so of each that it is cut into.
    let per_face = fine.face_count() / base_faces;
    let own = fine.parents();
    let mut counts = vec![0; mesh.topology().face_count()];
    own.iter().for_each(|&f| counts[f as usize] += per_face);
    parents.iter().for_each(|&f| counts[f as usize] -= 1);
    assert!(counts.iter().all(|&count| count == 0), "{name}: parents");
    for (f, &parent) in own.iter().enumerate() {
        let corners = fine.corners_in(f..f + 1, &base_places);
        assert!(corners.iter().all(|place| place.z == f64::from(parent)), "{name}: face {f}");
    }
    // Parts are the whole, bit for bit, and patches fit.
    for part in fine.parts() {
        let numbers = fine.numbers_of(&part);
        let (mut p, mut n) = (vec![Vec3::ZERO; numbers.len()], vec![Vec3::ZERO; numbers.len()]);
        surface.fill_part(&part, &mut p, Some(&mut n));
        assert!(p == positions[numbers.clone()] && n == normals[numbers], "{name}: {part:?}");
    }
    for f in fine.base().faces() {
        let numbers = fine.patch_numbers(f);
        let mut p = vec![Vec3::ZERO; numbers.len()];
        surface.fill_patch(f, &mut p, None::<&mut [Vec3]>);
        let at: Vec<Vec3> = numbers.iter().map(|&i| positions[i as usize]).collect();
        assert!(p == at, "{name}: patch {f}");
        let mut corners = vec![0; fine.patch_faces(f).corners().len()];
        fine.fill_faces(f.index()..f.index() + 1, &mut corners);
        let of_patch = |&i: &u32| numbers[i as usize];
        assert!(fine.patch_faces(f).corners().iter().map(of_patch).eq(corners), "{name}: {f}");
    }
    let inside = fine.numbers_of(&Part::Inside(0..1)).len();
    (1..=MOST_WITH_SMALL_BASE)
        .find(|j| {
            let n = (1_usize << j) - 1;
            let loop_inner = if n > 0 { n * (n - 1) / 2 } else { 0 };
            inside == if rules.scheme == Scheme::Loop { loop_inner } else { n * n }
        })
        .unwrap_or(0)
}

#[test]
fn a_small_base_gives_the_same_surface() {
    let triangles = assorted().into_iter().map(|(name, mesh)| (Scheme::Loop, name, mesh));
    let meshes = polygons().into_iter().map(|(name, mesh)| (Scheme::CatmullClark, name, mesh));
    for (scheme, name, mesh) in triangles.chain(meshes) {
        // Where nearly parallel tangents leave no normal.
        if name.contains("back to back") || mesh.topology().face_count() > 40 {
            continue;
        }
        let at_once = check(&mesh, &scheme.into(), 5, Points::Limit, name);
        assert_eq!(at_once, 4, "{name}");
    }
    let cube = shapes::cube();
    assert_eq!(check(&cube, &Scheme::CatmullClark.into(), 6, Points::Control, "cube"), 5);
    assert_eq!(check(&shapes::tetrahedron(), &Rules::LOOP, 6, Points::Limit, "tetrahedron"), 5);
}

#[test]
fn creases_and_mixed_faces_have_a_small_base_too() {
    let mesh = mixed();
    let creases = Some(random_creases(mesh.topology(), 5, 30).into());
    let rules = Rules { creases, ..Scheme::CatmullClark.into() };
    check(&mesh, &rules, 5, Points::Control, "mixed");
    let mesh = shapes::octahedron();
    let creases = Some(random_creases(mesh.topology(), 3, 30).into());
    check(&mesh, &Rules { creases, ..Rules::LOOP }, 5, Points::Control, "octahedron");
}

/// Vertices with too many neighbours for rows of their own: fewer steps are made at once, and where
/// none but the usual number are possible, those.
#[test]
fn what_is_special_does_not_take_memory_without_bound() {
    let mesh = shapes::bipyramid(200);
    let fine = |levels, most| {
        Tessellation::with_base(mesh.topology(), &Rules::LOOP, levels, most, Points::Limit).unwrap()
    };
    let per_face = |fine: &Tessellation| fine.face_count() / fine.base().face_count();
    assert_eq!(per_face(&fine(4, 0)), 64, "400 faces left of 1600");
    assert_eq!(per_face(&fine(2, 0)), 4);
    assert_eq!(base_level(mesh.topology(), &Rules::LOOP, 4, 0), Ok(1));
    assert_eq!(base_level(mesh.topology(), &Rules::LOOP, 7, 0), Ok(2));
    assert_eq!(base_level(mesh.topology(), &Rules::LOOP, 7, 400 * 64), Ok(3));
    assert_eq!(base_level(mesh.topology(), &Rules::LOOP, 7, u64::MAX), Ok(4));
    let plain = random_mesh(3, 10, 0);
    let large = Tessellation::with_base(plain.topology(), &Rules::LOOP, 5, 0, Points::Limit);
    assert!(base_level(plain.topology(), &Rules::LOOP, 5, 0) == Ok(1));
    assert_eq!(per_face(&large.unwrap()), 256);
}

/// The faces of each face of the base are as many as are written for it, and come one behind the other.
#[test]
fn faces_know_their_face_of_the_base() {
    for (mesh, scheme) in [
        (shapes::torus(5, 7), Scheme::Loop),
        (shapes::torus(5, 7), Scheme::Butterfly),
        (shapes::cube(), Scheme::CatmullClark),
        (shapes::torus(5, 7), Scheme::DooSabin),
        (shapes::sheet(4, 5, |x, y| x * y), Scheme::DooSabin),
    ] {
        for levels in 0..4 {
            let rules = Rules::from(scheme);
            let fine = Tessellation::new(mesh.topology(), &rules, levels, Points::Limit).unwrap();
            let (of, faces) = (fine.base_of_faces(), fine.faces());
            assert_eq!(of.len(), faces.len(), "{scheme} {levels}");
            for f in fine.base().faces() {
                let own: Vec<&[u32]> =
                    faces.iter().zip(&of).filter(|face| *face.1 == f.0).map(|f| f.0).collect();
                let mut expected = vec![0; own.iter().map(|face| face.len()).sum()];
                fine.fill_faces(f.index()..f.index() + 1, &mut expected);
                assert_eq!(own.concat(), expected, "{scheme} {levels} {f}");
            }
        }
    }
}
