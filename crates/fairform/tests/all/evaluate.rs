//! Evaluation of the limit surface: it is the surface that refinement converges to.

use crate::common::{assorted, random_mesh};
use fairform::evaluate::{Evaluator, Location, Sample};
use fairform::refine::refine_mesh;
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

fn size(mesh: &Mesh) -> f64 {
    mesh.positions().iter().map(|p| p.max_abs()).fold(1e-9, f64::max)
}

/// The limit points of refined vertices are points of the surface where their parameters say.
fn check_refinement(mesh: &Mesh, rules: &Rules, levels: u32, name: &str) {
    let evaluator = Evaluator::new(mesh.topology(), rules).unwrap();
    let found = match rules.scheme {
        Scheme::DooSabin => follow_cells(mesh, rules, levels),
        _ => follow(mesh, rules, levels),
    };
    let size = size(mesh);
    for (level, (fine, next, known)) in found.iter().enumerate() {
        let (locations, vertices): (Vec<Location>, Vec<VertexId>) = known.iter().copied().unzip();
        let samples = evaluator.evaluate_many(mesh.positions(), &locations).unwrap();
        let stencils;
        let limit = match next.border {
            Border::Bspline | Border::None => {
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

/// A mesh of polygons of many sizes: Doo and Sabin's of a triangle mesh; or its quadrilaterals.
fn polygons(triangles: &Mesh, scheme: Scheme) -> Mesh {
    refine_mesh(triangles, &Rules::from(scheme), 1).unwrap().0
}

/// Sharp edges and vertices at random: for a while, for ever, and beside each other.
fn creased(topology: &Topology, seed: u64) -> Creases {
    let mut creases = Creases::smooth(topology);
    let mut state = seed | 1;
    let mut random = |among: &[f64]| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        among[(state >> 11) as usize % among.len()]
    };
    for e in topology.edges() {
        creases.set_edge(e, random(&[0.0, 0.0, 0.0, 0.0, 0.7, 1.6, 10.0, 10.0])).unwrap();
    }
    for v in topology.vertices() {
        creases.set_vertex(v, random(&[0.0, 0.0, 0.0, 0.0, 0.0, 1.3, 10.0])).unwrap();
    }
    creases
}

fn with_creases(scheme: Scheme, corners: Corners, mesh: &Mesh, seed: u64) -> Rules {
    let creases = Some(creased(mesh.topology(), seed).into());
    Rules { corners, creases, ..Rules::from(scheme) }
}

fn has_two_faces(topology: &Topology) -> bool {
    topology.vertices().any(|v| !topology.is_boundary(v) && topology.fan_size(v) == 2)
}

#[test]
fn the_surface_is_the_limit_of_refinement_with_creases() {
    for (seed, (name, mesh)) in assorted().into_iter().enumerate() {
        for corners in [Corners::Smooth, Corners::Sharp] {
            for scheme in [Scheme::Loop, Scheme::CatmullClark] {
                let rules = with_creases(scheme, corners, &mesh, 77 + seed as u64);
                check_refinement(&mesh, &rules, 4, name);
            }
        }
    }
}

#[test]
fn the_surface_is_the_limit_of_refinement_in_two_phases() {
    for (seed, (name, mesh)) in assorted().into_iter().enumerate() {
        let lambda = mesh.topology().faces().map(|f| 0.5 + 0.125 * f64::from(f.0 % 5));
        let tension: Option<std::sync::Arc<[f64]>> = Some(lambda.collect());
        for scheme in [Scheme::Loop, Scheme::CatmullClark] {
            let creased = with_creases(scheme, Corners::Smooth, &mesh, 177 + seed as u64);
            for rules in [Rules::from(scheme), creased] {
                let rules = Rules { tension: tension.clone(), ..rules };
                check_refinement(&mesh, &rules, 3, name);
            }
        }
    }
}

#[test]
fn the_surface_is_the_limit_of_refinement_by_doo_and_sabin() {
    for (name, mesh) in assorted() {
        if has_two_faces(mesh.topology()) {
            continue;
        }
        let tension: Vec<f64> =
            mesh.topology().faces().map(|f| 0.3 + 0.7 / f64::from(f.0 % 4 + 1)).collect();
        let polygons = polygons(&mesh, Scheme::DooSabin);
        for border in [Border::Bspline, Border::Drop] {
            let rules = Rules { border, ..Rules::from(Scheme::DooSabin) };
            check_refinement(&mesh, &rules, 3, name);
            check_refinement(&polygons, &rules, 3, name);
            let rules = Rules { tension: Some(tension.clone().into()), ..rules };
            check_refinement(&mesh, &rules, 3, name);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn the_surface_is_the_limit_of_refinement_on_random_meshes(
        seed: u64, splits in 0..20_usize, holes in 0..9_usize,
    ) {
        let mesh = random_mesh(seed, splits, holes);
        let quads = polygons(&mesh, Scheme::CatmullClark);
        for corners in [Corners::Smooth, Corners::Sharp] {
            check_refinement(&mesh, &Rules { corners, ..Rules::LOOP }, 3, "random");
            check_refinement(&mesh, &with_creases(Scheme::Loop, corners, &mesh, seed), 3, "random");
            let rules = Rules { corners, ..Rules::from(Scheme::CatmullClark) };
            check_refinement(&mesh, &rules, 2, "random");
            check_refinement(&quads, &rules, 2, "random");
            let rules = with_creases(Scheme::CatmullClark, corners, &quads, seed);
            check_refinement(&quads, &rules, 2, "random");
        }
        if !has_two_faces(mesh.topology()) {
            let polygons = polygons(&mesh, Scheme::DooSabin);
            for border in [Border::Bspline, Border::Drop] {
                let rules = Rules { border, ..Rules::from(Scheme::DooSabin) };
                check_refinement(&mesh, &rules, 2, "random");
                check_refinement(&polygons, &rules, 2, "random");
            }
            check_refinement(&polygons, &Rules::from(Scheme::CatmullClark), 2, "random");
        }
    }
}

/// Some meshes with all their rules.
fn examples() -> Vec<(String, Mesh, Rules)> {
    let mut found = Vec::new();
    let random = random_mesh(4242, 12, 4);
    let (loops, polygons) = (
        [shapes::icosahedron(), shapes::fan(5), random.clone()],
        polygons(&random, Scheme::DooSabin),
    );
    for mesh in loops {
        found.push(("smooth".into(), mesh.clone(), Rules::LOOP));
        for scheme in [Scheme::Loop, Scheme::CatmullClark] {
            let rules = with_creases(scheme, Corners::Smooth, &mesh, 5);
            found.push((format!("creased {scheme}"), mesh.clone(), rules));
        }
        for scheme in [Scheme::CatmullClark, Scheme::DooSabin] {
            found.push((format!("triangles {scheme}"), mesh.clone(), scheme.into()));
        }
    }
    for mesh in [shapes::cube(), polygons] {
        for scheme in [Scheme::CatmullClark, Scheme::DooSabin] {
            found.push((format!("polygons {scheme}"), mesh.clone(), scheme.into()));
        }
    }
    found
}

/// Each face or quadrilateral at a corner that parameters are for.
fn charts(topology: &Topology, scheme: Scheme) -> Vec<(FaceId, u32)> {
    let count = |f| match (scheme, topology.face_vertices(f).len()) {
        (Scheme::Loop, _) | (_, 4) => 1,
        (_, size) => size as u32,
    };
    topology.faces().flat_map(|f| (0..count(f)).map(move |corner| (f, corner))).collect()
}

/// The derivatives are those of what `evaluate` itself says.
#[test]
fn derivatives_are_finite_differences() {
    const STEP: f64 = 1e-6;
    for (name, mesh, rules) in examples() {
        let evaluator = Evaluator::new(mesh.topology(), &rules).unwrap();
        let size = size(&mesh);
        for (face, corner) in charts(mesh.topology(), rules.scheme) {
            for [u, v] in [[0.31, 0.22], [0.07, 0.11], [0.6, 0.3], [0.1, 0.82], [0.011, 0.009]] {
                let at = |u, v| {
                    let location = Location::at_corner(face, corner, u, v);
                    evaluator.evaluate(mesh.positions(), location).unwrap()
                };
                let here = at(u, v);
                let (first, second) = (here.first.unwrap(), here.second.unwrap());
                let sides =
                    [[at(u + STEP, v), at(u - STEP, v)], [at(u, v + STEP), at(u, v - STEP)]];
                let slope = |f: &dyn Fn(&Sample) -> Vec3, i: usize| {
                    (f(&sides[i][0]) - f(&sides[i][1])) / (2.0 * STEP)
                };
                let differences = [
                    (first[0], slope(&|s| s.position, 0)),
                    (first[1], slope(&|s| s.position, 1)),
                    (second[0], slope(&|s| s.first.unwrap()[0], 0)),
                    (second[1], slope(&|s| s.first.unwrap()[1], 0)),
                    (second[1], slope(&|s| s.first.unwrap()[0], 1)),
                    (second[2], slope(&|s| s.first.unwrap()[1], 1)),
                ];
                for (i, (exact, near)) in differences.iter().enumerate() {
                    let error = (*exact - *near).length() / size;
                    assert!(error < 1e-5, "{name} {face} ({u}, {v}) derivative {i}: {error:e}");
                }
                let across = first[0].normalized().cross(first[1].normalized()).normalized();
                assert!((here.normal - across).length() < 1e-9, "{name} {face} ({u}, {v}): normal");
            }
        }
    }
}

/// Two faces say the same along their edge, but for the normal on a crease.
#[test]
fn faces_meet_along_edges() {
    for (name, mesh, rules) in examples() {
        let topology = mesh.topology();
        let evaluator = Evaluator::new(topology, &rules).unwrap();
        let along = |h: HalfedgeId, t: f64| {
            let face = topology.face(h);
            let i = topology.face_halfedges(face).position(|g| g == h).unwrap();
            let count = topology.face_vertices(face).len();
            let location = match (rules.scheme, count) {
                (Scheme::Loop, _) => {
                    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];
                    let [u, v] = [0, 1].map(|k| (1.0 - t) * corners[i][k] + t * corners[i + 1][k]);
                    Location::new(face, u, v)
                }
                (_, 4) => {
                    let [u, v] = [[t, 0.0], [1.0, t], [1.0 - t, 1.0], [0.0, 1.0 - t]][i];
                    Location::new(face, u, v)
                }
                _ if t <= 0.5 => Location::at_corner(face, i as u32, 2.0 * t, 0.0),
                _ => {
                    let next = (i + 1) % count;
                    Location::at_corner(face, next as u32, 0.0, 2.0 - 2.0 * t)
                }
            };
            evaluator.evaluate(mesh.positions(), location).unwrap()
        };
        for e in topology.edges() {
            let h = topology.edge_halfedge(e);
            let Some(twin) = topology.twin(h) else { continue };
            let is_sharp = rules.creases.as_ref().is_some_and(|c| c.edge(e) >= 10.0);
            for t in [0.0, 0.125, 0.3, 0.5, 0.77, 1.0 - 1e-3, 1.0] {
                let (a, b) = (along(h, t), along(twin, 1.0 - t));
                let error = (a.position - b.position).length() / size(&mesh);
                assert!(error < 1e-13, "{name} edge {e} at {t}: {error:e}");
                let is_inside = t > 0.0 && t < 1.0;
                if is_inside && !is_sharp && a.normal != Vec3::ZERO {
                    let error = (a.normal - b.normal).length();
                    assert!(error < 1e-8, "{name} edge {e} at {t}: normals {error:e}");
                }
            }
        }
    }
}

/// Normals at the limit points of vertices are those that the masks give.
#[test]
fn normals_at_corners_are_limit_normals() {
    let smooth = |rules: &Rules| rules.creases.is_none();
    for (name, mesh, rules) in examples().into_iter().filter(|e| smooth(&e.2)) {
        let topology = mesh.topology();
        let evaluator = Evaluator::new(topology, &rules).unwrap();
        let normals = limit::limit_normals(topology, mesh.positions(), &rules).unwrap();
        let points = limit::limit_points(topology, mesh.positions(), &rules).unwrap();
        for h in topology.halfedges() {
            let (v, face) = (topology.origin(h), topology.face(h));
            let i = topology.face_halfedges(face).position(|g| g == h).unwrap();
            let is_open = topology.is_boundary(v);
            let dual = rules.scheme == Scheme::DooSabin;
            if dual && is_open {
                // The faces of the corners do not reach it.
                continue;
            }
            let location = match (rules.scheme, topology.face_vertices(face).len()) {
                (Scheme::Loop, _) => {
                    let [u, v] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]][i];
                    Location::new(face, u, v)
                }
                (_, 4) => {
                    let [u, v] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]][i];
                    Location::new(face, u, v)
                }
                _ => Location::at_corner(face, i as u32, 0.0, 0.0),
            };
            let sample = evaluator.evaluate(mesh.positions(), location).unwrap();
            let error = (sample.position - points[v.index()]).length() / size(&mesh);
            assert!(error < 1e-13, "{name} vertex {v}: {error:e}");
            let error = (sample.normal - normals[v.index()]).length();
            assert!(error < 1e-9, "{name} vertex {v}: normal off by {error:e}");
        }
    }
}

