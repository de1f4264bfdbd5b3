//! Editing: drags equal solving again, and leave alone what they do not report.

use std::sync::Arc;

use crate::common::{
    assorted, limit_points, mixed, polygons, prism, quad_sheet, quad_torus, random_creases,
};
use fairform::edit::{Change, Editor};
use fairform::interpolate::{Norm, Options, interpolate};
use fairform::refine::refine;
use fairform::{
    Border, Creases, Defect, Error, Mesh, Rules, Scheme, Vec3, VertexId, pushback, shapes,
};
use proptest::prelude::*;

/// Control points as exact as they get.
fn solved(target: &Mesh, rules: &Rules) -> Vec<Vec3> {
    let options = Options { tolerance: Some(3e-15), norm: Norm::Absolute, ..Options::default() };
    interpolate(target, rules, &options).unwrap().0.into_positions()
}

fn editor(target: &Mesh, rules: &Rules, tolerance: f64) -> Editor {
    Editor::new(target, rules, solved(target, rules), tolerance).unwrap()
}

fn sheet(rows: u32, columns: u32) -> Mesh {
    shapes::sheet(rows, columns, |x, y| 0.3 * libm::sin(4.0 * x) * y)
}

fn two_phases(mesh: &Mesh, scheme: Scheme, share: f64) -> Rules {
    let tension = vec![share; mesh.topology().face_count()];
    Rules { tension: Some(tension.into()), ..scheme.into() }
}

fn creased(mesh: &Mesh, scheme: Scheme, seed: u64) -> Rules {
    Rules { creases: Some(Arc::new(random_creases(mesh.topology(), seed, 20))), ..scheme.into() }
}

/// A closed and an open mesh for each scheme, in one phase, in two, and with creases.
fn cases() -> Vec<(&'static str, Mesh, Rules)> {
    let (torus, sheet) = (shapes::torus(18, 21), sheet(17, 19));
    let (quads, open) = (quad_torus(19, 20), quad_sheet(18, 17));
    let two = |mesh: &Mesh, scheme, share| (mesh.clone(), two_phases(mesh, scheme, share));
    let cut = |mesh: &Mesh, scheme| (mesh.clone(), creased(mesh, scheme, 3));
    let loose: Vec<(&'static str, (Mesh, Rules))> = vec![
        ("loop closed", (torus.clone(), Rules::LOOP)),
        ("loop open", (sheet.clone(), Rules::LOOP)),
        ("loop closed, two phases", two(&torus, Scheme::Loop, 0.8)),
        ("loop open, two phases", two(&sheet, Scheme::Loop, 0.7)),
        ("loop closed, creases", cut(&torus, Scheme::Loop)),
        ("loop open, creases", cut(&sheet, Scheme::Loop)),
        ("catmull-clark closed", (quads.clone(), Scheme::CatmullClark.into())),
        ("catmull-clark open", (open.clone(), Scheme::CatmullClark.into())),
        ("catmull-clark closed, two phases", two(&quads, Scheme::CatmullClark, 0.8)),
        ("catmull-clark triangles", (torus, Scheme::CatmullClark.into())),
        ("catmull-clark closed, creases", cut(&quads, Scheme::CatmullClark)),
        ("catmull-clark open, creases", cut(&open, Scheme::CatmullClark)),
        ("doo-sabin closed", (quads.clone(), Scheme::DooSabin.into())),
        ("doo-sabin open", (open.clone(), Scheme::DooSabin.into())),
        ("doo-sabin closed, two phases", two(&quads, Scheme::DooSabin, 0.5)),
        ("doo-sabin open, two phases", two(&open, Scheme::DooSabin, 0.3)),
        ("doo-sabin triangles, two phases", two(&sheet, Scheme::DooSabin, 0.6)),
    ];
    loose.into_iter().map(|(name, (mesh, rules))| (name, mesh, rules)).collect()
}

fn largest_distance(a: &[Vec3], b: &[Vec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max)
}

/// The largest distance of a limit point from its data.
fn residual(mesh: &Mesh, editor: &Editor, rules: &Rules) -> f64 {
    let limit = limit_points(&mesh.with_positions(editor.control().to_vec()), rules);
    let pinned = mesh.topology().vertices().filter(|&v| !editor.is_free(v));
    pinned.map(|v| (limit[v.index()] - editor.target()[v.index()]).length()).fold(0.0, f64::max)
}

