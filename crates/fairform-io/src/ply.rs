//! The Stanford polygon file, as text or binary in either byte order.
//!
//! Read: `vertex` with coordinates, normals, colours and texture coordinates in any order and of
//! any type, `face` with `vertex_indices` and `texcoord`, `tristrips`. Other elements and
//! properties are skipped by their declared types. The elements may come in any order.
//!
//! Source: Greg Turk, *The PLY Polygon File Format*, 1994.

use std::io::Write;

use fairform::{Faces, Vec3};

use crate::data::{MeshData, WriteOptions, exact_bytes, push_face, scale_large_colours};
use crate::error::{Error, ParseError, Place};
use crate::format::left_out;
use crate::text::{NumberWriter, Scanner, counted, quoted, text_of};

/// The type of a number.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    const fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// What a colour component of this type counts to.
    const fn full(self) -> f64 {
        match self {
            Self::F32 | Self::F64 => 1.0,
            Self::I16 | Self::U16 => 65535.0,
            _ => 255.0,
        }
    }

    /// The number in the first bytes, which must be enough.
    fn read<const BIG: bool>(self, bytes: &[u8]) -> f64 {
        match self {
            Self::I8 => f64::from(bytes[0].cast_signed()),
            Self::U8 => f64::from(bytes[0]),
            Self::I16 => f64::from(i16::from_le_bytes(take::<BIG, 2>(bytes))),
            Self::U16 => f64::from(u16::from_le_bytes(take::<BIG, 2>(bytes))),
            Self::I32 => f64::from(i32::from_le_bytes(take::<BIG, 4>(bytes))),
            Self::U32 => f64::from(u32::from_le_bytes(take::<BIG, 4>(bytes))),
            Self::F32 => f64::from(f32::from_le_bytes(take::<BIG, 4>(bytes))),
            Self::F64 => f64::from_le_bytes(take::<BIG, 8>(bytes)),
        }
    }

    /// The whole number in the first bytes, which must be enough; 0 for floating types.
    fn read_integer<const BIG: bool>(self, bytes: &[u8]) -> i64 {
        match self {
            Self::I8 => i64::from(bytes[0].cast_signed()),
            Self::U8 => i64::from(bytes[0]),
            Self::I16 => i64::from(i16::from_le_bytes(take::<BIG, 2>(bytes))),
            Self::U16 => i64::from(u16::from_le_bytes(take::<BIG, 2>(bytes))),
            Self::I32 => i64::from(i32::from_le_bytes(take::<BIG, 4>(bytes))),
            Self::U32 => i64::from(u32::from_le_bytes(take::<BIG, 4>(bytes))),
            Self::F32 | Self::F64 => 0,
        }
    }
}

/// The first `N` bytes in little-endian order.
fn take<const BIG: bool, const N: usize>(bytes: &[u8]) -> [u8; N] {
    let mut out = [0; N];
    out.copy_from_slice(&bytes[..N]);
    if BIG {
        out.reverse();
    }
    out
}

struct Property<'a> {
    name: &'a [u8],
    /// The type of the number, or of the numbers in the list.
    scalar: Scalar,
    /// For a list the type of its length.
    count: Option<Scalar>,
}

struct Element<'a> {
    name: &'a [u8],
    count: u64,
    properties: Vec<Property<'a>>,
}

