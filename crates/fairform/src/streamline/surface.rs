//! The refined and integrated model, kept so that an edit recomputes only what depends on it.

use alloc::vec::Vec;
use core::ops::Range;

use crate::sphere::{self, Step, carry};
use crate::{Faces, Mesh, Vec3, par};

use super::integrate::{point_count, streamline};
use super::{Detail, Error, Grid, Integration, MAX_POINTS, Model, Order, Rect, increasing};

/// A streamline surface: the model with its grids at every level, and points.
#[derive(Clone, Debug)]
pub struct Surface {
    model: Model,
    levels: Vec<Level>,
    points: Grid<Vec3>,
    /// Points of the initial curve, one per refined streamline.
    begin: Vec<Vec3>,
}

/// One level of refinement.
#[derive(Clone, Debug)]
struct Level {
    tangents: Grid<Vec3>,
    s: Grid<f64>,
    t: Vec<f64>,
    /// How this level came about; none for level 0.
    from: Option<From>,
}

#[derive(Clone, Debug)]
struct From {
    along: Step,
    across: Step,
    /// Refined in the first of the two directions.
    half: Grid<Vec3>,
}

/// What an edit changed, in the finest grids.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Changed {
    /// All refined tangents that are new lie in this rectangle.
    pub tangents: Rect,
    /// All points that moved lie in this one.
    pub points: Rect,
}

impl Surface {
    /// Refines and integrates a model.
    ///
    /// # Errors
    /// As [`Model::check`]; [`Error::TooLarge`] for more than [`MAX_POINTS`] points, [`Error::Sphere`]
    /// if there are too few tangents for the scheme; [`Error::NotIncreasing`] if refinement breaks the
    /// order of very uneven parameters; [`Error::BadDetail`].
    pub fn new(mut model: Model) -> Result<Self, Error> {
        model.check()?;
        sphere::unit(model.tangents.values_mut())
            .map_err(|error| Error::Sphere { field: "tangents", error })?;
        let steps = steps(&model)?;
        let mut levels = alloc::vec![Level {
            tangents: model.tangents.clone(),
            s: model.s.clone(),
            t: model.t.clone(),
            from: None,
        }];
        for (level, [across, along]) in (1..).zip(steps) {
            let size = [across.refined_count(), along.refined_count()];
            let coarse = &levels[levels.len() - 1];
            let half = match model.order {
                Order::St => [coarse.tangents.row_count(), size[1]],
                Order::Ts => [size[0], coarse.tangents.column_count()],
            };
            let s = refined_numbers(&coarse.s, &along, &across);
            let t = across.numbers(&coarse.t);
            check_order(&s, &t, level)?;
            levels.push(Level {
                tangents: Grid::filled(size[0], size[1], Vec3::ZERO),
                s,
                t,
                from: Some(From {
                    along,
                    across,
                    half: Grid::filled(half[0], half[1], Vec3::ZERO),
                }),
            });
        }
        let mut surface = Self { model, levels, points: Grid::default(), begin: Vec::new() };
        surface.check_details()?;
        let whole = surface.whole(0);
        surface.refine(0, &whole);
        surface.set_lengths()?;
        surface.begin = surface.model.initial.points(surface.t())?;
        let (rows, columns) = (surface.tangents().row_count(), surface.tangents().column_count());
        let columns = point_count(surface.model.integration, columns);
        surface.points = Grid::filled(rows, columns, Vec3::ZERO);
        surface.integrate(&(0..rows));
        Ok(surface)
    }

    /// The model as it is now.
    #[must_use]
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Back to the model alone.
    #[must_use]
    pub fn into_model(self) -> Model {
        self.model
    }

    fn finest(&self) -> &Level {
        &self.levels[self.levels.len() - 1]
    }

    /// The refined tangents.
    #[must_use]
    pub fn tangents(&self) -> &Grid<Vec3> {
        &self.finest().tangents
    }

