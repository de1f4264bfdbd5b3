//! Streamline surfaces joined, turned round, and turned into B-splines.

use fairform::sphere::Ends;
use fairform::streamline::{
    BsplineSurface, Error, Grid, InitialCurve, Integration, Model, Order, Surface, join, seam,
    stitch, swap,
};
use fairform::{Scheme, Vec3};

/// Streamlines that rise and fall, higher in the middle; `y` and `phase` tell patches apart.
fn patch(scheme: Scheme, rows: usize, columns: usize, y: f64, phase: f64) -> Model {
    let tangent = |k: usize, i: usize| {
        let (u, v) = (i as f64 / (columns - 1) as f64, k as f64 / (rows - 1) as f64);
        let rise = (0.8 - 1.6 * u) * (1.0 + 0.5 * (2.0 * v + phase).sin());
        Vec3::new(1.0, 0.15 * (v - 0.5), rise).normalized()
    };
    let grid =
        Grid::from_rows((0..rows).map(|k| (0..columns).map(move |i| tangent(k, i)))).unwrap();
    let t: Vec<f64> = (0..rows).map(|k| y + k as f64).collect();
    let points = t.iter().map(|&y| Vec3::new(0.05 * y * y, y, 0.0)).collect();
    let initial = InitialCurve::Polyline { points, t: t.clone() };
    let lengths: Vec<f64> = (0..rows).map(|k| 4.0 + 0.1 * k as f64).collect();
    Model { scheme, ends: Ends::Clamped, depth: 2, ..Model::new(grid, &lengths, t, initial) }
}

fn schemes() -> [Scheme; 3] {
    [Scheme::DooSabin, Scheme::CatmullClark, Scheme::Kobbelt]
}

#[test]
fn stitched_patches_share_a_streamline() {
    for scheme in schemes() {
        for order in [Order::St, Order::Ts] {
            let first = Model { order, ..patch(scheme, 5, 6, 0.0, 0.0) };
            let mut second = patch(scheme, 6, 6, 4.0, 1.0);
            let apart =
                seam(&Surface::new(first.clone()).unwrap(), &Surface::new(second.clone()).unwrap());
            assert!(apart.unwrap().gap > 0.01, "they differ before");
            stitch(&first, &mut second, false).unwrap();
            let (a, b) = (Surface::new(first).unwrap(), Surface::new(second).unwrap());
            let seam = seam(&a, &b).unwrap();
            assert!(seam.gap < 1e-13, "{scheme} {order:?}: gap {}", seam.gap);
            assert!(seam.tangent_angle < 1e-14, "{scheme}: {}", seam.tangent_angle);
            let joined = join(&[a.clone(), b.clone()], 1e-9);
            for (surface, vertices) in [&a, &b].into_iter().zip(&joined.vertices) {
                for (p, &v) in surface.points().values().iter().zip(vertices.values()) {
                    assert!((joined.positions[v as usize] - *p).length() < 1e-13);
                }
            }
            let mesh = joined.into_mesh().unwrap();
            let shared = a.points().column_count();
            let all = a.points().values().len() + b.points().values().len();
            assert_eq!(mesh.topology().vertex_count(), all - shared);
            assert_eq!(mesh.topology().boundary_loops().len(), 1);
            // Too far apart to be joined.
            let apart = join(&[a, b], -1.0).into_mesh().unwrap();
            assert_eq!(apart.topology().boundary_loops().len(), 2);
        }
    }
}

/// Streamlines straight along x through corners of a prism over the y-z plane, from corner to corner.
fn side(corners: std::ops::RangeInclusive<usize>, of: usize) -> Surface {
    let corner = |k: usize| {
        let angle = std::f64::consts::TAU * (k % of) as f64 / of as f64;
        Vec3::new(0.0, angle.cos(), angle.sin())
    };
    let t: Vec<f64> = corners.clone().map(|k| k as f64).collect();
    let points = corners.map(corner).collect();
    let initial = InitialCurve::Polyline { points, t: t.clone() };
    let grid = Grid::filled(t.len(), 2, Vec3::new(1.0, 0.0, 0.0));
    Surface::new(Model::new(grid, &vec![2.0; t.len()], t, initial)).unwrap()
}

