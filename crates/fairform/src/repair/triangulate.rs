//! Cutting polygons into triangles.

use alloc::vec::Vec;
use core::fmt;

use super::edges::{EdgeSet, Edges};
use super::polygon::{Clipped, Shape, area_vector, clip_ears, unit_points};
use super::report::Sentence;
use super::{Rebuilt, Soup, Touched, source};
use crate::{FaceId, Vec3};

/// What [`Soup::triangulate`] did.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
#[must_use]
pub struct TriangulateReport {
    /// The polygons cut.
    pub cut: Touched<FaceId>,
    /// Those of them with triangles that are flat or folded over, since the polygon is flat,
    /// crosses itself, or leaves no other choice.
    pub rough: Touched<FaceId>,
    /// Those of them with a diagonal that is also an edge elsewhere, which makes the edge
    /// non-manifold.
    pub doubled: Touched<FaceId>,
}

impl TriangulateReport {
    /// Whether the soup is another one now.
    #[must_use]
    pub fn changed(&self) -> bool {
        !self.cut.is_empty()
    }
}

impl fmt::Display for TriangulateReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut sentence = Sentence::new(f);
        sentence.part("cut into triangles", &self.cut, ["polygon", "polygons"])?;
        sentence.part("not neatly", &self.rough, ["polygon", "polygons"])?;
        sentence.part("doubling an edge", &self.doubled, ["polygon", "polygons"])?;
        sentence.end("all faces are triangles")
    }
}

/// A diagonal that doubles an edge breaks the topology, a crooked triangle only the looks; so the
/// first is avoided before the second.
const TRIES: [(Shape, bool); 5] = [
    (Shape::Ear, true),
    (Shape::FlatEar, true),
    (Shape::Any, true),
    (Shape::Ear, false),
    (Shape::Any, false),
];

impl Soup {
    /// Cuts every proper face of more than three corners into triangles, without new vertices;
    /// they take its place in the order of the faces.
    ///
    /// A quad gets the shorter diagonal of those that lie inside it, larger polygons are clipped
    /// ear by ear in their best-fit plane. Diagonals that are edges of the soup already are
    /// avoided. A polygon that no ears fit gets a fan, and so does what is left of a ragged one of more
    /// than some twenty thousand corners when the time is up.
    ///
    /// # Panics
    /// If there would be 2³² corners or more.
    pub fn triangulate(&mut self) -> TriangulateReport {
        let mut report = TriangulateReport::default();
        if self.faces.iter().all(|face| face.len() <= 3) {
            return report;
        }
        let mut taken = Edges::of(self).into_set();
        let mut rebuilt = Rebuilt::for_faces_of(self);
        let mut triangles = Vec::new();
        for (f, proper) in (0..).zip(self.proper_faces()) {
            let face = self.faces.get(FaceId(f));
            if face.len() <= 3 || !proper {
                rebuilt.keep(self, f);
                continue;
            }
            let from = source(&self.face_source, f);
            triangles.clear();
            let clipped = self.cut_polygon(face, &taken, &mut triangles);
            report.cut.face(from);
            if clipped == Clipped::Rough {
                report.rough.face(from);
            }
            let start = self.corners_of(f).start;
            for triangle in &triangles {
                rebuilt.push(self, f, &triangle.map(|i| start + i));
            }
            let diagonals: Vec<[u32; 2]> = diagonals(face.len() as u32, &triangles)
                .map(|ends| ends.map(|i| face[i as usize]))
                .collect();
            if diagonals.iter().any(|&[a, b]| taken.has(a, b)) {
                report.doubled.face(from);
            }
            for [a, b] in diagonals {
                taken.add(a, b);
            }
        }
        if report.changed() {
            rebuilt.replace(self);
        }
        report
    }

    fn cut_polygon(&self, face: &[u32], taken: &EdgeSet, out: &mut Vec<[u32; 3]>) -> Clipped {
        let points = unit_points(face.iter().map(|&v| self.positions[v as usize]));
        let is_free = |i: u32, j: u32| !taken.has(face[i as usize], face[j as usize]);
        if face.len() == 4 {
            cut_quad(&points, is_free, out)
        } else {
            clip_ears(&points, &TRIES, is_free, out)
        }
    }
}

/// Cuts a quad along a free diagonal before a taken one, one inside it before one outside, and the
/// shorter before the longer.
fn cut_quad(
    points: &[Vec3],
    is_free: impl Fn(u32, u32) -> bool,
    out: &mut Vec<[u32; 3]>,
) -> Clipped {
    let normal = area_vector(points);
    let cuts = [[[0, 1, 2], [0, 2, 3]], [[3, 0, 1], [3, 1, 2]]];
    let key = |cut: [[u32; 3]; 2]| {
        let [a, _, b] = cut[0];
        let is_inside = cut.iter().all(|t| {
            let corners = t.map(|i| points[i as usize]);
            area_vector(&corners).dot(normal) > 0.0
        });
        let length = (points[a as usize] - points[b as usize]).length();
        (!is_free(a, b), !is_inside, length)
    };
    let [first, second] = cuts.map(key);
    let length_differs = second.2 < first.2 * (1.0 - 1e-12);
    let use_second = (second.0, second.1) < (first.0, first.1)
        || ((second.0, second.1) == (first.0, first.1) && length_differs);
    out.extend(cuts[usize::from(use_second)]);
    if [first, second][usize::from(use_second)].1 { Clipped::Rough } else { Clipped::Neat }
}

/// The sides of the triangles that are no sides of the polygon of `n` corners, once each.
fn diagonals(n: u32, triangles: &[[u32; 3]]) -> impl Iterator<Item = [u32; 2]> {
    triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .filter(move |&[a, b]| a < b && b - a != 1 && b - a != n - 1)
}
