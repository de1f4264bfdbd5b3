//! Many refinement steps at once: from a control mesh straight to the points of a fine mesh, or of
//! its limit surface with unit normals, and its faces.
//!
//! [`refine_mesh`](crate::refine::refine_mesh) makes one mesh after the other. Here the points inside
//! a face and on its sides are weighted sums of the vertices around the face, with weights that all
//! faces share whose surroundings look alike; the weights are found by refining one of them by the
//! rules for any mesh, so that boundaries, creases and shape parameters come out as there. Nothing
//! between the two meshes is stored, but for one mesh of a sixteenth of the size or less:
//! the first steps are made as ever, at least one and so many that [`MOST_AT_ONCE`] are left. Then
//! shape parameters have done their work, and a face has few extraordinary corners.
//!
//! # Numbering
//!
//! Let the mesh after the first steps be the *base*, with $`V`$ vertices, $`E`$ edges and $`F`$ faces, and
//! let $`j`$ steps be left: each face becomes a grid of $`N = 2^j`$ segments along its sides. The points
//! are, in this order:
//!
//! - the $`V`$ vertices of the base, of which the first are those of the control mesh;
//! - for each edge of the base its $`N - 1`$ inner points, in the direction of its
//!   first half-edge: point $`t = 1, \dots, N - 1`$ of edge $`e`$ has the number $`V + e(N - 1) + t - 1`$;
//! - for each face of the base its inner points, row by row. In the coordinates $`u`$ from the first
//!   corner towards the second and $`v`$ towards the last, in segments, a row has one $`v`$. Triangles
//!   have $`(N-1)(N-2)/2`$ such points, quadrilaterals $`(N-1)^2`$.
//!
//! The faces are those of each face of the base, $`4^j`$, row by row: in a quadrilateral
//! $`(u,v), (u+1,v), (u+1,v+1), (u,v+1)`$; in a triangle $`(u,v), (u+1,v), (u,v+1)`$, followed by
//! $`(u+1,v), (u+1,v+1), (u,v+1)`$ if that is inside.
//!
//! With Doo and Sabin's scheme, which is dual, and the interpolating ones, all steps are made one by
//! one, and the numbering is that of [`refine`](crate::refine::refine()).

use alloc::sync::Arc;
use alloc::vec::Vec;
use core::ops::Range;

use crate::error::Error;
use crate::ids::{EdgeId, FaceId, HalfedgeId, NONE, VertexId};
use crate::refine::{self, check_size, refine};
use crate::scheme::{Rules, Scheme};
use crate::{Faces, Topology, Vec3, limit, par, wide};

mod cells;
mod classes;
mod grid;
mod kernel;
mod point;
mod rest;

use cells::{Cells, owned_sides};
use classes::Task;
use grid::Grid;
use kernel::Scratch;
pub use point::Point;
use rest::RestPoints;

/// Most steps that are made at once.
pub const MOST_AT_ONCE: u32 = 3;

/// Faces of the base that are worked on together.
const BLOCK: usize = 512;

/// Vertices that are worked on together.
const TOGETHER: usize = 32;

/// The sides of faces and what is inside.
const BOTH: [bool; 2] = [true; 2];

/// Some points that lie one behind the other, and are made together: a few ten thousand at most.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Part {
    /// Vertices of the base.
    Vertices(Range<usize>),
    /// The points on those edges whose first face is one of these faces of the base.
    Sides(Range<usize>),
    /// The points inside these faces of the base.
    Inside(Range<usize>),
}

/// Which points are wanted.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Points {
    /// The vertices of the refined control mesh.
    Control,
    /// Their limit points, which lie on the surface.
    #[default]
    Limit,
}

