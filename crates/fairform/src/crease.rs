//! Sharpness of edges and vertices, with OpenSubdiv's meaning, and what it makes of the rules.
//!
//! An edge of sharpness `s` is refined like a crease for `s` steps and smoothly after, with a blend in
//! between for the fraction; from [`INFINITE`] on it stays a crease. A vertex of positive sharpness is
//! a corner likewise. Boundary edges are infinitely sharp. \[DeRose1998\]

use alloc::vec::Vec;

use crate::error::Error;
use crate::fairness::face_normal;
use crate::ids::{EdgeId, FaceId, VertexId};
use crate::scheme::Corners;
use crate::{Topology, par};

/// Sharpness from which an edge or vertex stays sharp for ever.
pub const INFINITE: f64 = 10.0;

/// Sharpness of the edges and vertices of a topology; zero is smooth.
#[derive(Clone, PartialEq, Debug)]
pub struct Creases {
    edge: Vec<f64>,
    vertex: Vec<f64>,
}

impl Creases {
    /// All smooth.
    #[must_use]
    pub fn smooth(topology: &Topology) -> Self {
        Self {
            edge: alloc::vec![0.0; topology.edge_count()],
            vertex: alloc::vec![0.0; topology.vertex_count()],
        }
    }

    /// Edges whose faces meet at more than `degrees`, with a sharpness.
    ///
    /// # Errors
    /// [`Error::BadOption`] for an angle or sharpness that is negative or not a number.
    ///
    /// # Panics
    /// If there is not one position per vertex.
    pub fn by_angle(
        topology: &Topology,
        positions: &[crate::Vec3],
        degrees: f64,
        sharpness: f64,
    ) -> Result<Self, Error> {
        check("the angle of creases", degrees)?;
        assert_eq!(positions.len(), topology.vertex_count(), "one position per vertex");
        let normals = par::collect(topology.face_count(), |f| {
            face_normal(topology, FaceId(f as u32), |v| positions[v.index()])
        });
        let normal = |h| normals[topology.face(h).index()];
        let limit = libm::cos(degrees.min(180.0).to_radians());
        let mut creases = Self::smooth(topology);
        for e in topology.edges() {
            let h = topology.edge_halfedge(e);
            if let Some(t) = topology.twin(h)
                && normal(h).dot(normal(t)) < limit
            {
                creases.set_edge(e, sharpness)?;
            }
        }
        Ok(creases)
    }

    /// Makes an edge so sharp.
    ///
    /// # Errors
    /// [`Error::BadOption`] if the sharpness is negative or not a number.
    ///
    /// # Panics
    /// If there is no such edge.
    pub fn set_edge(&mut self, edge: EdgeId, sharpness: f64) -> Result<(), Error> {
        self.edge[edge.index()] = check("the sharpness of an edge", sharpness)?;
        Ok(())
    }

    /// Makes a vertex so sharp.
    ///
    /// # Errors
    /// [`Error::BadOption`] if the sharpness is negative or not a number.
    ///
    /// # Panics
    /// If there is no such vertex.
    pub fn set_vertex(&mut self, vertex: VertexId, sharpness: f64) -> Result<(), Error> {
        self.vertex[vertex.index()] = check("the sharpness of a vertex", sharpness)?;
        Ok(())
    }

    /// Sharpness of an edge.
    ///
    /// # Panics
    /// If there is no such edge.
    #[must_use]
    pub fn edge(&self, edge: EdgeId) -> f64 {
        self.edge[edge.index()]
    }

    /// Sharpness of a vertex.
    ///
    /// # Panics
    /// If there is no such vertex.
    #[must_use]
    pub fn vertex(&self, vertex: VertexId) -> f64 {
        self.vertex[vertex.index()]
    }

    /// Whether nothing is sharp.
    #[must_use]
    pub fn is_smooth(&self) -> bool {
        self.edge.iter().chain(&self.vertex).all(|&s| s == 0.0)
    }

    pub(crate) fn fits(&self, topology: &Topology) -> bool {
        self.edge.len() == topology.edge_count() && self.vertex.len() == topology.vertex_count()
    }

    /// The sharpness that is left on the finer mesh, whose two halves of each edge `halves` tells.
    pub(crate) fn refined(&self, finer: &Topology, halves: impl Fn(EdgeId) -> [EdgeId; 2]) -> Self {
        let mut next = Self::smooth(finer);
        for (e, &sharpness) in self.edge.iter().enumerate().filter(|e| *e.1 > 0.0) {
            for half in halves(EdgeId(e as u32)) {
                next.edge[half.index()] = after_step(sharpness);
            }
        }
        for (new, &old) in next.vertex.iter_mut().zip(&self.vertex) {
            *new = after_step(old);
        }
        next
    }
}

