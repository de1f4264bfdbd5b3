//! Removing what is no polygon, and mending what nearly is one.

use alloc::vec;
use alloc::vec::Vec;
use core::fmt;

use super::polygon::{Clipped, Shape, clip_ears, unit_points};
use super::report::Sentence;
use super::{Rebuilt, Soup, Touched, source};
use crate::{FaceId, NONE};

/// What [`Soup::drop_degenerate`] did.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
#[must_use]
pub struct DegenerateReport {
    /// Faces dropped, since they list a vertex that there is not.
    pub out_of_range: Touched<FaceId>,
    /// Faces dropped, since a coordinate is infinite or not a number.
    pub not_finite: Touched<FaceId>,
    /// Faces dropped, since fewer than three corners were left.
    pub too_small: Touched<FaceId>,
    /// Faces dropped, since they cross a vertex again in a way that no simple polygons explain.
    pub tangled: Touched<FaceId>,
    /// Faces that lost corners: repeated ones, and spikes that go out and straight back.
    pub shortened: Touched<FaceId>,
    /// Faces that visited a vertex again and became several.
    pub divided: Touched<FaceId>,
}

impl DegenerateReport {
    /// Whether the soup is another one now.
    #[must_use]
    pub fn changed(&self) -> bool {
        self.dropped_count() > 0 || !self.shortened.is_empty() || !self.divided.is_empty()
    }

    /// How many faces are gone without leaving another.
    #[must_use]
    pub fn dropped_count(&self) -> usize {
        [&self.out_of_range, &self.not_finite, &self.too_small, &self.tangled]
            .iter()
            .map(|t| t.count)
            .sum()
    }
}

impl fmt::Display for DegenerateReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let missing = ["face with a vertex out of range", "faces with a vertex out of range"];
        let infinite =
            ["face with a coordinate not finite", "faces with a coordinate that is not finite"];
        let small = ["face of fewer than 3 corners", "faces of fewer than 3 corners"];
        let tangled = ["tangled face", "tangled faces"];
        let short = ["face with repeated corners", "faces with repeated corners"];
        let divided = ["face that met itself", "faces that met themselves"];
        let mut sentence = Sentence::new(f);
        sentence.part("dropped", &self.out_of_range, missing)?;
        sentence.part("dropped", &self.not_finite, infinite)?;
        sentence.part("dropped", &self.too_small, small)?;
        sentence.part("dropped", &self.tangled, tangled)?;
        sentence.part("shortened", &self.shortened, short)?;
        sentence.part("divided", &self.divided, divided)?;
        sentence.end("no degenerate faces")
    }
}

impl Soup {
    /// Leaves proper faces with finite vertices only.
    ///
    /// Faces that list a vertex out of range or a coordinate that is not finite are dropped. A
    /// corner that repeats the one before it goes, and so does a spike `a b a`. A polygon that
    /// still visits a vertex twice is divided there into simple ones; one that is joined to its
    /// own hole by a slit (`0 1 2 3 0 4 5 6 4`, say) is cut into triangles. All of this keeps the
    /// total area vector. What has fewer than three corners then, or resists, is dropped.
    ///
    /// Faces of zero area stay: they are valid.
    ///
    /// # Panics
    /// If there would be 2³² corners or more, which only slits could make of fewer.
    pub fn drop_degenerate(&mut self) -> DegenerateReport {
        let mut report = DegenerateReport::default();
        let mut rebuilt = Rebuilt::for_faces_of(self);
        let mut pieces = Pieces::new(self.positions.len());
        let mut corners = Vec::new();
        for (f, proper) in (0..).zip(self.proper_faces()) {
            let from = source(&self.face_source, f);
            let face = self.faces.get(FaceId(f));
            if face.iter().any(|&v| v as usize >= self.positions.len()) {
                report.out_of_range.face(from);
                continue;
            }
            if !face.iter().all(|&v| self.positions[v as usize].is_finite()) {
                report.not_finite.face(from);
                continue;
            }
            if proper {
                rebuilt.keep(self, f);
                continue;
            }
            corners.clear();
            corners.extend(self.corners_of(f));
            self.remove_spikes(&mut corners);
            let parts = if corners.len() < 3 { 0 } else { pieces.divide(self, &corners) };
            match parts {
                0 if corners.len() < 3 => report.too_small.face(from),
                0 => report.tangled.face(from),
                _ => {
                    if corners.len() < face.len() {
                        report.shortened.face(from);
                    }
                    if parts > 1 {
                        report.divided.face(from);
                    }
                }
            }
            for piece in &pieces.found[..parts] {
                rebuilt.push(self, f, piece);
            }
        }
        if report.changed() {
            rebuilt.replace(self);
        }
        report
    }

