//! The Object File Format of Geomview: OFF with any of the prefixes ST, C and N.
//!
//! Read: vertices with normals, colours and texture coordinates, polygons of any size. Face colours
//! are left out. Comments and empty lines may stand anywhere, the word OFF may be missing, and the
//! whole file may be one line.
//!
//! Source: Geomview manual, section "OFF: the Object File Format".

use std::io::Write;
use std::ops::Range;

use fairform::{Faces, Vec3};

use crate::data::{
    MeshData, WriteOptions, all_exact_bytes, exact_bytes, push_face, scale_large_colours,
};
use crate::error::{Error, ParseError, Place};
use crate::format::{NORMALS_PER_CORNER, left_out};
use crate::par;
use crate::stream::{Attributes, Checked, Shape};
use crate::text::{NumberWriter, ROWS, Scanner, counted, quoted};

/// What the first word says about the vertices.
#[derive(Clone, Copy, Default)]
struct Kind {
    normals: bool,
    colours: bool,
    uvs: bool,
}

/// The mesh in an OFF file.
pub(crate) fn parse(bytes: &[u8]) -> Result<MeshData, ParseError> {
    let mut text = Scanner::new(bytes)?;
    let kind = read_kind(&mut text)?;
    let (vertex_count, face_count) = read_counts(&mut text)?;
    // Every number takes a byte and what parts it from the next.
    let numbers = vertex_count.saturating_mul(3).saturating_add(face_count);
    if numbers > (text.remaining() as u64).div_ceil(2) {
        return Err(text.error(format!(
            "the file declares {vertex_count} vertices and {face_count} faces, more than its {} \
             bytes can hold",
            bytes.len()
        )));
    }
    let (vertex_count, face_count) = (vertex_count as usize, face_count as usize);
    let mut reader = Reader { by_line: true, text, data: MeshData::default() };
    reader.by_line = reader.is_by_line(kind, vertex_count, face_count);
    reader.vertices(kind, vertex_count)?;
    reader.faces(face_count)?;
    Ok(reader.data)
}

/// Reads the first word, if it is no number.
fn read_kind(text: &mut Scanner<'_>) -> Result<Kind, ParseError> {
    text.skip_space_and_comments();
    let at = text.at;
    let word = text.word();
    if word.first().is_none_or(|b| b.is_ascii_digit() || matches!(b, b'+' | b'-')) {
        text.at = at;
        return Ok(Kind::default());
    }
    let start = *text;
    let wrong = |message: String| {
        Err(start.error_at(at, message).expected("OFF, COFF, NOFF, STOFF or a vertex count"))
    };
    let Some(mut letters) = word.strip_suffix(b"OFF").or_else(|| word.strip_suffix(b"off")) else {
        return wrong(format!("found {}", quoted(word)));
    };
    let mut kind = Kind::default();
    while let Some((&letter, rest)) = letters.split_first() {
        letters = rest;
        match (letter, rest.first()) {
            (b'S' | b's', Some(b'T' | b't')) => {
                kind.uvs = true;
                letters = &rest[1..];
            }
            (b'C' | b'c', _) => kind.colours = true,
            (b'N', _) => kind.normals = true,
            (b'4' | b'n', _) => {
                return wrong(format!(
                    "{}: only vertices with 3 coordinates are read",
                    quoted(word)
                ));
            }
            _ => return wrong(format!("found {}", quoted(word))),
        }
    }
    let behind = text.at;
    if text.word().eq_ignore_ascii_case(b"BINARY") {
        return wrong("binary OFF is not read".into());
    }
    text.at = behind;
    Ok(kind)
}

