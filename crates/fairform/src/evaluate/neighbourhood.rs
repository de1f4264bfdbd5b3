//! [`Neighbourhood`]: the faces that the limit surface over one face depends on, numbered in a way
//! that only their arrangement decides.

use alloc::sync::Arc;
use alloc::vec::Vec;
use core::iter::successors;

use crate::ids::{HalfedgeId, NONE, VertexId};
use crate::rules::boundary_neighbours;
use crate::scheme::{Rules, Scheme};
use crate::{Creases, Faces, Topology};

/// The faces round a face, or for Doo–Sabin round a vertex, cut out of a mesh. Where the cut makes a
/// vertex fall into several fans, each has a copy of it.
pub(crate) struct Neighbourhood {
    /// The vertices in the mesh that this was cut out of; a vertex may come several times. The
    /// corners of the face come first, or the vertex.
    pub(crate) vertices: Vec<VertexId>,
    /// How many of them the surface depends on. The others are there since the rules for the
    /// boundary depend on how many faces there are.
    pub(crate) value_count: usize,
    faces: Faces,
    twin: Vec<u32>,
    /// Sharpness of the edge of each half-edge, and of the corners of the face, where it matters;
    /// empty if nothing is sharp.
    edge_sharpness: Vec<f64>,
    corner_sharpness: Vec<f64>,
}

/// A neighbourhood as a mesh by itself.
pub(crate) struct Local {
    pub(crate) topology: Topology,
    pub(crate) rules: Rules,
    pub(crate) value_count: usize,
}

impl Neighbourhood {
    /// All that the rules can see.
    pub(crate) fn key(&self) -> Vec<u32> {
        let faces = &self.faces;
        let mut key = Vec::with_capacity(2 + faces.len() + 2 * self.twin.len());
        key.push(faces.len() as u32);
        key.push(self.value_count as u32);
        key.extend(faces.iter().map(|f| f.len() as u32));
        key.extend(faces.corners());
        key.extend(&self.twin);
        for s in self.edge_sharpness.iter().chain(&self.corner_sharpness) {
            let bits = s.to_bits();
            key.extend([(bits >> 32) as u32, bits as u32]);
        }
        key
    }

    pub(crate) fn into_local(self, rules: &Rules) -> Local {
        let topology = Topology::from_twins(self.vertices.len(), &self.faces, self.twin);
        let mut creases = None;
        if !self.edge_sharpness.is_empty() {
            let mut sharp = Creases::smooth(&topology);
            // A sharpness that is there is no negative number.
            for (h, &s) in topology.halfedges().zip(&self.edge_sharpness) {
                sharp.set_edge(topology.edge(h), s).expect("a sharpness");
            }
            for (v, &s) in topology.vertices().zip(&self.corner_sharpness) {
                sharp.set_vertex(v, s).expect("a sharpness");
            }
            creases = Some(Arc::new(sharp));
        }
        let rules = Rules { tension: None, creases, ..rules.clone() };
        Local { topology, rules, value_count: self.value_count }
    }
}

/// Cuts neighbourhoods out of a mesh.
pub(crate) struct Gatherer<'a> {
    topology: &'a Topology,
    rules: &'a Rules,
    /// The number of each face in the neighbourhood; [`NONE`] between two of them.
    place: Vec<u32>,
    /// The half-edge with which each face of the neighbourhood begins.
    first: Vec<HalfedgeId>,
}

impl<'a> Gatherer<'a> {
    pub(crate) fn new(topology: &'a Topology, rules: &'a Rules) -> Self {
        let place = alloc::vec![NONE; topology.face_count()];
        Self { topology, rules, place, first: Vec::new() }
    }

    /// The neighbourhood of the face of `h`, with that corner first; for Doo–Sabin of the vertex where
    /// `h` begins, with that face first.
    pub(crate) fn gather(&mut self, h: HalfedgeId) -> Neighbourhood {
        let corners: Vec<HalfedgeId> = self.corners(h).collect();
        if self.rules.scheme == Scheme::DooSabin {
            self.add_fan(h);
        } else {
            self.add(h);
            for &h in &corners {
                self.add_fan(h);
            }
        }
        let near = self.first.len();
        self.add_boundary_fans(&corners);
        self.finish(1, near)
    }

    /// The neighbourhoods of the faces of several half-edges as one; these faces first.
    pub(crate) fn gather_all(
        &mut self,
        seeds: impl Iterator<Item = HalfedgeId> + Clone,
    ) -> Neighbourhood {
        seeds.clone().for_each(|h| self.add(h));
        let count = self.first.len();
        let mut corners: Vec<HalfedgeId> = seeds.flat_map(|h| self.corners(h)).collect();
        // Each vertex once: the time is not to be quadratic in the valence.
        corners.sort_by_key(|&h| self.topology.origin(h));
        corners.dedup_by_key(|&mut h| self.topology.origin(h));
        corners.iter().for_each(|&h| self.add_fan(h));
        let near = self.first.len();
        self.add_boundary_fans(&corners);
        self.finish(count, near)
    }

