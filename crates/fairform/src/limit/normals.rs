//! Tangents and normals of the limit surface at the limit points of the vertices.

use alloc::vec::Vec;
use core::f64::consts::PI;

use libm::{cos, sin};

use super::interpolating::InterpolatingTangents;
use super::local::{Local, local_rows};
use crate::crease::Sharpness;
use crate::error::Error;
use crate::ids::{HalfedgeId, VertexId};
use crate::refine::{DooSabinRows, PhaseOne};
use crate::rows;
use crate::rules::largest_fan;
use crate::scheme::loop_scheme::{
    inward_tangent_centre_weight, inward_tangent_weight, tangent_weights,
};
use crate::scheme::{Rules, Scheme, catmull_clark};
use crate::{Topology, Vec3, par};

/// The unit normals of the limit surface at the limit points of all vertices, outwards for
/// counter-clockwise faces; zero at isolated vertices and where the tangents are parallel.
///
/// On a crease the surface has a normal on either side; the result is their mean. At a boundary
/// vertex with two faces Loop's limit surface has no unique normal; there the result is that of the
/// convention of
/// [`inward_tangent_weight`](crate::scheme::loop_scheme::inward_tangent_weight).
///
/// The butterfly scheme has a tangent plane at every interior vertex, and on the boundary at vertices
/// with two or three faces. Kobbelt's scheme has one at interior vertices, for valence 3 only up to a
/// [tension](crate::scheme::kobbelt::VALENCE_3_SMOOTH_UP_TO), and on the boundary at vertices with two
/// faces and at sharp corners. At other boundary vertices the result is an approximate mean. Interior
/// vertices with two faces have no normal in either: zero.
///
/// # Errors
/// As [`limit_points`](super::limit_points); for interpolating schemes [`Error::TooLarge`] if there
/// is no room for one step.
///
/// # Panics
/// If there is not one point per vertex.
pub fn limit_normals(
    topology: &Topology,
    points: &[Vec3],
    rules: &Rules,
) -> Result<Vec<Vec3>, Error> {
    let tangents = Tangents::new(topology, points, rules)?;
    let mut normals = alloc::vec![Vec3::ZERO; points.len()];
    topology.fill_by_ring(&mut normals, |v, ring| {
        let mut normal = Vec3::ZERO;
        tangents.at(v, ring, |_, [along, across]| {
            // Scaled first, so that no product of tiny or huge tangents under- or overflows.
            normal += along.normalized().cross(across.normalized()).normalized();
        });
        normal.normalized()
    });
    Ok(normals)
}

/// The normals of [`limit_normals`] per half-edge, at the vertex where it begins: those of one side where
/// creases part the surface, so that what is sharp can be shown as sharp.
///
/// # Errors
/// As [`limit_normals`].
///
/// # Panics
/// If there is not one point per vertex.
pub fn limit_corner_normals(
    topology: &Topology,
    points: &[Vec3],
    rules: &Rules,
) -> Result<Vec<Vec3>, Error> {
    let mean = limit_normals(topology, points, rules)?;
    let mut normals = par::collect(topology.halfedge_count(), |h| {
        mean[topology.origin(HalfedgeId(h as u32)).index()]
    });
    if rules.creases.is_none() {
        return Ok(normals);
    }
    let tangents = Tangents::new(topology, points, rules)?;
    let sides = par::blocks(points.len(), |range| {
        let (mut sides, mut around) = (Vec::new(), Vec::new());
        for v in range.map(|v| VertexId(v as u32)) {
            if tangents.sharp.edges(v).all(|e| tangents.sharp.edge(e.0) == 0.0) {
                continue;
            }
            around.clear();
            around.extend(topology.ring(v).map(|q| q.0));
            let fan: Vec<HalfedgeId> = topology.fan(v).collect();
            tangents.at(v, &around, |(first, count), [along, across]| {
                let normal = along.normalized().cross(across.normalized()).normalized();
                sides.extend((first..first + count).map(|i| (fan[i % fan.len()], normal)));
            });
        }
        sides
    });
    for (h, normal) in sides.into_iter().flatten().filter(|side| side.1 != Vec3::ZERO) {
        normals[h.index()] = normal;
    }
    Ok(normals)
}

/// Two tangents of the limit surface at the limit point of every vertex; their vector product
/// points outwards. On a crease those of one side. Zero at isolated vertices.
///
/// # Errors
/// As [`limit_normals`].
///
/// # Panics
/// If there is not one point per vertex.
pub fn limit_tangents(
    topology: &Topology,
    points: &[Vec3],
    rules: &Rules,
) -> Result<Vec<[Vec3; 2]>, Error> {
    let tangents = Tangents::new(topology, points, rules)?;
    let mut out = alloc::vec![[Vec3::ZERO; 2]; points.len()];
    topology.fill_by_ring(&mut out, |v, ring| {
        let mut first = None;
        tangents.at(v, ring, |_, t| {
            first.get_or_insert(t);
        });
        first.unwrap_or_default()
    });
    Ok(out)
}

