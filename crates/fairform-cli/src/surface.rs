//! A mesh with everything that travels along when it is refined.

use std::ops::ControlFlow;
use std::sync::Arc;

use fairform::interpolate::{ExactFit, Fit, Interpolator, Norm, Options};
use fairform::refine::{self, Refined};
use fairform::{HalfedgeId, Mesh, Rules, Vec3, limit, tessellate};
use fairform_io::{CreaseList, Fields, Labels, MeshData, points_of_uvs, uvs_of_points};

use crate::console::{Console, Progress, count};
use crate::failure::{Failure, in_mesh};
use crate::input::Source;

mod adaptive;
mod fine;

pub(crate) use adaptive::Nearness;
use fine::Fine;
pub(crate) use fine::Made;

/// What is done to a surface that has been refined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Finish {
    /// Nothing: vertices and given normals are where the steps put them.
    Control,
    /// Vertices stay, with the normals of the limit surface.
    LimitNormals,
    /// Everything is moved to the limit, with exact normals.
    Limit,
}

/// What is in memory while a surface is refined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stored {
    /// The finest mesh and the one before.
    Steps,
    /// What is to be written.
    Result,
    /// A coarser mesh, of which the finest is made while it is written.
    Base,
}

/// A mesh, values per vertex, and labels of its faces.
#[derive(Debug, Clone)]
pub(crate) struct Surface {
    pub(crate) mesh: Mesh,
    /// How it is refined from here on.
    pub(crate) rules: Rules,
    fields: Fields,
    pub(crate) normals: Option<Vec<Vec3>>,
    /// Normals on each side of creases.
    corner_normals: Option<Vec<Vec3>>,
    corner_uvs: Option<Vec<Vec3>>,
    pub(crate) groups: Option<Labels>,
    pub(crate) materials: Option<Labels>,
    material_library: Option<String>,
    /// What the file says of creases, by the numbers of the mesh as it was read.
    pub(crate) creases: Option<CreaseList>,
    /// Whether each face of the mesh as it was read has a surface, if not all have.
    pub(crate) shown: Option<Arc<[bool]>>,
    /// The face of the mesh as it was read that each face is a part of.
    origin: Vec<u32>,
}

impl Surface {
    /// Checks the faces and coordinates of a file.
    pub(crate) fn new(data: MeshData, source: &Source) -> Result<Self, Failure> {
        let mesh = Mesh::new(data.positions.clone(), &data.faces)
            .map_err(|e| in_mesh(source, &e, &data.positions, &data.faces))?;
        let finite = |values: &Vec<Vec3>| values.iter().all(|v| v.is_finite());
        Ok(Self {
            mesh,
            rules: Rules::LOOP,
            fields: Fields::of(&data),
            normals: data.normals.filter(finite),
            // They describe the surface that was given.
            corner_normals: None,
            corner_uvs: data.corner_uvs.as_deref().map(points_of_uvs),
            groups: data.groups,
            materials: data.materials,
            material_library: data.material_library,
            creases: data.creases,
            shown: None,
            origin: (0..data.faces.len() as u32).collect(),
        })
    }

    /// A kernel error about this mesh.
    pub(crate) fn failure(&self, source: &Source, error: &fairform::Error) -> Failure {
        in_mesh(source, error, self.mesh.positions(), &self.mesh.topology().to_faces())
    }

    /// Says what will not survive refinement.
    pub(crate) fn warn_of_losses(&self, levels: u32, console: &Console) {
        if levels > 0
            && self.corner_uvs.is_some()
            && self.rules.scheme == fairform::Scheme::DooSabin
        {
            console.note(
                "note: texture coordinates with seams left out: Doo–Sabin's new faces lie across \
                 the old edges",
            );
        }
    }

    pub(crate) fn warn_of_no_faces(&self, source: &Source, console: &Console) {
        if self.mesh.topology().face_count() == 0 && !self.mesh.positions().is_empty() {
            console.note(format!("warning: {source}: no faces, so there is no surface"));
        }
    }

    /// Finds the control values of colours and texture coordinates, so that these pass through the
    /// given ones as the surface does through the vertices.
    pub(crate) fn fit_fields(&mut self, options: &Options) -> Result<(), fairform::Error> {
        // Their units are not those of the positions.
        let norm = if options.norm == Norm::Absolute { Norm::Diagonal } else { options.norm };
        let options = Options { norm, ..*options };
        if !self.fields.is_empty() {
            let (mesh, rules) = (self.mesh.clone(), self.rules.clone());
            let interpolator = Interpolator::near(mesh.topology(), &rules, mesh.positions())?;
            for field in self.fields.iter_mut() {
                let mut go_on = |_, _| ControlFlow::Continue(());
                *field = interpolator.fit(field, &options, &mut go_on)?.0;
            }
        }
        // Normals describe the surface that was given; the new one has its own.
        self.normals = None;
        Ok(())
    }

