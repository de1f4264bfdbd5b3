//! Streamline surfaces: reference values, exact shapes, orders of convergence, edits.

use crate::common::{assert_near, golden, golden_names, number, points};
use fairform::sphere::{self, Blend, Ends, Knots, Rule};
use fairform::streamline::{
    self, Curve, Error, Grid, InitialCurve, Integration, LengthFunction, Model, Order, Start,
    Surface, spaced,
};
use fairform::{Scheme, Vec3};
use proptest::prelude::*;
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

/// A rotation about an axis.
fn turned(axis: Vec3, angle: f64, v: Vec3) -> Vec3 {
    let (sine, cosine) = angle.sin_cos();
    cosine * v + sine * axis.cross(v) + (1.0 - cosine) * axis.dot(v) * axis
}

/// Streamlines that all turn uniformly in their planes, `turn` radians from end to end.
fn turning(rows: usize, columns: usize, turn: f64, length: f64) -> Model {
    let tangent = move |i: usize| {
        let angle = turn * i as f64 / (columns - 1) as f64;
        Vec3::new(angle.cos(), 0.0, angle.sin())
    };
    let grid = Grid::from_rows((0..rows).map(|_| (0..columns).map(tangent))).unwrap();
    let t: Vec<f64> = (0..rows).map(|k| k as f64).collect();
    let points = t.iter().map(|&y| Vec3::new(0.0, y, 0.0)).collect();
    Model::new(grid, &vec![length; rows], t.clone(), InitialCurve::Polyline { points, t })
}

fn schemes() -> [Scheme; 3] {
    [Scheme::DooSabin, Scheme::CatmullClark, Scheme::Kobbelt]
}

#[test]
fn constant_tangents_give_planes_and_ruled_surfaces() {
    for scheme in schemes() {
        let model = Model { scheme, depth: 3, ..turning(6, 7, 0.0, 5.0) };
        let surface = Surface::new(model.clone()).unwrap();
        assert!(surface.points().values().iter().all(|p| p.z == 0.0), "{scheme}: a plane");
        // One direction per streamline: straight lines, in steps as in the parameters.
        let mut ruled = model;
        for k in 0..6 {
            let t = Vec3::new(1.0, 0.0, 0.2 * k as f64).normalized();
            ruled.tangents.row_mut(k).fill(t);
        }
        let surface = Surface::new(ruled).unwrap();
        for (row, points) in surface.points().rows().enumerate() {
            let t = surface.tangents()[(row, 0)];
            let s = surface.parameters();
            for (i, &p) in points.iter().enumerate() {
                let expected = points[0] + (s[(row, i)][0] - s[(row, 0)][0]) * t;
                assert!((p - expected).length() < 1e-13, "{scheme}: {p:?} {expected:?}");
            }
        }
    }
}

/// The inner points of the midpoint rule lie on a circle of radius (h/2)/sin(δ/2), those of arcs on the
/// circle itself.
#[test]
fn uniformly_turning_tangents_give_circles() {
    for scheme in schemes() {
        let (turn, length) = (2.0, 5.0);
        let radius = length / turn;
        let mut errors = Vec::new();
        for depth in 1..5 {
            let model = Model { scheme, depth, ends: Ends::Clamped, ..turning(6, 9, turn, length) };
            let arcs = Model { integration: Integration::Arcs, ..model.clone() };
            let surface = Surface::new(arcs).unwrap();
            for (row, points) in surface.points().rows().enumerate() {
                let centre = points[0] + Vec3::new(0.0, 0.0, radius);
                for &p in points {
                    let off = (p - centre).length() - radius;
                    assert!(off.abs() < 1e-13, "{scheme}, depth {depth}, row {row}: {off:e}");
                }
            }
            // The midpoint rule against the end of the circle.
            let surface = Surface::new(model).unwrap();
            let end = radius * Vec3::new(turn.sin(), 0.0, 1.0 - turn.cos());
            let points = surface.points().row(0);
            errors.push((points[points.len() - 1] - points[0] - end).length());
        }
        // Clamped ends halve their intervals late, so the order comes from below.
        let order = (errors[2] / errors[3]).log2();
        assert!((1.8..2.1).contains(&order), "{scheme}: order {order}, errors {errors:?}");
    }
}

