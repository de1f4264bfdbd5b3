//! Colours by number, their bars, and mirrors.

use fairform::{Faces, Vec3};
use fairform_render::{
    Body, Colour, ColourMap, Line, Options, Panel, Picture, Range, RenderError, Style, Surface,
    Values, View, render,
};
use proptest::prelude::*;

const SIZE: (u32, u32) = (120, 90);

/// No shadows, and nothing where nothing is.
fn bare() -> Options {
    Options { background: Colour::TRANSPARENT, shadows: false, ground: false, ..Options::default() }
}

fn front() -> View {
    "front".parse().unwrap()
}

fn draw(body: &Body, view: &View, options: &Options) -> Picture {
    render(&[Panel { bodies: vec![*body], title: None }], view, SIZE, options).unwrap()
}

/// Squares side by side, `n` by `n`, in the plane z = 0 from −1 to 1.
fn sheet(n: u32) -> (Vec<Vec3>, Faces) {
    let at = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
    let positions = (0..=n).flat_map(|j| (0..=n).map(move |i| Vec3::new(at(i), at(j), 0.0)));
    let index = |i: u32, j: u32| j * (n + 1) + i;
    let faces = (0..n).flat_map(|j| {
        (0..n).map(move |i| [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)])
    });
    (positions.collect(), faces.collect())
}

/// A ball of radius 1 of squares and triangles, with its normals as positions.
fn ball(n: u32) -> (Vec<Vec3>, Faces) {
    let at = |i: u32, j: u32| {
        let (u, v) = (std::f64::consts::TAU * f64::from(i) / f64::from(2 * n), {
            std::f64::consts::PI * f64::from(j) / f64::from(n)
        });
        Vec3::new(libm::sin(v) * libm::sin(u), libm::cos(v), libm::sin(v) * libm::cos(u))
    };
    let positions = (0..=n).flat_map(|j| (0..2 * n).map(move |i| at(i, j)));
    let index = |i: u32, j: u32| j * 2 * n + i % (2 * n);
    let faces = (0..n).flat_map(|j| {
        (0..2 * n)
            .map(move |i| [index(i, j), index(i, j + 1), index(i + 1, j + 1), index(i + 1, j)])
    });
    (positions.collect(), faces.collect())
}

/// From 0 to 360, and how strong the colour is from 0 to 1.
fn hue([r, g, b, _]: [u8; 4]) -> (f64, f64) {
    let [r, g, b] = [r, g, b].map(f64::from);
    let (most, least) = (r.max(g).max(b), r.min(g).min(b));
    let range = (most - least).max(1.0);
    let hue = match most {
        m if m == r => (g - b) / range,
        m if m == g => 2.0 + (b - r) / range,
        _ => 4.0 + (r - g) / range,
    };
    ((60.0 * hue).rem_euclid(360.0), (most - least) / most.max(1.0))
}

fn is_near(a: [u8; 4], b: Colour, by: f64) -> bool {
    let bytes = [b.r, b.g, b.b].map(|c| 255.0 * c);
    (0..3).all(|k| (f64::from(a[k]) - bytes[k]).abs() <= by)
}

#[test]
fn the_greatest_is_yellow_and_the_least_violet() {
    let (positions, faces) = sheet(16);
    let of: Vec<f64> = positions.iter().map(|p| p.x).collect();
    let mut body = Body::new(&positions, &faces);
    body.values = Some(Values::per_vertex(&of));
    let picture = draw(&body, &front(), &bare());
    let [left, right] = [22, 98].map(|x| hue(picture.get(x, 45)));
    assert!((270.0..310.0).contains(&left.0) && left.1 > 0.5, "{left:?}");
    assert!((48.0..66.0).contains(&right.0) && right.1 > 0.6, "{right:?}");
    let middle = hue(picture.get(60, 45));
    assert!((160.0..190.0).contains(&middle.0), "{middle:?}");
}

