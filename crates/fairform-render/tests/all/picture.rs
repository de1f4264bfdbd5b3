//! What a picture shows, and what it does with input that is odd or wrong.

use fairform::{Faces, Vec3};
use fairform_render::{
    Body, Colour, Dot, Line, Options, Panel, Picture, RenderError, Style, View, render,
};
use proptest::prelude::*;

const SIZE: (u32, u32) = (96, 72);

/// No shadow on the ground, and nothing where nothing is.
fn bare() -> Options {
    Options { background: Colour::TRANSPARENT, ground: false, ..Options::default() }
}

fn panel(bodies: Vec<Body<'_>>) -> [Panel<'_>; 1] {
    [Panel { bodies, title: None }]
}

fn faces(list: &[&[u32]]) -> Faces {
    list.iter().collect()
}

fn points(list: &[[f64; 3]]) -> Vec<Vec3> {
    list.iter().copied().map(Vec3::from).collect()
}

fn front() -> View {
    "front".parse().unwrap()
}

fn coloured<'a>(positions: &'a [Vec3], faces: &'a Faces, fill: Colour) -> Body<'a> {
    let style = Style { fill: Some(fill), smooth: false, ..Style::default() };
    Body { style, ..Body::new(positions, faces) }
}

fn cube() -> (Vec<Vec3>, Faces) {
    let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2 & 1].map(|b| 2.0 * f64::from(b) - 1.0).into();
    let sides: [&[u32]; 6] =
        [&[0, 2, 3, 1], &[4, 5, 7, 6], &[0, 1, 5, 4], &[2, 6, 7, 3], &[0, 4, 6, 2], &[1, 3, 7, 5]];
    ((0..8).map(corner).collect(), faces(&sides))
}

fn is_red([r, g, b, _]: [u8; 4]) -> bool {
    u32::from(r) > 2 * u32::from(g) + 20 && u32::from(r) > 2 * u32::from(b) + 20
}

fn is_green([r, g, b, _]: [u8; 4]) -> bool {
    u32::from(g) > 2 * u32::from(r) + 20 && u32::from(g) > 2 * u32::from(b) + 20
}

/// Both orders of drawing, since a picture without depths would show the last.
#[test]
fn the_nearer_triangle_hides_the_farther() {
    let far = points(&[[-3., -3., 0.], [3., -3., 0.], [0., 3., 0.]]);
    let near = points(&[[-1., -1., 1.], [1., -1., 1.], [0., 1., 1.]]);
    let faces = faces(&[&[0, 1, 2]]);
    let red = coloured(&near, &faces, Colour::hex(0xff_00_00));
    let green = coloured(&far, &faces, Colour::hex(0x00_ff_00));
    for bodies in [vec![red, green], vec![green, red]] {
        let picture = render(&panel(bodies), &front(), SIZE, &bare()).unwrap();
        assert!(is_red(picture.get(48, 36)), "{:?}", picture.get(48, 36));
        assert!(is_green(picture.get(48, 62)), "{:?}", picture.get(48, 62));
    }
}

/// Two crossing triangles: each is in front on its own side.
#[test]
fn crossing_triangles_share_the_picture() {
    let a = points(&[[-1., -1., 1.], [1., -1., -1.], [1., 1., -1.], [-1., 1., 1.]]);
    let b = points(&[[-1., -1., -1.], [1., -1., 1.], [1., 1., 1.], [-1., 1., -1.]]);
    let faces = faces(&[&[0, 1, 2, 3]]);
    let bodies = vec![
        coloured(&a, &faces, Colour::hex(0xff_00_00)),
        coloured(&b, &faces, Colour::hex(0x00_ff_00)),
    ];
    let picture = render(&panel(bodies), &front(), SIZE, &bare()).unwrap();
    assert!(is_red(picture.get(36, 36)) && is_green(picture.get(60, 36)));
}

