//! [`Rest`]: the few faces that are refined step by step, since too much meets at a corner or their
//! surroundings are like no others.

use alloc::vec::Vec;

use super::classes::Task;
use super::grid::Grid;
use super::{Points, Steps};
use crate::error::Error;
use crate::evaluate::Gatherer;
use crate::ids::HalfedgeId;
use crate::{Vec3, limit};

/// Faces that are refined step by step, with what lies around them.
#[derive(Clone, Debug)]
pub(super) struct Rest {
    /// The faces, in order, and the vertices of them and what lies around.
    faces: Vec<u32>,
    vertices: Vec<u32>,
    steps: Steps,
}

/// Their points.
#[derive(Clone, Debug)]
pub(super) struct RestPoints {
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
}

impl RestPoints {
    /// The points that the last of some steps made.
    pub(super) fn new(
        steps: &Steps,
        values: Vec<Vec3>,
        what: Points,
        with_normals: bool,
    ) -> Result<Self, Error> {
        let (finest, rules) = (steps.topology(), steps.rules());
        let normals = match with_normals {
            true => limit::limit_normals(finest, &values, rules)?,
            // Nobody looks at them.
            false => alloc::vec![Vec3::ZERO; values.len()],
        };
        let positions = match what {
            Points::Control => values,
            Points::Limit => limit::limit_points(finest, &values, rules)?,
        };
        Ok(Self { positions, normals })
    }
}

impl Rest {
    pub(super) fn new(
        gatherer: &mut Gatherer<'_>,
        faces: Vec<u32>,
        task: Task<'_>,
    ) -> Result<Self, Error> {
        let first = faces.iter().map(|&f| HalfedgeId(f * task.grid.corners as u32));
        let found = gatherer.gather_all(first);
        let vertices = found.vertices.iter().map(|v| v.0).collect();
        let local = found.into_local(task.rules);
        let steps = Steps::new(local.topology, local.rules, task.grid.levels)?;
        Ok(Self { faces, vertices, steps })
    }

    /// The points at the finest level, and their normals if they are wanted.
    pub(super) fn apply(
        &self,
        points: &[Vec3],
        what: Points,
        with_normals: bool,
    ) -> Result<RestPoints, Error> {
        let values: Vec<Vec3> = self.vertices.iter().map(|&v| points[v as usize]).collect();
        let values = self.steps.apply(&values);
        RestPoints::new(&self.steps, values, what, with_normals)
    }

    /// For each point of the grid of a face, its number among those points.
    pub(super) fn grid(&self, face: usize, grid: &Grid) -> Vec<u32> {
        let place = self.faces.partition_point(|&f| (f as usize) < face);
        grid.vertices(self.steps.topology(), place)
    }
}
