//! Colours, texture coordinates and labels of a mesh on the surface that passes through it, as
//! `fairform fit` writes them: fitted like positions, so that they are met at the vertices.

use std::ops::ControlFlow;

use fairform::interpolate::{ExactFit, Interpolator, Norm, Options};
use fairform::{Vec3, refine};
use fairform_io::{Fields, Labels, MeshData, points_of_uvs, uvs_of_points};

use crate::Problem;
use crate::mesh_session::{Drawn, Fitted};

impl Fitted {
    /// Values of the control mesh, with those of the given mesh at its vertices.
    fn fields(&self, given: &MeshData) -> Result<Fields, Problem> {
        // Their units are not those of the positions.
        let options = Options { norm: Norm::Diagonal, fair: None, ..self.design.options() };
        let (topology, positions) = (self.target.topology(), self.target.positions());
        let fields = Fields::of(given);
        if fields.is_empty() {
            return Ok(fields);
        }
        if self.level == 0 {
            let interpolator = Interpolator::near(topology, &self.rules, positions)?;
            return fields.try_map(|field| {
                let mut go_on = |_, _| ControlFlow::Continue(());
                Ok(interpolator.fit(field, &options, &mut go_on)?.0)
            });
        }
        let mut exact = ExactFit::near(topology, &self.rules, positions)?;
        fields.try_map(|field| {
            let mut go_on = |_, _| ControlFlow::Continue(());
            Ok(exact.fit(field, &options, &mut go_on)?.0)
        })
    }

    /// Texture coordinates of the corners of the control mesh; none where they do not follow.
    fn corner_uvs(&self, given: &MeshData) -> Result<Option<Vec<Vec3>>, Problem> {
        let Some(uvs) = &given.corner_uvs else { return Ok(None) };
        let uvs = points_of_uvs(uvs);
        match self.level {
            0 => Ok(Some(uvs)),
            _ => Ok(refine::refine(self.target.topology(), &self.rules)?.apply_to_corners(&uvs)),
        }
    }

    /// Gives the control mesh what the given mesh has. `parents` are the faces of the given mesh that its
    /// faces are parts of.
    pub(crate) fn attributes(
        &self,
        given: &MeshData,
        parents: &[u32],
        data: &mut MeshData,
    ) -> Result<(), Problem> {
        self.fields(given)?.put(data);
        let uvs = self.corner_uvs(given)?;
        data.corner_uvs = uvs.as_deref().map(uvs_of_points);
        labels(given, parents, data);
        Ok(())
    }
}

impl Drawn {
    /// Gives the surface what the given mesh has, but for texture coordinates of corners where some faces
    /// have no surface. `origin` are the faces of the given mesh that its faces are parts of.
    pub(crate) fn attributes(
        &self,
        fitted: &Fitted,
        given: &MeshData,
        origin: &[u32],
        data: &mut MeshData,
    ) -> Result<(), Problem> {
        labels(given, origin, data);
        if self.level != fitted.level {
            // In the midst of a fit there are no control values of anything else.
            return Ok(());
        }
        let fields = fitted.fields(given)?;
        fields.try_map(|field| Ok::<_, Problem>(self.fine.field(field)?.points()))?.put(data);
        if fitted.shown.is_none()
            && let Some(uvs) = fitted.corner_uvs(given)?
            && let Some(uvs) = self.fine.base_corners(&uvs)
        {
            let uvs = self.fine.corners_in(0..self.fine.base().face_count(), &uvs);
            data.corner_uvs = Some(uvs_of_points(&uvs));
        }
        Ok(())
    }
}

/// The labels of faces that are parts of others.
fn labels(given: &MeshData, origin: &[u32], data: &mut MeshData) {
    let of = |labels: &Option<Labels>| {
        let Labels { names, of_face } = labels.as_ref()?;
        let of_face = origin.iter().map(|&f| of_face[f as usize]).collect();
        Some(Labels { names: names.clone(), of_face })
    };
    (data.groups, data.materials) = (of(&given.groups), of(&given.materials));
    data.material_library.clone_from(&given.material_library);
}
