//! Pictures of streamline models and of the Gaussian sphere.

use fairform::sphere::{Blend, Ends, Knots, Rule};
use fairform::streamline::{
    Grid, InitialCurve, Integration, LengthFunction, Model, Start, Surface,
};
use fairform::{Scheme, Vec3};
use fairform_render::{
    Axis, Directions, Extent, ModelView, Options, Panel, Part, Picture, Show, SphereView, View,
    render,
};
use proptest::prelude::*;

/// Streamlines that rise and fall, from a straight line.
fn model(rows: usize, columns: usize) -> Model {
    let row = |k: usize| {
        (0..columns).map(move |i| {
            let u = i as f64 / (columns - 1).max(1) as f64;
            let (rise, aside) = (1.2 * (0.5 - u) + 0.05 * k as f64, 0.1 * k as f64 * u);
            Vec3::new(rise.cos(), aside, rise.sin()).normalized()
        })
    };
    let t: Vec<f64> = (0..rows).map(|k| k as f64).collect();
    let points = t.iter().map(|&t| Vec3::new(0.0, t, 0.1 * t)).collect();
    let initial = InitialCurve::Polyline { points, t: t.clone() };
    let grid = Grid::from_rows((0..rows).map(row)).unwrap();
    Model::new(grid, &vec![5.0; rows], t, initial)
}

fn draw(parts: &[Part], view: &View) -> Picture {
    let bodies = parts.iter().map(Part::body).collect();
    let options = Options { ground: false, shadows: false, ..Options::default() };
    render(&[Panel { bodies, title: None }], view, (160, 120), &options).unwrap()
}

fn all() -> ModelView {
    ModelView { show: Show::ALL.to_vec(), ..ModelView::default() }
}

fn arrows_of(surface: &Surface) -> Vec<Vec3> {
    let view = ModelView { show: vec![Show::Arrows], ..ModelView::default() };
    let parts = view.parts(surface);
    parts.iter().flat_map(|part| &part.arrows).map(|arrow| arrow.at).collect()
}

/// Kobbelt's scheme keeps the control tangents, and arcs have a point at each: there the arrows are.
#[test]
fn arrows_are_at_the_places_of_their_tangents() {
    for (depth, start) in [(0, Start::Min), (2, Start::Max), (3, Start::At(7.0))] {
        let integration = Integration::Arcs;
        let model = Model { depth, start, integration, ..model(4, 6) };
        let surface = Surface::new(model).unwrap();
        let arrows = arrows_of(&surface);
        assert_eq!(arrows.len(), 24);
        for (n, at) in arrows.iter().enumerate() {
            let (row, column) = (n / 6, n % 6);
            let expected = surface.points()[(row << depth, column << depth)];
            assert!((*at - expected).length() < 1e-13, "{row} {column} at depth {depth}");
        }
    }
}

/// Where lengths are asked for, the spacing of the control grid is stretched along.
#[test]
fn arrows_stay_at_their_tangents_when_lengths_are_asked_for() {
    let length = LengthFunction::Polyline { lengths: vec![1.0, 9.0], t: vec![0.0, 3.0] };
    let model = Model { depth: 2, integration: Integration::Arcs, ..model(4, 6) };
    let surface = Surface::new(Model { length: Some(length), ..model }).unwrap();
    for (n, at) in arrows_of(&surface).iter().enumerate() {
        let expected = surface.points()[((n / 6) << 2, (n % 6) << 2)];
        assert!((*at - expected).length() < 1e-13, "arrow {n}");
    }
}

/// Natural ends shrink: the arrows beyond them are at the border.
#[test]
fn arrows_beyond_shrunk_ends_are_at_the_border() {
    let model = Model { scheme: Scheme::DooSabin, depth: 2, ..model(4, 6) };
    let surface = Surface::new(model).unwrap();
    let (points, arrows) = (surface.points(), arrows_of(&surface));
    let (rows, columns) = (points.row_count(), points.column_count());
    let corners = [(0, 0), (0, columns - 1), (rows - 1, 0), (rows - 1, columns - 1)];
    for (arrow, corner) in [0, 5, 18, 23].into_iter().zip(corners) {
        assert!((arrows[arrow] - points[corner]).length() < 1e-13, "{corner:?}");
    }
}

