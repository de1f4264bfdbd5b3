//! [`MeshData`]: what a mesh file holds.

use std::collections::HashMap;
use std::iter;

use fairform::{Faces, Vec3};

use crate::crease::CreaseList;
use crate::error::{Error, ParseError, Place};
use crate::par;

/// What a mesh file holds. Every corner is a vertex of the mesh; nothing else is promised about
/// the faces and coordinates: `Topology::from_faces` names what is wrong, repair mends it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Where the vertices are.
    pub positions: Vec<Vec3>,
    /// The polygons.
    pub faces: Faces,
    /// A normal per vertex, as the file has it: not always of length one.
    pub normals: Option<Vec<Vec3>>,
    /// A normal per face corner, in the order of [`Faces::corners`], where some vertex has several: a
    /// crease. They stand beside [`normals`](Self::normals) or alone.
    pub corner_normals: Option<Vec<Vec3>>,
    /// A colour per vertex: red, green, blue, alpha from 0 to 1. A byte `b` of a file is `b / 255`.
    pub colours: Option<Vec<[f64; 4]>>,
    /// Texture coordinates per vertex.
    pub uvs: Option<Vec<[f64; 2]>>,
    /// Texture coordinates per face corner, in the order of [`Faces::corners`], where some vertex
    /// has several: a seam.
    pub corner_uvs: Option<Vec<[f64; 2]>>,
    /// The group of each face: OBJ `g` or `o`, glTF node or mesh, STL solid.
    pub groups: Option<Labels>,
    /// The material of each face.
    pub materials: Option<Labels>,
    /// The material libraries that an OBJ file names, one `mtllib` statement per line.
    pub material_library: Option<String>,
    /// Creases, holes and the like, for a subdivision surface. Nothing is promised about their numbers.
    pub creases: Option<CreaseList>,
    /// What the reader did to the data or left out, for the user.
    pub notes: Vec<String>,
}

/// A name per face.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Labels {
    /// The names, each once. Empty for faces before the first name.
    pub names: Vec<String>,
    /// For each face an index into `names`.
    pub of_face: Vec<u32>,
}

/// How to write. The default loses nothing that the format can hold.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// PLY and STL as text instead of binary.
    pub ascii: bool,
    /// Numbers rounded to 32 bits where the format has a choice: PLY, and the texts.
    pub single_precision: bool,
}

impl MeshData {
    /// Checks that everything fits together, so that the writers can index freely.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let (vertices, faces) = (self.positions.len(), self.faces.len());
        let corners = self.faces.corners().len();
        let lengths = [
            ("normals", self.normals.as_ref().map(Vec::len), vertices),
            ("corner normals", self.corner_normals.as_ref().map(Vec::len), corners),
            ("colours", self.colours.as_ref().map(Vec::len), vertices),
            ("uvs", self.uvs.as_ref().map(Vec::len), vertices),
            ("corner uvs", self.corner_uvs.as_ref().map(Vec::len), corners),
            ("groups", self.groups.as_ref().map(|l| l.of_face.len()), faces),
            ("materials", self.materials.as_ref().map(|l| l.of_face.len()), faces),
        ];
        for (name, length, expected) in lengths {
            if length.is_some_and(|length| length != expected) {
                let length = length.unwrap_or_default();
                return Err(Error::Unwritable(format!("{length} {name}, expected {expected}")));
            }
        }
        if vertices > u32::MAX as usize {
            return Err(Error::Unwritable(format!("{vertices} vertices are too many")));
        }
        // The largest first: it takes less than looking where the first bad one is.
        if par::max(self.faces.corners()).is_some_and(|v| v as usize >= vertices) {
            for (face, corners) in self.faces.iter().enumerate() {
                if let Some(v) = corners.iter().find(|v| **v as usize >= vertices) {
                    return Err(Error::Unwritable(format!(
                        "face {face} lists vertex {v}, but the mesh has {vertices} vertices"
                    )));
                }
            }
        }
        for labels in [&self.groups, &self.materials].into_iter().flatten() {
            if labels.of_face.iter().any(|i| *i as usize >= labels.names.len()) {
                return Err(Error::Unwritable("a face has a label without a name".into()));
            }
        }
        Ok(())
    }
}

