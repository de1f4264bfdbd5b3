//! JSON as a tree, and the way down it, so that errors can name the field.

use std::fmt;

use fairform::Vec3;
use serde::de::{Deserialize, Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value};

use crate::error::{ParseError, Place};

/// A JSON value; at most some twenty bytes for each byte of text.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Node {
    Null,
    Flag(bool),
    Number(f64),
    Text(Box<str>),
    List(Vec<Node>),
    /// Each name once.
    Object(Vec<(Box<str>, Node)>),
}

/// The tree in a text.
pub(super) fn parse(bytes: &[u8]) -> Result<Node, ParseError> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    serde_json::from_slice(text).map_err(|e| {
        let message = e.to_string();
        let message = message.rsplit_once(" at line ").map_or(message.as_str(), |(m, _)| m);
        let place = Place::Character { line: e.line() as u64, column: e.column() as u64 };
        ParseError::new(place, message)
    })
}

impl<'de> Deserialize<'de> for Node {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Builder)
    }
}

struct Builder;

impl<'de> Visitor<'de> for Builder {
    type Value = Node;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_unit<E>(self) -> Result<Node, E> {
        Ok(Node::Null)
    }

    fn visit_bool<E>(self, flag: bool) -> Result<Node, E> {
        Ok(Node::Flag(flag))
    }

    fn visit_i64<E>(self, n: i64) -> Result<Node, E> {
        Ok(Node::Number(n as f64))
    }

    fn visit_u64<E>(self, n: u64) -> Result<Node, E> {
        Ok(Node::Number(n as f64))
    }

    fn visit_f64<E>(self, x: f64) -> Result<Node, E> {
        Ok(Node::Number(x))
    }

