//! Writing PLY.

use std::io::Write;
use std::ops::Range;

use fairform::FaceId;

use crate::data::{MeshData, WriteOptions, all_exact_bytes, exact_bytes};
use crate::error::Error;
use crate::format::{NORMALS_PER_CORNER, left_out};
use crate::par;
use crate::stream::{Attributes, Checked, Shape};
use crate::text::{NumberWriter, ROWS};

/// Appends numbers of the body: text, or binary in little-endian order.
struct RowWriter<'a> {
    out: &'a mut Vec<u8>,
    numbers: NumberWriter,
    ascii: bool,
    single: bool,
    row_begun: bool,
}

impl<'a> RowWriter<'a> {
    fn new(options: &WriteOptions, out: &'a mut Vec<u8>) -> Self {
        Self {
            out,
            numbers: NumberWriter::new(options.single_precision),
            ascii: options.ascii,
            single: options.single_precision,
            row_begun: false,
        }
    }

    fn part(&mut self) {
        if self.row_begun {
            self.out.push(b' ');
        }
        self.row_begun = true;
    }

    fn reals<const N: usize>(&mut self, values: [f64; N]) {
        if self.ascii {
            for value in values {
                self.part();
                self.numbers.write(self.out, value);
            }
        } else if self.single {
            let bytes = values.map(|value| (value as f32).to_le_bytes());
            self.out.extend_from_slice(bytes.as_flattened());
        } else {
            let bytes = values.map(f64::to_le_bytes);
            self.out.extend_from_slice(bytes.as_flattened());
        }
    }

    fn byte(&mut self, value: u8) {
        if self.ascii {
            self.part();
            self.numbers.whole(self.out, value.into());
        } else {
            self.out.push(value);
        }
    }

    fn index(&mut self, value: u32) {
        if self.ascii {
            self.part();
            self.numbers.whole(self.out, value.into());
        } else {
            self.out.extend_from_slice(&value.to_le_bytes());
        }
    }

    fn end(&mut self) {
        if self.ascii {
            self.out.push(b'\n');
        }
        self.row_begun = false;
    }
}

/// Writes a PLY file, with bytes where lists are short enough and indices of 32 bits.
pub(crate) fn encode(
    data: &MeshData,
    options: &WriteOptions,
    out: &mut dyn Write,
) -> Result<Vec<String>, Error> {
    let shape = Shape::of(data);
    let bytes = data.colours.as_deref().and_then(all_exact_bytes);
    write_header(&shape, bytes.is_some(), options, out)?;
    par::write_rows(out, shape.vertex_count, ROWS, |rows, out| {
        vertex_rows(data, bytes.as_deref(), rows, &mut RowWriter::new(options, out));
    })?;
    par::write_rows(out, shape.face_count, ROWS, |rows, out| {
        face_rows(data, has_short_lists(&shape), rows, &mut RowWriter::new(options, out));
    })?;
    Ok(notes(&shape))
}

/// As [`encode`], of a mesh that is made meanwhile.
pub(crate) fn encode_blocks(
    blocks: &Checked<'_>,
    options: &WriteOptions,
    out: &mut dyn Write,
) -> Result<Vec<String>, Error> {
    let shape = &blocks.shape;
    let as_bytes = blocks.all_colours(|c| exact_bytes(c).is_some());
    write_header(shape, as_bytes, options, out)?;
    blocks.write_vertices(out, Attributes::of(shape), |data, out| {
        let bytes = data.colours.as_deref().filter(|_| as_bytes).and_then(all_exact_bytes);
        let rows = 0..data.positions.len();
        vertex_rows(data, bytes.as_deref(), rows, &mut RowWriter::new(options, out));
    })?;
    blocks.write_faces(out, |data, _, out| {
        let rows = 0..data.faces.len();
        face_rows(data, has_short_lists(shape), rows, &mut RowWriter::new(options, out));
    })?;
    Ok(notes(shape))
}

/// Whether the length of every list fits into a byte. A list of texture coordinates is twice as long.
fn has_short_lists(shape: &Shape<'_>) -> bool {
    let longest = shape.face_size;
    (if shape.corner_uvs { longest.saturating_mul(2) } else { longest }) <= 255
}

fn write_header(
    shape: &Shape<'_>,
    colours_as_bytes: bool,
    options: &WriteOptions,
    out: &mut dyn Write,
) -> Result<(), Error> {
    let real = if options.single_precision { "float" } else { "double" };
    // Some readers know no unsigned indices.
    let index = if i32::try_from(shape.vertex_count).is_ok() { "int" } else { "uint" };
    let encoding = if options.ascii { "ascii" } else { "binary_little_endian" };
    write!(out, "ply\nformat {encoding} 1.0\nelement vertex {}\n", shape.vertex_count)?;
    let mut properties = |kind: &str, names: &[&str]| {
        names.iter().try_for_each(|name| writeln!(out, "property {kind} {name}"))
    };
    properties(real, &["x", "y", "z"])?;
    if shape.normals {
        properties(real, &["nx", "ny", "nz"])?;
    }
    if shape.colours {
        let kind = if colours_as_bytes { "uchar" } else { real };
        properties(kind, &["red", "green", "blue", "alpha"])?;
    }
    if shape.uvs {
        properties(real, &["s", "t"])?;
    }
    let length = if has_short_lists(shape) { "uchar" } else { "uint" };
    writeln!(out, "element face {}", shape.face_count)?;
    writeln!(out, "property list {length} {index} vertex_indices")?;
    if shape.corner_uvs {
        writeln!(out, "property list {length} {real} texcoord")?;
    }
    writeln!(out, "end_header")?;
    Ok(())
}

fn notes(shape: &Shape<'_>) -> Vec<String> {
    left_out(
        &[
            (shape.corner_normals, NORMALS_PER_CORNER),
            (shape.creases, "crease tags"),
            (shape.groups.is_some(), "groups"),
            (shape.materials.is_some(), "materials"),
            (shape.material_library.is_some(), "the material library"),
        ],
        "PLY",
    )
}

/// Appends the rows of some vertices.
fn vertex_rows(
    data: &MeshData,
    bytes: Option<&[[u8; 4]]>,
    rows: Range<usize>,
    out: &mut RowWriter<'_>,
) {
    for i in rows {
        out.reals(<[f64; 3]>::from(data.positions[i]));
        if let Some(normals) = &data.normals {
            out.reals(<[f64; 3]>::from(normals[i]));
        }
        if let Some(bytes) = bytes {
            bytes[i].into_iter().for_each(|b| out.byte(b));
        } else if let Some(colours) = &data.colours {
            out.reals(colours[i]);
        }
        if let Some(uvs) = &data.uvs {
            out.reals(uvs[i]);
        }
        out.end();
    }
}

/// Appends the rows of some faces.
fn face_rows(data: &MeshData, short_lists: bool, rows: Range<usize>, out: &mut RowWriter<'_>) {
    let length = |out: &mut RowWriter<'_>, n: usize| {
        if short_lists { out.byte(n as u8) } else { out.index(n as u32) }
    };
    let corners = data.faces.corners();
    for face in rows {
        let own = data.faces.range(FaceId(face as u32));
        length(out, own.len());
        corners[own.clone()].iter().for_each(|v| out.index(*v));
        if let Some(uvs) = &data.corner_uvs {
            length(out, 2 * own.len());
            uvs[own].iter().for_each(|uv| out.reals(*uv));
        }
        out.end();
    }
}