#[test]
fn dragging_equals_solving_again() {
    for (name, mesh, rules) in cases() {
        let count = mesh.topology().vertex_count() as u32;
        let middle = count / 2 + 9;
        for grabbed in [vec![middle], vec![0], vec![1, middle, middle + 1, count - 3]] {
            let grabbed: Vec<VertexId> = grabbed.into_iter().map(VertexId).collect();
            let mut editor = editor(&mesh, &rules, 1e-10);
            let drag = editor.grab(&grabbed).unwrap();
            let moves = [[0.5, 0.0, 0.1], [0.0, -0.7, 0.2], [0.1, 0.2, 0.4]].map(Vec3::from);
            let length: f64 = moves.iter().map(|m| m.length()).sum();
            for offset in moves {
                editor.drag(&drag, offset);
            }
            let mut target = mesh.positions().to_vec();
            for v in &grabbed {
                moves.iter().for_each(|&m| target[v.index()] += m);
            }
            assert_eq!(editor.target(), target, "{name}");
            let again = solved(&mesh.with_positions(target), &rules);
            let error = largest_distance(editor.control(), &again) / length;
            assert!(error <= 1e-9, "{name}, {grabbed:?}: {error:e}");
        }
    }
}

/// The promise of the tolerance, on meshes of all valences: that of the limit points.
#[test]
fn limit_points_follow_within_the_tolerance() {
    for scheme in [Scheme::Loop, Scheme::CatmullClark, Scheme::DooSabin] {
        let meshes = if scheme == Scheme::Loop { assorted() } else { polygons() };
        for (name, mesh) in meshes {
            let rules = Rules::from(scheme);
            let is_singular = !pushback::singular_components(mesh.topology(), &rules).is_empty();
            if is_singular || pushback::is_not_definite(mesh.topology(), &rules) {
                continue;
            }
            for tolerance in [1e-2, 1e-6] {
                // What the control points are does not matter, only how they move.
                let before = limit_points(&mesh, &rules);
                let control = mesh.positions().to_vec();
                for v in mesh.topology().vertices() {
                    let mut editor =
                        Editor::new(&mesh, &rules, control.clone(), tolerance).unwrap();
                    let drag = editor.grab(&[v]).unwrap();
                    editor.drag(&drag, Vec3::new(0.0, 3.0, 4.0));
                    let after =
                        limit_points(&mesh.with_positions(editor.control().to_vec()), &rules);
                    let mut expected = before.clone();
                    expected[v.index()] += Vec3::new(0.0, 3.0, 4.0);
                    let error = largest_distance(&after, &expected) / 5.0;
                    assert!(error <= tolerance + 1e-14, "{scheme}, {name}, {v}: {error:e}");
                }
            }
        }
    }
}

#[test]
fn what_is_not_reported_keeps_its_bits() {
    let irregular = refine_twice(&mixed(), &Scheme::CatmullClark.into());
    let mut all = cases();
    all.push(("poles", shapes::bipyramid(40), Rules::LOOP));
    all.push(("irregular", irregular.clone(), Scheme::CatmullClark.into()));
    all.push(("irregular, doo-sabin", irregular, Scheme::DooSabin.into()));
    for (name, mesh, rules) in all {
        let count = mesh.topology().vertex_count() as u32;
        for v in [0, 1, count / 2 + 7, count - 1].map(VertexId) {
            let control = mesh.positions().to_vec();
            let mut editor = Editor::new(&mesh, &rules, control, 0.1).unwrap();
            let drag = editor.grab(&[v]).unwrap();
            let changed = editor.drag(&drag, Vec3::new(0.3, -0.2, 0.5));
            assert!(changed.vertices.is_sorted() && changed.faces.is_sorted());
            let (before, after) = (mesh.positions(), editor.control());
            let moved =
                mesh.topology().vertices().filter(|v| before[v.index()] != after[v.index()]);
            assert_eq!(moved.collect::<Vec<_>>(), changed.vertices, "{name}");

            let step = refine(mesh.topology(), &rules).unwrap();
            let next = refine(&step.topology, &step.next).unwrap();
            let levels = [before, after].map(|p| {
                let first = step.apply(p);
                let second = next.apply(&first);
                [first, second]
            });
            let is_reported = |f| changed.faces.binary_search(&f).is_ok();
            let mut moved = vec![false; mesh.topology().face_count()];
            for f in step.topology.faces() {
                let same = |v: &VertexId| levels[0][0][v.index()] == levels[1][0][v.index()];
                let parent = step.parent(f);
                moved[parent.index()] |= !step.topology.face_vertices(f).iter().all(same);
            }
            for f in next.topology.faces() {
                let same = |v: &VertexId| levels[0][1][v.index()] == levels[1][1][v.index()];
                let parent = step.parent(next.parent(f));
                moved[parent.index()] |= !next.topology.face_vertices(f).iter().all(same);
            }
            for f in mesh.topology().faces() {
                assert!(is_reported(f) || !moved[f.index()], "{name}: face {f} moved");
            }
            let whole = changed.faces.len() == mesh.topology().face_count();
            assert!(!whole || name == "poles", "{name}: all faces are reported");
        }
    }
}