/// At vertices on creases and on the boundary too, the normal is the limit of those nearby: where there
/// is one.
#[test]
fn normals_at_corners_are_limits() {
    for n in [5, 6, 7, 9] {
        for scheme in [Scheme::Loop, Scheme::CatmullClark] {
            for spread in 1..=n / 2 {
                let fan = shapes::fan(n);
                let topology = fan.topology();
                let mut creases = Creases::smooth(topology);
                let spokes: Vec<HalfedgeId> = topology.fan(VertexId(n)).collect();
                for i in [0, spread] {
                    creases.set_edge(topology.edge(spokes[i as usize]), 10.0).unwrap();
                }
                let rules = Rules { creases: Some(creases.into()), ..Rules::from(scheme) };
                let evaluator = Evaluator::new(topology, &rules).unwrap();
                // Face i is i, i + 1, n, with the centre of the fan as its third corner.
                // Wider sides have no normal.
                let widest = if scheme == Scheme::Loop { 5 } else { 3 };
                let width = |f: &FaceId| if f.0 < spread { spread } else { n - spread };
                for face in topology.faces().filter(|f| width(f) <= widest) {
                    let at = |t: f64| {
                        let location = match scheme {
                            Scheme::Loop => Location::new(face, 0.4 * t, 1.0 - t),
                            _ => Location::at_corner(face, 2, 0.5 * t, 0.6 * t),
                        };
                        evaluator.evaluate(fan.positions(), location).unwrap().normal
                    };
                    let error = |t: f64| (at(t) - at(0.0)).length();
                    let (far, near) = (error(0.5_f64.powf(6.0)), error(0.5_f64.powf(22.0)));
                    assert!(
                        near < 1e-7 || near < 0.5 * far,
                        "{scheme} {n} {face}: {far:e} to {near:e}"
                    );
                }
            }
        }
    }
}

