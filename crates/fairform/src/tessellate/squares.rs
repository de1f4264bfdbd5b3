//! [`Squares`]: Doo and Sabin's scheme at once. It is dual, so the points belong to the vertices of the
//! base: each becomes a square of them, and the faces between squares lie in its edges and faces.
//!
//! ```text
//!              │                   u runs along the first half-edge from the vertex, v along the next
//!        f₁    │    f₀             one around it. Both count the points from the far side, so that
//!            ○ │ ○     v           those towards the face at the first half-edge come last.
//!      ──────── ────── ↑
//!            ○ │ ○     └→ u        At the boundary the first half-edge runs along it: the points with
//!        f₂    │    f₃             v below the middle come from the images in its edges.
//! ```

use alloc::vec::Vec;
use core::ops::Range;

use super::cells::{Key, distinct};
use super::classes::{MOST_CLASSES, MOST_SOURCES, MOST_WEIGHTS, point_rows};
use super::kernel::Form;
use super::{BLOCK, Points, Steps};
use crate::error::Error;
use crate::ids::{FaceId, HalfedgeId, VertexId};
use crate::refine::boundary_numbers;
use crate::scheme::{Border, Rules};
use crate::{Faces, Topology, par};

/// How the points of all squares are made, and the faces in and between them.
#[derive(Clone, Debug)]
pub(super) struct Squares {
    /// Points along each side.
    pub(super) side: usize,
    /// Vertices with faces of the same sizes around share a form.
    pub(super) forms: Vec<Form>,
    pub(super) class: Vec<u32>,
    /// Where the sources of each vertex begin, and the end.
    start: Vec<u32>,
    sources: Vec<u32>,
    /// The faces inside a square, row by row, in its points.
    inside: Vec<u16>,
}

/// Whether all vertices become squares.
pub(super) fn is_ready(topology: &Topology, rules: &Rules) -> bool {
    let is_ready = |v: VertexId| match topology.is_boundary(v) {
        true => topology.fan_size(v) == 2 && rules.border == Border::Bspline,
        false => topology.fan_size(v) == 4,
    };
    let blocks = par::blocks(topology.vertex_count(), |mut block| {
        block.all(|v| is_ready(VertexId(v as u32)))
    });
    rules.tension.is_none() && blocks.into_iter().all(|ready| ready)
}

impl Squares {
    /// For a topology that [`is_ready`]; `None` if more would meet than a form should have sources, or
    /// there would be too many forms.
    pub(super) fn new(
        topology: &Topology,
        rules: &Rules,
        levels: u32,
        points: Points,
    ) -> Result<Option<Self>, Error> {
        let count = topology.vertex_count();
        let keys = par::collect(count, |v| key(topology, VertexId(v as u32)));
        let known = distinct(&keys);
        let (side, most) = (1_usize << levels, MOST_SOURCES);
        let weights: usize = known.iter().map(|&k| 3 * side * side * source_count(k)).sum();
        let is_usual = |&k: &Key| k != Key::default() && source_count(k) <= most;
        if known.len() > MOST_CLASSES || weights > MOST_WEIGHTS || !known.iter().all(is_usual) {
            return Ok(None);
        }
        let forms = known
            .iter()
            .map(|&key| form(key, rules, levels, points))
            .collect::<Result<Vec<_>, _>>()?;
        let counts: Vec<u32> = known.iter().map(|&key| source_count(key) as u32).collect();
        let class = par::collect(count, |v| {
            known.binary_search(&keys[v]).expect("it is one of those found") as u32
        });
        drop(keys);
        let start = par::starts(count, |v| counts[class[v] as usize])
            .map_err(|end| Error::TooLarge { halfedges: end })?;
        let mut sources = alloc::vec![0; start[count] as usize];
        let mut nothing = alloc::vec![(); sources.len()];
        par::fill_rows(&start, &mut sources, &mut nothing, &|v, row: &mut [u32], _| {
            around(topology, VertexId(v as u32), row);
        });
        let mut inside = Vec::with_capacity(4 * (side - 1) * (side - 1));
        for v in 0..side - 1 {
            for p in v * side..v * side + side - 1 {
                inside.extend([p, p + 1, p + 1 + side, p + side].map(|p| p as u16));
            }
        }
        Ok(Some(Self { side, forms, class, start, sources, inside }))
    }

