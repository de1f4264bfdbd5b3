//! Fairness: the numbers of surfaces that have them in closed form, reached at the stated order.

use std::f64::consts::PI;

use crate::common::{assorted, random_mesh};
use fairform::fairness::{
    Curvature, Deviation, Measures, curvatures, deviation, distances, fitted_normals, measures,
    mutual_deviation, samples, undulation, vertex_normals,
};
use fairform::interpolate::{Options, interpolate};
use fairform::{Faces, Mesh, Rules, Topology, Vec3, limit, refine, shapes};
use proptest::prelude::*;

/// A sampled surface with what is known of it at every vertex.
struct Sampled {
    mesh: Mesh,
    normals: Vec<Vec3>,
    /// Principal curvatures, the larger first.
    exact: Vec<[f64; 2]>,
}

#[derive(Clone, Copy, PartialEq, Debug)]
enum Cells {
    /// All diagonals alike: valence 6.
    Alike,
    /// Every diagonal by chance: valence 4 to 8.
    Mixed,
    Quads,
}

/// A small generator of pseudo-random numbers in [-1, 1].
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Samples a parametric surface on a grid over the unit square, periodic in the axes asked for, with
/// parameters moved at random by up to `shift` of a cell.
fn sample(
    [columns, rows]: [u32; 2],
    [around, along]: [bool; 2],
    cells: Cells,
    shift: f64,
    surface: impl Fn(f64, f64) -> (Vec3, Vec3, [f64; 2]),
) -> Sampled {
    let (points_x, points_y) = (columns + u32::from(!around), rows + u32::from(!along));
    let mut noise = Noise(0x9e37_79b9_7f4a_7c15);
    let mut sampled = (Vec::new(), Vec::new(), Vec::new());
    for j in 0..points_y {
        for i in 0..points_x {
            // Borders stay borders.
            let inner =
                |i: u32, last: u32, wraps| if wraps || (i > 0 && i < last) { shift } else { 0.0 };
            let u = (f64::from(i) + inner(i, columns, around) * noise.next()) / f64::from(columns);
            let v = (f64::from(j) + inner(j, rows, along) * noise.next()) / f64::from(rows);
            let (position, normal, k) = surface(u, v);
            sampled.0.push(position);
            sampled.1.push(normal.normalized());
            sampled.2.push(k);
        }
    }
    let at = |i: u32, j: u32| j % points_y * points_x + i % points_x;
    let mut faces = Faces::new();
    for j in 0..rows {
        for i in 0..columns {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let other = cells == Cells::Mixed && noise.next() > 0.0;
            if cells == Cells::Quads {
                faces.push(&[a, b, c, d]);
            } else if other {
                faces.push(&[a, b, d]);
                faces.push(&[b, c, d]);
            } else {
                faces.push(&[a, b, c]);
                faces.push(&[a, c, d]);
            }
        }
    }
    Sampled { mesh: Mesh::new(sampled.0, &faces).unwrap(), normals: sampled.1, exact: sampled.2 }
}

/// The graph of a function with first and second derivatives, over [-1, 1]².
fn graph(
    f: impl Fn(f64, f64) -> (f64, [f64; 2], [f64; 3]),
) -> impl Fn(f64, f64) -> (Vec3, Vec3, [f64; 2]) {
    move |u, v| {
        let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        let (z, [p, q], [r, s, t]) = f(x, y);
        let w = 1.0 + p * p + q * q;
        let gaussian = (r * t - s * s) / (w * w);
        let mean = -((1.0 + q * q) * r - 2.0 * p * q * s + (1.0 + p * p) * t) / (2.0 * w.powf(1.5));
        let d = (mean * mean - gaussian).max(0.0).sqrt();
        (Vec3::new(x, y, z), Vec3::new(-p, -q, 1.0), [mean + d, mean - d])
    }
}

fn saddle(x: f64, y: f64) -> (f64, [f64; 2], [f64; 3]) {
    (0.5 * (x * x - y * y), [x, -y], [1.0, 0.0, -1.0])
}

fn monkey(x: f64, y: f64) -> (f64, [f64; 2], [f64; 3]) {
    (
        x * x * x - 3.0 * x * y * y,
        [3.0 * (x * x - y * y), -6.0 * x * y],
        [6.0 * x, -6.0 * y, -6.0 * x],
    )
}

fn waves(x: f64, y: f64) -> (f64, [f64; 2], [f64; 3]) {
    let (a, b) = (2.0 * x + 0.3, 1.5 * y - 0.2);
    (
        0.4 * a.sin() * b.cos(),
        [0.8 * a.cos() * b.cos(), -0.6 * a.sin() * b.sin()],
        [-1.6 * a.sin() * b.cos(), -1.2 * a.cos() * b.sin(), -0.9 * a.sin() * b.cos()],
    )
}

