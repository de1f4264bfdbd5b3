//! Solving by factorising the symmetrised system.

use alloc::vec::Vec;
use core::ops::ControlFlow;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

use super::{LinearOperator, Observer, Progress, Report, Stop, residuals};
use crate::error::Error;
use crate::{Vec3, par};

/// Share of a diagonal entry that rounding alone may leave of a pivot.
const ROUNDING: f64 = 1e-13;

/// An operator that tells its rows.
pub(crate) trait Entries: LinearOperator {
    /// The entries of row `i`: numbers of unknowns and known values, and weights.
    fn entries(&self, i: usize) -> impl Iterator<Item = (usize, f64)>;
}

/// Most entries of a factor: 16 GiB of them.
const MOST: usize = 1 << 31;

/// Solves `B x = target` from the start values in `x`: unknowns first, then known values, which
/// stay. `B` has to be symmetric but for its scale.
///
/// Factorises $`S = L L^T`$ in an order of approximate minimum degree, entry by entry, so that the
/// bits depend on nothing but the input; an update solves with the factor for what is left of the
/// error, so that the second one, if any, takes back the rounding of the first.
///
/// # Errors
/// [`Error::NotDefinite`], [`Error::FactorTooLarge`], [`Error::Interrupted`], [`Error::Overflow`].
///
/// # Panics
/// If there is not one target per unknown.
pub(crate) fn direct<A: Entries>(
    operator: &A,
    target: &[Vec3],
    x: &mut [Vec3],
    stop: Stop,
    observer: &mut Observer<'_>,
) -> Result<Report, Error> {
    let n = operator.unknown_count();
    assert_eq!(target.len(), n, "one target per unknown");
    let mut progress = Progress::new(stop, operator.smallest_eigenvalue_bound(), observer);
    let mut error = alloc::vec![Vec3::ZERO; n];
    let matrix = Matrix::of(operator);
    let symbolic = matrix.analyse()?;
    let mut values = alloc::vec![0.0; symbolic.len_val()];
    matrix.factorise(&symbolic, &mut values)?;
    let factor = LltRef::new(&symbolic, &values);
    let mut buffer = MemBuffer::new(factor.solve_in_place_scratch::<f64>(3, Par::Seq));
    let mut right = alloc::vec![0.0; 3 * n];
    let mut updates = 0;
    let outcome = loop {
        let residual = residuals(operator, target, x, &mut error);
        if let ControlFlow::Break(outcome) = progress.take(updates, residual)? {
            break outcome;
        }
        for (i, e) in error.iter().enumerate() {
            let scaled = *e / operator.scale(i);
            (right[i], right[n + i], right[2 * n + i]) = (scaled.x, scaled.y, scaled.z);
        }
        let columns = MatMut::from_column_major_slice_mut(&mut right, n, 3);
        let stack = MemStack::new(&mut buffer);
        factor.solve_in_place_with_conj(Conj::No, columns, Par::Seq, stack);
        par::for_blocks(&mut x[..n], |start, block| {
            for (i, x) in block.iter_mut().enumerate() {
                let i = start + i;
                *x += Vec3::new(right[i], right[n + i], right[2 * n + i]);
            }
        });
        updates += 1;
    };
    let predicted = progress.stop.tolerance.map(|_| 1);
    Ok(Report { history: progress.history, outcome, predicted })
}

/// The upper triangle of a symmetric matrix, column by column.
struct Matrix {
    start: Vec<usize>,
    row: Vec<usize>,
    value: Vec<f64>,
}

impl Matrix {
    /// $`S = D^{-1} B`$ among the unknowns.
    fn of<A: Entries>(operator: &A) -> Self {
        let n = operator.unknown_count();
        let (mut start, mut row, mut value) = (alloc::vec![0], Vec::new(), Vec::new());
        let mut column: Vec<(usize, f64)> = Vec::new();
        for i in 0..n {
            column.clear();
            column.extend(operator.entries(i).filter(|e| e.0 <= i));
            column.sort_by_key(|e| e.0);
            for same in column.chunk_by(|a, b| a.0 == b.0) {
                row.push(same[0].0);
                value.push(same.iter().map(|e| e.1).sum::<f64>() / operator.scale(i));
            }
            start.push(row.len());
        }
        Self { start, row, value }
    }

    fn pattern(&self) -> SymbolicSparseColMatRef<'_, usize> {
        let n = self.start.len() - 1;
        SymbolicSparseColMatRef::new_checked(n, n, &self.start, None, &self.row)
    }

    fn analyse(&self) -> Result<SymbolicCholesky<usize>, Error> {
        // Blocks of columns would be faster, but their bits depend on the processor.
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SIMPLICIAL,
            ..CholeskySymbolicParams::default()
        };
        let order = SymmetricOrdering::Amd;
        match factorize_symbolic_cholesky(self.pattern(), Side::Upper, order, parameters) {
            Ok(symbolic) if symbolic.len_val() <= MOST => Ok(symbolic),
            _ => Err(Error::FactorTooLarge),
        }
    }

    fn factorise(
        &self,
        symbolic: &SymbolicCholesky<usize>,
        values: &mut [f64],
    ) -> Result<(), Error> {
        let scratch =
            symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, faer::Spec::default());
        let mut buffer = MemBuffer::new(scratch);
        let matrix = SparseColMatRef::new(self.pattern(), &self.value);
        let factor = symbolic.factorize_numeric_llt(
            values,
            matrix,
            Side::Upper,
            faer::linalg::cholesky::llt::factor::LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut buffer),
            faer::Spec::default(),
        );
        if factor.is_err() || self.has_lost_pivot(symbolic, values) {
            return Err(Error::NotDefinite);
        }
        Ok(())
    }

    /// Whether a pivot is nothing but rounding.
    fn has_lost_pivot(&self, symbolic: &SymbolicCholesky<usize>, values: &[f64]) -> bool {
        let SymbolicCholeskyRaw::Simplicial(columns) = symbolic.raw() else { return false };
        let Some(order) = symbolic.perm() else { return false };
        columns.col_ptr().iter().zip(order.arrays().0).any(|(&first, &i)| {
            // The diagonal is the last of its column here, and the first one there.
            let before = self.value[self.start[i + 1] - 1];
            values[first] * values[first] <= ROUNDING * before
        })
    }
}
