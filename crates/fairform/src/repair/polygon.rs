//! One polygon: its normal, and its triangles by ear clipping.

use alloc::vec;
use alloc::vec::Vec;

use crate::Vec3;

/// The points moved and scaled into a box of about unit size, so that no product of theirs leaves
/// the range; all zero where a coordinate is not finite or all are equal.
///
/// The factor is a power of two, so that straight sides stay straight.
pub(super) fn unit_points(points: impl Iterator<Item = Vec3> + Clone) -> Vec<Vec3> {
    let largest = points.clone().map(Vec3::max_abs).fold(0.0, f64::max);
    if largest == 0.0 || !points.clone().all(Vec3::is_finite) {
        return points.map(|_| Vec3::ZERO).collect();
    }
    let mut unit: Vec<Vec3> = points.map(|p| shrink(p, largest)).collect();
    let first = unit[0];
    let reach = unit.iter().fold(0.0, |reach, &p| f64::max(reach, (p - first).max_abs()));
    for p in &mut unit {
        *p = shrink(*p - first, reach);
    }
    unit
}

/// A vector over the power of two next above `size`.
fn shrink(v: Vec3, size: f64) -> Vec3 {
    let exponent = libm::frexp(size).1;
    let shrink = |x: f64| libm::scalbn(x, -exponent);
    Vec3::new(shrink(v.x), shrink(v.y), shrink(v.z))
}

/// Twice the area vector of a closed polygon (Newell's sum of cross products).
pub(super) fn area_vector(points: &[Vec3]) -> Vec3 {
    let Some(&first) = points.first() else { return Vec3::ZERO };
    points.windows(2).map(|w| (w[0] - first).cross(w[1] - first)).sum()
}

/// What a vertex must fulfil to be cut off, in the plane of the polygon.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Shape {
    /// A convex corner whose triangle holds no other corner.
    Ear,
    /// The same, but the triangle may be flat and others may lie on its rim.
    FlatEar,
    /// Any corner.
    Any,
}

/// How a polygon came out.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Clipped {
    /// Every triangle is a proper ear.
    Neat,
    /// Some triangles are flat or folded over.
    Rough,
    /// No choice of diagonals was found.
    Stuck,
}

/// A triangle in the unit box turns by more than this, twice its area, unless it is flat up to
/// rounding.
const FLAT: f64 = 1e-15;

/// Tests after which a polygon of `n` corners gets a fan: a bound on the time, of a second or so,
/// that ragged polygons reach with some twenty thousand corners.
fn patience(n: usize) -> usize {
    20_000 * n.min(25_000) + 16 * n
}

/// Cuts a polygon of three corners or more into triangles of its corner numbers by clipping ears
/// in its best-fit plane, and appends them to `out`.
///
/// Each try is a shape with whether the diagonal must be free; the next one is used only while no
/// corner passes the ones before. `is_free` says whether the diagonal between two corners may be
/// used.
///
/// After D. Eberly, *Triangulation by Ear Clipping*; after a cut the search goes on beyond the
/// next corner, which keeps a round polygon from becoming a fan.
pub(super) fn clip_ears(
    points: &[Vec3],
    tries: &[(Shape, bool)],
    is_free: impl Fn(u32, u32) -> bool,
    out: &mut Vec<[u32; 3]>,
) -> Clipped {
    let mut ring = Ring::of(points);
    let (mut left, mut at, mut missed, mut level) = (points.len(), 0, 0, 0);
    let mut result = Clipped::Neat;
    while left > 3 {
        if ring.work > patience(points.len()) {
            return ring.fan(at, tries, is_free, out);
        }
        let Some(&(shape, must_be_free)) = tries.get(level) else { return Clipped::Stuck };
        let (before, after) = (ring.before[at as usize], ring.after[at as usize]);
        ring.work += 1;
        if ring.has(shape, at) && (!must_be_free || is_free(before, after)) {
            out.push([before, at, after]);
            if shape != Shape::Ear {
                result = Clipped::Rough;
            }
            ring.cut(at);
            left -= 1;
            (missed, level) = (0, 0);
            at = ring.after[after as usize];
        } else {
            missed += 1;
            if missed == left {
                (missed, level) = (0, level + 1);
            }
            at = after;
        }
    }
    let last = [ring.before[at as usize], at, ring.after[at as usize]];
    out.push(last);
    if ring.turn(last) > FLAT { result } else { Clipped::Rough }
}

