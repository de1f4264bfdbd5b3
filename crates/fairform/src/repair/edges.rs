//! Edges of a soup by sorting: which corners begin a half-edge along the same edge.

use alloc::collections::BTreeSet;
use alloc::vec;
use alloc::vec::Vec;

use super::Soup;
use crate::NONE;

/// The half-edges of the proper faces, grouped by undirected edge.
pub(super) struct Edges {
    /// Smaller vertex, larger vertex, half-edge; sorted.
    uses: Vec<[u32; 3]>,
    /// The face of each half-edge.
    pub(super) face: Vec<u32>,
    /// The half-edge that follows in the face; [`NONE`] in a face that is not proper.
    pub(super) next: Vec<u32>,
}

impl Edges {
    pub(super) fn of(soup: &Soup) -> Self {
        let corner_count = soup.faces.corners().len();
        let mut face = vec![NONE; corner_count];
        let mut next = vec![NONE; corner_count];
        let mut uses = Vec::with_capacity(corner_count);
        for (f, proper) in (0..).zip(soup.proper_faces()) {
            let corners = soup.corners_of(f);
            for h in corners.clone() {
                face[h as usize] = f;
                if proper {
                    let g = if h + 1 == corners.end { corners.start } else { h + 1 };
                    let (a, b) = (soup.vertex(h), soup.vertex(g));
                    next[h as usize] = g;
                    uses.push([a.min(b), a.max(b), h]);
                }
            }
        }
        uses.sort_unstable();
        Self { uses, face, next }
    }

    /// The half-edges along each edge, as smaller vertex, larger vertex, half-edge.
    pub(super) fn groups(&self) -> impl Iterator<Item = &[[u32; 3]]> {
        self.uses.chunk_by(|a, b| a[..2] == b[..2])
    }

    /// The other half-edge of each edge that has exactly two, whatever their directions.
    pub(super) fn mates(&self) -> Vec<u32> {
        let mut mate = vec![NONE; self.face.len()];
        for group in self.groups() {
            if let [[.., g], [.., h]] = *group {
                mate[g as usize] = h;
                mate[h as usize] = g;
            }
        }
        mate
    }

    /// The edges as a set that can grow.
    pub(super) fn into_set(self) -> EdgeSet {
        let mut given: Vec<[u32; 2]> = self.uses.into_iter().map(|[a, b, _]| [a, b]).collect();
        given.dedup();
        EdgeSet { given, added: BTreeSet::new() }
    }
}

/// Pairs of vertices that are joined by an edge.
pub(super) struct EdgeSet {
    given: Vec<[u32; 2]>,
    added: BTreeSet<[u32; 2]>,
}

impl EdgeSet {
    pub(super) fn has(&self, a: u32, b: u32) -> bool {
        let edge = [a.min(b), a.max(b)];
        self.given.binary_search(&edge).is_ok() || self.added.contains(&edge)
    }

    pub(super) fn add(&mut self, a: u32, b: u32) {
        if !self.has(a, b) {
            self.added.insert([a.min(b), a.max(b)]);
        }
    }
}