    /// The control surface one level down, from a fit of the positions that ended with a push-back.
    pub(crate) fn pushed_back(
        &self,
        fit: Fit,
        options: &Options,
        progress: &Progress,
    ) -> Result<Self, fairform::Error> {
        let mut finer = self.refine(1, progress)?;
        let mut given = self.clone();
        if !finer.fields.is_empty() {
            // Prepared once for all of them.
            let (topology, positions) = (self.mesh.topology(), self.mesh.positions());
            let mut exact = ExactFit::near(topology, &self.rules, positions)?;
            for (field, given) in finer.fields.iter_mut().zip(given.fields.iter_mut()) {
                let mut go_on = |_, _| ControlFlow::Continue(());
                *field = exact.fit(given, options, &mut go_on)?.0;
            }
        }
        finer.mesh = fit.control;
        finer.rules = fit.rules;
        finer.normals = None;
        finer.corner_normals = None;
        Ok(finer)
    }

    pub(crate) fn refine(&self, levels: u32, progress: &Progress) -> Result<Self, fairform::Error> {
        let mut surface = self.clone();
        for level in 1..=levels {
            let size = refine::check_size(surface.mesh.topology(), &surface.rules, 1)?;
            let vertices = count(usize::try_from(size.vertex_count).unwrap_or(usize::MAX));
            progress.say(format!("refining: level {level} of {levels}, {vertices} vertices"));
            let coarse = Arc::clone(surface.mesh.topology());
            let rules = surface.rules.clone();
            surface.step(refine::refine(&coarse, &rules)?);
        }
        if levels > 0
            && let Some(normals) = &mut surface.normals
        {
            for n in normals {
                *n = n.normalized();
            }
        }
        Ok(surface)
    }

    /// What is to be written of the refined surface, without faces that only support it. Vertices of the
    /// mesh keep their numbers; how others are numbered is told by [`fairform::tessellate`]. If they are
    /// asked for, also the faces of the mesh as it was read that the faces are parts of.
    pub(crate) fn refined(
        &self,
        levels: u32,
        finish: Finish,
        progress: &Progress,
        origins: Option<&mut Vec<u32>>,
    ) -> Result<MeshData, fairform::Error> {
        if self.goes_at_once(levels, finish) {
            progress.say("refining");
            let tessellation = self.tessellation(levels, finish)?;
            let fine = Fine::new(self, &tessellation, finish, progress)?;
            if let Some(origins) = origins {
                *origins = fine.origins();
            }
            return Ok(fine.into_data());
        }
        let mut fine = self.refine(levels, progress)?;
        match finish {
            Finish::Control => {}
            Finish::LimitNormals => fine.limit_normals()?,
            Finish::Limit => fine.move_to_limit()?,
        }
        if let Some(origins) = origins {
            *origins = fine.origin.iter().copied().filter(|&f| fine.is_shown(f)).collect();
        }
        Ok(fine.into_surface())
    }

    fn step(&mut self, step: Refined<'_>) {
        for field in self.fields.iter_mut() {
            *field = step.apply(field);
        }
        if let Some(normals) = &mut self.normals {
            *normals = step.apply(normals);
        }
        if let Some(uvs) = &mut self.corner_uvs {
            match step.apply_to_corners(uvs) {
                Some(finer) => *uvs = finer,
                None => self.corner_uvs = None,
            }
        }
        self.corner_normals = None;
        let origin = |f| self.origin[step.parent(f).index()];
        self.origin = step.topology.faces().map(origin).collect();
        for labels in [&mut self.groups, &mut self.materials].into_iter().flatten() {
            let parent = |f| labels.of_face[step.parent(f).index()];
            labels.of_face = step.topology.faces().map(parent).collect();
        }
        let positions = step.apply(self.mesh.positions());
        self.mesh = Mesh::from_parts(Arc::new(step.topology), positions);
        self.rules = step.next;
    }

    /// Moves everything to the limit, with exact normals.
    pub(crate) fn move_to_limit(&mut self) -> Result<(), fairform::Error> {
        self.limit_normals()?;
        let rules = self.rules.clone();
        let topology = Arc::clone(self.mesh.topology());
        for field in self.fields.iter_mut() {
            *field = limit::limit_points(&topology, field, &rules)?;
        }
        let points = limit::limit_points(&topology, self.mesh.positions(), &rules)?;
        self.mesh = self.mesh.with_positions(points);
        Ok(())
    }

    /// The normals of the limit surface, at the vertices as they are.
    pub(crate) fn limit_normals(&mut self) -> Result<(), fairform::Error> {
        let (topology, points) = (self.mesh.topology(), self.mesh.positions());
        let normals = limit::limit_normals(topology, points, &self.rules)?;
        if self.rules.creases.is_some() {
            let corners = limit::limit_corner_normals(topology, points, &self.rules)?;
            let is_parted =
                |h: HalfedgeId| corners[h.index()] != normals[topology.origin(h).index()];
            self.corner_normals = topology.halfedges().any(is_parted).then_some(corners);
        }
        self.normals = Some(normals);
        Ok(())
    }

