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

use super::Refined;
use crate::error::Error;
use crate::ids::{EdgeId, HalfedgeId, NONE, VertexId};
use crate::scheme::Corners;
use crate::scheme::loop_scheme::ring_weight;
use crate::topology::{MAX_HALFEDGES, Triangles};
use crate::{Stencils, Topology, limit, par};

pub(super) fn refine(topology: &Topology, corners: Corners) -> Result<Refined, Error> {
    let halfedges = 4 * topology.halfedge_count() as u64;
    if halfedges > MAX_HALFEDGES {
        return Err(Error::TooLarge { halfedges });
    }
    let (finer, stencils) =
        par::join(|| finer_topology(topology), || position_stencils(topology, corners));
    Ok(Refined { topology: finer, stencils })
}

/// The half-edge of the finer mesh with which parent half-edge `h` begins.
fn first_half(h: u32) -> u32 {
    12 * (h / 3) + 3 * (h % 3)
}

/// The half-edge of the finer mesh with which parent half-edge `h` ends.
fn second_half(h: u32) -> u32 {
    12 * (h / 3) + 3 * (h % 3 + 1) % 9 + 2
}

fn finer_topology(coarse: &Topology) -> Topology {
    let vertex_count = coarse.vertex_count() as u32;
    let face_count = coarse.face_count();
    let edge = |h: u32| coarse.edge(HalfedgeId(h)).0;
    let twin = |h: u32| coarse.twin(HalfedgeId(h)).map_or(NONE, |t| t.0);
    let leads = |h: u32| {
        let t = twin(h);
        t == NONE || t > h
    };

    // Edges first seen before each face: three of its own children are new per face, and two per
    // edge that it is the first to show.
    let mut shown_before: Vec<u32> = Vec::with_capacity(face_count);
    let mut shown = 0;
    for f in 0..face_count as u32 {
        shown_before.push(shown);
        shown += (3 * f..3 * f + 3).map(|h| u32::from(leads(h))).sum::<u32>();
    }
    // The finer edge of each place in a face: of the first half, the inner edge and the second half
    // of a corner, in the order in which the corner child (v, m_i, m_{i-1}) shows them.
    let edges_of_face = |f: u32| {
        let lead = [leads(3 * f), leads(3 * f + 1), leads(3 * f + 2)];
        let mut next = 3 * f + 2 * shown_before[f as usize];
        let mut take = |new: bool| {
            let id = next;
            next += u32::from(new);
            if new { id } else { NONE }
        };
        let mut places = [[NONE; 3]; 3];
        for (i, place) in places.iter_mut().enumerate() {
            *place = [take(lead[i]), take(true), take(lead[(i + 2) % 3])];
        }
        places
    };
    let first_half_edge = |h: u32| edges_of_face(h / 3)[h as usize % 3][0];
    let second_half_edge = |h: u32| edges_of_face(h / 3)[(h as usize + 1) % 3][2];

    let mut origin = alloc::vec![0; 12 * face_count];
    let mut twins = alloc::vec![0; 12 * face_count];
    let mut edges = alloc::vec![0; 12 * face_count];
    par::join(
        || {
            par::fill(origin.as_chunks_mut().0, |f| {
                let h = 3 * f as u32;
                let corner = |i: u32| coarse.origin(HalfedgeId(h + i)).0;
                let [a, b, c] = [corner(0), corner(1), corner(2)];
                let [m0, m1, m2] = [0, 1, 2].map(|i| vertex_count + edge(h + i));
                [a, m0, m2, b, m1, m0, c, m2, m1, m0, m1, m2]
            });
        },
        || {
            let (twins, edges) = (twins.as_chunks_mut::<12>().0, edges.as_chunks_mut::<12>().0);
            par::for_blocks2(twins, edges, |start, twins, edges| {
                for (i, (twin_of, edge_of)) in twins.iter_mut().zip(edges).enumerate() {
                    let f = (start + i) as u32;
                    let own = edges_of_face(f);
                    for i in 0..3 {
                        let h = 3 * f + i;
                        // Within the corner child: first half, inner edge, and the second half of
                        // the previous parent half-edge.
                        let at = 3 * i as usize;
                        let inner = (i as usize + 2) % 3;
                        twin_of[at + 1] = 12 * f + 9 + inner as u32;
                        twin_of[9 + inner] = 12 * f + at as u32 + 1;
                        edge_of[at + 1] = own[i as usize][1];
                        edge_of[9 + inner] = own[i as usize][1];
                        let end = (second_half(h) - 12 * f) as usize;
                        let t = twin(h);
                        if t == NONE {
                            twin_of[at] = NONE;
                            twin_of[end] = NONE;
                        } else {
                            twin_of[at] = second_half(t);
                            twin_of[end] = first_half(t);
                        }
                        if leads(h) {
                            edge_of[at] = own[i as usize][0];
                            edge_of[end] = own[(i as usize + 1) % 3][2];
                        } else {
                            edge_of[at] = second_half_edge(t);
                            edge_of[end] = first_half_edge(t);
                        }
                    }
                }
            });
        },
    );
    drop(shown_before);

    let edge_count = 2 * coarse.edge_count() + 3 * face_count;
    let mut edge_halfedge = Vec::with_capacity(edge_count);
    for (h, &t) in twins.iter().enumerate() {
        if t == NONE || t as usize > h {
            edge_halfedge.push(h as u32);
        }
    }

    let old = coarse.vertex_count();
    let outgoing = par::collect(old + coarse.edge_count(), |v| {
        if v < old {
            return coarse.outgoing(VertexId(v as u32)).map_or(NONE, |h| first_half(h.0));
        }
        let h = coarse.edge_halfedge(EdgeId((v - old) as u32)).0;
        let (face, i) = (12 * (h / 3), h % 3);
        match (twin(h), i) {
            (NONE, _) => second_half(h),
            (_, 0) => face + 1,
            (_, 1) => face + 4,
            _ => face + 2,
        }
    });
    let fan = par::collect(old + coarse.edge_count(), |v| {
        if v < old {
            return coarse.fan_size(VertexId(v as u32));
        }
        if coarse.is_boundary_edge(EdgeId((v - old) as u32)) { 3 } else { 6 }
    });
    let (twin, edge) = (twins, edges);
    Topology::from_triangles(Triangles { origin, twin, edge, edge_halfedge, outgoing, fan })
}