/// Reads the numbers of vertices, faces and edges; the last may be missing.
fn read_counts(text: &mut Scanner<'_>) -> Result<(u64, u64), ParseError> {
    text.skip_space_and_comments();
    let vertices = text.count("a vertex count")?;
    let one_line = !text.is_at_line_end();
    text.skip_space_and_comments();
    let faces = text.count("a face count")?;
    if !text.is_at_line_end() {
        text.count("an edge count")?;
    } else if !one_line {
        // Counts on lines of their own: the next is the edge count if it is alone there too.
        let before = *text;
        text.skip_space_and_comments();
        if text.count("").is_err() || !text.is_at_line_end() {
            *text = before;
        }
    }
    Ok((vertices, faces))
}

struct Reader<'a> {
    text: Scanner<'a>,
    /// Whether every vertex and face has a line of its own, so that more may stand on it.
    by_line: bool,
    data: MeshData,
}

impl Reader<'_> {
    /// Whether the file is cut into lines: there are enough of them, or the first vertex has one.
    fn is_by_line(&self, kind: Kind, vertices: usize, faces: usize) -> bool {
        let mut text = self.text;
        let mut lines = 0;
        let mut first_line = None;
        while lines < vertices + faces {
            text.skip_space_and_comments();
            if text.is_at_end() {
                break;
            }
            let mut words = 0;
            if first_line.is_none() {
                while !text.is_at_line_end() {
                    text.word();
                    words += 1;
                }
            }
            first_line.get_or_insert(words);
            text.skip_line();
            lines += 1;
        }
        let plain = 3 + 3 * usize::from(kind.normals) + 2 * usize::from(kind.uvs);
        let colour = if kind.colours { 3..=4 } else { 0..=0 };
        lines >= vertices + faces
            || vertices > 0
                && first_line.is_some_and(|n| n >= plain && colour.contains(&(n - plain)))
    }

    /// Goes to the next number, over line ends only where the line may end.
    fn seek(&mut self, may_cross_line: bool) {
        if may_cross_line || !self.by_line {
            self.text.skip_space_and_comments();
        } else {
            self.text.skip_blanks();
        }
    }

    /// An error if the file ends here, before `done` of `count` things were read.
    fn check_end(&self, done: usize, count: usize, what: &str) -> Result<(), ParseError> {
        if self.text.is_at_end() {
            let declared = counted(count, what);
            let message = format!("the file declares {declared} and ends after {done}");
            return Err(self.text.error(message));
        }
        Ok(())
    }

    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], ParseError> {
        let mut values = [0.0; N];
        for value in &mut values {
            self.seek(false);
            *value = self.text.number()?;
        }
        Ok(values)
    }

    fn vertices(&mut self, kind: Kind, count: usize) -> Result<(), ParseError> {
        let mut colours = Vec::new();
        let mut normals = Vec::new();
        let mut uvs = Vec::new();
        let mut whole_colours = true;
        let mut extra = 0;
        self.data.positions.reserve_exact(count);
        for done in 0..count {
            self.seek(true);
            self.check_end(done, count, "vertex")?;
            let mut read = || -> Result<(), ParseError> {
                let position: [f64; 3] = self.numbers()?;
                self.data.positions.push(position.into());
                if kind.normals {
                    normals.push(Vec3::from(self.numbers::<3>()?));
                }
                if kind.colours {
                    let from = self.text.at;
                    colours.push(self.colour(kind)?);
                    let written = &self.text.bytes[from..self.text.at];
                    whole_colours &= !written.iter().any(|b| matches!(b, b'.' | b'e' | b'E'));
                }
                if kind.uvs {
                    uvs.push(self.numbers::<2>()?);
                }
                Ok(())
            };
            if let Err(error) = read() {
                // Cut in the middle of a vertex.
                self.check_end(done, count, "vertex")?;
                return Err(error);
            }
            if self.by_line && !self.text.is_at_line_end() {
                extra += 1;
                self.text.skip_line();
            }
        }
        if extra > 0 {
            let n = counted(extra, "vertex");
            self.data.notes.push(format!("more numbers than expected at {n}: left out"));
        }
        if kind.colours {
            let largest = colours.iter().flatten().fold(0.0, |a: f64, b: &f64| a.max(*b));
            if whole_colours && largest > 1.0 {
                colours.iter_mut().flatten().for_each(|c| *c /= 255.0);
            } else {
                scale_large_colours(&mut colours, &mut self.data.notes);
            }
            self.data.colours = Some(colours);
        }
        self.data.normals = kind.normals.then_some(normals);
        self.data.uvs = kind.uvs.then_some(uvs);
        Ok(())
    }

    /// A colour of four numbers, or of three where the line says so; alpha is then full.
    fn colour(&mut self, kind: Kind) -> Result<[f64; 4], ParseError> {
        let [r, g, b] = self.numbers()?;
        if self.by_line {
            let mut rest = self.text;
            let mut left = 0;
            while !rest.is_at_line_end() {
                rest.word();
                left += 1;
            }
            if left == if kind.uvs { 2 } else { 0 } {
                // Of 3 numbers, none says whether they count to 1 or to 255.
                let full = if [r, g, b].iter().any(|c| *c > 1.0) { 255.0 } else { 1.0 };
                return Ok([r, g, b, full]);
            }
        }
        let [a] = self.numbers()?;
        Ok([r, g, b, a])
    }

    fn faces(&mut self, count: usize) -> Result<(), ParseError> {
        let vertices = self.data.positions.len();
        let mut faces = Faces::with_capacity(count, 0);
        let mut corners = Vec::new();
        let mut coloured = 0;
        for face in 0..count {
            self.seek(true);
            self.check_end(face, count, "face")?;
            let size = self.text.count("a corner count")?;
            if size > (self.text.remaining() as u64).div_ceil(2) {
                let message = format!("face {face} of {size} corners, more than the file can hold");
                return Err(self.text.error(message));
            }
            corners.clear();
            for _ in 0..size {
                self.seek(false);
                if self.text.is_at_end() {
                    self.check_end(face, count, "face")?;
                }
                let at = self.text.at;
                let vertex = self.text.integer("a vertex index")?;
                match u32::try_from(vertex) {
                    Ok(v) if (v as usize) < vertices => corners.push(v),
                    _ => {
                        let message = format!(
                            "face {face} lists vertex {vertex}, but the mesh has {vertices} \
                             vertices, counted from 0"
                        );
                        return Err(self.text.error_at(at, message));
                    }
                }
            }
            if faces.corners().len() + corners.len() > u32::MAX as usize {
                let place = Place::Line(self.text.line_of(self.text.at));
                return push_face(&mut faces, &corners, place);
            }
            faces.push(&corners);
            if self.by_line && !self.text.is_at_line_end() {
                coloured += 1;
                self.text.skip_line();
            }
        }
        self.data.faces = faces;
        if coloured > 0 {
            let n = counted(coloured, "face");
            self.data.notes.push(format!("colours of {n} left out"));
        }
        self.seek(true);
        if !self.text.is_at_end() {
            let line = self.text.line_of(self.text.at);
            self.data.notes.push(format!("text from line {line} on, behind the last face, unread"));
        }
        Ok(())
    }
}

