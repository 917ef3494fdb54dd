//! Why a volume could not be read, written or generated: where, what is wrong, and what would be right.

use std::path::{Path, PathBuf};

use cvr_core::memory::{self, Bound, gigabytes};

use super::Generator;

/// Where an error arose. Every [`InputError`] has one, so every message names its file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// A file as a whole.
    File(PathBuf),
    /// One line of a header.
    Line {
        /// File that holds the header.
        file: PathBuf,
        /// Line, counted from 1.
        line: usize,
    },
    /// A data file that a detached header names. It may lie anywhere, so both are named.
    Data {
        /// The data file.
        data: PathBuf,
        /// The header that names it.
        header: PathBuf,
        /// Line of the header that does, counted from 1.
        line: usize,
    },
    /// A part of a file that is not a line of text: a field of a binary header, a page, an element.
    Part {
        /// The file.
        file: PathBuf,
        /// The part, as a noun phrase.
        part: String,
    },
    /// No file: a generator.
    Generator(Generator),
}

impl Place {
    /// The file itself.
    pub(super) fn file(path: &Path) -> Self {
        Self::File(path.to_owned())
    }

    /// A part of a file.
    pub(super) fn part(path: &Path, part: impl Into<String>) -> Self {
        Self::Part { file: path.to_owned(), part: part.into() }
    }
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File(file) => write!(f, "{}", file.display()),
            Self::Line { file, line } => write!(f, "{}, line {line}", file.display()),
            Self::Data { data, header, line } => {
                write!(f, "{} (data file of {}, line {line})", data.display(), header.display())
            }
            Self::Part { file, part } => write!(f, "{}, {part}", file.display()),
            Self::Generator(generator) => write!(f, "generator {}", generator.name()),
        }
    }
}

/// What may be taken of memory, and how to have it otherwise; empty where nothing is bounded.
fn may_be_taken() -> String {
    let text = |bound: Bound| {
        format!(", {} may be taken by all together, and --max-gb allows more", gigabytes(bound.bytes))
    };
    memory::allowed().map(text).unwrap_or_default()
}

/// Why there is no volume. Each message names the place, the problem and the way out.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// The operating system refused.
    #[error("{place}: cannot {action}: {source}")]
    Io {
        /// File concerned.
        place: Place,
        /// What was attempted, as a verb with its object.
        action: &'static str,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// The path leads to a folder, pipe or device.
    #[error("{place}: not a regular file; give the path of a file that holds a volume")]
    NotAFile {
        /// The path.
        place: Place,
    },
    /// Neither extension nor content show the format.
    #[error(
        "{place}: neither the extension {extension:?} nor the first bytes \"{start}\" identify a format; \
         supported: {}",
        super::FORMATS
    )]
    UnknownFormat {
        /// The file.
        place: Place,
        /// Extension without its dot; empty where there is none.
        extension: String,
        /// First bytes, escaped.
        start: String,
    },
    /// The header breaks the rules of its format.
    #[error("{place}: {problem}; {remedy}")]
    Header {
        /// The line, or the file where something is missing.
        place: Place,
        /// The problem.
        problem: String,
        /// What would be right.
        remedy: String,
    },
    /// The header is well-formed but asks for something that this reader lacks.
    #[error("{place}: {found} is not supported; supported: {supported}")]
    Unsupported {
        /// Where it is asked for.
        place: Place,
        /// The requested value.
        found: String,
        /// The possible values.
        supported: String,
    },
    /// The volume exceeds [`super::MAX_VOLUME_BYTES`].
    #[error(
        "{place}: {what} take {bytes} bytes, more than the limit of {} (2^33); crop or downsample the volume",
        super::MAX_VOLUME_BYTES
    )]
    TooLarge {
        /// Where the size is claimed.
        place: Place,
        /// The claim: voxels along x, y, z, channels, frames.
        what: String,
        /// Claimed bytes, uncompressed: the larger of the sizes in the file and in memory.
        bytes: u128,
    },
    /// The volume is within the limit, but this machine cannot hold it.
    #[error(
        "{place}: no memory for {bytes} bytes of voxels{}; crop or downsample the volume",
        may_be_taken()
    )]
    Memory {
        /// The file or generator.
        place: Place,
        /// Bytes that could not be allocated.
        bytes: u64,
    },
    /// The data do not agree with the header.
    #[error("{place}: {problem}; {remedy}")]
    Data {
        /// The data file.
        place: Place,
        /// The problem.
        problem: String,
        /// What would be right.
        remedy: String,
    },
    /// A compressed stream is broken, or cut short in the middle.
    #[error(
        "{place}: the {stream} stream is damaged after {decoded} of {needed} bytes ({source}); \
         fetch the file again"
    )]
    Damaged {
        /// The data file.
        place: Place,
        /// Name of the compression.
        stream: &'static str,
        /// Bytes that decoded.
        decoded: u64,
        /// Bytes that the header claims.
        needed: u64,
        /// The decompressor's reason.
        source: std::io::Error,
    },
    /// A pattern or folder that holds no file that could be read.
    #[error("{place}: {problem}; {remedy}")]
    NoFiles {
        /// The pattern or folder.
        place: Place,
        /// The missing part.
        problem: String,
        /// What would be right.
        remedy: String,
    },
}
