//! [`Touched`]: how many things a step touched, and the first few of them by name.

use alloc::vec::Vec;
use core::fmt;

use crate::{FaceId, NONE, VertexId};

/// So many examples are kept.
const EXAMPLES: usize = 8;

/// How many things a step touched, with the input numbers of the first few.
///
/// The numbers are those of the soup as it came in, which are the numbers in the file. A thing that
/// an earlier step made is counted, but has no number to show.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Touched<Id> {
    /// How many in all.
    pub count: usize,
    /// The first few, at most eight, in the order of the soup.
    pub first: Vec<Id>,
}

impl<Id> Default for Touched<Id> {
    fn default() -> Self {
        Self { count: 0, first: Vec::new() }
    }
}

impl<Id> Touched<Id> {
    /// Whether nothing was touched.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    fn add(&mut self, known: bool, id: Id) {
        self.count += 1;
        if known && self.first.len() < EXAMPLES {
            self.first.push(id);
        }
    }
}

impl Touched<FaceId> {
    pub(super) fn face(&mut self, source: u32) {
        self.add(source != NONE, FaceId(source));
    }
}

impl Touched<VertexId> {
    pub(super) fn vertex(&mut self, source: u32) {
        self.add(source != NONE, VertexId(source));
    }
}

impl Touched<[VertexId; 2]> {
    pub(super) fn edge(&mut self, ends: [u32; 2]) {
        self.add(!ends.contains(&NONE), ends.map(VertexId));
    }
}

/// An id as it appears in a list of examples.
trait Example {
    fn show(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result;
}

impl Example for FaceId {
    fn show(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

impl Example for VertexId {
    fn show(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

impl Example for [VertexId; 2] {
    fn show(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}–{}", self[0], self[1])
    }
}

/// Writes the parts of a sentence that have something to say, or else that there was nothing.
pub(super) struct Sentence<'a, 'b> {
    out: &'a mut fmt::Formatter<'b>,
    empty: bool,
}

impl<'a, 'b> Sentence<'a, 'b> {
    pub(super) fn new(out: &'a mut fmt::Formatter<'b>) -> Self {
        Self { out, empty: true }
    }

    /// `verb count one/many (examples)`, if the count is not zero.
    #[expect(private_bounds, reason = "only the three kinds of id of this module are shown")]
    pub(super) fn part<Id: Example>(
        &mut self,
        verb: &str,
        touched: &Touched<Id>,
        [one, many]: [&str; 2],
    ) -> fmt::Result {
        if touched.is_empty() {
            return Ok(());
        }
        self.count(verb, touched.count, [one, many])?;
        for (i, id) in touched.first.iter().enumerate() {
            self.out.write_str(if i == 0 { " (" } else { ", " })?;
            id.show(self.out)?;
        }
        if !touched.first.is_empty() {
            let more = touched.first.len() < touched.count;
            self.out.write_str(if more { ", …)" } else { ")" })?;
        }
        Ok(())
    }

    /// `verb count one/many`, if the count is not zero.
    pub(super) fn count(
        &mut self,
        verb: &str,
        count: usize,
        [one, many]: [&str; 2],
    ) -> fmt::Result {
        if count == 0 {
            return Ok(());
        }
        let start = if self.empty { "" } else { "; " };
        self.empty = false;
        let noun = if count == 1 { one } else { many };
        let gap = if verb.is_empty() { "" } else { " " };
        write!(self.out, "{start}{verb}{gap}{count} {noun}")
    }

    /// Ends the sentence; one without parts becomes `nothing`.
    pub(super) fn end(self, nothing: &str) -> fmt::Result {
        if self.empty { self.out.write_str(nothing) } else { Ok(()) }
    }
}
