//! Changes of the structure of a model: streamlines and tangents more or less, and its mirror image.

use alloc::vec::Vec;

use crate::Vec3;
use crate::sphere::midpoint;

use super::{Error, Grid, InitialCurve, Model};

impl Model {
    /// Inserts a streamline between two others, of which it has the blended tangents, and the middles of
    /// their parameters. Details at finer levels, whose places it would move, are left out.
    ///
    /// # Errors
    /// [`Error::NoSuchPlace`] unless there are rows on both sides. Nothing is changed then.
    pub fn insert_row(&mut self, row: usize) -> Result<(), Error> {
        let rows = self.tangents.row_count();
        if row == 0 || row >= rows {
            return Err(Error::NoSuchPlace { level: 0, row, column: 0 });
        }
        let between = |k: usize| row_between(&self.tangents, k, midpoint);
        let numbers = |k: usize| row_between(&self.s, k, f64::midpoint);
        let (tangents, s) = (between(row), numbers(row));
        self.tangents = with_row(&self.tangents, row, tangents);
        self.s = with_row(&self.s, row, s);
        self.t.insert(row, f64::midpoint(self.t[row - 1], self.t[row]));
        self.details.clear();
        Ok(())
    }

    /// Inserts a tangent on every streamline between two others, blended, at the middle of their
    /// parameters. Details at finer levels, whose places it would move, are left out.
    ///
    /// # Errors
    /// [`Error::NoSuchPlace`] unless there are columns on both sides. Nothing is changed then.
    pub fn insert_column(&mut self, column: usize) -> Result<(), Error> {
        if column == 0 || column >= self.tangents.column_count() {
            return Err(Error::NoSuchPlace { level: 0, row: 0, column });
        }
        let (tangents, s) = (self.tangents.transposed(), self.s.transposed());
        let between = row_between(&tangents, column, midpoint);
        let numbers = row_between(&s, column, f64::midpoint);
        self.tangents = with_row(&tangents, column, between).transposed();
        self.s = with_row(&s, column, numbers).transposed();
        self.details.clear();
        Ok(())
    }

    /// Takes a streamline away. Details at finer levels are left out.
    ///
    /// # Errors
    /// [`Error::NoSuchPlace`]; [`Error::Empty`] if it is the last. Nothing is changed then.
    pub fn delete_row(&mut self, row: usize) -> Result<(), Error> {
        match self.tangents.row_count() {
            rows if row >= rows => return Err(Error::NoSuchPlace { level: 0, row, column: 0 }),
            1 => return Err(Error::Empty),
            _ => {}
        }
        self.tangents = without_row(&self.tangents, row);
        self.s = without_row(&self.s, row);
        self.t.remove(row);
        self.details.clear();
        Ok(())
    }

    /// Takes a tangent away from every streamline. If it is the first or last, streamlines become
    /// shorter. Details at finer levels are left out.
    ///
    /// # Errors
    /// [`Error::NoSuchPlace`]; [`Error::Empty`] if it is the last. Nothing is changed then.
    pub fn delete_column(&mut self, column: usize) -> Result<(), Error> {
        match self.tangents.column_count() {
            columns if column >= columns => {
                return Err(Error::NoSuchPlace { level: 0, row: 0, column });
            }
            1 => return Err(Error::Empty),
            _ => {}
        }
        self.tangents = without_row(&self.tangents.transposed(), column).transposed();
        self.s = without_row(&self.s.transposed(), column).transposed();
        self.details.clear();
        Ok(())
    }

    /// The mirror image in the plane through the origin with this unit normal,
    /// $`v \mapsto v - 2 (v \cdot n) n`$ of all tangents and points. Its surface is that of the model,
    /// mirrored.
    pub fn mirror(&mut self, normal: Vec3) {
        let mirrored = |v: Vec3| v - 2.0 * v.dot(normal) * normal;
        let mirror = |list: &mut [Vec3]| list.iter_mut().for_each(|v| *v = mirrored(*v));
        mirror(self.tangents.values_mut());
        for detail in &mut self.details {
            detail.predicted = mirrored(detail.predicted);
            detail.tangent = mirrored(detail.tangent);
        }
        match &mut self.initial {
            InitialCurve::Polyline { points, .. } | InitialCurve::Bspline { points, .. } => {
                mirror(points);
            }
            InitialCurve::Qi { tangents, start, .. } => {
                mirror(tangents);
                *start = mirrored(*start);
            }
        }
    }
}

/// The values between a row and the one before.
fn row_between<T: Copy>(grid: &Grid<T>, row: usize, middle: impl Fn(T, T) -> T) -> Vec<T> {
    grid.row(row - 1).iter().zip(grid.row(row)).map(|(&a, &b)| middle(a, b)).collect()
}

fn with_row<T: Clone>(grid: &Grid<T>, row: usize, new: Vec<T>) -> Grid<T> {
    let mut rows: Vec<Vec<T>> = grid.rows().map(<[T]>::to_vec).collect();
    rows.insert(row, new);
    Grid::collected(rows)
}

fn without_row<T: Clone>(grid: &Grid<T>, row: usize) -> Grid<T> {
    let rows = grid.rows().enumerate().filter(|(k, _)| *k != row);
    Grid::collected(rows.map(|(_, row)| row.to_vec()).collect::<Vec<_>>())
}
