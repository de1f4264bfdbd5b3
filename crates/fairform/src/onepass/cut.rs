//! Cutting the vertices of a topology into patches that are compact, so that their halos are small.

use alloc::collections::VecDeque;
use alloc::vec::Vec;

use crate::ids::{NONE, VertexId};
use crate::parted::{self, Parted};
use crate::{Topology, Vec3, order, par};

/// The rings of all vertices, one behind the other.
pub(super) struct Rings {
    pub(super) start: Vec<u32>,
    pub(super) neighbour: Vec<u32>,
}

impl Rings {
    pub(super) fn new(topology: &Topology) -> Self {
        let count = topology.vertex_count();
        let valence = |v: usize| topology.valence(VertexId(v as u32));
        let start = par::starts(count, valence).expect("half-edges can be numbered");
        let end = start[count] as usize;
        let mut neighbour = alloc::vec![0; end];
        let mut nothing = alloc::vec![(); end];
        par::fill_row_blocks(&start, &mut neighbour, &mut nothing, &|rows, block, _: &mut [()]| {
            topology.rings(rows.map(|v| VertexId(v as u32)), block);
        });
        Self { start, neighbour }
    }

    #[inline]
    pub(super) fn of(&self, v: u32) -> &[u32] {
        &self.neighbour[self.start[v as usize] as usize..self.start[v as usize + 1] as usize]
    }
}

/// The patch of every vertex, and how many patches there are: each grows breadth-first from where the
/// one before stopped until it has `size` vertices.
pub(super) fn cut(rings: &Rings, vertex_count: usize, size: usize) -> (Vec<u32>, usize) {
    let mut patch = alloc::vec![NONE; vertex_count];
    let mut patches = 0;
    // Vertices that a patch would have taken next, oldest first.
    let mut pending: VecDeque<u32> = VecDeque::new();
    let mut queue: VecDeque<u32> = VecDeque::new();
    let mut unseen = 0;
    let mut left = vertex_count;
    while left > 0 {
        let mut room = size.min(left);
        left -= room;
        while room > 0 {
            let Some(v) = queue.pop_front() else {
                let seed = pending.pop_front().filter(|&v| patch[v as usize] == NONE);
                if let Some(seed) = seed {
                    queue.push_back(seed);
                } else if pending.is_empty() {
                    while patch[unseen as usize] != NONE {
                        unseen += 1;
                    }
                    queue.push_back(unseen);
                }
                continue;
            };
            if patch[v as usize] != NONE {
                continue;
            }
            patch[v as usize] = patches;
            room -= 1;
            queue.extend(rings.of(v).iter().copied().filter(|&q| patch[q as usize] == NONE));
        }
        patches += 1;
        pending.extend(queue.drain(..).filter(|&v| patch[v as usize] == NONE));
    }
    (patch, patches as usize)
}

/// Vertices per cell of the grid over which positions are cut.
const PER_CELL: usize = 64;

/// Most bits of a cell's place per coordinate: a count for each cell lies in a core's last cache.
const MOST_BITS: u32 = 7;

/// As [`cut`], by positions: boxes with about `size` vertices in each, halved along their longest sides
/// until they are small enough. `None` where vertices lie too close together for the grid.
pub(super) fn cut_by_position(positions: &[Vec3], size: usize) -> Option<(Vec<u32>, usize)> {
    let count = positions.len();
    let patches = count.div_ceil(size);
    if patches <= 1 {
        return Some((alloc::vec![0; count], 1));
    }
    let bits = ((count / PER_CELL).max(1).ilog2() / 2).clamp(1, MOST_BITS);
    let bounds = order::bounds(positions);
    let side = bounds.longest_side();
    let scale = if side > 0.0 { f64::from((1_u32 << bits) - 1) / side } else { 0.0 };
    let mut patch_of = par::collect(count, |v| {
        let at = scale * (positions[v] - bounds.min);
        // What is not finite, or beyond, is clamped by the cast and the mask.
        let [x, y, z] = [at.x, at.y, at.z].map(|x| x as u32 & ((1 << bits) - 1));
        x | y << bits | z << (2 * bits)
    });
    let cell_count = 1 << (3 * bits);
    let counts = par::map_parts(parted::blocks(count), |block| {
        let mut counts = alloc::vec![0_u32; cell_count];
        patch_of[block].iter().for_each(|&cell| counts[cell as usize] += 1);
        counts
    });
    let weight = |cell: usize| counts.iter().map(|counts| counts[cell] as usize).sum();
    let mut cells: Vec<Cell> = (0..cell_count)
        .map(|i| {
            let place = [0, bits, 2 * bits].map(|shift| (i >> shift) as u8 & ((1 << bits) - 1));
            Cell { place, weight: weight(i) }
        })
        .filter(|cell| cell.weight > 0)
        .collect();
    let mut patch_of_cell = alloc::vec![0; cell_count];
    let mut next = 0;
    let largest = halve(&mut cells, patches, &mut |cells| {
        for &Cell { place: [x, y, z], .. } in cells {
            let cell = usize::from(x) | usize::from(y) << bits | usize::from(z) << (2 * bits);
            patch_of_cell[cell] = next;
        }
        next += 1;
    });
    if largest > 2 * size {
        return None;
    }
    par::for_blocks(&mut patch_of, |_, block| {
        block.iter_mut().for_each(|cell| *cell = patch_of_cell[*cell as usize]);
    });
    Some((patch_of, next as usize))
}

