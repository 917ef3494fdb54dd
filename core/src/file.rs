//! Files that are whole or not there.
//!
//! Every file that `cvr` leaves behind is written here: into a temporary file next to it, which is flushed, synced and
//! renamed after everything succeeded. A symbolic link stays, and its target is written. A device node, a FIFO or
//! standard output (under its name) is written directly.

use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// Prefix of temporary files and folders. Six letters and digits follow.
const TEMPORARY: &str = ".cvr-";
/// Suffix of temporary files and folders.
const PART: &str = ".part";
/// Letters and digits between the two.
const RANDOM: usize = 6;
/// Links that may follow each other, as many as Linux follows.
const LINKS: usize = 40;

/// Where the bytes of an output go.
#[derive(Debug)]
enum Destination {
    /// A regular file of this name, which is replaced or created as a whole.
    Replaced(PathBuf),
    /// An existing device node or FIFO.
    Straight(PathBuf),
    /// Into a regular file that no path names any more.
    Nameless(PathBuf),
    /// To standard output, by another name.
    Stdout(File),
}

/// Writes a file through a temporary one in the same folder. It is flushed, synced and renamed only when `write` has
/// succeeded. Only then is an older file replaced. The new file has the permissions that the user's umask gives to new
/// files.
///
/// A symbolic link is followed: its target is replaced. If the target is not a regular file, it is written directly,
/// and after an error it holds a part of the data.
///
/// # Errors
/// When the folder is missing, the path is that of a folder, or writing fails; no regular file is left behind or changed
/// then.
pub fn write_whole<E: From<io::Error>>(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<(), E> {
    match destination(path)? {
        Destination::Replaced(path) => {
            let mut builder = temporary();
            // By default, a temporary file is readable only by its owner.
            #[cfg(unix)]
            builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
            let mut file = builder.tempfile_in(folder_of(&path))?;
            checked(file.as_file_mut(), write)?;
            file.as_file().sync_all()?;
            file.persist(path).map_err(|e| e.error)?;
            Ok(())
        }
        Destination::Straight(path) => checked(&mut OpenOptions::new().write(true).open(path)?, write),
        Destination::Nameless(path) => {
            checked(&mut OpenOptions::new().write(true).truncate(true).open(path)?, write)
        }
        Destination::Stdout(mut file) => checked(&mut file, write),
    }
}

/// Writes through a buffer, whose last bytes are not lost in silence.
fn checked<E: From<io::Error>>(
    file: &mut File,
    write: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<(), E> {
    let mut buffered = BufWriter::new(file);
    write(&mut buffered)?;
    Ok(buffered.flush()?)
}

/// Opens nothing. Opening a FIFO would wait for its reader, and closing it would look like its end.
fn destination(path: &Path) -> io::Result<Destination> {
    let found = match std::fs::metadata(path) {
        Ok(found) => found,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Destination::Replaced(followed(path)?)),
        Err(e) => return Err(e),
    };
    if found.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "is a folder"));
    }
    if let Some(file) = standard_output(&found) {
        return Ok(Destination::Stdout(file));
    }
    if !found.is_file() {
        return Ok(Destination::Straight(path.to_owned()));
    }
    let target = followed(path)?;
    // A link in /proc to a deleted file leads to a name that is not that file.
    if std::fs::metadata(&target).is_ok_and(|named| is_same(&named, &found)) {
        return Ok(Destination::Replaced(target));
    }
    Ok(Destination::Nameless(path.to_owned()))
}

/// The path behind symbolic links, which need not exist.
fn followed(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..LINKS {
        if !std::fs::symlink_metadata(&path).is_ok_and(|m| m.is_symlink()) {
            return Ok(path);
        }
        path = folder_of(&path).join(std::fs::read_link(&path)?);
    }
    Err(io::Error::other("symbolic links that lead in a circle"))
}

/// Whether an output is this process's standard output, under any name. Terminals and other character devices do not
/// count.
#[must_use]
pub fn is_standard_output(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|found| standard_output(&found).is_some())
}

/// Standard output itself, if `found` is standard output. A regular file that was opened again would be written from
/// its beginning.
#[cfg(unix)]
fn standard_output(found: &std::fs::Metadata) -> Option<File> {
    use std::os::fd::AsFd as _;
    use std::os::unix::fs::FileTypeExt as _;
    if found.file_type().is_char_device() || found.file_type().is_block_device() {
        return None;
    }
    let own = File::from(io::stdout().as_fd().try_clone_to_owned().ok()?);
    own.metadata().is_ok_and(|own| is_same(&own, found)).then_some(own)
}

#[cfg(not(unix))]
fn standard_output(_: &std::fs::Metadata) -> Option<File> {
    None
}

#[cfg(unix)]
fn is_same(a: &std::fs::Metadata, b: &std::fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

#[cfg(not(unix))]
fn is_same(_: &std::fs::Metadata, _: &std::fs::Metadata) -> bool {
    true
}

/// The folder of a file.
#[must_use]
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."))
}

/// Folder for an output's temporary files: next to the file that it replaces, else the system's.
///
/// # Errors
/// When [`write_whole`] could not begin either.
pub fn scratch_folder(path: &Path) -> io::Result<PathBuf> {
    Ok(match destination(path)? {
        Destination::Replaced(path) => folder_of(&path).to_owned(),
        _ => std::env::temp_dir(),
    })
}

/// A folder below another, removed when it is dropped. [`is_temporary`] recognises one that a killed process left.
///
/// # Errors
/// When it cannot be made.
pub fn temporary_folder(below: &Path) -> io::Result<TempDir> {
    temporary().tempdir_in(below)
}

fn temporary() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMPORARY).suffix(PART).rand_bytes(RANDOM);
    builder
}

/// Whether a file or folder has a name that only temporary ones of `cvr` have.
#[must_use]
pub fn is_temporary(name: &str) -> bool {
    let random = name.strip_prefix(TEMPORARY).and_then(|rest| rest.strip_suffix(PART));
    random.is_some_and(|random| random.len() == RANDOM && random.bytes().all(|b| b.is_ascii_alphanumeric()))
}

#[cfg(test)]
mod tests;