#[test]
fn inner_points_of_the_midpoint_rule_lie_on_the_stated_circle() {
    let surface = Surface::new(Model { depth: 2, ..turning(4, 5, 1.5, 3.0) }).unwrap();
    let intervals = (surface.tangents().column_count() - 1) as f64;
    let (h, delta) = (3.0 / intervals, 1.5 / intervals);
    let radius = 0.5 * h / (0.5 * delta).sin();
    let points = surface.points().row(1);
    let inner = &points[1..points.len() - 1];
    // Through three of them, then all.
    let (a, b, c) = (inner[0], inner[4], inner[9]);
    let (u, v) = (b - a, c - a);
    let n = u.cross(v);
    let centre = a + (v.dot(v) * n.cross(u) + u.dot(u) * v.cross(n)) / (2.0 * n.dot(n));
    for &p in inner {
        assert!(((p - centre).length() - radius).abs() < 1e-12);
    }
}

/// A smooth field of tangents with known streamlines: measured order of both rules.
#[test]
fn integration_is_of_second_order() {
    let exact = |s: f64| {
        // Fine Simpson sums of a tangent that turns unevenly out of the plane.
        let tangent = |s: f64| {
            let (a, b) = (1.2 * s * s, 0.5 * (2.0 * s).sin());
            Vec3::new(a.cos() * b.cos(), a.sin() * b.cos(), b.sin())
        };
        let n = 4000;
        let h = s / f64::from(n);
        let at = |i: f64| tangent(i * h);
        (0..n)
            .map(f64::from)
            .fold(Vec3::ZERO, |p, i| p + (h / 6.0) * (at(i) + 4.0 * at(i + 0.5) + at(i + 1.0)))
    };
    let end = exact(1.5);
    for integration in [Integration::Midpoint, Integration::Arcs] {
        let error = |columns: usize| {
            let s: Vec<f64> = (0..columns).map(|i| 1.5 * i as f64 / (columns - 1) as f64).collect();
            let tangent = |&s: &f64| {
                let (a, b): (f64, f64) = (1.2 * s * s, 0.5 * (2.0 * s).sin());
                Vec3::new(a.cos() * b.cos(), a.sin() * b.cos(), b.sin())
            };
            let row: Vec<Vec3> = s.iter().map(tangent).collect();
            let initial = InitialCurve::Polyline { points: vec![Vec3::ZERO], t: vec![0.0] };
            let tangents = Grid::from_rows([row]).unwrap();
            let model = Model { integration, ..Model::new(tangents, &[1.5], vec![0.0], initial) };
            let surface = Surface::new(model).unwrap();
            let points = surface.points().row(0);
            (points[points.len() - 1] - end).length()
        };
        let errors = [9, 17, 33, 65].map(error);
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((1.9..2.1).contains(&order), "{integration:?}: {order} of {errors:?}");
        }
    }
}

fn random_model(seed: u64, scheme: Scheme, ends: Ends, order: Order, depth: u32) -> Model {
    let mut state = seed.wrapping_mul(2).wrapping_add(0x9E37_79B9_7F4A_7C15) | 1;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let rows = 4 + (random() * 3.0) as usize;
    let columns = 4 + (random() * 4.0) as usize;
    let mut tangent = |k: usize, i: usize| {
        let bend = Vec3::new(random() - 0.5, random() - 0.5, random() - 0.5);
        (Vec3::new(1.0, 0.1 * k as f64, 0.3 - 0.1 * i as f64) + 1.2 * bend).normalized()
    };
    let list: Vec<Vec<Vec3>> =
        (0..rows).map(|k| (0..columns).map(|i| tangent(k, i)).collect()).collect();
    let tangents = Grid::from_rows(list).unwrap();
    let lengths: Vec<f64> = (0..rows).map(|k| 3.0 + 0.4 * k as f64).collect();
    let t: Vec<f64> = (0..rows).map(|k| k as f64 * (1.0 + 0.1 * k as f64)).collect();
    let points = t.iter().map(|&y| Vec3::new(0.1 * y * y, y, 0.2 * y)).collect();
    let initial = InitialCurve::Polyline { points, t: t.clone() };
    Model { scheme, ends, order, depth, ..Model::new(tangents, &lengths, t, initial) }
}

