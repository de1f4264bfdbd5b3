//! What several test files need.

use std::path::PathBuf;

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
