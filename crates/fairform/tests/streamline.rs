//! Streamline surfaces: reference values, exact shapes, orders of convergence, edits.

mod common;

use common::{assert_near, golden, golden_names, number, points};
use fairform::sphere::{Ends, Knots};
use fairform::streamline::{Grid, InitialCurve, Integration, Model, Order, Start, Surface, spaced};
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

/// Meridians from a pole: the normals are radial, up to the second order in the distance of the
/// streamlines; at the pole, where all meet, there is none.
#[test]
fn normals_of_a_sphere_are_radial_in_the_limit() {
    let error = |rows: usize| {
        let turn = |k: usize| 1.5 * k as f64 / (rows - 1) as f64;
        let row = |k: usize| {
            (0..9).map(move |i| {
                let a = 0.15 * i as f64;
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
    assert!(fine < 0.01 && coarse / fine > 3.4 && coarse / fine < 4.6, "{coarse} {fine}");
}
