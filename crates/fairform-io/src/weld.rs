//! Equal positions made one vertex.

use std::collections::HashMap;

use fairform::Vec3;
use foldhash::quality::RandomState;

/// Numbers distinct positions in the order in which they first appear.
///
/// Positions are equal when their bits are, where −0 is 0; so NaN equals itself and does no harm.
/// The hash is seeded, but only found or not found comes out of it.
pub(crate) struct Weld {
    index: HashMap<[u64; 3], u32, RandomState>,
    pub(crate) positions: Vec<Vec3>,
}

impl Weld {
    pub(crate) fn with_capacity(positions: usize) -> Self {
        Self {
            index: HashMap::with_capacity_and_hasher(positions, RandomState::default()),
            positions: Vec::with_capacity(positions),
        }
    }

    /// The vertex at a position.
    pub(crate) fn vertex(&mut self, position: Vec3) -> u32 {
        // Adding 0 turns −0 into 0.
        let key = [position.x, position.y, position.z].map(|c| (c + 0.0).to_bits());
        *self.index.entry(key).or_insert_with(|| {
            self.positions.push(position);
            self.positions.len() as u32 - 1
        })
    }
}
