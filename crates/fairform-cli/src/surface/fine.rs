//! A refined surface made through a tessellation: in memory, or block by block while it is written.

use std::ops::Range;
use std::path::Path;

use fairform::tessellate::{self, Part, Points, Tessellation};
use fairform::{Error, FaceId, Faces, Scheme, Vec3};
use fairform_io::{Attributes, Blocks, Fields, Labels, MeshData, Patch, Shape};

use super::{Finish, Stored, Surface};
use crate::args::Writing;
use crate::console::{Console, Progress, count};
use crate::failure::Failure;
use crate::input;

/// Faces of the base up to which no more steps are made at once than is fastest: it takes some hundred
/// megabytes then.
pub(super) const LARGE_BASE: u64 = 1 << 20;

/// Vertices or faces that are made together.
const BLOCK: usize = 1 << 14;

/// A surface whose points and faces are made when they are asked for.
pub(crate) struct Fine<'t> {
    surface: &'t Surface,
    tessellation: &'t Tessellation,
    positions: tessellate::Surface<'t>,
    normals: Normals<'t>,
    fields: Fields<tessellate::Surface<'t>>,
    /// Of the corners of the base.
    corner_uvs: Option<Vec<Vec3>>,
    /// The face of the mesh as it was read that each face of the base is a part of.
    origin: Vec<u32>,
    /// Those faces of the base that have a surface, if not all have.
    shown: Option<Vec<u32>>,
    parts: Vec<Part>,
    /// Faces of the base, or places in `shown`, that make a block.
    face_blocks: Vec<Range<usize>>,
    progress: &'t Progress,
}

/// A surface to be written.
pub(crate) enum Made<'a> {
    Whole(MeshData),
    /// While it is written.
    Meanwhile(Fine<'a>),
}

impl Made<'_> {
    /// Tells how many vertices and faces were written.
    pub(crate) fn write(
        &self,
        output: &Path,
        writing: &Writing,
        console: &Console,
    ) -> Result<(usize, usize), Failure> {
        match self {
            Self::Whole(data) => {
                input::write(output, writing, data, console)?;
                Ok((data.positions.len(), data.faces.len()))
            }
            Self::Meanwhile(fine) => {
                input::write_blocks(output, writing, fine, console)?;
                Ok((fine.vertex_count(), fine.face_count()))
            }
        }
    }
}

/// What normals there are.
enum Normals<'t> {
    None,
    /// Those that were given, refined as positions are.
    Given(tessellate::Surface<'t>),
    /// Those of the limit surface.
    Limit,
}

impl Surface {
    /// Whether many steps can be made at once, so that nothing between is stored.
    ///
    /// Not so where the faces on both sides of a crease want normals of their own, which need the finest
    /// connectivity, nor with schemes whose steps are made one by one.
    pub(crate) fn goes_at_once(&self, levels: u32, finish: Finish) -> bool {
        levels > 1
            && matches!(self.rules.scheme, Scheme::Loop | Scheme::CatmullClark)
            && self.mesh.topology().face_count() > 0
            && (self.rules.creases.is_none() || finish == Finish::Control)
    }

    /// Whether the refined surface can be written while it is made.
    pub(crate) fn can_stream(
        &self,
        levels: u32,
        finish: Finish,
        output: &Path,
        writing: &Writing,
    ) -> bool {
        self.goes_at_once(levels, finish)
            && input::can_stream(output, writing, &self.fine_shape(finish))
    }

    /// What is in memory until the refined surface is written, while it is made or afterwards.
    pub(crate) fn stored(&self, levels: u32, finish: Finish, streams: bool) -> Stored {
        match (streams, self.goes_at_once(levels, finish)) {
            (true, _) => Stored::Base,
            (false, true) => Stored::Result,
            (false, false) => Stored::Steps,
        }
    }

