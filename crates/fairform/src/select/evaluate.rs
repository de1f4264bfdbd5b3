//! From [`Expression`] to the faces it picks.

use alloc::format;
use alloc::vec::Vec;
use core::cell::OnceCell;

use super::error::{Place, SelectError};
use super::expression::{Expression, Naming, Numbering, Range, Test};
use super::pattern::{Known, Pattern};
use super::{Context, Labels};
use crate::topology::Components;
use crate::{FaceId, Mesh, Vec3, par};

/// An angle computed from coordinates is off by about this much, in radians; faces that just touch
/// the bound are within it.
const ANGLE_ROUNDING: f64 = 1e-11;

/// The faces that an expression picks.
pub(super) fn faces(
    expression: &Expression,
    context: &Context<'_>,
) -> Result<Vec<bool>, SelectError> {
    Evaluator { context, parts: OnceCell::new() }.expression(expression)
}

struct Evaluator<'a> {
    context: &'a Context<'a>,
    parts: OnceCell<Components>,
}

impl Evaluator<'_> {
    /// Every operand is evaluated, whatever the others pick, so that no mistake stays hidden.
    fn expression(&self, expression: &Expression) -> Result<Vec<bool>, SelectError> {
        match expression {
            Expression::Test(test) => self.test(test),
            Expression::Not(inner) => {
                let mut picked = self.expression(inner)?;
                for face in &mut picked {
                    *face = !*face;
                }
                Ok(picked)
            }
            Expression::And(terms) => self.fold(terms, true, |a, b| a & b),
            Expression::Or(terms) => self.fold(terms, false, |a, b| a | b),
        }
    }

    fn fold(
        &self,
        terms: &[Expression],
        start: bool,
        join: impl Fn(bool, bool) -> bool,
    ) -> Result<Vec<bool>, SelectError> {
        let mut picked = alloc::vec![start; self.face_count()];
        for term in terms {
            for (face, other) in picked.iter_mut().zip(self.expression(term)?) {
                *face = join(*face, other);
            }
        }
        Ok(picked)
    }

    fn test(&self, test: &Test) -> Result<Vec<bool>, SelectError> {
        let mesh = self.context.mesh;
        Ok(match test {
            Test::All => alloc::vec![true; self.face_count()],
            Test::None => alloc::vec![false; self.face_count()],
            Test::Boundary => {
                let topology = mesh.topology();
                self.each(|f| topology.face_halfedges(f).any(|h| topology.twin(h).is_none()))
            }
            Test::Named(naming, patterns) => return self.named(*naming, patterns),
            Test::Numbered(Numbering::Face, ranges) => return self.numbers(ranges),
            Test::Numbered(Numbering::Part, ranges) => return self.in_parts(ranges),
            Test::Numbered(Numbering::Corners, ranges) => self.each(|f| {
                let count = mesh.topology().face_vertices(f).len() as u32;
                ranges.iter().any(|range| range.contains(count))
            }),
            &Test::Axis { axis, comparison, bound } => {
                self.each(|f| comparison.holds(centre(mesh, f)[axis], bound))
            }
            &Test::Plane { normal, offset } => self.each(|f| normal.dot(centre(mesh, f)) > offset),
            &Test::Box([a, b]) => {
                let (low, high) = (a.min(b), a.max(b));
                self.each(|f| {
                    let p = centre(mesh, f);
                    (0..3).all(|axis| (low[axis]..=high[axis]).contains(&p[axis]))
                })
            }
            &Test::Sphere { centre: middle, radius } => {
                self.each(|f| (centre(mesh, f) - middle).length() <= radius)
            }
            &Test::Normal { direction, degrees } => {
                let direction = direction.normalized();
                let most = degrees.to_radians() + ANGLE_ROUNDING;
                self.each(|f| {
                    let normal = normal(mesh, f);
                    let angle =
                        libm::atan2(normal.cross(direction).length(), normal.dot(direction));
                    normal != Vec3::ZERO && angle <= most
                })
            }
        })
    }

    fn named(&self, naming: Naming, patterns: &[Pattern]) -> Result<Vec<bool>, SelectError> {
        let what = naming.word();
        let place = patterns[0].place;
        let labels = match naming {
            Naming::Group => &self.context.groups,
            Naming::Material => &self.context.materials,
        };
        let Some(Labels { names, of_face }) = labels.as_ref().filter(|l| !l.names.is_empty())
        else {
            let expected = format!("a mesh with {what} names, or another test");
            return Err(place.error(format!("the mesh has no {what} names"), expected));
        };
        if of_face.len() != self.face_count() {
            let message = format!("the mesh has {what} names for {} faces", of_face.len());
            return Err(place.error(message, format!("names for all {} faces", self.face_count())));
        }
        let mut picked = alloc::vec![false; names.len()];
        for pattern in patterns {
            let mut matched = false;
            for (picked, name) in picked.iter_mut().zip(names) {
                let matches = pattern.matches(name);
                *picked |= matches;
                matched |= matches;
            }
            if !matched {
                let message = format!("there is no {what} {pattern}");
                return Err(pattern.place.error(message, format!("{}", Known(names))));
            }
        }
        Ok(self.each(|f| picked.get(of_face[f.index()] as usize).is_some_and(|&picked| picked)))
    }

    fn numbers(&self, ranges: &[Range]) -> Result<Vec<bool>, SelectError> {
        numbered(ranges, self.face_count(), Numbering::Face)
    }

    fn in_parts(&self, ranges: &[Range]) -> Result<Vec<bool>, SelectError> {
        let topology = self.context.mesh.topology();
        let parts = self.parts.get_or_init(|| topology.components());
        let picked = numbered(ranges, parts.list.len(), Numbering::Part)?;
        Ok(self.each(|f| {
            let part = parts.of_vertex[topology.face_vertices(f)[0].index()];
            picked[part as usize]
        }))
    }

    fn face_count(&self) -> usize {
        self.context.mesh.topology().face_count()
    }

    fn each(&self, picks: impl Fn(FaceId) -> bool + Sync) -> Vec<bool> {
        par::collect(self.face_count(), |f| picks(FaceId(f as u32)))
    }
}

