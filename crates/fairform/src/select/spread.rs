//! Moving the rim of a selection, and fading it out along the surface.

use alloc::collections::BinaryHeap;
use alloc::vec::Vec;
use core::cmp::Reverse;

use super::evaluate::centre;
use crate::{Error, FaceId, HalfedgeId, Mesh, Topology, Vec3, par};

/// The selected faces and those that share a vertex with them, so many times over.
///
/// # Panics
/// If `selected` is not one per face.
#[must_use]
pub fn grow(topology: &Topology, selected: &[bool], rings: u32) -> Vec<bool> {
    assert_eq!(selected.len(), topology.face_count(), "one per face");
    let mut grown = selected.to_vec();
    // The faces of the last ring; only their neighbours can be new.
    let mut rim: Vec<FaceId> = topology.faces().filter(|f| selected[f.index()]).collect();
    let mut seen = alloc::vec![false; topology.vertex_count()];
    for _ in 0..rings {
        let mut next = Vec::new();
        for f in rim {
            for &v in topology.face_vertices(f) {
                if core::mem::replace(&mut seen[v.index()], true) {
                    continue;
                }
                for h in topology.fan(v) {
                    let neighbour = topology.face(h);
                    if !core::mem::replace(&mut grown[neighbour.index()], true) {
                        next.push(neighbour);
                    }
                }
            }
        }
        if next.is_empty() {
            break;
        }
        rim = next;
    }
    grown
}

/// The selected faces without those that share a vertex with one that is not selected, so many
/// times over. The boundary of the mesh takes nothing away.
///
/// # Panics
/// If `selected` is not one per face.
#[must_use]
pub fn shrink(topology: &Topology, selected: &[bool], rings: u32) -> Vec<bool> {
    let mut others: Vec<bool> = selected.iter().map(|selected| !selected).collect();
    others = grow(topology, &others, rings);
    for face in &mut others {
        *face = !*face;
    }
    others
}

/// A weight for each face: 1 in the selection, falling smoothly to 0 at `distance` from it.
///
/// The distance `d` of a face is that of the shortest way from a selected face, from centre to
/// centre across edges, each step measured as if its two faces lay in one plane. The weight is
///
/// ```math
/// w = s^2 (3 - 2s), \qquad s = \max(0, 1 - d / \mathit{distance})
/// ```
///
/// Faces that cannot be reached have weight 0, and with `distance` 0 so do all that are not
/// selected, unless they have no extent and lie on one that is.
///
/// # Errors
/// [`Error::BadOption`] if `distance` is negative or not finite.
///
/// # Panics
/// If `selected` is not one per face.
pub fn falloff(mesh: &Mesh, selected: &[bool], distance: f64) -> Result<Vec<f64>, Error> {
    assert_eq!(selected.len(), mesh.topology().face_count(), "one per face");
    if !distance.is_finite() || distance < 0.0 {
        let (what, expected) = ("the distance of a falloff", "finite and not negative");
        return Err(Error::BadOption { what, expected, value: distance });
    }
    let mut weights = distances(mesh, selected, distance);
    for weight in &mut weights {
        let away = *weight;
        *weight = match away {
            0.0 => 1.0,
            _ if away >= distance => 0.0,
            _ => {
                let s = 1.0 - away / distance;
                (s * s * (3.0 - 2.0 * s)).min(1.0)
            }
        };
    }
    Ok(weights)
}

/// How far each face is from the selection, where that is at most `most`; infinity elsewhere.
/// By the method of Dijkstra.
fn distances(mesh: &Mesh, selected: &[bool], most: f64) -> Vec<f64> {
    let topology = mesh.topology();
    let centres = par::collect(selected.len(), |f| centre(mesh, FaceId(f as u32)));
    let mut away: Vec<f64> =
        selected.iter().map(|&s| if s { 0.0 } else { f64::INFINITY }).collect();
    let mut heap: BinaryHeap<Reverse<(Key, FaceId)>> = topology
        .faces()
        .filter(|f| selected[f.index()])
        .filter(|&f| {
            let across = |h| topology.twin(h).is_some_and(|t| !selected[topology.face(t).index()]);
            topology.face_halfedges(f).any(across)
        })
        .map(|f| Reverse((Key::new(0.0), f)))
        .collect();
    while let Some(Reverse((key, f))) = heap.pop() {
        let here = away[f.index()];
        if key > Key::new(here) {
            continue;
        }
        for h in topology.face_halfedges(f) {
            let Some(g) = topology.twin(h).map(|t| topology.face(t)) else { continue };
            let there = here + step(mesh, h, centres[f.index()], centres[g.index()]);
            if there <= most && there < away[g.index()] {
                away[g.index()] = there;
                heap.push(Reverse((Key::new(there), g)));
            }
        }
    }
    away
}

/// From the centre of one face to that of another across their edge, both turned into one plane.
fn step(mesh: &Mesh, edge: HalfedgeId, from: Vec3, to: Vec3) -> f64 {
    let topology = mesh.topology();
    let start = mesh.positions()[topology.origin(edge).index()];
    let along = (mesh.positions()[topology.target(edge).index()] - start).normalized();
    let (from, to) = (from - start, to - start);
    let (u, v) = (from.dot(along), to.dot(along));
    let height = (from - u * along).length() + (to - v * along).length();
    libm::hypot(u - v, height)
}

/// A distance that can be ordered: for numbers that are not negative the bits are in order.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Key(u64);

impl Key {
    fn new(distance: f64) -> Self {
        Self(distance.to_bits())
    }
}

/// Moves each number of `base` towards `value` by its weight: `base + (value - base) · weight`.
/// Weight 0 leaves it as it is, weight 1 gives `value` exactly.
///
/// # Panics
/// If `weight` is not as long as `base`.
pub fn blend(base: &mut [f64], weight: &[f64], value: f64) {
    assert_eq!(base.len(), weight.len(), "one weight per number");
    for (base, &weight) in base.iter_mut().zip(weight) {
        *base = if weight == 1.0 { value } else { *base + (value - *base) * weight };
    }
}
