//! [`Cells`]: for each face, its class and the vertices that its points are made of.

use alloc::collections::BTreeMap;
use alloc::vec::Vec;

use super::classes::{Classes, MOST_CLASSES, MOST_SOURCES, Task};
use super::rest::Rest;
use crate::crease::Sharpness;
use crate::error::Error;
use crate::evaluate::{Gatherer, Neighbourhood};
use crate::ids::{EdgeId, FaceId, HalfedgeId, NONE, VertexId};
use crate::scheme::Rules;
use crate::{Topology, par};

/// What the surroundings of a plain face, or of a vertex, look like.
pub(super) type Key = [u8; 4];

/// What the points of all faces are made of.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    pub(super) classes: Classes,
    /// The class of each face; [`NONE`] for those that are refined step by step.
    pub(super) class: Vec<u32>,
    /// Where the sources of each face begin, and the end.
    start: Vec<u32>,
    sources: Vec<u32>,
    pub(super) rest: Option<Rest>,
}

impl Cells {
    /// `None` if more faces would be refined step by step than the limits allow.
    pub(super) fn new(topology: &Topology, task: Task<'_>) -> Result<Option<Self>, Error> {
        let keys = keys(topology, task.rules);
        let mut classes = Classes::default();
        let plain: Vec<Key> =
            distinct(&keys).into_iter().filter(|k| *k != Key::default()).collect();
        // Each kind too many leaves a face: that is known before any rows are made.
        let most_kinds = task.limits.classes.saturating_add(task.limits.left);
        if plain.len() > most_kinds {
            return Ok(None);
        }
        let special = special_parts(topology, task, &keys, most_kinds - plain.len());
        if special.iter().any(|part| plain.len() + part.list.len() > most_kinds) {
            return Ok(None);
        }
        let of_plain = plain
            .iter()
            .map(|key| {
                let valences = key.map(u32::from);
                let found = classes.plain(&valences[..task.grid.corners], task)?;
                Ok(found.unwrap_or(NONE))
            })
            .collect::<Result<Vec<u32>, Error>>()?;
        let special = Special::new(special, task, &mut classes)?;
        let mut class = par::collect(keys.len(), |f| {
            plain.binary_search(&keys[f]).map_or(NONE, |place| of_plain[place])
        });
        drop(keys);
        special.faces.iter().zip(&special.class).for_each(|(&f, &c)| class[f as usize] = c);

        let count = |f: usize| match class[f] {
            NONE => 0,
            found => classes.list[found as usize].source_count as u32,
        };
        let start =
            par::starts(class.len(), count).map_err(|end| Error::TooLarge { halfedges: end })?;
        let (used, left) = used_and_left(topology, task, &class, classes.list.len());
        if left.len() > task.limits.left {
            return Ok(None);
        }
        classes.finish(&used, task.grid);
        let rest = match left.is_empty() {
            true => None,
            false => Some(Rest::new(&mut Gatherer::new(topology, task.rules), left, task)?),
        };
        let sources = sources(topology, task, &class, &start, &special);
        Ok(Some(Self { classes, class, start, sources, rest }))
    }

    /// The vertices that the points of a face are made of.
    #[inline(always)]
    pub(super) fn sources(&self, face: usize) -> &[u32] {
        &self.sources[self.start[face] as usize..self.start[face + 1] as usize]
    }
}

/// The sides of a face whose points are its own: those whose edge begins with it, as bits.
#[inline(always)]
pub(super) fn owned_sides(topology: &Topology, face: usize, corners: usize) -> usize {
    let first = (face * corners) as u32;
    (0..corners).fold(0, |sides, i| {
        let h = HalfedgeId(first + i as u32);
        let leads = topology.twin(h).is_none_or(|t| t > h);
        sides | usize::from(leads) << i
    })
}

/// For each class, which sides are their faces' own, as bits of bits; and the faces without a class.
fn used_and_left(
    topology: &Topology,
    task: Task<'_>,
    class: &[u32],
    class_count: usize,
) -> (Vec<u32>, Vec<u32>) {
    let blocks = par::blocks(class.len(), |faces| {
        let (mut used, mut left) = (alloc::vec![0_u32; class_count], Vec::new());
        for f in faces {
            match class[f] {
                NONE => left.push(f as u32),
                c => used[c as usize] |= 1 << owned_sides(topology, f, task.grid.corners),
            }
        }
        (used, left)
    });
    let (mut used, mut left) = (alloc::vec![0; class_count], Vec::new());
    for (of_block, left_in_block) in blocks {
        used.iter_mut().zip(of_block).for_each(|(used, more)| *used |= more);
        left.extend(left_in_block);
    }
    (used, left)
}

