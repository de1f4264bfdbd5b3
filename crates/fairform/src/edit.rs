//! Editing a fitted mesh: what a move of a few data, or other rules at a few faces and edges, do to the
//! control points, without solving again.
//!
//! With $`B`$ the limit operator and $`B x = p`$, moving the data of vertices $`v \in G`$ by $`d`$ moves
//! the control points by $`d`$ times
//!
//! ```math
//! c = \sum_{v \in G} B^{-1} e_v
//! ```
//!
//! The inverse of a well conditioned band matrix decays exponentially \[Demko1984\]; this one by about
//! 0.26 per ring for Loop and Catmull–Clark. So $`c`$ is solved once, when the vertices are grabbed, on
//! as many rings around them as it takes for the limit points beyond to stay where they are up to a
//! tolerance. A drag then is one sparse sum, of which the cost does not depend on the size of the mesh.
//!
//! A shape parameter or a sharpness changes the rows of $`B`$ at the vertices beside it and nothing else.
//! Their residuals are spread in the same way.
//!
//! The rows of free vertices are those of the identity: partial interpolation, where the control points of
//! some vertices are chosen and the others follow.

use alloc::collections::BTreeMap;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::ops::ControlFlow;

use crate::error::{Defects, Error};
use crate::ids::{NONE, VertexId};
use crate::interpolate::{Norm, bound_among};
use crate::limit::{self, LimitRows, operator::RowOperator};
use crate::mesh::{Bounds, not_finite};
use crate::pushback::singular_components;
use crate::solve::{Interval, LinearOperator as _, Outcome, Stop, stationary};
use crate::{Creases, Mesh, Rules, Stencils, Topology, Vec3, rows};

mod change;
mod part;

pub use change::{Change, Changed, Drag};

use change::{beside_changes, faces_around};
use part::Part;

/// A fitted mesh while it is edited: its data, and control points that follow them.
///
/// ```
/// use fairform::edit::Editor;
/// use fairform::{Rules, Vec3, VertexId, interpolate, limit, shapes};
///
/// let target = shapes::torus(20, 20);
/// let options = interpolate::Options::default();
/// let (control, _) = interpolate::interpolate(&target, &Rules::LOOP, &options)?;
/// let mut editor = Editor::new(&target, &Rules::LOOP, control.into_positions(), 1e-6)?;
/// let drag = editor.grab(&[VertexId(7)])?;
/// for _ in 0..10 {
///     editor.drag(&drag, Vec3::new(0.0, 0.0, 0.01));
/// }
/// assert!(editor.settle()?.0 <= 1e-6 * target.bounds().diagonal());
/// let surface = limit::limit_points(target.topology(), editor.control(), &Rules::LOOP)?;
/// let moved = surface[7] - target.positions()[7];
/// assert!((moved - Vec3::new(0.0, 0.0, 0.1)).length() < 1e-5);
/// # Ok::<(), fairform::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Editor {
    topology: Arc<Topology>,
    rules: Rules,
    /// The limit rows of the rules at the beginning.
    rows: Stencils,
    /// Those of the rules now, where they are others.
    changed_rows: BTreeMap<u32, Vec<(u32, f64)>>,
    tolerance: f64,
    target: Vec<Vec3>,
    control: Vec<Vec3>,
    is_free: Vec<bool>,
    /// How often the free vertices or the rules changed, which makes the columns of drags others.
    generation: u64,
}

/// Rings that are taken at first: those of a decay by so much per ring, which Doo and Sabin's scheme has,
/// the fastest of the three. The others add some.
const FIRST_DECAY: f64 = 0.16;

/// Fewest rings that are added at a time; a quarter of those there are if that is more, so that where the
/// decay is slow the solves together cost no more than a few times the last.
const MORE_RINGS: u32 = 2;

/// Accuracy of a column on its rings, in units of what is allowed beyond them.
const INNER: f64 = 0.1;

/// Most updates of a solve, which a meaningful one does not come near.
const MOST_UPDATES: u32 = 10_000;

