//! Turning faces so that neighbours agree, and closed surfaces so that they face outwards.

use alloc::vec;
use alloc::vec::Vec;
use core::fmt;

use super::edges::Edges;
use super::report::Sentence;
use super::{Soup, Touched, source};
use crate::{FaceId, NONE, Vec3, VertexId};

/// What [`Soup::orient`] did.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
#[must_use]
pub struct OrientReport {
    /// The faces turned around.
    pub flipped: Touched<FaceId>,
    /// Sets of faces connected through edges of exactly two faces.
    pub component_count: usize,
    /// Components that cannot be oriented, each with an edge along which two faces cannot be made
    /// to agree.
    pub one_sided: Touched<[VertexId; 2]>,
}

impl OrientReport {
    /// Whether the soup is another one now.
    #[must_use]
    pub fn changed(&self) -> bool {
        !self.flipped.is_empty()
    }
}

impl fmt::Display for OrientReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut sentence = Sentence::new(f);
        sentence.part("turned", &self.flipped, ["face", "faces"])?;
        let parts = ["part that has one side only", "parts that have one side only"];
        sentence.part("found", &self.one_sided, parts)?;
        sentence.end("all faces agree with their neighbours")
    }
}

/// What [`Soup::orient_outward`] did.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
#[must_use]
pub struct OutwardReport {
    /// The closed surfaces turned inside out, each named by its first face.
    pub turned: Touched<FaceId>,
    /// How many closed, consistently oriented surfaces there are.
    pub closed_count: usize,
}

impl OutwardReport {
    /// Whether the soup is another one now.
    #[must_use]
    pub fn changed(&self) -> bool {
        !self.turned.is_empty()
    }
}

impl fmt::Display for OutwardReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut sentence = Sentence::new(f);
        let surfaces = ["closed surface that faced inwards", "closed surfaces that faced inwards"];
        sentence.part("turned", &self.turned, surfaces)?;
        sentence.end("no closed surface faces inwards")
    }
}

/// The faces of a component in breadth-first order from the one with the smallest number, and how
/// they fit.
struct Component {
    faces: Vec<u32>,
    /// Half-edges whose mate runs the same way as things stand.
    clash_count: usize,
    /// The same after the turns that the walk asks for.
    rest_count: usize,
    /// The smallest half-edge that clashes after the turns.
    witness: u32,
    /// Whether every edge has two faces.
    is_closed: bool,
}

impl Soup {
    /// Turns faces around until the two faces at every edge run along it in opposite directions.
    ///
    /// This is done part by part, where a part is connected through edges of exactly two faces;
    /// edges of three or more faces connect nothing here. The direction of the majority of its
    /// faces wins, that of the first face if they are equally many.
    ///
    /// A part that has one side only (a Möbius strip, a Klein bottle) cannot be oriented. It is
    /// turned along a spanning tree where that leaves fewer clashing edges than there were, else
    /// left as it is; [`split_non_manifold`](Self::split_non_manifold) cuts it open along the rest.
    pub fn orient(&mut self) -> OrientReport {
        let edges = Edges::of(self);
        let mate = edges.mates();
        let mut report = OrientReport::default();
        let mut turned = vec![false; self.faces.len()];
        self.for_each_component(&edges, &mate, &mut turned, |soup, component, turned| {
            report.component_count += 1;
            if component.rest_count > 0 {
                let h = component.witness;
                let ends = [h, edges.next[h as usize]].map(|c| soup.vertex(c));
                report.one_sided.edge(ends.map(|v| source(&soup.vertex_source, v)));
            }
            let is_better = component.rest_count < component.clash_count;
            let turns = component.faces.iter().filter(|&&f| turned[f as usize]).count();
            let majority = 2 * turns > component.faces.len();
            for &f in &component.faces {
                turned[f as usize] = is_better && turned[f as usize] != majority;
            }
        });
        for (f, _) in (0..).zip(&turned).filter(|&(_, &turn)| turn) {
            report.flipped.face(source(&self.face_source, f));
        }
        if report.changed() {
            self.turn(&turned);
        }
        report
    }

