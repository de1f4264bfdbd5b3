//! Loop refinement in closed form: children are numbered by arithmetic, nothing is searched.
//!
//! ```text
//!              c                  face f = (a, b, c) with half-edges 3f, 3f+1, 3f+2
//!             ╱ ╲                 and midpoints m_0 on ab, m_1 on bc, m_2 on ca becomes
//!            ╱ 2 ╲                  4f    (a, m_0, m_2)
//!       m_2 ───── m_1               4f+1  (b, m_1, m_0)
//!          ╱ ╲ 3 ╱ ╲                4f+2  (c, m_2, m_1)
//!         ╱ 0 ╲ ╱ 1 ╲               4f+3  (m_0, m_1, m_2)
//!        a ──── m_0 ─── b
//! ```

use alloc::vec::Vec;

use crate::crease::{Kind, Sharpness};
use crate::ids::{EdgeId, HalfedgeId, NONE, VertexId};
use crate::rows::Rows;
use crate::rules::{BoundaryKinds, by_valence};
use crate::scheme::Rules;
use crate::scheme::loop_scheme::ring_weight;
use crate::tension::Shares;
use crate::topology::Triangles;
use crate::{Topology, Vec3, par};

/// The half-edge of the finer mesh with which parent half-edge `h` begins.
fn first_half(h: u32) -> u32 {
    12 * (h / 3) + 3 * (h % 3)
}

/// The half-edge of the finer mesh with which parent half-edge `h` ends.
fn second_half(h: u32) -> u32 {
    12 * (h / 3) + 3 * (h % 3 + 1) % 9 + 2
}

pub(super) fn finer_topology(coarse: &Topology) -> Topology {
    let face_count = coarse.face_count();
    let numbering = EdgeNumbering::new(coarse);
    let mut origin = alloc::vec![0; 12 * face_count];
    let mut twin = alloc::vec![0; 12 * face_count];
    let mut edge = alloc::vec![0; 12 * face_count];
    par::join(
        || {
            let vertex_count = coarse.vertex_count() as u32;
            par::fill(origin.as_chunks_mut().0, |f| {
                let h = 3 * f as u32;
                let [a, b, c] = [0, 1, 2].map(|i| coarse.origin(HalfedgeId(h + i)).0);
                let [m0, m1, m2] = [0, 1, 2].map(|i| vertex_count + edge_of(coarse, h + i));
                [a, m0, m2, b, m1, m0, c, m2, m1, m0, m1, m2]
            });
        },
        || {
            let (twin, edge) = (twin.as_chunks_mut().0, edge.as_chunks_mut().0);
            par::for_blocks2(twin, edge, |start, twin, edge| {
                for (i, (twin, edge)) in twin.iter_mut().zip(edge).enumerate() {
                    children(coarse, &numbering, (start + i) as u32, twin, edge);
                }
            });
        },
    );
    let edge_halfedge = numbering.edge_halfedge;

    let old = coarse.vertex_count();
    let mut outgoing = alloc::vec![0; old + coarse.edge_count()];
    let mut fan = alloc::vec![0; old + coarse.edge_count()];
    par::fill(&mut outgoing[..old], |v| {
        coarse.outgoing(VertexId(v as u32)).map_or(NONE, |h| first_half(h.0))
    });
    par::fill(&mut fan[..old], |v| coarse.fan_size(VertexId(v as u32)));
    par::for_blocks2(&mut outgoing[old..], &mut fan[old..], |start, outgoing, fan| {
        for (i, (outgoing, fan)) in outgoing.iter_mut().zip(fan).enumerate() {
            let h = coarse.edge_halfedge(EdgeId((start + i) as u32)).0;
            let is_boundary = twin_of(coarse, h) == NONE;
            *fan = if is_boundary { 3 } else { 6 };
            *outgoing = match (is_boundary, h % 3) {
                (true, _) => second_half(h),
                (false, 0) => 12 * (h / 3) + 1,
                (false, 1) => 12 * (h / 3) + 4,
                (false, _) => 12 * (h / 3) + 2,
            };
        }
    });
    Topology::from_triangles(Triangles { origin, twin, edge, edge_halfedge, outgoing, fan })
}

fn edge_of(coarse: &Topology, h: u32) -> u32 {
    coarse.edge(HalfedgeId(h)).0
}

fn twin_of(coarse: &Topology, h: u32) -> u32 {
    coarse.twin(HalfedgeId(h)).map_or(NONE, |t| t.0)
}

/// Whether `h` is the half-edge at which its edge appears first.
fn leads(coarse: &Topology, h: u32) -> bool {
    let t = twin_of(coarse, h);
    t == NONE || t > h
}