/// The torus with radii 1 and `r`, in a frame that no axis favours.
fn torus(r: f64) -> impl Fn(f64, f64) -> (Vec3, Vec3, [f64; 2]) {
    move |u, v| {
        let (u, v) = (2.0 * PI * u, 2.0 * PI * v);
        let normal = Vec3::new(u.cos() * v.cos(), u.sin() * v.cos(), v.sin());
        let position = Vec3::new(u.cos(), u.sin(), 0.0) + r * normal;
        (position, normal, [1.0 / r, v.cos() / (1.0 + r * v.cos())])
    }
}

fn cylinder(u: f64, v: f64) -> (Vec3, Vec3, [f64; 2]) {
    let u = 2.0 * PI * u;
    let normal = Vec3::new(u.cos(), u.sin(), 0.0);
    (normal + Vec3::new(0.0, 0.0, 2.0 * v), normal, [1.0, 0.0])
}

impl Sampled {
    fn curvatures(&self) -> Vec<Curvature> {
        curvatures(self.mesh.topology(), self.mesh.positions(), &self.normals)
    }

    fn measures(&self) -> Measures {
        measures(self.mesh.topology(), self.mesh.positions(), &self.curvatures())
    }

    /// Errors of `H` and `K`: largest and root mean square of each.
    fn errors(&self) -> [f64; 4] {
        let found = self.curvatures();
        let mut e = [0.0_f64; 4];
        for (c, [k1, k2]) in found.iter().zip(&self.exact) {
            let h = (c.mean() - 0.5 * (k1 + k2)).abs();
            let k = (c.gaussian() - k1 * k2).abs();
            e = [e[0].max(h), e[1] + h * h, e[2].max(k), e[3] + k * k];
        }
        let count = found.len() as f64;
        [e[0], (e[1] / count).sqrt(), e[2], (e[3] / count).sqrt()]
    }
}

/// Order in the edge length, from errors at lengths 4 and 1.
fn order(coarse: f64, fine: f64) -> f64 {
    (coarse / fine).log2() / 2.0
}

/// The unit sphere: a closed triangle mesh refined and moved onto it.
fn sphere(base: &Mesh, levels: u32) -> Sampled {
    let (mesh, _) = refine::refine_mesh(base, &Rules::LOOP, levels).unwrap();
    let normals: Vec<Vec3> = mesh.positions().iter().map(|p| p.normalized()).collect();
    let exact = vec![[1.0; 2]; normals.len()];
    Sampled { mesh: mesh.with_positions(normals.clone()), normals, exact }
}

/// The limit surface of a control mesh, sampled at the vertices of a refinement.
fn limit_surface(control: &Mesh, levels: u32) -> Sampled {
    let (mesh, _) = refine::refine_mesh(control, &Rules::LOOP, levels).unwrap();
    let (net, points) = (mesh.topology(), mesh.positions());
    let positions = limit::limit_points(net, points, &Rules::LOOP).unwrap();
    let normals = limit::limit_normals(net, points, &Rules::LOOP).unwrap();
    Sampled { mesh: mesh.with_positions(positions), normals, exact: Vec::new() }
}

const CELLS: [Cells; 3] = [Cells::Alike, Cells::Mixed, Cells::Quads];

/// At the boundary, on perturbed samples and at every valence from 3 to 8 alike.
#[test]
fn curvature_is_of_third_order() {
    type Surface<'a> = &'a dyn Fn(u32, Cells, f64) -> Sampled;
    let surfaces: [(&str, Surface); 5] = [
        ("torus", &|n, cells, shift| sample([2 * n, n], [true; 2], cells, shift, torus(0.4))),
        ("cylinder", &|n, cells, shift| sample([2 * n, n], [true, false], cells, shift, cylinder)),
        ("saddle", &|n, cells, shift| sample([n; 2], [false; 2], cells, shift, graph(saddle))),
        ("monkey", &|n, cells, shift| sample([n; 2], [false; 2], cells, shift, graph(monkey))),
        ("waves", &|n, cells, shift| sample([n; 2], [false; 2], cells, shift, graph(waves))),
    ];
    for (name, surface) in surfaces {
        for cells in CELLS {
            for shift in [0.0, 0.3] {
                let [coarse, fine] = [16, 64].map(|n| surface(n, cells, shift).errors());
                for (i, what) in ["max H", "rms H", "max K", "rms K"].iter().enumerate() {
                    // The largest error is that of the worst-shaped neighbourhood there happens to be.
                    let least = if i % 2 == 0 { 2.2 } else { 2.7 };
                    let order = order(coarse[i], fine[i]);
                    let exact = fine[i] < 1e-11;
                    assert!(exact || order > least, "{name} {cells:?} {shift} {what}: {order}");
                    assert!(fine[i] < 0.01, "{name} {cells:?} {shift} {what}: {}", fine[i]);
                }
            }
        }
    }
    for base in [shapes::tetrahedron(), shapes::octahedron(), shapes::icosahedron()] {
        let [coarse, fine] = [3, 5].map(|levels| sphere(&base, levels).errors());
        for i in 0..4 {
            let order = order(coarse[i], fine[i]);
            assert!(
                order > 2.7,
                "valence {}, {i}: {order}",
                base.topology().fan_size(fairform::VertexId(0))
            );
            assert!(fine[i] < 1e-3, "{}", fine[i]);
        }
    }
}

