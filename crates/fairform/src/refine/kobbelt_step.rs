//! Values of a Kobbelt step; the finer topology is that of Catmull and Clark's scheme.
//!
//! Points in faces are made of the new points on edges, and these of vertices and of sums round
//! extraordinary vertices. Values are carried over in that order; rows are written out by putting
//! one into the other.

use alloc::vec::Vec;

use crate::ids::{EdgeId, FaceId, HalfedgeId, VertexId};
use crate::rows::Rows;
use crate::rules::boundary_neighbours;
use crate::scheme::kobbelt::{corner_share, edge_weights};
use crate::scheme::{Corners, Rules};
use crate::{Topology, Vec3, par};

/// The finer values: vertices as they are, points on edges, points in faces.
pub(crate) struct KobbeltRows<'t> {
    topology: &'t Topology,
    corners: Corners,
    weights: [f64; 2],
    corner_share: f64,
}

/// What the point on an edge is a sum of.
enum Term {
    Vertex(VertexId),
    /// The part of the virtual points behind an interior vertex that is the same for all.
    Ring(VertexId),
}

impl<'t> KobbeltRows<'t> {
    pub(crate) fn new(topology: &'t Topology, rules: &Rules) -> Self {
        let w = rules.kobbelt_weight;
        let (weights, corner_share) = (edge_weights(w), corner_share(w));
        Self { topology, corners: rules.corners, weights, corner_share }
    }

    /// $`\frac4n \sum l_j - \frac{4w}{(8+w)n} \sum k_j`$.
    fn ring(&self, v: VertexId, share: f64, entry: &mut impl FnMut(u32, f64)) {
        let t = self.topology;
        let each = 4.0 * share / f64::from(t.fan_size(v));
        for h in t.fan(v) {
            entry(t.target(h).0, each);
            entry(corner(t, h).0, -self.corner_share * each);
        }
    }

    fn edge(&self, e: EdgeId, term: &mut impl FnMut(Term, f64)) {
        let t = self.topology;
        let h = t.edge_halfedge(e);
        let (a, b) = (t.origin(h), t.target(h));
        let [end, beyond] = self.weights;
        term(Term::Vertex(a), end);
        term(Term::Vertex(b), end);
        if let Some(twin) = t.twin(h) {
            self.behind(h, beyond, term);
            self.behind(twin, beyond, term);
            return;
        }
        // The loop goes on from b and comes from before a.
        let ends = [(a, b, boundary_neighbours(t, a).0), (b, a, boundary_neighbours(t, b).1)];
        for (p, l, other) in ends {
            if self.corners == Corners::Sharp && t.fan_size(p) == 1 {
                reflection(p, l, beyond, term);
            } else {
                term(Term::Vertex(other), beyond);
            }
        }
    }

    /// The point behind the origin of a half-edge inside the mesh, seen from its target.
    fn behind(&self, h: HalfedgeId, share: f64, term: &mut impl FnMut(Term, f64)) {
        let t = self.topology;
        let p = t.origin(h);
        if t.is_boundary(p) {
            return reflection(p, t.target(h), share, term);
        }
        let after = |h: HalfedgeId| t.twin(t.prev(h)).unwrap_or(h);
        let before = |h: HalfedgeId| t.twin(h).map_or(h, |twin| t.next(twin));
        if t.fan_size(p) == 4 {
            return term(Term::Vertex(t.target(after(after(h)))), share);
        }
        term(Term::Ring(p), share);
        for h in [before(h), h, after(h)] {
            term(Term::Vertex(t.target(h)), -share);
        }
        for h in [before(before(h)), before(h), h, after(h)] {
            term(Term::Vertex(corner(t, h)), self.corner_share * share);
        }
    }

    /// The mean of the four-point rule across the face in both directions.
    fn face(&self, f: FaceId, edge: &mut impl FnMut(EdgeId, f64)) {
        let t = self.topology;
        let [middle, beyond] = self.weights.map(|w| 0.5 * w);
        for h in t.face_halfedges(f) {
            edge(t.edge(h), middle);
            if let Some(twin) = t.twin(h) {
                edge(t.edge(opposite(t, twin)), beyond);
            } else {
                edge(t.edge(h), 2.0 * beyond);
                edge(t.edge(opposite(t, h)), -beyond);
            }
        }
    }

    /// The finer values at once, the same as by the rows up to rounding.
    pub(crate) fn apply(&self, values: &[Vec3]) -> Vec<Vec3> {
        let t = self.topology;
        let sums = self.ring_sums(values);
        let edge = |e| self.edge_value(EdgeId(e as u32), values, &sums);
        let edges = par::collect(t.edge_count(), edge);
        let face = |f| self.face_value(FaceId(f as u32), |e| edges[e.index()]);
        let faces = par::collect(t.face_count(), face);
        [values, &edges, &faces].concat()
    }

    /// The sums round extraordinary vertices that points on edges are made of; zero for others.
    pub(crate) fn ring_sums(&self, values: &[Vec3]) -> Vec<Vec3> {
        let t = self.topology;
        par::collect(t.vertex_count(), |v| {
            let mut sum = Vec3::ZERO;
            let v = VertexId(v as u32);
            if t.fan_size(v) != 4 && !t.is_boundary(v) && !t.is_isolated(v) {
                self.ring(v, 1.0, &mut |q, weight| sum += weight * values[q as usize]);
            }
            sum
        })
    }

    /// The new point on an edge.
    pub(crate) fn edge_value(&self, e: EdgeId, values: &[Vec3], ring_sums: &[Vec3]) -> Vec3 {
        let mut sum = Vec3::ZERO;
        self.edge(e, &mut |term, weight| {
            let value = match term {
                Term::Vertex(v) => values[v.index()],
                Term::Ring(v) => ring_sums[v.index()],
            };
            sum += weight * value;
        });
        sum
    }

    /// The new point in a face, from those on edges.
    pub(crate) fn face_value(&self, f: FaceId, edge: impl Fn(EdgeId) -> Vec3) -> Vec3 {
        let mut sum = Vec3::ZERO;
        self.face(f, &mut |e, weight| sum += weight * edge(e));
        sum
    }
}

/// The corner opposite the origin of a half-edge in its face.
fn corner(t: &Topology, h: HalfedgeId) -> VertexId {
    t.target(t.next(h))
}

/// The half-edge on the other side of the face.
fn opposite(t: &Topology, h: HalfedgeId) -> HalfedgeId {
    t.next(t.next(h))
}

fn reflection(p: VertexId, l: VertexId, share: f64, term: &mut impl FnMut(Term, f64)) {
    term(Term::Vertex(p), 2.0 * share);
    term(Term::Vertex(l), -share);
}

impl Rows for KobbeltRows<'_> {
    fn len(&self) -> usize {
        let t = self.topology;
        t.vertex_count() + t.edge_count() + t.face_count()
    }

    #[inline]
    fn visit(&self, row: usize, mut entry: impl FnMut(u32, f64)) {
        let (vertices, edges) = (self.topology.vertex_count(), self.topology.edge_count());
        let mut edge = |e: EdgeId, share: f64| {
            self.edge(e, &mut |term, weight| match term {
                Term::Vertex(v) => entry(v.0, share * weight),
                Term::Ring(v) => self.ring(v, share * weight, &mut entry),
            });
        };
        if row >= vertices + edges {
            self.face(FaceId((row - vertices - edges) as u32), &mut edge);
        } else if row >= vertices {
            edge(EdgeId((row - vertices) as u32), 1.0);
        } else {
            entry(row as u32, 1.0);
        }
    }
}
