//! Directions: blends, combinations, sequences, QI curves and meshes of tangents.

use crate::common::{assert_near, faces, golden, golden_names, number, points};
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

// Properties that hold for any tangents.

fn direction() -> impl Strategy<Value = Vec3> {
    // Leans towards axes and near-antipodal pairs through small grids of integers.
    let any = (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64);
    let grid = (-2..=2i32, -2..=2i32, -2..=2i32)
        .prop_map(|(x, y, z)| (f64::from(x), f64::from(y), f64::from(z)));
    prop_oneof![any, grid]
        .prop_filter("a direction", |(x, y, z)| x * x + y * y + z * z > 1e-3)
        .prop_map(|(x, y, z)| Vec3::new(x, y, z).normalized())
}

/// Directions, every now and then followed by almost the opposite, or by themselves.
fn directions(count: std::ops::Range<usize>) -> impl Strategy<Value = Vec<Vec3>> {
    let one = (direction(), 0..8u8, direction());
    prop::collection::vec(one, count).prop_map(|list| {
        let mut tangents: Vec<Vec3> = Vec::new();
        for (t, kind, other) in list {
            tangents.push(match (kind, tangents.last()) {
                (0, Some(&last)) => -last,
                (1, Some(&last)) => (-last + 1e-9 * other).normalized(),
                (2, Some(&last)) => last,
                (3, Some(&last)) => (last + 1e-12 * other).normalized(),
                _ => t,
            });
        }
        tangents
    })
}

fn rules() -> impl Strategy<Value = Rule> {
    prop_oneof![
        Just(Rule::Chaikin),
        Just(Rule::Cubic),
        (0.1..2.4f64).prop_map(|w| Rule::FourPoint { w })
    ]
}

fn all_ends() -> impl Strategy<Value = Ends> {
    prop_oneof![Just(Ends::Natural), Just(Ends::Clamped), Just(Ends::Closed)]
}

/// A rotation, as the images of the axes.
fn rotated(t: Vec3, frame: [Vec3; 3]) -> Vec3 {
    t.x * frame[0] + t.y * frame[1] + t.z * frame[2]
}

fn frame(a: Vec3, b: Vec3) -> Option<[Vec3; 3]> {
    let across = a.cross(b);
    (across.length() > 0.1).then(|| {
        let y = across.normalized();
        [a, y, a.cross(y)]
    })
}

