//! The inner loop: a few rows of weights for the points of one face, applied to its sources.

use alloc::vec::Vec;

use crate::Vec3;
use crate::wide::sqrt;

/// Rows that are worked on together.
const LANES: usize = 8;

/// The rows of some points of a face: their positions, and the two tangents on each of their sides.
#[derive(Clone, Debug, Default)]
pub(super) struct Form {
    pub(super) point_count: usize,
    /// The point of each pair of tangents, if some points have several.
    sides: Option<Vec<u32>>,
    /// Pairs of tangents.
    pair_count: usize,
    source_count: usize,
    /// Positions, first tangents, second tangents; eight rows at a time, source by source.
    weights: Vec<f64>,
}

/// Where the results of a form are put, coordinate by coordinate.
#[derive(Default)]
pub(super) struct Scratch {
    rows: [Vec<f64>; 3],
    normals: [Vec<f64>; 3],
}

/// The rows of one point: over the sources, for the position and each pair of tangents.
#[derive(Clone, Debug, Default)]
pub(super) struct PointRows {
    pub(super) position: Vec<f64>,
    pub(super) sides: Vec<[Vec<f64>; 2]>,
}

impl Form {
    pub(super) fn new<'a>(
        points: &(impl Iterator<Item = &'a PointRows> + Clone),
        source_count: usize,
    ) -> Self {
        let pairs = || points.clone().flat_map(|p| &p.sides);
        let mut rows: Vec<&[f64]> = points.clone().map(|p| p.position.as_slice()).collect();
        let point_count = rows.len();
        rows.extend(pairs().map(|t| t[0].as_slice()));
        rows.extend(pairs().map(|t| t[1].as_slice()));
        let mut weights = Vec::with_capacity(rows.len().next_multiple_of(LANES) * source_count);
        for block in rows.chunks(LANES) {
            for s in 0..source_count {
                weights.extend((0..LANES).map(|l| block.get(l).map_or(0.0, |row| row[s])));
            }
        }
        let sides: Vec<u32> = (0..)
            .zip(points.clone())
            .flat_map(|(i, p)| core::iter::repeat_n(i, p.sides.len()))
            .collect();
        let pair_count = sides.len();
        let is_plain = points.clone().all(|p| p.sides.len() == 1);
        let sides = (!is_plain).then_some(sides);
        Self { point_count, sides, pair_count, source_count, weights }
    }

    /// Applies the rows to some values: of the positions alone, or all.
    #[inline(always)]
    pub(super) fn evaluate(&self, sources: &[[f64; 3]], scratch: &mut Scratch, with_normals: bool) {
        let pairs = if with_normals { self.pair_count } else { 0 };
        let row_count = self.point_count + 2 * pairs;
        let Scratch { rows, normals } = scratch;
        assert_eq!(sources.len(), self.source_count, "one value per source");
        for row in rows.iter_mut().filter(|row| row.len() < row_count + LANES) {
            row.resize(row_count + LANES, 0.0);
        }
        let most = self.point_count.max(pairs);
        for normal in normals.iter_mut().filter(|normal| normal.len() < most) {
            normal.resize(most, 0.0);
        }
        product(&self.weights, sources, rows, row_count.div_ceil(LANES));
        one_sided(rows, self.point_count, pairs, normals);
        if let Some(sides) = self.sides.as_ref().filter(|_| with_normals) {
            self.add_sides(sides, normals);
        }
    }

    /// The normals of points from those of their sides.
    fn add_sides(&self, sides: &[u32], normals: &mut [Vec<f64>; 3]) {
        let mut sums = alloc::vec![Vec3::ZERO; self.point_count];
        for (pair, &point) in sides.iter().enumerate() {
            sums[point as usize] += Vec3::new(normals[0][pair], normals[1][pair], normals[2][pair]);
        }
        for (i, sum) in sums.into_iter().enumerate() {
            let n = sum.normalized();
            (normals[0][i], normals[1][i], normals[2][i]) = (n.x, n.y, n.z);
        }
    }
}

impl Scratch {
    #[inline(always)]
    pub(super) fn positions(&self, count: usize) -> impl Iterator<Item = Vec3> + '_ {
        triples(&self.rows, count)
    }

    #[inline(always)]
    pub(super) fn normals(&self, count: usize) -> impl Iterator<Item = Vec3> + '_ {
        triples(&self.normals, count)
    }
}

/// Appends the points of some vertices.
#[inline(always)]
pub(super) fn gather(vertices: &[u32], points: &[Vec3], out: &mut Vec<[f64; 3]>) {
    out.extend(vertices.iter().map(|&v| {
        let p = points[v as usize];
        [p.x, p.y, p.z]
    }));
}

#[inline(always)]
fn triples([x, y, z]: &[Vec<f64>; 3], count: usize) -> impl Iterator<Item = Vec3> + '_ {
    x[..count].iter().zip(&y[..count]).zip(&z[..count]).map(|((&x, &y), &z)| Vec3::new(x, y, z))
}

/// The sums go over the sources in order, whatever the lane: so a point has the same bits in every
/// form that it is a part of.
#[inline(always)]
fn product(weights: &[f64], sources: &[[f64; 3]], [x, y, z]: &mut [Vec<f64>; 3], blocks: usize) {
    let size = LANES * sources.len();
    let (x, y, z) =
        (x.as_chunks_mut::<LANES>().0, y.as_chunks_mut::<LANES>().0, z.as_chunks_mut::<LANES>().0);
    let out = x.iter_mut().zip(y).zip(z);
    for (block, ((x, y), z)) in weights.chunks_exact(size.max(1)).take(blocks).zip(out) {
        let mut sum = [[0.0; LANES]; 3];
        for (w, p) in block.as_chunks::<LANES>().0.iter().zip(sources) {
            for l in 0..LANES {
                sum[0][l] += w[l] * p[0];
                sum[1][l] += w[l] * p[1];
                sum[2][l] += w[l] * p[2];
            }
        }
        [*x, *y, *z] = sum;
    }
}

/// The unit normals of pairs of tangents.
#[inline(always)]
fn one_sided([x, y, z]: &[Vec<f64>; 3], first: usize, pairs: usize, normals: &mut [Vec<f64>; 3]) {
    let of = |row: usize| {
        let range = row..row + pairs;
        (&x[range.clone()], &y[range.clone()], &z[range])
    };
    let ((ax, ay, az), (bx, by, bz)) = (of(first), of(first + pairs));
    let [nx, ny, nz] = normals;
    let (nx, ny, nz) = (&mut nx[..pairs], &mut ny[..pairs], &mut nz[..pairs]);
    let is_usual = |square: f64| square > 1e-200 && square < 1e200;
    let mut all_usual = true;
    for i in 0..pairs {
        let x = ay[i] * bz[i] - az[i] * by[i];
        let y = az[i] * bx[i] - ax[i] * bz[i];
        let z = ax[i] * by[i] - ay[i] * bx[i];
        let square = x * x + y * y + z * z;
        all_usual &= is_usual(square);
        let length = sqrt(square);
        (nx[i], ny[i], nz[i]) = (x / length, y / length, z / length);
    }
    if all_usual {
        return;
    }
    // Scaled first, so that no product of tiny or huge tangents under- or overflows.
    for i in 0..pairs {
        let (a, b) = (Vec3::new(ax[i], ay[i], az[i]), Vec3::new(bx[i], by[i], bz[i]));
        let plain = a.cross(b);
        if !is_usual(plain.dot(plain)) {
            let n = a.normalized().cross(b.normalized()).normalized();
            (nx[i], ny[i], nz[i]) = (n.x, n.y, n.z);
        }
    }
}
