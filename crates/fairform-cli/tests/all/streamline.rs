//! Curves and streamline surfaces through the command and its files.

use std::fs;
use std::io::Write;
use std::process::Stdio;

use crate::common::{Folder, assert_near, data, points};
use fairform::Vec3;
use serde_json::{Value, json};

/// The fixtures of a folder whose names begin so.
fn fixtures(folder: &str, beginnings: &[&str]) -> Vec<(String, Value)> {
    let mut fixtures: Vec<_> = fs::read_dir(data("golden").join(folder))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.file_stem().unwrap().to_str().unwrap().to_string(), path))
        .filter(|(name, _)| beginnings.iter().any(|b| name.starts_with(b)))
        .map(|(name, path)| (name, serde_json::from_slice(&fs::read(path).unwrap()).unwrap()))
        .collect();
    fixtures.sort_by(|a, b| a.0.cmp(&b.0));
    fixtures
}

/// The same shape, the same names, and all numbers near.
#[track_caller]
fn assert_same(actual: &Value, expected: &Value, tolerance: f64, what: &str) {
    match (actual, expected) {
        (Value::Array(a), Value::Array(e)) => {
            assert_eq!(a.len(), e.len(), "{what}");
            a.iter().zip(e).for_each(|(a, e)| assert_same(a, e, tolerance, what));
        }
        (Value::Object(a), Value::Object(e)) => {
            let names = |o: &serde_json::Map<String, Value>| o.keys().cloned().collect::<Vec<_>>();
            assert_eq!(names(a), names(e), "{what}");
            e.iter().for_each(|(name, e)| {
                assert_same(&a[name], e, tolerance, &format!("{what}: {name}"));
            });
        }
        _ => {
            let (a, e) = (actual.as_f64().unwrap(), expected.as_f64().unwrap());
            assert!((a - e).abs() <= tolerance, "{what}: {a} is not {e}");
        }
    }
}

#[test]
fn curves_are_the_reference_values() {
    let folder = Folder::new();
    let fixtures = fixtures("sphere", &["curve-", "qi-"]);
    assert_eq!(fixtures.len(), 21);
    for (name, fixture) in fixtures {
        folder.write("spec.json", &fixture["spec"].to_string());
        folder.ok("curve spec.json -o curve.json");
        assert_same(&folder.json("curve.json"), &fixture["result"], 1e-12, &name);
        // The whole of a fixture is taken too.
        folder.write("whole.json", &fixture.to_string());
        folder.ok("curve whole.json -o again.json");
        assert_eq!(folder.bytes("again.json"), folder.bytes("curve.json"), "{name}");

        if fixture["result"]["points"].is_null() {
            folder.fails("curve spec.json -o none.obj", 1, "has tangents, but no points");
            continue;
        }
        folder.ok("curve spec.json -o curve.obj");
        let text = String::from_utf8(folder.bytes("curve.obj")).unwrap();
        let expected = points(&fixture["result"]["points"]);
        let read: Vec<Vec3> = text
            .lines()
            .filter_map(|line| line.strip_prefix("v "))
            .map(|line| {
                let numbers: Vec<f64> = line.split(' ').map(|n| n.parse().unwrap()).collect();
                Vec3::new(numbers[0], numbers[1], numbers[2])
            })
            .collect();
        assert_near(&read, &expected, 1e-12, &name);
        let line: Vec<String> = (1..=expected.len()).map(|i| i.to_string()).collect();
        assert!(text.ends_with(&format!("\nl {}\n", line.join(" "))), "{name}");
    }
}