proptest! {
    #[test]
    fn a_blend_is_commutative_to_the_last_bit(t in directions(2..3), k in 0..=64u32) {
        // Multiples of 1/64, so that 1 − u is exact.
        let u = f64::from(k) / 32.0 - 0.5;
        prop_assert_eq!(blend(t[0], t[1], u), blend(t[1], t[0], 1.0 - u));
    }

    #[test]
    fn a_blend_divides_the_angle(t in directions(2..3), u in 0.0..1.0f64) {
        let made = blend(t[0], t[1], u);
        let whole = sphere::angle(t[0], t[1]);
        prop_assert!((made.length() - 1.0).abs() < 1e-14);
        prop_assert!((sphere::angle(t[0], made) - u * whole).abs() < 1e-7);
        prop_assert!((sphere::angle(made, t[1]) - (1.0 - u) * whole).abs() < 1e-7);
    }

    #[test]
    fn exp_takes_back_log(t in directions(2..3)) {
        let back = sphere::exp(t[0], sphere::log(t[0], t[1]));
        prop_assert!((back - t[1]).length() < 1e-7, "{back:?}");
    }

    #[test]
    fn a_reversed_sequence_refines_to_the_same_curve(
        tangents in directions(5..12), rule in rules(), ends in all_ends(), depth in 1..4u32
    ) {
        let refined = |mut list: Vec<Vec3>| {
            for _ in 0..depth {
                list = Step::new(rule, ends, list.len()).unwrap().directions(&list);
            }
            list
        };
        let forward = refined(tangents.clone());
        let mut back = refined(tangents.iter().rev().copied().collect());
        back.reverse();
        if ends == Ends::Closed {
            // New elements between the last and the first come at the end of both.
            let shift = match rule {
                Rule::Chaikin => (1 << (depth + 1)) - 2,
                _ => (1 << depth) - 1,
            };
            back.rotate_left(shift % forward.len());
        }
        prop_assert_eq!(forward, back);
    }

    #[test]
    fn rows_of_terms_are_what_a_step_does(
        tangents in directions(5..12), rule in rules(), ends in all_ends()
    ) {
        let step = Step::new(rule, ends, tangents.len()).unwrap();
        let made = step.directions(&tangents);
        for (j, made) in made.into_iter().enumerate() {
            let terms = step.terms(j);
            let list: Vec<Vec3> = terms.sources().iter().map(|&i| tangents[i]).collect();
            let sum: f64 = terms.weights().iter().sum();
            prop_assert!((sum - 1.0).abs() < 1e-15);
            let combined = combine(terms.weights(), &list).unwrap();
            // Nearly opposite directions have nearly no plane.
            let opposite = list.windows(2).any(|t| t[0].dot(t[1]) < -0.99);
            prop_assert!(opposite || (made - combined).length() < 1e-11, "{j}: {made:?} {combined:?}");
            prop_assert!((made.length() - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn refinement_turns_with_its_tangents(
        tangents in prop::collection::vec(direction(), 5..9), rule in rules(), ends in all_ends(),
        a in direction(), b in direction()
    ) {
        let Some(frame) = frame(a, b) else { return Ok(()) };
        // Far from opposite, where the plane is a matter of convention.
        let tangents: Vec<Vec3> = tangents.iter().map(|&t| (a + 0.7 * t).normalized()).collect();
        let turned: Vec<Vec3> = tangents.iter().map(|&t| rotated(t, frame)).collect();
        let step = Step::new(rule, ends, tangents.len()).unwrap();
        for (t, turned) in step.directions(&tangents).into_iter().zip(step.directions(&turned)) {
            prop_assert!((rotated(t, frame) - turned).length() < 1e-10);
        }
    }

    #[test]
    fn affected_is_what_depends(
        count in 5..14usize, rule in rules(), clamped in any::<bool>(), a in 0..13usize, b in 0..13usize
    ) {
        let ends = if clamped { Ends::Clamped } else { Ends::Natural };
        let step = Step::new(rule, ends, count).unwrap();
        let changed = a.min(b).min(count - 1)..(a.max(b).min(count - 1) + 1);
        let depends = |j: &usize| step.terms(*j).sources().iter().any(|i| changed.contains(i));
        let all: Vec<usize> = (0..step.refined_count()).filter(depends).collect();
        let range = step.affected(changed.clone());
        prop_assert_eq!(all.first().copied().unwrap_or(range.start), range.start);
        prop_assert_eq!(all.last().map_or(range.end, |j| j + 1), range.end);
    }

    #[test]
    fn means_agree_with_pairs_at_third_order(
        tangents in prop::collection::vec(direction(), 6..7), centre in direction()
    ) {
        // Halving the spread divides the difference by eight; near zero rounding is left.
        let near = |h: f64| -> Vec<Vec3> {
            tangents.iter().map(|&t| (centre + h * t).normalized()).collect()
        };
        let step = Step::new(Rule::FourPoint { w: 1.0 }, Ends::Natural, 6).unwrap();
        let gap = |h: f64| {
            let (list, mean) = (near(h), Blend::Mean);
            let pairs = step.directions(&list).into_iter();
            pairs.zip(step.directions_by(&list, mean)).map(|(a, b)| (a - b).length()).fold(0.0, f64::max)
        };
        let (wide, narrow) = (gap(0.1), gap(0.05));
        prop_assert!(wide < 2e-3, "{wide}");
        prop_assert!(narrow < wide / 5.0 + 1e-6, "{wide} {narrow}");
    }
}

#[test]
fn uniformly_turning_tangents_stay_uniform_under_every_rule() {
    for rule in [Rule::Chaikin, Rule::Cubic, Rule::FourPoint { w: 1.0 }] {
        for ends in [Ends::Natural, Ends::Clamped] {
            let turn = |x: f64| Vec3::new((0.7 * x).cos(), 0.0, (0.7 * x).sin());
            let tangents: Vec<Vec3> = (0..8).map(|i| turn(f64::from(i))).collect();
            let s: Vec<f64> = (0..8).map(f64::from).collect();
            let step = Step::new(rule, ends, 8).unwrap();
            let places = step.numbers(&s);
            let made = step.directions(&tangents);
            let expected: Vec<Vec3> = places.iter().map(|&x| turn(x)).collect();
            assert_near(&made, &expected, 1e-15, rule.name());
        }
    }
}

#[test]
fn published_counts_come_out() {
    let counts = |rule, depth| {
        let mut count = 5;
        for _ in 0..depth {
            count = Step::new(rule, Ends::Natural, count).unwrap().refined_count();
        }
        count
    };
    assert_eq!(counts(Rule::Chaikin, 7), 386);
    assert_eq!(counts(Rule::Cubic, 7), 259);
    assert_eq!(counts(Rule::FourPoint { w: 1.0 }, 6), 257);
}

#[test]
fn too_few_or_wrong_tangents_are_named() {
    let error = Step::new(Rule::Cubic, Ends::Clamped, 3).unwrap_err();
    assert_eq!(error, Error::TooFew { rule: "clamped cubic", needed: 4, count: 3 });
    let mut tangents = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(1.0, 1.0, 0.0)];
    assert!(matches!(sphere::unit(&mut tangents), Err(Error::NotUnit { index: 1, .. })));
    let mut tangents = [Vec3::new(f64::NAN, 0.0, 0.0)];
    assert!(matches!(sphere::unit(&mut tangents), Err(Error::NotUnit { index: 0, .. })));
    let axes = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 1.0)];
    assert_eq!(
        combine(&[0.2, -0.2, 0.4, 0.6], &[axes[0], axes[1], axes[2], axes[0]]),
        Err(Error::Cancels)
    );
    assert!(matches!(combine(&[0.5, 0.4], &axes[..2]), Err(Error::BadNumber { .. })));
    assert!(matches!(combine(&[1.0], &axes), Err(Error::WrongCount { .. })));
    assert!(combine(&[], &[]).is_err());
    assert!(matches!(QiCurve::new(&axes, 4, Knots::Clamped), Err(Error::BadNumber { .. })));
}

#[test]
fn a_midpoint_is_halfway() {
    let (a, b) = (Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0));
    assert_eq!(midpoint(a, b), midpoint(b, a));
    assert_near(&[midpoint(a, b)], &[Vec3::new(0.5f64.sqrt(), 0.5f64.sqrt(), 0.0)], 1e-15, "half");
    assert_eq!(sphere::antipodal_neighbours(&[a, b, -b, a]), vec![1]);
}

