//! The neighbourhood that an edit is solved on.

use alloc::vec::Vec;

use super::Editor;
use crate::Vec3;
use crate::ids::{NONE, VertexId};

/// Vertices around some, ring by ring: a ring is what has the vertices before it in its limit rows.
/// So curves are not reached from the inside, nor free vertices from anywhere.
pub(super) struct Part<'e> {
    editor: &'e Editor,
    pub(super) vertices: Vec<u32>,
    /// Numbers of the vertices of the mesh in the part, or none.
    pub(super) local: Vec<u32>,
    /// The next ring, not yet in the part.
    next: Vec<u32>,
}

impl<'e> Part<'e> {
    pub(super) fn new(editor: &'e Editor, seeds: &[VertexId]) -> Self {
        let local = alloc::vec![NONE; editor.target.len()];
        let next = seeds.iter().map(|v| v.0).collect();
        Self { editor, vertices: Vec::new(), local, next }
    }

    /// Adds rings. Returns whether there is anything beyond.
    pub(super) fn grow(&mut self, rings: u32) -> bool {
        for _ in 0..rings {
            let start = self.vertices.len();
            if self.next.is_empty() {
                return false;
            }
            for &v in &self.next {
                self.local[v as usize] = self.vertices.len() as u32;
                self.vertices.push(v);
            }
            self.next.clear();
            for &q in &self.vertices[start..] {
                self.editor.for_column(q, |v| {
                    if self.local[v as usize] == NONE {
                        self.next.push(v);
                    }
                });
            }
            self.next.sort_unstable();
            self.next.dedup();
        }
        !self.next.is_empty()
    }

    /// The largest move of a limit point beyond the part, for moves `x` of its control points.
    pub(super) fn beyond(&self, x: &[Vec3]) -> f64 {
        let own = |v: u32| {
            let mut sum = Vec3::ZERO;
            self.editor.for_row(v, |q, weight| {
                let i = self.local[q as usize];
                if i != NONE {
                    sum += weight * x[i as usize];
                }
            });
            sum.length()
        };
        self.next.iter().map(|&v| own(v)).fold(0.0, f64::max)
    }
}