/// A cell of a grid, and how many vertices are in it.
struct Cell {
    place: [u8; 3],
    weight: usize,
}

/// Halves a box of cells until there are about so many, and returns the largest weight of any.
fn halve(cells: &mut [Cell], parts: usize, part: &mut impl FnMut(&[Cell])) -> usize {
    let whole: usize = cells.iter().map(|cell| cell.weight).sum();
    let extent = |axis: usize| {
        let places = || cells.iter().map(|cell| cell.place[axis]);
        (places().min().unwrap_or(0), places().max().unwrap_or(0))
    };
    let extents = [0, 1, 2].map(extent);
    let longest = (0..3).max_by_key(|&axis| extents[axis].1 - extents[axis].0).unwrap_or(0);
    let (low, high) = extents[longest];
    if parts <= 1 || low == high {
        part(cells);
        return whole;
    }
    let mut layers = [0; 1 << MOST_BITS];
    cells.iter().for_each(|cell| layers[usize::from(cell.place[longest])] += cell.weight);
    let wanted = whole * (parts / 2) / parts;
    // The lower box ends where its weight is nearest to that; both have a layer at least.
    let (mut end, mut lower) = (low + 1, layers[usize::from(low)]);
    while end < high && lower + layers[usize::from(end)] / 2 < wanted {
        lower += layers[usize::from(end)];
        end += 1;
    }
    let mut middle = 0;
    for i in 0..cells.len() {
        if cells[i].place[longest] < end {
            cells.swap(i, middle);
            middle += 1;
        }
    }
    let parts_below = ((parts * lower + whole / 2) / whole).clamp(1, parts - 1);
    let (below, above) = cells.split_at_mut(middle);
    halve(below, parts_below, part).max(halve(above, parts - parts_below, part))
}

/// Consecutive results of one patch; they end where the next run begins.
#[derive(Clone, Copy, Default, Debug)]
pub(super) struct Run {
    pub(super) patch: u32,
    pub(super) first: u32,
}

/// The runs of things whose patches `patch` tells.
pub(super) fn runs(count: usize, patch: impl Fn(u32) -> u32 + Sync) -> Vec<Run> {
    let blocks = par::blocks(count, |range| {
        let mut runs: Vec<Run> = Vec::new();
        for i in range.start as u32..range.end as u32 {
            let patch = patch(i);
            if runs.last().is_none_or(|run| run.patch != patch) {
                runs.push(Run { patch, first: i });
            }
        }
        runs
    });
    let mut runs: Vec<Run> = Vec::with_capacity(blocks.iter().map(Vec::len).sum());
    for block in blocks {
        let goes_on = runs.last().map(|run| run.patch) == block.first().map(|run| run.patch);
        runs.extend(&block[usize::from(goes_on && !block.is_empty())..]);
    }
    runs
}

/// Where a run ends among `count` things.
pub(super) fn end(runs: &[Run], i: usize, count: usize) -> u32 {
    runs.get(i + 1).map_or(count as u32, |next| next.first)
}

/// The things of each patch, in order.
pub(super) struct Groups(Parted<(u32, u32)>);

impl Groups {
    /// From the runs of `count` things.
    pub(super) fn new(patch_count: usize, runs: &[Run], count: usize) -> Self {
        Self(Parted::new(&parted::blocks(runs.len()), patch_count, |block| {
            block.map(|i| (runs[i].patch, (runs[i].first, end(runs, i, count))))
        }))
    }

    /// As ranges.
    pub(super) fn of(&self, patch: usize) -> &[(u32, u32)] {
        self.0.part(patch)
    }
}
