//! Polygons cut into triangles, for the formats that hold nothing else.

use std::borrow::Cow;

use fairform::{FaceId, Faces, Vec3};

use crate::par;

/// Above so many corners a polygon that is not convex becomes a fan: cutting ears takes the square
/// of their number.
const MAX_EARS: usize = 2048;

/// Cuts polygons into triangles; one value keeps its working memory for many.
#[derive(Default)]
pub(crate) struct Triangulator {
    points: Vec<[f64; 2]>,
    next: Vec<usize>,
    previous: Vec<usize>,
    ears: Vec<usize>,
}

/// All faces of a mesh as triangles.
pub(crate) struct Triangles<'a> {
    pub(crate) corners: Cow<'a, [[u32; 3]]>,
    /// The face of each, unless that is its own number.
    face_of: Option<Vec<u32>>,
    /// Faces with more than three corners, and with fewer.
    pub(crate) cut: usize,
    pub(crate) dropped: usize,
}

/// All faces as triangles of vertices in their sense of turning, and the face of each. Quadrilaterals are
/// cut along the shorter diagonal, or the one inside; larger polygons become fans if they are convex,
/// otherwise their ears are cut off. Faces with fewer than three corners have none.
///
/// # Panics
/// If a face lists a vertex without a position.
#[must_use]
pub fn triangles(positions: &[Vec3], faces: &Faces) -> (Vec<[u32; 3]>, Vec<u32>) {
    let made = Triangles::new(positions, faces);
    let face_of = (0..made.corners.len()).map(|t| made.face_of(t) as u32).collect();
    (made.corners.into_owned(), face_of)
}

impl<'a> Triangles<'a> {
    pub(crate) fn new(positions: &[Vec3], faces: &'a Faces) -> Self {
        if faces.uniform_size() == Some(3) {
            let corners = Cow::Borrowed(faces.corners().as_chunks::<3>().0);
            return Self { corners, face_of: None, cut: 0, dropped: 0 };
        }
        let parts = par::map(par::blocks(faces.len(), 1 << 14), |block| {
            let mut cutter = Triangulator::default();
            let (mut triangles, mut face_of) = (Vec::new(), Vec::new());
            for face in block {
                let own = faces.get(FaceId(face as u32));
                cutter.cut(positions, own, &mut triangles);
                face_of.resize(triangles.len(), face as u32);
            }
            (triangles, face_of)
        });
        let each: Vec<&[[u32; 3]]> = parts.iter().map(|(triangles, _)| &triangles[..]).collect();
        let faces_of: Vec<&[u32]> = parts.iter().map(|(_, face_of)| &face_of[..]).collect();
        let count = |is: fn(usize) -> bool| faces.iter().filter(|face| is(face.len())).count();
        Self {
            corners: Cow::Owned(par::concat(&each)),
            face_of: Some(par::concat(&faces_of)),
            cut: count(|n| n > 3),
            dropped: count(|n| n < 3),
        }
    }

    pub(crate) fn face_of(&self, triangle: usize) -> usize {
        self.face_of.as_ref().map_or(triangle, |of| of[triangle] as usize)
    }
}

impl Triangulator {
    /// Appends triangles of positions in `corners`, in the polygon's sense of turning: two fewer
    /// than it has corners, none if it has fewer than three.
    ///
    /// A quadrilateral is cut along its shorter diagonal, or the one inside. A larger polygon is
    /// seen along its Newell normal; it becomes a fan if it is convex there, else its ears are cut
    /// off one by one (Meisters 1975). A polygon that crosses itself gives triangles too, of which
    /// nothing is promised.
    pub(crate) fn cut(&mut self, positions: &[Vec3], corners: &[u32], out: &mut Vec<[u32; 3]>) {
        let n = corners.len();
        if n < 3 {
            return;
        }
        let triangle = |[a, b, c]: [usize; 3]| [corners[a], corners[b], corners[c]];
        if n == 3 {
            out.push(triangle([0, 1, 2]));
            return;
        }
        self.flatten(positions, corners);
        let reflex = (0..n).filter(|&i| self.turn((i + n - 1) % n, i, (i + 1) % n) < 0.0).count();
        if n == 4 {
            let p = |i: usize| positions[corners[i] as usize];
            let from = match (0..4).find(|&i| self.turn((i + 3) % 4, i, (i + 1) % 4) < 0.0) {
                Some(corner) if reflex == 1 => corner % 2,
                _ => usize::from((p(3) - p(1)).length() < (p(2) - p(0)).length()),
            };
            out.push(triangle([from, from + 1, from + 2]));
            out.push(triangle([from, from + 2, (from + 3) % 4]));
        } else if reflex == 0 || n > MAX_EARS {
            out.extend((1..n - 1).map(|i| triangle([0, i, i + 1])));
        } else {
            self.cut_ears(n);
            out.extend(self.ears.chunks_exact(3).map(|t| triangle([t[0], t[1], t[2]])));
        }
    }

    /// Puts the corners into the plane across the polygon's normal.
    fn flatten(&mut self, positions: &[Vec3], corners: &[u32]) {
        let p = |i: usize| positions[corners[i % corners.len()] as usize];
        let origin = p(0);
        let normal: Vec3 =
            (0..corners.len()).map(|i| (p(i) - origin).cross(p(i + 1) - origin)).sum();
        // Dropping the coordinate in which the normal is largest keeps the shape and loses no digit.
        let size = [normal.x.abs(), normal.y.abs(), normal.z.abs()];
        let axis = if size[2] >= size[0] && size[2] >= size[1] {
            2
        } else {
            usize::from(size[1] >= size[0])
        };
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let turned = normal[axis] < 0.0;
        self.points.clear();
        self.points.extend((0..corners.len()).map(|i| {
            let d = p(i) - origin;
            if turned { [d[v], d[u]] } else { [d[u], d[v]] }
        }));
    }

