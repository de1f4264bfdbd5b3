//! Many refinement steps at once: from a control mesh straight to the points of a fine mesh, or of
//! its limit surface with unit normals, and its faces.
//!
//! [`refine_mesh`](crate::refine::refine_mesh) makes one mesh after the other. Here the points inside
//! a face and on its sides are weighted sums of the vertices around the face, with weights that all
//! faces share whose surroundings look alike; the weights are found by refining one of them by the
//! rules for any mesh, so that boundaries, creases and shape parameters come out as there. Nothing
//! between the two meshes is stored, but for one mesh of a sixteenth of the size or less:
//! the first steps are made as ever, at least one and so many that [`MOST_AT_ONCE`] are left, or a
//! few more where even that mesh would be large, see [`Tessellation::with_base`]. Then
//! shape parameters have done their work, and a face has few extraordinary corners. Up to
//! [`MOST_AT_ONCE`] steps are made from the control mesh itself if it is large and its faces are of few kinds,
//! as those of most meshes that were refined or drawn by hand: see [`Tessellation::new`].
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
//! # Doo and Sabin's scheme
//!
//! It is dual: after the first step, every vertex of the base has four faces, or two on the boundary,
//! and becomes a square of $`N \times N`$ points, whatever the faces. Point $`(u, v)`$ of vertex $`i`$, with
//! $`u`$ in the direction of its first half-edge, [`Topology::outgoing`], and $`v`$ in that of the next one
//! around it, both from $`0`$ to $`N - 1`$ and from the far side, has the number $`i N^2 + v N + u`$. On the
//! boundary, $`v = 0`$ is the boundary of the fine mesh.
//!
//! The faces are, for each face of the base:
//!
//! - the one between the squares of its corners, with a corner of each, in the order of the face;
//! - for each of its half-edges that is the first of its edge, the $`N - 1`$ faces between the squares of
//!   its ends, from right to left;
//! - for each of its corners whose first half-edge is in this face, the $`(N-1)^2`$ faces inside that
//!   square, row by row.
//!
//! A mesh that has a vertex inside with two faces takes one step more, until all vertices are such. All
//! steps are made one by one with [`Border::Drop`](crate::Border::Drop) on open meshes, where a face of the
//! base has some ninety corners or more, and where next to no two vertices have faces alike.
//!
//! # The interpolating schemes
//!
//! All steps are made one by one, and the numbering is that of [`refine`](crate::refine::refine()).

#![expect(
    clippy::inline_always,
    reason = "what is compiled for the machine must be inlined into where that is chosen"
)]

use alloc::sync::Arc;
use alloc::vec::Vec;
use core::ops::Range;

use crate::error::Error;
use crate::ids::{EdgeId, FaceId, HalfedgeId, VertexId};
use crate::refine::{self, check_size, refine};
use crate::scheme::{Rules, Scheme};
use crate::{Faces, Topology, Vec3, limit, par};

mod adaptive;
mod blocks;
mod cells;
mod classes;
mod grid;
mod kernel;
mod point;
mod rest;
mod squares;
mod surface;

pub use adaptive::{Adaptive, Eye, Tolerance};
pub use blocks::{MOST_WITH_SMALL_BASE, base_level};
use cells::Cells;
use classes::{MOST_CLASSES, Task};
use grid::Grid;
pub use point::Point;
use rest::RestPoints;
use squares::Squares;
pub use surface::Surface;

/// Most steps that are made at once.
pub const MOST_AT_ONCE: u32 = 3;

/// As many faces as the base must have for each kind of them if it is the control mesh itself, not what
/// a step makes of that: rows for so many steps are worth that.
pub const FACES_PER_CLASS: usize = 512;

/// Faces of the base that are worked on together.
const BLOCK: usize = 512;

/// Some points that lie one behind the other, and are made together: a few ten thousand at most.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Part {
    /// Vertices of the base; with Doo and Sabin's scheme the squares that they become.
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
    /// How the points of the base's vertices are made, with Doo and Sabin's scheme.
    squares: Option<Squares>,
}

