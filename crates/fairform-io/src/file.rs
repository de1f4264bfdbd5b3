//! Reading and saving files.

use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use flate2::{Compression, GzBuilder};

use crate::data::{MeshData, WriteOptions};
use crate::error::Error;
use crate::stream::{Blocks, encode_blocks};
use crate::{Format, encode, gltf, gzip, par, parse};

/// The most bytes of a file that are read: 16 GiB. An endless pipe ends there.
const MAX_INPUT: u64 = 16 << 30;

/// Reads a mesh file, gzipped or not. `-` is the standard input. Without a format the name says it.
///
/// The buffers of a `.gltf` are read too, if they are in its folder or below.
///
/// # Errors
/// If the format is unknown, the file cannot be read, or it holds no mesh; the error names it.
pub fn read(path: &Path, format: Option<Format>) -> Result<MeshData, Error> {
    let format = resolve(path, format)?.0;
    let bytes = read_bytes(path).map_err(|source| Error::Read { path: path.into(), source })?;
    let parsed = match format {
        Format::Gltf | Format::Glb => {
            let plain = if gzip::is_gzip(&bytes) { gzip::unpack(&bytes) } else { Ok(bytes) };
            plain.and_then(|plain| {
                gltf::parse_with_buffers(&plain, &mut |name| read_buffer(path, name))
            })
        }
        _ => parse(&bytes, format),
    };
    parsed.map_err(|source| Error::Parse { path: path.into(), source })
}

/// The format to use for a path, and whether it says gzip.
fn resolve(path: &Path, format: Option<Format>) -> Result<(Format, bool), Error> {
    let named = Format::from_path(path);
    let gzip = is_gzip_name(path);
    match format.or(named.map(|(format, _)| format)) {
        Some(format) => Ok((format, gzip)),
        None => Err(Error::UnknownFormat { path: path.into() }),
    }
}

fn is_gzip_name(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"))
}

fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

fn read_bytes(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    if is_standard(path) {
        io::stdin().lock().take(MAX_INPUT + 1).read_to_end(&mut bytes)?;
    } else {
        let file = File::open(path)?;
        let size = usize::try_from(file.metadata()?.len().min(MAX_INPUT)).unwrap_or(0);
        bytes = read_at_once(&file, size)?;
        bytes.reserve_exact(size.saturating_sub(bytes.len()));
        file.take(MAX_INPUT + 1 - bytes.len() as u64).read_to_end(&mut bytes)?;
    }
    if bytes.len() as u64 > MAX_INPUT {
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, "more than 16 GiB"));
    }
    Ok(bytes)
}

/// Reads the first `size` bytes of a large file on all threads, and goes behind them. Empty where
/// the file is small or no such thing, for the caller to read from its beginning.
#[cfg(unix)]
fn read_at_once(mut file: &File, size: usize) -> io::Result<Vec<u8>> {
    use std::io::{Seek, SeekFrom};
    use std::os::unix::fs::FileExt;
    const BLOCK: usize = 1 << 22;
    if size <= BLOCK || par::threads() == 1 {
        return Ok(Vec::new());
    }
    // Zeros from the system: its pages are found by the thread that fills them.
    let mut bytes = vec![0; size];
    let read = par::map(bytes.chunks_mut(BLOCK).enumerate(), |(i, block)| {
        file.read_exact_at(block, (i * BLOCK) as u64)
    });
    // A file that was cut meanwhile is read as it is now.
    let whole = read.into_iter().all(|read| read.is_ok());
    if whole {
        file.seek(SeekFrom::Start(size as u64))?;
    }
    Ok(if whole { bytes } else { Vec::new() })
}

#[cfg(not(unix))]
fn read_at_once(_: &File, _: usize) -> io::Result<Vec<u8>> {
    Ok(Vec::new())
}

