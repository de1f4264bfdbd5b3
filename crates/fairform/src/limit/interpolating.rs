//! Tangents of the interpolating schemes, from the neighbourhood after one step or two: there it is
//! the same for all vertices of one valence, and maps to itself.

use alloc::vec::Vec;
use core::f64::consts::PI;

use libm::{cos, sin};

use crate::error::Error;
use crate::ids::{EdgeId, HalfedgeId, VertexId};
use crate::refine::{ButterflyRows, KobbeltRows, Refined, refine};
use crate::scheme::butterfly::{CURVE_EDGE, EDGE, regular_tangent_weights};
use crate::scheme::kobbelt::{corner_share, edge_weights, tangent_weights};
use crate::scheme::{Corners, Rules, Scheme};
use crate::{Topology, Vec3};

/// Steps after which what is not tangent has died out, where no closed mask is known.
const SETTLED: u32 = 64;

pub(super) struct InterpolatingTangents<'a> {
    topology: &'a Topology,
    points: &'a [Vec3],
    rules: &'a Rules,
    /// The points after one step.
    finer: Vec<Vec3>,
    /// Kobbelt's scheme at extraordinary vertices.
    second: Option<Second<'a>>,
}

/// What a second Kobbelt step round a vertex needs, and what is done with its result.
struct Second<'a> {
    step: Refined<'a>,
    /// Sums round the vertices after the first step.
    ring_sums: Vec<Vec3>,
    /// Masks by valence, in order.
    masks: Vec<(u32, Mask)>,
}

/// Complex weights of the six waves of a [`KobbeltDisc`] in the tangents.
type Mask = [[f64; 2]; 6];

impl<'a> InterpolatingTangents<'a> {
    pub(super) fn new(
        topology: &'a Topology,
        points: &'a [Vec3],
        rules: &'a Rules,
    ) -> Result<Self, Error> {
        if rules.scheme == Scheme::Butterfly {
            let finer = ButterflyRows::new(topology).apply(points);
            return Ok(Self { topology, points, rules, finer, second: None });
        }
        let step = refine(topology, rules)?;
        let finer = step.apply(points);
        let ring_sums = KobbeltRows::new(&step.topology, &step.next).ring_sums(&finer);
        let inner = topology.vertices().filter(|&v| !topology.is_boundary(v));
        let mut valences: Vec<u32> = inner.map(|v| topology.fan_size(v)).collect();
        valences.sort_unstable();
        valences.dedup();
        valences.retain(|&n| n > 0 && n != 4);
        let masks = valences.iter().map(|&n| (n, mask(n, rules.kobbelt_weight))).collect();
        let second = Some(Second { step, ring_sums, masks });
        Ok(Self { topology, points, rules, finer, second })
    }

    /// The tangents at a vertex that has faces; for Kobbelt's scheme on the boundary those in each
    /// face.
    pub(super) fn at(&self, v: VertexId, found: &mut impl FnMut([Vec3; 2])) {
        let boundary = self.topology.is_boundary(v);
        match &self.second {
            None if boundary => found(ButterflySide::new(self, v).tangents()),
            None => found(self.butterfly(v)),
            Some(_) if boundary => self.kobbelt_side(v, found),
            Some(_) if self.topology.fan_size(v) == 4 => found(self.kobbelt_grid(v)),
            Some(second) => found(self.kobbelt(v, second)),
        }
    }

    /// The new point on an edge, from `v`.
    fn on(&self, e: EdgeId, v: VertexId) -> Vec3 {
        self.finer[self.topology.vertex_count() + e.index()] - self.points[v.index()]
    }

    /// The edges at a vertex in the order of its ring: the new point on each, and the old end.
    fn spokes(&self, v: VertexId) -> Vec<[Vec3; 2]> {
        let t = self.topology;
        let spoke = |h: HalfedgeId, end: VertexId| {
            [self.on(t.edge(h), v), self.points[end.index()] - self.points[v.index()]]
        };
        let mut spokes: Vec<_> = t.fan(v).map(|h| spoke(h, t.target(h))).collect();
        if t.is_boundary(v)
            && let Some(last) = t.fan(v).last().map(|h| t.prev(h))
        {
            spokes.push(spoke(last, t.origin(last)));
        }
        spokes
    }

    fn butterfly(&self, v: VertexId) -> [Vec3; 2] {
        let t = self.topology;
        let step = 2.0 * PI / f64::from(t.fan_size(v));
        let regular = t.fan_size(v) == 6;
        let [near, between, behind] =
            if regular { regular_tangent_weights() } else { [1.0, 0.0, 0.0] };
        let mut tangents = [Vec3::ZERO; 2];
        for (j, (h, [q, g])) in t.fan(v).zip(self.spokes(v)).enumerate() {
            let f = self.on(t.edge(t.next(h)), v);
            let (at, half) = (step * j as f64, step * (j as f64 + 0.5));
            let ring = near * q + behind * g;
            tangents[0] += cos(at) * ring + between * cos(half) * f;
            tangents[1] += sin(at) * ring + between * sin(half) * f;
        }
        tangents
    }

