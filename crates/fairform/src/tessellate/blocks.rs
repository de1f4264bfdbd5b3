//! What is needed to make a mesh block by block: a small base, and what its faces stand for.

use alloc::sync::Arc;
use alloc::vec::Vec;
use core::ops::Range;

use super::classes::MOST_CLASSES;
use super::{Limits, MOST_AT_ONCE, Plan, Points, Tessellation};
use crate::error::Error;
use crate::ids::FaceId;
use crate::refine::{self, check_size};
use crate::scheme::{Rules, Scheme};
use crate::{Topology, Vec3};

/// Most steps that are made at once where the base would otherwise be large.
pub const MOST_WITH_SMALL_BASE: u32 = 5;

/// Most fine faces that are made step by step where more than [`MOST_AT_ONCE`] steps are made at once: with what
/// lies around they take some hundred megabytes at worst.
const MOST_LEFT: usize = 1 << 16;

/// The level of the base of [`Tessellation::with_base`] with Loop's or Catmull and Clark's scheme, if not
/// too much of the mesh is special.
///
/// # Errors
/// As [`check_size`].
pub fn base_level(
    topology: &Topology,
    rules: &Rules,
    levels: u32,
    most_faces: u64,
) -> Result<u32, Error> {
    let mut level = first_steps(levels, MOST_AT_ONCE);
    let last = first_steps(levels, MOST_WITH_SMALL_BASE);
    while level > last && check_size(topology, rules, level)?.face_count > most_faces {
        level -= 1;
    }
    Ok(level)
}

/// Steps that are made one by one if so many may be made at once: at least one.
pub(super) fn first_steps(levels: u32, at_once: u32) -> u32 {
    levels.saturating_sub(at_once).max(levels.min(1))
}

impl Tessellation {
    /// As [`new`](Self::new), but with up to [`MOST_WITH_SMALL_BASE`] steps at once, as long as the base
    /// would have more than so many faces: its memory is 1/1024 of that of the result then. That takes
    /// a little longer, since the rows of a class no longer fit into the nearest cache.
    ///
    /// Beside the base there are then at most 400 MiB of rows, in practice a few. Where many faces would have to be refined
    /// step by step, since their surroundings are like no others, fewer steps are made at once.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_base(
        topology: &Arc<Topology>,
        rules: &Rules,
        levels: u32,
        most_faces: u64,
        points: Points,
    ) -> Result<Self, Error> {
        check_size(topology, rules, levels)?;
        let at_once = match rules.scheme {
            Scheme::Loop | Scheme::CatmullClark => {
                levels - base_level(topology, rules, levels, most_faces)?
            }
            // Their rows are not bounded as classes are.
            _ => 0,
        };
        for most in (MOST_AT_ONCE + 1..=at_once).rev() {
            let first = first_steps(levels, most);
            let left = MOST_LEFT >> (2 * most);
            let limits = Limits { at_once: most, classes: MOST_CLASSES, left };
            let made = Self::with_limits(topology, rules, first, levels, points, limits)?;
            if let Some(made) = made {
                return Ok(made);
            }
        }
        Self::new(topology, rules, levels, points)
    }

    /// For each face of the base the face of the control mesh that it is a part of, or the first of those
    /// that it lies between.
    #[must_use]
    pub fn parents(&self) -> Vec<u32> {
        let levels = &self.steps.levels;
        let mut parents: Vec<u32> = (0..levels[0].0.face_count() as u32).collect();
        for step in levels.windows(2) {
            let ((coarse, rules), (finer, _)) = (&step[0], &step[1]);
            let of = |f| parents[refine::parent(rules.scheme, coarse, finer, f).index()];
            parents = finer.faces().map(of).collect();
        }
        parents
    }

    /// For each face the face of the base that it is a part of, as
    /// [`fill_faces`](Self::fill_faces) has them.
    #[must_use]
    pub fn base_of_faces(&self) -> Vec<u32> {
        let base = self.base();
        let count = |f: usize| match &self.squares {
            Some(squares) => squares.size(base, f..f + 1)[0],
            None => self.plan.as_ref().map_or(1, |plan| plan.grid.face_count()),
        };
        let faces = 0..base.face_count();
        faces.flat_map(|f| core::iter::repeat_n(f as u32, count(f))).collect()
    }

    /// Carries one value per face corner of the control mesh over to the corners of the base, linearly
    /// within each face, as [`apply_to_corners`](refine::Refined::apply_to_corners) does.
    ///
    /// # Panics
    /// If there is not one value per corner of the control mesh.
    #[must_use]
    pub fn base_corners(&self, values: &[Vec3]) -> Option<Vec<Vec3>> {
        let levels = &self.steps.levels;
        let mut values = values.to_vec();
        for (coarse, rules) in &levels[..levels.len() - 1] {
            values = refine::apply_to_corners(rules.scheme, coarse, &values)?;
        }
        Some(values)
    }

    /// From one value per corner of the base, those of the corners of all faces that some faces of the base
    /// are cut into, linearly within each: in the order of [`fill_faces`](Self::fill_faces).
    ///
    /// # Panics
    /// If there is not one value per corner of the base, or there are no such faces.
    #[must_use]
    pub fn corners_in(&self, base_faces: Range<usize>, values: &[Vec3]) -> Vec<Vec3> {
        let base = self.base();
        assert_eq!(values.len(), base.halfedge_count(), "one value per corner of the base");
        let corners_of = |f: usize| {
            base.face_halfedges(FaceId(f as u32)).map(|h| values[h.index()]).collect::<Vec<_>>()
        };
        let Some(plan) = &self.plan else { return base_faces.flat_map(corners_of).collect() };
        let shares = plan.shares();
        let mut out = Vec::with_capacity(base_faces.len() * shares.len());
        for f in base_faces {
            let corners = corners_of(f);
            let mixed = |shares: &[f64; 4]| {
                corners.iter().zip(shares).map(|(&value, &share)| share * value).sum::<Vec3>()
            };
            out.extend(shares.iter().map(mixed));
        }
        out
    }
}

impl Plan {
    /// For each corner of each face of the grid, the shares of the corners of the face of the base.
    fn shares(&self) -> Vec<[f64; 4]> {
        let grid = &self.grid;
        let n = grid.segments();
        let mut at = alloc::vec![[0.0; 4]; grid.point_count()];
        for v in 0..=n {
            for u in 0..=if grid.corners == 3 { n - v } else { n } {
                let [x, y] = [u, v].map(|t| t as f64 / n as f64);
                at[grid.number(u, v)] = if grid.corners == 3 {
                    [1.0 - x - y, x, y, 0.0]
                } else {
                    [(1.0 - x) * (1.0 - y), x * (1.0 - y), x * y, (1.0 - x) * y]
                };
            }
        }
        grid.faces.iter().map(|&point| at[point as usize]).collect()
    }
}