/// Reads a buffer of a glTF file: a file in its folder or below, also after links are followed.
fn read_buffer(gltf: &Path, name: &str) -> Result<Vec<u8>, String> {
    if is_standard(gltf) {
        return Err(format!(
            "the buffer is in another file, '{name}'; the standard input has none"
        ));
    }
    let outside = || format!("buffer '{name}' is outside the folder of the file");
    let relative = Path::new(name);
    let plain = |c| matches!(c, Component::Normal(_) | Component::CurDir);
    // A backslash or colon may mean a folder or drive elsewhere.
    if name.contains(['\\', ':', '\0']) || !relative.components().all(plain) {
        return Err(outside());
    }
    let failed = |e: io::Error| format!("cannot read buffer '{name}': {e}");
    let folder = match gltf.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let folder = folder.canonicalize().map_err(failed)?;
    let file = folder.join(relative).canonicalize().map_err(failed)?;
    if !file.starts_with(&folder) {
        return Err(outside());
    }
    // A pipe or device would wait or never end.
    if !fs::metadata(&file).map_err(failed)?.is_file() {
        return Err(format!("buffer '{name}' is no file"));
    }
    read_bytes(&file).map_err(failed)
}

/// Writes a mesh file whole or not at all, and says what the format could not hold. `-` is the
/// standard output; a name that ends in `.gz` is compressed. Without a format the name says it.
///
/// # Errors
/// If the format is unknown or cannot hold the mesh, or the file cannot be written; the error
/// names it.
pub fn write(
    path: &Path,
    format: Option<Format>,
    data: &MeshData,
    options: &WriteOptions,
) -> Result<Vec<String>, Error> {
    let (format, gzip) = resolve(path, format)?;
    save_encoded(path, gzip, &mut |out| encode(format, data, options, out))
}

/// Writes a mesh while it is made, as [`write()`] does one in memory.
///
/// # Errors
/// As [`write()`] and [`encode_blocks`].
pub fn write_blocks(
    path: &Path,
    format: Option<Format>,
    blocks: &dyn Blocks,
    options: &WriteOptions,
) -> Result<Vec<String>, Error> {
    let (format, gzip) = resolve(path, format)?;
    save_encoded(path, gzip, &mut |out| encode_blocks(format, blocks, options, out))
}

/// Saves what an encoder writes, compressed or not; what it refuses keeps the old file.
fn save_encoded<T: Default>(
    path: &Path,
    gzip: bool,
    encode: &mut dyn FnMut(&mut dyn Write) -> Result<T, Error>,
) -> Result<T, Error> {
    let mut made = Ok(T::default());
    let saved = save(path, &mut |out| {
        let result = if gzip {
            // Without a name or time in it, the same data give the same bytes.
            let mut packer = GzBuilder::new().write(out, Compression::default());
            encode(&mut packer)
                .and_then(|made| packer.finish().map(|_| made).map_err(Error::Output))
        } else {
            encode(out)
        };
        match result {
            Err(Error::Output(error)) => return Err(error),
            result => made = result,
        }
        // Anything makes `save` keep the old file.
        if made.is_err() { Err(io::ErrorKind::InvalidData.into()) } else { Ok(()) }
    });
    match made {
        Err(error) => Err(error),
        Ok(made) => saved.map(|()| made),
    }
}

/// Files of models, for [`crate::streamline`].
pub(crate) mod streamline {
    use super::{Error, Path, is_gzip_name, read_bytes, save_encoded};
    use crate::error::ParseError;
    use crate::streamline::{Contents, Curve, Models, encode, parse, parse_any, parse_curve};

    /// Reads the models in a file, gzipped or not. `-` is the standard input.
    ///
    /// # Errors
    /// If the file cannot be read, or as [`parse`]; the error names the file.
    pub fn read(path: &Path) -> Result<Models, Error> {
        read_by(path, parse)
    }

    /// Reads the curve in a file.
    ///
    /// # Errors
    /// If the file cannot be read, or as [`parse_curve`]; the error names the file.
    pub fn read_curve(path: &Path) -> Result<Curve, Error> {
        read_by(path, parse_curve)
    }

    /// Reads the surface or curve in a file.
    ///
    /// # Errors
    /// If the file cannot be read, or as [`parse_any`]; the error names the file.
    pub fn read_any(path: &Path) -> Result<Contents, Error> {
        read_by(path, parse_any)
    }

    fn read_by<T>(path: &Path, parse: fn(&[u8]) -> Result<T, ParseError>) -> Result<T, Error> {
        let bytes = read_bytes(path).map_err(|source| Error::Read { path: path.into(), source })?;
        parse(&bytes).map_err(|source| Error::Parse { path: path.into(), source })
    }

