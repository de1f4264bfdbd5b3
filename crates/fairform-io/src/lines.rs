//! A text with one thing per line, in parts that are read at once: each knows the numbers of its lines.

use std::ops::Range;

use crate::par;
use crate::text::Scanner;

/// The lines of a text that hold something, from 0, in parts.
pub(crate) struct Lines<'a> {
    text: Scanner<'a>,
    /// Where each part begins, and which lines are in it.
    parts: Vec<(Scanner<'a>, Range<usize>)>,
    /// Whether `#` begins a comment: a line with nothing before it holds nothing.
    comments: bool,
}

impl<'a> Lines<'a> {
    /// What is left of a text, in so many parts or a few times as many.
    pub(crate) fn new(text: &Scanner<'a>, part_count: usize, comments: bool) -> Self {
        // Vertices and faces are read after each other: with more parts each keeps all threads busy.
        let parts = text.parts(if part_count > 1 { 4 * part_count } else { 1 }, |_, _| true);
        let counts = par::map(&parts, |part| {
            let mut text = *part;
            skip(&mut text, comments);
            count_plain(&text.bytes[text.at..], comments).unwrap_or_else(|| count(text, comments))
        });
        let mut end = 0;
        let ranges = counts.into_iter().map(|count| {
            end += count;
            end - count..end
        });
        Self { parts: parts.into_iter().zip(ranges).collect(), text: *text, comments }
    }

    pub(crate) fn len(&self) -> usize {
        self.parts.last().map_or(0, |(_, lines)| lines.end)
    }

    /// Where the first word of a line is, if there are so many.
    pub(crate) fn start(&self, line: usize) -> Option<Scanner<'a>> {
        let (text, lines) = self.parts.iter().find(|(_, lines)| lines.contains(&line))?;
        let mut text = skip_lines(*text, line - lines.start, self.comments);
        skip(&mut text, self.comments);
        Some(Scanner { at: text.at, ..self.text })
    }

    /// What `read` makes of each part of some lines, in order. It gets a text that ends with the part,
    /// at the first of the lines in it or before, and which they are.
    pub(crate) fn map<R: Send>(
        &self,
        lines: Range<usize>,
        read: impl Fn(Scanner<'a>, Range<usize>) -> R + Sync + Send,
    ) -> Vec<R> {
        let tasks = self.parts.iter().filter_map(|(text, own)| {
            let wanted = own.start.max(lines.start)..own.end.min(lines.end);
            (!wanted.is_empty()).then_some((text, wanted.start - own.start, wanted))
        });
        par::map(tasks, |(text, before, lines)| {
            read(skip_lines(*text, before, self.comments), lines)
        })
    }
}

/// Goes to the next line that holds something.
fn skip(text: &mut Scanner<'_>, comments: bool) {
    if comments { text.skip_space_and_comments() } else { text.skip_space() }
}

fn skip_lines(mut text: Scanner<'_>, count: usize, comments: bool) -> Scanner<'_> {
    for _ in 0..count {
        skip(&mut text, comments);
        text.skip_line();
    }
    text
}

/// How many lines hold something.
fn count(mut text: Scanner<'_>, comments: bool) -> usize {
    let mut count = 0;
    loop {
        skip(&mut text, comments);
        if text.is_at_end() {
            return count;
        }
        text.skip_line();
        count += 1;
    }
}

/// As [`count`], if all lines begin with a word and end with LF or CRLF: several times as fast, since
/// one byte and the next are enough to see that.
fn count_plain(bytes: &[u8], comments: bool) -> Option<usize> {
    /// As many as a byte counts.
    const BLOCK: usize = 255;
    let comment = if comments { b'#' } else { b' ' };
    let is_word = |b: u8| b > b' ' && b != comment;
    let (&first, &last) = (bytes.first()?, bytes.last()?);
    if !is_word(first) || last == b'\r' {
        return None;
    }
    // The last byte ends a line, or the text does.
    let mut count = 1;
    for (bytes, next) in bytes.chunks(BLOCK).zip(bytes[1..].chunks(BLOCK)) {
        let (mut ends, mut odd) = (0_u8, false);
        for (&b, &next) in bytes.iter().zip(next) {
            let end = b == b'\n';
            ends += u8::from(end);
            odd |= end && !is_word(next) || b == b'\r' && next != b'\n';
        }
        if odd {
            return None;
        }
        count += usize::from(ends);
    }
    Some(count)
}

#[cfg(test)]
mod tests {
    use proptest::collection::vec;
    use proptest::prelude::*;
    use proptest::sample::select;

    use super::*;

    /// Where the words of all lines begin, by the definition.
    fn starts(bytes: &[u8], comments: bool) -> Vec<usize> {
        let mut starts = Vec::new();
        let mut at_start = true;
        for (i, b) in bytes.iter().enumerate() {
            if matches!(b, b'\n' | b'\r') {
                at_start = true;
            } else if at_start && comments && *b == b'#' {
                at_start = false;
            } else if at_start && !matches!(b, b' ' | b'\t' | 0x0b | 0x0c) {
                starts.push(i);
                at_start = false;
            }
        }
        starts
    }

    fn check(bytes: &[u8]) {
        for comments in [false, true] {
            let starts = starts(bytes, comments);
            if let Some(count) = count_plain(bytes, comments) {
                assert_eq!(count, starts.len());
            }
            for parts in [1, 2, 5] {
                let lines = Lines::new(&Scanner { bytes, at: 0 }, parts, comments);
                assert_eq!(lines.len(), starts.len());
                let found = (0..lines.len() + 2).filter_map(|line| lines.start(line));
                let found: Vec<usize> = found.map(|text| bytes.len() - text.remaining()).collect();
                assert_eq!(found, starts);
                let range = starts.len() / 3..starts.len();
                let read = lines.map(range.clone(), |mut text, lines| {
                    skip(&mut text, comments);
                    assert_eq!(text.at, starts[lines.start]);
                    assert!(lines.end == starts.len() || text.bytes.len() <= starts[lines.end]);
                    lines
                });
                assert_eq!(
                    read.into_iter().flatten().collect::<Vec<_>>(),
                    range.collect::<Vec<_>>()
                );
            }
        }
    }

    #[test]
    fn plain_lines_are_counted_at_once() {
        for length in [1, 7, 254, 255, 256, 600] {
            let line = "x".repeat(length);
            for (end, count) in [("\n", 9), ("\r\n", 9)] {
                let mut text = format!("{line}{end}").repeat(9);
                assert_eq!(count_plain(text.as_bytes(), true), Some(count));
                text += "#";
                assert_eq!(count_plain(text.as_bytes(), true), None);
                assert_eq!(count_plain(text.as_bytes(), false), Some(count + 1));
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn lines_are_where_their_first_word_is(
            words in vec(select(&["a", "bc d", "#", " ", "\t", "\n", "\n", "\r\n", "\r"][..]), 0..60),
        ) {
            check(words.concat().as_bytes());
        }
    }
}
