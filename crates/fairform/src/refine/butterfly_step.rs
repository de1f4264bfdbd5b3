//! Values of a butterfly step; the finer topology is that of Loop's scheme.

use alloc::vec::Vec;
use core::f64::consts::PI;

use libm::{cos, sin};

use crate::ids::{EdgeId, HalfedgeId, VertexId};
use crate::rows::Rows;
use crate::rules::boundary_neighbours;
use crate::scheme::butterfly::{CENTRE, CURVE_EDGE, EDGE, ring_weight};
use crate::{Topology, Vec3, par};

/// Up to this valence the new points round a vertex are summed one by one.
const FEW: u32 = 64;

/// The finer values: vertices as they are, then the points on the edges.
pub(crate) struct ButterflyRows<'t> {
    topology: &'t Topology,
    /// Weights of the ring for each valence of an interior vertex, other than 6.
    ring: Vec<Vec<f64>>,
}

/// What the point on an edge is a sum of.
enum Term {
    Vertex(VertexId),
    /// The ring stencil of the origin of a half-edge, for the point on it.
    Spoke(HalfedgeId),
}

impl<'t> ButterflyRows<'t> {
    pub(crate) fn new(topology: &'t Topology) -> Self {
        let mut ring: Vec<Vec<f64>> = Vec::new();
        for v in topology.vertices().filter(|&v| is_special(topology, v)) {
            let n = topology.fan_size(v);
            if ring.len() <= n as usize {
                ring.resize(n as usize + 1, Vec::new());
            }
            let weights = &mut ring[n as usize];
            if weights.is_empty() {
                weights.extend((0..n).map(|j| ring_weight(n, j)));
            }
        }
        Self { topology, ring }
    }

    fn edge(&self, e: EdgeId, term: &mut impl FnMut(Term, f64)) {
        let t = self.topology;
        let h = t.edge_halfedge(e);
        let (a, b) = (t.origin(h), t.target(h));
        let Some(twin) = t.twin(h) else {
            let [end, beyond] = CURVE_EDGE;
            term(Term::Vertex(a), end);
            term(Term::Vertex(b), end);
            term(Term::Vertex(boundary_neighbours(t, a).0), beyond);
            return term(Term::Vertex(boundary_neighbours(t, b).1), beyond);
        };
        match (is_special(t, a), is_special(t, b)) {
            (true, true) => {
                term(Term::Spoke(h), 0.5);
                term(Term::Spoke(twin), 0.5);
            }
            (true, false) => term(Term::Spoke(h), 1.0),
            (false, true) => term(Term::Spoke(twin), 1.0),
            (false, false) => {
                let [end, opposite, wing] = EDGE;
                term(Term::Vertex(a), end);
                term(Term::Vertex(b), end);
                for h in [h, twin] {
                    term(Term::Vertex(t.origin(t.prev(h))), opposite);
                    self.wing(t.next(h), wing, term);
                    self.wing(t.prev(h), wing, term);
                }
            }
        }
    }

    /// The corner on the other side of a half-edge.
    fn wing(&self, h: HalfedgeId, weight: f64, term: &mut impl FnMut(Term, f64)) {
        let t = self.topology;
        if let Some(twin) = t.twin(h) {
            return term(Term::Vertex(t.origin(t.prev(twin))), weight);
        }
        term(Term::Vertex(t.origin(h)), weight);
        term(Term::Vertex(t.target(h)), weight);
        term(Term::Vertex(t.origin(t.prev(h))), -weight);
    }

    fn spoke(&self, h: HalfedgeId, share: f64, entry: &mut impl FnMut(u32, f64)) {
        let t = self.topology;
        let v = t.origin(h);
        entry(v.0, CENTRE * share);
        let mut at = Some(h);
        for weight in &self.ring[t.fan_size(v) as usize] {
            let Some(h) = at else { return };
            entry(t.target(h).0, weight * share);
            at = t.twin(t.prev(h));
        }
    }

    /// The finer values at once, the same as by the rows up to rounding.
    pub(crate) fn apply(&self, values: &[Vec3]) -> Vec<Vec3> {
        let spokes = self.many_spokes(values);
        let mut finer = values.to_vec();
        finer.extend(par::collect(self.topology.edge_count(), |e| {
            let mut sum = Vec3::ZERO;
            self.edge(EdgeId(e as u32), &mut |term, weight| match term {
                Term::Vertex(v) => sum += weight * values[v.index()],
                Term::Spoke(h) => match spokes.binary_search_by_key(&h, |s| s.0) {
                    Ok(i) => sum += weight * spokes[i].1,
                    Err(_) => self.spoke(h, weight, &mut |v, w| sum += w * values[v as usize]),
                },
            });
            sum
        }));
        finer
    }

    /// The new points round vertices of high valence, by half-edge. One by one they would take time
    /// with the square of the valence; the weights are two waves, so sums over the ring do.
    fn many_spokes(&self, values: &[Vec3]) -> Vec<(HalfedgeId, Vec3)> {
        let t = self.topology;
        let mut spokes = Vec::new();
        for v in t.vertices().filter(|&v| t.fan_size(v) > FEW && is_special(t, v)) {
            let size = f64::from(t.fan_size(v));
            let wave = |j: usize, k: f64| {
                let angle = 2.0 * PI * k * j as f64 / size;
                [cos(angle), sin(angle)]
            };
            let mut mean = Vec3::ZERO;
            let mut parts = [[Vec3::ZERO; 2]; 2];
            for (j, q) in t.ring(v).map(|q| values[q.index()]).enumerate() {
                mean += q / size;
                for (part, k) in parts.iter_mut().zip([1.0, 2.0]) {
                    let [c, s] = wave(j, k);
                    part[0] += c / size * q;
                    part[1] += s / size * q;
                }
            }
            let fixed = CENTRE * values[v.index()] + 0.25 * mean;
            spokes.extend(t.fan(v).enumerate().map(|(i, h)| {
                let [c1, s1] = wave(i, 1.0);
                let [c2, s2] = wave(i, 2.0);
                let [first, second] = &parts;
                let waves = c1 * first[0] + s1 * first[1] + 0.5 * (c2 * second[0] + s2 * second[1]);
                (h, fixed + waves)
            }));
        }
        spokes.sort_unstable_by_key(|s| s.0);
        spokes
    }
}

/// Whether a vertex has its ring stencil.
fn is_special(topology: &Topology, v: VertexId) -> bool {
    topology.fan_size(v) != 6 && !topology.is_boundary(v) && !topology.is_isolated(v)
}

impl Rows for ButterflyRows<'_> {
    fn len(&self) -> usize {
        self.topology.vertex_count() + self.topology.edge_count()
    }

    #[inline]
    fn visit(&self, row: usize, mut entry: impl FnMut(u32, f64)) {
        match row.checked_sub(self.topology.vertex_count()) {
            None => entry(row as u32, 1.0),
            Some(e) => self.edge(EdgeId(e as u32), &mut |term, weight| match term {
                Term::Vertex(v) => entry(v.0, weight),
                Term::Spoke(h) => self.spoke(h, weight, &mut entry),
            }),
        }
    }
}