/// The limit point of a boundary vertex is where Doo and Sabin's strip ends.
#[test]
fn strips_end_at_the_boundary() {
    let mesh = shapes::sheet(4, 5, |x, y| x * x - y);
    let (topology, rules) = (mesh.topology(), Rules::from(Scheme::DooSabin));
    let evaluator = Evaluator::new(topology, &rules).unwrap();
    let points = limit::limit_points(topology, mesh.positions(), &rules).unwrap();
    let normals = limit::limit_normals(topology, mesh.positions(), &rules).unwrap();
    let mut count = 0;
    for v in topology.vertices().filter(|&v| topology.is_boundary(v)) {
        let h = topology.outgoing(v).unwrap();
        let face = topology.face(h);
        let i = topology.face_halfedges(face).position(|g| g == h).unwrap();
        let location = Location::at_corner(face, i as u32, 0.0, -1.0);
        let sample = evaluator.evaluate(mesh.positions(), location).unwrap();
        assert!((sample.position - points[v.index()]).length() < 1e-14);
        assert!((sample.normal - normals[v.index()]).length() < 1e-12);
        count += 1;
    }
    assert_eq!(count, 14);
}

/// Towards an extraordinary vertex the derivatives shrink or grow by twice the subdominant eigenvalue
/// each time that the distance is halved, at any distance.
#[test]
fn derivatives_follow_the_eigenvalue() {
    let c = |n: f64| (2.0 * std::f64::consts::PI / n).cos();
    let catmull_clark =
        |n: f64| (5.0 + c(n) + (0.5 + 0.5 * c(n)).sqrt() * (18.0 + 2.0 * c(n)).sqrt()) / 16.0;
    for (mesh, scheme, eigenvalue) in [
        (shapes::icosahedron(), Scheme::Loop, 0.375 + 0.25 * c(5.0)),
        (shapes::octahedron(), Scheme::Loop, 0.375 + 0.25 * c(4.0)),
        (shapes::cube(), Scheme::CatmullClark, catmull_clark(3.0)),
    ] {
        let topology = mesh.topology();
        let evaluator = Evaluator::new(topology, &scheme.into()).unwrap();
        let at = |t: f64| {
            let location = Location::new(FaceId(2), 0.3 * t, 0.2 * t);
            evaluator.evaluate(mesh.positions(), location).unwrap()
        };
        let corner = at(0.0);
        assert_eq!((corner.first, corner.second), (None, None));
        for level in [30, 60, 150, 230] {
            let t = 0.5_f64.powf(f64::from(level));
            let (near, nearer) = (at(t), at(0.5 * t));
            for (a, b) in near.first.unwrap().into_iter().zip(nearer.first.unwrap()) {
                let error = (b - 2.0 * eigenvalue * a).length() / b.length();
                assert!(error < 1e-9, "{scheme} at level {level}: {error:e}");
            }
            assert!((near.normal - corner.normal).length() < 1e-8, "{scheme} at level {level}");
        }
        for t in [1e-90, f64::MIN_POSITIVE, 1e-310] {
            assert!((at(t).position - corner.position).length() < 1e-15, "at {t:e}");
        }
    }
}