/// The finer edges, numbered by first appearance: each corner child `(v, m_i, m_{i-1})` shows the
/// first half of parent half-edge `i`, an inner edge, and the second half of the previous one.
struct EdgeNumbering {
    /// For each parent face, the edge inside each corner.
    inner: Vec<[u32; 3]>,
    /// For each parent edge, its halves in the direction of its first half-edge.
    halves: Vec<[u32; 2]>,
    edge_halfedge: Vec<u32>,
}

impl EdgeNumbering {
    fn new(coarse: &Topology) -> Self {
        let face_count = coarse.face_count();
        let mut inner = alloc::vec![[0; 3]; face_count];
        let mut halves = alloc::vec![[0; 2]; coarse.edge_count()];
        let mut edge_halfedge = alloc::vec![0; 2 * coarse.edge_count() + 3 * face_count];
        // Those of a block of faces are numbered in a row, since the edges of the parents are.
        let sizes = par::blocks(face_count, |faces| {
            let halfedges = 3 * faces.start as u32..3 * faces.end as u32;
            (faces.len(), halfedges.filter(|&h| leads(coarse, h)).count())
        });
        let all_inner = par::cut(&mut inner, sizes.iter().map(|s| s.0));
        let all_halves = par::cut(&mut halves, sizes.iter().map(|s| s.1));
        let all_own = par::cut(&mut edge_halfedge, sizes.iter().map(|s| 3 * s.0 + 2 * s.1));
        let (mut face, mut edge) = (0, 0);
        let mut parts = Vec::with_capacity(sizes.len());
        for (((inner, halves), own), size) in
            all_inner.into_iter().zip(all_halves).zip(all_own).zip(&sizes)
        {
            parts.push(NumberedBlock { face, edge, inner, halves, edge_halfedge: own });
            (face, edge) = (face + size.0, edge + size.1);
        }
        par::in_parts(parts, |part| part.number(coarse));
        Self { inner, halves, edge_halfedge }
    }
}

/// A part of [`EdgeNumbering`]: some faces and the edges that begin with them, from these on.
struct NumberedBlock<'o> {
    face: usize,
    edge: usize,
    inner: &'o mut [[u32; 3]],
    halves: &'o mut [[u32; 2]],
    edge_halfedge: &'o mut [u32],
}

impl NumberedBlock<'_> {
    fn number(self, coarse: &Topology) {
        let first = (3 * self.face + 2 * self.edge) as u32;
        let mut count = 0;
        let mut push = |halfedge| {
            self.edge_halfedge[count] = halfedge;
            count += 1;
            first + count as u32 - 1
        };
        for (own, f) in self.inner.iter_mut().zip(self.face as u32..) {
            let h = 3 * f;
            let lead = [leads(coarse, h), leads(coarse, h + 1), leads(coarse, h + 2)];
            let edge = [0, 1, 2].map(|i| edge_of(coarse, h + i) as usize);
            for i in 0..3 {
                let before = (i + 2) % 3;
                let place = 12 * f + 3 * i as u32;
                if lead[i] {
                    self.halves[edge[i] - self.edge][0] = push(place);
                }
                own[i] = push(place + 1);
                if lead[before] {
                    self.halves[edge[before] - self.edge][1] = push(place + 2);
                }
            }
        }
    }
}

/// Twins and edges of the twelve half-edges of the children of face `f`.
fn children(
    coarse: &Topology,
    numbering: &EdgeNumbering,
    f: u32,
    twin: &mut [u32; 12],
    edge: &mut [u32; 12],
) {
    for i in 0..3 {
        let h = 3 * f + i as u32;
        // Places within the children: first half, inner edge seen from the corner and from the
        // centre, second half.
        let (first, corner, centre, second) =
            (3 * i, 3 * i + 1, 9 + (i + 2) % 3, 3 * ((i + 1) % 3) + 2);
        twin[corner] = 12 * f + centre as u32;
        twin[centre] = 12 * f + corner as u32;
        edge[corner] = numbering.inner[f as usize][i];
        edge[centre] = edge[corner];
        let halves = numbering.halves[edge_of(coarse, h) as usize];
        let t = twin_of(coarse, h);
        (twin[first], twin[second]) =
            if t == NONE { (NONE, NONE) } else { (second_half(t), first_half(t)) };
        [edge[first], edge[second]] = if t > h { halves } else { [halves[1], halves[0]] };
    }
}

/// The half-edges with which the halves of the edge of `h` begin and end.
pub(super) fn halves(h: u32) -> [u32; 2] {
    [first_half(h), second_half(h)]
}

/// The finer values: vertices by their rule, then the points on the edges.
pub(crate) struct LoopRows<'t> {
    sharp: Sharpness<'t>,
    shares: Option<Shares<'t>>,
    kinds: BoundaryKinds<'t>,
    /// Weight of the ring by valence.
    ring: Vec<f64>,
}