#[test]
fn a_symmetric_outline_is_symmetric() {
    let (positions, faces) = cube();
    let picture =
        render(&panel(vec![Body::new(&positions, &faces)]), &front(), SIZE, &bare()).unwrap();
    for y in 0..SIZE.1 {
        for x in 0..SIZE.0 {
            let [here, across] = [picture.get(x, y), picture.get(SIZE.0 - 1 - x, y)].map(|p| p[3]);
            // The sixteen samples of a pixel are not quite symmetric.
            assert!(here.abs_diff(across) <= 32, "{here} {across} at {x} {y}");
        }
    }
}

/// An upright square seen from the front has straight sides, half as wide as high pixels say.
#[test]
fn coverage_is_an_area() {
    let positions = points(&[[-1., -1., 0.], [1., -1., 0.], [1., 1., 0.], [-1., 1., 0.]]);
    let faces = faces(&[&[0, 1, 2, 3]]);
    let body = coloured(&positions, &faces, Colour::WHITE);
    let picture = render(&panel(vec![body]), &front(), (200, 200), &bare()).unwrap();
    let covered: f64 = picture.pixels.iter().map(|p| f64::from(p[3]) / 255.0).sum();
    // A margin of 6 percent on each side.
    let side = 200.0 * 0.88;
    assert!((covered - side * side).abs() < 0.01 * side * side, "{covered}");
}

/// A cube's edges in front show, those behind do not, and neither do diagonals of the faces.
#[test]
fn lines_are_hidden_and_only_along_edges() {
    let (positions, faces) = cube();
    let style = Style {
        fill: Some(Colour::WHITE),
        smooth: false,
        wireframe: Some(Line { colour: Colour::hex(0xff_00_00), width: 12.0 }),
        ..Style::default()
    };
    let body = Body { style, ..Body::new(&positions, &faces) };
    // From straight ahead the edges of the back are inside the square of the front face.
    let picture = render(&panel(vec![body]), &front(), (200, 200), &bare()).unwrap();
    for y in 20..180 {
        for x in 20..180 {
            assert!(!is_red(picture.get(x, y)), "a line at {x} {y}");
        }
    }
    let on_row = (0..200).filter(|&x| is_red(picture.get(x, 100))).count();
    assert!((4..=7).contains(&on_row), "{on_row} red pixels across two sides");
    // Without the surface the back shows: the far square too.
    let open = Body { style: Style { fill: None, ..style }, ..body };
    let picture = render(&panel(vec![open]), &front(), (200, 200), &bare()).unwrap();
    let on_row: Vec<u32> = (0..200).filter(|&x| picture.get(x, 100)[3] > 0).collect();
    assert!((8..=16).contains(&on_row.len()), "{on_row:?}");
    assert!(on_row.iter().any(|x| (20..60).contains(x)), "the far square in {on_row:?}");
}

#[test]
fn only_the_boundary_is_red() {
    // Two triangles; the diagonal has faces on both sides.
    let positions = points(&[[-1., -1., 0.], [1., -1., 0.], [1., 1., 0.], [-1., 1., 0.]]);
    let faces = faces(&[&[0, 1, 2], &[2, 3, 0]]);
    let boundary = Some(Line { colour: Colour::hex(0xff_00_00), width: 20.0 });
    let style = Style { fill: Some(Colour::WHITE), boundary, ..Style::default() };
    let body = Body { style, ..Body::new(&positions, &faces) };
    let picture = render(&panel(vec![body]), &front(), (100, 100), &bare()).unwrap();
    assert!(!is_red(picture.get(50, 50)));
    for (x, y) in [(6, 50), (93, 50), (50, 6), (50, 93)] {
        assert!(is_red(picture.get(x, y)), "{:?}", picture.get(x, y));
    }
}

#[test]
fn the_back_of_a_surface_has_its_own_colour() {
    let positions = points(&[[-1., -1., 0.], [1., -1., 0.], [0., 1., 0.]]);
    let faces = faces(&[&[0, 1, 2]]);
    let mut body = coloured(&positions, &faces, Colour::hex(0x00_ff_00));
    body.style.back = Colour::hex(0xff_00_00);
    let from = |view: &str| {
        render(&panel(vec![body]), &view.parse().unwrap(), SIZE, &bare()).unwrap().get(48, 40)
    };
    assert!(is_green(from("front")) && is_red(from("back")));
}

