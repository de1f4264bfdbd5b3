//! Numbers in buffers.

use std::borrow::Cow;
use std::collections::HashMap;

use base64::Engine;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};

use super::json::{Accessor, Document};
use crate::error::ParseError;
use crate::par;

/// Elements that may be made from any file, however small.
const FREE_ELEMENTS: u64 = 1 << 22;
/// Elements that may be made for each byte of the file and its buffers.
const ELEMENTS_PER_BYTE: u64 = 64;

/// The buffers of a document, and how much may still be made from them.
pub(super) struct Buffers<'a> {
    document: &'a Document,
    data: Vec<Cow<'a, [u8]>>,
    /// Vertices and corners that may still be made. A few bytes may stand for any number of them:
    /// zeros without a buffer, and meshes that many nodes use.
    room: u64,
}

/// An element type with its number of components.
const KINDS: [(&str, usize); 7] =
    [("SCALAR", 1), ("VEC2", 2), ("VEC3", 3), ("VEC4", 4), ("MAT2", 4), ("MAT3", 9), ("MAT4", 16)];

/// Numbers of component types.
const UINT: u32 = 5125;
const FLOAT: u32 = 5126;

/// Bytes of a component, by its type's number in the file.
fn component_size(component_type: u32) -> Option<usize> {
    match component_type {
        5120 | 5121 => Some(1),
        5122 | 5123 => Some(2),
        5125 | 5126 => Some(4),
        _ => None,
    }
}

/// A component; `bytes` must be as long as its type says.
fn component(component_type: u32, normalized: bool, bytes: &[u8]) -> f64 {
    let two = || [bytes[0], bytes[1]];
    let four = || [bytes[0], bytes[1], bytes[2], bytes[3]];
    let (value, full) = match component_type {
        5120 => (f64::from(bytes[0].cast_signed()), 127.0),
        5121 => (f64::from(bytes[0]), 255.0),
        5122 => (f64::from(i16::from_le_bytes(two())), 32767.0),
        5123 => (f64::from(u16::from_le_bytes(two())), 65535.0),
        5125 => (f64::from(u32::from_le_bytes(four())), 4_294_967_295.0),
        _ => return f64::from(f32::from_le_bytes(four())),
    };
    if normalized { (value / full).max(-1.0) } else { value }
}