impl<'t> LoopRows<'t> {
    pub(crate) fn new(topology: &'t Topology, rules: &'t Rules) -> Self {
        Self {
            sharp: rules.sharpness(topology),
            shares: rules.shares(topology),
            kinds: BoundaryKinds { topology, corners: rules.corners },
            ring: by_valence(topology, ring_weight),
        }
    }

    fn vertex(&self, v: VertexId, ring: &[u32], mut entry: impl FnMut(u32, f64)) {
        let topology = self.sharp.topology;
        if topology.is_isolated(v) {
            return entry(v.0, 1.0);
        }
        if let Some(shares) = self.shares {
            return super::two_phase_vertex(self.sharp, shares, v, &mut entry, |share, entry| {
                let n = topology.fan_size(v);
                let each = self.ring[n as usize] / f64::from(n) * share;
                entry(v.0, share - each * shares.around(v));
                for h in topology.fan(v) {
                    let plain = shares.face(topology.face(h)) * each;
                    entry(topology.target(h).0, 0.5 * plain);
                    entry(topology.origin(topology.prev(h)).0, 0.5 * plain);
                }
            });
        }
        for (kind, share) in self.sharp.blend(v).into_iter().filter(|b| b.1 > 0.0) {
            match kind {
                Kind::Corner => entry(v.0, share),
                Kind::Crease(ends) => {
                    entry(v.0, 0.75 * share);
                    ends.iter().for_each(|q| entry(q.0, 0.125 * share));
                }
                Kind::Smooth => {
                    let n = ring.len();
                    let together = self.ring[n];
                    entry(v.0, (1.0 - together) * share);
                    let each = together / n as f64 * share;
                    ring.iter().for_each(|&q| entry(q, each));
                }
            }
        }
    }

    fn edge(&self, e: EdgeId, mut entry: impl FnMut(u32, f64)) {
        let topology = self.sharp.topology;
        let h = topology.edge_halfedge(e);
        let (a, b) = (topology.origin(h), topology.target(h));
        let Some(t) = topology.twin(h) else {
            let mut weights = self.kinds.edge_weights(a, b);
            if let Some(shares) = self.shares {
                weights = weights.map(|w| 0.5 + shares.edge(e) * (w - 0.5));
            }
            entry(a.0, weights[0]);
            return entry(b.0, weights[1]);
        };
        let smooth = 1.0 - self.sharp.edge(e).min(1.0);
        if let Some(shares) = self.shares {
            let plain = [h, t].map(|h| shares.face(topology.face(h)) * smooth);
            let end = 0.5 - 0.0625 * (plain[0] + plain[1]);
            entry(a.0, end);
            entry(b.0, end);
            for (h, plain) in [h, t].into_iter().zip(plain).filter(|p| p.1 > 0.0) {
                entry(topology.origin(topology.prev(h)).0, 0.125 * plain);
            }
            return;
        }
        let (end, wing) = (0.5 - 0.125 * smooth, 0.125 * smooth);
        entry(a.0, end);
        entry(b.0, end);
        if wing > 0.0 {
            entry(topology.origin(topology.prev(h)).0, wing);
            entry(topology.origin(topology.prev(t)).0, wing);
        }
    }
}

impl Rows for LoopRows<'_> {
    fn len(&self) -> usize {
        self.sharp.topology.vertex_count() + self.sharp.topology.edge_count()
    }

    #[inline]
    fn visit(&self, row: usize, entry: impl FnMut(u32, f64)) {
        match row.checked_sub(self.sharp.topology.vertex_count()) {
            None => {
                let v = VertexId(row as u32);
                let mut ring = alloc::vec![0; self.sharp.topology.valence(v) as usize];
                self.sharp.topology.rings(core::iter::once(v), &mut ring);
                self.visit_vertex(v, &ring, entry);
            }
            Some(e) => self.edge(EdgeId(e as u32), entry),
        }
    }

    fn by_ring(&self) -> Option<&Topology> {
        Some(self.sharp.topology)
    }

    #[inline]
    fn visit_vertex(&self, v: VertexId, ring: &[u32], entry: impl FnMut(u32, f64)) {
        self.vertex(v, ring, entry);
    }
}

/// Linear interpolation within each face.
pub(super) fn apply_to_corners(values: &[Vec3]) -> Vec<Vec3> {
    let mut finer = alloc::vec![Vec3::ZERO; 4 * values.len()];
    par::fill(finer.as_chunks_mut().0, |f| {
        let [a, b, c] = [values[3 * f], values[3 * f + 1], values[3 * f + 2]];
        let [m0, m1, m2] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
        [a, m0, m2, b, m1, m0, c, m2, m1, m0, m1, m2]
    });
    finer
}
