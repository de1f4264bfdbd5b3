//! One refinement step: a topology goes to a finer one and the rows that carry values over.

use alloc::sync::Arc;
use alloc::vec::Vec;

use crate::error::Error;
use crate::scheme::{Corners, Scheme};
use crate::{Mesh, Stencils, Topology};

mod loop_step;

/// A finer topology, and the values on it as weighted sums of values on the coarser.
#[derive(Clone, PartialEq, Debug)]
pub struct Refined {
    /// The finer topology, in the canonical order: old vertices first, then edge points.
    pub topology: Topology,
    /// One row per finer vertex.
    pub stencils: Stencils,
}

/// One step of a scheme.
///
/// # Errors
/// [`Error::NotTriangles`] if the scheme cannot refine these faces, [`Error::TooLarge`] if the
/// result has too many half-edges.
pub fn refine(topology: &Topology, scheme: Scheme, corners: Corners) -> Result<Refined, Error> {
    scheme.check(topology)?;
    match scheme {
        Scheme::Loop => loop_step::refine(topology, corners),
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
        let Refined { topology, stencils } = refine(mesh.topology(), scheme, corners)?;
        mesh = Mesh::from_parts(Arc::new(topology), stencils.apply(mesh.positions()));
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

/// The parent face of each face after one step.
#[must_use]
pub fn parent_faces(coarse: &Topology, scheme: Scheme) -> Vec<u32> {
    match scheme {
        Scheme::Loop => (0..coarse.face_count() as u32).flat_map(|f| [f; 4]).collect(),
    }
}
