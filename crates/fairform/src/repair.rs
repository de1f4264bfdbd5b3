//! Explicit repair of polygon soup, one step at a time; every step says what it did.
//!
//! Nothing here happens by itself: a mesh with a defect is refused by name elsewhere, and whoever
//! wants it mended picks the steps. A usual order is
//!
//! ```text
//! weld → drop_degenerate → drop_duplicates → orient → split_non_manifold → drop_isolated
//! ```
//!
//! after which the soup is an oriented 2-manifold with boundary, whatever it was before. A soup
//! that is one already goes through unchanged, and so does every soup the second time.
//!
//! ```
//! use fairform::repair::Soup;
//! use fairform::{Faces, Vec3};
//!
//! // A square as two triangles that do not know each other, as some files have it.
//! let at = |x, y| Vec3::new(x, y, 0.0);
//! let positions =
//!     vec![at(0., 0.), at(1., 0.), at(0., 1.), at(1., 0.), at(1., 1.), at(0., 1.)];
//! let mut soup = Soup::new(positions, Faces::uniform(3, (0..6).collect()));
//!
//! let report = soup.weld(0.0)?;
//! assert_eq!(report.to_string(), "joined 2 vertices (3, 5) into 2 others");
//! assert_eq!(soup.faces.corners(), [0, 1, 2, 1, 3, 2]);
//! assert_eq!(soup.vertex_source, [0, 1, 2, 4]);
//! # Ok::<(), fairform::repair::BadDistance>(())
//! ```
//!
//! A face is *proper* if it has at least three corners, all different and all in range. Steps that
//! look at neighbours ([`orient`](Soup::orient), [`split_non_manifold`](Soup::split_non_manifold),
//! [`triangulate`](Soup::triangulate), …) pass over the others as if they were not there;
//! [`drop_degenerate`](Soup::drop_degenerate) removes them.

mod degenerate;
mod duplicates;
mod edges;
mod holes;
mod isolated;
mod orient;
mod polygon;
mod report;
mod split;
mod triangulate;
mod weld;

use alloc::vec::Vec;
use core::ops::Range;

pub use degenerate::DegenerateReport;
pub use duplicates::DuplicateReport;
pub use holes::HoleReport;
pub use isolated::IsolatedReport;
pub use orient::{OrientReport, OutwardReport};
pub use report::Touched;
pub use split::SplitReport;
pub use triangulate::TriangulateReport;
pub use weld::{BadDistance, WeldReport};

use crate::{FaceId, Faces, NONE, Vec3};

/// A polygon soup under repair, and where each of its parts came from, so that attributes can
/// follow.
///
/// The lists of sources are as long as what they describe. A step reads a missing entry as
/// [`NONE`], so a caller who changes the lists does no worse than lose the trace.
#[derive(Clone, PartialEq, Debug)]
pub struct Soup {
    /// Positions of the vertices.
    pub positions: Vec<Vec3>,
    /// The polygons.
    pub faces: Faces,
    /// Input vertex of each vertex; [`NONE`] if it is new.
    pub vertex_source: Vec<u32>,
    /// Input face of each face; [`NONE`] if it is new, as in a filled hole.
    pub face_source: Vec<u32>,
    /// Input corner of each corner, counted through all faces; [`NONE`] if it is new.
    pub corner_source: Vec<u32>,
}

impl Soup {
    /// A soup as it comes in: every part is its own source.
    ///
    /// # Panics
    /// If there are 2³² − 1 vertices or more.
    #[must_use]
    pub fn new(positions: Vec<Vec3>, faces: Faces) -> Self {
        assert!(positions.len() < NONE as usize, "fewer than 2^32 - 1 vertices");
        Self {
            vertex_source: (0..positions.len() as u32).collect(),
            face_source: (0..faces.len() as u32).collect(),
            corner_source: (0..faces.corners().len() as u32).collect(),
            positions,
            faces,
        }
    }

    /// The corners of a face, counted through all faces.
    fn corners_of(&self, face: u32) -> core::ops::Range<u32> {
        let Range { start, end } = self.faces.range(FaceId(face));
        start as u32..end as u32
    }

    /// The vertex at a corner.
    fn vertex(&self, corner: u32) -> u32 {
        self.faces.corners()[corner as usize]
    }

