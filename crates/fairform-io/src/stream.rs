//! Meshes that are made while they are written, block by block: files may be larger than memory.
//!
//! [`encode_blocks`] gives the bytes that [`encode`](crate::encode) gives for the same mesh in memory:
//! headers and rows come from the same functions. A few blocks per thread are in memory at a time.

use std::io::Write;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use fairform::{Faces, Vec3};

use crate::data::{MeshData, WriteOptions};
use crate::error::Error;
use crate::{Format, gltf, obj, off, par, ply, stl};

/// What is known of a mesh before it is made.
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is an attribute that a mesh has or has not"
)]
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Shape<'a> {
    /// Number of vertices.
    pub vertex_count: usize,
    /// Number of faces.
    pub face_count: usize,
    /// Number of corners of every face, at least three.
    pub face_size: usize,
    /// Whether vertices have normals.
    pub normals: bool,
    /// Whether vertices have colours.
    pub colours: bool,
    /// Whether vertices have texture coordinates.
    pub uvs: bool,
    /// Whether face corners have texture coordinates.
    pub corner_uvs: bool,
    /// Whether some vertices have several normals, which blocks cannot hold.
    pub corner_normals: bool,
    /// Whether the mesh has creases, which blocks cannot hold.
    pub creases: bool,
    /// The names that [`MeshData::groups`] of the blocks of faces refer to.
    pub groups: Option<&'a [String]>,
    /// The names that [`MeshData::materials`] of the blocks of faces refer to.
    pub materials: Option<&'a [String]>,
    /// As [`MeshData::material_library`].
    pub material_library: Option<&'a str>,
    /// Number of vertices that belong to no face.
    pub unused: usize,
}

/// Some attributes of vertices.
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is an attribute that a mesh has or has not"
)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Attributes {
    /// [`MeshData::positions`].
    pub positions: bool,
    /// [`MeshData::normals`].
    pub normals: bool,
    /// [`MeshData::colours`].
    pub colours: bool,
    /// [`MeshData::uvs`].
    pub uvs: bool,
}

/// Faces with vertices of their own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Patch {
    /// The points of the faces.
    pub positions: Vec<Vec3>,
    /// The number of each of them in the mesh.
    pub numbers: Vec<u32>,
    /// The faces, in points of the patch.
    pub faces: Faces,
}

/// A mesh that is made block by block: each as often as it is asked for, the same every time, and on
/// several threads at once.
pub trait Blocks: Sync {
    /// What is known beforehand.
    fn shape(&self) -> Shape<'_>;

    /// Number of blocks of vertices. Their vertices follow on each other.
    fn vertex_block_count(&self) -> usize;

    /// Those attributes of the vertices of a block that are asked for and the shape has: nothing else
    /// of the mesh.
    fn vertices(&self, block: usize, wanted: Attributes) -> MeshData;

    /// Number of blocks of faces. Their faces follow on each other.
    fn face_block_count(&self) -> usize;

    /// The faces of a block, by the numbers of vertices in the mesh, with the labels and the texture
    /// coordinates of corners that the shape has. Of the names of labels only the numbers are looked at.
    fn faces(&self, block: usize) -> MeshData;

    /// Group and material of the face before a block of faces, if there is one, and they are.
    fn labels_before(&self, block: usize) -> [Option<u32>; 2];

    /// The faces of a block with the positions of their corners.
    fn patch(&self, block: usize) -> Patch;
}

/// Whether a mesh of a shape can be written block by block.
///
/// The formats differ: glTF as JSON cannot, nor can an OBJ file with texture coordinates or normals per
/// corner, a GLB file with several materials, or STL as text with groups: they need to know all faces.
#[must_use]
pub fn can_stream(format: Format, options: &WriteOptions, shape: &Shape<'_>) -> bool {
    match format {
        Format::Ply | Format::Off => true,
        Format::Obj => !shape.corner_uvs && !shape.corner_normals && !shape.creases,
        Format::Stl => !options.ascii || shape.groups.is_none(),
        Format::Glb => shape.materials.is_none_or(|names| names.len() <= 1),
        Format::Gltf => false,
    }
}

/// Writes a mesh while it is made, and says what the format could not hold.
///
/// # Errors
/// If the writer fails, the blocks do not fit together, the format cannot hold the mesh, or it cannot
/// be written block by block, see [`can_stream`].
pub fn encode_blocks(
    format: Format,
    blocks: &dyn Blocks,
    options: &WriteOptions,
    out: &mut dyn Write,
) -> Result<Vec<String>, Error> {
    let blocks = Checked::new(blocks);
    if !can_stream(format, options, &blocks.shape) {
        let message = format!("{format} cannot be written block by block with what this mesh has");
        return Err(Error::Unwritable(message));
    }
    if blocks.shape.vertex_count > u32::MAX as usize {
        let count = blocks.shape.vertex_count;
        return Err(Error::Unwritable(format!("{count} vertices are too many")));
    }
    if blocks.shape.face_count > 0 && blocks.shape.face_size < 3 {
        return Err(Error::Unwritable("faces need at least 3 corners".into()));
    }
    match format {
        Format::Obj => obj::encode_blocks(&blocks, options, out),
        Format::Off => off::encode_blocks(&blocks, options, out),
        Format::Ply => ply::encode_blocks(&blocks, options, out),
        Format::Stl => stl::encode_blocks(&blocks, options, out),
        Format::Glb | Format::Gltf => gltf::encode_blocks(&blocks, out),
    }
}

