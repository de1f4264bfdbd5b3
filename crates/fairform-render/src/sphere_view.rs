//! [`SphereView`]: directions as points and curves of the Gaussian sphere.

use fairform::sphere::{Ends, Error, Knots, QiCurve, Rule, Step, angle, blend};
use fairform::streamline::{self, Model};
use fairform::{Faces, Vec3};

use crate::{Axis, Colour, Dot, Line, Part, Style};

/// Control tangents and the curve that they make.
#[derive(Clone, PartialEq, Debug)]
pub struct Directions {
    /// Control tangents, of length one.
    pub control: Vec<Vec3>,
    /// The refined tangents, joined by great arcs.
    pub curve: Vec<Vec3>,
    /// Whether the first comes after the last.
    pub closed: bool,
}

impl Directions {
    /// Tangents refined by a rule.
    ///
    /// # Errors
    /// As [`Step::new`].
    pub fn subdivided(
        control: Vec<Vec3>,
        rule: Rule,
        ends: Ends,
        depth: u32,
    ) -> Result<Self, Error> {
        let mut curve = control.clone();
        for _ in 0..depth {
            curve = Step::new(rule, ends, curve.len())?.directions(&curve);
        }
        Ok(Self { control, curve, closed: ends == Ends::Closed })
    }

    /// A QI curve, at so many places.
    ///
    /// # Errors
    /// As [`QiCurve::new`].
    pub fn qi(control: Vec<Vec3>, order: usize, knots: Knots, count: usize) -> Result<Self, Error> {
        let curve = QiCurve::new(&control, order, knots)?;
        let last = count.max(2) - 1;
        let curve = (0..=last).map(|i| curve.tangent(i as f64 / last as f64)).collect();
        Ok(Self { control, curve, closed: false })
    }

    /// The streamlines of the control grid of a model, each refined by itself.
    ///
    /// # Errors
    /// As [`Surface::new`](streamline::Surface::new).
    pub fn rows(model: &Model) -> Result<Vec<Self>, streamline::Error> {
        let rule = model.rule()?;
        let row = |row: &[Vec3]| Self::subdivided(row.to_vec(), rule, model.ends, model.depth);
        let sphere = |error| streamline::Error::Sphere { field: "tangents", error };
        model.tangents.rows().map(row).collect::<Result<_, _>>().map_err(sphere)
    }

    /// The columns of the control grid of a model, each refined by itself.
    ///
    /// # Errors
    /// As [`Surface::new`](streamline::Surface::new).
    pub fn columns(model: &Model) -> Result<Vec<Self>, streamline::Error> {
        Self::rows(&Model { tangents: model.tangents.transposed(), ..model.clone() })
    }
}

/// How the Gaussian sphere is seen: the first control tangent red and the others yellow, great arcs
/// between neighbours, each curve in a colour of its own; fainter what lies on the far side.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SphereView {
    /// The axis through the poles.
    pub up: Axis,
    /// Shows the control tangents.
    pub points: bool,
    /// Shows great arcs between neighbouring control tangents.
    pub arcs: bool,
    /// Shows the refined tangents as beads.
    pub beads: bool,
}

impl Default for SphereView {
    fn default() -> Self {
        Self { up: Axis::Y, points: true, arcs: true, beads: false }
    }
}

const GLOBE: Style = Style {
    fill: Some(Colour::hex(0xdc_e4_ee)),
    back: Colour::hex(0xdc_e4_ee),
    surface: crate::Surface::Plain,
    smooth: true,
    gloss: 0.25,
    glow: 0.5,
    wireframe: None,
    boundary: None,
    points: None,
    through: 0.35,
};
const GRATICULE: Line = Line { colour: Colour::hex(0x5b_6f_88).with_opacity(0.45), width: 1.0 };
const EQUATOR: Line = Line { colour: Colour::hex(0x5b_6f_88).with_opacity(0.7), width: 1.4 };
const ARC: Line = Line { colour: Colour::hex(0x2a_33_40).with_opacity(0.85), width: 2.1 };
const CURVE: f64 = 4.0;
const FIRST: Dot = Dot { colour: Colour::hex(0xd9_22_22), radius: 11.0 };
const OTHERS: Dot = Dot { colour: Colour::hex(0xf5_bd_17), radius: 10.0 };
const BEAD: f64 = 4.5;
/// How much of lines and points on the far side shows.
const THROUGH: f64 = 0.3;
/// Colours of the curves, in turn: far apart, and none that of the points.
const COLOURS: [Colour; 6] = [
    Colour::hex(0x1f_5f_c4),
    Colour::hex(0x0f_8a_5f),
    Colour::hex(0x8e_2f_9e),
    Colour::hex(0xd8_62_1a),
    Colour::hex(0x12_8f_a8),
    Colour::hex(0x7a_5a_2e),
];