#[test]
fn patches_round_a_tube_are_closed() {
    // One patch, several, with what is not shared in between, and too few to be a tube.
    for (patches, vertices, loops) in [
        (vec![side(0..=5, 5)], 5, 2),
        (vec![side(0..=2, 5), side(2..=5, 5)], 5, 2),
        (vec![side(0..=1, 3), side(1..=2, 3), side(2..=3, 3)], 3, 2),
        (vec![side(0..=1, 5), side(2..=3, 5), side(3..=5, 5)], 5, 1),
        (vec![side(0..=1, 5), side(3..=5, 5)], 4, 1),
        (vec![side(0..=4, 5)], 5, 1),
        (vec![side(0..=2, 2)], 3, 1),
    ] {
        let joined = join(&patches, 0.0);
        let columns = patches[0].points().column_count();
        assert_eq!(joined.positions.len(), vertices * columns);
        let faces: usize = patches.iter().map(|p| (p.t().len() - 1) * (columns - 1)).sum();
        assert_eq!(joined.faces.len(), faces);
        // In order of first use, row by row.
        let mut next = 0;
        for &v in joined.vertices.iter().flat_map(Grid::values) {
            assert!(v <= next);
            next = next.max(v + 1);
        }
        let mesh = joined.into_mesh().unwrap();
        assert_eq!(mesh.topology().boundary_loops().len(), loops);
        assert_eq!(mesh.topology().vertex_count(), vertices * columns);
    }
    assert_eq!(join(&[], 1.0).positions, []);
}

/// Where a patch goes on smoothly, the angle between the planes halves with each step; without, a
/// crease stays.
#[test]
fn smooth_stitches_have_no_crease() {
    for scheme in schemes() {
        let angle = |depth: u32, smooth: bool| {
            let first = Model { depth, ..patch(scheme, 6, 7, 0.0, 0.0) };
            let mut second = Model { ..patch(scheme, 6, 7, 5.0, 2.0) };
            // The initial curves continue straight.
            for model in [&first.initial, &second.initial] {
                assert!(matches!(model, InitialCurve::Polyline { .. }));
            }
            let straight = |model: &mut Model| {
                let InitialCurve::Polyline { points, t } = &mut model.initial else { return };
                points.iter_mut().zip(t).for_each(|(p, t)| *p = Vec3::new(0.0, *t, 0.0));
            };
            let mut first = first;
            straight(&mut first);
            straight(&mut second);
            stitch(&first, &mut second, smooth).unwrap();
            let (a, b) = (Surface::new(first).unwrap(), Surface::new(second).unwrap());
            seam(&a, &b).unwrap().plane_angle
        };
        let smooth: Vec<f64> = (1..5).map(|depth| angle(depth, true)).collect();
        if scheme == Scheme::Kobbelt {
            assert!(smooth[3] < 0.01, "{scheme}: {smooth:?}");
        } else {
            assert!(smooth[3] < 0.7 * smooth[2] && smooth[3] < 0.01, "{scheme}: {smooth:?}");
        }
        let sharp = angle(4, false);
        assert!(sharp > 3.0 * smooth[3], "{scheme}: {sharp} {smooth:?}");
    }
}

#[test]
fn patches_that_cannot_be_stitched_are_named() {
    let natural = Model { ends: Ends::Natural, ..patch(Scheme::DooSabin, 5, 6, 0.0, 0.0) };
    let mut second = patch(Scheme::DooSabin, 5, 6, 4.0, 1.0);
    let before = second.clone();
    assert!(matches!(stitch(&natural, &mut second, false), Err(Error::NotKept { .. })));
    let first = patch(Scheme::Kobbelt, 5, 7, 0.0, 0.0);
    assert!(matches!(stitch(&first, &mut second, true), Err(Error::WrongCount { .. })));
    assert_eq!(second, before);
}

