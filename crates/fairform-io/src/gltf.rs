//! glTF 2.0, as JSON or as one binary file.
//!
//! Read: the triangles of the meshes in the default scene, moved by their nodes, as one mesh. A
//! vertex stays what it is in the file: programs that write glTF split vertices at seams and sharp
//! edges, and joining them again is repair's business.
//!
//! Source: Khronos Group, *glTF 2.0 Specification*, 2.0.1, 2021.

mod accessor;
mod json;
mod scene;
mod writer;

use crate::data::MeshData;
use crate::error::ParseError;
use accessor::Buffers;
use json::Document;

pub(crate) use writer::{encode, encode_blocks};

/// The mesh in a glTF file, JSON or binary, whose buffers may be in other files: `load` is called
/// with the name of each, as it stands in the file but with `%20` and the like decoded, and gives
/// its bytes or says why not.
///
/// # Errors
/// If the bytes are no glTF, refer to what is not there, need an extension we do not know, or
/// repeat their parts so often that more than 4 million vertices and corners, and 64 for each byte
/// of the file, would come out.
pub fn parse_with_buffers(
    bytes: &[u8],
    load: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
) -> Result<MeshData, ParseError> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(ParseError::file("the file is empty"));
    }
    let mut notes = Vec::new();
    let (json, chunk) =
        if bytes.starts_with(b"glTF") { binary_chunks(bytes, &mut notes)? } else { (bytes, None) };
    let document = json::parse(json)?;
    check_extensions(&document, &mut notes)?;
    let buffers = Buffers::new(&document, bytes.len(), chunk, load)?;
    let mut data = scene::read(&document, buffers)?;
    notes.append(&mut data.notes);
    data.notes = notes;
    Ok(data)
}

/// The JSON and the binary chunk of a GLB file.
fn binary_chunks<'a>(
    bytes: &'a [u8],
    notes: &mut Vec<String>,
) -> Result<(&'a [u8], Option<&'a [u8]>), ParseError> {
    let word = |at: usize| {
        let bytes = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(ParseError::byte(bytes.len(), "the file ends within its header"));
    };
    if version != 2 {
        return Err(ParseError::byte(4, format!("GLB version {version}")).expected("2"));
    }
    let length = length as usize;
    if length > bytes.len() {
        let message = format!("the file declares {length} bytes and ends after {}", bytes.len());
        return Err(ParseError::byte(8, message));
    }
    if length < bytes.len() {
        notes.push(format!("{} bytes behind the declared end unread", bytes.len() - length));
    }
    let mut at = 12;
    let mut json = None;
    let mut binary = None;
    while at < length {
        let (Some(size), Some(kind)) = (word(at), word(at + 4)) else {
            return Err(ParseError::byte(at, "the file ends within a chunk header"));
        };
        let from = at + 8;
        let Some(end) = from.checked_add(size as usize).filter(|end| *end <= length) else {
            let left = length.saturating_sub(from);
            let message = format!("a chunk of {size} bytes, but the file holds {left} more");
            return Err(ParseError::byte(at, message));
        };
        let chunk = &bytes[from..end];
        match kind {
            JSON_CHUNK if json.is_none() => json = Some(chunk),
            BINARY_CHUNK if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        at = end;
    }
    match json {
        Some(json) => Ok((json, binary)),
        None => Err(ParseError::byte(12, "the file has no JSON chunk")),
    }
}

const JSON_CHUNK: u32 = u32::from_le_bytes(*b"JSON");
const BINARY_CHUNK: u32 = u32::from_le_bytes(*b"BIN\0");

/// Fails if the file cannot be read without an extension that may change the geometry.
fn check_extensions(document: &Document, notes: &mut Vec<String>) -> Result<(), ParseError> {
    // Quantized attributes are read as the accessors say. The others are about looks.
    let harmless = |name: &str| {
        ["KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "MSFT_texture_"]
            .iter()
            .any(|prefix| name.starts_with(prefix))
            || matches!(
                name,
                "KHR_mesh_quantization" | "KHR_xmp_json_ld" | "EXT_lights_image_based"
            )
    };
    for name in &document.extensions_required {
        if !harmless(name) {
            let message = format!("the file needs the extension {name}, which is not read");
            return Err(ParseError::file(message)
                .expected("a file saved without compression or extensions"));
        }
        if name == "KHR_texture_transform" {
            notes.push("texture coordinates are those before KHR_texture_transform".into());
        }
    }
    Ok(())
}
