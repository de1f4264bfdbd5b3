//! [`Graph`]: how the limit surface over a face is made of regular patches.
//!
//! A neighbourhood that is not regular is refined once, by the rules for any mesh, and the parts of
//! the face are looked at in the same way. Only finitely many neighbourhoods turn up, since the parts
//! at an extraordinary corner soon look like the whole. So this is a finite graph, and evaluation a
//! walk in it: a product with a small matrix at each step, until the point lies in a regular patch.
//! The steps at an extraordinary corner are the powers in \[Stam1998\].

use alloc::boxed::Box;
use alloc::collections::BTreeMap;
use alloc::vec::Vec;

use libm::{cos, sin};

use super::Sample;
use super::basis::{self, Jet};
use super::map::{self, Map};
use super::neighbourhood::{Gatherer, Local, Neighbourhood};
use super::patch;
use crate::error::Error;
use crate::ids::HalfedgeId;
use crate::refine::refine;
use crate::scheme::{Rules, Scheme};
use crate::{Stencils, Topology, Vec3, limit};

/// Steps towards an extraordinary point after which a point counts as the extraordinary point. By
/// then the two are nearer than any rounding, since a step shrinks the mesh to 2/3 or less.
const MOST_STEPS: usize = 250;

/// All neighbourhoods that have turned up.
#[derive(Clone, Debug, Default)]
pub(crate) struct Graph {
    pub(crate) nodes: Vec<Node>,
    known: BTreeMap<Vec<u32>, u32>,
}

#[derive(Clone, Debug)]
pub(crate) enum Node {
    /// The points of a polynomial patch, and whether Doo and Sabin's boundary is at `v = 0`.
    Patch(Stencils, bool),
    Split(Box<Split>),
}

/// A face that falls into four parts; the first may look like the whole.
#[derive(Clone, Debug)]
pub(crate) struct Split {
    pub(crate) parts: [Part; 4],
    maps: &'static [Map; 4],
    pub(crate) corner: Option<Corner>,
}

#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) node: u32,
    /// The values of the part from those of the whole.
    pub(crate) rows: Stencils,
}

/// The extraordinary point that the first parts shrink to.
#[derive(Clone, Debug)]
pub(crate) struct Corner {
    /// The weights of the values in its limit point.
    pub(crate) limit: Vec<f64>,
    pub(crate) topology: Topology,
    pub(crate) rules: Rules,
}

impl Graph {
    /// The node of a neighbourhood.
    pub(super) fn node(&mut self, found: Neighbourhood, rules: &Rules) -> Result<u32, Error> {
        let mut pending = Vec::new();
        let node = self.number(found, rules, &mut pending);
        while let Some((number, local)) = pending.pop() {
            self.nodes[number as usize] = self.build(number, local, &mut pending)?;
        }
        Ok(node)
    }

    fn number(
        &mut self,
        found: Neighbourhood,
        rules: &Rules,
        pending: &mut Vec<(u32, Local)>,
    ) -> u32 {
        let key = found.key();
        if let Some(&node) = self.known.get(&key) {
            return node;
        }
        let node = self.nodes.len() as u32;
        self.known.insert(key, node);
        // A place to be filled.
        self.nodes.push(Node::Patch(patch::stencils(0, core::iter::empty()), false));
        pending.push((node, found.into_local(rules)));
        node
    }