    /// What is to be written: made in the writing where there is a tessellation for that.
    pub(crate) fn made<'a>(
        &'a self,
        levels: u32,
        finish: Finish,
        tessellation: Option<&'a Tessellation>,
        progress: &'a Progress,
    ) -> Result<Made<'a>, Error> {
        if let Some(tessellation) = tessellation {
            return Ok(Made::Meanwhile(Fine::new(self, tessellation, finish, progress)?));
        }
        if levels > 0 || finish == Finish::Limit {
            return Ok(Made::Whole(self.refined(levels, finish, progress, None)?));
        }
        let mut control = self.clone();
        if finish == Finish::LimitNormals {
            control.limit_normals()?;
        }
        Ok(Made::Whole(control.into_control()))
    }

    /// The steps, for [`Fine::new`].
    pub(crate) fn tessellation(&self, levels: u32, finish: Finish) -> Result<Tessellation, Error> {
        let points = if finish == Finish::Limit { Points::Limit } else { Points::Control };
        let topology = self.mesh.topology();
        Tessellation::with_base(topology, &self.rules, levels, LARGE_BASE, points)
    }

    /// What of the refined surface is known beforehand, but for its size.
    fn fine_shape(&self, finish: Finish) -> Shape<'_> {
        Shape {
            face_size: if self.rules.scheme == Scheme::Loop { 3 } else { 4 },
            normals: finish != Finish::Control || self.normals.is_some(),
            colours: self.fields.colours.is_some(),
            uvs: self.fields.uvs.is_some(),
            corner_uvs: self.corner_uvs.is_some(),
            groups: self.groups.as_ref().map(|labels| labels.names.as_slice()),
            materials: self.materials.as_ref().map(|labels| labels.names.as_slice()),
            material_library: self.material_library.as_deref(),
            ..Shape::default()
        }
    }
}

impl<'t> Fine<'t> {
    pub(crate) fn new(
        surface: &'t Surface,
        tessellation: &'t Tessellation,
        finish: Finish,
        progress: &'t Progress,
    ) -> Result<Self, Error> {
        let normals = match &surface.normals {
            _ if finish != Finish::Control => Normals::Limit,
            Some(given) => Normals::Given(tessellation.field(given)?),
            None => Normals::None,
        };
        let base = tessellation.base();
        let origin: Vec<u32> =
            tessellation.parents().into_iter().map(|f| surface.origin[f as usize]).collect();
        let shown = surface.shown.as_ref().map(|_| {
            let shown = origin.iter().zip(0..).filter(|f| surface.is_shown(*f.0));
            shown.map(|(_, f)| f).collect::<Vec<u32>>()
        });
        let per_face = tessellation.face_count() / base.face_count();
        let faces = |len| blocks(len, (BLOCK / per_face).max(1));
        let parts = blocks(base.vertex_count(), BLOCK)
            .map(Part::Vertices)
            .chain(faces(base.face_count()).map(Part::Sides))
            .chain(faces(base.face_count()).map(Part::Inside))
            .collect();
        let shown_count = shown.as_ref().map_or(base.face_count(), Vec::len);
        Ok(Self {
            surface,
            tessellation,
            positions: match &normals {
                Normals::Limit => tessellation.surface(surface.mesh.positions())?,
                _ => tessellation.field(surface.mesh.positions())?,
            },
            normals,
            fields: surface.fields.try_map(|values| tessellation.field(values))?,
            corner_uvs: surface.corner_uvs.as_ref().and_then(|uvs| tessellation.base_corners(uvs)),
            origin,
            shown,
            parts,
            face_blocks: faces(shown_count).collect(),
            progress,
        })
    }

    /// The number of faces that each face of the base is cut into.
    fn per_face(&self) -> usize {
        self.tessellation.face_count() / self.tessellation.base().face_count()
    }

    /// The face of the base at a place in the order of those shown.
    fn base_face(&self, place: usize) -> usize {
        self.shown.as_ref().map_or(place, |shown| shown[place] as usize)
    }

