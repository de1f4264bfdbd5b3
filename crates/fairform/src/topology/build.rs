//! Building a [`Topology`] from a face list, naming every defect.
//!
//! Half-edges are brought together by a counting sort on the lower end of their edge; each bucket is
//! then sorted by the higher end. Nothing depends on hashing or on the number of threads.

use alloc::vec::Vec;
use core::ops::Range;

use super::rings::TOGETHER;
use super::{MAX_HALFEDGES, Polygons, Topology, partition};
use crate::error::{Defect, Defects, Error};
use crate::faces::uniform_size;
use crate::ids::{FaceId, HalfedgeId, NONE, VertexId};
use crate::{Faces, par};

impl Topology {
    /// The topology of `faces` on `vertex_count` vertices.
    ///
    /// ```
    /// use fairform::{Faces, Topology};
    /// let tetrahedron = Faces::uniform(3, vec![0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3]);
    /// let topology = Topology::from_faces(4, &tetrahedron)?;
    /// assert_eq!(topology.edge_count(), 6);
    /// # Ok::<(), fairform::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::NotManifold`] with every defect, if the faces do not form an oriented manifold,
    /// with or without boundary. Edges are judged among the faces that are sound by themselves,
    /// vertices only where all their edges are sound. [`Error::TooLarge`] beyond
    /// [`MAX_HALFEDGES`].
    pub fn from_faces(vertex_count: usize, faces: &Faces) -> Result<Self, Error> {
        let halfedges = faces.corners().len() as u64;
        if halfedges > MAX_HALFEDGES || vertex_count as u64 > MAX_HALFEDGES {
            return Err(Error::TooLarge { halfedges: halfedges.max(vertex_count as u64) });
        }
        let (mut defects, sound) = check_faces(vertex_count, faces);
        let soup = Soup { vertex_count, faces, polygons: Polygons::of(faces), sound };

        // By streams where that is the faster way.
        let is_scattered = soup.is_scattered();
        let halfedge_count = faces.corners().len();
        let paired = || partition::twins(vertex_count, halfedge_count, |h| soup.ends(h));
        let twin = is_scattered.then(paired).flatten().unwrap_or_else(|| {
            let buckets = Buckets::new(&soup);
            if soup.sound.is_empty() && buckets.are_sound() {
                return soup.twins(&buckets);
            }
            defects.extend(buckets.defects(&soup));
            // Vertices can still be judged where all edges are sound.
            soup.twins_where_sound(&buckets)
        });

        let prev = |h: usize| soup.polygons.prev(HalfedgeId(h as u32)).index();
        let fans =
            is_scattered.then(|| partition::fans(vertex_count, faces.corners(), &twin, prev));
        let is_whole = defects.is_empty() && fans.as_ref().is_some_and(|fans| !fans.is_any_split);
        let (outgoing, fan) =
            fans.map_or_else(|| soup.fans(&twin), |fans| (fans.outgoing, fans.size));
        let topology = Self {
            polygons: soup.polygons.clone(),
            origin: faces.corners().to_vec(),
            twin,
            edge: Vec::new(),
            edge_halfedge: Vec::new(),
            outgoing,
            fan,
        };
        if is_whole {
            return Ok(topology.with_edges());
        }
        let skip = if defects.is_empty() { Vec::new() } else { soup.unsound_vertices(&defects) };
        defects.extend(topology.split_vertices(&skip));
        if !defects.is_empty() {
            return Err(Error::NotManifold(Defects(defects)));
        }
        Ok(topology.with_edges())
    }

    /// A topology whose twins are known, and known to be consistent.
    pub(crate) fn from_twins(vertex_count: usize, faces: &Faces, twin: Vec<u32>) -> Self {
        let soup = Soup { vertex_count, faces, polygons: Polygons::of(faces), sound: Vec::new() };
        let (outgoing, fan) = soup.fans(&twin);
        let (polygons, origin) = (soup.polygons, faces.corners().to_vec());
        let (edge, edge_halfedge) = (Vec::new(), Vec::new());
        Self { polygons, origin, twin, edge, edge_halfedge, outgoing, fan }.with_edges()
    }

