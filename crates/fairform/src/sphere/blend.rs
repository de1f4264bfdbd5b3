//! Two directions, blended along their great circle.

use crate::Vec3;

/// Directions whose vector product is shorter count as equal or opposite.
const PARALLEL: f64 = 1e-14;

/// Below this scalar product the sum of two directions says little of the plane between them.
const NEARLY_OPPOSITE: f64 = -0.9;

/// The blend $`(1-u)\,t_0 \oplus u\,t_1`$ of two directions: `t0` turned by $`u\,\theta`$ towards `t1`,
/// where $`\theta`$ is the angle between them; below 0 and above 1 it goes on along the same circle.
/// Commutative to the last bit if $`1 - u`$ is exact. \[Miura2001, eq. 26, with atan2\]
///
/// Opposite directions have no one circle: the axis then is $`t_0 \times e_m`$ with $`e_m`$ the
/// coordinate axis of the smallest coordinate of `t0` (the first of equals), which keeps the blend
/// commutative.
#[must_use]
pub fn blend(t0: Vec3, t1: Vec3, u: f64) -> Vec3 {
    weighted(1.0 - u, t0, u, t1)
}

/// [`blend`] by both coefficients, whose sum is one.
#[must_use]
pub fn weighted(c0: f64, t0: Vec3, c1: f64, t1: Vec3) -> Vec3 {
    if c0 == c1 {
        return midpoint(t0, t1);
    }
    if c0 == 0.75 && c1 == 0.25 {
        return midpoint(t0, midpoint(t0, t1));
    }
    if c0 == 0.25 && c1 == 0.75 {
        return midpoint(midpoint(t0, t1), t1);
    }
    if c0 == 0.0 {
        return t1;
    }
    if c1 == 0.0 || t0 == t1 {
        return t0;
    }
    general(c0, t0, c1, t1)
}

fn general(c0: f64, t0: Vec3, c1: f64, t1: Vec3) -> Vec3 {
    let cosine = t0.dot(t1);
    if cosine < NEARLY_OPPOSITE {
        // In an order of its own, so that the blend is commutative to the last bit.
        return if precedes(t0, t1) { turn(t0, t1, c1) } else { turn(t1, t0, c0) };
    }
    let sine = t0.cross(t1).length();
    if sine <= PARALLEL {
        return (c0 * t0 + c1 * t1).normalized();
    }
    let theta = libm::atan2(sine, cosine);
    (libm::sin(c0 * theta) * t0 + libm::sin(c1 * theta) * t1).normalized()
}

/// `t0`, turned by `u` times the angle to `t1`.
fn turn(t0: Vec3, t1: Vec3, u: f64) -> Vec3 {
    let (axis, theta) = axis_angle(t0, t1);
    if theta == 0.0 {
        return t0;
    }
    (libm::cos(u * theta) * t0 + libm::sin(u * theta) * axis.cross(t0)).normalized()
}

/// What becomes of `t` under the smallest rotation that takes `from` to `to`.
#[must_use]
pub fn carry(from: Vec3, to: Vec3, t: Vec3) -> Vec3 {
    let (axis, theta) = axis_angle(from, to);
    if theta == 0.0 {
        return t;
    }
    rotated(axis, theta, t).normalized()
}

/// A vector, turned about a unit axis by an angle.
#[must_use]
pub fn rotated(axis: Vec3, angle: f64, v: Vec3) -> Vec3 {
    let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
    cosine * v + sine * axis.cross(v) + (1.0 - cosine) * axis.dot(v) * axis
}