/// Two tangents and order 2 make a circular arc of the asked-for length.
#[test]
fn a_qi_curve_of_two_tangents_is_a_circular_arc() {
    let (a, b) = (Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0));
    let curve = QiCurve::new(&[a, b], 2, Knots::Clamped).unwrap();
    let radius = 3.0;
    let length = radius * std::f64::consts::FRAC_PI_2;
    let (points, _) = curve.points(length, Vec3::ZERO, &[0.0, 0.3, 0.5, 1.0]).unwrap();
    let centre = Vec3::new(0.0, radius, 0.0);
    for p in points {
        assert!(((p - centre).length() - radius).abs() < 1e-13, "{p:?}");
    }
}

#[test]
fn a_component_is_set_in_proportion() {
    let t = Vec3::new(0.36, 0.48, 0.8);
    for axis in 0..3 {
        for value in [-1.0, -0.3, 0.0, 0.5, 1.0] {
            let set = sphere::with_component(t, axis, value);
            assert!((set.length() - 1.0).abs() < 1e-15 && (set[axis] - value).abs() < 1e-15);
            let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
            assert!((set[i] * t[j] - set[j] * t[i]).abs() < 1e-15, "{set:?}");
        }
        // What it is already changes nothing.
        assert_near(&[sphere::with_component(t, axis, t[axis])], &[t], 1e-15, "the same");
    }
    let along = sphere::with_component(Vec3::new(0.0, -1.0, 0.0), 1, 0.6);
    assert_near(&[along], &[Vec3::new(0.0, 0.6, 0.8)], 1e-15, "the next coordinate");
    assert_eq!(sphere::with_component(t, 0, 3.0), Vec3::new(1.0, 0.0, 0.0));
}