    /// Writes models whole or not at all; a name that ends in `.gz` is compressed. `-` is the
    /// standard output.
    ///
    /// # Errors
    /// As [`encode`], or if the file cannot be written; the error names it.
    pub fn write(path: &Path, models: &Models) -> Result<(), Error> {
        save_encoded(path, is_gzip_name(path), &mut |out| encode(models, out))
    }
}

/// Temporary files that [`save`] has open.
static PENDING: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn pending() -> std::sync::MutexGuard<'static, Vec<PathBuf>> {
    PENDING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A temporary file's entry in the list of those open.
struct Pending(PathBuf);

impl Pending {
    /// Creates a temporary file and lists it, with no moment between in which a signal could find
    /// it unlisted.
    fn create(
        builder: &tempfile::Builder<'_, '_>,
        folder: &Path,
    ) -> io::Result<(File, tempfile::TempPath, Self)> {
        let mut list = pending();
        let (file, path) = builder.tempfile_in(folder).map_err(|e| without_path(&e))?.into_parts();
        list.push(path.to_path_buf());
        let entry = Self(path.to_path_buf());
        Ok((file, path, entry))
    }
}

/// What the system said, without the name of the temporary file, which tells nobody anything and
/// which `tempfile` puts behind it.
fn without_path(error: &io::Error) -> io::Error {
    let text = error.to_string();
    io::Error::new(error.kind(), text.split(" at path ").next().unwrap_or_default())
}

impl Drop for Pending {
    fn drop(&mut self) {
        pending().retain(|path| *path != self.0);
    }
}

/// Deletes the temporary files that [`save`] has open just now, so that a program about to end
/// leaves none behind. Those calls of `save` then fail. For a thread that waits for signals.
pub fn discard_pending() {
    discard_pending_then(|| ());
}

/// As [`discard_pending`], and then calls `end` while no other temporary file can be created: the
/// way to exit.
pub fn discard_pending_then<T>(end: impl FnOnce() -> T) -> T {
    let mut list = pending();
    for path in list.drain(..) {
        // Nothing can be done about a file that does not go.
        let _ = fs::remove_file(path);
    }
    end()
}

/// Writes a file whole or not at all: into a temporary file beside it, then renamed over it.
///
/// `-` is the standard output, and what is no plain file (a pipe, `/dev/null`) is written directly.
/// A link is followed, and the permissions of a file that is replaced are kept.
///
/// # Errors
/// If the file cannot be created or written, or `f` fails; the error names it.
pub fn save(path: &Path, f: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>) -> Result<(), Error> {
    let saved = if is_standard(path) {
        write_buffered(io::stdout().lock(), f).map(drop)
    } else {
        save_file(path, f)
    };
    saved.map_err(|source| Error::Write { path: path.into(), source })
}

fn write_buffered<W: Write>(
    out: W,
    f: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>,
) -> io::Result<W> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    f(&mut out)?;
    let mut out = out.into_inner().map_err(io::IntoInnerError::into_error)?;
    out.flush()?;
    Ok(out)
}

fn save_file(path: &Path, f: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let existing = match fs::metadata(path) {
        Ok(metadata) if metadata.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
        Ok(metadata) if !metadata.is_file() => {
            let file = fs::OpenOptions::new().write(true).open(path)?;
            return write_buffered(file, f).map(drop);
        }
        Ok(metadata) => Some(metadata),
        Err(_) => None,
    };
    // A file we may not write is not ours to replace, though its folder would let us.
    if existing.as_ref().is_some_and(|m| m.permissions().readonly()) {
        return Err(io::ErrorKind::PermissionDenied.into());
    }
    let target = match &existing {
        Some(_) => path.canonicalize()?,
        None => path.to_path_buf(),
    };
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".fairform-").suffix(".tmp");
    #[cfg(unix)]
    let permissions = std::os::unix::fs::PermissionsExt::from_mode(0o666);
    // Less the user's mask, as for any new file.
    #[cfg(unix)]
    builder.permissions(permissions);
    let (file, temporary, entry) = Pending::create(&builder, folder)?;
    let file = write_buffered(file, f)?;
    if let Some(metadata) = existing {
        file.set_permissions(metadata.permissions())?;
    }
    // Closed first: where renaming an open file fails.
    drop(file);
    let renamed = temporary.persist(&target).map_err(|e| e.error);
    drop(entry);
    renamed
}
