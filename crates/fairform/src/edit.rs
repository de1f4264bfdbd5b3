//! Dragging vertices of a fitted mesh: what a move of a few data does to the control points, without
//! solving again.
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
//! The rows of free vertices are those of the identity: partial interpolation, where the control points of
//! some vertices are chosen and the others follow.

use alloc::sync::Arc;
use alloc::vec::Vec;
use core::ops::ControlFlow;

use crate::error::{Defects, Error};
use crate::ids::{FaceId, NONE, VertexId};
use crate::interpolate::{Norm, whole_bound};
use crate::limit::{self, operator::RowOperator};
use crate::mesh::{Bounds, not_finite};
use crate::pushback::singular_components;
use crate::solve::{Interval, LinearOperator as _, Outcome, Stop, stationary};
use crate::{Mesh, Rules, Stencils, Topology, Vec3};

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
/// assert!(editor.settle()? <= 1e-6 * target.bounds().diagonal());
/// let surface = limit::limit_points(target.topology(), editor.control(), &Rules::LOOP)?;
/// let moved = surface[7] - target.positions()[7];
/// assert!((moved - Vec3::new(0.0, 0.0, 0.1)).length() < 1e-5);
/// # Ok::<(), fairform::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Editor {
    topology: Arc<Topology>,
    rules: Rules,
    rows: Stencils,
    /// By control point: the rows it comes in.
    columns: Stencils,
    /// Lower bounds of the spectrum: guaranteed, and usual.
    bound: [f64; 2],
    tolerance: f64,
    target: Vec<Vec3>,
    control: Vec<Vec3>,
    is_free: Vec<bool>,
    /// How often the free vertices changed, which makes the columns of drags others.
    generation: u64,
}

/// Grabbed vertices, and how the control points follow them.
#[derive(Clone, PartialEq, Debug)]
pub struct Drag {
    grabbed: Vec<VertexId>,
    vertices: Vec<VertexId>,
    /// Move of each control point for a move of the grabbed data by 1.
    column: Vec<f64>,
    faces: Vec<FaceId>,
    generation: u64,
}

/// What a drag changed; all else has the same bits as before.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Changed<'d> {
    /// The vertices whose control points moved, sorted.
    pub vertices: &'d [VertexId],
    /// The faces of the mesh whose part of the surface moved, at any level of refinement (see
    /// [`Refined::parent`](crate::refine::Refined::parent)), sorted: those that share a vertex with a
    /// face that has such a control point.
    pub faces: &'d [FaceId],
}

impl Drag {
    /// The vertices whose data move, sorted, each once.
    #[must_use]
    pub fn grabbed(&self) -> &[VertexId] {
        &self.grabbed
    }

    /// What every drag changes.
    #[must_use]
    pub fn changed(&self) -> Changed<'_> {
        Changed { vertices: &self.vertices, faces: &self.faces }
    }
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
            bound: whole_bound(topology, rules),
            columns: rows.transposed(),
            rows,
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
    /// Drags hold until the free vertices change; until then any number of them can be used in any order.
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
        let mut part = Part::new(self, &grabbed);
        let first = libm::ceil(libm::log(self.tolerance) / libm::log(FIRST_DECAY)) as u32;
        let mut is_done = grabbed.is_empty();
        let mut x = Vec::new();
        let (mut rings, mut more) = (0, first);
        while !is_done {
            let is_whole = !part.grow(more);
            x = self.column(&part, &grabbed, x)?;
            is_done = is_whole || part.beyond(&x) <= self.tolerance;
            rings += more;
            more = MORE_RINGS.max(rings / 4);
        }
        let mut entries: Vec<(VertexId, f64)> = part
            .vertices
            .iter()
            .zip(&x)
            .map(|(&v, x)| (VertexId(v), x.x))
            .filter(|e| e.1 != 0.0)
            .collect();
        entries.sort_unstable_by_key(|e| e.0);
        let (vertices, column): (Vec<_>, Vec<_>) = entries.into_iter().unzip();
        let faces = faces_around(&self.topology, &vertices);
        Ok(Drag { grabbed, vertices, column, faces, generation: self.generation })
    }

    /// Moves the data of the grabbed vertices by `offset`, and the control points with them.
    ///
    /// # Panics
    /// If vertices were freed or pinned since the vertices were grabbed, or they are those of another
    /// mesh; if the offset is not finite.
    pub fn drag<'d>(&mut self, drag: &'d Drag, offset: Vec3) -> Changed<'d> {
        assert_eq!(drag.generation, self.generation, "vertices are grabbed after others are freed");
        assert!(offset.is_finite(), "the offset is finite");
        for (v, &weight) in drag.vertices.iter().zip(&drag.column) {
            self.control[v.index()] += weight * offset;
        }
        for v in &drag.grabbed {
            self.target[v.index()] += offset;
        }
        drag.changed()
    }

    /// Takes away what drags leave: solves for all data, beginning with the control points there are,
    /// until the surface passes through every pinned vertex to the tolerance. May move any control point,
    /// none if that is so already. Returns the largest distance of a limit point from its data,
    /// measured on the result; it tells if the tolerance was missed.
    ///
    /// # Errors
    /// [`Error::Overflow`].
    pub fn settle(&mut self) -> Result<f64, Error> {
        let used = self.topology.vertices().filter(|&v| !self.topology.is_isolated(v));
        let unit = Norm::Diagonal.unit(&Bounds::of(used.map(|v| self.target[v.index()])));
        let all: Vec<u32> = (0..self.target.len() as u32).collect();
        let operator = self.operator(&all, &all);
        let stop = Stop { tolerance: Some(self.tolerance), unit, max_updates: MOST_UPDATES };
        let mut control = self.control.clone();
        stationary(&operator, &self.target, &mut control, self.interval(), stop, &mut |_| {
            ControlFlow::Continue(())
        })?;
        self.control = control;
        let limit = limit::limit_points(&self.topology, &self.control, &self.rules)?;
        let pinned = (0..limit.len()).filter(|&v| !self.is_free[v]);
        Ok(pinned.map(|v| (limit[v] - self.target[v]).length()).fold(0.0, f64::max))
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
        for (q, weight) in self.rows.row(v.index()) {
            sum += weight * self.control[q.index()];
        }
        sum
    }

    fn interval(&self) -> Interval {
        let [guaranteed, usual] = self.bound;
        Interval::Hopeful { usual, guaranteed: guaranteed.max(crate::interpolate::LEAST) }
    }

    /// The rows of some vertices, of which `local` has the numbers, and zero for all others. Of a
    /// symmetric definite operator, parts have no smaller eigenvalues than the whole.
    fn operator(&self, vertices: &[u32], local: &[u32]) -> RowOperator {
        let row = |i: usize, entries: &mut Vec<(u32, f64)>| {
            let v = vertices[i];
            if self.is_free[v as usize] {
                return entries.push((v, 1.0));
            }
            let row = self.rows.row(v as usize).map(|(q, weight)| (q.0, weight));
            entries.extend(row.filter(|e| local[e.0 as usize] != NONE));
        };
        let scale = alloc::vec![1.0; vertices.len()];
        let [guaranteed, usual] = self.bound;
        RowOperator::new(vertices.len(), row, local, scale, guaranteed, usual)
    }

    /// How the control points of a part follow the grabbed data, in the first coordinate.
    fn column(
        &self,
        part: &Part<'_>,
        grabbed: &[VertexId],
        mut x: Vec<Vec3>,
    ) -> Result<Vec<Vec3>, Error> {
        let operator = self.operator(&part.vertices, &part.local);
        let mut target = alloc::vec![Vec3::ZERO; operator.unknown_count()];
        // The grabbed vertices come first.
        target[..grabbed.len()].fill(Vec3::new(1.0, 0.0, 0.0));
        if x.is_empty() {
            // Grabbed vertices that are free have their values from the start, and keep them.
            x.clone_from(&target);
        }
        x.resize(target.len(), Vec3::ZERO);
        let tolerance = Some(INNER * self.tolerance);
        let stop = Stop { tolerance, unit: 1.0, max_updates: MOST_UPDATES };
        let report = stationary(&operator, &target, &mut x, self.interval(), stop, &mut |_| {
            ControlFlow::Continue(())
        });
        match report {
            Ok(report) if report.outcome == Outcome::Converged => Ok(x),
            _ => Err(Error::Singular { vertex: grabbed[0] }),
        }
    }
}