/// The sign shows, and zero is grey white, also where the numbers are lopsided.
#[test]
fn signs_are_red_and_blue() {
    let (positions, faces) = sheet(32);
    let of: Vec<f64> = positions.iter().map(|p| if p.x > 0.0 { 3.0 * p.x } else { p.x }).collect();
    let mut body = Body::new(&positions, &faces);
    body.values = Some(Values { map: ColourMap::CoolWarm, ..Values::per_vertex(&of) });
    let picture = draw(&body, &front(), &bare());
    let [left, middle, right] = [22, 60, 98].map(|x| picture.get(x, 45));
    assert!(left[2] > left[0].saturating_add(30), "{left:?}");
    assert!(right[0] > right[2].saturating_add(100), "{right:?}");
    assert!(hue(middle).1 < 0.1, "{middle:?}");
    // A third of the way to the end is paler than the end.
    assert!(hue(left).1 < 0.7 * hue(right).1, "{left:?} {right:?}");
}

/// Also a middle point of a large polygon has no value if a corner has none.
#[test]
fn what_has_no_value_is_grey() {
    let (positions, faces) = sheet(2);
    let grey = |p: [u8; 4]| hue(p).1 < 0.06 && (90..230).contains(&p[0]);
    // Bottom left corner of four squares.
    let mut of = vec![1.0; 9];
    of[0] = f64::NAN;
    of[8] = 2.0;
    let mut body = Body::new(&positions, &faces);
    body.values = Some(Values { map: ColourMap::Cyclic, ..Values::per_vertex(&of) });
    let picture = draw(&body, &front(), &bare());
    assert!(grey(picture.get(30, 75)), "{:?}", picture.get(30, 75));
    assert!(!grey(picture.get(90, 75)) && !grey(picture.get(30, 15)));
    let per_face = [f64::NAN, 0.0, 0.5, 1.0];
    body.values = Some(Values::per_face(&per_face));
    let picture = draw(&body, &front(), &bare());
    assert!(grey(picture.get(30, 75)), "{:?}", picture.get(30, 75));
    assert!(!grey(picture.get(90, 75)) && !grey(picture.get(30, 15)));
    // A negative number has no logarithm; zero is the least of all.
    let per_face = [-1.0, 0.0, 0.5, 1.0];
    body.values = Some(Values { log: true, ..Values::per_face(&per_face) });
    let picture = draw(&body, &front(), &bare());
    assert!(grey(picture.get(30, 75)));
    assert!((270.0..310.0).contains(&hue(picture.get(90, 75)).0));
}

#[test]
fn each_face_has_one_colour() {
    let (positions, faces) = sheet(2);
    let mut body = Body::new(&positions, &faces);
    let of = [0.0, 1.0, 2.0, 3.0];
    body.values = Some(Values::per_face(&of));
    let picture = draw(&body, &front(), &bare());
    // Two places of a square are alike; squares differ.
    let near = |a: [u8; 4], b: [u8; 4]| (0..3).all(|k| a[k].abs_diff(b[k]) < 12);
    for (x, y) in [(30, 70), (90, 70), (30, 20), (90, 20)] {
        assert!(near(picture.get(x - 6, y), picture.get(x + 6, y - 6)));
    }
    assert!(!near(picture.get(30, 70), picture.get(90, 70)));
    assert!(!near(picture.get(30, 70), picture.get(30, 20)));
}

