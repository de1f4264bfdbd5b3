//! The butterfly scheme for triangle meshes in Zorin's modified form, which is smooth at vertices of
//! any valence. Old vertices stay, so the limit surface passes through all vertices of the mesh.
//!
//! Away from vertices of another valence than 6 it is the original eight-point scheme
//! \[DynLevinGregory1990\]; there is no separate scheme for that one.
//!
//! Pure functions from valence to weights; nothing here knows a mesh.

use core::f64::consts::PI;

use libm::{cos, sqrt};

/// Weights in the new point on an edge between two regular or boundary vertices: of each end, of
/// each corner opposite the edge, and of each wing, the corner across one of the four other edges
/// of the two triangles. \[DynLevinGregory1990\]
///
/// ```text
///     w ─── c ─── w        a wing that falls outside is a reflection: beyond the boundary edge pq
///      ╲   ╱ ╲   ╱         of the triangle (p, q, r) it is p + q − r
///       ╲ ╱   ╲ ╱
///        a ─●── b
///       ╱ ╲   ╱ ╲
///      ╱   ╲ ╱   ╲
///     w ─── d ─── w
/// ```
pub const EDGE: [f64; 3] = [0.5, 0.125, -1.0 / 16.0];

/// Weights in the new point on a boundary edge: of each end, and of the next vertex beyond either,
/// along the boundary. The four-point scheme, [`kobbelt::edge_weights`](super::kobbelt::edge_weights)
/// with tension 1.
pub const CURVE_EDGE: [f64; 2] = [9.0 / 16.0, -1.0 / 16.0];

/// Weight of an interior vertex of another valence than 6 in the new points on its edges.
pub const CENTRE: f64 = 0.75;

/// Weight of the neighbour `j` steps from the other end, in the new point on an edge of an interior
/// vertex of valence `n`, beside [`CENTRE`]:
///
/// ```math
/// s_j = \frac1n \left(\frac14 + \cos\frac{2\pi j}{n} + \frac12 \cos\frac{4\pi j}{n}\right)
/// ```
///
/// for $`n \ge 5`$; $`\frac38, 0, -\frac18, 0`$ for 4 and $`\frac5{12}, -\frac1{12}, -\frac1{12}`$
/// for 3. Together they have 1/4. If both ends are such vertices, the new point is the mean of both.
/// \[Zorin1996\]
///
/// A valence of 2 is not published. Its weights $`\frac38, -\frac18`$ follow the same design: the
/// mean takes 1/4, and the alternating part, as for 4, one half of its eigenvalue.
///
/// # Panics
/// If `n < 2`.
#[must_use]
pub fn ring_weight(n: u32, j: u32) -> f64 {
    assert!(n >= 2, "an interior vertex has at least 2 neighbours, not {n}");
    match (n, j % n) {
        (2 | 4, 0) => 0.375,
        (2, _) | (4, 2) => -0.125,
        (4, _) => 0.0,
        (3, 0) => 5.0 / 12.0,
        (3, _) => -1.0 / 12.0,
        (_, j) => {
            let size = f64::from(n);
            let angle = 2.0 * PI * f64::from(j) / size;
            (0.25 + cos(angle) + 0.5 * cos(2.0 * angle)) / size
        }
    }
}

/// Weights in the tangents at a regular vertex, all valences around being 6 too: of neighbour `j`, of
/// the vertex beyond the edge between neighbours `j` and `j + 1`, and of the one straight behind
/// neighbour `j`:
///
/// ```math
/// t = \sum_j 16 \cos(j\theta)\, q_j - \frac{8}{\sqrt3} \cos\bigl((j + \tfrac12)\theta\bigr) f_j
///     + \cos(j\theta)\, g_j, \qquad \theta = \frac{\pi}{3}
/// ```
///
/// and the other with sines: the left eigenvectors for 1/2 of the local subdivision matrix. At a
/// vertex of another valence the neighbours alone take part, after one step. \[Zorin1996\]
#[must_use]
pub fn regular_tangent_weights() -> [f64; 3] {
    [16.0, -8.0 / sqrt(3.0), 1.0]
}
