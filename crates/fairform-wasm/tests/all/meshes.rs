//! From bytes to surfaces.

use std::ops::ControlFlow;

use fairform::interpolate::Method;
use fairform::{Corners, Scheme, Vec3, shapes};
use fairform_io::project::{Design, Fineness};
use fairform_io::{Format, parse};
use fairform_wasm::{Colouring, MeshSession, Query, What};
use serde_json::Value;

use crate::common::{data, distance, fit, names, obj, open, points, saved};

/// The fixtures of a scheme that say something about interpolation, opened; with the design for them.
fn fixtures(scheme: Scheme) -> Vec<(String, Value, MeshSession, Design)> {
    let mut all = Vec::new();
    for name in names(&format!("golden/{scheme}")) {
        let fixture: Value =
            serde_json::from_slice(&data(&format!("golden/{scheme}/{name}"))).unwrap();
        let expected = &fixture["interpolation"];
        if expected.is_null() || fixture["boundary"] == "drop" || !fixture["lambda"].is_null() {
            continue;
        }
        let face = |f: &Value| -> Vec<u32> {
            f.as_array().unwrap().iter().map(|v| v.as_u64().unwrap() as u32).collect()
        };
        let faces = fixture["mesh"]["faces"].as_array().unwrap().iter().map(face).collect();
        let bytes = obj(points(&fixture["mesh"]["vertices"]), faces);
        let session = MeshSession::open::<&str>(&bytes, "fixture.obj", &[]).unwrap();
        let corners = match fixture["corners"].as_str() {
            Some("sharp") => Corners::Sharp,
            _ => Corners::Smooth,
        };
        let design = Design { scheme, corners, method: Method::Plain, ..Design::default() };
        all.push((name, fixture, session, design));
    }
    all
}

const SCHEMES: [Scheme; 3] = [Scheme::Loop, Scheme::CatmullClark, Scheme::DooSabin];

/// Control points, histories and every iterate are those of the reference.
#[test]
fn fits_are_those_of_the_reference() {
    let mut checked = [0; 2];
    for (name, fixture, mut session, design) in SCHEMES.into_iter().flat_map(fixtures) {
        let expected = &fixture["interpolation"];
        let target = points(&fixture["mesh"]["vertices"]);
        let unit = expected["scales"]["diagonal"].as_f64().unwrap();
        let stages: Vec<&Value> = expected["stages"].as_array().unwrap().iter().collect();
        let stages: Vec<_> = stages.into_iter().filter(|s| s["name"] != "corner").collect();
        // So small that it is not met, so that exactly as many updates are made.
        let design = Design { tolerance: 1e-300, iterations: 20, ..design };
        let result = fit(&mut session, &design);
        if result.control_level == 0 && !stages.is_empty() {
            let histories = stages.iter().map(|s| s["history"].as_array().unwrap());
            let steps: Vec<&Value> = histories.flatten().collect();
            assert_eq!(result.history.len(), steps.len(), "{name}");
            for (step, expected) in result.history.iter().zip(&steps) {
                let max = expected[1].as_f64().unwrap();
                assert!((step.max * unit - max).abs() < 1e-12, "{name}: {step:?}");
            }
            if let [_] = stages[..] {
                for (k, control) in expected["iterates"].as_object().unwrap() {
                    session.surface(Fineness { levels: 1, limit: true }, None).unwrap();
                    let k: u32 = k.parse().unwrap();
                    let drawn = session.control(Some(k)).unwrap().positions;
                    let difference = drawn
                        .iter()
                        .zip(points(control))
                        .map(|(p, q)| (Vec3::from(p.map(f64::from)) - q).length());
                    let largest = difference.fold(0.0, f64::max);
                    // In single precision.
                    assert!(largest < 1e-6 * unit, "{name} after {k}: {largest:e}");
                    checked[0] += 1;
                }
            }
        }
        if expected["exact"].is_null() {
            continue;
        }
        let design = Design { tolerance: 1e-14, iterations: 10_000, ..design };
        let result = fit(&mut session, &design);
        if result.control_level == 0 {
            let control = saved(&session, What::Control).positions;
            assert_eq!(control.len(), target.len());
            let error = distance(&control, &points(&expected["exact"]));
            assert!(error < 2e-12 * unit, "{name}: {error:e}");
            checked[1] += 1;
        }
    }
    assert!(checked[0] > 20 && checked[1] > 10, "{checked:?}");
}