    fn base_faces(&self, block: usize) -> impl Iterator<Item = usize> + '_ {
        self.face_blocks[block].clone().map(|place| self.base_face(place))
    }

    fn shown_count(&self) -> usize {
        self.shown.as_ref().map_or(self.tessellation.base().face_count(), Vec::len)
    }

    pub(crate) fn vertex_count(&self) -> usize {
        self.tessellation.vertex_count()
    }

    pub(crate) fn face_count(&self) -> usize {
        self.shown_count() * self.per_face()
    }

    /// For each face that is written, the face of the mesh as it was read that it is a part of.
    pub(crate) fn origins(&self) -> Vec<u32> {
        self.labels(0..self.shown_count(), |origin| origin)
    }

    /// A label per face, of those at some places.
    fn labels(&self, places: Range<usize>, label: impl Fn(u32) -> u32) -> Vec<u32> {
        let of_place = |place| label(self.origin[self.base_face(place)]);
        places.flat_map(|place| std::iter::repeat_n(of_place(place), self.per_face())).collect()
    }

    fn faces_at(&self, places: Range<usize>) -> MeshData {
        let size = self.surface.fine_shape(Finish::Control).face_size;
        let per_face = size * self.per_face();
        let mut corners = vec![0; places.len() * per_face];
        let mut corner_uvs = Vec::new();
        let mut add_uvs = |faces| {
            if let Some(uvs) = &self.corner_uvs {
                let finer = self.tessellation.corners_in(faces, uvs);
                corner_uvs.extend(finer.into_iter().map(|uv| [uv.x, uv.y]));
            }
        };
        if self.shown.is_none() {
            self.tessellation.fill_faces(places.clone(), &mut corners);
            add_uvs(places.clone());
        } else {
            for (place, out) in places.clone().zip(corners.chunks_exact_mut(per_face)) {
                let f = self.base_face(place);
                self.tessellation.fill_faces(f..f + 1, out);
                add_uvs(f..f + 1);
            }
        }
        let labels = |labels: &Option<Labels>| {
            let Labels { of_face, .. } = labels.as_ref()?;
            let of_face = self.labels(places.clone(), |origin| of_face[origin as usize]);
            Some(Labels { names: Vec::new(), of_face })
        };
        MeshData {
            faces: Faces::uniform(size as u32, corners),
            corner_uvs: self.corner_uvs.is_some().then_some(corner_uvs),
            groups: labels(&self.surface.groups),
            materials: labels(&self.surface.materials),
            ..MeshData::default()
        }
    }

    /// All of it.
    pub(crate) fn into_data(self) -> MeshData {
        let vertices = self.vertex_count();
        self.progress.say(format!("refining: {} vertices", count(vertices)));
        let (positions, normals) = match &self.normals {
            Normals::Limit => {
                let (positions, normals) = self.positions.points_and_normals();
                (positions, Some(normals))
            }
            Normals::Given(given) => {
                let normals = given.points().into_iter().map(Vec3::normalized).collect();
                (self.positions.points(), Some(normals))
            }
            Normals::None => (self.positions.points(), None),
        };
        let named = |labels: Option<Labels>, surface: &Option<Labels>| {
            let names = surface.as_ref()?.names.clone();
            labels.map(|labels| Labels { names, ..labels })
        };
        let faces = self.faces_at(0..self.shown_count());
        let mut data = MeshData {
            positions,
            normals,
            groups: named(faces.groups, &self.surface.groups),
            materials: named(faces.materials, &self.surface.materials),
            material_library: self.surface.material_library.clone(),
            ..faces
        };
        self.fields.map(tessellate::Surface::points).put(&mut data);
        data
    }

    /// Number of vertices that belong to no face that is shown.
    fn unused(&self) -> usize {
        let base = self.tessellation.base();
        let (mut vertices, mut edges) =
            (vec![false; base.vertex_count()], vec![false; base.edge_count()]);
        for place in 0..self.shown_count() {
            for h in base.face_halfedges(FaceId(self.base_face(place) as u32)) {
                vertices[base.origin(h).index()] = true;
                edges[base.edge(h).index()] = true;
            }
        }
        let faces = base.face_count();
        let points = |part| self.tessellation.numbers_of(&part).len();
        let per_edge = points(Part::Sides(0..faces)) / base.edge_count().max(1);
        let unused = |used: &[bool]| used.iter().filter(|used| !**used).count();
        unused(&vertices)
            + per_edge * unused(&edges)
            + points(Part::Inside(0..1)) * (faces - self.shown_count())
    }
}