/// How the points of a fine mesh follow from the control points of a coarse one: for all meshes of one
/// connectivity, so that the frames of an animation, or colours, share it.
///
/// ```
/// use fairform::tessellate::{Points, Tessellation};
/// use fairform::{Rules, shapes};
///
/// let mesh = shapes::icosahedron();
/// let fine = Tessellation::new(mesh.topology(), &Rules::LOOP, 3, Points::Limit)?;
/// let (positions, normals) = fine.surface(mesh.positions())?.points_and_normals();
/// assert_eq!(positions.len(), 10 * 64 + 2);
/// assert!(normals[7].dot(positions[7].normalized()) > 0.99);
/// assert_eq!(fine.faces().len(), 20 * 64);
/// # Ok::<(), fairform::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Tessellation {
    /// From the control mesh to the base.
    steps: Steps,
    points: Points,
    /// How the points of the base's faces are made; `None` if there are no others than its vertices.
    plan: Option<Plan>,
}

#[derive(Clone, Debug)]
struct Plan {
    grid: Grid,
    cells: Cells,
}

impl Tessellation {
    /// Prepares so many steps. Time and memory are in proportion to the base, see the
    /// [module](self).
    ///
    /// # Errors
    /// As [`check_size`]; for limit points as [`limit_points`](crate::limit::limit_points).
    pub fn new(
        topology: &Arc<Topology>,
        rules: &Rules,
        levels: u32,
        points: Points,
    ) -> Result<Self, Error> {
        let first = levels.saturating_sub(MOST_AT_ONCE).max(levels.min(1));
        Self::from_level(topology, rules, first, levels, points)
    }