    /// Points of a square.
    pub(super) fn point_count(&self) -> usize {
        self.side * self.side
    }

    /// The vertices that the points of a vertex are made of.
    #[inline(always)]
    pub(super) fn sources(&self, v: usize) -> &[u32] {
        &self.sources[self.start[v] as usize..self.start[v + 1] as usize]
    }

    pub(super) fn face_count(&self, base: &Topology) -> usize {
        let between = self.side - 1;
        base.face_count() + (base.edge_count() + base.vertex_count() * between) * between
    }

    /// How many faces there are in some faces of the base, and how many corners they have.
    pub(super) fn size(&self, base: &Topology, faces: Range<usize>) -> [usize; 2] {
        let between = self.side - 1;
        let (mut corners, mut quadrilaterals) = (0, 0);
        for f in faces.clone() {
            for h in base.face_halfedges(FaceId(f as u32)) {
                corners += 1;
                quadrilaterals += usize::from(leads(base, h)) * between
                    + usize::from(is_first(base, h)) * between * between;
            }
        }
        [faces.len() + quadrilaterals, corners + 4 * quadrilaterals]
    }

    pub(super) fn faces(&self, base: &Topology) -> Faces {
        self.faces_in(base, 0..base.face_count(), &|v, _| v)
    }

    /// The faces in one of the base, in the points of the squares of its corners.
    pub(super) fn patch_faces(&self, base: &Topology, face: FaceId) -> Faces {
        self.faces_in(base, face.index()..face.index() + 1, &|_, corner| corner)
    }

    fn faces_in(
        &self,
        base: &Topology,
        faces: Range<usize>,
        square: &(impl Fn(usize, usize) -> usize + Sync),
    ) -> Faces {
        let [count, corner_count] = self.size(base, faces.clone());
        let (mut starts, mut corners) = (alloc::vec![0; count + 1], alloc::vec![0; corner_count]);
        starts[count] = u32::try_from(corner_count).expect("fewer than 2^32 corners");
        self.fill(base, faces, square, &mut corners, Some(&mut starts[..count]));
        Faces::from_starts(starts, corners)
    }

    /// Writes the corners of the faces in some faces of the base.
    pub(super) fn fill_faces(&self, base: &Topology, faces: Range<usize>, out: &mut [u32]) {
        self.fill(base, faces, &|v, _| v, out, None);
    }

    /// `square(v, i)` is the number of the square of vertex `v`, which is corner `i` of a face.
    fn fill(
        &self,
        base: &Topology,
        faces: Range<usize>,
        square: &(impl Fn(usize, usize) -> usize + Sync),
        corners: &mut [u32],
        starts: Option<&mut [u32]>,
    ) {
        let (end, with_starts) = (faces.end, starts.is_some());
        let blocks: Vec<_> = faces.step_by(BLOCK).map(|f| f..(f + BLOCK).min(end)).collect();
        let sizes = par::map_parts(blocks.clone(), |block| self.size(base, block));
        let total: usize = sizes.iter().map(|size| size[1]).sum();
        assert_eq!(corners.len(), total, "room for the corners");
        let all_starts = par::cut(
            starts.unwrap_or_default(),
            sizes.iter().map(|size| if with_starts { size[0] } else { 0 }),
        );
        let all_corners = par::cut(corners, sizes.iter().map(|size| size[1]));
        let (mut parts, mut first) = (Vec::with_capacity(blocks.len()), 0);
        for ((block, corners), starts) in blocks.into_iter().zip(all_corners).zip(all_starts) {
            let count = corners.len();
            parts.push((block, corners, starts, first));
            first += count;
        }
        par::in_parts(parts, |(block, mut corners, starts, first)| {
            let mut squares = Vec::new();
            let (mut starts, mut next) = (starts, first as u32);
            for f in block {
                let before = corners.len();
                let size = base.face_vertices(FaceId(f as u32)).len();
                corners = self.write_face(base, f, square, &mut squares, corners);
                if !with_starts {
                    continue;
                }
                let count = 1 + (before - corners.len() - size) / 4;
                let own;
                (own, starts) = starts.split_at_mut(count);
                own[0] = next;
                next += size as u32;
                own[1..].iter_mut().zip(0..).for_each(|(slot, i)| *slot = next + 4 * i);
                next += 4 * (count as u32 - 1);
            }
        });
    }