/// Meridians of the globe and parallels between its poles, in degrees from one to the next.
const STEP: usize = 3;
/// Of the graticule, in steps of the globe.
const EVERY: usize = 10;

impl SphereView {
    /// The parts of a picture; the first is the globe.
    #[must_use]
    pub fn parts(&self, sequences: &[Directions]) -> Vec<Part> {
        let mut parts = vec![self.globe()];
        let seen =
            || Part { style: Style { through: THROUGH, ..Style::default() }, ..Part::default() };
        if self.arcs {
            let mut part = seen();
            for sequence in sequences {
                part.polyline(arcs(&sequence.control, sequence.closed, 1.001), ARC);
            }
            parts.push(part);
        }
        let mut curves = seen();
        for (i, sequence) in sequences.iter().enumerate() {
            let colour = COLOURS[i % COLOURS.len()];
            let line = Line { colour, width: CURVE };
            curves.polyline(arcs(&sequence.curve, sequence.closed, 1.002), line);
            if self.beads {
                // What is a control tangent has its own.
                let is_new = |t: &&Vec3| sequence.control.iter().all(|c| angle(*c, **t) > 1e-3);
                let new: Vec<Vec3> = sequence.curve.iter().filter(is_new).copied().collect();
                parts.push(beads(&new, Dot { colour, radius: BEAD }, 1.004));
            }
        }
        parts.push(curves);
        if self.points {
            let first = sequences.iter().filter_map(|s| s.control.first().copied());
            let others = sequences.iter().flat_map(|s| s.control.iter().skip(1).copied());
            parts.push(beads(&others.collect::<Vec<_>>(), OTHERS, 1.012));
            parts.push(beads(&first.collect::<Vec<_>>(), FIRST, 1.014));
        }
        parts
    }

    fn globe(self) -> Part {
        let pole = self.up.direction();
        let side = self.up.next().direction();
        let other = pole.cross(side);
        let (around, between) = (360 / STEP, 180 / STEP - 1);
        let angle = |i: usize| ((i * STEP) as f64).to_radians();
        let mut positions = vec![pole];
        for k in 1..=between {
            let (height, radius) = (libm::cos(angle(k)), libm::sin(angle(k)));
            positions.extend((0..around).map(|i| {
                let (c, s) = (libm::cos(angle(i)), libm::sin(angle(i)));
                height * pole + radius * (c * side + s * other)
            }));
        }
        positions.push(-pole);
        let last = positions.len() as u32 - 1;
        let at = |k: usize, i: usize| match k {
            0 => 0,
            k if k > between => last,
            k => (1 + (k - 1) * around + i % around) as u32,
        };
        let mut faces: Vec<Vec<u32>> = Vec::new();
        let mut strokes = Vec::new();
        for k in 0..=between {
            for i in 0..around {
                let mut face = vec![at(k, i), at(k + 1, i), at(k + 1, i + 1), at(k, i + 1)];
                face.dedup();
                if face.first() == face.last() {
                    face.pop();
                }
                faces.push(face);
                if i % EVERY == 0 {
                    strokes.push(([at(k, i), at(k + 1, i)], GRATICULE));
                }
                if k > 0 && k % EVERY == 0 {
                    let line = if 2 * k == between + 1 { EQUATOR } else { GRATICULE };
                    strokes.push(([at(k, i), at(k, i + 1)], line));
                }
            }
        }
        Part {
            normals: Some(positions.clone()),
            positions,
            faces: faces.iter().collect::<Faces>(),
            strokes,
            arrows: Vec::new(),
            style: GLOBE,
        }
    }
}

/// Points of the great arcs that join directions, on a sphere of some radius.
fn arcs(directions: &[Vec3], closed: bool, radius: f64) -> Vec<Vec3> {
    // So short that chords stay on the same side of the globe's faces.
    const TURN: f64 = 0.02;
    let mut points: Vec<Vec3> = directions.first().map(|&t| radius * t).into_iter().collect();
    let around = directions.first().filter(|_| closed && directions.len() > 2);
    let next = directions.iter().skip(1).chain(around);
    for (&from, &to) in directions.iter().zip(next) {
        let count = libm::ceil(angle(from, to) / TURN).max(1.0);
        let parts = count as u32;
        points.extend((1..=parts).map(|i| {
            let t = if i == parts { to } else { blend(from, to, f64::from(i) / count) };
            radius * t
        }));
    }
    points
}

fn beads(directions: &[Vec3], dot: Dot, radius: f64) -> Part {
    Part {
        positions: directions.iter().map(|&t| radius * t).collect(),
        style: Style { points: Some(dot), glow: 0.5, through: THROUGH, ..Style::default() },
        ..Part::default()
    }
}
