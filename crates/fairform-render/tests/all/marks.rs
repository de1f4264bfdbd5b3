//! Arrows, lines and points: where they are seen, and what hides them.

use fairform::{Faces, Vec3};
use fairform_render::{
    Arrow, Body, Colour, Dot, Extent, Head, Line, Options, Panel, Part, Picture, RenderError,
    Style, View, render,
};

const RED: Colour = Colour::hex(0xff_00_00);
const BLUE: Colour = Colour::hex(0x00_00_ff);

fn bare() -> Options {
    Options { background: Colour::WHITE, ground: false, shadows: false, ..Options::default() }
}

fn draw(bodies: Vec<Body<'_>>, view: &View) -> Picture {
    render(&[Panel { bodies, title: None }], view, (200, 200), &bare()).unwrap()
}

fn front() -> View {
    "front".parse().unwrap()
}

/// A white square of side 2, `z` before the origin.
fn wall(z: f64) -> Part {
    let corners = [[-1., -1., z], [1., -1., z], [1., 1., z], [-1., 1., z]];
    Part {
        positions: corners.map(Vec3::from).to_vec(),
        faces: Faces::uniform(4, vec![0, 1, 2, 3]),
        style: Style { fill: Some(Colour::WHITE), glow: 1.0, ..Style::default() },
        ..Part::default()
    }
}

fn arrow(at: [f64; 3], direction: [f64; 3]) -> Arrow {
    Arrow {
        colour: RED,
        shaded: false,
        length: Extent::Picture(180.0),
        ..Arrow::new(at.into(), direction.into())
    }
}

fn with_arrows(arrows: Vec<Arrow>) -> Part {
    Part { arrows, ..Part::default() }
}

/// How red a pixel is, from 0 to 1, on white.
fn red(picture: &Picture, x: u32, y: u32) -> f64 {
    let [r, g, b, _] = picture.get(x, y).map(f64::from);
    (r - g.max(b)).max(0.0) / 255.0
}

fn reds(picture: &Picture) -> f64 {
    (0..200).flat_map(|y| (0..200).map(move |x| (x, y))).map(|(x, y)| red(picture, x, y)).sum()
}

/// From the front, an arrow of length 1 upward from the middle of a wall of side 2 ends where the wall
/// does; its head is wider than its shaft.
#[test]
fn an_arrow_points_from_its_place_to_its_tip() {
    let up = Arrow { length: Extent::Space(1.0), ..arrow([0., 0., 0.], [0., 7., 0.]) };
    let (wall, part) = (wall(0.0), with_arrows(vec![up]));
    let picture = draw(vec![wall.body(), part.body()], &front());
    // A margin of 12 pixels: the wall is seen from 12 to 188.
    let width = |y: u32| (0..200).map(|x| red(&picture, x, y)).sum::<f64>();
    assert!(width(102) < 0.1 && width(9) < 0.1, "{} {}", width(102), width(9));
    for y in 14..98 {
        assert!(red(&picture, 99, y) > 0.0 || red(&picture, 100, y) > 0.0, "row {y}");
    }
    let (shaft, head) = (width(70), width(40));
    assert!(shaft > 3.0 && head > 2.0 * shaft, "{shaft} {head}");
    assert!(width(16) < 0.4 * head, "{}", width(16));
}

#[test]
fn arrows_of_the_picture_keep_their_size_when_magnified() {
    let (wall, part) = (wall(0.0), with_arrows(vec![arrow([0.; 3], [1., 0., 0.])]));
    let size = |zoom| reds(&draw(vec![wall.body(), part.body()], &View { zoom, ..front() }));
    let (one, four) = (size(1.0), size(4.0));
    assert!(one > 20.0 && (one - four).abs() < 0.12 * one, "{one} {four}");
}

#[test]
fn a_wall_hides_arrows_behind_it_and_not_on_it() {
    let wall = wall(0.0);
    let seen = |z: f64| {
        let part = with_arrows(vec![arrow([0., 0., z], [1., 0., 0.])]);
        reds(&draw(vec![wall.body(), part.body()], &front()))
    };
    let (before, on, behind) = (seen(0.5), seen(0.0), seen(-0.5));
    assert!(before > 20.0 && on > 0.9 * before, "{before} {on}");
    assert!(behind < 1e-9, "{behind}");
}