fn refine_twice(mesh: &Mesh, rules: &Rules) -> Mesh {
    fairform::refine::refine_mesh(mesh, rules, 2).unwrap().0
}

#[test]
fn the_neighbourhood_does_not_grow_with_the_mesh() {
    for scheme in [Scheme::Loop, Scheme::CatmullClark, Scheme::DooSabin] {
        let counts = [20, 60].map(|n| {
            let mesh = if scheme == Scheme::Loop { shapes::torus(n, n) } else { quad_torus(n, n) };
            let control = mesh.positions().to_vec();
            let editor = Editor::new(&mesh, &scheme.into(), control, 1e-3).unwrap();
            let drag = editor.grab(&[VertexId(n * n / 2 + n / 2)]).unwrap();
            [drag.changed().vertices.len(), drag.changed().faces.len()]
        });
        assert_eq!(counts[0], counts[1], "{scheme}");
        assert!(counts[0][0] < 400, "{scheme}");
    }
}

#[test]
fn settling_takes_away_what_many_drags_leave() {
    for (name, mesh, rules) in cases() {
        let tolerance = 1e-2;
        let mut editor = editor(&mesh, &rules, tolerance);
        // Each vertex by itself, all the same way, so that what they leave adds up.
        for v in mesh.topology().vertices() {
            let drag = editor.grab(&[v]).unwrap();
            for _ in 0..100 {
                editor.drag(&drag, Vec3::new(0.6, 1.0, 0.0));
            }
        }
        let unit = mesh.bounds().diagonal();
        let before = residual(&mesh, &editor, &rules);
        assert!(before > 2.0 * tolerance * unit, "{name}: {before:e} for {unit}");
        let (largest, change) = editor.settle().unwrap();
        assert!(!change.changed().vertices.is_empty(), "{name}");
        assert_eq!(largest, residual(&mesh, &editor, &rules), "{name}");
        assert!(largest <= tolerance * unit * (1.0 + 1e-9), "{name}: {largest:e}");

        let settled = editor.control().to_vec();
        assert_eq!(editor.settle().unwrap().1, Change::default(), "{name}");
        assert_eq!(editor.control(), settled, "{name}: nothing is left to do");
    }
}

/// From control points that are no fit at all: settling is a fit.
#[test]
fn settling_fits() {
    for (name, mesh, rules) in cases() {
        let control = vec![Vec3::ZERO; mesh.topology().vertex_count()];
        let mut editor = Editor::new(&mesh, &rules, control, 1e-11).unwrap();
        let diagonal = mesh.bounds().diagonal();
        assert!(editor.settle().unwrap().0 <= 1.01e-11 * diagonal, "{name}");
        let error = largest_distance(editor.control(), &solved(&mesh, &rules));
        assert!(error <= 1e-9, "{name}: {error:e}");
    }
}

