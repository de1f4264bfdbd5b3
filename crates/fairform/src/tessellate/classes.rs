//! [`Classes`]: faces whose surroundings look alike share their rows.

use alloc::collections::BTreeMap;
use alloc::vec::Vec;

use super::grid::Grid;
use super::kernel::{Form, PointRows};
use super::{Limits, Points, Steps};
use crate::error::Error;
use crate::evaluate::Neighbourhood;
use crate::ids::VertexId;
use crate::scheme::Rules;
use crate::{Faces, Topology, Vec3, limit};

/// Most classes. Meshes have some tens; the faces of others are refined step by step.
pub(super) const MOST_CLASSES: usize = 1024;

/// Most weights of all classes together, so that memory is bounded whatever turns up.
pub(super) const MOST_WEIGHTS: usize = 1 << 21;
/// The same with [large](Grid::is_large) grids: 128 MiB.
const MOST_LARGE_WEIGHTS: usize = 1 << 24;

/// Most values that a class may depend on: products with larger matrices are no gain.
pub(super) const MOST_SOURCES: usize = 96;

/// The rows of all faces that look alike.
#[derive(Clone, Debug)]
pub(super) struct Class {
    pub(super) source_count: usize,
    points: Vec<PointRows>,
    /// Of each corner.
    pub(super) corners: Vec<Form>,
    /// Of the points on some sides, by the sides as bits; and of those and the inner points.
    pub(super) sides: Vec<Form>,
    pub(super) whole: Vec<Form>,
}

/// All classes that have turned up.
#[derive(Clone, Debug, Default)]
pub(super) struct Classes {
    pub(super) list: Vec<Class>,
    known: BTreeMap<Vec<u32>, u32>,
    weight_count: usize,
}

/// How many steps are made at once, and whether to the limit.
#[derive(Clone, Copy)]
pub(super) struct Task<'a> {
    pub(super) grid: &'a Grid,
    pub(super) rules: &'a Rules,
    pub(super) points: Points,
    pub(super) limits: Limits,
}

impl Classes {
    /// The class of a face with inner corners of such valences and nothing sharp; its sources are the
    /// corners and then those around them, in the order of [`sources`](super::cells). `None` if it is not
    /// to have one.
    pub(super) fn plain(&mut self, valences: &[u32], task: Task<'_>) -> Result<Option<u32>, Error> {
        let key: Vec<u32> = valences.to_vec();
        self.find(
            key,
            |_| {
                let (faces, vertex_count) = disc(valences);
                let rules = Rules { tension: None, creases: None, ..task.rules.clone() };
                Ok((Topology::from_faces(vertex_count, &faces)?, rules, vertex_count))
            },
            task,
        )
    }

    /// The class of any face, by its neighbourhood.
    pub(super) fn of(
        &mut self,
        found: Neighbourhood,
        task: Task<'_>,
    ) -> Result<Option<u32>, Error> {
        if found.value_count > MOST_SOURCES {
            return Ok(None);
        }
        self.find(
            found.key(),
            |rules| {
                let local = found.into_local(rules);
                Ok((local.topology, local.rules, local.value_count))
            },
            task,
        )
    }

    fn find(
        &mut self,
        key: Vec<u32>,
        local: impl FnOnce(&Rules) -> Result<(Topology, Rules, usize), Error>,
        task: Task<'_>,
    ) -> Result<Option<u32>, Error> {
        if let Some(&class) = self.known.get(&key) {
            return Ok(Some(class));
        }
        let most = if task.grid.is_large() { MOST_LARGE_WEIGHTS } else { MOST_WEIGHTS };
        if self.list.len() == task.limits.classes || self.weight_count >= most {
            return Ok(None);
        }
        let (topology, rules, source_count) = local(task.rules)?;
        let class = self.list.len() as u32;
        self.list.push(Class::new(topology, rules, source_count, task)?);
        self.known.insert(key, class);
        self.weight_count += 3 * source_count * task.grid.point_count();
        Ok(Some(class))
    }

    /// Makes the forms for those sides that faces have, as bits of bits.
    pub(super) fn finish(&mut self, used: &[u32], grid: &Grid) {
        self.known.clear();
        for (class, used) in self.list.iter_mut().zip(used) {
            class.finish(*used, grid);
        }
    }
}