/// As many colours as bands, and lines between them.
#[test]
fn bands_and_isolines_are_where_they_belong() {
    let (positions, faces) = sheet(7);
    let of: Vec<f64> = positions.iter().map(|p| p.x).collect();
    let mut body = Body::new(&positions, &faces);
    let range = Range::Between(-1.0, 1.0);
    let values = Values { range, bands: Some(4), ..Values::per_vertex(&of) };
    body.values = Some(values);
    let options = Options { columns: Some(1), ..bare() };
    let row = |body: Body| -> Vec<[u8; 4]> {
        let picture =
            render(&[Panel { bodies: vec![body], title: None }], &front(), (400, 400), &options)
                .unwrap();
        (0..400).map(|x| picture.get(x, 200)).filter(|p| p[3] == 255).collect()
    };
    let banded = row(body);
    let jump = |w: &[[u8; 4]]| (0..3).any(|k| w[0][k].abs_diff(w[1][k]) > 8);
    let jumps: Vec<usize> = (1..banded.len()).filter(|&i| jump(&banded[i - 1..=i])).collect();
    // A jump may take two steps, where a pixel is partly of one band.
    let places: Vec<usize> = jumps
        .iter()
        .enumerate()
        .filter(|&(i, &x)| i == 0 || x > jumps[i - 1] + 2)
        .map(|(_, &x)| x)
        .collect();
    assert_eq!(places.len(), 3, "{jumps:?}");
    for (i, &x) in places.iter().enumerate() {
        let share = x as f64 / banded.len() as f64;
        assert!((share - 0.25 * (i + 1) as f64).abs() < 0.01, "{share}");
    }
    let line = Line { colour: Colour::WHITE, width: 12.0 };
    body.values = Some(Values { bands: None, isolines: Some(line), ..values });
    // At −1, −0.5, 0, 0.5 and 1, half of the outer two; each of 4.8 pixels.
    let white = row(body).iter().filter(|p| p[0] > 225 && p[2] > 225).count();
    assert!((15..=21).contains(&white), "{white} white pixels");
}

/// At the seam of a circle the colours go on, not once around.
#[test]
fn a_cyclic_map_has_no_seam() {
    let (positions, faces) = sheet(9);
    let turn = |p: &Vec3| (0.9 + 0.1 * (p.x + 1.0)).rem_euclid(1.0);
    let of: Vec<f64> = positions.iter().map(turn).collect();
    let mut body = Body::new(&positions, &faces);
    let values = Values {
        map: ColourMap::Cyclic,
        range: Range::Between(0.0, 1.0),
        ..Values::per_vertex(&of)
    };
    body.values = Some(values);
    let picture = draw(&body, &front(), &bare());
    let green = (22..98).filter(|&x| {
        let h = hue(picture.get(x, 45)).0;
        (90.0..220.0).contains(&h)
    });
    assert_eq!(green.count(), 0);
}

/// One bar at the right if the numbers are of one kind; one below each panel if not.
#[test]
fn bars_are_where_they_are_wanted() {
    let (positions, faces) = sheet(4);
    let of: Vec<f64> = positions.iter().map(|p| p.x).collect();
    let body = |map: ColourMap, legend: Option<&'static str>| {
        let values = Values { map, legend, ..Values::per_vertex(&of) };
        Body { values: Some(values), ..Body::new(&positions, &faces) }
    };
    let picture = |bodies: &[Body], shared_range: bool| {
        let panels: Vec<Panel> =
            bodies.iter().map(|&b| Panel { bodies: vec![b], title: None }).collect();
        let options = Options { background: Colour::WHITE, shared_range, ..bare() };
        render(&panels, &front(), (480, 240), &options).unwrap()
    };
    // Columns of a part of the picture that hold both ends of the map.
    let has_bar = |picture: &Picture, columns: std::ops::Range<u32>, rows: std::ops::Range<u32>| {
        let holds = |t: f64| {
            let colour = ColourMap::Viridis.at(t);
            columns
                .clone()
                .flat_map(|x| rows.clone().map(move |y| (x, y)))
                .filter(|&(x, y)| is_near(picture.get(x, y), colour, 4.0))
                .count()
                >= 4
        };
        holds(0.01) && holds(0.99)
    };
    let (viridis, warm) = (ColourMap::Viridis, ColourMap::CoolWarm);
    let named = body(viridis, Some("x (mm)"));
    let one = picture(&[named, named], true);
    assert!(has_bar(&one, 400..480, 0..240));
    assert!(!has_bar(&one, 0..400, 200..240));
    let each = picture(&[named, named], false);
    assert!(has_bar(&each, 0..240, 180..240) && has_bar(&each, 240..480, 180..240));
    let mixed = picture(&[named, body(warm, Some("x (mm)"))], true);
    assert!(has_bar(&mixed, 0..240, 180..240) && !has_bar(&mixed, 240..480, 180..240));
    let none = picture(&[body(viridis, None), body(viridis, None)], true);
    assert_eq!(none.get(479, 120), [255; 4]);
    assert!(!has_bar(&none, 440..480, 0..240) && !has_bar(&none, 0..480, 230..240));
}

