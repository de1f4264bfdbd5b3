//! Reading and writing, with names and notes for people.

use std::path::Path;

use fairform_io::{Format, MeshData, WriteOptions};

use crate::args::{Input, Writing};
use crate::console::Console;
use crate::failure::Failure;

/// A file name as a user knows it.
pub(crate) fn name(path: &Path) -> String {
    if is_dash(path) { "standard input".into() } else { path.display().to_string() }
}

pub(crate) fn is_dash(path: &Path) -> bool {
    path.as_os_str() == "-"
}

pub(crate) fn read(input: &Input, console: &Console) -> Result<MeshData, Failure> {
    read_file(&input.input, input.from, console)
}

pub(crate) fn read_file(
    path: &Path,
    format: Option<Format>,
    console: &Console,
) -> Result<MeshData, Failure> {
    if is_dash(path) && format.is_none() {
        return Err(Failure::new("standard input has no name that tells its format")
            .help("say it with --from obj, off, ply, stl, gltf or glb"));
    }
    let data = fairform_io::read(path, format)?;
    for note in &data.notes {
        console.note(format!("note: {}: {note}", name(path)));
    }
    Ok(data)
}

pub(crate) fn write(
    path: &Path,
    writing: &Writing,
    data: &MeshData,
    console: &Console,
) -> Result<(), Failure> {
    check_output(path, writing)?;
    let options = WriteOptions { ascii: writing.ascii, single_precision: writing.single };
    for note in fairform_io::write(path, writing.to, data, &options)? {
        console.note(format!("note: {note}"));
    }
    Ok(())
}

/// Fails early, before any work, where the output has no format.
pub(crate) fn check_output(path: &Path, writing: &Writing) -> Result<(), Failure> {
    if writing.to.is_some() || Format::from_path(path).is_some() {
        return Ok(());
    }
    let what = if is_dash(path) {
        "standard output has".into()
    } else {
        format!("{}: has", path.display())
    };
    Err(Failure::new(format!("{what} no name that tells its format"))
        .help("say it with --to obj, off, ply, stl, gltf or glb"))
}

/// Writes text or bytes whole or not at all.
pub(crate) fn save(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    Ok(fairform_io::save(path, &mut |out| out.write_all(bytes))?)
}
