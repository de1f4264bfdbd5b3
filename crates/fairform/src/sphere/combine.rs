//! Several directions, combined pair by pair.

use crate::Vec3;

use super::blend::weighted;
use super::error::Error;

/// The combination $`c_0 t_0 \oplus \dots \oplus c_n t_n`$ of directions *in this order*: the list is
/// halved (a middle term goes to both sides with half its coefficient), each half is scaled by its
/// sum and combined in turn, and the two results are blended. Reversing the list changes nothing;
/// another order changes the result at third order in the spread. \[Miura2001, eq. 45 and 46\]
///
/// # Errors
/// [`Error::WrongCount`] if there is not one coefficient per direction, or none at all;
/// [`Error::BadNumber`] if their sum is not one; [`Error::Cancels`] if the coefficients of a half
/// cancel.
pub fn combine(coefficients: &[f64], tangents: &[Vec3]) -> Result<Vec3, Error> {
    if coefficients.len() != tangents.len() || tangents.is_empty() {
        let (what, expected) = ("coefficients, one per tangent", tangents.len().max(1));
        return Err(Error::WrongCount { what, expected, count: coefficients.len() });
    }
    let sum: f64 = coefficients.iter().sum();
    let is_one = (sum - 1.0).abs() <= 1e-9;
    if !is_one {
        let (what, expected) = ("the sum of the coefficients", "1");
        return Err(Error::BadNumber { what, expected, value: sum });
    }
    halves(&|i| (coefficients[i], tangents[i]), Part { start: 0, end: tangents.len() }, 1.0)
}

/// The terms from `start` up to `end`, the first or last of which may count half.
#[derive(Clone, Copy)]
struct Part {
    start: usize,
    end: usize,
}

/// Combines terms whose coefficients are to be divided by their sum `of`.
fn halves(term: &dyn Fn(usize) -> (f64, Vec3), part: Part, of: f64) -> Result<Vec3, Error> {
    let count = part.end - part.start;
    match count {
        1 => return Ok(term(part.start).1),
        2 => {
            let ((c0, t0), (c1, t1)) = (term(part.start), term(part.start + 1));
            return Ok(weighted(c0 / of, t0, c1 / of, t1));
        }
        _ => {}
    }
    let middle = part.start + count / 2;
    let shared = (count % 2 == 1).then_some(middle);
    // A term in the middle counts half in each part.
    let shared_half = |i: usize| {
        let (c, t) = term(i);
        if Some(i) == shared { (0.5 * c, t) } else { (c, t) }
    };
    let low = Part { start: part.start, end: middle + count % 2 };
    let high = Part { start: middle, end: part.end };
    let sums = [low, high].map(|half| {
        let outward = half.start == part.start;
        // From the outside in on both sides, so that the reversed list has the same sums.
        let sum = |total: f64, i: usize| total + shared_half(i).0;
        let range = half.start..half.end;
        if outward { range.fold(0.0, sum) } else { range.rev().fold(0.0, sum) }
    });
    let sizes = [low, high].map(|half| {
        (half.start..half.end).map(|i| shared_half(i).0.abs()).fold(0.0, |a: f64, b| a + b)
    });
    for (i, half) in [high, low].into_iter().enumerate() {
        if sizes[i] == 0.0 {
            return halves(&shared_half, half, sums[1 - i]);
        }
    }
    if (0..2).any(|i| sums[i].abs() <= 1e-14 * sizes[i]) {
        return Err(Error::Cancels);
    }
    let a = halves(&shared_half, low, sums[0])?;
    let b = halves(&shared_half, high, sums[1])?;
    Ok(weighted(sums[0] / of, a, sums[1] / of, b))
}