impl<'a> Shape<'a> {
    /// The shape of a mesh in memory, but for the vertices of no face; faces may differ in size, then
    /// it is the largest.
    pub(crate) fn of(data: &'a MeshData) -> Self {
        Self {
            vertex_count: data.positions.len(),
            face_count: data.faces.len(),
            face_size: data.faces.iter().map(<[u32]>::len).max().unwrap_or(0),
            normals: data.normals.is_some(),
            colours: data.colours.is_some(),
            uvs: data.uvs.is_some(),
            corner_uvs: data.corner_uvs.is_some(),
            corner_normals: data.corner_normals.is_some(),
            creases: data.creases.is_some(),
            groups: data.groups.as_ref().map(|labels| labels.names.as_slice()),
            materials: data.materials.as_ref().map(|labels| labels.names.as_slice()),
            material_library: data.material_library.as_deref(),
            unused: 0,
        }
    }
}

impl Attributes {
    /// No attribute.
    pub const NONE: Self = Self { positions: false, normals: false, colours: false, uvs: false };

    /// All that a mesh has.
    pub(crate) fn of(shape: &Shape<'_>) -> Self {
        Self { positions: true, normals: shape.normals, colours: shape.colours, uvs: shape.uvs }
    }
}

/// Blocks whose answers are compared with what was promised: a file must not say what is not in it.
pub(crate) struct Checked<'a> {
    blocks: &'a dyn Blocks,
    pub(crate) shape: Shape<'a>,
}

/// The first fault that was found while writing.
#[derive(Default)]
struct Fault(Mutex<Option<String>>);

impl Fault {
    fn note(&self, text: String) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(text);
    }

    fn expect(&self, count: usize, expected: usize, what: &str) -> bool {
        if count != expected {
            self.note(format!("{count} {what} in the blocks, expected {expected}"));
        }
        count == expected
    }

    fn end(self) -> Result<(), Error> {
        let fault = self.0.into_inner().unwrap_or_else(PoisonError::into_inner);
        fault.map_or(Ok(()), |text| Err(Error::Unwritable(text)))
    }
}

impl<'a> Checked<'a> {
    pub(crate) fn new(blocks: &'a dyn Blocks) -> Self {
        Self { blocks, shape: blocks.shape() }
    }

    /// Appends to a buffer what `format` makes of each block of vertices, and writes that.
    pub(crate) fn write_vertices(
        &self,
        out: &mut dyn Write,
        wanted: Attributes,
        format: impl Fn(&MeshData, &mut Vec<u8>) + Sync,
    ) -> Result<(), Error> {
        let (fault, total) = (Fault::default(), AtomicUsize::new(0));
        write(out, self.blocks.vertex_block_count(), &fault, |block, out| {
            let data = self.blocks.vertices(block, wanted);
            if let Some(count) = vertices_in(&data, wanted, &fault) {
                total.fetch_add(count, Ordering::Relaxed);
                format(&data, out);
            }
        })?;
        fault.expect(total.into_inner(), self.shape.vertex_count, "vertices");
        fault.end()
    }

    /// The same for each block of faces; `format` also gets the labels of the face before.
    pub(crate) fn write_faces(
        &self,
        out: &mut dyn Write,
        format: impl Fn(&MeshData, [Option<u32>; 2], &mut Vec<u8>) + Sync,
    ) -> Result<(), Error> {
        let (fault, total) = (Fault::default(), AtomicUsize::new(0));
        write(out, self.blocks.face_block_count(), &fault, |block, out| {
            let data = self.blocks.faces(block);
            if self.are_faces(&data, &fault) {
                total.fetch_add(data.faces.len(), Ordering::Relaxed);
                format(&data, self.blocks.labels_before(block), out);
            }
        })?;
        fault.expect(total.into_inner(), self.shape.face_count, "faces");
        fault.end()
    }

    /// The same for each patch.
    pub(crate) fn write_patches(
        &self,
        out: &mut dyn Write,
        format: impl Fn(&Patch, &mut Vec<u8>) + Sync,
    ) -> Result<(), Error> {
        let (fault, total) = (Fault::default(), AtomicUsize::new(0));
        write(out, self.blocks.face_block_count(), &fault, |block, out| {
            let patch = self.blocks.patch(block);
            let count = patch.positions.len();
            let is_known = fault.expect(patch.numbers.len(), count, "numbers of points");
            if is_known && self.are_corners(&patch.faces, count, &fault) {
                total.fetch_add(patch.faces.len(), Ordering::Relaxed);
                format(&patch, out);
            }
        })?;
        fault.expect(total.into_inner(), self.shape.face_count, "faces");
        fault.end()
    }

