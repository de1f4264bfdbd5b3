//! The meshes that are compared on, written where every peer can read them.

use std::fmt::Write as _;
use std::fs;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use fairform::{Faces, Mesh, Rules, refine, shapes};

/// A mesh as a file of OBJ.
pub(crate) struct Subject {
    pub(crate) name: String,
    pub(crate) path: PathBuf,
    pub(crate) vertex_count: usize,
    pub(crate) triangles: bool,
    /// Whether it is a shape that this program makes.
    pub(crate) is_made: bool,
    pub(crate) levels: RangeInclusive<u32>,
}

/// What is measured when no file is named: real meshes, closed, small enough to lie in the repository.
const REAL: [&str; 4] = [
    "data/meshes/tri_closed/horse_3k.off",
    "data/meshes/tri_closed/homer.off",
    "data/meshes/tri_closed/rocker_arm_2500.obj",
    "data/meshes/quad/fertility_quad.off",
];

/// Shapes of two sizes, and the meshes in `paths`, or some from the repository.
pub(crate) fn subjects(root: &Path, paths: &[PathBuf]) -> Vec<Subject> {
    let place = root.join("target/peers/meshes");
    fs::create_dir_all(&place).expect("the target folder can be written to");
    let sphere = |steps| {
        let refined = refine::refine_mesh(&shapes::icosahedron(), &Rules::LOOP, steps);
        refined.expect("an icosahedron can be refined").0
    };
    let shape = |name: &str, mesh: Mesh, levels| Subject {
        is_made: true,
        ..subject(&place, name, &mesh, levels)
    };
    let mut subjects = vec![
        shape("sphere", sphere(5), 1..=4),
        shape("torus", shapes::torus(400, 400), 3..=3),
        shape("torus of quadrilaterals", quad_torus(100), 1..=4),
        shape("large torus of quadrilaterals", quad_torus(400), 2..=2),
    ];
    let real: Vec<PathBuf> = match paths {
        [] => REAL.iter().map(|path| root.join(path)).collect(),
        _ => paths.to_vec(),
    };
    for path in real {
        let data = fairform_io::read(&path, None).unwrap_or_else(|e| panic!("{e}"));
        let mesh = Mesh::new(data.positions, &data.faces).expect("a manifold");
        let name = path.file_stem().expect("a file").to_string_lossy();
        subjects.push(subject(&place, &name, &mesh, 3..=3));
    }
    subjects
}

fn subject(place: &Path, name: &str, mesh: &Mesh, levels: RangeInclusive<u32>) -> Subject {
    let path = place.join(format!("{}.obj", name.replace(' ', "-")));
    fs::write(&path, obj(mesh)).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    Subject {
        name: name.into(),
        path,
        vertex_count: mesh.topology().vertex_count(),
        triangles: mesh.topology().uniform_face_size() == Some(3),
        is_made: false,
        levels,
    }
}

/// All digits of the coordinates, and nothing but vertices and faces.
fn obj(mesh: &Mesh) -> String {
    let mut text = String::new();
    for p in mesh.positions() {
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for face in mesh.topology().to_faces().iter() {
        text.push('f');
        face.iter().for_each(|v| {
            let _ = write!(text, " {}", v + 1);
        });
        text.push('\n');
    }
    text
}

/// The torus of [`shapes::torus`] without its diagonals.
fn quad_torus(side: u32) -> Mesh {
    let at = |row: u32, column: u32| row % side * side + column % side;
    let places = (0..side).flat_map(|row| (0..side).map(move |column| (row, column)));
    let face = |(r, c)| [at(r, c), at(r + 1, c), at(r + 1, c + 1), at(r, c + 1)];
    let faces = Faces::uniform(4, places.flat_map(face).collect());
    Mesh::new(shapes::torus(side, side).into_positions(), &faces).expect("a torus is a manifold")
}
