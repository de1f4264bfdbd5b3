//! Dragging is fitting again.

use fairform::{Mesh, Scheme, Vec3, shapes};
use fairform_io::project::{Design, Fineness};
use fairform_wasm::{DragAnswer, Geometry, What};

use crate::common::{distance, fit, open, saved};

const FINENESS: Fineness = Fineness { levels: 2, limit: true };

fn quads() -> Mesh {
    let (rows, columns) = (12_u32, 14_u32);
    let torus = shapes::torus(rows, columns);
    let mut faces = fairform::Faces::new();
    let at = |i: u32, j: u32| (i % rows) * columns + j % columns;
    for i in 0..rows {
        for j in 0..columns {
            faces.push(&[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    Mesh::new(torus.positions().to_vec(), &faces).unwrap()
}

fn take_over(drawn: &mut Geometry, answer: &DragAnswer) {
    match &answer.vertices {
        None => {
            drawn.positions.clone_from(&answer.positions);
            drawn.normals.clone_from(&answer.normals);
        }
        Some(vertices) => {
            let new = answer.positions.iter().zip(&answer.normals);
            for (&v, (&p, &n)) in vertices.iter().zip(new) {
                drawn.positions[v as usize] = p;
                drawn.normals[v as usize] = n;
            }
        }
    }
}

fn farthest(a: &[[f32; 3]], b: &[[f32; 3]]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.as_flattened().iter().zip(b.as_flattened()).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max)
}

/// After a drag and its release, control points and the surface are those of a fit of the moved mesh, and
/// what the answers told is what is drawn then, however the surface is made.
#[test]
fn a_drag_is_a_fit() {
    let cases = [
        (shapes::torus(20, 24), Scheme::Loop, false),
        (shapes::torus(20, 24), Scheme::Loop, true),
        (shapes::torus(20, 24), Scheme::Butterfly, false),
        (quads(), Scheme::CatmullClark, false),
        (quads(), Scheme::CatmullClark, true),
        (quads(), Scheme::DooSabin, false),
        (quads(), Scheme::Kobbelt, false),
        (shapes::cube(), Scheme::CatmullClark, false),
        (shapes::sheet(7, 8, |x, y| x * y), Scheme::Loop, false),
    ];
    for (mesh, scheme, exact) in cases {
        let what = format!("{scheme} {exact} {}", mesh.positions().len());
        let design = Design { scheme, exact, tolerance: 1e-11, ..Design::default() };
        let size = mesh.bounds().diagonal();
        let mut session = open(&mesh);
        fit(&mut session, &design);
        let mut drawn = session.surface(FINENESS, None).unwrap();
        session.grab(&[3, 5]).unwrap();
        let mut parts = 0;
        for i in 1..=4 {
            let offset = f64::from(i) * 0.01 * size * Vec3::new(1.0, 0.5, -0.3);
            let answer = session.drag(offset).unwrap();
            parts += usize::from(answer.vertices.is_some());
            take_over(&mut drawn, &answer);
        }
        let follows = !scheme.is_interpolating() && mesh.positions().len() != 8;
        assert_eq!(
            parts,
            if !follows {
                0
            } else if exact {
                3
            } else {
                4
            },
            "{what}"
        );
        // What the parts told is all that moved.
        let live = session.surface(FINENESS, None).unwrap();
        assert!(farthest(&drawn.positions, &live.positions) < 1e-6 * size as f32, "{what}");
        assert!(farthest(&drawn.normals, &live.normals) < 1e-5, "{what}");

        session.grab(&[3, 5]).unwrap();
        session.drag(Vec3::ZERO).unwrap();
        let released = session.release().unwrap();
        assert!(released.max <= 1e-11, "{what}: {}", released.max);
        take_over(&mut drawn, &released.answer);
        assert_eq!(released.moves.len(), 2, "{what}");
        let offset = 0.04 * size * Vec3::new(1.0, 0.5, -0.3);
        for &(v, x, y, z) in &released.moves {
            let there = mesh.positions()[v as usize] + offset;
            assert!((Vec3::new(x, y, z) - there).length() < 1e-14 * size, "{what}");
        }
        let control = saved(&session, What::Control).positions;
        let surface = saved(&session, What::Surface).positions;
        let again = Design { moves: released.moves, ..design };
        let mut other = open(&mesh);
        let result = fit(&mut other, &again);
        let expected = other.surface(FINENESS, None).unwrap();
        assert!(
            distance(&control, &saved(&other, What::Control).positions) < 1e-9 * size,
            "{what}"
        );
        assert!(
            distance(&surface, &saved(&other, What::Surface).positions) < 1e-9 * size,
            "{what}"
        );
        assert!(farthest(&drawn.positions, &expected.positions) < 1e-6 * size as f32, "{what}");
        assert!(result.max <= 1e-11);
    }
}

/// A drag of one vertex of a large mesh moves a small part of it.
#[test]
fn a_drag_stays_local() {
    let mut session = open(&shapes::torus(60, 80));
    fit(&mut session, &Design::default());
    let all = session.surface(FINENESS, None).unwrap().positions.len();
    session.grab(&[1000]).unwrap();
    let answer = session.drag(Vec3::new(0.0, 0.0, 0.01)).unwrap();
    let moved = answer.vertices.unwrap().len();
    assert!(moved > 100 && moved < all / 4, "{moved} of {all}");
    assert_eq!(answer.control_vertices.len(), answer.control_positions.len());
    assert!(answer.control_vertices.contains(&1000));
}

#[test]
fn what_cannot_be_dragged_is_said() {
    let mut session = open(&shapes::torus(9, 12));
    assert!(session.grab(&[0]).is_err());
    fit(&mut session, &Design::default());
    assert!(session.grab(&[0]).unwrap_err().message.contains("drawn"));
    session.surface(FINENESS, None).unwrap();
    assert!(session.drag(Vec3::ZERO).unwrap_err().message.contains("grabbed"));
    assert!(session.grab(&[108]).unwrap_err().message.contains("no vertex 108"));
    session.grab(&[0]).unwrap();
    assert!(session.drag(Vec3::splat(f64::NAN)).is_err());
    session.drag(Vec3::ZERO).unwrap();
    session.release().unwrap();
    assert!(session.release().is_err());
}
