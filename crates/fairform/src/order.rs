//! The order in which vertices lie in memory while a solver iterates on them.
//!
//! Gathering neighbours is as fast as memory lets it be if they lie near each other, and several
//! times slower if they do not. The order inside is nobody's concern outside: results come back in
//! the numbering of the mesh.

use alloc::vec::Vec;

use crate::ids::{NONE, VertexId};
use crate::parted::{self, Parted};
use crate::{Bounds, Topology, Vec3, par};

/// Vertices that fit into a core's cache: nearer neighbours than this cost nothing to speak of.
const NEAR: u32 = 8192;

/// Share of far neighbours at which a better order pays within a few iterations.
const TOO_MANY: f64 = 0.05;

/// The vertices in an order in which neighbours are near: as they are, if they are; otherwise along
/// their positions, if those are known; otherwise as the faces show them, if that is good; otherwise by
/// walking breadth-first.
pub(crate) fn by_locality(
    topology: &Topology,
    vertices: Vec<u32>,
    positions: Option<&[Vec3]>,
) -> Vec<u32> {
    if vertices.len() <= 4 * NEAR as usize {
        return vertices;
    }
    let count = topology.vertex_count();
    let far = |order: &[u32]| share_of_far_neighbours(topology, order);
    if far(&vertices) <= TOO_MANY {
        return vertices;
    }
    let mut wanted = alloc::vec![false; count];
    for &v in &vertices {
        wanted[v as usize] = true;
    }
    if let Some(positions) = positions {
        let mut order = by_position(positions);
        order.retain(|&v| wanted[v as usize]);
        return order;
    }
    let shown = by_appearance(topology, wanted.clone(), vertices.len());
    if far(&shown) <= 2.0 * TOO_MANY { shown } else { breadth_first(topology, wanted, &vertices) }
}

/// Bits of a Morton code per coordinate: on a surface, cells enough for some ten million vertices.
const BITS: u32 = 10;

/// The vertices along Morton's curve through their positions: what lies near in space lies near in
/// the order. Those in one cell keep their order. Positions that are not finite come first.
fn by_position(positions: &[Vec3]) -> Vec<u32> {
    let bounds = bounds(positions);
    let side = bounds.longest_side();
    let scale = if side > 0.0 { f64::from((1_u32 << BITS) - 1) / side } else { 0.0 };
    let code = |p: Vec3| {
        // What is not finite is cast to zero.
        let cell = scale * (p - bounds.min);
        spread(cell.x as u32) | spread(cell.y as u32) << 1 | spread(cell.z as u32) << 2
    };
    let mut cells = Parted::new(&parted::blocks(positions.len()), 1 << BITS, |block| {
        block.map(|v| {
            let code = code(positions[v]);
            (code >> (2 * BITS), u64::from(code) << 32 | v as u64)
        })
    });
    par::in_parts(cells.parts_mut(), |(_, cells)| cells.sort_unstable());
    par::collect(positions.len(), |i| cells.items[i] as u32)
}

/// The smallest box around the positions that are finite, or around the origin as well if a block has none.
pub(crate) fn bounds(positions: &[Vec3]) -> Bounds {
    let corners = par::blocks(positions.len(), |range| {
        Bounds::of(positions[range].iter().copied().filter(|p| p.is_finite()))
    });
    Bounds::of(corners.into_iter().flat_map(|b| [b.min, b.max]))
}

