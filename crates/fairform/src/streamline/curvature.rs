//! Curvature of streamlines, exact from the tangents.

use crate::Vec3;
use crate::sphere;

use super::{Grid, Integration, Surface};

/// Curvature of all streamlines of a surface between neighbouring tangents, where the natural curve
/// is a circular arc: row by row, one value less than there are tangents.
#[derive(Clone, PartialEq, Debug)]
pub struct Curvature {
    /// Curvature vectors: towards the centre of the arc, as long as one over its radius.
    pub vector: Grid<Vec3>,
    /// Their parameters: the middles between those of the tangents.
    pub s: Grid<f64>,
    /// How the length changes along the streamline, $`\mathrm d\kappa / \mathrm d s`$, by
    /// differences; zero in rows with fewer than three tangents.
    pub variation: Grid<f64>,
}

impl Curvature {
    /// The integral of $`\kappa^2`$ along all streamlines, each arc with its exact length.
    #[must_use]
    pub fn bending_energy(&self, surface: &Surface) -> f64 {
        let rows = self.vector.rows().zip(surface.s().rows());
        let row = |(vectors, s): (&[Vec3], &[f64])| -> f64 {
            let arcs = vectors.iter().zip(s.windows(2));
            arcs.map(|(k, s)| k.dot(*k) * (s[1] - s[0])).sum()
        };
        rows.map(row).sum()
    }

    /// The curvature vectors at the points of the surface. The midpoint rule has a point in the middle of
    /// each arc; elsewhere it is the mean of both sides, and at the ends the first and the last. Zero on
    /// streamlines with one tangent.
    #[must_use]
    pub fn at_points(&self, surface: &Surface) -> Grid<Vec3> {
        let is_between = surface.model().integration == Integration::Midpoint;
        let count = surface.points().column_count();
        let of_row = |vectors: &[Vec3]| -> alloc::vec::Vec<Vec3> {
            let Some(last) = vectors.len().checked_sub(1) else {
                return alloc::vec![Vec3::ZERO; count];
            };
            let at = |i: usize| {
                let (before, after) =
                    (vectors[i.saturating_sub(1).min(last)], vectors[i.min(last)]);
                if is_between { before } else { 0.5 * (before + after) }
            };
            (0..count).map(at).collect()
        };
        // A row of no vectors is a row still.
        if self.vector.column_count() == 0 {
            return Grid::filled(surface.points().row_count(), count, Vec3::ZERO);
        }
        Grid::collected(self.vector.rows().map(of_row))
    }
}

/// Curvature along the streamlines:
///
/// ```math
/// \kappa_i = \frac{\angle(t_i, t_{i+1})}{s_{i+1} - s_i}
/// ```
#[must_use]
pub fn curvature(surface: &Surface) -> Curvature {
    let rows = || surface.tangents().rows().zip(surface.s().rows());
    let vectors = rows().map(|(tangents, s)| {
        let pairs = tangents.windows(2).zip(s.windows(2));
        pairs.map(|(t, s)| {
            let size = sphere::angle(t[0], t[1]) / (s[1] - s[0]);
            let between = sphere::midpoint(t[0], t[1]);
            // Along the chord on the sphere; for opposite tangents along the arc that is taken.
            let towards = if t[0] == t[1] { Vec3::ZERO } else { t[1] - t[0] };
            size * (towards - towards.dot(between) * between).normalized()
        })
    });
    let vector = Grid::collected(vectors);
    let middles = rows().map(|(_, s)| s.windows(2).map(|s| 0.5 * (s[0] + s[1])));
    let s = Grid::collected(middles);
    let mut variation = Grid::filled(vector.row_count(), vector.column_count(), 0.0);
    let count = vector.column_count();
    for row in (0..vector.row_count()).filter(|_| count > 1) {
        let (k, s) = (vector.row(row), s.row(row));
        for (i, out) in variation.row_mut(row).iter_mut().enumerate() {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(count - 1));
            *out = (k[b].length() - k[a].length()) / (s[b] - s[a]);
        }
    }
    Curvature { vector, s, variation }
}