#[test]
fn surfaces_are_the_reference_values() {
    let folder = Folder::new();
    let fixtures = fixtures("streamline", &[""]);
    assert_eq!(fixtures.len(), 13);
    for (name, fixture) in fixtures {
        let result = &fixture["result"];
        folder.write("model.streamline.json", &fixture["spec"].to_string());
        folder.ok("streamline model.streamline.json -o result.json");
        assert_same(&folder.json("result.json"), result, 1e-12, &name);

        // The model, written again, is the same model; the mesh has its points.
        folder.ok("streamline model.streamline.json -o copy.streamline.json");
        folder.ok("streamline copy.streamline.json -o copy.json");
        assert_eq!(folder.bytes("copy.json"), folder.bytes("result.json"), "{name}");
        folder.ok("streamline copy.streamline.json -o mesh.ply");
        let mesh = folder.mesh("mesh.ply");
        let rows: Vec<Vec<Vec3>> =
            result["points"].as_array().unwrap().iter().map(points).collect();
        assert_near(&mesh.positions, &rows.concat(), 1e-12, &name);
        let (across, along) = (rows.len(), rows[0].len());
        assert_eq!(mesh.faces.len(), (across - 1) * (along - 1));
        assert_eq!(crate::common::face_lists(&mesh)[0], [0, 1, along as u32 + 1, along as u32]);
        let normals = mesh.normals.unwrap();
        assert!(normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-12), "{name}");
        let uvs = mesh.uvs.unwrap();
        let (t, s) = (&result["t"], &result["s"]);
        let number = |v: &Value| v.as_f64().unwrap();
        assert!((uvs[0][0] - number(&s[0][0])).abs() < 1e-12);
        assert!(
            (uvs[along + 1][0] - f64::midpoint(number(&s[1][0]), number(&s[1][1]))).abs() < 1e-12
        );
        assert!((uvs[along + 1][1] - number(&t[1])).abs() < 1e-12);
    }
}

#[test]
fn options_replace_what_the_model_says() {
    let folder = Folder::new();
    // From one fixture, the others of the same grid.
    let all = fixtures("streamline", &["doo", "catmull", "kobbelt-st", "kobbelt-ts"]);
    folder.write("model.json", &all[0].1["spec"].to_string());
    for (name, fixture) in &all {
        let spec = &fixture["spec"];
        let option = |name: &str| format!("--{name} {}", spec[name].as_str().unwrap());
        let options = ["scheme", "order", "ends"].map(option).join(" ");
        let depth = &spec["depth"];
        folder.ok(&format!("streamline model.json -o r.json {options} --depth {depth}"));
        assert_same(&folder.json("r.json"), &fixture["result"], 1e-12, name);
    }
    let (_, uneven) = fixtures("streamline", &["kobbelt-uneven"]).remove(0);
    folder.write("uneven.json", &uneven["spec"].to_string().replace("1.4", "1.0"));
    folder.ok("streamline uneven.json -o r.json --w 1.4");
    assert_same(&folder.json("r.json"), &uneven["result"], 1e-12, "w");

    folder.ok("streamline model.json -o arcs.streamline.json --integration arcs --depth 1");
    let model = folder.json("arcs.streamline.json");
    assert_eq!((&model["integration"], &model["depth"]), (&json!("arcs"), &json!(1)));
    folder.ok("streamline arcs.streamline.json -o arcs.json");
    let result = folder.json("arcs.json");
    assert_eq!(
        result["points"][0].as_array().unwrap().len(),
        result["tangents"][0].as_array().unwrap().len()
    );
}

#[test]
fn new_models_are_models() {
    let folder = Folder::new();
    for (name, size) in [("flat", [33, 49]), ("arc", [33, 49]), ("wave", [33, 49])] {
        let file = format!("{name}.streamline.json");
        folder.ok(&format!("streamline --new {name} -o {file}"));
        let info = folder.ok(&format!("info {file} --json")).json();
        assert_eq!(info["patches"][0]["refined"], json!(size), "{name}");
        assert_eq!(info["patches"][0]["name"], name);
        assert!(folder.ok(&format!("info {file}")).stdout.starts_with(file.as_bytes()));
        // Straight to a surface, it is the same surface, with its upper side up.
        folder.ok(&format!("streamline {file} -o a.obj"));
        folder.ok(&format!("streamline --new {name} -o b.obj"));
        assert_eq!(folder.bytes("a.obj"), folder.bytes("b.obj"), "{name}");
        let normals = folder.mesh("a.obj").normals.unwrap();
        let middle = normals[normals.len() / 2];
        assert!(middle.y > 0.7, "{name}: {middle:?}");
    }
    // The same in any kind of file.
    folder.ok("streamline --new car -o car.json");
    folder.ok("streamline car.json -o car.streamline.json.gz");
    folder.ok("streamline car.streamline.json.gz -o b.streamline.json");
    assert_eq!(folder.bytes("car.json"), folder.bytes("b.streamline.json"));
    assert_eq!(folder.bytes("car.streamline.json.gz")[..2], [0x1f, 0x8b]);
    for format in ["obj", "off", "ply", "stl", "gltf", "glb"] {
        folder.ok(&format!("streamline car.json -o car.{format} --depth 1"));
    }
    assert_eq!(folder.mesh("car.obj").positions.len(), folder.mesh("car.glb").positions.len());
}

