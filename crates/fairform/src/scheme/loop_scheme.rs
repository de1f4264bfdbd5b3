//! Loop's scheme for triangle meshes, with the boundary rules of \[ChengEtAl2009\].
//!
//! Pure functions from valence to weights; nothing here knows a mesh. Every mask sums to one, tangent
//! masks to zero.
//!
//! # In two phases, with a shape parameter per face
//!
//! The first step is blended, face by face, with linear subdivision; all others are plain. With
//! $`w_F = 2(1 - \lambda_F)`$ the share of the plain scheme, $`P_F`$ the corner of face `F` opposite the
//! edge, and $`\alpha = w_n / n`$ from [`ring_weight`],
//!
//! ```math
//! E^1 = \frac{V + W}{2} + \sum_{F \ni e} \frac{w_F}{16} (2 P_F - V - W), \qquad
//! V^1 = V + \alpha \sum_{F \ni V} w_F \Bigl(\frac{E_i + E_{i+1}}{2} - V\Bigr)
//! ```
//!
//! with $`E_i, E_{i+1}`$ the neighbours of `V` in `F`. With $`\chi = (1 - \beta_n)/n`$ the limit weight of
//! each neighbour, $`\beta_n / \chi = 3/(8\alpha)`$, the limit mask after that step gives
//!
//! ```math
//! \frac{V^\infty}{\chi} = \Bigl(\frac{3}{8\alpha} + \frac n2\Bigr) V + \frac12 \sum E_i
//!   + \frac14 \sum_F w_F (E_i + E_{i+1} - 2V)
//! ```
//!
//! So the limit operator is $`B = DS`$ with $`D = \chi`$ and `S` symmetric, $`\frac12 + \frac14 (w_F + w_G)`$
//! on the edge between faces `F` and `G`:
//!
//! ```math
//! x^T S x = \sum_F \frac{1 + w_F}{4} \Bigl(\sum_F x\Bigr)^2
//!   + \sum_i \Bigl(\frac{3}{8\alpha_i} + \frac{n_i}{4} - \frac34 n_i \bar w_i\Bigr) x_i^2
//! ```
//!
//! with $`\bar w_i`$ the mean of `w` around vertex `i`. The weights of a row are not negative and sum to
//! one, so no eigenvalue exceeds 1; and none is below
//! $`\min_i \beta + (1 - \beta)(\frac14 - \frac34 \bar w_i)`$, see [`two_phase_eigenvalue_bound`], which is
//! positive. Since $`(\sum_F x)^2 \le 3 \sum_F x^2`$, the form falls with every $`w_F`$: tension on a face
//! never lowers an eigenvalue.
//!
//! On boundaries the share $`w_e`$ of an edge is that of the face behind it; the rules of the boundary are
//! blended with midpoints and resting vertices likewise, and the limit masks are those of the finer
//! boundary after that. A vertex keeps at least $`3/5`$, so by Gershgorin's discs all eigenvalues have real
//! parts from $`3/5 - \frac25 \max w`$ to 1, and progressive interpolation converges. Where shares differ
//! along a boundary of regular and extraordinary vertices no `D` makes the rows symmetric in general:
//! conjugate gradients and factorising are then refused. Creases are those of
//! [`catmull_clark`](super::catmull_clark).

use core::f64::consts::PI;

use libm::{cos, sin};

/// Weight that all neighbours together have in the new position of an interior vertex of valence
/// `n`:
///
/// ```math
/// w_n = \frac58 - \left(\frac38 + \frac14 \cos\frac{2\pi}{n}\right)^2
/// ```
///
/// Each neighbour has $`w_n / n`$, the vertex keeps $`1 - w_n`$. A regular vertex gives
/// $`w_6 = 3/8`$. \[Loop1987\]
///
/// # Panics
/// If `n < 2`: no fan of triangles is smaller.
#[must_use]
pub fn ring_weight(n: u32) -> f64 {
    assert!(n >= 2, "an interior vertex has at least 2 neighbours, not {n}");
    let a = 0.375 + 0.25 * cos(2.0 * PI / f64::from(n));
    0.625 - a * a
}

/// Weight of the vertex itself in the limit position of an interior vertex of valence `n`:
///
/// ```math
/// V^\infty = \beta_n V + (1 - \beta_n)\,\mathrm{mean}(\mathrm{ring}), \qquad
/// \beta_n = \frac{3}{3 + 8 w_n}
/// ```
///
/// with $`w_n`$ from [`ring_weight`]; $`\beta_3 = 2/5`$, $`\beta_4 = 24/55`$, $`\beta_6 = 1/2`$,
/// increasing to $`8/13`$. \[ChengEtAl2009, eq. 3\]
///
/// # Panics
/// If `n < 2`.
#[must_use]
pub fn limit_weight(n: u32) -> f64 {
    3.0 / (3.0 + 8.0 * ring_weight(n))
}

/// Lower bound for the eigenvalues that interior vertices of valence `n` or more give the limit
/// operator: $`(3\beta_n - 1)/2`$, sharp on 3-colourable closed meshes of one valence.
///
/// # Panics
/// If `n < 2`.
#[must_use]
pub fn smallest_eigenvalue_bound(n: u32) -> f64 {
    f64::midpoint(3.0 * limit_weight(n), -1.0)
}

