//! [`Surface`]: the points of a tessellation, part by part.

use alloc::vec::Vec;
use core::ops::Range;

use super::cells::owned_sides;
use super::kernel::{self, Scratch};
use super::rest::RestPoints;
use super::squares::Squares;
use super::{BLOCK, Part, Plan, Point, Tessellation};
use crate::ids::{FaceId, HalfedgeId, NONE, VertexId};
use crate::{Vec3, par, wide};

/// The sides of faces and what is inside.
const BOTH: [bool; 2] = [true; 2];

/// Vertices that are worked on together.
const TOGETHER: usize = 32;

/// The fine points of one control mesh.
#[derive(Clone, Debug)]
pub struct Surface<'t> {
    tessellation: &'t Tessellation,
    /// The vertices of the base.
    points: Vec<Vec3>,
    /// Points that were made step by step.
    rest: Option<RestPoints>,
    /// Whether normals may be asked for.
    has_normals: bool,
}

/// Room for some points and, if they are wanted, normals.
struct Room<'o, P, N> {
    positions: &'o mut [P],
    normals: Option<&'o mut [N]>,
}

impl<P: Point, N: Point> Room<'_, P, N> {
    fn split(self, at: usize) -> (Self, Self) {
        let (left, right) = self.positions.split_at_mut(at);
        let (a, b) = self.normals.map(|n| n.split_at_mut(at)).unzip();
        (Self { positions: left, normals: a }, Self { positions: right, normals: b })
    }

    /// Cuts off the first.
    fn take(&mut self, count: usize) -> Self {
        let empty = Room { positions: &mut [], normals: None };
        let (first, rest) = core::mem::replace(self, empty).split(count);
        *self = rest;
        first
    }

    #[inline(always)]
    fn write(
        &mut self,
        positions: impl Iterator<Item = Vec3>,
        normals: impl Iterator<Item = Vec3>,
    ) {
        self.positions.iter_mut().zip(positions).for_each(|(slot, p)| *slot = P::from(p));
        if let Some(slots) = &mut self.normals {
            slots.iter_mut().zip(normals).for_each(|(slot, n)| *slot = N::from(n));
        }
    }
}

impl<'t> Surface<'t> {
    pub(super) fn new(
        tessellation: &'t Tessellation,
        points: Vec<Vec3>,
        rest: Option<RestPoints>,
        has_normals: bool,
    ) -> Self {
        Self { tessellation, points, rest, has_normals }
    }

