//! Welding: vertices at the same place, or nearly, become one.

use alloc::vec::Vec;
use core::cmp::Ordering;
use core::fmt;

use super::report::Sentence;
use super::{Sets, Soup, Touched, source};
use crate::{Vec3, VertexId};

/// A weld distance that is negative or not a number.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
#[error("a weld distance is zero or more, not {0}")]
pub struct BadDistance(pub f64);

/// What [`Soup::weld`] did.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
#[must_use]
pub struct WeldReport {
    /// The vertices that gave way to another one.
    pub joined: Touched<VertexId>,
    /// How many vertices took others in.
    pub survivor_count: usize,
}

impl WeldReport {
    /// Whether the soup is another one now.
    #[must_use]
    pub fn changed(&self) -> bool {
        !self.joined.is_empty()
    }
}

impl fmt::Display for WeldReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.changed() {
            return f.write_str("no vertices to join");
        }
        let mut sentence = Sentence::new(f);
        sentence.part("joined", &self.joined, ["vertex", "vertices"])?;
        sentence.end("")?;
        write!(f, " into {} others", self.survivor_count)
    }
}

impl Soup {
    /// Makes one vertex of those that lie within `distance` of each other, in the units of the
    /// positions; 0 joins only equal positions (where −0 equals 0).
    ///
    /// Joining is transitive: a row of vertices each within the distance of the next becomes one
    /// vertex. Of every set the smallest index survives and keeps its position; the others are
    /// removed. A vertex with a NaN coordinate is never joined; infinite coordinates are joined
    /// only where equal. Faces may come out with repeated corners:
    /// [`drop_degenerate`](Self::drop_degenerate) is the next step.
    ///
    /// # Errors
    /// If `distance` is negative or NaN.
    pub fn weld(&mut self, distance: f64) -> Result<WeldReport, BadDistance> {
        if distance.is_nan() || distance < 0.0 {
            return Err(BadDistance(distance));
        }
        let mut sets = Sets::new(self.positions.len());
        join_near(&self.positions, distance, &mut sets);

        let root: Vec<u32> = (0..self.positions.len() as u32).map(|v| sets.root(v)).collect();
        let stays: Vec<bool> = (0..).zip(&root).map(|(v, &r)| v == r).collect();
        let mut report = WeldReport::default();
        let mut survivors = Vec::new();
        for (v, &r) in (0..).zip(&root).filter(|&(v, &r)| v != r) {
            report.joined.vertex(source(&self.vertex_source, v));
            survivors.push(r);
        }
        survivors.sort_unstable();
        survivors.dedup();
        report.survivor_count = survivors.len();
        if report.changed() {
            self.keep_vertices(&stays, |v| root[v as usize]);
        }
        Ok(report)
    }
}

/// Joins the vertices within `distance` of each other.
fn join_near(positions: &[Vec3], distance: f64, sets: &mut Sets) {
    let at = |v: u32| positions[v as usize];
    let mut order: Vec<u32> =
        (0..positions.len() as u32).filter(|&v| !at(v).max_abs().is_nan()).collect();
    order.sort_unstable_by(|&a, &b| lexicographic(at(a), at(b)).then(a.cmp(&b)));
    for pair in order.windows(2) {
        if at(pair[0]) == at(pair[1]) {
            sets.join(pair[0], pair[1]);
        }
    }
    if distance > 0.0 {
        order.dedup_by(|a, b| at(*a) == at(*b));
        order.retain(|&v| at(v).is_finite());
        let mut tree = Tree { positions, distance, sets, nodes: Vec::new() };
        if !order.is_empty() {
            tree.grow(&mut order, 0);
            tree.join_within(&order, 0);
        }
    }
}

fn lexicographic(a: Vec3, b: Vec3) -> Ordering {
    let key = |v: Vec3| [v.x, v.y, v.z];
    key(a).partial_cmp(&key(b)).unwrap_or(Ordering::Equal)
}

/// A leaf of the tree holds at most so many points.
const LEAF: usize = 8;

/// A box of points: the range of them in the order of the tree, the children (0 in a leaf, since
/// the root is nobody's child), and whether the points are known to be one set.
struct Node {
    low: Vec3,
    high: Vec3,
    start: u32,
    end: u32,
    children: [u32; 2],
    is_one: bool,
}

/// A k-d tree of points all different, walked against itself.
///
/// Two boxes are looked at together only while they are within the distance of each other and not
/// yet one set, which is soon the case where points lie close; so a dense cluster costs no more
/// than a sparse one. The resulting sets do not depend on the shape of the tree.
struct Tree<'a> {
    positions: &'a [Vec3],
    distance: f64,
    sets: &'a mut Sets,
    nodes: Vec<Node>,
}