/// Regular grids give tensor products of the cardinal splines.
#[test]
fn regular_tori_are_tensor_product_splines() {
    const N: i32 = 7;
    let number = |i: i32, j: i32| (i.rem_euclid(N) * N + j.rem_euclid(N)) as u32;
    let faces: Faces = (0..N * N)
        .map(|k| (k / N, k % N))
        .map(|(i, j)| [[i, j], [i, j + 1], [i + 1, j + 1], [i + 1, j]].map(|[i, j]| number(i, j)))
        .collect();
    let wave = |k: usize, f: f64| (1.0 + f * (k * k + 3 * k) as f64).sin();
    let points: Vec<Vec3> = (0..(N * N) as usize)
        .map(|k| Vec3::new(wave(k, 0.7), wave(k, 1.9), wave(k, 2.3)))
        .collect();
    let mesh = Mesh::new(points, &faces).unwrap();
    let cubic = |x: f64| match x.abs() {
        x if x < 1.0 => 2.0 / 3.0 - x * x + 0.5 * x * x * x,
        x if x < 2.0 => (2.0 - x) * (2.0 - x) * (2.0 - x) / 6.0,
        _ => 0.0,
    };
    let quadratic = |x: f64| match x.abs() {
        x if x < 0.5 => 0.75 - x * x,
        x if x < 1.5 => 0.5 * (1.5 - x) * (1.5 - x),
        _ => 0.0,
    };
    let splines: [(Scheme, &dyn Fn(f64) -> f64); 2] =
        [(Scheme::CatmullClark, &cubic), (Scheme::DooSabin, &quadratic)];
    for (scheme, spline) in splines {
        let evaluator = Evaluator::new(mesh.topology(), &scheme.into()).unwrap();
        for k in 0..N * N {
            for [u, v] in [[0.0, 0.0], [0.3, 0.9], [0.5, 0.75], [0.62, 0.41], [1.0, 0.2]] {
                let mut expected = Vec3::ZERO;
                for i in -2..4 {
                    for j in -2..4 {
                        let weight = spline(v - f64::from(i)) * spline(u - f64::from(j));
                        let q = number(k / N + i, k % N + j);
                        expected += weight * mesh.positions()[q as usize];
                    }
                }
                let location = Location::new(FaceId(k as u32), u, v);
                let sample = evaluator.evaluate(mesh.positions(), location).unwrap();
                assert!((sample.position - expected).length() < 1e-14, "{scheme} {location:?}");
            }
        }
    }
}