    fn build(
        &mut self,
        number: u32,
        local: Local,
        pending: &mut Vec<(u32, Local)>,
    ) -> Result<Node, Error> {
        if let Some(points) = patch::regular(&local) {
            let is_strip = local.rules.scheme == Scheme::DooSabin
                && local.topology.is_boundary(crate::VertexId(0));
            return Ok(Node::Patch(points, is_strip));
        }
        let step = refine(&local.topology, &local.rules)?;
        let rows = step.stencils();
        let (starts, maps) = parts(&local, &step.topology);
        let mut gatherer = Gatherer::new(&step.topology, &step.next);
        let parts = starts.map(|h| {
            let found = gatherer.gather(h);
            let picked: Vec<Vec<(u32, f64)>> = found.vertices[..found.value_count]
                .iter()
                .map(|v| rows.row(v.index()).map(|(q, w)| (q.0, w)).collect())
                .collect();
            let rows = patch::stencils(local.value_count, picked.iter().map(Vec::as_slice));
            Part { node: self.number(found, &step.next, pending), rows }
        });
        let corner = (parts[0].node == number).then(|| {
            let limit = limit_row(&parts[0].rows, local.value_count);
            Corner { limit, topology: local.topology, rules: local.rules }
        });
        Ok(Node::Split(Box::new(Split { parts, maps, corner })))
    }

    /// The surface at the parameters `at` of a node, by the parameters whose derivatives are
    /// `jacobian`.
    pub(super) fn sample(
        &self,
        scheme: Scheme,
        node: u32,
        values: &mut Vec<Vec3>,
        mut at: [f64; 2],
        mut jacobian: [[f64; 2]; 2],
    ) -> Sample {
        // Relative to a point nearby, so that small differences keep their digits.
        let mut base = values.first().copied().unwrap_or_default();
        for p in values.iter_mut() {
            *p -= base;
        }
        let mut node = node as usize;
        let mut finer = Vec::with_capacity(values.len());
        let mut steps = 0;
        loop {
            let split = match &self.nodes[node] {
                Node::Patch(points, is_strip) => {
                    let jet = jet(scheme, points, values, at);
                    return patch_sample(jet, *is_strip, jacobian, base);
                }
                Node::Split(split) => split,
            };
            if let Some(corner) = &split.corner {
                let here: Vec3 = corner.limit.iter().zip(&*values).map(|(&w, &p)| w * p).sum();
                for p in values.iter_mut() {
                    *p -= here;
                }
                base += here;
                steps += 1;
                let is_there = at == if scheme == Scheme::DooSabin { [1.0; 2] } else { [0.0; 2] };
                if is_there || steps > MOST_STEPS {
                    return corner.sample(scheme, values, base);
                }
            }
            let i = match scheme {
                Scheme::Loop | Scheme::Butterfly => map::part_of_triangle(at),
                Scheme::CatmullClark | Scheme::Kobbelt => map::part_of_square(at),
                Scheme::DooSabin => map::part_of_cell(at),
            };
            let (part, map) = (&split.parts[i], &split.maps[i]);
            finer.clear();
            finer.extend((0..part.rows.row_count()).map(|row| sum(part.rows.row(row), values)));
            core::mem::swap(values, &mut finer);
            at = map.apply(at);
            jacobian = map.jacobian_after(jacobian);
            node = part.node as usize;
        }
    }
}

fn sum(row: impl Iterator<Item = (crate::VertexId, f64)>, values: &[Vec3]) -> Vec3 {
    row.map(|(q, w)| w * values[q.index()]).sum()
}

/// Where the four parts begin in the finer mesh, and how to get to them.
fn parts(local: &Local, finer: &Topology) -> ([HalfedgeId; 4], &'static [Map; 4]) {
    match local.rules.scheme {
        Scheme::Loop | Scheme::Butterfly => ([0, 3, 6, 9].map(HalfedgeId), &map::TRIANGLE),
        Scheme::CatmullClark | Scheme::Kobbelt => {
            ([0, 4, 8, 12].map(HalfedgeId), &map::QUADRILATERAL)
        }
        Scheme::DooSabin => {
            // The images of the corners at the vertex begin the image of each face.
            let topology = &local.topology;
            let v = crate::VertexId(0);
            let fan: Vec<HalfedgeId> = topology.fan(v).collect();
            if let (true, &[first, last]) = (topology.is_boundary(v), fan.as_slice()) {
                let back = topology.prev(last);
                let boundary = super::boundary(topology);
                let images = |h| super::boundary_images(topology, &boundary, h);
                let image = |v: u32| finer.outgoing(crate::VertexId(v)).unwrap_or(first);
                let ends = [image(images(back)[1]), image(images(first)[0])];
                ([first, last, ends[0], ends[1]], &map::BORDER_CELL)
            } else {
                let at = |i: usize| fan.get(i).copied().unwrap_or(HalfedgeId(0));
                ([at(0), at(1), at(2), at(3)], &map::CELL)
            }
        }
    }
}

