//! Streamline models.

use fairform::streamline::Surface;
use fairform::{Vec3, sphere};
use fairform_io::{Format, parse, streamline};
use fairform_wasm::{Colouring, ModelChange, StreamSession, edit, rotate, set_component};
use serde_json::Value;

use crate::common::{data, names, points};

fn open(name: &str) -> StreamSession {
    StreamSession::open(&data(&format!("streamline/{name}")), name).unwrap()
}

const MODELS: [&str; 6] = ["bottle", "car", "chair", "duct", "hull", "saddle"];

fn models() -> impl Iterator<Item = (String, StreamSession)> {
    MODELS.into_iter().map(|name| {
        let name = format!("{name}.streamline.json");
        let session = open(&name);
        (name, session)
    })
}

/// Points are those of the reference.
#[test]
fn points_are_those_of_the_reference() {
    let mut checked = 0;
    for name in names("golden/streamline") {
        let bytes = data(&format!("golden/streamline/{name}"));
        let fixture: Value = serde_json::from_slice(&bytes).unwrap();
        let session = StreamSession::open(&bytes, &name).unwrap();
        let patch = session.patch(0).unwrap();
        let expected = fixture["result"]["points"].as_array().unwrap();
        let expected: Vec<Vec3> = expected.iter().flat_map(points).collect();
        assert_eq!(patch.geometry.positions.len(), expected.len(), "{name}");
        for (p, q) in patch.geometry.positions.iter().zip(&expected) {
            let away = (Vec3::from(p.map(f64::from)) - *q).length();
            assert!(away < 1e-5, "{name}: {away:e}");
        }
        checked += 1;
    }
    assert!(checked > 10);
}

/// The same as opening the model with that tangent.
#[test]
fn a_set_tangent_is_a_model_with_it() {
    for (name, mut session) in models() {
        let tangent = Vec3::new(0.2, 0.3, 0.9);
        let patches = session.info().len();
        for patch in 0..patches {
            let answer = session.set_tangent(patch, 1, 1, tangent).unwrap();
            let text = session.text().unwrap();
            let anew = StreamSession::open(&text, &name).unwrap();
            for i in 0..patches {
                let (now, then) = (session.patch(i).unwrap(), anew.patch(i).unwrap());
                assert_eq!(now.geometry.positions, then.geometry.positions, "{name} {i}");
            }
            assert_eq!(answer.geometry, session.patch(patch).unwrap().geometry);
            let count = answer.geometry.positions.len();
            assert_eq!(count, answer.row_count * answer.column_count);
            assert_eq!(answer.fine_tangents.len(), count);
            assert_eq!(answer.feet.len(), answer.tangents.len());
            let info = &session.info()[patch];
            assert_eq!(answer.feet.len(), info.row_count * info.column_count);
            let unit = answer.tangents[info.column_count + 1];
            let unit = Vec3::from(unit.map(f64::from));
            assert!((unit - tangent.normalized()).length() < 1e-6 || patch > 0, "{name}");
        }
        assert!(session.set_tangent(0, 99, 0, tangent).is_err());
        assert!(session.set_tangent(99, 0, 0, tangent).unwrap_err().message.contains("patch 99"));
        assert!(session.set_tangent(0, 0, 0, Vec3::ZERO).is_err());
    }
}

#[test]
fn another_state_is_taken_over_whole_or_not_at_all() {
    let mut session = open("hull.streamline.json");
    let before = session.text().unwrap();
    let points = session.patch(0).unwrap();
    session.set_tangent(0, 1, 1, Vec3::new(0.0, 0.6, 0.8)).unwrap();
    session.set(&before).unwrap();
    assert_eq!(session.patch(0).unwrap(), points);
    let problem = session.set(br#"{"version": 1, "tangents": 7}"#).unwrap_err();
    assert!(problem.message.starts_with("tangents"), "{}", problem.message);
    assert_eq!(session.text().unwrap(), before);
}

#[test]
fn values_combs_and_arcs_fit_the_points() {
    for (name, session) in models() {
        let patch = session.patch(0).unwrap();
        let count = patch.geometry.positions.len();
        for colouring in [Colouring::Gaussian, Colouring::Mean, Colouring::MaxAbs] {
            let values = session.values(0, colouring).unwrap().values;
            assert!(values.len() == count && values.iter().all(|v| v.is_finite()), "{name}");
        }
        let problem = session.values(0, Colouring::Tension).unwrap_err();
        assert!(problem.help.is_some());
        let combs = session.combs(0, 2.0).unwrap();
        assert_eq!(combs.len(), count);
        assert!(combs.iter().zip(&patch.geometry.positions).all(|(c, p)| c[0] == *p));
        let info = &session.info()[0];
        let arcs = session.arcs(0, true, 5).unwrap();
        assert_eq!(arcs.len(), info.row_count * (info.column_count - 1) * 5);
        let across = session.arcs(0, false, 5).unwrap();
        assert_eq!(across.len(), info.column_count * (info.row_count - 1) * 5);
        assert_eq!(arcs[0], patch.tangents[0]);
        assert_eq!(arcs[4], patch.tangents[1]);
        let saved = parse(&session.save(Format::Ply).unwrap(), Format::Ply).unwrap();
        assert!(saved.faces.len() >= (patch.row_count - 1) * (patch.column_count - 1), "{name}");
    }
}

/// Streamlines of a circle of radius 2: the comb stands half as long as its scale.
#[test]
fn combs_of_a_circle() {
    let tangent = |i: i32| {
        let angle = f64::from(i) * std::f64::consts::FRAC_PI_8;
        format!("[{:?}, {:?}, 0]", angle.cos(), angle.sin())
    };
    let row: Vec<String> = (0..9).map(tangent).collect();
    let row = format!("[{}]", row.join(","));
    let length = 2.0 * std::f64::consts::PI;
    let text = format!(
        r#"{{"tangents": [{row}, {row}], "lengths": [{length:?}, {length:?}], "t": [0, 1],
        "scheme": "kobbelt", "depth": 3, "initial": {{"type": "polyline", "t": [0, 1],
        "points": [[0, 0, 0], [0, 0, 1]]}}}}"#
    );
    let session = StreamSession::open(text.as_bytes(), "circle.streamline.json").unwrap();
    for [foot, tip] in session.combs(0, 3.0).unwrap() {
        let comb = Vec3::from(tip.map(f64::from)) - Vec3::from(foot.map(f64::from));
        assert!((comb.length() - 1.5).abs() < 1e-4, "{comb:?}");
        // Away from the centre, which is at (0, 2, 0) above each foot.
        let outward = Vec3::new(f64::from(foot[0]), f64::from(foot[1]) - 2.0, 0.0);
        assert!(comb.dot(outward) > 0.0);
    }
}

