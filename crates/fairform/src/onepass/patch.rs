//! A patch: some vertices that it owns, halo rings around them, and all that is known about them in
//! local numbers.

use alloc::vec::Vec;
use core::ops::Range;

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
    /// Rings around the patch that have rows.
    pub(super) reach: u32,
    /// Whether finer values are wanted.
    pub(super) with_finer: bool,
}

/// Local numbers of vertices and faces, [`NONE`] between patches.
pub(super) struct Numbers {
    vertex: Vec<u32>,
    face: Vec<u32>,
    /// Memory for the patch that is being made.
    patch: Patch,
    rings: Vec<u32>,
    walked: Vec<(u32, u32)>,
    row: Row,
}

/// A row that is written out next.
type Row = Vec<(u32, f64)>;

/// Vertices whose rings are walked at once.
const WALKED: usize = 1024;

impl Numbers {
    pub(super) fn new(topology: &Topology, scheme: Scheme) -> Self {
        let faces = if scheme == Scheme::Loop { 0 } else { topology.face_count() };
        Self {
            vertex: alloc::vec![NONE; topology.vertex_count()],
            face: alloc::vec![NONE; faces],
            patch: Patch::default(),
            rings: Vec::new(),
            walked: Vec::new(),
            row: Row::new(),
        }
    }
}

impl Maker<'_, '_> {
    /// The patch that owns `vertices` and makes the new points `points`. `None` if there are more local
    /// numbers than fit.
    pub(super) fn patch(
        &self,
        vertices: &[(u32, u32)],
        points: &[(u32, u32)],
        numbers: &mut Numbers,
    ) -> Option<Patch> {
        let mut patch = core::mem::take(&mut numbers.patch);
        patch.clear();
        for &(from, to) in vertices {
            patch.vertices.extend(from..to);
        }
        for (i, &v) in patch.vertices.iter().enumerate() {
            numbers.vertex[v as usize] = i as u32;
        }
        let mut faces = Vec::new();
        let is_made = self.grow(&mut patch, &mut faces, numbers).is_some();
        if is_made && self.with_finer {
            self.outputs(&mut patch, points, numbers);
        }
        patch.vertices.iter().for_each(|&v| numbers.vertex[v as usize] = NONE);
        faces.iter().for_each(|&f: &u32| numbers.face[f as usize] = NONE);
        // As much memory as it takes, and no more.
        let made = is_made.then(|| patch.clone());
        numbers.patch = patch;
        made
    }

    /// Halo and rows.
    fn grow(&self, patch: &mut Patch, faces: &mut Vec<u32>, numbers: &mut Numbers) -> Option<()> {
        let mut begin = 0;
        patch.ends.push(patch.vertices.len() as u32);
        for _ in 0..=self.reach {
            let end = patch.vertices.len();
            if self.rules.scheme == Scheme::Loop {
                for first in (begin..end).step_by(WALKED) {
                    self.loop_vertices(first..end.min(first + WALKED), patch, numbers)?;
                }
            } else {
                for i in begin..end {
                    self.polygon_vertex(VertexId(patch.vertices[i]), patch, faces, numbers);
                    if patch.valence.len() == i {
                        self.special_vertex(VertexId(patch.vertices[i]), patch, numbers);
                    }
                    if patch.vertices.len().max(faces.len()) >= WRITTEN as usize {
                        return None;
                    }
                }
            }
            begin = end;
            patch.ends.push(patch.vertices.len() as u32);
            patch.faces.ends.push(faces.len() as u32);
        }
        Some(())
    }

    #[cold]
    fn special_vertex(&self, v: VertexId, patch: &mut Patch, numbers: &mut Numbers) {
        self.special.limit(v, &mut numbers.row);
        patch.limit.push(&numbers.row, 0.0, &numbers.vertex);
        patch.valence.push(SPECIAL);
        if self.rules.scheme == Scheme::DooSabin {
            patch.centre.push(0.0);
        }
    }