fn check(what: &'static str, value: f64) -> Result<f64, Error> {
    if value >= 0.0 {
        return Ok(value);
    }
    Err(Error::BadOption { what, expected: "zero or positive", value })
}

/// The sharpness that is left after one step.
pub(crate) fn after_step(sharpness: f64) -> f64 {
    if sharpness >= INFINITE { sharpness } else { (sharpness - 1.0).max(0.0) }
}

/// The sharpness that is left after several steps.
fn sharpness_after(sharpness: f64, steps: u32) -> f64 {
    (0..steps.min(INFINITE as u32)).fold(sharpness, |s, _| after_step(s))
}

/// Which rule a vertex follows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Kind {
    /// No sharp edge, or one: the rule is the same.
    Smooth,
    /// On a curve between two neighbours.
    Crease([VertexId; 2]),
    /// Stays where it is.
    Corner,
}

/// The sharpness of everything: boundary, corners and creases together.
#[derive(Clone, Copy)]
pub(crate) struct Sharpness<'a> {
    pub(crate) topology: &'a Topology,
    pub(crate) corners: Corners,
    pub(crate) creases: Option<&'a Creases>,
}

impl Sharpness<'_> {
    pub(crate) fn edge(self, e: EdgeId) -> f64 {
        if self.topology.is_boundary_edge(e) {
            return INFINITE;
        }
        self.creases.map_or(0.0, |c| c.edge[e.index()])
    }

    pub(crate) fn vertex(self, v: VertexId) -> f64 {
        let own = self.creases.map_or(0.0, |c| c.vertex[v.index()]);
        let t = self.topology;
        let is_kept = self.corners == Corners::Sharp && t.fan_size(v) == 1 && t.is_boundary(v);
        if is_kept { INFINITE } else { own }
    }

    /// The edges at a vertex, in the order of its ring, and their other ends.
    pub(crate) fn edges(self, v: VertexId) -> impl Iterator<Item = (EdgeId, VertexId)> {
        let t = self.topology;
        let inner = t.fan(v).map(move |h| (t.edge(h), t.target(h)));
        let last = t.is_boundary(v).then(|| t.fan(v).last()).flatten().map(move |h| {
            let back = t.prev(h);
            (t.edge(back), t.origin(back))
        });
        inner.chain(last)
    }

    /// The edges at a vertex that are still sharp `steps` later, and their other ends.
    pub(crate) fn sharp_edges(
        self,
        v: VertexId,
        steps: u32,
    ) -> impl Iterator<Item = (EdgeId, VertexId)> {
        self.edges(v).filter(move |e| sharpness_after(self.edge(e.0), steps) > 0.0)
    }

    /// The rule of a vertex, `steps` later; on the boundary without creases at a glance.
    pub(crate) fn kind(self, v: VertexId, steps: u32) -> Kind {
        if sharpness_after(self.vertex(v), steps) > 0.0 {
            return Kind::Corner;
        }
        if self.creases.is_none() && !self.topology.is_boundary(v) {
            return Kind::Smooth;
        }
        let mut ends = [v; 2];
        let mut count = 0;
        for (_, q) in self.sharp_edges(v, steps) {
            if let Some(end) = ends.get_mut(count) {
                *end = q;
            }
            count += 1;
        }
        match count {
            0 | 1 => Kind::Smooth,
            2 => Kind::Crease(ends),
            _ => Kind::Corner,
        }
    }

    /// The rules that the new position of a vertex is blended from, with their weights.
    pub(crate) fn blend(self, v: VertexId) -> [(Kind, f64); 2] {
        let now = self.kind(v, 0);
        if self.creases.is_none() {
            return [(now, 1.0), (now, 0.0)];
        }
        let next = self.kind(v, 1);
        if core::mem::discriminant(&now) == core::mem::discriminant(&next) {
            return [(now, 1.0), (now, 0.0)];
        }
        // The mean sharpness of what is about to vanish.
        let vanishing = |s: f64| s > 0.0 && after_step(s) == 0.0;
        let all = core::iter::once(self.vertex(v)).chain(self.edges(v).map(|e| self.edge(e.0)));
        let (sum, count) =
            all.filter(|&s| vanishing(s)).fold((0.0, 0.0), |(sum, n), s| (sum + s, n + 1.0));
        let weight = if count == 0.0 { 0.0 } else { f64::min(1.0, sum / count) };
        [(now, weight), (next, 1.0 - weight)]
    }
}