/// The iterates of a fit begin with the mesh and end with the control mesh, through all stages.
#[test]
fn iterates_lead_from_the_mesh_to_the_control_mesh() {
    let sheet = shapes::sheet(6, 7, |x, y| 0.3 * x * y - y);
    let mut session = open(&sheet);
    for (exact, method) in
        [(false, Method::Auto), (false, Method::ConjugateGradients), (true, Method::Plain)]
    {
        let result = fit(&mut session, &Design { exact, method, ..Design::default() });
        let last = result.history.last().unwrap().iteration;
        let order: Vec<u32> = result.history.iter().map(|p| p.iteration).collect();
        assert!(order.is_sorted() && last > 3, "{order:?}");
        let first = session.control(Some(0)).unwrap();
        assert_eq!(first.positions, session.given().geometry.positions);
        let end = session.control(Some(last)).unwrap();
        assert_eq!(end.positions, session.control(None).unwrap().positions);
        if !exact {
            // The last but one is nearly there.
            let before = session.control(Some(last - 1)).unwrap();
            let step = before.positions.as_flattened().iter().zip(end.positions.as_flattened());
            assert!(step.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) < 1e-4);
        }
    }
}

/// Drawn points lie on the vertices at once, and normals have length one.
#[test]
fn surfaces_pass_through_the_vertices() {
    let torus = shapes::torus(9, 12);
    for scheme in Scheme::ALL.iter().copied().filter(|s| *s != Scheme::Kobbelt) {
        for (exact, levels) in [(false, 0), (false, 2), (true, 1), (true, 3)] {
            let mut session = open(&torus);
            let design = Design { scheme, exact, tolerance: 1e-9, ..Design::default() };
            let result = fit(&mut session, &design);
            assert!(result.converged, "{scheme}");
            let drawn = session.surface(Fineness { levels, limit: true }, None).unwrap();
            assert_eq!(drawn.positions.len(), drawn.normals.len());
            for n in &drawn.normals {
                let length = n.iter().map(|x| x * x).sum::<f32>().sqrt();
                assert!((length - 1.0).abs() < 1e-5, "{scheme} {levels}: {n:?}");
            }
            let faces = torus.topology().face_count();
            assert_eq!(drawn.triangles.len(), drawn.face_of_triangle.len());
            let mut seen = vec![false; faces];
            drawn.face_of_triangle.iter().for_each(|&f| seen[f as usize] = true);
            assert!(seen.iter().all(|s| *s), "{scheme} {levels}: every face has a surface");
            // Loop and Catmull–Clark keep the vertices as the first points.
            if matches!(scheme, Scheme::Loop | Scheme::CatmullClark | Scheme::Butterfly) {
                let vertices = drawn.positions.iter().zip(torus.positions());
                let away = vertices.map(|(p, q)| (Vec3::from(p.map(f64::from)) - *q).length());
                let away = away.fold(0.0, f64::max);
                assert!(away < 1e-6, "{scheme} {levels} {exact}: {away:e}");
            }
            // A closed surface: Euler's number of the torus is 0.
            let saved = saved(&session, What::Surface);
            let edges = drawn.edges.len();
            assert_eq!(saved.positions.len() + saved.faces.len(), edges, "{scheme} {levels}");
            for colouring in ["gaussian", "mean", "max-abs", "error", "tension", "deviation"] {
                let colouring: Colouring = colouring.parse().unwrap();
                let values = session.values(colouring).unwrap();
                assert_eq!(values.values.len(), drawn.positions.len(), "{colouring:?}");
                assert!(values.low <= values.high && values.values.iter().all(|v| v.is_finite()));
            }
        }
    }
}

/// The values of a sphere are known.
#[test]
fn curvatures_of_a_sphere() {
    let sphere = shapes::icosahedron();
    let mut session = open(&sphere);
    fit(&mut session, &Design::default());
    session.surface(Fineness { levels: 4, limit: true }, None).unwrap();
    let radius = sphere.positions()[0].length();
    let mean = session.values(Colouring::Mean).unwrap();
    let average = mean.values.iter().map(|v| f64::from(*v)).sum::<f64>() / mean.values.len() as f64;
    assert!((average * radius - 1.0).abs() < 0.03, "{average}");
    assert_eq!(mean.low, -mean.high);
    let error = session.values(Colouring::Error).unwrap();
    assert!(error.values.iter().all(|e| *e <= 1e-6));
    // Before the first update the surface is that of the mesh itself.
    session.surface(Fineness { levels: 4, limit: true }, Some(0)).unwrap();
    let before = session.values(Colouring::Error).unwrap();
    assert!(before.values.iter().all(|e| *e > 0.05), "{before:?}");
}

