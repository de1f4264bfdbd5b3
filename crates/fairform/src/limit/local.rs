//! The neighbourhood of a vertex by itself: refined step by step where no closed mask holds, that is
//! beside semi-sharp edges and where a crease ends.

use alloc::vec::Vec;
use core::ops::{Add, Mul};

use crate::crease::{INFINITE, Sharpness, after_step};
use crate::ids::VertexId;
use crate::scheme::catmull_clark::vertex_weights;
use crate::scheme::loop_scheme::ring_weight;
use crate::scheme::{Rules, Scheme};

/// The rows of a refinement step that make the values on the fan of a vertex, in their order.
pub(crate) fn local_rows(
    sharp: Sharpness<'_>,
    scheme: Scheme,
    v: VertexId,
) -> impl Iterator<Item = usize> {
    let topology = sharp.topology;
    let (vertices, edges) = (topology.vertex_count(), topology.edge_count());
    let around = sharp.edges(v).map(move |(e, _)| vertices + e.index());
    let fan = (scheme == Scheme::CatmullClark).then(|| topology.fan(v)).into_iter().flatten();
    let faces = fan.map(move |h| vertices + edges + topology.face(h).index());
    core::iter::once(v.index()).chain(around).chain(faces)
}

/// The fan of faces at a vertex and its sharpness. Values on it lie in the order: the vertex, its
/// neighbours counter-clockwise, and for Catmull–Clark the faces: face `i` between neighbours `i` and
/// `i + 1`.
#[derive(Clone, Debug)]
pub(crate) struct Local {
    scheme: Scheme,
    closed: bool,
    vertex: f64,
    pub(crate) edges: Vec<f64>,
    /// Whether a step has been made: faces are quadrilaterals, given by the corner opposite the vertex;
    /// before, by their centroids.
    is_refined: bool,
    /// Loop: weights of the vertex and of its neighbour in a new point of the boundary.
    boundary_edges: [[f64; 2]; 2],
}

impl Local {
    pub(crate) fn new(sharp: Sharpness<'_>, rules: &Rules, v: VertexId) -> Self {
        let edges: Vec<f64> = sharp.edges(v).map(|e| sharp.edge(e.0)).collect();
        let closed = !sharp.topology.is_boundary(v);
        let mut boundary_edges = [[0.5; 2]; 2];
        if !closed && rules.scheme == Scheme::Loop {
            let kinds =
                crate::rules::BoundaryKinds { topology: sharp.topology, corners: rules.corners };
            let (last, first) = crate::rules::boundary_neighbours(sharp.topology, v);
            boundary_edges = [first, last].map(|q| kinds.edge_weights(v, q));
        }
        let vertex = sharp.vertex(v);
        let is_refined = false;
        Self { scheme: rules.scheme, closed, vertex, edges, is_refined, boundary_edges }
    }

    /// Whether the vertex is off the boundary.
    pub(crate) fn is_closed(&self) -> bool {
        self.closed
    }

    pub(crate) fn face_count(&self) -> usize {
        if self.closed { self.edges.len() } else { self.edges.len() - 1 }
    }

    /// Number of steps until nothing is sharp for a while only.
    pub(crate) fn steps(&self) -> u32 {
        let semi = self.edges.iter().chain([&self.vertex]).filter(|s| **s < INFINITE);
        libm::ceil(semi.fold(0.0, |a, &b| f64::max(a, b))) as u32
    }

    /// Whether a crease ends here, or something is sharp for a while only.
    pub(crate) fn is_special(&self) -> bool {
        let sharp = self.edges.iter().filter(|s| **s > 0.0).count();
        self.steps() > 0 || (self.vertex == 0.0 && sharp == 1)
    }

