//! Limit positions, tangents and normals at the vertices of a mesh.

use alloc::vec::Vec;

use crate::error::Error;
use crate::ids::VertexId;
use crate::rules::{BoundaryKinds, VertexRule, boundary_neighbours, largest_fan};
use crate::scheme::loop_scheme::{
    BoundaryKind, inward_tangent_centre_weight, inward_tangent_weight, tangent_weights,
};
use crate::scheme::{Corners, Scheme};
use crate::{Stencils, Topology, Vec3};

pub(crate) mod operator;

/// The rows that take control points to the limit points of the vertices, one row per vertex. An
/// isolated vertex is its own limit point.
///
/// # Errors
/// As [`Scheme::check`].
pub fn limit_stencils(
    topology: &Topology,
    scheme: Scheme,
    corners: Corners,
) -> Result<Stencils, Error> {
    scheme.check(topology)?;
    let rule = VertexRule::limit(topology, corners);
    let mut row_start = Vec::with_capacity(topology.vertex_count() + 1);
    let mut end = 0;
    row_start.push(end);
    for v in topology.vertices() {
        end += rule.row_len(v);
        row_start.push(end);
    }
    Ok(Stencils::build(topology.vertex_count(), row_start, &|row, source, weight| {
        rule.row(VertexId(row as u32), source, weight);
    }))
}

/// The limit points of all vertices for control points `points`.
///
/// # Errors
/// As [`Scheme::check`].
///
/// # Panics
/// If there is not one point per vertex.
pub fn limit_points(
    topology: &Topology,
    points: &[Vec3],
    scheme: Scheme,
    corners: Corners,
) -> Result<Vec<Vec3>, Error> {
    assert_eq!(points.len(), topology.vertex_count(), "one point per vertex");
    scheme.check(topology)?;
    let rule = VertexRule::limit(topology, corners);
    let mut limit = alloc::vec![Vec3::ZERO; points.len()];
    topology.fill_by_ring(&mut limit, |v, ring| rule.apply(v, ring, points));
    Ok(limit)
}

/// The unit normals of the limit surface at the limit points of all vertices, outwards for
/// counter-clockwise faces; zero at isolated vertices and where the tangents are parallel.
///
/// At a boundary vertex with two faces the limit surface has no unique normal; there the result is
/// that of the convention of [`inward_tangent_weight`].
///
/// # Errors
/// As [`Scheme::check`].
///
/// # Panics
/// If there is not one point per vertex.
pub fn limit_normals(
    topology: &Topology,
    points: &[Vec3],
    scheme: Scheme,
    corners: Corners,
) -> Result<Vec<Vec3>, Error> {
    assert_eq!(points.len(), topology.vertex_count(), "one point per vertex");
    scheme.check(topology)?;
    let tangents = Tangents {
        kinds: BoundaryKinds { topology, corners },
        points,
        ring_weights: RingTangents::new(topology),
    };
    let mut normals = alloc::vec![Vec3::ZERO; points.len()];
    topology.fill_by_ring(&mut normals, |v, ring| {
        let [along, across] = tangents.at(v, ring);
        // Tangents of tiny or huge meshes are scaled first, so that no product under- or overflows.
        along.normalized().cross(across.normalized()).normalized()
    });
    Ok(normals)
}

/// Two tangents of the limit surface at the limit point of every vertex; their vector product
/// points outwards. Zero at isolated vertices.
///
/// # Errors
/// As [`Scheme::check`].
///
/// # Panics
/// If there is not one point per vertex.
pub fn limit_tangents(
    topology: &Topology,
    points: &[Vec3],
    scheme: Scheme,
    corners: Corners,
) -> Result<Vec<[Vec3; 2]>, Error> {
    assert_eq!(points.len(), topology.vertex_count(), "one point per vertex");
    scheme.check(topology)?;
    let tangents = Tangents {
        kinds: BoundaryKinds { topology, corners },
        points,
        ring_weights: RingTangents::new(topology),
    };
    let mut out = alloc::vec![[Vec3::ZERO; 2]; points.len()];
    topology.fill_by_ring(&mut out, |v, ring| tangents.at(v, ring));
    Ok(out)
}

struct Tangents<'a> {
    kinds: BoundaryKinds<'a>,
    points: &'a [Vec3],
    ring_weights: RingTangents,
}

impl Tangents<'_> {
    fn at(&self, v: VertexId, ring: &[u32]) -> [Vec3; 2] {
        let topology = self.kinds.topology;
        match self.kinds.of(v) {
            None => self.interior(ring),
            Some(BoundaryKind::Corner) => {
                let (last, first) = boundary_neighbours(topology, v);
                let here = self.points[v.index()];
                [self.points[first.index()] - here, self.points[last.index()] - here]
            }
            Some(_) => self.boundary(v, topology.fan_size(v)),
        }
    }

    fn interior(&self, ring: &[u32]) -> [Vec3; 2] {
        let mut t = [Vec3::ZERO; 2];
        for (i, &q) in ring.iter().enumerate() {
            let q = self.points[q as usize];
            let [c, s] = self.ring_weights.get(ring.len() as u32, i as u32);
            t[0] += c * q;
            t[1] += s * q;
        }
        t
    }

    /// The masks hold on the ring after one step, so that step is made here, locally.
    fn boundary(&self, v: VertexId, k: u32) -> [Vec3; 2] {
        let topology = self.kinds.topology;
        let point = |q: VertexId| self.points[q.index()];
        let (last, first) = boundary_neighbours(topology, v);
        let here = point(v);
        let boundary_point = |q: VertexId| {
            let [a, b] = self.kinds.edge_weights(v, q);
            a * here + b * point(q)
        };
        let finer = 0.75 * here + 0.125 * (point(first) + point(last));
        let (first_point, last_point) = (boundary_point(first), boundary_point(last));
        let mut across = inward_tangent_centre_weight(k) * finer
            + inward_tangent_weight(k, 0) * first_point
            + inward_tangent_weight(k, k) * last_point;
        let mut ring = topology.ring(v).map(point);
        let (mut before, mut at) = (ring.next(), ring.next());
        for (i, after) in (1..k).zip(ring) {
            if let (Some(before), Some(at)) = (before, at) {
                let edge_point = 0.375 * (here + at) + 0.125 * (before + after);
                across += inward_tangent_weight(k, i) * edge_point;
            }
            (before, at) = (at, Some(after));
        }
        [first_point - last_point, across]
    }
}

/// Tangent weights of all ring places, for the usual valences kept in a table.
struct RingTangents {
    table: Vec<Vec<[f64; 2]>>,
}

impl RingTangents {
    const TABLE: u32 = 64;

    fn new(topology: &Topology) -> Self {
        let largest = largest_fan(topology).min(Self::TABLE);
        let row = |n: u32| (0..n).map(|i| tangent_weights(n, i)).collect();
        Self { table: (0..=largest).map(row).collect() }
    }

    fn get(&self, n: u32, i: u32) -> [f64; 2] {
        match self.table.get(n as usize) {
            Some(row) => row[i as usize],
            None => tangent_weights(n, i),
        }
    }
}
