//! Exact interpolation in one pass over memory.
//!
//! Chebyshev's recurrence is a polynomial in the limit operator, so that a control point after `m` steps
//! depends on `m` rings of vertices and no more. A *patch* of a few thousand vertices with so many *halo*
//! rings around therefore has all that it takes, and all its steps are made while it lies in a core's
//! cache; memory is read once and written once, however many steps there are. At the end the patch
//! refines its part of the mesh and pushes its vertices back to where their limit points are those
//! wanted, see [`pushback`](crate::pushback), so that the interpolation is exact up to rounding and what
//! the steps leave over concerns fairness alone.
//!
//! Corrections of the control points are iterated in `f32`, everything else is `f64`. Every value is
//! computed from its neighbours in the order of their ring, whichever patch it is in: the results are
//! the same bits for any number of threads and for any size of the patches.

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::ops::ControlFlow;

use crate::error::Error;
use crate::interpolate::{self, Interpolator, exponent, ldexp, whole_bound};
use crate::limit;
use crate::pushback::PushBack;
use crate::refine::check_size;
use crate::solve::chebyshev_steps;
use crate::{HalfedgeId, Rules, Scheme, Topology, Vec3, par, parted};

mod cut;
mod kernel;
mod lane;
mod patch;
mod special;

use cut::{Groups, Rings, Run};
use kernel::{Distances, Kernel, Scratch, Sink, Task};
use patch::{Maker, Numbers, Patch};
use special::Special;

/// How to prepare.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Options {
    /// Steps of Chebyshev's recurrence, [`usual_steps`] unless given. What they leave over is pushed back,
    /// or, on level 0, stays.
    pub steps: Option<u32>,
    /// Vertices per patch, at least 1; fewer where halos are large. The results do not depend on it.
    pub patch_size: usize,
    /// Which values are wanted.
    pub level: Level,
}

/// Where the control points of the interpolating surface live.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Level {
    /// On the vertices of the target: the limit points are as near as the steps bring them.
    Control,
    /// On the mesh refined once: the limit points are exact up to rounding.
    Finer,
}

impl Default for Options {
    fn default() -> Self {
        Self { steps: None, patch_size: PATCH_SIZE, level: Level::Finer }
    }
}

/// Steps before a push-back after which nobody sees a difference to a full solve: the energies `∫ H²` and
/// `∫ |∇H|²` of real meshes are within about a percent of those of the converged surface. Catmull and
/// Clark's limit operator is the worst conditioned of the three.
#[must_use]
pub fn usual_steps(scheme: Scheme) -> u32 {
    if scheme == Scheme::CatmullClark { 8 } else { 6 }
}

/// Vertices whose values fit into the second cache of a core, halo and all.
const PATCH_SIZE: usize = 12_288;

/// Local numbers that all patches together may have in any case, and per vertex: beyond that halos make
/// more work than they save, as around vertices with thousands of neighbours.
const COPIES: usize = 1 << 22;
const MOST_COPIES: f64 = 16.0;

/// Exponents of two up to which squares of lengths neither over- nor underflow.
const FAR: i32 = 400;

/// What a fit did.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Summary {
    /// Largest distance of the limit points of the control points from their vertices, in the units of the
    /// coordinates. On the finer level that is how far the push-back had to move a limit point.
    pub largest: f64,
    /// Their mean distance. Its last bits depend on the size of the patches.
    pub mean: f64,
}

/// A topology made ready for exact fits in one pass: as many sets of values per vertex as one likes,
/// positions, colours, frames of an animation.
///
/// ```
/// use fairform::{Rules, onepass, pushback::PushBack, shapes};
/// let target = shapes::torus(40, 60);
/// let (topology, points) = (target.topology(), target.positions());
/// let prepared = onepass::OnePass::new(topology, &Rules::LOOP, &onepass::Options::default())?;
/// let (finer, _) = prepared.fit(points)?;
/// let surface = PushBack::new(topology, &Rules::LOOP)?.limit_points(&finer);
/// assert!((surface[7] - points[7]).length() < 1e-15);
/// # Ok::<(), fairform::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct OnePass<'t> {
    topology: &'t Topology,
    level: Level,
    steps: u32,
    result_count: usize,
    engine: Engine<'t>,
}

#[derive(Clone, Debug)]
enum Engine<'t> {
    Patches(Patches),
    /// Sweeps over the whole mesh, where patches do not pay: beside vertices with very many neighbours.
    Sweeps(Box<Sweeps<'t>>),
}

#[derive(Clone, Debug)]
struct Sweeps<'t> {
    interpolator: Interpolator<'t>,
    /// On the finer level.
    pushback: Option<PushBack<'t>>,
}

