//! One streamline by itself.

use alloc::vec::Vec;

use crate::Vec3;
use crate::sphere::{self, Blend, Ends, Rule, Step};

use super::integrate::{point_count, streamline};
use super::{Error, Integration, MAX_DEPTH, MAX_POINTS, Start, increasing};

/// A single streamline as it is designed: tangents, refined and integrated as those of a
/// [`Model`](super::Model) are.
#[derive(Clone, PartialEq, Debug)]
pub struct Curve {
    /// Unit tangents.
    pub tangents: Vec<Vec3>,
    /// Arc-length parameter of each, increasing; without, there are refined tangents only. Closed
    /// sequences have none.
    pub s: Option<Vec<f64>>,
    /// The subdivision rule.
    pub rule: Rule,
    /// What happens at its ends.
    pub ends: Ends,
    /// How several directions become one.
    pub blend: Blend,
    /// The place of [`at`](Self::at) on the curve.
    pub start: Start,
    /// The point there.
    pub at: Vec3,
    /// How tangents become points.
    pub integration: Integration,
    /// Refinement steps.
    pub depth: u32,
}

/// What a [`Curve`] becomes.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct RefinedCurve {
    /// The refined tangents.
    pub tangents: Vec<Vec3>,
    /// Their parameters; none without parameters.
    pub s: Vec<f64>,
    /// The points of the streamline; none without parameters.
    pub points: Vec<Vec3>,
}

impl Curve {
    /// Whether the parts fit together.
    ///
    /// # Errors
    /// What does not, by field; a tangent is in row 0.
    pub fn check(&self) -> Result<(), Error> {
        if self.tangents.is_empty() {
            return Err(Error::Empty);
        }
        if self.depth > MAX_DEPTH {
            return Err(super::too_deep(self.depth));
        }
        for (column, t) in self.tangents.iter().enumerate() {
            let length = t.length();
            if !sphere::is_unit(length) {
                return Err(Error::NotUnit { row: 0, column, length });
            }
        }
        if let Some(s) = &self.s {
            let (expected, count) = (self.tangents.len(), s.len());
            if expected != count {
                let (field, what) = ("s", "numbers, one per tangent");
                return Err(Error::WrongCount { field, what, expected, count });
            }
            if self.ends == Ends::Closed {
                return Err(Error::Closed);
            }
            increasing(s).map_err(|column| Error::NotIncreasing { level: 0, row: 0, column })?;
        }
        let place = match self.start {
            Start::At(x) | Start::Fraction(x) => x,
            Start::Min | Start::Max => 0.0,
        };
        for (field, value) in [("s0", place), ("start", self.at.x + self.at.y + self.at.z)] {
            if !value.is_finite() {
                return Err(Error::BadNumber { field, expected: "finite", value });
            }
        }
        Ok(())
    }

    /// Refines and integrates it.
    ///
    /// # Errors
    /// As [`check`](Self::check); [`Error::Sphere`] if there are too few tangents for the rule;
    /// [`Error::TooLarge`]; [`Error::NotIncreasing`] if refinement breaks the order of very uneven
    /// parameters.
    pub fn refine(&self) -> Result<RefinedCurve, Error> {
        self.check()?;
        let wrong = |error| Error::Sphere { field: "tangents", error };
        let mut tangents = self.tangents.clone();
        sphere::unit(&mut tangents).map_err(wrong)?;
        let mut s = self.s.clone().unwrap_or_default();
        for level in 1..=self.depth {
            let step = Step::new(self.rule, self.ends, tangents.len()).map_err(wrong)?;
            if step.refined_count() as u64 > MAX_POINTS {
                return Err(Error::TooLarge { depth: self.depth });
            }
            tangents = step.directions_by(&tangents, self.blend);
            if self.s.is_some() {
                s = step.numbers(&s);
                increasing(&s).map_err(|column| Error::NotIncreasing { level, row: 0, column })?;
            }
        }
        let mut points = Vec::new();
        if self.s.is_some() {
            points.resize(point_count(self.integration, tangents.len()), Vec3::ZERO);
            streamline(self.integration, &tangents, &s, self.start, self.at, &mut points);
        }
        Ok(RefinedCurve { tangents, s, points })
    }
}