/// The same number has the same colour in all panels, or each panel uses all colours.
#[test]
fn panels_are_measured_together_or_alone() {
    let (positions, faces) = sheet(4);
    let small: Vec<f64> = positions.iter().map(|p| p.x).collect();
    let large: Vec<f64> = positions.iter().map(|p| 10.0 * p.x).collect();
    let panels = [&small, &large].map(|of| {
        let values = Some(Values { map: ColourMap::CoolWarm, ..Values::per_vertex(of) });
        Panel { bodies: vec![Body { values, ..Body::new(&positions, &faces) }], title: None }
    });
    let strongest = |shared_range: bool| {
        let options = Options { shared_range, ..bare() };
        let picture = render(&panels, &front(), (200, 100), &options).unwrap();
        [0..100, 100..200].map(|columns: std::ops::Range<u32>| {
            columns.map(|x| hue(picture.get(x, 50)).1).fold(0.0, f64::max)
        })
    };
    let [small, large] = strongest(true);
    assert!(small < 0.4 * large, "{small} {large}");
    let [small, large] = strongest(false);
    assert!((small - large).abs() < 0.02, "{small} {large}");
}

#[test]
fn stripes_depend_on_the_view_and_not_on_the_order() {
    let (positions, faces) = ball(24);
    let style = Style { surface: Surface::ZEBRA, ..Style::default() };
    let striped = Body { normals: Some(&positions), style, ..Body::new(&positions, &faces) };
    let view: View = "20,10".parse().unwrap();
    let here = draw(&striped, &view, &bare());
    let dark = |p: &Picture| p.pixels.iter().filter(|p| p[3] == 255 && p[0] < 90).count();
    let all = here.pixels.iter().filter(|p| p[3] == 255).count();
    assert!((all / 4..3 * all / 4).contains(&dark(&here)), "{} of {all}", dark(&here));

    let differ = |a: &Picture, b: &Picture| {
        a.pixels.iter().zip(&b.pixels).filter(|(a, b)| a[0].abs_diff(b[0]) > 40).count()
    };
    let above = draw(&striped, &"20,40".parse().unwrap(), &bare());
    assert!(differ(&here, &above) > all / 8);

    // The vertices and the faces back to front.
    let last = positions.len() as u32 - 1;
    let back: Vec<Vec3> = positions.iter().rev().copied().collect();
    let turned: Vec<Vec<u32>> =
        faces.iter().map(|f| f.iter().map(|&v| last - v).collect()).collect();
    let turned: Faces = turned.into_iter().rev().collect();
    let body = Body { normals: Some(&back), style, ..Body::new(&back, &turned) };
    assert_eq!(differ(&here, &draw(&body, &view, &bare())), 0);

    let plain = Body { style: Style::default(), ..striped };
    assert!(differ(&here, &draw(&plain, &view, &bare())) > all / 4);
}

/// The number of stripes seen on a mirror ball is that of the world, since it shows all of it.
#[test]
fn a_ball_shows_all_stripes() {
    let (positions, faces) = ball(64);
    let surface = "zebra,y,6".parse().unwrap();
    let style = Style { surface, ..Style::default() };
    let body = Body { normals: Some(&positions), style, ..Body::new(&positions, &faces) };
    let panel = [Panel { bodies: vec![body], title: None }];
    let picture = render(&panel, &front(), (900, 900), &bare()).unwrap();
    let column: Vec<bool> =
        (0..900).map(|y| picture.get(450, y)).filter(|p| p[3] == 255).map(|p| p[0] < 110).collect();
    let stripes = column.chunk_by(|a, b| a == b).filter(|run| run[0]).count();
    // From the middle upwards the mirror turns from the horizon to the pole and on behind it.
    assert_eq!(stripes, 12, "six in front and six behind");
}