/// The corners of a polygon that are left, in its plane.
struct Ring {
    flat: Vec<[f64; 2]>,
    before: Vec<u32>,
    after: Vec<u32>,
    /// Corners that are not convex; also some that have become so.
    dents: Vec<u32>,
    is_dent: Vec<bool>,
    work: usize,
}

impl Ring {
    fn of(points: &[Vec3]) -> Self {
        let n = points.len() as u32;
        let mut ring = Self {
            flat: flatten(points),
            before: (0..n).map(|i| if i == 0 { n - 1 } else { i - 1 }).collect(),
            after: (0..n).map(|i| if i + 1 == n { 0 } else { i + 1 }).collect(),
            dents: Vec::new(),
            is_dent: vec![false; points.len()],
            work: 0,
        };
        for i in 0..n {
            ring.look_at(i);
        }
        ring
    }

    /// Twice the signed area of a triangle of corners.
    fn turn(&self, [a, b, c]: [u32; 3]) -> f64 {
        let [a, b, c] = [a, b, c].map(|i| self.flat[i as usize]);
        turn(a, b, c)
    }

    fn look_at(&mut self, i: u32) {
        let dent = self.turn([self.before[i as usize], i, self.after[i as usize]]) <= FLAT;
        if dent && !self.is_dent[i as usize] {
            self.dents.push(i);
        }
        self.is_dent[i as usize] = dent;
    }

    fn cut(&mut self, i: u32) {
        let (before, after) = (self.before[i as usize], self.after[i as usize]);
        self.after[before as usize] = after;
        self.before[after as usize] = before;
        self.is_dent[i as usize] = false;
        self.look_at(before);
        self.look_at(after);
    }

    fn has(&mut self, shape: Shape, i: u32) -> bool {
        let corners = [self.before[i as usize], i, self.after[i as usize]];
        match shape {
            Shape::Ear => self.turn(corners) > FLAT && self.is_empty(corners, |t| t >= -FLAT),
            Shape::FlatEar => self.turn(corners) >= 0.0 && self.is_empty(corners, |t| t > 0.0),
            Shape::Any => true,
        }
    }

    /// Whether no dent lies inside a triangle; only dents can be the first to enter one.
    fn is_empty(&mut self, corners: [u32; 3], is_in: impl Fn(f64) -> bool) -> bool {
        let [a, b, c] = corners.map(|i| self.flat[i as usize]);
        let mut i = 0;
        while let Some(&dent) = self.dents.get(i) {
            self.work += 1;
            if !self.is_dent[dent as usize] {
                self.dents.swap_remove(i);
                continue;
            }
            i += 1;
            let p = self.flat[dent as usize];
            // A corner at the same place as one of the triangle's is the other side of a slit.
            if ![a, b, c].contains(&p)
                && is_in(turn(a, b, p))
                && is_in(turn(b, c, p))
                && is_in(turn(c, a, p))
            {
                return false;
            }
        }
        true
    }

    /// Gives the rest a fan from the corner `hub`.
    fn fan(
        &self,
        hub: u32,
        tries: &[(Shape, bool)],
        is_free: impl Fn(u32, u32) -> bool,
        out: &mut Vec<[u32; 3]>,
    ) -> Clipped {
        if !tries.iter().any(|&(shape, _)| shape == Shape::Any) {
            return Clipped::Stuck;
        }
        let must_be_free = !tries.contains(&(Shape::Any, false));
        let mut i = self.after[hub as usize];
        while self.after[i as usize] != hub {
            let j = self.after[i as usize];
            if must_be_free && self.after[j as usize] != hub && !is_free(hub, j) {
                return Clipped::Stuck;
            }
            out.push([hub, i, j]);
            i = j;
        }
        Clipped::Rough
    }
}

/// Twice the signed area of a triangle, positive if it runs counter-clockwise.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The points without the coordinate in which the polygon is thinnest, so that no rounding is
/// added; the polygon runs counter-clockwise afterwards.
fn flatten(points: &[Vec3]) -> Vec<[f64; 2]> {
    let normal = area_vector(points);
    let axis =
        (0..3).fold(0, |best, i| if normal[i].abs() > normal[best].abs() { i } else { best });
    let (x, y) = ((axis + 1) % 3, (axis + 2) % 3);
    let (x, y) = if normal[axis] < 0.0 { (y, x) } else { (x, y) };
    points.iter().map(|p| [p[x], p[y]]).collect()
}
