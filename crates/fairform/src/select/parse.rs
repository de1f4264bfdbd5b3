//! From text to [`Expression`], by recursive descent: one function per line of the grammar.
//!
//! ```text
//! or    = and { ( "or" | "|" ) and }
//! and   = not { ( "and" | "&" ) not }
//! not   = ( "not" | "!" ) not | "(" or ")" | test
//! test  = "all" | "none" | "boundary"
//!       | ( "group" | "material" ) "=" name { "," name }
//!       | ( "face" | "part" | "corners" ) "=" range { "," range }
//!       | ( "x" | "y" | "z" ) ( "<" | "<=" | ">" | ">=" ) number
//!       | "box" "=" number "," number "," number ".." number "," number "," number
//!       | ( "plane" | "sphere" | "normal" ) "=" number "," number "," number "," number
//! range = digits [ ".." [ digits ] ]
//! ```

use alloc::boxed::Box;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use super::error::{Place, SelectError};
use super::expression::{Comparison, Expression, Naming, Numbering, Range, Test};
use super::pattern::{Glyph, Pattern, is_bare};
use crate::Vec3;

/// Most parentheses and `not`s open at once; bounds the stack.
const MAX_DEPTH: u32 = 64;

const A_TEST: &str = "a test: all, none, boundary, group=, material=, face=, part=, corners=, x<, \
    y<, z<, plane=, box=, sphere= or normal=";

type Result<T> = core::result::Result<T, SelectError>;

/// Reads a whole text.
pub(super) fn parse(text: &str) -> Result<Expression> {
    let mut parser = Parser { rest: text, place: Place { at: 0, column: 1 }, depth: 0 };
    let expression = parser.or()?;
    parser.skip_spaces();
    if parser.rest.is_empty() {
        Ok(expression)
    } else {
        Err(parser.unexpected("and, or, or the end"))
    }
}

struct Parser<'t> {
    /// The text from `place` on.
    rest: &'t str,
    place: Place,
    depth: u32,
}

impl<'t> Parser<'t> {
    fn or(&mut self) -> Result<Expression> {
        let mut terms = Vec::new();
        loop {
            match self.and()? {
                // Parentheses that change nothing leave no trace.
                Expression::Or(inner) => terms.extend(inner),
                other => terms.push(other),
            }
            if !self.eat_word("or") && !self.eat('|') {
                return Ok(one_or_many(terms, Expression::Or));
            }
        }
    }

    fn and(&mut self) -> Result<Expression> {
        let mut terms = Vec::new();
        loop {
            match self.not()? {
                Expression::And(inner) => terms.extend(inner),
                other => terms.push(other),
            }
            if !self.eat_word("and") && !self.eat('&') {
                return Ok(one_or_many(terms, Expression::And));
            }
        }
    }

    fn not(&mut self) -> Result<Expression> {
        self.skip_spaces();
        let start = self.place;
        if self.eat_word("not") || self.eat('!') {
            self.deeper(start)?;
            let inner = self.not()?;
            self.depth -= 1;
            return Ok(Expression::Not(Box::new(inner)));
        }
        if self.eat('(') {
            self.deeper(start)?;
            let inner = self.or()?;
            self.depth -= 1;
            if !self.eat(')') {
                let column = start.column;
                let expected = format!("and, or, or `)` for the parenthesis at column {column}");
                return Err(self.unexpected(&expected));
            }
            return Ok(inner);
        }
        self.test().map(Expression::Test)
    }

    fn deeper(&mut self, start: Place) -> Result<()> {
        self.depth += 1;
        if self.depth <= MAX_DEPTH {
            return Ok(());
        }
        let expected = format!("at most {MAX_DEPTH} parentheses and nots inside each other");
        Err(start.error("this is nested too deeply", expected))
    }

    fn test(&mut self) -> Result<Test> {
        self.skip_spaces();
        let word = self.word();
        let start = self.place;
        self.advance(word.len());
        match word {
            "all" => Ok(Test::All),
            "none" => Ok(Test::None),
            "boundary" => Ok(Test::Boundary),
            "group" => self.named(Naming::Group, "group=lid"),
            "material" => self.named(Naming::Material, "material=steel"),
            "face" => self.numbered(Numbering::Face, "face=0..9,17"),
            "part" => self.numbered(Numbering::Part, "part=0"),
            "corners" => self.numbered(Numbering::Corners, "corners=4"),
            "x" => self.axis(0, "x>0.5"),
            "y" => self.axis(1, "y>0.5"),
            "z" => self.axis(2, "z>0.5"),
            "plane" => self.plane(),
            "box" => self.cuboid(),
            "sphere" => self.sphere(),
            "normal" => self.normal(),
            "" => Err(self.unexpected(A_TEST)),
            _ => Err(start.error(format!("there is no test `{}`", short(word)), A_TEST)),
        }
    }

    fn named(&mut self, naming: Naming, form: &str) -> Result<Test> {
        self.need("=", form)?;
        let mut patterns = alloc::vec![self.name(form)?];
        while self.eat(',') {
            patterns.push(self.name(form)?);
        }
        Ok(Test::Named(naming, patterns))
    }

