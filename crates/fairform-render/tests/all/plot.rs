//! What a plot holds, whatever the numbers.

use fairform_render::{Series, plot_svg};
use proptest::prelude::*;
use roxmltree::Document;

fn series(name: &str, points: &[(f64, f64)]) -> Series {
    Series { name: name.into(), points: points.to_vec(), dashed: false }
}

fn texts(svg: &str) -> Vec<String> {
    let document = Document::parse(svg).unwrap();
    let is_text = |n: &roxmltree::Node| n.has_tag_name("text");
    let text = |n: roxmltree::Node| {
        n.descendants().filter_map(|d| d.is_text().then(|| d.text())?).collect()
    };
    document.descendants().filter(is_text).map(text).collect()
}

#[test]
fn curves_names_and_labels_are_there() {
    let geometric: Vec<_> = (0..60).map(|k| (f64::from(k), 0.5_f64.powf(f64::from(k)))).collect();
    let mut reference = series("a < b & \"c\"", &[(0.0, 1.0), (59.0, 1e-12)]);
    reference.dashed = true;
    let svg = plot_svg(&[series("Richardson", &geometric), reference], "Title", "k", "error", true);
    let texts = texts(&svg);
    for expected in ["Richardson", "a < b & \"c\"", "Title", "k", "error"] {
        assert!(texts.iter().any(|t| t == expected), "{expected} in {texts:?}");
    }
    let document = Document::parse(&svg).unwrap();
    let curves: Vec<_> = document
        .descendants()
        .filter(|n| n.attribute("stroke-linejoin") == Some("round"))
        .collect();
    assert_eq!(curves.len(), 2);
    assert_eq!(curves[0].attribute("d").unwrap().matches('L').count(), 59);
    assert!(curves[1].attribute("stroke-dasharray").is_some());
}

/// A straight line on the logarithmic axis is straight in the picture.
#[test]
fn the_logarithmic_axis_is_logarithmic() {
    let points = [(0.0, 1.0), (1.0, 1e-2), (2.0, 1e-4), (3.0, 1e-6), (4.0, 1e-8)];
    let svg = plot_svg(&[series("", &points)], "", "", "", true);
    let document = Document::parse(&svg).unwrap();
    let dots: Vec<f64> = document
        .descendants()
        .filter_map(|n| n.attribute("cy"))
        .map(|y| y.parse().unwrap())
        .collect();
    assert_eq!(dots.len(), 5);
    for pair in dots.windows(2) {
        assert!((pair[1] - pair[0] - (dots[4] - dots[0]) / 4.0).abs() < 0.02, "{dots:?}");
    }
}

#[test]
fn ticks_are_at_powers_of_ten() {
    let svg = plot_svg(&[series("e", &[(0.0, 0.7), (10.0, 3e-6)])], "", "", "", true);
    let texts = texts(&svg);
    for decade in ["10⁰", "10⁻¹", "10⁻²", "10⁻³", "10⁻⁴", "10⁻⁵", "10⁻⁶"] {
        assert!(texts.iter().any(|t| t == decade), "{decade} in {texts:?}");
    }
    // Over many decades not all are named, but the named ones are whole.
    let svg = plot_svg(&[series("e", &[(0.0, 1.0), (10.0, 1e-300)])], "", "", "", true);
    let named = self::texts(&svg).iter().filter(|t| t.starts_with("10⁻")).count();
    assert!((3..=13).contains(&named), "{named}");
}

#[test]
fn steps_of_a_linear_axis_are_round() {
    let svg = plot_svg(&[series("e", &[(0.0, 0.0), (9.7, 0.83)])], "", "", "", false);
    let texts = texts(&svg);
    for number in ["0", "2", "4", "6", "8", "0.1", "0.2", "0.5", "0.9"] {
        assert!(texts.iter().any(|t| t == number), "{number} in {texts:?}");
    }
}

#[test]
fn little_or_no_data_is_said_or_shown() {
    for log_y in [false, true] {
        for points in [&[][..], &[(f64::NAN, 1.0)], &[(1.0, f64::INFINITY)]] {
            let svg = plot_svg(&[series("nothing", points)], "t", "x", "y", log_y);
            assert!(texts(&svg).iter().any(|t| t == "no data"));
        }
        let svg = plot_svg(&[series("one", &[(3.0, 4.0)])], "t", "x", "y", log_y);
        let document = Document::parse(&svg).unwrap();
        assert_eq!(document.descendants().filter(|n| n.has_tag_name("circle")).count(), 1);
    }
    assert!(texts(&plot_svg(&[], "", "", "", true)).iter().any(|t| t == "no data"));
}

/// A zero has no logarithm: the curve stops there and goes on behind.
#[test]
fn a_zero_interrupts_a_logarithmic_curve() {
    let mut points: Vec<_> = (0..50).map(|k| (f64::from(k), 1.0 + f64::from(k))).collect();
    points[20].1 = 0.0;
    let svg = plot_svg(&[series("e", &points)], "", "", "", true);
    let document = Document::parse(&svg).unwrap();
    let curve = document.descendants().find(|n| n.attribute("stroke-linejoin").is_some()).unwrap();
    let path = curve.attribute("d").unwrap();
    assert_eq!((path.matches('M').count(), path.matches('L').count()), (2, 47));
}

proptest! {
    /// Well-formed whatever is in it, and every coordinate a number inside the picture.
    #[test]
    fn any_numbers_and_any_text_are_well_formed(
        points in prop::collection::vec((any::<f64>(), any::<f64>()), 0..40),
        name in any::<String>(),
        title in any::<String>(),
        log_y in any::<bool>(),
    ) {
        let all = vec![series(&name, &points); 3];
        let svg = plot_svg(&all, &title, &name, &title, log_y);
        let document = Document::parse(&svg).unwrap();
        for circle in document.descendants().filter(|n| n.has_tag_name("circle")) {
            let [x, y] = ["cx", "cy"].map(|a| circle.attribute(a).unwrap().parse::<f64>().unwrap());
            prop_assert!((0.0..=760.0).contains(&x) && (0.0..=470.0).contains(&y));
        }
    }
}