    /// Rows of Loop's scheme, whose vertices come ring by ring.
    fn loop_vertices(
        &self,
        range: Range<usize>,
        patch: &mut Patch,
        numbers: &mut Numbers,
    ) -> Option<()> {
        let t = self.topology;
        let mut rings = core::mem::take(&mut numbers.rings);
        let mut walked = core::mem::take(&mut numbers.walked);
        walked.clear();
        walked.extend(patch.vertices[range].iter().map(|&v| (v, t.valence(VertexId(v)))));
        rings.resize(walked.iter().map(|&(_, valence)| valence as usize).sum(), NONE);
        t.rings(walked.iter().map(|&(v, _)| VertexId(v)), &mut rings);
        let mut rest = rings.as_slice();
        let mut fits = true;
        for &(v, valence) in &walked {
            let (ring, others) = rest.split_at(valence as usize);
            rest = others;
            let is_smooth = self.special.is_smooth_ring(VertexId(v), valence);
            let Patch { vertices, ring: local_ring, .. } = patch;
            let local = ring.iter().map(|&q| local(q, vertices, &mut numbers.vertex) as u16);
            if is_smooth {
                local_ring.extend(local);
                patch.valence.push(valence as u8);
            } else {
                local.for_each(drop);
                self.special_vertex(VertexId(v), patch, numbers);
            }
            fits = patch.vertices.len() < WRITTEN as usize;
            if !fits {
                break;
            }
        }
        (numbers.rings, numbers.walked) = (rings, walked);
        fits.then_some(())
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
                let local = local(q.0, &mut patch.vertices, &mut numbers.vertex);
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
    fn outputs(&self, patch: &mut Patch, points: &[(u32, u32)], numbers: &mut Numbers) {
        if self.rules.scheme != Scheme::DooSabin {
            for i in 0..patch.ends[0] as usize {
                if patch.valence[i] == SPECIAL {
                    let target = self.special.vertex(VertexId(patch.vertices[i]), &mut numbers.row);
                    patch.made.push(&numbers.row, target, &numbers.vertex);
                }
            }
        }
        for &(from, to) in points {
            match self.rules.scheme {
                Scheme::Loop => self.loop_edges(from..to, patch, numbers),
                Scheme::DooSabin => (from..to).for_each(|image| self.image(patch, image, numbers)),
                _ => (from..to).for_each(|point| self.point(patch, point, numbers)),
            }
        }
    }

    /// Points on edges of triangles, whose half-edges come three by three.
    fn loop_edges(&self, edges: Range<u32>, patch: &mut Patch, numbers: &mut Numbers) {
        let t = self.topology;
        for e in edges.map(EdgeId) {
            let h = t.edge_halfedge(e);
            let Some(twin) = t.twin(h).filter(|_| self.special.is_smooth_edge(e)) else {
                self.special_point(patch, e, numbers);
                continue;
            };
            let [next, prev] = around_triangle(h);
            let [_, last] = around_triangle(twin);
            let local = |h: HalfedgeId| numbers.vertex[t.origin(h).index()] as u16;
            patch.edges.push([local(h), local(next), local(prev), local(last)]);
        }
    }

    fn point(&self, patch: &mut Patch, point: u32, numbers: &mut Numbers) {
        let t = self.topology;
        if point as usize >= t.edge_count() {
            let f = point as usize - t.edge_count();
            return patch.points.push(numbers.face[f] as u16);
        }
        let e = EdgeId(point);
        let h = t.edge_halfedge(e);
        let Some(twin) = t.twin(h).filter(|_| self.special.is_smooth_edge(e)) else {
            return self.special_point(patch, e, numbers);
        };
        let vertex = |v: VertexId| numbers.vertex[v.index()] as u16;
        let face = |h: HalfedgeId| numbers.face[t.face(h).index()] as u16;
        patch.edges.push([vertex(t.origin(h)), vertex(t.target(h)), face(h), face(twin)]);
    }

    #[cold]
    fn special_point(&self, patch: &mut Patch, e: EdgeId, numbers: &mut Numbers) {
        self.special.point(self.topology.vertex_count() + e.index(), &mut numbers.row);
        patch.made.push(&numbers.row, 0.0, &numbers.vertex);
        patch.edges.push([WRITTEN; 4]);
    }

    fn image(&self, patch: &mut Patch, image: u32, numbers: &mut Numbers) {
        let t = self.topology;
        let v = self.special.vertex_of_image(image as usize);
        let local = numbers.vertex[v.index()] as u16;
        if patch.valence[local as usize] == SPECIAL {
            let target = self.special.image(image as usize, v, &mut numbers.row);
            patch.made.push(&numbers.row, target, &numbers.vertex);
            // The vertex is needed for what is to be met.
            return patch.images.push([local, WRITTEN]);
        }
        let f: FaceId = t.face(HalfedgeId(image));
        patch.images.push([local, numbers.face[f.index()] as u16]);
    }
}

/// The half-edges after and before one of a triangle.
#[inline]
fn around_triangle(h: HalfedgeId) -> [HalfedgeId; 2] {
    let first = h.0 / 3 * 3;
    let [next, prev] = match h.0 - first {
        0 => [first + 1, first + 2],
        1 => [first + 2, first],
        _ => [first, first + 1],
    };
    [HalfedgeId(next), HalfedgeId(prev)]
}

/// The local number of a vertex, a new one if it has none.
#[inline]
fn local(v: u32, vertices: &mut Vec<u32>, numbers: &mut [u32]) -> u32 {
    let local = &mut numbers[v as usize];
    if *local == NONE {
        *local = vertices.len() as u32;
        vertices.push(v);
    }
    *local
}

impl Patch {
    /// Empty again, with the memory that it has.
    fn clear(&mut self) {
        self.vertices.clear();
        self.ends.clear();
        self.valence.clear();
        self.ring.clear();
        self.centre.clear();
        self.faces.size.clear();
        self.faces.corner.clear();
        self.faces.lambda.clear();
        self.faces.ends.clear();
        self.limit.clear();
        self.made.clear();
        self.edges.clear();
        self.points.clear();
        self.images.clear();
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
    fn clear(&mut self) {
        self.start.clear();
        self.entries.clear();
        self.target.clear();
    }

    fn push(&mut self, entries: &[(u32, f64)], target: f64, numbers: &[u32]) {
        if self.start.is_empty() {
            self.start.push(0);
        }
        let local = entries.iter().map(|&(q, weight)| {
            let local = numbers[q as usize];
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