    /// Prepares so many steps, the `first` of which are made one by one: no more than are needed if
    /// the control mesh is itself the result of a step. More than [`MOST_AT_ONCE`] are not made
    /// at once, nor are any as long as there are shape parameters.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_level(
        topology: &Arc<Topology>,
        rules: &Rules,
        first: u32,
        levels: u32,
        points: Points,
    ) -> Result<Self, Error> {
        check_size(topology, rules, levels)?;
        let can_be_at_once = matches!(rules.scheme, Scheme::Loop | Scheme::CatmullClark);
        let all_quadrilaterals = topology.uniform_face_size() == Some(4);
        let is_ready = rules.tension.is_none()
            && (rules.scheme == Scheme::Loop || all_quadrilaterals)
            && topology.face_count() > 0;
        let needed = levels.saturating_sub(MOST_AT_ONCE).max(u32::from(!is_ready));
        let at_once = if can_be_at_once { levels.saturating_sub(first.max(needed)) } else { 0 };
        let steps = Steps::new(Arc::clone(topology), rules.clone(), levels - at_once)?;
        if points == Points::Limit {
            limit::check(steps.topology(), steps.rules())?;
        }
        let mut plan = None;
        if at_once > 0 && steps.topology().face_count() > 0 {
            let corners = if rules.scheme == Scheme::Loop { 3 } else { 4 };
            let grid = Grid::new(corners, at_once);
            let task = Task { grid: &grid, rules: steps.rules(), points };
            let cells = Cells::new(steps.topology(), task)?;
            plan = Some(Plan { grid, cells });
        }
        Ok(Self { steps, points, plan })
    }

    /// The mesh whose faces are cut into grids, see the [module](self).
    #[must_use]
    pub fn base(&self) -> &Topology {
        self.steps.topology()
    }

    /// Number of kinds of faces, each with weights of its own.
    #[must_use]
    pub fn class_count(&self) -> usize {
        self.plan.as_ref().map_or(0, |plan| plan.cells.classes.list.len())
    }

    /// Number of points.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        let base = self.base();
        let (side, inner) = self.per_edge_and_face();
        base.vertex_count() + base.edge_count() * side + base.face_count() * inner
    }

    /// Number of faces.
    #[must_use]
    pub fn face_count(&self) -> usize {
        self.base().face_count() * self.plan.as_ref().map_or(1, |plan| plan.grid.face_count())
    }

    fn per_edge_and_face(&self) -> (usize, usize) {
        self.plan.as_ref().map_or((0, 0), |plan| (plan.grid.side, plan.grid.inner))
    }

    /// The faces.
    ///
    /// # Panics
    /// If there are 2³² or more corners.
    #[must_use]
    pub fn faces(&self) -> Faces {
        let Some(plan) = &self.plan else { return self.base().to_faces() };
        let size = plan.grid.corners;
        let mut corners = alloc::vec![0; self.face_count() * size];
        self.fill_faces(0..self.base().face_count(), &mut corners);
        Faces::uniform(size as u32, corners)
    }

    /// Writes the corners of those faces that some faces of the base are cut into.
    ///
    /// # Panics
    /// If there is not room for just so many.
    pub fn fill_faces(&self, base_faces: Range<usize>, out: &mut [u32]) {
        let base = self.base();
        let Some(plan) = &self.plan else {
            let all = base_faces.flat_map(|f| base.face_vertices(FaceId(f as u32)));
            let mut out = out.iter_mut();
            all.for_each(|v| *out.next().expect("room for the corners") = v.0);
            assert!(out.next().is_none(), "room for the corners only");
            return;
        };
        let per_face = plan.grid.faces.len();
        assert_eq!(out.len(), base_faces.len() * per_face, "room for the corners");
        let mut parts = Vec::new();
        for (start, part) in base_faces.step_by(BLOCK).zip(out.chunks_mut(BLOCK * per_face)) {
            parts.push((start, part));
        }
        par::in_parts(parts, |(start, part)| {
            let mut numbers = alloc::vec![0; plan.grid.point_count()];
            for (i, out) in part.chunks_exact_mut(per_face).enumerate() {
                self.numbers(&plan.grid, start + i, &mut numbers);
                for (slot, &point) in out.iter_mut().zip(&plan.grid.faces) {
                    *slot = numbers[point as usize];
                }
            }
        });
    }

    /// The number of each point of the grid of a face.
    fn numbers(&self, grid: &Grid, face: usize, out: &mut [u32]) {
        let base = self.base();
        let (vertices, edges) = (base.vertex_count() as u32, base.edge_count() as u32);
        let side = grid.side as u32;
        let (corners, rest) = out.split_at_mut(grid.corners);
        let (sides, inner) = rest.split_at_mut(grid.corners * grid.side);
        for (i, slot) in corners.iter_mut().enumerate() {
            let h = HalfedgeId((face * grid.corners + i) as u32);
            *slot = base.origin(h).0;
            let e = base.edge(h);
            let first = vertices + e.0 * side;
            let points = sides[i * grid.side..(i + 1) * grid.side].iter_mut().zip(0..side);
            if base.edge_halfedge(e) == h {
                points.for_each(|(slot, t)| *slot = first + t);
            } else {
                points.for_each(|(slot, t)| *slot = first + side - 1 - t);
            }
        }
        let first = vertices + edges * side + (face * grid.inner) as u32;
        inner.iter_mut().zip(first..).for_each(|(slot, number)| *slot = number);
    }

    /// All points in order, part by part: for those who cannot, or need not, have all in memory.
    pub fn parts(&self) -> impl Iterator<Item = Part> + use<> {
        let blocks = |len: usize, block: usize| {
            (0..len).step_by(block).map(move |start| start..(start + block).min(len))
        };
        let face_count = if self.plan.is_some() { self.base().face_count() } else { 0 };
        blocks(self.base().vertex_count(), par::BLOCK)
            .map(Part::Vertices)
            .chain(blocks(face_count, BLOCK).map(Part::Sides))
            .chain(blocks(face_count, BLOCK).map(Part::Inside))
    }

    /// The numbers of the points of a part.
    ///
    /// # Panics
    /// If the base has no such vertices or faces.
    #[must_use]
    pub fn numbers_of(&self, part: &Part) -> Range<usize> {
        let (side, inner) = self.per_edge_and_face();
        let base = self.base();
        let first_of_edges = base.vertex_count();
        let first_of_faces = first_of_edges + base.edge_count() * side;
        let range = |r: &Range<usize>, first: usize, each: usize, most: usize| {
            assert!(r.start <= r.end && r.end <= most, "{part:?} of {most}");
            first + r.start * each..first + r.end * each
        };
        match part {
            Part::Vertices(vertices) => range(vertices, 0, 1, base.vertex_count()),
            Part::Inside(faces) => range(faces, first_of_faces, inner, base.face_count()),
            Part::Sides(faces) => {
                assert!(faces.end <= base.face_count(), "{part:?} of {}", base.face_count());
                let edges = self.edges_before(faces.start)..self.edges_before(faces.end);
                range(&edges, first_of_edges, side, base.edge_count())
            }
        }
    }

    /// The numbers of the points of a face of the base, those on its outline too: its corners, the points
    /// on its sides in its own direction, and those inside.
    ///
    /// # Panics
    /// If there is no such face.
    #[must_use]
    pub fn patch_numbers(&self, face: FaceId) -> Vec<u32> {
        let Some(plan) = &self.plan else {
            return self.base().face_vertices(face).iter().map(|v| v.0).collect();
        };
        let mut numbers = alloc::vec![0; plan.grid.point_count()];
        self.numbers(&plan.grid, face.index(), &mut numbers);
        numbers
    }

    /// The surface of certain control points.
    ///
    /// # Errors
    /// As [`limit_normals`](crate::limit::limit_normals).
    ///
    /// # Panics
    /// If there is not one point per vertex of the control mesh.
    pub fn surface(&self, control: &[Vec3]) -> Result<Surface<'_>, Error> {
        let points = self.steps.apply(control);
        let (base, rules) = (self.base(), self.steps.rules());
        let rest = match &self.plan {
            Some(plan) => {
                plan.cells.rest.as_ref().map(|r| r.apply(&points, self.points)).transpose()?
            }
            None => Some(RestPoints {
                normals: limit::limit_normals(base, &points, rules)?,
                positions: match self.points {
                    Points::Control => points.clone(),
                    Points::Limit => limit::limit_points(base, &points, rules)?,
                },
            }),
        };
        Ok(Surface { tessellation: self, points, rest })
    }

    /// The edges whose points are those of some faces of the base: edges are numbered by their first
    /// faces.
    fn edges_before(&self, face: usize) -> usize {
        let base = self.base();
        let first = base.face_halfedges(FaceId(0)).len() * face;
        let (mut low, mut high) = (0, base.edge_count());
        while low < high {
            let middle = usize::midpoint(low, high);
            if base.edge_halfedge(EdgeId(middle as u32)).index() < first {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        low
    }
}

/// The fine points of one control mesh.
#[derive(Clone, Debug)]
pub struct Surface<'t> {
    tessellation: &'t Tessellation,
    /// The vertices of the base.
    points: Vec<Vec3>,
    /// Points that were made step by step.
    rest: Option<RestPoints>,
}

