//! What several test files need.

use std::path::PathBuf;

/// The folder of the test meshes.
pub(crate) fn meshes() -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "..", "..", "data", "meshes"].iter().collect()
}
