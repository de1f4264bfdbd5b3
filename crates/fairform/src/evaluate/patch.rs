//! Regular patches: where the limit surface over a face is one polynomial.
//!
//! Along a boundary or crease that is regular itself, the control points beyond it are those that
//! make the spline of the whole lattice have the same boundary: reflections.

use alloc::vec::Vec;

use super::basis::{LATTICE, QUARTICS};
use super::neighbourhood::Local;
use crate::crease::{INFINITE, Kind, Sharpness};
use crate::ids::{HalfedgeId, VertexId};
use crate::rules::BoundaryKinds;
use crate::scheme::Scheme;
use crate::scheme::loop_scheme::BoundaryKind;
use crate::{Stencils, Topology};

type Row = Vec<(u32, f64)>;

/// The control points of the patch over the first face, or for Doo–Sabin of the cell of the first
/// vertex, in the order of its basis; `None` if it is not regular.
pub(super) fn regular(local: &Local) -> Option<Stencils> {
    let rows = match local.rules.scheme {
        Scheme::Loop | Scheme::Butterfly => triangle(local)?,
        Scheme::CatmullClark | Scheme::Kobbelt => quadrilateral(local)?,
        Scheme::DooSabin => cell(&local.topology)?,
    };
    Some(stencils(local.value_count, rows.iter().map(Vec::as_slice)))
}

/// Rows, one behind the other.
pub(super) fn stencils<'a>(
    source_count: usize,
    rows: impl Iterator<Item = &'a [(u32, f64)]>,
) -> Stencils {
    let (mut start, mut source, mut weight) = (alloc::vec![0], Vec::new(), Vec::new());
    for row in rows {
        source.extend(row.iter().map(|e| e.0));
        weight.extend(row.iter().map(|e| e.1));
        start.push(source.len() as u32);
    }
    Stencils::from_arrays(source_count, start, source, weight)
}

fn combine<const N: usize>(terms: [(f64, VertexId); N]) -> Row {
    terms.iter().map(|&(weight, v)| (v.0, weight)).collect()
}

/// The faces round a vertex from one sharp edge to the next, or all.
pub(crate) struct Sector {
    /// Half-edges from the vertex, counter-clockwise.
    spokes: Vec<HalfedgeId>,
    /// Which of them was asked for.
    place: usize,
    is_closed: bool,
}

impl Sector {
    /// The sector of `h`; `None` if an edge at the vertex, or itself, is sharp for a while only.
    pub(crate) fn new(sharp: Sharpness<'_>, h: HalfedgeId) -> Option<Self> {
        let topology = sharp.topology;
        let v = topology.origin(h);
        let is_settled = |s: f64| s == 0.0 || s >= INFINITE;
        if !is_settled(sharp.vertex(v)) || !sharp.edges(v).all(|e| is_settled(sharp.edge(e.0))) {
            return None;
        }
        let is_sharp = |h: HalfedgeId| sharp.edge(topology.edge(h)) > 0.0;
        let (mut first, mut place, mut is_closed) = (h, 0, false);
        while let Some(t) = topology.twin(first).filter(|_| !is_sharp(first)) {
            first = topology.next(t);
            place += 1;
            if first == h {
                (place, is_closed) = (0, true);
                break;
            }
        }
        let mut spokes = alloc::vec![first];
        let mut last = topology.prev(first);
        while let Some(t) = topology.twin(last).filter(|&t| !is_sharp(last) && t != first) {
            spokes.push(t);
            last = topology.prev(t);
        }
        Some(Self { spokes, place, is_closed })
    }

    /// The neighbours along the spokes; with the other end of the last face if it is open.
    pub(crate) fn ring(&self, topology: &Topology) -> Vec<VertexId> {
        let mut ring: Vec<VertexId> = self.spokes.iter().map(|&h| topology.target(h)).collect();
        if !self.is_closed {
            ring.extend(self.spokes.last().map(|&h| topology.origin(topology.prev(h))));
        }
        ring
    }
}

/// The half-edges of the first face.
fn corners(topology: &Topology) -> impl Iterator<Item = (usize, HalfedgeId)> + use<> {
    topology.face_halfedges(crate::FaceId(0)).enumerate()
}

fn offset<const N: usize>([x, y]: [i8; 2], steps: &[[i8; 2]; N], i: usize) -> [i8; 2] {
    let [dx, dy] = steps[i % N];
    [x + dx, y + dy]
}

