//! B-splines with any knots: where a parameter lies, and the functions that do not vanish there.

/// The knot span $`[u_m, u_{m+1})`$ in which a parameter lies; the last one is closed.
pub(crate) fn span(knots: &[f64], degree: usize, u: f64) -> usize {
    let count = knots.len() - degree - 1;
    degree + knots[degree..count].partition_point(|&k| k <= u).saturating_sub(1)
}

/// The functions $`B_j(u)`$ that do not vanish in a span, as many as the degree plus one, which is the
/// length of `basis`; the first for $`j`$ = span − degree.
pub(crate) fn basis(knots: &[f64], span: usize, u: f64, basis: &mut [f64]) {
    basis[0] = 1.0;
    for degree in 1..basis.len() {
        let mut carried = 0.0;
        for (r, b) in basis[..degree].iter_mut().enumerate() {
            let (right, left) = (knots[span + r + 1], knots[span + 1 + r - degree]);
            let share = *b / (right - left);
            *b = carried + (right - u) * share;
            carried = (u - left) * share;
        }
        basis[degree] = carried;
    }
}