#[test]
fn colours_of_vertices_are_blended_over_the_face() {
    let positions = points(&[[-1., 0., 0.], [1., 0., 0.], [1., 1., 0.], [-1., 1., 0.]]);
    let faces = faces(&[&[0, 1, 2, 3]]);
    let (red, green) = ([1., 0., 0., 1.], [0., 1., 0., 1.]);
    let mut body = coloured(&positions, &faces, Colour::WHITE);
    body.colours =
        Some(const { &[[1., 0., 0., 1.], [0., 1., 0., 1.], [0., 1., 0., 1.], [1., 0., 0., 1.]] });
    let picture = render(&panel(vec![body]), &front(), SIZE, &bare()).unwrap();
    assert!(is_red(picture.get(12, 36)) && is_green(picture.get(84, 36)));
    let [r, g, b, _] = picture.get(48, 36);
    assert!(r.abs_diff(g) < 12 && b < 60, "{r} {g} {b}");
    // A colour that is none leaves the fill.
    let bad = [[f64::NAN; 4], red, green, red];
    body.colours = Some(&bad);
    render(&panel(vec![body]), &front(), SIZE, &bare()).unwrap();
}

/// Half opaque is half of the samples, in front of whatever is there.
#[test]
fn translucent_bodies_let_through() {
    let positions = points(&[[-1., -1., 0.], [1., -1., 0.], [0., 1., 0.]]);
    let faces = faces(&[&[0, 1, 2]]);
    let body = coloured(&positions, &faces, Colour::WHITE.with_opacity(0.5));
    let picture = render(&panel(vec![body]), &front(), SIZE, &bare()).unwrap();
    assert_eq!(picture.get(48, 40)[3], 128);
}

#[test]
fn the_background_is_untouched_where_nothing_is() {
    let (positions, faces) = cube();
    let background = Colour::hex(0x12_34_56);
    let options = Options { background, ground: false, ..Options::default() };
    let bodies = vec![Body::new(&positions, &faces)];
    let picture = render(&panel(bodies), &View::default(), SIZE, &options).unwrap();
    for (x, y) in [(0, 0), (95, 0), (0, 71), (95, 71), (1, 36)] {
        assert_eq!(picture.get(x, y), [0x12, 0x34, 0x56, 255]);
    }
    let empty = render(&[], &View::default(), SIZE, &Options::default()).unwrap();
    assert!(empty.pixels.iter().all(|&p| p == [255; 4]));
}

#[test]
fn the_ground_is_darker_below_a_body_and_only_there() {
    let (positions, faces) = cube();
    let bodies = vec![Body::new(&positions, &faces)];
    let view = View { zoom: 0.6, ..View::default() };
    let picture = render(&panel(bodies), &view, (200, 160), &Options::default()).unwrap();
    let corners = [(0, 0), (199, 0), (0, 159), (199, 159)];
    assert!(corners.iter().all(|&(x, y)| picture.get(x, y) == [255; 4]));
    let grey = |p: &&[u8; 4]| p[0] == p[1] && p[1] == p[2] && (100..250).contains(&p[0]);
    assert!(picture.pixels.iter().filter(grey).count() > 200);
}

#[test]
fn panels_have_their_places_and_one_scale() {
    let (small, faces) = cube();
    let large: Vec<Vec3> = small.iter().map(|&p| 3.0 * p).collect();
    let panels = [&small, &large].map(|p| Panel {
        bodies: vec![Body::new(p, &faces)],
        title: Some("Catmull–Clark, α ≥ ½ <&>".into()),
    });
    let area = |picture: &Picture, columns: std::ops::Range<u32>| {
        columns
            .flat_map(|x| (0..80).map(move |y| (x, y)))
            .filter(|&(x, y)| picture.get(x, y)[3] > 128)
            .count()
    };
    let shared = render(&panels, &front(), (200, 110), &bare()).unwrap();
    let [left, right] = [area(&shared, 0..100), area(&shared, 100..200)];
    assert!(left > 0 && right > 8 * left, "{left} {right}");
    let options = Options { shared: false, ..bare() };
    let own = render(&panels, &front(), (200, 110), &options).unwrap();
    assert_eq!(area(&own, 0..100), area(&own, 100..200));
    // The titles: something in the strip below, of both panels.
    let written = |columns: std::ops::Range<u32>| {
        columns.flat_map(|x| (102..110).map(move |y| (x, y))).any(|(x, y)| own.get(x, y)[3] > 0)
    };
    assert!(written(0..100) && written(100..200));
}