#[test]
fn planes_have_no_curvature() {
    for cells in CELLS {
        let flat = |_, _| (0.0, [0.0; 2], [0.0; 3]);
        let plane = sample([9, 7], [false; 2], cells, 0.3, graph(flat));
        assert!(plane.errors().iter().all(|&e| e < 1e-14));
        let m = plane.measures();
        assert!((m.area - 4.0).abs() < 1e-14 && m.volume == 0.0 && m.euler_characteristic == 1);
        assert!(m.bending < 1e-25 && m.mean_variation < 1e-25 && m.turning < 1e-13);
    }
}

#[test]
fn principal_directions_are_those_of_the_cylinder_and_the_torus() {
    let tube = sample([40, 12], [true, false], Cells::Mixed, 0.2, cylinder);
    for (c, n) in tube.curvatures().iter().zip(&tube.normals) {
        assert!((c.directions[1].z.abs() - 1.0).abs() < 1e-3, "{c:?}");
        assert!((c.directions[0].cross(c.directions[1]) - *n).length() < 1e-12, "right-handed");
    }
    let ring = sample([80, 40], [true; 2], Cells::Quads, 0.0, torus(0.4));
    for ((c, n), p) in ring.curvatures().iter().zip(&ring.normals).zip(ring.mesh.positions()) {
        let parallel = Vec3::new(-p.y, p.x, 0.0).normalized();
        assert!(c.directions[1].dot(parallel).abs() > 1.0 - 1e-4);
        assert!((c.directions[0].cross(c.directions[1]) - *n).length() < 1e-12);
    }
}

/// On a drawn-out profile one principal curvature is that of the profile.
#[test]
fn variation_is_the_change_of_curvature_along_the_profile() {
    let profile = |x: f64, _: f64| {
        let a = 2.0 * x;
        (0.3 * a.sin(), [0.6 * a.cos(), 0.0], [-1.2 * a.sin(), 0.0, 0.0])
    };
    let errors = [16, 64].map(|n| {
        let s = sample([n; 2], [false; 2], Cells::Mixed, 0.2, graph(profile));
        let error = |(c, p): (&Curvature, &Vec3)| {
            let (sin, cos) = (2.0 * p.x).sin_cos();
            let w = 1.0 + 0.36 * cos * cos;
            // d/ds of -z'' / w^(3/2), with w = 1 + z'².
            let rate =
                2.4 * cos / w.powf(1.5) + 3.0 * 0.6 * cos * 1.2 * 1.2 * sin * sin / w.powf(2.5);
            let rate = rate.abs() / w.sqrt();
            let along = usize::from(c.directions[1].x.abs() > c.directions[0].x.abs());
            // The flat direction is a principal one, so nothing changes along it.
            let both = [c.variation[along].abs() - rate, c.variation[1 - along]];
            // At inflections the directions are arbitrary.
            if c.principal[0] - c.principal[1] < 0.1 {
                0.0
            } else {
                both[0].abs().max(both[1].abs())
            }
        };
        s.curvatures().iter().zip(s.mesh.positions()).map(error).fold(0.0, f64::max)
    });
    assert!(order(errors[0], errors[1]) > 1.4 && errors[1] < 0.05, "{errors:?}");
}

