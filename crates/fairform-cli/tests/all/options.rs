//! The scheme's options mean the same in every command; creases and support travel with files.

use std::fs;

use crate::common::{Folder, assert_near, data, obj};
use fairform::Mesh;
use fairform_io::MeshData;

fn mesh(data: &MeshData) -> Mesh {
    Mesh::new(data.positions.clone(), &data.faces).unwrap()
}

/// A sheet of 5 by 5 quadrilaterals, bumpy.
fn sheet(folder: &Folder) {
    let height = |x: f64, y: f64| 0.3 * (4.0 * x).sin() * y;
    let positions = fairform::shapes::sheet(6, 6, height).into_positions();
    let at = |i: u32, j: u32| 6 * i + j;
    let faces: Vec<Vec<u32>> = (0..25)
        .map(|k| (k / 5, k % 5))
        .map(|(i, j)| vec![at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)])
        .collect();
    folder.write("sheet.obj", &obj(&positions, &faces));
}

fn cube(folder: &Folder) {
    let cube = fairform::shapes::cube();
    let list: Vec<Vec<u32>> = cube.topology().to_faces().iter().map(<[u32]>::to_vec).collect();
    folder.write("cube.obj", &obj(cube.positions(), &list));
}

/// Adds tags to a mesh.
fn tag(folder: &Folder, from: &str, to: &str, tags: &str) {
    let text = String::from_utf8(folder.bytes(from)).unwrap();
    folder.write(to, &(text + tags));
}

const CREASE: &str = "t crease 2/1/0 0 1 10\nt crease 4/1/0 1 5 5 4 2.5\nt corner 1/1/0 2 1.5\n";

#[test]
fn creases_in_the_mesh_are_those_beside_it() {
    let folder = Folder::new();
    cube(&folder);
    tag(&folder, "cube.obj", "tagged.obj", CREASE);
    folder.write("creases.obj", CREASE);
    let fit = "-o out.ply --scheme catmull-clark --limit";
    let run = folder.ok(&format!("fit tagged.obj {fit}"));
    assert!(run.stderr.contains("from the file: 3 sharp edges, 1 sharp vertex"), "{}", run.stderr);
    let inside = folder.bytes("out.ply");
    folder.ok(&format!("fit cube.obj {fit} --creases creases.obj"));
    assert_eq!(folder.bytes("out.ply"), inside);
    let run = folder.ok(&format!("fit tagged.obj {fit} --creases none"));
    assert!(!run.stderr.contains("sharp"), "{}", run.stderr);
    let without = folder.bytes("out.ply");
    folder.ok(&format!("fit cube.obj {fit}"));
    assert!(folder.bytes("out.ply") == without && without != inside);
    // Other schemes leave them out, and say so.
    let run = folder.ok("fit tagged.obj -o out.ply --scheme doo-sabin");
    assert!(run.stderr.contains("doo-sabin knows no creases"), "{}", run.stderr);
    // What the mesh has not is an error that names the way out; what nobody understands is passed over.
    tag(&folder, "cube.obj", "far.obj", "t crease 2/1/0 0 7 1\n");
    let run = folder.fails(&format!("fit far.obj {fit}"), 1, "no edge between vertices 0 and 7");
    assert!(run.stderr.contains("--creases none"), "{}", run.stderr);
    tag(&folder, "cube.obj", "odd.obj", "t crease 2/1/0 0 x 1\nt creasemethod 0/0/1 chaikin\n");
    let run = folder.ok(&format!("fit odd.obj {fit}"));
    assert!(run.stderr.contains("a bad crease") && run.stderr.contains("creasemethod"));
    assert_eq!(folder.bytes("out.ply"), without);
    let json = folder.ok("info tagged.obj --json --scheme catmull-clark").json();
    assert_eq!(
        (&json["scheme"]["sharp_edges"], &json["scheme"]["sharp_vertices"]),
        (&3.into(), &1.into())
    );
}

