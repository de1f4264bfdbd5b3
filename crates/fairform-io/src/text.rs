//! Scanning words and numbers in text held as bytes, and writing numbers.

use crate::error::{ParseError, Place};

/// A position in a text. Lines are counted only when an error needs one.
#[derive(Clone, Copy)]
pub(crate) struct Scanner<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) at: usize,
}

/// Blanks within a line.
const fn is_blank(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | 0x0b | 0x0c)
}

const fn is_line_end(b: u8) -> bool {
    matches!(b, b'\n' | b'\r')
}

impl<'a> Scanner<'a> {
    /// A scanner at the beginning of a text, behind a byte order mark.
    ///
    /// # Errors
    /// If the text is empty or UTF-16.
    pub(crate) fn new(bytes: &'a [u8]) -> Result<Self, ParseError> {
        if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
            return Err(ParseError::file("the text is UTF-16").expected("UTF-8 or ASCII"));
        }
        let at = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        if bytes[at..].iter().all(u8::is_ascii_whitespace) {
            let what = if bytes.is_empty() { "is empty" } else { "holds only white space" };
            return Err(ParseError::file(format!("the file {what}")));
        }
        Ok(Self { bytes, at })
    }

    pub(crate) fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    pub(crate) fn is_at_end(&self) -> bool {
        self.at >= self.bytes.len()
    }

    pub(crate) fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    pub(crate) fn skip_blanks(&mut self) {
        while self.peek().is_some_and(is_blank) {
            self.at += 1;
        }
    }

    /// Skips blanks, and line ends behind a backslash.
    pub(crate) fn skip_blanks_and_continuations(&mut self) {
        loop {
            self.skip_blanks();
            if self.peek() != Some(b'\\') {
                return;
            }
            match self.bytes[self.at + 1..] {
                [b'\r', b'\n', ..] => self.at += 3,
                [b'\n' | b'\r', ..] => self.at += 2,
                [] => self.at += 1,
                _ => return,
            }
        }
    }

    /// Skips blanks, line ends, and comments from `#` to the end of the line.
    pub(crate) fn skip_space_and_comments(&mut self) {
        loop {
            match self.peek() {
                Some(b'#') => self.at = self.line_end(),
                Some(b) if is_blank(b) || is_line_end(b) => self.at += 1,
                _ => return,
            }
        }
    }

    /// Skips blanks and line ends.
    pub(crate) fn skip_space(&mut self) {
        while self.peek().is_some_and(|b| is_blank(b) || is_line_end(b)) {
            self.at += 1;
        }
    }

    /// Whether nothing but a comment is left on this line. Skips the blanks before it.
    pub(crate) fn is_at_line_end(&mut self) -> bool {
        self.skip_blanks();
        self.peek().is_none_or(|b| is_line_end(b) || b == b'#')
    }

    /// Where the line ends, before its line end bytes.
    pub(crate) fn line_end(&self) -> usize {
        memchr::memchr2(b'\n', b'\r', &self.bytes[self.at..])
            .map_or(self.bytes.len(), |n| self.at + n)
    }

    /// Skips the rest of the line and its end.
    pub(crate) fn skip_line(&mut self) {
        self.at = self.line_end();
        self.skip_line_end();
    }

    /// Skips one line end (LF, CR or CRLF), if there is one here.
    pub(crate) fn skip_line_end(&mut self) {
        if self.peek() == Some(b'\r') {
            self.at += 1;
        }
        if self.peek() == Some(b'\n') {
            self.at += 1;
        }
    }

    /// The rest of the line without the blanks around it.
    pub(crate) fn rest_of_line(&mut self) -> &'a [u8] {
        self.skip_blanks();
        let from = self.at;
        self.at = self.line_end();
        trim(&self.bytes[from..self.at])
    }

    /// Skips to the next line that does not continue this one behind a backslash.
    pub(crate) fn skip_statement(&mut self) {
        loop {
            let end = self.line_end();
            let continued = end > self.at && self.bytes[end - 1] == b'\\';
            self.skip_line();
            if !continued || self.is_at_end() {
                return;
            }
        }
    }

    /// The rest of the statement up to a comment, as a name.
    pub(crate) fn statement_name(&mut self) -> String {
        self.skip_blanks();
        let from = self.at;
        self.skip_statement();
        let rest = &self.bytes[from..self.at];
        let end = (0..rest.len())
            .find(|&i| rest[i] == b'#' && (i == 0 || rest[i - 1].is_ascii_whitespace()));
        let rest = trim(&rest[..end.unwrap_or(rest.len())]);
        if !rest.iter().any(|b| matches!(b, b'\n' | b'\r')) {
            return text_of(rest);
        }
        let joined: Vec<_> = text_of(rest)
            .split(['\n', '\r'])
            .map(|line| line.strip_suffix('\\').unwrap_or(line).trim().to_string())
            .collect();
        joined.join(" ").trim().to_string()
    }

    /// What is left, cut behind line ends into so many parts or fewer: where `may_cut` agrees, which
    /// gets the text of the part and the text behind it, without the line end between. Each part ends
    /// where the text of its scanner does, and counts offsets and lines as the whole.
    pub(crate) fn parts(&self, count: usize, may_cut: impl Fn(&[u8], &[u8]) -> bool) -> Vec<Self> {
        let length = self.remaining().div_ceil(count.max(1)).max(1);
        let mut parts = Vec::with_capacity(count);
        let mut at = self.at;
        while at < self.bytes.len() {
            let mut end = at + length;
            loop {
                let rest = self.bytes.get(end - 1..).unwrap_or_default();
                let Some(n) = memchr::memchr(b'\n', rest) else {
                    end = self.bytes.len();
                    break;
                };
                end += n;
                if may_cut(&self.bytes[at..end - 1], &self.bytes[end..]) {
                    break;
                }
                end += 1;
            }
            parts.push(Self { bytes: &self.bytes[..end], at });
            at = end;
        }
        parts
    }

    /// The next bytes up to white space or the end; empty at a line end.
    pub(crate) fn word(&mut self) -> &'a [u8] {
        self.skip_blanks();
        let from = self.at;
        while self.peek().is_some_and(|b| !is_blank(b) && !is_line_end(b)) {
            self.at += 1;
        }
        &self.bytes[from..self.at]
    }

    /// Whether a number may end here.
    fn is_at_delimiter(&self) -> bool {
        match self.peek() {
            None => true,
            // A comment, unless it is what some C libraries write for what is no number: 1.#IND.
            Some(b'#') => {
                let rest = &self.bytes[self.at..];
                ![&b"#IND"[..], b"#INF", b"#QNAN", b"#SNAN"].iter().any(|w| rest.starts_with(w))
            }
            Some(b'\\') => self.bytes.get(self.at + 1).is_none_or(|&b| is_line_end(b)),
            Some(b) => is_blank(b) || is_line_end(b),
        }
    }

    /// A number here, without skipping anything before it. "nan", "inf" and "infinity" are
    /// numbers in any case, and one too large is infinite.
    pub(crate) fn number(&mut self) -> Result<f64, ParseError> {
        if let Ok((value, length)) = fast_float2::parse_partial(&self.bytes[self.at..]) {
            let from = self.at;
            self.at += length;
            if self.is_at_delimiter() {
                return Ok(value);
            }
            self.at = from;
        }
        Err(self.unexpected("a number"))
    }

    /// A whole number here, up to anything that is no digit.
    pub(crate) fn digits(&mut self, what: &str) -> Result<i64, ParseError> {
        let from = self.at;
        let sign = self.peek().filter(|b| matches!(b, b'+' | b'-'));
        self.at += usize::from(sign.is_some());
        let mut value = Some(0_i64);
        let mut count = 0;
        while let Some(digit) = self.peek().map(|b| b.wrapping_sub(b'0')).filter(|d| *d < 10) {
            value = value.and_then(|v| v.checked_mul(10)?.checked_add(i64::from(digit)));
            self.at += 1;
            count += 1;
        }
        if count == 0 {
            self.at = from;
            return Err(self.unexpected(what));
        }
        let Some(value) = value else {
            let message = format!("found {}, too large", quoted(Self { at: from, ..*self }.word()));
            return Err(self.error_at(from, message).expected(what));
        };
        Ok(if sign == Some(b'-') { -value } else { value })
    }

    /// A whole number here that white space ends.
    pub(crate) fn integer(&mut self, what: &str) -> Result<i64, ParseError> {
        let from = self.at;
        let value = self.digits(what)?;
        if self.is_at_delimiter() {
            return Ok(value);
        }
        self.at = from;
        Err(self.unexpected(what))
    }

    /// A count here: a whole number that is not negative.
    pub(crate) fn count(&mut self, what: &str) -> Result<u64, ParseError> {
        let from = self.at;
        let value = self.integer(what)?;
        u64::try_from(value).map_err(|_| {
            self.at = from;
            self.unexpected(what)
        })
    }

    /// An error here, about the word that stands here instead of `what`.
    pub(crate) fn unexpected(&self, what: &str) -> ParseError {
        let found = match self.clone_word() {
            [] if self.is_at_end() => "the file ends here".to_string(),
            [] => "the line ends here".to_string(),
            word => format!("found {}", quoted(word)),
        };
        self.error(found).expected(what)
    }

    fn clone_word(&self) -> &'a [u8] {
        Self { ..*self }.word()
    }

    /// An error at this line.
    pub(crate) fn error(&self, message: impl Into<String>) -> ParseError {
        self.error_at(self.at, message)
    }

    /// An error at the line of an offset.
    pub(crate) fn error_at(&self, at: usize, message: impl Into<String>) -> ParseError {
        ParseError::new(Place::Line(self.line_of(at)), message)
    }

    /// The line of an offset, from 1. Takes as long as the text before it.
    pub(crate) fn line_of(&self, at: usize) -> u64 {
        let before = &self.bytes[..at.min(self.bytes.len())];
        let ends = memchr::memchr2_iter(b'\n', b'\r', before);
        let inside = |i: usize| before[i] == b'\r' && before.get(i + 1) == Some(&b'\n');
        1 + ends.filter(|&i| !inside(i)).count() as u64
    }
}