#[test]
fn shape_parameters_creases_and_moves_count() {
    let cube = shapes::cube();
    let mut session = open(&cube);
    let design = Design {
        scheme: Scheme::CatmullClark,
        exact: true,
        tension: Some(0.6),
        tensions: vec![(2, 0.9)],
        creases: vec![(0, 1, -1.0)],
        moves: vec![(3, 2.0, 2.0, 2.0)],
        ..Design::default()
    };
    let ends = session.given().geometry.edges[0];
    let design = Design { creases: vec![(ends[0], ends[1], -1.0)], ..design };
    let result = fit(&mut session, &design);
    assert!(result.max < 1e-14, "{result:?}");
    assert_eq!(session.given().geometry.positions[3], [2.0; 3]);
    session.surface(Fineness { levels: 2, limit: true }, None).unwrap();
    let tension = session.values(Colouring::Tension).unwrap();
    assert!(tension.low >= 0.6 - 1e-12 && tension.high > 0.65 && tension.high <= 0.9);

    let bad = |design: &Design| {
        let mut session = open(&cube);
        session.fit(design, &mut |_| ControlFlow::Continue(())).unwrap_err()
    };
    let base = Design { scheme: Scheme::CatmullClark, ..Design::default() };
    let problem = bad(&Design { moves: vec![(8, 0.0, 0.0, 0.0)], ..base.clone() });
    assert!(problem.message.contains("vertex 8") && problem.message.contains("8 vertices"));
    let problem = bad(&Design { tensions: vec![(6, 0.7)], ..base.clone() });
    assert!(problem.message.contains("no face 6"), "{}", problem.message);
    let problem = bad(&Design { creases: vec![(0, 0, 1.0)], ..base.clone() });
    assert!(problem.message.contains("no edge between vertices 0 and 0"), "{}", problem.message);
    let problem = bad(&Design { tension: Some(0.2), ..base.clone() });
    assert!(problem.message.contains("0.2"), "{}", problem.message);
    let problem = bad(&Design::default());
    assert!(problem.message.contains("needs triangles"), "{}", problem.message);
    assert!(problem.help.unwrap().contains("Catmull–Clark"));
}