    /// Vertices whose faces form several fans: walking the one at `outgoing` misses some.
    fn split_vertices(&self, skip: &[bool]) -> Vec<Defect> {
        let found = par::blocks(self.outgoing.len(), |vertices: Range<usize>| {
            self.split_among(vertices.filter(|&v| self.fan[v] > 0 && skip.get(v) != Some(&true)))
        });
        let split: Vec<usize> = found.into_iter().flatten().collect();
        if split.is_empty() {
            return Vec::new();
        }
        self.count_fans(&split)
    }

    /// The vertices of which walking one fan misses some faces.
    fn split_among(&self, mut vertices: impl Iterator<Item = usize>) -> Vec<usize> {
        let mut split = Vec::new();
        let mut walks = Vec::with_capacity(TOGETHER);
        loop {
            walks.extend(vertices.by_ref().take(TOGETHER).map(|v| (v, self.outgoing[v], 0)));
            if walks.is_empty() {
                split.sort_unstable();
                return split;
            }
            while !walks.is_empty() {
                walks.retain_mut(|(v, at, seen)| {
                    *at = self.twin[self.prev(HalfedgeId(*at)).index()];
                    *seen += 1;
                    let is_round = *at == NONE || *at == self.outgoing[*v];
                    let is_all = *seen == self.fan[*v];
                    if is_round != is_all {
                        split.push(*v);
                    }
                    !is_round && !is_all
                });
            }
        }
    }

    fn count_fans(&self, split: &[usize]) -> Vec<Defect> {
        let mut which = alloc::vec![NONE; self.outgoing.len()];
        for (i, &v) in split.iter().enumerate() {
            which[v] = i as u32;
        }
        let mut fan_count = alloc::vec![0; split.len()];
        let mut seen = alloc::vec![false; self.origin.len()];
        for h in self.halfedges() {
            // A face that is not sound itself may list any vertex.
            let i = which.get(self.origin[h.index()] as usize).copied().unwrap_or(NONE);
            if i == NONE || seen[h.index()] {
                continue;
            }
            fan_count[i as usize] += 1;
            // Mark the whole fan: counter-clockwise from h, and if it is open also clockwise.
            let mut at = Some(h);
            while let Some(one) = at.filter(|one| !seen[one.index()]) {
                seen[one.index()] = true;
                at = self.twin(self.prev(one));
            }
            at = self.twin(h).map(|t| self.next(t));
            while let Some(one) = at.filter(|one| !seen[one.index()]) {
                seen[one.index()] = true;
                at = self.twin(one).map(|t| self.next(t));
            }
        }
        split
            .iter()
            .zip(fan_count)
            .map(|(&v, fan_count)| Defect::NonManifoldVertex {
                vertex: VertexId(v as u32),
                fan_count,
                face_count: self.fan[v] as usize,
            })
            .collect()
    }

    /// Numbers the edges by first appearance.
    pub(super) fn with_edges(mut self) -> Self {
        let twin = &self.twin;
        let leads = |h: usize| twin[h] == NONE || twin[h] as usize > h;
        let counts =
            par::blocks(twin.len(), |range: Range<usize>| range.filter(|&h| leads(h)).count());
        let mut first = 0;
        let firsts: Vec<usize> = counts
            .iter()
            .map(|&count| {
                let start = first;
                first += count;
                start
            })
            .collect();
        let mut edge = alloc::vec![NONE; twin.len()];
        par::for_blocks(&mut edge, |start, block| {
            let mut next = firsts[start / par::BLOCK] as u32;
            for (i, slot) in block.iter_mut().enumerate() {
                if leads(start + i) {
                    *slot = next;
                    next += 1;
                }
            }
        });
        let mut edge_halfedge = alloc::vec![NONE; first];
        let own = par::cut(&mut edge_halfedge, counts.iter().copied());
        par::in_parts(own.into_iter().enumerate().collect(), |(block, own)| {
            let leading = (block * par::BLOCK..).filter(|&h| leads(h));
            own.iter_mut().zip(leading).for_each(|(slot, h)| *slot = h as u32);
        });
        // The second half of each edge takes the number of the first.
        let lead = edge;
        self.edge = par::collect(lead.len(), |h| match lead[h] {
            NONE => lead[twin[h] as usize],
            e => e,
        });
        self.edge_halfedge = edge_halfedge;
        self
    }
}