/// The direction with coordinate `axis` set to `value`, of which -1 to 1 counts, and the other two in the
/// same proportion, so that its length stays one. Of a direction along the axis, which has no such
/// proportion, the next coordinate takes what is left.
///
/// # Panics
/// If `axis > 2`.
#[must_use]
pub fn with_component(t: Vec3, axis: usize, value: f64) -> Vec3 {
    assert!(axis < 3, "a direction has axes 0, 1, 2, not {axis}");
    let value = value.clamp(-1.0, 1.0);
    let mut new = <[f64; 3]>::from(t);
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let (old, left) = (libm::hypot(new[i], new[j]), libm::sqrt((1.0 - value) * (1.0 + value)));
    new[axis] = value;
    if old > PARALLEL {
        new[i] *= left / old;
        new[j] *= left / old;
    } else {
        new[i] = left;
        new[j] = 0.0;
    }
    Vec3::from(new).normalized()
}

/// Unit axis and angle in $`[0, \pi]`$ of the rotation along the great circle from `t0` to `t1`.
pub(super) fn axis_angle(t0: Vec3, t1: Vec3) -> (Vec3, f64) {
    let (across, cosine) = (t0.cross(t1), t0.dot(t1));
    let sine = across.length();
    if sine > PARALLEL {
        (across / sine, libm::atan2(sine, cosine))
    } else if cosine > 0.0 {
        (Vec3::ZERO, 0.0)
    } else {
        (conventional_axis(t0), core::f64::consts::PI)
    }
}

/// The axis about which `t` is turned into its opposite: an odd function of `t`.
pub(super) fn conventional_axis(t: Vec3) -> Vec3 {
    let size = [t.x.abs(), t.y.abs(), t.z.abs()];
    let mut smallest = 0;
    for axis in 1..3 {
        if size[axis] < size[smallest] {
            smallest = axis;
        }
    }
    let unit = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 1.0)];
    t.cross(unit[smallest]).normalized()
}

fn precedes(a: Vec3, b: Vec3) -> bool {
    let key = |t: Vec3| [t.x, t.y, t.z];
    key(a).partial_cmp(&key(b)) == Some(core::cmp::Ordering::Less)
}

/// Whether two directions are opposite, so that their great circle is a matter of convention.
pub(super) fn is_antipodal(t0: Vec3, t1: Vec3) -> bool {
    t0.dot(t1) < 0.0 && t0.cross(t1).length() <= PARALLEL
}

/// The angle between two directions, in $`[0, \pi]`$.
#[must_use]
pub fn angle(t0: Vec3, t1: Vec3) -> f64 {
    libm::atan2(t0.cross(t1).length(), t0.dot(t1))
}

/// The direction halfway between two: their sum, scaled. Needs no trigonometry.
#[inline]
#[must_use]
pub fn midpoint(t0: Vec3, t1: Vec3) -> Vec3 {
    if t0 == t1 {
        return t0;
    }
    let sum = t0 + t1;
    let square = sum.dot(sum);
    if square > 2.0 + 2.0 * NEARLY_OPPOSITE {
        return sum / libm::sqrt(square);
    }
    if precedes(t0, t1) { turn(t0, t1, 0.5) } else { turn(t1, t0, 0.5) }
}

/// Blends with the same two coefficients, often: for nearby directions a series instead of roots or
/// trigonometry, which also keeps the length,
///
/// ```math
/// \frac{\sin u\theta}{\sin\theta} = u\;{}_2F_1\bigl(1+u,\,1-u;\,\tfrac32;\,\sin^2\tfrac\theta2\bigr).
/// ```
#[derive(Clone, Copy, Debug)]
pub(super) struct FixedBlend {
    coefficients: [f64; 2],
    series: [[f64; TERMS]; 2],
}

/// Terms of the series.
const TERMS: usize = 22;

/// Up to which $`y = \sin^2(\theta/2)`$ so many terms, with the first one left out below rounding: angles
/// of 1, 2.8, 7, 20 and 47 degrees.
const REACH: [(usize, f64); 5] = [(4, 1e-4), (5, 6e-4), (7, 4e-3), (11, 0.03), (TERMS, 0.16)];

/// Beyond, for angles of 120 degrees, the two directions say too little of their plane to be added up.
const FARTHEST: f64 = 0.75;

/// Chaikin's coefficients.
pub(super) const QUARTER: FixedBlend = FixedBlend::new(0.75, 0.25);