#[test]
fn a_fit_can_be_broken_off() {
    let mut session = open(&shapes::torus(9, 12));
    let mut seen = 0;
    let problem = session.fit(&Design::default(), &mut |_| {
        seen += 1;
        if seen == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert!(problem.unwrap_err().cancelled && seen == 3);
    let problem = session.control(None).unwrap_err();
    assert!(!problem.cancelled && problem.help.is_some());
}

/// What is advised for a bad mesh makes it usable; bytes that are no mesh say where.
#[test]
fn advised_repairs_work() {
    let (mut repaired, mut refused) = (0, 0);
    for folder in ["meshes/bad", "meshes/bad_real"] {
        for name in names(folder) {
            let bytes = data(&format!("{folder}/{name}"));
            let Err(problem) = MeshSession::open::<&str>(&bytes, &name, &[]) else { continue };
            assert!(problem.message.starts_with(&name), "{}", problem.message);
            if problem.repairs.is_empty() {
                refused += 1;
                continue;
            }
            let steps: Vec<&str> = problem.repairs.iter().map(|r| r.step.as_str()).collect();
            let session = MeshSession::open(&bytes, &name, &steps)
                .unwrap_or_else(|e| panic!("{name} {steps:?}: {}", e.message));
            assert!(session.info().face_count > 0);
            assert!(problem.repairs.iter().all(|r| !r.says.is_empty()));
            repaired += 1;
        }
    }
    assert!(repaired > 10 && refused > 30, "{repaired} {refused}");
    let problem = MeshSession::open::<&str>(b"", "mesh.step", &[]).unwrap_err();
    assert!(problem.help.unwrap().contains(".obj"));
    let problem = MeshSession::open(b"v 0 0 0", "mesh.obj", &["glue"]).unwrap_err();
    assert!(problem.message.contains("glue"), "{}", problem.message);
}

#[test]
fn faces_are_asked_about() {
    let bytes =
        b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nv 5 5 5\nv 6 5 5\nv 5 6 5\n\
        g lid\nf 1 2 3 4\ng rim\nf 2 5 6 3\nf 7 8 9\n";
    let session = MeshSession::open::<&str>(bytes, "three.obj", &[]).unwrap();
    let info = session.info();
    assert_eq!((info.face_count, info.component_count, info.boundary_loop_count), (3, 2, 2));
    assert_eq!((info.most_corners, info.least_corners, info.scheme), (4, 3, "catmull-clark"));
    let lid = &info.groups[0];
    assert_eq!((lid.kind, lid.name.as_str(), lid.face_count), ("group", "lid", 1));
    let ask = |selected: [u8; 3], query: Query| session.query(&selected, &query).unwrap();
    let text = |text: &str| Query::Expression { text: text.into() };
    assert_eq!(ask([0; 3], text("group=rim and x<3")), [0, 1, 0]);
    assert_eq!(ask([1, 0, 0], Query::Grow), [1, 1, 0]);
    assert_eq!(ask([1, 0, 0], Query::Shrink), [0, 0, 0]);
    assert_eq!(ask([1, 0, 0], Query::Invert), [0, 1, 1]);
    assert_eq!(ask([1, 0, 0], Query::Connected), [1, 1, 0]);
    let problem = session.query(&[0; 3], &text("group=top")).unwrap_err();
    assert!(problem.message.contains("top"), "{}", problem.message);
    assert!(session.query(&[0; 2], &Query::Grow).is_err());

    let design = Design { tensions: vec![(2, 0.7)], ..Design::default() };
    let set = |rings| session.spread_tension(&design, &[1, 0, 0], 0.9, rings).unwrap();
    assert_eq!(set(0.0), [(0, 0.9), (2, 0.7)]);
    let faded = set(2.0);
    assert_eq!((faded[0], faded[2]), ((0, 0.9), (2, 0.7)));
    assert!(faded[1].1 > 0.5 && faded[1].1 < 0.9, "{faded:?}");
}

/// Every format that is saved opens again, and has the same surface.
#[test]
fn what_is_saved_opens_again() {
    let mut session = open(&shapes::tube(4, 7));
    fit(&mut session, &Design::default());
    session.surface(Fineness { levels: 2, limit: true }, None).unwrap();
    for format in Format::ALL {
        for what in [What::Given, What::Control, What::Surface] {
            let bytes = session.save(what, format).unwrap();
            let data = parse(&bytes, format).unwrap();
            let expected = saved(&session, what);
            assert_eq!(data.faces.len(), expected.faces.len(), "{format} {what:?}");
        }
    }
}

/// Colours and texture coordinates are met at the vertices, labels are those of the faces.
#[test]
fn attributes_travel_along() {
    let text = b"mtllib c.mtl\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0.3 0 0 1\nv 0 1 0 1 1 0\n\
        v 2 0 0 0 1 1\nv 2 1 0 1 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\ng lid\nusemtl red\n\
        f 1/1 2/2 3/3 4/4\ng rim\nf 2/1 5/2 6/3 3/4\n";
    let given = parse(text, Format::Obj).unwrap();
    for exact in [false, true] {
        let mut session = MeshSession::open::<&str>(text, "two.obj", &[]).unwrap();
        let scheme = Scheme::CatmullClark;
        fit(&mut session, &Design { scheme, exact, tolerance: 1e-9, ..Design::default() });
        for levels in [1, 2] {
            session.surface(Fineness { levels, limit: true }, None).unwrap();
            let surface = saved(&session, What::Surface);
            let colours = surface.colours.unwrap();
            for (a, b) in colours.iter().zip(given.colours.as_ref().unwrap()) {
                assert!(a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-8), "{a:?} {b:?}");
            }
            let groups = surface.groups.unwrap();
            let names = groups.of_face.iter().map(|&i| groups.names[i as usize].as_str());
            let each = 4_usize.pow(levels);
            assert_eq!(names.filter(|name| *name == "rim").count(), each);
            assert_eq!(surface.corner_uvs.unwrap().len(), 2 * each * 4);
            assert_eq!(surface.material_library.as_deref(), Some("c.mtl"));
        }
        let control = saved(&session, What::Control);
        assert_eq!(control.colours.unwrap().len(), control.positions.len());
        assert_eq!(control.corner_uvs.unwrap().len(), control.faces.corners().len());
    }
}
