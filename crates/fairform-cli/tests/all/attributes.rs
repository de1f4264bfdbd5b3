//! What travels along: colours, normals, texture coordinates, groups and materials.

#![expect(clippy::format_collect, clippy::format_push_string, reason = "short texts")]

use crate::common::{Folder, data, obj};
use fairform::{Vec3, shapes};
use fairform_io::{Format, MeshData};

/// An octahedron within the unit cube, so that its coordinates are colours too.
fn octahedron() -> (Vec<Vec3>, Vec<Vec<u32>>) {
    let mesh = shapes::octahedron();
    let inside = |p: &Vec3| 0.3 * *p + Vec3::new(0.5, 0.45, 0.4);
    let faces = mesh.topology().to_faces().iter().map(<[u32]>::to_vec).collect();
    (mesh.positions().iter().map(inside).collect(), faces)
}

/// The octahedron, coloured by its own coordinates.
fn coloured() -> String {
    let (points, faces) = octahedron();
    let text = obj(&points, &faces);
    let coloured = |line: &str| match line.strip_prefix("v ") {
        Some(xyz) => format!("v {xyz} {xyz}\n"),
        None => format!("{line}\n"),
    };
    text.lines().map(coloured).collect()
}

fn assert_colours_are_coordinates(mesh: &MeshData) {
    for (p, c) in mesh.positions.iter().zip(mesh.colours.as_ref().expect("colours")) {
        let expected = [p.x.clamp(0.0, 1.0), p.y.clamp(0.0, 1.0), p.z.clamp(0.0, 1.0), 1.0];
        for (c, e) in c.iter().zip(expected) {
            assert!((c - e).abs() < 1e-6, "{c} is not {e}");
        }
    }
}

/// Colours that are the coordinates stay the coordinates.
#[test]
fn colours_follow_as_positions_do() {
    let folder = Folder::new();
    folder.write("in.obj", &coloured());
    for arguments in [
        "refine in.obj -o out.ply --levels 2",
        "refine in.obj -o out.obj --levels 2 --limit",
        "limit in.obj -o out.ply",
        "fit in.obj -o out.ply --levels 2",
        "fit in.obj -o out.ply --levels 2 --limit --method cg",
        "fit in.obj -o out.ply --levels 1 --method plain --iterations 4",
    ] {
        folder.ok(arguments);
        let output = arguments.split_whitespace().nth(3).unwrap();
        assert_colours_are_coordinates(&folder.mesh(output));
    }
}

#[test]
fn texture_coordinates_of_vertices_follow_as_positions_do() {
    let folder = Folder::new();
    let (points, faces) = octahedron();
    let mut text: String = points.iter().map(|p| format!("vt {} {}\n", p.x, p.y)).collect();
    for line in obj(&points, &faces).lines() {
        let corner = |v: &str| format!(" {v}/{v}");
        text += &match line.strip_prefix("f ") {
            Some(corners) => format!("f{}\n", corners.split(' ').map(corner).collect::<String>()),
            None => format!("{line}\n"),
        };
    }
    folder.write("in.obj", &text);
    for command in ["refine", "fit"] {
        folder.ok(&format!("{command} in.obj -o out.ply --levels 2"));
        let mesh = folder.mesh("out.ply");
        for (p, uv) in mesh.positions.iter().zip(mesh.uvs.expect("texture coordinates")) {
            assert!((uv[0] - p.x).abs() < 1e-6 && (uv[1] - p.y).abs() < 1e-6);
        }
    }
}

/// Two triangles with a seam between them, in groups and materials of their own.
const LABELLED: &str = "mtllib paint.mtl
v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0
vt 0 0\nvt 4 0\nvt 4 8\nvt 10 10\nvt 14 18\nvt 10 18
g left\nusemtl red\nf 1/1 2/2 3/3
g right\nusemtl blue\nf 1/4 3/5 4/6\n";

#[test]
fn texture_coordinates_of_corners_are_halved_within_faces() {
    let folder = Folder::new();
    folder.write("in.obj", LABELLED);
    for command in ["refine in.obj", "fit in.obj"] {
        folder.ok(&format!("{command} -o out.obj --levels 1"));
        let uvs = folder.mesh("out.obj").corner_uvs.expect("texture coordinates with a seam");
        let expected = |[a, b, c]: [[f64; 2]; 3]| {
            let mid =
                |p: [f64; 2], q: [f64; 2]| [f64::midpoint(p[0], q[0]), f64::midpoint(p[1], q[1])];
            let (ab, bc, ca) = (mid(a, b), mid(b, c), mid(c, a));
            [a, ab, ca, b, bc, ab, c, ca, bc, ab, bc, ca]
        };
        let left = expected([[0.0, 0.0], [4.0, 0.0], [4.0, 8.0]]);
        let right = expected([[10.0, 10.0], [14.0, 18.0], [10.0, 18.0]]);
        assert_eq!(uvs, [left, right].concat(), "{command}");
    }
}