#[test]
fn the_bytes_do_not_depend_on_the_threads() {
    let (positions, faces) = cube();
    let style = Style {
        wireframe: Some(Line::default()),
        points: Some(Dot::default()),
        ..Style::default()
    };
    let draw = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let body = Body { style, ..Body::new(&positions, &faces) };
        let panels = [Panel { bodies: vec![body], title: Some("cube".into()) }];
        pool.install(|| render(&panels, &View::default(), (300, 200), &Options::default()).unwrap())
    };
    let one = draw(1);
    for threads in [2, 3, 8] {
        assert!(draw(threads) == one, "{threads} threads");
    }
}

#[test]
fn a_png_holds_the_pixels() {
    let (positions, faces) = cube();
    for background in [Colour::WHITE, Colour::TRANSPARENT] {
        let options = Options { background, ..Options::default() };
        let bodies = vec![Body::new(&positions, &faces)];
        let picture = render(&panel(bodies), &View::default(), (61, 47), &options).unwrap();
        let file = picture.to_png();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&file)).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!((info.width, info.height), (61, 47));
        let channels = info.color_type.samples();
        let decoded: Vec<[u8; 4]> = bytes[..info.buffer_size()]
            .chunks_exact(channels)
            .map(|p| [p[0], p[1], p[2], if channels == 4 { p[3] } else { 255 }])
            .collect();
        assert!(decoded == picture.pixels);
    }
}

#[test]
fn wrong_input_is_named() {
    let positions = points(&[[0., 0., 0.], [1., 0., 0.], [f64::NAN, 1., 0.]]);
    let draw = |faces: &Faces, size, view: &View| {
        let body = Body::new(&positions, faces);
        render(&panel(vec![body]), view, size, &bare()).unwrap_err()
    };
    let view = View::default();
    let missing = draw(&faces(&[&[0, 1, 3]]), SIZE, &view);
    assert!(matches!(missing, RenderError::NoSuchVertex { vertex, .. } if vertex.0 == 3));
    assert_eq!(
        missing.to_string(),
        "panel 0, body 0: face 0 lists vertex 3, but there are 3 vertices"
    );
    let nan = draw(&faces(&[&[0, 1, 2]]), SIZE, &view);
    assert!(matches!(nan, RenderError::NotFinite { vertex, .. } if vertex.0 == 2));
    let none = Faces::new();
    for size in [(0, 1), (1, 0), (u32::MAX, u32::MAX), (16_384, 16_384), (1, 16_385)] {
        assert!(matches!(draw(&none, size, &view), RenderError::Size { .. }), "{size:?}");
    }
    let tilted = View { elevation: 91.0, ..view };
    assert!(matches!(draw(&none, SIZE, &tilted), RenderError::View { what: "elevation", .. }));
    let normals = [Vec3::ZERO];
    let body = Body { normals: Some(&normals), ..Body::new(&positions, &none) };
    let count = render(&panel(vec![body]), &view, SIZE, &bare()).unwrap_err();
    assert!(matches!(count, RenderError::Count { what: "normals", given: 1, .. }));
    let style =
        Style { wireframe: Some(Line { width: f64::NAN, ..Line::default() }), ..Style::default() };
    let body = Body { style, ..Body::new(&positions, &none) };
    let width = render(&panel(vec![body]), &view, SIZE, &bare()).unwrap_err();
    assert!(matches!(width, RenderError::Style { .. }));
    let many: Vec<Panel> = (0..10_000).map(|_| Panel::default()).collect();
    let crowd = render(&many, &view, SIZE, &bare()).unwrap_err();
    assert!(matches!(crowd, RenderError::NoRoom { panels: 10_000, .. }));
}

