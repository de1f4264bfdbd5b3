//! [`Arrow`]: a direction at a place; and its solid.

use std::str::FromStr;

use fairform::Vec3;

use crate::Colour;

/// A direction at a place, as a solid that is lit like surfaces but throws no shadow.
///
/// It is drawn a little nearer than it is, so that a surface to which it is tangent does not hide it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Arrow {
    /// Where it begins.
    pub at: Vec3,
    /// Where it points; a direction of length zero draws nothing.
    pub direction: Vec3,
    /// From the beginning to the tip; all else is in proportion.
    pub length: Extent,
    /// Its tip.
    pub head: Head,
    /// Its colour.
    pub colour: Colour,
    /// Whether it is lit; otherwise it has one flat colour.
    pub shaded: bool,
}

impl Arrow {
    /// A red cone on a shaft.
    #[must_use]
    pub fn new(at: Vec3, direction: Vec3) -> Self {
        Self {
            at,
            direction,
            length: Extent::Picture(70.0),
            head: Head::Cone,
            colour: Colour::RED,
            shaded: true,
        }
    }
}

/// A length.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Extent {
    /// In thousandths of the shorter side of the panel, the same wherever it is; foreshortened where
    /// it points into the picture.
    Picture(f64),
    /// In units of the input.
    Space(f64),
}

/// The tip of an arrow: a cone, and what is behind it, so that arrows that coincide can be told apart.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Head {
    /// A cone.
    #[default]
    Cone,
    /// A ball behind the cone.
    Ball,
    /// Another cone behind the cone.
    Double,
    /// A disc behind the cone.
    Disc,
}

impl Head {
    /// Another head for each of four numbers in a row.
    #[must_use]
    pub fn of_index(index: usize) -> Self {
        [Self::Cone, Self::Ball, Self::Double, Self::Disc][index % 4]
    }
}

/// A text is no head.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("`{0}` is no arrow head: expected cone, disc, double or ball")]
pub struct ParseHeadError(String);

impl FromStr for Head {
    type Err = ParseHeadError;

    fn from_str(text: &str) -> Result<Self, ParseHeadError> {
        Ok(match text {
            "cone" => Self::Cone,
            "disc" => Self::Disc,
            "double" => Self::Double,
            "ball" => Self::Ball,
            _ => return Err(ParseHeadError(text.chars().take(80).collect())),
        })
    }
}

/// A circle around the axis, in lengths of the arrow, with the normal of the solid there.
#[derive(Clone, Copy)]
struct Ring {
    along: f64,
    radius: f64,
    /// Along the axis, and away from it.
    normal: [f64; 2],
}

/// Corners of a circle.
const SIDES: usize = 14;
const SHAFT: f64 = 0.023;

/// Points of a solid, at most.
pub(crate) const MOST_POINTS: usize = 2 * SIDES * 10;

/// A part of a solid of revolution between two circles.
fn band(from: [f64; 2], to: [f64; 2]) -> [Ring; 2] {
    let [dx, dr] = [to[0] - from[0], to[1] - from[1]];
    let length = (dx * dx + dr * dr).sqrt();
    let normal = [-dr / length, dx / length];
    [from, to].map(|[along, radius]| Ring { along, radius, normal })
}

/// From the end of the shaft outward and to the tip.
fn cone(base: f64, radius: f64, tip: f64) -> [[Ring; 2]; 2] {
    [band([base, 0.0], [base, radius]), band([base, radius], [tip, 0.0])]
}

fn bands(head: Head) -> Vec<[Ring; 2]> {
    const BALL: f64 = 0.064;
    const STEPS: usize = 6;
    let mut bands = vec![band([0.0, 0.0], [0.0, SHAFT]), band([0.0, SHAFT], [0.7, SHAFT])];
    bands.extend(cone(0.68, 0.084, 1.0));
    match head {
        Head::Cone => {}
        Head::Double => bands.extend(cone(0.40, 0.084, 0.70)),
        Head::Disc => {
            let [back, front, radius] = [0.50, 0.55, 0.105];
            bands.push(band([back, 0.0], [back, radius]));
            bands.push(band([back, radius], [front, radius]));
            bands.push(band([front, radius], [front, 0.0]));
        }
        Head::Ball => {
            let ring = |i: usize| {
                let turn = std::f64::consts::PI * i as f64 / STEPS as f64;
                let [x, r] = [-libm::cos(turn), libm::sin(turn)];
                Ring { along: 0.53 + BALL * x, radius: BALL * r, normal: [x, r] }
            };
            bands.extend((0..STEPS).map(|i| [ring(i), ring(i + 1)]));
        }
    }
    bands
}

/// Points, normals and triangles, counter-clockwise seen from outside.
pub(crate) struct Solid {
    pub(crate) points: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// The arrow that begins at `at` and has a length and a direction of length one.
pub(crate) fn solid(at: Vec3, direction: Vec3, length: f64, head: Head) -> Solid {
    let aside = if direction.x.abs() < 0.7 { Vec3::new(1., 0., 0.) } else { Vec3::new(0., 1., 0.) };
    let u = direction.cross(aside).normalized();
    let v = direction.cross(u);
    let outward: Vec<Vec3> = (0..SIDES)
        .map(|i| {
            let turn = std::f64::consts::TAU * i as f64 / SIDES as f64;
            libm::cos(turn) * u + libm::sin(turn) * v
        })
        .collect();
    let mut solid = Solid { points: Vec::new(), normals: Vec::new(), triangles: Vec::new() };
    for rings in bands(head) {
        let first = solid.points.len() as u32;
        for ring in rings {
            for &out in &outward {
                solid.points.push(at + length * (ring.along * direction + ring.radius * out));
                let [along, away] = ring.normal;
                solid.normals.push(along * direction + away * out);
            }
        }
        let sides = SIDES as u32;
        for i in 0..sides {
            let next = (i + 1) % sides;
            let [a, b, c, d] = [i, next, sides + next, sides + i].map(|k| first + k);
            if rings[0].radius > 1e-12 {
                solid.triangles.push([a, b, d]);
            }
            if rings[1].radius > 1e-12 {
                solid.triangles.push([b, c, d]);
            }
        }
    }
    solid
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each triangle looks where its normals do, and the signed volume is that of a solid.
    #[test]
    fn solids_look_outward() {
        for head in (0..4).map(Head::of_index) {
            let direction = Vec3::new(0.6, -0.48, 0.64);
            let solid = solid(Vec3::new(1., 2., 3.), direction, 2.0, head);
            for t in &solid.triangles {
                let [a, b, c] = t.map(|i| solid.points[i as usize]);
                let side = (b - a).cross(c - a);
                assert!(side.length() > 0.0, "{head:?}");
                for &i in t {
                    let n = solid.normals[i as usize];
                    assert!((n.length() - 1.0).abs() < 1e-12);
                    assert!(side.normalized().dot(n) > 0.7, "{head:?} {n:?}");
                }
            }
            let along: Vec<f64> =
                solid.points.iter().map(|p| (*p - Vec3::new(1., 2., 3.)).dot(direction)).collect();
            let far = along.iter().copied().fold(f64::MIN, f64::max);
            let near = along.iter().copied().fold(f64::MAX, f64::min);
            assert!(near.abs() < 1e-12 && (far - 2.0).abs() < 1e-12, "{head:?} {near} {far}");
        }
    }
}
