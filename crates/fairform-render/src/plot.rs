//! Plots of curves as SVG.

use std::fmt::Write;

use crate::ticks::Scale;

/// A curve of a plot.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Series {
    /// What the legend says.
    pub name: String,
    /// Places that the curve goes through, in order. Where one is not finite, or not positive on a
    /// logarithmic axis, the curve is interrupted.
    pub points: Vec<(f64, f64)>,
    /// Whether it is drawn with dashes, in the colour of the last one that is not: a mean beside a
    /// largest value, say.
    pub dashed: bool,
}

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 470.0;
const LEFT: f64 = 88.0;
const RIGHT: f64 = WIDTH - 24.0;
const TOP: f64 = 52.0;
const BOTTOM: f64 = HEIGHT - 62.0;

/// Colours of the curves, told apart also by those who see few colours.
const COLOURS: [&str; 8] =
    ["#2867ac", "#d8622b", "#2d8a62", "#8c4f9f", "#bb3040", "#b08a1e", "#2e9db0", "#5f6670"];

/// A plot of curves over a common x axis, as an SVG document.
///
/// With `log_y` the vertical axis is logarithmic with its ticks at powers of ten, as for an error
/// over the iterations. Any text and any numbers give a well-formed document, also none.
///
/// ```
/// use fairform_render::{Series, plot_svg};
/// let points = (0..30).map(|k| (f64::from(k), 0.5_f64.powf(f64::from(k)))).collect();
/// let series = Series { name: "Richardson".into(), points, dashed: false };
/// let svg = plot_svg(&[series], "Convergence", "iteration", "max residual", true);
/// assert!(svg.starts_with("<svg") && svg.contains("Richardson"));
/// ```
#[must_use]
pub fn plot_svg(
    series: &[Series],
    title: &str,
    x_label: &str,
    y_label: &str,
    log_y: bool,
) -> String {
    let curves: Vec<Vec<Option<(f64, f64)>>> = series
        .iter()
        .map(|s| s.points.iter().map(|&(x, y)| usable(x, y, log_y)).collect())
        .collect();
    let shown = || curves.iter().flatten().flatten();
    let x_axis = Scale::linear(shown().map(|p| p.0), false);
    let ys = shown().map(|p| p.1);
    let y_axis = if log_y { Scale::logarithmic(ys) } else { Scale::linear(ys, true) };
    let place = |(x, y): (f64, f64)| {
        (LEFT + x_axis.share(x) * (RIGHT - LEFT), BOTTOM - y_axis.share(y) * (BOTTOM - TOP))
    };
    let curves: Vec<Vec<Option<(f64, f64)>>> =
        curves.into_iter().map(|c| c.into_iter().map(|p| p.map(place)).collect()).collect();

    let colours = colours(series);
    let mut svg = Svg(String::new());
    svg.open(title);
    svg.axes(&x_axis, &y_axis);
    svg.labels(title, x_label, y_label);
    for (i, (curve, series)) in curves.iter().zip(series).enumerate() {
        svg.curve(curve, colours[i], series.dashed);
    }
    if curves.iter().flatten().flatten().next().is_none() {
        svg.text(0.5 * (LEFT + RIGHT), 0.5 * (TOP + BOTTOM), "middle", "no data");
    }
    svg.legend(series, &curves, &colours);
    svg.0.push_str("</svg>\n");
    svg.0
}

/// A colour for each curve; dashed ones share that of the solid one before.
fn colours(series: &[Series]) -> Vec<&'static str> {
    let mut solid = 0;
    let number = |s: &Series| {
        solid += usize::from(!s.dashed);
        COLOURS[solid.saturating_sub(1) % COLOURS.len()]
    };
    series.iter().map(number).collect()
}

/// The point as the axes count it, if they can show it.
fn usable(x: f64, y: f64, log_y: bool) -> Option<(f64, f64)> {
    let y = match (log_y, y > 0.0) {
        (true, true) => libm::log10(y),
        (true, false) => return None,
        (false, _) => y,
    };
    (x.is_finite() && y.is_finite()).then_some((x, y))
}

