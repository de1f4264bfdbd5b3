//! Tessellation as fine as it must be: for each face of the base a grid of its own, between grids of
//! different fineness strips that fit both.
//!
//! How fine a side is cut depends on the points of that side alone, so that the two faces at it agree and
//! no crack can open: of $`1, 2, 4, \dots, N`$ segments the fewest that are near enough to all its points.
//! A face begins with a grid that fits its finest side, and takes a finer one until it is near enough to all
//! points of the finest.

use alloc::vec::Vec;
use core::ops::Range;

use super::grid::Grid;
use super::{Surface, Tessellation};
use crate::error::Error;
use crate::fairness::{square_to_segment, square_to_triangle};
use crate::ids::FaceId;
use crate::topology::MAX_HALFEDGES;
use crate::{Faces, Scheme, Vec3, par};

mod weave;

use weave::{Cut, weave};

/// How far a mesh may be from the surface.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Tolerance {
    /// Distance, in the units of the coordinates, that is always allowed.
    pub chord: f64,
    /// What may be allowed more, farther from where one looks.
    pub eye: Option<Eye>,
}

/// Where one looks from.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Eye {
    /// The eye.
    pub position: Vec3,
    /// Distance that is allowed at a distance of 1 from the eye; at another it is so many times that. For
    /// `p` pixels on a screen `h` pixels high, seen with a vertical angle of view `a`:
    /// $`2 p \tan(a/2) / h`$.
    pub per_distance: f64,
}

impl Tolerance {
    fn check(&self) -> Result<(), Error> {
        let is_sound = |x: f64| x >= 0.0 && x.is_finite();
        let expected = "a finite number, not negative";
        if !is_sound(self.chord) {
            return Err(Error::BadOption { what: "the chord error", expected, value: self.chord });
        }
        match self.eye {
            Some(Eye { per_distance: value, .. }) if !is_sound(value) => {
                Err(Error::BadOption { what: "the error per distance", expected, value })
            }
            Some(Eye { position, .. }) if !position.is_finite() => {
                let (what, value) = ("the eye", position.x + position.y + position.z);
                Err(Error::BadOption { what, expected: "a finite position", value })
            }
            _ => Ok(()),
        }
    }

    /// Whether a point may be so far off, squared.
    fn allows(&self, p: Vec3, square: f64) -> bool {
        let far = self.eye.map_or(0.0, |eye| eye.per_distance * (p - eye.position).length());
        let allowed = self.chord.max(far);
        square <= allowed * allowed
    }
}

/// A mesh that is fine where the surface is curved.
#[derive(Clone, PartialEq, Debug)]
pub struct Adaptive {
    /// The vertices of the base, of which the first are those of the control mesh; then those on its edges,
    /// edge by edge; then those inside its faces, face by face.
    pub positions: Vec<Vec3>,
    /// Unit normals of the limit surface there.
    pub normals: Vec<Vec3>,
    /// Triangles, and quadrilaterals inside quadrilaterals.
    pub faces: Faces,
    /// The face of the base that each face is a part of.
    pub origin: Vec<u32>,
    /// Number of faces of the base that are cut as finely as the tessellation allows: there the surface may
    /// be farther from the mesh than the tolerance.
    pub at_limit: usize,
}

