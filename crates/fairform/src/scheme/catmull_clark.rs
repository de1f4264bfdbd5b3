//! Catmull and Clark's scheme for polygon meshes.
//!
//! Pure functions from valence to weights; nothing here knows a mesh.
//!
//! # In two phases, with a shape parameter per face
//!
//! The first step is blended, face by face, with linear subdivision; all others are plain. With
//! $`w_F = 2(1 - \lambda_F)`$ the share of the plain scheme and $`c_F`$ the centroid of face `F`,
//!
//! ```math
//! E^1 = \frac{V + W}{2} + \sum_{F \ni e} w_F \Bigl(\frac{c_F}{4} - \frac{V + W}{8}\Bigr), \qquad
//! V^1 = V + \frac{1}{n^2} \sum_{F \ni V} w_F \Bigl(c_F + \frac{E_i + E_{i+1}}{2} - 2V\Bigr)
//! ```
//!
//! with $`E_i, E_{i+1}`$ the neighbours of `V` in `F`; points in faces are centroids. The limit mask for
//! quadrilaterals, $`n(n+5) V^\infty = n^2 V^1 + 4 \sum E^1 + \sum c_F`$, then gives
//!
//! ```math
//! n(n+5) V^\infty = \bigl(n^2 + 2n - 3 \sum w_F\bigr) V + 2 \sum E_i + \sum (1 + 3 w_F) c_F
//! ```
//!
//! So the limit operator is $`B = DS`$ with $`D = 1/(n(n+5))`$ and `S` symmetric,
//!
//! ```math
//! x^T S x = \sum_F \frac{1 + 3 w_F}{f} \Bigl(\sum_F x\Bigr)^2 + 2 \sum_{ij} (x_i + x_j)^2
//!   + \sum_i n_i (n_i - 3 \bar w_i) x_i^2
//! ```
//!
//! over faces with `f` corners, edges, and vertices, with $`\bar w_i`$ the mean of `w` around vertex `i`.
//! The weights of a row are not negative and sum to one, so no eigenvalue exceeds 1; and none is below
//! $`\min_i (n_i - 3 \bar w_i)/(n_i + 5)`$, see [`two_phase_eigenvalue_bound`]. With valences from 3 on
//! that is zero only for $`\bar w_i = 1`$. Since $`(\sum_F x)^2 \le f \sum_F x^2`$, the form falls with
//! every $`w_F`$: tension on a face never lowers an eigenvalue.
//!
//! On boundaries and creases the share $`w_e`$ of an edge is that of the face behind it, or the mean of
//! both. Points on edges are midpoints,
//!
//! ```math
//! V^1 = V + \sum \frac{w_e}{8} (E_e - V), \qquad
//! 12 V^\infty = \bigl(10 - \sum w_e\bigr) V + \sum (1 + w_e) E_e
//! ```
//!
//! over the two edges of the curve: symmetric, with eigenvalues from $`(2 - \max w)/3`$ to 1. Where curves
//! are fixed, the operator of the surface is a principal block, so that its bounds hold too. Semi-sharp
//! edges blend these rules as they do the plain ones, without a bound.

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

/// The same with a first step in two phases, for a vertex of valence `n` round which the plain scheme
/// has the mean share $`\bar w`$: $`(n - 3 \bar w)/(n + 5)`$. Sharp where `smallest_eigenvalue_bound` is,
/// for one share everywhere.
#[must_use]
pub fn two_phase_eigenvalue_bound(n: u32, share: f64) -> f64 {
    (f64::from(n) - 3.0 * share) / (f64::from(n) + 5.0)
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
