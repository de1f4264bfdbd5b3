//! Rows of weights that are told rather than stored.

use alloc::vec::Vec;

use crate::ids::VertexId;
use crate::{Stencils, Topology, Vec3, par};

/// A rule that makes one value after the other, each a weighted sum of given ones. It can be applied
/// at once, or written out.
pub(crate) trait Rows: Sync {
    /// Number of results.
    fn len(&self) -> usize;

    /// Tells the entries of a row, `(source, weight)`; a source may come several times.
    fn visit(&self, row: usize, entry: impl FnMut(u32, f64));

    /// The topology whose vertices the first rows belong to, if it helps to know their rings.
    fn by_ring(&self) -> Option<&Topology> {
        None
    }

    /// [`visit`](Self::visit) for the row of a vertex whose ring is known.
    fn visit_vertex(&self, v: VertexId, _ring: &[u32], entry: impl FnMut(u32, f64)) {
        self.visit(v.index(), entry);
    }
}

/// The weighted sums of all rows. One thread gathers a whole row, in row order, so the bits do not
/// depend on how many run.
pub(crate) fn apply(rows: &impl Rows, values: &[Vec3]) -> Vec<Vec3> {
    let mut out = alloc::vec![Vec3::ZERO; rows.len()];
    let mut first = 0;
    if let Some(topology) = rows.by_ring() {
        first = topology.vertex_count();
        topology.fill_by_ring(&mut out[..first], |v, ring| {
            let mut sum = Vec3::ZERO;
            rows.visit_vertex(v, ring, |source, weight| sum += weight * values[source as usize]);
            sum
        });
    }
    par::fill(&mut out[first..], |row| {
        let mut sum = Vec3::ZERO;
        rows.visit(first + row, |source, weight| sum += weight * values[source as usize]);
        sum
    });
    out
}

/// The rows written out, each source once, in the order of its first entry.
pub(crate) fn stencils(rows: &impl Rows, source_count: usize) -> Stencils {
    let blocks = par::blocks(rows.len(), |range| {
        let (mut lengths, mut entries) = (Vec::with_capacity(range.len()), Vec::new());
        for row in range {
            let start = entries.len();
            gather(rows, row, &mut entries);
            lengths.push((entries.len() - start) as u32);
        }
        (lengths, entries)
    });
    let mut row_start = Vec::with_capacity(rows.len() + 1);
    let len = blocks.iter().map(|b| b.1.len()).sum();
    let (mut source, mut weight) = (Vec::with_capacity(len), Vec::with_capacity(len));
    let mut end = 0;
    row_start.push(end);
    for (lengths, entries) in blocks {
        row_start.extend(lengths.into_iter().map(|length| {
            end += length;
            end
        }));
        source.extend(entries.iter().map(|e| e.0));
        weight.extend(entries.iter().map(|e| e.1));
    }
    Stencils::from_arrays(source_count, row_start, source, weight)
}

/// Appends a row to `entries`, each source once.
pub(crate) fn gather(rows: &impl Rows, row: usize, entries: &mut Vec<(u32, f64)>) {
    let start = entries.len();
    rows.visit(row, |source, weight| entries.push((source, weight)));
    merge(entries, start);
}

/// Adds up the entries of one source from `start` on, where it came first.
fn merge(entries: &mut Vec<(u32, f64)>, start: usize) {
    const FEW: usize = 64;
    let row = &mut entries[start..];
    let mut kept = 0;
    if row.len() <= FEW {
        for i in 0..row.len() {
            let (source, weight) = row[i];
            if let Some(first) = row[..kept].iter_mut().find(|e| e.0 == source) {
                first.1 += weight;
            } else {
                row[kept] = (source, weight);
                kept += 1;
            }
        }
    } else {
        // Stable, so that weights are added in the order in which they came.
        let mut sorted: Vec<(u32, usize)> = row.iter().map(|e| e.0).zip(0..).collect();
        sorted.sort_unstable();
        let mut first = alloc::vec![false; row.len()];
        for same in sorted.chunk_by(|a, b| a.0 == b.0) {
            let sum = same.iter().map(|&(_, i)| row[i].1).sum();
            row[same[0].1].1 = sum;
            first[same[0].1] = true;
        }
        for i in 0..row.len() {
            if first[i] {
                row[kept] = row[i];
                kept += 1;
            }
        }
    }
    entries.truncate(start + kept);
}