impl Surface<'_> {
    /// A mesh with few faces from which no point of the whole tessellation is farther than a tolerance. The
    /// coarsest is the base, the finest the whole tessellation.
    ///
    /// # Errors
    /// [`Error::BadOption`] for a tolerance that is negative or not finite; [`Error::NotForScheme`] but for
    /// Loop and Catmull–Clark; [`Error::TooLarge`].
    pub fn adaptive(&self, tolerance: &Tolerance) -> Result<Adaptive, Error> {
        tolerance.check()?;
        let all = self.tessellation();
        let base = all.base();
        let scheme = all.steps.rules().scheme;
        if !matches!(scheme, Scheme::Loop | Scheme::CatmullClark) {
            return Err(Error::NotForScheme {
                what: "adaptive tessellation",
                scheme: scheme.name(),
            });
        }
        let Some(plan) = &all.plan else {
            let (positions, normals) = self.points_and_normals();
            let origin = (0..base.face_count() as u32).collect();
            let faces = base.to_faces();
            return Ok(Adaptive { positions, normals, faces, origin, at_limit: 0 });
        };
        let grid = &plan.grid;
        let of_edge = self.side_levels(grid, tolerance);
        let cut = self.cuts(grid, &of_edge, tolerance);
        let layout = Layout::new(all, grid, of_edge, cut)?;
        Ok(self.assemble(grid, &layout))
    }

    /// Runs `f` with the points and normals of the grid of each of some faces.
    fn for_patches(&self, faces: Range<usize>, mut f: impl FnMut(usize, &[Vec3], &[Vec3])) {
        for face in faces {
            let (points, normals) = self.patch(FaceId(face as u32));
            f(face, &points, &normals);
        }
    }

    /// The level of each edge, found at its first face.
    fn side_levels(&self, grid: &Grid, tolerance: &Tolerance) -> Vec<u32> {
        let base = self.tessellation().base();
        let blocks = par::blocks(base.face_count(), |faces| {
            let mut levels = Vec::new();
            self.for_patches(faces, |face, points, _| {
                for (i, h) in base.face_halfedges(FaceId(face as u32)).enumerate() {
                    if base.edge_halfedge(base.edge(h)) == h {
                        levels.push(side_level(grid, i, points, tolerance));
                    }
                }
            });
            levels
        });
        blocks.concat()
    }

    /// How each face is cut.
    fn cuts(&self, grid: &Grid, of_edge: &[u32], tolerance: &Tolerance) -> Vec<Cut> {
        let blocks = par::blocks(self.tessellation().base().face_count(), |faces| {
            let mut cuts = Vec::with_capacity(faces.len());
            self.for_patches(faces, |face, points, _| {
                let sides = self.sides(face, of_edge);
                let is_fine = |cut: &Cut| is_near(grid, *cut, &sides, points, tolerance);
                let all = Cut::all(grid, &sides);
                let last = all[all.len() - 1];
                cuts.push(all.into_iter().find(is_fine).unwrap_or(last));
            });
            cuts
        });
        blocks.concat()
    }

    /// The levels of the sides of a face.
    fn sides(&self, face: usize, of_edge: &[u32]) -> Vec<u32> {
        let base = self.tessellation().base();
        base.face_halfedges(FaceId(face as u32)).map(|h| of_edge[base.edge(h).index()]).collect()
    }

    fn assemble(&self, grid: &Grid, layout: &Layout) -> Adaptive {
        let base = self.tessellation().base();
        let blocks = par::blocks(base.face_count(), |faces| {
            let mut block = Block::default();
            self.for_patches(faces, |face, points, normals| {
                let id = FaceId(face as u32);
                let put = |to: &mut [Vec<Vec3>; 2], i: usize| {
                    to[0].push(points[i]);
                    to[1].push(normals[i]);
                };
                for (i, h) in base.face_halfedges(id).enumerate() {
                    let e = base.edge(h);
                    if base.edge_halfedge(e) == h {
                        let step = grid.segments() >> layout.level[e.index()];
                        let on_side = grid.first_of_side(i) - 1;
                        (step..grid.segments())
                            .step_by(step)
                            .for_each(|t| put(&mut block.on_edges, on_side + t));
                    }
                }
                let cut = layout.cut[face];
                let step = grid.segments() >> cut.level;
                cut.inner(grid.corners)
                    .for_each(|[u, v]| put(&mut block.inside, grid.number(u * step, v * step)));
                let before = block.sizes.len();
                let numbers = layout.numbers(self.tessellation(), grid, face);
                weave(grid, cut, &self.sides(face, &layout.level), &mut |polygon| {
                    block.sizes.push(polygon.len() as u32);
                    let number = |&[u, v]: &[usize; 2]| numbers[grid.number(u, v)];
                    block.corners.extend(polygon.iter().map(number));
                });
                block.origin.extend((before..block.sizes.len()).map(|_| face as u32));
            });
            block
        });
        let at_limit = layout.cut.iter().filter(|cut| cut.level == grid.levels).count();
        self.gather(layout, blocks, at_limit)
    }

    /// The blocks one behind the other.
    fn gather(&self, layout: &Layout, blocks: Vec<Block>, at_limit: usize) -> Adaptive {
        let vertex_count = self.tessellation().base().vertex_count();
        let mut all =
            [alloc::vec![Vec3::ZERO; vertex_count], alloc::vec![Vec3::ZERO; vertex_count]];
        let [positions, normals] = &mut all;
        self.fill_part(
            &super::Part::Vertices(0..vertex_count),
            positions,
            Some(normals.as_mut_slice()),
        );
        for (i, all) in all.iter_mut().enumerate() {
            all.reserve_exact(layout.vertex_count - vertex_count);
            blocks.iter().for_each(|block| all.extend_from_slice(&block.on_edges[i]));
            blocks.iter().for_each(|block| all.extend_from_slice(&block.inside[i]));
        }
        let [positions, normals] = all;
        let count = blocks.iter().map(|block| block.sizes.len()).sum();
        let mut start = Vec::with_capacity(count + 1);
        let mut end = 0;
        start.push(end);
        let (mut corners, mut origin) = (Vec::new(), Vec::with_capacity(count));
        for block in blocks {
            start.extend(block.sizes.iter().map(|size| {
                end += size;
                end
            }));
            corners.extend(block.corners);
            origin.extend(block.origin);
        }
        Adaptive { positions, normals, faces: Faces::from_starts(start, corners), origin, at_limit }
    }
}

