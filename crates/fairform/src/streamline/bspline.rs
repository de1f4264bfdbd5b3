//! Streamline surfaces as B-spline surfaces, for other programs.

use alloc::vec::Vec;

use crate::{Vec3, par};

use super::initial::Bspline;
use super::{Error, Grid, Integration, Model, Surface};

/// A bicubic B-spline surface with clamped uniform knots on $`[0,1]^2`$: $`u`$ along the streamlines,
/// $`v`$ across.
#[derive(Clone, PartialEq, Debug)]
pub struct BsplineSurface {
    /// Control points; a row runs along the streamlines.
    pub points: Grid<Vec3>,
    /// Largest distance from the points of the refined surface to those with the same parameters.
    pub deviation: f64,
}

const DEGREE: usize = 3;

impl BsplineSurface {
    /// The surface within `tolerance`, the largest distance allowed, of the limit of a model, with as
    /// few control points as doubling their number finds. The model is refined until its own polygons
    /// are near enough to judge by.
    ///
    /// # Errors
    /// As [`Surface::new`]; [`Error::BadNumber`] for a tolerance that is not positive;
    /// [`Error::Tolerance`] if it is not reached with a thousand control points each way.
    pub fn fit(model: &Model, tolerance: f64) -> Result<Self, Error> {
        if !(tolerance.is_finite() && tolerance > 0.0) {
            let (field, expected) = ("tolerance", "finite and positive");
            return Err(Error::BadNumber { field, expected, value: tolerance });
        }
        let mut best = f64::INFINITY;
        let mut spans = [1, 1];
        let mut model = Model { integration: Integration::Arcs, ..model.clone() };
        let mut samples = Samples::of(&Surface::new(model.clone())?);
        loop {
            while samples.are_few(spans) {
                model.depth += 1;
                samples = match Surface::new(model.clone()) {
                    Ok(surface) => Samples::of(&surface),
                    Err(Error::TooLarge { .. }) => return Err(Error::Tolerance { best }),
                    Err(other) => return Err(other),
                };
            }
            let fit = samples.fit(spans);
            if fit.deviation <= tolerance {
                return Ok(fit);
            }
            best = best.min(fit.deviation);
            if spans[0].max(spans[1]) > 500 {
                return Err(Error::Tolerance { best });
            }
            // Where halving the spans helps, halve them.
            let finer = [[2 * spans[0], spans[1]], [spans[0], 2 * spans[1]]].map(|spans| {
                if samples.are_few(spans) { f64::INFINITY } else { samples.fit(spans).deviation }
            });
            let gain = finer.map(|f| f < 0.7 * fit.deviation);
            spans = match gain {
                [true, false] => [2 * spans[0], spans[1]],
                [false, true] => [spans[0], 2 * spans[1]],
                _ => spans.map(|s| 2 * s),
            };
        }
    }

    /// The knots in each direction, along and across.
    #[must_use]
    pub fn knots(&self) -> [Vec<f64>; 2] {
        [self.points.column_count(), self.points.row_count()]
            .map(|count| Bspline::new(DEGREE, count, None).into_knots())
    }

    /// The point at parameters in $`[0,1]^2`$; beyond, on the border.
    #[must_use]
    pub fn at(&self, u: f64, v: f64) -> Vec3 {
        let along = Bspline::new(DEGREE, self.points.column_count(), None);
        let across = Bspline::new(DEGREE, self.points.row_count(), None);
        let column: Vec<Vec3> = self.points.rows().map(|row| along.at(row, None, u)).collect();
        across.at(&column, None, v)
    }
}

/// Points of a refined surface with their parameters.
struct Samples {
    points: Grid<Vec3>,
    /// Fractions of the length, averaged over streamlines, and of the range of $`t`$.
    u: Vec<f64>,
    v: Vec<f64>,
}

impl Samples {
    fn of(surface: &Surface) -> Self {
        let (s, t) = (surface.s(), surface.t());
        let columns = s.column_count();
        let fraction = |list: &[f64], i: usize| {
            let (first, last) = (list[0], list[list.len() - 1]);
            if last > first { (list[i] - first) / (last - first) } else { 0.0 }
        };
        let mean =
            |i: usize| s.rows().map(|row| fraction(row, i)).sum::<f64>() / s.row_count() as f64;
        Self {
            points: surface.points().clone(),
            u: (0..columns).map(mean).collect(),
            v: (0..t.len()).map(|k| fraction(t, k)).collect(),
        }
    }

    /// Whether there are too few to judge a surface of so many spans: below four in each.
    fn are_few(&self, spans: [usize; 2]) -> bool {
        self.u.len() < 4 * spans[0] + DEGREE + 1 || self.v.len() < 4 * spans[1] + DEGREE + 1
    }

