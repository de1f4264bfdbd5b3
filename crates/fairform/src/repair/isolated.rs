//! Removing vertices that no face uses.

use alloc::vec;
use core::fmt;

use super::report::Sentence;
use super::{Soup, Touched, source};
use crate::VertexId;

/// What [`Soup::drop_isolated`] did.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
#[must_use]
pub struct IsolatedReport {
    /// The vertices removed.
    pub dropped: Touched<VertexId>,
}

impl IsolatedReport {
    /// Whether the soup is another one now.
    #[must_use]
    pub fn changed(&self) -> bool {
        !self.dropped.is_empty()
    }
}

impl fmt::Display for IsolatedReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut sentence = Sentence::new(f);
        sentence.part("dropped", &self.dropped, ["unused vertex", "unused vertices"])?;
        sentence.end("no unused vertices")
    }
}

impl Soup {
    /// Removes the vertices that no face lists; the others keep their order.
    pub fn drop_isolated(&mut self) -> IsolatedReport {
        let mut used = vec![false; self.positions.len()];
        for &v in self.faces.corners() {
            if let Some(used) = used.get_mut(v as usize) {
                *used = true;
            }
        }
        let mut report = IsolatedReport::default();
        for (v, _) in (0..).zip(&used).filter(|&(_, &used)| !used) {
            report.dropped.vertex(source(&self.vertex_source, v));
        }
        if report.changed() {
            self.keep_vertices(&used, |v| v);
        }
        report
    }
}
