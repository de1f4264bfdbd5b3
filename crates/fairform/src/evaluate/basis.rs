//! The basis functions of regular patches, with their derivatives.

/// The values and the derivatives of basis functions at a point, and of what they are the basis of:
/// the value, by $`u`$, $`v`$, $`uu`$, $`uv`$ and $`vv`$.
pub(crate) type Jet<T> = [T; 6];

/// The weights of 16 control points, row by row over $`\{-1, 0, 1, 2\}^2`$, in the bicubic B-spline
/// over $`[0, 1]^2`$.
pub(crate) fn bicubic([u, v]: [f64; 2], mut found: impl FnMut(usize, Jet<f64>)) {
    tensor(&cubic(u), &cubic(v), &mut found);
}

/// The weights of 9 control points, row by row over $`\{-1, 0, 1\}^2`$, in the biquadratic B-spline
/// over $`[-1/2, 1/2]^2`$, which $`[0, 1]^2`$ is mapped to.
pub(crate) fn biquadratic([u, v]: [f64; 2], mut found: impl FnMut(usize, Jet<f64>)) {
    tensor(&quadratic(u), &quadratic(v), &mut found);
}

fn tensor(u: &[[f64; 3]], v: &[[f64; 3]], found: &mut impl FnMut(usize, Jet<f64>)) {
    for (i, y) in v.iter().enumerate() {
        for (j, x) in u.iter().enumerate() {
            let jet =
                [x[0] * y[0], x[1] * y[0], x[0] * y[1], x[2] * y[0], x[1] * y[1], x[0] * y[2]];
            found(u.len() * i + j, jet);
        }
    }
}

fn cubic(t: f64) -> [[f64; 3]; 4] {
    let s = 1.0 - t;
    let end = |t: f64| t * t * t / 6.0;
    let inner = |t: f64| (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0;
    let slope = |t: f64| -2.0 * t + 1.5 * t * t;
    [
        [end(s), -0.5 * s * s, s],
        [inner(t), slope(t), 3.0 * t - 2.0],
        [inner(s), -slope(s), 3.0 * s - 2.0],
        [end(t), 0.5 * t * t, t],
    ]
}

fn quadratic(t: f64) -> [[f64; 3]; 3] {
    let s = 1.0 - t;
    [[0.5 * s * s, -s, 1.0], [0.5 + t * s, 1.0 - 2.0 * t, -2.0], [0.5 * t * t, t, 1.0]]
}

/// The exponents of quartic Bernstein polynomials in the three barycentric coordinates.
pub(super) const QUARTICS: [[u8; 3]; 15] = [
    [4, 0, 0],
    [3, 1, 0],
    [3, 0, 1],
    [2, 2, 0],
    [2, 1, 1],
    [2, 0, 2],
    [1, 3, 0],
    [1, 2, 1],
    [1, 1, 2],
    [1, 0, 3],
    [0, 4, 0],
    [0, 3, 1],
    [0, 2, 2],
    [0, 1, 3],
    [0, 0, 4],
];

const FACTORIAL: [f64; 5] = [1.0, 1.0, 2.0, 6.0, 24.0];

/// The weights of the 15 Bézier points of a quartic triangle, in the order of [`QUARTICS`].
pub(crate) fn quartic([u, v]: [f64; 2], mut found: impl FnMut(usize, Jet<f64>)) {
    let powers = [1.0 - u - v, u, v].map(|x| [1.0, x, x * x, x * x * x, x * x * x * x]);
    // Bernstein polynomials of degree i + j + k; zero where an exponent is negative.
    let b = |[i, j, k]: [i8; 3]| {
        if i < 0 || j < 0 || k < 0 {
            return 0.0;
        }
        let [i, j, k] = [i, j, k].map(|e| e as usize);
        let count = FACTORIAL[i + j + k] / (FACTORIAL[i] * FACTORIAL[j] * FACTORIAL[k]);
        count * powers[0][i] * powers[1][j] * powers[2][k]
    };
    for (n, &e) in QUARTICS.iter().enumerate() {
        let [i, j, k] = e.map(u8::cast_signed);
        let jet = [
            b([i, j, k]),
            4.0 * (b([i, j - 1, k]) - b([i - 1, j, k])),
            4.0 * (b([i, j, k - 1]) - b([i - 1, j, k])),
            12.0 * (b([i, j - 2, k]) - 2.0 * b([i - 1, j - 1, k]) + b([i - 2, j, k])),
            12.0 * (b([i, j - 1, k - 1]) - b([i - 1, j - 1, k]) - b([i - 1, j, k - 1])
                + b([i - 2, j, k])),
            12.0 * (b([i, j, k - 2]) - 2.0 * b([i - 1, j, k - 1]) + b([i - 2, j, k])),
        ];
        found(n, jet);
    }
}

/// The lattice points that the quartic box spline over the triangle (0, 0), (1, 0), (0, 1) depends on,
/// and how: on a corner; across a side from the corner given; next to the first corner given, towards
/// the second.
pub(super) const LATTICE: [([i8; 2], Role); 12] = [
    ([0, 0], Role::Corner(0)),
    ([1, 0], Role::Corner(1)),
    ([0, 1], Role::Corner(2)),
    ([1, 1], Role::Across(0)),
    ([-1, 1], Role::Across(1)),
    ([1, -1], Role::Across(2)),
    ([-1, 0], Role::Outside(0, 2)),
    ([0, -1], Role::Outside(0, 1)),
    ([2, 0], Role::Outside(1, 2)),
    ([2, -1], Role::Outside(1, 0)),
    ([0, 2], Role::Outside(2, 1)),
    ([-1, 2], Role::Outside(2, 0)),
];

/// Where a control point of the box spline lies.
#[derive(Clone, Copy)]
pub(super) enum Role {
    Corner(usize),
    Across(usize),
    Outside(usize, usize),
}

impl Role {
    /// The Bézier coefficient of this basis function that belongs to the given exponents. \[Stam1998\]
    pub(super) fn bezier(self, exponents: [u8; 3]) -> f64 {
        let e = |i: usize| exponents[i % 3];
        // Coefficients of monomials, times 12.
        let monomial = match self {
            Self::Corner(a) => match (e(a), e(a + 1).max(e(a + 2))) {
                (4, _) => 6.0,
                (3, _) | (2, 2) => 24.0,
                (2, _) => 60.0,
                (1, 3) => 8.0,
                (1, _) => 36.0,
                (_, 4) => 1.0,
                (_, 3) => 6.0,
                _ => 12.0,
            },
            Self::Across(c) => match (e(c), e(c + 1).max(e(c + 2))) {
                (0, 4) => 1.0,
                (0, 3) | (1, 2) => 6.0,
                (0, _) => 12.0,
                (1, 3) => 2.0,
                _ => 0.0,
            },
            Self::Outside(a, b) => match (e(a), e(b)) {
                (4, _) => 1.0,
                (3, 1) => 2.0,
                _ => 0.0,
            },
        };
        let [i, j, k] = exponents.map(|e| FACTORIAL[e as usize]);
        monomial / 12.0 * (i * j * k / 24.0)
    }
}
