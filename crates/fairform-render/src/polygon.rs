//! Triangles that fill a polygon, convex or not, flat or warped.

use fairform::Vec3;

/// A corner of a filling triangle: a corner of the polygon, or the point in its middle.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum Corner {
    /// Counted along the polygon.
    At(usize),
    /// The mean of all corners.
    Middle,
}

/// Sum of the vector products of consecutive corners: along the normal, twice the area long. \[Newell\]
pub(crate) fn area_vector(p: &[Vec3]) -> Vec3 {
    let n = p.len();
    (1..n.saturating_sub(1)).map(|i| (p[i] - p[0]).cross(p[i + 1] - p[0])).sum()
}

/// Calls `emit` for each triangle of a polygon of at least three corners, turning as it does.
///
/// A convex polygon becomes a star around its middle, which looks the same from all its corners
/// also where it is warped; a flat quad its two triangles along the shorter diagonal; any other
/// polygon loses ear after ear. \[Meisters1975\]
pub(crate) fn fill(p: &[Vec3], mut emit: impl FnMut([Corner; 3])) {
    let n = p.len();
    if n == 3 {
        return emit([0, 1, 2].map(Corner::At));
    }
    let area = area_vector(p);
    let flat = flattened(p, area);
    let convex = (0..n).all(|i| turn(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) >= 0.0);
    // Turning left everywhere can also mean going around several times.
    if convex && (n == 4 || is_star_around_middle(&flat)) {
        if n == 4 && is_flat_quad(p, area) {
            let long = (p[2] - p[0]).length() > (p[3] - p[1]).length();
            let quad = if long { [[1, 2, 3], [3, 0, 1]] } else { [[0, 1, 2], [2, 3, 0]] };
            return quad.into_iter().for_each(|t| emit(t.map(Corner::At)));
        }
        return (0..n).for_each(|i| {
            emit([Corner::At(i), Corner::At((i + 1) % n), Corner::Middle]);
        });
    }
    clip_ears(&flat, |t| emit(t.map(Corner::At)));
}

/// Whether the fourth corner is off the plane of the others by no more than about a hundredth of the size.
fn is_flat_quad(p: &[Vec3], area: Vec3) -> bool {
    let [a, b] = [p[2] - p[0], p[3] - p[1]];
    let volume = a.cross(b).normalized().dot(p[1] - p[0]);
    volume.abs() <= 0.005 * area.length().sqrt()
}

fn is_star_around_middle(flat: &[[f64; 2]]) -> bool {
    let n = flat.len();
    let [x, y] = flat.iter().fold([0.0, 0.0], |[x, y], q| [x + q[0], y + q[1]]);
    let middle = [x / n as f64, y / n as f64];
    let (mut once, mut all) = (0, true);
    for i in 0..n {
        let [a, b] = [flat[i], flat[(i + 1) % n]];
        all &= turn(a, b, middle) >= 0.0;
        // Times that the border crosses the ray to the right of the middle, upwards.
        once += usize::from(a[1] < middle[1] && b[1] >= middle[1]);
    }
    all && once == 1
}

/// The polygon seen along its area vector, turning left.
fn flattened(p: &[Vec3], area: Vec3) -> Vec<[f64; 2]> {
    let n = area.normalized();
    let n = if n == Vec3::ZERO { Vec3::new(0.0, 0.0, 1.0) } else { n };
    let least = if n.x.abs() <= n.y.abs() && n.x.abs() <= n.z.abs() {
        Vec3::new(1.0, 0.0, 0.0)
    } else if n.y.abs() <= n.z.abs() {
        Vec3::new(0.0, 1.0, 0.0)
    } else {
        Vec3::new(0.0, 0.0, 1.0)
    };
    let u = least.cross(n).normalized();
    let v = n.cross(u);
    p.iter().map(|&q| [(q - p[0]).dot(u), (q - p[0]).dot(v)]).collect()
}