impl Element<'_> {
    /// The fewest bytes that a row can take in binary.
    fn least_size(&self) -> usize {
        self.properties.iter().map(|p| p.count.unwrap_or(p.scalar).size()).sum()
    }

    fn has_lists(&self) -> bool {
        self.properties.iter().any(|p| p.count.is_some())
    }

    fn find(&self, names: &[&str]) -> Option<usize> {
        self.properties.iter().position(|p| names.iter().any(|n| n.as_bytes() == p.name))
    }

    /// How a message names so many rows.
    fn counted(&self, count: u64) -> String {
        counted(count as usize, &text_of(self.name))
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

/// The mesh in a PLY file.
pub(crate) fn parse(bytes: &[u8]) -> Result<MeshData, ParseError> {
    let mut text = Scanner::new(bytes)?;
    let (encoding, elements) = read_header(&mut text)?;
    let vertex_count = elements.iter().find(|e| e.name == b"vertex").map_or(0, |e| e.count);
    let mut reader = Reader { data: MeshData::default(), vertex_count, index_at: 0 };
    let end = match encoding {
        Encoding::Ascii => {
            let mut body = AsciiBody { text };
            reader.elements(&mut body, &elements)?;
            body.text.skip_space();
            body.text.at
        }
        Encoding::Little => {
            let mut body = BinaryBody::<false> { bytes, at: text.at };
            reader.elements(&mut body, &elements)?;
            body.at
        }
        Encoding::Big => {
            let mut body = BinaryBody::<true> { bytes, at: text.at };
            reader.elements(&mut body, &elements)?;
            body.at
        }
    };
    let mut data = reader.data;
    if end < bytes.len() {
        let n = counted(bytes.len() - end, "byte");
        data.notes.push(format!("{n} behind the last element unread"));
    }
    Ok(data)
}

/// Reads the header, and goes to the first byte behind it.
fn read_header<'a>(text: &mut Scanner<'a>) -> Result<(Encoding, Vec<Element<'a>>), ParseError> {
    if text.rest_of_line() != b"ply" {
        let start = Scanner { at: 0, ..*text };
        return Err(start.unexpected("'ply' on the first line"));
    }
    // The bytes behind the header's last line end may look like one, so how long it is follows
    // from the first.
    let crlf = text.bytes[text.at..].starts_with(b"\r\n");
    text.skip_line_end();
    let mut encoding = None;
    let mut elements: Vec<Element<'a>> = Vec::new();
    loop {
        if text.is_at_end() {
            return Err(text.error("the header has no end").expected("'end_header'"));
        }
        text.skip_blanks();
        let at = text.at;
        match text.word() {
            b"comment" | b"obj_info" | b"" => {}
            b"format" => encoding = Some(read_format(text)?),
            b"element" => {
                let name = text.word();
                text.skip_blanks();
                let count = text.count("a count")?;
                if name == b"vertex" && count >= u64::from(u32::MAX) {
                    let message = format!("the file declares {count} vertices, too many");
                    return Err(text.error_at(at, message));
                }
                if elements.iter().any(|e| e.name == name) {
                    let message = format!("element {} declared twice", quoted(name));
                    return Err(text.error_at(at, message));
                }
                elements.push(Element { name, count, properties: Vec::new() });
            }
            b"property" => {
                let property = read_property(text)?;
                match elements.last_mut() {
                    Some(element) => element.properties.push(property),
                    None => return Err(text.error_at(at, "a property before any element")),
                }
            }
            b"end_header" => break,
            _ => {
                let text = Scanner { at, ..*text };
                return Err(text.unexpected("a PLY header statement"));
            }
        }
        text.skip_line();
    }
    text.skip_blanks();
    match text.peek() {
        Some(b'\r') => {
            text.at += if crlf && text.bytes[text.at..].starts_with(b"\r\n") { 2 } else { 1 }
        }
        Some(b'\n') => text.at += 1,
        _ => {}
    }
    match encoding {
        Some(encoding) => Ok((encoding, elements)),
        None => Err(ParseError::file("the header does not say the format").expected("'format …'")),
    }
}

fn read_format(text: &mut Scanner<'_>) -> Result<Encoding, ParseError> {
    text.skip_blanks();
    let start = *text;
    match text.word() {
        b"ascii" => Ok(Encoding::Ascii),
        b"binary_little_endian" => Ok(Encoding::Little),
        b"binary_big_endian" => Ok(Encoding::Big),
        _ => Err(start.unexpected("ascii, binary_little_endian or binary_big_endian")),
    }
}

fn read_property<'a>(text: &mut Scanner<'a>) -> Result<Property<'a>, ParseError> {
    fn scalar(text: &mut Scanner<'_>) -> Result<Scalar, ParseError> {
        text.skip_blanks();
        let start = *text;
        Scalar::from_name(text.word()).ok_or_else(|| start.unexpected("a type, such as float"))
    }
    let before = *text;
    let count = if text.word() == b"list" {
        let count = scalar(text)?;
        if count.is_float() {
            return Err(text.error("the length of a list is no whole number").expected("uchar"));
        }
        Some(count)
    } else {
        *text = before;
        None
    };
    let scalar = scalar(text)?;
    let name = text.word();
    if name.is_empty() {
        return Err(text.unexpected("the name of the property"));
    }
    Ok(Property { name, scalar, count })
}

/// How a message begins that says the file ends in a row; how many rows there are is then said too.
const END: &str = "the file ends";

