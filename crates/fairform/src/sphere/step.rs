//! One refinement step of a sequence of directions, or of numbers beside them.
//!
//! Every new element is an ordered combination of a few old ones ([`Terms`]): of directions by
//! [`combine`](super::combine()), of numbers by the sum. The regular rules need no trigonometry except
//! the extrapolation of the four-point rule, and the inner loop shares what neighbours have in common.

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::ops::Range;

use crate::Vec3;

use super::blend::{FixedBlend, QUARTER, half};
use super::error::Error;
use super::mean::weighted_mean;
use super::{Blend, combine};

/// A subdivision rule for sequences.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Rule {
    /// Chaikin's corner cutting, quadratic B-splines: $`\tfrac34, \tfrac14`$.
    Chaikin,
    /// Cubic B-splines: $`\tfrac12, \tfrac12`$ and $`\tfrac18, \tfrac34, \tfrac18`$.
    Cubic,
    /// The four-point rule, which keeps the given directions, with tension `w`; 1 as published,
    /// smooth for $`0 < w < 2(\sqrt5 - 1)`$: $`\tfrac1{16}(-w, 8+w, 8+w, -w)`$.
    FourPoint {
        /// The tension.
        w: f64,
    },
}

impl Rule {
    /// Its name in files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Chaikin => "chaikin",
            Self::Cubic => "cubic",
            Self::FourPoint { .. } => "four-point",
        }
    }
}

/// What happens at the ends of a sequence.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Ends {
    /// Only what the rule gives where it has all it needs: Chaikin and the cubic rule then shrink from
    /// the ends. The four-point rule reflects: $`t_{-1} = 2t_0 \oplus (-1)t_1`$.
    #[default]
    Natural,
    /// The ends are kept, as knot insertion into a clamped uniform B-spline does. For the four-point
    /// rule, as natural.
    Clamped,
    /// There are none: after the last comes the first.
    Closed,
}

/// The combination that one new element is, in order.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Terms {
    count: usize,
    source: [usize; 4],
    weight: [f64; 4],
}

impl Terms {
    fn new(terms: &[(usize, f64)]) -> Self {
        let mut new = Self { count: terms.len(), source: [0; 4], weight: [0.0; 4] };
        for (i, &(source, weight)) in terms.iter().enumerate() {
            (new.source[i], new.weight[i]) = (source, weight);
        }
        new
    }

    /// Numbers of the old elements.
    #[must_use]
    pub fn sources(&self) -> &[usize] {
        &self.source[..self.count]
    }

    /// Their coefficients, with sum one.
    #[must_use]
    pub fn weights(&self) -> &[f64] {
        &self.weight[..self.count]
    }

    fn direction(&self, blend: Blend, get: &impl Fn(usize) -> Vec3) -> Vec3 {
        if self.count == 1 {
            return get(self.source[0]);
        }
        let mut tangents = [Vec3::ZERO; 4];
        self.sources().iter().zip(&mut tangents).for_each(|(&i, t)| *t = get(i));
        let tangents = &tangents[..self.count];
        let made = match blend {
            Blend::Pairs => combine(self.weights(), tangents),
            Blend::Mean => weighted_mean(self.weights(), tangents),
        };
        made.expect("the weights of a rule have sum one and do not cancel")
    }

    fn number(&self, get: &impl Fn(usize) -> f64) -> f64 {
        let terms = self.sources().iter().zip(self.weights());
        terms.map(|(&i, &w)| w * get(i)).sum()
    }
}

/// One step of a rule on a sequence of some length.
#[derive(Clone, Debug)]
pub struct Step {
    rule: Rule,
    ends: Ends,
    count: usize,
    /// Those of the four-point rule, if not of the published tension.
    blends: Option<Box<FourPointBlends>>,
}

/// What the four-point rule is made of.
#[derive(Clone, Debug)]
struct FourPointBlends {
    /// $`-\tfrac w8, \tfrac{8+w}8`$.
    outward: FixedBlend,
    /// $`\tfrac{8-w}8, \tfrac w8`$, at open ends.
    inward: FixedBlend,
}

impl FourPointBlends {
    const fn new(w: f64) -> Self {
        Self {
            outward: FixedBlend::new(-w / 8.0, (8.0 + w) / 8.0),
            inward: FixedBlend::new((8.0 - w) / 8.0, w / 8.0),
        }
    }
}

/// Of the published tension; to make them takes longer than a short step.
static FOUR_POINT: FourPointBlends = FourPointBlends::new(1.0);