/// Teeth of combs on circles are as long as each other, and point away from the centre.
#[test]
fn combs_are_curvature() {
    let turn = |i: usize| 0.2 * i as f64;
    let row = || (0..8).map(move |i| Vec3::new(-turn(i).sin(), turn(i).cos(), 0.0));
    let points = vec![Vec3::new(5.0, 0.0, 0.0), Vec3::new(5.0, 0.0, 2.0)];
    let initial = InitialCurve::Polyline { points, t: vec![0.0, 1.0] };
    let grid = Grid::from_rows([row(), row()]).unwrap();
    // Radius 5.
    let model = Model::new(grid, &[7.0; 2], vec![0.0, 1.0], initial);
    let model = Model { integration: Integration::Arcs, depth: 1, ..model };
    let surface = Surface::new(model).unwrap();
    let view = ModelView { show: vec![Show::Combs], ..ModelView::default() };
    let parts = view.parts(&surface);
    let comb = parts.last().unwrap();
    let points = surface.points().values();
    let (low, high) = points.iter().fold((points[0], points[0]), |(l, h), &p| (l.min(p), h.max(p)));
    let expected = view.comb * (high - low).length();
    let teeth: Vec<_> = comb.strokes.iter().filter(|(_, line)| line.width < 2.0).collect();
    assert_eq!(teeth.len(), 2 * 14);
    for ([foot, tip], _) in teeth {
        let [foot, tip] = [foot, tip].map(|&v| comb.positions[v as usize]);
        let flat = |p: Vec3| Vec3::new(p.x, p.y, 0.0);
        assert!(((tip - foot).length() - expected).abs() < 1e-9, "{:?}", tip - foot);
        assert!((tip - foot).dot(flat(foot)) > 0.99 * expected * 5.0 * 0.99);
    }
}

/// Seen from above, the initial curve is the left border of the surface, and from the right hidden by it.
#[test]
fn a_model_is_where_it_is_expected() {
    let surface = Surface::new(Model { depth: 2, ..model(4, 6) }).unwrap();
    let changed = |from: &str| -> Vec<(u32, u32)> {
        let [with, without] = [&[Show::Surface, Show::Initial][..], &[Show::Surface]].map(|show| {
            let view = ModelView { show: show.to_vec(), ..ModelView::default() };
            draw(&view.parts(&surface), &from.parse().unwrap())
        });
        let all = (0..120).flat_map(|y| (0..160).map(move |x| (x, y)));
        all.filter(|&(x, y)| with.get(x, y) != without.get(x, y)).collect()
    };
    let above = changed("top,z");
    assert!(above.len() > 50 && above.iter().all(|(x, _)| *x < 40), "{above:?}");
    assert_eq!(changed("90,12,z"), []);
}

/// What is on the far side of the sphere is fainter, but there.
#[test]
fn the_far_side_of_the_sphere_is_fainter() {
    let control = [-0.3, 0.0, 0.3].map(|a: f64| Vec3::new(a.sin(), 0.3, a.cos()).normalized());
    let directions =
        Directions::subdivided(control.to_vec(), Rule::Chaikin, Ends::Natural, 3).unwrap();
    let view = SphereView { points: false, arcs: false, ..SphereView::default() };
    let blues = |directions: &[Directions], from: &str| -> f64 {
        let picture = draw(&view.parts(directions), &from.parse().unwrap());
        picture.pixels.iter().map(|p| f64::from(p[2]) - f64::from(p[0])).sum()
    };
    let own = |from: &str| blues(std::slice::from_ref(&directions), from) - blues(&[], from);
    let (near, far) = (own("front"), own("back"));
    assert!(near > 400.0 && far > 0.1 * near && far < 0.6 * near, "{near} {far}");
}