/// A control mesh written as OBJ and refined later gives the same surface, whatever made it.
#[test]
fn control_meshes_keep_what_makes_their_surface() {
    let folder = Folder::new();
    sheet(&folder);
    cube(&folder);
    tag(&folder, "cube.obj", "tagged.obj", CREASE);
    tag(&folder, "sheet.obj", "holes.obj", "t hole 2/0/0 12 7\nt crease 2/1/0 14 15 1.5\n");
    for (input, options) in [
        ("tagged.obj", "--scheme catmull-clark"),
        ("cube.obj", "--scheme catmull-clark --crease-angle 30"),
        ("sheet.obj", "--scheme catmull-clark --corners sharp"),
        ("sheet.obj", "--scheme catmull-clark --boundary none"),
        ("sheet.obj", "--scheme catmull-clark --boundary none --exact"),
        ("holes.obj", "--scheme catmull-clark"),
        ("holes.obj", "--scheme catmull-clark --exact --corners sharp --boundary none"),
    ] {
        let what = format!("{input} {options}");
        folder.ok(&format!(
            "fit {input} {options} -o surface.ply --levels 3 --limit --control also.obj --report r.json"
        ));
        folder.ok(&format!("fit {input} {options} -o control.obj --levels 0"));
        assert_eq!(folder.bytes("control.obj"), folder.bytes("also.obj"), "{what}");
        let level = folder.json("r.json")["control_level"].as_u64().unwrap();
        folder.ok("convert control.obj -o again.obj");
        let refine = "refine again.obj -o later.ply --scheme catmull-clark --limit";
        folder.ok(&format!("{refine} --levels {}", 3 - level));
        assert_eq!(folder.bytes("later.ply"), folder.bytes("surface.ply"), "{what}");
    }
    // Other formats cannot, and say so.
    let run = folder.ok("convert tagged.obj -o tagged.ply");
    assert!(run.stderr.contains("no place for crease tags"), "{}", run.stderr);
    folder.ok("repair tagged.obj -o repaired.obj --triangulate");
    assert!(
        String::from_utf8(folder.bytes("repaired.obj")).unwrap().contains("t corner 1/1/0 2 1.5")
    );
}

