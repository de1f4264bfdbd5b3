//! Which vertices and points follow the smooth rules that the kernels know by heart, and the rows of all
//! others, written out.
//!
//! The last step of a row is composed with the push-back, so that one sum over control points and the
//! vertex to be met makes a value of the finer mesh.

use alloc::vec::Vec;

use crate::Topology;
use crate::crease::{Kind, Sharpness};
use crate::ids::{EdgeId, VertexId};
use crate::limit::LimitRows;
use crate::limit::local::{Local, local_rows};
use crate::refine::{CatmullClarkRows, DooSabinRows, LoopRows};
use crate::rows::{self, Rows};
use crate::rules::BoundaryKinds;
use crate::scheme::loop_scheme::{BoundaryKind, boundary_limit_weight, limit_weight};
use crate::scheme::{Rules, Scheme, catmull_clark};

/// Highest valence that a byte holds besides [`SPECIAL`](super::patch::SPECIAL).
pub(super) const MOST_NEIGHBOURS: u32 = 254;

enum StepRows<'t> {
    Loop(LoopRows<'t>),
    CatmullClark(CatmullClarkRows<'t>),
    DooSabin(DooSabinRows<'t>),
}

impl Rows for StepRows<'_> {
    fn len(&self) -> usize {
        match self {
            Self::Loop(rows) => rows.len(),
            Self::CatmullClark(rows) => rows.len(),
            Self::DooSabin(rows) => rows.len(),
        }
    }

    fn visit(&self, row: usize, entry: impl FnMut(u32, f64)) {
        match self {
            Self::Loop(rows) => rows.visit(row, entry),
            Self::CatmullClark(rows) => rows.visit(row, entry),
            Self::DooSabin(rows) => rows.visit(row, entry),
        }
    }
}

/// The rules of one topology, asked vertex by vertex.
pub(super) struct Special<'t> {
    topology: &'t Topology,
    rules: &'t Rules,
    sharp: Sharpness<'t>,
    limit: LimitRows<'t>,
    step: StepRows<'t>,
    /// Whether shape parameters leave smooth masks as the kernel knows them.
    has_plain_masks: bool,
}

impl<'t> Special<'t> {
    /// `None` for schemes that interpolate without being asked.
    pub(super) fn new(topology: &'t Topology, rules: &'t Rules) -> Option<Self> {
        let step = match rules.scheme {
            Scheme::Loop => StepRows::Loop(LoopRows::new(topology, rules)),
            Scheme::CatmullClark => StepRows::CatmullClark(CatmullClarkRows::new(topology, rules)),
            Scheme::DooSabin => StepRows::DooSabin(DooSabinRows::new(topology, rules)),
            Scheme::Butterfly | Scheme::Kobbelt => return None,
        };
        let (sharp, limit) = (rules.sharpness(topology), LimitRows::new(topology, rules));
        let has_plain_masks = match rules.scheme {
            Scheme::DooSabin => rules.tension.is_some(),
            _ => rules.tension.is_none(),
        };
        Some(Self { topology, rules, sharp, limit, step, has_plain_masks })
    }

    /// How many values there are after the step, besides those of the vertices.
    pub(super) fn new_point_count(&self) -> usize {
        match self.rules.scheme {
            Scheme::DooSabin => self.step.len(),
            _ => self.step.len() - self.topology.vertex_count(),
        }
    }

    /// Doo–Sabin: the vertex that a value is an image of.
    pub(super) fn vertex_of_image(&self, image: usize) -> VertexId {
        match &self.step {
            StepRows::DooSabin(images) => images.vertex(image),
            _ => VertexId(image as u32),
        }
    }

    /// Whether the limit mask of a vertex, and what is made of it, are those of the kernel.
    pub(super) fn is_smooth_vertex(&self, v: VertexId) -> bool {
        self.is_smooth_ring(v, self.topology.valence(v))
    }

    /// As [`is_smooth_vertex`](Self::is_smooth_vertex), of a vertex with so many edges.
    #[inline]
    pub(super) fn is_smooth_ring(&self, v: VertexId, valence: u32) -> bool {
        // There are more edges than faces on the boundary.
        self.has_plain_masks
            && (2..=MOST_NEIGHBOURS).contains(&valence)
            && self.topology.fan_size(v) == valence
            && (self.rules.creases.is_none() || self.is_off_creases(v))
    }

    fn is_off_creases(&self, v: VertexId) -> bool {
        self.sharp.vertex(v) == 0.0 && self.sharp.edges(v).all(|e| self.sharp.edge(e.0) == 0.0)
    }