/// Two halves of a model that share a streamline are one mesh, in which nothing gapes.
#[test]
fn patches_share_their_streamlines() {
    let folder = Folder::new();
    let patch = |t: [f64; 3], z: f64| {
        json!({
            "tangents": vec![vec![[0.8, 0.6, 0.0], [1.0, 0.0, 0.0], [0.8, -0.6, 0.0]]; 3],
            "lengths": [4, 4, 4], "t": t, "depth": 2,
            "initial": { "type": "polyline", "points": [[0, 0, -z], [0, 0, -z - 2.0]],
                "t": [t[0], t[2]] },
        })
    };
    let file = json!({ "version": 1, "patches": [patch([0.0, 1.0, 2.0], 0.0), patch([2.0, 3.0, 4.0], 2.0)] });
    folder.write("two.json", &file.to_string());
    folder.ok("streamline two.json -o two.obj");
    let mesh = folder.mesh("two.obj");
    assert_eq!((mesh.positions.len(), mesh.faces.len()), (17 * 10, 16 * 9));
    assert_eq!(mesh.uvs.unwrap().len(), 17 * 10);
    assert_eq!(mesh.groups.unwrap().names, ["patch 1", "patch 2"]);
    let info = folder.ok("info two.obj --json").json();
    assert_eq!((&info["components"], &info["boundary_loops"]), (&json!(1), &json!(1)));

    // Other parameters in the second patch are a seam; other points a gap.
    let file = json!({ "patches": [patch([0.0, 1.0, 2.0], 0.0), patch([0.0, 1.0, 2.0], 2.0)] });
    folder.write("seam.json", &file.to_string());
    folder.ok("streamline seam.json -o seam.obj");
    let mesh = folder.mesh("seam.obj");
    assert_eq!((mesh.positions.len(), mesh.corner_uvs.unwrap().len()), (17 * 10, 4 * 16 * 9));
    let file = json!({ "patches": [patch([0.0, 1.0, 2.0], 0.0), patch([2.0, 3.0, 4.0], 2.5)] });
    folder.write("gap.json", &file.to_string());
    folder.ok("streamline gap.json -o gap.obj");
    assert_eq!(folder.mesh("gap.obj").positions.len(), 18 * 10);
    folder.ok("streamline gap.json -o gap.json.json");
    let result = folder.json("gap.json.json");
    assert_eq!(result["patches"].as_array().unwrap().len(), 2);

    let info = folder.ok("info two.json").stdout;
    assert!(String::from_utf8(info).unwrap().contains("patches     2"));
}

/// A model whose last streamline is its first becomes a tube; its vertices are those of the rows, row by
/// row, the last not repeated.
#[test]
fn a_closed_duct_has_two_boundaries() {
    let folder = Folder::new();
    fs::copy(data("streamline/duct.streamline.json"), folder.path("duct.json")).unwrap();
    folder.ok("streamline duct.json -o duct.obj");
    folder.ok("streamline duct.json -o points.json");
    let result = folder.json("points.json");
    let rows: Vec<Vec<Vec3>> = result["points"].as_array().unwrap().iter().map(points).collect();
    let mesh = folder.mesh("duct.obj");
    assert_eq!(rows.first(), rows.last());
    assert_near(&mesh.positions, &rows[..rows.len() - 1].concat(), 1e-15, "duct");
    assert_eq!(mesh.faces.len(), (rows.len() - 1) * (rows[0].len() - 1));
    let info = folder.ok("info duct.obj --json").json();
    assert_eq!((&info["components"], &info["boundary_loops"]), (&json!(1), &json!(2)));
    // Texture coordinates do not run back along the seam.
    let uvs = mesh.corner_uvs.unwrap();
    let t = |v: &Value| v.as_f64().unwrap();
    assert_eq!(uvs[uvs.len() - 2][1], t(result["t"].as_array().unwrap().last().unwrap()));
    let stats = folder.ok("streamline duct.json --stats --json").json();
    let seams = stats["stats"]["seams"].as_array().unwrap();
    assert_eq!(seams.len(), 1);
    assert_eq!(stats["vertices"], mesh.positions.len());
    assert_eq!((&seams[0]["patches"], &seams[0]["gap"]), (&json!([0, 0]), &json!(0.0)));
}

