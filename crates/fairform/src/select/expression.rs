//! [`Expression`]: what a selection says, and its plainest form as text.

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::fmt;

use super::error::Place;
use super::pattern::Pattern;
use crate::Vec3;

/// A test, or several combined. Lists have at least two members and none of their own kind.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Expression {
    Test(Test),
    Not(Box<Expression>),
    And(Vec<Expression>),
    Or(Vec<Expression>),
}

/// What picks faces by itself.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Test {
    All,
    None,
    Boundary,
    Named(Naming, Vec<Pattern>),
    Numbered(Numbering, Vec<Range>),
    Axis { axis: usize, comparison: Comparison, bound: f64 },
    Plane { normal: Vec3, offset: f64 },
    Box([Vec3; 2]),
    Sphere { centre: Vec3, radius: f64 },
    Normal { direction: Vec3, degrees: f64 },
}

/// What has names.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Naming {
    Group,
    Material,
}

impl Naming {
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Group => "group",
            Self::Material => "material",
        }
    }
}

/// What has numbers.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Numbering {
    Face,
    Part,
    Corners,
}

impl Numbering {
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Face => "face",
            Self::Part => "part",
            Self::Corners => "corners",
        }
    }
}

/// Whole numbers from the first to the last, which is not below the first.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Range {
    pub(super) first: u32,
    /// `None` for no end.
    pub(super) last: Option<u32>,
    pub(super) place: Place,
}

impl Range {
    pub(super) fn contains(&self, number: u32) -> bool {
        self.first <= number && self.last.is_none_or(|last| number <= last)
    }
}

/// How a coordinate compares with a bound.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Comparison {
    Less,
    AtMost,
    Greater,
    AtLeast,
}

impl Comparison {
    pub(super) fn holds(self, coordinate: f64, bound: f64) -> bool {
        match self {
            Self::Less => coordinate < bound,
            Self::AtMost => coordinate <= bound,
            Self::Greater => coordinate > bound,
            Self::AtLeast => coordinate >= bound,
        }
    }

    fn sign(self) -> &'static str {
        match self {
            Self::Less => "<",
            Self::AtMost => "<=",
            Self::Greater => ">",
            Self::AtLeast => ">=",
        }
    }
}

impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let operand = |f: &mut fmt::Formatter<'_>, e: &Self, closed: bool| {
            if closed { write!(f, "({e})") } else { write!(f, "{e}") }
        };
        match self {
            Self::Test(test) => test.fmt(f),
            Self::Not(inner) => {
                f.write_str("not ")?;
                operand(f, inner, matches!(**inner, Self::And(_) | Self::Or(_)))
            }
            Self::And(terms) => {
                separated(f, terms, " and ", |f, e| operand(f, e, matches!(e, Self::Or(_))))
            }
            Self::Or(terms) => separated(f, terms, " or ", |f, e| operand(f, e, false)),
        }
    }
}

impl fmt::Display for Test {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All => f.write_str("all"),
            Self::None => f.write_str("none"),
            Self::Boundary => f.write_str("boundary"),
            Self::Named(naming, patterns) => {
                write!(f, "{}=", naming.word())?;
                separated(f, patterns, ",", |f, p| p.fmt(f))
            }
            Self::Numbered(numbering, ranges) => {
                write!(f, "{}=", numbering.word())?;
                separated(f, ranges, ",", |f, r| r.fmt(f))
            }
            Self::Axis { axis, comparison, bound } => {
                write!(f, "{}{}{}", ["x", "y", "z"][*axis], comparison.sign(), Number(*bound))
            }
            Self::Plane { normal, offset } => {
                write!(f, "plane={},{}", Triple(*normal), Number(*offset))
            }
            Self::Box([a, b]) => write!(f, "box={}..{}", Triple(*a), Triple(*b)),
            Self::Sphere { centre, radius } => {
                write!(f, "sphere={},{}", Triple(*centre), Number(*radius))
            }
            Self::Normal { direction, degrees } => {
                write!(f, "normal={},{}", Triple(*direction), Number(*degrees))
            }
        }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.last {
            None => write!(f, "{}..", self.first),
            Some(last) if last == self.first => last.fmt(f),
            Some(last) => write!(f, "{}..{last}", self.first),
        }
    }
}

fn separated<T>(
    f: &mut fmt::Formatter<'_>,
    list: &[T],
    separator: &str,
    write: impl Fn(&mut fmt::Formatter<'_>, &T) -> fmt::Result,
) -> fmt::Result {
    for (i, one) in list.iter().enumerate() {
        if i > 0 {
            f.write_str(separator)?;
        }
        write(f, one)?;
    }
    Ok(())
}

/// The shortest text that reads back as the number, with an exponent where it is far from one.
struct Number(f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.abs() {
            a if a == 0.0 || (1e-5..1e15).contains(&a) => write!(f, "{}", self.0),
            _ => write!(f, "{:e}", self.0),
        }
    }
}

struct Triple(Vec3);

impl fmt::Display for Triple {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{}", Number(self.0.x), Number(self.0.y), Number(self.0.z))
    }
}
