//! Walking around many vertices at once.
//!
//! Each step around a vertex waits for the memory that the step before asked for. So the walks of a
//! few vertices are made side by side, a step of each in turn, and wait together.

use alloc::vec::Vec;

use super::Topology;
use crate::ids::{HalfedgeId, NONE, VertexId};
use crate::par;

/// Walks side by side: enough for all that a processor can wait for, few enough for its first cache.
pub(super) const TOGETHER: usize = 64;

struct Walk {
    /// The half-edge that the walk has come to.
    at: u32,
    /// Where its target is to be written.
    place: u32,
    /// Half-edges to come, this one too.
    left: u32,
}

impl Topology {
    /// Sets every `out[v]` to `f(v, ring of v)`, the ring as in [`ring`](Self::ring).
    pub(crate) fn fill_by_ring<T: Send>(
        &self,
        out: &mut [T],
        f: impl Fn(VertexId, &[u32]) -> T + Sync,
    ) {
        assert_eq!(out.len(), self.vertex_count(), "one value per vertex");
        par::for_blocks(out, |start, block| {
            let mut rings = Vec::new();
            for (i, some) in block.chunks_mut(TOGETHER).enumerate() {
                let first = (start + i * TOGETHER) as u32;
                let vertices = || (first..first + some.len() as u32).map(VertexId);
                rings.resize(vertices().map(|v| self.valence(v) as usize).sum(), NONE);
                self.rings(vertices(), &mut rings);
                let mut rest = rings.as_slice();
                for (v, slot) in vertices().zip(some) {
                    let (ring, others) = rest.split_at(self.valence(v) as usize);
                    *slot = f(v, ring);
                    rest = others;
                }
            }
        });
    }

    /// Writes the rings of some vertices one behind the other.
    ///
    /// # Panics
    /// If there is not room for just so many.
    pub(crate) fn rings(&self, mut vertices: impl Iterator<Item = VertexId>, out: &mut [u32]) {
        let mut walks = Vec::with_capacity(TOGETHER);
        let mut end = 0;
        loop {
            walks.extend(vertices.by_ref().take(TOGETHER).map(|v| {
                let place = end;
                end += self.valence(v);
                Walk { at: self.outgoing[v.index()], place, left: self.fan_size(v) }
            }));
            if walks.is_empty() {
                assert_eq!(end as usize, out.len(), "room for the rings");
                return;
            }
            walks.retain(|walk| walk.left > 0);
            while let Some(steps) = walks.iter().map(|walk| walk.left).min() {
                for _ in 0..steps {
                    for walk in &mut walks {
                        self.step(walk, out);
                    }
                }
                walks.retain(|walk| walk.left > 0);
            }
        }
    }

    #[inline]
    fn step(&self, walk: &mut Walk, out: &mut [u32]) {
        let h = HalfedgeId(walk.at);
        let back = self.prev(h).index();
        out[walk.place as usize] = self.target(h).0;
        walk.at = self.twin[back];
        walk.place += 1;
        walk.left -= 1;
        if walk.left == 0 && walk.at == NONE {
            // An open fan has one neighbour more than faces.
            out[walk.place as usize] = self.origin[back];
        }
    }
}
