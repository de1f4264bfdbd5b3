//! The roles of $`s`$ and $`t`$ exchanged.

use alloc::vec::Vec;

use crate::Vec3;
use crate::sphere::angle;

use super::{Error, Grid, InitialCurve, Integration, Model, Surface};

/// A model of nearly the same surface whose streamlines run across those of the given one: `rows` of
/// them, with `columns` tangents each, evenly chosen from the refined surface. Tangents are those of
/// circles through three neighbouring points, lengths those of the arcs between; the initial curve is
/// the first streamline of the given surface. The deviation falls with both numbers, at second order.
///
/// # Errors
/// [`Error::WrongCount`] if there are fewer than three refined streamlines, or fewer than two new rows
/// or columns are asked for; [`Error::NotIncreasing`] where streamlines touch, so that one across has
/// no length.
pub fn swap(surface: &Surface, rows: usize, columns: usize) -> Result<Model, Error> {
    let points = surface.points();
    for (what, expected, count) in [
        ("refined streamlines, to take tangents across them", 3, points.row_count()),
        ("new streamlines", 2, rows),
        ("tangents on each", 2, columns),
    ] {
        if count < expected {
            return Err(Error::WrongCount { field: "tangents", what, expected, count });
        }
    }
    let pick = |count: usize, of: usize, i: usize| {
        // Rounded to the nearest.
        (2 * i * (of - 1) + (count - 1)) / (2 * (count - 1))
    };
    let rows = rows.min(points.column_count());
    let columns = columns.min(points.row_count());
    let parameters = surface.parameters();
    // The new t: the mean arc-length parameter of the points of a column, as the grid has it.
    let mean = |i: usize| {
        let sum: f64 = parameters.column(i).map(|p| p[0]).sum();
        sum / parameters.row_count() as f64
    };
    let (mut tangents, mut s, mut t) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..rows {
        let i = pick(rows, points.column_count(), row);
        let curve: Vec<Vec3> = points.column(i).copied().collect();
        let all = circle_tangents(&curve);
        let lengths = arc_lengths(&curve, &all);
        let chosen = (0..columns).map(|j| pick(columns, curve.len(), j));
        tangents.push(chosen.clone().map(|k| all[k]).collect::<Vec<_>>());
        s.push(chosen.map(|k| lengths[k]).collect::<Vec<_>>());
        t.push(mean(i));
    }
    for (row, s) in s.iter().enumerate() {
        super::increasing(s).map_err(|column| Error::NotIncreasing { level: 0, row, column })?;
    }
    let initial = InitialCurve::Polyline {
        points: points.row(0).to_vec(),
        t: (0..points.column_count()).map(mean).collect(),
    };
    Ok(Model {
        s: Grid::collected(s),
        integration: Integration::Arcs,
        depth: surface.model().depth,
        ..Model::new(Grid::collected(tangents), &[], t, initial)
    })
}

/// At each point of a polygon the tangent of the circle through it and its neighbours; at the ends of
/// the circle through the three outermost points.
fn circle_tangents(points: &[Vec3]) -> Vec<Vec3> {
    let last = points.len() - 1;
    let at = |i: usize| {
        let middle = i.clamp(1, last - 1);
        let (a, b) = (points[middle] - points[middle - 1], points[middle + 1] - points[middle]);
        let (la, lb) = (a.length(), b.length());
        if la == 0.0 || lb == 0.0 {
            return (a + b).normalized();
        }
        let (a, b) = (a / la, b / lb);
        // The circle turns from chord to chord in proportion to their lengths.
        let tangent = (lb * a + la * b).normalized();
        if i == 0 {
            (2.0 * a.dot(tangent) * a - tangent).normalized()
        } else if i == last {
            (2.0 * b.dot(tangent) * b - tangent).normalized()
        } else {
            tangent
        }
    };
    (0..=last).map(at).collect()
}

/// Lengths from the first point on, along arcs that turn from tangent to tangent.
fn arc_lengths(points: &[Vec3], tangents: &[Vec3]) -> Vec<f64> {
    let mut sum = 0.0;
    let mut lengths = alloc::vec![0.0];
    for (p, t) in points.windows(2).zip(tangents.windows(2)) {
        let half = 0.5 * angle(t[0], t[1]);
        let stretch = if half < 1e-8 { 1.0 } else { half / libm::sin(half) };
        sum += (p[1] - p[0]).length() * stretch;
        lengths.push(sum);
    }
    lengths
}