/// The same with a first step in two phases, for a vertex of valence `n` round which the plain scheme
/// has the mean share $`\bar w`$: $`\beta + (1 - \beta)(\frac14 - \frac34 \bar w)`$. Sharp where
/// `smallest_eigenvalue_bound` is, for one share everywhere.
///
/// # Panics
/// If `n < 2`.
#[must_use]
pub fn two_phase_eigenvalue_bound(n: u32, share: f64) -> f64 {
    let own = limit_weight(n);
    own + (1.0 - own) * (0.25 - 0.75 * share)
}

/// What the rules distinguish on the boundary.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum BoundaryKind {
    /// Valence 4, that is three faces, as on the boundary of a regular mesh.
    Regular,
    /// Any other valence.
    Extraordinary,
    /// A vertex that stays where it is, see [`Corners::Sharp`](super::Corners::Sharp).
    Corner,
}

/// Lower bound for the eigenvalues of the limit operator on boundary vertices, $`3/10`$: it is
/// attained on an even loop of extraordinary vertices.
pub const BOUNDARY_SMALLEST_EIGENVALUE: f64 = 0.3;

/// Weights of the two ends in the new point on a boundary edge: one half each between vertices of
/// one kind, $`5/8`$ for the regular end and $`3/8`$ for the extraordinary one between mixed.
/// A corner counts as the kind of its neighbour.
#[must_use]
pub fn boundary_edge_weights(a: BoundaryKind, b: BoundaryKind) -> [f64; 2] {
    use BoundaryKind::{Extraordinary, Regular};
    match (a, b) {
        (Regular, Extraordinary) => [0.625, 0.375],
        (Extraordinary, Regular) => [0.375, 0.625],
        _ => [0.5, 0.5],
    }
}

/// Weight of a boundary neighbour in the limit position of a boundary vertex; the vertex keeps what
/// is left to one.
///
/// | centre | neighbour | weight |
/// |---|---|---|
/// | regular | regular or corner | 1/6 |
/// | regular | extraordinary | 7/48 |
/// | extraordinary | regular | 1/5 |
/// | extraordinary | extraordinary or corner | 7/40 |
/// | corner | any | 0 |
///
/// They compose one refinement step with the masks 1/6, 2/3, 1/6 (regular) and 1/5, 3/5, 1/5
/// (extraordinary), which hold when both neighbours are regular. \[ChengEtAl2009, section 4\]
#[must_use]
pub fn boundary_limit_weight(centre: BoundaryKind, neighbour: BoundaryKind) -> f64 {
    use BoundaryKind::{Corner, Extraordinary, Regular};
    match (centre, neighbour) {
        (Regular, Regular | Corner) => 1.0 / 6.0,
        (Regular, Extraordinary) => 7.0 / 48.0,
        (Extraordinary, Regular) => 0.2,
        (Extraordinary, Extraordinary | Corner) => 7.0 / 40.0,
        (Corner, _) => 0.0,
    }
}

/// Diagonal scale that makes the boundary rows symmetric: row `i` of the limit operator is
/// `boundary_scale(kind of i)` times a row of a symmetric matrix.
#[must_use]
pub fn boundary_scale(centre: BoundaryKind) -> f64 {
    match centre {
        BoundaryKind::Regular => 35.0,
        BoundaryKind::Extraordinary | BoundaryKind::Corner => 48.0,
    }
}

/// Weights of neighbour `i` in the two tangents at an interior vertex of valence `n`:
/// $`\cos(2\pi i/n)`$ and $`\sin(2\pi i/n)`$.
#[must_use]
pub fn tangent_weights(n: u32, i: u32) -> [f64; 2] {
    let angle = 2.0 * PI * f64::from(i) / f64::from(n);
    [cos(angle), sin(angle)]
}

/// Weight of the vertex itself in the inward tangent at a boundary vertex with `k` faces, to be
/// used on the ring after one refinement step together with [`inward_tangent_weight`].
///
/// # Panics
/// If `k` is zero.
#[must_use]
pub fn inward_tangent_centre_weight(k: u32) -> f64 {
    match k {
        0 => panic!("a boundary vertex has a face"),
        1 => -1.0,
        2 => -24.0 / 30.0,
        3 => -2.0,
        _ => 0.0,
    }
}

/// Weight of ring point `i` of `0..=k` in the inward tangent at a boundary vertex with `k` faces.
///
/// For two faces (valence 3) the limit surface has no unique normal; the mask is a convention, the
/// secant to the limit position of the inner neighbour.
///
/// # Panics
/// If `k` is zero or `i > k`.
#[must_use]
pub fn inward_tangent_weight(k: u32, i: u32) -> f64 {
    assert!(k > 0 && i <= k, "ring point {i} of a boundary vertex with {k} faces");
    let end = i == 0 || i == k;
    match (k, end) {
        (1, _) => 0.5,
        (2, true) => -5.0 / 60.0,
        (2, false) => 29.0 / 30.0,
        (3, true) => -1.0,
        (3, false) => 2.0,
        (_, true) => -sin(PI / f64::from(k)),
        (_, false) => {
            let theta = PI / f64::from(k);
            (2.0 - 2.0 * cos(theta)) * sin(f64::from(i) * theta)
        }
    }
}
