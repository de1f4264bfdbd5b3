//! Projects of the studio, opened by the command.

use std::fs;

use fairform::{Scheme, Vec3};
use fairform_io::project::{self, MeshPart, Project};
use serde_json::Value;

use crate::common::{Folder, data};

const BOX: &str = "\
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// A box of which a vertex is moved and a face is tighter than the others.
fn part() -> MeshPart {
    let mut part = MeshPart::new("box.obj", BOX.into());
    part.design.scheme = Scheme::DooSabin;
    part.design.tolerance = 1e-9;
    part.design.tensions = vec![(1, 0.8)];
    part.design.moves = vec![(6, 1.5, 1.25, 2.0)];
    part.fineness.levels = 2;
    part
}

/// With a project in it.
fn folder(mesh: Option<MeshPart>, model: Option<Value>) -> Folder {
    let mut project = Project::default();
    (project.mesh, project.model) = (mesh, model);
    let folder = Folder::new();
    fs::write(folder.path("a.fairform.json"), project::encode(&project)).unwrap();
    folder
}

/// What the options say for a file of its own is what the project says for its mesh.
#[test]
fn a_fit_of_a_project_is_the_fit_that_it_describes() {
    let folder = folder(Some(part()), None);
    folder.ok("fit a.fairform.json -o a.obj");
    folder.write("box.obj", &BOX.replace("v 1 1 1\n", "v 1.5 1.25 2\n"));
    folder.write("tension.json", r#"{"default": 0.5, "faces": {"1": 0.8}}"#);
    folder.ok(
        "fit box.obj -o b.obj --scheme doo-sabin --tolerance 1e-9 --lambda tension.json --levels 2 --limit",
    );
    assert_eq!(folder.bytes("a.obj"), folder.bytes("b.obj"));

    folder.ok("fit a.fairform.json -o c.obj --levels 1");
    assert!(folder.mesh("c.obj").positions.len() < folder.mesh("a.obj").positions.len());
}

#[test]
fn others_read_the_mesh_as_it_was_moved() {
    let folder = folder(Some(part()), None);
    let run = folder.ok("convert a.fairform.json -o b.obj");
    assert!(run.stderr.contains("a.fairform.json: its mesh as it was moved"), "{}", run.stderr);
    assert_eq!(folder.mesh("b.obj").positions[6], Vec3::new(1.5, 1.25, 2.0));
}

#[test]
fn what_the_project_says_is_not_said_twice() {
    let folder = folder(Some(part()), None);
    let run = folder.run("fit a.fairform.json -o b.obj --lambda 0.7");
    assert_eq!(run.code, Some(2));
    assert!(run.stderr.contains("--lambda and --tension-where: the project says that"));
}

#[test]
fn a_project_with_a_model_makes_its_surface() {
    let text = fs::read(data("streamline/car.streamline.json")).unwrap();
    let model = Some(serde_json::from_slice(&text).unwrap());
    let folder = folder(None, model);
    folder.ok("streamline a.fairform.json -o a.obj");
    fs::write(folder.path("car.streamline.json"), text).unwrap();
    folder.ok("streamline car.streamline.json -o b.obj");
    assert_eq!(folder.bytes("a.obj"), folder.bytes("b.obj"));

    let run = folder.run("fit a.fairform.json -o c.obj");
    assert_eq!(run.code, Some(1));
    assert!(run.stderr.contains("the project holds no mesh"), "{}", run.stderr);
    assert!(run.stderr.contains("fairform streamline a.fairform.json"), "{}", run.stderr);
}

#[test]
fn what_is_wrong_with_a_project_is_said_with_its_field() {
    let folder = Folder::new();
    for (text, what) in [
        (r#"{"fairform": 2}"#, "fairform: version 2"),
        (r#"{"mesh": null}"#, "fairform: missing"),
        (r#"{"fairform": 1}"#, "the project holds no mesh"),
        (r#"{"fairform": 1, "mesh": {"name": 3}}"#, "mesh.name: invalid type"),
    ] {
        folder.write("a.fairform.json", text);
        let run = folder.run("fit a.fairform.json -o b.obj");
        assert_eq!(run.code, Some(1), "{text}");
        assert!(run.stderr.contains(what), "{text}: {}", run.stderr);
    }
    let mut part = part();
    part.design.moves = vec![(8, 0.0, 0.0, 0.0)];
    let folder = self::folder(Some(part), None);
    let run = folder.run("fit a.fairform.json -o b.obj");
    assert!(
        run.stderr.contains("vertex 8 is moved, but the mesh has 8 vertices"),
        "{}",
        run.stderr
    );
}
