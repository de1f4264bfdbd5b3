//! Removing faces that are there twice.

use alloc::vec;
use alloc::vec::Vec;
use core::fmt;

use super::edges::Edges;
use super::report::Sentence;
use super::{Rebuilt, Soup, Touched, source};
use crate::{FaceId, Faces, NONE};

/// What [`Soup::drop_duplicates`] did.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
#[must_use]
pub struct DuplicateReport {
    /// The faces removed, since an earlier one has the same corners.
    pub dropped: Touched<FaceId>,
    /// Closed pairs of faces back to back, which stay.
    pub closed_pair_count: usize,
}

impl DuplicateReport {
    /// Whether the soup is another one now.
    #[must_use]
    pub fn changed(&self) -> bool {
        !self.dropped.is_empty()
    }
}

impl fmt::Display for DuplicateReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut sentence = Sentence::new(f);
        sentence.part("dropped", &self.dropped, ["duplicate face", "duplicate faces"])?;
        let pairs = ["closed pair of faces back to back", "closed pairs of faces back to back"];
        sentence.count("kept", self.closed_pair_count, pairs)?;
        sentence.end("no duplicate faces")
    }
}

impl Soup {
    /// Removes every face that lists the same vertices in the same cyclic order as an earlier one,
    /// in either direction.
    ///
    /// One case stays: exactly two copies in opposite directions whose edges no other face shares.
    /// They are a closed surface of two faces, which is a valid mesh, and a valid mesh is never
    /// changed. Faces that are not proper are not compared.
    pub fn drop_duplicates(&mut self) -> DuplicateReport {
        let (cycles, turned) = self.cycles();
        let uses = self.edge_uses();
        let cycle = |f: u32| cycles.get(FaceId(f));
        let mut order: Vec<u32> =
            (0..self.faces.len() as u32).filter(|&f| !cycle(f).is_empty()).collect();
        order.sort_unstable_by(|&f, &g| cycle(f).cmp(cycle(g)).then(f.cmp(&g)));

        let mut report = DuplicateReport::default();
        let mut goes = vec![false; self.faces.len()];
        for copies in order.chunk_by(|&f, &g| cycle(f) == cycle(g)) {
            let is_alone = |f: u32| self.corners_of(f).all(|h| uses[h as usize] == 2);
            if let [f, g] = *copies
                && turned[f as usize] != turned[g as usize]
                && is_alone(f)
            {
                report.closed_pair_count += 1;
                continue;
            }
            for &f in &copies[1..] {
                goes[f as usize] = true;
            }
        }
        for (f, _) in (0..).zip(&goes).filter(|&(_, &goes)| goes) {
            report.dropped.face(source(&self.face_source, f));
        }
        if report.changed() {
            let mut rebuilt = Rebuilt::for_faces_of(self);
            for (f, _) in (0..).zip(&goes).filter(|&(_, &goes)| !goes) {
                rebuilt.keep(self, f);
            }
            rebuilt.replace(self);
        }
        report
    }

    /// Each proper face turned and rotated so that the smallest vertex comes first and its smaller
    /// neighbour second, and whether it had to be turned; no corners for the other faces.
    fn cycles(&self) -> (Faces, Vec<bool>) {
        let mut cycles = Faces::with_capacity(self.faces.len(), self.faces.corners().len());
        let mut turned = Vec::with_capacity(self.faces.len());
        let mut cycle = Vec::new();
        for (face, proper) in self.faces.iter().zip(self.proper_faces()) {
            cycle.clear();
            let mut turn = false;
            if proper {
                cycle.extend_from_slice(face);
                let smallest = (0..face.len()).min_by_key(|&i| face[i]).unwrap_or(0);
                cycle.rotate_left(smallest);
                turn = cycle[1] > cycle[cycle.len() - 1];
                if turn {
                    cycle[1..].reverse();
                }
            }
            cycles.push(&cycle);
            turned.push(turn);
        }
        (cycles, turned)
    }

    /// How many proper faces have the edge that begins at each corner.
    fn edge_uses(&self) -> Vec<u32> {
        let mut uses = vec![NONE; self.faces.corners().len()];
        for group in Edges::of(self).groups() {
            for &[.., h] in group {
                uses[h as usize] = group.len() as u32;
            }
        }
        uses
    }
}
