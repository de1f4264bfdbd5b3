//! What several test files need.

use std::path::PathBuf;

use fairform_io::{Format, parse_in_parts};
use proptest::prelude::*;

/// The folder of test data.
#[allow(dead_code, reason = "every test file uses some of it")]
pub(crate) fn data() -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "..", "..", "data"].iter().collect()
}

/// The folder of the test meshes.
#[allow(dead_code, reason = "every test file uses some of it")]
pub(crate) fn meshes() -> PathBuf {
    data().join("meshes")
}

/// The mesh or error of a reader that sees the whole text is that of many that see parts.
pub(crate) fn same_in_parts(bytes: &[u8], format: Format) -> Result<(), TestCaseError> {
    let whole = parse_in_parts(bytes, format, 1);
    for parts in [2, 3, 7, 20, bytes.len()] {
        let read = parse_in_parts(bytes, format, parts);
        // As text, NaN is NaN.
        if read != whole {
            prop_assert_eq!(format!("{read:?}"), format!("{whole:?}"), "{} parts", parts);
        }
    }
    Ok(())
}