    /// Loop's rules on the boundary depend on how many faces the neighbours there have.
    fn add_boundary_fans(&mut self, corners: &[HalfedgeId]) {
        if self.rules.scheme != Scheme::Loop {
            return;
        }
        let topology = self.topology;
        for v in corners.iter().map(|&h| topology.origin(h)).filter(|&v| topology.is_boundary(v)) {
            let (before, after) = boundary_neighbours(topology, v);
            let outgoing = [before, after].into_iter().filter_map(|q| topology.outgoing(q));
            outgoing.for_each(|h| self.add_fan(h));
        }
    }

    fn finish(&mut self, seeds: usize, near: usize) -> Neighbourhood {
        let found = self.cut(seeds, near);
        self.first.drain(..).for_each(|h| self.place[self.topology.face(h).index()] = NONE);
        found
    }

    /// The half-edges of the face of `h`, from there.
    fn corners(&self, h: HalfedgeId) -> impl Iterator<Item = HalfedgeId> + use<'a> {
        let topology = self.topology;
        let count = topology.face_halfedges(topology.face(h)).len();
        successors(Some(h), move |&h| Some(topology.next(h))).take(count)
    }

    /// The faces at the vertex where `h` begins, from there, or from the boundary if it has one.
    fn add_fan(&mut self, h: HalfedgeId) {
        let topology = self.topology;
        let v = topology.origin(h);
        let start = if topology.is_boundary(v) { topology.outgoing(v) } else { Some(h) };
        let fan = successors(start, |&h| topology.twin(topology.prev(h)));
        fan.take(topology.fan_size(v) as usize).for_each(|h| self.add(h));
    }

    fn add(&mut self, h: HalfedgeId) {
        let place = &mut self.place[self.topology.face(h).index()];
        if *place == NONE {
            *place = self.first.len() as u32;
            self.first.push(h);
        }
    }

    fn cut(&self, seeds: usize, near: usize) -> Neighbourhood {
        let topology = self.topology;
        let mut start = Vec::with_capacity(self.first.len() + 1);
        let mut halfedges = Vec::with_capacity(4 * self.first.len());
        for &h in &self.first {
            start.push(halfedges.len());
            halfedges.extend(self.corners(h));
        }
        start.push(halfedges.len());
        let local = |h: HalfedgeId| {
            let place = *self.place.get(topology.face(h).index())?;
            let place = (place != NONE).then_some(place as usize)?;
            let size = start[place + 1] - start[place];
            Some(start[place] + (h.index() + size - self.first[place].index()) % size)
        };
        let twin: Vec<u32> = halfedges
            .iter()
            .map(|&h| topology.twin(h).and_then(local).map_or(NONE, |t| t as u32))
            .collect();

        // A fan at a time, so that vertices are told apart by their fans.
        let (mut origin, mut vertices) = (alloc::vec![NONE; halfedges.len()], Vec::new());
        let (mut corner_count, mut value_count) = (0, 0);
        for i in 0..halfedges.len() {
            if origin[i] == NONE {
                let number = vertices.len() as u32;
                vertices.push(topology.origin(halfedges[i]));
                let mut at = Some(halfedges[i]);
                while let Some((h, i)) = at.and_then(|h| Some((h, local(h)?))) {
                    if core::mem::replace(&mut origin[i], number) == number {
                        break;
                    }
                    at = topology.twin(topology.prev(h));
                }
                at = topology.twin(halfedges[i]).map(|t| topology.next(t));
                while let Some((h, i)) = at.and_then(|h| Some((h, local(h)?))) {
                    if core::mem::replace(&mut origin[i], number) == number {
                        break;
                    }
                    at = topology.twin(h).map(|t| topology.next(t));
                }
            }
            if i < start[seeds] {
                corner_count = vertices.len();
            }
            if i < start[near] {
                value_count = vertices.len();
            }
        }

        let faces: Faces = start.windows(2).map(|w| &origin[w[0]..w[1]]).collect();
        let (mut edge_sharpness, mut corner_sharpness) = (Vec::new(), Vec::new());
        if let Some(creases) = &self.rules.creases {
            // Only what the corners of the face can see.
            let is_corner =
                |h: HalfedgeId| local(h).is_some_and(|i| (origin[i] as usize) < corner_count);
            edge_sharpness.extend(halfedges.iter().map(|&h| {
                let is_seen = is_corner(h) || is_corner(topology.next(h));
                if is_seen { creases.edge(topology.edge(h)) } else { 0.0 }
            }));
            corner_sharpness.extend(vertices[..corner_count].iter().map(|&v| creases.vertex(v)));
            if edge_sharpness.iter().chain(&corner_sharpness).all(|&s| s == 0.0) {
                edge_sharpness.clear();
                corner_sharpness.clear();
            }
        }
        Neighbourhood { vertices, value_count, faces, twin, edge_sharpness, corner_sharpness }
    }
}
