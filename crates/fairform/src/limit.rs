//! Limit positions, tangents and normals at the vertices of a mesh.

use alloc::vec::Vec;

use crate::crease::{Kind, Sharpness};
use crate::error::Error;
use crate::ids::VertexId;
use crate::refine::{DooSabinRows, PhaseOne};
use crate::rows::{self, Rows};
use crate::rules::{BoundaryKinds, by_valence};
use crate::scheme::loop_scheme::{BoundaryKind, boundary_limit_weight, limit_weight};
use crate::scheme::{Border, Rules, Scheme, catmull_clark};
use crate::tension::Shares;
use crate::{Stencils, Topology, Vec3};

mod interpolating;
pub(crate) mod local;
mod normals;
pub(crate) mod operator;

pub use normals::{limit_corner_normals, limit_normals, limit_tangents};
pub(crate) use normals::{side_tangents, vertex_tangents};

use local::{Local, local_rows};

/// The rows that take control points to the limit points of the vertices, one row per vertex. An
/// isolated vertex is its own limit point, as is every vertex in an interpolating scheme.
///
/// # Errors
/// As [`Rules::check`]; [`Error::NoLimit`] for vertices that Doo and Sabin's scheme gives no limit
/// point: those with two faces, and on the boundary with [`Border::Drop`].
pub fn limit_stencils(topology: &Topology, rules: &Rules) -> Result<Stencils, Error> {
    check(topology, rules)?;
    Ok(rows::stencils(&LimitRows::new(topology, rules), topology.vertex_count()))
}

/// The limit points of all vertices for control points `points`.
///
/// # Errors
/// As [`limit_stencils`].
///
/// # Panics
/// If there is not one point per vertex.
pub fn limit_points(
    topology: &Topology,
    points: &[Vec3],
    rules: &Rules,
) -> Result<Vec<Vec3>, Error> {
    assert_eq!(points.len(), topology.vertex_count(), "one point per vertex");
    check(topology, rules)?;
    Ok(rows::apply(&LimitRows::new(topology, rules), points))
}

/// Whether all vertices have limit points.
pub(crate) fn check(topology: &Topology, rules: &Rules) -> Result<(), Error> {
    rules.check(topology)?;
    if rules.scheme != Scheme::DooSabin {
        return Ok(());
    }
    let scheme = rules.scheme.name();
    let has_none = |v: &VertexId| match topology.is_boundary(*v) {
        true => rules.border == Border::Drop,
        false => topology.fan_size(*v) == 2,
    };
    topology.vertices().find(has_none).map_or(Ok(()), |vertex| {
        let reason = match topology.is_boundary(vertex) {
            true => "it is on the boundary, which is dropped",
            false => "it has only two faces",
        };
        Err(Error::NoLimit { vertex, scheme, reason })
    })
}

/// One row per vertex: its limit point.
pub(crate) struct LimitRows<'t> {
    rules: &'t Rules,
    sharp: Sharpness<'t>,
    /// Loop: weight of the vertex by valence.
    centre: Vec<f64>,
    images: Option<DooSabinRows<'t>>,
    /// Loop and Catmull–Clark in two phases.
    phase_one: Option<(PhaseOne<'t>, Shares<'t>)>,
}

impl<'t> LimitRows<'t> {
    pub(crate) fn new(topology: &'t Topology, rules: &'t Rules) -> Self {
        let centre = match rules.scheme {
            Scheme::Loop => by_valence(topology, limit_weight),
            _ => Vec::new(),
        };
        let images = (rules.scheme == Scheme::DooSabin).then(|| DooSabinRows::new(topology, rules));
        let phase_one = PhaseOne::new(topology, rules).zip(rules.shares(topology));
        Self { rules, sharp: rules.sharpness(topology), centre, images, phase_one }
    }

    fn curve(&self, v: VertexId, ends: [VertexId; 2], entry: &mut impl FnMut(u32, f64)) {
        let topology = self.sharp.topology;
        let (own, [a, b]) = if self.rules.scheme == Scheme::Loop && topology.is_boundary(v) {
            let kinds = BoundaryKinds { topology, corners: self.rules.corners };
            // The ends are in the order of the ring: the boundary goes on to the first.
            let [own, before, after] = kinds.limit_weights(v);
            (own, [after, before])
        } else {
            let [own, end] = catmull_clark::CURVE_LIMIT;
            (own, [end; 2])
        };
        entry(v.0, own);
        entry(ends[0].0, a);
        entry(ends[1].0, b);
    }

    fn smooth(&self, v: VertexId, entry: &mut impl FnMut(u32, f64)) {
        let topology = self.sharp.topology;
        let n = topology.fan_size(v);
        if self.rules.scheme == Scheme::Loop {
            let own = self.centre[n as usize];
            entry(v.0, own);
            let each = (1.0 - own) / f64::from(n);
            topology.ring(v).for_each(|q| entry(q.0, each));
        } else {
            let [own, edge, face] = catmull_clark::limit_weights(n);
            entry(v.0, own);
            topology.ring(v).for_each(|q| entry(q.0, edge));
            self.faces(v, |_| face, entry);
        }
    }

