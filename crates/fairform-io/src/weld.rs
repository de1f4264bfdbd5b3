//! Equal positions made one vertex.

use std::hash::{BuildHasher, Hasher};

use fairform::{NONE, Vec3};
use foldhash::quality::RandomState;

use crate::par;

/// A position by its bits, where −0 is 0: so NaN equals itself and does no harm.
pub(crate) trait Point: Copy {
    fn bits(self) -> [u64; 3];
    fn position(self) -> Vec3;
}

impl Point for Vec3 {
    fn bits(self) -> [u64; 3] {
        // Adding 0 turns −0 into 0.
        let bits = |c: f64| (c + 0.0).to_bits();
        [bits(self.x), bits(self.y), bits(self.z)]
    }

    fn position(self) -> Vec3 {
        self
    }
}

impl Point for [f32; 3] {
    fn bits(self) -> [u64; 3] {
        let bits = |c: f32| u64::from((c + 0.0).to_bits());
        [bits(self[0]), bits(self[1]), bits(self[2])]
    }

    fn position(self) -> Vec3 {
        self.map(f64::from).into()
    }
}

/// Which numbers have which bits: a table with linear probing, never more than 5/8 full.
///
/// The hash is seeded, but only found or not found comes out of it.
struct Table {
    /// The number in each slot, or `NONE`. The slots are a power of two.
    slots: Vec<u32>,
    count: usize,
    state: RandomState,
}

impl Table {
    fn with_capacity(count: usize, state: RandomState) -> Self {
        let slots = (count + count * 5 / 8).next_power_of_two().max(16);
        Self { slots: vec![NONE; slots], count: 0, state }
    }

    fn hash(&self, bits: [u64; 3]) -> u64 {
        hash(&self.state, bits)
    }

    /// The number with these bits and this hash, or `new`, which is put there.
    fn number(
        &mut self,
        (bits, hash): ([u64; 3], u64),
        new: u32,
        bits_of: impl Fn(u32) -> [u64; 3],
    ) -> u32 {
        if self.count >= self.slots.len() / 8 * 5 {
            self.grow(&bits_of);
        }
        let mask = self.slots.len() - 1;
        let mut slot = hash as usize & mask;
        loop {
            match self.slots[slot] {
                NONE => {
                    self.slots[slot] = new;
                    self.count += 1;
                    return new;
                }
                number if bits_of(number) == bits => return number,
                _ => slot = (slot + 1) & mask,
            }
        }
    }

    #[cold]
    fn grow(&mut self, bits_of: &impl Fn(u32) -> [u64; 3]) {
        let mask = 4 * self.slots.len() - 1;
        let old = std::mem::replace(&mut self.slots, vec![NONE; mask + 1]);
        for number in old.into_iter().filter(|number| *number != NONE) {
            let mut slot = self.hash(bits_of(number)) as usize & mask;
            while self.slots[slot] != NONE {
                slot = (slot + 1) & mask;
            }
            self.slots[slot] = number;
        }
    }
}

fn hash(state: &RandomState, [x, y, z]: [u64; 3]) -> u64 {
    let mut hasher = state.build_hasher();
    hasher.write_u64(x);
    hasher.write_u64(y);
    hasher.write_u64(z);
    hasher.finish()
}

/// Numbers distinct positions in the order in which they first appear.
pub(crate) struct Weld<P> {
    table: Table,
    pub(crate) positions: Vec<P>,
}

impl<P: Point> Weld<P> {
    pub(crate) fn with_capacity(positions: usize) -> Self {
        Self {
            table: Table::with_capacity(positions, RandomState::default()),
            positions: Vec::with_capacity(positions),
        }
    }

    /// The vertex at a position.
    pub(crate) fn vertex(&mut self, position: P) -> u32 {
        let bits = position.bits();
        let new = self.positions.len() as u32;
        let key = (bits, self.table.hash(bits));
        let vertex = self.table.number(key, new, |v| self.positions[v as usize].bits());
        if vertex == new {
            self.positions.push(position);
        }
        vertex
    }
}

/// The positions that stand before, each with the first that is equal: in order for each of a few
/// parts. Each thread takes the positions whose hash is its own.
fn repeated<P: Point + Sync>(positions: &[P]) -> Vec<Vec<(u32, u32)>> {
    const LEAST: usize = 1 << 14;
    let state = RandomState::default();
    let parts = par::threads().min(positions.len() / LEAST).max(1) as u64;
    par::map(0..parts, |part| {
        let mut table = Table::with_capacity(positions.len() / parts as usize, state.clone());
        let mut repeated = Vec::new();
        for (i, position) in (0..).zip(positions) {
            let bits = position.bits();
            let hash = hash(&state, bits);
            if ((hash >> 32) * parts) >> 32 == part {
                let first = table.number((bits, hash), i, |i| positions[i as usize].bits());
                if first != i {
                    repeated.push((i, first));
                }
            }
        }
        repeated
    })
}

/// How many distinct positions there are.
pub(crate) fn distinct(positions: &[Vec3]) -> usize {
    positions.len() - repeated(positions).iter().map(Vec::len).sum::<usize>()
}

/// For each position the number of its vertex, in the order in which they first appear.
pub(crate) fn numbers<P: Point + Sync>(positions: &[P]) -> Vec<u32> {
    let mut numbers = vec![NONE; positions.len()];
    for (i, first) in repeated(positions).into_iter().flatten() {
        numbers[i as usize] = first;
    }
    let mut next = 0;
    for i in 0..numbers.len() {
        numbers[i] = match numbers[i] {
            NONE => {
                next += 1;
                next - 1
            }
            // Numbered already, since it stands before.
            first => numbers[first as usize],
        };
    }
    numbers
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;

    /// Numbers by a map of the library, on one thread.
    fn plainly(points: &[[f32; 3]]) -> Vec<u32> {
        let mut known = HashMap::new();
        points
            .iter()
            .map(|p| {
                let next = known.len() as u32;
                *known.entry(p.bits()).or_insert(next)
            })
            .collect()
    }

    #[test]
    fn positions_are_numbered_as_they_first_appear() {
        // Few of many, many of few, and all of one; long enough for several parts.
        for distinct in [1_u32, 50, 20_000, 200_000] {
            let point = |i: u32| {
                let k = (i.wrapping_mul(2_654_435_761) >> 7) % distinct;
                [k as f32, -0.0, if i.is_multiple_of(2) { 0.0 } else { -0.0 }]
            };
            let mut points: Vec<[f32; 3]> = (0..60_000).map(point).collect();
            points[77] = [f32::NAN; 3];
            points[59_000] = [f32::NAN; 3];
            let expected = plainly(&points);
            assert_eq!(numbers(&points), expected);
            let count = expected.iter().max().unwrap() + 1;
            let positions: Vec<Vec3> = points.iter().map(|p| p.position()).collect();
            assert_eq!(super::distinct(&positions), count as usize);
            // From no room at all the table grows.
            let mut weld = Weld::with_capacity(0);
            assert_eq!(points.iter().map(|p| weld.vertex(*p)).collect::<Vec<_>>(), expected);
            assert_eq!(weld.positions.len(), count as usize);
        }
    }
}
