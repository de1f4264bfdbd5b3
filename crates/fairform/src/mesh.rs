//! [`Mesh`]: a topology and its positions.

use alloc::sync::Arc;
use alloc::vec::Vec;

use crate::error::{Defect, Defects, Error};
use crate::ids::VertexId;
use crate::{Faces, Topology, Vec3, par};

/// A polygon mesh: a shared, immutable [`Topology`] and one position per vertex.
#[derive(Clone, PartialEq, Debug)]
pub struct Mesh {
    topology: Arc<Topology>,
    positions: Vec<Vec3>,
}

impl Mesh {
    /// The mesh of `faces` on `positions`.
    ///
    /// # Errors
    /// [`Error::NotManifold`] with every defect of the faces and every coordinate that is not
    /// finite, [`Error::TooLarge`].
    pub fn new(positions: Vec<Vec3>, faces: &Faces) -> Result<Self, Error> {
        let not_finite = not_finite(&positions);
        match Topology::from_faces(positions.len(), faces) {
            Ok(topology) if not_finite.is_empty() => {
                Ok(Self { topology: Arc::new(topology), positions })
            }
            Ok(_) => Err(Error::NotManifold(Defects(not_finite))),
            Err(Error::NotManifold(Defects(defects))) => {
                Err(Error::NotManifold(Defects([not_finite, defects].concat())))
            }
            Err(other) => Err(other),
        }
    }

    /// A mesh on a topology that exists already.
    ///
    /// # Panics
    /// If there is not one position per vertex.
    #[must_use]
    pub fn from_parts(topology: Arc<Topology>, positions: Vec<Vec3>) -> Self {
        assert_eq!(positions.len(), topology.vertex_count(), "one position per vertex");
        Self { topology, positions }
    }

    /// The same connectivity at other positions.
    ///
    /// # Panics
    /// If there is not one position per vertex.
    #[must_use]
    pub fn with_positions(&self, positions: Vec<Vec3>) -> Self {
        Self::from_parts(Arc::clone(&self.topology), positions)
    }

    /// The connectivity.
    #[must_use]
    pub fn topology(&self) -> &Arc<Topology> {
        &self.topology
    }

    /// One position per vertex.
    #[must_use]
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// The positions, by value.
    #[must_use]
    pub fn into_positions(self) -> Vec<Vec3> {
        self.positions
    }

    /// The bounding box of the vertices that belong to a face.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        Bounds::of(
            self.topology
                .vertices()
                .filter(|&v| !self.topology.is_isolated(v))
                .map(|v| self.positions[v.index()]),
        )
    }
}

/// One [`Defect::NotFinite`] per vertex with a NaN or infinite coordinate.
#[must_use]
pub fn not_finite(positions: &[Vec3]) -> Vec<Defect> {
    let found = par::blocks(positions.len(), |range| {
        range.filter(|&v| !positions[v].is_finite()).collect::<Vec<_>>()
    });
    found.into_iter().flatten().map(|v| Defect::NotFinite { vertex: VertexId(v as u32) }).collect()
}

/// An axis-aligned box.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Bounds {
    /// Lowest coordinates.
    pub min: Vec3,
    /// Highest coordinates.
    pub max: Vec3,
}

impl Bounds {
    /// The smallest box around points; a single point at the origin if there are none.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        let mut points = points.into_iter();
        let first = points.next().unwrap_or_default();
        points.fold(Self { min: first, max: first }, |b, p| Self {
            min: b.min.min(p),
            max: b.max.max(p),
        })
    }

    /// From the lowest corner to the highest.
    #[must_use]
    pub fn size(&self) -> Vec3 {
        self.max - self.min
    }

    /// Length of the diagonal.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        self.size().length()
    }

    /// Length of the longest side.
    #[must_use]
    pub fn longest_side(&self) -> f64 {
        self.size().max_abs()
    }
}
