//! Evaluation of the limit surface: it is the surface that refinement converges to.

mod common;

use common::{assorted, random_mesh};
use fairform::evaluate::{Evaluator, Location, Sample};
use fairform::refine::{refine, refine_mesh};
use fairform::{
    Border, Corners, Creases, Error, FaceId, Faces, HalfedgeId, Mesh, Rules, Scheme, Topology,
    Vec3, VertexId, limit, shapes,
};
use proptest::prelude::*;

/// Where a vertex of a refined mesh lies.
type Known = Vec<(Location, VertexId)>;

fn middle(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
}

fn plus(a: [f64; 2], b: [f64; 2], factor: f64) -> [f64; 2] {
    [a[0] + factor * b[0], a[1] + factor * b[1]]
}

/// A part of a face: its parameters, in the face or in a quadrilateral at a corner.
#[derive(Clone)]
struct Part {
    face: FaceId,
    corner: u32,
    parameters: Vec<[f64; 2]>,
}

impl Part {
    fn locations(&self) -> impl Iterator<Item = Location> + '_ {
        self.parameters.iter().map(|p| Location::at_corner(self.face, self.corner, p[0], p[1]))
    }
}

/// The vertices of all levels from 1 on, with where they lie, for Loop and Catmull–Clark; and those
/// levels.
fn follow(mesh: &Mesh, rules: &Rules, levels: u32) -> Vec<(Mesh, Rules, Known)> {
    let triangles = rules.scheme == Scheme::Loop;
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    // Polygons get their parameters with the first step.
    let whole = |f| match mesh.topology().face_vertices(f).len() {
        3 if triangles => vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        4 => square.to_vec(),
        _ => vec![],
    };
    let mut parts: Vec<Part> = (mesh.topology().faces())
        .map(|face| Part { face, corner: 0, parameters: whole(face) })
        .collect();
    let mut found: Vec<(Mesh, Rules, Known)> = Vec::new();
    let (mut mesh, mut rules) = (mesh.clone(), rules.clone());
    for _ in 0..levels {
        let mut finer = Vec::new();
        for (f, part) in mesh.topology().faces().zip(&parts) {
            let p = &part.parameters;
            if triangles {
                let m = [0, 1, 2].map(|i| middle(p[i], p[(i + 1) % 3]));
                for parameters in
                    [[p[0], m[0], m[2]], [p[1], m[1], m[0]], [p[2], m[2], m[1]], [m[0], m[1], m[2]]]
                {
                    finer.push(Part { parameters: parameters.to_vec(), ..*part });
                }
            } else {
                for i in 0..mesh.topology().face_vertices(f).len() {
                    let (corner, parameters) = if p.is_empty() {
                        (i as u32, square.to_vec())
                    } else {
                        let next = middle(p[i], p[(i + 1) % 4]);
                        let before = middle(p[i], p[(i + 3) % 4]);
                        (part.corner, vec![p[i], next, middle(p[0], p[2]), before])
                    };
                    finer.push(Part { face: part.face, corner, parameters });
                }
            }
        }
        parts = finer;
        (mesh, rules) = refine_mesh(&mesh, &rules, 1).unwrap();
        let topology = mesh.topology();
        let known = topology
            .faces()
            .zip(&parts)
            .flat_map(|(f, part)| part.locations().zip(topology.face_vertices(f).to_vec()))
            .collect();
        found.push((mesh.clone(), rules.clone(), known));
    }
    found
}

/// A cell of Doo and Sabin's scheme: the vertex, the half-edge it begins with, and its frame.
#[derive(Clone)]
struct Cell {
    vertex: VertexId,
    face: FaceId,
    corner: u32,
    origin: [f64; 2],
    axes: [[f64; 2]; 2],
}

