//! Kobbelt's scheme for quadrilateral meshes, the tensor product of the four-point scheme where the
//! mesh is a grid. Old vertices stay, so the limit surface passes through all vertices of the mesh.
//!
//! Pure functions from valence and tension to weights; nothing here knows a mesh.

/// Tensions above zero and below this, $`2(\sqrt5 - 1)`$, give smooth curves. \[Kobbelt1996\]
pub const SMOOTH_BELOW: f64 = 2.472_135_954_999_579_4;

/// Above this tension the limit surface has no tangent plane at interior vertices of valence 3: a
/// complex pair of eigenvalues of the local subdivision matrix becomes the largest but one.
pub const VALENCE_3_SMOOTH_UP_TO: f64 = 1.66;

/// Weights in a new point of the four-point scheme with tension `w`: of the two points between which
/// it lies, and of the next on either side.
///
/// ```math
/// \frac{8+w}{16} (p_0 + p_1) - \frac{w}{16} (p_{-1} + p_2)
/// ```
///
/// Cubics are reproduced for `w = 1`, with 9/16 and −1/16; `w = 0` is the polygon itself.
/// \[DynLevinGregory1987\]
#[must_use]
pub fn edge_weights(w: f64) -> [f64; 2] {
    [(8.0 + w) / 16.0, -w / 16.0]
}

/// Weight of neighbour $`l_j`$ in the virtual point behind an interior vertex of valence `n`, seen
/// from its neighbour $`l_0`$: what the four-point rule on the edge between them uses as the next point.
///
/// ```math
/// v = \frac4n \sum_j l_j - (l_{-1} + l_0 + l_1)
///     + \frac{w}{8+w} \Bigl(k_{-2} + k_{-1} + k_0 + k_1 - \frac4n \sum_j k_j\Bigr)
/// ```
///
/// where $`k_j`$ is the corner opposite the vertex in the face between $`l_j`$ and $`l_{j+1}`$, see
/// [`virtual_corner_weight`]. It makes the new points in the faces at the vertex the same in both
/// directions. For `n = 4` it is $`l_2`$; for `n = 3` the neighbours have 1/3 each. \[Kobbelt1996\]
///
/// # Panics
/// If `n` is zero.
#[must_use]
pub fn virtual_neighbour_weight(n: u32, j: u32) -> f64 {
    assert!(n > 0, "an interior vertex has neighbours");
    4.0 / f64::from(n) - count(n, j, [n - 1, 0, 1])
}

/// Weight of corner $`k_j`$ in the virtual point behind an interior vertex of valence `n`, for tension
/// `w`; see [`virtual_neighbour_weight`].
///
/// For `n = 5`, `w = 1`: 1/45, but −4/45 for `j = 2`.
///
/// # Panics
/// If `n` is zero.
#[must_use]
pub fn virtual_corner_weight(n: u32, j: u32, w: f64) -> f64 {
    assert!(n > 0, "an interior vertex has neighbours");
    corner_share(w) * (count(n, j, [2 * n - 2, n - 1, 0, 1]) - 4.0 / f64::from(n))
}

/// How often `j` is among the places, both modulo `n`.
fn count<const K: usize>(n: u32, j: u32, places: [u32; K]) -> f64 {
    places.iter().map(|place| f64::from(u8::from(place % n == j % n))).sum()
}

/// The factor $`w/(8+w)`$ of corners in a virtual point.
pub(crate) fn corner_share(w: f64) -> f64 {
    w / (8.0 + w)
}

/// Weights in the derivative of a four-point curve with tension `w` at a point: of the next point on
/// either side, the one before counting negative, and of the next but one.
///
/// ```math
/// t = (p_1 - p_{-1}) - \frac w8 (p_2 - p_{-2})
/// ```
///
/// The left eigenvector for 1/2; for `w = 1` the difference formula exact for quartics.
#[must_use]
pub fn tangent_weights(w: f64) -> [f64; 2] {
    [1.0, -w / 8.0]
}
