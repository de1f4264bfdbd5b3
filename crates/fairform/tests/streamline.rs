//! Streamline surfaces: reference values, exact shapes, orders of convergence, edits.

mod common;

use common::{assert_near, golden, golden_names, number, points};
use fairform::sphere::{Blend, Ends, Knots, Rule};
use fairform::streamline::{
    Curve, Error, Grid, InitialCurve, Integration, Model, Order, Start, Surface, spaced,
};
use fairform::{Scheme, Vec3};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(number).collect()
}

fn grid_of_points(value: &Value) -> Grid<Vec3> {
    Grid::from_rows(value.as_array().unwrap().iter().map(points)).unwrap()
}

fn initial(value: &Value) -> InitialCurve {
    match value["type"].as_str().unwrap() {
        "polyline" => {
            InitialCurve::Polyline { points: points(&value["points"]), t: numbers(&value["t"]) }
        }
        "bspline" => InitialCurve::Bspline {
            points: points(&value["points"]),
            weights: None,
            degree: value["degree"].as_u64().unwrap() as usize,
            knots: None,
            t0: number(&value["t0"]),
            t1: number(&value["t1"]),
        },
        "qi" => InitialCurve::Qi {
            tangents: points(&value["tangents"]),
            order: value["order"].as_u64().unwrap() as usize,
            knots: Knots::Clamped,
            length: number(&value["length"]),
            start: match &value["start"] {
                Value::Null => Vec3::ZERO,
                start => points(&Value::Array(vec![start.clone()]))[0],
            },
            t0: number(&value["t0"]),
            t1: number(&value["t1"]),
        },
        other => panic!("no curve {other}"),
    }
}

fn model(spec: &Value) -> Model {
    let tangents = grid_of_points(&spec["tangents"]);
    let t = numbers(&spec["t"]);
    let s = match &spec["s"] {
        Value::Null => spaced(&numbers(&spec["lengths"]), tangents.column_count()),
        rows => Grid::from_rows(rows.as_array().unwrap().iter().map(numbers)).unwrap(),
    };
    let start = match &spec["s0"] {
        Value::Null => Start::Min,
        Value::String(name) if name == "min" => Start::Min,
        Value::String(name) if name == "max" => Start::Max,
        Value::Number(x) => Start::At(x.as_f64().unwrap()),
        other => Start::Fraction(number(&other["fraction"])),
    };
    Model {
        s,
        start,
        scheme: spec["scheme"].as_str().unwrap().parse().unwrap(),
        order: if spec["order"] == "ts" { Order::Ts } else { Order::St },
        ends: if spec["ends"] == "clamped" { Ends::Clamped } else { Ends::Natural },
        w: spec["w"].as_f64().unwrap_or(1.0),
        depth: spec["depth"].as_u64().unwrap() as u32,
        ..Model::new(tangents, &[], t, initial(&spec["initial"]))
    }
}

#[test]
fn surfaces_are_the_reference_values() {
    let names = golden_names("streamline");
    assert_eq!(names.len(), 13);
    for name in names {
        let fixture = golden(&name);
        let surface = Surface::new(model(&fixture["spec"])).unwrap();
        let result = &fixture["result"];
        for (what, grid) in [("tangents", surface.tangents()), ("points", surface.points())] {
            let expected = grid_of_points(&result[what]);
            assert_eq!(grid.column_count(), expected.column_count(), "{name}: {what}");
            assert_near(grid.values(), expected.values(), 1e-12, &format!("{name}: {what}"));
        }
        let s = Grid::from_rows(result["s"].as_array().unwrap().iter().map(numbers)).unwrap();
        for (a, b) in surface.s().values().iter().zip(s.values()) {
            assert!((a - b).abs() < 1e-12, "{name}: s is {a}, not {b}");
        }
        for (a, b) in surface.t().iter().zip(numbers(&result["t"])) {
            assert!((a - b).abs() < 1e-12, "{name}: t is {a}, not {b}");
        }
    }
}