/// Where the numbers come from.
trait Body {
    /// An error unless what is left can hold the rows of an element.
    fn check(&self, element: &Element<'_>) -> Result<(), ParseError>;
    /// Starts a row.
    fn begin_row(&mut self) {}
    /// Ends a row.
    fn end_row(&mut self) -> Result<(), ParseError> {
        Ok(())
    }
    /// Whether nothing is left.
    fn is_at_end(&mut self) -> bool;
    /// The next number. Fails at the end.
    fn number(&mut self, scalar: Scalar) -> Result<f64, ParseError>;
    /// The next whole number, of a type that is no floating one. Fails at the end.
    fn integer(&mut self, scalar: Scalar) -> Result<i64, ParseError>;
    /// The length of the list here. Fails if what is left cannot hold it, or for one below 0.
    fn length(&mut self, property: &Property<'_>) -> Result<usize, ParseError>;
    /// Skips so many numbers.
    fn skip(&mut self, scalar: Scalar, count: usize) -> Result<(), ParseError>;
    /// Where the next number is.
    fn offset(&self) -> usize;
    /// The place of an offset.
    fn place(&self, offset: usize) -> Place;
    /// The rows of an element without lists, if they are bytes of one size: those, and the reading
    /// of one number.
    fn rows(&mut self, _: &Element<'_>) -> Option<Rows<'_>> {
        None
    }
}

/// The rows of an element as bytes.
struct Rows<'a> {
    bytes: &'a [u8],
    size: usize,
    read: fn(Scalar, &[u8]) -> f64,
}

struct AsciiBody<'a> {
    text: Scanner<'a>,
}

impl Body for AsciiBody<'_> {
    fn check(&self, element: &Element<'_>) -> Result<(), ParseError> {
        // A number takes a byte, and one to part it from the next.
        let numbers = element.count.saturating_mul(element.properties.len() as u64);
        if numbers > (self.text.remaining() as u64).div_ceil(2) {
            // Count what is there, to say it.
            let mut text = self.text;
            let mut rows = 0_u64;
            text.skip_space();
            while !text.is_at_end() && rows < element.count {
                text.skip_line();
                text.skip_space();
                rows += 1;
            }
            let declared = element.counted(element.count);
            let message = format!("the file declares {declared} and ends after {rows}");
            return Err(text.error(message));
        }
        Ok(())
    }

    fn begin_row(&mut self) {
        self.text.skip_space();
    }

    fn end_row(&mut self) -> Result<(), ParseError> {
        self.text.skip_blanks();
        match self.text.peek() {
            None | Some(b'\n' | b'\r') => Ok(()),
            _ => Err(self.text.unexpected("the end of the line")),
        }
    }

    fn is_at_end(&mut self) -> bool {
        self.text.skip_space();
        self.text.is_at_end()
    }

    fn number(&mut self, _: Scalar) -> Result<f64, ParseError> {
        self.text.skip_space();
        self.text.number()
    }

    fn integer(&mut self, _: Scalar) -> Result<i64, ParseError> {
        self.text.skip_space();
        self.text.integer("a whole number")
    }

    fn length(&mut self, _: &Property<'_>) -> Result<usize, ParseError> {
        self.text.skip_space();
        let at = self.text.at;
        let length = self.text.count("the length of a list")?;
        if length > (self.text.remaining() as u64).div_ceil(2) {
            let message = format!("{END}, too soon for a list of {length} numbers");
            return Err(self.text.error_at(at, message));
        }
        Ok(length as usize)
    }

    fn skip(&mut self, _: Scalar, count: usize) -> Result<(), ParseError> {
        for _ in 0..count {
            self.text.skip_space();
            if self.text.word().is_empty() {
                return Err(self.text.unexpected("a number"));
            }
        }
        Ok(())
    }

    fn offset(&self) -> usize {
        self.text.at
    }

    fn place(&self, offset: usize) -> Place {
        Place::Line(self.text.line_of(offset))
    }
}

struct BinaryBody<'a, const BIG: bool> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a, const BIG: bool> BinaryBody<'a, BIG> {
    fn next(&mut self, scalar: Scalar) -> Result<&'a [u8], ParseError> {
        match self.bytes.get(self.at..self.at + scalar.size()) {
            Some(bytes) => {
                self.at += scalar.size();
                Ok(bytes)
            }
            None => Err(ParseError::byte(self.at, END)),
        }
    }
}

