//! Streamline surfaces: tangents are designed, and points follow by integration.
//!
//! A [`Model`] holds a grid of unit tangents, row $`k`$ along the streamline at parameter $`t_k`$, with
//! their arc-length parameters $`s`$, and an initial curve across the streamlines. Subdivision on the
//! Gaussian sphere refines tangents and parameters; along each streamline the tangents are integrated
//! from the initial curve, forward and backward. So curvature is what one shapes, and every
//! streamline has exactly the length asked for. \[Miura2001\]
//!
//! ```
//! use fairform::Vec3;
//! use fairform::streamline::{Grid, InitialCurve, Model, Surface};
//!
//! // Three streamlines that rise and fall again.
//! let row = [Vec3::new(0.8, 0.0, 0.6), Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.8, 0.0, -0.6)];
//! let points = [0.0, 1.0, 2.0].map(|y| Vec3::new(0.0, y, 0.0)).to_vec();
//! let initial = InitialCurve::Polyline { points, t: vec![0.0, 1.0, 2.0] };
//! let model = Model {
//!     depth: 3,
//!     ..Model::new(Grid::from_rows(vec![row; 3]).unwrap(), &[4.0; 3], vec![0.0, 1.0, 2.0], initial)
//! };
//! let surface = Surface::new(model)?;
//! assert_eq!((surface.tangents().row_count(), surface.tangents().column_count()), (17, 17));
//! assert!((surface.length(8) - 4.0).abs() < 1e-14);
//! # Ok::<(), fairform::streamline::Error>(())
//! ```

use alloc::vec::Vec;

use crate::Vec3;
use crate::scheme::{Scheme, kobbelt};
use crate::sphere::{self, Blend, Ends, Rule};

mod bspline;
mod curvature;
mod curve;
mod error;
mod grid;
mod initial;
mod integrate;
mod normals;
mod stitch;
mod structure;
mod surface;
mod swap;

pub use bspline::BsplineSurface;
pub use curvature::{Curvature, curvature};
pub use curve::{Curve, RefinedCurve};
pub use error::{Error, Warning};
pub use grid::{Grid, Rect};
pub use initial::{InitialCurve, LengthFunction};
pub use stitch::{Joined, Seam, join, seam, stitch};
pub use surface::{Changed, Surface};
pub use swap::swap;

/// Most points that a refined model may have: memory for more is not what was meant.
pub const MAX_POINTS: u64 = 1 << 26;

/// Most refinement steps: some rules make no more of the fewest tangents that they take, however
/// often.
pub const MAX_DEPTH: u32 = 32;

/// In which direction tangents are refined first; the results differ at third order in the spread.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Order {
    /// Along the streamlines, then across.
    #[default]
    St,
    /// Across, then along.
    Ts,
}

/// Where on the streamlines the initial curve lies.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub enum Start {
    /// At their beginnings.
    #[default]
    Min,
    /// At their ends.
    Max,
    /// At a value of $`s`$; beyond the ends of a streamline, straight on along its end tangent.
    At(f64),
    /// At a fraction of each streamline.
    Fraction(f64),
}

/// How tangents are integrated to points.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Integration {
    /// Straight from the middle between two tangents to the next middle, with one point more than
    /// there are tangents; the polygon has the length of the streamline. As published.
    #[default]
    Midpoint,
    /// Circular arcs from tangent to tangent, each of its exact length; one point per tangent, on the
    /// curve.
    Arcs,
}

/// A tangent that was set at some level of refinement, and goes with the coarser ones: if these
/// turn the tangent predicted there, it is turned along by the smallest rotation that does so.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Detail {
    /// The level, from 1.
    pub level: u32,
    /// Row in the grid of that level.
    pub row: usize,
    /// Column in it.
    pub column: usize,
    /// What refinement gave there when the tangent was set.
    pub predicted: Vec3,
    /// What was set instead.
    pub tangent: Vec3,
}

/// A streamline surface as it is designed.
#[derive(Clone, PartialEq, Debug)]
pub struct Model {
    /// Unit tangents; a row is a streamline.
    pub tangents: Grid<Vec3>,
    /// Arc-length parameter of each tangent, increasing along rows.
    pub s: Grid<f64>,
    /// Parameter of each streamline, increasing.
    pub t: Vec<f64>,
    /// The curve across the streamlines from which they are integrated.
    pub initial: InitialCurve,
    /// Where on the streamlines it lies.
    pub start: Start,
    /// Lengths of the refined streamlines, if not those of `s`, which then give the spacing only.
    pub length: Option<LengthFunction>,
    /// Doo–Sabin (quadratic), Catmull–Clark (cubic) or Kobbelt (four-point).
    pub scheme: Scheme,
    /// Which direction comes first.
    pub order: Order,
    /// What happens at the borders of the grid; Kobbelt's scheme keeps them.
    pub ends: Ends,
    /// Tension of the four-point rule, 1 as published.
    pub w: f64,
    /// How several directions become one.
    pub blend: Blend,
    /// How tangents become points.
    pub integration: Integration,
    /// Tangents set at finer levels.
    pub details: Vec<Detail>,
    /// Refinement steps.
    pub depth: u32,
}

