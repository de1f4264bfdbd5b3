//! A patch: some vertices that it owns, halo rings around them, and all that is known about them in
//! local numbers.

use alloc::vec::Vec;

use super::cut::Rings;
use super::special::Special;
use crate::Topology;
use crate::ids::{EdgeId, FaceId, HalfedgeId, NONE, VertexId};
use crate::scheme::{Rules, Scheme};

/// Stands for a valence: the row is written out.
pub(super) const SPECIAL: u8 = u8::MAX;

/// Stands for a local number: the row is written out.
pub(super) const WRITTEN: u16 = u16::MAX;

/// Rows written out, in the order in which they are asked for.
#[derive(Clone, Debug, Default)]
pub(super) struct Written {
    pub(super) start: Vec<u32>,
    pub(super) entries: Vec<(u16, f64)>,
    /// What the vertex to be met adds.
    pub(super) target: Vec<f64>,
}

/// The faces at the vertices of a patch that have rows, in the order in which these come to them.
#[derive(Clone, Debug, Default)]
pub(super) struct PatchFaces {
    pub(super) size: Vec<u16>,
    pub(super) corner: Vec<u16>,
    /// Doo–Sabin: shape parameters.
    pub(super) lambda: Vec<f64>,
    /// How many there are at the vertices no farther than so many rings.
    pub(super) ends: Vec<u32>,
}

/// A patch in local numbers.
#[derive(Clone, Debug, Default)]
pub(super) struct Patch {
    /// The vertex of every local number: those that the patch owns, then ring by ring.
    pub(super) vertices: Vec<u32>,
    /// How many vertices are no farther than so many rings.
    pub(super) ends: Vec<u32>,
    /// Number of faces at each vertex that has a row, or [`SPECIAL`].
    pub(super) valence: Vec<u8>,
    /// Their neighbours along edges, except for Doo–Sabin; then, except for Loop, their faces.
    pub(super) ring: Vec<u16>,
    /// Doo–Sabin: the weight of each such vertex itself in its limit point, less what its faces add.
    pub(super) centre: Vec<f64>,
    pub(super) faces: PatchFaces,
    /// Limit rows of the special vertices.
    pub(super) limit: Written,
    /// The rows of special finer values.
    pub(super) made: Written,
    /// Points on edges: the ends, and the corners beyond (Loop) or the faces (Catmull–Clark).
    pub(super) edges: Vec<[u16; 4]>,
    /// Catmull–Clark: points in faces.
    pub(super) points: Vec<u16>,
    /// Doo–Sabin: images, as vertex and face.
    pub(super) images: Vec<[u16; 2]>,
}

/// What patches are made from.
pub(super) struct Maker<'a, 't> {
    pub(super) topology: &'t Topology,
    pub(super) rules: &'t Rules,
    pub(super) special: &'a Special<'t>,
    pub(super) rings: &'a Rings,
    /// Rings around the patch that have rows.
    pub(super) reach: u32,
    /// Whether finer values are wanted.
    pub(super) with_finer: bool,
}

/// Local numbers of vertices and faces, [`NONE`] between patches.
pub(super) struct Numbers {
    vertex: Vec<u32>,
    face: Vec<u32>,
}

impl Numbers {
    pub(super) fn new(topology: &Topology, scheme: Scheme) -> Self {
        let faces = if scheme == Scheme::Loop { 0 } else { topology.face_count() };
        Self { vertex: alloc::vec![NONE; topology.vertex_count()], face: alloc::vec![NONE; faces] }
    }
}

impl Maker<'_, '_> {
    /// The patch that owns `vertices` and makes the new points `points`. `None` if there are more local
    /// numbers than fit.
    pub(super) fn patch(
        &self,
        vertices: &[u32],
        points: &[u32],
        numbers: &mut Numbers,
    ) -> Option<Patch> {
        let mut patch = Patch { vertices: vertices.to_vec(), ..Patch::default() };
        for (i, &v) in vertices.iter().enumerate() {
            numbers.vertex[v as usize] = i as u32;
        }
        let mut faces = Vec::new();
        let is_made = self.grow(&mut patch, &mut faces, numbers).is_some();
        if is_made && self.with_finer {
            self.outputs(&mut patch, points, numbers);
        }
        patch.vertices.iter().for_each(|&v| numbers.vertex[v as usize] = NONE);
        faces.iter().for_each(|&f: &u32| numbers.face[f as usize] = NONE);
        is_made.then(|| {
            patch.shrink();
            patch
        })
    }

