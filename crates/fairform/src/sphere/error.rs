//! What can go wrong with directions.

/// Why directions could not be blended or refined.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A direction that is not of length one.
    #[error("tangent {index} has length {length}; it must be 1")]
    NotUnit {
        /// Which.
        index: usize,
        /// Its length, or NaN.
        length: f64,
    },
    /// Coefficients of one half that cancel, so that it has no direction.
    #[error("the coefficients of a half of the list cancel, so their combination has no direction")]
    Cancels,
    /// Fewer tangents than a rule needs.
    #[error("the {rule} rule needs at least {needed} tangents, not {count}")]
    TooFew {
        /// The rule with its ends.
        rule: &'static str,
        /// How many it needs.
        needed: usize,
        /// How many there are.
        count: usize,
    },
    /// A number that is out of range.
    #[error("{what} must be {expected}, not {value}")]
    BadNumber {
        /// What it is.
        what: &'static str,
        /// Its range in words.
        expected: &'static str,
        /// What was given.
        value: f64,
    },
    /// A list of the wrong length.
    #[error("expected {expected} {what}, not {count}")]
    WrongCount {
        /// What the list holds.
        what: &'static str,
        /// How many there should be.
        expected: usize,
        /// How many there are.
        count: usize,
    },
    /// The mesh or the scheme.
    #[error(transparent)]
    Mesh(#[from] crate::Error),
}