/// Writes an OFF file.
pub(crate) fn encode(
    data: &MeshData,
    options: &WriteOptions,
    out: &mut dyn Write,
) -> Result<Vec<String>, Error> {
    let shape = Shape::of(data);
    write_header(&shape, out)?;
    let bytes = data.colours.as_deref().and_then(byte_colours);
    par::write_rows(out, data.positions.len(), ROWS, |rows, out| {
        vertex_rows(data, bytes.as_deref(), options.single_precision, rows, out);
    })?;
    par::write_rows(out, data.faces.len(), ROWS, |rows, out| face_rows(data, rows, out))?;
    Ok(notes(&shape))
}

/// As [`encode`], of a mesh that is made meanwhile.
pub(crate) fn encode_blocks(
    blocks: &Checked<'_>,
    options: &WriteOptions,
    out: &mut dyn Write,
) -> Result<Vec<String>, Error> {
    let shape = &blocks.shape;
    write_header(shape, out)?;
    let as_bytes = blocks.all_colours(|c| exact_bytes(c).is_some())
        && !blocks.all_colours(|c| exact_bytes(c).is_none_or(|b| b.iter().all(|b| *b <= 1)));
    blocks.write_vertices(out, Attributes::of(shape), |data, out| {
        let bytes = data.colours.as_deref().filter(|_| as_bytes).and_then(all_exact_bytes);
        vertex_rows(data, bytes.as_deref(), options.single_precision, 0..data.positions.len(), out);
    })?;
    blocks.write_faces(out, |data, _, out| face_rows(data, 0..data.faces.len(), out))?;
    Ok(notes(shape))
}