#[derive(Clone, Debug)]
struct Patches {
    kernel: Kernel,
    list: Vec<Patch>,
    /// Which patches the results come from, in their order.
    runs: Vec<Run>,
    /// How many runs each patch has.
    run_count: Vec<u32>,
}

impl<'t> OnePass<'t> {
    /// Prepares a topology: cuts it into patches with halos.
    ///
    /// # Errors
    /// As [`Interpolator::new`] and, on the finer level, [`PushBack::new`].
    ///
    /// # Panics
    /// If the patch size is zero.
    pub fn new(topology: &'t Topology, rules: &'t Rules, options: &Options) -> Result<Self, Error> {
        Self::prepare(topology, rules, options, None)
    }

    /// As [`new`](Self::new), with patches cut as `positions` lie in space, which takes a fraction of the
    /// time. The results are the same.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    ///
    /// # Panics
    /// As [`new`](Self::new); if there is not one position per vertex.
    pub fn near(
        topology: &'t Topology,
        rules: &'t Rules,
        options: &Options,
        positions: &[Vec3],
    ) -> Result<Self, Error> {
        assert_eq!(positions.len(), topology.vertex_count(), "one position per vertex");
        Self::prepare(topology, rules, options, Some(positions))
    }

    fn prepare(
        topology: &'t Topology,
        rules: &'t Rules,
        options: &Options,
        positions: Option<&[Vec3]>,
    ) -> Result<Self, Error> {
        if let Some(patched) = Self::patched(topology, rules, options, positions)? {
            return Ok(patched);
        }
        let pushback = match options.level {
            Level::Control => None,
            Level::Finer => Some(PushBack::new(topology, rules)?),
        };
        let interpolator = Interpolator::prepare(topology, rules, positions)?;
        let finer = pushback.as_ref().map(|p| p.step().topology.vertex_count());
        Ok(Self {
            topology,
            level: options.level,
            steps: options.steps.unwrap_or(usual_steps(rules.scheme)),
            result_count: finer.unwrap_or(topology.vertex_count()),
            engine: Engine::Sweeps(Box::new(Sweeps { interpolator, pushback })),
        })
    }

    /// [`new`](Self::new) or [`near`](Self::near), if there are patches.
    pub(crate) fn patched(
        topology: &'t Topology,
        rules: &Rules,
        options: &Options,
        positions: Option<&[Vec3]>,
    ) -> Result<Option<Self>, Error> {
        assert!(options.patch_size > 0, "a patch has vertices");
        limit::check(topology, rules)?;
        if topology.vertex_count() == 0 {
            return Err(Error::NoVertices);
        }
        let level = options.level;
        let steps = options.steps.unwrap_or(usual_steps(rules.scheme));
        if level == Level::Finer {
            check_size(topology, rules, 1)?;
        }
        let patches = Patches::new(topology, rules, steps, options, positions);
        Ok(patches.map(|(patches, result_count)| Self {
            topology,
            level,
            steps,
            result_count,
            engine: Engine::Patches(patches),
        }))
    }

    /// Whether there are patches. Otherwise fits sweep over the whole mesh.
    #[must_use]
    pub fn is_patched(&self) -> bool {
        matches!(self.engine, Engine::Patches(_))
    }

    /// Number of values that a fit makes: of the vertices, or of the vertices of the mesh refined once.
    #[must_use]
    pub fn result_count(&self) -> usize {
        self.result_count
    }

    /// Bytes that the patches take, and how many vertices there are in them, halos included, for each
    /// vertex of the mesh.
    #[must_use]
    pub fn patch_bytes(&self) -> (usize, f64) {
        let Engine::Patches(patches) = &self.engine else { return (0, 0.0) };
        let bytes = patches.list.iter().map(Patch::size).sum::<usize>()
            + size_of::<Run>() * patches.runs.len();
        let copies: usize = patches.list.iter().map(|p| p.vertices.len()).sum();
        (bytes, copies as f64 / self.topology.vertex_count() as f64)
    }

    /// The values whose limit values at the vertices are `target`, numbered as
    /// [`refine`](crate::refine::refine) does on the finer level.
    ///
    /// # Errors
    /// [`Error::Overflow`] if the targets are too large.
    ///
    /// # Panics
    /// If there is not one target per vertex, or one is not finite.
    pub fn fit(&self, target: &[Vec3]) -> Result<(Vec<Vec3>, Summary), Error> {
        let mut out = alloc::vec![Vec3::ZERO; self.result_count];
        let summary = self.fit_into(target, &mut out)?;
        Ok((out, summary))
    }

