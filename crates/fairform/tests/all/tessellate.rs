//! Many steps at once give what one after the other gives.

use crate::common::{assorted, polygons, random_creases, random_mesh};
use fairform::refine::refine;
use fairform::refine::refine_mesh;
use fairform::tessellate::{FACES_PER_CLASS, Points, Tessellation};
use fairform::{
    Border, Corners, Error, FaceId, HalfedgeId, Mesh, Rules, Scheme, Topology, Vec3, VertexId,
    limit, shapes,
};
use proptest::prelude::*;
use std::collections::BTreeMap;

/// For each point of a tessellation its vertex in the mesh that was refined step by step: the grid
/// of each face of the base is followed through the steps.
fn map(fine: &Tessellation, rules: &Rules, finest: &Topology, levels: u32) -> Vec<u32> {
    if levels == 0 {
        return (0..fine.vertex_count() as u32).collect();
    }
    if rules.scheme == Scheme::DooSabin {
        return dual_map(fine, rules, finest, levels);
    }
    let base = fine.base();
    let faces = fine.faces();
    let mut map = vec![u32::MAX; fine.vertex_count()];
    let per_face = faces.len() / base.face_count();
    for f in 0..base.face_count() {
        // The step by step children by their coordinates, and the faces row by row.
        let k = base.face_vertices(FaceId(f as u32)).len();
        let n = 1_i32 << levels;
        let corners = if k == 3 {
            vec![[0, 0], [n, 0], [0, n]]
        } else {
            vec![[0, 0], [n, 0], [n, n], [0, n]]
        };
        let mut vertex = BTreeMap::new();
        descend(finest, f, levels, &corners, &mut vertex);
        let mut here = (f * per_face..).map(|i| faces.get(FaceId(i as u32)));
        for v in 0..n {
            for u in 0..if k == 3 { n - v } else { n } {
                let mut cells = vec![vec![[u, v], [u + 1, v], [u, v + 1]]];
                if k == 4 {
                    cells = vec![vec![[u, v], [u + 1, v], [u + 1, v + 1], [u, v + 1]]];
                } else if u + v + 1 < n {
                    cells.push(vec![[u + 1, v], [u + 1, v + 1], [u, v + 1]]);
                }
                for cell in cells {
                    for (at, &point) in cell.iter().zip(here.next().unwrap()) {
                        let other = vertex[at];
                        let known = &mut map[point as usize];
                        assert!(*known == u32::MAX || *known == other, "one point, one vertex");
                        *known = other;
                    }
                }
            }
        }
    }
    for (v, slot) in map.iter_mut().enumerate().filter(|m| *m.1 == u32::MAX) {
        assert!(v < base.vertex_count(), "point {v} is in no face");
        *slot = v as u32;
    }
    map
}

/// Doo and Sabin's steps make half-edge `h` vertex `h`, and after those two of each boundary half-edge.
/// So a vertex becomes four, of its half-edges in order, or of two of them and the edges beside.
fn dual_map(fine: &Tessellation, rules: &Rules, finest: &Topology, levels: u32) -> Vec<u32> {
    let mut topology = fine.base().clone();
    let mut firsts: Vec<_> = topology.vertices().map(|v| topology.outgoing(v).unwrap()).collect();
    let rules = Rules { tension: None, border: Border::Bspline, ..rules.clone() };
    for level in 0..levels {
        let finer = refine(&topology, &rules).unwrap().topology;
        let boundary: Vec<_> =
            topology.halfedges().filter(|&h| topology.twin(h).is_none()).collect();
        let in_edge = |h, end| {
            let place = boundary.binary_search(&h).unwrap();
            VertexId((topology.halfedge_count() + 2 * place + end) as u32)
        };
        let (per_square, side) = (1 << (2 * level), 1 << level);
        let mut next = vec![HalfedgeId(u32::MAX); 4 * firsts.len()];
        for (i, &first) in firsts.iter().enumerate() {
            let (square, v, u) = (i / per_square, i % per_square / side, i % side);
            let mut slot = |a: usize, b: usize, h: HalfedgeId| {
                let place = (2 * v + b) * 2 * side + 2 * u + a;
                next[square * 4 * per_square + place] = h;
            };
            // Clockwise, so that all point in the direction of the first.
            let back = |h: HalfedgeId| finer.next(finer.twin(h).unwrap());
            slot(1, 1, first);
            let second = topology.twin(topology.prev(first)).unwrap();
            slot(0, 1, back(second));
            if let Some(third) = topology.twin(topology.prev(second)) {
                slot(0, 0, back(back(third)));
                let fourth = topology.twin(topology.prev(third)).unwrap();
                slot(1, 0, back(back(back(fourth))));
            } else {
                slot(0, 0, finer.outgoing(in_edge(topology.prev(second), 1)).unwrap());
                slot(1, 0, finer.outgoing(in_edge(first, 0)).unwrap());
            }
        }
        (topology, firsts) = (finer, next);
    }
    assert_eq!(&topology, finest);
    firsts.iter().map(|&h| topology.origin(h).0).collect()
}