/// How much is made at once at most.
#[derive(Clone, Copy)]
struct Limits {
    /// Steps.
    at_once: u32,
    /// Kinds of faces.
    classes: usize,
    /// Faces that are refined step by step since they are of other kinds.
    left: usize,
}

#[derive(Clone, Debug)]
struct Plan {
    grid: Grid,
    cells: Cells,
}

impl Tessellation {
    /// Prepares so many steps. Time and memory are in proportion to the base, see the
    /// [module](self): with Loop's and Catmull and Clark's scheme and no more than [`MOST_AT_ONCE`] steps
    /// the control mesh, if there are [`FACES_PER_CLASS`] faces for each kind of surroundings.
    ///
    /// # Errors
    /// As [`check_size`]; for limit points as [`limit_points`](crate::limit::limit_points).
    pub fn new(
        topology: &Arc<Topology>,
        rules: &Rules,
        levels: u32,
        points: Points,
    ) -> Result<Self, Error> {
        let first = blocks::first_steps(levels, MOST_AT_ONCE);
        let is_direct = matches!(rules.scheme, Scheme::Loop | Scheme::CatmullClark);
        if is_direct && (1..=MOST_AT_ONCE).contains(&levels) && is_ready(topology, rules) {
            let classes = topology.face_count() / FACES_PER_CLASS;
            let limits = Limits { at_once: MOST_AT_ONCE, classes, left: 0 };
            let made = Self::with_limits(topology, rules, 0, levels, points, limits)?;
            if let Some(made) = made {
                return Ok(made);
            }
        }
        Self::from_level(topology, rules, first, levels, points)
    }

    /// Prepares so many steps, the `first` of which are made one by one: no more than are needed if
    /// the control mesh is itself the result of a step. More than [`MOST_AT_ONCE`] are not made
    /// at once, nor are any as long as there are shape parameters.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    #[expect(clippy::missing_panics_doc, reason = "only large grids leave too many faces")]
    pub fn from_level(
        topology: &Arc<Topology>,
        rules: &Rules,
        first: u32,
        levels: u32,
        points: Points,
    ) -> Result<Self, Error> {
        let limits = Limits { at_once: MOST_AT_ONCE, classes: MOST_CLASSES, left: usize::MAX };
        let made = Self::with_limits(topology, rules, first, levels, points, limits)?;
        Ok(made.expect("any number of faces may be refined step by step"))
    }

    /// [`from_level`](Self::from_level) within such limits. `None` if more faces than are allowed then would be
    /// refined step by step.
    fn with_limits(
        topology: &Arc<Topology>,
        rules: &Rules,
        first: u32,
        levels: u32,
        points: Points,
        limits: Limits,
    ) -> Result<Option<Self>, Error> {
        check_size(topology, rules, levels)?;
        let is_dual = rules.scheme == Scheme::DooSabin;
        let is_ready = is_ready(topology, rules);
        let needed = levels.saturating_sub(limits.at_once).max(u32::from(!is_ready));
        let mut at_once = levels.saturating_sub(first.max(needed));
        if rules.scheme.is_interpolating() {
            at_once = 0;
        }
        let mut steps = Steps::new(Arc::clone(topology), rules.clone(), levels - at_once)?;
        while is_dual && at_once > 0 && !squares::is_ready(steps.topology(), steps.rules()) {
            steps.push()?;
            at_once -= 1;
        }
        let (mut plan, mut squares) = (None, None);
        if is_dual && at_once > 0 && steps.topology().face_count() > 0 {
            squares = Squares::new(steps.topology(), steps.rules(), at_once, points)?;
            if squares.is_none() {
                (0..at_once).try_for_each(|_| steps.push())?;
            }
        }
        if points == Points::Limit {
            limit::check(steps.topology(), steps.rules())?;
        }
        if !is_dual && at_once > 0 && steps.topology().face_count() > 0 {
            let corners = if rules.scheme == Scheme::Loop { 3 } else { 4 };
            let grid = Grid::new(corners, at_once);
            let task = Task { grid: &grid, rules: steps.rules(), points, limits };
            let Some(cells) = Cells::new(steps.topology(), task)? else { return Ok(None) };
            plan = Some(Plan { grid, cells });
        }
        Ok(Some(Self { steps, points, plan, squares }))
    }

