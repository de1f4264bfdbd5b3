//! [`Point`]: what points can be written as.

use crate::Vec3;

/// What points and normals can be written as: [`Vec3`], or `[f32; 3]`, each coordinate rounded to the
/// nearest.
pub trait Point: Copy + Send + Sync + From<Vec3> + sealed::Sealed {}

impl Point for Vec3 {}
impl Point for [f32; 3] {}

impl From<Vec3> for [f32; 3] {
    #[inline]
    fn from(p: Vec3) -> Self {
        [p.x as f32, p.y as f32, p.z as f32]
    }
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for crate::Vec3 {}
    impl Sealed for [f32; 3] {}
}
