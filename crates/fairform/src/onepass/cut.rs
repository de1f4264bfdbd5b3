//! Cutting the vertices of a topology into patches that are compact, so that their halos are small.

use alloc::collections::VecDeque;
use alloc::vec::Vec;

use crate::ids::{NONE, VertexId};
use crate::{Topology, par};

/// The rings of all vertices, one behind the other.
pub(super) struct Rings {
    pub(super) start: Vec<u32>,
    pub(super) neighbour: Vec<u32>,
}

impl Rings {
    pub(super) fn new(topology: &Topology) -> Self {
        let count = topology.vertex_count();
        let mut start = Vec::with_capacity(count + 1);
        let mut end = 0;
        start.push(end);
        start.extend(topology.vertices().map(|v| {
            end += topology.valence(v);
            end
        }));
        let mut neighbour = alloc::vec![0; end as usize];
        let mut nothing = alloc::vec![(); end as usize];
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

/// Things in groups, in order within each.
pub(super) struct Groups {
    start: Vec<u32>,
    item: Vec<u32>,
}

impl Groups {
    pub(super) fn new(group_count: usize, item_count: usize, group: impl Fn(u32) -> u32) -> Self {
        let mut start = alloc::vec![0; group_count + 2];
        for i in 0..item_count as u32 {
            start[group(i) as usize + 2] += 1;
        }
        for g in 2..start.len() {
            start[g] += start[g - 1];
        }
        let mut item = alloc::vec![0; item_count];
        for i in 0..item_count as u32 {
            let end = &mut start[group(i) as usize + 1];
            item[*end as usize] = i;
            *end += 1;
        }
        start.pop();
        Self { start, item }
    }

    pub(super) fn of(&self, group: usize) -> &[u32] {
        &self.item[self.start[group] as usize..self.start[group + 1] as usize]
    }
}

/// Consecutive results of one patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    pub(super) patch: u32,
    pub(super) len: u32,
}

/// Appends the runs of results whose patches `patch` tells.
pub(super) fn runs(count: usize, patch: impl Fn(u32) -> u32) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for i in 0..count as u32 {
        let patch = patch(i);
        match runs.last_mut() {
            Some(run) if run.patch == patch => run.len += 1,
            _ => runs.push(Run { patch, len: 1 }),
        }
    }
    runs
}
