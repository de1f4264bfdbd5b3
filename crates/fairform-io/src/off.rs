//! The Object File Format of Geomview: OFF with any of the prefixes ST, C and N.
//!
//! Read: vertices with normals, colours and texture coordinates, polygons of any size. Face colours
//! are left out. Comments and empty lines may stand anywhere, the word OFF may be missing, and the
//! whole file may be one line.
//!
//! Source: Geomview manual, section "OFF: the Object File Format".

use std::io::Write;
use std::mem::take;
use std::ops::Range;

use fairform::{FaceId, Faces, Vec3};

use crate::data::{
    MeshData, WriteOptions, all_exact_bytes, exact_bytes, join_faces, scale_large_colours,
    too_many_corners,
};
use crate::error::{Error, ParseError, Place};
use crate::format::{NORMALS_PER_CORNER, left_out};
use crate::lines::Lines;
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

/// The mesh in an OFF file. One that has a line for each vertex and face is read in so many parts; one
/// with a fault is read again as a whole, so that its error is that of a reader that sees all before.
pub(crate) fn parse(bytes: &[u8], part_count: usize) -> Result<MeshData, ParseError> {
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
    let lines = Lines::new(&text, part_count, true);
    let by_line = is_by_line(&lines, kind, vertex_count, face_count);
    let file = File { kind, by_line, vertex_count, face_count };
    if part_count > 1
        && lines.len() >= vertex_count + face_count
        && let Some(data) = file.in_parts(&lines)
    {
        return Ok(data);
    }
    file.as_whole(text)
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

/// Whether the file is cut into lines: there are enough of them, or the first vertex has one.
fn is_by_line(lines: &Lines<'_>, kind: Kind, vertices: usize, faces: usize) -> bool {
    if lines.len() >= vertices + faces {
        return true;
    }
    let Some(mut text) = lines.start(0).filter(|_| vertices > 0) else { return false };
    let plain = 3 + 3 * usize::from(kind.normals) + 2 * usize::from(kind.uvs);
    let colour = if kind.colours { 3..=4 } else { 0..=0 };
    let words = words_left(&mut text);
    words >= plain && colour.contains(&(words - plain))
}

/// How many words are left on this line. Goes to its end.
fn words_left(text: &mut Scanner<'_>) -> usize {
    let mut words = 0;
    while !text.is_at_line_end() {
        text.word();
        words += 1;
    }
    words
}

/// What is known of a file before its vertices are read.
#[derive(Clone, Copy)]
struct File {
    kind: Kind,
    /// Whether every vertex and face has a line of its own, so that more may stand on it.
    by_line: bool,
    vertex_count: usize,
    face_count: usize,
}

impl File {
    /// The mesh, whose vertices and faces are one on each line; `None` if there is a fault.
    fn in_parts(self, lines: &Lines<'_>) -> Option<MeshData> {
        let end = self.vertex_count + self.face_count;
        let vertices = lines
            .map(0..self.vertex_count, |text, rows| Reader { text, file: self }.vertices(rows));
        let vertices = Vertices::joined(vertices.into_iter().collect::<Result<_, _>>().ok()?);
        let faces = lines.map(self.vertex_count..end, |text, rows| {
            let rows = rows.start - self.vertex_count..rows.end - self.vertex_count;
            Reader { text, file: self }.faces(rows)
        });
        let (faces, coloured): (Vec<_>, Vec<_>) =
            faces.into_iter().collect::<Result<Vec<_>, _>>().ok()?.into_iter().unzip();
        let faces = (join_faces(faces).ok()?, coloured.into_iter().sum());
        Some(self.mesh(vertices, faces, lines.start(end)))
    }

    /// The mesh, read from the first vertex to the last face.
    fn as_whole(self, text: Scanner<'_>) -> Result<MeshData, ParseError> {
        let mut reader = Reader { text, file: self };
        let vertices = reader.vertices(0..self.vertex_count)?;
        let faces = reader.faces(0..self.face_count)?;
        reader.seek(true);
        let behind = (!reader.text.is_at_end()).then_some(reader.text);
        Ok(self.mesh(vertices, faces, behind))
    }

    /// The mesh of vertices, and faces of which some have colours. `behind` is at text that is left.
    fn mesh(
        self,
        vertices: Vertices,
        (faces, coloured): (Faces, usize),
        behind: Option<Scanner<'_>>,
    ) -> MeshData {
        let mut notes = Vec::new();
        if vertices.extra > 0 {
            let n = counted(vertices.extra, "vertex");
            notes.push(format!("more numbers than expected at {n}: left out"));
        }
        let mut colours = vertices.colours;
        let largest = colours.iter().flatten().fold(0.0, |a: f64, b: &f64| a.max(*b));
        if !vertices.fractions && largest > 1.0 {
            colours.iter_mut().flatten().for_each(|c| *c /= 255.0);
        } else {
            scale_large_colours(&mut colours, &mut notes);
        }
        if coloured > 0 {
            notes.push(format!("colours of {} left out", counted(coloured, "face")));
        }
        if let Some(text) = behind {
            let line = text.line_of(text.at);
            notes.push(format!("text from line {line} on, behind the last face, unread"));
        }
        MeshData {
            positions: vertices.positions,
            faces,
            normals: self.kind.normals.then_some(vertices.normals),
            colours: self.kind.colours.then_some(colours),
            uvs: self.kind.uvs.then_some(vertices.uvs),
            notes,
            ..MeshData::default()
        }
    }
}

/// Vertices that stand one behind the other in a file.
#[derive(Default)]
struct Vertices {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    colours: Vec<[f64; 4]>,
    uvs: Vec<[f64; 2]>,
    /// Whether a colour is not written as whole numbers.
    fractions: bool,
    /// How many have more numbers on their line.
    extra: usize,
}

impl Vertices {
    fn joined(mut parts: Vec<Self>) -> Self {
        Self {
            positions: par::join(parts.iter_mut().map(|part| take(&mut part.positions)).collect()),
            normals: par::join(parts.iter_mut().map(|part| take(&mut part.normals)).collect()),
            colours: par::join(parts.iter_mut().map(|part| take(&mut part.colours)).collect()),
            uvs: par::join(parts.iter_mut().map(|part| take(&mut part.uvs)).collect()),
            fractions: parts.iter().any(|part| part.fractions),
            extra: parts.iter().map(|part| part.extra).sum(),
        }
    }
}

/// Reads vertices and faces of a file, or of a part of it.
struct Reader<'a> {
    text: Scanner<'a>,
    file: File,
}

