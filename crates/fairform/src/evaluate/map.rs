//! [`Map`]: from the parameters of a patch to those of a part of it.

/// An affine map of the parameter plane; all numbers are small integers or powers of two, so that
/// compositions are exact.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Map {
    /// The image of the origin.
    origin: [f64; 2],
    /// New parameter `i` grows by `axes[i][j]` with old parameter `j`.
    axes: [[f64; 2]; 2],
}

const fn map(u: [i8; 3], v: [i8; 3]) -> Map {
    Map {
        origin: [u[0] as f64, v[0] as f64],
        axes: [[u[1] as f64, u[2] as f64], [v[1] as f64, v[2] as f64]],
    }
}

/// To the parts of a triangle: those at its corners, each beginning with the corner, then the inner
/// one, which begins on the side from the first corner to the second.
pub(super) const TRIANGLE: [Map; 4] = [
    map([0, 2, 0], [0, 0, 2]),
    map([0, 0, 2], [2, -2, -2]),
    map([2, -2, -2], [0, 2, 0]),
    map([-1, 2, 2], [1, -2, 0]),
];

/// To the parts of a quadrilateral at its corners, each beginning with the corner.
pub(super) const QUADRILATERAL: [Map; 4] = [
    map([0, 2, 0], [0, 0, 2]),
    map([0, 0, 2], [2, -2, 0]),
    map([2, -2, 0], [2, 0, -2]),
    map([2, 0, -2], [0, 2, 0]),
];

/// To the parts of a cell of four faces, each beginning at the centre of the cell, counter-clockwise
/// from the part farthest from the origin.
pub(super) const CELL: [Map; 4] = [
    map([-1, 2, 0], [-1, 0, 2]),
    map([-1, 0, 2], [1, -2, 0]),
    map([1, -2, 0], [1, 0, -2]),
    map([1, 0, -2], [-1, 2, 0]),
];

/// The same for a cell with the boundary at `v = 0`, which the two parts on it begin with.
pub(super) const BORDER_CELL: [Map; 4] =
    [CELL[0], CELL[1], map([0, 2, 0], [0, 0, 2]), map([-1, 2, 0], [0, 0, 2])];

/// From a strip along the first side, `v < 0`, to its cell.
pub(super) const FIRST_STRIP: Map = map([0, 1, 0], [1, 0, 1]);

/// From a strip along the last side, `u < 0`, to its cell.
pub(super) const LAST_STRIP: Map = map([1, 0, -1], [1, 1, 0]);

impl Map {
    pub(super) const IDENTITY: Self = map([0, 1, 0], [0, 0, 1]);

    pub(super) fn apply(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| self.origin[i] + self.axes[i][0] * u + self.axes[i][1] * v)
    }

    /// How the new parameters grow with the old ones.
    pub(super) fn jacobian(&self) -> [[f64; 2]; 2] {
        self.axes
    }

    /// The derivatives of this after a map with derivatives `before`.
    pub(super) fn jacobian_after(&self, before: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
        self.axes.map(|row| [0, 1].map(|j| row[0] * before[0][j] + row[1] * before[1][j]))
    }
}

/// Which part of a triangle has a point.
pub(super) fn part_of_triangle([u, v]: [f64; 2]) -> usize {
    match () {
        () if u + v <= 0.5 => 0,
        () if u >= 0.5 => 1,
        () if v >= 0.5 => 2,
        () => 3,
    }
}

/// Which quarter of the unit square has a point, as in [`QUADRILATERAL`].
pub(super) fn part_of_square([u, v]: [f64; 2]) -> usize {
    match (u > 0.5, v > 0.5) {
        (false, false) => 0,
        (true, false) => 1,
        (true, true) => 2,
        (false, true) => 3,
    }
}

/// Which quarter of the unit square has a point, as in [`CELL`].
pub(super) fn part_of_cell(at: [f64; 2]) -> usize {
    [2, 3, 0, 1][part_of_square(at)]
}