#[test]
fn a_stitched_bottle_is_whole() {
    let folder = Folder::new();
    fs::copy(data("streamline/bottle.streamline.json"), folder.path("b.streamline.json")).unwrap();
    let stats = folder.ok("streamline b.streamline.json -o b.obj --stats --json").json();
    let mesh = folder.mesh("b.obj");
    assert_eq!((mesh.positions.len(), mesh.faces.len()), (160 * 65, 160 * 64));
    assert_eq!(mesh.groups.unwrap().names, ["left", "right"]);
    let info = folder.ok("info b.obj --json").json();
    assert_eq!((&info["components"], &info["boundary_loops"]), (&json!(1), &json!(2)));
    let seams = stats["stats"]["seams"].as_array().unwrap();
    assert_eq!([&seams[0]["patches"], &seams[1]["patches"]], [&json!([0, 1]), &json!([1, 0])]);
    for seam in seams {
        let number = |name: &str| seam[name].as_f64().unwrap();
        assert!(number("gap") < 1e-15 && number("tangent_degrees") < 1e-12, "{seam}");
        assert!(number("plane_degrees") < 6.0, "{seam}");
    }
    let text = folder.ok("streamline b.streamline.json --stats").stdout;
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains("seam         patches 0 and 1: gap 0, tangents 0°, planes "), "{text}");
    let info = String::from_utf8(folder.ok("info b.streamline.json").stdout).unwrap();
    assert!(info.contains("2, stitched smoothly"), "{info}");
    // What is written is what was designed.
    folder.ok("streamline b.streamline.json -o copy.streamline.json");
    assert_eq!(folder.json("copy.streamline.json")["stitch"], "smooth");
    folder.ok("streamline copy.streamline.json -o copy.obj");
    assert_eq!(folder.bytes("copy.obj"), folder.bytes("b.obj"));
}

#[test]
fn stitching_says_what_cannot_be() {
    let folder = Folder::new();
    let patch = |scheme: &str, length: f64| {
        json!({
            "tangents": vec![vec![[0.8, 0.6, 0.0], [1.0, 0.0, 0.0], [0.8, -0.6, 0.0]]; 3],
            "lengths": [length, length, length], "t": [0, 1, 2], "depth": 1, "scheme": scheme,
            "initial": { "type": "polyline", "points": [[0, 0, 0], [0, 0, -2]], "t": [0, 2] },
        })
    };
    let write = |first: Value, second: Value| {
        folder.write("m.json", &json!({ "stitch": true, "patches": [first, second] }).to_string());
    };
    write(patch("kobbelt", 4.0), patch("doo-sabin", 5.0));
    let run = folder.ok("streamline m.json -o m.obj");
    assert!(!run.stderr.contains("warning"), "{}", run.stderr);
    assert_eq!(folder.mesh("m.obj").positions.len(), 9 * 6);
    write(patch("doo-sabin", 4.0), patch("kobbelt", 5.0));
    folder.fails(
        "streamline m.json -o m.obj",
        1,
        "m.json: patches[1]: cannot be stitched to patches[0]: scheme: doo-sabin with natural ends",
    );
    fs::copy(folder.path("m.json"), folder.path("m.streamline.json")).unwrap();
    let words = "m.streamline.json: patches[1]: cannot be stitched to patches[0]: scheme";
    folder.fails("render m.streamline.json -o m.png", 1, words);
    folder.fails("render m.streamline.json -o m.png --sphere", 1, words);
    // With what the options say.
    folder.ok("streamline m.json -o m.obj --ends clamped");
    let mut longer = patch("kobbelt", 4.0);
    longer["length"] = json!({ "type": "polyline", "lengths": [6, 6], "t": [0, 2] });
    write(patch("kobbelt", 4.0), longer);
    let run = folder.ok("streamline m.json -o m.obj");
    assert!(
        run.stderr.contains("warning: m.json: patches[1]: stitched to patches[0], but up to"),
        "{}",
        run.stderr
    );
    assert_eq!(folder.mesh("m.obj").positions.len(), 10 * 6);
}

