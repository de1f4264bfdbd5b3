//! The arithmetic of a patch: Chebyshev's recurrence over shrinking rings, then what is wanted of it.
#![expect(clippy::inline_always, reason = "loops are as fast as their bodies are inlined")]

use alloc::boxed::Box;
use alloc::vec::Vec;

use super::lane::{Lane, Values, values};
use super::patch::{Patch, SPECIAL, WRITTEN, Written};
use crate::Vec3;
use crate::scheme::{Scheme, catmull_clark, loop_scheme};

pub(super) const LOOP: u8 = 0;
pub(super) const CATMULL_CLARK: u8 = 1;
pub(super) const DOO_SABIN: u8 = 2;

/// What all patches share.
#[derive(Clone, Debug)]
pub(super) struct Kernel {
    pub(super) scheme: Scheme,
    /// Weights in the limit point by valence: the vertex, and the sums of its neighbours and its faces.
    weights: Weights<f64>,
    weights32: Weights<f32>,
    /// One over the number of corners.
    share: Box<[f64; 256]>,
    /// Chebyshev's numbers, one pair per step.
    steps: Vec<(f64, f64)>,
}

/// Weights that a valence indexes without looking.
type Weights<R> = Box<[[R; 3]; 256]>;

/// A patch and what it is to meet.
#[derive(Clone, Copy)]
pub(super) struct Task<'a> {
    pub(super) patch: &'a Patch,
    pub(super) target: &'a [Vec3],
    /// The first takes residuals to where `f32` can hold them, the second takes corrections back.
    pub(super) scale: [f64; 2],
}

impl Task<'_> {
    /// Where the limit point of a vertex is to be.
    #[inline(always)]
    fn goal(&self, i: usize) -> [f64; 4] {
        lanes(self.target[self.patch.vertices[i] as usize])
    }
}

/// Values of one patch at a time.
pub(super) struct Scratch<const N: usize> {
    /// Vertices to be met, then control points.
    x: Box<Values<[f64; 4], N>>,
    /// What comes of the faces, for schemes that have a use for them.
    face: Vec<[f64; 4]>,
    face32: Vec<[f32; 4]>,
    /// The first residual, and corrections of the control points.
    residual: Box<Values<[f32; 4], N>>,
    now: Box<Values<[f32; 4], N>>,
    other: Box<Values<[f32; 4], N>>,
    /// Doo–Sabin: what is left to be moved at each vertex that the patch owns.
    left: Vec<[f64; 4]>,
}

impl<const N: usize> Scratch<N> {
    pub(super) fn new() -> Self {
        Self {
            x: values!([0.0; 4], N),
            face: Vec::new(),
            face32: Vec::new(),
            residual: values!([0.0; 4], N),
            now: values!([0.0; 4], N),
            other: values!([0.0; 4], N),
            left: Vec::new(),
        }
    }
}

/// Where results go: the slices of a patch, in order.
pub(super) struct Sink<'o> {
    slices: alloc::vec::IntoIter<&'o mut [Vec3]>,
    now: core::slice::IterMut<'o, Vec3>,
}

impl<'o> Sink<'o> {
    pub(super) fn new(slices: Vec<&'o mut [Vec3]>) -> Self {
        Self { slices: slices.into_iter(), now: [].iter_mut() }
    }

    #[inline(always)]
    fn push(&mut self, [x, y, z, _]: [f64; 4]) {
        loop {
            if let Some(slot) = self.now.next() {
                *slot = Vec3 { x, y, z };
                return;
            }
            match self.slices.next() {
                Some(slice) => self.now = slice.iter_mut(),
                None => return,
            }
        }
    }
}

/// A limit point, as sums over what it is made from.
enum Sums<L> {
    Smooth { n: u8, ring: L, faces: L },
    Whole(L),
}

/// Distances of limit points from their vertices.
#[derive(Clone, Copy, Default)]
pub(super) struct Distances {
    /// The largest, or NaN.
    pub(super) largest: f64,
    pub(super) sum: f64,
}

impl Distances {
    #[inline(always)]
    fn add(&mut self, [x, y, z, _]: [f64; 4]) {
        self.merge(libm::sqrt(x * x + y * y + z * z));
    }

    #[inline(always)]
    fn merge(&mut self, distance: f64) {
        // `f64::max` would drop a NaN, and with it an overflow.
        if distance > self.largest || distance.is_nan() {
            self.largest = distance;
        }
        self.sum += distance;
    }

