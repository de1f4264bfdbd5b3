//! Cutting a soup into a manifold: edges with too many faces, then vertices with several fans.

use alloc::vec;
use alloc::vec::Vec;
use core::fmt;

use super::edges::Edges;
use super::polygon::{area_vector, unit_points};
use super::report::Sentence;
use super::{Sets, Soup, Touched, source};
use crate::{FaceId, NONE, Vec3, VertexId};

/// What [`Soup::split_non_manifold`] did.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
#[must_use]
pub struct SplitReport {
    /// Edges along which faces were parted.
    pub edges: Touched<[VertexId; 2]>,
    /// Vertices of several fans, which now have a copy for each fan but the first.
    pub vertices: Touched<VertexId>,
    /// How many vertices were appended.
    pub new_vertex_count: usize,
}

impl SplitReport {
    /// Whether the soup is another one now.
    #[must_use]
    pub fn changed(&self) -> bool {
        !self.vertices.is_empty()
    }
}

impl fmt::Display for SplitReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut sentence = Sentence::new(f);
        sentence.part("parted the faces at", &self.edges, ["edge", "edges"])?;
        sentence.part("divided", &self.vertices, ["vertex", "vertices"])?;
        sentence.count("added", self.new_vertex_count, ["vertex", "vertices"])?;
        sentence.end("already a manifold")
    }
}

/// Edges with more faces than this pair them in the order of the input, to bound the time.
const PAIRED_BY_ANGLE: usize = 32;

impl Soup {
    /// Cuts the proper faces apart until they are an oriented 2-manifold with boundary.
    ///
    /// At every edge, faces that run along it in opposite directions are paired, and pairs stay
    /// together. Where there is a choice, the pair goes first that bends least; of two that bend
    /// alike, the one whose faces bend away from their front, as at the edge of a solid, so that
    /// two boxes that touch along an edge come apart as boxes; and then the one that is first in
    /// the input. Faces without a partner are cut off. So are two faces that run in the same
    /// direction: [`orient`](Self::orient) first, and only the seam of a one-sided surface is cut.
    ///
    /// Then every vertex gets one copy for each of its fans. The fan with the first corner keeps
    /// the vertex; the copies are appended in the order of their first corners.
    ///
    /// This is the cutting half of the cutting and stitching of \[Gueziec2001\].
    ///
    /// Faces that are not proper are left as they are, except that vertices out of range become
    /// [`NONE`], lest they turn into new vertices by accident.
    ///
    /// # Panics
    /// If there would be 2³² − 1 vertices or more.
    pub fn split_non_manifold(&mut self) -> SplitReport {
        let edges = Edges::of(self);
        let mut mate = self.pair_faces(&edges);
        let mut fan = fans(&edges, &mate);
        if part_entangled_pairs(&edges, &fan, &mut mate) {
            fan = fans(&edges, &mate);
        }
        let mut report = SplitReport::default();
        for group in edges.groups() {
            let ends = |h: u32| [fan[h as usize], fan[edges.next[h as usize] as usize]];
            let first = ends(group[0][2]);
            let stays = |h: u32| ends(h) == first || ends(h) == [first[1], first[0]];
            if !group.iter().all(|&[.., h]| stays(h)) {
                let [a, b, _] = group[0];
                report.edges.edge([a, b].map(|v| source(&self.vertex_source, v)));
            }
        }
        self.divide_vertices(&edges, &fan, &mut report);
        report
    }

    /// The half-edge on the other side of each, where two faces stay together.
    fn pair_faces(&self, edges: &Edges) -> Vec<u32> {
        let mut mate = vec![NONE; edges.face.len()];
        let mut pairs = Vec::new();
        for group in edges.groups() {
            let (ahead, back): (Vec<u32>, Vec<u32>) =
                group.iter().map(|&[.., h]| h).partition(|&h| self.vertex(h) == group[0][0]);
            pairs.clear();
            if group.len() == 2 || group.len() > PAIRED_BY_ANGLE {
                pairs.extend(ahead.iter().zip(&back).map(|(&g, &h)| (0.0, g, h)));
            } else if group.len() > 2 {
                let sheets = |side: &[u32]| -> Vec<Sheet> {
                    side.iter().map(|&h| Sheet::at(self, edges, h)).collect()
                };
                let (front, rear) = (sheets(&ahead), sheets(&back));
                for (&g, a) in ahead.iter().zip(&front) {
                    pairs.extend(back.iter().zip(&rear).map(|(&h, b)| (a.bend_to(b), g, h)));
                }
                pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
            }
            for &(_, g, h) in &pairs {
                if mate[g as usize] == NONE && mate[h as usize] == NONE {
                    mate[g as usize] = h;
                    mate[h as usize] = g;
                }
            }
        }
        mate
    }

