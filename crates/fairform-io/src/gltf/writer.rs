//! One mesh as glTF.

use std::borrow::Cow;
use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use fairform::{Bounds, Vec3};
use serde_json::{Value, json};

use crate::data::{MeshData, all_exact_bytes, exact_bytes};
use crate::error::Error;
use crate::format::{NORMALS_PER_CORNER, left_out};
use crate::par;
use crate::stl::{are_single, rounding_note, triangle_notes};
use crate::stream::{Attributes, Checked, Shape};
use crate::text::ROWS;
use crate::triangulate::Triangles;

/// Numbers of component types, buffer targets and primitive modes.
const BYTE: u32 = 5121;
const UINT: u32 = 5125;
const FLOAT: u32 = 5126;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// The buffer being described: JSON arrays that say what lies where.
#[derive(Default)]
struct Buffer {
    length: usize,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Adds an accessor of 4-byte aligned data with a view of its own: its number.
    fn add(&mut self, length: usize, target: u32, mut accessor: Value) -> usize {
        let view = self.views.len();
        self.views.push(json!({
            "buffer": 0, "byteOffset": self.length, "byteLength": length, "target": target,
        }));
        self.length += length;
        accessor["bufferView"] = view.into();
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds so many rows of so many floats.
    fn add_floats(&mut self, (rows, per_row): (usize, usize), mut accessor: Value) -> usize {
        accessor["componentType"] = FLOAT.into();
        accessor["count"] = rows.into();
        self.add(4 * per_row * rows, VERTICES, accessor)
    }
}

/// Writes a GLB file, or JSON with the buffer inside.
pub(crate) fn encode(
    data: &MeshData,
    binary: bool,
    out: &mut dyn Write,
) -> Result<Vec<String>, Error> {
    let blocks = par::map(data.positions.chunks(ROWS), |block| block.iter().position(is_bad));
    let bad = (0..).step_by(ROWS).zip(blocks).find_map(|(start, v)| Some(start + v?));
    refuse(bad)?;
    let shape = Shape::of(data);
    let single = par::map(data.positions.chunks(ROWS), are_single);
    let mut notes: Vec<String> = single.contains(&false).then(rounding_note).into_iter().collect();
    let (mut document, mut parts) = (empty_document(), Vec::new());
    if !data.positions.is_empty() {
        let bounds =
            par::map(data.positions.chunks(ROWS), |block| Bounds::of(block.iter().copied()));
        let bytes = data.colours.as_deref().and_then(all_exact_bytes);
        let mut buffer = Buffer::default();
        let attributes = describe_attributes(&shape, &union(bounds), bytes.is_some(), &mut buffer);
        parts.push(floats::<3>(bytemuck::cast_slice(&data.positions)));
        parts.extend(data.normals.as_ref().map(|n| floats::<3>(bytemuck::cast_slice(n))));
        match bytes {
            Some(bytes) => parts.push(bytemuck::cast_vec(bytes)),
            None => parts.extend(data.colours.as_ref().map(|c| floats(c))),
        }
        parts.extend(data.uvs.as_ref().map(|uvs| floats(uvs)));
        let triangles = sorted_triangles(data, &mut notes);
        let counts: Vec<usize> = triangles.iter().map(|t| t.len()).collect();
        fill_document(&mut document, &shape, &attributes, &counts, buffer, &mut notes);
        let used = triangles.iter().filter(|t| !t.is_empty());
        parts.extend(used.map(|triangles| indices(triangles)));
    }
    if binary {
        write_glb_header(&document, parts.iter().map(Vec::len).sum(), out)?;
        parts.iter().try_for_each(|part| out.write_all(part))?;
    } else {
        if !data.positions.is_empty() {
            let data = STANDARD.encode(parts.concat());
            document["buffers"][0]["uri"] =
                format!("data:application/octet-stream;base64,{data}").into();
        }
        serde_json::to_writer_pretty(&mut *out, &document).map_err(std::io::Error::from)?;
        out.write_all(b"\n")?;
    }
    notes.extend(losses(&shape));
    Ok(notes)
}

/// As [`encode`], a GLB file of a mesh that is made meanwhile. The bounds stand before everything, so the
/// positions are made twice.
pub(crate) fn encode_blocks(
    blocks: &Checked<'_>,
    out: &mut dyn Write,
) -> Result<Vec<String>, Error> {
    let shape = &blocks.shape;
    let triangles = shape.face_count.saturating_mul(shape.face_size.saturating_sub(2));
    // Before anything is made for nothing.
    let least = (shape.vertex_count as u64).saturating_add(triangles as u64).saturating_mul(12);
    check_length(least)?;
    let positions = Attributes { positions: true, ..Attributes::NONE };
    let (mut bounds, mut count, mut bad, mut single) = (Vec::new(), 0, None, true);
    let look = |data: &MeshData| {
        let all = &data.positions;
        let bad = all.iter().position(is_bad);
        (all.len(), bad, are_single(all), Bounds::of(all.iter().copied()))
    };
    blocks.all_vertices(positions, look, |(len, found, is_single, block)| {
        bad = found.map(|v| count + v);
        count += len;
        single &= is_single;
        if len > 0 {
            bounds.push(block);
        }
        bad.is_none()
    })?;
    refuse(bad)?;
    let mut notes: Vec<String> = (!single).then(rounding_note).into_iter().collect();
    let mut document = empty_document();
    if count == 0 {
        write_glb_header(&document, 0, out)?;
        notes.extend(losses(shape));
        return Ok(notes);
    }
    let as_bytes = shape.colours && blocks.all_colours(|c| exact_bytes(c).is_some());
    let mut buffer = Buffer::default();
    let attributes = describe_attributes(shape, &union(bounds), as_bytes, &mut buffer);
    let cut = if shape.face_size > 3 { shape.face_count } else { 0 };
    notes.extend(triangle_notes(cut, 0));
    let length = buffer.length + 12 * triangles;
    fill_document(&mut document, shape, &attributes, &[triangles], buffer, &mut notes);
    write_glb_header(&document, length, out)?;
    blocks.write_vertices(out, positions, |data, out| {
        out.extend(floats::<3>(bytemuck::cast_slice(&data.positions)));
    })?;
    if shape.normals {
        let wanted = Attributes { normals: true, ..Attributes::NONE };
        blocks.write_vertices(out, wanted, |data, out| {
            let normals = data.normals.as_deref().unwrap_or_default();
            out.extend(floats::<3>(bytemuck::cast_slice(normals)));
        })?;
    }
    if shape.colours {
        let wanted = Attributes { colours: true, ..Attributes::NONE };
        blocks.write_vertices(out, wanted, |data, out| {
            let colours = data.colours.as_deref().unwrap_or_default();
            if as_bytes {
                out.extend(colours.iter().filter_map(exact_bytes).flatten());
            } else {
                out.extend(floats(colours));
            }
        })?;
    }
    if shape.uvs {
        let wanted = Attributes { uvs: true, ..Attributes::NONE };
        blocks.write_vertices(out, wanted, |data, out| {
            out.extend(floats(data.uvs.as_deref().unwrap_or_default()));
        })?;
    }
    if shape.face_size == 3 {
        blocks.write_faces(out, |data, _, out| {
            out.extend(indices(data.faces.corners().as_chunks::<3>().0));
        })?;
    } else {
        blocks.write_patches(out, |patch, out| {
            let triangles = Triangles::new(&patch.positions, &patch.faces);
            let in_mesh = triangles.corners.iter().flatten().map(|&v| patch.numbers[v as usize]);
            out.extend(in_mesh.flat_map(u32::to_le_bytes));
        })?;
    }
    notes.extend(losses(shape));
    Ok(notes)
}

fn empty_document() -> Value {
    json!({
        "asset": { "version": "2.0", "generator": "fairform" },
        "scene": 0,
        "scenes": [{}],
    })
}

fn losses(shape: &Shape<'_>) -> Vec<String> {
    left_out(
        &[
            (shape.corner_normals, NORMALS_PER_CORNER),
            (shape.creases, "crease tags"),
            (shape.corner_uvs, "texture coordinates per corner"),
            (shape.groups.is_some(), "groups"),
            (shape.material_library.is_some(), "the material library"),
        ],
        "glTF",
    )
}

fn is_bad(p: &Vec3) -> bool {
    !to_f32(*p).is_finite()
}

fn refuse(bad: Option<usize>) -> Result<(), Error> {
    bad.map_or(Ok(()), |v| {
        Err(Error::Unwritable(format!(
            "glTF holds 32-bit finite coordinates only, and vertex {v} has others"
        )))
    })
}

fn to_f32(p: Vec3) -> Vec3 {
    let round = |x: f64| f64::from(x as f32);
    Vec3::new(round(p.x), round(p.y), round(p.z))
}

fn union(bounds: Vec<Bounds>) -> Bounds {
    Bounds::of(bounds.into_iter().flat_map(|b| [b.min, b.max]))
}

fn floats<const N: usize>(rows: &[[f64; N]]) -> Vec<u8> {
    bytemuck::cast_vec(par::collect(rows.len(), |i| rows[i].map(|x| (x as f32).to_le_bytes())))
}

fn indices(triangles: &[[u32; 3]]) -> Vec<u8> {
    bytemuck::cast_vec(par::collect(triangles.len(), |i| triangles[i].map(u32::to_le_bytes)))
}

/// Positions, normals, colours and texture coordinates, which lie in the buffer in this order.
fn describe_attributes(
    shape: &Shape<'_>,
    bounds: &Bounds,
    colours_as_bytes: bool,
    buffer: &mut Buffer,
) -> Value {
    let count = shape.vertex_count;
    // The bounds must be those of the rounded coordinates; rounding keeps the order. A zero has no
    // sign, whichever came first.
    let [low, high] =
        [bounds.min, bounds.max].map(|p| <[f64; 3]>::from(to_f32(p)).map(|x| x + 0.0));
    let accessor = json!({ "type": "VEC3", "min": low, "max": high });
    let mut attributes = json!({ "POSITION": buffer.add_floats((count, 3), accessor) });
    if shape.normals {
        attributes["NORMAL"] = buffer.add_floats((count, 3), json!({ "type": "VEC3" })).into();
    }
    if shape.colours {
        let accessor = if colours_as_bytes {
            let accessor = json!({
                "type": "VEC4", "componentType": BYTE, "normalized": true, "count": count,
            });
            buffer.add(4 * count, VERTICES, accessor)
        } else {
            buffer.add_floats((count, 4), json!({ "type": "VEC4" }))
        };
        attributes["COLOR_0"] = accessor.into();
    }
    if shape.uvs {
        let accessor = buffer.add_floats((count, 2), json!({ "type": "VEC2" }));
        attributes["TEXCOORD_0"] = accessor.into();
    }
    attributes
}

/// The triangles of each material, in the order of their names.
fn sorted_triangles<'a>(data: &'a MeshData, notes: &mut Vec<String>) -> Vec<Cow<'a, [[u32; 3]]>> {
    let all = Triangles::new(&data.positions, &data.faces);
    notes.extend(triangle_notes(all.cut, all.dropped));
    let triangles: Vec<Cow<'a, [[u32; 3]]>> = match &data.materials {
        Some(materials) if materials.names.len() > 1 => {
            let mut triangles = vec![Vec::new(); materials.names.len()];
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
    triangles
}

