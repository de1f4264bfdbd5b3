//! What can go wrong with a model, by field, row and column.

use crate::sphere;

/// Why a model has no surface. Fields are named as in model files.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No tangents.
    #[error("tangents: there are none")]
    Empty,
    /// A tangent that is not of length one.
    #[error("tangents: row {row}, column {column} has length {length}; it must be 1")]
    NotUnit {
        /// Its row.
        row: usize,
        /// Its column.
        column: usize,
        /// Its length.
        length: f64,
    },
    /// A list of the wrong length.
    #[error("{field}: {count} {what}, not {expected}")]
    WrongCount {
        /// The field.
        field: &'static str,
        /// What the list holds.
        what: &'static str,
        /// How many there should be.
        expected: usize,
        /// How many there are.
        count: usize,
    },
    /// Parameters along a streamline that do not increase.
    #[error(
        "s: not increasing in row {row} at column {column}{}",
        if *level == 0 { "" } else {
            " of a refined grid; space the tangents more evenly, or lower w"
        }
    )]
    NotIncreasing {
        /// Refinement level; 0 is the model itself.
        level: u32,
        /// The row.
        row: usize,
        /// The column at which the parameter is not above the one before.
        column: usize,
    },
    /// Parameters of streamlines that do not increase.
    #[error("t: not increasing at number {index}")]
    TNotIncreasing {
        /// Which is not above the one before.
        index: usize,
    },
    /// A number that is out of range.
    #[error("{field}: must be {expected}, not {value}")]
    BadNumber {
        /// The field.
        field: &'static str,
        /// Its range in words.
        expected: &'static str,
        /// What was given.
        value: f64,
    },
    /// A parameter for which the initial curve or the length function is not defined.
    #[error("{field}: defined for t from {from} to {to}, but the model needs t = {t}")]
    OutsideCurve {
        /// The field.
        field: &'static str,
        /// First parameter of the curve.
        from: f64,
        /// Its last.
        to: f64,
        /// What is needed.
        t: f64,
    },
    /// A scheme that knows no tangents.
    #[error("scheme: {scheme} does not refine tangents; doo-sabin, catmull-clark and kobbelt do")]
    BadScheme {
        /// Its name.
        scheme: &'static str,
    },
    /// Closed ends, where `s` and `t` have no meaning.
    #[error("ends: a grid of streamlines is open; use natural or clamped")]
    Closed,
    /// A detail that is not in the grid of its level, or not a direction.
    #[error("details: number {index} {what}")]
    BadDetail {
        /// Which.
        index: usize,
        /// What is wrong.
        what: &'static str,
    },
    /// A place that the grid does not have.
    #[error("the grid of level {level} has no row {row} with a column {column}")]
    NoSuchPlace {
        /// The level.
        level: u32,
        /// The row asked for.
        row: usize,
        /// The column.
        column: usize,
    },
    /// Too many points.
    #[error("depth: {depth} makes more than {} points; use a smaller one", super::MAX_POINTS)]
    TooLarge {
        /// The depth asked for.
        depth: u32,
    },
    /// A scheme whose refined border is not the border of the model.
    #[error(
        "scheme: {scheme} with natural ends does not keep the streamlines at the border; patches \
         are stitched with clamped ends or Kobbelt's scheme"
    )]
    NotKept {
        /// Its name.
        scheme: &'static str,
    },
    /// A B-spline surface that does not come near enough.
    #[error("tolerance: not reached; the nearest B-spline surface deviates by {best:e}")]
    Tolerance {
        /// What was reached.
        best: f64,
    },
    /// Tangents that cannot be refined.
    #[error("{field}: {error}")]
    Sphere {
        /// The field.
        field: &'static str,
        /// What is wrong.
        error: sphere::Error,
    },
}

/// What is allowed, but may surprise.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// A four-point tension for which smoothness is not proved.
    #[error("a tension w of {w} may not be smooth; it should be above 0 and below 2.472")]
    Tension {
        /// The tension.
        w: f64,
    },
    /// Neighbours that point in opposite directions.
    #[error(
        "the tangents in row {}, column {} and row {}, column {} are opposite: any turn between \
         them is as good, so one is chosen", from[0], from[1], to[0], to[1]
    )]
    Antipodal {
        /// Row and column of the one.
        from: [usize; 2],
        /// And of the other.
        to: [usize; 2],
    },
}