    /// The tangents at a level of refinement, from 0.
    ///
    /// # Panics
    /// If the level is beyond the depth.
    #[must_use]
    pub fn tangents_at(&self, level: u32) -> &Grid<Vec3> {
        &self.levels[level as usize].tangents
    }

    /// The refined arc-length parameters.
    #[must_use]
    pub fn s(&self) -> &Grid<f64> {
        &self.finest().s
    }

    /// The refined parameters of the streamlines.
    #[must_use]
    pub fn t(&self) -> &[f64] {
        &self.finest().t
    }

    /// The points, a row for each streamline.
    #[must_use]
    pub fn points(&self) -> &Grid<Vec3> {
        &self.points
    }

    /// Length of a refined streamline.
    ///
    /// # Panics
    /// If there is no such row.
    #[must_use]
    pub fn length(&self, row: usize) -> f64 {
        let s = self.s().row(row);
        s[s.len() - 1] - s[0]
    }

    /// Sets a tangent at a level of refinement; at levels above 0 it is kept as a [`Detail`], which
    /// goes with later changes of coarser tangents. Recomputes what depends on it, to the same bits
    /// as anew.
    ///
    /// # Errors
    /// [`Error::NoSuchPlace`]; [`Error::NotUnit`]. Nothing is changed then.
    pub fn set_tangent(
        &mut self,
        level: u32,
        row: usize,
        column: usize,
        tangent: Vec3,
    ) -> Result<Changed, Error> {
        self.set_tangents(level, &[(row, column, tangent)])
    }

    /// Sets several tangents of one level at once.
    ///
    /// # Errors
    /// As [`set_tangent`](Self::set_tangent).
    pub fn set_tangents(
        &mut self,
        level: u32,
        edits: &[(usize, usize, Vec3)],
    ) -> Result<Changed, Error> {
        let mut rect = Rect::default();
        for &(row, column, tangent) in edits {
            let grid = self.levels.get(level as usize).map(|l| &l.tangents);
            let size = grid.map_or([0, 0], |g| [g.row_count(), g.column_count()]);
            if row >= size[0] || column >= size[1] {
                return Err(Error::NoSuchPlace { level, row, column });
            }
            let length = tangent.length();
            if !sphere::is_unit(length) {
                return Err(Error::NotUnit { row, column, length });
            }
            rect = rect.union(&Rect::single(row, column));
        }
        for &(row, column, tangent) in edits {
            let tangent =
                if (tangent.length() - 1.0).abs() > 1e-15 { tangent.normalized() } else { tangent };
            self.levels[level as usize].tangents[(row, column)] = tangent;
            if level == 0 {
                self.model.tangents[(row, column)] = tangent;
                continue;
            }
            let predicted = self.predicted(level, row, column);
            let detail = Detail { level, row, column, predicted, tangent };
            let same = |d: &Detail| (d.level, d.row, d.column) == (level, row, column);
            match self.model.details.iter_mut().find(|d| same(d)) {
                Some(old) => *old = detail,
                None => self.model.details.push(detail),
            }
        }
        Ok(self.update(level, &rect))
    }

    /// Takes back what was set at a level above 0.
    ///
    /// # Errors
    /// [`Error::NoSuchPlace`] if nothing was set there.
    pub fn remove_detail(
        &mut self,
        level: u32,
        row: usize,
        column: usize,
    ) -> Result<Changed, Error> {
        let same = |d: &Detail| (d.level, d.row, d.column) == (level, row, column);
        let index = self.model.details.iter().position(same);
        let index = index.ok_or(Error::NoSuchPlace { level, row, column })?;
        self.model.details.remove(index);
        self.levels[level as usize].tangents[(row, column)] = self.predicted(level, row, column);
        Ok(self.update(level, &Rect::single(row, column)))
    }

