//! The Stanford polygon file, as text or binary in either byte order.
//!
//! Read: `vertex` with coordinates, normals, colours and texture coordinates in any order and of
//! any type, `face` with `vertex_indices` and `texcoord`, `tristrips`. Other elements and
//! properties are skipped by their declared types. The elements may come in any order.
//!
//! Source: Greg Turk, *The PLY Polygon File Format*, 1994.

mod body;
mod header;
mod writer;

use std::mem::take;
use std::ops::Range;

use bytemuck::Zeroable;
use fairform::{Faces, Vec3};

use crate::data::{MeshData, join_faces, push_face, scale_large_colours, too_many_corners};
use crate::error::{ParseError, Place};
use crate::par;
use crate::text::{Scanner, counted, quoted};
use body::{AsciiBody, BinaryBody, Body, END, Rows};
use header::{Element, Encoding, Property, Scalar, read_header};

pub(crate) use writer::{encode, encode_blocks};

/// The mesh in a PLY file. A text that has a line for each row is read in so many parts; one with a
/// fault is read again as a whole, so that its error is that of a reader that sees all before.
pub(crate) fn parse(bytes: &[u8], part_count: usize) -> Result<MeshData, ParseError> {
    let mut text = Scanner::new(bytes)?;
    let (encoding, elements) = read_header(&mut text)?;
    match encoding {
        Encoding::Ascii => {
            if part_count > 1
                && let Ok(data) = read(AsciiBody::in_parts(text, part_count), &elements)
            {
                return Ok(data);
            }
            read(AsciiBody::new(text), &elements)
        }
        Encoding::Little => read(BinaryBody::<false> { bytes, at: text.at }, &elements),
        Encoding::Big => read(BinaryBody::<true> { bytes, at: text.at }, &elements),
    }
}