    /// Turns closed surfaces whose signed volume is negative, so that they face outwards.
    ///
    /// Only parts are looked at whose every edge has exactly two faces, in opposite directions:
    /// [`orient`](Self::orient) first. Each is taken alone, so the wall of a cavity inside a solid
    /// is turned as well. A volume of zero, up to rounding, leaves its surface as it is.
    pub fn orient_outward(&mut self) -> OutwardReport {
        let edges = Edges::of(self);
        let mate = edges.mates();
        let mut report = OutwardReport::default();
        let mut turned = vec![false; self.faces.len()];
        self.for_each_component(&edges, &mate, &mut turned, |soup, component, turned| {
            let is_oriented = component.is_closed && component.clash_count == 0;
            report.closed_count += usize::from(is_oriented);
            let inside_out = is_oriented && soup.is_inside_out(&component.faces);
            if inside_out {
                report.turned.face(source(&soup.face_source, component.faces[0]));
            }
            for &f in &component.faces {
                turned[f as usize] = inside_out;
            }
        });
        if report.changed() {
            self.turn(&turned);
        }
        report
    }

    /// Walks the parts that are connected through `mate`, from the face with the smallest number
    /// on, and says in `turned` which faces would agree with that first one if they were turned.
    fn for_each_component(
        &self,
        edges: &Edges,
        mate: &[u32],
        turned: &mut [bool],
        mut visit: impl FnMut(&Self, &Component, &mut [bool]),
    ) {
        let mut seen = vec![false; self.faces.len()];
        let mut around = Vec::new();
        for (root, proper) in (0..).zip(self.proper_faces()) {
            if !proper || seen[root as usize] {
                continue;
            }
            seen[root as usize] = true;
            let mut found = Component {
                faces: vec![root],
                clash_count: 0,
                rest_count: 0,
                witness: NONE,
                is_closed: true,
            };
            let mut next = 0;
            while let Some(&f) = found.faces.get(next) {
                next += 1;
                // In an order that no turn changes, so that a second walk takes the same way.
                around.clear();
                around.extend(self.corners_of(f));
                around.sort_unstable_by_key(|&h| {
                    let (a, b) = (self.vertex(h), self.vertex(edges.next[h as usize]));
                    (edges.face.get(mate[h as usize] as usize), a.min(b), a.max(b))
                });
                for &h in &around {
                    let m = mate[h as usize];
                    if m == NONE {
                        found.is_closed = false;
                        continue;
                    }
                    let clash = self.vertex(h) == self.vertex(m);
                    let g = edges.face[m as usize];
                    let wanted = turned[f as usize] != clash;
                    found.clash_count += usize::from(clash);
                    if !seen[g as usize] {
                        seen[g as usize] = true;
                        turned[g as usize] = wanted;
                        found.faces.push(g);
                    } else if turned[g as usize] != wanted {
                        found.rest_count += 1;
                        found.witness = found.witness.min(h);
                    }
                }
            }
            visit(self, &found, turned);
        }
    }

    /// Whether the signed volume of closed faces is negative by more than rounding.
    fn is_inside_out(&self, faces: &[u32]) -> bool {
        let corners =
            || faces.iter().flat_map(|&f| self.faces.get(FaceId(f))).map(|&v| self.position(v));
        // Coordinates are brought to order 1 about a point of the surface, so that neither huge
        // nor tiny ones leave the range, nor a far place costs digits.
        let Some(first) = corners().next() else { return false };
        let reach = corners().fold(0.0, |reach, p| f64::max(reach, (p - first).max_abs()));
        if !(reach > 0.0 && reach.is_finite() && corners().all(Vec3::is_finite)) {
            return false;
        }
        let unit = |v: u32| (self.position(v) - first) / reach;
        let (mut volume, mut size, mut count) = (0.0, 0.0, 0.0);
        for &f in faces {
            let face = self.faces.get(FaceId(f));
            for pair in face[1..].windows(2) {
                let part = unit(face[0]).dot(unit(pair[0]).cross(unit(pair[1])));
                volume += part;
                size += part.abs();
                count += 1.0;
            }
        }
        volume < -size * f64::EPSILON * (count + 16.0)
    }

    fn position(&self, v: u32) -> Vec3 {
        self.positions[v as usize]
    }
}
