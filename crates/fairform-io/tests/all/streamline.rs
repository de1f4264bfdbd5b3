//! Model files: reference values, every error by its field, and back to the same bits.

mod schema;

use std::fs;
use std::path::Path;

use fairform::Scheme;
use fairform::Vec3;
use fairform::sphere::{Blend, Ends, Knots, Rule};
use fairform::streamline::{
    self, Detail, Grid, InitialCurve, Integration, LengthFunction, Model, Order, Start, Surface,
};
use fairform_io::streamline::{Contents, Curve, Models, Patch, Stitch};
use fairform_io::{Error, Place, streamline as files};
use proptest::prelude::*;
use schema::Schema;
use serde_json::{Value, json};

fn golden(folder: &str) -> Vec<(String, Value)> {
    let folder = crate::common::data().join("golden").join(folder);
    let mut fixtures: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_str().unwrap().to_string();
            (name, serde_json::from_slice(&fs::read(path).unwrap()).unwrap())
        })
        .collect();
    fixtures.sort_by(|a, b| a.0.cmp(&b.0));
    fixtures
}

fn is_curve(name: &str) -> bool {
    name.starts_with("curve-") || name.starts_with("qi-")
}

fn text(models: &Models) -> String {
    let mut bytes = Vec::new();
    files::encode(models, &mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

fn curve_text(curve: &Curve) -> String {
    let mut bytes = Vec::new();
    files::encode_curve(curve, &mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

/// The specification of a reference value, the whole of it, and it written and read again are the
/// same model.
#[test]
fn reference_values_are_models() {
    let mut seen = 0;
    for (name, fixture) in golden("streamline") {
        let models = files::parse(fixture["spec"].to_string().as_bytes()).unwrap();
        assert_eq!(files::parse(fixture.to_string().as_bytes()).unwrap(), models, "{name}");
        let written = text(&models);
        assert_eq!(files::parse(written.as_bytes()).unwrap(), models, "{name}");
        assert_eq!(written.contains("\"lengths\""), !fixture["spec"]["lengths"].is_null());
        let surface = Surface::new(models.patches[0].model.clone()).unwrap();
        let expected = &fixture["result"]["points"];
        assert_eq!(surface.points().row_count(), expected.as_array().unwrap().len(), "{name}");
        for (k, row) in surface.points().rows().enumerate() {
            for (i, p) in row.iter().enumerate() {
                let e = [0, 1, 2].map(|c| expected[k][i][c].as_f64().unwrap());
                assert!((*p - Vec3::from(e)).length() < 1e-12, "{name}: point {k}, {i}");
            }
        }
        seen += 1;
    }
    for (name, fixture) in golden("sphere").into_iter().filter(|f| is_curve(&f.0)) {
        let curve = files::parse_curve(fixture["spec"].to_string().as_bytes()).unwrap();
        assert_eq!(files::parse_curve(fixture.to_string().as_bytes()).unwrap(), curve, "{name}");
        assert_eq!(files::parse_curve(curve_text(&curve).as_bytes()).unwrap(), curve, "{name}");
        seen += 1;
    }
    assert_eq!(seen, 13 + 21);
}

fn schema() -> Schema {
    let path = crate::common::data().join("../docs/streamline.schema.json");
    Schema(serde_json::from_slice(&fs::read(path).unwrap()).unwrap())
}

/// The fixtures and the examples are what the schema says; their refinements are not.
#[test]
fn reference_values_and_examples_fit_the_schema() {
    let schema = schema();
    let curves = golden("sphere").into_iter().filter(|f| is_curve(&f.0));
    for (name, fixture) in golden("streamline").into_iter().chain(curves) {
        assert!(schema.accepts(&fixture), "{name}");
        assert!(schema.accepts(&fixture["spec"]), "{name}");
        assert!(!schema.accepts(&fixture["result"]), "{name}");
    }
    let mut seen = 0;
    let all_fields = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/all-fields.streamline.json");
    let examples = fs::read_dir(crate::common::data().join("streamline")).unwrap();
    for path in examples.map(|file| file.unwrap().path()).chain([all_fields]) {
        if path.extension().is_none_or(|e| e != "json") {
            continue;
        }
        let bytes = fs::read(&path).unwrap();
        let models = files::parse(&bytes).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert!(schema.accepts(&serde_json::from_slice(&bytes).unwrap()), "{}", path.display());
        for model in models.stitched().unwrap() {
            Surface::new(model).unwrap();
        }
        seen += 1;
    }
    assert!(seen > 6);
    for value in [small(), small_curve(), small_qi(), json!({ "patches": [small(), small()] })] {
        assert!(schema.accepts(&value), "{value}");
    }
}

/// Schema and reader know the same fields, need the same ones, and take no other values for them.
#[test]
fn schema_and_reader_agree() {
    let schema = schema();
    let patches = json!({ "patches": [small()] });
    let refused = |value: &Value| {
        assert!(!schema.accepts(value), "the schema takes {value}");
        message(value)
    };
    for (definition, good, start) in [
        ("surface", small(), ""),
        ("patches", patches, ""),
        ("curve", small_curve(), ""),
        ("qiCurve", small_qi(), ""),
        ("initial/anyOf/0", small(), "initial."),
    ] {
        let rules = schema.0.pointer(&format!("/$defs/{definition}")).unwrap();
        let names: Vec<&String> = rules["properties"].as_object().unwrap().keys().collect();
        let unknown = refused(&with(good.clone(), &format!("{start}qqqqqq"), json!(1)));
        let (_, known) = unknown.split_once("; known are ").expect("a list of fields");
        let mut known: Vec<&str> = known.split(", ").collect();
        known.sort_unstable();
        assert_eq!(known, names, "{definition}");
        for name in names {
            // No field takes this.
            let found = refused(&with(good.clone(), &format!("{start}{name}"), json!([[true]])));
            assert!(found.starts_with(&format!("{start}{name}")), "{definition}: {found}");
        }
        for name in rules["required"].as_array().unwrap() {
            let name = name.as_str().unwrap();
            let found = refused(&with(good.clone(), &format!("{start}{name}"), Value::Null));
            // What has no scheme is taken for a surface.
            assert!(name == "scheme" || found.contains("no field"), "{name}: {found}");
        }
    }
    for (path, new) in [
        ("version", json!(2)),
        ("kind", json!("curve")),
        ("tangents", json!([])),
        ("tangents", json!([[[0, 0, 1.1]]])),
        ("tangents", json!([[[0, 1]]])),
        ("lengths", json!([1, 0, 1])),
        ("s", json!([[0, 1], [0, 1], [0, 1]])),
        ("scheme", json!("loop")),
        ("w", json!(-8)),
        ("depth", json!(33)),
        ("depth", json!(0.5)),
        ("s0", json!({ "fraction": "1" })),
        (
            "initial",
            json!({ "type": "nurbs", "points": [[0, 0, 0]], "degree": 1, "t0": 0, "t1": 1 }),
        ),
        (
            "initial",
            json!({ "type": "qi", "tangents": [[0, 0, 1]], "order": 0, "length": 1, "t0": 0, "t1": 1 }),
        ),
        ("length", json!({ "type": "bspline", "lengths": [1, -1], "degree": 1, "t0": 0, "t1": 2 })),
    ] {
        refused(&with(small(), path, new));
    }
    refused(&with(with(small_curve(), "closed", json!(true)), "s", json!([0, 1, 2])));
    refused(&with(small_qi(), "u", json!([0])));
}

/// A small model as JSON, with all that it must have.
fn small() -> Value {
    json!({
        "tangents": [[[0.8, 0, 0.6], [1, 0, 0]], [[0.6, 0, 0.8], [1, 0, 0]], [[0, 0, 1], [1, 0, 0]]],
        "lengths": [4, 5, 6],
        "t": [0, 1, 2],
        "initial": { "type": "polyline", "points": [[0, 0, 0], [0, 2, 0]], "t": [0, 2] },
    })
}

fn small_curve() -> Value {
    json!({ "scheme": "chaikin", "tangents": [[1, 0, 0], [0, 1, 0], [0, 0, 1]] })
}

fn small_qi() -> Value {
    json!({ "scheme": "qi", "tangents": [[1, 0, 0], [0, 1, 0]], "order": 2, "length": 2, "samples": 3 })
}

fn read(value: &Value) -> Model {
    files::parse(value.to_string().as_bytes()).unwrap().patches.remove(0).model
}

#[test]
fn what_is_left_out_is_as_documented() {
    let model = read(&small());
    assert_eq!(
        (model.scheme, model.order, model.ends),
        (Scheme::Kobbelt, Order::St, Ends::Natural)
    );
    assert_eq!((model.w, model.depth, model.start), (1.0, 3, Start::Min));
    assert_eq!((model.blend, model.integration), (Blend::Pairs, Integration::Midpoint));
    assert_eq!((model.length, model.details), (None, vec![]));
    assert_eq!(model.s.values(), [0.0, 4.0, 0.0, 5.0, 0.0, 6.0]);
    let Curve::Subdivided(curve) =
        files::parse_curve(small_curve().to_string().as_bytes()).unwrap()
    else {
        panic!("a QI curve")
    };
    assert_eq!((curve.depth, curve.ends, curve.s, curve.at), (3, Ends::Natural, None, Vec3::ZERO));
    let qi = files::parse_curve(small_qi().to_string().as_bytes()).unwrap();
    assert!(matches!(qi, Curve::Qi { knots: Knots::Clamped, u, .. } if u == [0.0, 0.5, 1.0]));
}

/// Sets a field, by a path such as `initial.points`.
fn with(mut value: Value, path: &str, new: Value) -> Value {
    let (folder, name) = path.rsplit_once('.').unwrap_or(("", path));
    let object = folder.split('.').filter(|f| !f.is_empty()).fold(&mut value, |v, f| &mut v[f]);
    match new {
        Value::Null => drop(object.as_object_mut().unwrap().remove(name)),
        new => object[name] = new,
    }
    value
}

fn message(value: &Value) -> String {
    let error = files::parse_any(value.to_string().as_bytes()).unwrap_err();
    assert_eq!(error.place, Place::File);
    error.to_string()
}

#[test]
#[expect(clippy::too_many_lines, reason = "one line for each way to be wrong")]
fn every_wrong_field_is_named() {
    let bspline = json!({ "type": "bspline", "points": [[0, 0, 0], [0, 1, 0], [0, 2, 0]], "degree": 2,
        "t0": 0, "t1": 2 });
    let nurbs = with(with(bspline.clone(), "type", json!("nurbs")), "weights", json!([1, 2, 1]));
    let qi = json!({ "type": "qi", "tangents": [[0, 1, 0], [0, 1, 1]], "order": 2, "length": 2,
        "t0": 0, "t1": 2 });
    let detail = json!({ "level": 1, "row": 0, "column": 0, "predicted": [1, 0, 0],
        "tangent": [0, 1, 0] });
    for (path, new, words) in [
        ("version", json!(2), "version: 2; expected 1, the version that this program knows"),
        ("version", json!("1"), "version: \"1\"; expected a number"),
        ("kind", json!("mesh"), "kind: \"mesh\"; expected \"surface\" or \"curve\""),
        ("name", json!(7), "name: 7; expected text"),
        ("display", json!([]), "display: a list of 0; expected an object"),
        ("tangets", json!([]), "tangets: unknown field; did you mean tangents?"),
        ("colour", json!([]), "colour: unknown field; known are version, kind, name, display, "),
        ("tangents", json!(null), "no field tangents"),
        ("tangents", json!(7), "tangents: 7; expected a list of streamlines, each a list"),
        ("tangents", json!([]), "tangents: an empty grid; expected one row of one at least"),
        ("tangents", json!([[]]), "tangents: an empty grid"),
        ("tangents", json!([7]), "tangents[0]: 7; expected a list of tangents [x, y, z]"),
        ("tangents", json!([[7]]), "tangents[0][0]: 7; expected three numbers, [x, y, z]"),
        ("tangents", json!([[[0, 1]]]), "tangents[0][0]: a list of 2; expected three numbers"),
        (
            "tangents",
            json!([[[1, 0, 0], [0, 0, "a"]]]),
            "tangents[0][1][2]: \"a\"; expected a number",
        ),
        (
            "tangents",
            json!([[[1, 0, 0]], [[1, 0, 0], [1, 0, 0]]]),
            "tangents[1]: a list of 2; expected 1, as",
        ),
        (
            "tangents",
            json!([[[1, 0, 0], [3, 0, 4]]]),
            "tangents[0][1]: a tangent of length 5; expected length 1, as [0.6, 0, 0.8] has",
        ),
        (
            "tangents",
            json!([[[1.000_002, 0, 0]]]),
            "tangents[0][0]: a tangent of length 1.000002; expected length 1, as [1, 0, 0] has",
        ),
        (
            "tangents",
            json!([[[0, 0, 0]]]),
            "tangents[0][0]: a tangent of length 0; expected a direction of length 1",
        ),
        ("lengths", json!(null), "no field s or lengths"),
        (
            "lengths",
            json!([1, 2]),
            "lengths: a list of 2; expected 3, one for each row of tangents",
        ),
        ("lengths", json!([1, 0, 2]), "lengths[1]: 0; expected a positive number"),
        (
            "s",
            json!([[0, 1], [0, 1], [0, 1]]),
            "lengths: is there beside s; expected only one of the two",
        ),
        ("t", json!(null), "no field t"),
        ("t", json!([0, 1]), "t: 2 numbers, one per row of tangents, not 3"),
        ("t", json!([0, 1, 1]), "t[2]: not above the number before"),
        ("t", json!([0, true, 2]), "t[1]: true; expected a number"),
        ("scheme", json!("loop"), "scheme: \"loop\"; expected \"doo-sabin\", \"catmull-clark\""),
        ("order", json!("tt"), "order: \"tt\"; expected \"st\" or \"ts\""),
        ("ends", json!("closed"), "ends: \"closed\"; expected \"natural\" or \"clamped\""),
        ("w", json!(-8), "w: -8; expected a tension above -8"),
        ("depth", json!(-1), "depth: -1; expected a whole number from 0 to 32"),
        ("depth", json!(33), "depth: 33; expected a whole number"),
        ("depth", json!(1.5), "depth: 1.5; expected a whole number"),
        (
            "s0",
            json!("middle"),
            "s0: \"middle\"; expected \"min\", \"max\", a number, or {\"fraction\": a",
        ),
        ("s0", json!({ "fractoin": 1 }), "s0.fractoin: unknown field; did you mean fraction?"),
        ("s0", json!({ "fraction": "1" }), "s0.fraction: \"1\"; expected a number"),
        ("s0", json!({}), "s0: no field fraction"),
        (
            "integration",
            json!("euler"),
            "integration: \"euler\"; expected \"midpoint\" or \"arcs\"",
        ),
        ("blend", json!(null), ""),
        ("blend", json!("sum"), "blend: \"sum\"; expected \"pairs\" or \"mean\""),
        (
            "length",
            json!({ "type": "qi" }),
            "length.type: \"qi\"; expected \"polyline\" or \"bspline\"",
        ),
        ("length", json!({}), "length: no field type; expected polyline or bspline"),
        (
            "length",
            json!({ "type": "polyline", "lengths": [1, 1], "t": [0, 1] }),
            "length.t: defined for t from 0 to 1, but the model needs t = 2",
        ),
        (
            "length",
            json!({ "type": "polyline", "lengths": [1], "t": [0, 2] }),
            "length.t: 2 numbers, one per length, not 1",
        ),
        (
            "length",
            json!({ "type": "polyline", "lengths": [1, -1], "t": [0, 2] }),
            "length.lengths[1]: -1; expected a positive number",
        ),
        (
            "length",
            json!({ "type": "bspline", "lengths": [1, 1], "degree": 2, "t0": 0, "t1": 2 }),
            "length.degree: must be from 1 to the number of points less one, not 2",
        ),
        (
            "details",
            json!([with(detail.clone(), "level", json!(0))]),
            "details[0].level: 0; expected a whole number from 1 to 32",
        ),
        (
            "details",
            json!([with(detail.clone(), "row", json!(-1))]),
            "details[0].row: -1; expected a whole number",
        ),
        (
            "details",
            json!([detail.clone(), with(detail.clone(), "tangent", json!([0, 2, 0]))]),
            "details[1].tangent: a tangent of length 2",
        ),
        ("details", json!([with(detail, "column", json!(null))]), "details[0]: no field column"),
        ("initial", json!(null), "no field initial"),
        ("initial", json!({}), "initial: no field type; expected polyline, bspline, nurbs or qi"),
        (
            "initial.type",
            json!("circle"),
            "initial.type: \"circle\"; expected \"polyline\", \"bspline\", \"nurbs\" or \"qi\"",
        ),
        ("initial.pionts", json!([]), "initial.pionts: unknown field; did you mean points?"),
        ("initial.degree", json!(2), "initial.degree: unknown field; known are type, points, t"),
        (
            "initial.points",
            json!([[0, 0]]),
            "initial.points[0]: a list of 2; expected three numbers",
        ),
        (
            "initial.t",
            json!([0, 1]),
            "initial.t: defined for t from 0 to 1, but the model needs t = 2",
        ),
        ("initial.t", json!([2, 0]), "initial.t: must be increasing, not 0"),
        (
            "initial",
            with(bspline.clone(), "degree", json!(3)),
            "initial.degree: must be from 1 to the number of points less one, not 3",
        ),
        (
            "initial",
            with(bspline.clone(), "degree", json!(65)),
            "initial.degree: 65; expected a whole number from 1 to 64",
        ),
        ("initial", with(bspline.clone(), "weights", json!([1])), "initial.weights: unknown field"),
        (
            "initial",
            with(bspline.clone(), "knots", json!([1])),
            "initial.knots: 1 numbers, as many as points, degree and one, not 6",
        ),
        (
            "initial",
            with(bspline, "t1", json!(0)),
            "initial.t1: must be finite and above the parameter at the beginning, not 0",
        ),
        ("initial", with(nurbs.clone(), "weights", json!(null)), "initial: no field weights"),
        (
            "initial",
            with(nurbs.clone(), "weights", json!([1, 0, 1])),
            "initial.weights[1]: 0; expected a positive number",
        ),
        (
            "initial",
            with(nurbs, "weights", json!([1])),
            "initial.weights: 1 numbers, one per point, not 3",
        ),
        (
            "initial",
            with(qi.clone(), "order", json!(3)),
            "initial: the order of a QI curve must be from 1 to the number of tangents, not 3",
        ),
        (
            "initial",
            with(qi.clone(), "tangents", json!([[0, 0, 0]])),
            "initial.tangents[0]: no direction, for it has no length",
        ),
        (
            "initial",
            with(qi.clone(), "length", json!(0)),
            "initial.length: 0; expected a positive number",
        ),
        (
            "initial",
            with(qi, "knots", json!("open")),
            "initial.knots: \"open\"; expected \"clamped\" or \"uniform\"",
        ),
    ] {
        let value = with(small(), path, new);
        if words.is_empty() {
            read(&value);
            continue;
        }
        let found = message(&value);
        assert!(found.starts_with(words), "{path}: {found}\nnot: {words}");
        // In a patch, the same behind its place.
        if path != "version" || found.contains("text") {
            let found = message(&json!({ "patches": [small(), value] }));
            let words = if words.starts_with("no field") {
                format!(": {words}")
            } else {
                format!(".{words}")
            };
            assert!(found.starts_with(&format!("patches[1]{words}")), "{found}\nnot: {words}");
        }
    }
    let s = json!([[0, 1], [0, 2], [3, 3]]);
    let value = with(with(small(), "lengths", json!(null)), "s", s);
    assert_eq!(message(&value), "s[2][1]: not above the number before");
    let value = with(value, "s", json!([[0, 1], [0, 2], [3]]));
    assert_eq!(message(&value), "s[2]: a list of 1; expected 2, one for each tangent of the row");
    assert!(message(&json!({ "patches": [] })).starts_with("patches: an empty list"));
    assert!(message(&json!({ "spec": 7 })).starts_with("spec: 7; expected an object"));
    assert!(message(&json!([])).starts_with("a list of 0; expected an object"));
}

#[test]
fn every_wrong_field_of_a_curve_is_named() {
    for (path, new, words) in [
        ("scheme", json!("four-pint"), "scheme: \"four-pint\"; expected \"doo-sabin\""),
        ("tangents", json!([[0, 0, 2]]), "tangents[0]: a tangent of length 2"),
        ("tangents", json!([]), "tangents: there are none"),
        ("s", json!([0, 1]), "s: 2 numbers, one per tangent, not 3"),
        ("s", json!([0, 1, 1]), "s[2]: not above the number before"),
        ("closed", json!("yes"), "closed: \"yes\"; expected true or false"),
        ("start", json!([0, 1]), "start: a list of 2; expected three numbers"),
        ("lengths", json!([1]), "lengths: unknown field"),
    ] {
        let found = message(&with(small_curve(), path, new));
        assert!(found.starts_with(words), "{path}: {found}");
    }
    let closed = with(with(small_curve(), "closed", json!(true)), "s", json!([0, 1, 2]));
    assert!(message(&closed).starts_with("s: has no meaning where the tangents are closed"));
    for (path, new, words) in [
        ("order", json!(3), "order: 3; expected at most 2, the number of tangents"),
        ("samples", json!(1), "samples: 1; expected a whole number from 2 to 1048576"),
        ("samples", json!(null), "no field samples or u"),
        ("u", json!([0]), "samples: is there beside u; expected only one of the two"),
        ("depth", json!(2), "depth: unknown field"),
    ] {
        let found = message(&with(small_qi(), path, new));
        assert!(found.starts_with(words), "{path}: {found}");
    }
    let u = with(with(small_qi(), "samples", json!(null)), "u", json!([0.5, 0.4]));
    assert!(message(&u).starts_with("u[1]: 0.4; expected numbers from 0 to 1, none below"));
}

#[test]
fn what_is_no_json_has_a_line_and_a_column() {
    for (text, line, column, words) in [
        ("{\n \"t\": [0, 1,, 2]\n}", 2, 13, "expected value"),
        ("{\"t\": [1e999]}", 1, 12, "number out of range"),
        ("{\"t\": 1,\n\"t\": 2}", 2, 7, "the field t is there twice"),
        ("{\"t\": nan}", 1, 8, "expected"),
        ("", 1, 0, "EOF"),
        ("{} {}", 1, 4, "trailing characters"),
    ] {
        let error = files::parse(text.as_bytes()).unwrap_err();
        assert_eq!(error.place, Place::Character { line, column }, "{text}: {error}");
        assert!(error.to_string().contains(words), "{text}: {error}");
        assert!(error.to_string().starts_with(&format!("line {line}, column {column}: ")));
    }
    let deep = "[".repeat(100_000);
    assert!(files::parse(deep.as_bytes()).is_err());
}

#[test]
fn a_curve_is_no_surface() {
    let error = files::parse(small_curve().to_string().as_bytes()).unwrap_err();
    assert!(error.to_string().contains("`fairform curve` takes curves"), "{error}");
    let error = files::parse_curve(small().to_string().as_bytes()).unwrap_err();
    assert!(error.to_string().contains("`fairform streamline` takes surfaces"), "{error}");
}

#[test]
fn several_patches_keep_their_names() {
    let one = with(small(), "name", json!("one"));
    let display = json!({ "view": "iso", "colours": [1, 2.5, null], "title": "two" });
    let two = with(with(small(), "display", display.clone()), "kind", json!("surface"));
    let file = json!({ "version": 1, "name": "both", "patches": [one, two] });
    let models = files::parse(file.to_string().as_bytes()).unwrap();
    assert_eq!(models.name.as_deref(), Some("both"));
    assert_eq!(models.patches[0].name.as_deref(), Some("one"));
    assert_eq!(models.patches[1].display, Some(display));
    assert_eq!(files::parse(text(&models).as_bytes()).unwrap(), models);
}

/// Stitching is the kernel's, patch by patch, and the file keeps what is designed.
#[test]
fn patches_are_stitched_as_the_file_says() {
    let tangents = json!([[[1, 0, 0], [0, 1, 0]], [[0, 1, 0], [1, 0, 0]], [[0, 0, 1], [1, 0, 0]]]);
    let other = with(with(small(), "tangents", tangents), "lengths", json!([6, 7, 8]));
    let list = json!([small(), other, small()]);
    for (word, stitch) in [
        (json!(false), Stitch::None),
        (json!(true), Stitch::Shared),
        (json!("smooth"), Stitch::Smooth),
    ] {
        let file = json!({ "patches": list, "stitch": word });
        assert!(schema().accepts(&file));
        let models = files::parse(file.to_string().as_bytes()).unwrap();
        assert_eq!(models.stitch, stitch);
        let given: Vec<Model> = models.patches.iter().map(|p| p.model.clone()).collect();
        let stitched = models.stitched().unwrap();
        assert_eq!(stitched[0], given[0]);
        for i in 1..3 {
            let mut expected = given[i].clone();
            if stitch != Stitch::None {
                let smooth = stitch == Stitch::Smooth;
                streamline::stitch(&stitched[i - 1], &mut expected, smooth).unwrap();
                assert_ne!(expected, given[i]);
            }
            assert_eq!(stitched[i], expected);
        }
        assert_eq!(files::parse(text(&models).as_bytes()).unwrap(), models);
    }
    for word in [json!("rough"), json!(1), json!(null)] {
        let file = json!({ "patches": [small()], "stitch": word });
        assert!(!schema().accepts(&file));
        let found = message(&file);
        assert!(found.starts_with(&format!("stitch: {word}; expected true, false or \"smooth\"")));
    }
    let natural = with(with(small(), "scheme", json!("doo-sabin")), "ends", json!("natural"));
    let file = json!({ "patches": [small(), natural, small()], "stitch": true });
    let mut models = files::parse(file.to_string().as_bytes()).unwrap();
    // The second takes over the scheme of the first, and with it can be stitched to.
    assert!(models.stitched().is_ok());
    models.patches.remove(0);
    let (index, error) = models.stitched().unwrap_err();
    assert!(matches!((index, error), (1, streamline::Error::NotKept { .. })));
}

#[test]
fn files_are_whole_and_may_be_packed() {
    let folder = tempfile::tempdir().unwrap();
    let models: Models = read(&small()).into();
    for name in ["a.streamline.json", "a.streamline.json.gz"] {
        let path = folder.path().join(name);
        files::write(&path, &models).unwrap();
        assert_eq!(files::read(&path).unwrap(), models);
        assert_eq!(files::read_any(&path).unwrap(), Contents::Surface(models.clone()));
    }
    let packed = fs::read(folder.path().join("a.streamline.json.gz")).unwrap();
    assert!(packed.starts_with(&[0x1f, 0x8b]));
    let mut bad = models;
    bad.patches[0].model.w = f64::NAN;
    let path = folder.path().join("a.streamline.json");
    let before = fs::read(&path).unwrap();
    assert!(matches!(files::write(&path, &bad), Err(Error::Unwritable(_))));
    assert_eq!(fs::read(&path).unwrap(), before);
    let error = files::read(Path::new("none.streamline.json")).unwrap_err();
    assert!(error.to_string().contains("none.streamline.json"), "{error}");
}

fn direction() -> impl Strategy<Value = Vec3> {
    [-1.0..1.0, -1.0..1.0, 0.1..1.0_f64].prop_map(|v| Vec3::from(v).normalized())
}

fn increasing(count: usize) -> impl Strategy<Value = Vec<f64>> {
    proptest::collection::vec(0.01..2.0_f64, count).prop_map(|steps| {
        let next = |sum: &mut f64, step: f64| {
            *sum += step;
            Some(*sum)
        };
        steps.into_iter().scan(-1.0, next).collect()
    })
}

fn initial(t0: f64, t1: f64) -> impl Strategy<Value = InitialCurve> {
    let points = || proptest::collection::vec(direction(), 4);
    let numbers = || proptest::option::of(proptest::collection::vec(0.1..2.0_f64, 4));
    prop_oneof![
        points().prop_map(move |points| InitialCurve::Polyline {
            points: points[..2].to_vec(),
            t: vec![t0, t1]
        }),
        (points(), numbers(), 1..=3_usize, any::<bool>()).prop_map(
            move |(points, weights, degree, knots)| {
                let knots = knots.then(|| (0..degree + 5).map(|i| i as f64 / 3.0).collect());
                InitialCurve::Bspline { points, weights, degree, knots, t0, t1 }
            }
        ),
        (points(), 1..=4_usize, any::<bool>(), 0.1..9.0_f64).prop_map(
            move |(tangents, order, uniform, length)| InitialCurve::Qi {
                start: tangents[1],
                tangents,
                order,
                knots: if uniform { Knots::Uniform } else { Knots::Clamped },
                length,
                t0,
                t1,
            }
        ),
    ]
}

prop_compose! {
    fn choices()(
        start in prop_oneof![
            Just(Start::Min), Just(Start::Max),
            (-1.0..2.0_f64).prop_map(Start::At), (-1.0..2.0_f64).prop_map(Start::Fraction),
        ],
        scheme in prop::sample::select(vec![Scheme::DooSabin, Scheme::CatmullClark, Scheme::Kobbelt]),
        flags in any::<[bool; 4]>(),
        w in -2.0..3.0_f64,
        depth in 0..=32_u32,
    ) -> (Start, Scheme, [bool; 4], f64, u32) {
        (start, scheme, flags, w, depth)
    }
}

fn model() -> impl Strategy<Value = Model> {
    let grid = (1..5_usize, 1..5_usize).prop_flat_map(|(rows, columns)| {
        let tangents = proptest::collection::vec(direction(), rows * columns);
        let s = proptest::collection::vec(increasing(columns), rows);
        let lengths = proptest::option::of(proptest::collection::vec(1e-3..1e3_f64, rows));
        (Just(columns), tangents, s, lengths, increasing(rows))
    });
    let parts = (grid, choices(), direction()).prop_flat_map(|(grid, choices, tangent)| {
        let t = &grid.4;
        let (t0, t1) = (t[0] - 0.1, t[t.len() - 1] + 0.1);
        (Just(grid), Just(choices), Just(tangent), initial(t0, t1))
    });
    parts.prop_map(|((columns, tangents, s, lengths, t), choices, tangent, initial)| {
        let (start, scheme, flags, w, depth) = choices;
        let s = match lengths {
            Some(lengths) => streamline::spaced(&lengths, columns),
            None => Grid::from_rows(s).unwrap(),
        };
        let [t0, t1] = initial.range();
        let length = flags[0].then(|| match depth % 2 {
            0 => LengthFunction::Polyline { lengths: vec![w.abs() + 0.1, 2.0], t: vec![t0, t1] },
            _ => LengthFunction::Bspline { lengths: vec![1.0, 2.0, 1.5], degree: 2, t0, t1 },
        });
        let detail = Detail { level: 1, row: 0, column: 0, predicted: tangent, tangent };
        Model {
            s,
            start,
            length,
            scheme,
            order: if flags[0] { Order::Ts } else { Order::St },
            ends: if flags[1] { Ends::Clamped } else { Ends::Natural },
            w,
            blend: if flags[2] { Blend::Mean } else { Blend::Pairs },
            integration: if flags[3] { Integration::Arcs } else { Integration::Midpoint },
            details: if flags[1] { vec![detail] } else { vec![] },
            depth,
            ..Model::new(Grid::from_values(columns, tangents).unwrap(), &[], t, initial)
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn models_come_back_to_the_bit(
        models in proptest::collection::vec(model(), 1..3),
        stitch in prop::sample::select(vec![Stitch::None, Stitch::Shared, Stitch::Smooth]),
    ) {
        let patches: Vec<Patch> = models.into_iter().map(Patch::from).collect();
        let models = Models { patches, stitch, ..Models::default() };
        let written = text(&models);
        let again = files::parse(written.as_bytes()).map_err(|e| {
            TestCaseError::fail(format!("{e} in {written}"))
        })?;
        prop_assert_eq!(&again, &models);
        prop_assert!(schema().accepts(&serde_json::from_str(&written).unwrap()));
        prop_assert_eq!(text(&again), written);
    }

    #[test]
    fn curves_come_back_to_the_bit(
        tangents in proptest::collection::vec(direction(), 3..6),
        s in increasing(8),
        (start, _, flags, w, depth) in choices(),
    ) {
        let rule = [Rule::Chaikin, Rule::Cubic, Rule::FourPoint { w }][depth as usize % 3];
        let ends = [Ends::Natural, Ends::Clamped, Ends::Closed][depth as usize / 3 % 3];
        let curve = Curve::Subdivided(streamline::Curve {
            s: (flags[0] && ends != Ends::Closed).then(|| s[..tangents.len()].to_vec()),
            at: tangents[1],
            tangents,
            rule,
            ends,
            blend: if flags[2] { Blend::Mean } else { Blend::Pairs },
            start,
            integration: if flags[3] { Integration::Arcs } else { Integration::Midpoint },
            depth,
        });
        let written = curve_text(&curve);
        prop_assert!(schema().accepts(&serde_json::from_str(&written).unwrap()));
        prop_assert_eq!(files::parse_curve(written.as_bytes()).unwrap(), curve);
    }
}

/// Schemes that know no tangents have no place in a file.
#[test]
fn what_cannot_be_read_is_not_written() {
    let bad = |change: fn(&mut Model)| {
        let mut model = read(&small());
        change(&mut model);
        files::encode(&model.into(), &mut Vec::new()).is_err()
    };
    assert!(bad(|m| m.scheme = Scheme::Loop));
    assert!(bad(|m| m.ends = Ends::Closed));
    assert!(bad(|m| m.t[0] = f64::INFINITY));
    assert!(bad(|m| m.start = Start::At(f64::NAN)));
    assert!(files::encode(&Models::default(), &mut Vec::new()).is_err());
}
