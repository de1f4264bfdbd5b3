//! Catmull and Clark's scheme for polygon meshes.
//!
//! Pure functions from valence to weights; nothing here knows a mesh.

use core::f64::consts::PI;

use libm::{cos, sin, sqrt};

/// Weights in the new position of an interior vertex with `n` faces: of the vertex itself, of each
/// neighbour along an edge, and of each face centroid.
///
/// ```math
/// V' = \frac{n-2}{n} V + \frac{1}{n^2} \sum E_i + \frac{1}{n^2} \sum c_i
/// ```
///
/// \[CatmullClark1978\]
///
/// # Panics
/// If `n` is zero.
#[must_use]
pub fn vertex_weights(n: u32) -> [f64; 3] {
    assert!(n > 0, "an interior vertex has faces");
    let n = f64::from(n);
    [(n - 2.0) / n, 1.0 / (n * n), 1.0 / (n * n)]
}

/// Weights in the limit position of an interior vertex with `n` faces of any size: of the vertex
/// itself, of each neighbour along an edge, and of each face centroid.
///
/// ```math
/// V^\infty = \frac{n(n-1) V + 2 \sum E_i + 4 \sum c_i}{n(n+5)}
/// ```
///
/// One refinement step composed with the limit mask for quadrilaterals. \[Halstead1993\]
///
/// # Panics
/// If `n` is zero.
#[must_use]
pub fn limit_weights(n: u32) -> [f64; 3] {
    assert!(n > 0, "an interior vertex has faces");
    let n = f64::from(n);
    let whole = n * (n + 5.0);
    [n * (n - 1.0) / whole, 2.0 / whole, 4.0 / whole]
}

/// Lower bound for the eigenvalues that interior vertices of valence `n` or more give the limit
/// operator, $`(n-3)/(n+5)`$: sharp on 2-colourable closed meshes of one valence. Zero for 3, where
/// the operator of a closed bipartite mesh is singular; negative for 2.
#[must_use]
pub fn smallest_eigenvalue_bound(n: u32) -> f64 {
    (f64::from(n) - 3.0) / (f64::from(n) + 5.0)
}

/// Lower bound for the eigenvalues of the limit operator on boundary and crease curves,
/// $`1/3`$: that of the cubic B-spline.
pub const CURVE_SMALLEST_EIGENVALUE: f64 = 1.0 / 3.0;

/// Weights of a curve vertex and of each of its two neighbours in its new position.
pub const CURVE_VERTEX: [f64; 2] = [0.75, 0.125];

/// Weights of a curve vertex and of each of its two neighbours in its limit position.
pub const CURVE_LIMIT: [f64; 2] = [2.0 / 3.0, 1.0 / 6.0];

/// Weights in the two tangents at an interior vertex with `n` quadrilaterals: of neighbour `i` along
/// an edge, and of the corner opposite in the face between neighbours `i` and `i + 1`.
///
/// ```math
/// t_1 = \sum_i A c_i E_i + (c_i + c_{i+1}) F_i, \quad
/// A = 1 + c_1 + \cos\tfrac{\pi}{n} \sqrt{2 (9 + c_1)}, \quad c_i = \cos\tfrac{2\pi i}{n}
/// ```
///
/// and the second with sines. \[Halstead1993\]
#[must_use]
pub fn tangent_weights(n: u32, i: u32) -> [[f64; 2]; 2] {
    let step = 2.0 * PI / f64::from(n);
    let c1 = cos(step);
    let a = 1.0 + c1 + cos(0.5 * step) * sqrt(2.0 * (9.0 + c1));
    let (at, next) = (f64::from(i) * step, f64::from(i + 1) * step);
    [[a * cos(at), cos(at) + cos(next)], [a * sin(at), sin(at) + sin(next)]]
}
