//! Everything the reference values of `data/golden` say about meshes.

use std::ops::ControlFlow;

use crate::common::{assert_near, faces, golden, golden_names, mesh, number, points};
use fairform::interpolate::{Interpolator, Method, Norm, Options, interpolate};
use fairform::refine::refine;
use fairform::scheme::loop_scheme;
use fairform::{Border, Corners, Mesh, Rules, Scheme, limit};
use serde_json::Value;

/// All fixtures of the schemes that this file checks, with their rules.
fn fixtures() -> Vec<(String, Value, Rules)> {
    let mut all = Vec::new();
    for &scheme in Scheme::ALL {
        for name in golden_names(scheme.name()) {
            let fixture = golden(&name);
            let tension = match &fixture["lambda"] {
                Value::Null => None,
                Value::Array(list) => Some(list.iter().map(number).collect()),
                one => Some(vec![number(one); fixture["mesh"]["faces"].as_array().unwrap().len()]),
            };
            let rules = Rules {
                scheme,
                corners: match fixture["corners"].as_str() {
                    None => Rules::from(scheme).corners,
                    Some("sharp") => Corners::Sharp,
                    Some(_) => Corners::Smooth,
                },
                border: if fixture["boundary"] == "drop" { Border::Drop } else { Border::Bspline },
                tension: tension.map(Into::into),
                creases: None,
                kobbelt_weight: fixture["w"].as_f64().unwrap_or(1.0),
            };
            all.push((name, fixture, rules));
        }
    }
    assert!(all.len() > 70, "{} fixtures", all.len());
    all
}

fn from_lowest(face: &[u32]) -> Vec<u32> {
    let mut face = face.to_vec();
    let lowest = face.iter().enumerate().min_by_key(|c| c.1).map_or(0, |c| c.0);
    face.rotate_left(lowest);
    face
}

#[test]
fn refinement() {
    for (name, fixture, rules) in fixtures() {
        let (mut at, mut rules) = (mesh(&fixture["mesh"]), rules);
        for level in fixture["refine"].as_array().unwrap() {
            let step = refine(at.topology(), &rules).unwrap();
            let positions = step.apply(at.positions());
            assert_near(&step.stencils().apply(at.positions()), &positions, 4e-15, &name);
            let (topology, next) = (step.topology, step.next);
            at = Mesh::from_parts(topology.into(), positions);
            rules = next;
            assert_near(at.positions(), &points(&level["vertices"]), 1e-12, &name);
            let (actual, expected) = (at.topology().to_faces(), faces(&level["faces"]));
            assert_eq!(actual.len(), expected.len(), "{name}");
            for (a, e) in actual.iter().zip(expected.iter()) {
                // Doo–Sabin leaves open at which corner the face of a vertex begins.
                let any_start = rules.scheme == Scheme::DooSabin;
                assert!(a == e || any_start && from_lowest(a) == from_lowest(e), "{name} {a:?}");
            }
        }
    }
}

#[test]
fn limit_points_and_normals() {
    for (name, fixture, rules) in fixtures() {
        if fixture["limit"].is_null() {
            continue;
        }
        let at = mesh(&fixture["mesh"]);
        let (topology, control) = (at.topology(), at.positions());
        let limit = limit::limit_points(topology, control, &rules).unwrap();
        assert_near(&limit, &points(&fixture["limit"]), 1e-12, &name);
        let normals = limit::limit_normals(topology, control, &rules).unwrap();
        for (i, (&actual, expected)) in normals.iter().zip(points(&fixture["normals"])).enumerate()
        {
            // Zero stands where the fixtures give none.
            let unknown = expected == fairform::Vec3::ZERO;
            assert!(unknown || (actual - expected).length() < 1e-12, "{name} normal {i}");
        }
    }
}

fn fit(
    target: &Mesh,
    rules: &Rules,
    options: &Options,
) -> (Vec<fairform::Vec3>, fairform::interpolate::FitReport) {
    let (control, report) = interpolate(target, rules, options).unwrap();
    (control.into_positions(), report)
}

fn updates(iterations: u32) -> Options {
    let (method, norm) = (Method::Plain, Norm::Absolute);
    Options { method, norm, tolerance: None, iterations, ..Options::default() }
}