    /// [`fit`](Self::fit) into memory that there is already, which is faster.
    ///
    /// # Errors
    /// As [`fit`](Self::fit).
    ///
    /// # Panics
    /// As [`fit`](Self::fit); if there is not room for [`result_count`](Self::result_count) values.
    pub fn fit_into(&self, target: &[Vec3], out: &mut [Vec3]) -> Result<Summary, Error> {
        assert_eq!(target.len(), self.topology.vertex_count(), "one target per vertex");
        assert_eq!(out.len(), self.result_count, "room for the results");
        let patches = match &self.engine {
            Engine::Patches(patches) => patches,
            Engine::Sweeps(sweeps) => return self.sweep(sweeps, target, out),
        };
        let exponent = exponent(target)?;
        if exponent.abs() <= FAR {
            return Ok(self.summary(patches.fit(self.level, target, exponent, out), 0));
        }
        let near = par::collect(target.len(), |v| ldexp(target[v], -exponent));
        let distances = patches.fit(self.level, &near, 0, out);
        par::for_blocks(out, |_, block| {
            block.iter_mut().for_each(|p| *p = ldexp(*p, exponent));
        });
        Ok(self.summary(distances, exponent))
    }

    fn summary(&self, distances: Distances, exponent: i32) -> Summary {
        let used = self.topology.vertex_count() - self.topology.isolated_count();
        let mean = distances.sum / (used as f64).max(1.0);
        let [largest, mean] = [distances.largest, mean].map(|x| libm::ldexp(x, exponent));
        Summary { largest, mean }
    }

    fn sweep(
        &self,
        Sweeps { interpolator, pushback }: &Sweeps<'_>,
        target: &[Vec3],
        out: &mut [Vec3],
    ) -> Result<Summary, Error> {
        let options = interpolate::Options {
            norm: interpolate::Norm::Absolute,
            tolerance: None,
            iterations: self.steps,
            ..interpolate::Options::default()
        };
        let mut go_on = |_, _| ControlFlow::Continue(());
        let (values, report) = match pushback {
            None => interpolator.fit(target, &options, &mut go_on)?,
            Some(pushback) => interpolator.sweep_exactly(pushback, target, &options, &mut go_on)?,
        };
        out.copy_from_slice(&values);
        let last = report.stages.last().map_or(0.0, |stage| stage.solve.last().mean);
        let mean = if pushback.is_some() { last } else { report.mean };
        Ok(Summary { largest: report.pushed_back.unwrap_or(report.max), mean })
    }
}

impl Patches {
    /// `None` where patches do not pay; otherwise also the number of results.
    fn new(
        topology: &Topology,
        rules: &Rules,
        reach: u32,
        options: &Options,
        positions: Option<&[Vec3]>,
    ) -> Option<(Self, usize)> {
        let special = Special::new(topology, rules)?;
        let [guaranteed, usual] = whole_bound(topology, rules);
        let steps = chebyshev_steps(usual.max(guaranteed), reach);
        let kernel = Kernel::new(rules.scheme, steps);
        let with_finer = options.level == Level::Finer;
        let maker = Maker { topology, rules, special: &special, reach, with_finer };
        let mut size = options.patch_size.min(topology.vertex_count());
        let near = positions.and_then(|positions| cut::cut_by_position(positions, size));
        let made = near.and_then(|cut| Self::make(&maker, &kernel, cut, copies_near(size, reach)));
        if made.is_some() {
            return made;
        }
        let rings = Rings::new(topology);
        let most = MOST_COPIES.max(COPIES as f64 / topology.vertex_count() as f64);
        loop {
            let cut = cut::cut(&rings, topology.vertex_count(), size);
            let made = Self::make(&maker, &kernel, cut, most);
            // Fewer vertices have smaller halos, unless some have very many neighbours.
            if made.is_some() || size < 1024 {
                return made;
            }
            size /= 4;
        }
    }

