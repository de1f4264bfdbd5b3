//! Rows of values of one length.

use alloc::vec::Vec;
use core::ops::{Index, IndexMut, Range};

/// A rectangular grid, row by row.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Grid<T> {
    column_count: usize,
    values: Vec<T>,
}

impl<T> Grid<T> {
    /// The grid with these rows; `None` if they differ in length.
    #[must_use]
    pub fn from_rows<R: IntoIterator<Item = T>>(rows: impl IntoIterator<Item = R>) -> Option<Self> {
        let (mut column_count, mut values) = (None, Vec::new());
        for row in rows {
            let before = values.len();
            values.extend(row);
            let count = values.len() - before;
            if *column_count.get_or_insert(count) != count {
                return None;
            }
        }
        Some(Self { column_count: column_count.unwrap_or(0), values })
    }

    /// The grid with these rows, which are known to be of one length.
    pub(super) fn collected<R: IntoIterator<Item = T>>(rows: impl IntoIterator<Item = R>) -> Self {
        Self::from_rows(rows).expect("rows of one length")
    }

    /// The grid with `column_count` values in each row; `None` if the last row is not full.
    #[must_use]
    pub fn from_values(column_count: usize, values: Vec<T>) -> Option<Self> {
        let full = if column_count == 0 {
            values.is_empty()
        } else {
            values.len().is_multiple_of(column_count)
        };
        full.then_some(Self { column_count, values })
    }

    /// Number of rows.
    #[must_use]
    pub fn row_count(&self) -> usize {
        self.values.len().checked_div(self.column_count).unwrap_or(0)
    }

    /// Number of values in each row.
    #[must_use]
    pub fn column_count(&self) -> usize {
        self.column_count
    }

    /// All values, row by row.
    #[must_use]
    pub fn values(&self) -> &[T] {
        &self.values
    }

    pub(super) fn values_mut(&mut self) -> &mut [T] {
        &mut self.values
    }

    /// A row.
    ///
    /// # Panics
    /// If there is no such row.
    #[must_use]
    pub fn row(&self, row: usize) -> &[T] {
        &self.values[row * self.column_count..(row + 1) * self.column_count]
    }

    /// A row, to be changed.
    ///
    /// # Panics
    /// If there is no such row.
    #[must_use]
    pub fn row_mut(&mut self, row: usize) -> &mut [T] {
        &mut self.values[row * self.column_count..(row + 1) * self.column_count]
    }

    /// All rows.
    #[must_use]
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[T]> + '_ {
        (0..self.row_count()).map(|row| self.row(row))
    }

    /// A column.
    ///
    /// # Panics
    /// If there is no such column.
    #[must_use]
    pub fn column(&self, column: usize) -> impl ExactSizeIterator<Item = &T> + '_ {
        assert!(column < self.column_count, "there is no column {column}");
        (0..self.row_count()).map(move |row| &self.values[row * self.column_count + column])
    }
}

impl<T: Clone> Grid<T> {
    /// The grid with the same value everywhere.
    #[must_use]
    pub fn filled(row_count: usize, column_count: usize, value: T) -> Self {
        Self { column_count, values: alloc::vec![value; row_count * column_count] }
    }

    /// Rows and columns exchanged.
    #[must_use]
    pub fn transposed(&self) -> Self {
        let columns = 0..self.column_count;
        let values = columns.flat_map(|c| self.column(c).cloned()).collect();
        Self { column_count: self.row_count(), values }
    }
}

impl<T> Index<(usize, usize)> for Grid<T> {
    type Output = T;
    /// # Panics
    /// If there is no such row or column.
    fn index(&self, (row, column): (usize, usize)) -> &T {
        &self.row(row)[column]
    }
}

impl<T> IndexMut<(usize, usize)> for Grid<T> {
    fn index_mut(&mut self, (row, column): (usize, usize)) -> &mut T {
        &mut self.row_mut(row)[column]
    }
}

/// A rectangle in a grid.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Rect {
    /// Its rows.
    pub rows: Range<usize>,
    /// Its columns.
    pub columns: Range<usize>,
}

impl Rect {
    /// Whether nothing is in it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty() || self.columns.is_empty()
    }

    /// Whether a place is in it.
    #[must_use]
    pub fn contains(&self, row: usize, column: usize) -> bool {
        self.rows.contains(&row) && self.columns.contains(&column)
    }

    /// The smallest rectangle around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        if self.is_empty() {
            return other.clone();
        }
        if other.is_empty() {
            return self.clone();
        }
        let around = |a: &Range<usize>, b: &Range<usize>| a.start.min(b.start)..a.end.max(b.end);
        Self {
            rows: around(&self.rows, &other.rows),
            columns: around(&self.columns, &other.columns),
        }
    }

    pub(super) fn single(row: usize, column: usize) -> Self {
        Self { rows: row..row + 1, columns: column..column + 1 }
    }
}
