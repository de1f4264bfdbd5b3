//! What a PLY header declares: elements, and the properties of their rows.

use crate::error::ParseError;
use crate::text::{Scanner, counted, quoted, text_of};

/// The type of a number.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Scalar {
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

    pub(super) const fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(super) const fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// What a colour component of this type counts to.
    pub(super) const fn full(self) -> f64 {
        match self {
            Self::F32 | Self::F64 => 1.0,
            Self::I16 | Self::U16 => 65535.0,
            _ => 255.0,
        }
    }

    /// The number in the first bytes, which must be enough.
    pub(super) fn read<const BIG: bool>(self, bytes: &[u8]) -> f64 {
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
    pub(super) fn read_integer<const BIG: bool>(self, bytes: &[u8]) -> i64 {
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

pub(super) struct Property<'a> {
    pub(super) name: &'a [u8],
    /// The type of the number, or of the numbers in the list.
    pub(super) scalar: Scalar,
    /// For a list the type of its length.
    pub(super) count: Option<Scalar>,
}

pub(super) struct Element<'a> {
    pub(super) name: &'a [u8],
    pub(super) count: u64,
    pub(super) properties: Vec<Property<'a>>,
}

impl Element<'_> {
    /// The fewest bytes that a row can take in binary.
    pub(super) fn least_size(&self) -> usize {
        self.properties.iter().map(|p| p.count.unwrap_or(p.scalar).size()).sum()
    }

    /// Whether there are rows that take any place.
    pub(super) fn has_rows(&self) -> bool {
        self.count > 0 && !self.properties.is_empty()
    }

    pub(super) fn has_lists(&self) -> bool {
        self.properties.iter().any(|p| p.count.is_some())
    }

    pub(super) fn find(&self, names: &[&str]) -> Option<usize> {
        self.properties.iter().position(|p| names.iter().any(|n| n.as_bytes() == p.name))
    }

    /// How a message names so many rows.
    pub(super) fn counted(&self, count: u64) -> String {
        counted(count as usize, &text_of(self.name))
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

/// Reads the header, and goes to the first byte behind it.
pub(super) fn read_header<'a>(
    text: &mut Scanner<'a>,
) -> Result<(Encoding, Vec<Element<'a>>), ParseError> {
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