#[test]
fn free_vertices_keep_their_control_points() {
    for (name, mesh, rules) in cases() {
        let mut editor = editor(&mesh, &rules, 1e-9);
        let (free, other) = ([40, 41, 61, 90].map(VertexId), VertexId(60));
        editor.free(&free).unwrap();
        let before = editor.control().to_vec();
        let drag = editor.grab(&[other]).unwrap();
        editor.drag(&drag, Vec3::new(0.0, 0.2, 0.1));
        assert!(residual(&mesh, &editor, &rules) < 1e-9, "{name}");
        for v in free {
            assert!(editor.is_free(v));
            assert_eq!(editor.control()[v.index()], before[v.index()], "{name}");
        }
        // A free vertex is dragged by its control point.
        let drag = editor.grab(&free[..1]).unwrap();
        editor.drag(&drag, Vec3::new(0.5, 0.0, 0.0));
        let moved = before[free[0].index()] + Vec3::new(0.5, 0.0, 0.0);
        assert_eq!(editor.control()[free[0].index()], moved, "{name}");
        assert!(residual(&mesh, &editor, &rules) < 1e-9, "{name}");
        editor.settle().unwrap();
        assert_eq!(editor.control()[free[0].index()], moved, "{name}");

        // Pinning leaves the surface where it is.
        let before = editor.control().to_vec();
        editor.pin(&free).unwrap();
        assert_eq!(editor.control(), before, "{name}");
        assert!(!editor.is_free(free[0]));
        assert!(residual(&mesh, &editor, &rules) < 1e-8, "{name}");
    }
}

#[test]
fn support_is_free() {
    for scheme in [Scheme::Loop, Scheme::CatmullClark] {
        let mesh = if scheme == Scheme::Loop { sheet(9, 9) } else { quad_sheet(9, 9) };
        let rules = Rules { border: Border::None, ..scheme.into() };
        let mut editor = editor(&mesh, &rules, 1e-9);
        editor.pin(&[VertexId(0)]).unwrap();
        assert!(editor.is_free(VertexId(0)) && !editor.is_free(VertexId(10)));
        let drag = editor.grab(&[VertexId(40)]).unwrap();
        let changed = editor.drag(&drag, Vec3::new(0.0, 0.0, 1.0));
        assert!(changed.vertices.iter().all(|&v| !mesh.topology().is_boundary(v)));
        assert!(residual(&mesh, &editor, &rules) <= 1e-9);
    }
}

/// A mesh of more than a block of rows, and a column as well.
#[test]
fn threads_do_not_change_the_bits() {
    let run = |mesh: &Mesh, rules: &Rules| {
        let mut editor = Editor::new(mesh, rules, mesh.positions().to_vec(), 1e-11).unwrap();
        let grabbed: Vec<VertexId> = (0..30).map(|i| VertexId(170 * i + 3)).collect();
        let drag = editor.grab(&grabbed).unwrap();
        assert!(drag.changed().vertices.len() > 5000);
        editor.drag(&drag, Vec3::new(0.1, 0.2, 0.3));
        let dragged = editor.control().to_vec();
        let largest = editor.settle().unwrap();
        (drag, dragged, largest, editor.into_control())
    };
    let loops = (shapes::torus(70, 75), Rules::LOOP);
    let quads = (quad_sheet(70, 75), Rules::from(Scheme::CatmullClark));
    for (mesh, rules) in [loops, quads] {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| run(&mesh, &rules))
        };
        let one = on(1);
        for threads in [2, 3, 7] {
            assert!(on(threads) == one, "{threads} threads");
        }
    }
}