/// What some faces add.
#[derive(Default)]
struct Block {
    on_edges: [Vec<Vec3>; 2],
    inside: [Vec<Vec3>; 2],
    sizes: Vec<u32>,
    corners: Vec<u32>,
    origin: Vec<u32>,
}

/// The fewest segments of a side, as a level, whose distance from its points is allowed.
fn side_level(grid: &Grid, i: usize, points: &[Vec3], tolerance: &Tolerance) -> u32 {
    let (n, first) = (grid.segments(), grid.first_of_side(i));
    let point = |t: usize| match t {
        0 => points[i],
        t if t == n => points[(i + 1) % grid.corners],
        t => points[first + t - 1],
    };
    let is_near = |level: &u32| {
        let step = n >> level;
        (1..n).filter(|t| t % step > 0).all(|t| {
            let p = point(t);
            let to = |start: usize| square_to_segment(p, point(start), point(start + step));
            // Points may slide along the side.
            tolerance.allows(p, to(t / step * step))
                || (0..n).step_by(step).any(|start| tolerance.allows(p, to(start)))
        })
    };
    (0..grid.levels).find(is_near).unwrap_or(grid.levels)
}

/// Whether all points of the grid of a face are near a cut.
fn is_near(grid: &Grid, cut: Cut, sides: &[u32], points: &[Vec3], tolerance: &Tolerance) -> bool {
    let point = |[u, v]: [usize; 2]| points[grid.number(u, v)];
    let mut polygons: Vec<Vec<[usize; 2]>> = Vec::new();
    weave(grid, cut, sides, &mut |polygon| polygons.push(polygon.to_vec()));
    let is_near_one = |p: Vec3, polygon: &[[usize; 2]]| {
        let of = |i: usize, j: usize, k: usize| [polygon[i], polygon[j], polygon[k]].map(point);
        let square = match polygon.len() {
            3 => square_to_triangle(p, &of(0, 1, 2)),
            // However it is cut in two.
            _ => [[of(0, 1, 2), of(0, 2, 3)], [of(0, 1, 3), of(1, 2, 3)]]
                .map(|[a, b]| square_to_triangle(p, &a).min(square_to_triangle(p, &b)))
                .into_iter()
                .fold(0.0, f64::max),
        };
        tolerance.allows(p, square)
    };
    polygons.iter().all(|polygon| {
        let range = |k: usize| {
            let of = polygon.iter().map(|at| at[k]);
            of.clone().min().unwrap_or(0)..=of.max().unwrap_or(0)
        };
        range(1).all(|v| {
            let mut within = range(0).filter(|&u| is_inside(polygon, [u, v]));
            within.all(|u| {
                let p = point([u, v]);
                // Points may slide within the face.
                polygon.contains(&[u, v])
                    || is_near_one(p, polygon)
                    || polygons.iter().any(|other| is_near_one(p, other))
            })
        })
    })
}

