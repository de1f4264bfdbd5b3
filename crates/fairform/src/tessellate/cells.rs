//! [`Cells`]: for each face, its class and the vertices that its points are made of.

use alloc::vec::Vec;

use super::classes::{Classes, MOST_SOURCES, Task};
use super::rest::Rest;
use crate::crease::Sharpness;
use crate::error::Error;
use crate::evaluate::Gatherer;
use crate::ids::{EdgeId, FaceId, HalfedgeId, NONE, VertexId};
use crate::scheme::Rules;
use crate::{Topology, par};

/// Most faces that are made step by step where a face becomes a [large](Grid::is_large) grid: with what
/// lies around they take some hundred megabytes at worst.
const MOST_LEFT: u64 = 1 << 16;

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
    /// `None` if many steps are to be made at once and too many faces would be left.
    pub(super) fn new(topology: &Topology, task: Task<'_>) -> Result<Option<Self>, Error> {
        let keys = keys(topology, task.rules);
        let mut finder = Finder { topology, task, classes: Classes::default(), recent: Vec::new() };
        finder.recent.resize(RECENT, ([0; 4], None));
        let mut gatherer = Gatherer::new(topology, task.rules);
        let mut class = alloc::vec![NONE; keys.len()];
        let mut start = Vec::with_capacity(keys.len() + 1);
        let (mut special, mut left) = (Vec::new(), Vec::new());
        let mut used = Vec::new();
        let mut end = 0_u64;
        for (f, (class, key)) in class.iter_mut().zip(&keys).enumerate() {
            start.push(end as u32);
            let mut count = 0;
            let found = if *key == [0; 4] {
                let found = finder.special(f, &mut gatherer)?;
                found.map(|(class, sources)| {
                    count = sources.len();
                    special.push((f as u32, sources));
                    class
                })
            } else {
                count = source_count(*key, task.grid.corners);
                finder.plain(*key)?
            };
            if let Some(found) = found {
                *class = found;
                used.resize(used.len().max(found as usize + 1), 0);
                used[found as usize] |= 1 << owned_sides(topology, f, task.grid.corners);
                end += count as u64;
            } else {
                left.push(f as u32);
            }
            if end > u64::from(u32::MAX) {
                return Err(Error::TooLarge { halfedges: end });
            }
        }
        start.push(end as u32);
        drop(keys);
        if task.grid.is_large() && (left.len() as u64) << (2 * task.grid.levels) > MOST_LEFT {
            return Ok(None);
        }
        let mut classes = finder.classes;
        classes.finish(&used, task.grid);
        let rest = if left.is_empty() { None } else { Some(Rest::new(&mut gatherer, left, task)?) };
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

/// Places for classes found recently.
const RECENT: usize = 64;

struct Finder<'a> {
    topology: &'a Topology,
    task: Task<'a>,
    classes: Classes,
    recent: Vec<([u8; 4], Option<u32>)>,
}

impl Finder<'_> {
    fn plain(&mut self, key: [u8; 4]) -> Result<Option<u32>, Error> {
        let place = key.iter().fold(0, |sum, &n| 5 * sum + n as usize) % RECENT;
        let (recent, class) = self.recent[place];
        if recent == key {
            return Ok(class);
        }
        let valences = key.map(u32::from);
        let class = self.classes.plain(&valences[..self.task.grid.corners], self.task)?;
        self.recent[place] = (key, class);
        Ok(class)
    }

    /// The class and the sources of a face that is not plain.
    fn special(
        &mut self,
        face: usize,
        gatherer: &mut Gatherer<'_>,
    ) -> Result<Option<(u32, Vec<u32>)>, Error> {
        let first = HalfedgeId((face * self.task.grid.corners) as u32);
        if !is_small(self.topology, self.task.rules, first) {
            return Ok(None);
        }
        let found = gatherer.gather(first);
        let sources = found.vertices[..found.value_count].iter().map(|v| v.0).collect();
        Ok(self.classes.of(found, self.task)?.map(|class| (class, sources)))
    }
}

/// Whether a neighbourhood is worth looking at.
fn is_small(topology: &Topology, rules: &Rules, first: HalfedgeId) -> bool {
    crate::evaluate::face_count(topology, rules, first) <= 2 * MOST_SOURCES as u64
}

/// The valences of the corners of each face that is plain: all of them inside, nothing sharp, and the
/// faces around it a disc. Zeros for other faces.
fn keys(topology: &Topology, rules: &Rules) -> Vec<[u8; 4]> {
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

fn is_plain(sharp: Sharpness<'_>, v: VertexId) -> bool {
    !sharp.topology.is_boundary(v)
        && sharp.vertex(v) == 0.0
        && sharp.edges(v).all(|(e, _): (EdgeId, _)| sharp.edge(e) == 0.0)
}

/// How many vertices there are on and around a plain face.
fn source_count(key: [u8; 4], corners: usize) -> usize {
    let sum = key[..corners].iter().map(|&n| n as usize).sum::<usize>();
    if corners == 3 { sum - 6 } else { 2 * sum - 16 }
}

fn sources(
    topology: &Topology,
    task: Task<'_>,
    class: &[u32],
    start: &[u32],
    special: &[(u32, Vec<u32>)],
) -> Vec<u32> {
    let mut sources = alloc::vec![0; start[start.len() - 1] as usize];
    let mut nothing = alloc::vec![(); sources.len()];
    par::fill_row_blocks(start, &mut sources, &mut nothing, &|faces, mut out: &mut [u32], _| {
        let mut next = special.partition_point(|s| (s.0 as usize) < faces.start);
        for f in faces {
            if class[f] == NONE {
                continue;
            }
            let (row, rest) = out.split_at_mut((start[f + 1] - start[f]) as usize);
            if let Some((_, found)) = special.get(next).filter(|s| s.0 as usize == f) {
                row.copy_from_slice(found);
                next += 1;
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
