//! Numbers behind a PLY header: text, or binary in either byte order.

use std::ops::Range;

use super::header::{Element, Property, Scalar};
use crate::error::{ParseError, Place};
use crate::lines::Lines;
use crate::par;
use crate::text::Scanner;

/// How a message begins that says the file ends in a row; how many rows there are is then said too.
pub(super) const END: &str = "the file ends";

/// Where the numbers come from.
pub(super) trait Body {
    /// What `read` makes of all rows of an element: of those in each of a few parts of the body, in
    /// order, or of all at once.
    fn gather<R: Send>(
        &mut self,
        element: &Element<'_>,
        read: impl Fn(&mut Self, Range<u64>) -> Result<R, ParseError> + Sync + Send,
    ) -> Result<Vec<R>, ParseError>
    where
        Self: Sized,
    {
        Ok(vec![read(self, 0..element.count)?])
    }
    /// An error unless what is left can hold the rows of an element.
    fn check(&self, element: &Element<'_>) -> Result<(), ParseError>;
    /// Starts a row.
    fn begin_row(&mut self) {}
    /// Ends a row.
    fn end_row(&mut self) -> Result<(), ParseError> {
        Ok(())
    }
    /// Whether nothing is left.
    fn is_at_end(&mut self) -> bool;
    /// How many bytes are left behind the last element.
    fn left(&mut self) -> usize;
    /// The next number. Fails at the end.
    fn number(&mut self, scalar: Scalar) -> Result<f64, ParseError>;
    /// The next whole number, of a type that is no floating one. Fails at the end.
    fn integer(&mut self, scalar: Scalar) -> Result<i64, ParseError>;
    /// The length of the list here. Fails if what is left cannot hold it, or for one below 0.
    fn length(&mut self, property: &Property<'_>) -> Result<usize, ParseError>;
    /// Skips so many numbers.
    fn skip(&mut self, scalar: Scalar, count: usize) -> Result<(), ParseError>;
    /// Where the next number is.
    fn offset(&self) -> usize;
    /// The place of an offset.
    fn place(&self, offset: usize) -> Place;
    /// The rows of an element without lists, if they are bytes of one size: those, and the reading
    /// of one number.
    fn rows(&mut self, _: &Element<'_>) -> Option<Rows<'_>> {
        None
    }
    /// What is left, if it is binary in little-endian order.
    fn little(&self) -> Option<&[u8]> {
        None
    }
    /// Goes over bytes of [`little`](Self::little).
    fn advance(&mut self, _: usize) {}
}

/// The rows of an element as bytes.
pub(super) struct Rows<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) size: usize,
    pub(super) read: fn(Scalar, &[u8]) -> f64,
    little: bool,
}

impl Rows<'_> {
    /// `N` numbers of each row: their types, and where they are in it.
    pub(super) fn columns<const N: usize>(&self, at: [(Scalar, usize); N]) -> Vec<[f64; N]> {
        let same = |scalar| self.little && at.iter().all(|(of, _)| *of == scalar);
        let count = self.bytes.len() / self.size;
        let row = |i: usize| &self.bytes[i * self.size..][..self.size];
        // The usual types by themselves: a type that is known is read several times as fast.
        if same(Scalar::F64) {
            return par::collect(count, |i| at.map(|(_, at)| real(row(i), at)));
        }
        if same(Scalar::F32) {
            return par::collect(count, |i| at.map(|(_, at)| f64::from(single(row(i), at))));
        }
        if same(Scalar::U8) {
            return par::collect(count, |i| at.map(|(_, at)| f64::from(row(i)[at])));
        }
        par::collect(count, |i| at.map(|(scalar, at)| (self.read)(scalar, &row(i)[at..])))
    }
}

fn real(row: &[u8], at: usize) -> f64 {
    row[at..].first_chunk().map_or(f64::NAN, |bytes| f64::from_le_bytes(*bytes))
}

fn single(row: &[u8], at: usize) -> f32 {
    row[at..].first_chunk().map_or(f32::NAN, |bytes| f32::from_le_bytes(*bytes))
}