    /// The same after a step.
    pub(crate) fn next(&self) -> Self {
        let mut next = self.clone();
        next.is_refined = true;
        next.vertex = after_step(self.vertex);
        next.edges.iter_mut().for_each(|s| *s = after_step(*s));
        if self.scheme == Scheme::Loop && !self.closed {
            // All new neighbours on the boundary are regular.
            let regular = self.face_count() == 3;
            next.boundary_edges = [if regular { [0.5; 2] } else { [0.375, 0.625] }; 2];
        }
        next
    }

    /// Which neighbours the vertex lies on a curve with; `None` if it stays; none if it is smooth.
    fn curve(&self) -> Option<Vec<usize>> {
        let sharp: Vec<usize> = (0..self.edges.len()).filter(|&i| self.edges[i] > 0.0).collect();
        match sharp.len() {
            _ if self.vertex > 0.0 => None,
            0 | 1 => Some(Vec::new()),
            2 => Some(sharp),
            _ => None,
        }
    }

    /// The rows of one step.
    pub(crate) fn matrix(&self) -> Vec<Vec<f64>> {
        let (m, k) = (self.edges.len(), self.face_count());
        let size = match self.scheme {
            Scheme::CatmullClark => 1 + m + k,
            _ => 1 + m,
        };
        let zero = || alloc::vec![0.0; size];
        // A face centroid in terms of the values.
        let add_face = |row: &mut [f64], i: usize, weight: f64| {
            if self.is_refined {
                for at in [0, 1 + i, 1 + (i + 1) % m, 1 + m + i] {
                    row[at] += 0.25 * weight;
                }
            } else {
                row[1 + m + i] += weight;
            }
        };
        let mut rows = Vec::with_capacity(size);
        rows.push(self.vertex_row(zero(), &add_face));
        for i in 0..m {
            let mut row = zero();
            let on_boundary = !self.closed && (i == 0 || i + 1 == m);
            let smooth = if on_boundary { 0.0 } else { 1.0 - self.edges[i].min(1.0) };
            match self.scheme {
                Scheme::CatmullClark => {
                    let end = 0.5 - 0.25 * smooth;
                    row[0] += end;
                    row[1 + i] += end;
                    if smooth > 0.0 {
                        add_face(&mut row, i % k, 0.25 * smooth);
                        add_face(&mut row, (i + k - 1) % k, 0.25 * smooth);
                    }
                }
                _ if on_boundary => {
                    let [own, other] = self.boundary_edges[usize::from(i > 0)];
                    row[0] += own;
                    row[1 + i] += other;
                }
                _ => {
                    let end = 0.5 - 0.125 * smooth;
                    row[0] += end;
                    row[1 + i] += end;
                    row[1 + (i + 1) % m] += 0.125 * smooth;
                    row[1 + (i + m - 1) % m] += 0.125 * smooth;
                }
            }
            rows.push(row);
        }
        for i in 0..size - 1 - m {
            let mut row = zero();
            add_face(&mut row, i, 1.0);
            rows.push(row);
        }
        rows
    }

    fn vertex_row(&self, zero: Vec<f64>, add_face: &dyn Fn(&mut [f64], usize, f64)) -> Vec<f64> {
        let mut row = zero;
        let now = self.curve();
        let next = self.next();
        let count = |curve: &Option<Vec<usize>>| curve.as_ref().map(Vec::len);
        let shares = if count(&now) == count(&next.curve()) {
            [1.0, 0.0]
        } else {
            let vanishing = |s: f64| s > 0.0 && after_step(s) == 0.0;
            let all = self.edges.iter().chain([&self.vertex]).filter(|s| vanishing(**s));
            let (sum, n) = all.fold((0.0, 0.0), |(sum, n), s| (sum + s, n + 1.0));
            let weight = if n == 0.0 { 0.0 } else { f64::min(1.0, sum / n) };
            [weight, 1.0 - weight]
        };
        for (curve, share) in [(now, shares[0]), (next.curve(), shares[1])] {
            if share == 0.0 {
                continue;
            }
            match curve.as_deref() {
                None => row[0] += share,
                Some([a, b]) => {
                    row[0] += 0.75 * share;
                    row[1 + a] += 0.125 * share;
                    row[1 + b] += 0.125 * share;
                }
                Some(_) => self.smooth_row(&mut row, share, add_face),
            }
        }
        row
    }