impl Editor {
    /// An editor for control points whose limit points are the vertices of `target`, as a fit finds them.
    /// They need not be exact, see [`settle`](Self::settle). All vertices are pinned, except those that
    /// are support ([`Border::None`](crate::Border::None)), which always are free.
    ///
    /// `tolerance` says how far limit points may be from their data: after a drag, relative to the distance
    /// dragged; after settling, relative to the diagonal of the bounding box.
    ///
    /// # Errors
    /// [`Error::NoVertices`]; [`Error::BadOption`] for a tolerance that is not between 1e-12 and 1;
    /// [`Error::WrongCount`] if there is not one control point per vertex; [`Error::NotManifold`] for
    /// coordinates that are not finite; [`Error::Singular`] where the limit operator is known to be, see
    /// [`singular_components`]; [`Error::NotForScheme`] for interpolating schemes, whose control points
    /// are the data; as [`limit::limit_stencils`].
    pub fn new(
        target: &Mesh,
        rules: &Rules,
        control: Vec<Vec3>,
        tolerance: f64,
    ) -> Result<Self, Error> {
        let topology = target.topology();
        if topology.vertex_count() == 0 {
            return Err(Error::NoVertices);
        }
        if !(1e-12..1.0).contains(&tolerance) {
            let (what, expected) = ("the tolerance", "at least 1e-12 and below 1");
            return Err(Error::BadOption { what, expected, value: tolerance });
        }
        if control.len() != topology.vertex_count() {
            let (what, expected) = ("control points", topology.vertex_count());
            return Err(Error::WrongCount { what, expected });
        }
        let bad = [not_finite(target.positions()), not_finite(&control)].concat();
        if !bad.is_empty() {
            return Err(Error::NotManifold(Defects(bad)));
        }
        if rules.scheme.is_interpolating() {
            let what = "control points other than the data";
            return Err(Error::NotForScheme { what, scheme: rules.scheme.name() });
        }
        let rows = limit::limit_stencils(topology, rules)?;
        if let Some(&vertex) = singular_components(topology, rules).first() {
            return Err(Error::Singular { vertex });
        }
        let is_free: Vec<bool> =
            topology.vertices().map(|v| rules.is_support(topology, v)).collect();
        let mut target = target.positions().to_vec();
        for v in (0..target.len()).filter(|&v| is_free[v]) {
            target[v] = control[v];
        }
        Ok(Self {
            rows,
            changed_rows: BTreeMap::new(),
            topology: Arc::clone(topology),
            rules: rules.clone(),
            tolerance,
            target,
            control,
            is_free,
            generation: 0,
        })
    }

    /// The control points.
    #[must_use]
    pub fn control(&self) -> &[Vec3] {
        &self.control
    }

    /// The data: what limit points of pinned vertices are to be, and control points of free ones are.
    #[must_use]
    pub fn target(&self) -> &[Vec3] {
        &self.target
    }

    /// The control points, by value.
    #[must_use]
    pub fn into_control(self) -> Vec<Vec3> {
        self.control
    }

    /// The rules.
    #[must_use]
    pub fn rules(&self) -> &Rules {
        &self.rules
    }

    /// Whether the surface need not pass through a vertex.
    ///
    /// # Panics
    /// If there is no such vertex.
    #[must_use]
    pub fn is_free(&self, v: VertexId) -> bool {
        self.is_free[v.index()]
    }

    /// Frees vertices: their control points stay where they are, whatever is dragged, unless they are
    /// grabbed themselves. Ends all drags.
    ///
    /// # Errors
    /// [`Error::NoSuchVertex`], and nothing is changed.
    pub fn free(&mut self, vertices: &[VertexId]) -> Result<(), Error> {
        self.check(vertices)?;
        for v in vertices {
            self.is_free[v.index()] = true;
            self.target[v.index()] = self.control[v.index()];
        }
        self.generation += 1;
        Ok(())
    }

    /// Pins free vertices where the surface is now, so that nothing moves. Support stays free. Ends all
    /// drags.
    ///
    /// # Errors
    /// [`Error::NoSuchVertex`], and nothing is changed.
    pub fn pin(&mut self, vertices: &[VertexId]) -> Result<(), Error> {
        self.check(vertices)?;
        for &v in vertices {
            if self.is_free[v.index()] && !self.rules.is_support(&self.topology, v) {
                self.is_free[v.index()] = false;
                self.target[v.index()] = self.limit_point(v);
            }
        }
        self.generation += 1;
        Ok(())
    }