/// The row that a matrix takes its powers to: the limit of all rows.
fn limit_row(rows: &Stencils, count: usize) -> Vec<f64> {
    const MOST: usize = 1000;
    let mut row = alloc::vec![0.0; count];
    row[0] = 1.0;
    let mut next = row.clone();
    for _ in 0..MOST {
        next.fill(0.0);
        for (i, &factor) in row.iter().enumerate().filter(|e| *e.1 != 0.0) {
            rows.row(i).for_each(|(q, w)| next[q.index()] += factor * w);
        }
        let change = row.iter().zip(&next).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        core::mem::swap(&mut row, &mut next);
        if change < 1e-18 {
            break;
        }
    }
    let sum: f64 = row.iter().sum();
    for w in &mut row {
        *w /= sum;
    }
    row
}

impl Corner {
    fn sample(&self, scheme: Scheme, values: &[Vec3], position: Vec3) -> Sample {
        let tangents = if scheme == Scheme::DooSabin {
            let face = self.topology.face_vertices(crate::FaceId(0));
            let step = 2.0 * core::f64::consts::PI / face.len() as f64;
            let mut tangents = [Vec3::ZERO; 2];
            for (i, v) in face.iter().enumerate() {
                let angle = step * i as f64;
                tangents[0] += cos(angle) * values[v.index()];
                tangents[1] += sin(angle) * values[v.index()];
            }
            tangents
        } else {
            let mut points = values.to_vec();
            points.resize(self.topology.vertex_count(), Vec3::ZERO);
            limit::side_tangents(&self.topology, &points, &self.rules, HalfedgeId(0))
        };
        Sample { position, first: None, second: None, normal: normal(tangents) }
    }
}

fn normal([a, b]: [Vec3; 2]) -> Vec3 {
    // Scaled first, so that no product of tiny or huge tangents under- or overflows.
    a.normalized().cross(b.normalized()).normalized()
}

fn jet(scheme: Scheme, points: &Stencils, values: &[Vec3], at: [f64; 2]) -> Jet<Vec3> {
    let mut jet = [Vec3::ZERO; 6];
    let add = |i: usize, weights: Jet<f64>| {
        let point = sum(points.row(i), values);
        jet.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += weight * point);
    };
    match scheme {
        Scheme::Loop | Scheme::Butterfly => basis::quartic(at, add),
        Scheme::CatmullClark | Scheme::Kobbelt => basis::bicubic(at, add),
        Scheme::DooSabin => basis::biquadratic(at, add),
    }
    jet
}

fn patch_sample(
    [p, du, dv, duu, duv, dvv]: Jet<Vec3>,
    is_strip: bool,
    jacobian: [[f64; 2]; 2],
    base: Vec3,
) -> Sample {
    let [a, b] = [0, 1].map(|j| [jacobian[0][j], jacobian[1][j]]);
    let first = |d: [f64; 2]| d[0] * du + d[1] * dv;
    let second = |d: [f64; 2], e: [f64; 2]| {
        d[0] * e[0] * duu + (d[0] * e[1] + d[1] * e[0]) * duv + d[1] * e[1] * dvv
    };
    Sample {
        position: base + p,
        first: Some([first(a), first(b)]),
        second: Some([second(a, a), second(a, b), second(b, b)]),
        // The derivative across a strip is v times the second one.
        normal: normal([du, if is_strip { dvv } else { dv }]),
    }
}