#[test]
fn the_orders_of_blending_agree_in_numbers_and_differ_at_third_order_in_tangents() {
    for scheme in schemes() {
        let gap = |spread: f64| {
            let mut model = random_model(7, scheme, Ends::Natural, Order::St, 1);
            let mean = Vec3::new(1.0, 0.0, 0.0);
            for k in 0..model.tangents.row_count() {
                for t in model.tangents.row_mut(k) {
                    *t = (mean + spread * *t).normalized();
                }
            }
            let st = Surface::new(model.clone()).unwrap();
            let ts = Surface::new(Model { order: Order::Ts, ..model }).unwrap();
            for (a, b) in st.s().values().iter().zip(ts.s().values()) {
                assert!((a - b).abs() < 1e-14);
            }
            let pairs = st.tangents().values().iter().zip(ts.tangents().values());
            pairs.map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max)
        };
        let (wide, narrow) = (gap(0.4), gap(0.2));
        assert!(wide > 0.0 && narrow < wide / 5.0, "{scheme}: {wide:e} {narrow:e}");
    }
}

proptest! {
    #[test]
    fn streamlines_have_the_lengths_asked_for(
        seed in any::<u64>(), scheme in prop::sample::select(schemes().to_vec()), depth in 0..4u32
    ) {
        let model = random_model(seed, scheme, Ends::Clamped, Order::St, depth);
        let asked: Vec<f64> = (0..model.t.len()).map(|k| {
            let s = model.s.row(k);
            s[s.len() - 1] - s[0]
        }).collect();
        let t = model.t.clone();
        let lengths = LengthFunction::Polyline { lengths: asked.iter().map(|l| 2.0 * l).collect(), t: t.clone() };
        let plain = Surface::new(model.clone()).unwrap();
        let ends = [0, plain.points().row_count() - 1];
        for (row, k) in ends.into_iter().zip([0, t.len() - 1]) {
            prop_assert!((plain.length(row) - asked[k]).abs() < 1e-12);
            let points = plain.points().row(row);
            let polygon: f64 = points.windows(2).map(|p| (p[1] - p[0]).length()).sum();
            prop_assert!((polygon - asked[k]).abs() < 1e-12, "{polygon} {}", asked[k]);
        }
        let stretched = Surface::new(Model { length: Some(lengths.clone()), ..model }).unwrap();
        for (row, asked) in lengths.lengths(stretched.t()).unwrap().into_iter().enumerate() {
            prop_assert!((stretched.length(row) - asked).abs() < 1e-12);
        }
    }

    /// An edit of the model leads to the same bits as the edited model anew, and names what moved.
    #[test]
    fn an_edit_is_the_same_as_anew(
        seed in any::<u64>(), scheme in prop::sample::select(schemes().to_vec()),
        clamped in any::<bool>(), ts in any::<bool>(), depth in 1..4u32, arcs in any::<bool>(),
        edits in prop::collection::vec((0..3u32, any::<prop::sample::Index>(), -1.0..1.0f64), 1..4),
    ) {
        let ends = if clamped { Ends::Clamped } else { Ends::Natural };
        let order = if ts { Order::Ts } else { Order::St };
        let mut model = random_model(seed, scheme, ends, order, depth);
        model.start = if arcs { Start::Fraction(0.4) } else { Start::Min };
        model.integration = if arcs { Integration::Arcs } else { Integration::Midpoint };
        let mut surface = Surface::new(model).unwrap();
        for (level, place, bend) in edits {
            let level = level.min(depth);
            let grid = surface.tangents_at(level);
            let place = place.index(grid.values().len());
            let (row, column) = (place / grid.column_count(), place % grid.column_count());
            let old = grid[(row, column)];
            let to = turned(Vec3::new(0.0, 0.6, 0.8), bend, old);
            let (before, points) = (surface.tangents().clone(), surface.points().clone());
            let changed = surface.set_tangent(level, row, column, to).unwrap();
            let anew = Surface::new(surface.model().clone()).unwrap();
            prop_assert_eq!(anew.tangents(), surface.tangents());
            prop_assert_eq!(anew.points(), surface.points());
            for (rect, old, new) in [
                (&changed.tangents, &before, surface.tangents()),
                (&changed.points, &points, surface.points()),
            ] {
                for k in 0..old.row_count() {
                    for i in 0..old.column_count() {
                        prop_assert!(rect.contains(k, i) || old[(k, i)] == new[(k, i)]);
                    }
                }
            }
            prop_assert!((surface.tangents_at(level)[(row, column)] - to).length() < 1e-14);
        }
    }

    #[test]
    fn a_turned_model_has_the_turned_surface(
        seed in any::<u64>(), scheme in prop::sample::select(schemes().to_vec()), angle in -3.0..3.0f64
    ) {
        let model = random_model(seed, scheme, Ends::Natural, Order::St, 2);
        let axis = Vec3::new(0.48, 0.6, 0.64);
        let turn = |v: Vec3| turned(axis, angle, v);
        let mut other = model.clone();
        for k in 0..other.tangents.row_count() {
            other.tangents.row_mut(k).iter_mut().for_each(|t| *t = turn(*t));
        }
        let InitialCurve::Polyline { points, .. } = &mut other.initial else { panic!("a polyline") };
        points.iter_mut().for_each(|p| *p = turn(*p));
        let (a, b) = (Surface::new(model).unwrap(), Surface::new(other).unwrap());
        let expected: Vec<Vec3> = a.points().values().iter().map(|&p| turn(p)).collect();
        assert_near(b.points().values(), &expected, 1e-11, "turned");
    }

    /// Tangents reversed and negated, parameters mirrored, held at the other end: the same points
    /// backwards.
    #[test]
    fn a_reversed_model_has_the_reversed_surface(
        seed in any::<u64>(), scheme in prop::sample::select(schemes().to_vec())
    ) {
        let model = random_model(seed, scheme, Ends::Clamped, Order::St, 2);
        let mut other = model.clone();
        for k in 0..other.tangents.row_count() {
            let (tangents, s) = (model.tangents.row(k), model.s.row(k));
            let n = tangents.len();
            for i in 0..n {
                other.tangents.row_mut(k)[i] = -tangents[n - 1 - i];
                other.s.row_mut(k)[i] = s[n - 1] + s[0] - s[n - 1 - i];
            }
        }
        other.start = Start::Max;
        let (a, b) = (Surface::new(model).unwrap(), Surface::new(other).unwrap());
        for (a, b) in a.points().rows().zip(b.points().rows()) {
            let back: Vec<Vec3> = b.iter().rev().copied().collect();
            assert_near(a, &back, 1e-12, "reversed");
        }
    }
}