    /// Which faces are proper: three corners or more, all different, all in range.
    fn proper_faces(&self) -> Vec<bool> {
        let mut sorted = Vec::new();
        self.faces
            .iter()
            .map(|face| {
                sorted.clear();
                sorted.extend_from_slice(face);
                sorted.sort_unstable();
                face.len() >= 3
                    && sorted.windows(2).all(|w| w[0] != w[1])
                    && sorted.last().is_some_and(|&v| (v as usize) < self.positions.len())
            })
            .collect()
    }

    /// Removes the vertices for which `stays` is false, and renames the others in the faces through
    /// `image`, which maps every old vertex to an old one that stays.
    fn keep_vertices(&mut self, stays: &[bool], image: impl Fn(u32) -> u32) {
        let mut name = Vec::with_capacity(stays.len());
        let mut count = 0;
        for &stay in stays {
            name.push(if stay { count } else { NONE });
            count += u32::from(stay);
        }
        let mut old = 0..stays.len();
        self.positions.retain(|_| old.next().is_some_and(|v| stays[v]));
        self.vertex_source = (0..stays.len())
            .filter(|&v| stays[v])
            .map(|v| source(&self.vertex_source, v as u32))
            .collect();
        // An index out of range is above every index in range, so it stays out of range.
        self.rename(|_, v| if (v as usize) < stays.len() { name[image(v) as usize] } else { v });
    }

    /// Gives every corner the vertex `new(corner, vertex)`.
    fn rename(&mut self, new: impl Fn(u32, u32) -> u32) {
        let mut faces = Faces::with_capacity(self.faces.len(), self.faces.corners().len());
        let mut renamed = Vec::new();
        let mut corner = 0;
        for face in self.faces.iter() {
            renamed.clear();
            for &v in face {
                renamed.push(new(corner, v));
                corner += 1;
            }
            faces.push(&renamed);
        }
        self.faces = faces;
    }

    /// Reverses the faces for which `turned` is true; each keeps its first corner.
    fn turn(&mut self, turned: &[bool]) {
        let mut rebuilt = Rebuilt::for_faces_of(self);
        let mut corners = Vec::new();
        for (f, &turn) in turned.iter().enumerate() {
            corners.clear();
            corners.extend(self.corners_of(f as u32));
            if turn && corners.len() > 1 {
                corners[1..].reverse();
            }
            rebuilt.push(self, f as u32, &corners);
        }
        rebuilt.replace(self);
    }
}

/// The source of a part; [`NONE`] where the list has been cut short.
fn source(sources: &[u32], part: u32) -> u32 {
    sources.get(part as usize).copied().unwrap_or(NONE)
}

/// The faces that a step leaves, and where they come from.
struct Rebuilt {
    faces: Faces,
    face_source: Vec<u32>,
    corner_source: Vec<u32>,
    scratch: Vec<u32>,
}

impl Rebuilt {
    fn for_faces_of(soup: &Soup) -> Self {
        let (faces, corners) = (soup.faces.len(), soup.faces.corners().len());
        Self {
            faces: Faces::with_capacity(faces, corners),
            face_source: Vec::with_capacity(faces),
            corner_source: Vec::with_capacity(corners),
            scratch: Vec::new(),
        }
    }

    /// Appends a face made of `corners` of the soup, which come from its face `face`.
    fn push(&mut self, soup: &Soup, face: u32, corners: &[u32]) {
        self.scratch.clear();
        self.scratch.extend(corners.iter().map(|&c| soup.vertex(c)));
        self.faces.push(&self.scratch);
        self.face_source.push(source(&soup.face_source, face));
        self.corner_source.extend(corners.iter().map(|&c| source(&soup.corner_source, c)));
    }

    /// Appends a face as it is.
    fn keep(&mut self, soup: &Soup, face: u32) {
        self.faces.push(soup.faces.get(FaceId(face)));
        self.face_source.push(source(&soup.face_source, face));
        self.corner_source.extend(soup.corners_of(face).map(|c| source(&soup.corner_source, c)));
    }

    fn replace(self, soup: &mut Soup) {
        soup.faces = self.faces;
        soup.face_source = self.face_source;
        soup.corner_source = self.corner_source;
    }
}

/// Disjoint sets of numbers; the root of a set is its smallest number.
struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    fn root(&mut self, mut a: u32) -> u32 {
        while self.parent[a as usize] != a {
            let above = self.parent[self.parent[a as usize] as usize];
            self.parent[a as usize] = above;
            a = above;
        }
        a
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}