/// Which of `count` things have a number in one of the ranges.
fn numbered(
    ranges: &[Range],
    count: usize,
    numbering: Numbering,
) -> Result<Vec<bool>, SelectError> {
    let mut picked = alloc::vec![false; count];
    for &Range { first, last, place } in ranges {
        let missing = |number| no_such(number, count, numbering, place);
        if first as usize >= count {
            return Err(missing(first));
        }
        let end = match last {
            Some(last) if last as usize >= count => return Err(missing(last)),
            Some(last) => last as usize + 1,
            None => count,
        };
        picked[first as usize..end].fill(true);
    }
    Ok(picked)
}

fn no_such(number: u32, count: usize, numbering: Numbering, place: Place) -> SelectError {
    let what = numbering.word();
    let expected = match count {
        0 => format!("a mesh with {what}s"),
        1 => format!("{what} 0, the only one"),
        _ => format!("a {what} from 0 to {}", count - 1),
    };
    place.error(format!("there is no {what} {number}"), expected)
}

/// The mean of the corners of a face.
pub(super) fn centre(mesh: &Mesh, face: FaceId) -> Vec3 {
    let corners = mesh.topology().face_vertices(face);
    let position = |i: usize| mesh.positions()[corners[i].index()];
    let count = corners.len() as f64;
    // From one of the corners, so that a level face at z = 0.1 has its centre just there.
    let first = position(0);
    let centre = first + (1..corners.len()).map(|i| position(i) - first).sum::<Vec3>() / count;
    if centre.is_finite() {
        return centre;
    }
    (0..corners.len()).map(|i| position(i) / count).sum()
}

/// The unit normal of a face, the direction of its vector area; zero if it has none.
fn normal(mesh: &Mesh, face: FaceId) -> Vec3 {
    let corners = mesh.topology().face_vertices(face);
    let first = 0.5 * mesh.positions()[corners[0].index()];
    // Halves, and then shares of the largest, since differences and products can overflow.
    let arm = |i: usize| 0.5 * mesh.positions()[corners[i].index()] - first;
    let size = (1..corners.len()).map(|i| arm(i).max_abs()).fold(0.0, f64::max);
    if size == 0.0 {
        return Vec3::ZERO;
    }
    let area: Vec3 = (2..corners.len()).map(|i| (arm(i - 1) / size).cross(arm(i) / size)).sum();
    area.normalized()
}
