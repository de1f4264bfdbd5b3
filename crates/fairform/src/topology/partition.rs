//! Pairing half-edges where neighbours lie far apart in memory.
//!
//! Looking up the ends of an edge one by one then waits for memory each time. Here everything is moved
//! in streams instead: half-edges go to the part of the vertices that their lower end lies in, are
//! paired there within a cache, and the pairs go to the part of the half-edges where they are wanted.
//! The result is that of [`Buckets`](super::build), to the last bit.

use alloc::vec::Vec;

use crate::ids::NONE;
use crate::par;
use crate::parted::{Parted, blocks, parts_for};

/// Vertices per part, as a power of two: their half-edges fit into a core's cache.
const VERTICES: u32 = 13;
/// Half-edges per part, likewise.
const HALFEDGES: u32 = 16;

/// Fewest half-edges for which streams pay: fewer lie in the caches anyway.
pub(super) const FEWEST: usize = 1 << 18;

/// Share of faces at which the jump to the next one is far, above which streams pay.
const TOO_MANY: f64 = 0.25;

/// Whether most faces lie far from the one listed before, by the numbers of their first vertices.
pub(super) fn is_scattered(firsts: impl Fn(usize) -> u32, face_count: usize) -> bool {
    const SAMPLES: usize = 2048;
    let step = (face_count / SAMPLES).max(1);
    let (mut far, mut all) = (0, 0);
    for f in (0..face_count.saturating_sub(1)).step_by(step) {
        all += 1;
        far += u32::from(firsts(f).abs_diff(firsts(f + 1)) > 1 << VERTICES);
    }
    f64::from(far) > TOO_MANY * f64::from(all)
}

/// A half-edge on its way to its lower end.
#[derive(Clone, Copy, Default)]
struct Half {
    low: u32,
    high: u32,
    /// The half-edge, doubled, and one more if it runs from the lower end to the higher.
    code: u32,
}

/// The twin of every half-edge, if every edge has one face, or two that run through it in opposite
/// directions. `ends(h)` tells where half-edge `h` begins and ends.
pub(super) fn twins(
    vertex_count: usize,
    halfedge_count: usize,
    ends: impl Fn(usize) -> (u32, u32) + Sync + Send,
) -> Option<Vec<u32>> {
    let mut halves =
        Parted::new(&blocks(halfedge_count), parts_for(vertex_count, VERTICES), |block| {
            block.map(|h| {
                let (from, to) = ends(h);
                let (low, high) = (from.min(to), from.max(to));
                (low >> VERTICES, Half { low, high, code: (h as u32) << 1 | u32::from(from < to) })
            })
        });
    let sound = par::map_parts(halves.parts_mut(), |(part, halves)| pair(part, halves));
    if sound.contains(&false) {
        return None;
    }
    let pairs = Parted::new(&blocks(halfedge_count), parts_for(halfedge_count, HALFEDGES), |b| {
        halves.items[b].iter().map(|half| (half.low >> HALFEDGES, (half.low, half.high)))
    });
    drop(halves);
    let mut twin = alloc::vec![NONE; halfedge_count];
    let work: Vec<_> = twin.chunks_mut(1 << HALFEDGES).enumerate().collect();
    par::in_parts(work, |(part, twin)| {
        for &(h, t) in pairs.part(part) {
            twin[h as usize - (part << HALFEDGES)] = t;
        }
    });
    Some(twin)
}

/// Pairs the half-edges of one part. Each entry then holds a half-edge in `low`, and its twin in
/// `high`. Whether all edges are sound.
fn pair(part: usize, halves: &mut [Half]) -> bool {
    let first = (part << VERTICES) as u32;
    let mut start = alloc::vec![0_u32; (1 << VERTICES) + 1];
    halves.iter().for_each(|half| start[(half.low - first) as usize + 1] += 1);
    for v in 0..1 << VERTICES {
        start[v + 1] += start[v];
    }
    let mut next = start.clone();
    let mut sorted = alloc::vec![0_u64; halves.len()];
    for half in &*halves {
        let slot = &mut next[(half.low - first) as usize];
        sorted[*slot as usize] = u64::from(half.high) << 32 | u64::from(half.code);
        *slot += 1;
    }
    let mut done = 0;
    for w in start.windows(2) {
        let bucket = &mut sorted[w[0] as usize..w[1] as usize];
        bucket.sort_unstable();
        let mut at = 0;
        while at < bucket.len() {
            let same = |i: usize| bucket.get(i).is_some_and(|e| e >> 32 == bucket[at] >> 32);
            let code = |i: usize| bucket[i] as u32;
            let mut put = |h: u32, twin: u32| {
                halves[done] = Half { low: h, high: twin, code: 0 };
                done += 1;
            };
            if !same(at + 1) {
                put(code(at) >> 1, NONE);
                at += 1;
            } else if same(at + 2) || (code(at) ^ code(at + 1)) & 1 == 0 {
                return false;
            } else {
                put(code(at) >> 1, code(at + 1) >> 1);
                put(code(at + 1) >> 1, code(at) >> 1);
                at += 2;
            }
        }
    }
    true
}