/// The classes and sources of the faces that are not plain.
#[derive(Default)]
struct Special {
    faces: Vec<u32>,
    /// Of each of them; [`NONE`] without one, and then there are no sources.
    class: Vec<u32>,
    /// Where the sources of each begin, and the end.
    start: Vec<usize>,
    sources: Vec<u32>,
}

/// Some of them, with their classes by their place in a list.
#[derive(Default)]
struct SpecialPart {
    found: Special,
    list: Vec<Neighbourhood>,
}

/// How many faces of a mesh can be passed over while the neighbourhood of one is gathered, or a part of that.
const PASSED_OVER: usize = 256;

/// The faces that are not plain, with all that their classes are found by. A part that has more than so many
/// kinds ends there.
fn special_parts(
    topology: &Topology,
    task: Task<'_>,
    keys: &[Key],
    most_kinds: usize,
) -> Vec<SpecialPart> {
    let faces = par::blocks(keys.len(), |block| {
        let is_special = |f: &usize| keys[*f] == Key::default();
        block.filter(is_special).map(|f| f as u32).collect::<Vec<_>>()
    })
    .concat();
    // Each part fills memory in proportion to the mesh, so they are few, and one where that would
    // take the longest.
    let worth = PASSED_OVER * faces.len() / keys.len().max(1);
    let count = worth.clamp(1, par::part_count());
    let parts = faces.chunks(faces.len().div_ceil(count).max(1)).collect();
    par::map_parts(parts, |part| SpecialPart::new(topology, task, part, most_kinds))
}

impl Special {
    fn new(parts: Vec<SpecialPart>, task: Task<'_>, classes: &mut Classes) -> Result<Self, Error> {
        let mut all = Self { start: alloc::vec![0], ..Self::default() };
        for SpecialPart { found, list } in parts {
            let of_part = list
                .into_iter()
                .map(|found| Ok(classes.of(found, task)?.unwrap_or(NONE)))
                .collect::<Result<Vec<u32>, Error>>()?;
            for (i, &face) in found.faces.iter().enumerate() {
                let class = of_part.get(found.class[i] as usize).copied().unwrap_or(NONE);
                all.faces.push(face);
                all.class.push(class);
                if class != NONE {
                    all.sources.extend(&found.sources[found.start[i]..found.start[i + 1]]);
                }
                all.start.push(all.sources.len());
            }
        }
        Ok(all)
    }
}

impl SpecialPart {
    fn new(topology: &Topology, task: Task<'_>, faces: &[u32], most_kinds: usize) -> Self {
        let mut gatherer = Gatherer::new(topology, task.rules);
        let mut known: BTreeMap<Vec<u32>, u32> = BTreeMap::new();
        let mut part = Self::default();
        part.found.start.push(0);
        for &f in faces {
            let first = HalfedgeId(f * task.grid.corners as u32);
            let mut class = NONE;
            let near = is_small(topology, task.rules, first).then(|| gatherer.gather(first));
            if let Some(near) = near.filter(|near| near.value_count <= MOST_SOURCES) {
                let sources = near.vertices[..near.value_count].iter().map(|v| v.0);
                part.found.sources.extend(sources);
                let key = near.key();
                class = known.get(&key).copied().unwrap_or(NONE);
                // With more no class would be found for those that come later in any case.
                if class == NONE && known.len() < MOST_CLASSES {
                    class = part.list.len() as u32;
                    known.insert(key, class);
                    part.list.push(near);
                }
            }
            part.found.faces.push(f);
            part.found.class.push(class);
            part.found.start.push(part.found.sources.len());
            if part.list.len() > most_kinds {
                break;
            }
        }
        part
    }
}

/// Whether a neighbourhood is worth looking at.
fn is_small(topology: &Topology, rules: &Rules, first: HalfedgeId) -> bool {
    crate::evaluate::face_count(topology, rules, first) <= 2 * MOST_SOURCES as u64
}

/// The valences of the corners of each face that is plain: all of them inside, nothing sharp, and the
/// faces around it a disc. Zeros for other faces.
fn keys(topology: &Topology, rules: &Rules) -> Vec<Key> {
    let sharp = rules.sharpness(topology);
    let plain_vertex = rules
        .creases
        .as_ref()
        .map(|_| par::collect(topology.vertex_count(), |v| is_plain(sharp, VertexId(v as u32))));
    let is_plain = |v: VertexId| match &plain_vertex {
        Some(plain) => plain[v.index()],
        None => !topology.is_boundary(v),
    };
    par::collect(topology.face_count(), |f| {
        let corners = topology.face_vertices(FaceId(f as u32));
        if !corners.iter().all(|&v| is_plain(v)) {
            return [0; 4];
        }
        let valences = || corners.iter().map(|&v| topology.fan_size(v));
        let (k, threes) = (corners.len(), valences().filter(|n| *n == 3).count());
        let is_disc = valences().all(|n| n >= 3)
            && (k == 4 || (threes <= 1 && valences().sum::<u32>() >= 12));
        if !is_disc || valences().any(|n| n as usize > MOST_SOURCES) {
            return [0; 4];
        }
        let mut key = [0; 4];
        // No valence is too large, since no more sources are allowed.
        key.iter_mut().zip(valences()).for_each(|(slot, n)| *slot = n as u8);
        if source_count(key, k) <= MOST_SOURCES { key } else { [0; 4] }
    })
}