struct Svg(String);

impl Svg {
    /// Writing to a string cannot fail.
    fn add(&mut self, line: std::fmt::Arguments) {
        let _ = self.0.write_fmt(line);
        self.0.push('\n');
    }

    fn open(&mut self, title: &str) {
        self.add(format_args!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
             width=\"{WIDTH}\" height=\"{HEIGHT}\" role=\"img\" font-size=\"15\" fill=\"#1d2633\" \
             font-family=\"Ubuntu, 'Source Sans 3', 'Helvetica Neue', Arial, sans-serif\">"
        ));
        self.add(format_args!("<title>{}</title>", escaped(title)));
        self.add(format_args!("<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#ffffff\"/>"));
    }

    fn axes(&mut self, x_axis: &Scale, y_axis: &Scale) {
        for tick in &y_axis.ticks {
            let y = BOTTOM - y_axis.share(tick.at) * (BOTTOM - TOP);
            let grey = if tick.label.is_some() { "#dde1e6" } else { "#eff1f4" };
            self.add(format_args!(
                "<path d=\"M{LEFT} {y:.2}H{RIGHT}\" stroke=\"{grey}\" fill=\"none\"/>"
            ));
            if let Some(label) = &tick.label {
                let (x, y) = (LEFT - 10.0, y + 5.0);
                self.add(format_args!(
                    "<text x=\"{x}\" y=\"{y:.2}\" text-anchor=\"end\">{}</text>",
                    label.text()
                ));
            }
        }
        for tick in &x_axis.ticks {
            let x = LEFT + x_axis.share(tick.at) * (RIGHT - LEFT);
            let (end, y) = (BOTTOM + 6.0, BOTTOM + 23.0);
            self.add(format_args!(
                "<path d=\"M{x:.2} {TOP}V{BOTTOM}\" stroke=\"#eff1f4\" fill=\"none\"/>\
                 <path d=\"M{x:.2} {BOTTOM}V{end}\" stroke=\"#1d2633\" fill=\"none\"/>"
            ));
            if let Some(label) = &tick.label {
                self.add(format_args!(
                    "<text x=\"{x:.2}\" y=\"{y}\" text-anchor=\"middle\">{}</text>",
                    label.text()
                ));
            }
        }
        self.add(format_args!(
            "<path d=\"M{LEFT} {TOP}V{BOTTOM}H{RIGHT}\" stroke=\"#1d2633\" stroke-width=\"1.2\" \
             fill=\"none\"/>"
        ));
    }

    fn labels(&mut self, title: &str, x_label: &str, y_label: &str) {
        let middle = 0.5 * (LEFT + RIGHT);
        self.add(format_args!(
            "<text x=\"{middle}\" y=\"30\" text-anchor=\"middle\" font-size=\"19\">{}</text>",
            escaped(title)
        ));
        self.text(middle, HEIGHT - 14.0, "middle", x_label);
        let y = 0.5 * (TOP + BOTTOM);
        self.add(format_args!(
            "<text transform=\"translate(24 {y}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            escaped(y_label)
        ));
    }

    fn text(&mut self, x: f64, y: f64, anchor: &str, text: &str) {
        self.add(format_args!(
            "<text x=\"{x:.2}\" y=\"{y:.2}\" text-anchor=\"{anchor}\">{}</text>",
            escaped(text)
        ));
    }

    fn curve(&mut self, curve: &[Option<(f64, f64)>], colour: &str, dashed: bool) {
        let mut path = String::new();
        let mut last: Option<(f64, f64)> = None;
        for (i, &point) in curve.iter().enumerate() {
            if let Some((x, y)) = point {
                let ends = curve.get(i + 1).is_none_or(Option::is_none);
                let near = last.is_some_and(|(a, b)| (x - a).abs() < 0.3 && (y - b).abs() < 0.3);
                if near && !ends {
                    continue;
                }
                let _ = write!(path, "{}{x:.2} {y:.2}", if last.is_some() { 'L' } else { 'M' });
            }
            last = point;
        }
        let dashes = dash(dashed);
        if !path.is_empty() {
            self.add(format_args!(
                "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2.2\" \
                 stroke-linejoin=\"round\" stroke-linecap=\"round\"{dashes}/>"
            ));
        }
        // Few points are data, many are a curve; a lonely one would not show at all.
        let few = curve.len() <= 24 && !dashed;
        for (i, point) in curve.iter().enumerate() {
            let gap = |j: Option<usize>| j.and_then(|j| curve.get(j)).is_none_or(Option::is_none);
            let alone = || gap(i.checked_sub(1)) && gap(Some(i + 1));
            if let Some((x, y)) = point
                && (few || alone())
            {
                self.add(format_args!(
                    "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"3.2\" fill=\"{colour}\"/>"
                ));
            }
        }
    }

    /// In the corner where the fewest points of the curves are.
    fn legend(&mut self, series: &[Series], curves: &[Vec<Option<(f64, f64)>>], colours: &[&str]) {
        const LINE: f64 = 23.0;
        const MOST: usize = 14;
        let named: Vec<usize> = (0..series.len()).filter(|&i| !series[i].name.is_empty()).collect();
        if named.is_empty() {
            return;
        }
        let rest = named.len().saturating_sub(MOST);
        let longest = named.iter().map(|&i| series[i].name.chars().count()).max().unwrap_or(0);
        let width = (58.0 + 7.6 * longest as f64).min(0.6 * (RIGHT - LEFT));
        let lines = named.len().min(MOST) + usize::from(rest > 0);
        let height = LINE * lines as f64 + 10.0;
        let corners = [
            (RIGHT - width - 8.0, TOP + 4.0),
            (LEFT + 12.0, BOTTOM - height - 8.0),
            (RIGHT - width - 8.0, BOTTOM - height - 8.0),
            (LEFT + 12.0, TOP + 4.0),
        ];
        let covered = |&(x, y): &(f64, f64)| {
            let inside = |p: (f64, f64)| {
                (x - 6.0..x + width + 6.0).contains(&p.0)
                    && (y - 6.0..y + height + 6.0).contains(&p.1)
            };
            // Also between the points.
            let between = |w: &[Option<(f64, f64)>]| match (w[0], w[1]) {
                (Some(a), Some(b)) => (0..8).any(|k| {
                    let t = f64::from(k) / 8.0;
                    inside((a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1)))
                }),
                (a, b) => a.is_some_and(inside) || b.is_some_and(inside),
            };
            curves.iter().flat_map(|c| c.windows(2)).filter(|w| between(w)).count()
        };
        let (x, y) = corners.into_iter().min_by_key(covered).unwrap_or(corners[0]);
        self.add(format_args!(
            "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" rx=\"4\" \
             fill=\"#ffffff\" fill-opacity=\"0.86\"/>"
        ));
        for (line, &i) in named.iter().take(MOST).enumerate() {
            let y = y + LINE * (line as f64 + 0.5) + 5.0;
            let (from, to, colour) = (x + 10.0, x + 40.0, colours[i]);
            self.add(format_args!(
                "<path d=\"M{from:.2} {y:.2}H{to:.2}\" stroke=\"{colour}\" stroke-width=\"2.2\" \
                 stroke-linecap=\"round\"{}/>",
                dash(series[i].dashed)
            ));
            self.text(x + 50.0, y + 5.0, "start", &series[i].name);
        }
        if rest > 0 {
            let y = y + LINE * (MOST as f64 + 0.5) + 10.0;
            self.text(x + 50.0, y, "start", &format!("and {rest} more"));
        }
    }
}

fn dash(dashed: bool) -> &'static str {
    if dashed { " stroke-dasharray=\"7 6\"" } else { "" }
}

/// Text between tags; characters that XML cannot hold become replacement characters.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '\t' | '\n' | '\r' => out.push(' '),
            '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}