impl Tree<'_> {
    /// Builds the tree over `points`, which begin at `start` in the whole order.
    fn grow(&mut self, points: &mut [u32], start: u32) -> u32 {
        let positions = self.positions;
        let at = |v: u32| positions[v as usize];
        let first = at(points[0]);
        let (low, high) =
            points.iter().fold((first, first), |(l, h), &v| (l.min(at(v)), h.max(at(v))));
        let id = self.nodes.len() as u32;
        let end = start + points.len() as u32;
        self.nodes.push(Node { low, high, start, end, children: [0; 2], is_one: false });
        if points.len() > LEAF {
            let size = high - low;
            let axis = (0..3).fold(0, |best, i| if size[i] > size[best] { i } else { best });
            let middle = points.len() / 2;
            points.select_nth_unstable_by(middle, |&a, &b| {
                at(a)[axis].total_cmp(&at(b)[axis]).then(a.cmp(&b))
            });
            let (left, right) = points.split_at_mut(middle);
            let left = self.grow(left, start);
            let right = self.grow(right, start + middle as u32);
            self.nodes[id as usize].children = [left, right];
        }
        id
    }

    fn join_within(&mut self, order: &[u32], id: u32) {
        let node = &self.nodes[id as usize];
        let (range, children) = (node.start as usize..node.end as usize, node.children);
        if (node.high - node.low).length() <= self.distance {
            for &v in &order[range.clone()] {
                self.sets.join(order[range.start], v);
            }
            self.mark(id);
        } else if children == [0; 2] {
            for i in range.clone() {
                for j in i + 1..range.end {
                    self.join_if_near(order[i], order[j]);
                }
            }
            let root = self.sets.root(order[range.start]);
            let is_one = order[range].iter().all(|&v| self.sets.root(v) == root);
            self.nodes[id as usize].is_one = is_one;
        } else {
            let [left, right] = children;
            self.join_within(order, left);
            self.join_within(order, right);
            self.join_across(order, left, right);
            self.nodes[id as usize].is_one = self.are_one(order, left, right);
        }
    }

    fn join_across(&mut self, order: &[u32], a: u32, b: u32) {
        let (p, q) = (&self.nodes[a as usize], &self.nodes[b as usize]);
        let gap = (q.low - p.high).max(p.low - q.high).max(Vec3::ZERO);
        if gap.length() > self.distance || self.are_one(order, a, b) {
            return;
        }
        let (p, q) = (&self.nodes[a as usize], &self.nodes[b as usize]);
        let span = (q.high - p.low).max(p.high - q.low);
        let (p_range, q_range) =
            (p.start as usize..p.end as usize, q.start as usize..q.end as usize);
        if span.length() <= self.distance {
            let first = order[p_range.start];
            for &v in order[p_range].iter().chain(&order[q_range]) {
                self.sets.join(first, v);
            }
            return;
        }
        let descend_p = match (p.children, q.children) {
            ([0, 0], [0, 0]) => {
                for &v in &order[p_range] {
                    for &w in &order[q_range.clone()] {
                        self.join_if_near(v, w);
                    }
                }
                return;
            }
            (_, [0, 0]) => true,
            ([0, 0], _) => false,
            _ => (p.high - p.low).max_abs() >= (q.high - q.low).max_abs(),
        };
        let (children, other) = if descend_p { (p.children, b) } else { (q.children, a) };
        for child in children {
            self.join_across(order, child, other);
        }
    }

    fn join_if_near(&mut self, v: u32, w: u32) {
        if (self.positions[v as usize] - self.positions[w as usize]).length() <= self.distance {
            self.sets.join(v, w);
        }
    }

    /// Whether the points of two boxes are known to be one set.
    fn are_one(&mut self, order: &[u32], a: u32, b: u32) -> bool {
        let (p, q) = (&self.nodes[a as usize], &self.nodes[b as usize]);
        let (v, w) = (order[p.start as usize], order[q.start as usize]);
        p.is_one && q.is_one && self.sets.root(v) == self.sets.root(w)
    }

    /// Marks a box and those inside it as one set.
    fn mark(&mut self, id: u32) {
        let node = &mut self.nodes[id as usize];
        node.is_one = true;
        if node.children != [0; 2] {
            let [left, right] = node.children;
            self.mark(left);
            self.mark(right);
        }
    }
}