/// Twice the area of a triangle, positive if it turns left.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn clip_ears(p: &[[f64; 2]], mut emit: impl FnMut([usize; 3])) {
    let n = p.len();
    let mut next: Vec<usize> = (0..n).map(|i| (i + 1) % n).collect();
    let mut last: Vec<usize> = (0..n).map(|i| (i + n - 1) % n).collect();
    // Only a corner that turns right can lie in an ear; once it turns left it stays so.
    let mut right: Vec<usize> =
        (0..n).filter(|&i| turn(p[last[i]], p[i], p[next[i]]) < 0.0).collect();
    let mut left = n;
    let (mut at, mut refused) = (0, 0);
    // Ears of a huge crooked polygon take the square of its size; the rest is then cut anyhow.
    let mut patience = 1024 * n;
    while left > 3 {
        let (a, b) = (last[at], next[at]);
        let area = turn(p[a], p[at], p[b]);
        let is_ear = refused >= left
            || patience == 0
            || area >= 0.0 && {
                patience = patience.saturating_sub(right.len() + 1);
                !right.iter().any(|&r| {
                    let q = p[r];
                    // A corner at the same place as one of the ear's is in the way of none.
                    r != at
                        && ![p[a], p[at], p[b]].contains(&q)
                        && turn(p[a], p[at], q) >= 0.0
                        && turn(p[at], p[b], q) >= 0.0
                        && turn(p[b], p[a], q) >= 0.0
                })
            };
        if !is_ear {
            at = b;
            refused += 1;
            continue;
        }
        emit([a, at, b]);
        next[a] = b;
        last[b] = a;
        left -= 1;
        refused = 0;
        let gone = at;
        right.retain(|&r| {
            r != gone && (r != a && r != b || turn(p[last[r]], p[r], p[next[r]]) < 0.0)
        });
        // Skipping one keeps the triangles fat.
        at = next[b];
    }
    emit([last[at], at, next[at]]);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangles(p: &[Vec3]) -> Vec<[Vec3; 3]> {
        let middle = p.iter().copied().sum::<Vec3>() / p.len() as f64;
        let mut all = Vec::new();
        fill(p, |t| {
            all.push(t.map(|c| match c {
                Corner::At(i) => p[i],
                Corner::Middle => middle,
            }));
        });
        all
    }

    /// The triangles turn as the polygon does and have its area: they cover it once.
    fn assert_filled(p: &[Vec3]) {
        let whole = area_vector(p);
        let mut sum = 0.0;
        for t in triangles(p) {
            let part = area_vector(&t).dot(whole.normalized());
            assert!(part >= -1e-12, "{t:?} is turned over");
            sum += part;
        }
        assert!(
            (sum - whole.length()).abs() < 1e-12 * whole.length(),
            "{sum} of {}",
            whole.length()
        );
    }

    fn plane(points: &[[f64; 2]]) -> Vec<Vec3> {
        // On a slanted plane, so that no axis is special.
        points.iter().map(|&[x, y]| Vec3::new(x, y, 0.3 * x - 0.7 * y + 2.0)).collect()
    }

    #[test]
    fn polygons_are_covered_once() {
        assert_filled(&plane(&[[0., 0.], [1., 0.], [1., 1.], [0., 1.]]));
        assert_filled(&plane(&[[0., 0.], [4., 0.], [1., 1.], [0., 4.]]));
        assert_filled(&plane(&[
            [0., 0.],
            [4., 0.],
            [4., 4.],
            [3., 4.],
            [3., 1.],
            [1., 1.],
            [1., 4.],
            [0., 4.],
        ]));
        for n in [5, 6, 32, 301] {
            let ring = |r: &dyn Fn(usize) -> f64| -> Vec<[f64; 2]> {
                (0..n)
                    .map(|i| {
                        let t = std::f64::consts::TAU * i as f64 / n as f64;
                        [r(i) * libm::cos(t), r(i) * libm::sin(t)]
                    })
                    .collect()
            };
            assert_filled(&plane(&ring(&|_| 1.0)));
            assert_filled(&plane(&ring(&|i| if i % 2 == 0 { 1.0 } else { 0.4 })));
        }
    }

    /// A spiral has no star point, and most of its corners turn right.
    #[test]
    fn a_spiral_is_covered_once() {
        let arm = |r: f64| {
            (0..100).map(move |i| {
                let t = 0.2 * f64::from(i);
                [(r + t) * libm::cos(t), (r + t) * libm::sin(t)]
            })
        };
        let spiral: Vec<_> =
            arm(3.0).chain(arm(1.0).collect::<Vec<_>>().into_iter().rev()).collect();
        assert_filled(&plane(&spiral));
    }

    #[test]
    fn crossed_and_collapsed_polygons_still_end() {
        for n in 4..9 {
            assert!((n - 2..=n).contains(&triangles(&vec![Vec3::splat(1.0); n]).len()));
        }
        let star: Vec<_> = (0..5)
            .map(|i| {
                let t = 2.0 * std::f64::consts::TAU * f64::from(i) / 5.0;
                [libm::cos(t), libm::sin(t)]
            })
            .collect();
        assert!(!triangles(&plane(&star)).is_empty());
        let bow = plane(&[[0., 0.], [1., 1.], [1., 0.], [0., 1.]]);
        assert_eq!(triangles(&bow).len(), 2);
    }
}