/// A name, a value, and where it stands.
type Expected = (&'static str, f64, fn(&Measures) -> f64);

/// Each measure of a surface at two densities against its value.
fn check_measures(surfaces: [Measures; 2], expected: &[Expected], name: &str) {
    for (what, value, measure) in expected {
        let [coarse, fine] = surfaces.each_ref().map(|m| (measure(m) - value).abs());
        let scale = value.abs().max(1.0);
        let order = order(coarse, fine);
        // The errors of area and curvature have opposite signs, which blurs the second order.
        assert!(order > 1.5 || fine < 1e-9 * scale, "{name} {what}: order {order}");
        assert!(fine < 0.03 * scale, "{name} {what}: off by {fine} from {value}");
    }
}

#[test]
fn measures_of_spheres() {
    for base in [shapes::octahedron(), shapes::icosahedron()] {
        let surfaces = [3, 5].map(|levels| sphere(&base, levels).measures());
        check_measures(
            surfaces,
            &[
                ("area", 4.0 * PI, |m| m.area),
                ("volume", 4.0 / 3.0 * PI, |m| m.volume),
                ("mean", 4.0 * PI, |m| m.mean),
                ("Willmore", 4.0 * PI, |m| m.willmore),
                ("bending", 8.0 * PI, |m| m.bending),
                ("Gauss-Bonnet", 4.0 * PI, |m| m.gaussian),
                ("turning", 4.0 * PI, |m| m.turning),
                ("variation of the mean", 0.0, |m| m.mean_variation),
                ("variation of the principal", 0.0, |m| m.principal_variation),
                ("sphericity", 1.0, Measures::sphericity),
                ("median", 1.0, |m| m.mean_percentiles[0]),
                ("largest", 1.0, |m| m.mean_percentiles[4]),
            ],
            "sphere",
        );
        assert_eq!(surfaces[0].euler_characteristic, 2);
    }
}

/// The Clifford torus is the one that bends least: 2π². \[Marques2014\]
#[test]
fn measures_of_the_clifford_torus() {
    let r = 0.5_f64.sqrt();
    // ∫|∇H|² is an integral over one angle, which the trapezoidal rule gets to all digits.
    let steps = 400;
    let gradient = |i: u32| {
        let (sin, cos) = (2.0 * PI * f64::from(i) / f64::from(steps)).sin_cos();
        let w = 1.0 + r * cos;
        let slope = -0.5 * sin / (w * w) / r;
        2.0 * PI * slope * slope * r * w
    };
    let variation = (0..steps).map(gradient).sum::<f64>() * 2.0 * PI / f64::from(steps);
    for cells in CELLS {
        for shift in [0.0, 0.2] {
            let surfaces = [24, 96]
                .map(|n| sample([n + n / 2, n], [true; 2], cells, shift, torus(r)).measures());
            check_measures(
                surfaces,
                &[
                    ("area", 4.0 * PI * PI * r, |m| m.area),
                    ("volume", 2.0 * PI * PI * r * r, |m| m.volume),
                    ("Willmore", 2.0 * PI * PI, |m| m.willmore),
                    ("Gauss-Bonnet", 0.0, |m| m.gaussian),
                    ("variation of the mean", variation, |m| m.mean_variation),
                    // All lines of curvature are circles.
                    ("variation of the principal", 0.0, |m| m.principal_variation),
                ],
                &format!("torus {cells:?} {shift}"),
            );
            assert_eq!(surfaces[0].euler_characteristic, 0);
        }
    }
}

#[test]
fn percentiles_are_shares_of_the_area() {
    let s = sample([96, 64], [true; 2], Cells::Alike, 0.0, torus(0.4));
    let m = s.measures();
    // |H| falls from the outer equator inwards; the part with cos v > c has a known area.
    let h = |cos: f64| 0.5 * (2.5 + cos / (1.0 + 0.4 * cos));
    let share = |v: f64| (v + 0.4 * v.sin()) / PI;
    let (mut low, mut high) = (0.0, PI);
    for _ in 0..60 {
        let v = f64::midpoint(low, high);
        if share(v) < 0.5 { low = v } else { high = v }
    }
    assert!((m.mean_percentiles[0] - h(low.cos())).abs() < 0.02, "{:?}", m.mean_percentiles);
    assert!((m.mean_percentiles[4] - h(1.0)).abs() < 0.01);
    assert!(m.mean_percentiles.windows(2).all(|w| w[0] <= w[1]));
}

/// A polygon that is not convex has its own area, and closes a volume.
#[test]
fn measures_of_a_prism_over_an_l() {
    let l = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];
    let positions =
        [0.0, 3.0].iter().flat_map(|&z| l.map(|[x, y]| Vec3::new(x + 100.0, y, z))).collect();
    let mut faces = Faces::new();
    faces.push(&[5, 4, 3, 2, 1, 0]);
    faces.push(&[6, 7, 8, 9, 10, 11]);
    for i in 0..6 {
        let j = (i + 1) % 6;
        faces.push(&[i, j, j + 6, i + 6]);
    }
    let prism = Mesh::new(positions, &faces).unwrap();
    let m = measures(prism.topology(), prism.positions(), &[Curvature::default(); 12]);
    assert!((m.area - 30.0).abs() < 1e-12 && (m.volume - 9.0).abs() < 1e-12, "{m:?}");
    // Over the notch the nearest point lies on its rim, not where an ear might be cut wrongly.
    let d = distances(&[Vec3::new(101.5, 1.25, 3.0), Vec3::new(100.5, 1.5, 3.5)], &prism);
    assert!((d[0] - 0.25).abs() < 1e-12 && (d[1] - 0.5).abs() < 1e-12, "{d:?}");
    // Six upright edges bend by a right angle, also inwards, and so do both rims.
    let turning = undulation(&m, &prism).mesh;
    assert!((turning - 0.5 * (0.5 * PI) * (6.0 * 3.0 + 2.0 * 8.0)).abs() < 1e-12, "{turning}");
}