/// A face list that is being judged.
struct Soup<'a> {
    vertex_count: usize,
    faces: &'a Faces,
    polygons: Polygons,
    /// Whether each face is sound by itself; empty if all are.
    sound: Vec<bool>,
}

fn check_faces(vertex_count: usize, faces: &Faces) -> (Vec<Defect>, Vec<bool>) {
    let ok = |f: usize| {
        let corners = faces.get(FaceId(f as u32));
        corners.len() >= 3
            && corners.iter().all(|&v| (v as usize) < vertex_count)
            && repeated(corners).is_none()
    };
    let all_ok = par::blocks(faces.len(), |mut range: Range<usize>| range.all(ok));
    if all_ok.into_iter().all(|ok| ok) {
        return (Vec::new(), Vec::new());
    }
    let mut sound = alloc::vec![true; faces.len()];
    let mut defects = Vec::new();
    for (f, corners) in faces.iter().enumerate() {
        let face = FaceId(f as u32);
        let before = defects.len();
        for &vertex in corners {
            if vertex as usize >= vertex_count {
                defects.push(Defect::NoSuchVertex { face, vertex, vertex_count });
            }
        }
        if corners.len() < 3 {
            defects.push(Defect::TooFewCorners { face, count: corners.len() });
        } else if let Some(v) = repeated(corners) {
            defects.push(Defect::RepeatedCorner { face, vertex: VertexId(v) });
        }
        sound[f] = defects.len() == before;
    }
    (defects, sound)
}

/// A vertex that a face lists twice.
fn repeated(corners: &[u32]) -> Option<u32> {
    if let &[a, b, c] = corners {
        return if a == b || a == c {
            Some(a)
        } else if b == c {
            Some(b)
        } else {
            None
        };
    }
    if corners.len() <= 16 {
        return (1..corners.len())
            .map(|i| corners[i])
            .enumerate()
            .find_map(|(i, v)| corners[..=i].contains(&v).then_some(v));
    }
    let mut sorted = corners.to_vec();
    sorted.sort_unstable();
    sorted.windows(2).find(|w| w[0] == w[1]).map(|w| w[0])
}

impl Polygons {
    fn of(faces: &Faces) -> Self {
        match faces.uniform_size() {
            Some(size) if size > 0 => Self::Uniform { size },
            _ => Self::from_starts(&faces.starts()),
        }
    }

    /// From where each face begins, and the end of all.
    pub(super) fn from_starts(start: &[u32]) -> Self {
        if let Some(size) = uniform_size(start).filter(|&size| size > 0) {
            return Self::Uniform { size };
        }
        let mut face = Vec::with_capacity(start[start.len() - 1] as usize);
        for (f, w) in start.windows(2).enumerate() {
            face.extend(core::iter::repeat_n(f as u32, (w[1] - w[0]) as usize));
        }
        Self::Varied { start: start.to_vec(), face }
    }
}

