//! Curves across the streamlines: where these begin, and how long they are.

use alloc::vec::Vec;

use crate::sphere::{Knots, QiCurve};
use crate::{Vec3, bspline};

use super::error::Error;
use super::increasing;

/// The curve from which streamlines are integrated, as a function of $`t`$.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum InitialCurve {
    /// Points at given parameters, with straight lines between.
    Polyline {
        /// The points.
        points: Vec<Vec3>,
        /// Their parameters, increasing.
        t: Vec<f64>,
    },
    /// A B-spline, rational if there are weights, on $`[t_0, t_1]`$.
    Bspline {
        /// Control points.
        points: Vec<Vec3>,
        /// A positive weight for each, or none.
        weights: Option<Vec<f64>>,
        /// Degree, from 1 to the number of points less one.
        degree: usize,
        /// Knots, not decreasing, as many as points, degree and one together; without, clamped and
        /// uniform. The range between the outer $`p+1`$ ones is mapped to $`[t_0, t_1]`$.
        knots: Option<Vec<f64>>,
        /// Parameter at its beginning.
        t0: f64,
        /// Parameter at its end.
        t1: f64,
    },
    /// A QI curve, see [`QiCurve`].
    Qi {
        /// Control tangents.
        tangents: Vec<Vec3>,
        /// Degree plus one.
        order: usize,
        /// Where its knots lie.
        knots: Knots,
        /// Its length.
        length: f64,
        /// Its first point.
        start: Vec3,
        /// Parameter at its beginning.
        t0: f64,
        /// Parameter at its end.
        t1: f64,
    },
}

/// How far beyond its ends a curve is still taken to be meant, relative to its range.
const SLACK: f64 = 1e-9;

fn covers(field: &'static str, from: f64, to: f64, t: &[f64]) -> Result<(), Error> {
    if !(from.is_finite() && to.is_finite() && from < to) {
        let expected = "finite and above the parameter at the beginning";
        return Err(Error::BadNumber { field, expected, value: to });
    }
    let slack = SLACK * (to - from);
    let outside = t.iter().find(|t| !(**t >= from - slack && **t <= to + slack));
    outside.map_or(Ok(()), |&t| Err(Error::OutsideCurve { field, from, to, t }))
}

fn one_each(
    field: &'static str,
    what: &'static str,
    expected: usize,
    count: usize,
) -> Result<(), Error> {
    if expected == count { Ok(()) } else { Err(Error::WrongCount { field, what, expected, count }) }
}

fn all_finite(field: &'static str, points: &[Vec3]) -> Result<(), Error> {
    let bad = points.iter().find(|p| !p.is_finite());
    let value = f64::NAN;
    bad.map_or(Ok(()), |_| Err(Error::BadNumber { field, expected: "finite points", value }))
}

impl InitialCurve {
    pub(super) fn check(&self, t: &[f64]) -> Result<(), Error> {
        match self {
            Self::Polyline { points, t: at } => {
                one_each("initial.t", "numbers, one per point", points.len(), at.len())?;
                all_finite("initial.points", points)?;
                polyline_covers("initial.t", at, t)
            }
            Self::Bspline { points, weights, degree, knots, t0, t1 } => {
                all_finite("initial.points", points)?;
                if let Some(weights) = weights {
                    let what = "numbers, one per point";
                    one_each("initial.weights", what, points.len(), weights.len())?;
                    let bad = weights.iter().find(|w| !(w.is_finite() && **w > 0.0));
                    if let Some(&value) = bad {
                        let (field, expected) = ("initial.weights", "finite and positive");
                        return Err(Error::BadNumber { field, expected, value });
                    }
                }
                bspline_check("initial", points.len(), *degree, knots.as_deref())?;
                covers("initial.t1", *t0, *t1, t)
            }
            Self::Qi { tangents, order, knots, length, start, t0, t1 } => {
                let field = "initial";
                let curve = QiCurve::new(tangents, *order, *knots)
                    .map_err(|error| Error::Sphere { field, error })?;
                curve
                    .points(*length, *start, &[])
                    .map_err(|error| Error::Sphere { field, error })?;
                all_finite("initial.start", &[*start])?;
                covers("initial.t1", *t0, *t1, t)
            }
        }
    }

