//! Several patches along shared streamlines.

use alloc::vec::Vec;

use crate::scheme::Scheme;
use crate::sphere::{self, Ends, exp, log};
use crate::{Faces, Mesh, Vec3};

use super::{Error, Grid, InitialCurve, Model, Surface};

/// How well two patches agree along the last streamline of the one and the first of the other.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Seam {
    /// Largest distance of points that should be the same.
    pub gap: f64,
    /// Largest angle between tangents that should be the same.
    pub tangent_angle: f64,
    /// Largest angle between the planes spanned on both sides by the streamline and the way across,
    /// both refined; it falls with the depth where the patches join smoothly.
    pub plane_angle: f64,
}

/// Changes `second` so that its first streamline is the last one of `first`: tangents, parameters,
/// rules and the place of the initial curve are taken over, and the initial curve is moved to where
/// the other one ends. If `smooth`, the second streamline of `second` is set so that tangents and
/// parameters go on across the seam as they end in `first`; then the planes agree as well, if the
/// initial curves do: exactly for clamped ends, and for Kobbelt's scheme to third order in the turn
/// between streamlines.
///
/// # Errors
/// [`Error::NotKept`] if the scheme does not keep the streamlines at the border;
/// [`Error::WrongCount`] if the rows differ in length or there are fewer than two;
/// [`Error::NotIncreasing`] if the parameters that go on do not increase. `second` is unchanged then.
pub fn stitch(first: &Model, second: &mut Model, smooth: bool) -> Result<(), Error> {
    if first.scheme != Scheme::Kobbelt && first.ends != Ends::Clamped {
        return Err(Error::NotKept { scheme: first.scheme.name() });
    }
    let columns = first.tangents.column_count();
    let (last, rows) = (first.tangents.row_count(), second.tangents.row_count());
    let counts = [
        ("tangents", "columns, as in the other patch", columns, second.tangents.column_count()),
        ("s", "columns, as in the other patch", columns, second.s.column_count()),
    ];
    for (field, what, expected, count) in counts {
        if expected != count {
            return Err(Error::WrongCount { field, what, expected, count });
        }
    }
    if let Some(&count) = [last, rows].iter().find(|&&count| count < 2) {
        let (field, what) = ("tangents", "rows, for a patch with two sides");
        return Err(Error::WrongCount { field, what, expected: 2, count });
    }
    let last = last - 1;
    let mut stitched = Model {
        start: first.start,
        scheme: first.scheme,
        order: first.order,
        ends: first.ends,
        w: first.w,
        blend: first.blend,
        integration: first.integration,
        depth: first.depth,
        ..second.clone()
    };
    stitched.tangents.row_mut(0).copy_from_slice(first.tangents.row(last));
    stitched.s.row_mut(0).copy_from_slice(first.s.row(last));
    if smooth {
        go_on(first, &mut stitched)?;
    }
    let end = first.initial.points(&[first.t[last]])?[0];
    let begin = second.initial.points(&[second.t[0]])?[0];
    stitched.initial.shift(end - begin);
    *second = stitched;
    Ok(())
}

/// Sets the second streamline so that derivatives across the seam are those of the other patch.
///
/// The derivative at the end of a refined sequence is, from its elements $`a_1, a_2`$ less $`a_0`$,
/// $`(a_1 - \tfrac w8 a_2) / (1 - \tfrac w4)`$ for the four-point rule, whose reflection makes an odd
/// sequence, and $`a_1`$ for clamped B-splines, as if $`w = 0`$.
fn go_on(first: &Model, second: &mut Model) -> Result<(), Error> {
    let last = first.t.len() - 1;
    // Near 4 the rule has no derivative to speak of.
    let third =
        first.scheme == Scheme::Kobbelt && last.min(second.t.len() - 1) >= 2 && first.w < 3.5;
    let w = if third { first.w } else { 0.0 };
    let (own, next) = (1.0 - 0.25 * w, 0.125 * w);
    // Rows away from the seam; the next one but one counts nothing where it may not exist.
    let far = if third { 2 } else { 1 };
    let derivative = |away: &dyn Fn(usize) -> f64| (away(1) - next * away(far)) / own;
    let before = derivative(&|k| first.t[last] - first.t[last - k]);
    let after = derivative(&|k| second.t[k] - second.t[0]);
    let ratio = -after / before;
    for i in 0..first.tangents.column_count() {
        let here = first.tangents[(last, i)];
        let away = |k: usize| log(here, first.tangents[(last - k, i)]);
        let derivative = (ratio / own) * (away(1) - next * away(far));
        let onward = log(here, second.tangents[(far, i)]);
        second.tangents[(1, i)] = exp(here, own * derivative + next * onward);
        let here = first.s[(last, i)];
        let away = |k: usize| first.s[(last - k, i)] - here;
        let derivative = (ratio / own) * (away(1) - next * away(far));
        second.s[(1, i)] = here + own * derivative + next * (second.s[(far, i)] - here);
    }
    super::increasing(second.s.row(1)).map_err(|column| Error::NotIncreasing {
        level: 0,
        row: 1,
        column,
    })
}