/// Bytes without the blanks around them.
pub(crate) fn trim(bytes: &[u8]) -> &[u8] {
    bytes.trim_ascii()
}

/// Bytes as text: UTF-8, else Latin-1.
pub(crate) fn text_of(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_string(),
        Err(_) => bytes.iter().map(|&b| char::from(b)).collect(),
    }
}

/// Bytes in quotation marks, short enough for a message.
pub(crate) fn quoted(bytes: &[u8]) -> String {
    let text = text_of(bytes);
    let short: String = text.chars().take(40).flat_map(char::escape_default).collect();
    format!("'{short}{}'", if text.chars().count() > 40 { "…" } else { "" })
}

/// "1 face", "2 faces".
pub(crate) fn counted(n: usize, one: &str) -> String {
    let many = match one {
        "vertex" => "vertices".to_string(),
        _ => format!("{one}s"),
    };
    format!("{n} {}", if n == 1 { one } else { &many })
}

/// Appends numbers in the shortest form that reads back as the same bits.
pub(crate) struct NumberWriter {
    buffer: zmij::Buffer,
    whole: itoa::Buffer,
    single: bool,
}

impl NumberWriter {
    /// With `single`, numbers are rounded to 32 bits first.
    pub(crate) fn new(single: bool) -> Self {
        Self { buffer: zmij::Buffer::new(), whole: itoa::Buffer::new(), single }
    }