    /// What it is a surface of.
    #[must_use]
    pub fn tessellation(&self) -> &'t Tessellation {
        self.tessellation
    }

    fn check_normals(&self, points: usize, normals: Option<usize>) {
        assert!(normals.is_none_or(|count| count == points), "as many normals");
        assert!(self.has_normals || normals.is_none(), "a field has no normals");
    }

    /// All points.
    #[must_use]
    pub fn points(&self) -> Vec<Vec3> {
        let mut positions = bytemuck::zeroed_vec(self.tessellation.vertex_count());
        self.fill(&mut positions, None::<&mut [Vec3]>);
        positions
    }

    /// All points and the unit normals of the limit surface there, as
    /// [`limit_normals`](crate::limit::limit_normals).
    #[must_use]
    pub fn points_and_normals(&self) -> (Vec<Vec3>, Vec<Vec3>) {
        // Zeros straight from the system, so that the threads touch the memory first, each its own.
        let new = || bytemuck::zeroed_vec(self.tessellation.vertex_count());
        let (mut positions, mut normals) = (new(), new());
        self.fill(&mut positions, Some(&mut normals));
        (positions, normals)
    }

    /// Writes all points and, if there is room for them, normals: into memory that was used before
    /// much faster than into new memory.
    ///
    /// # Panics
    /// If there is not room for just so many.
    pub fn fill<P: Point, N: Point>(&self, positions: &mut [P], normals: Option<&mut [N]>) {
        let all = self.tessellation;
        let base = all.base();
        assert_eq!(positions.len(), all.vertex_count(), "room for the points");
        self.check_normals(positions.len(), normals.as_ref().map(|n| n.len()));
        if let Some(squares) = &all.squares {
            return self.fill_all_squares(squares, Room { positions, normals });
        }
        let (vertices, rest) = Room { positions, normals }.split(base.vertex_count());
        self.fill_vertices(vertices);
        let Some(plan) = &all.plan else { return };
        let (mut on_edges, mut in_faces) = rest.split(base.edge_count() * plan.grid.side);
        let mut parts = Vec::new();
        let mut edges = 0;
        for start in (0..base.face_count()).step_by(BLOCK) {
            let faces = start..(start + BLOCK).min(base.face_count());
            let end = all.edges_before(faces.end);
            let room = on_edges.take((end - edges) * plan.grid.side);
            edges = end;
            parts.push((room, in_faces.take(faces.len() * plan.grid.inner), faces));
        }
        par::in_parts(parts, |(on_edges, in_faces, faces)| {
            self.fill_block(plan, BOTH, faces, on_edges, in_faces);
        });
    }

    /// Writes the points and normals of a part, the same bits as [`fill`](Self::fill) writes there.
    ///
    /// # Panics
    /// If there is not room for just so many, or the base has no such vertices or faces.
    pub fn fill_part<P: Point, N: Point>(
        &self,
        part: &Part,
        positions: &mut [P],
        normals: Option<&mut [N]>,
    ) {
        assert_eq!(
            positions.len(),
            self.tessellation.numbers_of(part).len(),
            "room for the points"
        );
        self.check_normals(positions.len(), normals.as_ref().map(|n| n.len()));
        let room = Room { positions, normals };
        if let (Part::Vertices(vertices), Some(squares)) = (part, &self.tessellation.squares) {
            return self.fill_squares(squares, vertices.clone(), room);
        }
        match (part, &self.tessellation.plan) {
            (Part::Vertices(vertices), _) => self.fill_vertex_block(vertices.start, room),
            (Part::Sides(faces), Some(plan)) => {
                let (nothing, room) = room.split(0);
                self.fill_block(plan, [true, false], faces.clone(), room, nothing);
            }
            (Part::Inside(faces), Some(plan)) => {
                let (nothing, room) = room.split(0);
                self.fill_block(plan, [false, true], faces.clone(), nothing, room);
            }
            (_, None) => {}
        }
    }

    /// The points of a face of the base and their normals, those on its outline too, in the order of
    /// [`patch_numbers`](Tessellation::patch_numbers); the same bits as [`fill`](Self::fill) writes, so
    /// that neighbouring patches fit without a gap.
    ///
    /// # Panics
    /// If there is no such face.
    #[must_use]
    pub fn patch(&self, face: FaceId) -> (Vec<Vec3>, Vec<Vec3>) {
        let count = self.tessellation.patch_numbers(face).len();
        let (mut positions, mut normals) =
            (alloc::vec![Vec3::ZERO; count], alloc::vec![Vec3::ZERO; count]);
        self.fill_patch(face, &mut positions, Some(&mut normals));
        (positions, normals)
    }

    /// As [`patch`](Self::patch), into given memory.
    ///
    /// # Panics
    /// If there is no such face, or not room for just so many points.
    pub fn fill_patch<P: Point, N: Point>(
        &self,
        face: FaceId,
        positions: &mut [P],
        normals: Option<&mut [N]>,
    ) {
        let all = self.tessellation;
        self.check_normals(positions.len(), normals.as_ref().map(|n| n.len()));
        let mut room = Room { positions, normals };
        for v in all.base().face_vertices(face).iter().map(|v| v.index()) {
            match &all.squares {
                Some(squares) => {
                    self.fill_squares(squares, v..v + 1, room.take(squares.point_count()));
                }
                None => self.fill_vertex_block(v, room.take(1)),
            }
        }
        if let Some(plan) = &all.plan {
            for h in all.base().face_halfedges(face) {
                self.fill_side(plan, h, room.take(plan.grid.side));
            }
            let inner = room.take(plan.grid.inner);
            let (nothing, inner) = inner.split(0);
            self.fill_block(plan, [false, true], face.index()..face.index() + 1, nothing, inner);
        }
        assert!(room.positions.is_empty(), "room for the points only");
    }

    /// The points on the side of a half-edge, in its direction, as the first face of the edge has them.
    fn fill_side<P: Point, N: Point>(&self, plan: &Plan, h: HalfedgeId, room: Room<'_, P, N>) {
        let base = self.tessellation.base();
        let (side, corners) = (plan.grid.side, plan.grid.corners);
        let first = base.edge_halfedge(base.edge(h));
        let face = first.index() / corners;
        let owned = owned_sides(base, face, corners);
        let before = owned & ((1 << (first.index() % corners)) - 1);
        let (skipped, count) =
            (before.count_ones() as usize * side, owned.count_ones() as usize * side);
        let mut positions = alloc::vec![P::from(Vec3::ZERO); count];
        let mut normals = room.normals.as_ref().map(|_| alloc::vec![N::from(Vec3::ZERO); count]);
        let whole = Room { positions: &mut positions[..], normals: normals.as_deref_mut() };
        let (nothing, whole) = whole.split(0);
        self.fill_block(plan, [true, false], face..face + 1, whole, nothing);
        let own = skipped..skipped + side;
        room.positions.copy_from_slice(&positions[own.clone()]);
        if first != h {
            room.positions.reverse();
        }
        if let (Some(slots), Some(normals)) = (room.normals, normals) {
            slots.copy_from_slice(&normals[own]);
            if first != h {
                slots.reverse();
            }
        }
    }

    fn fill_all_squares<P: Point, N: Point>(&self, squares: &Squares, mut room: Room<'_, P, N>) {
        let mut parts = Vec::new();
        let count = squares.class.len();
        for start in (0..count).step_by(BLOCK) {
            let vertices = start..(start + BLOCK).min(count);
            parts.push((room.take(vertices.len() * squares.point_count()), vertices));
        }
        par::in_parts(parts, |(room, vertices)| self.fill_squares(squares, vertices, room));
    }

    fn fill_squares<P: Point, N: Point>(
        &self,
        squares: &Squares,
        vertices: Range<usize>,
        room: Room<'_, P, N>,
    ) {
        wide::run(
            #[inline(always)]
            || self.fill_squares_wide(squares, vertices, room),
        );
    }

    #[inline(always)]
    fn fill_squares_wide<P: Point, N: Point>(
        &self,
        squares: &Squares,
        vertices: Range<usize>,
        mut room: Room<'_, P, N>,
    ) {
        let count = squares.point_count();
        let with_normals = room.normals.is_some();
        let (mut scratch, mut sources) = (Scratch::default(), Vec::new());
        for v in vertices {
            sources.clear();
            kernel::gather(squares.sources(v), &self.points, &mut sources);
            let form = &squares.forms[squares.class[v] as usize];
            form.evaluate(&sources, &mut scratch, with_normals);
            let normals = scratch.normals(if with_normals { count } else { 0 });
            room.take(count).write(scratch.positions(count), normals);
        }
    }

    fn fill_vertices<P: Point, N: Point>(&self, mut room: Room<'_, P, N>) {
        let mut parts = Vec::new();
        let count = room.positions.len();
        for start in (0..count).step_by(par::BLOCK) {
            parts.push((start, room.take(par::BLOCK.min(count - start))));
        }
        par::in_parts(parts, |(start, room)| self.fill_vertex_block(start, room));
    }

    fn fill_vertex_block<P: Point, N: Point>(&self, start: usize, room: Room<'_, P, N>) {
        wide::run(
            #[inline(always)]
            || self.fill_vertex_block_wide(start, room),
        );
    }

    #[inline(always)]
    fn fill_vertex_block_wide<P: Point, N: Point>(&self, start: usize, mut room: Room<'_, P, N>) {
        let vertices = start..start + room.positions.len();
        let Some(plan) = &self.tessellation.plan else {
            if let Some(done) = &self.rest {
                let (positions, normals) =
                    (&done.positions[vertices.clone()], &done.normals[vertices]);
                room.write(positions.iter().copied(), normals.iter().copied());
            }
            return;
        };
        let mut scratch = Scratch::default();
        let (mut owners, mut sources) = (Vec::new(), Vec::new());
        for first in vertices.clone().step_by(TOGETHER) {
            let some = first..(first + TOGETHER).min(vertices.end);
            self.fill_some_vertices(plan, some, &mut room, &mut owners, &mut sources, &mut scratch);
        }
    }

    /// A few vertices of the base, each by the rows of its first face. What the next step needs to know
    /// is asked for of all of them at once, so that they wait for memory together.
    #[inline(always)]
    fn fill_some_vertices<P: Point, N: Point>(
        &self,
        plan: &Plan,
        vertices: Range<usize>,
        room: &mut Room<'_, P, N>,
        owners: &mut Vec<(usize, u32)>,
        sources: &mut Vec<[f64; 3]>,
        scratch: &mut Scratch,
    ) {
        let base = self.tessellation.base();
        owners.clear();
        sources.clear();
        owners.extend(vertices.clone().map(|v| match base.outgoing(VertexId(v as u32)) {
            Some(h) => (h.index(), plan.cells.class[h.index() / plan.grid.corners]),
            None => (usize::MAX, NONE),
        }));
        for &(h, _) in owners.iter().filter(|o| o.1 != NONE) {
            kernel::gather(plan.cells.sources(h / plan.grid.corners), &self.points, sources);
        }
        let with_normals = room.normals.is_some();
        let mut rest = sources.as_slice();
        for (v, &(h, class)) in vertices.zip(owners.iter()) {
            let mut one = room.take(1);
            let (face, corner) = (h / plan.grid.corners, h % plan.grid.corners);
            if let Some(class) = plan.cells.classes.list.get(class as usize) {
                let own;
                (own, rest) = rest.split_at(class.source_count);
                class.corners[corner].evaluate(own, scratch, with_normals);
                one.write(scratch.positions(1), scratch.normals(usize::from(with_normals)));
            } else if h == usize::MAX {
                one.write([self.points[v]].into_iter(), [Vec3::ZERO].into_iter());
            } else {
                self.write_rest(plan, face, corner..corner + 1, &mut one);
            }
        }
    }

    /// Writes some points of the grid of a face that was refined step by step.
    fn write_rest<P: Point, N: Point>(
        &self,
        plan: &Plan,
        face: usize,
        points: Range<usize>,
        room: &mut Room<'_, P, N>,
    ) {
        if let (Some(rest), Some(done)) = (&plan.cells.rest, &self.rest) {
            let numbers = &rest.grid(face, &plan.grid)[points];
            let of = |all: &[Vec3]| numbers.iter().map(|&i| all[i as usize]).collect::<Vec<_>>();
            room.write(of(&done.positions).into_iter(), of(&done.normals).into_iter());
        }
    }

    /// The points of some faces of the base: of their own edges, and inside.
    fn fill_block<P: Point, N: Point>(
        &self,
        plan: &Plan,
        what: [bool; 2],
        faces: Range<usize>,
        on_edges: Room<'_, P, N>,
        in_faces: Room<'_, P, N>,
    ) {
        wide::run(
            #[inline(always)]
            || self.fill_block_wide(plan, what, faces, on_edges, in_faces),
        );
    }

    #[inline(always)]
    fn fill_block_wide<P: Point, N: Point>(
        &self,
        plan: &Plan,
        [with_sides, with_inner]: [bool; 2],
        faces: Range<usize>,
        mut on_edges: Room<'_, P, N>,
        mut in_faces: Room<'_, P, N>,
    ) {
        let base = self.tessellation.base();
        let (side, corners) = (plan.grid.side, plan.grid.corners);
        let inner = if with_inner { plan.grid.inner } else { 0 };
        let with_normals = in_faces.normals.is_some();
        let (mut scratch, mut sources) = (Scratch::default(), Vec::new());
        let apart = with_sides && with_inner && plan.grid.is_large();
        for face in faces {
            let sides = if with_sides { owned_sides(base, face, corners) } else { 0 };
            let on_sides = sides.count_ones() as usize * side;
            let (mut on_edges, mut in_face) = (on_edges.take(on_sides), in_faces.take(inner));
            let class = plan.cells.class[face];
            if class == NONE {
                for i in (0..corners).filter(|i| sides >> i & 1 > 0) {
                    let first = plan.grid.first_of_side(i);
                    self.write_rest(plan, face, first..first + side, &mut on_edges.take(side));
                }
                let first = plan.grid.first_inner();
                self.write_rest(plan, face, first..first + inner, &mut in_face);
                continue;
            }
            let class = &plan.cells.classes.list[class as usize];
            sources.clear();
            kernel::gather(plan.cells.sources(face), &self.points, &mut sources);
            let (mut on_sides, mut sides) = (on_sides, sides);
            if apart {
                class.sides[sides].evaluate(&sources, &mut scratch, with_normals);
                let normals = if with_normals { on_sides } else { 0 };
                on_edges.write(scratch.positions(on_sides), scratch.normals(normals));
                (on_sides, sides) = (0, 0);
            }
            let form = if with_inner { &class.whole[sides] } else { &class.sides[sides] };
            form.evaluate(&sources, &mut scratch, with_normals);
            let count = on_sides + inner;
            let (mut p, mut n) =
                (scratch.positions(count), scratch.normals(if with_normals { count } else { 0 }));
            on_edges.write(p.by_ref().take(on_sides), n.by_ref().take(on_sides));
            in_face.write(p, n);
        }
    }
}