    /// Derivatives of the two curves that cross.
    fn kobbelt_grid(&self, v: VertexId) -> [Vec3; 2] {
        let spokes = self.spokes(v);
        [0, 1].map(|i| self.along(spokes[i]) - self.along(spokes[i + 2]))
    }

    /// The one-sided derivative of a four-point curve that is its own reflection.
    fn along(&self, [next, next_but_one]: [Vec3; 2]) -> Vec3 {
        let [a, b] = tangent_weights(self.rules.kobbelt_weight);
        a * next + b * next_but_one
    }

    /// On the boundary every inner edge is refined as if its reflection went on outside.
    fn kobbelt_side(&self, v: VertexId, found: &mut impl FnMut([Vec3; 2])) {
        let t = self.topology;
        let mut edges: Vec<Vec3> = self.spokes(v).into_iter().map(|s| self.along(s)).collect();
        let k = edges.len() - 1;
        if k > 1 || self.rules.corners == Corners::Smooth {
            let curve = edges[0] - edges[k];
            (edges[0], edges[k]) = (curve, -curve);
        }
        if k == 1 && self.rules.corners == Corners::Smooth {
            let inside = t.fan(v).next().map_or(Vec3::ZERO, |h| {
                let at = t.vertex_count() + t.edge_count() + t.face(h).index();
                self.finer[at] - self.points[v.index()]
            });
            return found([edges[0], inside]);
        }
        edges.windows(2).for_each(|pair| found([pair[0], pair[1]]));
    }

    fn kobbelt(&self, v: VertexId, second: &Second<'_>) -> [Vec3; 2] {
        let Second { step, ring_sums, masks } = second;
        let t = &step.topology;
        let rows = KobbeltRows::new(t, &step.next);
        let here = self.points[v.index()];
        let edge = |e: EdgeId| rows.edge_value(e, &self.finer, ring_sums);
        let angle = 2.0 * PI / f64::from(t.fan_size(v));
        let mut disc = [Wave::default(); 6];
        for (j, h) in t.fan(v).enumerate() {
            let (next, far) = (t.next(h), t.next(t.next(h)));
            let old = |h: HalfedgeId| self.finer[t.origin(h).index()];
            let values = [
                edge(t.edge(h)),
                old(next),
                rows.face_value(t.face(h), edge),
                edge(t.edge(next)),
                edge(t.edge(far)),
                old(far),
            ];
            let (c, s) = (cos(angle * j as f64), sin(angle * j as f64));
            for (wave, value) in disc.iter_mut().zip(values) {
                wave.re += c * (value - here);
                wave.im += -s * (value - here);
            }
        }
        let Ok(at) = masks.binary_search_by_key(&t.fan_size(v), |m| m.0) else {
            return [Vec3::ZERO; 2];
        };
        let mut tangents = [Vec3::ZERO; 2];
        for (&[re, im], wave) in masks[at].1.iter().zip(&disc) {
            tangents[0] += re * wave.re - im * wave.im;
            // The sine part of a wave is the negative imaginary one.
            tangents[1] += -(im * wave.re + re * wave.im);
        }
        tangents
    }
}

/// The mask of Kobbelt's scheme at an interior vertex of valence `n`, up to scale: what is left of
/// each of the six waves after many steps.
fn mask(n: u32, w: f64) -> Mask {
    let mut mask = [[0.0; 2]; 6];
    let axes = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 1.0)];
    // The coordinates are three waves at a time.
    for first in [0, 3] {
        let mut waves = [Wave::default(); 6];
        for (wave, axis) in waves[first..].iter_mut().zip(axes) {
            wave.re = axis;
        }
        let mut disc = KobbeltDisc { waves, angle: 2.0 * PI / f64::from(n), w };
        for _ in 0..SETTLED {
            disc = disc.next();
        }
        for (axis, weight) in mask[first..first + 3].iter_mut().enumerate() {
            *weight = [disc.waves[0].re[axis], disc.waves[0].im[axis]];
        }
    }
    mask
}

/// The neighbourhood of a boundary vertex in a butterfly mesh after a step, from the vertex: for each
/// neighbour its position and that of the one straight behind, and beyond each outer edge one more.
///
/// ```text
///     g ── f ── g ── f ── g
///      ╲  ╱ ╲  ╱ ╲  ╱ ╲  ╱
///       q ─── q ─── q ─ …          the vertex is below, between the first and the last q
/// ```
struct ButterflySide {
    near: Vec<Vec3>,
    behind: Vec<Vec3>,
    between: Vec<Vec3>,
}

impl ButterflySide {
    fn new(all: &InterpolatingTangents<'_>, v: VertexId) -> Self {
        let t = all.topology;
        let between = t.fan(v).map(|h| all.on(t.edge(t.next(h)), v)).collect();
        let (near, behind) = all.spokes(v).into_iter().map(|[q, g]| (q, g)).unzip();
        Self { near, behind, between }
    }

