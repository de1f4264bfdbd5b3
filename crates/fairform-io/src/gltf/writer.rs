//! One mesh as glTF.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use fairform::Vec3;
use serde_json::{Value, json};

use crate::data::{MeshData, exact_bytes};
use crate::error::Error;
use crate::format::{NORMALS_PER_CORNER, left_out};
use crate::stl::{rounding_note, triangle_notes};
use crate::triangulate::Triangulator;

/// Numbers of component types, buffer targets and primitive modes.
const BYTE: u32 = 5121;
const UINT: u32 = 5125;
const FLOAT: u32 = 5126;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// The buffer being filled, and the JSON arrays that describe it.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Adds an accessor of 4-byte aligned data with a view of its own: its number.
    fn add(&mut self, bytes: &[u8], target: u32, mut accessor: Value) -> usize {
        let view = self.views.len();
        self.views.push(json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(),
            "target": target,
        }));
        self.bytes.extend_from_slice(bytes);
        accessor["bufferView"] = view.into();
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn add_floats<const N: usize>(&mut self, rows: &[[f64; N]], mut accessor: Value) -> usize {
        let bytes: Vec<u8> =
            rows.iter().flatten().flat_map(|x| (*x as f32).to_le_bytes()).collect();
        accessor["componentType"] = FLOAT.into();
        accessor["count"] = rows.len().into();
        self.add(&bytes, VERTICES, accessor)
    }
}

/// Writes a GLB file, or JSON with the buffer inside.
pub(crate) fn encode(
    data: &MeshData,
    binary: bool,
    out: &mut dyn Write,
) -> Result<Vec<String>, Error> {
    if let Some(v) = data.positions.iter().position(|p| !to_f32(*p).is_finite()) {
        return Err(Error::Unwritable(format!(
            "glTF holds 32-bit finite coordinates only, and vertex {v} has others"
        )));
    }
    let mut buffer = Buffer::default();
    let mut notes: Vec<String> = rounding_note(data).into_iter().collect();
    let mut document = json!({
        "asset": { "version": "2.0", "generator": "fairform" },
        "scene": 0,
        "scenes": [{}],
    });
    if !data.positions.is_empty() {
        let attributes = write_attributes(data, &mut buffer);
        let (primitives, materials) = write_primitives(data, &attributes, &mut buffer, &mut notes);
        document["scenes"] = json!([{ "nodes": [0] }]);
        document["nodes"] = json!([{ "mesh": 0 }]);
        document["meshes"] = json!([{ "primitives": primitives }]);
        if !materials.is_empty() {
            document["materials"] = materials.into();
        }
        document["accessors"] = buffer.accessors.into();
        document["bufferViews"] = buffer.views.into();
        document["buffers"] = json!([{ "byteLength": buffer.bytes.len() }]);
    }
    if binary {
        write_glb(&document, &buffer.bytes, out)?;
    } else {
        if !data.positions.is_empty() {
            let data = STANDARD.encode(&buffer.bytes);
            document["buffers"][0]["uri"] =
                format!("data:application/octet-stream;base64,{data}").into();
        }
        serde_json::to_writer_pretty(&mut *out, &document).map_err(std::io::Error::from)?;
        out.write_all(b"\n")?;
    }
    notes.extend(left_out(
        &[
            (data.corner_normals.is_some(), NORMALS_PER_CORNER),
            (data.creases.is_some(), "crease tags"),
            (data.corner_uvs.is_some(), "texture coordinates per corner"),
            (data.groups.is_some(), "groups"),
            (data.material_library.is_some(), "the material library"),
        ],
        "glTF",
    ));
    Ok(notes)
}

fn to_f32(p: Vec3) -> Vec3 {
    let round = |x: f64| f64::from(x as f32);
    Vec3::new(round(p.x), round(p.y), round(p.z))
}

