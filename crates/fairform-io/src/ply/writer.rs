//! Writing PLY.

use std::io::Write;

use crate::data::{MeshData, WriteOptions, exact_bytes};
use crate::error::Error;
use crate::format::{NORMALS_PER_CORNER, left_out};
use crate::text::NumberWriter;

/// Writes numbers of the body: text, or binary in little-endian order.
struct RowWriter<'a> {
    out: &'a mut dyn Write,
    numbers: NumberWriter,
    ascii: bool,
    single: bool,
    row_begun: bool,
}

impl RowWriter<'_> {
    fn part(&mut self) -> Result<(), Error> {
        if self.row_begun {
            self.out.write_all(b" ")?;
        }
        self.row_begun = true;
        Ok(())
    }

    fn real(&mut self, value: f64) -> Result<(), Error> {
        if self.ascii {
            self.part()?;
            self.numbers.write(self.out, value)?;
        } else if self.single {
            self.out.write_all(&(value as f32).to_le_bytes())?;
        } else {
            self.out.write_all(&value.to_le_bytes())?;
        }
        Ok(())
    }

    fn byte(&mut self, value: u8) -> Result<(), Error> {
        if self.ascii {
            self.part()?;
            write!(self.out, "{value}")?;
        } else {
            self.out.write_all(&[value])?;
        }
        Ok(())
    }

    fn index(&mut self, value: u32) -> Result<(), Error> {
        if self.ascii {
            self.part()?;
            write!(self.out, "{value}")?;
        } else {
            self.out.write_all(&value.to_le_bytes())?;
        }
        Ok(())
    }

    fn end(&mut self) -> Result<(), Error> {
        if self.ascii {
            self.out.write_all(b"\n")?;
        }
        self.row_begun = false;
        Ok(())
    }
}

/// Writes a PLY file, with bytes where lists are short enough and indices of 32 bits.
pub(crate) fn encode(
    data: &MeshData,
    options: &WriteOptions,
    out: &mut dyn Write,
) -> Result<Vec<String>, Error> {
    let real = if options.single_precision { "float" } else { "double" };
    let bytes = data
        .colours
        .as_ref()
        .and_then(|colours| colours.iter().map(exact_bytes).collect::<Option<Vec<_>>>());
    let longest = data.faces.iter().map(<[u32]>::len).max().unwrap_or(0);
    // A list of texture coordinates is twice as long.
    let longest = if data.corner_uvs.is_some() { longest.saturating_mul(2) } else { longest };
    let short_lists = longest <= 255;
    // Some readers know no unsigned indices.
    let index = if i32::try_from(data.positions.len()).is_ok() { "int" } else { "uint" };

    let encoding = if options.ascii { "ascii" } else { "binary_little_endian" };
    let vertices = data.positions.len();
    write!(out, "ply\nformat {encoding} 1.0\nelement vertex {vertices}\n")?;
    let mut properties = |kind: &str, names: &[&str]| {
        names.iter().try_for_each(|name| writeln!(out, "property {kind} {name}"))
    };
    properties(real, &["x", "y", "z"])?;
    if data.normals.is_some() {
        properties(real, &["nx", "ny", "nz"])?;
    }
    if data.colours.is_some() {
        let kind = if bytes.is_some() { "uchar" } else { real };
        properties(kind, &["red", "green", "blue", "alpha"])?;
    }
    if data.uvs.is_some() {
        properties(real, &["s", "t"])?;
    }
    let length = if short_lists { "uchar" } else { "uint" };
    writeln!(out, "element face {}", data.faces.len())?;
    writeln!(out, "property list {length} {index} vertex_indices")?;
    if data.corner_uvs.is_some() {
        writeln!(out, "property list {length} {real} texcoord")?;
    }
    writeln!(out, "end_header")?;

    let mut rows = RowWriter {
        out,
        numbers: NumberWriter::new(options.single_precision),
        ascii: options.ascii,
        single: options.single_precision,
        row_begun: false,
    };
    write_vertices(data, bytes.as_deref(), &mut rows)?;
    write_faces(data, short_lists, &mut rows)?;
    Ok(left_out(
        &[
            (data.corner_normals.is_some(), NORMALS_PER_CORNER),
            (data.creases.is_some(), "crease tags"),
            (data.groups.is_some(), "groups"),
            (data.materials.is_some(), "materials"),
            (data.material_library.is_some(), "the material library"),
        ],
        "PLY",
    ))
}

fn write_vertices(
    data: &MeshData,
    bytes: Option<&[[u8; 4]]>,
    rows: &mut RowWriter<'_>,
) -> Result<(), Error> {
    for (i, &position) in data.positions.iter().enumerate() {
        <[f64; 3]>::from(position).into_iter().try_for_each(|x| rows.real(x))?;
        if let Some(normals) = &data.normals {
            <[f64; 3]>::from(normals[i]).into_iter().try_for_each(|x| rows.real(x))?;
        }
        if let Some(bytes) = bytes {
            bytes[i].into_iter().try_for_each(|b| rows.byte(b))?;
        } else if let Some(colours) = &data.colours {
            colours[i].into_iter().try_for_each(|c| rows.real(c))?;
        }
        if let Some(uvs) = &data.uvs {
            uvs[i].into_iter().try_for_each(|x| rows.real(x))?;
        }
        rows.end()?;
    }
    Ok(())
}

fn write_faces(data: &MeshData, short_lists: bool, rows: &mut RowWriter<'_>) -> Result<(), Error> {
    let mut corner = 0;
    for face in data.faces.iter() {
        let length = |rows: &mut RowWriter<'_>, n: usize| {
            if short_lists { rows.byte(n as u8) } else { rows.index(n as u32) }
        };
        length(rows, face.len())?;
        face.iter().try_for_each(|v| rows.index(*v))?;
        if let Some(uvs) = &data.corner_uvs {
            let uvs = &uvs[corner..corner + face.len()];
            length(rows, 2 * face.len())?;
            uvs.iter().flatten().try_for_each(|x| rows.real(*x))?;
        }
        corner += face.len();
        rows.end()?;
    }
    Ok(())
}