    /// Halo and rows.
    fn grow(&self, patch: &mut Patch, faces: &mut Vec<u32>, numbers: &mut Numbers) -> Option<()> {
        let mut begin = 0;
        let mut entries = Vec::new();
        patch.ends.push(patch.vertices.len() as u32);
        for _ in 0..=self.reach {
            let end = patch.vertices.len();
            for i in begin..end {
                let v = VertexId(patch.vertices[i]);
                match self.rules.scheme {
                    Scheme::Loop => self.loop_vertex(v, patch, numbers),
                    _ => self.polygon_vertex(v, patch, faces, numbers),
                }
                if patch.vertices.len() >= WRITTEN as usize || faces.len() >= WRITTEN as usize {
                    return None;
                }
                if patch.valence.len() == i {
                    self.special.limit(v, &mut entries);
                    patch.limit.push(&entries, 0.0, numbers);
                    patch.valence.push(SPECIAL);
                    if self.rules.scheme == Scheme::DooSabin {
                        patch.centre.push(0.0);
                    }
                }
            }
            begin = end;
            patch.ends.push(patch.vertices.len() as u32);
            patch.faces.ends.push(faces.len() as u32);
        }
        Some(())
    }

    fn loop_vertex(&self, v: VertexId, patch: &mut Patch, numbers: &mut Numbers) {
        let ring = self.rings.of(v.0);
        let is_smooth = self.special.is_smooth_vertex(v);
        for &q in ring {
            let local = patch.vertex(q, numbers);
            if is_smooth {
                patch.ring.push(local as u16);
            }
        }
        if is_smooth {
            patch.valence.push(ring.len() as u8);
        }
    }

    fn polygon_vertex(
        &self,
        v: VertexId,
        patch: &mut Patch,
        faces: &mut Vec<u32>,
        numbers: &mut Numbers,
    ) {
        let t = self.topology;
        for h in t.fan(v) {
            let f = t.face(h);
            if numbers.face[f.index()] != NONE {
                continue;
            }
            numbers.face[f.index()] = faces.len() as u32;
            faces.push(f.0);
            let corners = t.face_vertices(f);
            for q in corners {
                let local = patch.vertex(q.0, numbers);
                patch.faces.corner.push(local as u16);
            }
            patch.faces.size.push(corners.len().min(WRITTEN as usize) as u16);
            if let Some(lambda) = self.lambda() {
                patch.faces.lambda.push(lambda[f.index()]);
            }
        }
        if !self.special.is_smooth_vertex(v) {
            return;
        }
        if let Some(lambda) = self.lambda() {
            let sum: f64 = t.fan(v).map(|h| lambda[t.face(h).index()]).sum();
            patch.centre.push(sum / f64::from(t.fan_size(v)));
        } else {
            let ring = t.ring(v).map(|q| numbers.vertex[q.index()] as u16);
            patch.ring.extend(ring);
        }
        patch.ring.extend(t.fan(v).map(|h| numbers.face[t.face(h).index()] as u16));
        patch.valence.push(t.fan_size(v) as u8);
    }

    fn lambda(&self) -> Option<&[f64]> {
        self.rules.tension.as_deref().filter(|_| self.rules.scheme == Scheme::DooSabin)
    }

    /// The rows of finer values.
    fn outputs(&self, patch: &mut Patch, points: &[u32], numbers: &Numbers) {
        let mut entries = Vec::new();
        if self.rules.scheme != Scheme::DooSabin {
            for i in 0..patch.ends[0] as usize {
                if patch.valence[i] == SPECIAL {
                    let target = self.special.vertex(VertexId(patch.vertices[i]), &mut entries);
                    patch.made.push(&entries, target, numbers);
                }
            }
        }
        for &point in points {
            match self.rules.scheme {
                Scheme::DooSabin => self.image(patch, point, numbers, &mut entries),
                _ => self.point(patch, point, numbers, &mut entries),
            }
        }
    }