fn triangle(local: &Local) -> Option<Vec<Row>> {
    const STEPS: [[i8; 2]; 6] = [[1, 0], [0, 1], [-1, 1], [-1, 0], [0, -1], [1, -1]];
    let topology = &local.topology;
    let sharp = local.rules.sharpness(topology);
    let mut points: [Row; 12] = core::array::from_fn(|_| Row::new());
    let mut set = |at: [i8; 2], row: Row| {
        if let Some(i) = LATTICE.iter().position(|p| p.0 == at) {
            points[i] = row;
        }
    };
    for (i, h) in corners(topology) {
        let (v, at) = (topology.origin(h), LATTICE[i].0);
        let sector = Sector::new(sharp, h)?;
        match (sharp.kind(v, 0), sector.is_closed, sector.spokes.len()) {
            (Kind::Smooth, true, 6) => {}
            (Kind::Crease(_), false, 3) if is_straight(local, v) => {}
            _ => return None,
        }
        set(at, combine([(1.0, v)]));
        // Half-edge i of the face runs in direction 2 i.
        let first = 2 * i + 6 - sector.place;
        let ring = sector.ring(topology);
        for (j, &q) in ring.iter().enumerate() {
            set(offset(at, &STEPS, first + j), combine([(1.0, q)]));
        }
        if let (false, &[right, a, b, left]) = (sector.is_closed, ring.as_slice()) {
            let beyond = |end, inner| combine([(1.0, v), (1.0, end), (-1.0, inner)]);
            set(offset(at, &STEPS, first + 5), beyond(right, a));
            set(offset(at, &STEPS, first + 4), beyond(left, b));
        }
    }
    // To Bézier points.
    let bezier = |&e: &[u8; 3]| {
        let mut row = Row::new();
        for (point, (_, role)) in points.iter().zip(LATTICE) {
            let weight = role.bezier(e);
            for &(q, w) in point.iter().filter(|_| weight != 0.0) {
                match row.iter_mut().find(|entry| entry.0 == q) {
                    Some(entry) => entry.1 += weight * w,
                    None => row.push((q, weight * w)),
                }
            }
        }
        row
    };
    Some(QUARTICS.iter().map(bezier).collect())
}

/// Whether the boundary at a vertex follows the rules of a regular one; so does any crease.
fn is_straight(local: &Local, v: VertexId) -> bool {
    let kinds = BoundaryKinds { topology: &local.topology, corners: local.rules.corners };
    match kinds.of(v) {
        None => true,
        Some(BoundaryKind::Regular) => {
            let (before, after) = crate::rules::boundary_neighbours(&local.topology, v);
            [before, after].iter().all(|&q| kinds.edge_weights(v, q) == [0.5; 2])
        }
        Some(_) => false,
    }
}

/// The directions from a vertex of the square lattice.
const AXES: [[i8; 2]; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

fn quadrilateral(local: &Local) -> Option<Vec<Row>> {
    const CORNERS: [[i8; 2]; 4] = [[0, 0], [1, 0], [1, 1], [0, 1]];
    let topology = &local.topology;
    let sharp = local.rules.sharpness(topology);
    let mut points: Vec<Row> = alloc::vec![Row::new(); 16];
    let mut set = |[x, y]: [i8; 2], row: Row| points[(4 * (y + 1) + x + 1) as usize] = row;
    for (i, h) in corners(topology) {
        let (v, at) = (topology.origin(h), CORNERS[i]);
        let sector = Sector::new(sharp, h)?;
        let count = sector.spokes.len();
        match (sharp.kind(v, 0), sector.is_closed, count) {
            (Kind::Smooth, true, 4) | (Kind::Crease(_), false, 2) | (Kind::Corner, false, 1) => {}
            _ => return None,
        }
        // Half-edge i of the face runs in direction i.
        let first = i + 4 - sector.place;
        let edge = |j: usize| offset(at, &AXES, first + j);
        let diagonal = |j: usize| offset(edge(j), &AXES, first + j + 1);
        set(at, combine([(1.0, v)]));
        let ring = sector.ring(topology);
        let opposite: Vec<VertexId> =
            sector.spokes.iter().map(|&h| topology.target(topology.next(h))).collect();
        ring.iter().enumerate().for_each(|(j, &q)| set(edge(j), combine([(1.0, q)])));
        opposite.iter().enumerate().for_each(|(j, &o)| set(diagonal(j), combine([(1.0, o)])));
        match (ring.as_slice(), opposite.as_slice()) {
            (&[right, inner, left], &[a, b]) => {
                set(edge(3), combine([(2.0, v), (-1.0, inner)]));
                set(diagonal(2), combine([(2.0, left), (-1.0, b)]));
                set(diagonal(3), combine([(2.0, right), (-1.0, a)]));
            }
            (&[right, left], &[a]) => {
                set(edge(2), combine([(2.0, v), (-1.0, right)]));
                set(edge(3), combine([(2.0, v), (-1.0, left)]));
                set(diagonal(1), combine([(2.0, left), (-1.0, a)]));
                set(diagonal(3), combine([(2.0, right), (-1.0, a)]));
                set(diagonal(2), combine([(4.0, v), (-2.0, right), (-2.0, left), (1.0, a)]));
            }
            _ => {}
        }
    }
    Some(points)
}

/// The faces at the first vertex are the only ones, each beginning with it.
fn cell(topology: &Topology) -> Option<Vec<Row>> {
    if topology.uniform_face_size() != Some(4) {
        return None;
    }
    let mut points: Vec<Row> = alloc::vec![Row::new(); 9];
    let mut set = |[x, y]: [i8; 2], v: VertexId| {
        points[(3 * (y + 1) + x + 1) as usize] = combine([(1.0, v)]);
    };
    let v = VertexId(0);
    set([0, 0], v);
    let mut last = v;
    for (i, h) in topology.fan(v).enumerate() {
        let at = AXES[i % 4];
        let corners = topology.face_vertices(topology.face(h));
        set(at, corners[1]);
        set(offset(at, &AXES, i + 1), corners[2]);
        last = corners[3];
    }
    if topology.is_boundary(v) {
        // The control points on the boundary count twice.
        set(AXES[2], last);
        let right = topology.ring(v).next()?;
        for (at, v) in [([-1, -1], last), ([0, -1], v), ([1, -1], right)] {
            set(at, v);
        }
    }
    Some(points)
}