    /// Whether the point on an edge is that of the smooth rule.
    #[inline]
    pub(super) fn is_smooth_edge(&self, e: EdgeId) -> bool {
        self.rules.tension.is_none()
            && self.rules.creases.as_deref().is_none_or(|c| c.edge(e) == 0.0)
    }

    /// The limit point of a vertex, as it is solved for. Support stays as given.
    pub(super) fn limit(&self, v: VertexId, entries: &mut Vec<(u32, f64)>) {
        entries.clear();
        if self.rules.is_support(self.topology, v) {
            return entries.push((v.0, 1.0));
        }
        rows::gather(&self.limit, v.index(), entries);
    }

    /// A new point that no vertex has to do with.
    pub(super) fn point(&self, row: usize, entries: &mut Vec<(u32, f64)>) -> f64 {
        entries.clear();
        rows::gather(&self.step, row, entries);
        0.0
    }

    /// An image of a vertex, moved with the others so that their mean is met.
    pub(super) fn image(&self, row: usize, v: VertexId, entries: &mut Vec<(u32, f64)>) -> f64 {
        entries.clear();
        let both = Composed(|entry: &mut dyn FnMut(u32, f64)| {
            self.step.visit(row, &mut *entry);
            self.limit.visit(v.index(), |q, weight| entry(q, -weight));
        });
        rows::gather(&both, 0, entries);
        1.0
    }

    /// A vertex pushed back to where its limit point is met.
    pub(super) fn vertex(&self, v: VertexId, entries: &mut Vec<(u32, f64)>) -> f64 {
        entries.clear();
        let mut own = 0.0;
        self.level_one(v, &mut |row, weight| own += if row == v.index() { weight } else { 0.0 });
        let is_support = self.rules.is_support(self.topology, v);
        let pushed = Composed(|entry: &mut dyn FnMut(u32, f64)| {
            if is_support {
                self.limit.visit(v.index(), |q, weight| entry(q, weight / own));
            }
            self.level_one(v, &mut |row, weight| {
                if row != v.index() {
                    self.step.visit(row, |q, w| entry(q, -(weight / own) * w));
                }
            });
        });
        rows::gather(&pushed, 0, entries);
        if is_support { 0.0 } else { 1.0 / own }
    }

    /// The limit point of a vertex in values of the finer mesh.
    fn level_one(&self, v: VertexId, entry: &mut dyn FnMut(usize, f64)) {
        let t = self.topology;
        if t.is_isolated(v) {
            return entry(v.index(), 1.0);
        }
        let on_edge = |e: EdgeId| t.vertex_count() + e.index();
        if self.rules.creases.is_some() {
            let next = Local::new(self.sharp, self.rules, v).next();
            if next.is_special() {
                let rows = local_rows(self.sharp, self.rules.scheme, v);
                return rows.zip(next.limit_row()).for_each(|(row, weight)| entry(row, weight));
            }
        }
        match self.sharp.kind(v, 1) {
            Kind::Corner => entry(v.index(), 1.0),
            Kind::Crease(_) => {
                let kinds = BoundaryKinds { topology: t, corners: self.rules.corners };
                let end = match kinds.of(v).filter(|_| self.rules.scheme == Scheme::Loop) {
                    // All new points on the boundary are regular.
                    Some(kind) => boundary_limit_weight(kind, BoundaryKind::Regular),
                    None => catmull_clark::CURVE_LIMIT[1],
                };
                entry(v.index(), 1.0 - 2.0 * end);
                self.sharp.sharp_edges(v, 1).for_each(|(e, _)| entry(on_edge(e), end));
            }
            Kind::Smooth => {
                let n = t.fan_size(v);
                let size = f64::from(n);
                let [own, edge, face] = match self.rules.scheme {
                    Scheme::Loop => {
                        let own = limit_weight(n.max(2));
                        [own, (1.0 - own) / size, 0.0]
                    }
                    _ => [size, 4.0 / size, 1.0 / size].map(|w| w / (size + 5.0)),
                };
                entry(v.index(), own);
                t.fan(v).for_each(|h| entry(on_edge(t.edge(h)), edge));
                if face > 0.0 {
                    let first = t.vertex_count() + t.edge_count();
                    t.fan(v).for_each(|h| entry(first + t.face(h).index(), face));
                }
            }
        }
    }
}

/// One row that a closure tells.
struct Composed<F>(F);

impl<F: Fn(&mut dyn FnMut(u32, f64)) + Sync> Rows for Composed<F> {
    fn len(&self) -> usize {
        1
    }

    fn visit(&self, _: usize, mut entry: impl FnMut(u32, f64)) {
        (self.0)(&mut entry);
    }
}