fn map(s: &Sampled, point: impl Fn(Vec3) -> Vec3, normal: impl Fn(Vec3) -> Vec3) -> Sampled {
    Sampled {
        mesh: s.mesh.with_positions(s.mesh.positions().iter().map(|&p| point(p)).collect()),
        normals: s.normals.iter().map(|&n| normal(n)).collect(),
        exact: s.exact.clone(),
    }
}

fn rotated(v: Vec3) -> Vec3 {
    let (a, b) = (0.6 * v.x - 0.8 * v.y, 0.8 * v.x + 0.6 * v.y);
    let (c, d) = (28.0 / 53.0, 45.0 / 53.0);
    Vec3::new(a, c * b - d * v.z, d * b + c * v.z)
}

fn all_measures(m: &Measures) -> [f64; 9] {
    [
        m.area,
        m.volume,
        m.mean,
        m.willmore,
        m.bending,
        m.gaussian,
        m.turning,
        m.mean_variation,
        m.principal_variation,
    ]
}

#[track_caller]
fn assert_close(actual: f64, expected: f64, tolerance: f64) {
    let error = (actual - expected).abs();
    assert!(error <= tolerance * expected.abs().max(1e-300), "{actual:e} is not {expected:e}");
}

fn assert_all_close(actual: &Measures, expected: &Measures, tolerance: f64) {
    for (a, e) in all_measures(actual).into_iter().zip(all_measures(expected)) {
        assert!((a - e).abs() <= tolerance * e.abs().max(expected.area), "{actual:?} {expected:?}");
    }
}

#[test]
fn rotation_and_translation_change_nothing() {
    let s = limit_surface(&shapes::bipyramid(7), 3);
    let moved = map(&s, |p| rotated(p) + Vec3::new(3.0, -2.0, 5.0), rotated);
    assert_all_close(&moved.measures(), &s.measures(), 1e-8);
    for (a, b) in moved.curvatures().iter().zip(s.curvatures()) {
        for i in 0..2 {
            assert_close(a.principal[i], b.principal[i], 1e-9);
        }
    }
}

/// Powers of two change not a bit, also where squares of lengths would leave the range.
#[test]
fn scaling_laws() {
    let s = sample([30, 20], [true; 2], Cells::Mixed, 0.2, torus(0.4));
    let m = s.measures();
    for scale in [0.5_f64.powf(400.0), 0.25, 3.0, 2.0_f64.powf(300.0)] {
        let t = map(&s, |p| scale * p, |n| n).measures();
        let lengths = [2, 3, 1, 0, 0, 0, 1, -2, -2];
        for ((actual, value), power) in
            all_measures(&t).into_iter().zip(all_measures(&m)).zip(lengths)
        {
            let expected = (0..i32::abs(power))
                .fold(value, |x, _| if power > 0 { x * scale } else { x / scale });
            let expected = expected.clamp(-f64::MAX, f64::MAX);
            assert_close(actual, expected, if scale == 3.0 { 1e-8 } else { 0.0 });
        }
        if (0.1..10.0).contains(&scale) {
            assert_close(t.relative_mean_variation(), m.relative_mean_variation(), 1e-9);
            assert_close(t.sphericity(), m.sphericity(), 1e-12);
        }
        assert_close(t.mean_percentiles[2], m.mean_percentiles[2] / scale, 1e-9);
    }
}

#[test]
fn turning_the_surface_inside_out_changes_the_signs() {
    let s = sample([30, 20], [true; 2], Cells::Quads, 0.2, torus(0.4));
    let faces = s.mesh.topology().to_faces();
    let reversed: Faces =
        faces.iter().map(|f| f.iter().rev().copied().collect::<Vec<_>>()).collect();
    let net = Topology::from_faces(s.normals.len(), &reversed).unwrap();
    let normals: Vec<Vec3> = s.normals.iter().map(|&n| -n).collect();
    let turned = curvatures(&net, s.mesh.positions(), &normals);
    for (a, b) in turned.iter().zip(s.curvatures()) {
        assert_close(a.principal[0], -b.principal[1], 1e-9);
        assert_close(a.principal[1], -b.principal[0], 1e-9);
    }
    let (m, t) = (s.measures(), measures(&net, s.mesh.positions(), &turned));
    assert_close(t.volume, -m.volume, 1e-12);
    assert_close(t.mean, -m.mean, 1e-9);
    assert_close(t.willmore, m.willmore, 1e-9);
}