    /// The first and the last parameter.
    ///
    /// # Panics
    /// If a polyline has no points.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        match self {
            Self::Polyline { t, .. } => [t[0], t[t.len() - 1]],
            Self::Bspline { t0, t1, .. } | Self::Qi { t0, t1, .. } => [*t0, *t1],
        }
    }

    /// The points at ascending parameters; before and behind the curve, its ends.
    ///
    /// # Errors
    /// As for models with such a curve.
    pub fn points(&self, parameters: &[f64]) -> Result<Vec<Vec3>, Error> {
        self.check(&[])?;
        Ok(match self {
            Self::Polyline { points, t } => {
                parameters.iter().map(|&x| polyline(t, points, x)).collect()
            }
            Self::Bspline { points, weights, degree, knots, t0, t1 } => {
                let curve = Bspline::new(*degree, points.len(), knots.as_deref());
                let at = |t: &f64| curve.at(points, weights.as_deref(), (t - t0) / (t1 - t0));
                parameters.iter().map(at).collect()
            }
            Self::Qi { tangents, order, knots, length, start, t0, t1 } => {
                let sphere = |error| Error::Sphere { field: "initial", error };
                let curve = QiCurve::new(tangents, *order, *knots).map_err(sphere)?;
                let u = |t: &f64| ((t - t0) / (t1 - t0)).clamp(0.0, 1.0);
                let u: Vec<f64> = parameters.iter().map(u).collect();
                curve.points(*length, *start, &u).map_err(sphere)?.0
            }
        })
    }
}

/// Length of the streamlines as a function of $`t`$.
#[derive(Clone, PartialEq, Debug)]
pub enum LengthFunction {
    /// Lengths at given parameters, linear between.
    Polyline {
        /// The lengths.
        lengths: Vec<f64>,
        /// Their parameters, increasing.
        t: Vec<f64>,
    },
    /// A clamped uniform B-spline on $`[t_0, t_1]`$.
    Bspline {
        /// Control values.
        lengths: Vec<f64>,
        /// Degree, from 1 to their number less one.
        degree: usize,
        /// Parameter at its beginning.
        t0: f64,
        /// Parameter at its end.
        t1: f64,
    },
}

impl LengthFunction {
    pub(super) fn check(&self, t: &[f64]) -> Result<(), Error> {
        let (Self::Polyline { lengths, .. } | Self::Bspline { lengths, .. }) = self;
        if let Some(&value) = lengths.iter().find(|l| !(l.is_finite() && **l > 0.0)) {
            let (field, expected) = ("length", "finite and positive everywhere");
            return Err(Error::BadNumber { field, expected, value });
        }
        match self {
            Self::Polyline { lengths, t: at } => {
                one_each("length.t", "numbers, one per length", lengths.len(), at.len())?;
                polyline_covers("length.t", at, t)
            }
            Self::Bspline { lengths, degree, t0, t1 } => {
                bspline_check("length", lengths.len(), *degree, None)?;
                covers("length.t1", *t0, *t1, t)
            }
        }
    }

    /// The length at each parameter.
    ///
    /// # Errors
    /// As for models with such a function.
    pub fn lengths(&self, parameters: &[f64]) -> Result<Vec<f64>, Error> {
        self.check(&[])?;
        let lifted =
            |list: &[f64]| -> Vec<Vec3> { list.iter().map(|&x| Vec3::new(x, 0.0, 0.0)).collect() };
        Ok(match self {
            Self::Polyline { lengths, t } => {
                let points = lifted(lengths);
                parameters.iter().map(|&x| polyline(t, &points, x).x).collect()
            }
            Self::Bspline { lengths, degree, t0, t1 } => {
                let points = lifted(lengths);
                let curve = Bspline::new(*degree, points.len(), None);
                let at = |t: &f64| curve.at(&points, None, (t - t0) / (t1 - t0)).x;
                parameters.iter().map(at).collect()
            }
        })
    }
}

fn polyline_covers(field: &'static str, at: &[f64], t: &[f64]) -> Result<(), Error> {
    if at.is_empty() {
        return Err(Error::WrongCount { field, what: "numbers", expected: 1, count: 0 });
    }
    if let Err(index) = increasing(at) {
        return Err(Error::BadNumber { field, expected: "increasing", value: at[index] });
    }
    if at.len() == 1 {
        let outside = t.iter().find(|t| **t != at[0]);
        let [from, to] = [at[0]; 2];
        return outside.map_or(Ok(()), |&t| Err(Error::OutsideCurve { field, from, to, t }));
    }
    covers(field, at[0], at[at.len() - 1], t)
}