    /// What refinement alone gives at a place of a level above 0.
    fn predicted(&self, level: u32, row: usize, column: usize) -> Vec3 {
        let level = &self.levels[level as usize];
        let from = level.from.as_ref().expect("a refined level");
        let (half, blend) = (&from.half, self.model.blend);
        let mut made = Vec3::ZERO;
        match self.model.order {
            Order::St => {
                let put = |_, t| made = t;
                from.across.run(blend, |k| half[(k, column)], row..row + 1, put);
            }
            Order::Ts => {
                let put = |_, t| made = t;
                from.along.run(blend, |i| half[(row, i)], column..column + 1, put);
            }
        }
        made
    }

    /// Moves the initial curve or the place where it lies.
    ///
    /// # Errors
    /// As for models with such a curve. Nothing is changed then.
    pub fn set_initial(
        &mut self,
        initial: super::InitialCurve,
        start: super::Start,
    ) -> Result<Changed, Error> {
        let model = Model { initial, start, ..self.model.clone() };
        model.check()?;
        self.begin = model.initial.points(self.t())?;
        self.model = model;
        let rows = 0..self.points.row_count();
        Ok(Changed { tangents: Rect::default(), points: self.integrate(&rows) })
    }

    /// Carries a change of a rectangle of a level to the finest grids.
    fn update(&mut self, level: u32, rect: &Rect) -> Changed {
        let tangents = self.refine(level, rect);
        let points = self.integrate(&tangents.rows);
        Changed { tangents, points }
    }

    fn whole(&self, level: usize) -> Rect {
        let grid = &self.levels[level].tangents;
        Rect { rows: 0..grid.row_count(), columns: 0..grid.column_count() }
    }

    /// Makes anew, at all finer levels, what depends on a rectangle; returns what it is at the finest.
    fn refine(&mut self, level: u32, rect: &Rect) -> Rect {
        let mut rect = rect.clone();
        for fine in level as usize + 1..self.levels.len() {
            let (coarser, finer) = self.levels.split_at_mut(fine);
            let (coarse, level) = (&coarser[fine - 1], &mut finer[0]);
            let from = level.from.as_mut().expect("a refined level");
            let new = Rect {
                rows: from.across.affected(rect.rows.clone()),
                columns: from.along.affected(rect.columns.clone()),
            };
            let blend = self.model.blend;
            let (along, across) = (&from.along, &from.across);
            match self.model.order {
                Order::St => {
                    let half = Rect { rows: rect.rows, columns: new.columns.clone() };
                    refine_along(along, blend, &coarse.tangents, &mut from.half, &half);
                    refine_across(across, blend, &from.half, &mut level.tangents, &new);
                }
                Order::Ts => {
                    let half = Rect { rows: new.rows.clone(), columns: rect.columns };
                    refine_across(across, blend, &coarse.tangents, &mut from.half, &half);
                    refine_along(along, blend, &from.half, &mut level.tangents, &new);
                }
            }
            let here = |d: &&Detail| d.level as usize == fine && new.contains(d.row, d.column);
            for detail in self.model.details.iter().filter(here) {
                let tangent = &mut level.tangents[(detail.row, detail.column)];
                *tangent = carry(detail.predicted, *tangent, detail.tangent);
            }
            rect = new;
        }
        rect
    }

    fn check_details(&mut self) -> Result<(), Error> {
        for (index, detail) in self.model.details.iter_mut().enumerate() {
            let bad = |what| Err(Error::BadDetail { index, what });
            for direction in [&mut detail.predicted, &mut detail.tangent] {
                if sphere::unit(core::slice::from_mut(direction)).is_err() {
                    return bad("has a tangent whose length is not 1");
                }
            }
            // Details of levels beyond the depth wait until it is reached.
            if detail.level == 0 {
                return bad("has level 0; tangents of level 0 are those of the model");
            }
            if let Some(level) = self.levels.get(detail.level as usize) {
                let grid = &level.tangents;
                if detail.row >= grid.row_count() || detail.column >= grid.column_count() {
                    return bad("is outside the grid of its level");
                }
            }
        }
        Ok(())
    }