    pub(super) fn plus(self, other: Self) -> Self {
        let sum = self.sum + other.sum;
        let mut both = self;
        both.merge(other.largest);
        Self { sum, ..both }
    }
}

#[inline(always)]
fn lanes(p: Vec3) -> [f64; 4] {
    [p.x, p.y, p.z, 0.0]
}

#[inline(always)]
fn narrow(a: [f64; 4], scale: f64) -> [f32; 4] {
    [(a[0] * scale) as f32, (a[1] * scale) as f32, (a[2] * scale) as f32, (a[3] * scale) as f32]
}

#[inline(always)]
fn minus(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    a.plus(b.times(-1.0))
}

impl Kernel {
    /// For eigenvalues from `smallest` to 1.
    pub(super) fn new(scheme: Scheme, steps: Vec<(f64, f64)>) -> Self {
        let weights: Weights<f64> = Box::new(core::array::from_fn(|n| {
            let n = n as u32;
            match scheme {
                Scheme::Loop if n >= 2 => {
                    let own = loop_scheme::limit_weight(n);
                    [own, (1.0 - own) / f64::from(n), 0.0]
                }
                Scheme::CatmullClark if n >= 2 => catmull_clark::limit_weights(n),
                Scheme::DooSabin if n >= 2 => [0.0, 0.0, 1.0 / f64::from(n)],
                _ => [1.0, 0.0, 0.0],
            }
        }));
        let weights32 = Box::new(weights.map(|w| w.map(|w| w as f32)));
        let share = Box::new(core::array::from_fn(|n| 1.0 / (n as f64).max(1.0)));
        Self { scheme, weights, weights32, share, steps }
    }

    /// Level 0: control points. Returns the distances of their limit points from the vertices.
    pub(super) fn control<const N: usize>(
        &self,
        task: Task<'_>,
        scratch: &mut Scratch<N>,
        out: &mut Sink<'_>,
    ) -> Distances {
        match self.scheme {
            Scheme::Loop => self.control_of::<LOOP, N>(task, scratch, out),
            Scheme::CatmullClark => self.control_of::<CATMULL_CLARK, N>(task, scratch, out),
            _ => self.control_of::<DOO_SABIN, N>(task, scratch, out),
        }
    }

    fn control_of<const SCHEME: u8, const N: usize>(
        &self,
        task: Task<'_>,
        scratch: &mut Scratch<N>,
        out: &mut Sink<'_>,
    ) -> Distances {
        self.solve::<SCHEME, N>(task, scratch);
        let Scratch { x, face, .. } = scratch;
        let mut distances = Distances::default();
        self.visit::<SCHEME, N, _>(task.patch, 0, x, face, |i, sums| {
            let limit = Self::whole::<SCHEME, _>(&self.weights, task.patch, i, x[i], &sums);
            distances.add(minus(task.goal(i), limit));
            out.push(x[i]);
        });
        distances
    }

    /// Level 1: finer values whose limit points are the vertices. Returns how far they had to be moved.
    pub(super) fn finer<const N: usize>(
        &self,
        task: Task<'_>,
        scratch: &mut Scratch<N>,
        out: &mut Sink<'_>,
    ) -> Distances {
        match self.scheme {
            Scheme::Loop => self.primal_finer::<LOOP, N>(task, scratch, out),
            Scheme::CatmullClark => self.primal_finer::<CATMULL_CLARK, N>(task, scratch, out),
            _ => self.doo_sabin_finer(task, scratch, out),
        }
    }

