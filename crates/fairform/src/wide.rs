//! The widest registers that the machine has, for loops over plain arrays.
//!
//! Products and sums are never fused into one rounding, and square roots are correctly rounded
//! everywhere, so the results are the same bits on every machine.

/// Runs a function compiled for the machine it is on. All that is to profit must be inlined into it.
#[cfg(feature = "simd")]
#[inline]
pub(crate) fn run<R>(f: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(f)
}

#[cfg(not(feature = "simd"))]
#[inline]
pub(crate) fn run<R>(f: impl FnOnce() -> R) -> R {
    f()
}

/// The square root, which compilers know how to take of many numbers at once.
#[cfg(feature = "simd")]
#[inline]
pub(crate) fn sqrt(x: f64) -> f64 {
    extern crate std;
    f64::sqrt(x)
}

#[cfg(not(feature = "simd"))]
#[inline]
pub(crate) fn sqrt(x: f64) -> f64 {
    libm::sqrt(x)
}