fn write_attributes(data: &MeshData, buffer: &mut Buffer) -> Value {
    let arrays = |v: &[Vec3]| v.iter().map(|v| <[f64; 3]>::from(*v)).collect::<Vec<_>>();
    // The bounds must be those of the rounded coordinates.
    let rounded: Vec<Vec3> = data.positions.iter().map(|p| to_f32(*p)).collect();
    let low: [f64; 3] = rounded.iter().copied().fold(rounded[0], Vec3::min).into();
    let high: [f64; 3] = rounded.iter().copied().fold(rounded[0], Vec3::max).into();
    let accessor = json!({ "type": "VEC3", "min": low, "max": high });
    let mut attributes = json!({ "POSITION": buffer.add_floats(&arrays(&rounded), accessor) });
    if let Some(normals) = &data.normals {
        let accessor = buffer.add_floats(&arrays(normals), json!({ "type": "VEC3" }));
        attributes["NORMAL"] = accessor.into();
    }
    if let Some(colours) = &data.colours {
        let bytes: Option<Vec<[u8; 4]>> = colours.iter().map(exact_bytes).collect();
        let accessor = match bytes {
            Some(bytes) => buffer.add(
                bytes.as_flattened(),
                VERTICES,
                json!({
                    "type": "VEC4", "componentType": BYTE, "normalized": true,
                    "count": bytes.len(),
                }),
            ),
            None => buffer.add_floats(colours, json!({ "type": "VEC4" })),
        };
        attributes["COLOR_0"] = accessor.into();
    }
    if let Some(uvs) = &data.uvs {
        let accessor = buffer.add_floats(uvs, json!({ "type": "VEC2" }));
        attributes["TEXCOORD_0"] = accessor.into();
    }
    attributes
}

/// The primitives, one per material in the order of their names, and the materials.
fn write_primitives(
    data: &MeshData,
    attributes: &Value,
    buffer: &mut Buffer,
    notes: &mut Vec<String>,
) -> (Vec<Value>, Vec<Value>) {
    let names = data.materials.as_ref().map_or(&[][..], |m| &m.names);
    let mut triangles = vec![Vec::new(); names.len().max(1)];
    let mut cutter = Triangulator::default();
    let (mut cut, mut dropped) = (0, 0);
    for (face, corners) in data.faces.iter().enumerate() {
        let material = data.materials.as_ref().map_or(0, |m| m.of_face[face] as usize);
        cutter.cut(&data.positions, corners, &mut triangles[material]);
        cut += usize::from(corners.len() > 3);
        dropped += usize::from(corners.len() < 3);
    }
    notes.extend(triangle_notes(cut, dropped));
    let used = triangles.iter().filter(|t| !t.is_empty()).count();
    let unsorted = data.materials.as_ref().is_some_and(|m| !m.of_face.is_sorted());
    if used > 1 && unsorted {
        notes.push("faces sorted by material: glTF has a primitive for each".into());
    }
    let mut primitives = Vec::new();
    let mut materials = Vec::new();
    for (i, triangles) in triangles.iter().enumerate().filter(|(_, t)| !t.is_empty()) {
        let bytes: Vec<u8> = triangles.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let accessor = json!({
            "type": "SCALAR", "componentType": UINT, "count": 3 * triangles.len(),
        });
        let mut primitive = json!({
            "attributes": attributes, "indices": buffer.add(&bytes, INDICES, accessor),
        });
        if let Some(name) = names.get(i).filter(|name| !name.is_empty()) {
            primitive["material"] = materials.len().into();
            materials.push(json!({ "name": name }));
        }
        primitives.push(primitive);
    }
    if primitives.is_empty() {
        notes.push("no triangles: vertices written as points".into());
        primitives.push(json!({ "attributes": attributes, "mode": 0 }));
    }
    (primitives, materials)
}

fn write_glb(document: &Value, binary: &[u8], out: &mut dyn Write) -> Result<(), Error> {
    let mut json = serde_json::to_vec(document).map_err(std::io::Error::from)?;
    // Chunks are multiples of 4 bytes; the buffer holds nothing but such.
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunk = if binary.is_empty() { 0 } else { 8 + binary.len() };
    let length = 12 + 8 + json.len() + chunk;
    let Ok(length) = u32::try_from(length) else {
        return Err(Error::Unwritable(format!(
            "GLB files end at 4 GiB; this takes {length} bytes"
        )));
    };
    out.write_all(b"glTF")?;
    out.write_all(&2_u32.to_le_bytes())?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(&(json.len() as u32).to_le_bytes())?;
    out.write_all(b"JSON")?;
    out.write_all(&json)?;
    if !binary.is_empty() {
        out.write_all(&(binary.len() as u32).to_le_bytes())?;
        out.write_all(b"BIN\0")?;
        out.write_all(binary)?;
    }
    Ok(())
}
