//! Polygon schemes, shape parameters, creases and comparisons, through files.

use std::fs;

use crate::common::{Folder, assert_near, assert_same_mesh, data, faces, obj, points};
use serde_json::Value;

/// The fixtures of a scheme and the options they stand for.
fn fixtures(folder: &Folder, scheme: &str) -> Vec<(String, Value, String)> {
    let mut all = Vec::new();
    for entry in fs::read_dir(data(&format!("golden/{scheme}"))).unwrap() {
        let path = entry.unwrap().path();
        let fixture: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let mut options = format!("--scheme {scheme}");
        if !fixture["lambda"].is_null() {
            let file = format!("{name}.lambda.json");
            folder.write(&file, &fixture["lambda"].to_string());
            options += &format!(" --lambda {file}");
        }
        for key in ["boundary", "corners", "w"] {
            match &fixture[key] {
                Value::Null => {}
                Value::String(text) => options += &format!(" --{key} {text}"),
                other => options += &format!(" --{key} {other}"),
            }
        }
        all.push((name, fixture, options));
    }
    assert!(all.len() > 4, "{scheme}");
    all
}

#[test]
fn golden_values_through_files() {
    let folder = Folder::new();
    for scheme in ["catmull-clark", "doo-sabin", "butterfly", "kobbelt"] {
        for (name, fixture, options) in fixtures(&folder, scheme) {
            folder.write_golden("in.obj", &fixture["mesh"]);
            for level in fixture["refine"].as_array().unwrap() {
                let n = &level["level"];
                folder.ok(&format!("refine in.obj -o fine.ply {options} --levels {n}"));
                let fine = folder.mesh("fine.ply");
                let (vertices, faces) = (points(&level["vertices"]), faces(&level["faces"]));
                assert_eq!(fine.faces.len(), faces.len(), "{name}");
                if scheme == "catmull-clark" && *n != 1 {
                    let kept = points(&fixture["mesh"]["vertices"]).len();
                    assert_same_mesh(&fine, (&vertices, &faces), kept, 1e-12, &name);
                } else {
                    assert_near(&fine.positions, &vertices, 1e-12, &name);
                }
            }
            if !fixture["limit"].is_null() {
                folder.ok(&format!("limit in.obj -o limit.json {options}"));
                let json = folder.json("limit.json");
                assert_near(&points(&json["points"]), &points(&fixture["limit"]), 1e-12, &name);
            }
            let iterates = fixture["interpolation"]["iterates"].as_object();
            for (k, control) in iterates.into_iter().flatten() {
                let fit = "fit in.obj -o control.ply --method plain --levels 0";
                folder.ok(&format!("{fit} --iterations {k} {options}"));
                let actual = folder.mesh("control.ply").positions;
                assert_near(&actual, &points(control), 1e-12, &format!("{name} after {k}"));
            }
        }
    }
}

fn cube(folder: &Folder) {
    let cube = fairform::shapes::cube();
    let list: Vec<Vec<u32>> = cube.topology().to_faces().iter().map(<[u32]>::to_vec).collect();
    folder.write("cube.obj", &obj(cube.positions(), &list));
}

/// No control cube has a dented cube as its Catmull–Clark limit; it works all the same.
#[test]
fn a_cube_simply_works() {
    let folder = Folder::new();
    cube(&folder);
    let dented =
        String::from_utf8(folder.bytes("cube.obj")).unwrap().replacen("v 0 0 0", "v 0.1 0.2 0", 1);
    folder.write("dented.obj", &dented);
    for mesh in ["cube.obj", "dented.obj"] {
        let run = folder.ok(&format!("fit {mesh} -o surface.ply --scheme catmull-clark --limit"));
        assert!(run.stderr.contains("one level finer"), "{}", run.stderr);
        let (target, surface) = (folder.mesh(mesh), folder.mesh("surface.ply"));
        assert_near(&surface.positions[..8], &target.positions, 1e-14, mesh);
    }
    folder.ok("fit dented.obj -o exact.ply --scheme doo-sabin --exact --report r.json");
    let report = folder.json("r.json");
    assert!(report["max"].as_f64().unwrap() < 1e-14 && report["control_level"] == 1);
    folder.ok("fit dented.obj -o fair.ply --scheme catmull-clark --fair 1 --report r.json");
    let report = folder.json("r.json");
    assert!(report["max"].as_f64().unwrap() < 1e-13);
    let fairing = &report["fairing"];
    assert!(fairing["after"].as_f64().unwrap() < fairing["before"].as_f64().unwrap());
    assert_eq!(fairing["energy"]["stretching"], 0.001);
    let tight = "fit dented.obj -o tight.ply --scheme catmull-clark --fair 1 --fair-stretch 10";
    let run = folder.ok(tight);
    assert!(run.stderr.contains("of the limit surface"), "{}", run.stderr);
    assert_ne!(folder.bytes("fair.ply"), folder.bytes("tight.ply"));
    folder.fails("fit cube.obj -o fair.ply --scheme catmull-clark --fair 2", 1, "between 0 and 1");
}