impl Step {
    /// The step that refines `count` elements.
    ///
    /// # Errors
    /// [`Error::TooFew`]: natural ends need 2 elements (cubic 3), clamped ends 3 (cubic 4), four-point
    /// 2, closed sequences 3; [`Error::BadNumber`] for a tension that is not finite or not above −8.
    pub fn new(rule: Rule, ends: Ends, count: usize) -> Result<Self, Error> {
        let (name, needed) = match (rule, ends) {
            (Rule::Chaikin, Ends::Natural) => ("Chaikin", 2),
            (Rule::Chaikin, Ends::Clamped) => ("clamped Chaikin", 3),
            (Rule::Chaikin, Ends::Closed) => ("closed Chaikin", 3),
            (Rule::Cubic, Ends::Natural) => ("cubic", 3),
            (Rule::Cubic, Ends::Clamped) => ("clamped cubic", 4),
            (Rule::Cubic, Ends::Closed) => ("closed cubic", 3),
            (Rule::FourPoint { .. }, Ends::Natural | Ends::Clamped) => ("four-point", 2),
            (Rule::FourPoint { .. }, Ends::Closed) => ("closed four-point", 3),
        };
        if count < needed {
            return Err(Error::TooFew { rule: name, needed, count });
        }
        let mut blends = None;
        if let Rule::FourPoint { w } = rule {
            if !(w.is_finite() && w > -8.0) {
                let (what, expected) = ("the four-point tension", "finite and above -8");
                return Err(Error::BadNumber { what, expected, value: w });
            }
            blends = (w != 1.0).then(|| Box::new(FourPointBlends::new(w)));
        }
        Ok(Self { rule, ends, count, blends })
    }

    fn blends(&self) -> &FourPointBlends {
        self.blends.as_deref().unwrap_or(&FOUR_POINT)
    }

    /// Number of elements of the refined sequence.
    #[must_use]
    pub fn refined_count(&self) -> usize {
        let n = self.count;
        match (self.rule, self.ends) {
            (_, Ends::Closed) => 2 * n,
            (Rule::Chaikin, _) => 2 * n - 2,
            (Rule::Cubic, _) => 2 * n - 3,
            (Rule::FourPoint { .. }, _) => 2 * n - 1,
        }
    }

    /// What the new element `j` is a combination of.
    ///
    /// # Panics
    /// If there is no such element.
    #[must_use]
    pub fn terms(&self, j: usize) -> Terms {
        assert!(j < self.refined_count(), "there is no new element {j}");
        if self.ends == Ends::Clamped
            && let Some(terms) = self.clamped(j)
        {
            return terms;
        }
        match self.rule {
            Rule::Chaikin => {
                let [a, b] = self.leg(j / 2);
                let [near, far] = if j.is_multiple_of(2) { [0.75, 0.25] } else { [0.25, 0.75] };
                Terms::new(&[(a, near), (b, far)])
            }
            // Open: edge, vertex, …, edge; closed: vertex, edge, …
            Rule::Cubic => {
                let place = if self.ends == Ends::Closed { j } else { j + 1 };
                let i = place / 2;
                if !place.is_multiple_of(2) {
                    let [a, b] = self.leg(i);
                    return Terms::new(&[(a, 0.5), (b, 0.5)]);
                }
                Terms::new(&[(self.before(i), 0.125), (i, 0.75), (self.after(i), 0.125)])
            }
            Rule::FourPoint { w } => self.four_point(j, w),
        }
    }

    fn four_point(&self, j: usize, w: f64) -> Terms {
        let i = j / 2;
        if j.is_multiple_of(2) {
            return Terms::new(&[(i, 1.0)]);
        }
        let [a, b] = self.leg(i);
        let (wing, end) = (-w / 16.0, (8.0 + w) / 16.0);
        // A reflected neighbour turns into the end half (8 − w)/16, w/16 of the leg itself.
        let (near, far) = ((8.0 - w) / 16.0, w / 16.0);
        let open = self.ends != Ends::Closed;
        match (open && i == 0, open && i + 2 == self.count) {
            (true, true) => Terms::new(&[(a, 0.5), (b, 0.5)]),
            (true, false) => Terms::new(&[(a, near), (b, far), (b, end), (self.after(b), wing)]),
            (false, true) => Terms::new(&[(self.before(a), wing), (a, end), (a, far), (b, near)]),
            (false, false) => {
                Terms::new(&[(self.before(a), wing), (a, end), (b, end), (self.after(b), wing)])
            }
        }
    }