fn write_header(shape: &Shape<'_>, out: &mut dyn Write) -> Result<(), Error> {
    let prefix = |has: bool, letters: &'static str| if has { letters } else { "" };
    let (st, c, n) =
        (prefix(shape.uvs, "ST"), prefix(shape.colours, "C"), prefix(shape.normals, "N"));
    writeln!(out, "{st}{c}{n}OFF")?;
    writeln!(out, "{} {} 0", shape.vertex_count, shape.face_count)?;
    Ok(())
}

fn notes(shape: &Shape<'_>) -> Vec<String> {
    left_out(
        &[
            (shape.corner_normals, NORMALS_PER_CORNER),
            (shape.creases, "crease tags"),
            (shape.corner_uvs, "texture coordinates per corner"),
            (shape.groups.is_some(), "groups"),
            (shape.materials.is_some(), "materials"),
            (shape.material_library.is_some(), "the material library"),
        ],
        "OFF",
    )
}

/// Appends the lines of some vertices.
fn vertex_rows(
    data: &MeshData,
    bytes: Option<&[[u8; 4]]>,
    single: bool,
    rows: Range<usize>,
    out: &mut Vec<u8>,
) {
    let mut numbers = NumberWriter::new(single);
    for i in rows {
        let p = data.positions[i];
        numbers.write(out, p.x);
        numbers.write_all(out, &[p.y, p.z]);
        if let Some(normals) = &data.normals {
            numbers.write_all(out, &<[f64; 3]>::from(normals[i]));
        }
        if let Some(bytes) = bytes {
            for byte in bytes[i] {
                out.push(b' ');
                numbers.whole(out, byte.into());
            }
        } else if let Some(colours) = &data.colours {
            write_fractions(out, &mut numbers, &colours[i]);
        }
        if let Some(uvs) = &data.uvs {
            numbers.write_all(out, &uvs[i]);
        }
        out.push(b'\n');
    }
}

/// Appends the lines of some faces.
fn face_rows(data: &MeshData, rows: Range<usize>, out: &mut Vec<u8>) {
    let mut numbers = NumberWriter::new(false);
    let (start, corners) = (data.faces.starts(), data.faces.corners());
    for face in rows {
        let face = &corners[start[face] as usize..start[face + 1] as usize];
        numbers.whole(out, face.len() as u64);
        for &v in face {
            out.push(b' ');
            numbers.whole(out, v.into());
        }
        out.push(b'\n');
    }
}

/// All colours as bytes, if they are some, and a reader can tell: one is above 1.
fn byte_colours(colours: &[[f64; 4]]) -> Option<Vec<[u8; 4]>> {
    let bytes = all_exact_bytes(colours)?;
    bytes.iter().flatten().any(|b| *b > 1).then_some(bytes)
}

/// Writes fractions with a point, so that a reader can tell them from bytes.
fn write_fractions(out: &mut Vec<u8>, numbers: &mut NumberWriter, values: &[f64; 4]) {
    for &value in values {
        numbers.write_all(out, &[value]);
        // Larger ones have an exponent.
        if value.fract() == 0.0 && value.abs() < 1e6 {
            out.extend_from_slice(b".0");
        }
    }
}