    /// Stretches the finest parameters to the lengths that the model asks for.
    fn set_lengths(&mut self) -> Result<(), Error> {
        let Some(length) = &self.model.length else { return Ok(()) };
        let lengths = length.lengths(self.t())?;
        let last = self.levels.len() - 1;
        let grid = &mut self.levels[last].s;
        for (row, length) in lengths.into_iter().enumerate() {
            let s = grid.row_mut(row);
            let (first, end) = (s[0], s[s.len() - 1]);
            if end > first {
                let share = length / (end - first);
                s.iter_mut().for_each(|s| *s = first + (*s - first) * share);
            }
        }
        Ok(())
    }

    /// Integrates some streamlines anew; the rectangle in which points moved.
    fn integrate(&mut self, rows: &Range<usize>) -> Rect {
        let finest = &self.levels[self.levels.len() - 1];
        let columns = self.points.column_count();
        let (model, begin) = (&self.model, &self.begin);
        let parts = row_parts(&mut self.points, rows);
        let moved = par::map_parts(parts, |(first, block): (usize, &mut [Vec3])| {
            let mut new = alloc::vec![Vec3::ZERO; columns];
            let mut moved = Rect::default();
            for (row, old) in (first..).zip(block.chunks_exact_mut(columns)) {
                let (tangents, s) = (finest.tangents.row(row), finest.s.row(row));
                streamline(model.integration, tangents, s, model.start, begin[row], &mut new);
                let differs = |i: &usize| old[*i] != new[*i];
                if let Some(start) = (0..columns).find(differs) {
                    let end = (0..columns).rev().find(differs).map_or(columns, |i| i + 1);
                    moved = moved.union(&Rect { rows: row..row + 1, columns: start..end });
                    old.copy_from_slice(&new);
                }
            }
            moved
        });
        moved.iter().fold(Rect::default(), |all, one| all.union(one))
    }

    /// The surface as a mesh of quadrilaterals: vertices row by row, faces
    /// $`(k,i), (k,i+1), (k+1,i+1), (k+1,i)`$.
    ///
    /// # Errors
    /// [`crate::Error::TooLarge`]; [`crate::Error::NotManifold`] if coordinates overflowed.
    pub fn mesh(&self) -> Result<Mesh, crate::Error> {
        Mesh::new(self.points.values().to_vec(), &self.faces())
    }

    /// The faces of [`mesh`](Self::mesh).
    #[must_use]
    pub fn faces(&self) -> Faces {
        let (rows, columns) = (self.points.row_count(), self.points.column_count());
        let (cells, across) = (columns.saturating_sub(1), rows.saturating_sub(1));
        let mut corners = Vec::with_capacity(4 * cells * across);
        for k in 0..across {
            for i in 0..cells {
                let at = |k: usize, i: usize| (k * columns + i) as u32;
                corners.extend([at(k, i), at(k, i + 1), at(k + 1, i + 1), at(k + 1, i)]);
            }
        }
        Faces::uniform(4, corners)
    }

    /// Parameters $`(s, t)`$ of the points.
    #[must_use]
    pub fn parameters(&self) -> Grid<[f64; 2]> {
        let rows = self.s().rows().zip(self.t());
        let of_row = |(s, &t): (&[f64], &f64)| -> Vec<[f64; 2]> {
            match self.model.integration {
                Integration::Arcs => s.iter().map(|&s| [s, t]).collect(),
                Integration::Midpoint => {
                    let inner = s.windows(2).map(|s| 0.5 * (s[0] + s[1]));
                    let ends = [s[0], s[s.len() - 1]];
                    let all = core::iter::once(ends[0]).chain(inner).chain([ends[1]]);
                    all.map(|s| [s, t]).collect()
                }
            }
        };
        Grid::collected(rows.map(of_row))
    }
}