    fn name(&mut self, form: &str) -> Result<Pattern> {
        self.skip_spaces();
        let place = self.place;
        let glyphs = match self.rest.chars().next() {
            Some(quote @ ('"' | '\'')) => self.quoted(quote)?,
            Some(c) if is_bare(c) => {
                let end = self.rest.find(|c| !is_bare(c)).unwrap_or(self.rest.len());
                let glyphs = self.rest[..end].chars().map(glyph).collect();
                self.advance(end);
                glyphs
            }
            _ => return Err(self.unexpected(&format!("a name, as in {form}"))),
        };
        Ok(Pattern { glyphs, place })
    }

    fn quoted(&mut self, quote: char) -> Result<Vec<Glyph>> {
        let start = self.place;
        self.advance(1);
        let mut glyphs = Vec::new();
        loop {
            let place = self.place;
            match self.take() {
                None => {
                    let column = start.column;
                    let message = format!("the quote at column {column} has no end");
                    return Err(place.error(message, format!("`{quote}`")));
                }
                Some(c) if c == quote => return Ok(glyphs),
                Some('\\') => {
                    let Some(c @ ('*' | '?' | '\\' | '"' | '\'')) = self.take() else {
                        let expected = r#"*, ?, \, " or ' behind it, or \\ for itself"#;
                        return Err(place.error("a lone `\\`", expected));
                    };
                    glyphs.push(Glyph::Char(c));
                }
                Some(c) if c.is_control() => {
                    let message = format!("a control character `{}` in a name", c.escape_debug());
                    return Err(place.error(message, "? in its place"));
                }
                Some(c) => glyphs.push(glyph(c)),
            }
        }
    }

    fn numbered(&mut self, numbering: Numbering, form: &str) -> Result<Test> {
        self.need("=", form)?;
        let mut ranges = alloc::vec![self.range(form)?];
        while self.eat(',') {
            ranges.push(self.range(form)?);
        }
        Ok(Test::Numbered(numbering, ranges))
    }

    fn range(&mut self, form: &str) -> Result<Range> {
        let Some((first, place)) = self.whole()? else {
            return Err(self.unexpected(&format!("a whole number, as in {form}")));
        };
        self.skip_spaces();
        if !self.rest.starts_with("..") {
            return Ok(Range { first, last: Some(first), place });
        }
        self.advance(2);
        match self.whole()? {
            Some((last, at)) if last < first => {
                Err(at.error(format!("the range ends below its start, {first}"), "a larger number"))
            }
            last => Ok(Range { first, last: last.map(|(last, _)| last), place }),
        }
    }

    /// A whole number, if there is one.
    fn whole(&mut self) -> Result<Option<(u32, Place)>> {
        self.skip_spaces();
        let place = self.place;
        let length = digits(self.rest.as_bytes());
        let number = &self.rest[..length];
        self.advance(length);
        if number.is_empty() {
            return Ok(None);
        }
        match number.parse() {
            Ok(number) => Ok(Some((number, place))),
            Err(_) => Err(place.error("the number is too large", "a number below 4294967296")),
        }
    }

    fn axis(&mut self, axis: usize, form: &str) -> Result<Test> {
        self.skip_spaces();
        let signs = [
            ("<=", Comparison::AtMost),
            ("<", Comparison::Less),
            (">=", Comparison::AtLeast),
            (">", Comparison::Greater),
        ];
        let Some((sign, comparison)) = signs.into_iter().find(|s| self.rest.starts_with(s.0))
        else {
            return Err(self.unexpected(&format!("<, <=, > or >=, as in {form}")));
        };
        self.advance(sign.len());
        let (bound, _) = self.number(form)?;
        Ok(Test::Axis { axis, comparison, bound })
    }

    fn plane(&mut self) -> Result<Test> {
        let form = "plane=NX,NY,NZ,D";
        self.need("=", form)?;
        let normal = self.direction(form)?;
        self.need(",", form)?;
        let (offset, _) = self.number(form)?;
        Ok(Test::Plane { normal, offset })
    }

    fn cuboid(&mut self) -> Result<Test> {
        let form = "box=X,Y,Z..X,Y,Z";
        self.need("=", form)?;
        let (a, _) = self.triple(form)?;
        self.need("..", form)?;
        let (b, _) = self.triple(form)?;
        Ok(Test::Box([a, b]))
    }

    fn sphere(&mut self) -> Result<Test> {
        let form = "sphere=X,Y,Z,RADIUS";
        self.need("=", form)?;
        let (centre, _) = self.triple(form)?;
        self.need(",", form)?;
        match self.number(form)? {
            (radius, _) if radius >= 0.0 => Ok(Test::Sphere { centre, radius }),
            (_, place) => Err(place.error("the radius is negative", "a radius of 0 or more")),
        }
    }