    /// Writes the faces in a face of the base: the one amid its corners, those along the edges that
    /// begin with it, and those of the squares of the vertices that do.
    fn write_face<'o>(
        &self,
        base: &Topology,
        face: usize,
        square: &impl Fn(usize, usize) -> usize,
        squares: &mut Vec<[usize; 2]>,
        out: &'o mut [u32],
    ) -> &'o mut [u32] {
        let halfedges = || base.face_halfedges(FaceId(face as u32));
        squares.clear();
        squares.extend(halfedges().enumerate().map(|(i, h)| {
            let number = square(base.origin(h).index(), i);
            [number * self.point_count(), place(base, h)]
        }));
        let last = self.side - 1;
        let (own, mut out) = out.split_at_mut(squares.len());
        for (slot, &[first, turns]) in own.iter_mut().zip(&*squares) {
            *slot = (first + self.turned(turns, last, last)) as u32;
        }
        for (i, _) in halfedges().enumerate().filter(|&(_, h)| leads(base, h)) {
            let own;
            (own, out) = out.split_at_mut(4 * last);
            let [a, turns_a] = squares[i];
            let [b, turns_b] = squares[(i + 1) % squares.len()];
            let here = |t| (a + self.turned(turns_a, last, t)) as u32;
            // Seen from the other end, the points of its side come in the other direction.
            let there = |t| (b + self.turned((turns_b + 1) % 4, last, last - t)) as u32;
            for (t, corners) in own.as_chunks_mut().0.iter_mut().enumerate() {
                *corners = [here(t), there(t), there(t + 1), here(t + 1)];
            }
        }
        for &[first, _] in squares.iter().filter(|s| s[1] == 0) {
            let own;
            (own, out) = out.split_at_mut(self.inside.len());
            let first = first as u32;
            own.iter_mut().zip(&self.inside).for_each(|(slot, &p)| *slot = first + u32::from(p));
        }
        out
    }

    /// The place in a square of the point with such coordinates in one turned so many quarters.
    fn turned(&self, quarters: usize, a: usize, b: usize) -> usize {
        let last = self.side - 1;
        let [u, v] = match quarters {
            0 => [a, b],
            1 => [last - b, a],
            2 => [last - a, last - b],
            _ => [b, last - a],
        };
        v * self.side + u
    }
}

/// Whether the edge of a half-edge begins with it.
fn leads(base: &Topology, h: HalfedgeId) -> bool {
    base.twin(h).is_none_or(|t| t > h)
}

/// Whether the faces around its origin begin with a half-edge.
fn is_first(base: &Topology, h: HalfedgeId) -> bool {
    base.outgoing(base.origin(h)) == Some(h)
}

/// How many half-edges from its origin come before one.
fn place(base: &Topology, h: HalfedgeId) -> usize {
    base.fan(base.origin(h)).position(|other| other == h).unwrap_or(0)
}

/// The sizes of the faces around a vertex, from its first; a vertex on the boundary has two. Zeros for
/// faces that are too large.
fn key(topology: &Topology, v: VertexId) -> Key {
    let mut key = Key::default();
    for (slot, h) in key.iter_mut().zip(topology.fan(v)) {
        let size = topology.face_vertices(topology.face(h)).len();
        match u8::try_from(size) {
            Ok(size) => *slot = size,
            Err(_) => return Key::default(),
        }
    }
    key
}

