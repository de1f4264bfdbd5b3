//! Maps between the sphere and its tangent planes, and spherical means.

use crate::Vec3;

use super::blend::{axis_angle, conventional_axis};
use super::error::Error;

/// The tangent vector at `p` that points to `x` along their great circle and is as long as the arc.
/// For the opposite point, of length $`\pi`$ in the direction that [`blend`](super::blend()) takes.
#[must_use]
pub fn log(p: Vec3, x: Vec3) -> Vec3 {
    let (axis, theta) = axis_angle(p, x);
    theta * axis.cross(p)
}

/// The point to which the tangent vector `v` at `p` leads: $`\exp_p(\log_p x) = x`$.
#[must_use]
pub fn exp(p: Vec3, v: Vec3) -> Vec3 {
    let length = v.length();
    if length == 0.0 {
        return p;
    }
    (libm::cos(length) * p + libm::sin(length) / length * v).normalized()
}

/// The spherical mean of directions: where the sum of the logarithms vanishes. Unique if all lie in
/// an open half-sphere; otherwise the one that the iteration finds from the normalised sum. `None` of
/// nothing.
#[must_use]
pub fn mean(tangents: &[Vec3]) -> Option<Vec3> {
    let each = 1.0 / tangents.len() as f64;
    fixed_point(tangents.len(), |i| (each, tangents[i]))
}

/// The spherical mean with weights, whose sum is one; some may be negative.
///
/// # Errors
/// [`Error::WrongCount`] if there is not one coefficient per direction, or none at all.
pub fn weighted_mean(coefficients: &[f64], tangents: &[Vec3]) -> Result<Vec3, Error> {
    let wrong = Error::WrongCount {
        what: "coefficients, one per tangent",
        expected: tangents.len().max(1),
        count: coefficients.len(),
    };
    if coefficients.len() != tangents.len() {
        return Err(wrong);
    }
    fixed_point(tangents.len(), |i| (coefficients[i], tangents[i])).ok_or(wrong)
}

/// Iterates $`m \leftarrow \exp_m \sum c_i \log_m t_i`$ until the step is below 1e-15.
fn fixed_point(count: usize, term: impl Fn(usize) -> (f64, Vec3)) -> Option<Vec3> {
    const MOST: u32 = 200;
    let terms = || (0..count).map(&term);
    let first = terms().next()?.1;
    let sum: Vec3 = terms().map(|(c, t)| c * t).sum();
    let mut m = if sum.length() > 1e-12 { sum.normalized() } else { conventional_axis(first) };
    for _ in 0..MOST {
        let step: Vec3 = terms().map(|(c, t)| c * log(m, t)).sum();
        m = exp(m, step);
        if step.length() < 1e-15 {
            break;
        }
    }
    Some(m)
}