/// Appends a face, unless the corners become too many to count in 32 bits.
pub(crate) fn push_face(
    faces: &mut Faces,
    corners: &[u32],
    place: Place,
) -> Result<(), ParseError> {
    if faces.corners().len() + corners.len() > u32::MAX as usize {
        return Err(too_many_corners(place));
    }
    faces.push(corners);
    Ok(())
}

/// All faces of some parts.
///
/// # Errors
/// If the corners become too many to count in 32 bits.
pub(crate) fn join_faces(mut parts: Vec<Faces>) -> Result<Faces, ParseError> {
    if parts.len() == 1 {
        return Ok(parts.swap_remove(0));
    }
    let mut tasks = Vec::with_capacity(parts.len());
    let mut before = 0;
    let starts: Vec<_> = parts.iter().map(Faces::starts).collect();
    for (part, starts) in parts.iter().zip(&starts) {
        tasks.push((&starts[1..], before as u32));
        before += part.corners().len();
        if before > u32::MAX as usize {
            return Err(too_many_corners(Place::File));
        }
    }
    let starts = par::map(tasks, |(ends, before)| ends.iter().map(|end| before + end).collect());
    let starts: Vec<Vec<u32>> = iter::once(vec![0]).chain(starts).collect();
    let corners: Vec<&[u32]> = parts.iter().map(Faces::corners).collect();
    Ok(Faces::from_starts(par::join(starts), par::concat(&corners)))
}

pub(crate) fn too_many_corners(place: Place) -> ParseError {
    ParseError::new(place, "more than 4,294,967,295 face corners")
}

/// Collects the names of faces, in the order in which faces first have them.
#[derive(Default)]
pub(crate) struct LabelBuilder {
    labels: Labels,
    index: HashMap<String, u32>,
    /// The name of the faces to come, and its index once a face has it.
    current: (String, Option<u32>),
}

impl LabelBuilder {
    /// The name of the faces from here on.
    pub(crate) fn set(&mut self, name: String) {
        self.current = (name, None);
    }

    /// Gives the current name to all faces that have none yet, up to `face_count`.
    pub(crate) fn fill(&mut self, face_count: usize) {
        if face_count <= self.labels.of_face.len() {
            return;
        }
        let (name, known) = &mut self.current;
        let index = *known.get_or_insert_with(|| {
            *self.index.entry(name.clone()).or_insert_with(|| {
                self.labels.names.push(name.clone());
                self.labels.names.len() as u32 - 1
            })
        });
        self.labels.of_face.resize(face_count, index);
    }

    /// The labels, if any face has a name.
    pub(crate) fn finish(self) -> Option<Labels> {
        self.labels.names.iter().any(|name| !name.is_empty()).then_some(self.labels)
    }
}

/// The bytes of colours, if all came from bytes.
pub(crate) fn all_exact_bytes(colours: &[[f64; 4]]) -> Option<Vec<[u8; 4]>> {
    colours.iter().map(exact_bytes).collect()
}

/// The bytes of a colour, if it came from bytes.
pub(crate) fn exact_bytes(colour: &[f64; 4]) -> Option<[u8; 4]> {
    let mut bytes = [0; 4];
    for (byte, &value) in bytes.iter_mut().zip(colour) {
        let nearest = (value * 255.0).round();
        if !(0.0..=255.0).contains(&nearest) || (nearest / 255.0).to_bits() != value.to_bits() {
            return None;
        }
        // In range by the line above.
        #[expect(clippy::cast_sign_loss, reason = "checked to be 0 to 255")]
        {
            *byte = nearest as u8;
        }
    }
    Some(bytes)
}

/// Makes colours that were counted to 255 though written as fractions count to 1.
pub(crate) fn scale_large_colours(colours: &mut [[f64; 4]], notes: &mut Vec<String>) {
    // Alpha may be our own 1.
    if colours.iter().flat_map(|c| &c[..3]).any(|c| *c > 1.0) {
        for c in colours.iter_mut() {
            let alpha_counts = c[3] > 1.0;
            for value in &mut c[..if alpha_counts { 4 } else { 3 }] {
                *value /= 255.0;
            }
        }
        notes.push("colours above 1 were taken to count to 255".into());
    }
}