#[test]
fn exchanged_directions_are_as_far_as_is_said() {
    let folder = Folder::new();
    folder.ok("streamline --new wave -o wave.streamline.json");
    folder.ok("streamline wave.streamline.json -o wave.obj");
    let given = folder.mesh("wave.obj");
    let given = fairform::Mesh::new(given.positions, &given.faces).unwrap();
    let mut before = f64::INFINITY;
    for size in [5, 9, 17] {
        let run = folder.ok(&format!(
            "streamline wave.streamline.json --swap {size}x{} -o across.obj --json",
            2 * size - 1
        ));
        let distance = run.json()["swap"]["distance"].as_f64().unwrap();
        let points = folder.mesh("across.obj").positions;
        let expected = fairform::fairness::deviation(&points, &given).max;
        assert!((distance - expected).abs() < 1e-12, "{distance} {expected}");
        assert!(distance < 0.5 * before, "{size}: {distance} after {before}");
        before = distance;
        assert!(run.stderr.contains("swapped: the points of the new surface are at most"));
    }
    // The model that is written is that of the surface, and says how large it is.
    let args = "streamline wave.streamline.json --swap 17x33 -o across";
    folder.ok(&format!("{args}.streamline.json"));
    folder.ok("streamline across.streamline.json -o again.obj");
    assert_eq!(folder.bytes("again.obj"), folder.bytes("across.obj"));
    let tangents = &folder.json("across.streamline.json")["tangents"];
    assert_eq!(tangents.as_array().unwrap().len(), 17);
    assert_eq!(tangents[0].as_array().unwrap().len(), 33);
    let run = folder.ok("streamline wave.streamline.json --swap 1000x7 -o a.obj");
    assert!(run.stderr.contains("50 × 7 tangents, for the refined surface has no more points"));
    for wrong in ["9", "1x9", "9x", "ax9"] {
        folder.fails(
            &format!("streamline wave.streamline.json --swap {wrong} -o a.obj"),
            2,
            "--swap",
        );
    }
}

/// The free-form surface of an OBJ file, evaluated by de Boor's algorithm, straight from its statements.
struct FreeForm {
    control: Vec<Vec3>,
    knots: [Vec<f64>; 2],
}

fn free_forms(text: &str) -> Vec<FreeForm> {
    let text = text.replace("\\\n", " ");
    let (mut vertices, mut surfaces) = (Vec::new(), Vec::new());
    let (mut control, mut knots) = (Vec::new(), [vec![], vec![]]);
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let numbers = |from: usize| -> Vec<f64> {
            words[from..].iter().map(|word| word.parse().unwrap()).collect()
        };
        match words[0] {
            "v" => vertices.push(Vec3::new(numbers(1)[0], numbers(1)[1], numbers(1)[2])),
            "cstype" => assert_eq!(line, "cstype bspline"),
            "deg" => assert_eq!(line, "deg 3 3"),
            "surf" => {
                assert_eq!(numbers(1)[..4], [0.0, 1.0, 0.0, 1.0]);
                control = numbers(5).iter().map(|&i| vertices[i as usize - 1]).collect();
            }
            "parm" => knots[usize::from(words[1] == "v")] = numbers(2),
            "end" => surfaces.push(FreeForm { control: control.clone(), knots: knots.clone() }),
            other => assert_eq!(other, "g"),
        }
    }
    surfaces
}

fn de_boor(control: &[Vec3], knots: &[f64], u: f64) -> Vec3 {
    assert_eq!(knots.len(), control.len() + 4);
    let span = (3..control.len()).rev().find(|&i| knots[i] <= u).unwrap();
    let mut d: Vec<Vec3> = control[span - 3..=span].to_vec();
    for level in 1..=3 {
        for j in (level..=3).rev() {
            let (from, to) = (knots[span - 3 + j], knots[span + 1 + j - level]);
            let a = (u - from) / (to - from);
            d[j] = (1.0 - a) * d[j - 1] + a * d[j];
        }
    }
    d[3]
}

impl FreeForm {
    fn at(&self, u: f64, v: f64) -> Vec3 {
        let columns = self.knots[0].len() - 4;
        let rows = self.control.chunks_exact(columns);
        let across: Vec<Vec3> = rows.map(|row| de_boor(row, &self.knots[0], u)).collect();
        de_boor(&across, &self.knots[1], v)
    }
}