    fn normal(&mut self) -> Result<Test> {
        let form = "normal=NX,NY,NZ,DEGREES";
        self.need("=", form)?;
        let direction = self.direction(form)?;
        self.need(",", form)?;
        match self.number(form)? {
            (degrees, _) if (0.0..=180.0).contains(&degrees) => {
                Ok(Test::Normal { direction, degrees })
            }
            (_, place) => {
                Err(place.error("the angle is out of range", "an angle from 0 to 180 degrees"))
            }
        }
    }

    fn direction(&mut self, form: &str) -> Result<Vec3> {
        match self.triple(form)? {
            (Vec3::ZERO, place) => {
                Err(place.error("the direction is zero", "a number that is not zero"))
            }
            (direction, _) => Ok(direction),
        }
    }

    fn triple(&mut self, form: &str) -> Result<(Vec3, Place)> {
        let (x, place) = self.number(form)?;
        self.need(",", form)?;
        let (y, _) = self.number(form)?;
        self.need(",", form)?;
        let (z, _) = self.number(form)?;
        Ok((Vec3::new(x, y, z), place))
    }

    fn number(&mut self, form: &str) -> Result<(f64, Place)> {
        self.skip_spaces();
        let place = self.place;
        let text = &self.rest[..number_length(self.rest.as_bytes())];
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => {
                self.advance(text.len());
                Ok((number, place))
            }
            Ok(_) => Err(place.error("the number is too large", "a number below 1.8e308")),
            Err(_) => Err(self.unexpected(&format!("a number, as in {form}"))),
        }
    }

    /// Steps over a sign that has to come next.
    fn need(&mut self, sign: &str, form: &str) -> Result<()> {
        self.skip_spaces();
        if self.rest.starts_with(sign) {
            self.advance(sign.len());
            return Ok(());
        }
        Err(self.unexpected(&format!("`{sign}`, as in {form}")))
    }

    /// Steps over a sign if it comes next.
    fn eat(&mut self, sign: char) -> bool {
        self.skip_spaces();
        let found = self.rest.starts_with(sign);
        if found {
            self.advance(sign.len_utf8());
        }
        found
    }

    /// Steps over a word if it, and no longer one, comes next.
    fn eat_word(&mut self, word: &str) -> bool {
        self.skip_spaces();
        let found = self.word() == word;
        if found {
            self.advance(word.len());
        }
        found
    }

    /// The letters that come next, and digits or `_` behind them.
    fn word(&self) -> &'t str {
        if !self.rest.starts_with(char::is_alphabetic) {
            return "";
        }
        let end = self.rest.find(|c: char| !c.is_alphanumeric() && c != '_');
        &self.rest[..end.unwrap_or(self.rest.len())]
    }

    fn take(&mut self) -> Option<char> {
        let c = self.rest.chars().next()?;
        self.advance(c.len_utf8());
        Some(c)
    }

    fn skip_spaces(&mut self) {
        self.advance(self.rest.len() - self.rest.trim_start().len());
    }

    fn advance(&mut self, bytes: usize) {
        let (passed, rest) = self.rest.split_at(bytes);
        self.place.at += bytes;
        self.place.column += passed.chars().count();
        self.rest = rest;
    }

    fn unexpected(&self, expected: &str) -> SelectError {
        let message = match (self.word(), self.rest.chars().next()) {
            (_, None) => String::from("the selection ends here"),
            ("", Some(c)) => format!("`{}` does not fit here", c.escape_debug()),
            (word, _) => format!("`{}` does not fit here", short(word)),
        };
        self.place.error(message, expected)
    }
}

fn one_or_many(
    mut terms: Vec<Expression>,
    many: impl Fn(Vec<Expression>) -> Expression,
) -> Expression {
    match (terms.pop(), terms.is_empty()) {
        (Some(one), true) => one,
        (last, _) => {
            terms.extend(last);
            many(terms)
        }
    }
}

fn glyph(c: char) -> Glyph {
    match c {
        '*' => Glyph::Many,
        '?' => Glyph::One,
        c => Glyph::Char(c),
    }
}

/// The beginning of a word, for messages.
fn short(word: &str) -> &str {
    word.char_indices().nth(24).map_or(word, |(end, _)| &word[..end])
}

/// How many digits a text begins with.
fn digits(text: &[u8]) -> usize {
    text.iter().take_while(|b| b.is_ascii_digit()).count()
}

/// How many bytes at the beginning of a text are a decimal number. In `0..1` it is `0`: two points
/// are a range.
fn number_length(text: &[u8]) -> usize {
    let sign = usize::from(matches!(text.first(), Some(b'+' | b'-')));
    let mut end = sign + digits(&text[sign..]);
    let mut count = end - sign;
    if text.get(end) == Some(&b'.') && text.get(end + 1) != Some(&b'.') {
        let fraction = digits(&text[end + 1..]);
        count += fraction;
        end += 1 + fraction;
    }
    if count == 0 {
        return 0;
    }
    if let Some(b'e' | b'E') = text.get(end) {
        let sign = usize::from(matches!(text.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits(&text[end + 1 + sign..]);
        if exponent > 0 {
            end += 1 + sign + exponent;
        }
    }
    end
}