    /// Twice the signed area of a triangle of corners: above 0 if it turns left.
    fn turn(&self, a: usize, b: usize, c: usize) -> f64 {
        let [a, b, c] = [self.points[a], self.points[b], self.points[c]];
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    }

    fn cut_ears(&mut self, n: usize) {
        self.next.clear();
        self.next.extend((0..n).map(|i| (i + 1) % n));
        self.previous.clear();
        self.previous.extend((0..n).map(|i| (i + n - 1) % n));
        self.ears.clear();
        let mut left = n;
        let mut tip = 1;
        // Corners looked at since the last cut. Once round without an ear: the polygon crosses
        // itself or is flat, and any corner will do.
        let mut looked = 0;
        while left > 3 {
            let (a, c) = (self.previous[tip], self.next[tip]);
            if looked < left && !self.is_ear(a, tip, c) {
                looked += 1;
                tip = c;
                continue;
            }
            self.ears.extend([a, tip, c]);
            self.next[a] = c;
            self.previous[c] = a;
            left -= 1;
            looked = 0;
            // Skipping a corner makes rounder triangles than going on from here.
            tip = self.next[c];
        }
        self.ears.extend([self.previous[tip], tip, self.next[tip]]);
    }

    /// Whether a triangle turns left and holds no other corner that is left.
    fn is_ear(&self, a: usize, b: usize, c: usize) -> bool {
        if self.turn(a, b, c) <= 0.0 {
            return false;
        }
        let mut q = self.next[c];
        while q != a {
            let inside =
                self.turn(a, b, q) >= 0.0 && self.turn(b, c, q) >= 0.0 && self.turn(c, a, q) >= 0.0;
            #[expect(
                clippy::float_cmp,
                reason = "the very point, as where a polygon touches itself"
            )]
            let at_corner = [a, b, c].iter().any(|&p| self.points[p] == self.points[q]);
            if inside && !at_corner {
                return false;
            }
            q = self.next[q];
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(polygon: &[[f64; 3]]) -> (f64, f64) {
        let positions: Vec<Vec3> = polygon.iter().map(|p| (*p).into()).collect();
        let corners: Vec<u32> = (0..positions.len() as u32).collect();
        let mut triangles = Vec::new();
        Triangulator::default().cut(&positions, &corners, &mut triangles);
        assert_eq!(triangles.len(), polygon.len() - 2);
        let double = |[a, b, c]: [u32; 3]| {
            let [a, b, c] = [a, b, c].map(|v| positions[v as usize]);
            (b - a).cross(c - a)
        };
        let unsigned = triangles.iter().map(|t| double(*t).length()).sum::<f64>();
        let signed: Vec3 = triangles.iter().map(|t| double(*t)).sum();
        (unsigned / 2.0, signed.length() / 2.0)
    }

    /// Triangles that do not overlap have together the polygon's area, each counted positive.
    #[test]
    fn concave_polygons_are_covered_once() {
        let arrow = [[0.0, 0.0, 0.0], [4.0, 1.0, 0.0], [0.0, 2.0, 0.0], [1.0, 1.0, 0.0]];
        assert_eq!(area(&arrow), (3.0, 3.0));
        // A comb whose fan from any corner would leave it, in a tilted plane and in both senses.
        let mut comb = vec![[0.0, 0.0, 0.0]];
        for i in 0..6 {
            let x = f64::from(i);
            comb.extend([
                [x, 3.0, 0.0],
                [x + 0.5, 3.0, 0.0],
                [x + 0.5, 1.0, 0.0],
                [x + 1.0, 1.0, 0.0],
            ]);
        }
        comb.push([6.0, 0.0, 0.0]);
        let tilted = |p: &[f64; 3]| [p[0], p[1], p[0] + 2.0 * p[1]];
        let flat_area = 6.0 + 6.0 * 0.5 * 2.0;
        // Area grows by the length of (−1, −2, 1).
        let expected = flat_area * 6.0_f64.sqrt();
        for polygon in
            [comb.iter().map(tilted).collect::<Vec<_>>(), comb.iter().rev().map(tilted).collect()]
        {
            let (unsigned, signed) = area(&polygon);
            assert!((unsigned - expected).abs() < 1e-12 * expected, "{unsigned} {expected}");
            assert!((signed - expected).abs() < 1e-12 * expected);
        }
    }

    #[test]
    fn a_quad_is_cut_along_its_shorter_diagonal() {
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [3.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let positions = positions.map(Vec3::from);
        let mut out = Vec::new();
        Triangulator::default().cut(&positions, &[0, 1, 2, 3], &mut out);
        assert_eq!(out, [[1, 2, 3], [1, 3, 0]]);
    }

    #[test]
    fn shapeless_polygons_are_cut_too() {
        for value in [0.0, f64::NAN, f64::INFINITY, 1e300] {
            let positions = vec![Vec3::splat(value); 7];
            let mut out = Vec::new();
            Triangulator::default().cut(&positions, &[0, 1, 2, 3, 4, 5, 6], &mut out);
            assert_eq!(out.len(), 5);
        }
        let mut out = Vec::new();
        Triangulator::default().cut(&[Vec3::ZERO; 2], &[0, 1], &mut out);
        assert!(out.is_empty());
    }
}