    /// Gets vertices ready to be dragged together. Each counts once.
    ///
    /// Drags hold until the free vertices or the rules change; until then any number of them can be used in any order.
    ///
    /// # Errors
    /// [`Error::NoSuchVertex`]; [`Error::Singular`] where no iteration finds how the control points follow,
    /// which happens on meshes that [`pushback::is_not_definite`](crate::pushback::is_not_definite) is
    /// about.
    pub fn grab(&self, vertices: &[VertexId]) -> Result<Drag, Error> {
        self.check(vertices)?;
        let mut grabbed = vertices.to_vec();
        grabbed.sort_unstable();
        grabbed.dedup();
        let unit = Vec3::new(1.0, 0.0, 0.0);
        let moves = self.spread(&grabbed, &alloc::vec![unit; grabbed.len()], self.tolerance)?;
        let (vertices, column): (Vec<_>, Vec<_>) = moves.into_iter().map(|m| (m.0, m.1.x)).unzip();
        let faces = faces_around(&self.topology, &vertices);
        Ok(Drag { grabbed, vertices, column, faces, generation: self.generation })
    }

    /// Moves the data of the grabbed vertices by `offset`, and the control points with them.
    ///
    /// # Panics
    /// If vertices were freed or pinned or the rules changed since the vertices were grabbed, or they are
    /// those of another mesh; if the offset is not finite.
    pub fn drag<'d>(&mut self, drag: &'d Drag, offset: Vec3) -> Changed<'d> {
        assert_eq!(
            drag.generation, self.generation,
            "vertices are grabbed after all else is changed"
        );
        assert!(offset.is_finite(), "the offset is finite");
        for (v, &weight) in drag.vertices.iter().zip(&drag.column) {
            self.control[v.index()] += weight * offset;
        }
        for v in &drag.grabbed {
            self.target[v.index()] += offset;
        }
        drag.changed()
    }

    /// Other shape parameters, as in [`Rules::tension`]: the surface still passes through every pinned
    /// vertex. Solves near the faces whose parameter is another one, after a look at all parameters. Ends
    /// all drags.
    ///
    /// `None` and parameters of 1/2 are the same scheme for Loop and Catmull–Clark, but not for Doo–Sabin,
    /// where all vertices are near then; going from one to the other may change rounding anywhere.
    ///
    /// Limit points near there are within the tolerance of their data after it, relative to the diagonal of
    /// the bounding box.
    ///
    /// # Errors
    /// As [`Rules::check`]; [`Error::Singular`] where the limit operator now is, or no iteration finds
    /// control points. Nothing is changed then.
    pub fn set_tension(&mut self, tension: Option<Arc<[f64]>>) -> Result<Change, Error> {
        self.set_rules(Rules { tension, ..self.rules.clone() })
    }

    /// Other creases, as [`set_tension`](Self::set_tension) for shape parameters.
    ///
    /// # Errors
    /// As [`set_tension`](Self::set_tension).
    pub fn set_creases(&mut self, creases: Option<Arc<Creases>>) -> Result<Change, Error> {
        self.set_rules(Rules { creases, ..self.rules.clone() })
    }

    fn set_rules(&mut self, rules: Rules) -> Result<Change, Error> {
        limit::check(&self.topology, &rules)?;
        let beside = beside_changes(&self.topology, &self.rules, &rules);
        if beside.is_empty() {
            self.rules = rules;
            return Ok(Change::default());
        }
        if let Some(&vertex) = singular_components(&self.topology, &rules).first() {
            return Err(Error::Singular { vertex });
        }
        let limit_rows = LimitRows::new(&self.topology, &rules);
        let rows = beside.iter().map(|v| {
            let mut row = Vec::new();
            rows::gather(&limit_rows, v.index(), &mut row);
            (v.0, row)
        });
        let rows: Vec<_> = rows.collect();
        let before = core::mem::replace(&mut self.rules, rules);
        let kept: Vec<_> =
            rows.into_iter().map(|(v, row)| (v, self.changed_rows.insert(v, row))).collect();
        match self.mend(&beside) {
            Ok(change) => {
                self.generation += 1;
                Ok(change)
            }
            Err(error) => {
                self.rules = before;
                for (v, row) in kept {
                    match row {
                        Some(row) => self.changed_rows.insert(v, row),
                        None => self.changed_rows.remove(&v),
                    };
                }
                Err(error)
            }
        }
    }

    /// Brings the limit points of some vertices, whose rows changed, back to their data.
    fn mend(&mut self, beside: &[VertexId]) -> Result<Change, Error> {
        let tolerance = self.tolerance * self.unit();
        let residual = |&v: &VertexId| (v, self.target[v.index()] - self.limit_point(v));
        let pinned = beside.iter().filter(|v| !self.is_free[v.index()]);
        let (seeds, residuals): (Vec<_>, Vec<_>) =
            pinned.map(residual).filter(|r| r.1 != Vec3::ZERO).unzip();
        let moves = self.spread(&seeds, &residuals, tolerance)?;
        for &(v, offset) in &moves {
            self.control[v.index()] += offset;
        }
        let vertices: Vec<VertexId> = moves.into_iter().map(|m| m.0).collect();
        let mut all = [vertices.as_slice(), beside].concat();
        all.sort_unstable();
        all.dedup();
        Ok(Change { faces: faces_around(&self.topology, &all), vertices })
    }

    /// Takes away what edits leave: solves for all data, beginning with the control points there are,
    /// until the surface passes through every pinned vertex to the tolerance. May move any control point,
    /// none if that is so already. Returns the largest distance of a limit point from its data,
    /// measured on the result, which tells if the tolerance was missed; and what moved.
    ///
    /// # Errors
    /// [`Error::Overflow`].
    pub fn settle(&mut self) -> Result<(f64, Change), Error> {
        let all: Vec<u32> = (0..self.target.len() as u32).collect();
        let operator = self.operator(&all, &all);
        let tolerance = Some(self.tolerance);
        let stop = Stop { tolerance, unit: self.unit(), max_updates: MOST_UPDATES };
        let mut control = self.control.clone();
        let interval = interval(&operator);
        stationary(&operator, &self.target, &mut control, interval, stop, &mut |_| {
            ControlFlow::Continue(())
        })?;
        let moved = |&v: &VertexId| control[v.index()] != self.control[v.index()];
        let vertices: Vec<VertexId> = self.topology.vertices().filter(moved).collect();
        self.control = control;
        let limit = limit::limit_points(&self.topology, &self.control, &self.rules)?;
        let pinned = (0..limit.len()).filter(|&v| !self.is_free[v]);
        let largest = pinned.map(|v| (limit[v] - self.target[v]).length()).fold(0.0, f64::max);
        Ok((largest, Change { faces: faces_around(&self.topology, &vertices), vertices }))
    }

    /// The diagonal of the box around the data, or 1.
    fn unit(&self) -> f64 {
        let used = self.topology.vertices().filter(|&v| !self.topology.is_isolated(v));
        Norm::Diagonal.unit(&Bounds::of(used.map(|v| self.target[v.index()])))
    }

    fn check(&self, vertices: &[VertexId]) -> Result<(), Error> {
        let vertex_count = self.target.len();
        match vertices.iter().find(|v| v.index() >= vertex_count) {
            Some(&vertex) => Err(Error::NoSuchVertex { vertex, vertex_count }),
            None => Ok(()),
        }
    }

    fn limit_point(&self, v: VertexId) -> Vec3 {
        let mut sum = Vec3::ZERO;
        self.for_row(v.0, |q, weight| sum += weight * self.control[q as usize]);
        sum
    }

    /// The entries of the limit row of a vertex.
    fn for_row(&self, v: u32, mut entry: impl FnMut(u32, f64)) {
        match self.changed_rows.get(&v) {
            Some(row) => row.iter().for_each(|&(q, weight)| entry(q, weight)),
            None => self.rows.row(v as usize).for_each(|(q, weight)| entry(q.0, weight)),
        }
    }

    /// The vertices, pinned ones, in whose limit rows a control point comes.
    fn for_column(&self, q: u32, mut found: impl FnMut(u32)) {
        // Rows do not reach beyond the faces of their vertices.
        for h in self.topology.fan(VertexId(q)) {
            for &v in self.topology.face_vertices(self.topology.face(h)) {
                let mut is_in_row = false;
                self.for_row(v.0, |source, weight| is_in_row |= source == q && weight != 0.0);
                if is_in_row && !self.is_free[v.index()] {
                    found(v.0);
                }
            }
        }
    }

    /// The rows of some vertices, of which `local` has the numbers, and zero for all others. Of a
    /// symmetric definite operator, parts have no smaller eigenvalues than the whole.
    fn operator(&self, vertices: &[u32], local: &[u32]) -> RowOperator {
        let row = |i: usize, entries: &mut Vec<(u32, f64)>| {
            let v = vertices[i];
            if self.is_free[v as usize] {
                return entries.push((v, 1.0));
            }
            self.for_row(v, |q, weight| {
                if local[q as usize] != NONE {
                    entries.push((q, weight));
                }
            });
        };
        let scale = alloc::vec![1.0; vertices.len()];
        let [guaranteed, usual] = bound_among(&self.topology, &self.rules, vertices);
        RowOperator::new(vertices.len(), row, local, scale, guaranteed, usual)
    }

    /// How the control points follow moves of the limit points of some vertices (of the control points
    /// themselves where they are free): until no limit point beyond the part that moves is off by more
    /// than `tolerance`. Sorted by vertex.
    fn spread(
        &self,
        seeds: &[VertexId],
        moves: &[Vec3],
        tolerance: f64,
    ) -> Result<Vec<(VertexId, Vec3)>, Error> {
        let largest = moves.iter().map(|m| m.length()).fold(0.0, f64::max);
        if largest == 0.0 {
            return Ok(Vec::new());
        }
        let mut part = Part::new(self, seeds);
        let small = (tolerance / largest).min(FIRST_DECAY);
        let mut more = libm::ceil(libm::log(small) / libm::log(FIRST_DECAY)) as u32;
        let (mut x, mut rings) = (Vec::new(), 0);
        loop {
            let is_whole = !part.grow(more);
            x = self.follow(&part, moves, tolerance, x)?;
            if is_whole || part.beyond(&x) <= tolerance {
                break;
            }
            rings += more;
            more = MORE_RINGS.max(rings / 4);
        }
        let moved = part.vertices.iter().map(|&v| VertexId(v)).zip(x);
        let mut moved: Vec<_> = moved.filter(|m| m.1 != Vec3::ZERO).collect();
        moved.sort_unstable_by_key(|m| m.0);
        Ok(moved)
    }

    /// How the control points of a part follow moves of its first limit points.
    fn follow(
        &self,
        part: &Part<'_>,
        moves: &[Vec3],
        tolerance: f64,
        mut x: Vec<Vec3>,
    ) -> Result<Vec<Vec3>, Error> {
        let operator = self.operator(&part.vertices, &part.local);
        let mut target = alloc::vec![Vec3::ZERO; operator.unknown_count()];
        // The seeds come first.
        target[..moves.len()].copy_from_slice(moves);
        if x.is_empty() {
            // Seeds that are free have their values from the start, and keep them.
            x.clone_from(&target);
        }
        x.resize(target.len(), Vec3::ZERO);
        let tolerance = Some(INNER * tolerance);
        let stop = Stop { tolerance, unit: 1.0, max_updates: MOST_UPDATES };
        let interval = interval(&operator);
        let report = stationary(&operator, &target, &mut x, interval, stop, &mut |_| {
            ControlFlow::Continue(())
        });
        match report {
            Ok(report) if report.outcome == Outcome::Converged => Ok(x),
            _ => Err(Error::Singular { vertex: VertexId(part.vertices[0]) }),
        }
    }
}

fn interval(operator: &RowOperator) -> Interval {
    Interval::Hopeful {
        usual: operator.usual_smallest_eigenvalue(),
        guaranteed: operator.smallest_eigenvalue_bound().max(crate::interpolate::LEAST),
    }
}
