//! Unit-quaternion integral curves: B-splines of rotations, and the space curves they integrate to.

use alloc::vec::Vec;

use crate::{Vec3, bspline};

use super::blend::{axis_angle, rotated};
use super::error::Error;
use super::unit;

/// Where the knots of a B-spline lie.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Knots {
    /// As many equal ones at each end as the order: the curve begins at the first tangent and ends at
    /// the last.
    #[default]
    Clamped,
    /// Equally spaced everywhere; the ends are not reached.
    Uniform,
}

/// A curve of directions, a unit-quaternion B-spline in cumulative form,
///
/// ```math
/// t(u) = R_n(\tilde B_n(u)) \cdots R_1(\tilde B_1(u))\, t_0, \qquad
/// \tilde B_i(u) = \sum_{j \ge i} B_{j,k}(u),
/// ```
///
/// where $`R_i(b)`$ turns by $`b`$ times the angle from $`t_{i-1}`$ to $`t_i`$ about their common
/// axis, and the space curve $`P(u) = P_0 + L \int_0^u t`$ of length $`L`$. Not reversible: the
/// tangents in reverse give another curve. \[Miura2001, eq. 16 to 24, corrected\]
#[derive(Clone, PartialEq, Debug)]
pub struct QiCurve {
    tangents: Vec<Vec3>,
    /// Axis and angle from each tangent to the next.
    turns: Vec<(Vec3, f64)>,
    order: usize,
    knots: Vec<f64>,
}

impl QiCurve {
    /// The curve of some order (degree plus one) on control tangents, of which only the directions
    /// count.
    ///
    /// # Errors
    /// [`Error::TooFew`] for no tangents, [`Error::NotUnit`] for one that is zero or not finite,
    /// [`Error::BadNumber`] for an order below 1 or above the number of tangents.
    pub fn new(tangents: &[Vec3], order: usize, knots: Knots) -> Result<Self, Error> {
        let count = tangents.len();
        if count == 0 {
            return Err(Error::TooFew { rule: "QI", needed: 1, count });
        }
        if order < 1 || order > count {
            return Err(Error::BadNumber {
                what: "the order of a QI curve",
                expected: "from 1 to the number of tangents",
                value: order as f64,
            });
        }
        let mut tangents: Vec<Vec3> = tangents.iter().map(|t| t.normalized()).collect();
        unit(&mut tangents)?;
        let turns = tangents.windows(2).map(|pair| axis_angle(pair[0], pair[1])).collect();
        let n = count - 1;
        let spans = (n + 2 - order) as f64;
        let knot = |i: usize| {
            let place = (i as f64 + 1.0 - order as f64) / spans;
            match knots {
                Knots::Clamped => place.clamp(0.0, 1.0),
                Knots::Uniform => place,
            }
        };
        let knots = (0..=n + order).map(knot).collect();
        Ok(Self { tangents, turns, order, knots })
    }

    /// The tangent at a parameter in $`[0, 1]`$; beyond, that at the end.
    #[must_use]
    pub fn tangent(&self, u: f64) -> Vec3 {
        let u = u.clamp(0.0, 1.0);
        let span = self.span(u);
        self.tangent_in(span, u, &mut self.room())
    }

    /// For the functions that do not vanish in a span.
    fn room(&self) -> Vec<f64> {
        alloc::vec![0.0; self.order]
    }

    fn span(&self, u: f64) -> usize {
        bspline::span(&self.knots, self.order - 1, u)
    }

    /// With room for as many functions as the order.
    fn tangent_in(&self, span: usize, u: f64, basis: &mut [f64]) -> Vec3 {
        bspline::basis(&self.knots, span, u, basis);
        // B̃ is one before the order's reach, so that tangents are met there, and zero behind the span.
        let first = span + 1 - self.order;
        let mut t = self.tangents[first];
        for (i, &(axis, theta)) in (1..).zip(&self.turns[first..span]) {
            t = rotated(axis, basis[i..].iter().sum::<f64>() * theta, t);
        }
        t.normalized()
    }

    /// The points of the space curve of some length from `start`, and its tangents, at parameters in
    /// ascending order. The integral is exact up to rounding: Gauss rules within knot spans, which are
    /// cut where the tangent turns far.
    ///
    /// # Errors
    /// [`Error::BadNumber`] for a length that is not finite and positive, or a parameter that is not
    /// in $`[0, 1]`$ or below the one before.
    pub fn points(
        &self,
        length: f64,
        start: Vec3,
        parameters: &[f64],
    ) -> Result<(Vec<Vec3>, Vec<Vec3>), Error> {
        if !(length.is_finite() && length > 0.0) {
            let (what, expected) = ("the length of a QI curve", "finite and positive");
            return Err(Error::BadNumber { what, expected, value: length });
        }
        let mut basis = self.room();
        let (mut at, mut sum) = (0.0, Vec3::ZERO);
        let mut points = Vec::with_capacity(parameters.len());
        for &u in parameters {
            if !(u >= at && u <= 1.0) {
                let (what, expected) = ("a parameter of a QI curve", "in [0, 1] and ascending");
                return Err(Error::BadNumber { what, expected, value: u });
            }
            while at < u {
                let span = self.span(at);
                let end = u.min(self.knots[span + 1]);
                sum += self.integral(span, at, end, &mut basis);
                at = end;
            }
            points.push(start + length * sum);
        }
        Ok((points, parameters.iter().map(|&u| self.tangent(u)).collect()))
    }

    fn integral(&self, span: usize, from: f64, to: f64, basis: &mut [f64]) -> Vec3 {
        // Largest turn in the span per Gauss rule; 16 points then are exact to rounding.
        const TURN: f64 = 0.5;
        let reach = &self.turns[(span + 1 - self.order)..span];
        let turn: f64 = reach.iter().map(|t| t.1).sum::<f64>() * self.order as f64;
        let share = (to - from) / (self.knots[span + 1] - self.knots[span]);
        let parts = libm::ceil(turn * share / TURN).max(1.0) as usize;
        let width = (to - from) / parts as f64;
        let mut sum = Vec3::ZERO;
        for part in 0..parts {
            let middle = from + (part as f64 + 0.5) * width;
            for (x, weight) in GAUSS {
                let half = 0.5 * width * x;
                let pair = self.tangent_in(span, middle - half, basis)
                    + self.tangent_in(span, middle + half, basis);
                sum += 0.5 * weight * width * pair;
            }
        }
        sum
    }
}

/// Positive points and weights of the Gauss–Legendre rule with 16 points on $`[-1, 1]`$.
const GAUSS: [(f64, f64); 8] = [
    (0.095_012_509_837_637_44, 0.189_450_610_455_068_5),
    (0.281_603_550_779_258_9, 0.182_603_415_044_923_6),
    (0.458_016_777_657_227_4, 0.169_156_519_395_002_54),
    (0.617_876_244_402_643_7, 0.149_595_988_816_576_74),
    (0.755_404_408_355_003, 0.124_628_971_255_533_87),
    (0.865_631_202_387_831_7, 0.095_158_511_682_492_78),
    (0.944_575_023_073_232_6, 0.062_253_523_938_647_894),
    (0.989_400_934_991_649_9, 0.027_152_459_411_754_095),
];