#[test]
fn the_first_control_tangent_is_red_and_the_others_yellow() {
    let at = |a: f64| Vec3::new(a.sin(), 0.1, a.cos()).normalized();
    let control = vec![at(-0.6), at(0.0), at(0.6)];
    let directions = Directions::subdivided(control, Rule::Cubic, Ends::Natural, 2).unwrap();
    let parts = SphereView { up: Axis::Y, ..SphereView::default() }.parts(&[directions]);
    let picture = draw(&parts, &"front".parse().unwrap());
    let columns = |is: fn([u8; 4]) -> bool| -> Vec<u32> {
        (0..160).filter(|&x| (0..120).any(|y| is(picture.get(x, y)))).collect()
    };
    let red = columns(|[r, g, b, _]| r > 130 && g < 70 && b < 70);
    let yellow = columns(|[r, g, b, _]| r > 150 && g > 110 && b < 80);
    assert!(!red.is_empty() && red.iter().all(|&x| x < 75), "{red:?}");
    assert!(yellow.iter().any(|&x| (76..85).contains(&x)) && yellow.iter().any(|&x| x > 100));
}

#[test]
fn the_bytes_do_not_depend_on_the_threads() {
    let surface = Surface::new(Model { depth: 1, start: Start::At(6.0), ..model(3, 5) }).unwrap();
    let rows = Directions::rows(surface.model()).unwrap();
    let pictures = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let sphere = SphereView { beads: true, ..SphereView::default() };
            [all().parts(&surface), sphere.parts(&rows)].map(|p| draw(&p, &View::default()))
        })
    };
    let one = pictures(1);
    for threads in [2, 5] {
        assert!(pictures(threads) == one, "{threads} threads");
    }
}

fn direction() -> impl Strategy<Value = Vec3> {
    prop_oneof![
        4 => prop::array::uniform3(-1.0..1.0).prop_map(Vec3::from),
        1 => prop::array::uniform3(-1_i8..=1).prop_map(|d| Vec3::from(d.map(f64::from))),
    ]
    .prop_map(|d| if d.length() > 1e-3 { d.normalized() } else { Vec3::new(1.0, 0.0, 0.0) })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Any model has a picture, and so have its directions, opposite and equal neighbours included.
    #[test]
    fn any_model_is_drawn(
        (columns, tangents) in (1_usize..6, 1_usize..5).prop_flat_map(|(columns, rows)| {
            (Just(columns), prop::collection::vec(direction(), rows * columns))
        }),
        scheme in prop::sample::select(vec![Scheme::Kobbelt, Scheme::DooSabin, Scheme::CatmullClark]),
        ends in prop::sample::select(vec![Ends::Natural, Ends::Clamped]),
        start in prop_oneof![
            Just(Start::Min), Just(Start::Max),
            (-9.0..9.0).prop_map(Start::At), (0.0..1.0).prop_map(Start::Fraction),
        ],
        arcs in any::<bool>(),
        length in prop_oneof![Just(1e-9), 0.1..10.0, Just(1e9)],
        flat in any::<bool>(),
        depth in 0_u32..3,
    ) {
        let grid = Grid::from_values(columns, tangents).unwrap();
        let rows = grid.row_count();
        let t: Vec<f64> = (0..rows).map(|k| k as f64).collect();
        let points = t.iter().map(|&t| Vec3::new(0.0, if flat { 0.0 } else { t }, 1.0)).collect();
        let initial = InitialCurve::Polyline { points, t: t.clone() };
        let integration = if arcs { Integration::Arcs } else { Integration::Midpoint };
        let model = Model {
            scheme, ends, start, integration, depth, blend: Blend::Pairs,
            ..Model::new(grid, &vec![length; rows], t, initial)
        };
        // Too few tangents for the scheme have no surface.
        if let Ok(surface) = Surface::new(model) {
            let parts = all().parts(&surface);
            let shortest = Extent::Space(0.0);
            prop_assert!(parts.iter().flat_map(|p| &p.arrows).all(|a| a.length != shortest));
            draw(&parts, &View::default());
            if let Ok(rows) = Directions::rows(surface.model()) {
                draw(&SphereView { beads: true, ..SphereView::default() }.parts(&rows), &View::default());
            }
        }
    }

    /// So has any QI curve.
    #[test]
    fn any_qi_curve_is_drawn(
        control in prop::collection::vec(direction(), 1..7),
        share in 0.0..1.0,
        clamped in any::<bool>(),
    ) {
        let order = 1 + (share * control.len() as f64) as usize;
        let knots = if clamped { Knots::Clamped } else { Knots::Uniform };
        let directions = Directions::qi(control, order, knots, 50).unwrap();
        draw(&SphereView::default().parts(&[directions]), &View::default());
    }
}