#[test]
fn iterates_and_histories() {
    for (name, fixture, rules) in fixtures() {
        let expected = &fixture["interpolation"];
        if expected.is_null() {
            continue;
        }
        let target = mesh(&fixture["mesh"]);
        for (k, control) in expected["iterates"].as_object().unwrap() {
            let (actual, _) = fit(&target, &rules, &updates(k.parse().unwrap()));
            assert_near(&actual, &points(control), 1e-12, &format!("{name} after {k}"));
        }
        let (_, report) = fit(&target, &rules, &updates(20));
        // Corners that stay are no stage here: there is nothing to solve.
        let stages = expected["stages"].as_array().unwrap();
        let stages: Vec<&Value> = stages.iter().filter(|s| s["name"] != "corner").collect();
        assert_eq!(report.stages.len(), stages.len(), "{name}");
        for (stage, expected) in report.stages.iter().zip(stages) {
            assert_eq!(stage.name.name(), expected["name"], "{name}");
            assert_eq!(stage.vertex_count, expected["vertices"].as_array().unwrap().len());
            check_history(&name, &stage.solve.history, &expected["history"], 1.0);
        }
    }
}

fn check_history(name: &str, actual: &[fairform::solve::Step], expected: &Value, unit: f64) {
    let expected = expected.as_array().unwrap();
    assert_eq!(actual.len(), expected.len(), "{name}");
    for (step, row) in actual.iter().zip(expected) {
        assert_eq!(f64::from(step.updates), number(&row[0]), "{name}");
        for (actual, expected) in [(step.max, &row[1]), (step.mean, &row[2])] {
            let difference = (actual * unit - number(expected)).abs();
            assert!(difference < 1e-12, "{name} update {}: {difference:e}", step.updates);
        }
    }
}

#[test]
fn exact_control_meshes_by_every_method() {
    for (name, fixture, rules) in fixtures() {
        let exact = &fixture["interpolation"]["exact"];
        if exact.is_null() {
            continue;
        }
        let exact = points(exact);
        let target = mesh(&fixture["mesh"]);
        for method in Method::ALL {
            let options = Options { method, tolerance: Some(1e-14), ..Options::default() };
            let (control, report) = fit(&target, &rules, &options);
            // Rounding may keep the residual a few units above so small a tolerance.
            assert!(report.max < 1e-13, "{name} {method}: {}", report.max);
            assert_near(&control, &exact, 2e-12, &format!("{name} {method}"));
        }
    }
}

#[test]
fn runs_to_a_tolerance() {
    for (name, fixture, rules) in fixtures() {
        let run = &fixture["interpolation"]["tolerance_run"];
        if run.is_null() {
            continue;
        }
        let norm = match run["norm"].as_str().unwrap() {
            "unit_cube" => Norm::LongestSide,
            "diagonal" => Norm::Diagonal,
            other => panic!("{other}"),
        };
        let target = mesh(&fixture["mesh"]);
        let options = Options {
            method: Method::Plain,
            norm,
            tolerance: Some(number(&run["tol"])),
            ..Options::default()
        };
        let (control, report) = fit(&target, &rules, &options);
        assert!(report.is_converged());
        for stage in &report.stages {
            let expected = &run["iterations"][stage.name.name()];
            assert_eq!(f64::from(stage.solve.last().updates), number(expected), "{name}");
        }
        assert_near(&control, &points(&run["control"]), 1e-12, &name);
    }
}

#[test]
fn scales() {
    for (name, fixture, rules) in fixtures() {
        if fixture["interpolation"].is_null() {
            continue;
        }
        let target = mesh(&fixture["mesh"]);
        let interpolator = Interpolator::new(target.topology(), &rules).unwrap();
        for (norm, key) in [
            (Norm::Absolute, "absolute"),
            (Norm::LongestSide, "unit_cube"),
            (Norm::Diagonal, "diagonal"),
        ] {
            let options = Options { norm, ..Options::default() };
            let mut go_on = |_, _| ControlFlow::Continue(());
            let (_, report) = interpolator.fit(target.positions(), &options, &mut go_on).unwrap();
            let expected = number(&fixture["interpolation"]["scales"][key]);
            assert!((report.unit / expected - 1.0).abs() < 1e-15, "{name} {key}");
        }
    }
}

#[test]
fn limit_weights_by_valence() {
    let masks = golden("masks");
    for (n, expected) in masks["loop_beta"].as_object().unwrap() {
        let actual = loop_scheme::limit_weight(n.parse().unwrap());
        assert!((actual - number(expected)).abs() < 1e-15, "valence {n}");
    }
    for (n, expected) in masks["loop_lambda_min_bound"].as_object().unwrap() {
        let actual = loop_scheme::smallest_eigenvalue_bound(n.parse().unwrap());
        assert!((actual - number(expected)).abs() < 1e-15, "valence {n}");
    }
}