    fn fit(&self, [along, across]: [usize; 2]) -> BsplineSurface {
        let along = Fit::new(&self.u, along);
        let across = Fit::new(&self.v, across);
        let rows: Vec<Vec<Vec3>> = self.points.rows().map(|row| along.solve(row)).collect();
        let half = Grid::collected(rows).transposed();
        let columns: Vec<Vec<Vec3>> = half.rows().map(|column| across.solve(column)).collect();
        let points = Grid::collected(columns).transposed();
        let mut fit = BsplineSurface { points, deviation: 0.0 };
        fit.deviation = self.deviation(&fit, &along, &across);
        fit
    }

    fn deviation(&self, fit: &BsplineSurface, along: &Fit, across: &Fit) -> f64 {
        let rows: Vec<Vec<Vec3>> = fit.points.rows().map(|row| along.values(row)).collect();
        let half = Grid::collected(rows);
        let errors = par::collect(self.v.len(), |k| {
            let (first, weights) = &across.rows[k];
            let at = |i: usize| -> Vec3 {
                weights.iter().enumerate().map(|(j, &w)| w * half[(first + j, i)]).sum()
            };
            let row = self.points.row(k).iter().enumerate();
            row.map(|(i, p)| (at(i) - *p).length()).fold(0.0, f64::max)
        });
        errors.into_iter().fold(0.0, f64::max)
    }
}

/// Least squares by a cubic B-spline whose ends are those of the data.
struct Fit {
    count: usize,
    /// First basis function that does not vanish at each parameter, and the values of it and the
    /// next three.
    rows: Vec<(usize, [f64; DEGREE + 1])>,
    /// The Cholesky factor of the normal equations of the inner control points, by diagonals.
    factor: Vec<[f64; DEGREE + 1]>,
}

impl Fit {
    fn new(parameters: &[f64], spans: usize) -> Self {
        let count = spans + DEGREE;
        let curve = Bspline::new(DEGREE, count, None);
        let rows: Vec<_> = parameters.iter().map(|&u| curve.basis(u)).collect();
        let inner = count - 2;
        // Lower band: entry (i, d) couples control points i and i − d.
        let mut band = alloc::vec![[0.0; DEGREE + 1]; inner];
        for (first, weights) in &rows {
            for (j, &a) in weights.iter().enumerate() {
                for (k, &b) in weights[..=j].iter().enumerate() {
                    let (row, column) = (first + j, first + k);
                    if row >= 1 && row <= inner && column >= 1 {
                        band[row - 1][row - column] += a * b;
                    }
                }
            }
        }
        Self { count, rows, factor: cholesky(band) }
    }

    /// The curve at the parameters of the data.
    fn values(&self, control: &[Vec3]) -> Vec<Vec3> {
        let at = |(first, weights): &(usize, [f64; DEGREE + 1])| -> Vec3 {
            weights.iter().enumerate().map(|(j, &w)| w * control[first + j]).sum()
        };
        self.rows.iter().map(at).collect()
    }

    fn solve(&self, data: &[Vec3]) -> Vec<Vec3> {
        let mut control = alloc::vec![Vec3::ZERO; self.count];
        let last = self.count - 1;
        (control[0], control[last]) = (data[0], data[data.len() - 1]);
        let ends = self.values(&control);
        let mut right = alloc::vec![Vec3::ZERO; self.count];
        for (((first, weights), &p), &end) in self.rows.iter().zip(data).zip(&ends) {
            for (j, &w) in weights.iter().enumerate() {
                right[first + j] += w * (p - end);
            }
        }
        let inner = &mut right[1..last];
        for i in 0..inner.len() {
            for d in 1..=DEGREE.min(i) {
                let before = inner[i - d];
                inner[i] -= self.factor[i][d] * before;
            }
            inner[i] = inner[i] / self.factor[i][0];
        }
        for i in (0..inner.len()).rev() {
            for d in 1..=DEGREE.min(inner.len() - 1 - i) {
                let behind = inner[i + d];
                inner[i] -= self.factor[i + d][d] * behind;
            }
            inner[i] = inner[i] / self.factor[i][0];
        }
        control[1..last].copy_from_slice(inner);
        control
    }
}

/// Factors a positive definite band matrix in place; rows without data stay at one.
fn cholesky(mut band: Vec<[f64; DEGREE + 1]>) -> Vec<[f64; DEGREE + 1]> {
    for i in 0..band.len() {
        for d in (0..=DEGREE.min(i)).rev() {
            let j = i - d;
            let mut sum = band[i][d];
            for e in d + 1..=DEGREE.min(i) {
                if e - d <= DEGREE {
                    sum -= band[i][e] * band[j][e - d];
                }
            }
            band[i][d] = if d > 0 {
                sum / band[j][0]
            } else if sum > 0.0 {
                libm::sqrt(sum)
            } else {
                1.0
            };
        }
    }
    band
}