/// Vertices around grabbed ones, ring by ring: a ring is what has the vertices before it in its limit rows.
/// So curves are not reached from the inside, nor free vertices from anywhere.
struct Part<'e> {
    editor: &'e Editor,
    vertices: Vec<u32>,
    /// Numbers of the vertices of the mesh in the part, or none.
    local: Vec<u32>,
    /// The next ring, not yet in the part.
    next: Vec<u32>,
}

impl<'e> Part<'e> {
    fn new(editor: &'e Editor, grabbed: &[VertexId]) -> Self {
        let local = alloc::vec![NONE; editor.target.len()];
        let next = grabbed.iter().map(|v| v.0).collect();
        Self { editor, vertices: Vec::new(), local, next }
    }

    /// Adds rings. Returns whether there is anything beyond.
    fn grow(&mut self, rings: u32) -> bool {
        for _ in 0..rings {
            let start = self.vertices.len();
            if self.next.is_empty() {
                return false;
            }
            for &v in &self.next {
                self.local[v as usize] = self.vertices.len() as u32;
                self.vertices.push(v);
            }
            self.next.clear();
            for &v in &self.vertices[start..] {
                let reached = self.editor.columns.row(v as usize).map(|e| e.0);
                self.next.extend(
                    reached
                        .filter(|q| {
                            self.local[q.index()] == NONE && !self.editor.is_free[q.index()]
                        })
                        .map(|q| q.0),
                );
            }
            self.next.sort_unstable();
            self.next.dedup();
        }
        !self.next.is_empty()
    }

    /// The largest move of a limit point beyond the part, for moves `x` of its control points.
    fn beyond(&self, x: &[Vec3]) -> f64 {
        let own = |v: u32| {
            let mut sum = 0.0;
            for (q, weight) in self.editor.rows.row(v as usize) {
                let i = self.local[q.index()];
                if i != NONE {
                    sum += weight * x[i as usize].x;
                }
            }
            f64::abs(sum)
        };
        self.next.iter().map(|&v| own(v)).fold(0.0, f64::max)
    }
}

/// The faces whose surface depends on control points of some vertices.
///
/// A limit surface over a face depends on the faces that share a vertex with it, whatever the valences: so
/// does the face's part of every refined mesh, and for Doo–Sabin what is new on its edges and vertices.
fn faces_around(topology: &Topology, vertices: &[VertexId]) -> Vec<FaceId> {
    let faces = |vertices: &[VertexId]| {
        let around = |&v: &VertexId| topology.fan(v).map(|h| topology.face(h));
        let mut faces: Vec<FaceId> = vertices.iter().flat_map(around).collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    };
    let corners = |&f: &FaceId| topology.face_vertices(f).iter().copied();
    let mut near: Vec<VertexId> = faces(vertices).iter().flat_map(corners).collect();
    near.sort_unstable();
    near.dedup();
    faces(&near)
}
