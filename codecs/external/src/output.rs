//! Reads the output of a command: a regular file of an expected size, and nothing else. Opening a FIFO would wait;
//! reading a device or a huge file would not end.

use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, Read as _};
use std::ops::RangeInclusive;
use std::path::Path;

/// Why an output is not read.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// There is none.
    #[error("wrote nothing to {{out}}")]
    Missing,
    /// A FIFO, a device, a folder, or a link to one.
    #[error("left a {0} as {{out}}, where a regular file belongs")]
    Kind(&'static str),
    /// The file has another size, in bytes.
    #[error("wrote {0} bytes to {{out}}")]
    Size(u64),
    /// It cannot be read.
    #[error("left {{out}} so that it cannot be read: {0}")]
    Io(#[from] io::Error),
}

/// Reads a regular file whose length lies in `lengths` (bytes). It reads no other file and never waits.
pub fn read(path: &Path, lengths: RangeInclusive<u64>) -> Result<Vec<u8>, OutputError> {
    let (file, length) = open(path, lengths)?;
    let mut bytes = Vec::new();
    file.take(length.saturating_add(1)).read_to_end(&mut bytes)?;
    // Something that the command started may write on.
    if bytes.len() as u64 == length { Ok(bytes) } else { Err(OutputError::Size(bytes.len() as u64)) }
}

/// Opens a regular file whose length lies in `lengths` (bytes), and returns its length. It opens no other file and
/// never waits.
pub fn open(path: &Path, lengths: RangeInclusive<u64>) -> Result<(File, u64), OutputError> {
    // Checked before opening, because opening a device may start it. Checked again afterwards, because another file may
    // have taken the name.
    let check = |found: &Metadata| {
        if !found.is_file() {
            return Err(OutputError::Kind(kind(found)));
        }
        if lengths.contains(&found.len()) { Ok(found.len()) } else { Err(OutputError::Size(found.len())) }
    };
    match std::fs::metadata(path) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Err(OutputError::Missing),
        found => check(&found?)?,
    };
    let file = open_at_once(path)?;
    let length = check(&file.metadata()?)?;
    Ok((file, length))
}

/// Opens at once: a FIFO would make it wait for a writer.
fn open_at_once(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(
        &mut options,
        rustix::fs::OFlags::NONBLOCK.bits().cast_signed(),
    );
    options.open(path)
}

#[cfg(unix)]
fn kind(found: &Metadata) -> &'static str {
    use std::os::unix::fs::FileTypeExt as _;
    let kind = found.file_type();
    match () {
        () if kind.is_dir() => "folder",
        () if kind.is_fifo() => "FIFO",
        () if kind.is_socket() => "socket",
        () => "device",
    }
}

#[cfg(not(unix))]
fn kind(found: &Metadata) -> &'static str {
    if found.is_dir() { "folder" } else { "device" }
}

/// Writes the input of a command. It replaces any file of that name, which may be left from a command.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    use std::io::Write as _;
    let _ = std::fs::remove_file(path);
    OpenOptions::new().write(true).create_new(true).open(path)?.write_all(bytes)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn nothing_but_regular_files_of_the_expected_size_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let made = std::process::Command::new("mkfifo").arg(at("fifo")).status().unwrap();
        assert!(made.success());
        std::fs::create_dir(at("folder")).unwrap();
        std::fs::write(at("file"), [7; 64]).unwrap();
        let _socket = std::os::unix::net::UnixListener::bind(at("socket")).unwrap();
        symlink("/dev/zero", at("device")).unwrap();
        // As long as a terabyte, without its bytes.
        File::create(at("sparse")).unwrap().set_len(1 << 40).unwrap();
        for (name, said) in [
            ("none", "wrote nothing to {out}"),
            ("fifo", "left a FIFO as {out}"),
            ("folder", "left a folder as {out}"),
            ("socket", "left a socket as {out}"),
            ("device", "left a device as {out}"),
            ("sparse", "wrote 1099511627776 bytes to {out}"),
        ] {
            symlink(name, at("link")).unwrap();
            for path in [at(name), at("link")] {
                let problem = read(&path, 0..=64).unwrap_err().to_string();
                assert!(problem.starts_with(said), "{name}: {problem}");
            }
            std::fs::remove_file(at("link")).unwrap();
        }
        symlink("file", at("link")).unwrap();
        for path in [at("file"), at("link")] {
            assert_eq!(read(&path, 64..=64).unwrap(), [7; 64]);
            assert!(matches!(read(&path, 65..=100), Err(OutputError::Size(64))));
            assert!(matches!(read(&path, 0..=63), Err(OutputError::Size(64))));
        }
        // Opening without the check does not wait either.
        assert!(open_at_once(&at("fifo")).is_ok());
    }

    #[test]
    fn what_lies_under_a_name_is_replaced_and_not_opened() {
        let folder = tempfile::tempdir().unwrap();
        let fifo = folder.path().join("fifo");
        assert!(std::process::Command::new("mkfifo").arg(&fifo).status().unwrap().success());
        write(&fifo, b"samples").unwrap();
        assert_eq!(read(&fifo, 7..=7).unwrap(), b"samples");
    }
}