#[test]
fn lamps_are_light_on_dark() {
    let (positions, faces) = ball(48);
    let style = Style { surface: Surface::REFLECTION, ..Style::default() };
    let body = Body { normals: Some(&positions), style, ..Body::new(&positions, &faces) };
    let picture = draw(&body, &"20,10".parse().unwrap(), &bare());
    let seen = || picture.pixels.iter().filter(|p| p[3] == 255);
    let (all, dark) = (seen().count(), seen().filter(|p| p[0] < 90).count());
    let light = seen().filter(|p| p[0] > 190).count();
    assert!(dark > all / 4 && light > all / 20, "{dark} dark and {light} light of {all}");
}

/// Strokes need no edge, and hide behind surfaces.
#[test]
fn strokes_join_the_vertices_they_name() {
    let (positions, faces) = sheet(1);
    let red = Line { colour: Colour::hex(0xff_00_00), width: 40.0 };
    let is_red = |p: [u8; 4]| p[0] > 200 && p[1] < 40;
    let strokes = [([1, 3], red), ([1, 2], red)];
    let body = Body { strokes: &strokes, ..Body::new(&positions, &faces) };
    let picture = draw(&body, &front(), &bare());
    // An edge at the right, and a diagonal.
    let rightmost = (0..SIZE.0).rev().find(|&x| picture.get(x, 45)[3] == 255).unwrap();
    assert!(is_red(picture.get(rightmost - 1, 45)));
    assert!(is_red(picture.get(60, 44)));
    assert!(!is_red(picture.get(40, 60)));
    let none = Body { strokes: &[], ..body };
    assert!(!is_red(draw(&none, &front(), &bare()).get(60, 44)));
    // Without faces the strokes are all there is to see.
    let no_faces = Faces::new();
    let lonely = Body { strokes: &strokes[1..], ..Body::new(&positions, &no_faces) };
    assert!(is_red(draw(&lonely, &front(), &bare()).get(60, 44)));
}

#[test]
fn titles_have_a_second_line() {
    let (positions, faces) = sheet(1);
    let written = |title: &str| {
        let panel =
            Panel { bodies: vec![Body::new(&positions, &faces)], title: Some(title.into()) };
        let options = Options { background: Colour::WHITE, ..bare() };
        let picture = render(&[panel], &front(), (300, 300), &options).unwrap();
        let has_ink = |y: &u32| (0..300).any(|x| picture.get(x, *y)[0] < 200);
        (265..300).filter(has_ink).collect::<Vec<u32>>()
    };
    let (one, two) = (written("mean"), written("mean\ncurvature"));
    assert!(two.len() > one.len() + 4, "{one:?} {two:?}");
    assert!(written("\n\n").is_empty() || written("").len() <= one.len());
}

#[test]
fn the_bytes_do_not_depend_on_the_threads() {
    let (positions, faces) = ball(12);
    let of: Vec<f64> = positions.iter().map(|p| p.x * p.y).collect();
    let line = Line::default();
    let values = Values {
        map: ColourMap::CoolWarm,
        isolines: Some(line),
        legend: Some("xy"),
        ..Values::per_vertex(&of)
    };
    let strokes = [([0, 40], line)];
    let draw = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let panels = [Surface::Plain, Surface::ZEBRA, Surface::REFLECTION].map(|surface| {
            let style = Style { surface, ..Style::default() };
            let body = Body {
                style,
                strokes: &strokes,
                values: Some(values),
                ..Body::new(&positions, &faces)
            };
            Panel { bodies: vec![body], title: Some("a\nb".into()) }
        });
        pool.install(|| render(&panels, &View::default(), (360, 160), &Options::default()).unwrap())
    };
    let one = draw(1);
    for threads in [2, 5] {
        assert!(draw(threads) == one, "{threads} threads");
    }
}