    /// Whether there is a surface for a face of the mesh as it was read.
    fn is_shown(&self, origin: u32) -> bool {
        self.shown.as_ref().is_none_or(|has| has[origin as usize])
    }

    /// The mesh as a control mesh: with the support and the creases that make its surface.
    pub(crate) fn into_control(self) -> MeshData {
        let creases = CreaseList::of_control(
            self.mesh.topology(),
            &self.rules,
            self.creases.is_some(),
            |f| self.is_shown(self.origin[f.index()]),
        );
        MeshData { creases, ..self.into_data() }
    }

    /// The surface: without faces that only support it. Vertices keep their numbers.
    pub(crate) fn into_surface(self) -> MeshData {
        let Some(has_surface) = self.shown.clone() else { return self.into_data() };
        let shown: Vec<bool> = self.origin.iter().map(|&f| has_surface[f as usize]).collect();
        let data = self.into_data();
        let of_corner: Vec<bool> =
            data.faces.iter().zip(&shown).flat_map(|(f, &s)| f.iter().map(move |_| s)).collect();
        let labels = |labels: Option<Labels>| {
            let Labels { names, of_face } = labels?;
            Some(Labels { names, of_face: keep(Some(of_face), &shown)? })
        };
        MeshData {
            faces: data.faces.iter().zip(&shown).filter(|f| *f.1).map(|f| f.0).collect(),
            corner_normals: keep(data.corner_normals, &of_corner),
            corner_uvs: keep(data.corner_uvs, &of_corner),
            groups: labels(data.groups),
            materials: labels(data.materials),
            ..data
        }
    }

    /// What a file can hold.
    fn into_data(self) -> MeshData {
        let mut data = MeshData {
            faces: self.mesh.topology().to_faces(),
            positions: self.mesh.into_positions(),
            normals: self.normals,
            corner_normals: self.corner_normals,
            corner_uvs: self.corner_uvs.as_deref().map(uvs_of_points),
            groups: self.groups,
            materials: self.materials,
            material_library: self.material_library,
            ..MeshData::default()
        };
        self.fields.put(&mut data);
        data
    }
}

/// Refuses what would not fit into memory, before it is begun.
pub(crate) fn check_memory(
    surface: &Surface,
    levels: u32,
    stored: Stored,
    source: &Source,
) -> Result<(), Failure> {
    let too_much = |what: String| {
        Failure::new(format!("{source}: {levels} levels would make {what}"))
            .help("use fewer --levels; each makes four times as many faces")
    };
    let (topology, rules) = (surface.mesh.topology(), &surface.rules);
    let size_at = |level| match refine::check_size(topology, rules, level) {
        Ok(size) => Ok(size),
        Err(fairform::Error::TooLarge { .. }) => {
            Err(too_much("more than 2,147,483,647 half-edges".into()))
        }
        Err(other) => Err(surface.failure(source, &other)),
    };
    let size = size_at(levels)?;
    // Topology, positions, normals and the copy that is written, generously.
    let of_steps = size.halfedge_count * 24 + size.vertex_count * 160;
    let base = match stored {
        Stored::Steps => 0,
        Stored::Result | Stored::Base => {
            let level = tessellate::base_level(topology, rules, levels, fine::LARGE_BASE)
                .map_err(|e| surface.failure(source, &e))?;
            let base = size_at(level)?;
            // Topologies and what each face is made of; rows, blocks and whatever is special.
            base.halfedge_count * 80 + base.vertex_count * 160 + (128 << 20)
        }
    };
    let bytes = match stored {
        Stored::Steps => of_steps,
        // The arrays that are written, and a copy as bytes.
        Stored::Result => of_steps.min(base + size.halfedge_count * 12 + size.vertex_count * 120),
        Stored::Base => base,
    };
    match available_memory() {
        Some(available) if bytes > available => Err(too_much(format!(
            "{} faces, which takes about {:.1} GB; {:.1} GB are free",
            count(usize::try_from(size.face_count).unwrap_or(usize::MAX)),
            bytes as f64 / 1e9,
            available as f64 / 1e9
        ))),
        _ => Ok(()),
    }
}

/// Free memory in bytes, where the system tells it as a file.
pub(crate) fn available_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kilobytes)
}

/// Those values that are shown.
fn keep<T>(values: Option<Vec<T>>, shown: &[bool]) -> Option<Vec<T>> {
    let kept = values?.into_iter().zip(shown).filter(|v| *v.1);
    Some(kept.map(|v| v.0).collect())
}