    /// The rows at clamped ends, which differ from the regular ones.
    fn clamped(&self, j: usize) -> Option<Terms> {
        let last = self.count - 1;
        let from_end = self.refined_count() - 1 - j;
        let mirrored = |terms: &[(usize, f64)], back: bool| {
            let mut row = Terms::new(terms);
            if back {
                row.source[..row.count].iter_mut().for_each(|s| *s = last - *s);
                row.source[..row.count].reverse();
                row.weight[..row.count].reverse();
            }
            Some(row)
        };
        let half = [0.5, 0.5];
        let (near, back) = if from_end < j { (from_end, true) } else { (j, false) };
        match (self.rule, near) {
            (Rule::FourPoint { .. }, _) => None,
            (_, 0) => mirrored(&[(0, 1.0)], back),
            (_, 1) => mirrored(&[(0, half[0]), (1, half[1])], back),
            (Rule::Cubic, 2) if self.count == 4 => mirrored(&[(1, half[0]), (2, half[1])], back),
            (Rule::Cubic, 2) => mirrored(&[(1, 0.75), (2, 0.25)], back),
            (Rule::Cubic, 3) if self.count == 5 => {
                mirrored(&[(1, 3.0 / 16.0), (2, 10.0 / 16.0), (3, 3.0 / 16.0)], back)
            }
            (Rule::Cubic, 3) => {
                mirrored(&[(1, 3.0 / 16.0), (2, 11.0 / 16.0), (3, 2.0 / 16.0)], back)
            }
            (Rule::Chaikin | Rule::Cubic, _) => None,
        }
    }

    fn before(&self, i: usize) -> usize {
        if i == 0 { self.count - 1 } else { i - 1 }
    }

    fn after(&self, i: usize) -> usize {
        if i + 1 == self.count { 0 } else { i + 1 }
    }

    fn leg(&self, i: usize) -> [usize; 2] {
        [i, self.after(i)]
    }

    /// The new elements that depend on the old ones of a range, not closed: the smallest range with
    /// all of them.
    #[must_use]
    pub fn affected(&self, changed: Range<usize>) -> Range<usize> {
        // No row lies farther from twice its sources than this.
        const REACH: usize = 5;
        if changed.is_empty() {
            return 0..0;
        }
        let all = self.refined_count();
        let first = (2 * changed.start).saturating_sub(REACH);
        let end = (2 * changed.end + REACH).min(all);
        let depends = |j: &usize| self.terms(*j).sources().iter().any(|i| changed.contains(i));
        let start = (first..end).find(depends).unwrap_or(0);
        let end = (start..end).rev().find(depends).map_or(start, |j| j + 1);
        start..end
    }

    /// The refined directions.
    ///
    /// # Panics
    /// If there are not as many as the step was made for.
    #[must_use]
    pub fn directions(&self, tangents: &[Vec3]) -> Vec<Vec3> {
        self.directions_by(tangents, Blend::Pairs)
    }

    /// The refined directions by either blend.
    ///
    /// # Panics
    /// As [`directions`](Self::directions).
    #[must_use]
    pub fn directions_by(&self, tangents: &[Vec3], blend: Blend) -> Vec<Vec3> {
        assert_eq!(tangents.len(), self.count, "one direction per element");
        let mut finer = alloc::vec![Vec3::ZERO; self.refined_count()];
        self.run(blend, |i| tangents[i], 0..finer.len(), |j, t| finer[j] = t);
        finer
    }

    /// The refined numbers that lie beside directions: the linear scheme of the same rule.
    ///
    /// # Panics
    /// If there are not as many as the step was made for.
    #[must_use]
    pub fn numbers(&self, numbers: &[f64]) -> Vec<f64> {
        assert_eq!(numbers.len(), self.count, "one number per element");
        (0..self.refined_count()).map(|j| self.terms(j).number(&|i| numbers[i])).collect()
    }

    /// Makes the new directions of a range, and hands them to `put`; the bits do not depend on the
    /// range.
    pub(crate) fn run(
        &self,
        blend: Blend,
        get: impl Fn(usize) -> Vec3,
        range: Range<usize>,
        mut put: impl FnMut(usize, Vec3),
    ) {
        let regular = self.regular(&range);
        if blend == Blend::Mean || regular.is_empty() {
            return range.for_each(|j| put(j, self.direction(j, blend, &get)));
        }
        for j in (range.start..regular.start).chain(regular.end..range.end) {
            put(j, self.direction(j, blend, &get));
        }
        match self.rule {
            Rule::Chaikin => chaikin(&get, regular, &mut put),
            Rule::Cubic => self.cubic(&get, regular, &mut put),
            Rule::FourPoint { .. } => self.four_points(&get, regular, &mut put),
        }
    }

