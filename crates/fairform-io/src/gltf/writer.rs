//! One mesh as glTF.

use std::borrow::Cow;
use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use fairform::Vec3;
use serde_json::{Value, json};

use crate::data::{MeshData, exact_bytes};
use crate::error::Error;
use crate::format::{NORMALS_PER_CORNER, left_out};
use crate::par;
use crate::stl::{rounding_note, triangle_notes};
use crate::text::ROWS;
use crate::triangulate::Triangles;

/// Numbers of component types, buffer targets and primitive modes.
const BYTE: u32 = 5121;
const UINT: u32 = 5125;
const FLOAT: u32 = 5126;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// The buffer being filled, and the JSON arrays that describe it.
#[derive(Default)]
struct Buffer {
    /// One behind the other.
    parts: Vec<Vec<u8>>,
    length: usize,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Adds an accessor of 4-byte aligned data with a view of its own: its number.
    fn add(&mut self, bytes: Vec<u8>, target: u32, mut accessor: Value) -> usize {
        let view = self.views.len();
        self.views.push(json!({
            "buffer": 0, "byteOffset": self.length, "byteLength": bytes.len(),
            "target": target,
        }));
        self.length += bytes.len();
        self.parts.push(bytes);
        accessor["bufferView"] = view.into();
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn add_floats<const N: usize>(&mut self, rows: &[[f64; N]], mut accessor: Value) -> usize {
        let words = par::collect(rows.len(), |i| rows[i].map(|x| (x as f32).to_le_bytes()));
        accessor["componentType"] = FLOAT.into();
        accessor["count"] = rows.len().into();
        self.add(bytemuck::cast_vec(words), VERTICES, accessor)
    }
}

/// Writes a GLB file, or JSON with the buffer inside.
pub(crate) fn encode(
    data: &MeshData,
    binary: bool,
    out: &mut dyn Write,
) -> Result<Vec<String>, Error> {
    let bad = |p: &Vec3| !to_f32(*p).is_finite();
    let blocks = par::map(data.positions.chunks(ROWS), |block| block.iter().any(bad));
    if blocks.contains(&true)
        && let Some(v) = data.positions.iter().position(bad)
    {
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
        document["buffers"] = json!([{ "byteLength": buffer.length }]);
    }
    if binary {
        write_glb(&document, &buffer.parts, out)?;
    } else {
        if !data.positions.is_empty() {
            let data = STANDARD.encode(buffer.parts.concat());
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
    // The bounds must be those of the rounded coordinates; rounding keeps the order.
    let first = data.positions[0];
    let bounds = par::map(data.positions.chunks(ROWS), |block| {
        let fold = |f: fn(Vec3, Vec3) -> Vec3| block.iter().copied().fold(block[0], f);
        (fold(Vec3::min), fold(Vec3::max))
    });
    let low = bounds.iter().map(|(low, _)| *low).fold(first, Vec3::min);
    let high = bounds.iter().map(|(_, high)| *high).fold(first, Vec3::max);
    let [low, high] = [low, high].map(|p| <[f64; 3]>::from(to_f32(p)));
    let accessor = json!({ "type": "VEC3", "min": low, "max": high });
    let positions: &[[f64; 3]] = bytemuck::cast_slice(&data.positions);
    let mut attributes = json!({ "POSITION": buffer.add_floats(positions, accessor) });
    if let Some(normals) = &data.normals {
        let normals: &[[f64; 3]] = bytemuck::cast_slice(normals);
        let accessor = buffer.add_floats(normals, json!({ "type": "VEC3" }));
        attributes["NORMAL"] = accessor.into();
    }
    if let Some(colours) = &data.colours {
        let bytes: Option<Vec<[u8; 4]>> = colours.iter().map(exact_bytes).collect();
        let accessor = match bytes {
            Some(bytes) => {
                let accessor = json!({
                    "type": "VEC4", "componentType": BYTE, "normalized": true,
                    "count": bytes.len(),
                });
                buffer.add(bytemuck::cast_vec(bytes), VERTICES, accessor)
            }
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
    let all = Triangles::new(&data.positions, &data.faces);
    notes.extend(triangle_notes(all.cut, all.dropped));
    let triangles = match &data.materials {
        Some(materials) if names.len() > 1 => {
            let mut triangles = vec![Vec::new(); names.len()];
            for (i, triangle) in all.corners.iter().enumerate() {
                triangles[materials.of_face[all.face_of(i)] as usize].push(*triangle);
            }
            triangles.into_iter().map(Cow::Owned).collect()
        }
        _ => vec![all.corners],
    };
    let used = triangles.iter().filter(|t| !t.is_empty()).count();
    let unsorted = data.materials.as_ref().is_some_and(|m| !m.of_face.is_sorted());
    if used > 1 && unsorted {
        notes.push("faces sorted by material: glTF has a primitive for each".into());
    }
    let mut primitives = Vec::new();
    let mut materials = Vec::new();
    for (i, triangles) in triangles.iter().enumerate().filter(|(_, t)| !t.is_empty()) {
        let words = par::collect(triangles.len(), |i| triangles[i].map(u32::to_le_bytes));
        let accessor = json!({
            "type": "SCALAR", "componentType": UINT, "count": 3 * triangles.len(),
        });
        let mut primitive = json!({
            "attributes": attributes, "indices": buffer.add(bytemuck::cast_vec(words), INDICES, accessor),
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

fn write_glb(document: &Value, binary: &[Vec<u8>], out: &mut dyn Write) -> Result<(), Error> {
    let mut json = serde_json::to_vec(document).map_err(std::io::Error::from)?;
    // Chunks are multiples of 4 bytes; the buffer holds nothing but such.
    json.resize(json.len().next_multiple_of(4), b' ');
    let size: usize = binary.iter().map(Vec::len).sum();
    let chunk = if size == 0 { 0 } else { 8 + size };
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
    if size > 0 {
        out.write_all(&(size as u32).to_le_bytes())?;
        out.write_all(b"BIN\0")?;
        binary.iter().try_for_each(|part| out.write_all(part))?;
    }
    Ok(())
}