/// A vertex of very many faces is not looked at beforehand, and is no different.
#[test]
fn high_valences_are_no_different() {
    let mesh = shapes::bipyramid(400);
    let evaluator = Evaluator::new(mesh.topology(), &Rules::LOOP).unwrap();
    for (fine, rules, known) in follow(&mesh, &Rules::LOOP, 2) {
        let limit = limit::limit_points(fine.topology(), fine.positions(), &rules).unwrap();
        for (location, v) in known.into_iter().step_by(997) {
            let sample = evaluator.evaluate(mesh.positions(), location).unwrap();
            let error = (sample.position - limit[v.index()]).length();
            assert!(error < 1e-12, "{location:?}: {error:e}");
        }
    }
}

#[test]
fn an_affine_map_of_the_mesh_is_one_of_the_surface() {
    let map =
        |p: Vec3| Vec3::new(3.0 * p.x - p.y + 7.0, 0.5 * p.z + p.x, 10.0 - 2.0 * p.y + 0.1 * p.z);
    for (name, mesh, rules) in examples() {
        let evaluator = Evaluator::new(mesh.topology(), &rules).unwrap();
        let mapped: Vec<Vec3> = mesh.positions().iter().map(|&p| map(p)).collect();
        for (face, corner) in charts(mesh.topology(), rules.scheme) {
            for [u, v] in [[0.0, 0.0], [0.25, 0.3], [1e-9, 0.4], [0.0, 1.0]] {
                let location = Location::at_corner(face, corner, u, v);
                let here = evaluator.evaluate(mesh.positions(), location).unwrap().position;
                let there = evaluator.evaluate(&mapped, location).unwrap().position;
                assert!((map(here) - there).length() < 1e-13, "{name} {location:?}");
            }
        }
    }
}

