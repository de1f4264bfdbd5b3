//! [`Pattern`]: a name in which `*` and `?` stand for other characters.

use alloc::vec::Vec;
use core::fmt::{self, Write};

use super::error::Place;

/// What one place of a pattern matches.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Glyph {
    /// This character.
    Char(char),
    /// Any one character, written `?`.
    One,
    /// Any number of characters, written `*`.
    Many,
}

/// A name in which `*` and `?` stand for other characters.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Pattern {
    pub(super) glyphs: Vec<Glyph>,
    pub(super) place: Place,
}

/// Whether a character may be part of a name without quotes.
pub(super) fn is_bare(c: char) -> bool {
    !c.is_whitespace() && !c.is_control() && !r#"()&|!<>=,:\'""#.contains(c)
}

impl Pattern {
    /// Whether all of a name matches.
    pub(super) fn matches(&self, name: &str) -> bool {
        let mut rest = name.chars();
        let mut next = 0;
        // Behind the last `*`: the next glyph, and the shortest rest it has not tried yet.
        let mut retry = None;
        loop {
            let glyph = self.glyphs.get(next);
            if glyph == Some(&Glyph::Many) {
                next += 1;
                retry = Some((next, rest.clone()));
                continue;
            }
            let mut ahead = rest.clone();
            let fits = match (glyph, ahead.next()) {
                (None, None) => return true,
                (Some(Glyph::Char(wanted)), Some(c)) => *wanted == c,
                (Some(_), Some(_)) => true,
                _ => false,
            };
            if fits {
                next += 1;
                rest = ahead;
                continue;
            }
            // Earlier stars need not move: whatever they could skip, the last one can skip too.
            let Some((after, from)) = &mut retry else { return false };
            if from.next().is_none() {
                return false;
            }
            next = *after;
            rest = from.clone();
        }
    }
}

impl fmt::Display for Pattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_name(f, &self.glyphs)
    }
}

/// Writes a name, in quotes where it needs them.
fn write_name(f: &mut fmt::Formatter<'_>, glyphs: &[Glyph]) -> fmt::Result {
    let bare = |glyph: &Glyph| match *glyph {
        Glyph::Char('*' | '?') => false,
        Glyph::Char(c) => is_bare(c),
        Glyph::One | Glyph::Many => true,
    };
    let quoted = glyphs.is_empty() || !glyphs.iter().all(bare);
    if quoted {
        f.write_char('"')?;
    }
    for glyph in glyphs {
        match *glyph {
            Glyph::One => f.write_char('?')?,
            Glyph::Many => f.write_char('*')?,
            Glyph::Char(c) => {
                if matches!(c, '*' | '?' | '\\' | '"') {
                    f.write_char('\\')?;
                }
                f.write_char(c)?;
            }
        }
    }
    if quoted { f.write_char('"') } else { Ok(()) }
}

/// The first few names of a list, each as a pattern that matches it.
pub(super) struct Known<'a>(pub(super) &'a [&'a str]);

impl fmt::Display for Known<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const NAMES: usize = 6;
        const CHARACTERS: usize = 40;
        for (i, name) in self.0.iter().take(NAMES).enumerate() {
            if i > 0 {
                f.write_str(", ")?;
            }
            // A file may put anything into a name; only what can be typed is shown.
            let typed = |c: char| if c.is_control() { Glyph::One } else { Glyph::Char(c) };
            let mut glyphs: Vec<Glyph> = name.chars().take(CHARACTERS).map(typed).collect();
            if name.chars().nth(CHARACTERS).is_some() {
                glyphs.push(Glyph::Many);
            }
            write_name(f, &glyphs)?;
        }
        match self.0.len().saturating_sub(NAMES) {
            0 => Ok(()),
            1 => f.write_str(" or one other"),
            more => write!(f, " or one of {more} others"),
        }
    }
}
