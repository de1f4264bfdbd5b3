//! From tangents to points along one streamline.

use crate::Vec3;
use crate::sphere::{blend, midpoint};

use super::{Integration, Start};

/// Number of points for so many tangents.
pub(super) fn point_count(rule: Integration, tangents: usize) -> usize {
    match rule {
        Integration::Midpoint => tangents + 1,
        Integration::Arcs => tangents,
    }
}

/// The points of a streamline that lies at `at` where `start` says.
///
/// With [`Integration::Midpoint`], tangents $`t_0 \dots t_n`$ at $`s_0 < \dots < s_n`$ give
///
/// ```math
/// p_{i+1} = p_i + (\sigma_{i+1} - \sigma_i)\,t_i, \qquad
/// \sigma_0 = s_0,\; \sigma_i = \tfrac12(s_{i-1} + s_i),\; \sigma_{n+1} = s_n.
/// ```
///
/// \[Miura2001, eq. 65\]
pub(super) fn streamline(
    rule: Integration,
    tangents: &[Vec3],
    s: &[f64],
    start: Start,
    at: Vec3,
    points: &mut [Vec3],
) {
    let last = tangents.len() - 1;
    let mut p = Vec3::ZERO;
    points[0] = p;
    match rule {
        Integration::Midpoint => {
            for i in 0..=last {
                p += (sigma(s, i + 1) - sigma(s, i)) * tangents[i];
                points[i + 1] = p;
            }
        }
        Integration::Arcs => {
            for i in 0..last {
                p += arc(tangents[i], tangents[i + 1], s[i + 1] - s[i], 1.0);
                points[i + 1] = p;
            }
        }
    }
    let (first, end) = (s[0], s[last]);
    let held = match start {
        Start::Min => Vec3::ZERO,
        Start::Max => points[points.len() - 1],
        Start::At(x) => place(rule, tangents, s, points, x),
        Start::Fraction(f) => place(rule, tangents, s, points, first + f * (end - first)),
    };
    let shift = at - held;
    points.iter_mut().for_each(|p| *p += shift);
    // To the bit where nothing was to be added up.
    match start {
        Start::Min => points[0] = at,
        Start::Max => points[points.len() - 1] = at,
        _ => {}
    }
}

/// Parameter of point `i` of the midpoint rule.
fn sigma(s: &[f64], i: usize) -> f64 {
    if i == 0 {
        s[0]
    } else if i == s.len() {
        s[s.len() - 1]
    } else {
        0.5 * (s[i - 1] + s[i])
    }
}

/// The chord of the first part `u` of a circular arc of some length that turns from `t0` to `t1`.
fn arc(t0: Vec3, t1: Vec3, length: f64, u: f64) -> Vec3 {
    if u == 0.0 {
        return Vec3::ZERO;
    }
    let direction = if u == 1.0 { midpoint(t0, t1) } else { blend(t0, t1, 0.5 * u) };
    // Half of the angle, from its sine to the quarter circle and from its cosine beyond.
    let half_sine = 0.5 * (t1 - t0).length();
    let half = libm::atan2(half_sine, 0.5 * (t0 + t1).length());
    let turned = u * half;
    let chord = if turned < 1e-8 { 1.0 } else { libm::sin(turned) / turned };
    u * length * chord * direction
}

/// The point at parameter `x`; beyond the ends, straight on.
fn place(rule: Integration, tangents: &[Vec3], s: &[f64], points: &[Vec3], x: f64) -> Vec3 {
    let last = tangents.len() - 1;
    if x <= s[0] {
        return points[0] + (x - s[0]) * tangents[0];
    }
    if x >= s[last] {
        return points[points.len() - 1] + (x - s[last]) * tangents[last];
    }
    match rule {
        Integration::Midpoint => {
            // Cell i runs from σ_i to σ_{i+1} along tangent i.
            let mut i = s.partition_point(|&s| s <= x) - 1;
            if x >= sigma(s, i + 1) {
                i += 1;
            }
            points[i] + (x - sigma(s, i)) * tangents[i]
        }
        Integration::Arcs => {
            let i = s.partition_point(|&s| s <= x) - 1;
            let length = s[i + 1] - s[i];
            points[i] + arc(tangents[i], tangents[i + 1], length, (x - s[i]) / length)
        }
    }
}
