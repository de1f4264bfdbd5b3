//! [`Geometry`]: a mesh as the screen takes it.

use fairform::tessellate::Surface;
use fairform::{Faces, Mesh, Vec3, fairness};
use fairform_io::triangles;

/// A mesh to draw.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Geometry {
    /// Where the vertices are.
    pub positions: Vec<[f32; 3]>,
    /// Their unit normals.
    pub normals: Vec<[f32; 3]>,
    /// The faces, polygons cut into triangles.
    pub triangles: Vec<[u32; 3]>,
    /// The face of the given mesh that each triangle belongs to.
    pub face_of_triangle: Vec<u32>,
    /// The edges of the polygons.
    pub edges: Vec<[u32; 2]>,
}

/// Points in single precision.
pub(crate) fn single(points: &[Vec3]) -> Vec<[f32; 3]> {
    points.iter().map(|&p| p.into()).collect()
}

impl Geometry {
    /// A mesh as it is, with the normals of its vertices. `origin` tells the face of the given mesh that
    /// each face is a part of.
    pub(crate) fn of_mesh(mesh: &Mesh, origin: impl Fn(u32) -> u32) -> Self {
        let topology = mesh.topology();
        let positions = mesh.positions();
        let (triangles, mut face_of_triangle) = triangles(positions, &topology.to_faces());
        face_of_triangle.iter_mut().for_each(|f| *f = origin(*f));
        let ends = topology.edges().map(|e| {
            let h = topology.edge_halfedge(e);
            [topology.origin(h).0, topology.target(h).0]
        });
        Self {
            positions: single(positions),
            normals: single(&fairness::vertex_normals(topology, positions)),
            triangles,
            face_of_triangle,
            edges: ends.collect(),
        }
    }

    /// The points of a tessellation. `origin` are the faces of the given mesh that the faces of the base are
    /// parts of; `shown` tells which of those have a surface, if not all have.
    pub(crate) fn of_surface(
        surface: &Surface<'_>,
        origin: &[u32],
        shown: Option<&[bool]>,
    ) -> Self {
        let fine = surface.tessellation();
        let mut positions = vec![[0.0; 3]; fine.vertex_count()];
        let mut normals = positions.clone();
        surface.fill(&mut positions, Some(&mut normals));
        let faces = fine.faces();
        let is_shown = |f: u32| shown.is_none_or(|shown| shown[f as usize]);
        let mut of_face = fine.base_of_faces();
        of_face.iter_mut().for_each(|f| *f = origin[*f as usize]);
        let (mut triangles, mut face_of_triangle) = match faces.uniform_size() {
            Some(3) => (faces.corners().as_chunks::<3>().0.to_vec(), of_face.clone()),
            Some(4) => {
                let quads = faces.corners().as_chunks::<4>().0;
                let halves = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
                let each = of_face.iter().flat_map(|&f| [f, f]);
                (halves.collect::<Vec<_>>(), each.collect())
            }
            _ => {
                let points = surface.points();
                let (triangles, mut face_of) = self::triangles(&points, &faces);
                face_of.iter_mut().for_each(|f| *f = of_face[*f as usize]);
                (triangles, face_of)
            }
        };
        let edges = if shown.is_none() {
            edges(&faces, positions.len())
        } else {
            let mut of_triangle = face_of_triangle.iter();
            triangles.retain(|_| of_triangle.next().is_some_and(|&f| is_shown(f)));
            face_of_triangle.retain(|&f| is_shown(f));
            let kept = faces.iter().zip(&of_face).filter(|f| is_shown(*f.1));
            edges(&kept.map(|f| f.0).collect(), positions.len())
        };
        Self { positions, normals, triangles, face_of_triangle, edges }
    }
}

/// The edges of faces, each once. Neighbours run along their edge in opposite directions.
fn edges(faces: &Faces, vertex_count: usize) -> Vec<[u32; 2]> {
    let directed = || {
        faces.iter().flat_map(|face| {
            (0..face.len())
                .map(move |i| [face[i], face[if i + 1 == face.len() { 0 } else { i + 1 }]])
        })
    };
    // What comes into an inner vertex also goes out; on the boundary something is left.
    let mut left = vec![0_u32; vertex_count];
    for [a, b] in directed() {
        left[a as usize] = left[a as usize].wrapping_add(b + 1);
        left[b as usize] = left[b as usize].wrapping_sub(a + 1);
    }
    let is_inner = |v: u32| left[v as usize] == 0;
    let mut edges = Vec::with_capacity(faces.corners().len() / 2 + 1);
    let mut doubtful = Vec::new();
    for [a, b] in directed() {
        if is_inner(a) || is_inner(b) {
            if a < b {
                edges.push([a, b]);
            }
        } else {
            doubtful.push([a.min(b), a.max(b)]);
        }
    }
    doubtful.sort_unstable();
    doubtful.dedup();
    edges.extend(doubtful);
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use fairform::shapes;

    /// The same edges as those of the topology.
    #[test]
    fn every_edge_is_drawn_once() {
        for mesh in [shapes::tube(3, 5), shapes::fan(5), shapes::torus(5, 6), shapes::cube()] {
            let topology = mesh.topology();
            let mut drawn = edges(&topology.to_faces(), topology.vertex_count());
            drawn.iter_mut().for_each(|e| e.sort_unstable());
            drawn.sort_unstable();
            let ends = topology.edges().map(|e| {
                let h = topology.edge_halfedge(e);
                let mut ends = [topology.origin(h).0, topology.target(h).0];
                ends.sort_unstable();
                ends
            });
            let mut all: Vec<_> = ends.collect();
            all.sort_unstable();
            assert_eq!(drawn, all);
        }
    }
}