#[test]
fn errors_say_what_is_wrong() {
    let mesh = shapes::torus(4, 5);
    let control = || mesh.positions().to_vec();
    for tolerance in [0.0, -1.0, 1.0, f64::NAN, f64::INFINITY, 1e-13] {
        let error = Editor::new(&mesh, &Rules::LOOP, control(), tolerance).unwrap_err();
        assert!(matches!(error, Error::BadOption { what: "the tolerance", .. }), "{error}");
    }
    let error = Editor::new(&mesh, &Rules::LOOP, vec![Vec3::ZERO], 1e-6).unwrap_err();
    assert_eq!(error, Error::WrongCount { what: "control points", expected: 20 });
    let mut bad = control();
    bad[7].y = f64::NAN;
    let error = Editor::new(&mesh, &Rules::LOOP, bad, 1e-6).unwrap_err();
    let Error::NotManifold(defects) = error else { panic!("{error}") };
    assert_eq!(defects.0, [Defect::NotFinite { vertex: VertexId(7) }]);
    let none = Mesh::new(Vec::new(), &fairform::Faces::new()).unwrap();
    let error = Editor::new(&none, &Rules::LOOP, Vec::new(), 1e-6).unwrap_err();
    assert_eq!(error, Error::NoVertices);
    let error = Editor::new(&mesh, &Scheme::Butterfly.into(), control(), 1e-6).unwrap_err();
    assert!(matches!(error, Error::NotForScheme { .. }), "{error}");
    for mesh in [shapes::cube(), prism(6)] {
        let rules = Scheme::CatmullClark.into();
        let control = mesh.positions().to_vec();
        let error = Editor::new(&mesh, &rules, control, 1e-6).unwrap_err();
        assert_eq!(error, Error::Singular { vertex: VertexId(0) });
        assert!(error.to_string().contains("singular"), "{error}");
    }

    let mut editor = editor(&mesh, &Rules::LOOP, 1e-6);
    let unknown = Error::NoSuchVertex { vertex: VertexId(20), vertex_count: 20 };
    let list = [VertexId(3), VertexId(20)];
    assert_eq!(editor.grab(&list).unwrap_err(), unknown);
    assert_eq!(editor.free(&list).unwrap_err(), unknown);
    assert_eq!(editor.pin(&list).unwrap_err(), unknown);
    assert!(!editor.is_free(VertexId(3)));
    assert!(editor.grab(&[]).unwrap().changed().faces.is_empty());
    let twice = editor.grab(&[VertexId(3), VertexId(3)]).unwrap();
    assert_eq!(twice, editor.grab(&[VertexId(3)]).unwrap());
}

/// Two polygons glued on all sides: all vertices have two faces, and no iteration converges.
#[test]
fn what_cannot_follow_is_an_error() {
    for n in [4, 5, 7, 40] {
        let mut faces = fairform::Faces::new();
        faces.push(&(0..n).collect::<Vec<_>>());
        faces.push(&(0..n).rev().collect::<Vec<_>>());
        let mesh = Mesh::new(prism(n).positions()[..n as usize].to_vec(), &faces).unwrap();
        let control = mesh.positions().to_vec();
        let editor = Editor::new(&mesh, &Scheme::CatmullClark.into(), control, 1e-6).unwrap();
        let error = editor.grab(&[VertexId(2)]).unwrap_err();
        assert_eq!(error, Error::Singular { vertex: VertexId(2) }, "{n}");
    }
}

#[test]
#[should_panic(expected = "grabbed after")]
fn a_drag_ends_when_vertices_are_freed() {
    let mut editor = editor(&shapes::icosahedron(), &Rules::LOOP, 1e-6);
    let drag = editor.grab(&[VertexId(3)]).unwrap();
    editor.free(&[VertexId(4)]).unwrap();
    editor.drag(&drag, Vec3::ZERO);
}

/// Rules that differ from those of a case near a vertex: a shape parameter, a crease or both.
fn edited(mesh: &Mesh, rules: &Rules, near: VertexId) -> Vec<Rules> {
    let topology = mesh.topology();
    let h = topology.fan(near).find(|&h| topology.twin(h).is_some()).unwrap();
    let mut others = Vec::new();
    if rules.creases.is_none() {
        let count = topology.face_count();
        let mut tension =
            rules.tension.as_ref().map_or_else(|| vec![0.5; count], |tension| tension.to_vec());
        tension[topology.face(h).index()] = 0.9;
        others.push(Rules { tension: Some(tension.into()), ..rules.clone() });
    }
    if rules.scheme != Scheme::DooSabin {
        let smooth = Arc::new(Creases::smooth(topology));
        let mut creases = (**rules.creases.as_ref().unwrap_or(&smooth)).clone();
        let e = topology.edge(h);
        creases.set_edge(e, creases.edge(e) + 1.5).unwrap();
        others.push(Rules { creases: Some(Arc::new(creases.clone())), ..rules.clone() });
        creases.set_vertex(near, 12.0).unwrap();
        others.push(Rules { creases: Some(Arc::new(creases)), ..rules.clone() });
    }
    others
}