/// The faces, each from its lowest vertex, in order.
fn sorted<'f>(faces: impl Iterator<Item = &'f [u32]>, map: impl Fn(u32) -> u32) -> Vec<Vec<u32>> {
    let mut all: Vec<Vec<u32>> = faces
        .map(|face| {
            let mut face: Vec<u32> = face.iter().map(|&v| map(v)).collect();
            let lowest = face.iter().enumerate().min_by_key(|v| v.1).unwrap().0;
            face.rotate_left(lowest);
            face
        })
        .collect();
    all.sort_unstable();
    all
}

fn descend(
    finest: &Topology,
    face: usize,
    levels: u32,
    at: &[[i32; 2]],
    out: &mut BTreeMap<[i32; 2], u32>,
) {
    if levels == 0 {
        let corners = finest.face_vertices(FaceId(face as u32));
        at.iter()
            .zip(corners)
            .for_each(|(&at, v)| assert!(out.insert(at, v.0).is_none_or(|w| w == v.0)));
        return;
    }
    let k = at.len();
    let mid = |i: usize, j: usize| [0, 1].map(|c| i32::midpoint(at[i % k][c], at[j % k][c]));
    for i in 0..4 {
        let child = match (k, i) {
            (3, 3) => vec![mid(0, 1), mid(1, 2), mid(2, 0)],
            (3, _) => vec![at[i % k], mid(i, i + 1), mid(i + 2, i)],
            _ => vec![at[i % k], mid(i, i + 1), mid(0, 2), mid(i + 3, i)],
        };
        descend(finest, 4 * face + i, levels - 1, &child, out);
    }
}

fn at_once(fine: &Tessellation, rules: &Rules) -> u32 {
    let base = fine.base();
    let (of_base, all) = match rules.scheme {
        Scheme::DooSabin => (base.vertex_count(), fine.vertex_count()),
        _ => (base.face_count(), fine.face_count()),
    };
    (0..16).find(|steps| of_base << (2 * steps) >= all).unwrap()
}

/// Compares with step by step refinement, and tells how many classes there were.
fn check(mesh: &Mesh, rules: &Rules, first: u32, levels: u32, name: &str) -> usize {
    let new = |points| Tessellation::from_level(mesh.topology(), rules, first, levels, points);
    check_made(mesh, rules, levels, name, |points| new(points).unwrap())
}

fn check_made(
    mesh: &Mesh,
    rules: &Rules,
    levels: u32,
    name: &str,
    new: impl Fn(Points) -> Tessellation,
) -> usize {
    let (stepped, next) = refine_mesh(mesh, rules, levels).unwrap();
    let (topology, values) = (stepped.topology(), stepped.positions());
    let diagonal = mesh.bounds().diagonal();
    let mut classes = 0;
    for points in [Points::Control, Points::Limit] {
        let fine = new(points);
        classes = fine.class_count();
        assert_eq!(fine.vertex_count(), topology.vertex_count(), "{name}");
        assert_eq!(fine.face_count(), topology.face_count(), "{name}");
        let expected = match points {
            Points::Control => values.to_vec(),
            Points::Limit => limit::limit_points(topology, values, &next).unwrap(),
        };
        let tangents = limit::limit_tangents(topology, values, &next).unwrap();
        let expected_normals = limit::limit_normals(topology, values, &next).unwrap();
        let (positions, normals) = fine.surface(mesh.positions()).unwrap().points_and_normals();
        let at_once = at_once(&fine, rules);
        let map = map(&fine, rules, topology, at_once);
        let mut seen = vec![false; map.len()];
        for (i, &v) in map.iter().enumerate() {
            assert!(!std::mem::replace(&mut seen[v as usize], true), "{name}: vertex {v} twice");
            let v = v as usize;
            let off = (positions[i] - expected[v]).length();
            assert!(off <= 1e-13 * diagonal, "{name} {points:?} point {i} is {off:e} off");
            // Where tangents are nearly parallel, or as good as zero, a normal is not well defined.
            if name.starts_with("back to back") {
                continue;
            }
            let [a, b] = tangents[v].map(Vec3::normalized);
            let sine = a.cross(b).length();
            let off = (normals[i] - expected_normals[v]).length();
            // The normals of both sides of a crease may nearly cancel; and with each step tangents
            // become shorter, but what positions are rounded by does not.
            let steps = f64::from(1_u32 << (2 * levels.saturating_sub(2)));
            let tolerance = if rules.creases.is_some() { 1e-9 } else { 1e-12 * steps };
            assert!(off * sine <= tolerance, "{name} {points:?} normal {i} is {off:e} off");
        }
        let expected = sorted(topology.to_faces().iter(), |v| v);
        assert_eq!(sorted(fine.faces().iter(), |v| map[v as usize]), expected, "{name}");
        // Vertices stay what they are.
        let stay = rules.scheme != Scheme::DooSabin;
        assert!(
            !stay || map[..mesh.topology().vertex_count()].iter().zip(0..).all(|(&v, i)| v == i)
        );
    }
    classes
}

