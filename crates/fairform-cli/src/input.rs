//! Reading and writing, with names and notes for people.

use std::fmt;
use std::path::Path;

use fairform_io::project::{self, MeshPart};
use fairform_io::repair::Steps;
use fairform_io::{Blocks, Error, Format, MeshData, Shape, WriteOptions};

use crate::args::{Input, Writing};
use crate::console::Console;
use crate::failure::Failure;

/// Where a mesh comes from. Shown as a user knows it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source<'a> {
    pub(crate) path: &'a Path,
    /// If the name does not say it.
    pub(crate) format: Option<Format>,
}

impl fmt::Display for Source<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if is_dash(self.path) { f.write_str("standard input") } else { self.path.display().fmt(f) }
    }
}

impl<'a> From<&'a Input> for Source<'a> {
    fn from(input: &'a Input) -> Self {
        Self { path: &input.input, format: input.from }
    }
}

impl Source<'_> {
    /// The command that repairs this mesh, to be copied into a shell.
    pub(crate) fn repair(&self, steps: &Steps) -> String {
        let from = self.format.map_or(String::new(), |format| format!(" --from {format}"));
        let path = quoted(&self.path.to_string_lossy());
        format!("fairform repair {path}{from} -o repaired.obj {steps}")
    }
}

/// A file name as a shell reads it.
fn quoted(name: &str) -> String {
    // A name like an option needs a folder before it.
    let name = if name.starts_with('-') && name != "-" { format!("./{name}") } else { name.into() };
    let plain = |c: char| c.is_alphanumeric() || "/\\._-+,:@%=~".contains(c);
    if name.chars().all(plain) && !name.starts_with('~') && (cfg!(windows) || !name.contains('\\'))
    {
        name
    } else if cfg!(windows) {
        format!("\"{name}\"")
    } else {
        format!("'{}'", name.replace('\'', r"'\''"))
    }
}

