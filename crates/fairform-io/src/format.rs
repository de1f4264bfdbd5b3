//! [`Format`], and the way from it to each reader and writer.

use std::fmt;
use std::io::Write;
use std::path::Path;
use std::str::FromStr;

use crate::data::{MeshData, WriteOptions};
use crate::error::{Error, ParseError};
use crate::{gltf, gzip, obj, off, par, ply, stl};

/// A mesh file format.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
#[non_exhaustive]
pub enum Format {
    /// Wavefront OBJ.
    Obj,
    /// Object File Format of Geomview.
    Off,
    /// Stanford polygon file, text or binary.
    Ply,
    /// Stereolithography file, text or binary.
    Stl,
    /// glTF 2.0 as JSON.
    Gltf,
    /// glTF 2.0 in one binary file.
    Glb,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 6] = [Self::Obj, Self::Off, Self::Ply, Self::Stl, Self::Gltf, Self::Glb];

    pub(crate) const KNOWN: &str = "obj, off, ply, stl, gltf, glb, each also with .gz";

    /// The format that a file name says, and whether it says `.gz` as well. Case does not matter.
    #[must_use]
    pub fn from_path(path: &Path) -> Option<(Self, bool)> {
        let name = path.file_name()?.to_string_lossy().to_ascii_lowercase();
        let (name, gzip) = match name.strip_suffix(".gz") {
            Some(stem) => (stem, true),
            None => (name.as_str(), false),
        };
        let (_, extension) = name.rsplit_once('.')?;
        Some((extension.parse().ok()?, gzip))
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Off => "off",
            Self::Ply => "ply",
            Self::Stl => "stl",
            Self::Gltf => "gltf",
            Self::Glb => "glb",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Format {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|format| format.name().eq_ignore_ascii_case(name))
            .ok_or_else(|| format!("unknown format '{name}'; known are {}", Self::KNOWN))
    }
}

/// The mesh in bytes of a format, which may be gzipped.
///
/// A `.gltf` that keeps its numbers in other files is refused; see
/// [`parse_with_buffers`](crate::parse_with_buffers).
///
/// # Errors
/// If the bytes are not what the format asks for; the error says where.
pub fn parse(bytes: &[u8], format: Format) -> Result<MeshData, ParseError> {
    if gzip::is_gzip(bytes) {
        let bytes = gzip::unpack(bytes)?;
        return parse_in_parts(&bytes, format, par::part_count(bytes.len()));
    }
    parse_in_parts(bytes, format, par::part_count(bytes.len()))
}

/// As [`parse`], of bytes that are not gzipped, with a text cut into about so many parts. The mesh or
/// error is the same for any number: for tests, which want many parts of a short text.
///
/// # Errors
/// As [`parse`].
#[doc(hidden)]
pub fn parse_in_parts(
    bytes: &[u8],
    format: Format,
    part_count: usize,
) -> Result<MeshData, ParseError> {
    match format {
        Format::Obj => obj::parse(bytes, part_count),
        Format::Off => off::parse(bytes, part_count),
        Format::Ply => ply::parse(bytes, part_count),
        Format::Stl => stl::parse(bytes, part_count),
        Format::Gltf | Format::Glb => gltf::parse_with_buffers(bytes, &mut |name| {
            Err(format!("the buffer is in another file, '{name}', which is not at hand"))
        }),
    }
}

/// Writes a mesh, and says what the format could not hold. The same data give the same bytes.
///
/// # Errors
/// If the writer fails, the arrays do not fit together, or the format cannot hold the mesh at all
/// (glTF: coordinates that are not finite).
pub fn encode(
    format: Format,
    data: &MeshData,
    options: &WriteOptions,
    out: &mut dyn Write,
) -> Result<Vec<String>, Error> {
    data.check()?;
    match format {
        Format::Obj => obj::encode(data, options, out),
        Format::Off => off::encode(data, options, out),
        Format::Ply => ply::encode(data, options, out),
        Format::Stl => stl::encode(data, options, out),
        Format::Gltf => gltf::encode(data, false, out),
        Format::Glb => gltf::encode(data, true, out),
    }
}

/// What formats with one normal per vertex lose. [`MeshData::normals`], the mean, is written.
pub(crate) const NORMALS_PER_CORNER: &str = "several normals of a vertex";

/// Notes on the attributes that a format has no place for.
pub(crate) fn left_out(attributes: &[(bool, &str)], format: &str) -> Vec<String> {
    let lost: Vec<_> = attributes.iter().filter(|(has, _)| *has).map(|(_, name)| *name).collect();
    if lost.is_empty() {
        return Vec::new();
    }
    vec![format!("{format} has no place for {}: left out", lost.join(", "))]
}
