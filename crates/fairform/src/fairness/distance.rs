//! Distances from points to a mesh.

use alloc::vec::Vec;

use libm::sqrt;

use super::frame::Unit;
use crate::repair::Soup;
use crate::{Bounds, Mesh, Vec3, par};

/// Distances of many points, summed up, in the unit of length of the points.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Deviation {
    /// Largest: the one-sided Hausdorff distance, as far as the points show it.
    pub max: f64,
    /// Mean.
    pub mean: f64,
    /// Root of the mean square.
    pub rms: f64,
}

impl Deviation {
    /// The summary of distances; zero of none.
    #[must_use]
    pub fn of(distances: &[f64]) -> Self {
        let max = distances.iter().copied().fold(0.0, f64::max);
        if max <= 0.0 || !max.is_finite() {
            return Self::default();
        }
        let sums = par::blocks(distances.len(), |range| {
            range.fold([0.0; 2], |[sum, squares], i| {
                let d = distances[i] / max;
                [sum + d, squares + d * d]
            })
        });
        let [sum, squares] =
            sums.into_iter().fold([0.0; 2], |[a, b], [sum, squares]| [a + sum, b + squares]);
        let count = distances.len() as f64;
        Self { max, mean: max * (sum / count), rms: max * sqrt(squares / count) }
    }
}

/// The deviation of points, say of the vertices of a fine surface, from a mesh of any polygons.
#[must_use]
pub fn deviation(points: &[Vec3], mesh: &Mesh) -> Deviation {
    Deviation::of(&distances(points, mesh))
}

/// Both one-sided deviations: of the vertices of `surface` from `mesh`, and of as many points of the
/// faces of `mesh`, see [`samples`], from `surface`.
#[must_use]
pub fn mutual_deviation(surface: &Mesh, mesh: &Mesh) -> [Deviation; 2] {
    let points = samples(mesh, surface.positions().len());
    [deviation(surface.positions(), mesh), deviation(&points, surface)]
}

/// The exact distance of every point from the nearest triangle of a mesh, its polygons cut as
/// [`Soup::triangulate`] cuts them.
///
/// Zero for points that are not finite, and if no face has only finite coordinates.
#[must_use]
pub fn distances(points: &[Vec3], mesh: &Mesh) -> Vec<f64> {
    let unit = Unit::of(points.iter().chain(mesh.positions()));
    let mut triangles = triangles(mesh);
    for corner in triangles.iter_mut().flatten() {
        *corner = unit.point(*corner);
    }
    let tree = Tree::new(&triangles);
    par::collect(points.len(), |i| match tree.distance(unit.point(points[i])) {
        Some(d) => unit.restore(d, 1),
        None => 0.0,
    })
}

/// Points of the faces of a mesh, about `count` of them, evenly spread in each triangle and alike in
/// all, corners and edges left out: at least one per triangle.
#[must_use]
pub fn samples(mesh: &Mesh, count: usize) -> Vec<Vec3> {
    let triangles = triangles(mesh);
    let each = count.div_ceil(triangles.len().max(1)).max(1);
    // A side cut in n gives n² small triangles, and these are their centroids.
    let n = (sqrt(each as f64) as usize).max(1);
    let mut points = Vec::with_capacity(triangles.len() * n * n);
    let third = 1.0 / 3.0;
    for [a, b, c] in triangles {
        let at = |i: f64, j: f64| {
            let (s, t) = (i / n as f64, j / n as f64);
            (1.0 - s - t) * a + s * b + t * c
        };
        for i in 0..n {
            for j in 0..n - i {
                let (i, j, upside_down) = (i as f64, j as f64, i + j + 1 < n);
                points.push(at(i + third, j + third));
                if upside_down {
                    points.push(at(i + 2.0 * third, j + 2.0 * third));
                }
            }
        }
    }
    points
}

/// The triangles of a mesh, without those that have a coordinate that is not finite.
fn triangles(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    let positions = mesh.positions();
    let mut soup = Soup::new(positions.to_vec(), mesh.topology().to_faces());
    let _ = soup.triangulate();
    let corners = soup.faces.iter().map(|f| [0, 1, 2].map(|i| positions[f[i] as usize]));
    corners.filter(|t| t.iter().all(|p| p.is_finite())).collect()
}

/// Most triangles in a leaf.
const LEAF: usize = 4;

/// Triangles in a balanced binary tree of boxes.
struct Tree {
    /// In order, so that each leaf is a range.
    triangles: Vec<[Vec3; 3]>,
    /// Parents before children; a lower child lies right behind its parent.
    nodes: Vec<Node>,
}

