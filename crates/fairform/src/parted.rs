//! Sorting large arrays into parts that fit into a cache, in streams.

use alloc::vec::Vec;
use core::ops::Range;

use crate::par;

/// Items in the order of their parts, and where each part begins.
pub(crate) struct Parted<T> {
    /// All items, part by part.
    pub(crate) items: Vec<T>,
    start: Vec<usize>,
}

impl<T: Copy + Default + Send + Sync> Parted<T> {
    /// Puts the items `(part, item)` of each block into their parts, in the order of the blocks.
    pub(crate) fn new<I: Iterator<Item = (u32, T)>>(
        blocks: &[Range<usize>],
        part_count: usize,
        items: impl Fn(Range<usize>) -> I + Sync + Send,
    ) -> Self {
        let counts = par::map_parts(blocks.to_vec(), |block| {
            let mut count = alloc::vec![0_u32; part_count];
            items(block).for_each(|(part, _)| count[part as usize] += 1);
            count
        });
        let mut start = Vec::with_capacity(part_count + 1);
        let mut end = 0;
        for part in 0..part_count {
            start.push(end);
            end += counts.iter().map(|count| count[part] as usize).sum::<usize>();
        }
        start.push(end);
        let mut all = alloc::vec![T::default(); end];
        let mut places: Vec<Vec<&mut [T]>> =
            counts.iter().map(|_| Vec::with_capacity(part_count)).collect();
        let mut rest = all.as_mut_slice();
        for part in 0..part_count {
            for (count, places) in counts.iter().zip(&mut places) {
                let (own, others) = rest.split_at_mut(count[part] as usize);
                places.push(own);
                rest = others;
            }
        }
        let work: Vec<_> = blocks.iter().cloned().zip(places).collect();
        par::in_parts(work, |(block, mut places)| {
            let mut next = alloc::vec![0_u32; part_count];
            for (part, item) in items(block) {
                let part = part as usize;
                places[part][next[part] as usize] = item;
                next[part] += 1;
            }
        });
        Self { items: all, start }
    }

    /// The parts, to change.
    pub(crate) fn parts_mut(&mut self) -> Vec<(usize, &mut [T])> {
        let lengths = self.start.windows(2).map(|w| w[1] - w[0]);
        par::cut(&mut self.items, lengths).into_iter().enumerate().collect()
    }

    /// The items of one part.
    pub(crate) fn part(&self, part: usize) -> &[T] {
        &self.items[self.start[part]..self.start[part + 1]]
    }
}

/// A few ranges of about one size that make up `0..len`, none of them empty.
pub(crate) fn blocks(len: usize) -> Vec<Range<usize>> {
    let count = par::part_count().min(len);
    (0..count).map(|b| len * b / count..len * (b + 1) / count).collect()
}

/// How many parts of `1 << shift` there are in `len`.
pub(crate) fn parts_for(len: usize, shift: u32) -> usize {
    len.div_ceil(1 << shift)
}