/// A vertex that no face uses is nobody's business, unless points are drawn.
/// A smooth cube whose corners have the normals of their sides has sides as flat as a flat one.
#[test]
fn normals_of_corners_part_what_a_vertex_joins() {
    let (positions, faces) = cube();
    let sides =
        [[0., 0., -1.], [0., 0., 1.], [0., -1., 0.], [0., 1., 0.], [-1., 0., 0.], [1., 0., 0.]];
    let normals: Vec<Vec3> = sides.iter().flat_map(|&n| [Vec3::from(n); 4]).collect();
    let draw = |body| render(&panel(vec![body]), &View::default(), SIZE, &bare()).unwrap().to_png();
    let smooth = Body::new(&positions, &faces);
    let flat = Body { style: Style { smooth: false, ..Style::default() }, ..smooth };
    let parted = Body { corner_normals: Some(&normals), ..smooth };
    assert_eq!(draw(parted), draw(flat));
    assert_ne!(draw(parted), draw(smooth));
    // Those without a direction do not count, nor those that point away.
    let inward: Vec<Vec3> = normals.iter().map(|n| -1.0 * *n).collect();
    assert_eq!(draw(Body { corner_normals: Some(&inward), ..smooth }), draw(smooth));
    let none = [Vec3::ZERO, Vec3::new(f64::NAN, 0.0, 0.0)].repeat(12);
    assert_eq!(draw(Body { corner_normals: Some(&none), ..smooth }), draw(smooth));
    let few = Body { corner_normals: Some(&normals[1..]), ..smooth };
    let error = render(&panel(vec![few]), &View::default(), SIZE, &bare()).unwrap_err();
    assert!(matches!(error, RenderError::CornerCount { given: 23, corner_count: 24, .. }));
}

#[test]
fn an_unused_vertex_may_be_anything() {
    let positions = points(&[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [f64::INFINITY, 0., 0.]]);
    let faces = faces(&[&[0, 1, 2]]);
    let mut body = Body::new(&positions, &faces);
    render(&panel(vec![body]), &View::default(), SIZE, &bare()).unwrap();
    body.style.points = Some(Dot::default());
    assert!(render(&panel(vec![body]), &View::default(), SIZE, &bare()).is_err());
}

#[test]
fn degenerate_bodies_still_give_a_picture() {
    let everything = Style {
        wireframe: Some(Line::default()),
        boundary: Some(Line { colour: Colour::RED, width: 5.0 }),
        points: Some(Dot::default()),
        ..Style::default()
    };
    let triangle = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
    let scaled = |s: f64| points(&triangle.map(|p| p.map(|x| x * s)));
    let mut cases: Vec<(Vec<Vec3>, Faces)> = vec![
        (vec![], Faces::new()),
        (points(&[[5., 5., 5.]]), Faces::new()),
        (points(&[[5., 5., 5.]; 3]), faces(&[&[0, 1, 2]])),
        (
            points(&[[0., 0., 0.], [1., 1., 1.], [2., 2., 2.], [3., 3., 3.]]),
            faces(&[&[0, 1, 2, 3]]),
        ),
        (scaled(1.0), faces(&[&[], &[0], &[0, 1], &[0, 0, 0], &[0, 1, 0, 2], &[0, 1, 2, 0, 1, 2]])),
        (points(&[[1e300, 0., 0.], [-1e300, 0., 0.], [0., 1e-300, 0.]]), faces(&[&[0, 1, 2]])),
        (
            points(&[[1e8, 1e8, 1e8], [1e8 + 1e-8, 1e8, 1e8], [1e8, 1e8 + 1e-8, 1e8]]),
            faces(&[&[0, 1, 2]]),
        ),
    ];
    for s in [1e30, 1e-40, 5e-324, 1e-320, f64::MAX, -f64::MAX] {
        cases.push((scaled(s), faces(&[&[0, 1, 2]])));
    }
    for (positions, faces) in &cases {
        let body = Body { style: everything, ..Body::new(positions, faces) };
        let nan = vec![Vec3::splat(f64::NAN); positions.len()];
        let body_of_nan = Body { normals: Some(&nan), ..body };
        for view in ["iso", "front", "top", "bottom,z", "right,x"] {
            let view: View = view.parse().unwrap();
            let picture = render(&panel(vec![body]), &view, SIZE, &bare()).unwrap();
            let shown = picture.pixels.iter().any(|p| p[3] > 0);
            assert_eq!(shown, !positions.is_empty(), "{positions:?} from {view:?}");
            let same = render(&panel(vec![body_of_nan]), &view, SIZE, &bare()).unwrap();
            assert!(same == picture, "normals that are none are not used");
        }
    }
}