impl FixedBlend {
    pub(super) const fn new(c0: f64, c1: f64) -> Self {
        Self { coefficients: [c0, c1], series: [series(c0), series(c1)] }
    }

    /// $`c_0\,t_0 \oplus c_1\,t_1`$ and $`c_1\,t_0 \oplus c_0\,t_1`$.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "the loops over nearby directions take half as long")]
    pub(super) fn both(&self, t0: Vec3, t1: Vec3) -> [Vec3; 2] {
        let y = quarter_square(t0, t1);
        if y > FARTHEST {
            // Taken apart, so that the usual case stays in registers.
            let [a, b] = self.far(t0, t1);
            return [Vec3::new(a.x, a.y, a.z), Vec3::new(b.x, b.y, b.z)];
        }
        let (w0, w1) =
            if y <= REACH[0].1 { self.weights::<{ REACH[0].0 }>(y) } else { self.wide_weights(y) };
        [w0 * t0 + w1 * t1, w1 * t0 + w0 * t1]
    }

    #[inline]
    fn weights<const N: usize>(&self, y: f64) -> (f64, f64) {
        (evaluate::<N>(&self.series[0], y), evaluate::<N>(&self.series[1], y))
    }

    #[inline(never)]
    fn wide_weights(&self, y: f64) -> (f64, f64) {
        if y <= REACH[1].1 {
            self.weights::<{ REACH[1].0 }>(y)
        } else if y <= REACH[2].1 {
            self.weights::<{ REACH[2].0 }>(y)
        } else if y <= REACH[3].1 {
            self.weights::<{ REACH[3].0 }>(y)
        } else if y <= REACH[4].1 {
            self.weights::<{ REACH[4].0 }>(y)
        } else {
            let theta = 2.0 * libm::atan2(libm::sqrt(y), libm::sqrt(1.0 - y));
            let [s0, s1] = self.coefficients.map(|c| libm::sin(c * theta));
            let sine = libm::sin(theta);
            (s0 / sine, s1 / sine)
        }
    }

    #[cold]
    fn far(&self, t0: Vec3, t1: Vec3) -> [Vec3; 2] {
        let [c0, c1] = self.coefficients;
        [weighted(c0, t0, c1, t1), weighted(c1, t0, c0, t1)]
    }
}

/// [`midpoint`] by the series for nearby directions.
#[inline]
pub(super) fn half(t0: Vec3, t1: Vec3) -> Vec3 {
    const HALF: [f64; TERMS] = series(0.5);
    let y = quarter_square(t0, t1);
    if y > FARTHEST {
        let made = midpoint_apart(t0, t1);
        return Vec3::new(made.x, made.y, made.z);
    }
    let weight = if y <= REACH[0].1 {
        evaluate::<{ REACH[0].0 }>(&HALF, y)
    } else {
        0.5 / libm::sqrt(1.0 - y)
    };
    weight * (t0 + t1)
}

#[cold]
fn midpoint_apart(t0: Vec3, t1: Vec3) -> Vec3 {
    midpoint(t0, t1)
}

/// $`\sin^2(\theta/2)`$.
#[inline]
fn quarter_square(t0: Vec3, t1: Vec3) -> f64 {
    let apart = t1 - t0;
    0.25 * apart.dot(apart)
}

#[inline]
fn evaluate<const N: usize>(series: &[f64; TERMS], y: f64) -> f64 {
    let mut sum = series[N - 1];
    for k in (0..N - 1).rev() {
        sum = sum * y + series[k];
    }
    sum
}

const fn series(u: f64) -> [f64; TERMS] {
    let mut coefficients = [u; TERMS];
    let mut k = 0;
    while k < TERMS - 1 {
        let n = k as f64;
        let ratio = (1.0 + u + n) * (1.0 - u + n) / ((1.5 + n) * (1.0 + n));
        coefficients[k + 1] = coefficients[k] * ratio;
        k += 1;
    }
    coefficients
}