    /// One new direction; regular rows to the bit as the inner loops do them.
    fn direction(&self, j: usize, blend: Blend, get: &impl Fn(usize) -> Vec3) -> Vec3 {
        let terms = self.terms(j);
        let at = |k: usize| get(terms.source[k]);
        let four_point = matches!(self.rule, Rule::FourPoint { .. });
        match terms.weights() {
            _ if blend == Blend::Mean => {}
            [0.5, 0.5] => return half(at(0), at(1)),
            [0.75, 0.25] => return QUARTER.both(at(0), at(1))[0],
            [0.25, 0.75] => return QUARTER.both(at(0), at(1))[1],
            [0.125, 0.75, 0.125] => {
                let [_, before] = QUARTER.both(at(0), at(1));
                let [after, _] = QUARTER.both(at(1), at(2));
                return half(before, after);
            }
            [_, _, _, _] if four_point => {
                // A leg at an end stands for its own reflection.
                let FourPointBlends { outward, inward } = self.blends();
                let (before, behind) = match (terms.source[1] == terms.source[2], j == 1) {
                    (false, _) => (outward, outward),
                    (true, true) => (inward, outward),
                    (true, false) => (outward, inward),
                };
                let [onward, _] = before.both(at(0), at(1));
                let [_, back] = behind.both(at(2), at(3));
                return half(onward, back);
            }
            _ => {}
        }
        terms.direction(blend, get)
    }

    /// The part of a range whose rows are regular and do not wrap around.
    fn regular(&self, range: &Range<usize>) -> Range<usize> {
        let all = self.refined_count();
        let margin = match (self.rule, self.ends) {
            (_, Ends::Closed) | (Rule::Cubic, Ends::Clamped) => 4,
            (Rule::Chaikin | Rule::Cubic, Ends::Natural) => 0,
            (Rule::Chaikin, Ends::Clamped) | (Rule::FourPoint { .. }, _) => 2,
        };
        let start = range.start.max(margin);
        start..range.end.min(all.saturating_sub(margin)).max(start)
    }

    /// A new vertex lies between the quarter points of the legs at it.
    fn cubic(
        &self,
        get: &impl Fn(usize) -> Vec3,
        range: Range<usize>,
        put: &mut impl FnMut(usize, Vec3),
    ) {
        let shift = usize::from(self.ends != Ends::Closed);
        // Place 2i is vertex i, place 2i + 1 the edge behind it.
        let places = range.start + shift..range.end + shift;
        if places.is_empty() {
            return;
        }
        let (first, last) = (places.start / 2, (places.end - 1) / 2);
        let begins_with_vertex = places.start.is_multiple_of(2);
        let mut from = get(first);
        let mut before = from;
        if begins_with_vertex {
            before = QUARTER.both(get(first - 1), from)[1];
        }
        for i in first..=last {
            let to = get(i + 1);
            let [near, far] = QUARTER.both(from, to);
            if i > first || begins_with_vertex {
                put(2 * i - shift, half(before, near));
            }
            if i < last || 2 * i + 1 < places.end {
                put(2 * i + 1 - shift, half(from, to));
            }
            (before, from) = (far, to);
        }
    }

    fn four_points(
        &self,
        get: &impl Fn(usize) -> Vec3,
        range: Range<usize>,
        put: &mut impl FnMut(usize, Vec3),
    ) {
        if range.is_empty() {
            return;
        }
        let (first, last) = (range.start / 2, (range.end - 1) / 2);
        let ends_with_edge = range.end.is_multiple_of(2);
        if first == last && !ends_with_edge {
            return put(2 * first, get(first));
        }
        // Each leg prolonged beyond both its ends.
        let outward = &self.blends().outward;
        let mut vertex = get(first);
        let mut next = get(first + 1);
        let [mut onward, _] = outward.both(get(first - 1), vertex);
        let [mut ahead, _] = outward.both(vertex, next);
        for i in first..=last {
            if i > first || 2 * i == range.start {
                put(2 * i, vertex);
            }
            if i == last && !ends_with_edge {
                break;
            }
            let after = get(i + 2);
            let [beyond, back] = outward.both(next, after);
            put(2 * i + 1, half(onward, back));
            (onward, ahead) = (ahead, beyond);
            (vertex, next) = (next, after);
        }
    }
}

/// Both quarter points of each leg.
fn chaikin(get: &impl Fn(usize) -> Vec3, range: Range<usize>, put: &mut impl FnMut(usize, Vec3)) {
    if range.is_empty() {
        return;
    }
    let (first, last) = (range.start / 2, (range.end - 1) / 2);
    let mut from = get(first);
    for i in first..=last {
        let to = get(i + 1);
        let [near, far] = QUARTER.both(from, to);
        // Both are wanted but for the first and the last leg.
        if i > first || 2 * i == range.start {
            put(2 * i, near);
        }
        if i < last || 2 * i + 2 == range.end {
            put(2 * i + 1, far);
        }
        from = to;
    }
}
