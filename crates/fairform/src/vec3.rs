//! [`Vec3`]: a point or a direction.

use core::iter::Sum;
use core::ops::{Add, AddAssign, Div, Index, Mul, Neg, Sub, SubAssign};

/// A point or direction of space, or any other triple that is refined alike (a colour, say).
#[derive(Clone, Copy, PartialEq, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Vec3 {
    /// First coordinate.
    pub x: f64,
    /// Second coordinate.
    pub y: f64,
    /// Third coordinate.
    pub z: f64,
}

impl Vec3 {
    /// The origin.
    pub const ZERO: Self = Self::new(0.0, 0.0, 0.0);

    /// A vector from its coordinates.
    #[must_use]
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self { x, y, z }
    }

    /// The vector with three equal coordinates.
    #[must_use]
    pub const fn splat(a: f64) -> Self {
        Self::new(a, a, a)
    }

    /// Scalar product.
    #[must_use]
    pub fn dot(self, b: Self) -> f64 {
        self.x * b.x + self.y * b.y + self.z * b.z
    }

    /// Vector product.
    #[must_use]
    pub fn cross(self, b: Self) -> Self {
        Self::new(
            self.y * b.z - self.z * b.y,
            self.z * b.x - self.x * b.z,
            self.x * b.y - self.y * b.x,
        )
    }

    /// Euclidean length, safe from overflow and underflow of the squares.
    #[must_use]
    pub fn length(self) -> f64 {
        let square = self.dot(self);
        if square > 1e-280 && square < 1e280 {
            return libm::sqrt(square);
        }
        let scale = self.max_abs();
        if scale == 0.0 || !scale.is_finite() {
            return scale;
        }
        let unit = self / scale;
        scale * libm::sqrt(unit.dot(unit))
    }

    /// The vector of length one in this direction; zero stays zero.
    #[must_use]
    pub fn normalized(self) -> Self {
        let scale = self.max_abs();
        if scale == 0.0 || !scale.is_finite() {
            return Self::ZERO;
        }
        let unit = self / scale;
        unit / libm::sqrt(unit.dot(unit))
    }

    /// Largest absolute coordinate; NaN where a coordinate is NaN.
    #[must_use]
    pub fn max_abs(self) -> f64 {
        if self.x.is_nan() || self.y.is_nan() || self.z.is_nan() {
            return f64::NAN;
        }
        self.x.abs().max(self.y.abs()).max(self.z.abs())
    }

    /// Coordinate-wise product.
    #[must_use]
    pub fn scale(self, b: Self) -> Self {
        Self::new(self.x * b.x, self.y * b.y, self.z * b.z)
    }

    /// Coordinate-wise minimum.
    #[must_use]
    pub fn min(self, b: Self) -> Self {
        Self::new(self.x.min(b.x), self.y.min(b.y), self.z.min(b.z))
    }

    /// Coordinate-wise maximum.
    #[must_use]
    pub fn max(self, b: Self) -> Self {
        Self::new(self.x.max(b.x), self.y.max(b.y), self.z.max(b.z))
    }

    /// Whether no coordinate is NaN or infinite.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.z.is_finite()
    }
}

impl Add for Vec3 {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self::new(self.x + b.x, self.y + b.y, self.z + b.z)
    }
}

impl AddAssign for Vec3 {
    fn add_assign(&mut self, b: Self) {
        *self = *self + b;
    }
}

impl Sub for Vec3 {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        Self::new(self.x - b.x, self.y - b.y, self.z - b.z)
    }
}

impl SubAssign for Vec3 {
    fn sub_assign(&mut self, b: Self) {
        *self = *self - b;
    }
}

impl Neg for Vec3 {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl Mul<Vec3> for f64 {
    type Output = Vec3;
    fn mul(self, v: Vec3) -> Vec3 {
        Vec3::new(self * v.x, self * v.y, self * v.z)
    }
}

impl Div<f64> for Vec3 {
    type Output = Self;
    fn div(self, a: f64) -> Self {
        Self::new(self.x / a, self.y / a, self.z / a)
    }
}

impl Sum for Vec3 {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::ZERO, Add::add)
    }
}

impl Index<usize> for Vec3 {
    type Output = f64;
    /// # Panics
    /// If `axis > 2`.
    fn index(&self, axis: usize) -> &f64 {
        match axis {
            0 => &self.x,
            1 => &self.y,
            2 => &self.z,
            _ => panic!("a Vec3 has axes 0, 1, 2, not {axis}"),
        }
    }
}

impl From<[f64; 3]> for Vec3 {
    fn from([x, y, z]: [f64; 3]) -> Self {
        Self::new(x, y, z)
    }
}

impl From<Vec3> for [f64; 3] {
    fn from(v: Vec3) -> Self {
        [v.x, v.y, v.z]
    }
}