fn polyline(t: &[f64], points: &[Vec3], x: f64) -> Vec3 {
    let last = points.len() - 1;
    if x <= t[0] {
        return points[0];
    }
    if x >= t[last] {
        return points[last];
    }
    let i = t.partition_point(|&t| t <= x) - 1;
    let u = (x - t[i]) / (t[i + 1] - t[i]);
    (1.0 - u) * points[i] + u * points[i + 1]
}

fn bspline_check(
    field: &'static str,
    count: usize,
    degree: usize,
    knots: Option<&[f64]>,
) -> Result<(), Error> {
    if degree < 1 || degree >= count {
        let expected = "from 1 to the number of points less one";
        let (field, value) =
            (if field == "length" { "length.degree" } else { "initial.degree" }, degree as f64);
        return Err(Error::BadNumber { field, expected, value });
    }
    let Some(knots) = knots else { return Ok(()) };
    let field = "initial.knots";
    one_each(field, "numbers, as many as points, degree and one", count + degree + 1, knots.len())?;
    let expected = "finite and not decreasing, with a range that is not empty";
    let bad =
        (0..knots.len()).find(|&i| !(knots[i].is_finite() && (i == 0 || knots[i] >= knots[i - 1])));
    if let Some(i) = bad {
        return Err(Error::BadNumber { field, expected, value: knots[i] });
    }
    if knots[degree] >= knots[count] {
        return Err(Error::BadNumber { field, expected, value: knots[count] });
    }
    Ok(())
}

/// Knots and degree, evaluated by de Boor's recurrence.
pub(super) struct Bspline {
    degree: usize,
    knots: Vec<f64>,
}

impl Bspline {
    /// Clamped and uniform on $`[0, 1]`$ unless there are knots.
    pub(super) fn new(degree: usize, count: usize, knots: Option<&[f64]>) -> Self {
        let spans = (count - degree) as f64;
        let uniform = |i: usize| ((i as f64 - degree as f64) / spans).clamp(0.0, 1.0);
        let knots =
            knots.map_or_else(|| (0..=count + degree).map(uniform).collect(), <[f64]>::to_vec);
        Self { degree, knots }
    }

    pub(super) fn into_knots(self) -> Vec<f64> {
        self.knots
    }

    /// The parameter at a fraction of the range, and the span in which it lies.
    fn place(&self, fraction: f64) -> (f64, usize) {
        let (p, count) = (self.degree, self.knots.len() - self.degree - 1);
        let (from, to) = (self.knots[p], self.knots[count]);
        let u = from + fraction.clamp(0.0, 1.0) * (to - from);
        (u, bspline::span(&self.knots, p, u))
    }

    /// The first cubic basis function that does not vanish at a fraction of the range, and the values
    /// of it and the next three.
    pub(super) fn basis(&self, fraction: f64) -> (usize, [f64; 4]) {
        debug_assert_eq!(self.degree, 3, "a cubic");
        let (u, span) = self.place(fraction);
        let mut basis = [0.0; 4];
        bspline::basis(&self.knots, span, u, &mut basis);
        (span - 3, basis)
    }

    /// The point at a fraction of the range; beyond, the end.
    pub(super) fn at(&self, points: &[Vec3], weights: Option<&[f64]>, fraction: f64) -> Vec3 {
        let p = self.degree;
        let (u, span) = self.place(fraction);
        let weight = |i: usize| weights.map_or(1.0, |w| w[i]);
        let homogeneous = |i: usize| (weight(i) * points[i], weight(i));
        let mut d: Vec<(Vec3, f64)> = (span - p..=span).map(homogeneous).collect();
        for r in 1..=p {
            for j in (r..=p).rev() {
                let (left, right) = (self.knots[j + span - p], self.knots[j + 1 + span - r]);
                let a = (u - left) / (right - left);
                d[j] = ((1.0 - a) * d[j - 1].0 + a * d[j].0, (1.0 - a) * d[j - 1].1 + a * d[j].1);
            }
        }
        d[p].0 / d[p].1
    }
}
