//! [`ModelView`]: a streamline model as parts of a picture.

use std::fmt;
use std::str::FromStr;

use fairform::streamline::{self, Curvature, Grid, Model, Start, curvature};
use fairform::{Bounds, Vec3};

use crate::{Arrow, Colour, Dot, Extent, Head, Line, Part, Style};

/// Something to see of a streamline model.
///
/// Reads from the text that it writes: `surface`, `streamlines`, …
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Show {
    /// The surface.
    Surface,
    /// The streamlines.
    Streamlines,
    /// Lines of constant place across the streamlines.
    Across,
    /// The control tangents at their places on the surface; rows differ by their heads.
    Arrows,
    /// The refined tangents.
    Refined,
    /// The initial curve.
    Initial,
    /// Where the streamlines of the control grid start.
    Start,
    /// Curvature combs on the streamlines of the control grid.
    Combs,
}

impl Show {
    /// Everything.
    pub const ALL: [Self; 8] = [
        Self::Surface,
        Self::Streamlines,
        Self::Across,
        Self::Arrows,
        Self::Refined,
        Self::Initial,
        Self::Start,
        Self::Combs,
    ];
}

impl fmt::Display for Show {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Surface => "surface",
            Self::Streamlines => "streamlines",
            Self::Across => "across",
            Self::Arrows => "arrows",
            Self::Refined => "refined",
            Self::Initial => "initial",
            Self::Start => "start",
            Self::Combs => "combs",
        })
    }
}

/// A text is nothing that can be shown of a model.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error(
    "`{0}` is nothing to show of a model: expected surface, streamlines, across, arrows, refined, \
     initial, start or combs"
)]
pub struct ParseShowError(String);

impl FromStr for Show {
    type Err = ParseShowError;

    fn from_str(text: &str) -> Result<Self, ParseShowError> {
        let found = Self::ALL.into_iter().find(|show| show.to_string() == text.trim());
        found.ok_or_else(|| ParseShowError(text.chars().take(80).collect()))
    }
}

/// How a streamline model is seen.
///
/// ```
/// use fairform::Vec3;
/// use fairform::streamline::{Grid, InitialCurve, Model, Surface};
/// use fairform_render::{ModelView, Options, Panel, View, render};
///
/// let row = [Vec3::new(0.8, 0.0, 0.6), Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.8, 0.0, -0.6)];
/// let points = vec![Vec3::ZERO, Vec3::new(0.0, 3.0, 0.0)];
/// let initial = InitialCurve::Polyline { points, t: vec![0.0, 1.0] };
/// let grid = Grid::from_rows([row; 2]).unwrap();
/// let surface = Surface::new(Model::new(grid, &[4.0, 4.0], vec![0.0, 1.0], initial))?;
/// let parts = ModelView::default().parts(&surface);
/// let panel = Panel { bodies: parts.iter().map(|part| part.body()).collect(), title: None };
/// let picture = render(&[panel], &"iso,z".parse()?, (160, 120), &Options::default())?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, PartialEq, Debug)]
pub struct ModelView {
    /// What is shown.
    pub show: Vec<Show>,
    /// How the surface looks.
    pub style: Style,
    /// The most streamlines, and lines across, that are drawn; of more, every second, fourth, ….
    pub most_lines: usize,
    /// Length of the longest tooth of the combs as a share of the diagonal of the bounding box.
    pub comb: f64,
}

impl Default for ModelView {
    /// The surface, its streamlines and control tangents, and the initial curve.
    fn default() -> Self {
        Self {
            show: vec![Show::Surface, Show::Streamlines, Show::Arrows, Show::Initial],
            style: Style { gloss: 0.3, ..Style::default() },
            most_lines: 50,
            comb: 0.12,
        }
    }
}