fn set_rules(editor: &mut Editor, rules: &Rules) -> Result<Change, Error> {
    let one = editor.set_tension(rules.tension.clone())?;
    let other = editor.set_creases(rules.creases.clone())?;
    let is_one = other == Change::default();
    assert!(is_one || one == Change::default(), "the edits are of one kind");
    Ok(if is_one { one } else { other })
}

#[test]
fn other_rules_equal_solving_again() {
    for (name, mesh, rules) in cases() {
        let near = VertexId(mesh.topology().vertex_count() as u32 / 2 + 9);
        let before = solved(&mesh, &rules);
        for other in edited(&mesh, &rules, near) {
            let mut editor = Editor::new(&mesh, &rules, before.clone(), 1e-10).unwrap();
            if rules.scheme == Scheme::DooSabin && rules.tension.is_none() {
                // The plain scheme has no parameter: all rows change.
                let change = set_rules(&mut editor, &other).unwrap();
                assert_eq!(change.changed().faces.len(), mesh.topology().face_count());
                continue;
            }
            let change = set_rules(&mut editor, &other).unwrap();
            assert_eq!(editor.rules().creases, other.creases, "{name}");
            let error = largest_distance(editor.control(), &solved(&mesh, &other));
            assert!(error <= 1e-9, "{name}: {error:e}");
            assert!(residual(&mesh, &editor, &other) <= 1e-9, "{name}");
            let moved = |v: &VertexId| editor.control()[v.index()] != before[v.index()];
            let moved: Vec<VertexId> = mesh.topology().vertices().filter(moved).collect();
            // A tiny move may be lost in rounding.
            let told = change.changed().vertices;
            assert!(moved.iter().all(|v| told.binary_search(v).is_ok()), "{name}");
            assert!(!moved.is_empty(), "{name}");

            // The surface elsewhere keeps its bits.
            let [old, new] = [(&rules, before.as_slice()), (&other, editor.control())].map(
                |(rules, control)| refine_twice(&mesh.with_positions(control.to_vec()), rules),
            );
            let faces = change.changed().faces;
            for v in mesh.topology().vertices() {
                let mut fan = mesh.topology().fan(v).map(|h| mesh.topology().face(h));
                if rules.scheme != Scheme::DooSabin && fan.all(|f| !faces.contains(&f)) {
                    // Another phase is rounded in another way.
                    let distance =
                        (old.positions()[v.index()] - new.positions()[v.index()]).length();
                    let is_alike = rules.tension.is_some() == other.tension.is_some();
                    assert!(distance <= if is_alike { 0.0 } else { 1e-15 }, "{name}: {distance:e}");
                }
            }

            // And back again.
            set_rules(&mut editor, &rules).unwrap();
            let error = largest_distance(editor.control(), &before);
            assert!(error <= 1e-9, "{name}: {error:e}");
        }
    }
}

#[test]
fn rules_that_do_not_fit_change_nothing() {
    let mesh = shapes::torus(8, 9);
    let mut editor = editor(&mesh, &Rules::LOOP, 1e-8);
    let (before, count) = (editor.control().to_vec(), mesh.topology().face_count());
    assert!(editor.set_tension(Some(vec![0.5; 3].into())).is_err(), "too few");
    let mut tension = vec![0.7; count];
    tension[5] = f64::NAN;
    assert!(editor.set_tension(Some(tension.into())).is_err(), "not a number");
    let other = Creases::smooth(shapes::cube().topology());
    assert!(editor.set_creases(Some(Arc::new(other))).is_err(), "of another mesh");
    assert!(editor.control() == before && *editor.rules() == Rules::LOOP);

    // A single tense face makes the cube regular; without it there is no way back.
    let cube = shapes::cube();
    let mut tension = vec![0.5; 6];
    tension[2] = 0.8;
    let rules = Rules { tension: Some(tension.into()), ..Scheme::CatmullClark.into() };
    let mut editor = editor_of(&cube, &rules);
    let before = editor.control().to_vec();
    let error = editor.set_tension(None).unwrap_err();
    assert_eq!(error, Error::Singular { vertex: VertexId(0) });
    assert!(editor.control() == before && *editor.rules() == rules);
}