/// Describes a mesh of so many triangles of each material, behind what the buffer has already.
fn fill_document(
    document: &mut Value,
    shape: &Shape<'_>,
    attributes: &Value,
    triangle_counts: &[usize],
    mut buffer: Buffer,
    notes: &mut Vec<String>,
) {
    let (mut primitives, mut materials) = (Vec::new(), Vec::new());
    for (i, &count) in triangle_counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let accessor = json!({ "type": "SCALAR", "componentType": UINT, "count": 3 * count });
        let mut primitive = json!({
            "attributes": attributes, "indices": buffer.add(12 * count, INDICES, accessor),
        });
        let names = shape.materials.unwrap_or_default();
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

fn check_length(bytes: u64) -> Result<u32, Error> {
    u32::try_from(bytes).map_err(|_| {
        Error::Unwritable(format!("GLB files end at 4 GiB; this takes {bytes} bytes or more"))
    })
}

/// All but the buffer of a GLB file, which follows.
fn write_glb_header(document: &Value, size: usize, out: &mut dyn Write) -> Result<(), Error> {
    let mut json = serde_json::to_vec(document).map_err(std::io::Error::from)?;
    // Chunks are multiples of 4 bytes; the buffer holds nothing but such.
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunk = if size == 0 { 0 } else { 8 + size };
    let length = 12 + 8 + json.len() + chunk;
    let length = check_length(length as u64)?;
    out.write_all(b"glTF")?;
    out.write_all(&2_u32.to_le_bytes())?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(&(json.len() as u32).to_le_bytes())?;
    out.write_all(b"JSON")?;
    out.write_all(&json)?;
    if size > 0 {
        out.write_all(&(size as u32).to_le_bytes())?;
        out.write_all(b"BIN\0")?;
    }
    Ok(())
}