    /// The mesh whose faces are cut into grids, see the [module](self).
    #[must_use]
    pub fn base(&self) -> &Topology {
        self.steps.topology()
    }

    /// Number of kinds of faces, or with Doo and Sabin's scheme of vertices, each with weights
    /// of its own.
    #[must_use]
    pub fn class_count(&self) -> usize {
        if let Some(squares) = &self.squares {
            return squares.forms.len();
        }
        self.plan.as_ref().map_or(0, |plan| plan.cells.classes.list.len())
    }

    /// Number of points.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        let base = self.base();
        let (side, inner) = self.per_edge_and_face();
        base.vertex_count() * self.per_vertex()
            + base.edge_count() * side
            + base.face_count() * inner
    }

    /// Number of faces.
    #[must_use]
    pub fn face_count(&self) -> usize {
        if let Some(squares) = &self.squares {
            return squares.face_count(self.base());
        }
        self.base().face_count() * self.plan.as_ref().map_or(1, |plan| plan.grid.face_count())
    }

    fn per_vertex(&self) -> usize {
        self.squares.as_ref().map_or(1, Squares::point_count)
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
        if let Some(squares) = &self.squares {
            return squares.faces(self.base());
        }
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
        if let Some(squares) = &self.squares {
            return squares.fill_faces(base, base_faces, out);
        }
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

    /// Whether there are points on the sides of the faces of the base, or inside: not where all steps are made
    /// one by one, nor with Doo and Sabin's scheme, which has squares around vertices.
    #[must_use]
    pub fn has_grids(&self) -> bool {
        self.plan.is_some()
    }

    /// All points in order, part by part: for those who cannot, or need not, have all in memory.
    pub fn parts(&self) -> impl Iterator<Item = Part> + use<> {
        let blocks = |len: usize, block: usize| {
            (0..len).step_by(block).map(move |start| start..(start + block).min(len))
        };
        let face_count = if self.plan.is_some() { self.base().face_count() } else { 0 };
        let per_block = if self.squares.is_some() { BLOCK } else { par::BLOCK };
        blocks(self.base().vertex_count(), per_block)
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
        let first_of_edges = base.vertex_count() * self.per_vertex();
        let first_of_faces = first_of_edges + base.edge_count() * side;
        let range = |r: &Range<usize>, first: usize, each: usize, most: usize| {
            assert!(r.start <= r.end && r.end <= most, "{part:?} of {most}");
            first + r.start * each..first + r.end * each
        };
        match part {
            Part::Vertices(vertices) => range(vertices, 0, self.per_vertex(), base.vertex_count()),
            Part::Inside(faces) => range(faces, first_of_faces, inner, base.face_count()),
            Part::Sides(faces) => {
                assert!(faces.end <= base.face_count(), "{part:?} of {}", base.face_count());
                let edges = self.edges_before(faces.start)..self.edges_before(faces.end);
                range(&edges, first_of_edges, side, base.edge_count())
            }
        }
    }

    /// The numbers of the points of a face of the base, those on its outline too: its corners, the points
    /// on its sides in its own direction, and those inside. With Doo and Sabin's scheme those of the squares
    /// of its corners.
    ///
    /// # Panics
    /// If there is no such face.
    #[must_use]
    pub fn patch_numbers(&self, face: FaceId) -> Vec<u32> {
        if let Some(squares) = &self.squares {
            let count = squares.point_count() as u32;
            let square = |v: &VertexId| v.0 * count..(v.0 + 1) * count;
            return self.base().face_vertices(face).iter().flat_map(square).collect();
        }
        let Some(plan) = &self.plan else {
            return self.base().face_vertices(face).iter().map(|v| v.0).collect();
        };
        let mut numbers = alloc::vec![0; plan.grid.point_count()];
        self.numbers(&plan.grid, face.index(), &mut numbers);
        numbers
    }

    /// The faces that a face of the base is cut into, in the points of
    /// [`patch_numbers`](Self::patch_numbers).
    ///
    /// # Panics
    /// If there is no such face.
    #[must_use]
    pub fn patch_faces(&self, face: FaceId) -> Faces {
        if let Some(squares) = &self.squares {
            return squares.patch_faces(self.base(), face);
        }
        match &self.plan {
            Some(plan) => {
                let corners = plan.grid.faces.iter().map(|&point| u32::from(point)).collect();
                Faces::uniform(plan.grid.corners as u32, corners)
            }
            None => core::iter::once(self.patch_numbers(face))
                .map(|all| (0..all.len() as u32).collect::<Vec<_>>())
                .collect(),
        }
    }

    /// The surface of certain control points.
    ///
    /// # Errors
    /// As [`limit_normals`](crate::limit::limit_normals).
    ///
    /// # Panics
    /// If there is not one point per vertex of the control mesh.
    pub fn surface(&self, control: &[Vec3]) -> Result<Surface<'_>, Error> {
        self.surface_of(control, true)
    }

    /// [`surface`](Self::surface) for values of which no normals are wanted: colours, texture coordinates, or
    /// positions alone. Where points are made step by step that takes a fraction of the time.
    ///
    /// # Errors
    /// For limit points as [`limit_points`](crate::limit::limit_points).
    ///
    /// # Panics
    /// If there is not one value per vertex of the control mesh; later on, if normals are asked for.
    pub fn field(&self, values: &[Vec3]) -> Result<Surface<'_>, Error> {
        self.surface_of(values, false)
    }

    fn surface_of(&self, control: &[Vec3], with_normals: bool) -> Result<Surface<'_>, Error> {
        let points = self.steps.apply(control);
        let rest = match &self.plan {
            Some(plan) => {
                let rest = plan.cells.rest.as_ref();
                rest.map(|r| r.apply(&points, self.points, with_normals)).transpose()?
            }
            None if self.squares.is_some() => None,
            None => Some(RestPoints::new(&self.steps, points.clone(), self.points, with_normals)?),
        };
        Ok(Surface::new(self, points, rest, with_normals))
    }

    /// How many edges begin with faces before this one: edges are numbered by their first faces.
    fn edges_before(&self, face: usize) -> usize {
        let (base, corners) = (self.base(), self.plan.as_ref().map_or(0, |p| p.grid.corners));
        let first = corners * face;
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

/// Whether each face of a mesh can become a grid.
fn is_ready(topology: &Topology, rules: &Rules) -> bool {
    let has_shape = match rules.scheme {
        Scheme::Loop => true,
        Scheme::DooSabin => squares::is_ready(topology, rules),
        _ => topology.uniform_face_size() == Some(4),
    };
    has_shape && rules.tension.is_none() && topology.face_count() > 0
}

/// A topology and what some steps make of it.
#[derive(Clone, Debug)]
struct Steps {
    levels: Vec<(Arc<Topology>, Rules)>,
}

impl Steps {
    fn new(topology: impl Into<Arc<Topology>>, rules: Rules, count: u32) -> Result<Self, Error> {
        let mut steps = Self { levels: alloc::vec![(topology.into(), rules)] };
        (0..count).try_for_each(|_| steps.push())?;
        Ok(steps)
    }

    /// One step more.
    fn push(&mut self) -> Result<(), Error> {
        let (topology, rules) = self.last();
        let step = refine(topology, rules)?;
        let next = (Arc::new(step.topology), step.next);
        self.levels.push(next);
        Ok(())
    }

    /// Before the first step.
    fn first(&self) -> &Topology {
        &self.levels[0].0
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