    /// Gives each vertex a copy for every fan but its first.
    fn divide_vertices(&mut self, edges: &Edges, fan: &[u32], report: &mut SplitReport) {
        let is_first = |h: u32| edges.next[h as usize] != NONE && fan[h as usize] == h;
        let mut image: Vec<u32> = self.faces.corners().to_vec();
        let mut is_taken = vec![false; self.positions.len()];
        let mut divided = Vec::new();
        for h in (0..fan.len() as u32).filter(|&h| is_first(h)) {
            let v = self.vertex(h) as usize;
            if is_taken[v] {
                image[h as usize] = self.positions.len() as u32;
                self.positions.push(self.positions[v]);
                self.vertex_source.push(source(&self.vertex_source, v as u32));
                divided.push(v as u32);
            }
            is_taken[v] = true;
        }
        if divided.is_empty() {
            return;
        }
        assert!(self.positions.len() < NONE as usize, "fewer than 2^32 - 1 vertices");
        report.new_vertex_count = divided.len();
        divided.sort_unstable();
        divided.dedup();
        for v in divided {
            report.vertices.vertex(source(&self.vertex_source, v));
        }
        let old_count = is_taken.len();
        self.rename(|h, v| match edges.next[h as usize] {
            NONE if v as usize >= old_count => NONE,
            NONE => v,
            _ => image[fan[h as usize] as usize],
        });
    }
}

/// The first corner of the fan that each corner belongs to.
fn fans(edges: &Edges, mate: &[u32]) -> Vec<u32> {
    let mut sets = Sets::new(mate.len());
    for (h, &m) in (0..).zip(mate) {
        if m != NONE {
            sets.join(h, edges.next[m as usize]);
        }
    }
    (0..mate.len() as u32).map(|h| sets.root(h)).collect()
}

/// Parts the pairs that a cut elsewhere does not keep apart, and says whether there were any.
///
/// Two pairs at one edge may belong to the same fan at either end, by ways around the ends; the
/// ends would have one number each, and the edge four faces still. When all pairs of such an edge
/// are parted, a fan touches it only where it begins and ends: at most twice, and in opposite
/// directions. Parting makes fans smaller, so no other edge gets worse.
fn part_entangled_pairs(edges: &Edges, fan: &[u32], mate: &mut [u32]) -> bool {
    let mut parted = false;
    let mut by_ends: Vec<[u32; 3]> = Vec::new();
    for group in edges.groups().filter(|group| group.len() > 2) {
        by_ends.clear();
        by_ends.extend(group.iter().map(|&[.., h]| {
            let (a, b) = (fan[h as usize], fan[edges.next[h as usize] as usize]);
            [a.min(b), a.max(b), h]
        }));
        by_ends.sort_unstable();
        for same in by_ends.chunk_by(|a, b| a[..2] == b[..2]).filter(|same| same.len() > 2) {
            for &[.., h] in same {
                let m = mate[h as usize];
                if m != NONE {
                    mate[h as usize] = NONE;
                    mate[m as usize] = NONE;
                    parted = true;
                }
            }
        }
    }
    parted
}

/// A face at one of its edges: its unit normal, and the unit direction into it.
struct Sheet {
    normal: Vec3,
    inward: Vec3,
}

impl Sheet {
    fn at(soup: &Soup, edges: &Edges, h: u32) -> Self {
        let face = soup.faces.get(FaceId(edges.face[h as usize]));
        let points = unit_points(face.iter().map(|&v| soup.positions[v as usize]));
        let start = soup.corners_of(edges.face[h as usize]).start;
        let [a, b] = [h, edges.next[h as usize]].map(|c| points[(c - start) as usize]);
        let normal = area_vector(&points).normalized();
        Self { normal, inward: normal.cross(b - a).normalized() }
    }

    /// How much the surface bends from one face to another, 0 straight on and 2 folded back; a
    /// millionth more where it bends towards the front.
    fn bend_to(&self, other: &Self) -> f64 {
        let towards_front = other.inward.dot(self.normal) > 1e-9;
        1.0 - self.normal.dot(other.normal) + if towards_front { 1e-6 } else { 0.0 }
    }
}