#[test]
fn the_numbering_does_not_matter() {
    let s = limit_surface(&shapes::bipyramid(5), 3);
    let count = s.normals.len();
    // 7919 is a prime, so that this is a permutation.
    let new = |v: usize| (v * 7919 + 13) % count;
    let mut positions = vec![Vec3::ZERO; count];
    let mut normals = vec![Vec3::ZERO; count];
    for v in 0..count {
        positions[new(v)] = s.mesh.positions()[v];
        normals[new(v)] = s.normals[v];
    }
    let list = s.mesh.topology().to_faces();
    let faces: Faces = list
        .iter()
        .collect::<Vec<_>>()
        .into_iter()
        .rev()
        .map(|f| [f[1], f[2], f[0]].map(|v| new(v as usize) as u32))
        .collect();
    let other = Sampled { mesh: Mesh::new(positions, &faces).unwrap(), normals, exact: Vec::new() };
    let (a, b) = (other.curvatures(), s.curvatures());
    for v in 0..count {
        assert_close(a[new(v)].principal[0], b[v].principal[0], 1e-9);
        assert_close(a[new(v)].principal[1], b[v].principal[1], 1e-9);
    }
    assert_all_close(&other.measures(), &s.measures(), 1e-9);
}

/// A sphere's points, fitted: the surface is nearly the sphere, the nearer the more there are.
#[test]
fn a_surface_fitted_through_points_of_a_sphere_is_nearly_a_sphere() {
    let fit = |levels: u32| {
        let target = sphere(&shapes::icosahedron(), levels).mesh;
        let (control, _) = interpolate(&target, &Rules::LOOP, &Options::default()).unwrap();
        let surface = limit_surface(&control, 3);
        (surface.measures(), mutual_deviation(&surface.mesh, &target), target)
    };
    let (coarse, deviations, target) = fit(0);
    let (fine, finer, finer_target) = fit(2);
    let willmore = |m: &Measures| (m.willmore / (4.0 * PI) - 1.0).abs();
    assert!(willmore(&coarse) < 0.02 && willmore(&fine) < 0.002, "{coarse:?} {fine:?}");
    assert!((fine.gaussian / (4.0 * PI) - 1.0).abs() < 0.001, "{fine:?}");
    // Of the icosahedron inscribed in the sphere.
    let in_radius = 0.794_654_472_291_766;
    assert!((deviations[0].max - (1.0 - in_radius)).abs() < 0.02, "{deviations:?}");
    assert!(finer[0].max < deviations[0].max / 8.0 && finer[1].max < deviations[1].max / 8.0);
    for d in deviations {
        assert!(d.mean < d.rms && d.rms < d.max && d.mean > 0.5 * d.max, "{d:?}");
    }
    // Bulging faces turn a little more than the flat ones they replace.
    for (m, mesh) in [(coarse, target), (fine, finer_target)] {
        let ratio = undulation(&m, &mesh).ratio().unwrap();
        assert!((0.99..1.12).contains(&ratio), "{ratio}");
    }
}

/// A prism with `n` sides, and a surface through its vertices that swings `ripple` to both sides of
/// the circle, `waves` times between two vertices.
#[test]
fn undulation_counts_ripples() {
    let n = 12_u32;
    let swing = |waves: f64, ripple: f64| {
        move |u: f64, v: f64| {
            let (a, m) = (2.0 * PI * u, waves * f64::from(n));
            let [r, r1, r2] = [
                1.0 + ripple * (m * a).sin(),
                m * ripple * (m * a).cos(),
                -m * m * ripple * (m * a).sin(),
            ];
            let k = (r * r + 2.0 * r1 * r1 - r * r2) / (r * r + r1 * r1).powf(1.5);
            let (sin, cos) = a.sin_cos();
            let normal = Vec3::new(r1 * sin + r * cos, r * sin - r1 * cos, 0.0);
            (Vec3::new(r * cos, r * sin, v), normal, [k.max(0.0), k.min(0.0)])
        }
    };
    let prism = sample([n, 1], [true, false], Cells::Quads, 0.0, swing(1.0, 0.0)).mesh;
    let ratio = |waves: f64, ripple: f64| {
        let surface = sample([n * 60, 2], [true, false], Cells::Alike, 0.0, swing(waves, ripple));
        let ratio = undulation(&surface.measures(), &prism).ratio().unwrap();
        // The turning angle of the profile, as an integral.
        let steps = 24000;
        let turn = |i: u32| {
            let at =
                |j: u32| swing(waves, ripple)(f64::from(j) / f64::from(steps), 0.0).1.normalized();
            at(i).cross(at(i + 1)).length().asin()
        };
        let expected = (0..steps).map(turn).sum::<f64>() / (2.0 * PI);
        assert!((ratio - expected).abs() < 0.01 * expected, "{ratio} is not {expected}");
        ratio
    };
    assert!((ratio(1.0, 0.0) - 1.0).abs() < 1e-3);
    assert!(ratio(1.0, 0.02) > 1.5, "one wave between vertices");
    assert!(ratio(3.0, 0.02) > 2.0 * ratio(1.0, 0.02), "more waves");
    let flat =
        sample([4, 4], [false; 2], Cells::Quads, 0.0, graph(|_, _| (0.0, [0.0; 2], [0.0; 3])));
    assert_eq!(undulation(&flat.measures(), &flat.mesh).ratio(), None);
}

