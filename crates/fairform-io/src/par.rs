//! The only module of this crate that knows threads.
//!
//! What is read is cut into parts whose answers come back in order, what is written into blocks
//! that leave in order; nothing that comes out depends on how many threads there are.

use std::io::{self, Write};
use std::ops::Range;

use bytemuck::Zeroable;

/// Numbers per block of [`collect`].
const BLOCK: usize = 1 << 15;

/// How many threads there are to share the work.
pub(crate) fn threads() -> usize {
    #[cfg(feature = "parallel")]
    {
        rayon::current_num_threads()
    }
    #[cfg(not(feature = "parallel"))]
    {
        1
    }
}

/// How many parts to cut a text of so many bytes into: one if it is short or there is one thread.
pub(crate) fn part_count(bytes: usize) -> usize {
    const LEAST: usize = 1 << 18;
    match threads() {
        1 => 1,
        threads => (4 * threads).min(bytes / LEAST).max(1),
    }
}

/// The answers to all parts, in order.
pub(crate) fn map<P: Send, R: Send>(
    parts: impl IntoIterator<Item = P>,
    f: impl Fn(P) -> R + Sync + Send,
) -> Vec<R> {
    #[cfg(feature = "parallel")]
    {
        use rayon::prelude::*;
        let parts: Vec<P> = parts.into_iter().collect();
        if parts.len() > 1 && threads() > 1 {
            return parts.into_par_iter().with_max_len(1).map(f).collect();
        }
        parts.into_iter().map(f).collect()
    }
    #[cfg(not(feature = "parallel"))]
    {
        parts.into_iter().map(f).collect()
    }
}

/// `0..len` in blocks of one size, but for the last.
pub(crate) fn blocks(len: usize, block: usize) -> impl ExactSizeIterator<Item = Range<usize>> {
    (0..len.div_ceil(block)).map(move |i| i * block..((i + 1) * block).min(len))
}

/// A vector of `f(0), f(1), …`.
pub(crate) fn collect<T: Zeroable + Send>(len: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    if len <= BLOCK || threads() == 1 {
        return (0..len).map(f).collect();
    }
    // Zeros from the system: its pages are found by the thread that fills them.
    let mut out: Vec<T> = bytemuck::zeroed_vec(len);
    map(out.chunks_mut(BLOCK).enumerate(), |(block, out)| {
        for (i, slot) in out.iter_mut().enumerate() {
            *slot = f(block * BLOCK + i);
        }
    });
    out
}

/// All parts one behind the other.
pub(crate) fn concat<T: Zeroable + Copy + Send + Sync>(parts: &[&[T]]) -> Vec<T> {
    let mut out: Vec<T> = bytemuck::zeroed_vec(parts.iter().map(|part| part.len()).sum());
    let mut rest = out.as_mut_slice();
    let tasks = parts.iter().map(|part| {
        let (own, others) = std::mem::take(&mut rest).split_at_mut(part.len());
        rest = others;
        (own, part)
    });
    map(tasks, |(own, part)| own.copy_from_slice(part));
    out
}

/// All parts one behind the other; a part that is alone is not copied.
pub(crate) fn join<T: Zeroable + Copy + Send + Sync>(mut parts: Vec<Vec<T>>) -> Vec<T> {
    match parts.len() {
        1 => parts.swap_remove(0),
        _ => concat(&parts.iter().map(Vec::as_slice).collect::<Vec<_>>()),
    }
}

/// The largest number.
pub(crate) fn max(numbers: &[u32]) -> Option<u32> {
    map(numbers.chunks(BLOCK), |block| block.iter().copied().max()).into_iter().flatten().max()
}

/// Writes `len` rows: `format` appends those of a range to a buffer. Blocks of `block` rows are
/// formatted at once, while those before them are written; a few are in memory at a time.
pub(crate) fn write_rows(
    out: &mut dyn Write,
    len: usize,
    block: usize,
    format: impl Fn(Range<usize>, &mut Vec<u8>) + Sync,
) -> io::Result<()> {
    #[cfg(feature = "parallel")]
    if threads() > 1 && len > block {
        return write_rows_at_once(out, blocks(len, block), &format);
    }
    let mut buffer = Vec::new();
    for rows in blocks(len, block) {
        buffer.clear();
        format(rows, &mut buffer);
        out.write_all(&buffer)?;
    }
    Ok(())
}

#[cfg(feature = "parallel")]
fn write_rows_at_once(
    out: &mut dyn Write,
    mut blocks: impl ExactSizeIterator<Item = Range<usize>>,
    format: &(impl Fn(Range<usize>, &mut Vec<u8>) + Sync),
) -> io::Result<()> {
    let width = (2 * threads()).min(blocks.len());
    let mut ready: Vec<Vec<u8>> = Vec::new();
    let mut next: Vec<Vec<u8>> = vec![Vec::new(); width];
    loop {
        let mut used = 0;
        let written = rayon::in_place_scope(|scope| {
            for (buffer, rows) in next.iter_mut().zip(&mut blocks) {
                used += 1;
                scope.spawn(move |_| {
                    buffer.clear();
                    format(rows, buffer);
                });
            }
            ready.iter().try_for_each(|buffer| out.write_all(buffer))
        });
        written?;
        if used == 0 {
            return Ok(());
        }
        std::mem::swap(&mut ready, &mut next);
        next.resize(width, Vec::new());
        // Those before are written; what the last round did not use must not be written again.
        ready.truncate(used);
    }
}