/// The steps across and along the streamlines, from the coarsest on; nothing large is made before
/// all of them are known to fit.
fn steps(model: &Model) -> Result<Vec<[Step; 2]>, Error> {
    let rule = model.rule()?;
    let step = |count: usize| {
        Step::new(rule, model.ends, count)
            .map_err(|error| Error::Sphere { field: "tangents", error })
    };
    let mut size = [model.tangents.row_count(), model.tangents.column_count()];
    let mut steps = Vec::new();
    for _ in 0..model.depth {
        let [across, along] = [step(size[0])?, step(size[1])?];
        size = [across.refined_count(), along.refined_count()];
        if size[0] as u64 * size[1] as u64 > MAX_POINTS {
            return Err(Error::TooLarge { depth: model.depth });
        }
        steps.push([across, along]);
    }
    Ok(steps)
}

/// Refines each row of a rectangle of `fine` from the same row of `coarse`.
fn refine_along(
    step: &Step,
    blend: sphere::Blend,
    coarse: &Grid<Vec3>,
    fine: &mut Grid<Vec3>,
    rect: &Rect,
) {
    let columns = fine.column_count();
    par::in_parts(row_parts(fine, &rect.rows), |(first, block)| {
        for (row, out) in (first..).zip(block.chunks_exact_mut(columns)) {
            let from = coarse.row(row);
            step.run(blend, |i| from[i], rect.columns.clone(), |j, t| out[j] = t);
        }
    });
}

/// Refines each column of a rectangle of `fine` from the same column of `coarse`.
fn refine_across(
    step: &Step,
    blend: sphere::Blend,
    coarse: &Grid<Vec3>,
    fine: &mut Grid<Vec3>,
    rect: &Rect,
) {
    let columns = fine.column_count();
    par::in_parts(row_parts(fine, &rect.rows), |(first, block)| {
        let rows = first..first + block.len() / columns;
        for i in rect.columns.clone() {
            let put = |j: usize, t| block[(j - first) * columns + i] = t;
            step.run(blend, |k| coarse[(k, i)], rows.clone(), put);
        }
    });
}

/// Rows cut into a few parts, each with the number of its first row; one part if they are few.
fn row_parts<'g, T>(grid: &'g mut Grid<T>, rows: &Range<usize>) -> Vec<(usize, &'g mut [T])> {
    const FEW: usize = 1 << 14;
    let (columns, first) = (grid.column_count(), rows.start);
    let block = &mut grid.values_mut()[rows.start * columns..rows.end * columns];
    let rows = rows.len();
    let parts = if block.len() < FEW { 1 } else { par::part_count() };
    let each = rows.div_ceil(parts).max(1);
    let chunks = block.chunks_mut((each * columns).max(1)).enumerate();
    chunks.map(|(i, chunk)| (first + i * each, chunk)).collect()
}

fn refined_numbers(coarse: &Grid<f64>, along: &Step, across: &Step) -> Grid<f64> {
    let half = coarse.rows().map(|row| along.numbers(row));
    let half = Grid::collected(half);
    let columns = half.column_count();
    let mut fine = Grid::filled(across.refined_count(), columns, 0.0);
    for row in 0..fine.row_count() {
        let terms = across.terms(row);
        let out = fine.row_mut(row);
        for (&k, &w) in terms.sources().iter().zip(terms.weights()) {
            out.iter_mut().zip(half.row(k)).for_each(|(out, s)| *out += w * s);
        }
    }
    fine
}

fn check_order(s: &Grid<f64>, t: &[f64], level: u32) -> Result<(), Error> {
    for (row, s) in s.rows().enumerate() {
        increasing(s).map_err(|column| Error::NotIncreasing { level, row, column })?;
    }
    increasing(t).map_err(|index| Error::TNotIncreasing { index })
}