/// Closest point on a triangle by its Voronoi regions \[Ericson2005\].
fn closest(p: Vec3, [a, b, c]: [Vec3; 3]) -> Vec3 {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(p - a), ac.dot(p - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let (d3, d4) = (ab.dot(p - b), ac.dot(p - b));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + (d1 / (d1 - d3)) * ab;
    }
    let (d5, d6) = (ab.dot(p - c), ac.dot(p - c));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + (d2 / (d2 - d6)) * ac;
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b);
    }
    a + (vb / (va + vb + vc)) * ab + (vc / (va + vb + vc)) * ac
}

fn cloud(seed: u64, count: usize) -> Vec<Vec3> {
    let mut noise = Noise(seed | 1);
    (0..count)
        .map(|_| Vec3::new(2.0 * noise.next(), 2.0 * noise.next(), 2.0 * noise.next()))
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn distances_are_those_of_the_nearest_triangle(seed: u64, splits in 0..300_usize) {
        let mesh = random_mesh(seed, splits, 3);
        let points = [cloud(seed, 60), mesh.positions().to_vec()].concat();
        let faces = mesh.topology().to_faces();
        for (&p, d) in points.iter().zip(distances(&points, &mesh)) {
            let to = |f: &[u32]| {
                let q = closest(p, [0, 1, 2].map(|i| mesh.positions()[f[i] as usize]));
                (p - q).length()
            };
            let expected = faces.iter().map(to).fold(f64::INFINITY, f64::min);
            prop_assert!((d - expected).abs() < 1e-9, "{} is not {}", d, expected);
        }
    }

    /// Whatever the numbers are, the results are finite.
    #[test]
    fn nothing_breaks(seed: u64, splits in 0..30_usize, kind in 0..8_u32) {
        let mesh = random_mesh(seed, splits, 5);
        let mut noise = Noise(seed | 1);
        let mut odd = |p: Vec3| {
            if noise.next() > 0.0 {
                return p;
            }
            match kind {
                0 => Vec3::new(f64::NAN, p.y, p.z),
                1 => Vec3::new(p.x, f64::INFINITY, -f64::INFINITY),
                2 => 1e308 * p,
                3 => 1e-308 * p,
                4 => Vec3::ZERO,
                5 => Vec3::new(p.x, 0.0, 0.0),
                6 => 1e-200 * p + Vec3::splat(1.0),
                _ => Vec3::splat(f64::MAX),
            }
        };
        let positions: Vec<Vec3> = mesh.positions().iter().map(|&p| odd(p)).collect();
        let normals: Vec<Vec3> = mesh.positions().iter().map(|&p| odd(p)).collect();
        let bad = mesh.with_positions(positions.clone());
        for normals in [normals, vertex_normals(mesh.topology(), &positions)] {
            let c = curvatures(mesh.topology(), &positions, &normals);
            for c in &c {
                prop_assert!(c.principal.iter().chain(&c.variation).all(|k| k.is_finite()), "{:?}", c);
                prop_assert!(c.principal[0] >= c.principal[1]);
                prop_assert!(c.directions.iter().all(|d| d.is_finite() && d.length() < 1.0 + 1e-9));
                prop_assert!(c.gaussian().is_finite() && c.mean().is_finite());
            }
            let m = measures(mesh.topology(), &positions, &c);
            prop_assert!(all_measures(&m).iter().chain(&m.mean_percentiles).all(|x| x.is_finite()), "{:?}", m);
            prop_assert!(m.relative_mean_variation().is_finite() && m.sphericity().is_finite());
            let u = undulation(&m, &bad);
            prop_assert!(u.surface.is_finite() && u.mesh.is_finite(), "{:?}", u);
        }
        for (surface, mesh) in [(&bad, &mesh), (&mesh, &bad), (&bad, &bad)] {
            for d in mutual_deviation(surface, mesh) {
                prop_assert!(d.max.is_finite() && d.mean.is_finite() && d.rms.is_finite(), "{:?}", d);
            }
        }
    }
}