const STREAMLINE: Line = Line { colour: Colour::hex(0x1f_3f_6e).with_opacity(0.62), width: 1.5 };
const ACROSS: Line = Line { colour: Colour::hex(0x1f_3f_6e).with_opacity(0.4), width: 1.1 };
const INITIAL: Line = Line { colour: Colour::hex(0x0b_8a_5f), width: 6.0 };
const LEADER: Line = Line { colour: Colour::hex(0x0b_8a_5f), width: 1.5 };
const START: Dot = Dot { colour: Colour::hex(0x0b_8a_5f), radius: 7.0 };
const ARROW: Colour = Colour::hex(0xd9_3a_1e);
const REFINED: Colour = Colour::hex(0xe8_8d_2a);
const TOOTH: Line = Line { colour: Colour::hex(0x8e_24_7a).with_opacity(0.55), width: 1.1 };
const ENVELOPE: Line = Line { colour: Colour::hex(0x8e_24_7a), width: 2.6 };

impl ModelView {
    /// Whether something is shown.
    #[must_use]
    pub fn shows(&self, what: Show) -> bool {
        self.show.contains(&what)
    }

    /// The parts of a picture; the first is the surface, invisible if it is not shown.
    #[must_use]
    pub fn parts(&self, surface: &streamline::Surface) -> Vec<Part> {
        let places = Places::new(surface);
        let mut mesh = self.mesh(surface);
        let mut parts = Vec::new();
        if self.shows(Show::Initial) {
            parts.extend(initial(surface, &mut mesh));
        }
        parts.insert(0, mesh);
        if self.shows(Show::Start) {
            parts.push(start(surface, &places));
        }
        if self.shows(Show::Combs) {
            parts.push(self.combs(surface, &places));
        }
        if self.shows(Show::Refined) {
            parts.push(refined(surface, &places));
        }
        if self.shows(Show::Arrows) {
            parts.push(arrows(surface, &places));
        }
        parts
    }

    fn mesh(&self, surface: &streamline::Surface) -> Part {
        let points = surface.points();
        let (rows, columns) = (points.row_count(), points.column_count());
        let at = |row: usize, i: usize| (row * columns + i) as u32;
        let mut strokes = Vec::new();
        if self.shows(Show::Across) {
            for i in chosen(columns, self.most_lines) {
                strokes.extend((1..rows).map(|row| ([at(row - 1, i), at(row, i)], ACROSS)));
            }
        }
        if self.shows(Show::Streamlines) {
            for row in chosen(rows, self.most_lines) {
                strokes.extend((1..columns).map(|i| ([at(row, i - 1), at(row, i)], STREAMLINE)));
            }
        }
        let fill = self.style.fill.filter(|_| self.shows(Show::Surface));
        Part {
            positions: points.values().to_vec(),
            faces: surface.faces(),
            normals: Some(surface.normals().values().to_vec()),
            strokes,
            arrows: Vec::new(),
            style: Style { fill, ..self.style },
        }
    }

    fn combs(&self, surface: &streamline::Surface, places: &Places) -> Part {
        let Curvature { vector, s, .. } = curvature(surface);
        let rows = control_rows(surface);
        let mut sizes: Vec<f64> =
            rows.iter().flat_map(|&row| vector.row(row)).map(|k| k.length()).collect();
        sizes.sort_unstable_by(f64::total_cmp);
        // Not the very largest: one kink shall not flatten all the others.
        let scale = |largest: f64| self.comb * places.diagonal / largest;
        let size = sizes.get(sizes.len().saturating_sub(1 + sizes.len() / 50)).copied();
        // Where the curve turns the other way the comb is on the other side of the surface.
        let style = Style { through: 0.3, ..Style::default() };
        let mut part = Part { style, ..Part::default() };
        let Some(largest) = size.filter(|size| *size > 0.0 && size.is_finite()) else {
            return part;
        };
        let longest = 2.0 * self.comb * places.diagonal;
        for row in rows {
            let feet: Vec<Vec3> = s.row(row).iter().map(|&s| places.on_row(row, s)).collect();
            let tips = feet.iter().zip(vector.row(row)).map(|(&foot, &k)| {
                let tooth = scale(largest) * k;
                let length = tooth.length();
                foot - if length > longest { longest / length * tooth } else { tooth }
            });
            let tips: Vec<Vec3> = tips.collect();
            for (&foot, &tip) in feet.iter().zip(&tips) {
                part.polyline([foot, tip], TOOTH);
            }
            part.polyline(tips, ENVELOPE);
        }
        part
    }
}