/// [`limit_tangents`] of all sides, at some vertices.
pub(crate) fn vertex_tangents(
    topology: &Topology,
    points: &[Vec3],
    rules: &Rules,
    vertices: &[VertexId],
) -> Result<Vec<Vec<[Vec3; 2]>>, Error> {
    let tangents = Tangents::new(topology, points, rules)?;
    let of = |&v: &VertexId| {
        let around: Vec<u32> = topology.ring(v).map(|q| q.0).collect();
        let mut sides = Vec::new();
        tangents.at(v, &around, |_, t| sides.push(t));
        sides
    };
    Ok(vertices.iter().map(of).collect())
}

/// The tangents at the vertex where a half-edge begins, on the side of its face. For Loop and
/// Catmull–Clark; rules that fit the topology.
pub(crate) fn side_tangents(
    topology: &Topology,
    points: &[Vec3],
    rules: &Rules,
    h: HalfedgeId,
) -> [Vec3; 2] {
    let (v, sharp) = (topology.origin(h), rules.sharpness(topology));
    let place = topology.fan(v).position(|g| g == h).unwrap_or(0);
    let size = topology.fan_size(v) as usize;
    let mut here = [Vec3::ZERO; 2];
    let tangents = Tangents {
        sharp,
        rules,
        points,
        refined: phase_one(topology, points, rules),
        images: None,
        weights: Vec::new(),
        quad_weights: Vec::new(),
        interpolating: None,
    };
    let around: Vec<u32> = topology.ring(v).map(|q| q.0).collect();
    tangents.at(v, &around, |(first, count), t| {
        if (place + size - first % size) % size < count {
            here = t;
        }
    });
    here
}

/// A rule that tells its entries to whoever asks.
type Entries<'e> = dyn Fn(&mut dyn FnMut(u32, f64)) + 'e;

struct Tangents<'a> {
    sharp: Sharpness<'a>,
    rules: &'a Rules,
    points: &'a [Vec3],
    /// Loop and Catmull–Clark in two phases: the points after phase one.
    refined: Option<Vec<Vec3>>,
    images: Option<DooSabinRows<'a>>,
    /// Tangent weights of all ring places, for the usual valences: Loop's, and Catmull and Clark's.
    weights: Vec<Vec<[f64; 2]>>,
    quad_weights: Vec<Vec<[[f64; 2]; 2]>>,
    interpolating: Option<InterpolatingTangents<'a>>,
}

impl<'a> Tangents<'a> {
    fn new(topology: &'a Topology, points: &'a [Vec3], rules: &'a Rules) -> Result<Self, Error> {
        assert_eq!(points.len(), topology.vertex_count(), "one point per vertex");
        super::check(topology, rules)?;
        let images = (rules.scheme == Scheme::DooSabin).then(|| DooSabinRows::new(topology, rules));
        let (mut weights, mut quad_weights) = (Vec::new(), Vec::new());
        let usual = 0..=largest_fan(topology).min(64);
        match rules.scheme {
            Scheme::Loop => {
                weights.extend(usual.map(|n| (0..n).map(|i| tangent_weights(n, i)).collect()));
            }
            Scheme::CatmullClark => {
                let of = catmull_clark::tangent_weights;
                quad_weights.extend(usual.map(|n| (0..n).map(|i| of(n, i)).collect()));
            }
            _ => {}
        }
        let interpolating = if rules.scheme.is_interpolating() {
            Some(InterpolatingTangents::new(topology, points, rules)?)
        } else {
            None
        };
        let sharp = rules.sharpness(topology);
        let refined = phase_one(topology, points, rules);
        Ok(Self { sharp, rules, points, refined, images, weights, quad_weights, interpolating })
    }

