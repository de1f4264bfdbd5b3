//! Normals of a streamline surface, from its tangents.

use alloc::vec::Vec;

use crate::Vec3;

use super::{Grid, Integration, Surface};

impl Surface {
    /// Unit normals at the points,
    ///
    /// ```math
    /// n = \frac{T \times \partial S / \partial t}{|T \times \partial S / \partial t|},
    /// ```
    ///
    /// with the tangents exact and the derivative across streamlines from a parabola through three
    /// neighbours: second order in the distance of the streamlines. Zero where the streamlines meet or
    /// are alone.
    #[must_use]
    pub fn normals(&self) -> Grid<Vec3> {
        let (points, t) = (self.points(), self.t());
        let (rows, columns) = (points.row_count(), points.column_count());
        let tangents = self.point_tangents();
        let of_row = |row: usize| -> Vec<Vec3> {
            let weights = slope_weights(t, row);
            let across = |i: usize| -> Vec3 {
                weights.iter().map(|&(k, w)| w * (points[(k, i)] - points[(row, i)])).sum()
            };
            (0..columns).map(|i| tangents[(row, i)].cross(across(i)).normalized()).collect()
        };
        let mut normals = Grid::filled(rows, columns, Vec3::ZERO);
        for row in 0..rows {
            normals.row_mut(row).copy_from_slice(&of_row(row));
        }
        normals
    }

    /// The unit tangent of the streamline at each point: as refined, or between two refined ones.
    #[must_use]
    pub fn point_tangents(&self) -> Grid<Vec3> {
        if self.model().integration == Integration::Arcs {
            return self.tangents().clone();
        }
        let of_row = |tangents: &[Vec3]| -> Vec<Vec3> {
            let last = tangents.len() - 1;
            let between = |i: usize| {
                let (before, after) = (tangents[i.saturating_sub(1)], tangents[i.min(last)]);
                (before + after).normalized()
            };
            (0..=tangents.len()).map(between).collect()
        };
        Grid::collected(self.tangents().rows().map(of_row))
    }

    /// Where the control tangents stand on the surface: the points at their parameters, linearly between
    /// the refined ones. Where refinement draws the ends in, those beyond stand at the ends.
    #[must_use]
    pub fn feet(&self) -> Grid<Vec3> {
        let (model, points) = (self.model(), self.points());
        let parameters = self.parameters();
        // Refined streamlines may be stretched to another length than that of the parameters.
        let stretched = |row: usize, share: f64| {
            let s = parameters.row(row);
            let (first, last) = (s[0][0], s[s.len() - 1][0]);
            first + share * (last - first)
        };
        let on_row = |row: usize, share: f64| {
            let at = stretched(row, share);
            let (i, u) = place(parameters.row(row).iter().map(|p| p[0]), at);
            let line = points.row(row);
            if u == 0.0 { line[i] } else { line[i] + u * (line[i + 1] - line[i]) }
        };
        let feet = (0..model.t.len()).map(|k| {
            let s = model.s.row(k);
            let (first, last) = (s[0], s[s.len() - 1]);
            let (row, v) = place(self.t().iter().copied(), model.t[k]);
            s.iter()
                .map(|&s| {
                    let share = if last > first { (s - first) / (last - first) } else { 0.0 };
                    let p = on_row(row, share);
                    if v == 0.0 { p } else { p + v * (on_row(row + 1, share) - p) }
                })
                .collect::<Vec<_>>()
        });
        Grid::collected(feet.collect::<Vec<_>>())
    }
}

/// The interval of increasing numbers in which one lies, and where in it; at an end if it is beyond.
fn place(numbers: impl ExactSizeIterator<Item = f64>, at: f64) -> (usize, f64) {
    let last = numbers.len() - 1;
    let mut before = None;
    for (i, x) in numbers.enumerate() {
        if at <= x {
            return match before {
                Some(y) if at < x => (i - 1, (at - y) / (x - y)),
                _ => (i, 0.0),
            };
        }
        before = Some(x);
    }
    (last, 0.0)
}

/// Weights of the differences to the value at `row` that give the slope there of the parabola through
/// three neighbours, or of the line through two.
fn slope_weights(t: &[f64], row: usize) -> Vec<(usize, f64)> {
    let last = t.len() - 1;
    let [a, b] = match (row, last) {
        (_, 0) => return Vec::new(),
        (_, 1) => [1 - row, 1 - row],
        (0, _) => [1, 2],
        _ if row == last => [last - 1, last - 2],
        _ => [row - 1, row + 1],
    };
    let (x, y) = (t[a] - t[row], t[b] - t[row]);
    if a == b {
        return alloc::vec![(a, 1.0 / x)];
    }
    alloc::vec![(a, -y / (x * (x - y))), (b, x / (y * (x - y)))]
}
