//! Pictures of streamline models and curves.

use std::fs;

use crate::common::{Folder, data};

fn folder() -> Folder {
    let folder = Folder::new();
    let model = data("streamline/car.streamline.json");
    fs::copy(model, folder.path("car.streamline.json")).unwrap();
    let curve = r#"{"kind": "curve", "scheme": "qi", "order": 3, "length": 1, "samples": 5,
        "tangents": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}"#;
    fs::write(folder.path("curve.streamline.json"), curve).unwrap();
    folder
}

/// Each option changes the picture, and none is empty.
#[test]
fn models_are_drawn() {
    let folder = folder();
    let mut pictures = Vec::new();
    for options in [
        "",
        "--depth 1",
        "--depth 0,1",
        "--show surface",
        "--show across,combs,start",
        "--show surface --colour curvature",
        "--show surface --colour zebra",
        "--wireframe",
        "--sphere",
        "--sphere=columns",
        "--sphere=2",
    ] {
        let run = folder.run(&format!(
            "render car.streamline.json -o out.png --size 160x120 --view iso {options}"
        ));
        assert_eq!(run.code, Some(0), "{options}: {}", run.stderr);
        let picture = fs::read(folder.path("out.png")).unwrap();
        assert!(!pictures.contains(&picture), "{options} changes nothing");
        pictures.push(picture);
    }
}

#[test]
fn curves_have_a_picture_of_their_directions() {
    let folder = folder();
    let run = folder.run("render curve.streamline.json -o out.png --size 160x120 --sphere");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let run = folder.run("render curve.streamline.json -o out.png --size 160x120");
    assert_eq!(run.code, Some(1));
    assert!(run.stderr.contains("--sphere"), "{}", run.stderr);
}

#[test]
fn options_that_do_not_fit_are_named() {
    let folder = folder();
    fs::copy(data("meshes/tri_closed/icosahedron.off"), folder.path("in.off")).unwrap();
    for (arguments, named) in [
        ("in.off --sphere", "--sphere"),
        ("in.off car.streamline.json --depth 2", "--depth"),
        ("car.streamline.json --scheme kobbelt", "--scheme"),
        ("car.streamline.json --fit", "--fit"),
        ("car.streamline.json --sphere --colour zebra", "--colour"),
        ("car.streamline.json --sphere=9", "row 9"),
        ("car.streamline.json --show nothing", "nothing"),
    ] {
        let run = folder.run(&format!("render {arguments} -o out.png --size 160x120"));
        assert_eq!(run.code, Some(2), "{arguments}: {}", run.stderr);
        assert!(run.stderr.contains(named), "{arguments}: {}", run.stderr);
    }
    // A mesh and a model together are fine.
    let run = folder.run("render in.off car.streamline.json -o out.png --size 160x120");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
}

/// The view of a model is taken where none is asked for.
#[test]
fn a_model_says_its_view() {
    let folder = Folder::new();
    folder.ok("streamline --new wave -o wave.streamline.json");
    let mut model = folder.json("wave.streamline.json");
    let mut picture = |view: serde_json::Value, option: &str| {
        model["display"] = serde_json::json!({ "view": view, "colours": 3 });
        folder.write("m.streamline.json", &model.to_string());
        let run = folder.ok(&format!("render m.streamline.json -o p.png --size 160x120 {option}"));
        (folder.bytes("p.png"), run.stderr)
    };
    let (top, iso) = (picture("top".into(), ""), picture("iso".into(), ""));
    assert_ne!(top, iso);
    assert_eq!(top, picture("front,z".into(), "--view top"));
    assert_eq!(picture("30,20".into(), ""), picture("top".into(), "--view 30,20"));
    // What another viewer wants is said, and does no harm.
    for view in [serde_json::json!("nowhere"), serde_json::json!([1, 2, 3])] {
        let (bytes, said) = picture(view.clone(), "");
        assert_eq!(bytes, iso.0);
        let words = format!("m.streamline.json: display.view: {view} is no view");
        assert!(said.contains(&words), "{said}");
    }
    // The first that has one, of all.
    folder.write("plain.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let two = |option: &str| {
        folder.ok(&format!("render plain.obj m.streamline.json -o p.png --size 160x120 {option}"));
        folder.bytes("p.png")
    };
    folder.write("m.streamline.json", &{
        model["display"] = serde_json::json!({ "view": "left" });
        serde_json::json!({ "patches": [model] }).to_string()
    });
    assert_eq!(two(""), two("--view left"));
}