/// The unit does not matter.
#[test]
fn a_picture_does_not_depend_on_the_scale() {
    let (positions, faces) = cube();
    let draw = |s: f64| {
        let scaled: Vec<Vec3> = positions.iter().map(|&p| s * p).collect();
        render(&panel(vec![Body::new(&scaled, &faces)]), &View::default(), SIZE, &bare()).unwrap()
    };
    let plain = draw(1.0);
    // Powers of two, which scale without rounding.
    for exponent in [-1000.0, -100.0, 3.0, 100.0, 1000.0] {
        assert!(draw(2.0_f64.powf(exponent)) == plain, "2^{exponent}");
    }
}

/// One pixel is a picture too.
#[test]
fn small_and_narrow_pictures() {
    let (positions, faces) = cube();
    for size in [(1, 1), (1, 300), (300, 1), (2, 3)] {
        let bodies = vec![Body::new(&positions, &faces)];
        let picture = render(&panel(bodies), &View::default(), size, &Options::default()).unwrap();
        assert_eq!(picture.pixels.len() as u32, size.0 * size.1);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// A box of any shape, from anywhere, leaves the rim of the picture free and fills the rest in
    /// one direction.
    #[test]
    fn everything_is_in_the_frame(
        sides in prop::array::uniform3(prop_oneof![Just(0.0), 1e-3..1.0, 1.0..1e3]),
        corner in prop::array::uniform3(-1e4..1e4),
        azimuth in -360.0..360.0,
        elevation in -90.0..=90.0,
        field in 1.0..120.0,
    ) {
        let (unit, faces) = cube();
        let positions: Vec<Vec3> =
            unit.iter().map(|p| p.scale(sides.into()) + Vec3::from(corner)).collect();
        let view = View { azimuth, elevation, field, ..View::default() };
        // Edges too, since a box without thickness may be seen from its side.
        let style = Style { wireframe: Some(Line { width: 20.0, ..Line::default() }), ..Style::default() };
        let body = Body { style, ..Body::new(&positions, &faces) };
        let options = Options { shadows: false, ..bare() };
        let picture = render(&panel(vec![body]), &view, SIZE, &options).unwrap();
        let shown = |x: u32, y: u32| picture.get(x, y)[3] > 0;
        let columns: Vec<u32> = (0..SIZE.0).filter(|&x| (0..SIZE.1).any(|y| shown(x, y))).collect();
        let rows: Vec<u32> = (0..SIZE.1).filter(|&y| (0..SIZE.0).any(|x| shown(x, y))).collect();
        prop_assert!(columns[0] >= 2 && *columns.last().unwrap() < SIZE.0 - 2, "{columns:?}");
        prop_assert!(rows[0] >= 2 && *rows.last().unwrap() < SIZE.1 - 2, "{rows:?}");
    }

    /// Any triangles, however they lie, give a picture.
    #[test]
    fn any_finite_soup_is_drawn(
        coordinates in prop::collection::vec(
            prop_oneof![-1.0..1.0, Just(0.0), Just(1.0), -1e300..1e300, -1e-300..1e-300], 9..60),
        corners in prop::collection::vec(0_u32..3, 0..40),
        size in 1_usize..7,
    ) {
        let positions: Vec<Vec3> =
            coordinates.chunks_exact(3).map(|c| Vec3::new(c[0], c[1], c[2])).collect();
        let faces: Faces = corners.chunks(size).collect();
        let style = Style {
            wireframe: Some(Line::default()),
            points: Some(Dot::default()),
            ..Style::default()
        };
        let body = Body { style, ..Body::new(&positions, &faces) };
        prop_assert!(render(&panel(vec![body]), &View::default(), (32, 24), &bare()).is_ok());
    }
}