impl Reader<'_> {
    /// Goes to the next number, over line ends only where the line may end.
    fn seek(&mut self, may_cross_line: bool) {
        if may_cross_line || !self.file.by_line {
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

    /// Reads vertices, which the text is at.
    fn vertices(&mut self, rows: Range<usize>) -> Result<Vertices, ParseError> {
        let File { kind, by_line, vertex_count, .. } = self.file;
        let mut vertices = Vertices::default();
        vertices.positions.reserve_exact(rows.len());
        for done in rows {
            self.seek(true);
            self.check_end(done, vertex_count, "vertex")?;
            if let Err(error) = self.vertex(kind, &mut vertices) {
                // Cut in the middle of a vertex.
                self.check_end(done, vertex_count, "vertex")?;
                return Err(error);
            }
            if by_line && !self.text.is_at_line_end() {
                vertices.extra += 1;
                self.text.skip_line();
            }
        }
        Ok(vertices)
    }

    fn vertex(&mut self, kind: Kind, vertices: &mut Vertices) -> Result<(), ParseError> {
        let position: [f64; 3] = self.numbers()?;
        vertices.positions.push(position.into());
        if kind.normals {
            vertices.normals.push(Vec3::from(self.numbers::<3>()?));
        }
        if kind.colours {
            let from = self.text.at;
            vertices.colours.push(self.colour(kind)?);
            let written = &self.text.bytes[from..self.text.at];
            vertices.fractions |= written.iter().any(|b| matches!(b, b'.' | b'e' | b'E'));
        }
        if kind.uvs {
            vertices.uvs.push(self.numbers::<2>()?);
        }
        Ok(())
    }

    /// A colour of four numbers, or of three where the line says so; alpha is then full.
    fn colour(&mut self, kind: Kind) -> Result<[f64; 4], ParseError> {
        let [r, g, b] = self.numbers()?;
        if self.file.by_line {
            let mut rest = self.text;
            if words_left(&mut rest) == if kind.uvs { 2 } else { 0 } {
                // Of 3 numbers, none says whether they count to 1 or to 255.
                let full = if [r, g, b].iter().any(|c| *c > 1.0) { 255.0 } else { 1.0 };
                return Ok([r, g, b, full]);
            }
        }
        let [a] = self.numbers()?;
        Ok([r, g, b, a])
    }

    /// Reads faces, which the text is at, and says how many have colours.
    fn faces(&mut self, rows: Range<usize>) -> Result<(Faces, usize), ParseError> {
        let File { by_line, vertex_count: vertices, face_count: count, .. } = self.file;
        let mut faces = Faces::with_capacity(rows.len(), 0);
        let mut corners = Vec::new();
        let mut coloured = 0;
        for face in rows {
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
                return Err(too_many_corners(Place::Line(self.text.line_of(self.text.at))));
            }
            faces.push(&corners);
            if by_line && !self.text.is_at_line_end() {
                coloured += 1;
                self.text.skip_line();
            }
        }
        Ok((faces, coloured))
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
    for face in rows {
        let face = data.faces.get(FaceId(face as u32));
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether the text is read in parts, and not again.
    fn is_in_parts(text: &str, kind: Kind, [vertex_count, face_count]: [usize; 2]) -> bool {
        let mut text = Scanner { bytes: text.as_bytes(), at: 0 };
        text.skip_line();
        text.skip_line();
        let lines = Lines::new(&text, 5, true);
        File { kind, by_line: true, vertex_count, face_count }.in_parts(&lines).is_some()
    }

    #[test]
    fn a_line_each_is_read_in_parts() {
        let kind = Kind { colours: true, normals: true, uvs: true };
        let text = "STCNOFF\n4 3 0\n\n0 0 0 0 0 1 255 0 0 1 0\r\n# no vertex\n1 0 0 0 0 1 1 2 3 1 1 # one\n\
            \t1 1 0 0 0 1 0 0 0 0 0 7 8\n\n 0 1 0 0 0 1 9 9 9 0 0\n3 0 1 2\n0\n4 0 1 2 3 255 0 0\n\nbehind\n";
        assert!(is_in_parts(text, kind, [4, 3]));
        let whole = parse(text.as_bytes(), 1).unwrap();
        assert_eq!(whole.notes.len(), 3, "{:?}", whole.notes);
        assert_eq!(*whole.faces.starts(), [0, 3, 3, 7]);
        assert_eq!(whole.colours.as_ref().unwrap()[0], [1.0, 0.0, 0.0, 1.0]);
        for parts in 2..text.len() {
            assert_eq!(parse(text.as_bytes(), parts).as_ref(), Ok(&whole), "{parts} parts");
        }
        assert!(!is_in_parts(&text.replace("4 0 1 2 3", "4 0 1\n2 3"), kind, [4, 3]));
    }
}