/// A vertex, and those of the faces around it.
fn source_count(key: Key) -> usize {
    let sizes = key.iter().filter(|&&size| size > 0);
    let on_boundary = usize::from(key[3] == 0);
    1 + on_boundary + sizes.map(|&size| size as usize - 2).sum::<usize>()
}

/// A vertex and then those around it, face by face, without the last of each, with which the next one
/// begins.
fn around(topology: &Topology, v: VertexId, out: &mut [u32]) {
    let mut slots = out.iter_mut();
    let mut push = |v: VertexId| *slots.next().expect("as many as were counted") = v.0;
    push(v);
    let mut end = None;
    for h in topology.fan(v) {
        let last = topology.prev(h);
        let mut at = h;
        while topology.next(at) != last {
            push(topology.target(at));
            at = topology.next(at);
        }
        end = Some(topology.origin(last));
    }
    if let Some(end) = end.filter(|_| topology.is_boundary(v)) {
        push(end);
    }
}

/// The first vertex with such faces around, and the others as in [`around`].
fn disc(key: Key) -> (Faces, usize) {
    let count = source_count(key);
    let mut faces = Faces::new();
    let mut next = 1;
    for &size in key.iter().filter(|&&size| size > 0) {
        let mut corners = alloc::vec![0];
        corners.extend(
            (next..).take(size as usize - 1).map(|v: u32| if v as usize == count { 1 } else { v }),
        );
        next += u32::from(size) - 2;
        faces.push(&corners);
    }
    (faces, count)
}

/// The rows of a square: by the rules for any mesh.
fn form(key: Key, rules: &Rules, levels: u32, points: Points) -> Result<Form, Error> {
    let (faces, count) = disc(key);
    // The border of the disc is seen by nothing but what it has in common with the mesh.
    let rules = Rules { tension: None, border: Border::Bspline, ..rules.clone() };
    let steps = Steps::new(Topology::from_faces(count, &faces)?, rules, levels)?;
    let rows = point_rows(&steps, &square(&steps), count, points)?;
    Ok(Form::new(&rows.iter(), count))
}

/// The vertices at the finest level that the vertex becomes where the first half-edge begins.
fn square(steps: &Steps) -> Vec<u32> {
    let mut first = alloc::vec![HalfedgeId(0)];
    let mut side = 1;
    for levels in steps.levels.windows(2) {
        let (coarse, finer) = (&levels[0].0, &levels[1].0);
        let boundary = boundary_numbers(coarse).0;
        let mut next = alloc::vec![HalfedgeId(0); 4 * first.len()];
        for (i, &h) in first.iter().enumerate() {
            let [u, v] = [2 * (i % side), 2 * (i / side)];
            let places = [[1, 1], [0, 1], [0, 0], [1, 0]];
            for ([a, b], image) in places.into_iter().zip(images(coarse, finer, &boundary, h)) {
                next[(v + b) * 2 * side + u + a] = image;
            }
        }
        (first, side) = (next, 2 * side);
    }
    first.iter().map(|&h| steps.topology().origin(h).0).collect()
}

/// The first half-edges of the four images of the vertex whose first half-edge this is.
fn images(
    coarse: &Topology,
    finer: &Topology,
    boundary: &[u32],
    first: HalfedgeId,
) -> [HalfedgeId; 4] {
    let v = coarse.origin(first);
    let after = |h| coarse.twin(coarse.prev(h)).unwrap_or(h);
    let before = |h| finer.twin(h).map_or(h, |t| finer.next(t));
    // The images in faces keep their half-edges, which point towards the next image around.
    let second = after(first);
    if coarse.is_boundary(v) {
        let in_edge = |h: HalfedgeId, end: u32| {
            let number = coarse.halfedge_count() as u32 + 2 * boundary[h.index()] + end;
            finer.outgoing(VertexId(number)).unwrap_or(first)
        };
        let back = coarse.prev(second);
        return [first, before(second), in_edge(back, 1), in_edge(first, 0)];
    }
    let third = after(second);
    let fourth = after(third);
    [first, before(second), before(before(third)), before(before(before(fourth)))]
}
