//! One refinement step: a topology goes to a finer one and the rows that carry values over.

use alloc::sync::Arc;
use alloc::vec::Vec;

use crate::error::Error;
use crate::ids::FaceId;
use crate::scheme::{Corners, Scheme};
use crate::{Mesh, Stencils, Topology, Vec3};

mod loop_step;

/// One refinement step: the finer topology, and how values are carried over to it.
#[derive(Clone, PartialEq, Debug)]
pub struct Refined<'t> {
    coarse: &'t Topology,
    scheme: Scheme,
    corners: Corners,
    /// The finer topology, in the canonical order: old vertices first, then edge points.
    pub topology: Topology,
}

/// One step of a scheme.
///
/// # Errors
/// [`Error::NotTriangles`] if the scheme cannot refine these faces, [`Error::TooLarge`] if the
/// result has too many half-edges.
pub fn refine(topology: &Topology, scheme: Scheme, corners: Corners) -> Result<Refined<'_>, Error> {
    check_size(topology, scheme, 1)?;
    let finer = match scheme {
        Scheme::Loop => loop_step::finer_topology(topology),
    };
    Ok(Refined { coarse: topology, scheme, corners, topology: finer })
}

impl Refined<'_> {
    /// The values at the finer vertices, from one value per coarser vertex: positions, or whatever
    /// else is to be as smooth.
    ///
    /// # Panics
    /// If there is not one value per coarser vertex.
    #[must_use]
    pub fn apply(&self, values: &[Vec3]) -> Vec<Vec3> {
        assert_eq!(values.len(), self.coarse.vertex_count(), "one value per vertex");
        match self.scheme {
            Scheme::Loop => loop_step::apply(self.coarse, self.corners, values),
        }
    }

    /// The rows that [`apply`](Self::apply) stands for, one per finer vertex.
    #[must_use]
    pub fn stencils(&self) -> Stencils {
        match self.scheme {
            Scheme::Loop => loop_step::stencils(self.coarse, self.corners),
        }
    }

    /// The coarser face that a finer face is a part of.
    ///
    /// # Panics
    /// If there is no such face.
    #[must_use]
    pub fn parent(&self, face: FaceId) -> FaceId {
        assert!(face.index() < self.topology.face_count(), "no face {face}");
        match self.scheme {
            Scheme::Loop => FaceId(face.0 / 4),
        }
    }

    /// Carries one value per face corner over to the finer corners, within each face by linear
    /// interpolation: the right thing for texture coordinates with seams, which stay seams.
    ///
    /// # Panics
    /// If there is not one value per coarser corner.
    #[must_use]
    pub fn apply_to_corners(&self, values: &[Vec3]) -> Vec<Vec3> {
        assert_eq!(values.len(), self.coarse.halfedge_count(), "one value per corner");
        match self.scheme {
            Scheme::Loop => loop_step::apply_to_corners(values),
        }
    }
}

/// Several steps of a scheme, on the positions of a mesh.
///
/// # Errors
/// As [`refine`].
pub fn refine_mesh(
    mesh: &Mesh,
    scheme: Scheme,
    corners: Corners,
    levels: u32,
) -> Result<Mesh, Error> {
    check_size(mesh.topology(), scheme, levels)?;
    let mut mesh = mesh.clone();
    for _ in 0..levels {
        let step = refine(mesh.topology(), scheme, corners)?;
        let positions = step.apply(mesh.positions());
        mesh = Mesh::from_parts(Arc::new(step.topology), positions);
    }
    Ok(mesh)
}

/// How many vertices, edges and faces there will be after so many steps.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Size {
    /// Vertices.
    pub vertex_count: u64,
    /// Edges.
    pub edge_count: u64,
    /// Faces.
    pub face_count: u64,
    /// Half-edges.
    pub halfedge_count: u64,
}

/// The size of a mesh after refinement, without refining.
///
/// # Errors
/// [`Error::TooLarge`] if the half-edges could not be numbered; as [`Scheme::check`].
pub fn check_size(topology: &Topology, scheme: Scheme, levels: u32) -> Result<Size, Error> {
    scheme.check(topology)?;
    let mut size = Size {
        vertex_count: topology.vertex_count() as u64,
        edge_count: topology.edge_count() as u64,
        face_count: topology.face_count() as u64,
        halfedge_count: topology.halfedge_count() as u64,
    };
    if size.face_count == 0 {
        return Ok(size);
    }
    for _ in 0..levels {
        size = match scheme {
            Scheme::Loop => Size {
                vertex_count: size.vertex_count + size.edge_count,
                edge_count: 2 * size.edge_count + 3 * size.face_count,
                face_count: 4 * size.face_count,
                halfedge_count: 4 * size.halfedge_count,
            },
        };
        if size.halfedge_count > crate::topology::MAX_HALFEDGES {
            return Err(Error::TooLarge { halfedges: size.halfedge_count });
        }
    }
    Ok(size)
}