impl Soup<'_> {
    fn are_triangles(&self) -> bool {
        matches!(self.polygons, Polygons::Uniform { size: 3 })
    }

    fn is_sound(&self, f: usize) -> bool {
        self.sound.is_empty() || self.sound[f]
    }

    /// Calls `visit(half-edge, from, to)` for all half-edges of sound faces, in order.
    fn for_halfedges(&self, mut visit: impl FnMut(usize, u32, u32)) {
        let corners = self.faces.corners();
        if self.sound.is_empty() && self.are_triangles() {
            for (f, t) in corners.as_chunks::<3>().0.iter().enumerate() {
                visit(3 * f, t[0], t[1]);
                visit(3 * f + 1, t[1], t[2]);
                visit(3 * f + 2, t[2], t[0]);
            }
            return;
        }
        for f in 0..self.faces.len() {
            let Range { start, end } = self.faces.range(FaceId(f as u32));
            if self.is_sound(f) {
                for h in start..end {
                    let next = if h + 1 == end { start } else { h + 1 };
                    visit(h, corners[h], corners[next]);
                }
            }
        }
    }

    /// Whether the mesh is large and its faces lie about in memory.
    fn is_scattered(&self) -> bool {
        let first = |f: usize| self.faces.get(FaceId(f as u32))[0];
        self.sound.is_empty()
            && self.faces.corners().len() >= partition::FEWEST
            && partition::is_scattered(first, self.faces.len())
    }

    /// Where a half-edge begins and ends.
    fn ends(&self, h: usize) -> (u32, u32) {
        let corners = self.faces.corners();
        (corners[h], corners[self.polygons.next(HalfedgeId(h as u32)).index()])
    }

    /// The twin of every half-edge, all edges being sound.
    fn twins(&self, buckets: &Buckets) -> Vec<u32> {
        par::collect(self.faces.corners().len(), |h| {
            let (from, to) = self.ends(h);
            buckets.twin(h as u32, from, to)
        })
    }

    /// As [`twins`](Self::twins), leaving out faces and edges that are not sound.
    fn twins_where_sound(&self, buckets: &Buckets) -> Vec<u32> {
        let mut twin = alloc::vec![NONE; self.faces.corners().len()];
        buckets.for_groups(|_, _, group| {
            if let &[a, b] = group
                && a.is_forward() != b.is_forward()
            {
                twin[a.halfedge() as usize] = b.halfedge();
                twin[b.halfedge() as usize] = a.halfedge();
            }
        });
        twin
    }

    /// A half-edge from each vertex, on the boundary the one without a twin, and the number of
    /// faces at the vertex.
    fn fans(&self, twin: &[u32]) -> (Vec<u32>, Vec<u32>) {
        let mut outgoing = alloc::vec![NONE; self.vertex_count];
        let mut fan = alloc::vec![0; self.vertex_count];
        self.for_halfedges(|h, from, _| {
            let v = from as usize;
            fan[v] += 1;
            if outgoing[v] == NONE || (twin[h] == NONE && twin[outgoing[v] as usize] != NONE) {
                outgoing[v] = h as u32;
            }
        });
        (outgoing, fan)
    }

    /// Vertices at which something was found already, so that their fans mean nothing.
    fn unsound_vertices(&self, defects: &[Defect]) -> Vec<bool> {
        let mut unsound = alloc::vec![false; self.vertex_count];
        let mut mark = |v: u32| {
            if let Some(slot) = unsound.get_mut(v as usize) {
                *slot = true;
            }
        };
        for defect in defects {
            match defect {
                Defect::NonManifoldEdge { ends, .. } => ends.iter().for_each(|v| mark(v.0)),
                Defect::InconsistentOrientation { from, to, .. } => {
                    mark(from.0);
                    mark(to.0);
                }
                Defect::NoSuchVertex { face, .. }
                | Defect::TooFewCorners { face, .. }
                | Defect::RepeatedCorner { face, .. } => {
                    self.faces.get(*face).iter().for_each(|&v| mark(v));
                }
                Defect::NotFinite { .. } | Defect::NonManifoldVertex { .. } => {}
            }
        }
        unsound
    }
}

/// One half-edge in the bucket of its lower end: the higher end, the half-edge and its direction,
/// packed so that sorting brings the half-edges of one edge together.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
struct Entry(u64);

impl Entry {
    fn new(high: u32, halfedge: u32, forward: bool) -> Self {
        Self(u64::from(high) << 32 | u64::from(halfedge) << 1 | u64::from(forward))
    }

    fn high(self) -> u32 {
        (self.0 >> 32) as u32
    }

    fn halfedge(self) -> u32 {
        (self.0 as u32) >> 1
    }

    /// Whether it runs from the lower end to the higher.
    fn is_forward(self) -> bool {
        self.0 & 1 == 1
    }
}

/// All half-edges of sound faces, sorted by their lower and then their higher end.
struct Buckets {
    start: Vec<u32>,
    entries: Vec<Entry>,
}

impl Buckets {
    fn new(soup: &Soup) -> Self {
        let mut start = alloc::vec![0; soup.vertex_count + 1];
        soup.for_halfedges(|_, from, to| start[from.min(to) as usize + 1] += 1);
        for v in 0..soup.vertex_count {
            start[v + 1] += start[v];
        }
        let mut entries = alloc::vec![Entry::default(); start[soup.vertex_count] as usize];
        par::in_parts(cut(&start, &mut entries), |(vertices, entries)| {
            scatter(soup, &start, vertices, entries);
        });
        par::fill_rows(&start, &mut entries, &mut no_values(&start), &|_, row, _: &mut [()]| {
            row.sort_unstable();
        });
        Self { start, entries }
    }