impl Blocks for Fine<'_> {
    fn shape(&self) -> Shape<'_> {
        let finish =
            if matches!(self.normals, Normals::None) { Finish::Control } else { Finish::Limit };
        Shape {
            vertex_count: self.vertex_count(),
            face_count: self.face_count(),
            unused: self.unused(),
            ..self.surface.fine_shape(finish)
        }
    }

    fn vertex_block_count(&self) -> usize {
        self.parts.len()
    }

    fn vertices(&self, block: usize, wanted: Attributes) -> MeshData {
        let part = &self.parts[block];
        let numbers = self.tessellation.numbers_of(part);
        let all = count(self.vertex_count());
        self.progress.say(format!("writing: vertex {} of {all}", count(numbers.end)));
        let room = || vec![Vec3::ZERO; numbers.len()];
        let points = |field: &tessellate::Surface<'_>| {
            let mut values = room();
            field.fill_part(part, &mut values, None::<&mut [Vec3]>);
            values
        };
        let mut data = MeshData::default();
        match &self.normals {
            Normals::Limit if wanted.normals => {
                let (mut positions, mut normals) = (room(), room());
                self.positions.fill_part(part, &mut positions, Some(&mut normals));
                data.normals = Some(normals);
                if wanted.positions {
                    data.positions = positions;
                }
            }
            normals => {
                if wanted.positions {
                    data.positions = points(&self.positions);
                }
                if let Normals::Given(given) = normals
                    && wanted.normals
                {
                    data.normals = Some(points(given).into_iter().map(Vec3::normalized).collect());
                }
            }
        }
        let of = |field: &Option<tessellate::Surface<'_>>, is_wanted: bool| {
            field.as_ref().filter(|_| is_wanted).map(points)
        };
        let Fields { colours, opacity, uvs } = &self.fields;
        let fields = Fields {
            colours: of(colours, wanted.colours),
            opacity: of(opacity, wanted.colours),
            uvs: of(uvs, wanted.uvs),
        };
        fields.put(&mut data);
        data
    }

    fn face_block_count(&self) -> usize {
        self.face_blocks.len()
    }

    fn faces(&self, block: usize) -> MeshData {
        self.say_faces(block);
        self.faces_at(self.face_blocks[block].clone())
    }

    fn labels_before(&self, block: usize) -> [Option<u32>; 2] {
        let last = self.face_blocks[block].start.checked_sub(1);
        let origin = last.map(|place| self.origin[self.base_face(place)] as usize);
        [&self.surface.groups, &self.surface.materials]
            .map(|labels| Some(labels.as_ref()?.of_face[origin?]))
    }

    fn patch(&self, block: usize) -> Patch {
        self.say_faces(block);
        let (mut positions, mut numbers, mut corners) = (Vec::new(), Vec::new(), Vec::new());
        for f in self.base_faces(block).map(|f| FaceId(f as u32)) {
            let first = positions.len();
            numbers.extend(self.tessellation.patch_numbers(f));
            positions.resize(numbers.len(), Vec3::ZERO);
            self.positions.fill_patch(f, &mut positions[first..], None::<&mut [Vec3]>);
            let own = self.tessellation.patch_faces(f);
            corners.extend(own.corners().iter().map(|point| first as u32 + point));
        }
        let size = self.surface.fine_shape(Finish::Control).face_size;
        Patch { positions, numbers, faces: Faces::uniform(size as u32, corners) }
    }
}

impl Fine<'_> {
    fn say_faces(&self, block: usize) {
        let done = self.face_blocks[block].end * self.per_face();
        let (done, all) = (count(done), count(self.face_count()));
        self.progress.say(format!("writing: face {done} of {all}"));
    }
}

/// `0..len` in blocks of one size, but for the last.
fn blocks(len: usize, size: usize) -> impl Iterator<Item = Range<usize>> {
    (0..len).step_by(size).map(move |start| start..(start + size).min(len))
}

#[cfg(test)]
mod tests;