#[test]
fn bspline_surfaces_are_within_the_tolerance() {
    let folder = Folder::new();
    fs::copy(data("streamline/bottle.streamline.json"), folder.path("b.streamline.json")).unwrap();
    folder.ok("streamline b.streamline.json -o fine.obj --depth 5");
    let fine = folder.mesh("fine.obj");
    let size = fairform::Bounds::of(fine.positions.iter().copied()).diagonal();
    let fine = fairform::Mesh::new(fine.positions, &fine.faces).unwrap();
    for tolerance in [1e-2, 1e-3, 1e-4] {
        let args = format!("streamline b.streamline.json --bspline {tolerance} -o s");
        let said = folder.ok(&format!("{args}.obj --json")).json();
        folder.ok(&format!("{args}.json"));
        let text = String::from_utf8(folder.bytes("s.obj")).unwrap();
        assert!(text.contains("\ng left\n") && text.contains("\ng right\n"));
        let surfaces = free_forms(&text);
        assert_eq!(surfaces.len(), 2);
        let result = folder.json("s.json");
        for (i, surface) in surfaces.iter().enumerate() {
            let places =
                (0..=30).flat_map(|i| (0..=30).map(move |k| [i, k].map(|x| f64::from(x) / 30.0)));
            let on: Vec<Vec3> = places.map(|[u, v]| surface.at(u, v)).collect();
            let off = fairform::fairness::deviation(&on, &fine).max;
            // Between the points to which it is fitted, and the mesh, it may be a little farther.
            assert!(off < 1.2 * tolerance * size, "{tolerance}: {off}");
            let deviation = result["patches"][i]["deviation"].as_f64().unwrap();
            assert!(deviation <= tolerance * size);
            assert_eq!(said["bspline"][i]["deviation"], deviation);
            let rows = result["patches"][i]["points"].as_array().unwrap();
            let control: Vec<Vec3> = rows.iter().flat_map(points).collect();
            assert_eq!(control, surface.control);
            for (k, name) in ["u", "v"].into_iter().enumerate() {
                assert_eq!(result["patches"][i]["knots"][name], json!(surface.knots[k]));
            }
            assert_eq!(result["patches"][i]["degree"], json!([3, 3]));
        }
    }
    // One surface by itself; and of exchanged directions.
    folder.ok("streamline --new wave -o wave.streamline.json");
    folder.ok("streamline wave.streamline.json --bspline 1e-3 -o w.json");
    assert!(folder.json("w.json")["points"][0][0][2].is_number());
    folder.ok("streamline wave.streamline.json --swap 9x9 --bspline 1e-3 -o w.obj");
    assert_eq!(free_forms(&String::from_utf8(folder.bytes("w.obj")).unwrap()).len(), 1);
    let names = folder.names();
    for (args, code, words) in [
        ("--bspline 1e-15 -o x.obj", 1, "not within 1e-15 of the diagonal: the nearest"),
        ("--bspline 0 -o x.obj", 2, "a positive number"),
        ("--bspline 1e-3 -o x.ply", 2, "a B-spline surface is written as OBJ or JSON"),
        ("--bspline 1e-3 -o x.streamline.json", 2, "not in .streamline.json"),
        ("--bspline 1e-3 --stats", 2, "--output"),
    ] {
        folder.fails(&format!("streamline wave.streamline.json {args}"), code, words);
    }
    assert_eq!(folder.names(), names);
}

/// The road from a streamline surface to a smooth one through its points.
#[test]
fn coarse_surfaces_can_be_fitted() {
    let folder = Folder::new();
    folder.ok("streamline --new car -o car.streamline.json");
    folder.ok("streamline car.streamline.json --depth 1 -o coarse.obj");
    folder.ok("fit coarse.obj --scheme catmull-clark -o smooth.ply");
    let (coarse, smooth) = (folder.mesh("coarse.obj"), folder.mesh("smooth.ply"));
    assert_eq!(smooth.faces.len(), 64 * coarse.faces.len());
}

