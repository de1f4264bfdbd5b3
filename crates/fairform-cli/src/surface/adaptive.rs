//! A surface that is refined only where it is curved.

use fairform::tessellate::{Eye, Points, Tessellation, Tolerance};
use fairform::{Error, Vec3};
use fairform_io::{Labels, MeshData};

use super::{Surface, keep};

/// How near the result is to be to the surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Nearness {
    /// In diagonals of the bounding box; with an eye, in distances from it.
    pub(crate) tolerance: f64,
    pub(crate) eye: Option<Vec3>,
}

/// A mesh as fine as it must be.
pub(crate) struct Adaptive {
    pub(crate) data: MeshData,
    /// Share of the surface that is as fine as so many levels make it, so that it may be farther off.
    pub(crate) at_limit: f64,
}

impl Surface {
    /// Whether there are colours or texture coordinates, which adaptive refinement leaves out.
    pub(crate) fn has_fields(&self) -> bool {
        !self.fields.is_empty() || self.corner_uvs.is_some()
    }

    /// The limit surface by no more faces than it takes, nor more than so many levels make. Positions,
    /// exact normals, groups and materials.
    pub(crate) fn adaptive(&self, levels: u32, nearness: Nearness) -> Result<Adaptive, Error> {
        let topology = self.mesh.topology();
        // The smaller the base, the coarser the result may be.
        let all = Tessellation::with_base(topology, &self.rules, levels, 0, Points::Limit)?;
        let Nearness { tolerance, eye } = nearness;
        let tolerance = match eye {
            Some(position) => {
                Tolerance { chord: 0.0, eye: Some(Eye { position, per_distance: tolerance }) }
            }
            None => Tolerance { chord: tolerance * self.mesh.bounds().diagonal(), eye: None },
        };
        let made = all.surface(self.mesh.positions())?.adaptive(&tolerance)?;
        let at_limit = made.at_limit as f64 / (all.base().face_count() as f64).max(1.0);
        let parents = all.parents();
        let origin: Vec<u32> = made.origin.iter().map(|&f| parents[f as usize]).collect();
        let shown: Vec<bool> =
            origin.iter().map(|&f| self.is_shown(self.origin[f as usize])).collect();
        let labels = |labels: &Option<Labels>| {
            let Labels { names, of_face } = labels.clone()?;
            let of_face = origin.iter().map(|&f| of_face[f as usize]).collect();
            Some(Labels { names, of_face: keep(Some(of_face), &shown)? })
        };
        let data = MeshData {
            faces: made.faces.iter().zip(&shown).filter(|f| *f.1).map(|f| f.0).collect(),
            positions: made.positions,
            normals: Some(made.normals),
            groups: labels(&self.groups),
            materials: labels(&self.materials),
            material_library: self.material_library.clone(),
            ..MeshData::default()
        };
        Ok(Adaptive { data, at_limit })
    }
}