    /// Where vertices stay vertices: these, then the points on edges and those in faces.
    fn primal_finer<const SCHEME: u8, const N: usize>(
        &self,
        task: Task<'_>,
        scratch: &mut Scratch<N>,
        out: &mut Sink<'_>,
    ) -> Distances {
        self.solve::<SCHEME, N>(task, scratch);
        let patch = task.patch;
        let Scratch { x, face, .. } = scratch;
        let mut distances = Distances::default();
        let mut made = MadeRows::new(&patch.made);
        self.visit::<SCHEME, N, _>(patch, 0, x, face, |i, sums| {
            let goal = task.goal(i);
            let limit = Self::whole::<SCHEME, _>(&self.weights, patch, i, x[i], &sums);
            distances.add(minus(goal, limit));
            out.push(match sums {
                Sums::Whole(_) => made.next(goal, x),
                Sums::Smooth { n, .. } if SCHEME == LOOP => {
                    // The mean of the points on the edges is 3/8 x + 5/8 of the mean of the ring.
                    let own = self.weights[usize::from(n)][0];
                    let rest = x[i].times(0.375 - own).plus(limit.times(0.625));
                    minus(goal, rest).times(1.0 / own)
                }
                Sums::Smooth { n, ring, faces } => {
                    // Four times the points on the edges and those in the faces.
                    let n = f64::from(n);
                    let rest = x[i].times(n).plus(ring).plus(faces.times(3.0));
                    minus(goal.times(n * (n + 5.0)), rest).times(1.0 / (n * n))
                }
            });
        });
        for &[a, b, c, d] in &patch.edges {
            out.push(if a == WRITTEN {
                made.next([0.0; 4], x)
            } else {
                let [a, b] = [a, b].map(|q| x[usize::from(q) % N]);
                if SCHEME == LOOP {
                    let [c, d] = [c, d].map(|q| x[usize::from(q) % N]);
                    a.plus(b).times(0.375).plus(c.plus(d).times(0.125))
                } else {
                    let [f, g] = [c, d].map(|f| face[usize::from(f)]);
                    a.plus(b).plus(f.plus(g)).times(0.25)
                }
            });
        }
        for &f in &patch.points {
            out.push(face[usize::from(f)]);
        }
        distances
    }

    fn doo_sabin_finer<const N: usize>(
        &self,
        task: Task<'_>,
        scratch: &mut Scratch<N>,
        out: &mut Sink<'_>,
    ) -> Distances {
        self.solve::<DOO_SABIN, N>(task, scratch);
        let patch = task.patch;
        let Scratch { x, face, left, .. } = scratch;
        let mut distances = Distances::default();
        left.clear();
        self.visit::<DOO_SABIN, N, _>(patch, 0, x, face, |i, sums| {
            let limit = Self::whole::<DOO_SABIN, _>(&self.weights, patch, i, x[i], &sums);
            let rest = minus(task.goal(i), limit);
            distances.add(rest);
            left.push(rest);
        });
        let mut made = MadeRows::new(&patch.made);
        for &[v, f] in &patch.images {
            let (v, f) = (usize::from(v) % N, usize::from(f));
            out.push(if f == usize::from(WRITTEN) {
                made.next(task.goal(v), x)
            } else {
                x[v].times(patch.faces.lambda[f]).plus(face[f]).plus(left[v])
            });
        }
        distances
    }

    /// A limit point from its sums.
    #[inline(always)]
    fn whole<const SCHEME: u8, L: Lane>(
        weights: &Weights<L::Real>,
        patch: &Patch,
        i: usize,
        x: L,
        sums: &Sums<L>,
    ) -> L {
        let Sums::Smooth { n, ring, faces } = *sums else {
            let Sums::Whole(limit) = *sums else { unreachable!() };
            return limit;
        };
        let [own, edge, face] = weights[usize::from(n)];
        match SCHEME {
            LOOP => x.times(own).plus(ring.times(edge)),
            CATMULL_CLARK => x.times(own).plus(ring.times(edge)).plus(faces.times(face)),
            _ => x.times(L::real(patch.centre[i])).plus(faces.times(face)),
        }
    }

    /// Control points at the vertices that a patch owns and one ring around, into `x`.
    fn solve<const SCHEME: u8, const N: usize>(&self, task: Task<'_>, scratch: &mut Scratch<N>) {
        let Task { patch, target, scale } = task;
        let Scratch { x, face, residual, now, other, face32, .. } = scratch;
        if SCHEME != LOOP {
            let count = patch.faces.size.len();
            face.resize(count, [0.0; 4]);
            face32.resize(count, [0.0; 4]);
        }
        for (i, &v) in patch.vertices.iter().enumerate() {
            x[i] = lanes(target[v as usize]);
        }
        let Some((&(_, first), steps)) = self.steps.split_first() else { return };
        let first = first as f32;
        let reach = self.steps.len();
        self.visit::<SCHEME, N, _>(patch, reach, x, face, |i, sums| {
            let limit = Self::whole::<SCHEME, _>(&self.weights, patch, i, x[i], &sums);
            let r = narrow(minus(x[i], limit), scale[0]);
            residual[i] = r;
            now[i] = r.map(|r| first * r);
            // The step before the first corrects nothing.
            other[i] = [0.0; 4];
        });
        for (k, &(a, b)) in steps.iter().enumerate() {
            let (a, b) = (a as f32, b as f32);
            self.visit::<SCHEME, N, _>(patch, reach - 1 - k, now, face32, |i, sums| {
                let own = now[i];
                let limit = Self::whole::<SCHEME, _>(&self.weights32, patch, i, own, &sums);
                let (before, r) = (other[i], residual[i]);
                other[i] = core::array::from_fn(|j| {
                    own[j] + b * (r[j] - limit[j]) + a * (own[j] - before[j])
                });
            });
            core::mem::swap(now, other);
        }
        let end = patch.ends[1] as usize;
        for (x, c) in x[..end].iter_mut().zip(&now[..end]) {
            *x = x.plus(c.map(|c| scale[1] * f64::from(c)));
        }
    }