#[test]
fn every_mesh_has_finite_measures_and_lies_on_itself() {
    for (name, mesh) in assorted() {
        let normals = vertex_normals(mesh.topology(), mesh.positions());
        let c = curvatures(mesh.topology(), mesh.positions(), &normals);
        let m = measures(mesh.topology(), mesh.positions(), &c);
        assert!(all_measures(&m).iter().all(|x| x.is_finite()), "{name}: {m:?}");
        assert!(deviation(&samples(&mesh, 500), &mesh).max < 1e-15, "{name}");
        for v in mesh.topology().vertices().filter(|&v| mesh.topology().is_isolated(v)) {
            assert_eq!(c[v.index()], Curvature::default(), "{name}");
        }
    }
    let empty = Mesh::new(vec![], &Faces::new()).unwrap();
    assert_eq!(measures(empty.topology(), &[], &[]), Measures::default());
    assert_eq!(deviation(&[Vec3::splat(1.0)], &empty), Deviation::default());
    assert_eq!(mutual_deviation(&empty, &shapes::octahedron()), [Deviation::default(); 2]);
}

#[test]
fn deviation_sums_up() {
    let d = Deviation::of(&[3.0, 0.0, 4.0, 0.0]);
    assert_eq!((d.max, d.mean, d.rms), (4.0, 1.75, 2.5));
    assert_eq!(Deviation::of(&[]), Deviation::default());
    let huge = Deviation::of(&[f64::MAX; 3]);
    assert_eq!((huge.max, huge.mean), (f64::MAX, f64::MAX));
}

#[test]
fn angles_weigh_the_normals() {
    let cube = shapes::cube();
    let middle = cube.positions().iter().copied().sum::<Vec3>() / 8.0;
    for (n, p) in vertex_normals(cube.topology(), cube.positions()).iter().zip(cube.positions()) {
        assert!((*n - (*p - middle).normalized()).length() < 1e-14, "a corner of the cube");
    }
    // However a side is cut, its angle stays the same.
    let mut faces = Faces::new();
    for f in cube.topology().to_faces().iter() {
        faces.push(&[f[0], f[1], f[2]]);
        faces.push(&[f[0], f[2], f[3]]);
    }
    let cut = Topology::from_faces(8, &faces).unwrap();
    for (n, p) in vertex_normals(&cut, cube.positions()).iter().zip(cube.positions()) {
        assert!((*n - (*p - middle).normalized()).length() < 1e-14, "a corner of the cut cube");
    }
}

impl Sampled {
    /// The same samples as if only the positions were known, and the root mean square error of the
    /// normals.
    fn without_normals(mut self) -> (Self, f64) {
        let fitted = fitted_normals(self.mesh.topology(), self.mesh.positions());
        let squares = fitted.iter().zip(&self.normals).map(|(a, b)| (*a - *b).dot(*a - *b));
        let rms = (squares.sum::<f64>() / fitted.len() as f64).sqrt();
        self.normals = fitted;
        (self, rms)
    }
}

/// Of third order inside, so that the curvature is of second; of one order less at the boundary.
#[test]
fn normals_can_be_fitted() {
    for cells in CELLS {
        for (inside, least) in [(true, [2.8, 1.8]), (false, [2.2, 1.3])] {
            let [coarse, fine] = [16, 64].map(|n| {
                let s = if inside {
                    sample([2 * n, n], [true; 2], cells, 0.2, torus(0.4))
                } else {
                    sample([n; 2], [false; 2], cells, 0.2, graph(waves))
                };
                let (s, normals) = s.without_normals();
                [normals, s.errors()[1], s.errors()[3]]
            });
            let orders = [0, 1, 2].map(|i| order(coarse[i], fine[i]));
            let enough = orders[0] > least[0] && orders[1].min(orders[2]) > least[1];
            assert!(enough, "{cells:?}, inside {inside}: {orders:?}");
            assert!(fine[0] < 5e-4 && fine[1] < 0.02, "{cells:?}, inside {inside}: {fine:?}");
        }
    }
}

/// A normal that is missing is fitted, and the others are taken as they are.
#[test]
fn missing_normals_are_fitted() {
    let exact = sample([60, 40], [true; 2], Cells::Alike, 0.0, torus(0.4));
    let [max, ..] = exact.errors();
    for odd in [Vec3::ZERO, Vec3::new(f64::NAN, 0.0, 1.0), Vec3::splat(f64::INFINITY)] {
        let mut some = map(&exact, |p| p, |n| 7.0 * n);
        some.normals[17] = odd;
        some.normals[800] = odd;
        assert!(some.errors()[0] < max + 2e-3, "{:?}", some.errors());
    }
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let target = sphere(&shapes::icosahedron(), 3).mesh;
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let s = sample([120, 90], [true; 2], Cells::Mixed, 0.3, torus(0.4));
            let c = s.curvatures();
            let m = measures(s.mesh.topology(), s.mesh.positions(), &c);
            let d = distances(s.mesh.positions(), &target);
            (c, m, mutual_deviation(&s.mesh, &target), d, undulation(&m, &s.mesh))
        })
    };
    let one = run(1);
    for threads in [2, 3] {
        assert!(run(threads) == one, "{threads} threads");
    }
}