/// The lowest bits of a number, two zeros between each.
fn spread(x: u32) -> u32 {
    let x = x & ((1 << BITS) - 1);
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Share of neighbours, at some of the vertices, that lie far off in an order.
fn share_of_far_neighbours(topology: &Topology, order: &[u32]) -> f64 {
    const STRIDE: usize = 61;
    let mut place = alloc::vec![NONE; topology.vertex_count()];
    for (i, &v) in order.iter().enumerate() {
        place[v as usize] = i as u32;
    }
    let blocks = par::blocks(order.len() / STRIDE, |range| {
        let (mut far, mut all) = (0_u32, 0_u32);
        for i in range.map(|i| i * STRIDE) {
            for q in topology.ring(VertexId(order[i])) {
                let at = place[q.index()];
                all += 1;
                far += u32::from(at != NONE && at.abs_diff(i as u32) > NEAR);
            }
        }
        (far, all)
    });
    let (far, all) = blocks.into_iter().fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    f64::from(far) / f64::from(all.max(1))
}

/// The wanted vertices as the faces list them.
fn by_appearance(topology: &Topology, mut wanted: Vec<bool>, count: usize) -> Vec<u32> {
    let mut order = Vec::with_capacity(count);
    for h in topology.halfedges() {
        let v = topology.origin(h);
        if core::mem::take(&mut wanted[v.index()]) {
            order.push(v.0);
        }
    }
    order
}

/// The wanted vertices from the first on, each followed by its neighbours.
fn breadth_first(topology: &Topology, mut wanted: Vec<bool>, vertices: &[u32]) -> Vec<u32> {
    let mut order: Vec<u32> = Vec::with_capacity(vertices.len());
    let mut done = 0;
    for &seed in vertices {
        if core::mem::take(&mut wanted[seed as usize]) {
            order.push(seed);
        }
        while let Some(&v) = order.get(done) {
            done += 1;
            for q in topology.ring(VertexId(v)) {
                if core::mem::take(&mut wanted[q.index()]) {
                    order.push(q.0);
                }
            }
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Faces, Mesh, shapes};

    fn shuffled(mesh: &Mesh, shuffle_faces: bool) -> Topology {
        let n = mesh.positions().len() as u64;
        let relabel = |v: u32| (u64::from(v) * 7_919 % n) as u32;
        let faces = mesh.topology().to_faces();
        let count = faces.len();
        let pick = |f: usize| if shuffle_faces { f * 7_919 % count } else { f };
        let faces: Faces = (0..count)
            .map(|f| faces.get(crate::FaceId(pick(f) as u32)))
            .map(|f| f.iter().map(|&v| relabel(v)).collect::<Vec<_>>())
            .collect();
        Topology::from_faces(n as usize, &faces).expect("the same mesh")
    }

    #[test]
    fn every_order_is_near_and_complete() {
        let mesh = shapes::torus(200, 300);
        let all = || (0..60_000).collect::<Vec<u32>>();
        assert_eq!(by_locality(mesh.topology(), all(), None), all(), "a good order stays");
        for shuffle_faces in [false, true] {
            let topology = shuffled(&mesh, shuffle_faces);
            assert!(share_of_far_neighbours(&topology, &all()) > 0.5, "shuffled");
            let mut order = by_locality(&topology, all(), None);
            assert!(share_of_far_neighbours(&topology, &order) < 0.1, "near again");
            order.sort_unstable();
            assert_eq!(order, all(), "each vertex once");
        }
    }

    #[test]
    fn positions_order_any_numbering() {
        let mesh = shapes::torus(200, 300);
        let topology = shuffled(&mesh, true);
        let mut positions = alloc::vec![Vec3::ZERO; 60_000];
        for (v, &p) in mesh.positions().iter().enumerate() {
            positions[v * 7_919 % 60_000] = p;
        }
        let mut order = by_position(&positions);
        assert!(share_of_far_neighbours(&topology, &order) < 0.1, "near");
        order.sort_unstable();
        assert_eq!(order, (0..60_000).collect::<Vec<u32>>(), "each vertex once");
        positions[17] = Vec3::new(f64::NAN, 0.0, f64::INFINITY);
        order = by_position(&positions);
        order.sort_unstable();
        assert_eq!(order, (0..60_000).collect::<Vec<u32>>(), "each vertex once");
        assert_eq!(by_position(&[Vec3::ZERO; 3]), [0, 1, 2]);
        assert!(by_position(&[]).is_empty());
    }

    #[test]
    fn codes_leave_room_for_each_other() {
        for x in [0, 1, 2, 3, 512, 1023] {
            let slow = (0..BITS).map(|b| (x >> b & 1) << (3 * b)).sum::<u32>();
            assert_eq!(spread(x), slow);
        }
    }
}