#[test]
fn what_is_not_on_the_surface_is_said() {
    let sheet = shapes::sheet(3, 3, |x, y| x * y);
    let at = |rules: &Rules, location: Location| {
        Evaluator::new(sheet.topology(), rules).unwrap().evaluate(sheet.positions(), location)
    };
    let (face, dual) = (FaceId(0), Rules::from(Scheme::DooSabin));
    for [u, v] in [[-0.1, 0.2], [0.6, 0.5], [f64::NAN, 0.0], [0.0, f64::INFINITY], [-1e-9, 0.0]] {
        let error = at(&Rules::LOOP, Location::new(face, u, v)).unwrap_err();
        assert!(matches!(error, Error::BadOption { .. }), "{error}");
        let error = at(&Rules::from(Scheme::CatmullClark), Location::new(face, 2.0 * u, v));
        assert!(matches!(error, Err(Error::BadOption { .. })), "{error:?}");
    }
    for location in [Location::new(FaceId(8), 0.1, 0.1), Location::at_corner(face, 1, 0.1, 0.1)] {
        let error = at(&Rules::LOOP, location).unwrap_err();
        assert!(matches!(error, Error::BadOption { .. }), "{error}");
    }
    // Face 0 is 0, 1, 4, of which the first side is on the boundary.
    assert!(at(&dual, Location::at_corner(face, 0, 0.5, -0.5)).is_ok());
    for (corner, u, v) in [(0, -0.5, 0.5), (1, 0.5, -0.5), (0, -0.5, -0.5), (3, 0.5, 0.5)] {
        let error = at(&dual, Location::at_corner(face, corner, u, v)).unwrap_err();
        assert!(matches!(error, Error::BadOption { .. }), "{error}");
    }
    let drop = Rules { border: Border::Drop, ..dual.clone() };
    assert!(at(&drop, Location::at_corner(face, 2, 0.5, 0.5)).is_ok());
    let error = at(&drop, Location::at_corner(face, 0, 0.5, 0.5)).unwrap_err();
    assert!(matches!(error, Error::NoLimit { vertex: VertexId(0), .. }), "{error}");

    let pillow = crate::common::back_to_back();
    let evaluator = Evaluator::new(pillow.topology(), &dual).unwrap();
    let error = evaluator.evaluate(pillow.positions(), Location::new(face, 0.5, 0.5)).unwrap_err();
    assert!(matches!(error, Error::NoLimit { .. }), "{error}");
}

/// A step from the topology alone, to be sure that no part of the surface is left out: the parts of a
/// face cover it.
#[test]
fn parts_meet_inside_faces() {
    for (name, mesh, rules) in examples() {
        let evaluator = Evaluator::new(mesh.topology(), &rules).unwrap();
        let at = |face, corner, u, v| {
            let location = Location::at_corner(face, corner, u, v);
            evaluator.evaluate(mesh.positions(), location).unwrap()
        };
        let step = 1e-9;
        for (face, corner) in charts(mesh.topology(), rules.scheme) {
            for ([u, v], [du, dv]) in [
                ([0.5, 0.2], [step, 0.0]),
                ([0.2, 0.5], [0.0, step]),
                ([0.3, 0.2], [step, step]),
                ([0.25, 0.1], [step, 0.0]),
                ([0.375, 0.4], [step, 0.0]),
            ] {
                let a = at(face, corner, u - du, v - dv);
                let b = at(face, corner, u + du, v + dv);
                let error = (a.position - b.position).length() / size(&mesh);
                assert!(error < 1e-7, "{name} {face} ({u}, {v}): {error:e}");
                let [a, b] = [a.first.unwrap(), b.first.unwrap()];
                for (a, b) in a.into_iter().zip(b) {
                    let error = (a - b).length() / size(&mesh);
                    assert!(error < 1e-6, "{name} {face} ({u}, {v}): derivative {error:e}");
                }
            }
        }
    }
}