    fn bucket(&self, v: usize) -> &[Entry] {
        &self.entries[self.start[v] as usize..self.start[v + 1] as usize]
    }

    /// Whether every edge has one face, or two that run through it in opposite directions.
    fn are_sound(&self) -> bool {
        let sound = par::blocks(self.start.len() - 1, |mut vertices: Range<usize>| {
            vertices.all(|v| {
                groups(self.bucket(v)).all(|group| match group {
                    [_] => true,
                    [a, b] => a.is_forward() != b.is_forward(),
                    _ => false,
                })
            })
        });
        sound.into_iter().all(|ok| ok)
    }

    /// The other half-edge of a sound edge.
    fn twin(&self, h: u32, from: u32, to: u32) -> u32 {
        let (low, high) = (from.min(to), from.max(to));
        let bucket = self.bucket(low as usize);
        let own = Entry::new(high, h, from < to);
        let at = if bucket.len() <= 32 {
            bucket.iter().position(|e| *e == own).unwrap_or(bucket.len())
        } else {
            bucket.partition_point(|e| *e < own)
        };
        let same = |e: &&Entry| e.high() == high;
        let before = at.checked_sub(1).and_then(|i| bucket.get(i)).filter(same);
        before.or_else(|| bucket.get(at + 1).filter(same)).map_or(NONE, |e| e.halfedge())
    }

    fn for_groups(&self, mut visit: impl FnMut(u32, u32, &[Entry])) {
        for v in 0..self.start.len() - 1 {
            for group in groups(self.bucket(v)) {
                visit(v as u32, group[0].high(), group);
            }
        }
    }

    fn defects(&self, soup: &Soup) -> Vec<Defect> {
        let mut defects = Vec::new();
        self.for_groups(|low, high, group| {
            let face = |e: &Entry| soup.polygons.face(HalfedgeId(e.halfedge()));
            match group {
                [_] => {}
                [a, b] if a.is_forward() != b.is_forward() => {}
                [a, b] => {
                    let ends = if a.is_forward() { (low, high) } else { (high, low) };
                    defects.push(Defect::InconsistentOrientation {
                        from: VertexId(ends.0),
                        to: VertexId(ends.1),
                        faces: [face(a), face(b)],
                    });
                }
                more => defects.push(Defect::NonManifoldEdge {
                    ends: [VertexId(low), VertexId(high)],
                    faces: more.iter().map(face).collect(),
                }),
            }
        });
        defects
    }
}

/// The runs of entries of one edge.
fn groups(bucket: &[Entry]) -> impl Iterator<Item = &[Entry]> {
    bucket.chunk_by(|a, b| a.high() == b.high())
}

/// Cuts the entries into a few parts at bucket boundaries, of about one size.
fn cut<'a>(start: &[u32], entries: &'a mut [Entry]) -> Vec<(Range<usize>, &'a mut [Entry])> {
    let count = par::part_count();
    let total = entries.len();
    let mut parts = Vec::with_capacity(count);
    let mut rest = entries;
    let mut from = 0;
    for part in 1..=count {
        let end = if part == count {
            start.len() - 1
        } else {
            start.partition_point(|&s| (s as usize) < total * part / count).min(start.len() - 1)
        };
        let end = end.max(from);
        let (own, others) = rest.split_at_mut((start[end] - start[from]) as usize);
        parts.push((from..end, own));
        rest = others;
        from = end;
    }
    parts
}

/// Puts the half-edges whose lower end lies in `vertices` into their buckets.
fn scatter(soup: &Soup, start: &[u32], vertices: Range<usize>, entries: &mut [Entry]) {
    let base = start[vertices.start];
    let mut next: Vec<u32> = start[vertices.clone()].iter().map(|s| s - base).collect();
    soup.for_halfedges(|h, from, to| {
        let low = from.min(to) as usize;
        if let Some(slot) = low.checked_sub(vertices.start).and_then(|i| next.get_mut(i)) {
            entries[*slot as usize] = Entry::new(from.max(to), h as u32, from < to);
            *slot += 1;
        }
    });
}

/// A second column of no size, for the row filler.
fn no_values(start: &[u32]) -> Vec<()> {
    alloc::vec![(); start.last().map_or(0, |&end| end as usize)]
}