    /// The tangents at a vertex, for each of its sectors between sharp edges: first face and number
    /// of faces.
    fn at(&self, v: VertexId, around: &[u32], mut found: impl FnMut((usize, usize), [Vec3; 2])) {
        let topology = self.sharp.topology;
        let all = (0, topology.fan_size(v) as usize);
        if topology.is_isolated(v) {
            return;
        }
        let point = |q: VertexId| self.points[q.index()];
        if let Some(images) = &self.images {
            return found(all, self.doo_sabin(images, v));
        }
        if let Some(tangents) = &self.interpolating {
            return tangents.at(v, &mut |t| found(all, t));
        }
        let is_plain =
            self.rules.creases.is_none() && self.refined.is_none() && !topology.is_boundary(v);
        match self.rules.scheme {
            Scheme::Loop if is_plain => return found(all, self.ring(around)),
            // Other faces become quadrilaterals with a step.
            Scheme::CatmullClark if is_plain && topology.uniform_face_size() == Some(4) => {
                let opposite = topology.fan(v).map(|h| point(topology.target(topology.next(h))));
                let edges = around.iter().map(|&q| self.points[q as usize]);
                return found(all, self.quads(edges.zip(opposite), all.1));
            }
            _ => {}
        }
        let mut local = Local::new(self.sharp, self.rules, v);
        let mut values = Vec::with_capacity(1 + around.len() + topology.fan_size(v) as usize);
        if let Some(refined) = &self.refined {
            local = local.next();
            values.extend(local_rows(self.sharp, self.rules.scheme, v).map(|row| refined[row]));
        } else {
            values.push(point(v));
            values.extend(around.iter().map(|&q| self.points[q as usize]));
            if self.rules.scheme == Scheme::CatmullClark {
                values.extend(topology.fan(v).map(|h| {
                    let corners = topology.face_vertices(topology.face(h));
                    corners.iter().map(|&q| point(q)).sum::<Vec3>() / corners.len() as f64
                }));
            }
        }
        let (local, values) = local.settle(values);
        let (m, k) = (local.edges.len(), local.face_count());
        let (here, edges) = (values[0], &values[1..=m]);
        let faces = &values[1 + m..];
        if local.is_smooth() {
            let tangents = match self.rules.scheme {
                Scheme::CatmullClark => {
                    self.quads(edges.iter().copied().zip(faces.iter().copied()), k)
                }
                _ => ring(edges.iter().copied(), k as u32),
            };
            return found(all, tangents);
        }
        for (first, count) in local.sectors() {
            let edge = |i: usize| edges[(first + i) % m];
            let tangents = if local.is_corner() {
                [edge(0) - here, edge(count) - here]
            } else if self.rules.scheme == Scheme::CatmullClark {
                let face = |i: usize| faces[(first + i) % k];
                catmull_clark_side(here, count, edge, face)
            } else if local.is_closed() {
                loop_crease_side(here, count, edge)
            } else {
                loop_side(here, count as u32, edge)
            };
            found((first, count), tangents);
        }
    }

    /// Loop's tangents, with the weights of the usual valences from a table.
    fn ring(&self, around: &[u32]) -> [Vec3; 2] {
        let n = around.len() as u32;
        let table = self.weights.get(around.len());
        let mut t = [Vec3::ZERO; 2];
        for (i, &q) in around.iter().enumerate() {
            let [c, s] = table.map_or_else(|| tangent_weights(n, i as u32), |row| row[i]);
            t[0] += c * self.points[q as usize];
            t[1] += s * self.points[q as usize];
        }
        t
    }

    /// Catmull and Clark's tangents from the neighbours and opposite corners of an interior vertex of valence
    /// `n`.
    fn quads(&self, around: impl Iterator<Item = (Vec3, Vec3)>, n: usize) -> [Vec3; 2] {
        let table = self.quad_weights.get(n);
        let mut t = [Vec3::ZERO; 2];
        for (i, (e, f)) in around.enumerate() {
            let weights = table
                .map_or_else(|| catmull_clark::tangent_weights(n as u32, i as u32), |row| row[i]);
            for (t, [edge, face]) in t.iter_mut().zip(weights) {
                *t += edge * e + face * f;
            }
        }
        t
    }

    fn doo_sabin(&self, images: &DooSabinRows<'_>, v: VertexId) -> [Vec3; 2] {
        let topology = self.sharp.topology;
        let sum = |visit: &Entries<'_>| {
            let mut sum = Vec3::ZERO;
            visit(&mut |q, w| sum += w * self.points[q as usize]);
            sum
        };
        let image = |h| sum(&|mut entry| images.image(h, 1.0, &mut entry));
        let mut corners: Vec<Vec3> = topology.fan(v).map(image).collect();
        let (Some(first), Some(last)) = (topology.outgoing(v), topology.fan(v).last()) else {
            return [Vec3::ZERO; 2];
        };
        if !topology.is_boundary(v) {
            return polygon(&corners);
        }
        let in_edge = |h| sum(&|mut entry| images.edge_image(h, v, 1.0, &mut entry));
        let (start, end) = (in_edge(first), in_edge(topology.prev(last)));
        corners.insert(0, start);
        corners.push(end);
        // The side of the V-face from `end` to `start` is the boundary of the finer mesh; the next
        // step gives it images on the inside.
        let f = corners.len() as u32;
        let regular = |i: u32| -> Vec3 {
            (0..f)
                .zip(&corners)
                .map(|(j, &p)| crate::scheme::doo_sabin::image_weight(f, i.abs_diff(j)) * p)
                .sum()
        };
        let inner = 0.5 * (regular(0) + regular(f - 1));
        [start - end, inner - 0.5 * (start + end)]
    }
}