    /// [`curve`](Self::curve) in two phases: phase one and then the mask of the finer curve.
    fn two_phase_curve(&self, v: VertexId, shares: Shares<'_>, entry: &mut impl FnMut(u32, f64)) {
        let topology = self.sharp.topology;
        let on_boundary = self.rules.scheme == Scheme::Loop && topology.is_boundary(v);
        let kinds = BoundaryKinds { topology, corners: self.rules.corners };
        let end = match kinds.of(v).filter(|_| on_boundary) {
            // All new points on the boundary are regular.
            Some(kind) => boundary_limit_weight(kind, BoundaryKind::Regular),
            None => catmull_clark::CURVE_LIMIT[1],
        };
        let mut own = 1.0;
        for (e, q) in self.sharp.sharp_edges(v, 0) {
            let share = shares.edge(e);
            let bias = if on_boundary { kinds.edge_weights(v, q)[1] - 0.5 } else { 0.0 };
            let weight = (1.0 - 2.0 * end) * catmull_clark::CURVE_VERTEX[1] * share
                + end * (0.5 + bias * share);
            own -= weight;
            entry(q.0, weight);
        }
        entry(v.0, own);
    }

    /// [`smooth`](Self::smooth) in two phases, in closed form.
    fn two_phase_smooth(&self, v: VertexId, shares: Shares<'_>, entry: &mut impl FnMut(u32, f64)) {
        let topology = self.sharp.topology;
        let (n, around) = (topology.fan_size(v), shares.around(v));
        let size = f64::from(n);
        if self.rules.scheme == Scheme::Loop {
            let own = self.centre[n as usize];
            let each = (1.0 - own) / size;
            entry(v.0, own + 0.5 * each * (size - around));
            for h in topology.fan(v) {
                let weight = 0.25 * each * (1.0 + shares.face(topology.face(h)));
                entry(topology.target(h).0, weight);
                entry(topology.origin(topology.prev(h)).0, weight);
            }
        } else {
            let whole = size * (size + 5.0);
            entry(v.0, (size * (size + 2.0) - 3.0 * around) / whole);
            topology.ring(v).for_each(|q| entry(q.0, 2.0 / whole));
            for h in topology.fan(v) {
                let f = topology.face(h);
                let weight = (1.0 + 3.0 * shares.face(f)) / whole;
                crate::refine::centroid(topology, f, weight, entry);
            }
        }
    }

    /// The centroids of the faces at a vertex, with weights by their place.
    fn faces(&self, v: VertexId, weight: impl Fn(usize) -> f64, entry: &mut impl FnMut(u32, f64)) {
        let topology = self.sharp.topology;
        for (i, h) in topology.fan(v).enumerate() {
            crate::refine::centroid(topology, topology.face(h), weight(i), entry);
        }
    }

    /// By refining the neighbourhood, where no mask is known.
    fn special(&self, v: VertexId, local: &Local, entry: &mut impl FnMut(u32, f64)) {
        if let Some((phase_one, _)) = &self.phase_one {
            let weights = local.next().limit_row();
            let rows = local_rows(self.sharp, self.rules.scheme, v);
            for (row, weight) in rows.zip(weights).filter(|r| r.1 != 0.0) {
                phase_one.visit(row, |q, w| entry(q, weight * w));
            }
            return;
        }
        let row = local.limit_row();
        let m = local.edges.len();
        entry(v.0, row[0]);
        for (q, &w) in self.sharp.topology.ring(v).zip(&row[1..=m]) {
            entry(q.0, w);
        }
        if row.len() > 1 + m {
            self.faces(v, |i| row[1 + m + i], entry);
        }
    }

    fn doo_sabin(&self, images: &DooSabinRows<'_>, v: VertexId, entry: &mut impl FnMut(u32, f64)) {
        let topology = self.sharp.topology;
        if topology.is_boundary(v) {
            let (Some(first), Some(last)) = (topology.outgoing(v), topology.fan(v).last()) else {
                return;
            };
            images.edge_image(first, v, 0.5, entry);
            images.edge_image(topology.prev(last), v, 0.5, entry);
        } else {
            let share = 1.0 / f64::from(topology.fan_size(v));
            topology.fan(v).for_each(|h| images.image(h, share, entry));
        }
    }
}

impl Rows for LimitRows<'_> {
    fn len(&self) -> usize {
        self.sharp.topology.vertex_count()
    }

    fn by_ring(&self) -> Option<&Topology> {
        let plain = self.rules.scheme == Scheme::Loop
            && self.sharp.creases.is_none()
            && self.phase_one.is_none();
        plain.then_some(self.sharp.topology)
    }

    #[inline]
    fn visit_vertex(&self, v: VertexId, ring: &[u32], mut entry: impl FnMut(u32, f64)) {
        if ring.is_empty() || self.sharp.topology.is_boundary(v) {
            return self.visit(v.index(), entry);
        }
        let own = self.centre[ring.len()];
        entry(v.0, own);
        let each = (1.0 - own) / ring.len() as f64;
        ring.iter().for_each(|&q| entry(q, each));
    }

    #[inline]
    fn visit(&self, row: usize, mut entry: impl FnMut(u32, f64)) {
        let v = VertexId(row as u32);
        if self.sharp.topology.is_isolated(v) || self.rules.scheme.is_interpolating() {
            return entry(v.0, 1.0);
        }
        if let Some(images) = &self.images {
            return self.doo_sabin(images, v, &mut entry);
        }
        if self.sharp.creases.is_some() {
            let local = Local::new(self.sharp, self.rules, v);
            if local.is_special() {
                return self.special(v, &local, &mut entry);
            }
        }
        let shares = self.phase_one.as_ref().map(|p| p.1);
        match (self.sharp.kind(v, 0), shares) {
            (Kind::Corner, _) => entry(v.0, 1.0),
            (Kind::Crease(ends), None) => self.curve(v, ends, &mut entry),
            (Kind::Crease(_), Some(shares)) => self.two_phase_curve(v, shares, &mut entry),
            (Kind::Smooth, None) => self.smooth(v, &mut entry),
            (Kind::Smooth, Some(shares)) => self.two_phase_smooth(v, shares, &mut entry),
        }
    }
}
