//! Closing holes with triangles.

use alloc::vec;
use alloc::vec::Vec;
use core::fmt;

use super::edges::{EdgeSet, Edges};
use super::polygon::{Clipped, Shape, clip_ears, unit_points};
use super::report::Sentence;
use super::{Soup, Touched, source};
use crate::{NONE, Vec3, VertexId};

/// What [`Soup::fill_holes`] did.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
#[must_use]
pub struct HoleReport {
    /// The holes closed, each named by a vertex on its rim.
    pub filled: Touched<VertexId>,
    /// Holes with more corners than asked for.
    pub too_large: Touched<VertexId>,
    /// Holes left open, since every way to close them would double an edge, their rim visits a
    /// vertex twice, or a coordinate is not finite.
    pub resisting: Touched<VertexId>,
    /// How many triangles were appended.
    pub new_face_count: usize,
}

impl HoleReport {
    /// Whether the soup is another one now.
    #[must_use]
    pub fn changed(&self) -> bool {
        !self.filled.is_empty()
    }
}

impl fmt::Display for HoleReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut sentence = Sentence::new(f);
        sentence.part("filled", &self.filled, ["hole", "holes"])?;
        sentence.count("added", self.new_face_count, ["triangle", "triangles"])?;
        sentence.part("left", &self.too_large, ["larger hole", "larger holes"])?;
        sentence.part(
            "could not fill",
            &self.resisting,
            ["hole without doubling an edge", "holes without doubling an edge"],
        )?;
        sentence.end("no holes")
    }
}

/// Up to so many corners a hole gets its best triangles (time grows with the cube), beyond them
/// ears.
const BEST_UP_TO: usize = 200;

impl Soup {
    /// Closes every hole of at most `max_corners` edges with triangles appended after the faces,
    /// oriented like the faces around it.
    ///
    /// A hole is a boundary loop; the outer rim of an open sheet is one, too. Up to 200 corners
    /// the triangles have the smallest total area, found by dynamic programming; larger holes are
    /// clipped ear by ear. No triangle repeats an edge that the soup has, so a manifold stays one;
    /// where that cannot be, the hole stays open. \[Barequet1995\]
    ///
    /// # Panics
    /// If there would be 2³² corners or more.
    pub fn fill_holes(&mut self, max_corners: usize) -> HoleReport {
        let edges = Edges::of(self);
        let rims = self.rims(&edges);
        let mut taken = edges.into_set();
        let mut report = HoleReport::default();
        let mut triangles = Vec::new();
        let mut seen = vec![false; self.positions.len()];
        for rim in rims {
            let name = source(&self.vertex_source, rim[0]);
            if rim.len() > max_corners {
                report.too_large.vertex(name);
                continue;
            }
            triangles.clear();
            if !self.close(&rim, &taken, &mut seen, &mut triangles) {
                report.resisting.vertex(name);
                continue;
            }
            report.filled.vertex(name);
            report.new_face_count += triangles.len();
            for triangle in &triangles {
                let [a, b, c] = triangle.map(|i| rim[i as usize]);
                self.faces.push(&[a, b, c]);
                self.face_source.push(NONE);
                self.corner_source.extend([NONE; 3]);
                for [a, b] in [[a, b], [b, c], [c, a]] {
                    taken.add(a, b);
                }
            }
        }
        report
    }

    /// The boundary loops, each as the polygon that would close it.
    fn rims(&self, edges: &Edges) -> Vec<Vec<u32>> {
        let mut mate = edges.mates();
        let mut is_rim = vec![false; mate.len()];
        for group in edges.groups() {
            if let [[.., h]] = *group {
                is_rim[h as usize] = true;
            } else if let [[.., g], [.., h]] = *group
                && self.vertex(g) == self.vertex(h)
            {
                mate[g as usize] = NONE;
                mate[h as usize] = NONE;
            }
        }
        let mut rims = Vec::new();
        let mut seen = vec![false; mate.len()];
        for start in (0..mate.len() as u32).filter(|&h| is_rim[h as usize]) {
            let mut rim = Vec::new();
            let mut h = start;
            while h != NONE && is_rim[h as usize] && !seen[h as usize] {
                seen[h as usize] = true;
                rim.push(self.vertex(h));
                // Turn around the end of `h`, from face to face, to the other end of its fan.
                h = edges.next[h as usize];
                while h != NONE && !is_rim[h as usize] {
                    let m = mate[h as usize];
                    h = if m == NONE { NONE } else { edges.next[m as usize] };
                }
            }
            // A rim that ends at an edge of three faces, say, is no loop and nothing to fill.
            if h == start && rim.len() >= 3 {
                rim.reverse();
                rims.push(rim);
            }
        }
        rims
    }

    /// The triangles that close a rim, as places on it; false if there are none.
    fn close(
        &self,
        rim: &[u32],
        taken: &EdgeSet,
        seen: &mut [bool],
        out: &mut Vec<[u32; 3]>,
    ) -> bool {
        let mut is_simple = true;
        for &v in rim {
            is_simple &= !core::mem::replace(&mut seen[v as usize], true);
        }
        for &v in rim {
            seen[v as usize] = false;
        }
        let corners = rim.iter().map(|&v| self.positions[v as usize]);
        if !is_simple || !corners.clone().all(Vec3::is_finite) {
            return false;
        }
        let points = unit_points(corners);
        let is_free = |i: u32, j: u32| !taken.has(rim[i as usize], rim[j as usize]);
        if rim.len() <= BEST_UP_TO {
            smallest(&points, is_free, out)
        } else {
            let tries = [(Shape::Ear, true), (Shape::FlatEar, true), (Shape::Any, true)];
            clip_ears(&points, &tries, is_free, out) != Clipped::Stuck
        }
    }
}

/// The triangulation of a closed polygon in space with the smallest total area, whose diagonals
/// are all free; false if there is none.
///
/// ```math
/// w_{ik} = \min_{i<j<k} \; w_{ij} + w_{jk} + a(i,j,k)
/// ```
///
/// where `a` is the area plus a thousandth of the squared sides, which picks well-shaped triangles
/// among equal areas, as in a flat hole. \[Barequet1995\]
fn smallest(points: &[Vec3], is_free: impl Fn(u32, u32) -> bool, out: &mut Vec<[u32; 3]>) -> bool {
    let n = points.len();
    let mut weight = vec![0.0; n * n];
    let mut middle = vec![NONE; n * n];
    for gap in 2..n {
        for i in 0..n - gap {
            let k = i + gap;
            let mut best = (f64::INFINITY, NONE);
            if gap == n - 1 || is_free(i as u32, k as u32) {
                for j in i + 1..k {
                    let parts = weight[i * n + j] + weight[j * n + k];
                    if parts < best.0 {
                        let total = parts + cost(points[i], points[j], points[k]);
                        if total < best.0 {
                            best = (total, j as u32);
                        }
                    }
                }
            }
            (weight[i * n + k], middle[i * n + k]) = best;
        }
    }
    if middle[n - 1] == NONE {
        return false;
    }
    let mut open = vec![(0, n - 1)];
    while let Some((i, k)) = open.pop() {
        if k - i >= 2 {
            let j = middle[i * n + k] as usize;
            out.push([i as u32, j as u32, k as u32]);
            open.push((j, k));
            open.push((i, j));
        }
    }
    true
}

fn cost(a: Vec3, b: Vec3, c: Vec3) -> f64 {
    let (u, v) = (b - a, c - a);
    let w = v - u;
    0.5 * u.cross(v).length() + 1e-3 * (u.dot(u) + v.dot(v) + w.dot(w))
}