/// Whether a point of the grid lies in a polygon, its outline included.
fn is_inside(polygon: &[[usize; 2]], at: [usize; 2]) -> bool {
    let [x, y] = at.map(|c| c as f64);
    (0..polygon.len()).all(|i| {
        let [ax, ay] = polygon[i].map(|c| c as f64);
        let [bx, by] = polygon[(i + 1) % polygon.len()].map(|c| c as f64);
        (bx - ax) * (y - ay) - (by - ay) * (x - ax) >= 0.0
    })
}

/// How everything is cut, and where its points begin.
struct Layout {
    /// Of each edge.
    level: Vec<u32>,
    /// Of each face.
    cut: Vec<Cut>,
    /// The first point of each edge.
    of_edge: Vec<u32>,
    /// The first inner point of each face.
    of_face: Vec<u32>,
    vertex_count: usize,
}

impl Layout {
    fn new(all: &Tessellation, grid: &Grid, level: Vec<u32>, cut: Vec<Cut>) -> Result<Self, Error> {
        let mut end = all.base().vertex_count() as u64;
        let mut place = |count: u64| {
            let start = end;
            end += count;
            match end <= MAX_HALFEDGES {
                true => Ok(start as u32),
                false => Err(Error::TooLarge { halfedges: end }),
            }
        };
        let of_edge =
            level.iter().map(|&level| place((1 << level) - 1)).collect::<Result<_, _>>()?;
        let inside = |cut: &Cut| place(cut.inner_count(grid.corners) as u64);
        let of_face = cut.iter().map(inside).collect::<Result<_, _>>()?;
        // A triangle has half a point, and three corners.
        if 6 * end > u64::from(u32::MAX) {
            return Err(Error::TooLarge { halfedges: 6 * end });
        }
        Ok(Self { level, cut, of_edge, of_face, vertex_count: end as usize })
    }

    /// The numbers of the points of the grid of a face that are used; of others nothing is said.
    fn numbers(&self, all: &Tessellation, grid: &Grid, face: usize) -> Vec<u32> {
        let (base, n) = (all.base(), grid.segments());
        let mut numbers = alloc::vec![0; grid.point_count()];
        for (i, h) in base.face_halfedges(FaceId(face as u32)).enumerate() {
            numbers[i] = base.origin(h).0;
            let e = base.edge(h);
            let (first, step) = (self.of_edge[e.index()], n >> self.level[e.index()]);
            let count = (n / step - 1) as u32;
            for (k, t) in (0..count).zip((step..n).step_by(step)) {
                let number =
                    if base.edge_halfedge(e) == h { first + k } else { first + count - 1 - k };
                numbers[grid.first_of_side(i) + t - 1] = number;
            }
        }
        let cut = self.cut[face];
        let step = n >> cut.level;
        for ([u, v], number) in cut.inner(grid.corners).zip(self.of_face[face]..) {
            numbers[grid.number(u * step, v * step)] = number;
        }
        numbers
    }
}