    /// What `f` makes of the vertices of each block, a few at a time, until one is not to be followed
    /// by more: whether there was none.
    pub(crate) fn all_vertices<R: Send>(
        &self,
        wanted: Attributes,
        f: impl Fn(&MeshData) -> R + Sync,
        mut go_on: impl FnMut(R) -> bool,
    ) -> Result<bool, Error> {
        let fault = Fault::default();
        let (count, mut total) = (self.blocks.vertex_block_count(), 0);
        for some in par::blocks(count, 2 * par::threads()) {
            let answers = par::map(some, |block| {
                let data = self.blocks.vertices(block, wanted);
                vertices_in(&data, wanted, &fault).map(|count| (count, f(&data)))
            });
            for (count, answer) in answers.into_iter().flatten() {
                total += count;
                if !go_on(answer) {
                    fault.end()?;
                    return Ok(false);
                }
            }
        }
        fault.expect(total, self.shape.vertex_count, "vertices");
        fault.end().map(|()| true)
    }

    /// Whether all colours are of a kind; true without colours, and of blocks that do not fit, which
    /// writing them will tell.
    pub(crate) fn all_colours(&self, is: impl Fn(&[f64; 4]) -> bool + Sync) -> bool {
        let wanted = Attributes { colours: true, ..Attributes::NONE };
        !self.shape.colours
            || self
                .all_vertices(wanted, |data| data.colours.iter().flatten().all(&is), |all| all)
                .unwrap_or(true)
    }

    fn are_faces(&self, data: &MeshData, fault: &Fault) -> bool {
        let (count, corners) = (data.faces.len(), data.faces.corners().len());
        let groups = self.shape.groups.zip(data.groups.as_ref());
        let materials = self.shape.materials.zip(data.materials.as_ref());
        let labels = [groups, materials].into_iter().flatten().all(|(names, labels)| {
            let known = labels.of_face.iter().all(|i| (*i as usize) < names.len());
            if !known {
                fault.note("a face has a label without a name".into());
            }
            known && fault.expect(labels.of_face.len(), count, "labels")
        });
        let has = [data.groups.is_some(), data.materials.is_some(), data.corner_uvs.is_some()];
        let promised =
            [self.shape.groups.is_some(), self.shape.materials.is_some(), self.shape.corner_uvs];
        if has != promised {
            fault.note("attributes of faces are not those of the shape".into());
        }
        let uvs = data.corner_uvs.as_ref().map_or(corners, Vec::len);
        labels
            && has == promised
            && fault.expect(uvs, corners, "corner uvs")
            && self.are_corners(&data.faces, self.shape.vertex_count, fault)
    }

    fn are_corners(&self, faces: &Faces, vertex_count: usize, fault: &Fault) -> bool {
        let is_uniform =
            faces.is_empty() || faces.uniform_size() == Some(self.shape.face_size as u32);
        if !is_uniform {
            fault.note(format!("a face has not {} corners", self.shape.face_size));
        }
        let outside = faces.corners().iter().find(|v| **v as usize >= vertex_count);
        if let Some(v) = outside {
            fault.note(format!("a face lists vertex {v} of {vertex_count}"));
        }
        is_uniform && outside.is_none()
    }
}

/// Writes what `format` makes of each block, until there is a fault.
fn write(
    out: &mut dyn Write,
    count: usize,
    fault: &Fault,
    format: impl Fn(usize, &mut Vec<u8>) + Sync,
) -> Result<(), Error> {
    let mut out = Stopping { out, fault };
    let written = par::write_rows(&mut out, count, 1, |blocks: Range<usize>, out| {
        blocks.for_each(|block| format(block, out));
    });
    match fault.0.lock().unwrap_or_else(PoisonError::into_inner).take() {
        Some(text) => Err(Error::Unwritable(text)),
        None => Ok(written?),
    }
}

/// Number of vertices in a block, if their attributes are complete.
fn vertices_in(data: &MeshData, wanted: Attributes, fault: &Fault) -> Option<usize> {
    let lengths = [
        (wanted.positions, Some(data.positions.len())),
        (wanted.normals, data.normals.as_ref().map(Vec::len)),
        (wanted.colours, data.colours.as_ref().map(Vec::len)),
        (wanted.uvs, data.uvs.as_ref().map(Vec::len)),
    ];
    let mut lengths = lengths.into_iter().filter(|l| l.0).map(|l| l.1.unwrap_or(0));
    let count = lengths.next()?;
    lengths.all(|length| fault.expect(length, count, "values of vertices")).then_some(count)
}

/// Passes bytes on until there is a fault.
struct Stopping<'a> {
    out: &'a mut dyn Write,
    fault: &'a Fault,
}

impl Write for Stopping<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if self.fault.0.lock().unwrap_or_else(PoisonError::into_inner).is_some() {
            return Err(std::io::ErrorKind::InvalidData.into());
        }
        self.out.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}