    /// From the patch of every vertex, and how many patches there are.
    fn make(
        maker: &Maker<'_, '_>,
        kernel: &Kernel,
        (patch_of, count): (Vec<u32>, usize),
        most_copies: f64,
    ) -> Option<(Self, usize)> {
        let topology = maker.topology;
        let vertex_count = topology.vertex_count();
        let of_vertex = |v: u32| patch_of[v as usize];
        let of_point = |i: u32| {
            let v = if maker.rules.scheme == Scheme::DooSabin {
                maker.special.vertex_of_image(i as usize)
            } else {
                let first = (i as usize).checked_sub(topology.edge_count());
                topology.origin(match first {
                    None => topology.edge_halfedge(crate::EdgeId(i)),
                    Some(f) => first_halfedge(topology, f as u32),
                })
            };
            patch_of[v.index()]
        };
        let point_count = if maker.with_finer { maker.special.new_point_count() } else { 0 };
        let mut runs = cut::runs(vertex_count, of_vertex);
        let point_runs = cut::runs(point_count, of_point);
        let vertices = Groups::new(count, &runs, vertex_count);
        let points = Groups::new(count, &point_runs, point_count);

        let most = (most_copies * vertex_count as f64) as usize;
        let made = par::map_parts(parted::blocks(count), |range| {
            let mut numbers = Numbers::new(topology, maker.rules.scheme);
            let mut copies = 0;
            let mut patches = Vec::with_capacity(range.len());
            for p in range {
                let patch = maker.patch(vertices.of(p), points.of(p), &mut numbers)?;
                copies += patch.vertices.len() + patch.ring.len() / 8;
                if copies > most {
                    return None;
                }
                patches.push(patch);
            }
            Some((patches, copies))
        });
        let made: Vec<(Vec<Patch>, usize)> = made.into_iter().collect::<Option<_>>()?;
        if made.iter().map(|part| part.1).sum::<usize>() > most {
            return None;
        }
        let list: Vec<Patch> = made.into_iter().flat_map(|part| part.0).collect();

        let mut result_count = vertex_count;
        if maker.with_finer && maker.rules.scheme == Scheme::DooSabin {
            (runs, result_count) = (Vec::new(), 0);
        }
        let first = result_count as u32;
        runs.extend(point_runs.iter().map(|run| Run { first: first + run.first, ..*run }));
        result_count += point_count;
        let mut run_count = alloc::vec![0; count];
        runs.iter().for_each(|run| run_count[run.patch as usize] += 1);
        Some((Self { kernel: kernel.clone(), list, runs, run_count }, result_count))
    }

    fn fit(&self, level: Level, target: &[Vec3], exponent: i32, out: &mut [Vec3]) -> Distances {
        // Memory that is new costs more than the arithmetic on it: no more than is needed.
        match self.list.iter().map(|patch| patch.vertices.len()).max().unwrap_or(0) {
            0..=0x1000 => self.fit_with::<0x1000>(level, target, exponent, out),
            0x1001..=0x4000 => self.fit_with::<0x4000>(level, target, exponent, out),
            0x4001..=0x8000 => self.fit_with::<0x8000>(level, target, exponent, out),
            _ => self.fit_with::<0x10000>(level, target, exponent, out),
        }
    }

    /// With room for so many local numbers.
    fn fit_with<const N: usize>(
        &self,
        level: Level,
        target: &[Vec3],
        exponent: i32,
        out: &mut [Vec3],
    ) -> Distances {
        let scale = [-exponent, exponent].map(|e| libm::ldexp(1.0, e));
        let mut slices: Vec<Vec<&mut [Vec3]>> =
            self.run_count.iter().map(|&count| Vec::with_capacity(count as usize)).collect();
        let count = out.len();
        let mut rest = out;
        for (i, run) in self.runs.iter().enumerate() {
            let len = cut::end(&self.runs, i, count) - run.first;
            let (own, others) = rest.split_at_mut(len as usize);
            slices[run.patch as usize].push(own);
            rest = others;
        }
        let mut jobs: Vec<Vec<Job<'_, '_>>> = Vec::new();
        let parts = match par::part_count() {
            1 => 1,
            // Some may be held up by other work; each part needs memory of its own.
            threads => 3 * threads,
        };
        let each = self.list.len().div_ceil(parts);
        for (i, job) in self.list.iter().zip(slices).enumerate() {
            if i % each == 0 {
                jobs.push(Vec::with_capacity(each));
            }
            if let Some(last) = jobs.last_mut() {
                last.push(job);
            }
        }
        let distances = par::map_parts(jobs, |jobs| {
            let mut scratch = Scratch::<N>::new();
            jobs.into_iter().fold(Distances::default(), |distances, (patch, slices)| {
                let mut sink = Sink::new(slices);
                let task = Task { patch, target, scale };
                let found = match level {
                    Level::Control => self.kernel.control(task, &mut scratch, &mut sink),
                    Level::Finer => self.kernel.finer(task, &mut scratch, &mut sink),
                };
                distances.plus(found)
            })
        });
        distances.into_iter().fold(Distances::default(), Distances::plus)
    }
}

/// Local numbers per vertex that patches may have which are cut by positions, twice as wide halos as those of
/// squares of so many vertices; with more, the positions are not those of a surface.
fn copies_near(size: usize, reach: u32) -> f64 {
    let side = 1.0 + 4.0 * f64::from(reach + 1) / libm::sqrt(size as f64);
    (side * side).max(3.0)
}

/// A patch and where its results go.
type Job<'p, 'o> = (&'p Patch, Vec<&'o mut [Vec3]>);

fn first_halfedge(topology: &Topology, f: u32) -> HalfedgeId {
    topology.face_halfedges(crate::FaceId(f)).next().expect("a face has corners")
}
