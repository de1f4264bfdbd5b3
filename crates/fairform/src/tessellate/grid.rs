//! [`Grid`]: the points and faces that a triangle or quadrilateral is cut into.
//!
//! ```text
//!   (0,N)                        corners in the order of the face, at (0,0), (N,0) and (0,N), or
//!     c                          (0,0), (N,0), (N,N) and (0,N), where N = 2^levels
//!     │╲      v                  sides in the order of the half-edges: point t of side i lies t
//!     │ ╲     ↑                  steps from corner i, 0 < t < N
//!     ┼──┼    ┼→ u               inner points row by row: v = 1, 2, …, and in each u = 1, 2, …
//!     │╲ │╲
//!     a──┼─b (N,0)
//! ```

use alloc::vec::Vec;

use super::MOST_AT_ONCE;
use crate::Topology;
use crate::ids::FaceId;

/// What each face is cut into. Its points are numbered corners first, then sides, then inner ones.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// Corners of a face: 3 or 4.
    pub(super) corners: usize,
    pub(super) levels: u32,
    /// Points inside each side.
    pub(super) side: usize,
    /// Points off the sides.
    pub(super) inner: usize,
    /// The faces, row by row, in points of the grid.
    pub(super) faces: Vec<u16>,
}

impl Grid {
    pub(super) fn new(corners: usize, levels: u32) -> Self {
        let n = 1_usize << levels;
        let (side, inner) = (
            n - 1,
            if corners == 3 { (n - 1) * n.saturating_sub(2) / 2 } else { (n - 1) * (n - 1) },
        );
        let mut grid = Self { corners, levels, side, inner, faces: Vec::new() };
        let mut faces = Vec::with_capacity(corners * grid.face_count());
        for v in 0..n {
            for u in 0..if corners == 3 { n - v } else { n } {
                let at = |[u, v]: [usize; 2]| grid.number(u, v) as u16;
                let (right, up, far) = ([u + 1, v], [u, v + 1], [u + 1, v + 1]);
                if corners == 4 {
                    faces.extend([[u, v], right, far, up].map(at));
                    continue;
                }
                faces.extend([[u, v], right, up].map(at));
                if u + v + 1 < n {
                    faces.extend([right, far, up].map(at));
                }
            }
        }
        grid.faces = faces;
        grid
    }

    /// Whether the rows of a class take so much memory that none are stored twice.
    pub(super) fn is_large(&self) -> bool {
        self.levels > MOST_AT_ONCE
    }

    pub(super) fn segments(&self) -> usize {
        self.side + 1
    }

    pub(super) fn face_count(&self) -> usize {
        self.segments() * self.segments()
    }

    pub(super) fn point_count(&self) -> usize {
        self.first_inner() + self.inner
    }

    /// The first point of a side.
    pub(super) fn first_of_side(&self, i: usize) -> usize {
        self.corners + i * self.side
    }

    pub(super) fn first_inner(&self) -> usize {
        self.first_of_side(self.corners)
    }

    /// The coordinates of a point on a side, `t` segments from its beginning.
    pub(super) fn on_side(&self, i: usize, t: usize) -> [usize; 2] {
        let n = self.segments();
        match (self.corners, i) {
            (_, 0) => [t, 0],
            (3, 1) => [n - t, t],
            (3, _) => [0, n - t],
            (_, 1) => [n, t],
            (_, 2) => [n - t, n],
            _ => [0, n - t],
        }
    }

    /// The number of the point with such coordinates.
    pub(super) fn number(&self, u: usize, v: usize) -> usize {
        let n = self.segments();
        let on_side = |i: usize, t: usize| if t == 0 { i } else { self.first_of_side(i) + t - 1 };
        if self.corners == 3 {
            return match (u, v) {
                (u, 0) if u < n => on_side(0, u),
                (u, v) if u + v == n && v < n => on_side(1, v),
                (0, v) => on_side(2, n - v),
                // Rows have n - 2, n - 3, … points.
                (u, v) => self.first_inner() + (v - 1) * (2 * n - 2 - v) / 2 + u - 1,
            };
        }
        match (u, v) {
            (u, 0) if u < n => on_side(0, u),
            (u, v) if u == n && v < n => on_side(1, v),
            (u, v) if v == n && u > 0 => on_side(2, n - u),
            (0, v) => on_side(3, n - v),
            (u, v) => self.first_inner() + (v - 1) * (n - 1) + u - 1,
        }
    }

    /// For each point of the grid of a face, its vertex in the topology that so many steps made of
    /// one with that face.
    pub(super) fn vertices(&self, finest: &Topology, face: usize) -> Vec<u32> {
        let n = self.segments();
        let mut vertices = alloc::vec![0; self.point_count()];
        let corners = if self.corners == 3 {
            alloc::vec![[0, 0], [n, 0], [0, n]]
        } else {
            alloc::vec![[0, 0], [n, 0], [n, n], [0, n]]
        };
        self.visit(finest, face, self.levels, &corners, &mut vertices);
        vertices
    }

    fn visit(
        &self,
        finest: &Topology,
        face: usize,
        levels: u32,
        corners: &[[usize; 2]],
        vertices: &mut [u32],
    ) {
        if levels == 0 {
            for (&[u, v], q) in corners.iter().zip(finest.face_vertices(FaceId(face as u32))) {
                vertices[self.number(u, v)] = q.0;
            }
            return;
        }
        let k = corners.len();
        let middle = |i: usize, j: usize| {
            let (a, b) = (corners[i % k], corners[j % k]);
            [usize::midpoint(a[0], b[0]), usize::midpoint(a[1], b[1])]
        };
        for i in 0..4 {
            // The children as the steps number them.
            let child = match (k, i) {
                (3, 3) => alloc::vec![middle(0, 1), middle(1, 2), middle(2, 0)],
                (3, _) => alloc::vec![corners[i % k], middle(i, i + 1), middle(i + 2, i)],
                _ => alloc::vec![corners[i % k], middle(i, i + 1), middle(0, 2), middle(i + 3, i)],
            };
            self.visit(finest, 4 * face + i, levels - 1, &child, vertices);
        }
    }
}
