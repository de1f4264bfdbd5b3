//! The only module that knows threads.
//!
//! Everything here is parallel over *outputs*, in blocks whose size never depends on the number of
//! threads; partial sums come back block by block, in order. So the results are the same bits with
//! one thread, with many, and with the feature `parallel` off.

use alloc::vec::Vec;
use core::ops::Range;

/// Outputs per block. Fixed, since sums are taken per block.
pub(crate) const BLOCK: usize = 4096;

/// Sets every `out[i]` to `f(i)`.
pub(crate) fn fill<T: Send>(out: &mut [T], f: impl Fn(usize) -> T + Sync) {
    for_blocks(out, |start, block| {
        for (i, slot) in block.iter_mut().enumerate() {
            *slot = f(start + i);
        }
    });
}

/// A vector of `f(0), f(1), …`.
pub(crate) fn collect<T: Send + Clone + Default>(
    len: usize,
    f: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    let mut out = alloc::vec![T::default(); len];
    fill(&mut out, f);
    out
}

/// Runs `f(start, block)` on each block of `out` and returns the answers in order.
pub(crate) fn for_blocks<T: Send, R: Send>(
    out: &mut [T],
    f: impl Fn(usize, &mut [T]) -> R + Sync,
) -> Vec<R> {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        out.par_chunks_mut(BLOCK).enumerate().map(|(b, block)| f(b * BLOCK, block)).collect()
    }
    #[cfg(not(feature = "parallel"))]
    {
        out.chunks_mut(BLOCK).enumerate().map(|(b, block)| f(b * BLOCK, block)).collect()
    }
}

/// [`for_blocks`] over two slices of one length at once.
pub(crate) fn for_blocks2<T: Send, U: Send, R: Send>(
    a: &mut [T],
    b: &mut [U],
    f: impl Fn(usize, &mut [T], &mut [U]) -> R + Sync,
) -> Vec<R> {
    assert_eq!(a.len(), b.len(), "slices of one length");
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        a.par_chunks_mut(BLOCK)
            .zip(b.par_chunks_mut(BLOCK))
            .enumerate()
            .map(|(i, (a, b))| f(i * BLOCK, a, b))
            .collect()
    }
    #[cfg(not(feature = "parallel"))]
    {
        a.chunks_mut(BLOCK)
            .zip(b.chunks_mut(BLOCK))
            .enumerate()
            .map(|(i, (a, b))| f(i * BLOCK, a, b))
            .collect()
    }
}

/// Runs `f` on each block of `0..len` and returns the answers in order.
pub(crate) fn blocks<R: Send>(len: usize, f: impl Fn(Range<usize>) -> R + Sync) -> Vec<R> {
    let range = |b: usize| b * BLOCK..((b + 1) * BLOCK).min(len);
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        (0..len.div_ceil(BLOCK)).into_par_iter().map(|b| f(range(b))).collect()
    }
    #[cfg(not(feature = "parallel"))]
    {
        (0..len.div_ceil(BLOCK)).map(|b| f(range(b))).collect()
    }
}

/// Where each of some rows begins that lie one behind the other, and the end; an error with the end if that
/// is 2³² or more.
pub(crate) fn starts(len: usize, count: impl Fn(usize) -> u32 + Sync) -> Result<Vec<u32>, u64> {
    let mut end = 0_u64;
    let firsts: Vec<u64> = blocks(len, |rows| rows.map(|i| u64::from(count(i))).sum::<u64>())
        .into_iter()
        .map(|sum| {
            end += sum;
            end - sum
        })
        .collect();
    let mut starts = alloc::vec![0; len + 1];
    starts[len] = u32::try_from(end).map_err(|_| end)?;
    for_blocks(&mut starts[..len], |first, block| {
        let mut next = firsts[first / BLOCK] as u32;
        for (i, slot) in block.iter_mut().enumerate() {
            *slot = next;
            next += count(first + i);
        }
    });
    Ok(starts)
}

/// Cuts a slice into parts of such lengths, one behind the other.
pub(crate) fn cut<T>(mut all: &mut [T], lengths: impl Iterator<Item = usize>) -> Vec<&mut [T]> {
    let mut parts = Vec::new();
    for length in lengths {
        let part;
        (part, all) = all.split_at_mut(length);
        parts.push(part);
    }
    parts
}

/// How many parts [`in_parts`] is worth cutting into; the results do not depend on it.
pub(crate) fn part_count() -> usize {
    #[cfg(feature = "parallel")]
    {
        rayon::current_num_threads().min(8)
    }
    #[cfg(not(feature = "parallel"))]
    {
        1
    }
}

/// Runs `f(part)` on each of a few parts at once, each owning what it writes.
pub(crate) fn in_parts<P: Send>(parts: Vec<P>, f: impl Fn(P) + Sync + Send) {
    map_parts(parts, f);
}

/// [`in_parts`], with the answers in order.
pub(crate) fn map_parts<P: Send, R: Send>(
    parts: Vec<P>,
    f: impl Fn(P) -> R + Sync + Send,
) -> Vec<R> {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        parts.into_par_iter().with_max_len(1).map(f).collect()
    }
    #[cfg(not(feature = "parallel"))]
    {
        parts.into_iter().map(f).collect()
    }
}

/// Fills rows of varying length that lie one behind the other: `f(i, row_i_of_a, row_i_of_b)`, where
/// row `i` is `start[i]..start[i + 1]`.
pub(crate) fn fill_rows<T: Send, U: Send>(
    start: &[u32],
    a: &mut [T],
    b: &mut [U],
    f: &(impl Fn(usize, &mut [T], &mut [U]) + Sync),
) {
    fill_row_blocks(start, a, b, &|rows: Range<usize>, mut a: &mut [T], mut b: &mut [U]| {
        for row in rows {
            let len = (start[row + 1] - start[row]) as usize;
            let (row_a, rest_a) = a.split_at_mut(len);
            let (row_b, rest_b) = b.split_at_mut(len);
            f(row, row_a, row_b);
            (a, b) = (rest_a, rest_b);
        }
    });
}

/// As [`fill_rows`], for many rows at once: `f(rows, rows_of_a, rows_of_b)`.
pub(crate) fn fill_row_blocks<T: Send, U: Send>(
    start: &[u32],
    a: &mut [T],
    b: &mut [U],
    f: &(impl Fn(Range<usize>, &mut [T], &mut [U]) + Sync),
) {
    fill_row_blocks_from(0, start, a, b, f);
}

fn fill_row_blocks_from<T: Send, U: Send>(
    first: usize,
    start: &[u32],
    a: &mut [T],
    b: &mut [U],
    f: &(impl Fn(Range<usize>, &mut [T], &mut [U]) + Sync),
) {
    let rows = start.len() - 1;
    if rows <= BLOCK {
        f(first..first + rows, a, b);
        return;
    }
    let middle = rows / 2;
    let cut = (start[middle] - start[0]) as usize;
    let (a0, a1) = a.split_at_mut(cut);
    let (b0, b1) = b.split_at_mut(cut);
    let lower = || fill_row_blocks_from(first, &start[..=middle], a0, b0, f);
    let upper = || fill_row_blocks_from(first + middle, &start[middle..], a1, b1, f);
    join(lower, upper);
}

/// Runs two closures, at once if there are threads.
pub(crate) fn join<A: Send, B: Send>(
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    #[cfg(feature = "parallel")]
    {
        rayon::join(a, b)
    }
    #[cfg(not(feature = "parallel"))]
    {
        (a(), b())
    }
}