impl Model {
    /// A model with evenly spaced tangents on streamlines of the given lengths, starting at the
    /// initial curve, refined by Kobbelt's scheme, as published.
    #[must_use]
    pub fn new(tangents: Grid<Vec3>, lengths: &[f64], t: Vec<f64>, initial: InitialCurve) -> Self {
        let s = spaced(lengths, tangents.column_count());
        Self {
            tangents,
            s,
            t,
            initial,
            start: Start::Min,
            length: None,
            scheme: Scheme::Kobbelt,
            order: Order::St,
            ends: Ends::Natural,
            w: 1.0,
            blend: Blend::Pairs,
            integration: Integration::Midpoint,
            details: Vec::new(),
            depth: 0,
        }
    }

    /// The univariate rule of the scheme.
    ///
    /// # Errors
    /// [`Error::BadScheme`] for other schemes.
    pub fn rule(&self) -> Result<Rule, Error> {
        match self.scheme {
            Scheme::DooSabin => Ok(Rule::Chaikin),
            Scheme::CatmullClark => Ok(Rule::Cubic),
            Scheme::Kobbelt => Ok(Rule::FourPoint { w: self.w }),
            scheme => Err(Error::BadScheme { scheme: scheme.name() }),
        }
    }

    /// Whether the parts fit together.
    ///
    /// # Errors
    /// What does not, by field, row and column.
    pub fn check(&self) -> Result<(), Error> {
        self.rule()?;
        if self.depth > MAX_DEPTH {
            return Err(too_deep(self.depth));
        }
        let (rows, columns) = (self.tangents.row_count(), self.tangents.column_count());
        if rows == 0 || columns == 0 {
            return Err(Error::Empty);
        }
        if self.ends == Ends::Closed {
            return Err(Error::Closed);
        }
        let counts = [
            ("s", "rows", rows, self.s.row_count()),
            ("s", "numbers in each row", columns, self.s.column_count()),
            ("t", "numbers, one per row of tangents", rows, self.t.len()),
        ];
        for (field, what, expected, count) in counts {
            if expected != count {
                return Err(Error::WrongCount { field, what, expected, count });
            }
        }
        for row in 0..rows {
            for (column, t) in self.tangents.row(row).iter().enumerate() {
                let length = t.length();
                if !sphere::is_unit(length) {
                    return Err(Error::NotUnit { row, column, length });
                }
            }
            increasing(self.s.row(row)).map_err(|column| Error::NotIncreasing {
                level: 0,
                row,
                column,
            })?;
        }
        increasing(&self.t).map_err(|index| Error::TNotIncreasing { index })?;
        match self.start {
            Start::At(x) | Start::Fraction(x) if !x.is_finite() => {
                return Err(Error::BadNumber { field: "s0", expected: "finite", value: x });
            }
            _ => {}
        }
        self.initial.check(&self.t)?;
        self.length.as_ref().map_or(Ok(()), |length| length.check(&self.t))
    }

    /// What is allowed, but may surprise.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let smooth = self.w > 0.0 && self.w < kobbelt::SMOOTH_BELOW;
        if self.scheme == Scheme::Kobbelt && !smooth {
            warnings.push(Warning::Tension { w: self.w });
        }
        for row in 0..self.tangents.row_count() {
            let columns = sphere::antipodal_neighbours(self.tangents.row(row));
            let warning =
                |column| Warning::Antipodal { from: [row, column], to: [row, column + 1] };
            warnings.extend(columns.into_iter().map(warning));
        }
        for column in 0..self.tangents.column_count() {
            let across: Vec<Vec3> = self.tangents.column(column).copied().collect();
            let rows = sphere::antipodal_neighbours(&across);
            let warning = |row| Warning::Antipodal { from: [row, column], to: [row + 1, column] };
            warnings.extend(rows.into_iter().map(warning));
        }
        warnings
    }
}

fn too_deep(depth: u32) -> Error {
    Error::BadNumber { field: "depth", expected: "at most 32", value: f64::from(depth) }
}

/// The first place where a list does not increase, or is not finite.
fn increasing(list: &[f64]) -> Result<(), usize> {
    let bad = |i: &usize| !(list[*i].is_finite() && (*i == 0 || list[*i] > list[*i - 1]));
    (0..list.len()).find(bad).map_or(Ok(()), Err)
}

/// Rows of evenly spaced parameters from zero to each length.
#[must_use]
pub fn spaced(lengths: &[f64], columns: usize) -> Grid<f64> {
    let intervals = columns.saturating_sub(1).max(1) as f64;
    let row = |length: &f64| (0..columns).map(|i| length * i as f64 / intervals).collect();
    Grid::collected(lengths.iter().map(row).collect::<Vec<Vec<f64>>>())
}
