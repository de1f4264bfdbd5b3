//! The faces that a face of the base is cut into, if its sides are cut in other ways than its inside.
//!
//! ```text
//!      c                    The inner points are those of a grid. The strip along each side is a zip
//!     ╱│╲                   between them and the points of the side: here a side cut into two below,
//!    ╱ i ╲      i  inside   and sides that are not cut.
//!   ╱ ╱ ╲ ╲     o  on a side
//!  ╱ i───i ╲
//! a─────o───b
//! ```

use alloc::vec::Vec;

use crate::tessellate::grid::Grid;

/// How finely the inside of a face is cut.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Cut {
    /// Level of the grid.
    pub(super) level: u32,
    /// Whether there are no inner points: the face itself, or a triangle with halved sides.
    is_hollow: bool,
}

impl Cut {
    /// The ways to cut a face whose sides have certain levels, the coarsest first.
    pub(super) fn all(grid: &Grid, sides: &[u32]) -> Vec<Self> {
        let finest = sides.iter().copied().fold(0, u32::max);
        let first_full = if grid.corners == 3 { 2 } else { 1 };
        let mut all = Vec::new();
        if finest < first_full {
            all.push(Self { level: finest, is_hollow: true });
        }
        all.extend(
            (first_full.max(finest)..=grid.levels).map(|level| Self { level, is_hollow: false }),
        );
        all
    }

    /// The inner points, row by row.
    pub(super) fn inner(self, corners: usize) -> impl Iterator<Item = [usize; 2]> + use<> {
        let n = if self.is_hollow { 0 } else { 1_usize << self.level };
        (1..n).flat_map(move |v| {
            let end = if corners == 3 { n.saturating_sub(v) } else { n };
            (1..end).map(move |u| [u, v])
        })
    }

    pub(super) fn inner_count(self, corners: usize) -> usize {
        match (self.is_hollow, 1_usize << self.level) {
            (true, _) => 0,
            (false, n) if corners == 3 => (n - 1) * n.saturating_sub(2) / 2,
            (false, n) => (n - 1) * (n - 1),
        }
    }
}

/// Shows the faces, as points of the finest grid.
pub(super) fn weave(grid: &Grid, cut: Cut, sides: &[u32], put: &mut impl FnMut(&[[usize; 2]])) {
    let outline = sides.iter().enumerate().map(|(i, &level)| {
        let step = grid.segments() >> level;
        (0..=grid.segments()).step_by(step).map(|t| grid.on_side(i, t)).collect()
    });
    let weaver = Weaver { grid, cut, outline: outline.collect() };
    if cut.is_hollow {
        return weaver.halve(put);
    }
    weaver.weave_inside(put);
    (0..grid.corners).for_each(|i| weaver.zip(i, put));
}

struct Weaver<'a> {
    grid: &'a Grid,
    cut: Cut,
    /// The points along each side, corners included.
    outline: Vec<Vec<[usize; 2]>>,
}

impl Weaver<'_> {
    /// Segments of the grid inside.
    fn segments(&self) -> usize {
        1 << self.cut.level
    }

    /// A point of the grid inside, in points of the finest.
    fn at(&self, [u, v]: [usize; 2]) -> [usize; 2] {
        let step = self.grid.segments() / self.segments();
        [step * u, step * v]
    }

    /// A face of which no more than sides are halved, if it is a triangle.
    fn halve(&self, put: &mut impl FnMut(&[[usize; 2]])) {
        let corner = |i: usize| self.outline[i % self.outline.len()][0];
        let middle = |i: usize| {
            let side = &self.outline[i % self.outline.len()];
            (side.len() == 3).then(|| side[1])
        };
        if let (Some(m0), Some(m1), Some(m2)) = (middle(0), middle(1), middle(2)) {
            put(&[corner(0), m0, m2]);
            put(&[corner(1), m1, m0]);
            put(&[corner(2), m2, m1]);
            return put(&[m0, m1, m2]);
        }
        // The side that no other halved side comes before.
        let is_first = |&i: &usize| middle(i).is_some() && middle(i + 2).is_none();
        let Some(first) = (0..3).find(is_first) else {
            let corners: Vec<_> = (0..self.outline.len()).map(corner).collect();
            return put(&corners);
        };
        let [a, b, c] = [0, 1, 2].map(|k| corner(first + k));
        match (middle(first), middle(first + 1)) {
            (Some(m), Some(next)) => {
                put(&[m, b, next]);
                put(&[a, m, next]);
                put(&[a, next, c]);
            }
            (Some(m), None) => {
                put(&[a, m, c]);
                put(&[m, b, c]);
            }
            (None, _) => {}
        }
    }

    /// The faces that touch no side.
    fn weave_inside(&self, put: &mut impl FnMut(&[[usize; 2]])) {
        let n = self.segments();
        for [u, v] in self.cut.inner(self.grid.corners) {
            let at = |i: usize, j: usize| self.at([u + i, v + j]);
            if self.grid.corners == 4 {
                if u + 1 < n && v + 1 < n {
                    put(&[at(0, 0), at(1, 0), at(1, 1), at(0, 1)]);
                }
                continue;
            }
            if u + v + 1 < n {
                put(&[at(0, 0), at(1, 0), at(0, 1)]);
            }
            if u + v + 2 < n {
                put(&[at(1, 0), at(1, 1), at(0, 1)]);
            }
        }
    }

    /// The strip between a side and the inner points along it: whichever lags behind goes on.
    fn zip(&self, i: usize, put: &mut impl FnMut(&[[usize; 2]])) {
        let outer = &self.outline[i];
        let row = self.row(i);
        let place = |o: usize| (o * self.segments()) as f64 / (outer.len() - 1) as f64;
        // Inner points of triangles lie between those of the side.
        let first = if self.grid.corners == 3 { 1.5 } else { 1.0 };
        let middle_outer = |o: usize| f64::midpoint(place(o), place(o + 1));
        let middle_row = |r: usize| r as f64 + first + 0.5;
        let (mut o, mut r) = (0, 0);
        while o + 1 < outer.len() || r + 1 < row.len() {
            let is_row_done = r + 1 == row.len();
            let lags = |o: usize, r: usize| middle_outer(o) <= middle_row(r);
            if is_row_done || (o + 1 < outer.len() && lags(o, r)) {
                put(&[outer[o], outer[o + 1], row[r]]);
                o += 1;
            } else {
                put(&[outer[o], row[r + 1], row[r]]);
                r += 1;
            }
        }
    }

    /// The inner points along a side, in its direction.
    fn row(&self, i: usize) -> Vec<[usize; 2]> {
        let n = self.segments();
        let point = |t: usize| match (self.grid.corners, i) {
            (_, 0) => [t, 1],
            (3, 1) => [n - 1 - t, t],
            (3, _) => [1, n - 1 - t],
            (_, 1) => [n - 1, t],
            (_, 2) => [n - t, n - 1],
            _ => [1, n - t],
        };
        let end = if self.grid.corners == 3 { n - 1 } else { n };
        (1..end).map(|t| self.at(point(t))).collect()
    }
}
