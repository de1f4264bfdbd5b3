//! What goes through files agrees with the reference values of `data/golden/loop`.

use crate::common::{
    Folder, GOLDEN_LOOP, assert_near, assert_same_mesh, face_lists, faces, golden, points,
};
use serde_json::Value;

#[test]
fn refined_meshes_and_their_order() {
    let folder = Folder::new();
    for name in GOLDEN_LOOP {
        let fixture = golden(name);
        folder.write_golden("in.obj", &fixture["mesh"]);
        for level in fixture["refine"].as_array().unwrap() {
            for output in ["fine.ply", "fine.obj", "fine.off"] {
                let n = &level["level"];
                folder.ok(&format!("refine in.obj -o {output} --scheme loop --levels {n}"));
                let fine = folder.mesh(output);
                let (vertices, faces) = (points(&level["vertices"]), faces(&level["faces"]));
                if *n == 1 {
                    assert_near(&fine.positions, &vertices, 1e-12, name);
                    assert_eq!(face_lists(&fine), faces, "{name} as {output}");
                } else {
                    // Steps at once number the vertices of the level before first.
                    let levels = fixture["refine"].as_array().unwrap();
                    let before = levels.iter().find(|l| l["level"] == n.as_u64().unwrap() - 1);
                    let kept = points(&before.unwrap()["vertices"]).len();
                    assert_same_mesh(&fine, (&vertices, &faces), kept, 1e-12, name);
                }
            }
        }
    }
}

#[test]
fn limit_points_and_normals() {
    let folder = Folder::new();
    for name in GOLDEN_LOOP {
        let fixture = golden(name);
        let (limit, normals) = (points(&fixture["limit"]), points(&fixture["normals"]));
        folder.write_golden("in.obj", &fixture["mesh"]);
        folder.ok("limit in.obj -o limit.json --scheme loop");
        let json = folder.json("limit.json");
        assert_near(&points(&json["points"]), &limit, 1e-12, name);
        assert_near(&points(&json["normals"]), &normals, 1e-12, name);

        folder.ok("limit in.obj -o limit.obj --scheme loop");
        let mesh = folder.mesh("limit.obj");
        assert_near(&mesh.positions, &limit, 1e-12, name);
        assert_eq!(face_lists(&mesh), faces(&fixture["mesh"]["faces"]));
        assert_near(&mesh.normals.unwrap(), &normals, 1e-12, name);

        // A step and its limit do not move the limit points.
        folder.ok("refine in.obj -o fine.ply --levels 1 --limit");
        let fine = folder.mesh("fine.ply");
        assert_near(&fine.positions[..limit.len()], &limit, 1e-12, name);
        let fine_normals = fine.normals.unwrap();
        assert!(fine_normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-12), "{name}");
    }
}

#[test]
fn histories_of_twenty_updates() {
    let folder = Folder::new();
    for name in GOLDEN_LOOP {
        let expected = &golden(name)["interpolation"];
        folder.write_golden("in.obj", &golden(name)["mesh"]);
        folder.ok(
            "fit in.obj -o surface.ply --method plain --norm absolute --iterations 20 --levels 1 \
             --control control.ply --report report.json",
        );
        let report = folder.json("report.json");
        assert_eq!((&report["scheme"], &report["method"]), (&"loop".into(), &"plain".into()));
        check_stages(name, &report, &expected["stages"]);
        let control = folder.mesh("control.ply").positions;
        assert_near(&control, &points(&expected["iterates"]["20"]), 1e-12, name);

        // No level, and the surface is the control mesh.
        folder.ok("fit in.obj -o same.ply --method plain --iterations 20 --levels 0");
        assert_eq!(folder.bytes("same.ply"), folder.bytes("control.ply"), "{name}");
        folder.ok("refine control.ply -o refined.ply --levels 1");
        assert_eq!(folder.bytes("refined.ply"), folder.bytes("surface.ply"), "{name}");
    }
}

fn check_stages(name: &str, report: &Value, expected: &Value) {
    let (stages, expected) = (report["stages"].as_array().unwrap(), expected.as_array().unwrap());
    assert_eq!(stages.len(), expected.len(), "{name}");
    for (stage, expected) in stages.iter().zip(expected) {
        assert_eq!(stage["name"], expected["name"], "{name}");
        assert_eq!(stage["iterations"], 20);
        let history = stage["history"].as_array().unwrap();
        assert_eq!(history.len(), 21, "{name}");
        for (row, expected) in history.iter().zip(expected["history"].as_array().unwrap()) {
            assert_eq!(row[0], expected[0], "the number of updates");
            for column in 1..3 {
                let (a, e) = (row[column].as_f64().unwrap(), expected[column].as_f64().unwrap());
                assert!((a - e).abs() < 1e-12, "{name}: {row} is not {expected}");
            }
        }
    }
    let last = |column: usize| {
        let of = |stage: &Value| stage["history"][20][column].as_f64().unwrap();
        stages.iter().map(of).fold(0.0, f64::max)
    };
    // Measured by another path, so the last digits may differ.
    let max = report["max"].as_f64().unwrap();
    assert!((max - last(1)).abs() < 1e-13, "{name}: {max} is not {}", last(1));
}

#[test]
fn iterations_until_a_tolerance() {
    let folder = Folder::new();
    for name in GOLDEN_LOOP {
        let run = &golden(name)["interpolation"]["tolerance_run"];
        assert_eq!(run["norm"], "unit_cube", "which is the longest side");
        folder.write_golden("in.obj", &golden(name)["mesh"]);
        let tolerance = &run["tol"];
        folder.ok(&format!(
            "fit in.obj -o c.ply --levels 0 --method plain --norm longest-side --report r.json \
             --tolerance {tolerance} --iterations 100000"
        ));
        let report = folder.json("r.json");
        assert_eq!(report["converged"], true);
        for stage in report["stages"].as_array().unwrap() {
            let expected = &run["iterations"][stage["name"].as_str().unwrap()];
            assert_eq!(&stage["iterations"], expected, "{name}");
        }
        assert_near(&folder.mesh("c.ply").positions, &points(&run["control"]), 1e-12, name);
    }
}