/// A detail set at a fine level goes along when a coarse tangent turns everything.
#[test]
fn details_turn_with_the_coarse_tangents() {
    let model = random_model(3, Scheme::CatmullClark, Ends::Clamped, Order::St, 2);
    let mut plain = Surface::new(model.clone()).unwrap();
    let mut detailed = Surface::new(model.clone()).unwrap();
    let (row, column) = (3, 4);
    let before = detailed.tangents_at(1)[(row, column)];
    let axis = Vec3::new(0.0, 0.0, 1.0);
    detailed.set_tangent(1, row, column, turned(axis, 0.3, before)).unwrap();
    let bend =
        sphere::angle(plain.tangents_at(1)[(row, column)], detailed.tangents_at(1)[(row, column)]);
    // Turn all coarse tangents about one axis: the detail keeps its angle to the surface beneath.
    let rows = model.tangents.row_count();
    let columns = model.tangents.column_count();
    let mut edits = Vec::new();
    for k in 0..rows {
        for i in 0..columns {
            edits.push((k, i, turned(Vec3::new(0.0, 1.0, 0.0), 0.5, model.tangents[(k, i)])));
        }
    }
    plain.set_tangents(0, &edits).unwrap();
    detailed.set_tangents(0, &edits).unwrap();
    let after =
        sphere::angle(plain.tangents_at(1)[(row, column)], detailed.tangents_at(1)[(row, column)]);
    assert!((bend - after).abs() < 1e-12, "{bend} {after}");
    detailed.remove_detail(1, row, column).unwrap();
    assert_eq!(detailed.points(), plain.points());
}