    fn smooth_row(&self, row: &mut [f64], share: f64, add_face: &dyn Fn(&mut [f64], usize, f64)) {
        let m = self.edges.len();
        let n = m as u32;
        if self.scheme == Scheme::CatmullClark {
            let [own, edge, face] = vertex_weights(n);
            row[0] += own * share;
            row[1..=m].iter_mut().for_each(|w| *w += edge * share);
            (0..m).for_each(|i| add_face(row, i, face * share));
        } else {
            let ring = ring_weight(n);
            row[0] += (1.0 - ring) * share;
            row[1..=m].iter_mut().for_each(|w| *w += ring / f64::from(n) * share);
        }
    }

    /// The weights of the values on the fan in the limit point of the vertex.
    pub(crate) fn limit_row(&self) -> Vec<f64> {
        const MOST: usize = 2000;
        let mut levels = alloc::vec![self.clone()];
        for _ in 0..=self.steps() {
            levels.extend(levels.last().map(Self::next));
        }
        let last = levels[levels.len() - 1].matrix();
        let mut row = alloc::vec![0.0; last.len()];
        row[0] = 1.0;
        for _ in 0..MOST {
            let next = times(&row, &last);
            let change = row.iter().zip(&next).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            row = next;
            if change < 1e-17 {
                break;
            }
        }
        for level in levels.iter().rev() {
            row = times(&row, &level.matrix());
        }
        row
    }

    /// The values after the steps it takes until nothing changes any more, at least one if none has been
    /// made; and the fan then.
    pub(crate) fn settle<T>(&self, values: Vec<T>) -> (Self, Vec<T>)
    where
        T: Copy + Default + Add<Output = T>,
        f64: Mul<T, Output = T>,
    {
        let (mut local, mut values) = (self.clone(), values);
        for _ in 0..self.steps().max(u32::from(!self.is_refined)) {
            let rows = local.matrix();
            let sum = |row: &Vec<f64>| {
                row.iter().zip(&values).fold(T::default(), |sum, (&w, &x)| sum + w * x)
            };
            values = rows.iter().map(sum).collect();
            local = local.next();
        }
        (local, values)
    }

    /// The runs of faces between sharp edges: first neighbour and number of faces; the whole fan once
    /// if no edge, or only one, is sharp.
    pub(crate) fn sectors(&self) -> Vec<(usize, usize)> {
        let sharp: Vec<usize> = (0..self.edges.len()).filter(|&i| self.edges[i] > 0.0).collect();
        let m = self.edges.len();
        if sharp.len() < 2 {
            return alloc::vec![(0, self.face_count())];
        }
        let mut sectors: Vec<(usize, usize)> =
            sharp.windows(2).map(|w| (w[0], w[1] - w[0])).collect();
        if self.closed {
            let last = sharp[sharp.len() - 1];
            sectors.push((last, m + sharp[0] - last));
        }
        sectors
    }

    /// Whether the vertex follows the smooth rule.
    pub(crate) fn is_smooth(&self) -> bool {
        self.curve().is_some_and(|c| c.is_empty())
    }

    /// Whether the vertex stays where it is.
    pub(crate) fn is_corner(&self) -> bool {
        self.curve().is_none()
    }
}

fn times(row: &[f64], matrix: &[Vec<f64>]) -> Vec<f64> {
    let mut product = alloc::vec![0.0; row.len()];
    for (&factor, other) in row.iter().zip(matrix) {
        if factor != 0.0 {
            for (sum, &x) in product.iter_mut().zip(other) {
                *sum += factor * x;
            }
        }
    }
    product
}