/// Numbers as text, whose rows may go over several lines.
pub(super) struct AsciiBody<'a> {
    text: Scanner<'a>,
    /// To read in parts, where each row must have a line of its own: the lines.
    lines: Option<Lines<'a>>,
    /// The line of the next row.
    line: usize,
    /// Whether a row ends with the line.
    by_line: bool,
}

impl<'a> AsciiBody<'a> {
    /// A body that is read from its first row to the last.
    pub(super) fn new(text: Scanner<'a>) -> Self {
        Self { text, lines: None, line: 0, by_line: false }
    }

    /// A body that is read in so many parts. It fails, without saying what is wrong, where a row has
    /// no line of its own or there is another fault.
    pub(super) fn in_parts(text: Scanner<'a>, part_count: usize) -> Self {
        Self { lines: Some(Lines::new(&text, part_count, false)), ..Self::new(text) }
    }

    /// Goes to the next number.
    fn seek(&mut self) {
        if self.by_line { self.text.skip_blanks() } else { self.text.skip_space() }
    }
}

impl Body for AsciiBody<'_> {
    fn gather<R: Send>(
        &mut self,
        element: &Element<'_>,
        read: impl Fn(&mut Self, Range<u64>) -> Result<R, ParseError> + Sync + Send,
    ) -> Result<Vec<R>, ParseError> {
        let Some(lines) = self.lines.as_ref().filter(|_| element.has_rows()) else {
            return Ok(vec![read(self, 0..element.count)?]);
        };
        let first = self.line;
        let left = lines.len() - first;
        let count = usize::try_from(element.count).ok().filter(|count| *count <= left);
        let end = first + count.ok_or_else(|| ParseError::file(END))?;
        let parts = lines.map(first..end, |text, rows| {
            let mut part = Self { by_line: true, ..Self::new(text) };
            read(&mut part, (rows.start - first) as u64..(rows.end - first) as u64)
        });
        self.line = end;
        parts.into_iter().collect()
    }

    fn check(&self, element: &Element<'_>) -> Result<(), ParseError> {
        // A number takes a byte, and one to part it from the next.
        let numbers = element.count.saturating_mul(element.properties.len() as u64);
        if numbers > (self.text.remaining() as u64).div_ceil(2) {
            // Count what is there, to say it.
            let mut text = self.text;
            let mut rows = 0_u64;
            text.skip_space();
            while !text.is_at_end() && rows < element.count {
                text.skip_line();
                text.skip_space();
                rows += 1;
            }
            let declared = element.counted(element.count);
            let message = format!("the file declares {declared} and ends after {rows}");
            return Err(text.error(message));
        }
        Ok(())
    }

    fn begin_row(&mut self) {
        self.text.skip_space();
    }

    fn end_row(&mut self) -> Result<(), ParseError> {
        self.text.skip_blanks();
        match self.text.peek() {
            None | Some(b'\n' | b'\r') => Ok(()),
            _ => Err(self.text.unexpected("the end of the line")),
        }
    }

    fn is_at_end(&mut self) -> bool {
        self.text.skip_space();
        self.text.is_at_end()
    }

    fn left(&mut self) -> usize {
        if let Some(lines) = &self.lines {
            return lines.start(self.line).map_or(0, |text| text.remaining());
        }
        self.text.skip_space();
        self.text.remaining()
    }

    fn number(&mut self, _: Scalar) -> Result<f64, ParseError> {
        self.seek();
        self.text.number()
    }

    fn integer(&mut self, _: Scalar) -> Result<i64, ParseError> {
        self.seek();
        self.text.integer("a whole number")
    }

    fn length(&mut self, _: &Property<'_>) -> Result<usize, ParseError> {
        self.seek();
        let at = self.text.at;
        let length = self.text.count("the length of a list")?;
        if length > (self.text.remaining() as u64).div_ceil(2) {
            let message = format!("{END}, too soon for a list of {length} numbers");
            return Err(self.text.error_at(at, message));
        }
        Ok(length as usize)
    }

    fn skip(&mut self, _: Scalar, count: usize) -> Result<(), ParseError> {
        for _ in 0..count {
            self.seek();
            if self.text.word().is_empty() {
                return Err(self.text.unexpected("a number"));
            }
        }
        Ok(())
    }

    fn offset(&self) -> usize {
        self.text.at
    }

    fn place(&self, offset: usize) -> Place {
        Place::Line(self.text.line_of(offset))
    }
}