#[test]
fn wrong_input_is_named() {
    let (positions, faces) = sheet(1);
    let fails = |body: Body| {
        let panel = Panel { bodies: vec![body], title: None };
        render(&[panel], &front(), SIZE, &bare()).unwrap_err()
    };
    let body = Body::new(&positions, &faces);
    let with = |values: Values<'static>| fails(Body { values: Some(values), ..body });
    let three = Values::per_vertex(&[1.0, 2.0, 3.0]);
    assert_eq!(with(three).to_string(), "panel 0, body 0: 3 values are given for 4 vertices");
    let per_face = Values::per_face(&[1.0, 2.0]);
    assert_eq!(with(per_face).to_string(), "panel 0, body 0: 2 values are given for 1 faces");
    let four = Values::per_vertex(&[1.0; 4]);
    for range in [
        Range::Between(1.0, 1.0),
        Range::Between(f64::NAN, 1.0),
        Range::Between(0.0, f64::INFINITY),
        Range::Percentiles(-1.0, 50.0),
        Range::Percentiles(60.0, 50.0),
    ] {
        assert!(matches!(with(Values { range, ..four }), RenderError::Style { .. }), "{range:?}");
    }
    let range = Range::Between(0.0, 1.0);
    let message = with(Values { range, log: true, ..four }).to_string();
    assert!(message.contains("positive on a logarithmic scale"), "{message}");
    for bands in [0, 257] {
        assert!(matches!(with(Values { bands: Some(bands), ..four }), RenderError::Style { .. }));
    }
    let isolines = Some(Line { width: -1.0, ..Line::default() });
    assert!(matches!(with(Values { isolines, ..four }), RenderError::Style { .. }));

    let strokes = [([0, 4], Line::default())];
    let end = fails(Body { strokes: &strokes, ..body });
    assert_eq!(
        end.to_string(),
        "panel 0, body 0: stroke 0 ends at vertex 4, but there are 4 vertices"
    );
    let wide = [([0, 1], Line { width: f64::NAN, ..Line::default() })];
    assert!(matches!(fails(Body { strokes: &wide, ..body }), RenderError::Style { .. }));
    let surface = Surface::Zebra { axis: fairform_render::Axis::X, stripes: 0 };
    let style = Style { surface, ..Style::default() };
    assert!(matches!(fails(Body { style, ..body }), RenderError::Style { .. }));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Any numbers, on any scale, with any text, in any size, give a picture.
    #[test]
    fn any_values_are_drawn(
        of in prop::collection::vec(
            prop_oneof![any::<f64>(), -1.0..1.0, Just(0.0), Just(f64::NAN), Just(1e300)], 16),
        map in prop::sample::select(ColourMap::ALL.to_vec()),
        surface in prop::sample::select(vec![Surface::Plain, Surface::ZEBRA, Surface::REFLECTION]),
        log in any::<bool>(),
        bands in prop::option::of(1_u32..=256),
        has_lines in any::<bool>(),
        legend in ".{0,12}",
        shared_range in any::<bool>(),
        size in (1_u32..80, 1_u32..80),
        title_size in prop_oneof![Just(38.0), 0.0..500.0],
        view in prop::sample::select(vec!["iso", "front", "top", "right,x", "bottom,z"]),
    ) {
        let (positions, faces) = sheet(3);
        let isolines = has_lines.then(Line::default);
        let legend = Some(&*legend);
        let values = Values { map, log, bands, isolines, legend, ..Values::per_vertex(&of) };
        let style = Style { surface, ..Style::default() };
        let body = Body { values: Some(values), style, ..Body::new(&positions, &faces) };
        let other = Body { values: Some(Values::per_face(&of[..9])), ..body };
        let panels = [body, other].map(|b| Panel { bodies: vec![b], title: Some("a\nb".into()) });
        let options = Options { shared_range, title_size, ..bare() };
        match render(&panels, &view.parse().unwrap(), size, &options) {
            Ok(picture) => prop_assert_eq!(picture.pixels.len() as u32, size.0 * size.1),
            Err(error) => prop_assert!(matches!(error, RenderError::NoRoom { .. }), "{}", error),
        }
    }
}
