//! Directions: blends, combinations, sequences, QI curves and meshes of tangents.

mod common;

use common::{assert_near, faces, golden, golden_names, number, points};
use fairform::sphere::{
    self, Blend, Ends, Error, Knots, MeshOptions, QiCurve, Rule, Step, blend, combine, midpoint,
};
use fairform::{Corners, Scheme, Topology, Vec3};
use proptest::prelude::*;
use serde_json::Value;

const TOLERANCE: f64 = 1e-12;

fn vector(value: &Value) -> Vec3 {
    Vec3::new(number(&value[0]), number(&value[1]), number(&value[2]))
}

fn cases(name: &str) -> Vec<Value> {
    golden(name)["cases"].as_array().expect("cases").clone()
}

#[test]
fn blends_are_the_reference_values() {
    for case in cases("sphere/blend") {
        let (t0, t1, u) = (vector(&case["t0"]), vector(&case["t1"]), number(&case["u"]));
        let expected = vector(&case["result"]);
        assert_near(&[blend(t0, t1, u)], &[expected], TOLERANCE, &format!("{case}"));
        assert_near(&[blend(t1, t0, 1.0 - u)], &[expected], TOLERANCE, "commuted");
    }
}

#[test]
fn combinations_are_the_reference_values() {
    for case in cases("sphere/combine") {
        let coefficients: Vec<f64> =
            case["coefficients"].as_array().unwrap().iter().map(number).collect();
        let tangents = points(&case["tangents"]);
        let made = combine(&coefficients, &tangents).unwrap();
        assert_near(&[made], &[vector(&case["result"])], TOLERANCE, &format!("{case}"));
    }
}

fn rule(spec: &Value) -> Rule {
    match spec["scheme"].as_str().unwrap() {
        "chaikin" => Rule::Chaikin,
        "cubic" => Rule::Cubic,
        "four-point" => Rule::FourPoint { w: spec["w"].as_f64().unwrap_or(1.0) },
        other => panic!("no rule {other}"),
    }
}

#[test]
fn refined_sequences_are_the_reference_values() {
    let mut seen = 0;
    for name in golden_names("sphere").iter().filter(|n| n.contains("curve-")) {
        let fixture = golden(name);
        let (spec, result) = (&fixture["spec"], &fixture["result"]);
        let ends = match spec["ends"].as_str() {
            _ if spec["closed"] == true => Ends::Closed,
            Some("clamped") => Ends::Clamped,
            _ => Ends::Natural,
        };
        let mut tangents = points(&spec["tangents"]);
        let mut s: Vec<f64> = spec["s"].as_array().into_iter().flatten().map(number).collect();
        for _ in 0..spec["depth"].as_u64().unwrap() {
            let step = Step::new(rule(spec), ends, tangents.len()).unwrap();
            if !s.is_empty() {
                s = step.numbers(&s);
            }
            tangents = step.directions(&tangents);
        }
        assert_near(&tangents, &points(&result["tangents"]), TOLERANCE, name);
        for (a, b) in s.iter().zip(result["s"].as_array().into_iter().flatten().map(number)) {
            assert!((a - b).abs() <= TOLERANCE, "{name}: s is {a}, not {b}");
        }
        seen += 1;
    }
    assert_eq!(seen, 16);
}

#[test]
fn qi_curves_are_the_reference_values() {
    let mut seen = 0;
    for name in golden_names("sphere").iter().filter(|n| n.contains("qi-")) {
        let fixture = golden(name);
        let (spec, result) = (&fixture["spec"], &fixture["result"]);
        let knots = if spec["knots"] == "uniform" { Knots::Uniform } else { Knots::Clamped };
        let order = spec["order"].as_u64().unwrap() as usize;
        let curve = QiCurve::new(&points(&spec["tangents"]), order, knots).unwrap();
        let start = if spec["start"].is_null() { Vec3::ZERO } else { vector(&spec["start"]) };
        let u: Vec<f64> = result["u"].as_array().unwrap().iter().map(number).collect();
        let (made, tangents) = curve.points(number(&spec["length"]), start, &u).unwrap();
        assert_near(&tangents, &points(&result["tangents"]), TOLERANCE, name);
        assert_near(&made, &points(&result["points"]), TOLERANCE, name);
        seen += 1;
    }
    assert_eq!(seen, 5);
}

#[test]
fn tangents_on_meshes_are_the_reference_values() {
    for name in golden_names("sphere-mesh") {
        let fixture = golden(&name);
        let scheme: Scheme = fixture["scheme"].as_str().unwrap().parse().unwrap();
        let mut options = MeshOptions::from(scheme);
        if fixture["options"]["corners"] == "sharp" {
            options.rules.corners = Corners::Sharp;
        }
        let mut tangents = points(&fixture["tangents"]);
        let mut topology = Topology::from_faces(tangents.len(), &faces(&fixture["faces"])).unwrap();
        let pairs = |value: &Value| -> Vec<[f64; 2]> {
            let list = value.as_array().into_iter().flatten();
            list.map(|p| [number(&p[0]), number(&p[1])]).collect()
        };
        let mut parameters = pairs(&fixture["params"]);
        for _ in 0..fixture["levels"].as_u64().unwrap() {
            let (refined, finer) = sphere::refine_tangents(&topology, &tangents, &options).unwrap();
            if !parameters.is_empty() {
                parameters = sphere::refine_parameters(&refined, &parameters);
            }
            tangents = finer;
            topology = refined.topology;
        }
        let result = &fixture["result"];
        assert_eq!(topology.to_faces(), faces(&result["faces"]), "{name}");
        assert_near(&tangents, &points(&result["tangents"]), TOLERANCE, &name);
        for (a, b) in parameters.iter().zip(pairs(&result["params"])) {
            assert!((a[0] - b[0]).abs() + (a[1] - b[1]).abs() < TOLERANCE, "{name}: {a:?} {b:?}");
        }
    }
}