impl<'a> Buffers<'a> {
    pub(super) fn new(
        document: &'a Document,
        file_size: usize,
        chunk: Option<&'a [u8]>,
        load: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    ) -> Result<Self, ParseError> {
        let mut buffers = Vec::new();
        let mut loaded: HashMap<String, usize> = HashMap::new();
        let mut size = file_size as u64;
        for (i, buffer) in document.buffers.iter().enumerate() {
            let bytes: Cow<'a, [u8]> = match &buffer.uri {
                None if i == 0 && chunk.is_some() => Cow::Borrowed(chunk.unwrap_or_default()),
                None => return Err(ParseError::file(format!("buffer {i} has no data"))),
                Some(uri) if uri.starts_with("data:") => Cow::Owned(data_uri(uri, i)?),
                Some(uri) => {
                    let name = decoded_name(uri);
                    // One file many times would cost its size each time.
                    if loaded.insert(name.clone(), i).is_some() {
                        let message = format!("buffer {i} is in the file of another, '{name}'");
                        return Err(ParseError::file(message));
                    }
                    let bytes =
                        load(&name).map_err(|e| ParseError::file(format!("buffer {i}: {e}")))?;
                    size += bytes.len() as u64;
                    Cow::Owned(bytes)
                }
            };
            if buffer.byte_length > bytes.len() as u64 {
                let message =
                    format!("buffer {i} of {} bytes has only {}", buffer.byte_length, bytes.len());
                return Err(ParseError::file(message));
            }
            buffers.push(bytes);
        }
        let room = FREE_ELEMENTS + ELEMENTS_PER_BYTE * size;
        Ok(Self { document, data: buffers, room })
    }

    /// Takes room for so many vertices or corners.
    pub(super) fn spend(&mut self, elements: u64, what: &str) -> Result<(), ParseError> {
        match self.room.checked_sub(elements) {
            Some(room) => {
                self.room = room;
                Ok(())
            }
            None => Err(ParseError::file(format!(
                "{what} brings {elements} vertices or corners, more than a file of this size may"
            ))),
        }
    }

    fn accessor(&self, index: usize) -> Result<&'a Accessor, ParseError> {
        let accessors = &self.document.accessors;
        accessors.get(index).ok_or_else(|| {
            ParseError::file(format!("accessor {index}, but the file has {}", accessors.len()))
        })
    }

    pub(super) fn count(&self, accessor: usize) -> Result<u64, ParseError> {
        Ok(self.accessor(accessor)?.count)
    }

    /// The bytes of `count` elements of `size` bytes, and how far apart they begin.
    fn strided(
        &self,
        (view, offset): (usize, u64),
        (count, size): (u64, usize),
        who: &str,
    ) -> Result<(&[u8], usize), ParseError> {
        let views = &self.document.buffer_views;
        let Some(v) = views.get(view) else {
            let message =
                format!("{who} refers to buffer view {view}, but the file has {}", views.len());
            return Err(ParseError::file(message));
        };
        let Some(buffer) = self.data.get(v.buffer) else {
            let n = self.data.len();
            let message =
                format!("buffer view {view} refers to buffer {}, but the file has {n}", v.buffer);
            return Err(ParseError::file(message));
        };
        let range = usize::try_from(v.byte_offset).ok().zip(
            v.byte_offset.checked_add(v.byte_length).and_then(|end| usize::try_from(end).ok()),
        );
        let Some(bytes) = range.and_then(|(from, end)| buffer.get(from..end)) else {
            return Err(ParseError::file(format!("buffer view {view} goes beyond its buffer")));
        };
        let stride = v.byte_stride.filter(|s| *s > 0).unwrap_or(size as u64);
        let end = count
            .checked_sub(1)
            .map_or(Some(0), |n| n.checked_mul(stride)?.checked_add(size as u64));
        let end = end.and_then(|end| end.checked_add(offset));
        if end.is_none_or(|end| end > bytes.len() as u64) {
            let message = format!(
                "{who} of {count} elements goes beyond its buffer view of {} bytes",
                bytes.len()
            );
            return Err(ParseError::file(message));
        }
        // Without elements the offset is not checked by the end.
        Ok((bytes.get(offset as usize..).unwrap_or_default(), stride as usize))
    }

    /// The elements of an accessor whose kind is one of `kinds`, by `N` components each; those that
    /// the kind lacks are `missing`. The caller has spent room for them.
    pub(super) fn elements<const N: usize>(
        &self,
        index: usize,
        kinds: &[&str],
        missing: f64,
    ) -> Result<Vec<[f64; N]>, ParseError> {
        let accessor = self.accessor(index)?;
        let who = format!("accessor {index}");
        let components =
            KINDS.iter().find(|(kind, _)| *kind == accessor.kind && kinds.contains(kind));
        let Some(&(_, components)) = components else {
            let message = format!("{who} is of type {}", accessor.kind);
            return Err(ParseError::file(message).expected(kinds.join(" or ")));
        };
        let kind = accessor.component_type;
        let Some(size) = component_size(kind) else {
            return Err(ParseError::file(format!("{who} has unknown component type {kind}")));
        };
        let element = |bytes: &[u8]| {
            let mut values = [missing; N];
            for (value, bytes) in values.iter_mut().zip(bytes.chunks_exact(size)).take(components) {
                *value = component(kind, accessor.normalized, bytes);
            }
            values
        };
        let size = size * components;
        let mut out: Vec<[f64; N]> = if let Some(view) = accessor.buffer_view {
            let (bytes, stride) =
                self.strided((view, accessor.byte_offset), (accessor.count, size), &who)?;
            let count = accessor.count as usize;
            if kind == FLOAT && stride == 4 * N && components == N {
                // What most files are.
                let floats = bytes.as_chunks::<4>().0;
                let number = |i: usize| f64::from(f32::from_le_bytes(floats[i]));
                par::collect(count, |i| std::array::from_fn(|c| number(N * i + c)))
            } else {
                par::collect(count, |i| element(&bytes[i * stride..]))
            }
        } else {
            let mut zero = [missing; N];
            zero[..components.min(N)].fill(0.0);
            vec![zero; accessor.count as usize]
        };
        if let Some(sparse) = &accessor.sparse {
            let who = format!("the sparse part of {who}");
            let kind = sparse.indices.component_type;
            let index_size = match kind {
                5121 | 5123 | 5125 => component_size(kind).unwrap_or(4),
                _ => return Err(ParseError::file(format!("{who} has indices of type {kind}"))),
            };
            let at = (sparse.indices.buffer_view, sparse.indices.byte_offset);
            let indices = self.strided(at, (sparse.count, index_size), &who)?;
            let at = (sparse.values.buffer_view, sparse.values.byte_offset);
            let values = self.strided(at, (sparse.count, size), &who)?;
            for i in 0..sparse.count as usize {
                let target = component(kind, false, &indices.0[i * indices.1..]);
                // Whole and not negative by the types allowed above.
                #[expect(clippy::cast_sign_loss, reason = "an unsigned number of the file")]
                let Some(slot) = out.get_mut(target as usize) else {
                    let n = accessor.count;
                    let message = format!("{who} replaces element {target} of {n}");
                    return Err(ParseError::file(message));
                };
                *slot = element(&values.0[i * values.1..]);
            }
        }
        Ok(out)
    }

    /// The bytes of indices that are 32-bit words one behind the other, as in most files.
    fn plain_indices(&self, index: usize) -> Result<Option<&[[u8; 4]]>, ParseError> {
        let accessor = self.accessor(index)?;
        let plain = accessor.kind == "SCALAR"
            && accessor.component_type == UINT
            && !accessor.normalized
            && accessor.sparse.is_none();
        let Some(view) = accessor.buffer_view.filter(|_| plain) else { return Ok(None) };
        let who = format!("accessor {index}");
        let (bytes, stride) =
            self.strided((view, accessor.byte_offset), (accessor.count, 4), &who)?;
        Ok((stride == 4).then(|| &bytes.as_chunks::<4>().0[..accessor.count as usize]))
    }

    /// The indices of an accessor. The caller has spent room for them.
    pub(super) fn indices(&self, index: usize) -> Result<Vec<u32>, ParseError> {
        let kind = self.accessor(index)?.component_type;
        if !matches!(kind, 5121 | 5123 | 5125) {
            let message = format!("accessor {index} has component type {kind}");
            return Err(ParseError::file(message).expected("whole numbers for indices"));
        }
        if let Some(words) = self.plain_indices(index)? {
            return Ok(par::collect(words.len(), |i| u32::from_le_bytes(words[i])));
        }
        let elements = self.elements::<1>(index, &["SCALAR"], 0.0)?;
        // Normalized indices are against the rules, and would be fractions; they become 0 or 1.
        #[expect(clippy::cast_sign_loss, reason = "an unsigned number of the file")]
        Ok(elements.into_iter().map(|[i]| i as u32).collect())
    }
}

/// The bytes in a `data:` address.
fn data_uri(uri: &str, buffer: usize) -> Result<Vec<u8>, ParseError> {
    let Some((_, data)) = uri.split_once(";base64,") else {
        return Err(ParseError::file(format!("buffer {buffer} is no base64 data")));
    };
    // Padding is against the rules both where it is and where it is not, and found both ways.
    let config =
        GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    GeneralPurpose::new(&base64::alphabet::STANDARD, config)
        .decode(data)
        .map_err(|e| ParseError::file(format!("buffer {buffer} is no base64 data: {e}")))
}

/// A file name with `%20` and the like decoded, if that gives text.
fn decoded_name(uri: &str) -> String {
    let mut out = Vec::new();
    let mut rest = uri.as_bytes();
    while let Some((&byte, after)) = rest.split_first() {
        let hex = |b: u8| char::from(b).to_digit(16);
        let code = match after {
            [high, low, ..] if byte == b'%' => hex(*high).zip(hex(*low)),
            _ => None,
        };
        if let Some((high, low)) = code {
            out.push((16 * high + low) as u8);
            rest = &after[2..];
        } else {
            out.push(byte);
            rest = after;
        }
    }
    String::from_utf8(out).unwrap_or_else(|_| uri.to_string())
}