/// Meridians from a pole: the normals are radial, up to at least second order in the distance of the
/// streamlines; at the pole, where all meet, there is none.
#[test]
fn normals_of_a_sphere_are_radial_in_the_limit() {
    let error = |rows: usize| {
        let turn = |k: usize| 1.5 * k as f64 / (rows - 1) as f64;
        let row = |k: usize| {
            (0..9).map(move |i| {
                let a = 0.15 * f64::from(i);
                let (c, s) = (libm::cos(a), libm::sin(a));
                Vec3::new(c * libm::cos(turn(k)), c * libm::sin(turn(k)), -s)
            })
        };
        let grid = Grid::from_rows((0..rows).map(row)).unwrap();
        let t: Vec<f64> = (0..rows).map(turn).collect();
        let pole = Vec3::new(0.0, 0.0, 1.0);
        let initial = InitialCurve::Polyline { points: vec![pole; 2], t: vec![0.0, 1.5] };
        let model = Model::new(grid, &vec![1.2; rows], t, initial);
        let surface = Surface::new(Model { integration: Integration::Arcs, ..model }).unwrap();
        let normals = surface.normals();
        assert!((0..rows).all(|k| normals[(k, 0)] == Vec3::ZERO));
        let pairs = normals.values().iter().zip(surface.points().values());
        pairs
            .filter(|(n, _)| **n != Vec3::ZERO)
            .map(|(n, p)| (*n - *p).length())
            .fold(0.0, f64::max)
    };
    let [coarse, fine] = [error(9), error(17)];
    assert!(fine < 0.01 && coarse / fine > 3.8, "{coarse} {fine}");
}

/// A curve is the streamline of a surface with one row, and its own refinement of the tangents.
#[test]
fn a_curve_is_one_streamline() {
    let tangents: Vec<Vec3> =
        [0.0, 0.3, 0.9, 1.1].map(|a: f64| Vec3::new(libm::cos(a), libm::sin(a), 0.0)).to_vec();
    let s = vec![0.0, 1.0, 1.5, 3.0];
    let at = Vec3::new(1.0, 2.0, 3.0);
    for start in [Start::Min, Start::Max, Start::At(0.7), Start::Fraction(0.5)] {
        for integration in [Integration::Midpoint, Integration::Arcs] {
            let curve = Curve {
                tangents: tangents.clone(),
                s: Some(s.clone()),
                rule: Rule::Cubic,
                ends: Ends::Natural,
                blend: Blend::Pairs,
                start,
                at,
                integration,
                depth: 2,
            };
            let refined = curve.refine().unwrap();
            let row = Model {
                s: Grid::from_rows([refined.s.clone()]).unwrap(),
                start,
                integration,
                ..Model::new(
                    Grid::from_rows([refined.tangents.clone()]).unwrap(),
                    &[],
                    vec![0.0],
                    InitialCurve::Polyline { points: vec![at], t: vec![0.0] },
                )
            };
            assert_eq!(Surface::new(row).unwrap().points().row(0), refined.points);
            let bad = Curve { ends: Ends::Closed, ..curve.clone() };
            assert_eq!(bad.refine(), Err(Error::Closed));
            let bad = Curve { s: Some(vec![0.0, 1.0, 1.0, 2.0]), ..curve.clone() };
            assert_eq!(bad.refine(), Err(Error::NotIncreasing { level: 0, row: 0, column: 2 }));
            let bad = Curve { depth: 33, ..curve };
            assert!(matches!(bad.refine(), Err(Error::BadNumber { field: "depth", .. })));
        }
    }
}

/// Two tangents stay two under Chaikin's rule, so the number of points bounds nothing.
#[test]
fn a_depth_without_end_is_an_error() {
    let initial = InitialCurve::Polyline {
        points: vec![Vec3::ZERO, Vec3::new(0.0, 1.0, 0.0)],
        t: vec![0.0, 1.0],
    };
    let tangents = Grid::filled(2, 2, Vec3::new(1.0, 0.0, 0.0));
    let model = Model {
        scheme: Scheme::DooSabin,
        depth: u32::MAX,
        ..Model::new(tangents, &[1.0; 2], vec![0.0, 1.0], initial)
    };
    assert!(matches!(Surface::new(model), Err(Error::BadNumber { field: "depth", .. })));
}