    fn point(
        &self,
        patch: &mut Patch,
        point: u32,
        numbers: &Numbers,
        entries: &mut Vec<(u32, f64)>,
    ) {
        let t = self.topology;
        let Some(e) = Some(point as usize).filter(|&e| e < t.edge_count()) else {
            let f = point as usize - t.edge_count();
            return patch.points.push(numbers.face[f] as u16);
        };
        let h = t.edge_halfedge(EdgeId(e as u32));
        let twin = t.twin(h).filter(|_| self.special.is_smooth_edge(EdgeId(e as u32)));
        let Some(twin) = twin else {
            self.special.point(t.vertex_count() + e, entries);
            patch.made.push(entries, 0.0, numbers);
            return patch.edges.push([WRITTEN; 4]);
        };
        let vertex = |v: VertexId| numbers.vertex[v.index()] as u16;
        let beyond = |h: HalfedgeId| match self.rules.scheme {
            Scheme::Loop => vertex(t.origin(t.prev(h))),
            _ => numbers.face[t.face(h).index()] as u16,
        };
        patch.edges.push([vertex(t.origin(h)), vertex(t.target(h)), beyond(h), beyond(twin)]);
    }

    fn image(
        &self,
        patch: &mut Patch,
        image: u32,
        numbers: &Numbers,
        entries: &mut Vec<(u32, f64)>,
    ) {
        let t = self.topology;
        let v = self.special.vertex_of_image(image as usize);
        let local = numbers.vertex[v.index()] as u16;
        if patch.valence[local as usize] == SPECIAL {
            let target = self.special.image(image as usize, v, entries);
            patch.made.push(entries, target, numbers);
            // The vertex is needed for what is to be met.
            return patch.images.push([local, WRITTEN]);
        }
        let f: FaceId = t.face(HalfedgeId(image));
        patch.images.push([local, numbers.face[f.index()] as u16]);
    }
}

impl Patch {
    /// The local number of a vertex, a new one if it has none.
    fn vertex(&mut self, v: u32, numbers: &mut Numbers) -> u32 {
        let local = &mut numbers.vertex[v as usize];
        if *local == NONE {
            *local = self.vertices.len() as u32;
            self.vertices.push(v);
        }
        *local
    }

    fn shrink(&mut self) {
        self.vertices.shrink_to_fit();
        self.valence.shrink_to_fit();
        self.ring.shrink_to_fit();
        self.edges.shrink_to_fit();
        self.images.shrink_to_fit();
        self.faces.corner.shrink_to_fit();
        self.faces.size.shrink_to_fit();
    }

    /// Bytes that it takes.
    pub(super) fn size(&self) -> usize {
        4 * (self.vertices.len() + self.ends.len() + self.faces.ends.len())
            + self.valence.len()
            + 2 * (self.ring.len() + self.points.len())
            + 8 * (self.centre.len() + self.faces.lambda.len() + self.edges.len())
            + 4 * self.images.len()
            + 2 * (self.faces.size.len() + self.faces.corner.len())
            + self.limit.size()
            + self.made.size()
    }
}

impl Written {
    fn push(&mut self, entries: &[(u32, f64)], target: f64, numbers: &Numbers) {
        if self.start.is_empty() {
            self.start.push(0);
        }
        let local = entries.iter().map(|&(q, weight)| {
            let local = numbers.vertex[q as usize];
            debug_assert!(local != NONE, "rows reach one ring");
            (local as u16, weight)
        });
        self.entries.extend(local);
        self.start.push(self.entries.len() as u32);
        self.target.push(target);
    }

    fn size(&self) -> usize {
        4 * self.start.len() + 16 * self.entries.len() + 8 * self.target.len()
    }
}