/// Triangle and polygon meshes with the schemes that they suit.
fn suited() -> Vec<(Scheme, &'static str, Mesh)> {
    let triangles = assorted().into_iter().map(|(name, mesh)| (Scheme::Loop, name, mesh));
    let polygons = polygons().into_iter().map(|(name, mesh)| (Scheme::CatmullClark, name, mesh));
    triangles.chain(polygons).collect()
}

#[test]
fn steps_at_once_are_the_steps() {
    for (scheme, name, mesh) in suited() {
        for corners in [Corners::Smooth, Corners::Sharp] {
            let rules = Rules { corners, ..scheme.into() };
            for (first, levels) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 3)] {
                check(&mesh, &rules, first, levels, &format!("{name} {first} {levels}"));
            }
        }
    }
}

#[test]
fn sharp_and_fading_creases_are_the_same_at_once() {
    for (scheme, name, mesh) in suited() {
        for seed in [3, 11] {
            let creases = Some(random_creases(mesh.topology(), seed, 40).into());
            let rules = Rules { creases, ..scheme.into() };
            for (first, levels) in [(0, 2), (1, 3)] {
                check(&mesh, &rules, first, levels, &format!("{name} {seed} {first} {levels}"));
            }
        }
    }
}

#[test]
fn shape_parameters_and_support_are_the_same_at_once() {
    for (scheme, name, mesh) in suited() {
        let tension = (0..mesh.topology().face_count()).map(|f| 0.5 + 0.125 * (f % 5) as f64);
        let rules = Rules { tension: Some(tension.collect()), ..scheme.into() };
        check(&mesh, &rules, 0, 3, name);
        check(&mesh, &Rules { border: Border::None, ..scheme.into() }, 1, 3, name);
    }
}

#[test]
fn the_other_schemes_go_step_by_step() {
    let fine = |mesh: &Mesh, rules: &Rules| {
        let fine = Tessellation::new(mesh.topology(), rules, 2, Points::Limit).unwrap();
        let (stepped, next) = refine_mesh(mesh, rules, 2).unwrap();
        let expected = crate::common::limit_points(&stepped, &next);
        assert_eq!(fine.surface(mesh.positions()).unwrap().points(), expected);
        assert_eq!(fine.faces(), stepped.topology().to_faces());
    };
    for (_, mesh) in [("", shapes::icosahedron()), ("", shapes::fan(5))] {
        fine(&mesh, &Scheme::Butterfly.into());
    }
    fine(&crate::common::quad_sheet(4, 4), &Scheme::Kobbelt.into());
    // A vertex where so much meets that its squares would be large.
    fine(&shapes::bipyramid(100), &Scheme::DooSabin.into());
}