/// The initial curve: on the mesh if it lies at its border, else a part of its own.
fn initial(surface: &streamline::Surface, mesh: &mut Part) -> Option<Part> {
    let points = surface.points();
    let columns = points.column_count();
    let column = match surface.model().start {
        Start::Min => Some(0),
        Start::Max => Some(columns - 1),
        _ => None,
    };
    if let Some(column) = column {
        let at = |row: usize| (row * columns + column) as u32;
        mesh.strokes.extend((1..points.row_count()).map(|k| ([at(k - 1), at(k)], INITIAL)));
        return None;
    }
    let mut part = Part::default();
    part.polyline(surface.model().initial.points(surface.t()).ok()?, INITIAL);
    Some(part)
}

/// Numbers of at most `most` lines of `count`, evenly, the last always among them.
fn chosen(count: usize, most: usize) -> Vec<usize> {
    let mut step = 1;
    while count.div_ceil(step) > most.max(2) {
        step *= 2;
    }
    let mut chosen: Vec<usize> = (0..count).step_by(step).collect();
    if chosen.last().is_some_and(|&last| last + 1 < count) {
        chosen.push(count - 1);
    }
    chosen
}

/// The refined rows nearest to those of the control grid.
fn control_rows(surface: &streamline::Surface) -> Vec<usize> {
    let t = surface.t();
    let nearest = |x: f64| {
        let after = t.partition_point(|&t| t < x).min(t.len() - 1);
        let before = after.saturating_sub(1);
        if x - t[before] < t[after] - x { before } else { after }
    };
    let mut rows: Vec<usize> = surface.model().t.iter().map(|&x| nearest(x)).collect();
    rows.dedup();
    rows
}

/// Where parameters lie on a surface.
struct Places<'a> {
    surface: &'a streamline::Surface,
    parameters: Grid<[f64; 2]>,
    /// Per refined row: the range of parameters before lengths were asked for.
    ranges: Option<Vec<[f64; 2]>>,
    /// Of the bounding box.
    diagonal: f64,
}

impl<'a> Places<'a> {
    fn new(surface: &'a streamline::Surface) -> Self {
        let model = surface.model();
        let ranges = model.length.is_some().then(|| {
            let plain = Model { length: None, details: Vec::new(), ..model.clone() };
            let plain = streamline::Surface::new(plain).ok()?;
            Some(plain.s().rows().map(|s| [s[0], s[s.len() - 1]]).collect())
        });
        Self {
            surface,
            parameters: surface.parameters(),
            ranges: ranges.flatten(),
            diagonal: Bounds::of(surface.points().values().iter().copied()).diagonal(),
        }
    }

    /// The point of a refined streamline at a parameter, or its end.
    fn on_row(&self, row: usize, s: f64) -> Vec3 {
        let (at, points) = (self.parameters.row(row), self.surface.points().row(row));
        let last = points.len() - 1;
        let i = at.partition_point(|&[x, _]| x <= s).clamp(1, last.max(1)) - 1;
        let j = (i + 1).min(last);
        let span = at[j][0] - at[i][0];
        let u = if span > 0.0 { ((s - at[i][0]) / span).clamp(0.0, 1.0) } else { 0.0 };
        (1.0 - u) * points[i] + u * points[j]
    }

