//! Unit tangents at the vertices of a mesh, refined by the schemes whose linear parts they are.
//!
//! No direction of the mesh is preferred: the rules depend neither on the numbering nor on where a
//! face begins. On a grid they agree with tensor products to second order in the spread.

use alloc::vec::Vec;

use crate::ids::{EdgeId, FaceId, HalfedgeId, VertexId};
use crate::refine::{Refined, boundary_numbers, refine};
use crate::rules::boundary_neighbours;
use crate::scheme::doo_sabin::image_weight;
use crate::scheme::kobbelt::{corner_share, edge_weights};
use crate::scheme::{Border, Corners, Rules, Scheme};
use crate::{Topology, Vec3, par};

use super::blend::{blend, midpoint, weighted};
use super::error::Error;
use super::mean::{exp, log, mean};
use super::{Blend, combine, unit, weighted_mean};

/// How tangents on a mesh are refined.
#[derive(Clone, Debug)]
pub struct MeshOptions {
    /// Doo–Sabin, Catmull–Clark or Kobbelt, with choices at boundaries and Kobbelt's weight.
    pub rules: Rules,
    /// How several directions become one.
    pub blend: Blend,
}

impl From<Scheme> for MeshOptions {
    fn from(scheme: Scheme) -> Self {
        Self { rules: scheme.into(), blend: Blend::default() }
    }
}

/// One step: the finer topology, and the direction at each of its vertices from one per coarser
/// vertex. The vertices come in the order of [`refine()`].
///
/// # Errors
/// As [`Rules::check`]; [`crate::Error::NotForScheme`] for Loop, butterfly, creases and shape
/// parameters; [`Error::WrongCount`] and [`Error::NotUnit`] for the directions.
pub fn refine_tangents<'t>(
    topology: &'t Topology,
    tangents: &[Vec3],
    options: &'t MeshOptions,
) -> Result<(Refined<'t>, Vec<Vec3>), Error> {
    let rules = &options.rules;
    let not_for = |what| crate::Error::NotForScheme { what, scheme: rules.scheme.name() };
    if matches!(rules.scheme, Scheme::Loop | Scheme::Butterfly) {
        return Err(not_for("tangents on the sphere").into());
    }
    if rules.creases.is_some() || rules.tension.is_some() {
        return Err(not_for("creases or shape parameters of tangents").into());
    }
    let (what, expected) = ("tangents, one per vertex", topology.vertex_count());
    if tangents.len() != expected {
        return Err(Error::WrongCount { what, expected, count: tangents.len() });
    }
    let mut tangents = tangents.to_vec();
    unit(&mut tangents)?;
    let refined = refine(topology, rules)?;
    let around = Around { topology, tangents: &tangents, blend: options.blend };
    let finer = match rules.scheme {
        Scheme::DooSabin => around.doo_sabin(rules.border),
        Scheme::CatmullClark => around.catmull_clark(rules.corners),
        _ => Kobbelt { around, rules }.apply(),
    };
    Ok((refined, finer))
}

/// Parameters beside tangents, refined by the linear scheme.
///
/// # Panics
/// If there is not one pair per coarser vertex.
#[must_use]
pub fn refine_parameters(refined: &Refined<'_>, parameters: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let lifted: Vec<Vec3> = parameters.iter().map(|&[s, t]| Vec3::new(s, t, 0.0)).collect();
    refined.apply(&lifted).into_iter().map(|p| [p.x, p.y]).collect()
}

#[derive(Clone, Copy)]
struct Around<'a> {
    topology: &'a Topology,
    tangents: &'a [Vec3],
    blend: Blend,
}

impl Around<'_> {
    fn at(&self, v: VertexId) -> Vec3 {
        self.tangents[v.index()]
    }

    /// Several directions in order; the coefficients are those of a scheme and do not cancel.
    fn combine(&self, coefficients: &[f64], tangents: &[Vec3]) -> Vec3 {
        let made = match self.blend {
            Blend::Pairs => combine(coefficients, tangents),
            Blend::Mean => weighted_mean(coefficients, tangents),
        };
        made.expect("coefficients of a scheme have sum one and do not cancel")
    }

    fn doo_sabin(&self, border: Border) -> Vec<Vec3> {
        let t = self.topology;
        let mut finer = par::collect(t.halfedge_count(), |h| self.image(HalfedgeId(h as u32)));
        if border == Border::Bspline {
            let (numbers, count) = boundary_numbers(t);
            finer.reserve(2 * count as usize);
            for h in t.halfedges().filter(|h| numbers[h.index()] != crate::NONE) {
                let (a, b) = (self.at(t.origin(h)), self.at(t.target(h)));
                finer.extend([weighted(0.75, a, 0.25, b), weighted(0.75, b, 0.25, a)]);
            }
        }
        finer
    }

    /// In centred order: from the corner outward on both sides; the opposite corner of an even face
    /// comes at both ends with half its weight.
    fn image(&self, h: HalfedgeId) -> Vec3 {
        let t = self.topology;
        let count = t.face_halfedges(t.face(h)).len() as u32;
        let reach = count / 2;
        let mut at = h;
        (0..reach).for_each(|_| at = t.prev(at));
        let (mut weights, mut tangents) = (Vec::new(), Vec::new());
        for step in 0..=2 * reach {
            let distance = reach.abs_diff(step);
            let shared = count.is_multiple_of(2) && distance == reach;
            let weight = image_weight(count, distance);
            weights.push(if shared { 0.5 * weight } else { weight });
            tangents.push(self.at(t.origin(at)));
            at = t.next(at);
        }
        self.combine(&weights, &tangents)
    }

    fn catmull_clark(&self, corners: Corners) -> Vec<Vec3> {
        let t = self.topology;
        let of = |vertices: &mut dyn Iterator<Item = VertexId>| -> Vec<Vec3> {
            vertices.map(|v| self.at(v)).collect()
        };
        let centre = |list: &[Vec3]| mean(list).expect("there are some");
        let faces = par::collect(t.face_count(), |f| {
            centre(&of(&mut t.face_vertices(FaceId(f as u32)).iter().copied()))
        });
        let face = |h: HalfedgeId| faces[t.face(h).index()];
        let edges = par::collect(t.edge_count(), |e| {
            let h = t.edge_halfedge(EdgeId(e as u32));
            let ends = midpoint(self.at(t.origin(h)), self.at(t.target(h)));
            t.twin(h).map_or(ends, |twin| midpoint(ends, midpoint(face(h), face(twin))))
        });
        let vertices = par::collect(t.vertex_count(), |v| {
            let v = VertexId(v as u32);
            let own = self.at(v);
            if t.is_isolated(v) || (t.fan_size(v) == 1 && corners == Corners::Sharp) {
                return own;
            }
            if t.is_boundary(v) {
                let (before, after) = boundary_neighbours(t, v);
                let three = [self.at(before), own, self.at(after)];
                return self.combine(&[0.125, 0.75, 0.125], &three);
            }
            let n = f64::from(t.fan_size(v));
            let q = centre(&t.fan(v).map(face).collect::<Vec<_>>());
            let r = centre(&of(&mut t.ring(v)));
            self.combine(&[1.0 / n, (n - 2.0) / n, 1.0 / n], &[q, own, r])
        });
        [vertices, edges, faces].concat()
    }
}