#[test]
fn vertices_become_squares() {
    let smooth = Rules::from(Scheme::DooSabin);
    let mut meshes: Vec<_> = polygons();
    meshes.extend(assorted());
    meshes.push(("bipyramid 60", shapes::bipyramid(60)));
    for (name, mesh) in meshes {
        for (first, levels) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (1, 4)] {
            let has_limit = levels > 0
                || fairform::limit::limit_points(mesh.topology(), mesh.positions(), &smooth)
                    .is_ok();
            if has_limit && (levels < 4 || mesh.topology().halfedge_count() < 100) {
                check(&mesh, &smooth, first, levels, &format!("{name} {first} {levels}"));
            }
        }
        let tension = (0..mesh.topology().face_count()).map(|f| 0.5 + 0.125 * (f % 4) as f64);
        let rules = Rules { tension: Some(tension.collect()), ..smooth.clone() };
        check(&mesh, &rules, 0, 2, name);
    }
    // All steps at once, where all vertices have four faces.
    let torus = shapes::torus(5, 7);
    let quads = refine_mesh(&torus, &Scheme::CatmullClark.into(), 1).unwrap().0;
    let (dual, next) = refine_mesh(&quads, &smooth, 1).unwrap();
    let fine = Tessellation::from_level(dual.topology(), &next, 0, 3, Points::Limit).unwrap();
    assert_eq!(fine.base(), &**dual.topology());
    assert_eq!(fine.vertex_count(), 64 * dual.topology().vertex_count());
    check(&dual, &next, 0, 3, "dual of a torus");
    // The boundary is dropped step by step.
    let rules = Rules { border: Border::Drop, ..smooth };
    let sheet = crate::common::quad_sheet(6, 5);
    let new = |points| Tessellation::new(sheet.topology(), &rules, 2, points);
    let stepped = refine_mesh(&sheet, &rules, 2).unwrap().0;
    assert_eq!(new(Points::Control).unwrap().faces(), stepped.topology().to_faces());
    assert!(matches!(new(Points::Limit).err(), Some(Error::NoLimit { .. })));
}

/// A vertex where so much meets that its faces have no class, and others that do.
#[test]
fn a_hub_goes_step_by_step() {
    for n in [60, 89, 90, 91, 200] {
        let rules = Rules::LOOP;
        let classes = check(&shapes::bipyramid(n), &rules, 1, 2, &format!("bipyramid {n}"));
        assert!(classes > 0);
    }
    check(&shapes::fan(200), &Rules::LOOP, 0, 2, "fan");
    check(&crate::common::prism(70), &Scheme::CatmullClark.into(), 1, 3, "prism");
}

/// Base, numbers of steps and classes of meshes of one valence, however large.
#[test]
fn a_base_has_few_classes() {
    let torus = shapes::torus(9, 12);
    assert_eq!(check(&torus, &Rules::LOOP, 1, 3, "torus"), 1);
    let fine = Tessellation::new(torus.topology(), &Rules::LOOP, 5, Points::Limit).unwrap();
    assert_eq!(fine.base().face_count(), 16 * torus.topology().face_count());
    assert_eq!(check(&shapes::icosahedron(), &Rules::LOOP, 1, 3, "icosahedron"), 2);
}

/// Without a mesh between where the faces of the control mesh are of few kinds, and with one where they are
/// of too many.
#[test]
fn a_large_mesh_of_few_kinds_is_its_own_base() {
    let few = FACES_PER_CLASS;
    let sheet = |n: u32| crate::common::quad_sheet(n, n);
    // Inside, at four sides and in four corners.
    assert!(63 * 63 < 9 * few && 71 * 71 >= 9 * few);
    for (scheme, mesh, classes) in [
        (Scheme::Loop, shapes::torus(24, 30), Some(1)),
        (Scheme::CatmullClark, sheet(72), Some(9)),
        (Scheme::CatmullClark, sheet(64), None),
        (Scheme::Loop, random_mesh(3, 40, 2), None),
    ] {
        let rules: Rules = scheme.into();
        let name = format!("{scheme} {classes:?}");
        for levels in 1..=if mesh.topology().face_count() > 2000 { 2 } else { 3 } {
            let new = |points| Tessellation::new(mesh.topology(), &rules, levels, points).unwrap();
            let made = check_made(&mesh, &rules, levels, &name, new);
            let is_direct = new(Points::Limit).base() == &**mesh.topology();
            assert_eq!(is_direct, classes.is_some(), "{name} {levels}");
            assert!(classes.is_none_or(|count| count == made), "{name}: {made}");
        }
    }
    // A mesh with shape parameters has to take the first step.
    let mesh = shapes::torus(24, 30);
    let rules = Rules { tension: Some(vec![0.7; 1440].into()), ..Rules::LOOP };
    let fine = Tessellation::new(mesh.topology(), &rules, 2, Points::Limit).unwrap();
    assert_eq!(fine.base().face_count(), 4 * 1440);
}