fn editor_of(mesh: &Mesh, rules: &Rules) -> Editor {
    editor(mesh, rules, 1e-8)
}

/// A neighbourhood of the same size on any mesh.
#[test]
fn other_rules_are_solved_nearby() {
    for scheme in [Scheme::Loop, Scheme::CatmullClark] {
        let counts = [24, 60].map(|n| {
            let mesh = if scheme == Scheme::Loop { shapes::torus(n, n) } else { quad_torus(n, n) };
            let rules = scheme.into();
            let mut editor = editor(&mesh, &rules, 1e-4);
            let mut tension = vec![0.5; mesh.topology().face_count()];
            tension[(n * n / 2 + n / 2) as usize] = 0.8;
            editor.set_tension(Some(tension.into())).unwrap().changed().vertices.len()
        });
        assert!(counts[0] < 400 && counts[1] < 400, "{scheme}: {counts:?}");
    }
}

#[test]
#[should_panic(expected = "grabbed after")]
fn a_drag_ends_when_the_rules_change() {
    let mesh = shapes::torus(8, 9);
    let mut editor = editor(&mesh, &Rules::LOOP, 1e-6);
    let drag = editor.grab(&[VertexId(3)]).unwrap();
    editor.set_tension(Some(vec![0.6; mesh.topology().face_count()].into())).unwrap();
    editor.drag(&drag, Vec3::ZERO);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// On any triangle mesh, with any free vertices and creases, drags move the surface as they should.
    #[test]
    fn any_mesh_can_be_edited(
        seed in 0_u64..1 << 40, splits in 0_usize..30, holes in 0_usize..6, sharp in 0_u64..40,
    ) {
        let mesh = crate::common::random_mesh(seed, splits, holes);
        let creases = random_creases(mesh.topology(), seed, sharp);
        let rules = Rules { creases: Some(Arc::new(creases)), ..Rules::LOOP };
        let control = limit_points(&mesh, &rules);
        let mut editor = Editor::new(&mesh, &rules, control, 1e-8).unwrap();
        let count = mesh.topology().vertex_count() as u64;
        let free: Vec<VertexId> = (0..3).map(|i| VertexId((seed / (7 + i) % count) as u32)).collect();
        editor.free(&free).unwrap();
        editor.settle().unwrap();
        let before = residual(&mesh, &editor, &rules);
        let grabbed: Vec<VertexId> = (0..2).map(|i| VertexId((seed / (3 + i) % count) as u32)).collect();
        let drag = editor.grab(&grabbed).unwrap();
        editor.drag(&drag, Vec3::new(0.6, 0.0, 0.8));
        prop_assert!(residual(&mesh, &editor, &rules) <= before + 1e-8 + 1e-13);
    }

    /// On any mesh, other shape parameters and creases leave the limit points on their data.
    #[test]
    fn any_rules_can_be_changed(
        seed in 0_u64..1 << 40, splits in 0_usize..30, holes in 0_usize..6,
        lambda in 0.5..1.0_f64, sharpness in 0.0..4.0_f64,
    ) {
        let mesh = crate::common::random_mesh(seed, splits, holes);
        let topology = mesh.topology();
        let mut editor = editor(&mesh, &Rules::LOOP, 1e-8);
        let unit = mesh.bounds().diagonal();
        let mut tension = vec![0.5; topology.face_count()];
        tension[seed as usize % topology.face_count()] = lambda;
        editor.set_tension(Some(tension.into())).unwrap();
        let mut creases = Creases::smooth(topology);
        for i in 1..3 {
            let e = fairform::EdgeId((seed / i % topology.edge_count() as u64) as u32);
            creases.set_edge(e, sharpness).unwrap();
        }
        editor.set_creases(Some(Arc::new(creases))).unwrap();
        let rules = editor.rules().clone();
        prop_assert!(residual(&mesh, &editor, &rules) <= 2.1e-8 * unit);
        let change = editor.set_creases(None).unwrap();
        prop_assert!(change.changed().faces.len() <= topology.face_count());
        editor.set_tension(None).unwrap();
        prop_assert!(residual(&mesh, &editor, &Rules::LOOP) <= 4.1e-8 * unit);
    }
}