    /// The point of the surface at parameters of the control grid, or the nearest that it has.
    fn on_surface(&self, s: f64, t: f64) -> Vec3 {
        let rows = self.surface.t();
        let i = rows.partition_point(|&x| x <= t).clamp(1, rows.len()) - 1;
        let j = (i + 1).min(rows.len() - 1);
        let span = rows[j] - rows[i];
        let u = if span > 0.0 { ((t - rows[i]) / span).clamp(0.0, 1.0) } else { 0.0 };
        let on = |row: usize| self.on_row(row, self.scaled(row, s));
        if u == 0.0 { on(i) } else { (1.0 - u) * on(i) + u * on(j) }
    }

    /// The parameter that one of the control grid became when lengths were asked for.
    fn scaled(&self, row: usize, s: f64) -> f64 {
        let Some(ranges) = &self.ranges else { return s };
        let [first, last] = ranges[row];
        let share = if last > first { (s - first) / (last - first) } else { 0.0 };
        first + share * self.surface.length(row)
    }

    /// A length for arrows at parameters so far apart.
    fn arrow(&self, s: &Grid<f64>, least: f64) -> Extent {
        let range = |s: &[f64]| s[s.len() - 1] - s[0];
        let intervals = s.column_count().saturating_sub(1).max(1) * s.row_count().max(1);
        let step = s.rows().map(range).sum::<f64>() / intervals as f64;
        let length = (0.72 * step).clamp(least * self.diagonal, 0.12 * self.diagonal);
        // A model of a single point has no size.
        if length > 0.0 && length.is_finite() {
            Extent::Space(length)
        } else {
            Extent::Picture(70.0)
        }
    }
}

fn arrows(surface: &streamline::Surface, places: &Places) -> Part {
    let model = surface.model();
    let length = places.arrow(&model.s, 0.025);
    let mut part = Part::default();
    for (row, &t) in model.t.iter().enumerate() {
        let all = model.tangents.row(row).iter().zip(model.s.row(row));
        part.arrows.extend(all.map(|(&direction, &s)| Arrow {
            length,
            head: Head::of_index(row),
            colour: ARROW,
            ..Arrow::new(places.on_surface(s, t), direction)
        }));
    }
    part
}

fn refined(surface: &streamline::Surface, places: &Places) -> Part {
    let length = places.arrow(surface.s(), 0.01);
    let mut part = Part::default();
    for row in 0..surface.tangents().row_count() {
        let all = surface.tangents().row(row).iter().zip(surface.s().row(row));
        part.arrows.extend(all.map(|(&direction, &s)| Arrow {
            length,
            colour: REFINED,
            ..Arrow::new(places.on_row(row, s), direction)
        }));
    }
    part
}

/// The points of the initial curve where streamlines of the control grid start, and what lies between
/// them and streamlines that begin elsewhere.
fn start(surface: &streamline::Surface, places: &Places) -> Part {
    let model = surface.model();
    let t = surface.t();
    let (first, last) = (t[0], t[t.len() - 1]);
    let mut control: Vec<f64> = model.t.iter().map(|t| t.clamp(first, last)).collect();
    control.dedup();
    let points = model.initial.points(&control).unwrap_or_default();
    let mut part = Part::default();
    if let Start::At(s) = model.start {
        for (&point, &t) in points.iter().zip(&control) {
            let near = places.on_surface(s, t);
            if (near - point).length() > 1e-6 * places.diagonal {
                part.polyline([point, near], LEADER);
            }
        }
    }
    let lines = part.positions.len();
    debug_assert_eq!(lines, 2 * part.strokes.len());
    part.positions.extend(points);
    part.style.points = Some(START);
    part
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_shown_is_read_as_written() {
        for show in Show::ALL {
            assert_eq!(show.to_string().parse(), Ok(show));
        }
        assert!("shadow".parse::<Show>().is_err());
    }

    #[test]
    fn lines_are_chosen_evenly_up_to_the_last() {
        assert_eq!(chosen(5, 50), [0, 1, 2, 3, 4]);
        assert_eq!(chosen(9, 5), [0, 2, 4, 6, 8]);
        assert_eq!(chosen(10, 5), [0, 2, 4, 6, 8, 9]);
        assert_eq!(chosen(1, 50), [0]);
    }
}