/// Room for some points and, if they are wanted, normals.
struct Room<'o, P, N> {
    positions: &'o mut [P],
    normals: Option<&'o mut [N]>,
}

impl<'o, P: Point, N: Point> Room<'o, P, N> {
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

impl Surface<'_> {
    /// All points.
    #[must_use]
    pub fn points(&self) -> Vec<Vec3> {
        let mut positions = alloc::vec![Vec3::ZERO; self.tessellation.vertex_count()];
        self.fill(&mut positions, None::<&mut [Vec3]>);
        positions
    }

    /// All points and the unit normals of the limit surface there, as
    /// [`limit_normals`](crate::limit::limit_normals).
    #[must_use]
    pub fn points_and_normals(&self) -> (Vec<Vec3>, Vec<Vec3>) {
        let mut positions = alloc::vec![Vec3::ZERO; self.tessellation.vertex_count()];
        let mut normals = positions.clone();
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
        assert!(normals.as_ref().is_none_or(|n| n.len() == positions.len()), "as many normals");
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
        assert!(normals.as_ref().is_none_or(|n| n.len() == positions.len()), "as many normals");
        let room = Room { positions, normals };
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
        let all = self.tessellation;
        let count = all.patch_numbers(face).len();
        let (mut positions, mut normals) =
            (alloc::vec![Vec3::ZERO; count], alloc::vec![Vec3::ZERO; count]);
        let mut room = Room { positions: &mut positions[..], normals: Some(&mut normals[..]) };
        for v in all.base().face_vertices(face) {
            self.fill_vertex_block(v.index(), room.take(1));
        }
        if let Some(plan) = &all.plan {
            for h in all.base().face_halfedges(face) {
                self.fill_side(plan, h, room.take(plan.grid.side));
            }
            let (nothing, room) = room.split(0);
            self.fill_block(plan, [false, true], face.index()..face.index() + 1, nothing, room);
        }
        (positions, normals)
    }