    /// The same one step later, twice as large.
    fn next(&self) -> Self {
        let (q, g, f) = (&self.near, &self.behind, &self.between);
        let k = f.len();
        let [end, opposite, wing] = EDGE;
        // Next in the ring; beyond the boundary the reflection that takes its place.
        let after = |i: usize| if i < k { q[i + 1] } else { q[k] - q[k - 1] };
        let before = |i: usize| if i > 0 { q[i - 1] } else { q[0] - q[1] };
        let near = |i: usize| match i {
            0 => CURVE_EDGE[0] * q[0] + CURVE_EDGE[1] * (q[k] + g[0]),
            i if i == k => CURVE_EDGE[0] * q[k] + CURVE_EDGE[1] * (q[0] + g[k]),
            i => {
                let wings = f[i - 1] + f[i] + after(i + 1) + before(i - 1);
                end * q[i] + opposite * (q[i - 1] + q[i + 1]) + wing * wings
            }
        };
        let between = |i: usize| {
            let wings = before(i) + after(i + 1) + g[i] + g[i + 1];
            end * (q[i] + q[i + 1]) + opposite * f[i] + wing * wings
        };
        Self {
            near: (0..=k).map(|i| 2.0 * near(i)).collect(),
            behind: q.iter().map(|&q| 2.0 * q).collect(),
            between: (0..k).map(|i| 2.0 * between(i)).collect(),
        }
    }

    /// The curve's, and a direction inwards. With two or three faces there are but two directions
    /// that shrink slowest. With more, several inner ones do that lie in no plane: the result is
    /// that of a few steps.
    fn tangents(mut self) -> [Vec3; 2] {
        const FEW: u32 = 3;
        let k = self.between.len();
        let [a, b] = tangent_weights(1.0);
        let along = a * (self.near[0] - self.near[k]) + b * (self.behind[0] - self.behind[k]);
        for _ in 0..if matches!(k, 2 | 3) { SETTLED } else { FEW } {
            self = self.next();
        }
        if k == 1 {
            return [along, self.between[0]];
        }
        let across = |(i, &q)| sin(PI * f64::from(i) / k as f64) * q;
        [along, (0..).zip(&self.near).map(across).sum()]
    }
}

/// Six points of each sector of the neighbourhood of an extraordinary vertex in a Kobbelt mesh, from
/// the vertex: their waves once round the vertex.
///
/// ```text
///     .  e  f        the vertex at (0, 0), a at (1, 0), b at (2, 0), c at (1, 1), d at (2, 1),
///     .  c  d        e at (1, 2), f at (2, 2); the next sector begins with the column on the left
///     v  a  b
/// ```
struct KobbeltDisc {
    waves: [Wave; 6],
    angle: f64,
    w: f64,
}

impl KobbeltDisc {
    /// The same one step later, twice as large.
    fn next(&self) -> Self {
        let [a, b, c, d, e, f] = self.waves;
        let turn = |x: Wave, sectors: f64| x.turned(self.angle * sectors);
        let [middle, beyond] = edge_weights(self.w);
        let rule = |near: Wave, far: Wave| near.times(middle).plus(far.times(beyond));
        // Sums over the ring vanish for this wave.
        let neighbours = turn(a, -1.0).plus(a).plus(turn(a, 1.0));
        let corners = turn(c, -2.0).plus(turn(c, -1.0)).plus(c).plus(turn(c, 1.0));
        let opposite = corners.times(corner_share(self.w)).plus(neighbours.times(-1.0));
        let (left, below) = (turn(a, 1.0), turn(e, -1.0));

        let a1 = rule(a, opposite.plus(b));
        let d1 = rule(a.plus(c), turn(c, -1.0).plus(e));
        let e1 = rule(left.plus(c), turn(c, 1.0).plus(d));
        let right = rule(b.plus(d), below.plus(f));
        let top = rule(turn(b, 1.0).plus(e), turn(d, 1.0).plus(f));
        let across = rule(turn(a1, 1.0).plus(d1), turn(e1, 1.0).plus(right));
        let up = rule(a1.plus(e1), turn(d1, -1.0).plus(top));
        let c1 = across.plus(up).times(0.5);
        Self { waves: [a1, a, c1, d1, e1, c].map(|x| x.times(2.0)), ..*self }
    }
}

/// A complex multiple of a wave round a vertex.
#[derive(Clone, Copy, Default)]
struct Wave {
    re: Vec3,
    im: Vec3,
}

impl Wave {
    fn plus(self, b: Self) -> Self {
        Self { re: self.re + b.re, im: self.im + b.im }
    }

    fn times(self, a: f64) -> Self {
        Self { re: a * self.re, im: a * self.im }
    }

    fn turned(self, angle: f64) -> Self {
        let (c, s) = (cos(angle), sin(angle));
        Self { re: c * self.re - s * self.im, im: s * self.re + c * self.im }
    }
}
