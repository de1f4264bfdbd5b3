//! Gauss's quadrature of polynomial patches.

use alloc::vec::Vec;

use libm::{cos, fabs};

use crate::scheme::Scheme;

/// Points in each direction: exact up to degree 15. A regular patch needs degree 7; in a
/// characteristic map, where integrands are rational, the error is below any that one could see.
const COUNT: usize = 8;

/// The points and weights for the domain of a patch: a triangle for Loop, otherwise the unit square.
pub(super) fn points(scheme: Scheme) -> Vec<([f64; 2], f64)> {
    let rule = rule();
    let mut points = Vec::with_capacity(COUNT * COUNT);
    for (u, a) in rule {
        for (v, b) in rule {
            points.push(match scheme {
                // The square with one side shrunk to a corner.
                Scheme::Loop | Scheme::Butterfly => ([u, (1.0 - u) * v], (1.0 - u) * a * b),
                _ => ([u, v], a * b),
            });
        }
    }
    points
}

/// The points and weights of the Gauss–Legendre rule on $`[0, 1]`$: the zeros of the Legendre
/// polynomial $`P_n`$, by Newton's method, and $`2 / ((1 - x^2) P_n'(x)^2)`$.
fn rule() -> [(f64, f64); COUNT] {
    let n = COUNT as f64;
    core::array::from_fn(|i| {
        let mut x = cos(core::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5));
        loop {
            let (p, slope) = legendre(x);
            x -= p / slope;
            if fabs(p / slope) < 1e-15 {
                return (f64::midpoint(1.0, x), 1.0 / ((1.0 - x * x) * slope * slope));
            }
        }
    })
}

/// $`P_n`$ and its derivative.
fn legendre(x: f64) -> (f64, f64) {
    let (mut before, mut p) = (1.0, x);
    for k in 2..=COUNT {
        let k = k as f64;
        (before, p) = (p, ((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k);
    }
    (p, COUNT as f64 * (before - x * p) / (1.0 - x * x))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// $`\int u^i v^j`$ is $`i! j! / (i + j + 2)!`$ over the triangle, $`1/((i+1)(j+1))`$ over the
    /// square.
    #[test]
    fn integrates_monomials_exactly() {
        let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
        let power = |x: f64, n: usize| core::iter::repeat_n(x, n).product::<f64>();
        for i in 0..=7 {
            for j in 0..=7 {
                let sum = |scheme| -> f64 {
                    points(scheme).iter().map(|([u, v], w)| w * power(*u, i) * power(*v, j)).sum()
                };
                let triangle = factorial(i) * factorial(j) / factorial(i + j + 2);
                assert!((sum(Scheme::Loop) - triangle).abs() < 1e-15, "triangle {i} {j}");
                let square = 1.0 / ((i + 1) * (j + 1)) as f64;
                assert!((sum(Scheme::CatmullClark) - square).abs() < 1e-14, "square {i} {j}");
            }
        }
    }
}