/// OpenSubdiv's "none": nine of 25 faces have a surface, which meets their 16 vertices; the others stay as
/// control points.
#[test]
fn the_boundary_can_be_support() {
    let folder = Folder::new();
    sheet(&folder);
    let target = folder.mesh("sheet.obj");
    let topology = mesh(&target).topology().clone();
    let fit = "--scheme catmull-clark --limit --levels 2";
    let run = folder.ok(&format!("fit sheet.obj -o option.ply {fit} --boundary none"));
    assert!(run.stderr.contains("16 of 25 faces are support"), "{}", run.stderr);
    let surface = folder.mesh("option.ply");
    assert_eq!(surface.faces.len(), 9 * 16);
    folder.ok("fit sheet.obj -o control.obj --scheme catmull-clark --boundary none --levels 0");
    let control = folder.mesh("control.obj");
    assert_eq!(control.faces.len(), 25);
    for v in topology.vertices() {
        let (i, given) = (v.index(), target.positions[v.index()]);
        if topology.is_boundary(v) {
            assert_eq!(control.positions[i], given, "{v}");
        } else {
            assert!((surface.positions[i] - given).length() < 2e-6, "{v}");
        }
    }
    // The same as JSON, as a tag beside the mesh, and in it.
    let option = folder.bytes("option.ply");
    folder.write("none.json", r#"{"interpolateBoundary": "none"}"#);
    folder.write("tags.obj", "t interpolateboundary 1/0/0 0\n");
    tag(&folder, "sheet.obj", "inside.obj", "t interpolateboundary 1/0/0 0\n");
    for input in ["sheet.obj --creases none.json", "sheet.obj --creases tags.obj", "inside.obj"] {
        folder.ok(&format!("fit {input} -o file.ply {fit}"));
        assert!(folder.bytes("file.ply") == option, "{input}");
    }
    // Options win over files, and 1 keeps corners as in OpenSubdiv.
    folder.ok(&format!("fit sheet.obj -o plain.ply {fit}"));
    folder.ok(&format!("fit inside.obj -o file.ply {fit} --boundary bspline"));
    assert_eq!(folder.bytes("file.ply"), folder.bytes("plain.ply"));
    tag(&folder, "sheet.obj", "kept.obj", "t interpolateboundary 1/0/0 1\n");
    folder.ok(&format!("fit kept.obj -o file.ply {fit}"));
    folder.ok(&format!("fit sheet.obj -o sharp.ply {fit} --corners sharp"));
    assert_eq!(folder.bytes("file.ply"), folder.bytes("sharp.ply"));
    // Where everything is at the boundary, nothing is left.
    folder.ok("limit sheet.obj -o limit.obj --scheme catmull-clark --boundary none");
    assert_eq!(folder.mesh("limit.obj").faces.len(), 9);
    folder.write("one.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    let run = folder.ok("refine one.obj -o fine.obj --scheme catmull-clark --boundary none");
    assert!(run.stderr.contains("warning: no surface"), "{}", run.stderr);
    let drop = "refine sheet.obj -o fine.obj --scheme";
    folder.fails(&format!("{drop} catmull-clark --boundary drop"), 1, "dropped");
    folder.fails(&format!("{drop} doo-sabin --boundary none"), 1, "support");
}

/// The picture of a surface is that of the file which `fit` or `refine` writes.
#[test]
fn render_draws_what_other_commands_write() {
    let folder = Folder::new();
    sheet(&folder);
    cube(&folder);
    let draw = |what: &str| {
        folder.ok(&format!("render {what} -o p.png --size 160x120"));
        folder.bytes("p.png")
    };
    for options in [
        "--scheme catmull-clark --crease-angle 30",
        "--scheme catmull-clark --corners sharp",
        "--scheme catmull-clark --boundary none",
        "--scheme doo-sabin --lambda 0.8 --tension-where face=3:0.3 --falloff 0.4",
        "--scheme doo-sabin --boundary bspline",
        "--scheme kobbelt --w 0.6",
    ] {
        for input in ["sheet.obj", "cube.obj"] {
            // OBJ keeps every bit, and the normals on each side of a crease.
            folder.ok(&format!("refine {input} -o fine.obj {options} --levels 2 --limit"));
            assert_eq!(
                draw(&format!("{input} {options} --levels 2")),
                draw("fine.obj"),
                "{options}"
            );
            folder.ok(&format!("fit {input} -o fine.obj {options} --levels 2 --limit"));
            let fitted = format!("{input} {options} --levels 2 --fit");
            assert_eq!(draw(&fitted), draw("fine.obj"), "{input} {options}");
        }
    }
    let fair = "cube.obj --scheme catmull-clark --levels 2 --fit";
    folder.ok("fit cube.obj -o fine.obj --scheme doo-sabin --levels 2 --limit --exact");
    assert_eq!(draw("cube.obj --scheme doo-sabin --levels 2 --fit --exact"), draw("fine.obj"));
    folder.ok("fit cube.obj -o fine.obj --scheme catmull-clark --levels 2 --limit --fair 0.5");
    assert_eq!(draw(&format!("{fair} --fair 0.5")), draw("fine.obj"));
    folder.fails("render cube.obj -o p.png --exact", 2, "--fit");
    folder.fails("render cube.obj -o p.png --corners sharp", 2, "--scheme");
    folder.fails("render cube.obj -o p.png --levels 2", 2, "--scheme");
    assert_ne!(draw("sheet.obj --draw-boundary"), draw("sheet.obj"));
}

/// Sides of a crease are as flat as they are; formats with one normal per vertex keep the mean.
#[test]
fn creases_are_written_with_the_normals_of_their_sides() {
    let folder = Folder::new();
    cube(&folder);
    let fit = "fit cube.obj --scheme catmull-clark --crease-angle 30 --limit --levels 1";
    folder.ok(&format!("{fit} -o fine.obj"));
    let fine = folder.mesh("fine.obj");
    let normals = fine.corner_normals.unwrap();
    for (corner, n) in normals.iter().enumerate() {
        let face = fine.faces.iter().nth(corner / 4).unwrap();
        let p = |i: usize| fine.positions[face[i] as usize];
        let flat = (p(1) - p(0)).cross(p(2) - p(0)).normalized();
        assert!((*n - flat).length() < 1e-12, "{corner}");
    }
    let run = folder.ok(&format!("{fit} -o fine.ply"));
    assert!(run.stderr.contains("several normals of a vertex"), "{}", run.stderr);
    let mean = folder.mesh("fine.ply").normals.unwrap();
    for (n, p) in mean.iter().zip(&fine.positions).take(8) {
        let outward = (*p - fairform::Vec3::splat(0.5)).normalized();
        assert!((*n - outward).length() < 1e-12);
    }
    // Smooth surfaces have one per vertex.
    folder.ok("fit cube.obj --scheme catmull-clark --limit --levels 1 -o fine.obj");
    assert!(folder.mesh("fine.obj").corner_normals.is_none());
}

#[test]
fn shape_parameters_colour_surfaces_by_the_face_they_come_from() {
    let folder = Folder::new();
    cube(&folder);
    let draw = |options: &str| {
        let size = "--size 160x120 --view front --colour tension --range 0..1";
        folder.ok(&format!("render cube.obj -o p.png {size} {options}"));
        folder.bytes("p.png")
    };
    let tight = "--lambda 0.4 --tension-where normal=0,0,1,10:0.9";
    let pictures = [
        draw(tight),
        draw(&format!("{tight} --scheme doo-sabin")),
        draw(&format!("{tight} --scheme doo-sabin --fit")),
        draw("--lambda 0.4 --scheme doo-sabin --fit"),
    ];
    for (i, a) in pictures.iter().enumerate() {
        assert!(pictures[..i].iter().all(|b| a != b), "picture {i} is like another");
    }
    let without = "render cube.obj -o p.png --colour tension --scheme doo-sabin";
    folder.fails(without, 2, "--lambda");
}

#[test]
fn info_judges_a_scheme_with_its_options() {
    let folder = Folder::new();
    sheet(&folder);
    cube(&folder);
    let scheme = |input: &str, options: &str| {
        folder.ok(&format!("info {input} --json --scheme {options}")).json()["scheme"].clone()
    };
    let cube_json = scheme("cube.obj", "catmull-clark");
    assert_eq!(cube_json["singular_parts"], 1);
    let creased = scheme("cube.obj", "catmull-clark --crease-angle 30");
    assert_eq!((&creased["singular_parts"], &creased["sharp_edges"]), (&0.into(), &12.into()));
    let sheet_json = scheme("sheet.obj", "catmull-clark");
    let stages = sheet_json["stages"].as_array().unwrap();
    assert_eq!((&stages[0]["name"], &stages[1]["name"]), (&"boundary".into(), &"interior".into()));
    assert!((stages[0]["smallest_eigenvalue"].as_f64().unwrap() - 1.0 / 3.0).abs() < 1e-15);
    assert!((stages[1]["smallest_eigenvalue"].as_f64().unwrap() - 1.0 / 9.0).abs() < 1e-15);
    let none = scheme("sheet.obj", "catmull-clark --boundary none");
    assert_eq!((&none["support_faces"], none["stages"].as_array().unwrap().len()), (&16.into(), 1));
    let lambda = scheme("sheet.obj", "doo-sabin --lambda 0.4 --tension-where face=0:0.7");
    assert_eq!(lambda["lambda"], serde_json::json!([0.4, 0.7]));
    assert_eq!(scheme("sheet.obj", "doo-sabin --boundary drop")["suits"], false);
    assert_eq!(scheme("sheet.obj", "kobbelt --w 3")["notes"].as_array().unwrap().len(), 1);
    let text = folder.ok("info sheet.obj --scheme doo-sabin --lambda 0.4").stdout;
    assert!(String::from_utf8(text).unwrap().contains("λ         0.4 to 0.4"));
    folder.fails("info sheet.obj --lambda 0.4", 2, "--scheme");
    folder.fails("info sheet.obj --corners sharp", 2, "--scheme");
}

/// Every scheme takes every mesh: cut or split first where it must be, with the vertices where they are.
#[test]
fn compare_shows_all_schemes_on_any_mesh() {
    let folder = Folder::new();
    sheet(&folder);
    let mixed = data("meshes/polygon/platonic_shelf.obj");
    fs::copy(mixed, folder.path("mixed.obj")).unwrap();
    fs::copy(data("golden/meshes/open-grid.obj"), folder.path("triangles.obj")).unwrap();
    for (input, shapes) in [
        ("sheet.obj", ["triangulated", "triangulated", "as given"]),
        ("mixed.obj", ["triangulated", "triangulated", "split"]),
        ("triangles.obj", ["as given", "as given", "split"]),
    ] {
        let json = folder.ok(&format!("compare {input} --json --levels 2")).json();
        let rows = json["schemes"].as_array().unwrap();
        assert_eq!(rows.len(), 10, "{input}");
        let shape = |name: &str| rows.iter().find(|r| r["scheme"] == name).unwrap()["mesh"].clone();
        assert_eq!(["loop", "butterfly", "kobbelt"].map(shape), shapes, "{input}");
        for row in rows {
            assert!(row["error"].as_f64().unwrap() < 2e-6, "{input} {row}");
            assert!(row["deviation"].as_f64().unwrap() < 0.2, "{input} {row}");
        }
    }
    let table = String::from_utf8(folder.ok("compare mixed.obj --levels 2").stdout).unwrap();
    assert!(table.contains("loop *") && table.contains("\n* of the mesh"), "{table}");
    assert!(table.contains("kobbelt **") && table.contains("\n** of the mesh"), "{table}");
    let table = String::from_utf8(folder.ok("compare triangles.obj --levels 2").stdout).unwrap();
    assert!(!table.contains("\n* of the mesh"), "{table}");
}

/// What `assert_near` is for: the interior of a fitted sheet does not depend on who holds its boundary.
#[test]
fn support_and_curve_agree_where_the_boundary_is_its_own_limit() {
    let folder = Folder::new();
    // A straight boundary with equal steps is its own limit, except at the corners, which are kept.
    let positions = fairform::shapes::sheet(6, 6, |x, y| 3.0 * x * y * (1.0 - x) * (1.0 - y));
    let at = |i: u32, j: u32| 6 * i + j;
    let faces: Vec<Vec<u32>> = (0..25)
        .map(|k| (k / 5, k % 5))
        .map(|(i, j)| vec![at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)])
        .collect();
    folder.write("flat.obj", &obj(positions.positions(), &faces));
    let fit = "fit flat.obj --scheme catmull-clark --corners sharp --levels 0 --tolerance 1e-12";
    folder.ok(&format!("{fit} -o curve.obj"));
    folder.ok(&format!("{fit} -o support.obj --boundary none"));
    let [curve, support] = ["curve.obj", "support.obj"].map(|name| folder.mesh(name).positions);
    assert_near(&curve, &support, 1e-10, "control points");
}

#[test]
fn adaptive_meshes_are_as_near_as_asked_for() {
    let folder = Folder::new();
    sheet(&folder);
    let refine = "refine sheet.obj -o out.ply --scheme catmull-clark --levels 4 --json";
    folder.ok(&format!("{refine} --limit"));
    let whole = mesh(&folder.mesh("out.ply"));
    let mut last = usize::MAX;
    for tolerance in [1e-4, 1e-3, 1e-2] {
        let run = folder.ok(&format!("{refine} --adaptive {tolerance}"));
        let report = run.json();
        let made = mesh(&folder.mesh("out.ply"));
        assert_eq!(report["faces"], made.topology().face_count());
        // The diagonal of the sheet is below 1.5.
        let farthest = fairform::fairness::deviation(whole.positions(), &made).max;
        assert!(report["share_at_limit"].as_f64().unwrap() > 0.0 || farthest <= 1.5 * tolerance);
        assert!(made.topology().face_count() < last);
        last = made.topology().face_count();
    }
    assert!(8 * last < whole.topology().face_count(), "{last}");

    let run =
        folder.ok("refine sheet.obj -o out.obj --scheme catmull-clark --levels 3 --adaptive 1e-9");
    assert!(run.stderr.contains("more --levels help"), "{}", run.stderr);
    let near = format!("{refine} --adaptive 2e-4");
    let [close, far] = ["0,0,1", "-90,0,3"].map(|eye| {
        let run = folder.ok(&format!("{near} --eye {eye}"));
        run.json()["faces"].as_u64().unwrap()
    });
    assert!(far < close, "{far} {close}");
    folder.fails("refine sheet.obj -o out.ply --scheme doo-sabin --adaptive 0.01", 1, "adaptive");
    folder.fails("refine sheet.obj -o out.ply --adaptive 0.01 --eye 1,2", 2, "three numbers");
}