/// What is known of the corners at each vertex.
pub(super) struct Fans {
    /// A half-edge from each vertex, on the boundary the one without a twin.
    pub(super) outgoing: Vec<u32>,
    /// The number of faces at each vertex.
    pub(super) size: Vec<u32>,
    /// Whether the faces at some vertex form several fans.
    pub(super) is_any_split: bool,
}

/// A corner on its way to its vertex.
#[derive(Clone, Copy, Default)]
struct Corner {
    vertex: u32,
    halfedge: u32,
    /// The next half-edge from the vertex, counter-clockwise.
    after: u32,
    is_on_boundary: bool,
}

/// Collects the corners at each vertex. `prev(h)` is the half-edge before `h` in its face.
pub(super) fn fans(
    vertex_count: usize,
    origin: &[u32],
    twin: &[u32],
    prev: impl Fn(usize) -> usize + Sync + Send,
) -> Fans {
    let mut corners =
        Parted::new(&blocks(origin.len()), parts_for(vertex_count, VERTICES), |block| {
            block.map(|h| {
                let (vertex, after) = (origin[h], twin[prev(h)]);
                let is_on_boundary = twin[h] == NONE;
                let corner = Corner { vertex, halfedge: h as u32, after, is_on_boundary };
                (vertex >> VERTICES, corner)
            })
        });
    let mut outgoing = alloc::vec![NONE; vertex_count];
    let mut size = alloc::vec![0; vertex_count];
    let arrays = outgoing.chunks_mut(1 << VERTICES).zip(size.chunks_mut(1 << VERTICES));
    let work: Vec<_> = corners.parts_mut().into_iter().zip(arrays).collect();
    let split = par::map_parts(work, |((part, corners), (outgoing, size))| {
        corners.iter().for_each(|c| size[c.vertex as usize - (part << VERTICES)] += 1);
        // Half-edge and the next one, by vertex.
        let mut sorted = alloc::vec![(0, 0); corners.len()];
        let mut next = Vec::with_capacity(size.len());
        let mut end = 0;
        for &count in &*size {
            next.push(end);
            end += count;
        }
        for c in corners {
            let i = c.vertex as usize - (part << VERTICES);
            sorted[next[i] as usize] = (c.halfedge, c.after);
            next[i] += 1;
            // The first on the boundary, the first of all otherwise; in the order of half-edges.
            if outgoing[i] == NONE || (c.is_on_boundary && !is_boundary(twin, outgoing[i])) {
                outgoing[i] = c.halfedge;
            }
        }
        let (mut rest, mut is_any_split) = (sorted.as_slice(), false);
        for (&first, &count) in outgoing.iter().zip(&*size) {
            let (own, others) = rest.split_at(count as usize);
            is_any_split |= count > 0 && !is_one_fan(first, own);
            rest = others;
        }
        is_any_split
    });
    Fans { outgoing, size, is_any_split: split.contains(&true) }
}

fn is_boundary(twin: &[u32], h: u32) -> bool {
    twin[h as usize] == NONE
}

