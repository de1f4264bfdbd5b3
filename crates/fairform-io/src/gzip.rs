//! Taking gzip apart, with a bound on what comes out.

use std::io::Read;

use flate2::read::MultiGzDecoder;

use crate::error::ParseError;

/// The most bytes that `compressed` bytes of gzip may unpack to: 64 MiB and 64 times their size.
///
/// Mesh files shrink three- to twentyfold; a bomb shrinks a thousandfold.
#[must_use]
pub fn limit(compressed: usize) -> u64 {
    (64 << 20) + 64 * compressed as u64
}

/// Whether bytes begin as gzip does.
pub(crate) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

/// The bytes in a gzip file, all members of it.
pub(crate) fn unpack(bytes: &[u8]) -> Result<Vec<u8>, ParseError> {
    let limit = limit(bytes.len());
    let mut out = Vec::new();
    let mut decoder = MultiGzDecoder::new(bytes).take(limit + 1);
    decoder
        .read_to_end(&mut out)
        .map_err(|e| ParseError::file(format!("the gzip data are damaged: {e}")))?;
    if out.len() as u64 > limit {
        return Err(ParseError::file(format!("the gzip data unpack to more than {limit} bytes")));
    }
    Ok(out)
}