#[test]
fn structure_is_changed() {
    for (name, session) in models() {
        let text = session.text().unwrap();
        let size = |text: &[u8]| {
            let models = streamline::parse(text).unwrap();
            let tangents = &models.patches[0].model.tangents;
            [tangents.row_count(), tangents.column_count()]
        };
        let [rows, columns] = size(&text);
        let at = |index| ModelChange::InsertRow { patch: 0, index };
        let more = edit(&text, &at(1)).unwrap();
        assert_eq!(size(&more), [rows + 1, columns], "{name}");
        let wider = edit(&more, &ModelChange::InsertColumn { patch: 0, index: 1 }).unwrap();
        assert_eq!(size(&wider), [rows + 1, columns + 1]);
        let narrow = edit(&wider, &ModelChange::DeleteColumn { patch: 0, index: 1 }).unwrap();
        let back = edit(&narrow, &ModelChange::DeleteRow { patch: 0, index: 1 }).unwrap();
        assert_eq!(size(&back), [rows, columns]);
        let [was, is] = [&text, &back].map(|text| streamline::parse(text).unwrap());
        assert_eq!(was.patches[0].model.tangents, is.patches[0].model.tangents, "{name}");
        assert!(edit(&text, &at(0)).is_err() && edit(&text, &at(rows)).is_err());
        let problem = edit(&text, &ModelChange::DeleteRow { patch: 9, index: 0 }).unwrap_err();
        assert!(problem.message.contains("no patch 9"));
    }
}

/// The surface of the mirror image is the mirror image of the surface.
#[test]
fn mirrored_models_have_mirrored_surfaces() {
    let n = Vec3::new(1.0, 2.0, -0.5).normalized();
    for (name, session) in models() {
        let text = session.text().unwrap();
        let change = ModelChange::Mirror { patch: 0, normal: (3.0 * n).into() };
        let mirrored = streamline::parse(&edit(&text, &change).unwrap()).unwrap();
        let given = streamline::parse(&text).unwrap();
        let surface = |m: &streamline::Models| Surface::new(m.patches[0].model.clone()).unwrap();
        let (a, b) = (surface(&given), surface(&mirrored));
        let size = fairform::Bounds::of(a.points().values().iter().copied()).diagonal();
        for (p, q) in a.points().values().iter().zip(b.points().values()) {
            let image = *p - 2.0 * p.dot(n) * n;
            assert!((image - *q).length() < 1e-12 * size, "{name}");
        }
    }
}

#[test]
fn directions_are_set_and_turned() {
    let t = Vec3::new(0.6, 0.8, 0.0);
    let set = set_component(t, 2, 0.5).unwrap();
    assert!((set.z - 0.5).abs() < 1e-15 && (set.y / set.x - 0.8 / 0.6).abs() < 1e-14);
    assert!((set.length() - 1.0).abs() < 1e-15);
    let along = set_component(Vec3::new(0.0, 0.0, 1.0), 2, 0.0).unwrap();
    assert!((along.length() - 1.0).abs() < 1e-15 && along.z == 0.0);
    assert_eq!(set_component(t, 0, 7.0).unwrap(), Vec3::new(1.0, 0.0, 0.0));
    let turned = rotate(Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 0.0, 5.0), 90.0).unwrap();
    assert!((turned - Vec3::new(0.0, 1.0, 0.0)).length() < 1e-15);
    assert!(sphere::angle(turned, t) > 0.0);
    assert!(rotate(t, Vec3::ZERO, 1.0).is_err() && set_component(Vec3::ZERO, 0, 0.0).is_err());
}
