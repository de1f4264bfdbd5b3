//! The unit of length that keeps every product within the range of `f64`.

use crate::Vec3;

/// A power of two as the unit of length, so that changing to it and back rounds nothing.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Unit(i32);

impl Unit {
    /// The unit in which the largest finite coordinate is below one.
    pub(super) fn of<'p>(points: impl IntoIterator<Item = &'p Vec3>) -> Self {
        let finite = points.into_iter().filter(|p| p.is_finite());
        let largest = finite.map(|p| p.max_abs()).fold(0.0, f64::max);
        Self(if largest > 0.0 { libm::frexp(largest).1 } else { 0 })
    }

    /// The point in this unit; NaN where a coordinate is not finite, which no test for being
    /// larger than something lets pass.
    pub(super) fn point(self, p: Vec3) -> Vec3 {
        if !p.is_finite() {
            return Vec3::splat(f64::NAN);
        }
        let shrink = |x: f64| libm::scalbn(x, -self.0);
        Vec3::new(shrink(p.x), shrink(p.y), shrink(p.z))
    }

    /// A quantity of dimension length to the `power`, in the caller's unit.
    pub(super) fn restore(self, x: f64, power: i32) -> f64 {
        finite(libm::scalbn(x, self.0 * power))
    }

    /// A quantity of dimension length to the `power`, in this unit.
    pub(super) fn convert(self, x: f64, power: i32) -> f64 {
        finite(libm::scalbn(x, -self.0 * power))
    }
}

/// The nearest finite number; zero for NaN.
pub(super) fn finite(x: f64) -> f64 {
    if x.is_nan() { 0.0 } else { x.clamp(-f64::MAX, f64::MAX) }
}