    fn visit_str<E>(self, text: &str) -> Result<Node, E> {
        Ok(Node::Text(text.into()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Node, A::Error> {
        let mut list = Vec::new();
        while let Some(item) = items.next_element()? {
            list.push(item);
        }
        list.shrink_to_fit();
        Ok(Node::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Node, A::Error> {
        let mut fields: Vec<(Box<str>, Node)> = Vec::new();
        while let Some(entry) = entries.next_entry()? {
            fields.push(entry);
        }
        fields.shrink_to_fit();
        let mut names: Vec<&str> = fields.iter().map(|f| &*f.0).collect();
        names.sort_unstable();
        match names.windows(2).find(|pair| pair[0] == pair[1]) {
            Some(pair) => {
                Err(A::Error::custom(format_args!("the field {} is there twice", cut(pair[0]))))
            }
            None => Ok(Node::Object(fields)),
        }
    }
}

impl Node {
    /// What it is, for errors.
    fn shown(&self) -> String {
        match self {
            Self::Null => "null".into(),
            Self::Flag(flag) => flag.to_string(),
            Self::Number(x) => x.to_string(),
            Self::Text(text) => format!("{:?}", cut(text)),
            Self::List(list) => format!("a list of {}", list.len()),
            Self::Object(_) => "an object".into(),
        }
    }

    /// How many values are in it, itself included.
    fn count(&self) -> usize {
        match self {
            Self::List(list) => list.iter().map(Self::count).sum::<usize>() + 1,
            Self::Object(fields) => fields.iter().map(|f| f.1.count()).sum::<usize>() + 1,
            _ => 1,
        }
    }

    fn value(&self) -> Value {
        match self {
            Self::Null => Value::Null,
            Self::Flag(flag) => Value::Bool(*flag),
            // Whole numbers as such, as far as they are exact.
            Self::Number(x) if x.trunc() == *x && x.abs() < 9e15 => {
                Value::Number(Number::from(*x as i64))
            }
            Self::Number(x) => Number::from_f64(*x).map_or(Value::Null, Value::Number),
            Self::Text(text) => Value::String(text.to_string()),
            Self::List(list) => Value::Array(list.iter().map(Self::value).collect()),
            Self::Object(fields) => {
                let fields = fields.iter().map(|(name, node)| (name.to_string(), node.value()));
                Value::Object(fields.collect::<Map<_, _>>())
            }
        }
    }
}

/// The beginning of a text that may be long.
fn cut(text: &str) -> String {
    const SHOWN: usize = 40;
    let mut short: String = text.chars().take(SHOWN).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}

/// A node and the way to it.
#[derive(Clone, Copy)]
pub(super) struct At<'a> {
    pub(super) node: &'a Node,
    way: Way<'a>,
}

#[derive(Clone, Copy)]
enum Way<'a> {
    Root,
    Field(&'a At<'a>, &'a str),
    Item(&'a At<'a>, usize),
}

impl fmt::Display for At<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.way {
            Way::Root => Ok(()),
            Way::Field(from, name) if matches!(from.way, Way::Root) => f.write_str(&cut(name)),
            Way::Field(from, name) => write!(f, "{from}.{}", cut(name)),
            Way::Item(from, index) => write!(f, "{from}[{index}]"),
        }
    }
}

type Read<T> = Result<T, ParseError>;

impl<'a> At<'a> {
    pub(super) fn root(node: &'a Node) -> Self {
        Self { node, way: Way::Root }
    }

    /// An error at this place.
    pub(super) fn error(&self, message: impl fmt::Display) -> ParseError {
        match self.way {
            Way::Root => ParseError::file(message.to_string()),
            _ => ParseError::file(format!("{self}: {message}")),
        }
    }

    /// The path of a field of this object.
    pub(super) fn path(&self, field: &str) -> String {
        let at = At { node: self.node, way: Way::Field(self, field) };
        at.to_string()
    }

    /// What comes before the name of a field of this object.
    pub(super) fn prefix(&self) -> String {
        match self.way {
            Way::Root => String::new(),
            _ => format!("{self}."),
        }
    }

    pub(super) fn not(&self, expected: impl Into<String>) -> ParseError {
        self.error(self.node.shown()).expected(expected)
    }

    /// The object here, whose fields must be among those known.
    pub(super) fn object(&'a self, known: &[&[&'static str]]) -> Read<Object<'a>> {
        let Node::Object(fields) = self.node else { return Err(self.not("an object {…}")) };
        let known = || known.iter().copied().flatten().copied();
        for (name, node) in fields {
            if !known().any(|k| k == &**name) {
                let at = Self { node, way: Way::Field(self, name) };
                let list = known().collect::<Vec<_>>().join(", ");
                return Err(match nearest(name, known()) {
                    Some(near) => at.error(format_args!("unknown field; did you mean {near}?")),
                    None => at.error(format_args!("unknown field; known are {list}")),
                });
            }
        }
        Ok(Object { at: self, fields })
    }

    /// A field of this, if it is an object that has it.
    pub(super) fn field(&'a self, name: &'a str) -> Option<Self> {
        let Node::Object(fields) = self.node else { return None };
        let (_, node) = fields.iter().find(|f| &*f.0 == name)?;
        Some(Self { node, way: Way::Field(self, name) })
    }

    /// A whole number of a range.
    pub(super) fn whole(&self, from: u32, to: u32) -> Read<u32> {
        match self.node {
            Node::Number(x) if x.trunc() == *x && (f64::from(from)..=f64::from(to)).contains(x) => {
                Ok(*x as u32)
            }
            _ => Err(self.not(format!("a whole number from {from} to {to}"))),
        }
    }

    /// One of some words, each with its meaning.
    pub(super) fn choice<T: Copy>(&self, words: &[(&str, T)]) -> Read<T> {
        let chosen = match self.node {
            Node::Text(text) => words.iter().find(|w| w.0 == &**text),
            _ => None,
        };
        chosen.map(|w| w.1).ok_or_else(|| {
            let words: Vec<_> = words.iter().map(|w| format!("\"{}\"", w.0)).collect();
            let (last, others) = words.split_last().expect("words to choose from");
            let separator = if others.is_empty() { "" } else { " or " };
            self.not(format!("{}{separator}{last}", others.join(", ")))
        })
    }

    pub(super) fn list<T>(&self, what: &str, item: impl Fn(&At) -> Read<T>) -> Read<Vec<T>> {
        let Node::List(list) = self.node else { return Err(self.not(format!("a list of {what}"))) };
        let at = |(i, node)| item(&At { node, way: Way::Item(self, i) });
        list.iter().enumerate().map(at).collect()
    }
}