#[test]
fn statistics_of_a_circle() {
    let folder = Folder::new();
    // Four turns of 10 degrees on a length of 4, on streamlines side by side.
    let row: Vec<[f64; 3]> = (0..5)
        .map(|i| (f64::from(i) * 10.0).to_radians())
        .map(|a| [a.cos(), a.sin(), 0.0])
        .collect();
    let model = json!({ "tangents": [row, row], "lengths": [4, 4], "t": [0, 1], "depth": 3,
        "initial": { "type": "polyline", "points": [[0, 0, 0], [0, 0, -1]], "t": [0, 1] } });
    folder.write("circle.json", &model.to_string());
    let stats = folder.ok("streamline circle.json --stats --json").json();
    let curvature = 10_f64.to_radians();
    let number = |path: &str| stats.pointer(path).unwrap().as_f64().unwrap();
    for (path, expected) in [
        ("/stats/streamlines", 9.0),
        ("/stats/tangents", 9.0 * 33.0),
        ("/stats/length/min", 4.0),
        ("/stats/length/max", 4.0),
        ("/stats/length_asked_for/max", 4.0),
        ("/stats/curvature/max", curvature),
        ("/stats/curvature/mean", curvature),
        ("/stats/variation_max", 0.0),
        ("/stats/bending_energy", 9.0 * 4.0 * curvature * curvature),
        ("/vertices", 9.0 * 34.0),
        ("/faces", 8.0 * 33.0),
    ] {
        assert!((number(path) - expected).abs() < 1e-11, "{path} is {}", number(path));
    }
    assert_eq!(stats["stats"]["warnings"], json!([]));
    let text = String::from_utf8(folder.ok("streamline circle.json --stats").stdout).unwrap();
    assert!(text.contains("curvature    at most 0.174533, 0.174533 on average"), "{text}");
    assert_eq!(folder.names(), ["circle.json"]);
}