#[test]
fn curvature_of_circles_is_exact() {
    let surface = Surface::new(Model { depth: 2, ..turning(4, 6, 1.5, 6.0) }).unwrap();
    let curvature = streamline::curvature(&surface);
    for k in curvature.vector.values() {
        assert!((k.length() - 0.25).abs() < 1e-13);
    }
    assert!(curvature.variation.values().iter().all(|v| v.abs() < 1e-11));
    // κ² × length × streamlines.
    let rows = surface.points().row_count() as f64;
    assert!((curvature.bending_energy(&surface) - 0.0625 * 6.0 * rows).abs() < 1e-11);
}

#[test]
fn wrong_models_are_named() {
    let model = || turning(4, 5, 1.0, 3.0);
    let error = |model: Model| Surface::new(model).unwrap_err();
    let mut bad = model();
    bad.tangents[(2, 3)] = Vec3::new(1.0, 1.0, 0.0);
    assert!(matches!(error(bad), Error::NotUnit { row: 2, column: 3, .. }));
    let mut bad = model();
    bad.s[(1, 2)] = bad.s[(1, 1)];
    assert!(matches!(error(bad), Error::NotIncreasing { level: 0, row: 1, column: 2 }));
    let mut bad = model();
    bad.t.swap(0, 1);
    assert!(matches!(error(bad), Error::TNotIncreasing { index: 1 }));
    let bad = Model { scheme: Scheme::Loop, ..model() };
    assert!(matches!(error(bad), Error::BadScheme { .. }));
    let bad = Model { depth: 30, ..model() };
    assert!(matches!(error(bad), Error::TooLarge { depth: 30 }));
    let bad = Model { t: vec![0.0, 1.0, 2.0, 9.0], ..model() };
    assert!(matches!(error(bad), Error::OutsideCurve { .. }));
    let bad = Model { start: Start::At(f64::NAN), ..model() };
    assert!(matches!(error(bad), Error::BadNumber { field: "s0", .. }));
    let bad = Model { w: -9.0, depth: 1, ..model() };
    assert!(matches!(error(bad), Error::Sphere { .. }));
    let bad = Model { ends: Ends::Closed, ..model() };
    assert!(matches!(error(bad), Error::Closed));
    // Very uneven parameters: the four-point rule overshoots.
    let mut bad = Model { w: 2.0, depth: 1, ..model() };
    bad.s.row_mut(0).copy_from_slice(&[0.0, 10.0, 10.001, 10.002, 20.0]);
    assert!(matches!(error(bad), Error::NotIncreasing { level: 1, row: 0, .. }));
    let mut surface = Surface::new(model()).unwrap();
    let x = Vec3::new(1.0, 0.0, 0.0);
    assert!(matches!(surface.set_tangent(0, 4, 0, x), Err(Error::NoSuchPlace { .. })));
    assert!(matches!(surface.set_tangent(3, 0, 0, x), Err(Error::NoSuchPlace { .. })));
    assert!(matches!(surface.set_tangent(0, 0, 0, 2.0 * x), Err(Error::NotUnit { .. })));
}