/// Published and independently computed values: control points two levels on, limit points, normals.
#[test]
fn golden_values() {
    let names = ["loop", "catmull-clark", "doo-sabin"].map(crate::common::golden_names).concat();
    assert!(names.len() > 15);
    for name in names {
        let fixture = crate::common::golden(&name);
        let is_plain = fixture["lambda"].is_null() && fixture["boundary"] != "drop";
        let scheme: Scheme = fixture["scheme"].as_str().unwrap().parse().unwrap();
        let corners = if fixture["corners"] == "sharp" { Corners::Sharp } else { Corners::Smooth };
        let (mesh, rules) =
            (crate::common::mesh(&fixture["mesh"]), Rules { corners, ..scheme.into() });
        if !is_plain {
            continue;
        }
        for level in fixture["refine"].as_array().unwrap() {
            let levels = level["level"].as_u64().unwrap() as u32;
            for first in 0..levels {
                let new = Tessellation::from_level;
                let fine = new(mesh.topology(), &rules, first, levels, Points::Control).unwrap();
                let points = fine.surface(mesh.positions()).unwrap().points();
                let stepped = refine_mesh(&mesh, &rules, levels).unwrap().0;
                let map = map(&fine, &rules, stepped.topology(), at_once(&fine, &rules));
                let expected = crate::common::points(&level["vertices"]);
                for (point, &v) in points.iter().zip(&map) {
                    assert!((*point - expected[v as usize]).length() < 1e-12, "{name} {v}");
                }
            }
        }
        // With Doo and Sabin's scheme the vertices are no points of the surface.
        if fixture["limit"].is_null() || scheme == Scheme::DooSabin {
            continue;
        }
        let fine = Tessellation::new(mesh.topology(), &rules, 3, Points::Limit).unwrap();
        let (limit, normals) = fine.surface(mesh.positions()).unwrap().points_and_normals();
        let count = mesh.topology().vertex_count();
        crate::common::assert_near(
            &limit[..count],
            &crate::common::points(&fixture["limit"]),
            1e-12,
            &name,
        );
        for (v, expected) in crate::common::points(&fixture["normals"]).iter().enumerate() {
            // Zero stands where the fixtures give none. Loop's convention for two faces on the boundary
            // depends on the level.
            let id = fairform::VertexId(v as u32);
            let is_convention = scheme == Scheme::Loop
                && mesh.topology().is_boundary(id)
                && mesh.topology().fan_size(id) == 2;
            let is_near = (normals[v] - *expected).length() < 1e-12;
            assert!(is_near || is_convention || *expected == Vec3::ZERO, "{name} normal {v}");
        }
    }
}

#[test]
fn bad_input_is_an_error() {
    let quads = shapes::cube();
    let new = |mesh: &Mesh, rules: &Rules, levels| {
        Tessellation::new(mesh.topology(), rules, levels, Points::Limit).err()
    };
    assert!(matches!(new(&quads, &Rules::LOOP, 3), Some(Error::NotTriangles { .. })));
    assert!(matches!(new(&shapes::icosahedron(), &Rules::LOOP, 40), Some(Error::TooLarge { .. })));
}

#[test]
fn results_do_not_depend_on_threads() {
    let mesh = random_mesh(5, 300, 5);
    for scheme in [Scheme::Loop, Scheme::CatmullClark, Scheme::DooSabin] {
        let fine = || {
            let rules = scheme.into();
            let fine = Tessellation::new(mesh.topology(), &rules, 3, Points::Limit).unwrap();
            let points = fine.surface(mesh.positions()).unwrap().points_and_normals();
            (points, fine.faces())
        };
        let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let one = pool(1).install(fine);
        assert!(one == pool(2).install(fine) && one == pool(5).install(fine));
    }
}