pub(super) struct BinaryBody<'a, const BIG: bool> {
    pub(super) bytes: &'a [u8],
    pub(super) at: usize,
}

impl<'a, const BIG: bool> BinaryBody<'a, BIG> {
    fn next(&mut self, scalar: Scalar) -> Result<&'a [u8], ParseError> {
        match self.bytes.get(self.at..self.at + scalar.size()) {
            Some(bytes) => {
                self.at += scalar.size();
                Ok(bytes)
            }
            None => Err(ParseError::byte(self.at, END)),
        }
    }
}

impl<const BIG: bool> Body for BinaryBody<'_, BIG> {
    fn check(&self, element: &Element<'_>) -> Result<(), ParseError> {
        let size = element.least_size();
        let left = self.bytes.len() - self.at;
        // With lists the rows differ, and where the file ends shows on the way; but not even the
        // shortest rows may be more than the bytes.
        if size > 0 && element.count > (left / size) as u64 && !element.has_lists() {
            let (declared, n) = (element.counted(element.count), left / size);
            let message = format!("the file declares {declared} and ends after {n}");
            return Err(ParseError::byte(self.bytes.len(), message));
        }
        Ok(())
    }

    fn is_at_end(&mut self) -> bool {
        self.at >= self.bytes.len()
    }

    fn left(&mut self) -> usize {
        self.bytes.len() - self.at
    }

    fn number(&mut self, scalar: Scalar) -> Result<f64, ParseError> {
        Ok(scalar.read::<BIG>(self.next(scalar)?))
    }

    fn integer(&mut self, scalar: Scalar) -> Result<i64, ParseError> {
        Ok(scalar.read_integer::<BIG>(self.next(scalar)?))
    }

    fn length(&mut self, property: &Property<'_>) -> Result<usize, ParseError> {
        let at = self.at;
        let length = self.integer(property.count.unwrap_or(Scalar::U8))?;
        let left = (self.bytes.len() - self.at) / property.scalar.size();
        match usize::try_from(length) {
            Ok(length) if length <= left => Ok(length),
            Ok(length) => {
                let message = format!("{END}, and holds {left} of the {length} numbers of a list");
                Err(ParseError::byte(at, message))
            }
            Err(_) => Err(ParseError::byte(at, format!("a list of {length} numbers"))),
        }
    }

    fn skip(&mut self, scalar: Scalar, count: usize) -> Result<(), ParseError> {
        let left = (self.bytes.len() - self.at) / scalar.size();
        if count > left {
            return Err(ParseError::byte(self.bytes.len(), END));
        }
        self.at += count * scalar.size();
        Ok(())
    }

    fn offset(&self) -> usize {
        self.at
    }

    fn place(&self, offset: usize) -> Place {
        Place::Byte(offset as u64)
    }

    fn rows(&mut self, element: &Element<'_>) -> Option<Rows<'_>> {
        let size = element.least_size();
        if element.has_lists() || size == 0 {
            return None;
        }
        let length = usize::try_from(element.count).ok()?.checked_mul(size)?;
        let bytes = self.bytes.get(self.at..self.at.checked_add(length)?)?;
        self.at += length;
        Some(Rows { bytes, size, read: Scalar::read::<BIG>, little: !BIG })
    }

    fn little(&self) -> Option<&[u8]> {
        (!BIG).then(|| &self.bytes[self.at..])
    }

    fn advance(&mut self, count: usize) {
        self.at += count;
    }
}
