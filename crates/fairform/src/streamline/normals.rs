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
        let tangent = |row: usize, i: usize| -> Vec3 {
            let tangents = self.tangents().row(row);
            match self.model().integration {
                Integration::Arcs => tangents[i],
                Integration::Midpoint => {
                    let last = tangents.len() - 1;
                    let (before, after) = (tangents[i.saturating_sub(1)], tangents[i.min(last)]);
                    (before + after).normalized()
                }
            }
        };
        let of_row = |row: usize| -> Vec<Vec3> {
            let weights = slope_weights(t, row);
            let across = |i: usize| -> Vec3 {
                weights.iter().map(|&(k, w)| w * (points[(k, i)] - points[(row, i)])).sum()
            };
            (0..columns).map(|i| tangent(row, i).cross(across(i)).normalized()).collect()
        };
        let mut normals = Grid::filled(rows, columns, Vec3::ZERO);
        for row in 0..rows {
            normals.row_mut(row).copy_from_slice(&of_row(row));
        }
        normals
    }
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