    /// The points on the side of a half-edge, in its direction, as the first face of the edge has them.
    fn fill_side(&self, plan: &Plan, h: HalfedgeId, room: Room<'_, Vec3, Vec3>) {
        let base = self.tessellation.base();
        let (side, corners) = (plan.grid.side, plan.grid.corners);
        let first = base.edge_halfedge(base.edge(h));
        let face = first.index() / corners;
        let before = owned_sides(base, face, corners) & ((1 << (first.index() % corners)) - 1);
        let (skipped, mut all) = (before.count_ones() as usize * side, [Vec::new(), Vec::new()]);
        let count = owned_sides(base, face, corners).count_ones() as usize * side;
        all.iter_mut().for_each(|all| all.resize(count, Vec3::ZERO));
        let [positions, normals] = &mut all;
        let whole = Room { positions: &mut positions[..], normals: Some(&mut normals[..]) };
        let (nothing, whole) = whole.split(0);
        self.fill_block(plan, [true, false], face..face + 1, whole, nothing);
        let [positions, normals] = all.map(|mut all| {
            let own = &mut all[skipped..skipped + side];
            if first != h {
                own.reverse();
            }
            own.to_vec()
        });
        let mut room = room;
        room.write(positions.into_iter(), normals.into_iter());
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
            let form = if with_inner { &class.whole[sides] } else { &class.sides[sides] };
            sources.clear();
            kernel::gather(plan.cells.sources(face), &self.points, &mut sources);
            form.evaluate(&sources, &mut scratch, with_normals);
            let count = on_sides + inner;
            let (mut p, mut n) =
                (scratch.positions(count), scratch.normals(if with_normals { count } else { 0 }));
            on_edges.write(p.by_ref().take(on_sides), n.by_ref().take(on_sides));
            in_face.write(p, n);
        }
    }
}

/// A topology and what some steps make of it.
#[derive(Clone, Debug)]
struct Steps {
    levels: Vec<(Arc<Topology>, Rules)>,
}

impl Steps {
    fn new(topology: impl Into<Arc<Topology>>, rules: Rules, count: u32) -> Result<Self, Error> {
        let mut levels = alloc::vec![(topology.into(), rules)];
        for _ in 0..count {
            let (topology, rules) = &levels[levels.len() - 1];
            let step = refine(topology, rules)?;
            let next = (Arc::new(step.topology), step.next);
            levels.push(next);
        }
        Ok(Self { levels })
    }

    fn last(&self) -> &(Arc<Topology>, Rules) {
        self.levels.last().expect("the first is always there")
    }

    /// After the last step.
    fn topology(&self) -> &Topology {
        &self.last().0
    }

    /// For what follows the last step.
    fn rules(&self) -> &Rules {
        &self.last().1
    }

    fn apply(&self, values: &[Vec3]) -> Vec<Vec3> {
        assert_eq!(values.len(), self.levels[0].0.vertex_count(), "one point per vertex");
        let mut values = values.to_vec();
        for (topology, rules) in &self.levels[..self.levels.len() - 1] {
            values = refine::apply(topology, rules, &values);
        }
        values
    }
}