fn position_stencils(topology: &Topology, corners: Corners) -> Stencils {
    let old = topology.vertex_count();
    let kinds = limit::BoundaryKinds { topology, corners };
    let mut row_start = Vec::with_capacity(old + topology.edge_count() + 1);
    let mut end = 0;
    row_start.push(end);
    for v in topology.vertices() {
        end += match kinds.of(v) {
            Some(limit::BoundaryKind::Corner) => 1,
            Some(_) => 3,
            None => 1 + topology.fan_size(v),
        };
        row_start.push(end);
    }
    for e in topology.edges() {
        end += if topology.is_boundary_edge(e) { 2 } else { 4 };
        row_start.push(end);
    }
    let ring_weights = limit::by_valence(topology, ring_weight);
    Stencils::build(old, row_start, &|row, source, weight| {
        if row < old {
            let v = VertexId(row as u32);
            source[0] = v.0;
            if let [_] = source {
                weight[0] = 1.0;
            } else if topology.is_boundary(v) {
                let (left, right) = limit::boundary_neighbours(topology, v);
                source[1..].copy_from_slice(&[left.0, right.0]);
                weight.copy_from_slice(&[0.75, 0.125, 0.125]);
            } else {
                let n = source.len() - 1;
                let ring = ring_weights[n];
                weight[0] = 1.0 - ring;
                weight[1..].fill(ring / n as f64);
                for (slot, q) in source[1..].iter_mut().zip(topology.ring(v)) {
                    *slot = q.0;
                }
            }
        } else {
            let h = topology.edge_halfedge(EdgeId((row - old) as u32));
            let (a, b) = (topology.origin(h), topology.target(h));
            source[..2].copy_from_slice(&[a.0, b.0]);
            if let Some(t) = topology.twin(h) {
                source[2] = topology.origin(topology.prev(h)).0;
                source[3] = topology.origin(topology.prev(t)).0;
                weight.copy_from_slice(&[0.375, 0.375, 0.125, 0.125]);
            } else {
                weight.copy_from_slice(&kinds.edge_weights(a, b));
            }
        }
    })
}