pub(crate) fn is_dash(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Whether a name ends in `.json`.
pub(crate) fn is_json(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"))
}

pub(crate) fn read(source: &Source, console: &Console) -> Result<MeshData, Failure> {
    if let Some(part) = project(source)? {
        console.note(format!(
            "note: {source}: its mesh as it was moved; `fairform fit` makes the surface that was designed"
        ));
        return data(&part, source, console);
    }
    if is_dash(source.path) && source.format.is_none() {
        return Err(Failure::usage("standard input has no name that tells its format")
            .help("say it with --from obj, off, ply, stl, gltf or glb"));
    }
    let data = fairform_io::read(source.path, source.format).map_err(|error| {
        let failure = Failure::from(error);
        let is_model = source.format.is_none()
            && source.path.is_file()
            && fairform_io::streamline::read(source.path).is_ok();
        if !is_model {
            return failure;
        }
        let path = quoted(&source.path.to_string_lossy());
        let message = format!("{source}: a streamline model, not a mesh");
        Failure { message, ..failure }
            .help(format!("fairform streamline {path} -o surface.obj makes a mesh of it"))
    })?;
    tell_notes(&data, source, console);
    Ok(data)
}

fn tell_notes(data: &MeshData, source: &Source, console: &Console) {
    for note in &data.notes {
        console.note(format!("note: {source}: {note}"));
    }
}

/// The mesh of a project of the studio, and what was decided about it; `None` for other files.
pub(crate) fn project(source: &Source) -> Result<Option<MeshPart>, Failure> {
    let name = source.path.file_name().map(|name| name.to_string_lossy().to_lowercase());
    let is_project = |name: &String| name.trim_end_matches(".gz").ends_with(project::EXTENSION);
    if source.format.is_some() || !name.as_ref().is_some_and(is_project) {
        return Ok(None);
    }
    let bytes = std::fs::read(source.path)
        .map_err(|e| Failure::new(format!("{source}: cannot read it: {e}")))?;
    let project = project::parse(&bytes).map_err(|e| Failure::new(format!("{source}: {e}")))?;
    let without = || Failure::new(format!("{source}: the project holds no mesh"));
    match (project.mesh, project.model) {
        (Some(part), _) => Ok(Some(part)),
        (None, Some(_)) => Err(without().help(format!(
            "it holds a streamline model: fairform streamline {} -o surface.obj",
            quoted(&source.path.to_string_lossy())
        ))),
        (None, None) => Err(without()),
    }
}

/// The mesh of a project, repaired and moved.
pub(crate) fn data(
    part: &MeshPart,
    source: &Source,
    console: &Console,
) -> Result<MeshData, Failure> {
    let data = part.data().map_err(|e| Failure::new(format!("{source}: {e}")))?;
    tell_notes(&data, source, console);
    Ok(data)
}

pub(crate) fn write(
    path: &Path,
    writing: &Writing,
    data: &MeshData,
    console: &Console,
) -> Result<(), Failure> {
    tell(path, fairform_io::write(path, writing.to, data, &options(writing)), console)
}

/// As [`write`], of a mesh that is made meanwhile.
pub(crate) fn write_blocks(
    path: &Path,
    writing: &Writing,
    blocks: &dyn Blocks,
    console: &Console,
) -> Result<(), Failure> {
    tell(path, fairform_io::write_blocks(path, writing.to, blocks, &options(writing)), console)
}

/// Whether a mesh like this can be written while it is made.
pub(crate) fn can_stream(path: &Path, writing: &Writing, shape: &Shape<'_>) -> bool {
    let format = writing.to.or(Format::from_path(path).map(|(format, _)| format));
    format.is_some_and(|format| fairform_io::can_stream(format, &options(writing), shape))
}

fn options(writing: &Writing) -> WriteOptions {
    WriteOptions { ascii: writing.ascii, single_precision: writing.single }
}

fn tell(
    path: &Path,
    written: Result<Vec<String>, Error>,
    console: &Console,
) -> Result<(), Failure> {
    let name = output_name(path);
    match written {
        Ok(notes) => {
            for note in notes {
                console.note(format!("note: {name}: {note}"));
            }
            Ok(())
        }
        Err(Error::Unwritable(why)) => Err(Failure::new(format!("cannot write {name}: {why}"))),
        Err(error) => Err(error.into()),
    }
}

/// Fails early, before any work, where a mesh cannot be written.
pub(crate) fn check_mesh(path: &Path, writing: &Writing) -> Result<(), Failure> {
    if writing.to.is_some() || Format::from_path(path).is_some() {
        return Ok(());
    }
    let what = if is_dash(path) {
        "standard output has no name that tells its format".into()
    } else {
        format!("{}: the name tells no format", path.display())
    };
    Err(Failure::usage(what).help("say it with --to obj, off, ply, stl, gltf or glb"))
}

/// Fails early where outputs cannot be written, or are in each other's way.
pub(crate) fn check_outputs(outputs: &[&Path], console: &Console) -> Result<(), Failure> {
    for (i, path) in outputs.iter().enumerate() {
        let name = output_name(path);
        if outputs[..i].contains(path) {
            return Err(Failure::usage(format!("two outputs go to {name}")));
        }
        if is_dash(path) && console.json() {
            return Err(Failure::usage("--json and `-o -` both want standard output"));
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            let folder = folder.display();
            return Err(Failure::new(format!("cannot write {name}: there is no folder {folder}")));
        }
    }
    Ok(())
}

fn output_name(path: &Path) -> String {
    if is_dash(path) { "standard output".into() } else { path.display().to_string() }
}

/// Writes text or bytes whole or not at all.
pub(crate) fn save(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    Ok(fairform_io::save(path, &mut |out| out.write_all(bytes))?)
}

#[cfg(test)]
mod tests {
    #[cfg(not(windows))]
    #[test]
    fn names_are_quoted_for_the_shell() {
        for (name, expected) in [
            ("a/b.obj", "a/b.obj"),
            ("größe.obj", "größe.obj"),
            ("-", "-"),
            ("-x.obj", "./-x.obj"),
            ("a b.obj", "'a b.obj'"),
            ("it's.obj", r"'it'\''s.obj'"),
            ("$HOME.obj", "'$HOME.obj'"),
        ] {
            assert_eq!(super::quoted(name), expected);
        }
    }
}