/// Of two equal arrows one hides the other, unless they have different heads.
#[test]
fn arrows_that_coincide_differ_by_their_heads() {
    let wall = wall(0.0);
    let of = |index: usize, colour: Colour| Arrow {
        head: Head::of_index(index),
        colour,
        ..arrow([0., 0., 0.], [1., 0., 0.])
    };
    let blues = |picture: &Picture| {
        picture.pixels.iter().filter(|p| p[2] > 200 && p[0] < 60 && p[1] < 60).count()
    };
    let reds = |picture: &Picture| {
        picture.pixels.iter().filter(|p| p[0] > 200 && p[1] < 60 && p[2] < 60).count()
    };
    for (a, b) in [(0, 1), (0, 2), (0, 3), (1, 3), (2, 3), (1, 2)] {
        // The one with more behind its cone is seen whichever is drawn first.
        for [first, second] in [[of(a, RED), of(b, BLUE)], [of(b, BLUE), of(a, RED)]] {
            let part = with_arrows(vec![first, second]);
            let panel = Panel { bodies: vec![wall.body(), part.body()], title: None };
            let picture = render(&[panel], &front(), (600, 600), &bare()).unwrap();
            assert!(reds(&picture) > 20 || a == 0, "{a} {b}: {}", reds(&picture));
            assert!(blues(&picture) > 20, "{a} {b}: {}", blues(&picture));
        }
    }
}

fn line(z: f64, through: f64) -> Part {
    let mut part = Part { style: Style { through, ..Style::default() }, ..Part::default() };
    let points = [[-0.9, 0., z], [0., 0., z], [0.9, 0., z]].map(Vec3::from);
    part.polyline(points, Line { colour: RED, width: 30.0 });
    part
}

#[test]
fn lines_show_through_as_much_as_they_are_asked_to() {
    let wall = wall(0.0);
    let seen = |z: f64, through: f64| {
        let line = line(z, through);
        red(&draw(vec![wall.body(), line.body()], &front()), 60, 99)
    };
    assert!(seen(0.2, 0.0) > 0.99 && seen(0.2, 0.3) > 0.99);
    assert_eq!(seen(-0.2, 0.0), 0.0);
    let (some, more) = (seen(-0.2, 0.2), seen(-0.2, 0.5));
    assert!(some > 0.05 && more > some + 0.1 && more < 0.5, "{some} {more}");
}

#[test]
fn points_show_through_as_much_as_they_are_asked_to() {
    let wall = wall(0.0);
    let seen = |z: f64, through: f64| {
        let dot = Dot { colour: RED, radius: 40.0 };
        let style = Style { points: Some(dot), glow: 1.0, through, ..Style::default() };
        let part = Part { positions: vec![Vec3::new(0., 0., z)], style, ..Part::default() };
        red(&draw(vec![wall.body(), part.body()], &front()), 99, 103)
    };
    assert!(seen(0.2, 0.3) > 0.7, "{}", seen(0.2, 0.3));
    assert_eq!(seen(-0.4, 0.0), 0.0);
    assert!(seen(-0.4, 0.3) > 0.08 && seen(-0.4, 0.3) < 0.4, "{}", seen(-0.4, 0.3));
}

/// Half opaque red over blue is both; where the strokes of one line meet it is no darker.
#[test]
fn translucent_lines_let_others_through_and_have_no_knots() {
    let wall = wall(0.0);
    let half = Line { colour: RED.with_opacity(0.5), width: 30.0 };
    let mut over = Part::default();
    over.polyline([[-0.9, 0., 0.2], [0., 0., 0.2], [0.9, 0., 0.2]].map(Vec3::from), half);
    let mut under = Part::default();
    under.polyline(
        [[0.5, -0.9, 0.1], [0.5, 0.9, 0.1]].map(Vec3::from),
        Line { colour: BLUE, width: 30.0 },
    );
    for bodies in
        [vec![wall.body(), over.body(), under.body()], vec![wall.body(), under.body(), over.body()]]
    {
        let picture = draw(bodies, &front());
        let crossing = 145;
        let [r, g, b, _] = picture.get(crossing, 100);
        assert!(r > 150 && b > 150 && g < 40, "{r} {g} {b}");
        assert_eq!(picture.get(100, 100), picture.get(60, 100));
    }
}

#[test]
fn wrong_arrows_are_named() {
    let check = |arrow: Arrow| {
        let part = with_arrows(vec![Arrow::new(Vec3::ZERO, Vec3::ZERO), arrow]);
        let panel = Panel { bodies: vec![part.body()], title: None };
        render(&[panel], &front(), (64, 64), &bare()).map(|_| ())
    };
    let infinite = Vec3::new(0.0, f64::INFINITY, 0.0);
    let expected = Err(RenderError::Arrow { panel: 0, body: 0, arrow: 1 });
    assert_eq!(check(Arrow::new(infinite, Vec3::ZERO)), expected);
    assert_eq!(check(Arrow::new(Vec3::ZERO, infinite)), expected);
    for length in [Extent::Picture(-1.0), Extent::Space(f64::NAN), Extent::Picture(1e3)] {
        let wrong = check(Arrow { length, ..arrow([0.; 3], [1., 0., 0.]) });
        assert!(matches!(wrong, Err(RenderError::Style { .. })), "{length:?}");
    }
    // Longer than the way to the eye, and of no direction: not drawn, but not wrong.
    assert_eq!(
        check(Arrow { length: Extent::Space(1e300), ..arrow([0.; 3], [1., 0., 0.]) }),
        Ok(())
    );
    assert_eq!(check(arrow([0.; 3], [0.; 3])), Ok(()));
}