struct Kobbelt<'a> {
    around: Around<'a>,
    rules: &'a Rules,
}

impl Kobbelt<'_> {
    fn apply(&self) -> Vec<Vec3> {
        let t = self.around.topology;
        let edges = par::collect(t.edge_count(), |e| self.edge(EdgeId(e as u32)));
        let faces = par::collect(t.face_count(), |f| self.face(FaceId(f as u32), &edges));
        [self.around.tangents, &edges, &faces].concat()
    }

    fn four(&self, tangents: [Vec3; 4]) -> Vec3 {
        let [end, wing] = edge_weights(self.rules.kobbelt_weight);
        self.around.combine(&[wing, end, end, wing], &tangents)
    }

    fn edge(&self, e: EdgeId) -> Vec3 {
        let t = self.around.topology;
        let h = t.edge_halfedge(e);
        let (a, b) = (t.origin(h), t.target(h));
        let (p, l) = (self.around.at(a), self.around.at(b));
        if let Some(twin) = t.twin(h) {
            return self.four([self.behind(h), p, l, self.behind(twin)]);
        }
        let outside = |v: VertexId, other: VertexId, from: Vec3| {
            if self.rules.corners == Corners::Sharp && t.fan_size(v) == 1 {
                blend(self.around.at(v), from, -1.0)
            } else {
                self.around.at(other)
            }
        };
        let before = outside(a, boundary_neighbours(t, a).0, l);
        self.four([before, p, l, outside(b, boundary_neighbours(t, b).1, p)])
    }

    /// The direction behind the origin of a half-edge inside the mesh, seen from its target.
    fn behind(&self, h: HalfedgeId) -> Vec3 {
        let t = self.around.topology;
        let p = t.origin(h);
        let own = self.around.at(p);
        if t.is_boundary(p) {
            return blend(own, self.around.at(t.target(h)), -1.0);
        }
        let fan: Vec<HalfedgeId> = t.fan(p).collect();
        let n = fan.len();
        let place =
            fan.iter().position(|&g| g == h).expect("a half-edge is in the fan of its origin");
        let neighbour = |j: usize| self.around.at(t.target(fan[j % n]));
        if n == 4 {
            return neighbour(place + 2);
        }
        let corner = |j: usize| self.around.at(t.target(t.next(fan[j % n])));
        let share = corner_share(self.rules.kobbelt_weight);
        let each = 4.0 / n as f64;
        let mut sum = Vec3::ZERO;
        let mut add = |weight: f64, x: Vec3| sum += weight * log(own, x);
        for j in 0..n {
            add(each, neighbour(j));
            add(-share * each, corner(j));
        }
        for j in [n - 1, n, n + 1] {
            add(-1.0, neighbour(place + j));
        }
        for j in [2 * n - 2, 2 * n - 1, 2 * n, 2 * n + 1] {
            add(share, corner(place + j));
        }
        exp(own, sum)
    }

    /// The middle of the four-point rule across the face in both directions.
    fn face(&self, f: FaceId, edges: &[Vec3]) -> Vec3 {
        let t = self.around.topology;
        let h = t.face_halfedges(f).next().expect("a face has corners");
        let across = |h: HalfedgeId| {
            let far = t.next(t.next(h));
            let (near_point, far_point) = (edges[t.edge(h).index()], edges[t.edge(far).index()]);
            let beyond = |h: HalfedgeId, own: Vec3, other: Vec3| {
                t.twin(h).map_or_else(
                    || blend(own, other, -1.0),
                    |twin| edges[t.edge(t.next(t.next(twin))).index()],
                )
            };
            self.four([
                beyond(h, near_point, far_point),
                near_point,
                far_point,
                beyond(far, far_point, near_point),
            ])
        };
        midpoint(across(h), across(t.next(h)))
    }
}
