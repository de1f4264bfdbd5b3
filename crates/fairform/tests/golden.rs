//! Everything the reference values of `data/golden/loop` say.

mod common;

use std::ops::ControlFlow;

use common::{GOLDEN_LOOP, assert_near, faces, golden, mesh, number, points};
use fairform::interpolate::{Interpolator, Method, Norm, Options, interpolate};
use fairform::refine::refine;
use fairform::scheme::loop_scheme;
use fairform::{Corners, Mesh, Scheme, limit};
use serde_json::Value;

const SMOOTH: Corners = Corners::Smooth;

#[test]
fn refinement() {
    for name in GOLDEN_LOOP {
        let fixture = golden(&format!("loop/{name}"));
        let mut at = mesh(&fixture["mesh"]);
        for level in fixture["refine"].as_array().unwrap() {
            let step = refine(at.topology(), Scheme::Loop, SMOOTH).unwrap();
            let positions = step.apply(at.positions());
            assert_near(&step.stencils().apply(at.positions()), &positions, 1e-15, name);
            at = Mesh::from_parts(step.topology.into(), positions);
            assert_near(at.positions(), &points(&level["vertices"]), 1e-12, name);
            assert_eq!(at.topology().to_faces(), faces(&level["faces"]), "{name}");
        }
    }
}

#[test]
fn limit_points_and_normals() {
    for name in GOLDEN_LOOP {
        let fixture = golden(&format!("loop/{name}"));
        let at = mesh(&fixture["mesh"]);
        let (topology, control) = (at.topology(), at.positions());
        let limit = limit::limit_points(topology, control, Scheme::Loop, SMOOTH).unwrap();
        assert_near(&limit, &points(&fixture["limit"]), 1e-12, name);
        let normals = limit::limit_normals(topology, control, Scheme::Loop, SMOOTH).unwrap();
        assert_near(&normals, &points(&fixture["normals"]), 1e-12, name);
    }
}

fn fit(
    target: &Mesh,
    options: &Options,
) -> (Vec<fairform::Vec3>, fairform::interpolate::FitReport) {
    let (control, report) = interpolate(target, options).unwrap();
    (control.into_positions(), report)
}

fn updates(iterations: u32) -> Options {
    let (method, norm) = (Method::Plain, Norm::Absolute);
    Options { method, norm, tolerance: None, iterations, ..Options::default() }
}

#[test]
fn iterates_and_histories() {
    for name in GOLDEN_LOOP {
        let fixture = &golden(&format!("loop/{name}"));
        let expected = &fixture["interpolation"];
        let target = mesh(&fixture["mesh"]);
        for (k, control) in expected["iterates"].as_object().unwrap() {
            let (actual, _) = fit(&target, &updates(k.parse().unwrap()));
            assert_near(&actual, &points(control), 1e-12, &format!("{name} after {k}"));
        }
        let (_, report) = fit(&target, &updates(20));
        let stages = expected["stages"].as_array().unwrap();
        assert_eq!(report.stages.len(), stages.len(), "{name}");
        for (stage, expected) in report.stages.iter().zip(stages) {
            assert_eq!(stage.name.name(), expected["name"], "{name}");
            assert_eq!(stage.vertex_count, expected["vertices"].as_array().unwrap().len());
            check_history(name, &stage.solve.history, &expected["history"], 1.0);
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
    for name in GOLDEN_LOOP {
        let fixture = golden(&format!("loop/{name}"));
        let exact = points(&fixture["interpolation"]["exact"]);
        let target = mesh(&fixture["mesh"]);
        for method in Method::ALL {
            let options = Options { method, tolerance: Some(1e-14), ..Options::default() };
            let (control, report) = fit(&target, &options);
            // Rounding may keep the residual a few units above so small a tolerance.
            assert!(report.max < 1e-13, "{name} {method}: {report:?}");
            assert_near(&control, &exact, 2e-12, &format!("{name} {method}"));
        }
    }
}

#[test]
fn runs_to_a_tolerance() {
    for name in GOLDEN_LOOP {
        let fixture = golden(&format!("loop/{name}"));
        let run = &fixture["interpolation"]["tolerance_run"];
        assert_eq!(run["norm"], "unit_cube");
        let target = mesh(&fixture["mesh"]);
        let options = Options {
            method: Method::Plain,
            norm: Norm::LongestSide,
            tolerance: Some(number(&run["tol"])),
            ..Options::default()
        };
        let (control, report) = fit(&target, &options);
        assert!(report.is_converged());
        for stage in &report.stages {
            let expected = &run["iterations"][stage.name.name()];
            assert_eq!(f64::from(stage.solve.last().updates), number(expected), "{name}");
        }
        assert_near(&control, &points(&run["control"]), 1e-12, name);
    }
}

#[test]
fn scales() {
    for name in GOLDEN_LOOP {
        let fixture = golden(&format!("loop/{name}"));
        let target = mesh(&fixture["mesh"]);
        let interpolator = Interpolator::new(target.topology(), Scheme::Loop, SMOOTH).unwrap();
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