    /// Removes corners at the vertex of the one before, and spikes `a b a`, all around.
    fn remove_spikes(&self, corners: &mut Vec<u32>) {
        let mut left: Vec<u32> = Vec::with_capacity(corners.len());
        for &c in corners.iter() {
            let back = |n: usize| left.len().checked_sub(n).map(|i| self.vertex(left[i]));
            if back(1) == Some(self.vertex(c)) {
                continue;
            }
            if back(2) == Some(self.vertex(c)) {
                left.pop();
            } else {
                left.push(c);
            }
        }
        // The same across the end, where what is left can only shrink from both sides.
        let (mut i, mut j) = (0, left.len());
        while j - i >= 2 {
            let v = |k: usize| self.vertex(left[k]);
            if v(j - 1) == v(i) || (j - i > 2 && v(j - 2) == v(i)) {
                j -= 1;
            } else if j - i > 2 && v(j - 1) == v(i + 1) {
                i += 1;
            } else {
                break;
            }
        }
        corners.clear();
        corners.extend_from_slice(&left[i..j]);
    }
}

/// The simple polygons that one polygon falls into.
struct Pieces {
    found: Vec<Vec<u32>>,
    /// Where on the path each vertex stands; [`NONE`] off the path.
    place: Vec<u32>,
}

impl Pieces {
    fn new(vertex_count: usize) -> Self {
        Self { found: Vec::new(), place: vec![NONE; vertex_count] }
    }

    /// Divides a polygon without spikes, and says into how many.
    fn divide(&mut self, soup: &Soup, corners: &[u32]) -> usize {
        self.found.clear();
        // Walk along the polygon; whenever the path meets itself, the loop since then comes off.
        let mut path: Vec<u32> = Vec::new();
        for &c in corners {
            let v = soup.vertex(c) as usize;
            if self.place[v] == NONE {
                self.place[v] = path.len() as u32;
                path.push(c);
            } else {
                let from = self.place[v] as usize;
                self.found.push(path.drain(from..).collect());
                for &d in self.found.last().into_iter().flatten() {
                    self.place[soup.vertex(d) as usize] = NONE;
                }
                self.place[v] = path.len() as u32;
                path.push(c);
            }
        }
        for &c in &path {
            self.place[soup.vertex(c) as usize] = NONE;
        }
        self.found.push(path);
        // A loop of two corners is a slit: its sides belong together across other loops.
        if self.found.iter().any(|piece| piece.len() < 3) && !self.clip(soup, corners) {
            self.found.clear();
        }
        self.found.len()
    }

    /// Cuts a polygon with slits into triangles, if proper ears do it.
    fn clip(&mut self, soup: &Soup, corners: &[u32]) -> bool {
        let vertex = |i: u32| soup.vertex(corners[i as usize]);
        let points = unit_points(corners.iter().map(|&c| soup.positions[soup.vertex(c) as usize]));
        let mut ears = Vec::new();
        let clipped =
            clip_ears(&points, &[(Shape::Ear, true)], |i, j| vertex(i) != vertex(j), &mut ears);
        let mut sides: Vec<[u32; 2]> = ears
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|side| side.map(vertex))
            .collect();
        sides.sort_unstable();
        self.found.clear();
        self.found.extend(ears.iter().map(|ear| ear.map(|i| corners[i as usize]).to_vec()));
        clipped == Clipped::Neat && sides.windows(2).all(|w| w[0] != w[1])
    }
}