/// The surface with exchanged directions comes nearer at second order.
#[test]
fn exchanging_directions_keeps_the_surface() {
    let model = Model {
        depth: 5,
        integration: Integration::Arcs,
        ..patch(Scheme::CatmullClark, 7, 8, 0.0, 0.3)
    };
    let surface = Surface::new(model).unwrap();
    let deviation = |count: usize| {
        let swapped = swap(&surface, count, count).unwrap();
        let other = Surface::new(Model { depth: 3, ..swapped }).unwrap();
        // From each point of the coarse net to the nearest of the dense surface.
        let net = other.points();
        let mut worst = 0.0f64;
        for k in (0..net.row_count()).step_by(4) {
            for i in (0..net.column_count()).step_by(4) {
                let nearest = surface.points().values().iter();
                let nearest =
                    nearest.map(|p| (*p - net[(k, i)]).length()).fold(f64::INFINITY, f64::min);
                worst = worst.max(nearest);
            }
        }
        worst
    };
    // The points of the surface are some 0.05 apart, so nearer cannot be told.
    let [coarse, fine] = [5, 9].map(deviation);
    assert!(fine < 0.06, "{coarse} {fine}");
    // Corner to corner.
    let swapped = Surface::new(Model { depth: 4, ..swap(&surface, 17, 17).unwrap() }).unwrap();
    let (a, b) = (surface.points(), swapped.points());
    let last = |g: &Grid<Vec3>| [g.row_count() - 1, g.column_count() - 1];
    let ([ra, ca], [rb, cb]) = (last(a), last(b));
    assert!((a[(0, 0)] - b[(0, 0)]).length() < 1e-12);
    assert!((a[(0, ca)] - b[(rb, 0)]).length() < 1e-12);
    assert!((a[(ra, 0)] - b[(0, cb)]).length() < 0.01);
    assert!((a[(ra, ca)] - b[(rb, cb)]).length() < 0.01);
}

#[test]
fn a_bspline_surface_is_within_its_tolerance() {
    for scheme in schemes() {
        let points = [0.0, 1.0, 2.5, 4.0, 5.0].map(|y| Vec3::new(0.05 * y * y, y, 0.0)).to_vec();
        let initial = InitialCurve::Bspline {
            points,
            weights: None,
            degree: 3,
            knots: None,
            t0: 0.0,
            t1: 5.0,
        };
        let model = Model { initial, ..patch(scheme, 6, 9, 0.0, 0.5) };
        let mut sizes = Vec::new();
        for tolerance in [1e-2, 1e-3, 1e-4] {
            let fit = BsplineSurface::fit(&model, tolerance).unwrap();
            assert!(fit.deviation <= tolerance);
            sizes.push(fit.points.values().len());
            // Against another, finer refinement than the one it was fitted to.
            let fine =
                Surface::new(Model { depth: 6, integration: Integration::Arcs, ..model.clone() });
            let fine = fine.unwrap();
            let corners = [(0, 0, 0.0, 0.0), (0, 1, 1.0, 0.0), (1, 0, 0.0, 1.0), (1, 1, 1.0, 1.0)];
            let [rows, columns] = [fine.points().row_count() - 1, fine.points().column_count() - 1];
            for (k, i, u, v) in corners {
                let p = fine.points()[(k * rows, i * columns)];
                assert!((fit.at(u, v) - p).length() < 10.0 * tolerance, "{scheme} {tolerance}");
            }
            for k in (0..=rows).step_by(7) {
                for i in (0..=columns).step_by(11) {
                    let (s, t) = (fine.s(), fine.t());
                    let mean: f64 = (0..=rows)
                        .map(|k| (s[(k, i)] - s[(k, 0)]) / (s[(k, columns)] - s[(k, 0)]))
                        .sum::<f64>()
                        / (rows + 1) as f64;
                    let v = (t[k] - t[0]) / (t[rows] - t[0]);
                    let off = (fit.at(mean, v) - fine.points()[(k, i)]).length();
                    assert!(off < 5.0 * tolerance, "{scheme} {tolerance}: {off}");
                }
            }
        }
        assert!(sizes[0] <= sizes[1] && sizes[1] <= sizes[2] && sizes[2] < 20_000, "{sizes:?}");
    }
    let bad = BsplineSurface::fit(&patch(Scheme::Kobbelt, 4, 4, 0.0, 0.0), 0.0);
    assert!(matches!(bad, Err(Error::BadNumber { .. })));
}

#[test]
fn knots_are_clamped() {
    let fit = BsplineSurface::fit(&patch(Scheme::Kobbelt, 4, 5, 0.0, 0.0), 1e-3).unwrap();
    let [along, across] = fit.knots();
    assert_eq!(along.len(), fit.points.column_count() + 4);
    assert_eq!(across.len(), fit.points.row_count() + 4);
    assert_eq!(along[..4], [0.0; 4]);
    assert_eq!(along[along.len() - 4..], [1.0; 4]);
}
