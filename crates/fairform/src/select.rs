//! [`Selection`]: the faces of a mesh that a short text describes, such as `group=lid and z>0.5`.
//!
//! # The language
//!
//! A *test* picks faces; `and`, `or`, `not` and parentheses combine tests.
//!
//! | Test | Picks the faces … |
//! |---|---|
//! | `all`, `none` | all of them, none of them |
//! | `group=lid` | of the group `lid` |
//! | `group=lid,rim*` | of the group `lid` and of all groups whose names begin with `rim` |
//! | `material="blue steel"` | of the material `blue steel` |
//! | `face=0..9,17` | number 0 to 9, and 17 |
//! | `part=0` | of the first connected part; parts are numbered by their lowest vertex |
//! | `corners=4`, `corners=5..` | with four corners, with five or more |
//! | `boundary` | with an edge on the boundary |
//! | `z>0.5`, `x<=-1` | with their centre in that half of space; also `>=`, `<`, and `y` |
//! | `plane=1,1,0,2` | with their centre `p` where `n·p > d`: the numbers are `n` and `d` |
//! | `box=0,0,0..1,1,2` | with their centre in the box between two opposite corners |
//! | `sphere=0,0,1,0.5` | with their centre within 0.5 of the point `0,0,1` |
//! | `normal=0,0,1,30` | whose normal is within 30 degrees of the direction `0,0,1` |
//!
//! | Together | Picks the faces … | Binds |
//! |---|---|---|
//! | `not A`, `!A` | that `A` does not pick | most |
//! | `A and B`, `A & B` | that both pick | |
//! | `A or B`, <code>A \| B</code> | that at least one picks | least |
//! | `( A )` | that `A` picks | |
//!
//! So `not group=lid and z>0.5 or boundary` means `((not group=lid) and z>0.5) or boundary`.
//!
//! **Names.** `*` stands for any number of characters, `?` for one; upper and lower case differ. A
//! name with a space or one of `( ) & | ! < > = , : \ ' "` goes in quotes, single or double. Inside
//! quotes `\` takes the character behind it as it is: `\*`, `\?`, `\\`, `\"`, `\'`. The empty name
//! `""` is that of the faces before the first name of a file. A name that no group has is an error.
//!
//! **Numbers** of faces, parts and corners are those of the mesh, as in messages; faces and parts
//! count from 0. A range `a..b` has both its ends, and `a..` goes on to the last. Other numbers
//! look like `2`, `-0.5` or `1e-3`. A face or part that the mesh does not have is an error.
//!
//! **Geometry.** The *centre* of a face is the mean of its corners. Box and sphere have their
//! surface. The half-space of `plane` has not, and its normal need not have length one. An angle
//! goes from 0 to 180; a face without area has no normal and is picked by no `normal`.
//!
//! **In a shell** put the whole selection in single quotes, and names that need quotes in double
//! ones: `'material="blue steel"'`. Spaces between the pieces do not matter. Outside quotes the
//! language has no colon, and a number has none either, so `SELECTION:NUMBER` is cut at its last
//! colon: `'group=lid & z>0.5:0.85'`.
//!
//! ```
//! use fairform::select::{Context, Selection};
//! use fairform::shapes;
//!
//! let cube = shapes::cube();
//! let selection: Selection = "(z > 0) & !face=4..5".parse()?;
//! assert_eq!(selection.to_string(), "z>0 and not face=4..5");
//! assert_eq!(selection.faces(&Context::new(&cube))?, [false, true, true, true, false, false]);
//!
//! let error = "z > 0 and grope=lid".parse::<Selection>().unwrap_err();
//! assert_eq!((error.at, error.column), (10, 11));
//! assert_eq!(error.message, "there is no test `grope`");
//! # Ok::<(), fairform::select::SelectError>(())
//! ```
//!
//! # What to do with it
//!
//! [`grow`] and [`shrink`] move the rim of a selection; [`falloff`] turns it into weights that fade
//! along the surface, and [`blend`] applies a value with those weights.

mod error;
mod evaluate;
mod expression;
mod parse;
mod pattern;
mod spread;

use alloc::vec::Vec;
use core::fmt;
use core::str::FromStr;

use expression::Expression;

pub use error::SelectError;
pub use spread::{blend, falloff, grow, shrink};

use crate::Mesh;

/// A selection of faces that was read from text, for any mesh.
///
/// Shown, it takes its plainest form: words instead of signs, no needless parentheses or spaces.
/// That form reads back as an equal selection. Two selections are equal if they say the same in the
/// same order, wherever in the text they say it.
#[derive(Clone, PartialEq, Debug)]
pub struct Selection {
    expression: Expression,
}

impl Selection {
    /// Which faces of a mesh are selected.
    ///
    /// # Errors
    /// If a name matches no group or material, there is no face or part of some number, or the
    /// labels are not one per face.
    pub fn faces(&self, context: &Context<'_>) -> Result<Vec<bool>, SelectError> {
        evaluate::faces(&self.expression, context)
    }
}

impl FromStr for Selection {
    type Err = SelectError;

    /// Reads a selection in the language of [this module](self).
    ///
    /// # Errors
    /// Where the text leaves the language, a number is not finite, a radius is negative, a normal
    /// is zero, an angle is not between 0 and 180, or more than 64 parentheses and `not`s are open
    /// at once.
    fn from_str(text: &str) -> Result<Self, SelectError> {
        Ok(Self { expression: parse::parse(text)? })
    }
}

impl fmt::Display for Selection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.expression.fmt(f)
    }
}

/// A name per face, as mesh files give them.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Labels<'a> {
    /// The names, each once. Empty for faces before the first name.
    pub names: Vec<&'a str>,
    /// For each face an index into `names`; a face whose index is out of range has no name.
    pub of_face: &'a [u32],
}

impl<'a> Labels<'a> {
    /// Labels from any list of names.
    #[must_use]
    pub fn new<S: AsRef<str>>(names: &'a [S], of_face: &'a [u32]) -> Self {
        Self { names: names.iter().map(AsRef::as_ref).collect(), of_face }
    }
}

/// What a selection chooses from.
#[derive(Clone, Debug)]
pub struct Context<'a> {
    /// The mesh with the faces.
    pub mesh: &'a Mesh,
    /// The group of each face, if they have any.
    pub groups: Option<Labels<'a>>,
    /// The material of each face, if they have any.
    pub materials: Option<Labels<'a>>,
}

impl<'a> Context<'a> {
    /// A mesh without names.
    #[must_use]
    pub fn new(mesh: &'a Mesh) -> Self {
        Self { mesh, groups: None, materials: None }
    }
}
