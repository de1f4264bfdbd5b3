//! Points in registers: three coordinates and one lane that is not used.
#![expect(clippy::inline_always, reason = "loops are as fast as their bodies are inlined")]

/// A value of the kernels: `[f32; 4]` for the iteration, `[f64; 4]` for what must be exact.
pub(super) trait Lane: Copy {
    /// Its coordinates.
    type Real: Copy;

    const ZERO: Self;

    fn real(x: f64) -> Self::Real;

    fn plus(self, other: Self) -> Self;

    fn times(self, factor: Self::Real) -> Self;
}

impl Lane for [f32; 4] {
    type Real = f32;

    const ZERO: Self = [0.0; 4];

    #[inline(always)]
    fn plus(self, b: Self) -> Self {
        [self[0] + b[0], self[1] + b[1], self[2] + b[2], self[3] + b[3]]
    }

    #[inline(always)]
    fn real(x: f64) -> f32 {
        x as f32
    }

    #[inline(always)]
    fn times(self, a: f32) -> Self {
        [a * self[0], a * self[1], a * self[2], a * self[3]]
    }
}

impl Lane for [f64; 4] {
    type Real = f64;

    const ZERO: Self = [0.0; 4];

    #[inline(always)]
    fn plus(self, b: Self) -> Self {
        [self[0] + b[0], self[1] + b[1], self[2] + b[2], self[3] + b[3]]
    }

    #[inline(always)]
    fn real(x: f64) -> f64 {
        x
    }

    #[inline(always)]
    fn times(self, a: f64) -> Self {
        [a * self[0], a * self[1], a * self[2], a * self[3]]
    }
}

/// Values that `u16` index without looking, modulo their number.
pub(super) type Values<L, const N: usize> = [L; N];

/// A value for every index; the system hands out the memory as it is touched.
macro_rules! values {
    ($zero:expr, $count:expr) => {
        match alloc::vec![$zero; $count].into_boxed_slice().try_into() {
            Ok(values) => values,
            Err(_) => unreachable!("so many values"),
        }
    };
}
pub(super) use values;