#[test]
fn shape_parameters_in_every_form() {
    let folder = Folder::new();
    cube(&folder);
    let with = |options: &str| {
        folder.ok(&format!("fit cube.obj -o out.ply --scheme doo-sabin {options}"));
        folder.bytes("out.ply")
    };
    folder.write("number.json", "0.7");
    folder.write("list.json", "[0.7, 0.7, 0.7, 0.9, 0.7, 0.7]");
    folder.write("object.json", r#"{"default": 0.7, "faces": {"3": 0.9}}"#);
    assert_eq!(with("--lambda 0.7"), with("--lambda number.json"));
    assert_eq!(with("--lambda list.json"), with("--tension object.json"));
    assert_eq!(with("--lambda list.json"), with("--lambda 0.7 --tension-where face=3:0.9"));
    assert_eq!(with("--lambda 0.7"), with("--lambda 0.2 --tension-where all:0.7"));
    assert_ne!(with("--lambda auto"), with("--lambda 0.7"));
    assert_ne!(
        with("--lambda 0.5 --tension-where face=3:0.9 --falloff 2"),
        with("--lambda 0.5 --tension-where face=3:0.9")
    );
    let fit = "fit cube.obj -o out.ply --scheme doo-sabin";
    folder.write("short.json", "[0.5]");
    folder.write("odd.json", r#"{"defualt": 0.5}"#);
    folder.write("far.json", r#"{"faces": {"6": 0.5}}"#);
    for (options, words) in [
        ("--lambda 0", "face 0"),
        ("--lambda 1.5", "face 0"),
        ("--lambda NaN", "face 0"),
        ("--lambda short.json", "1 values, but the mesh has 6 faces"),
        ("--lambda odd.json", "defualt"),
        ("--lambda far.json", "no face \"6\""),
        ("--lambda missing.json", "missing.json"),
        ("--tension-where group=lid:0.5", "group"),
        ("--tension-where face=9:0.5", "face=9"),
    ] {
        folder.fails(&format!("{fit} {options}"), 1, words);
    }
    folder.fails(&format!("{fit} --tension-where 0.5"), 2, "SELECTION:X");
}

#[test]
fn shape_parameters_for_all_approximating_schemes() {
    let folder = Folder::new();
    cube(&folder);
    folder.ok("repair cube.obj -o triangles.obj --triangulate");
    for (mesh, scheme) in [("cube.obj", "catmull-clark"), ("triangles.obj", "loop")] {
        let fit = format!("fit {mesh} -o out.ply --scheme {scheme}");
        let with = |options: &str| {
            folder.ok(&format!("{fit} {options} --report r.json"));
            let report = folder.json("r.json");
            assert!(report["max"].as_f64().unwrap() <= 1e-6, "{scheme} {options}");
            (report["control_level"].as_u64().unwrap(), folder.bytes("out.ply"))
        };
        // The cube alone needs no correction any more.
        assert_eq!(with("--lambda 0.6").0, 0);
        assert_ne!(with("--lambda 0.6").1, with("--lambda 0.9").1);
        assert_eq!(with("--lambda 0.9"), with("--tension-where all:0.9"));
        assert_ne!(with("--lambda 0.5").1, with("--tension-where face=3:0.9 --falloff 2").1);
        for (options, words) in [
            ("--lambda 0.4", "face 0 is 0.4"),
            ("--lambda 1.5", "from 0.5 to 1"),
            ("--tension-where face=2:0.1", "face 2"),
            ("--lambda auto", "doo-sabin"),
        ] {
            folder.fails(&format!("{fit} {options}"), 1, words);
        }
        let picture = format!("render {mesh} -o p.png --size 200x160 --scheme {scheme}");
        folder.ok(&picture);
        let plain = folder.bytes("p.png");
        folder.ok(&format!("{picture} --lambda 0.9"));
        assert_ne!(plain, folder.bytes("p.png"));
    }
    let kobbelt = "fit cube.obj -o out.ply --scheme kobbelt --lambda 0.7";
    folder.fails(kobbelt, 1, "does not know a shape parameter");
}

#[test]
fn creases_from_files_and_angles() {
    let folder = Folder::new();
    cube(&folder);
    let fit = "fit cube.obj -o out.ply --scheme catmull-clark --limit";
    let mut bytes = Vec::new();
    // All edges sharp: the cube itself, whichever way it is said.
    let all: Vec<(u32, u32)> = (0..8)
        .flat_map(|a: u32| [1, 2, 4].map(|bit| (a, a | bit)))
        .filter(|(a, b)| a != b)
        .collect();
    assert_eq!(all.len(), 12);
    let tags: String = all.iter().map(|(a, b)| format!("t crease 2/1/0 {a} {b} 10\n")).collect();
    folder.write("creases.obj", &tags);
    let indices: Vec<u32> = all.iter().flat_map(|&(a, b)| [a, b]).collect();
    let usd = serde_json::json!({
        "creaseIndices": indices, "creaseLengths": vec![2; 12], "creaseSharpnesses": vec![10.0; 12],
    });
    folder.write("creases.json", &usd.to_string());
    for options in ["--creases creases.obj", "--creases creases.json", "--crease-angle 30"] {
        folder.ok(&format!("{fit} {options}"));
        bytes.push(folder.bytes("out.ply"));
        let surface = folder.mesh("out.ply");
        for p in surface.positions {
            let off = |x: f64| x.abs().min((x - 1.0).abs());
            assert!(off(p.x).min(off(p.y)).min(off(p.z)) < 1e-12, "{p:?} is on a side of the cube");
        }
    }
    assert!(bytes.windows(2).all(|w| w[0] == w[1]));
    folder.write("bad.obj", "t crease 2/1/0 0 7 3\n");
    folder.fails(&format!("{fit} --creases bad.obj"), 1, "no edge between vertices 0 and 7");
    folder.write("none.obj", "v 0 0 0\n");
    folder.fails(&format!("{fit} --creases none.obj"), 1, "no creases");
    folder.fails("fit cube.obj -o out.ply --scheme doo-sabin --crease-angle 30", 1, "crease");
}

#[test]
fn schemes_are_compared() {
    let folder = Folder::new();
    cube(&folder);
    let names = |run: &crate::common::Run| -> Vec<String> {
        let json = run.json();
        let rows = json["schemes"].as_array().unwrap();
        assert!(rows.iter().all(|r| r["error"].as_f64().unwrap() < 2e-6), "{json}");
        rows.iter().map(|r| r["scheme"].as_str().unwrap().to_owned()).collect()
    };
    let quads = names(&folder.ok("compare cube.obj --json --levels 2"));
    assert!(quads.contains(&"kobbelt".into()) && quads.contains(&"catmull-clark".into()));
    folder.ok("repair cube.obj -o triangles.obj --triangulate");
    let triangles = names(&folder.ok("compare triangles.obj --json --levels 2"));
    assert!(triangles.contains(&"loop".into()) && triangles.contains(&"butterfly".into()));
    let table = folder.ok("compare cube.obj -o sheet.png --levels 2 --size 600x400");
    assert!(String::from_utf8(table.stdout).unwrap().contains("doo-sabin"));
    assert!(folder.bytes("sheet.png").starts_with(b"\x89PNG"));
}

#[test]
fn surfaces_are_coloured() {
    let folder = Folder::new();
    cube(&folder);
    folder.ok("fit cube.obj -o surface.ply --scheme doo-sabin --limit --levels 2");
    let mut pictures = Vec::new();
    for colour in ["curvature", "gaussian", "zebra", "reflection", "error --reference cube.obj"] {
        folder.ok(&format!("render surface.ply -o p.png --size 200x160 --colour {colour}"));
        pictures.push(folder.bytes("p.png"));
    }
    let tension = "render cube.obj -o p.png --size 200x160 --colour tension --lambda 0.5";
    folder.ok(&format!("{tension} --tension-where face=2:0.9"));
    pictures.push(folder.bytes("p.png"));
    for (i, a) in pictures.iter().enumerate() {
        assert!(pictures[..i].iter().all(|b| a != b), "picture {i} is like another");
    }
    folder.fails("render surface.ply -o p.png --colour error", 2, "--reference");
    folder.fails("render surface.ply -o p.png --colour tension", 2, "--lambda");
}

#[test]
fn schemes_are_judged_and_drawn() {
    let folder = Folder::new();
    cube(&folder);
    let json = folder.ok("info cube.obj --json --scheme catmull-clark").json();
    assert_eq!(json["scheme"]["suits"], true);
    assert!(json["scheme"]["note"].as_str().unwrap().contains("level 1"), "{json}");
    let json = folder.ok("info cube.obj --json --scheme loop").json();
    assert_eq!(json["scheme"]["suits"], false);
    folder.ok("info cube.obj --scheme kobbelt");
    let mut pictures = Vec::new();
    for options in ["", "--scheme catmull-clark", "--scheme doo-sabin --lambda 0.9"] {
        folder.ok(&format!("render cube.obj -o p.png --size 200x160 {options}"));
        pictures.push(folder.bytes("p.png"));
    }
    assert!(pictures[0] != pictures[1] && pictures[1] != pictures[2]);
    folder.fails("render cube.obj -o p.png --scheme loop", 1, "triangles");
}