impl<const BIG: bool> Body for BinaryBody<'_, BIG> {
    fn check(&self, element: &Element<'_>) -> Result<(), ParseError> {
        let size = element.least_size();
        let left = self.bytes.len() - self.at;
        // With lists the rows differ, and where the file ends shows on the way; but not even the
        // shortest rows may be more than the bytes.
        if size > 0 && element.count > (left / size) as u64 && !element.has_lists() {
            let (declared, n) = (element.counted(element.count), left / size);
            let message = format!("the file declares {declared} and ends after {n}");
            return Err(ParseError::byte(self.bytes.len(), message));
        }
        Ok(())
    }

    fn is_at_end(&mut self) -> bool {
        self.at >= self.bytes.len()
    }

    fn number(&mut self, scalar: Scalar) -> Result<f64, ParseError> {
        Ok(scalar.read::<BIG>(self.next(scalar)?))
    }

    fn integer(&mut self, scalar: Scalar) -> Result<i64, ParseError> {
        Ok(scalar.read_integer::<BIG>(self.next(scalar)?))
    }

    fn length(&mut self, property: &Property<'_>) -> Result<usize, ParseError> {
        let at = self.at;
        let length = self.integer(property.count.unwrap_or(Scalar::U8))?;
        let left = (self.bytes.len() - self.at) / property.scalar.size();
        match usize::try_from(length) {
            Ok(length) if length <= left => Ok(length),
            Ok(length) => {
                let message = format!("{END}, and holds {left} of the {length} numbers of a list");
                Err(ParseError::byte(at, message))
            }
            Err(_) => Err(ParseError::byte(at, format!("a list of {length} numbers"))),
        }
    }

    fn skip(&mut self, scalar: Scalar, count: usize) -> Result<(), ParseError> {
        let left = (self.bytes.len() - self.at) / scalar.size();
        if count > left {
            return Err(ParseError::byte(self.bytes.len(), END));
        }
        self.at += count * scalar.size();
        Ok(())
    }

    fn offset(&self) -> usize {
        self.at
    }

    fn place(&self, offset: usize) -> Place {
        Place::Byte(offset as u64)
    }

    fn rows(&mut self, element: &Element<'_>) -> Option<Rows<'_>> {
        let size = element.least_size();
        if element.has_lists() || size == 0 {
            return None;
        }
        let length = usize::try_from(element.count).ok()?.checked_mul(size)?;
        let bytes = self.bytes.get(self.at..self.at.checked_add(length)?)?;
        self.at += length;
        Some(Rows { bytes, size, read: Scalar::read::<BIG> })
    }
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

struct Reader {
    data: MeshData,
    vertex_count: u64,
    /// Where the list of the face being read begins.
    index_at: usize,
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

    /// Reads the rows of an element one after the other.
    fn rows<B: Body>(
        body: &mut B,
        element: &Element<'_>,
        mut row: impl FnMut(&mut B, u64) -> Result<(), ParseError>,
    ) -> Result<(), ParseError> {
        if element.properties.is_empty() {
            return Ok(());
        }
        for done in 0..element.count {
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
        Self::rows(body, element, |body, _| {
            element.properties.iter().try_for_each(|p| Self::skip_property(body, p))
        })
    }

    fn vertices<B: Body>(&mut self, body: &mut B, element: &Element<'_>) -> Result<(), ParseError> {
        let columns = VertexColumns::new(element)?;
        let data = &mut self.data;
        // `check` compared the count with the bytes, unless there are lists.
        let room = if element.has_lists() { 0 } else { element.count as usize };
        data.positions.reserve_exact(room);
        data.normals = columns.normal.map(|_| Vec::with_capacity(room));
        data.colours = columns.colour.map(|_| Vec::with_capacity(room));
        data.uvs = columns.uv.map(|_| Vec::with_capacity(room));
        let full: Vec<_> = element.properties.iter().map(|p| p.scalar.full()).collect();
        let mut store = |value: &dyn Fn(usize) -> f64| {
            let vec3 = |[x, y, z]: [usize; 3]| Vec3::new(value(x), value(y), value(z));
            data.positions.push(vec3(columns.position));
            if let (Some(at), Some(normals)) = (columns.normal, &mut data.normals) {
                normals.push(vec3(at));
            }
            if let (Some((rgb, alpha)), Some(colours)) = (columns.colour, &mut data.colours) {
                let part = |i: usize| value(i) / full[i];
                let [r, g, b] = rgb.map(part);
                colours.push([r, g, b, alpha.map_or(1.0, part)]);
            }
            if let (Some(at), Some(uvs)) = (columns.uv, &mut data.uvs) {
                uvs.push(at.map(value));
            }
        };
        if let Some(Rows { bytes, size, read }) = body.rows(element) {
            let mut offsets = Vec::with_capacity(element.properties.len());
            let mut offset = 0;
            for property in &element.properties {
                offsets.push((property.scalar, offset));
                offset += property.scalar.size();
            }
            for row in bytes.chunks_exact(size) {
                store(&|i| read(offsets[i].0, &row[offsets[i].1..]));
            }
        } else {
            let mut values = vec![0.0; element.properties.len()];
            Self::rows(body, element, |body, _| {
                for (value, property) in values.iter_mut().zip(&element.properties) {
                    if property.count.is_some() {
                        Self::skip_property(body, property)?;
                    } else {
                        *value = body.number(property.scalar)?;
                    }
                }
                store(&|i| values[i]);
                Ok(())
            })?;
        }
        if let Some(colours) = &mut self.data.colours {
            scale_large_colours(colours, &mut self.data.notes);
        }
        Ok(())
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

    fn vertex<B: Body>(&self, body: &B, index: i64, row: (&str, u64)) -> Result<u32, ParseError> {
        match u32::try_from(index) {
            Ok(v) if u64::from(v) < self.vertex_count => Ok(v),
            _ => {
                let (name, row) = row;
                let message = format!(
                    "{name} {row} lists vertex {index}, but the mesh has {} vertices, counted \
                     from 0",
                    self.vertex_count
                );
                Err(ParseError::new(body.place(self.index_at), message))
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
        let texcoord = element
            .find(&["texcoord"])
            .filter(|i| element.properties[*i].count.is_some() && *i != list);
        let mut faces = Faces::new();
        let mut corners = Vec::new();
        // Triangles of strips may stand before.
        let mut uvs = vec![[0.0; 2]; self.data.faces.corners().len()];
        let mut without_uvs = 0;
        let mut numbers = Vec::new();
        Self::rows(body, element, |body, face| {
            numbers.clear();
            for (i, property) in element.properties.iter().enumerate() {
                if i == list {
                    self.index_at = body.offset();
                    corners.clear();
                    for _ in 0..body.length(property)? {
                        let index = body.integer(property.scalar)?;
                        corners.push(self.vertex(body, index, ("face", face))?);
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
                    uvs.extend(numbers.chunks_exact(2).map(|uv| [uv[0], uv[1]]));
                } else {
                    without_uvs += 1;
                    uvs.resize(uvs.len() + corners.len(), [0.0; 2]);
                }
            }
            if faces.corners().len() + corners.len() > u32::MAX as usize {
                let place = body.place(self.index_at);
                return push_face(&mut faces, &corners, place);
            }
            faces.push(&corners);
            Ok(())
        })?;
        if texcoord.is_some() && without_uvs < faces.len() {
            self.data.corner_uvs = Some(uvs);
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

    /// Reads triangle strips, which −1 parts and whose every other triangle turns over.
    fn strips<B: Body>(&mut self, body: &mut B, element: &Element<'_>) -> Result<(), ParseError> {
        let Some(list) = Self::index_list(element)? else {
            return Self::skip(body, element);
        };
        let mut faces = Faces::new();
        Self::rows(body, element, |body, strip| {
            for (i, property) in element.properties.iter().enumerate() {
                if i != list {
                    Self::skip_property(body, property)?;
                    continue;
                }
                self.index_at = body.offset();
                let mut last = [0; 2];
                let mut length = 0;
                for _ in 0..body.length(property)? {
                    let index = body.integer(property.scalar)?;
                    // Written as an unsigned number −1 is the largest.
                    if index == -1 || index == i64::from(u32::MAX) {
                        length = 0;
                        continue;
                    }
                    let v = self.vertex(body, index, ("strip", strip))?;
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
        let (n, strips) =
            (counted(faces.len(), "triangle"), counted(element.count as usize, "strip"));
        self.data.notes.push(format!("{n} made from {strips}"));
        self.append(faces, Place::File)
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
