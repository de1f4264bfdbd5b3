//! Doo and Sabin's scheme for polygon meshes, and its first phase with a shape parameter per face.
//!
//! Pure functions from face size to weights; nothing here knows a mesh.

use core::f64::consts::PI;

use libm::cos;

/// Weight of the corner `distance` steps away in the image of a corner of a face with `f` corners:
///
/// ```math
/// \alpha_{ii} = \frac{f+5}{4f}, \qquad \alpha_{ij} = \frac{3 + 2\cos(2\pi(i-j)/f)}{4f}
/// ```
///
/// A quadrilateral has $`9/16, 3/16, 1/16, 3/16`$. \[DooSabin1978\]
///
/// # Panics
/// If `f` is zero.
#[must_use]
pub fn image_weight(f: u32, distance: u32) -> f64 {
    assert!(f > 0, "a face has corners");
    let size = f64::from(f);
    if distance.is_multiple_of(f) {
        return (size + 5.0) / (4.0 * size);
    }
    (3.0 + 2.0 * cos(2.0 * PI * f64::from(distance) / size)) / (4.0 * size)
}

/// Weights in the image of a corner in phase one of the two-phase scheme, of the corner itself and
/// of each other corner of its face with `f` corners:
///
/// ```math
/// V'_i = \lambda V_i + (1-\lambda) A
/// ```
///
/// with `A` the centroid. \[FanEtAl, eq. 1\]
#[must_use]
pub fn phase_one_weights(f: u32, lambda: f64) -> [f64; 2] {
    let each = (1.0 - lambda) / f64::from(f);
    [lambda + each, each]
}

/// The parameter with which phase one on a boundary edge, a face of two corners, is a regular step:
/// Chaikin's 3/4, 1/4.
pub const CHAIKIN: f64 = 0.5;

/// Lower bound for the eigenvalues that a regular first step gives the limit operator: 1/4, attained
/// on closed 2-colourable quadrilateral meshes.
pub const SMALLEST_EIGENVALUE: f64 = 0.25;