pub(super) fn number(at: &At) -> Read<f64> {
    match at.node {
        Node::Number(x) => Ok(*x),
        _ => Err(at.not("a number")),
    }
}

pub(super) fn positive(at: &At) -> Read<f64> {
    number(at).ok().filter(|x| *x > 0.0).ok_or_else(|| at.not("a positive number"))
}

pub(super) fn flag(at: &At) -> Read<bool> {
    match at.node {
        Node::Flag(flag) => Ok(*flag),
        _ => Err(at.not("true or false")),
    }
}

pub(super) fn numbers(at: &At) -> Read<Vec<f64>> {
    at.list("numbers", number)
}

/// Three numbers.
pub(super) fn vector(at: &At) -> Read<Vec3> {
    match at.node {
        Node::List(list) if list.len() == 3 => {
            let numbers = numbers(at)?;
            Ok(Vec3::new(numbers[0], numbers[1], numbers[2]))
        }
        _ => Err(at.not("three numbers, [x, y, z]")),
    }
}

/// A vector whose length is one.
pub(super) fn unit(at: &At) -> Read<Vec3> {
    let vector = vector(at)?;
    let length = vector.length();
    if (length - 1.0).abs() <= fairform::sphere::UNIT_TOLERANCE {
        return Ok(vector);
    }
    let message = format!("a tangent of length {length}");
    Err(at.error(message).expected(match vector.normalized() {
        u if (u.length() - 1.0).abs() < 1e-9 => {
            format!("length 1, as [{}, {}, {}] has", u.x, u.y, u.z)
        }
        _ => "a direction of length 1".into(),
    }))
}

pub(super) fn points(at: &At) -> Read<Vec<Vec3>> {
    at.list("points [x, y, z]", vector)
}

/// An object as it is.
pub(super) fn kept(at: &At) -> Read<Value> {
    const MOST: usize = 100_000;
    if !matches!(at.node, Node::Object(_)) {
        return Err(at.not("an object {…}"));
    }
    if at.node.count() > MOST {
        return Err(at.error(format_args!("more than {MOST} values")));
    }
    Ok(at.node.value())
}

pub(super) fn text(at: &At) -> Read<String> {
    match at.node {
        Node::Text(text) => Ok(text.to_string()),
        _ => Err(at.not("text")),
    }
}

/// An object whose fields are all known.
pub(super) struct Object<'a> {
    pub(super) at: &'a At<'a>,
    fields: &'a [(Box<str>, Node)],
}

impl Object<'_> {
    /// A field, if it is there.
    pub(super) fn get<T>(&self, name: &str, read: impl Fn(&At) -> Read<T>) -> Read<Option<T>> {
        let field = self.fields.iter().find(|f| &*f.0 == name);
        field.map(|(_, node)| read(&At { node, way: Way::Field(self.at, name) })).transpose()
    }

    /// A field that must be there.
    pub(super) fn need<T>(&self, name: &str, read: impl Fn(&At) -> Read<T>) -> Read<T> {
        self.get(name, read)?.ok_or_else(|| self.at.error(format_args!("no field {name}")))
    }

    /// An error at a field.
    pub(super) fn error(&self, name: &str, message: impl fmt::Display) -> ParseError {
        ParseError::file(format!("{}: {message}", self.at.path(name)))
    }
}

/// The known name that is most like a mistyped one, if one is.
fn nearest(name: &str, known: impl Iterator<Item = &'static str>) -> Option<&'static str> {
    if name.len() > 40 {
        return None;
    }
    let likeness = |known: &'static str| (strsim::jaro_winkler(name, known), known);
    let best = known.map(likeness).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 > 0.75).then_some(best.1)
}