/// The same for Doo and Sabin's scheme, whose vertices lie in the middle of cells.
fn follow_cells(mesh: &Mesh, rules: &Rules, levels: u32) -> Vec<(Mesh, Rules, Known)> {
    let coarse = mesh.topology();
    let is_open = |h| rules.border == Border::Bspline && coarse.twin(h).is_none();
    let mut cells = Vec::new();
    let mut extra = coarse.halfedge_count() as u32;
    for face in coarse.faces() {
        let whole = coarse.face_vertices(face).len() == 4;
        for (i, h) in coarse.face_halfedges(face).enumerate() {
            // The corner's quadrilateral, in the parameters of the face.
            let frame = |i: usize| {
                let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
                let axes = [[0.5, 0.0], [0.0, 0.5], [-0.5, 0.0], [0.0, -0.5]];
                if whole {
                    (0, corners[i], [axes[i], axes[(i + 1) % 4]])
                } else {
                    (i as u32, corners[0], [[1.0, 0.0], [0.0, 1.0]])
                }
            };
            let (corner, origin, axes) = frame(i);
            if rules.border == Border::Bspline || !coarse.is_boundary(coarse.origin(h)) {
                cells.push(Cell { vertex: VertexId(h.0), face, corner, origin, axes });
            }
            if is_open(h) {
                let low = plus(origin, axes[1], -1.0);
                cells.push(Cell { vertex: VertexId(extra), face, corner, origin: low, axes });
                let (corner, origin, axes) = frame((i + 1) % coarse.face_halfedges(face).len());
                let low = plus(plus(origin, axes[0], -1.0), axes[1], 1.0);
                let axes = [[-axes[1][0], -axes[1][1]], axes[0]];
                let vertex = VertexId(extra + 1);
                cells.push(Cell { vertex, face, corner, origin: low, axes });
                extra += 2;
            }
        }
    }
    let mut found: Vec<(Mesh, Rules, Known)> = Vec::new();
    let (mut mesh, mut rules) = (mesh.clone(), rules.clone());
    for level in 0..levels {
        if level > 0 {
            cells = cells.iter().flat_map(|cell| split(mesh.topology(), cell)).collect();
        }
        (mesh, rules) = refine_mesh(&mesh, &rules, 1).unwrap();
        let topology = mesh.topology();
        let known = cells
            .iter()
            .map(|cell| {
                let across = if topology.is_boundary(cell.vertex) { 0.0 } else { 0.5 };
                let [u, v] = plus(plus(cell.origin, cell.axes[0], 0.5), cell.axes[1], across);
                (Location::at_corner(cell.face, cell.corner, u, v), cell.vertex)
            })
            .collect();
        found.push((mesh.clone(), rules.clone(), known));
    }
    found
}

fn split(topology: &Topology, cell: &Cell) -> Vec<Cell> {
    let v = cell.vertex;
    let [a, b] = cell.axes.map(|axis| [0.5 * axis[0], 0.5 * axis[1]]);
    let centre = plus(plus(cell.origin, a, 1.0), b, 1.0);
    let minus = |a: [f64; 2]| [-a[0], -a[1]];
    let turns = [[a, b], [b, minus(a)], [minus(a), minus(b)], [minus(b), a]];
    // Inner vertices are images of corners and their cells begin in that face.
    let start =
        if topology.is_boundary(v) { topology.outgoing(v).unwrap() } else { HalfedgeId(v.0) };
    let fan = std::iter::successors(Some(start), |&h| topology.twin(topology.prev(h)));
    let fan: Vec<HalfedgeId> = fan.take(topology.fan_size(v) as usize).collect();
    let mut cells: Vec<Cell> = fan
        .iter()
        .zip(turns)
        .map(|(h, axes)| Cell { vertex: VertexId(h.0), origin: centre, axes, ..*cell })
        .collect();
    if topology.is_boundary(v) {
        let number = |h| {
            let before = topology.halfedges().take_while(|&g| g != h);
            topology.halfedge_count() + 2 * before.filter(|&g| topology.twin(g).is_none()).count()
        };
        let before = VertexId(number(topology.prev(fan[1])) as u32 + 1);
        let after = VertexId(number(fan[0]) as u32);
        cells.push(Cell { vertex: before, origin: cell.origin, axes: [a, b], ..*cell });
        let origin = plus(cell.origin, a, 1.0);
        cells.push(Cell { vertex: after, origin, axes: [a, b], ..*cell });
    }
    cells
}

/// The limit points of refined vertices are points of the surface where their parameters say.
fn check_refinement(mesh: &Mesh, rules: &Rules, levels: u32, name: &str) {
    let evaluator = Evaluator::new(mesh.topology(), rules).unwrap();
    let found = match rules.scheme {
        Scheme::DooSabin => follow_cells(mesh, rules, levels),
        _ => follow(mesh, rules, levels),
    };
    let size = mesh.positions().iter().map(|p| p.max_abs()).fold(1e-9, f64::max);
    for (level, (fine, next, known)) in found.iter().enumerate() {
        let (locations, vertices): (Vec<Location>, Vec<VertexId>) = known.iter().copied().unzip();
        let samples = evaluator.evaluate_many(mesh.positions(), &locations).unwrap();
        let stencils;
        let limit = match next.border {
            Border::Bspline => {
                limit::limit_points(fine.topology(), fine.positions(), next).unwrap()
            }
            // Only inner vertices have limit points: with the other border they are the same.
            Border::Drop => {
                stencils = Rules { border: Border::Bspline, ..next.clone() };
                limit::limit_points(fine.topology(), fine.positions(), &stencils).unwrap()
            }
        };
        for ((sample, v), location) in samples.iter().zip(vertices).zip(locations) {
            let error = (sample.position - limit[v.index()]).length() / size;
            assert!(error < 1e-12, "{name}, level {level}, {location:?}: off by {error:e}");
        }
    }
}

#[test]
fn the_surface_is_the_limit_of_refinement() {
    for (name, mesh) in assorted() {
        for corners in [Corners::Smooth, Corners::Sharp] {
            check_refinement(&mesh, &Rules { corners, ..Rules::LOOP }, 3, name);
            let rules = Rules { corners, ..Rules::from(Scheme::CatmullClark) };
            check_refinement(&mesh, &rules, 3, name);
        }
    }
}