    /// Visits the limit points of the vertices no farther than so many rings, from the values of vertices;
    /// `face` is for what comes of the faces.
    #[inline(always)]
    fn visit<const SCHEME: u8, const N: usize, L: Lane>(
        &self,
        patch: &Patch,
        distance: usize,
        x: &Values<L, N>,
        face: &mut [L],
        mut visit: impl FnMut(usize, Sums<L>),
    ) {
        if SCHEME != LOOP {
            self.faces::<SCHEME, N, L>(patch, patch.faces.ends[distance] as usize, x, face);
        }
        let mut ring = patch.ring.as_slice();
        let mut written = MadeRows::new(&patch.limit);
        for (i, &n) in patch.valence[..patch.ends[distance] as usize].iter().enumerate() {
            // Of sixteen bits, so that it indexes without looking.
            let i = usize::from(i as u16) % N;
            let sums = if n == SPECIAL {
                Sums::Whole(written.next(L::ZERO, x))
            } else {
                let mut sums = [L::ZERO; 2];
                if SCHEME != DOO_SABIN {
                    let (own, rest) = ring.split_at(usize::from(n));
                    ring = rest;
                    sums[0] = sum::<L, 6>(own, |q| x[usize::from(q) % N]);
                }
                if SCHEME != LOOP {
                    let (own, rest) = ring.split_at(usize::from(n));
                    ring = rest;
                    sums[1] = sum::<L, 4>(own, |f| face[usize::from(f)]);
                }
                Sums::Smooth { n, ring: sums[0], faces: sums[1] }
            };
            visit(i, sums);
        }
    }

    /// What the faces add to images and limit points.
    #[inline(always)]
    fn faces<const SCHEME: u8, const N: usize, L: Lane>(
        &self,
        patch: &Patch,
        end: usize,
        x: &Values<L, N>,
        face: &mut [L],
    ) {
        let mut corners = patch.faces.corner.as_slice();
        for (f, &size) in patch.faces.size[..end].iter().enumerate() {
            let (own, rest) = corners.split_at(usize::from(size));
            corners = rest;
            let share = self.share.get(usize::from(size)).copied();
            let mut weight = share.unwrap_or_else(|| 1.0 / f64::from(size));
            if SCHEME == DOO_SABIN
                && let Some(lambda) = patch.faces.lambda.get(f)
            {
                weight *= 1.0 - lambda;
            }
            face[f] = sum::<L, 4>(own, |q| x[usize::from(q) % N]).times(L::real(weight));
        }
    }
}

/// A sum in the order of its terms, the usual number of them unrolled.
#[inline(always)]
fn sum<L: Lane, const USUAL: usize>(list: &[u16], value: impl Fn(u16) -> L) -> L {
    if let Ok(list) = <&[u16; USUAL]>::try_from(list) {
        let mut sum = value(list[0]);
        for &q in &list[1..] {
            sum = sum.plus(value(q));
        }
        return sum;
    }
    list.iter().fold(L::ZERO, |sum, &q| sum.plus(value(q)))
}

/// Rows written out, one after the other.
struct MadeRows<'p> {
    rows: &'p Written,
    next: usize,
}

impl<'p> MadeRows<'p> {
    fn new(rows: &'p Written) -> Self {
        Self { rows, next: 0 }
    }

    #[inline(never)]
    fn next<const N: usize, L: Lane>(&mut self, target: L, x: &Values<L, N>) -> L {
        let [from, to] = [0, 1].map(|j| self.rows.start[self.next + j] as usize);
        let own = target.times(L::real(self.rows.target[self.next]));
        self.next += 1;
        let entries = self.rows.entries[from..to].iter();
        entries
            .fold(own, |sum, &(q, weight)| sum.plus(x[usize::from(q) % N].times(L::real(weight))))
    }
}