impl Class {
    /// The rows of the first face of a mesh, from its first vertices.
    fn new(
        topology: Topology,
        rules: Rules,
        source_count: usize,
        task: Task<'_>,
    ) -> Result<Self, Error> {
        let steps = Steps::new(topology, rules, task.grid.levels)?;
        let vertices = task.grid.vertices(steps.topology(), 0);
        let points = point_rows(&steps, &vertices, source_count, task.points)?;
        let (corners, sides, whole) = (Vec::new(), Vec::new(), Vec::new());
        Ok(Self { source_count, points, corners, sides, whole })
    }

    fn finish(&mut self, used: u32, grid: &Grid) {
        let points = core::mem::take(&mut self.points);
        let corners = points[..grid.corners].iter();
        self.corners =
            corners.map(|p| Form::new(&core::iter::once(p), self.source_count)).collect();
        let make = |sides: usize, inner: &[PointRows]| {
            let of_side = |i| &points[grid.first_of_side(i)..][..grid.side];
            let on_sides = (0..grid.corners).filter(|i| sides >> i & 1 > 0).flat_map(of_side);
            Form::new(&on_sides.chain(inner), self.source_count)
        };
        let all = 0..1 << grid.corners;
        let is_used = |&sides: &usize| used >> sides & 1 > 0;
        let inner = &points[grid.first_inner()..];
        let or_empty = |sides: usize, inner: &[PointRows], needed: bool| {
            if needed { make(sides, inner) } else { Form::default() }
        };
        self.sides = all.clone().map(|s| or_empty(s, &[], is_used(&s))).collect();
        // Without sides too, for when those are asked for alone.
        let is_whole = |s: usize| s == 0 || is_used(&s) && !grid.is_large();
        self.whole = all.map(|s| or_empty(s, inner, is_whole(s))).collect();
    }
}

/// The rows of some vertices at the finest level, from the first vertices of the coarsest: by the rules for
/// any mesh, from one, three values at a time.
pub(super) fn point_rows(
    steps: &Steps,
    vertices: &[u32],
    source_count: usize,
    what: Points,
) -> Result<Vec<PointRows>, Error> {
    let (finest, next) = (steps.topology(), steps.rules());
    let ids: Vec<VertexId> = vertices.iter().map(|&v| VertexId(v)).collect();
    let mut points = alloc::vec![PointRows::default(); vertices.len()];
    for first in (0..source_count).step_by(3) {
        let count = (source_count - first).min(3);
        let mut values = alloc::vec![Vec3::ZERO; steps.first().vertex_count()];
        for (i, unit) in
            [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)].into_iter().take(count).enumerate()
        {
            values[first + i] = Vec3::new(unit.0, unit.1, unit.2);
        }
        let values = steps.apply(&values);
        let push = |row: &mut Vec<f64>, p: Vec3| row.extend(&[p.x, p.y, p.z][..count]);
        let places = match what {
            Points::Control => values.clone(),
            Points::Limit => limit::limit_points(finest, &values, next)?,
        };
        let tangents = limit::vertex_tangents(finest, &values, next, &ids)?;
        for ((point, &v), sides) in points.iter_mut().zip(vertices).zip(tangents) {
            push(&mut point.position, places[v as usize]);
            point.sides.resize_with(sides.len(), Default::default);
            for (rows, tangents) in point.sides.iter_mut().zip(sides) {
                rows.iter_mut().zip(tangents).for_each(|(row, t)| push(row, t));
            }
        }
    }
    Ok(points)
}

/// A face whose corners have such valences, and the faces around it: a disc, whose vertices are the
/// corners and then those around, beginning beyond the first side.
fn disc(valences: &[u32]) -> (Faces, usize) {
    let k = valences.len();
    let (per_step, own) = if k == 3 { (1, 0) } else { (2, 1) };
    let part = |c: usize| (valences[c % k] as usize - 3) * per_step + own;
    let ring: usize = (0..k).map(part).sum();
    let outer = |i: usize| (k + (i + ring) % ring) as u32;
    let mut faces = Faces::new();
    let corners: Vec<u32> = (0..k as u32).collect();
    faces.push(&corners);
    let mut start = 0;
    for i in 0..k {
        let (before, c) = (i as u32, ((i + 1) % k) as u32);
        if k == 3 {
            faces.push(&[c, before, outer(start)]);
        } else {
            faces.push(&[c, before, outer(start + ring - 1), outer(start)]);
        }
        for j in 0..valences[c as usize] as usize - 3 {
            let at = start + per_step * j;
            if k == 3 {
                faces.push(&[c, outer(at), outer(at + 1)]);
            } else {
                faces.push(&[c, outer(at), outer(at + 1), outer(at + 2)]);
            }
        }
        start += part(c as usize);
    }
    (faces, k + ring)
}