fn phase_one(topology: &Topology, points: &[Vec3], rules: &Rules) -> Option<Vec<Vec3>> {
    PhaseOne::new(topology, rules).map(|rows| rows::apply(&rows, points))
}

/// Tangents at the centroid of a polygon that shrinks by Doo and Sabin's rule.
fn polygon(corners: &[Vec3]) -> [Vec3; 2] {
    let n = corners.len() as f64;
    let mut t = [Vec3::ZERO; 2];
    for (j, &p) in corners.iter().enumerate() {
        let angle = 2.0 * PI * j as f64 / n;
        t[0] += cos(angle) * p;
        t[1] += sin(angle) * p;
    }
    t
}

/// Loop's tangents from the ring of an interior vertex.
fn ring(points: impl Iterator<Item = Vec3>, n: u32) -> [Vec3; 2] {
    let mut t = [Vec3::ZERO; 2];
    for (i, q) in points.enumerate() {
        let [c, s] = tangent_weights(n, i as u32);
        t[0] += c * q;
        t[1] += s * q;
    }
    t
}

/// Loop's inward tangents at a boundary vertex with `k` faces.
fn loop_side(here: Vec3, k: u32, edge: impl Fn(usize) -> Vec3) -> [Vec3; 2] {
    let mut across = inward_tangent_centre_weight(k) * here;
    for i in 0..=k {
        across += inward_tangent_weight(k, i) * edge(i as usize);
    }
    [edge(0) - edge(k as usize), across]
}

/// Loop's tangents on one side of a crease through a vertex with `k` faces on that side. Other than on
/// the boundary, the points on a crease are midpoints whatever the valence.
///
/// The inward one is the left eigenvector for $`\lambda = 3/8 + \cos(\theta)/4`$,
/// $`\theta = \pi/k`$, which has $`\sin i\theta`$ at inner neighbours.
fn loop_crease_side(here: Vec3, k: usize, edge: impl Fn(usize) -> Vec3) -> [Vec3; 2] {
    let along = edge(0) - edge(k);
    if k == 1 {
        return [along, 0.5 * (edge(0) + edge(1)) - here];
    }
    let theta = PI / k as f64;
    let eigenvalue = 0.375 + 0.25 * cos(theta);
    let s = |i: usize| sin(i as f64 * theta);
    let sum: f64 = (1..k).map(s).sum();
    let [own, end] = curve_weights(eigenvalue, 0.375 * sum, 0.125 * s(1));
    let inner: Vec3 = (1..k).map(|i| s(i) * edge(i)).sum();
    [along, own * here + end * (edge(0) + edge(k)) + inner]
}

/// The weights of a vertex on a cubic B-spline and of each neighbour there, in a left eigenvector
/// that draws so much from them for other points.
fn curve_weights(eigenvalue: f64, own: f64, end: f64) -> [f64; 2] {
    let whole = (eigenvalue - 1.0) * (eigenvalue - 0.25);
    [((eigenvalue - 0.5) * own + end) / whole, ((eigenvalue - 0.75) * end + 0.125 * own) / whole]
}

/// Catmull–Clark tangents on one side of a curve through a vertex with `k` faces on that side.
///
/// The inward one is the left eigenvector for
/// $`16\lambda = 5 + c + \sqrt{(c + 1)(c + 9)}`$, $`c = \cos\theta`$, $`\theta = \pi/k`$, which has
/// $`(16\lambda - 4) \sin i\theta`$ at inner neighbours and
/// $`\sin i\theta + \sin (i+1)\theta`$ at opposite corners.
fn catmull_clark_side(
    here: Vec3,
    k: usize,
    edge: impl Fn(usize) -> Vec3,
    face: impl Fn(usize) -> Vec3,
) -> [Vec3; 2] {
    let along = edge(0) - edge(k);
    if k == 1 {
        return [along, 0.5 * (edge(0) + edge(1)) - here];
    }
    let theta = PI / k as f64;
    let c = cos(theta);
    let eigenvalue = (5.0 + c + libm::sqrt((c + 1.0) * (c + 9.0))) / 16.0;
    let s = |i: usize| sin(i as f64 * theta);
    let sum: f64 = (1..k).map(s).sum();
    let [own, end] = curve_weights(eigenvalue, (6.0 * eigenvalue - 1.0) * sum, eigenvalue * s(1));
    let mut across = own * here + end * (edge(0) + edge(k));
    for i in 0..k {
        across += (16.0 * eigenvalue - 4.0) * s(i) * edge(i) + (s(i) + s(i + 1)) * face(i);
    }
    [along, across]
}