    pub(crate) fn write(&mut self, out: &mut Vec<u8>, value: f64) {
        if !value.is_finite() {
            let word = match value {
                v if v.is_nan() => "nan",
                v if v > 0.0 => "inf",
                _ => "-inf",
            };
            out.extend_from_slice(word.as_bytes());
            return;
        }
        let text = if self.single && (value as f32).is_finite() {
            self.buffer.format_finite(value as f32)
        } else {
            self.buffer.format_finite(value)
        };
        out.extend_from_slice(text.strip_suffix(".0").unwrap_or(text).as_bytes());
    }

    /// Appends numbers with a blank before each.
    pub(crate) fn write_all(&mut self, out: &mut Vec<u8>, values: &[f64]) {
        for &value in values {
            out.push(b' ');
            self.write(out, value);
        }
    }

    /// Appends a whole number.
    pub(crate) fn whole(&mut self, out: &mut Vec<u8>, value: u64) {
        out.extend_from_slice(self.whole.format(value).as_bytes());
    }
}

/// Rows of text formatted at once.
pub(crate) const ROWS: usize = 1 << 14;

#[cfg(test)]
mod tests {
    use super::*;

    fn number(text: &str) -> Result<f64, String> {
        Scanner { bytes: text.as_bytes(), at: 0 }.number().map_err(|e| e.to_string())
    }

    #[test]
    fn numbers_are_read_in_every_usual_form() {
        for (text, value) in [
            ("1", 1.0),
            ("+1.5", 1.5),
            (".5", 0.5),
            ("-2.", -2.0),
            ("1e3 ", 1000.0),
            ("1E-3\n", 0.001),
            ("-Infinity", f64::NEG_INFINITY),
            ("1e999", f64::INFINITY),
            ("7#", 7.0),
        ] {
            assert_eq!(number(text), Ok(value), "{text}");
        }
        assert!(number("NaN").unwrap().is_nan());
        for text in ["", " 1", "1.#IND", "0,5", "zero", "1x", "nano", "--1", ".", "1e"] {
            assert!(number(text).is_err(), "{text}");
        }
        assert_eq!(number("0,5").unwrap_err(), "line 1: found '0,5'; expected a number");
    }

    #[test]
    fn lines_are_counted_with_any_line_end() {
        let text = Scanner { bytes: b"a\nb\r\nc\rd\n\ne", at: 0 };
        let line = |b| text.line_of(text.bytes.iter().position(|&x| x == b).unwrap());
        assert_eq!([b'a', b'b', b'c', b'd', b'e'].map(line), [1, 2, 3, 4, 6]);
        assert_eq!(text.line_of(1000), 6);
    }

    #[test]
    fn numbers_are_written_shortest() {
        let mut out = Vec::new();
        let mut writer = NumberWriter::new(false);
        writer.write_all(&mut out, &[1.0, -0.5, 0.1, 1e30, 5e-324, f64::NAN, f64::NEG_INFINITY]);
        assert_eq!(out, b" 1 -0.5 0.1 1e+30 5e-324 nan -inf");
        out.clear();
        NumberWriter::new(true).write_all(&mut out, &[f64::from(0.1_f32), 1e-7]);
        assert_eq!(out, b" 0.1 1e-7");
    }
}