/// How well the last streamline of a surface and the first of another agree; `None` if they have
/// different numbers of points.
#[must_use]
pub fn seam(first: &Surface, second: &Surface) -> Option<Seam> {
    let rows = first.points().row_count();
    let (a, b) = (first.points().row(rows - 1), second.points().row(0));
    let (s, t) = (first.tangents().row(rows - 1), second.tangents().row(0));
    if a.len() != b.len() || s.len() != t.len() {
        return None;
    }
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    let gap = largest(&mut a.iter().zip(b).map(|(a, b)| (*a - *b).length()));
    let tangent_angle = largest(&mut s.iter().zip(t).map(|(s, t)| sphere::angle(*s, *t)));
    let mut plane_angle = 0.0;
    if rows > 1 && second.points().row_count() > 1 {
        let (before, after) = (first.points().row(rows - 2), second.points().row(1));
        for i in 0..a.len() {
            let along = s[i.min(s.len() - 1)];
            let normals = [a[i] - before[i], after[i] - b[i]].map(|d| along.cross(d).normalized());
            // No plane where the streamline runs across.
            if normals.iter().all(|n| *n != Vec3::ZERO) {
                plane_angle = f64::max(plane_angle, sphere::angle(normals[0], normals[1]));
            }
        }
    }
    Some(Seam { gap, tangent_angle, plane_angle })
}

/// Surfaces whose vertices along shared streamlines are the same.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Joined {
    /// Surface by surface, row by row; what is there already is not repeated.
    pub positions: Vec<Vec3>,
    /// Surface by surface, as those of [`Surface::mesh`].
    pub faces: Faces,
    /// For each surface the vertex of each of its points.
    pub vertices: Vec<Grid<u32>>,
}

impl Joined {
    /// The mesh.
    ///
    /// # Errors
    /// As [`Surface::mesh`].
    pub fn into_mesh(self) -> Result<Mesh, crate::Error> {
        Mesh::new(self.positions, &self.faces)
    }
}

/// Joins each surface to the one before where the last streamline of the one and the first of the
/// other agree to `tolerance`, the largest distance of their points; and the last to the first, which
/// may be the same, so that a tube is closed. Vertices are those of the surface that comes first.
/// Streamlines are not joined where that would leave a tube with fewer than three.
#[must_use]
pub fn join(surfaces: &[Surface], tolerance: f64) -> Joined {
    let mut joined = Joined::default();
    // Streamlines in the chain of surfaces joined so far, without those that are shared.
    let (mut chain_length, mut chain_start) = (0, 0);
    for (i, surface) in surfaces.iter().enumerate() {
        let points = surface.points();
        let (rows, columns) = (points.row_count(), points.column_count());
        let agree = |other: &Surface| seam(other, surface).is_some_and(|s| s.gap <= tolerance);
        let before = i.checked_sub(1).filter(|&i| agree(&surfaces[i]));
        let mut numbers = Vec::with_capacity(points.values().len());
        if let Some(before) = before {
            let last = &joined.vertices[before];
            numbers.extend_from_slice(last.row(last.row_count() - 1));
            chain_length += rows - 1;
        } else {
            (chain_length, chain_start) = (rows, i);
        }
        let closing = i + 1 == surfaces.len()
            && rows > 1
            && (chain_start > 0 || chain_length > 3)
            && seam(surface, &surfaces[0]).is_some_and(|s| s.gap <= tolerance);
        let new = numbers.len()..if closing { (rows - 1) * columns } else { rows * columns };
        let next = joined.positions.len() as u32;
        numbers.extend(next..next + new.len() as u32);
        joined.positions.extend_from_slice(&points.values()[new]);
        if closing {
            match joined.vertices.first() {
                Some(first) => numbers.extend_from_slice(first.row(0)),
                None => numbers.extend_from_within(..columns),
            }
        }
        for face in surface.faces().iter() {
            let corners: Vec<u32> = face.iter().map(|&v| numbers[v as usize]).collect();
            joined.faces.push(&corners);
        }
        let numbers = numbers.chunks_exact(columns).map(<[u32]>::to_vec);
        joined.vertices.push(Grid::collected(numbers));
    }
    joined
}

impl InitialCurve {
    /// Moves the whole curve.
    fn shift(&mut self, by: Vec3) {
        match self {
            Self::Polyline { points, .. } | Self::Bspline { points, .. } => {
                points.iter_mut().for_each(|p| *p += by);
            }
            Self::Qi { start, .. } => *start += by,
        }
    }
}