#[test]
fn a_surface_is_a_manifold_grid() {
    let surface = Surface::new(Model { depth: 3, ..turning(6, 9, 1.0, 3.0) }).unwrap();
    assert_eq!((surface.tangents().row_count(), surface.tangents().column_count()), (41, 65));
    let mesh = surface.mesh().unwrap();
    assert_eq!(mesh.topology().face_count(), 40 * 65);
    assert_eq!(mesh.topology().uniform_face_size(), Some(4));
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

/// With Kobbelt's scheme a foot is where the curve of its row is at its parameter; at the ends it is the
/// first and last point.
#[test]
fn control_tangents_stand_on_the_surface() {
    // A circle of radius 2 in each row, half of it.
    let turn = std::f64::consts::PI;
    for integration in [Integration::Midpoint, Integration::Arcs] {
        let model = Model { depth: 5, integration, ..turning(4, 9, turn, 2.0 * turn) };
        let surface = Surface::new(model.clone()).unwrap();
        let (feet, points) = (surface.feet(), surface.points());
        assert_eq!((feet.row_count(), feet.column_count()), (4, 9));
        let last = points.column_count() - 1;
        for row in 0..4 {
            assert_eq!(feet[(row, 0)], points[(row << 5, 0)]);
            assert!((feet[(row, 8)] - points[(row << 5, last)]).length() < 1e-12);
            // By the tangents, a foot and its neighbour are a chord of the circle apart.
            for pair in feet.row(row).windows(2) {
                let chord = 4.0 * (turn / 16.0).sin();
                assert!(((pair[1] - pair[0]).length() - chord).abs() < 1e-3, "{pair:?}");
            }
        }
        // Stretched streamlines are stood upon in the same proportion.
        let stretched =
            LengthFunction::Polyline { lengths: vec![4.0 * turn; 2], t: vec![0.0, 3.0] };
        let long = Surface::new(Model { length: Some(stretched), ..model }).unwrap();
        let begin = feet[(0, 0)];
        for i in 0..9 {
            let (near, far) = (feet[(0, i)] - begin, long.feet()[(0, i)] - long.feet()[(0, 0)]);
            assert!((2.0 * near - far).length() < 1e-12);
        }
    }
}

/// Between the points of a circle the curvature is one over the radius, everywhere.
#[test]
fn curvature_at_the_points_of_circles() {
    for integration in [Integration::Midpoint, Integration::Arcs] {
        let model = Model { depth: 3, integration, ..turning(3, 7, 2.0, 5.0) };
        let surface = Surface::new(model).unwrap();
        let vectors = streamline::curvature(&surface).at_points(&surface);
        assert_eq!(vectors.values().len(), surface.points().values().len());
        for k in vectors.values() {
            assert!((k.length() - 0.4).abs() < 1e-3, "{k:?}");
        }
        let tangents = surface.point_tangents();
        for (k, t) in vectors.values().iter().zip(tangents.values()) {
            assert!((t.length() - 1.0).abs() < 1e-14 && k.dot(*t).abs() < 0.05);
        }
    }
}

/// What is inserted lies halfway on the great circles between its neighbours, and is taken away again.
#[test]
fn rows_and_columns_come_and_go() {
    let given = random_model(7, Scheme::Kobbelt, Ends::Natural, Order::St, 2);
    let mut model = given.clone();
    model.insert_row(1).unwrap();
    model.insert_column(2).unwrap();
    model.check().unwrap();
    let halfway = sphere::midpoint(given.tangents[(0, 0)], given.tangents[(1, 0)]);
    assert_eq!(model.tangents[(1, 0)], halfway);
    assert_eq!(model.t[1], f64::midpoint(given.t[0], given.t[1]));
    let halfway = sphere::midpoint(given.tangents[(0, 1)], given.tangents[(0, 2)]);
    assert_eq!(model.tangents[(0, 2)], halfway);
    assert_eq!(model.s[(0, 2)], f64::midpoint(given.s[(0, 1)], given.s[(0, 2)]));
    model.delete_column(2).unwrap();
    model.delete_row(1).unwrap();
    assert_eq!(model, Model { details: Vec::new(), ..given.clone() });

    let [rows, columns] = [given.tangents.row_count(), given.tangents.column_count()];
    for index in [0, rows, rows + 1] {
        assert!(matches!(model.insert_row(index), Err(Error::NoSuchPlace { .. })));
    }
    for index in [0, columns] {
        assert!(matches!(model.insert_column(index), Err(Error::NoSuchPlace { .. })));
    }
    assert!(model.delete_row(rows).is_err() && model.delete_column(columns).is_err());
    (1..rows).for_each(|_| model.delete_row(0).unwrap());
    (1..columns).for_each(|_| model.delete_column(0).unwrap());
    assert_eq!(model.delete_row(0), Err(Error::Empty));
    assert_eq!(model.delete_column(0), Err(Error::Empty));
}