#[test]
fn children_have_the_labels_of_their_parent() {
    let folder = Folder::new();
    folder.write("in.obj", LABELLED);
    for command in ["refine in.obj", "fit in.obj", "fit in.obj --limit"] {
        folder.ok(&format!("{command} -o out.obj --levels 2"));
        let mesh = folder.mesh("out.obj");
        assert_eq!(mesh.material_library.as_deref(), Some("paint.mtl"));
        for (labels, names) in [
            (mesh.groups.expect("groups"), ["left", "right"]),
            (mesh.materials.expect("materials"), ["red", "blue"]),
        ] {
            let of_face: Vec<_> =
                labels.of_face.iter().map(|&i| labels.names[i as usize].as_str()).collect();
            assert_eq!(of_face, [[names[0]; 16], [names[1]; 16]].concat(), "{command}");
        }
    }
}

#[test]
fn normals_stay_of_length_one() {
    let folder = Folder::new();
    let (points, faces) = octahedron();
    let normals: String = points.iter().map(|p| format!("vn {} {} {}\n", p.x, p.y, p.z)).collect();
    let text = obj(&points, &faces);
    let (vertices, corners) = text.split_at(text.find('f').unwrap());
    let corner = |v: &str| format!(" {v}//{v}");
    let corners: String = corners
        .lines()
        .map(|l| format!("f{}\n", l[2..].split(' ').map(corner).collect::<String>()))
        .collect();
    folder.write("in.obj", &format!("{vertices}{normals}{corners}"));
    for command in ["refine in.obj", "fit in.obj", "fit in.obj --limit", "limit in.obj"] {
        let levels = if command.starts_with("limit") { "" } else { "--levels 2" };
        folder.ok(&format!("{command} -o out.ply {levels}"));
        let normals = folder.mesh("out.ply").normals.expect("normals");
        assert!(normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-12), "{command}");
    }
}

/// The embedded picture needs its normals to point outwards, as those of an octahedron do.
#[test]
fn limit_normals_point_outwards() {
    let folder = Folder::new();
    let (points, faces) = octahedron();
    folder.write("in.obj", &obj(&points, &faces));
    folder.ok("fit in.obj -o out.ply --levels 2 --limit");
    let mesh = folder.mesh("out.ply");
    let centre = Vec3::new(0.5, 0.45, 0.4);
    let normals = mesh.normals.expect("normals");
    assert!(mesh.positions.iter().zip(&normals).all(|(p, n)| (*p - centre).dot(*n) > 0.1));
}

#[test]
fn repair_lets_attributes_follow() {
    let folder = Folder::new();
    // An edge too many at the end, and a vertex that nothing uses at the start.
    let shifted = |line: &str| match line.strip_prefix("f ") {
        Some(corners) => {
            let next = |v: &str| format!(" {}", v.parse::<u32>().unwrap() + 1);
            format!("f{}\n", corners.split(' ').map(next).collect::<String>())
        }
        None => format!("{line}\n"),
    };
    let body: String = coloured().lines().map(shifted).collect();
    folder.write("in.obj", &format!("v 9 9 9 0 0 0\n{body}f 2 3\n"));
    folder.fails("fit in.obj -o out.ply", 1, "face 8 has 2 corners");
    folder.ok("repair in.obj -o out.ply --drop-degenerate --drop-isolated");
    let mesh = folder.mesh("out.ply");
    assert_eq!((mesh.positions.len(), mesh.faces.len()), (6, 8));
    assert_colours_are_coordinates(&mesh);
}

/// Every format takes what it can, and says what it cannot.
#[test]
fn what_a_format_cannot_hold_is_said() {
    let folder = Folder::new();
    folder.write("in.obj", LABELLED);
    for format in Format::ALL {
        let run = folder.ok(&format!("convert in.obj -o out.{format}"));
        let says = run.stderr.contains(&format!("note: out.{format}: "));
        assert_eq!(says, format != Format::Obj, "{format}: {}", run.stderr);
        assert_eq!(folder.mesh(&format!("out.{format}")).faces.len(), 2);
    }
    let quiet = folder.ok("convert in.obj -o out.off --quiet");
    assert_eq!(quiet.stderr, "");
}

#[test]
fn isolated_vertices_and_parts_stay() {
    let folder = Folder::new();
    let file = data("meshes/odd/three_components.obj");
    folder.ok(&format!("fit {} -o out.ply --levels 1 --report r.json", file.display()));
    let counts = &folder.json("r.json")["counts"];
    let input = fairform_io::read(&file, None).unwrap();
    assert_eq!(counts["input"]["vertices"], input.positions.len());
    assert_eq!(counts["output"]["faces"], 4 * input.faces.len());

    let file = data("meshes/bad/unreferenced_vertices.ply");
    folder.ok(&format!("fit {} -o out.ply --levels 0", file.display()));
    let (given, control) = (fairform_io::read(&file, None).unwrap(), folder.mesh("out.ply"));
    let mut used = vec![false; given.positions.len()];
    given.faces.corners().iter().for_each(|&v| used[v as usize] = true);
    for (v, used) in used.into_iter().enumerate() {
        assert_eq!(used, given.positions[v] != control.positions[v], "vertex {v}");
    }
}