struct Node {
    min: Vec3,
    max: Vec3,
    /// Of a leaf its first triangle, otherwise the upper child.
    first: u32,
    /// Triangles of a leaf, otherwise zero.
    count: u32,
}

impl Tree {
    fn new(triangles: &[[Vec3; 3]]) -> Self {
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let mut nodes = Vec::with_capacity(triangles.len());
        if !order.is_empty() {
            build(triangles, &mut order, 0, &mut nodes);
        }
        Self { triangles: order.into_iter().map(|t| triangles[t as usize]).collect(), nodes }
    }

    /// `None` if there are no triangles or the point is NaN.
    fn distance(&self, p: Vec3) -> Option<f64> {
        let mut best = f64::INFINITY;
        // Halving a range of 2³² takes 32 levels, and of each one child waits.
        let mut stack = [(0, 0.0); 40];
        let mut height = usize::from(!self.nodes.is_empty() && p.is_finite());
        while height > 0 {
            height -= 1;
            let (at, square) = stack[height];
            if square >= best {
                continue;
            }
            let node = &self.nodes[at];
            if node.count > 0 {
                let first = node.first as usize;
                for triangle in &self.triangles[first..first + node.count as usize] {
                    best = best.min(square_to_triangle(p, triangle));
                }
                continue;
            }
            let child = |at: usize| (at, self.nodes[at].square_to(p));
            let (lower, upper) = (child(at + 1), child(node.first as usize));
            let (near, far) = if upper.1 < lower.1 { (upper, lower) } else { (lower, upper) };
            stack[height] = far;
            stack[height + 1] = near;
            height += 2;
        }
        (best < f64::INFINITY).then(|| sqrt(best))
    }
}

/// Appends the nodes over a part of the triangles that begins at `first`, halving at the median
/// along the longest side of the box of the centres.
fn build(triangles: &[[Vec3; 3]], order: &mut [u32], first: u32, nodes: &mut Vec<Node>) {
    let corners = order.iter().flat_map(|&t| triangles[t as usize]);
    let bounds = Bounds::of(corners);
    let at = nodes.len();
    let count = if order.len() <= LEAF { order.len() as u32 } else { 0 };
    nodes.push(Node { min: bounds.min, max: bounds.max, first, count });
    if count > 0 {
        return;
    }
    let centre = |t: u32| triangles[t as usize].into_iter().sum::<Vec3>();
    let size = Bounds::of(order.iter().map(|&t| centre(t))).size();
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let middle = order.len() / 2;
    let key = |&t: &u32| (centre(t)[axis], t);
    order.select_nth_unstable_by(middle, |a, b| {
        let (a, b) = (key(a), key(b));
        a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
    });
    let (lower, upper) = order.split_at_mut(middle);
    build(triangles, lower, first, nodes);
    nodes[at].first = nodes.len() as u32;
    build(triangles, upper, first + middle as u32, nodes);
}

impl Node {
    /// Square of the distance from a point to the box.
    fn square_to(&self, p: Vec3) -> f64 {
        let outside = (self.min - p).max(p - self.max).max(Vec3::ZERO);
        outside.dot(outside)
    }
}

/// Square of the distance from a point to a triangle, which may be a segment or a point.
pub(crate) fn square_to_triangle(p: Vec3, &[a, b, c]: &[Vec3; 3]) -> f64 {
    let sides = square_to_segment(p, a, b).min(square_to_segment(p, b, c));
    let rim = sides.min(square_to_segment(p, c, a));
    // Coordinates of the foot of the perpendicular, times the square of twice the area.
    let (u, v, w) = (b - a, c - a, p - a);
    let normal = u.cross(v);
    let square = normal.dot(normal);
    let (s, t) = (w.cross(v).dot(normal), u.cross(w).dot(normal));
    if square > 0.0 && s >= 0.0 && t >= 0.0 && s + t <= square {
        // A point of the triangle even if rounding moved it, so never an underestimate.
        let offset = w - (s / square) * u - (t / square) * v;
        return rim.min(offset.dot(offset));
    }
    rim
}

pub(crate) fn square_to_segment(p: Vec3, a: Vec3, b: Vec3) -> f64 {
    let (side, w) = (b - a, p - a);
    let length = side.dot(side);
    let t = if length > 0.0 { (w.dot(side) / length).clamp(0.0, 1.0) } else { 0.0 };
    let offset = w - t * side;
    offset.dot(offset)
}