/// Whether going from corner to corner, beginning at `first`, shows all of them. The corners are in the
/// order of their half-edges.
fn is_one_fan(first: u32, corners: &[(u32, u32)]) -> bool {
    let (mut at, mut seen) = (first, 0);
    loop {
        let found = if corners.len() <= 32 {
            corners.iter().find(|c| c.0 == at)
        } else {
            corners.binary_search_by_key(&at, |c| c.0).ok().map(|i| &corners[i])
        };
        seen += 1;
        match found {
            Some(&(_, after)) if after != NONE && after != first && seen < corners.len() => {
                at = after;
            }
            _ => return seen == corners.len(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::{Defect, Defects};
    use crate::refine::refine_mesh;
    use crate::{Error, FaceId, Faces, Rules, Scheme, Topology, VertexId, shapes};

    /// A torus of so many quadrilaterals or twice so many triangles, all in disorder.
    fn torus(triangles: bool) -> (usize, Faces) {
        let (side, rules) =
            if triangles { (210, Rules::LOOP) } else { (110, Scheme::CatmullClark.into()) };
        let mesh = shapes::torus(side, side + 1);
        let mesh = if triangles { mesh } else { refine_mesh(&mesh, &rules, 1).expect("small").0 };
        let (n, faces) = (mesh.positions().len(), mesh.topology().to_faces());
        let count = faces.len();
        let faces = (0..count)
            .map(|f| faces.get(FaceId((f * 7_919 % count) as u32)))
            .map(|f| f.iter().map(|&v| (v as usize * 7_919 % n) as u32).collect::<Vec<_>>());
        (n, faces.collect())
    }

    /// The same twins, fans and edges as those of the other way, which small meshes take.
    fn check(n: usize, faces: &Faces) {
        let topology = Topology::from_faces(n, faces).expect("a torus");
        let size = faces.uniform_size().expect("faces of one size") as usize;
        let (origin, count) = (faces.corners(), faces.corners().len());
        assert!(count >= FEWEST && is_scattered(|f| origin[size * f], faces.len()));
        let mut edges: Vec<_> = (0..count)
            .map(|h| {
                let next = if (h + 1).is_multiple_of(size) { h + 1 - size } else { h + 1 };
                let (from, to) = (origin[h], origin[next]);
                (from.min(to), from.max(to), h)
            })
            .collect();
        edges.sort_unstable();
        for pair in edges.chunks(2) {
            let [a, b] = [pair[0].2, pair[1].2].map(|h| crate::HalfedgeId(h as u32));
            assert_eq!((topology.twin(a), topology.twin(b)), (Some(b), Some(a)));
        }
        let mut first = alloc::vec![NONE; n];
        (0..count).rev().for_each(|h| first[origin[h] as usize] = h as u32);
        for v in topology.vertices() {
            assert_eq!(topology.outgoing(v).map(|h| h.0), Some(first[v.index()]));
            assert!(size == 4 || topology.fan_size(v) == 6);
        }
    }

    #[test]
    fn large_meshes_in_disorder() {
        for triangles in [true, false] {
            let (n, faces) = torus(triangles);
            check(n, &faces);
        }
    }

    #[test]
    fn boundaries_and_defects_are_found() {
        let (n, faces) = torus(true);
        let hole: Faces = faces.iter().skip(1).map(<[u32]>::to_vec).collect();
        let topology = Topology::from_faces(n, &hole).expect("a torus with a hole");
        for &v in faces.get(FaceId(0)) {
            assert!(topology.is_boundary(VertexId(v)), "{v} is at the hole");
            let first = topology.outgoing(VertexId(v)).expect("faces");
            assert_eq!(topology.twin(first), None);
        }

        let mut flipped = faces.corners().to_vec();
        flipped.swap(0, 1);
        let result = Topology::from_faces(n, &Faces::uniform(3, flipped));
        assert!(matches!(result, Err(Error::NotManifold(Defects(d))) if d.len() == 3));

        // A vertex is taken for another one: their faces meet in it, and in nothing else.
        let (from, to) = (faces.corners()[0], faces.corners()[3000]);
        let corners = faces.corners().iter().map(|&v| if v == from { to } else { v }).collect();
        let Err(Error::NotManifold(Defects(defects))) =
            Topology::from_faces(n, &Faces::uniform(3, corners))
        else {
            panic!("two fans");
        };
        let vertex = VertexId(to);
        assert_eq!(defects, [Defect::NonManifoldVertex { vertex, fan_count: 2, face_count: 12 }]);
    }

    #[test]
    fn many_corners_at_a_vertex() {
        let corners: Vec<(u32, u32)> = (0..100).map(|h| (h, (h + 37) % 100)).collect();
        assert!(is_one_fan(5, &corners), "37 and 100 have no common factor");
        let corners: Vec<(u32, u32)> = (0..100).map(|h| (h, (h + 36) % 100)).collect();
        assert!(!is_one_fan(5, &corners));
        let few = [(1, 4), (4, NONE), (7, 1)];
        assert!(is_one_fan(7, &few) && !is_one_fan(1, &few));
    }
}