/// Patches and parts are what the whole is, bit for bit.
#[test]
fn patches_and_parts_make_the_whole() {
    let mut cases = vec![
        (random_mesh(8, 40, 3), Rules::LOOP, 3),
        (shapes::bipyramid(100), Rules::LOOP, 3),
        (crate::common::mixed(), Scheme::CatmullClark.into(), 2),
        (crate::common::mixed(), Scheme::DooSabin.into(), 1),
        (crate::common::mixed(), Scheme::DooSabin.into(), 3),
        (crate::common::quad_sheet(3, 4), Scheme::DooSabin.into(), 2),
        (shapes::cube(), Scheme::CatmullClark.into(), 4),
    ];
    let creases = Some(random_creases(cases[0].0.topology(), 7, 30).into());
    cases.push((cases[0].0.clone(), Rules { creases, ..Rules::LOOP }, 2));
    for (mesh, rules, levels) in cases {
        let fine = Tessellation::new(mesh.topology(), &rules, levels, Points::Limit).unwrap();
        let surface = fine.surface(mesh.positions()).unwrap();
        let (positions, normals) = surface.points_and_normals();
        let faces = fine.faces();
        let mut end = 0;
        for part in fine.parts() {
            let numbers = fine.numbers_of(&part);
            assert_eq!(numbers.start, end);
            end = numbers.end;
            let mut p = vec![Vec3::ZERO; numbers.len()];
            let mut n = p.clone();
            surface.fill_part(&part, &mut p, Some(&mut n));
            assert_eq!(p, positions[numbers.clone()], "{part:?}");
            assert_eq!(n, normals[numbers], "{part:?}");
        }
        assert_eq!(end, positions.len());
        let mut all = faces.iter();
        for face in fine.base().faces() {
            let numbers = fine.patch_numbers(face);
            let at = |all: &[Vec3]| numbers.iter().map(|&i| all[i as usize]).collect::<Vec<_>>();
            assert_eq!(surface.patch(face), (at(&positions), at(&normals)), "{face}");
            let patch_faces = fine.patch_faces(face);
            let of_patch = |p: &u32| numbers[*p as usize];
            for own in patch_faces.iter() {
                assert!(own.iter().map(of_patch).eq(all.next().unwrap().iter().copied()));
            }
            let mut corners = vec![0; patch_faces.corners().len()];
            fine.fill_faces(face.index()..face.index() + 1, &mut corners);
            assert!(patch_faces.corners().iter().map(of_patch).eq(corners));
        }
        assert!(all.next().is_none());
    }
}

/// Single precision is double precision rounded; positions alone are the same as with normals.
#[test]
fn formats_agree() {
    let mesh = random_mesh(8, 40, 3);
    let fine = Tessellation::new(mesh.topology(), &Rules::LOOP, 3, Points::Limit).unwrap();
    let surface = fine.surface(mesh.positions()).unwrap();
    let (positions, normals) = surface.points_and_normals();
    assert_eq!(surface.points(), positions);
    let mut single = [vec![[0.0_f32; 3]; positions.len()], vec![[0.0_f32; 3]; positions.len()]];
    let [p, n] = &mut single;
    surface.fill(p, Some(n));
    let rounded = |all: &[Vec3]| all.iter().map(|&p| p.into()).collect::<Vec<[f32; 3]>>();
    assert!(single == [rounded(&positions), rounded(&normals)]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn any_mesh(seed: u64, splits in 0_usize..12, holes in 0_usize..4, share in 0_u64..60) {
        let mesh = random_mesh(seed, splits, holes);
        let dual = Rules::from(Scheme::DooSabin);
        check(&mesh, &dual, 1, 2, "dual");
        check(&mesh, &dual, 1, 3, "dual");
        for scheme in [Scheme::Loop, Scheme::CatmullClark] {
            let smooth = Rules::from(scheme);
            let creases = Some(random_creases(mesh.topology(), seed, share).into());
            check(&mesh, &smooth, 1, 2, "smooth");
            check(&mesh, &smooth, 0, 2, "smooth");
            check(&mesh, &Rules { creases, ..smooth }, 1, 2, "creased");
        }
    }
}

#[test]
fn fields_are_surfaces_without_normals() {
    let mesh = shapes::torus(6, 9);
    for (scheme, levels) in [(Scheme::Loop, 0), (Scheme::Loop, 3), (Scheme::Butterfly, 1)] {
        let rules = scheme.into();
        for points in [Points::Control, Points::Limit] {
            let all = Tessellation::new(mesh.topology(), &rules, levels, points).unwrap();
            let field = all.field(mesh.positions()).unwrap();
            assert_eq!(field.points(), all.surface(mesh.positions()).unwrap().points());
        }
    }
}

#[test]
#[should_panic(expected = "no normals")]
fn fields_have_no_normals() {
    let mesh = shapes::octahedron();
    let all = Tessellation::new(mesh.topology(), &Rules::LOOP, 2, Points::Limit).unwrap();
    let _ = all.field(mesh.positions()).unwrap().points_and_normals();
}