#[test]
fn warnings_name_their_place() {
    let folder = Folder::new();
    let mut model = json!({ "tangents": [[[1, 0, 0], [-1, 0, 0]], [[0, 1, 0], [0, 1, 0]]],
        "lengths": [1, 1], "t": [0, 1], "w": 3, "depth": 1,
        "initial": { "type": "polyline", "points": [[0, 0, 0], [0, 0, 1]], "t": [0, 1] } });
    folder.write("m.json", &model.to_string());
    let run = folder.ok("streamline m.json -o m.obj");
    assert!(run.stderr.contains("warning: m.json: a tension w of 3 may not be smooth"));
    assert!(
        run.stderr.contains(
            "warning: m.json: the tangents in row 0, column 0 and row 0, column 1 are opposite"
        ),
        "{}",
        run.stderr
    );
    let stats = folder.ok("streamline m.json --stats --json").json();
    assert_eq!(stats["stats"]["warnings"].as_array().unwrap().len(), 2);
    assert_eq!(folder.ok("streamline m.json -o m.obj --quiet").stderr, "");
    model["tangents"] = json!([[[1, 0, 0], [0, 1, 0]]]);
    model["lengths"] = json!([1]);
    model["t"] = json!([0]);
    folder.write("m.json", &model.to_string());
    folder.fails(
        "streamline m.json -o m.obj",
        1,
        "m.json: tangents: the four-point rule needs at least 2",
    );
    let run = folder.ok("streamline m.json -o m.obj --depth 0");
    assert!(run.stderr.contains("warning: m.json: one streamline has no faces"), "{}", run.stderr);
    folder.write("c.json", r#"{"scheme": "four-point", "w": -1, "tangents": [[1,0,0],[-1,0,0]]}"#);
    let run = folder.ok("curve c.json -o c.out.json");
    assert!(
        run.stderr.contains("warning: c.json: tangents 0 and 1 are opposite"),
        "{}",
        run.stderr
    );
    assert!(run.stderr.contains("warning: c.json: a tension w of -1"), "{}", run.stderr);
}

#[test]
fn bad_models_are_named_and_nothing_is_written() {
    let folder = Folder::new();
    let (_, fixture) = fixtures("streamline", &["kobbelt-st"]).remove(0);
    let spec = &fixture["spec"];
    for (field, new, words) in [
        (
            "tangents",
            json!([[[1, 0, 0], [0, 0, 2]]]),
            "m.json: tangents[0][1]: a tangent of length 2; expected length 1, as [0, 0, 1] has",
        ),
        (
            "lengths",
            json!([1, 2]),
            "m.json: lengths: a list of 2; expected 4, one for each row of tangents",
        ),
        ("t", json!([0, 2, 1, 3]), "m.json: t[2]: not above the number before"),
        ("depth", json!("three"), "m.json: depth: \"three\"; expected a whole number from 0 to 32"),
        ("sheme", json!("kobbelt"), "m.json: sheme: unknown field; did you mean scheme?"),
        (
            "initial",
            json!({ "type": "line" }),
            "m.json: initial.type: \"line\"; expected \"polyline\", \"bspline\", \"nurbs\" or \"qi\"",
        ),
        (
            "depth",
            json!(32),
            "m.json: depth: 32 makes more than 67108864 points; use a smaller one",
        ),
        (
            "version",
            json!(3),
            "m.json: version: 3; expected 1, the version that this program knows",
        ),
    ] {
        let mut bad = spec.clone();
        bad[field] = new;
        folder.write("m.json", &bad.to_string());
        folder.write("out.ply", "old");
        folder.write("out.streamline.json", "old");
        for output in ["out.ply", "out.streamline.json"] {
            folder.fails(&format!("streamline m.json -o {output}"), 1, words);
            assert_eq!(folder.bytes(output), b"old");
        }
        assert_eq!(folder.names(), ["m.json", "out.ply", "out.streamline.json"]);
    }
    folder.write("m.json", "{\n  \"t\": [0, 1,\n}");
    folder.fails("streamline m.json -o a.ply", 1, "m.json: line 3, column 1: ");
    folder.fails("info m.json", 1, "m.json: line 3, column 1: ");
    folder.fails("curve m.json -o a.json", 1, "m.json: line 3, column 1: ");
    folder.fails("streamline none.json -o a.ply", 1, "none.json");
    folder.write(
        "curve.json",
        r#"{"scheme": "qi", "tangents": [[1,0,0]], "order": 1, "length": 1, "samples": 2}"#,
    );
    folder.fails("streamline curve.json -o a.ply", 1, "`fairform curve` takes curves");
    folder.write("m.json", &spec.to_string());
    folder.fails("curve m.json -o a.json", 1, "`fairform streamline` takes surfaces");
    folder.fails("streamline m.json -o none/a.ply", 1, "there is no folder none");
    for wrong in [
        "streamline",
        "streamline m.json",
        "streamline m.json -o a.nothing",
        "streamline m.json -o a",
        "streamline m.json -o a.ply --scheme loop",
        "streamline m.json -o a.ply --depth 33",
        "streamline m.json -o a.ply --depth -1",
        "streamline m.json -o a.ply --ends closed",
        "streamline m.json --new car -o a.ply",
        "streamline --new plane -o a.ply",
        "streamline m.json -o - --stats",
        "streamline m.json -o - --json",
        "curve m.json",
        "curve m.json -o a.ply",
        "curve curve.json -o a.json --depth 2",
        "info m.json --scheme loop",
    ] {
        let run = folder.run(wrong);
        assert_eq!(run.code, Some(2), "fairform {wrong}: {}", run.stderr);
    }
    assert_eq!(folder.names(), ["curve.json", "m.json", "out.ply", "out.streamline.json"]);
}

#[test]
fn standard_input_and_output() {
    let folder = Folder::new();
    folder.ok("streamline --new wave -o wave.json");
    folder.ok("streamline wave.json -o result.json");
    folder.ok("streamline wave.json -o mesh.ply");
    for (arguments, file) in
        [("streamline - -o -", "result.json"), ("streamline - -o - --to ply", "mesh.ply")]
    {
        let mut command = folder.command(arguments);
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(&folder.bytes("wave.json")).unwrap();
        assert_eq!(child.wait_with_output().unwrap().stdout, folder.bytes(file), "{arguments}");
    }
    assert_eq!(folder.ok("streamline --new wave -o -").stdout, folder.bytes("wave.json"));
    let result = folder.ok("streamline wave.json -o out.ply --json").json();
    assert_eq!(result, json!({ "vertices": 33 * 50, "faces": 32 * 49 }));
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let folder = Folder::new();
    for threads in [1, 3] {
        folder.ok(&format!("streamline --new car -o {threads}.ply --depth 5 --threads {threads}"));
    }
    assert!(folder.bytes("1.ply") == folder.bytes("3.ply"));
}

/// Commands for meshes say what to do with a model.
#[test]
fn a_model_is_no_mesh_but_can_become_one() {
    let folder = Folder::new();
    folder.ok("streamline --new wave -o wave.streamline.json");
    folder.fails(
        "fit wave.streamline.json -o x.ply",
        1,
        "fairform streamline wave.streamline.json",
    );
    folder.write("other.json", "{\"a\": 1}");
    folder.fails("fit other.json -o x.ply", 1, "unknown format");
    assert!(!folder.path("x.ply").exists());
}