fn read<B: Body>(mut body: B, elements: &[Element<'_>]) -> Result<MeshData, ParseError> {
    let vertex_count = elements.iter().find(|e| e.name == b"vertex").map_or(0, |e| e.count);
    let mut reader = Reader { data: MeshData::default(), vertex_count };
    reader.elements(&mut body, elements)?;
    let left = body.left();
    if left > 0 {
        let n = counted(left, "byte");
        reader.data.notes.push(format!("{n} behind the last element unread"));
    }
    Ok(reader.data)
}

/// What the properties of a vertex mean.
struct VertexColumns {
    position: [usize; 3],
    normal: Option<[usize; 3]>,
    colour: Option<([usize; 3], Option<usize>)>,
    uv: Option<[usize; 2]>,
}

impl VertexColumns {
    fn new(element: &Element<'_>) -> Result<Self, ParseError> {
        let scalar =
            |names: &[&str]| element.find(names).filter(|i| element.properties[*i].count.is_none());
        let need = |name: &str| {
            scalar(&[name]).ok_or_else(|| {
                ParseError::file(format!("element vertex has no property {name}"))
                    .expected("x, y and z")
            })
        };
        let all =
            |names: [&[&str]; 3]| Some([scalar(names[0])?, scalar(names[1])?, scalar(names[2])?]);
        let pair = |[s, t]: [&str; 2]| Some([scalar(&[s])?, scalar(&[t])?]);
        Ok(Self {
            position: [need("x")?, need("y")?, need("z")?],
            normal: all([&["nx"], &["ny"], &["nz"]]),
            colour: all([
                &["red", "diffuse_red", "r"],
                &["green", "diffuse_green", "g"],
                &["blue", "diffuse_blue", "b"],
            ])
            .map(|rgb| (rgb, scalar(&["alpha", "diffuse_alpha", "a"]))),
            uv: [["s", "t"], ["u", "v"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]]
                .into_iter()
                .find_map(pair),
        })
    }
}

impl MeshData {
    /// Takes vertices from rows of bytes.
    fn take_columns(&mut self, columns: &VertexColumns, element: &Element<'_>, rows: &Rows<'_>) {
        let mut place = Vec::with_capacity(element.properties.len());
        let mut offset = 0;
        for property in &element.properties {
            place.push((property.scalar, offset));
            offset += property.scalar.size();
        }
        let all = [Some(columns.position), columns.normal];
        let [positions, normals] =
            all.map(|at| Some(bytemuck::cast_vec(rows.columns(at?.map(|i| place[i])))));
        self.positions = positions.unwrap_or_default();
        self.normals = normals;
        self.uvs = columns.uv.map(|at| rows.columns(at.map(|i| place[i])));
        self.colours = columns.colour.map(|([r, g, b], alpha)| {
            // Where there is no alpha, any number in its place.
            let at = [r, g, b, alpha.unwrap_or(r)];
            let full = at.map(|i| place[i].0.full());
            let mut colours = rows.columns(at.map(|i| place[i]));
            for colour in &mut colours {
                for (value, full) in colour.iter_mut().zip(full) {
                    *value /= full;
                }
                if alpha.is_none() {
                    colour[3] = 1.0;
                }
            }
            colours
        });
    }
}

struct Reader {
    data: MeshData,
    vertex_count: u64,
}

/// Faces that stand one behind the other in a file.
struct FaceRows {
    faces: Faces,
    /// Texture coordinates of their corners, if they are read, and how many faces have none.
    uvs: Vec<[f64; 2]>,
    without_uvs: usize,
}

impl Reader {
    fn elements<B: Body>(
        &mut self,
        body: &mut B,
        elements: &[Element<'_>],
    ) -> Result<(), ParseError> {
        for element in elements {
            body.check(element)?;
            match element.name {
                b"vertex" => self.vertices(body, element)?,
                b"face" => self.faces(body, element)?,
                b"tristrips" => self.strips(body, element)?,
                _ => Self::skip(body, element)?,
            }
        }
        Ok(())
    }

    /// Reads some rows of an element one after the other.
    fn rows<B: Body>(
        body: &mut B,
        element: &Element<'_>,
        rows: Range<u64>,
        mut row: impl FnMut(&mut B, u64) -> Result<(), ParseError>,
    ) -> Result<(), ParseError> {
        if element.properties.is_empty() {
            return Ok(());
        }
        for done in rows {
            body.begin_row();
            let result = if body.is_at_end() {
                Err(ParseError::file(END))
            } else {
                row(body, done).and_then(|()| body.end_row())
            };
            if let Err(error) = result {
                // Cut in a row: say how many rows there are.
                if let Some(how) = error.message.strip_prefix(END) {
                    let declared = element.counted(element.count);
                    let message = format!(
                        "the file declares {declared} and ends after {done}{}",
                        how.trim_start_matches(" here")
                    );
                    return Err(ParseError::new(body.place(body.offset()), message));
                }
                return Err(error);
            }
        }
        Ok(())
    }

    fn skip_property<B: Body>(body: &mut B, property: &Property<'_>) -> Result<(), ParseError> {
        let count = match property.count {
            Some(_) => body.length(property)?,
            None => 1,
        };
        body.skip(property.scalar, count)
    }

    fn skip<B: Body>(body: &mut B, element: &Element<'_>) -> Result<(), ParseError> {
        if body.rows(element).is_some() {
            return Ok(());
        }
        let parts = body.gather(element, |body, rows| {
            Self::rows(body, element, rows, |body, _| {
                element.properties.iter().try_for_each(|p| Self::skip_property(body, p))
            })
        });
        parts.map(drop)
    }

    fn vertices<B: Body>(&mut self, body: &mut B, element: &Element<'_>) -> Result<(), ParseError> {
        let columns = VertexColumns::new(element)?;
        if let Some(rows) = body.rows(element) {
            self.data.take_columns(&columns, element, &rows);
        } else {
            let read = |body: &mut B, rows| Self::vertex_rows(&columns, body, element, rows);
            self.take_parts(body.gather(element, read)?);
        }
        if let Some(colours) = &mut self.data.colours {
            scale_large_colours(colours, &mut self.data.notes);
        }
        Ok(())
    }

    /// Takes vertices that stand one behind the other.
    fn take_parts(&mut self, mut parts: Vec<MeshData>) {
        fn all<T: Zeroable + Copy + Send + Sync>(
            parts: &mut [MeshData],
            values: impl Fn(&mut MeshData) -> Option<Vec<T>>,
        ) -> Option<Vec<T>> {
            parts.iter_mut().map(values).collect::<Option<Vec<_>>>().map(par::join)
        }
        let positions = all(&mut parts, |part| Some(take(&mut part.positions)));
        self.data.positions = positions.unwrap_or_default();
        self.data.normals = all(&mut parts, |part| part.normals.take());
        self.data.colours = all(&mut parts, |part| part.colours.take());
        self.data.uvs = all(&mut parts, |part| part.uvs.take());
    }

    /// Reads some vertices one after the other.
    fn vertex_rows<B: Body>(
        columns: &VertexColumns,
        body: &mut B,
        element: &Element<'_>,
        rows: Range<u64>,
    ) -> Result<MeshData, ParseError> {
        let mut data = MeshData::default();
        // `check` compared the count with the bytes, unless there are lists.
        let room = if element.has_lists() { 0 } else { (rows.end - rows.start) as usize };
        data.positions.reserve_exact(room);
        data.normals = columns.normal.map(|_| Vec::with_capacity(room));
        data.colours = columns.colour.map(|_| Vec::with_capacity(room));
        data.uvs = columns.uv.map(|_| Vec::with_capacity(room));
        let full: Vec<_> = element.properties.iter().map(|p| p.scalar.full()).collect();
        let mut values = vec![0.0; element.properties.len()];
        Self::rows(body, element, rows, |body, _| {
            for (value, property) in values.iter_mut().zip(&element.properties) {
                if property.count.is_some() {
                    Self::skip_property(body, property)?;
                } else {
                    *value = body.number(property.scalar)?;
                }
            }
            let vec3 = |[x, y, z]: [usize; 3]| Vec3::new(values[x], values[y], values[z]);
            data.positions.push(vec3(columns.position));
            if let (Some(at), Some(normals)) = (columns.normal, &mut data.normals) {
                normals.push(vec3(at));
            }
            if let (Some((rgb, alpha)), Some(colours)) = (columns.colour, &mut data.colours) {
                let part = |i: usize| values[i] / full[i];
                let [r, g, b] = rgb.map(part);
                colours.push([r, g, b, alpha.map_or(1.0, part)]);
            }
            if let (Some(at), Some(uvs)) = (columns.uv, &mut data.uvs) {
                uvs.push(at.map(|i| values[i]));
            }
            Ok(())
        })?;
        Ok(data)
    }

    /// The property of an element that lists vertices, if there is one and it holds whole numbers.
    fn index_list(element: &Element<'_>) -> Result<Option<usize>, ParseError> {
        let Some(list) = element.find(&["vertex_indices", "vertex_index"]) else {
            return Ok(None);
        };
        let property = &element.properties[list];
        if property.count.is_none() || property.scalar.is_float() {
            let message = format!(
                "{} of {} is no list of whole numbers",
                quoted(property.name),
                quoted(element.name)
            );
            return Err(ParseError::file(message).expected("list uchar int"));
        }
        Ok(Some(list))
    }

    /// The vertex of an index in the list at an offset.
    fn vertex<B: Body>(
        &self,
        body: &B,
        index: i64,
        list_at: usize,
        (name, row): (&str, u64),
    ) -> Result<u32, ParseError> {
        match u32::try_from(index) {
            Ok(v) if u64::from(v) < self.vertex_count => Ok(v),
            _ => {
                let message = format!(
                    "{name} {row} lists vertex {index}, but the mesh has {} vertices, counted \
                     from 0",
                    self.vertex_count
                );
                Err(ParseError::new(body.place(list_at), message))
            }
        }
    }

    fn faces<B: Body>(&mut self, body: &mut B, element: &Element<'_>) -> Result<(), ParseError> {
        let Some(list) = Self::index_list(element)? else {
            if element.count > 0 {
                let message = "element face has no list of vertices";
                return Err(ParseError::file(message).expected("vertex_indices"));
            }
            return Self::skip(body, element);
        };
        if let Some((faces, length)) = self.uniform_faces(body, element) {
            body.advance(length);
            return self.append(faces, Place::File);
        }
        let texcoord = element
            .find(&["texcoord"])
            .filter(|i| element.properties[*i].count.is_some() && *i != list);
        let read = |body: &mut B, rows| self.face_rows([Some(list), texcoord], body, element, rows);
        let parts = body.gather(element, read)?;
        let without_uvs = parts.iter().map(|part| part.without_uvs).sum();
        let (faces, mut uvs): (Vec<_>, Vec<_>) =
            parts.into_iter().map(|part| (part.faces, part.uvs)).unzip();
        let faces = join_faces(faces)?;
        if texcoord.is_some() && without_uvs < faces.len() {
            // Triangles of strips may stand before.
            let before = self.data.faces.corners().len();
            if before > 0 {
                uvs.insert(0, vec![[0.0; 2]; before]);
            }
            self.data.corner_uvs = Some(par::join(uvs));
            if without_uvs > 0 {
                let n = counted(without_uvs, "face");
                self.data.notes.push(format!("{n} without texture coordinates have 0 0"));
            }
        }
        if element.find(&["red", "r", "diffuse_red"]).is_some() {
            self.data.notes.push("colours of faces left out".into());
        }
        self.append(faces, Place::File)
    }

    /// Reads some faces one after the other: the properties with their vertices and their texture
    /// coordinates.
    fn face_rows<B: Body>(
        &self,
        [list, texcoord]: [Option<usize>; 2],
        body: &mut B,
        element: &Element<'_>,
        rows: Range<u64>,
    ) -> Result<FaceRows, ParseError> {
        let mut part = FaceRows { faces: Faces::new(), uvs: Vec::new(), without_uvs: 0 };
        let mut corners = Vec::new();
        let mut numbers = Vec::new();
        Self::rows(body, element, rows, |body, face| {
            numbers.clear();
            let mut list_at = 0;
            for (i, property) in element.properties.iter().enumerate() {
                if Some(i) == list {
                    list_at = body.offset();
                    corners.clear();
                    for _ in 0..body.length(property)? {
                        let index = body.integer(property.scalar)?;
                        corners.push(self.vertex(body, index, list_at, ("face", face))?);
                    }
                } else if Some(i) == texcoord {
                    for _ in 0..body.length(property)? {
                        numbers.push(body.number(property.scalar)?);
                    }
                } else {
                    Self::skip_property(body, property)?;
                }
            }
            if texcoord.is_some() {
                if numbers.len() == 2 * corners.len() {
                    part.uvs.extend(numbers.chunks_exact(2).map(|uv| [uv[0], uv[1]]));
                } else {
                    part.without_uvs += 1;
                    part.uvs.resize(part.uvs.len() + corners.len(), [0.0; 2]);
                }
            }
            if part.faces.corners().len() + corners.len() > u32::MAX as usize {
                return Err(too_many_corners(body.place(list_at)));
            }
            part.faces.push(&corners);
            Ok(())
        })?;
        Ok(part)
    }

    /// The faces of an element, and the bytes that they take, if each is a list of as many indices as
    /// the first, of a usual type and in range, and nothing more.
    fn uniform_faces<B: Body>(&self, body: &B, element: &Element<'_>) -> Option<(Faces, usize)> {
        const BLOCK: usize = 1 << 14;
        let [list] = element.properties.as_slice() else { return None };
        let usual = match list.scalar {
            Scalar::U32 => true,
            // A negative one is large as an unsigned one.
            Scalar::I32 => self.vertex_count <= 1 << 31,
            _ => false,
        };
        let usual = usual && list.count == Some(Scalar::U8);
        let bytes = body.little().filter(|_| usual)?;
        let size = *bytes.first().filter(|size| **size > 0)?;
        let (count, corners) = (usize::try_from(element.count).ok()?, usize::from(size));
        let length = count.checked_mul(1 + 4 * corners)?;
        let rows = bytes.get(..length)?;
        if count * corners > u32::MAX as usize {
            return None;
        }
        let mut all: Vec<u32> = bytemuck::zeroed_vec(count * corners);
        let tasks = all.chunks_mut(BLOCK * corners).zip(rows.chunks(BLOCK * (1 + 4 * corners)));
        par::map(tasks, |(out, rows)| {
            let mut good = true;
            for (face, row) in out.chunks_exact_mut(corners).zip(rows.chunks_exact(1 + 4 * corners))
            {
                good &= row[0] == size;
                for (corner, index) in face.iter_mut().zip(row[1..].as_chunks::<4>().0) {
                    *corner = u32::from_le_bytes(*index);
                    good &= u64::from(*corner) < self.vertex_count;
                }
            }
            good
        })
        .into_iter()
        .all(|good| good)
        .then(|| (Faces::uniform(u32::from(size), all), length))
    }

    /// Reads triangle strips, which −1 parts and whose every other triangle turns over.
    fn strips<B: Body>(&mut self, body: &mut B, element: &Element<'_>) -> Result<(), ParseError> {
        let Some(list) = Self::index_list(element)? else {
            return Self::skip(body, element);
        };
        let read = |body: &mut B, rows| self.strip_rows(list, body, element, rows);
        let faces = join_faces(body.gather(element, read)?)?;
        let (n, strips) =
            (counted(faces.len(), "triangle"), counted(element.count as usize, "strip"));
        self.data.notes.push(format!("{n} made from {strips}"));
        self.append(faces, Place::File)
    }

    fn strip_rows<B: Body>(
        &self,
        list: usize,
        body: &mut B,
        element: &Element<'_>,
        rows: Range<u64>,
    ) -> Result<Faces, ParseError> {
        let mut faces = Faces::new();
        Self::rows(body, element, rows, |body, strip| {
            for (i, property) in element.properties.iter().enumerate() {
                if i != list {
                    Self::skip_property(body, property)?;
                    continue;
                }
                let list_at = body.offset();
                let mut last = [0; 2];
                let mut length = 0;
                for _ in 0..body.length(property)? {
                    let index = body.integer(property.scalar)?;
                    // Written as an unsigned number −1 is the largest.
                    if index == -1 || index == i64::from(u32::MAX) {
                        length = 0;
                        continue;
                    }
                    let v = self.vertex(body, index, list_at, ("strip", strip))?;
                    let [a, b] = last;
                    if length >= 2 {
                        let triangle = if length % 2 == 0 { [a, b, v] } else { [b, a, v] };
                        // Strips repeat a vertex to turn.
                        if a != b && b != v && v != a {
                            push_face(&mut faces, &triangle, Place::File)?;
                        }
                    }
                    last = [b, v];
                    length += 1;
                }
            }
            Ok(())
        })?;
        Ok(faces)
    }

    /// Adds faces behind those already read.
    fn append(&mut self, faces: Faces, place: Place) -> Result<(), ParseError> {
        if self.data.faces.is_empty() {
            self.data.faces = faces;
            return Ok(());
        }
        for face in faces.iter() {
            push_face(&mut self.data.faces, face, place)?;
        }
        // Strips have no texture coordinates per corner.
        if let Some(uvs) = &mut self.data.corner_uvs {
            uvs.resize(self.data.faces.corners().len(), [0.0; 2]);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A binary file of `vertex_count` vertices and faces, each with a byte behind or without.
    fn file(vertex_count: u32, faces: &[&[i32]], behind: bool) -> Vec<u8> {
        let property = if behind { "property uchar flag\n" } else { "" };
        let mut bytes = format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {vertex_count}\nproperty float z\n\
             property double x\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
             property short y\nelement face {}\nproperty list uchar int vertex_indices\n{property}\
             end_header\n",
            faces.len()
        )
        .into_bytes();
        for i in 0..vertex_count {
            bytes.extend((0.5 * i as f32).to_le_bytes());
            bytes.extend((0.1 * f64::from(i)).to_le_bytes());
            bytes.extend([255, 0, 51, i as u8, 0xff]);
        }
        for face in faces {
            bytes.push(face.len() as u8);
            bytes.extend(face.iter().flat_map(|v| v.to_le_bytes()));
            bytes.extend(behind.then_some(7));
        }
        bytes
    }

    #[test]
    fn faces_of_one_size_are_read_as_any() {
        let cases: [&[&[i32]]; 6] = [
            &[&[0, 1, 2], &[2, 1, 3]],
            &[&[0, 1, 2, 3]],
            &[&[0, 1, 2], &[2, 1, 3, 0], &[1, 2, 3]],
            &[&[], &[0, 1, 2]],
            &[&[0, 1, 2], &[2, 1, 4]],
            &[&[0, 1, 2], &[2, 1, -1]],
        ];
        for faces in cases {
            let plain = parse(&file(4, faces, false), 1);
            let general = parse(&file(4, faces, true), 1);
            match (plain, general) {
                (Ok(plain), Ok(general)) => {
                    assert_eq!(plain, general);
                    let expected: Vec<Vec<u32>> =
                        faces.iter().map(|f| f.iter().map(|v| *v as u32).collect()).collect();
                    assert_eq!(plain.faces, expected.iter().collect());
                }
                (Err(plain), Err(general)) => assert_eq!(plain.message, general.message),
                (plain, general) => panic!("{plain:?} and {general:?}"),
            }
        }
        let cut = file(4, cases[0], false);
        let error = parse(&cut[..cut.len() - 1], 1).unwrap_err().message;
        assert!(error.starts_with("the file declares 2 faces and ends after 1"), "{error}");
    }

    #[test]
    fn columns_of_any_type_are_read() {
        let data = parse(&file(3, &[&[0, 1, 2]], false), 1).unwrap();
        // The two bytes of y are those of -256 + i.
        assert_eq!(data.positions[2], Vec3::new(0.2, -254.0, 1.0));
        assert_eq!(data.colours.unwrap()[1], [1.0, 0.0, 0.2, 1.0]);
    }

    /// Whether the text is read in parts, and not again.
    fn is_in_parts(text: &str) -> bool {
        let mut text = Scanner { bytes: text.as_bytes(), at: 0 };
        let (_, elements) = read_header(&mut text).unwrap();
        read(AsciiBody::in_parts(text, 5), &elements).is_ok()
    }

    #[test]
    fn rows_of_a_line_each_are_read_in_parts() {
        let text = "ply\nformat ascii 1.0\nelement nothing 7\nelement tristrips 1\n\
            property list int int vertex_indices\nelement edge 2\nproperty int a\nproperty int b\n\
            element vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
            property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float nx\n\
            property float ny\nproperty float nz\nproperty list uchar int more\nproperty float s\n\
            property float t\nelement face 3\nproperty list uchar int vertex_indices\n\
            property list uchar float texcoord\nproperty uchar red\nend_header\n\
            4 0 1 2 3\n0 1\n1 2\n\n0 0 0 255 0 0 0 0 1 0 0.5 1\r\n  1 0 0 0 0 0 0 0 1 2 7 8 0 1\n\
            1 1 0 0 51 0 0 0 1 0 0 0 \n0 1 0 0 0 0 0 0 1 0 1 1\n3 0 1 2 6 0 0 1 0 1 1 9\n0 0 9\n\
            4 0 1 2 3 0 9\n\nbehind\n";
        assert!(is_in_parts(text));
        let whole = parse(text.as_bytes(), 1).unwrap();
        assert_eq!(whole.notes.len(), 4, "{:?}", whole.notes);
        assert_eq!(*whole.faces.starts(), [0, 3, 6, 9, 9, 13]);
        assert_eq!(whole.corner_uvs.as_ref().unwrap()[7], [1.0, 0.0]);
        for parts in 2..text.len() {
            assert_eq!(parse(text.as_bytes(), parts).as_ref(), Ok(&whole), "{parts} parts");
        }
        let spread = text.replace("0 1 0 0 0 0 0 0 1", "0 1 0\n0 0 0\n0 0 1");
        assert!(!is_in_parts(&spread));
        assert_eq!(parse(spread.as_bytes(), 9).unwrap(), whole);
    }
}