/// The keys that turn up, in order.
pub(super) fn distinct(keys: &[Key]) -> Vec<Key> {
    let blocks = par::blocks(keys.len(), |block| {
        let mut found: Vec<Key> = Vec::new();
        let mut last = None;
        for key in &keys[block] {
            if last != Some(key)
                && let Err(place) = found.binary_search(key)
            {
                found.insert(place, *key);
            }
            last = Some(key);
        }
        found
    });
    let mut all = blocks.concat();
    all.sort_unstable();
    all.dedup();
    all
}

fn is_plain(sharp: Sharpness<'_>, v: VertexId) -> bool {
    !sharp.topology.is_boundary(v)
        && sharp.vertex(v) == 0.0
        && sharp.edges(v).all(|(e, _): (EdgeId, _)| sharp.edge(e) == 0.0)
}

/// How many vertices there are on and around a plain face.
fn source_count(key: Key, corners: usize) -> usize {
    let sum = key[..corners].iter().map(|&n| n as usize).sum::<usize>();
    if corners == 3 { sum - 6 } else { 2 * sum - 16 }
}

fn sources(
    topology: &Topology,
    task: Task<'_>,
    class: &[u32],
    start: &[u32],
    special: &Special,
) -> Vec<u32> {
    let mut sources = alloc::vec![0; start[start.len() - 1] as usize];
    let mut nothing = alloc::vec![(); sources.len()];
    par::fill_row_blocks(start, &mut sources, &mut nothing, &|faces, mut out: &mut [u32], _| {
        let mut next = special.faces.partition_point(|&f| (f as usize) < faces.start);
        for f in faces {
            let place = next;
            let is_special = special.faces.get(next).is_some_and(|&s| s as usize == f);
            next += usize::from(is_special);
            if class[f] == NONE {
                continue;
            }
            let (row, rest) = out.split_at_mut((start[f + 1] - start[f]) as usize);
            if is_special {
                row.copy_from_slice(
                    &special.sources[special.start[place]..special.start[place + 1]],
                );
            } else if task.grid.corners == 3 {
                around_triangle(topology, f, row);
            } else {
                around_quadrilateral(topology, f, row);
            }
            out = rest;
        }
    });
    sources
}

/// The half-edge that follows counter-clockwise around its origin, inside.
#[inline]
fn turned(topology: &Topology, h: HalfedgeId) -> HalfedgeId {
    topology.twin(topology.prev(h)).unwrap_or(h)
}

/// The corners of a plain triangle, and then the vertices around, beginning beyond its first side.
fn around_triangle(topology: &Topology, face: usize, out: &mut [u32]) {
    let corners = topology.face_vertices(FaceId(face as u32));
    let (own, mut out) = out.split_at_mut(3);
    own.iter_mut().zip(corners).for_each(|(slot, v)| *slot = v.0);
    for i in 0..3 {
        let c = corners[(i + 1) % 3];
        let side = HalfedgeId((3 * face + i) as u32);
        let (part, rest) = out.split_at_mut(topology.fan_size(c) as usize - 3);
        let mut h = topology.twin(side).unwrap_or(side);
        for slot in part {
            h = turned(topology, h);
            *slot = topology.target(h).0;
        }
        out = rest;
    }
}

/// The corners of a plain quadrilateral, and then the vertices around, beginning beyond its first
/// side with the neighbour of the second corner.
fn around_quadrilateral(topology: &Topology, face: usize, out: &mut [u32]) {
    let corners = topology.face_vertices(FaceId(face as u32));
    let (own, mut out) = out.split_at_mut(4);
    own.iter_mut().zip(corners).for_each(|(slot, v)| *slot = v.0);
    for i in 0..4 {
        let c = corners[(i + 1) % 4];
        let side = HalfedgeId((4 * face + i) as u32);
        let (part, rest) = out.split_at_mut(2 * topology.fan_size(c) as usize - 5);
        let mut h = topology.twin(side).unwrap_or(side);
        for pair in part.chunks_mut(2) {
            h = turned(topology, h);
            pair[0] = topology.target(h).0;
            if let Some(slot) = pair.get_mut(1) {
                *slot = topology.target(topology.next(h)).0;
            }
        }
        out = rest;
    }
}
