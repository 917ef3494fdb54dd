//! What text headers have in common: numbered lines, named fields that occur once, numbers.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use super::payload::open_regular;
use super::{InputError, Place};

/// Longest header that is looked at. Real ones take a few hundred bytes, or some KiB with key/value pairs.
const MAX_HEADER_BYTES: u64 = 1 << 20;

/// The beginning of a file, where a header may be.
pub(super) struct HeaderText {
    path: PathBuf,
    bytes: Vec<u8>,
}

/// One line of a header, without its line break.
pub(super) struct Line<'a> {
    /// Counted from 1.
    pub number: usize,
    /// The text, without white space at its end. Bytes that are not UTF-8 are replaced.
    pub text: Cow<'a, str>,
    /// Offset in the file of the first byte after the line break.
    pub end: u64,
}

impl HeaderText {
    /// # Errors
    /// When the file cannot be read.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let place = Place::file(path);
        let (file, _) = open_regular(path, &place)?;
        let mut bytes = Vec::new();
        file.take(MAX_HEADER_BYTES).read_to_end(&mut bytes).map_err(|source| InputError::Io {
            place,
            action: "read the header",
            source,
        })?;
        Ok(Self { path: path.to_owned(), bytes })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The first bytes, escaped for a message.
    pub fn start(&self) -> String {
        self.bytes.iter().take(16).flat_map(|&b| std::ascii::escape_default(b)).map(char::from).collect()
    }

    /// The beginning of the file, at most [`MAX_HEADER_BYTES`].
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    pub fn starts_with(&self, magic: &[u8]) -> bool {
        self.bytes.starts_with(magic)
    }

    /// The lines from the first on. Behind the header they are data, so the caller stops at its end.
    pub fn lines(&self) -> impl Iterator<Item = Line<'_>> {
        let mut end = 0;
        self.bytes.split_inclusive(|&b| b == b'\n').enumerate().map(move |(i, line)| {
            end += line.len() as u64;
            Line { number: i + 1, text: trimmed(String::from_utf8_lossy(line)), end }
        })
    }

    /// The place of a line.
    pub fn place(&self, line: usize) -> Place {
        Place::Line { file: self.path.clone(), line }
    }

    /// The error of a line that is nothing the format knows.
    pub fn malformed(&self, line: &Line<'_>, remedy: &str) -> InputError {
        InputError::Header {
            place: self.place(line.number),
            problem: format!("{} is no header line", shown(&line.text)),
            remedy: remedy.to_owned(),
        }
    }
}

fn trimmed(text: Cow<'_, str>) -> Cow<'_, str> {
    match text {
        Cow::Borrowed(text) => Cow::Borrowed(text.trim_end()),
        Cow::Owned(text) => Cow::Owned(text.trim_end().to_owned()),
    }
}

/// A quotation of foreign text, safe to print: escaped, and cut where it gets long.
pub(super) fn shown(text: &str) -> String {
    const LONGEST: usize = 60;
    let cut: String = text.chars().take(LONGEST).flat_map(char::escape_debug).collect();
    let more = if text.chars().nth(LONGEST).is_some() { "…" } else { "" };
    format!("`{cut}{more}`")
}

/// One field of a header.
#[derive(Clone, Debug)]
pub(super) struct Field {
    /// Its line.
    pub place: Place,
    /// Line number, from 1.
    pub line: usize,
    /// Name as the file spells it.
    pub name: String,
    /// Value without surrounding white space.
    pub value: String,
}

impl Field {
    /// A field on a line of `text`.
    pub fn on(text: &HeaderText, line: &Line<'_>, name: &str, value: &str) -> Self {
        Self {
            place: text.place(line.number),
            line: line.number,
            name: name.trim().to_owned(),
            value: value.trim().to_owned(),
        }
    }

    /// The value breaks the rules; `wanted` is a noun phrase that says what would not.
    pub fn malformed(&self, wanted: &str) -> InputError {
        InputError::Header {
            place: self.place.clone(),
            problem: format!("`{}` is {}", self.name, shown(&self.value)),
            remedy: format!("wanted: {wanted}"),
        }
    }

    /// The value is legal in its format, but not supported here.
    pub fn unsupported(&self, supported: &str) -> InputError {
        InputError::Unsupported {
            place: self.place.clone(),
            found: format!("`{}` {}", self.name, shown(&self.value)),
            supported: supported.to_owned(),
        }
    }

    /// This field contradicts `other`.
    pub fn conflicts(&self, other: &Self) -> InputError {
        InputError::Header {
            place: self.place.clone(),
            problem: format!("`{}` contradicts `{}` of line {}", self.name, other.name, other.line),
            remedy: "keep one of the two".to_owned(),
        }
    }

    /// Exactly `N` numbers, separated by white space.
    pub fn numbers<T: FromStr, const N: usize>(&self, wanted: &str) -> Result<[T; N], InputError> {
        let numbers: Result<Vec<T>, _> = self.value.split_whitespace().map(str::parse).collect();
        numbers.ok().and_then(|n| n.try_into().ok()).ok_or_else(|| self.malformed(wanted))
    }

    /// Exactly one number.
    pub fn number<T: FromStr>(&self, wanted: &str) -> Result<T, InputError> {
        self.numbers::<T, 1>(wanted).map(|[n]| n)
    }

    /// Exactly `count` numbers, separated by white space.
    pub fn numbers_of<T: FromStr>(&self, count: usize, wanted: &str) -> Result<Vec<T>, InputError> {
        let numbers: Result<Vec<T>, _> = self.value.split_whitespace().map(str::parse).collect();
        numbers.ok().filter(|n| n.len() == count).ok_or_else(|| self.malformed(wanted))
    }

    /// Elements along each of `axes` axes; none of them zero.
    pub fn sizes(&self, axes: usize) -> Result<Vec<u32>, InputError> {
        let wanted = match axes {
            3 => "three whole numbers from 1 to 4294967295, the voxels along x, y and z".to_owned(),
            n => format!("{n} whole numbers from 1 to 4294967295, one for each axis"),
        };
        let sizes = self.numbers_of(axes, &wanted)?;
        if sizes.contains(&0) { Err(self.malformed(&wanted)) } else { Ok(sizes) }
    }

    /// Spacing along x, y, z; each positive and finite.
    pub fn spacing(&self) -> Result<[f64; 3], InputError> {
        let wanted =
            "three positive, finite lengths, the spacing along x, y and z (without the field: 1 1 1)";
        let spacing: [f64; 3] = self.numbers(wanted)?;
        if spacing.iter().all(|s| s.is_finite() && *s > 0.0) {
            Ok(spacing)
        } else {
            Err(self.malformed(wanted))
        }
    }
}

/// The fields of one header, each at most once.
pub(super) struct Fields {
    path: PathBuf,
    by_name: BTreeMap<String, Field>,
}

impl Fields {
    pub fn of(text: &HeaderText) -> Self {
        Self { path: text.path().to_owned(), by_name: BTreeMap::new() }
    }

    /// Adds a field under its normalised name.
    ///
    /// # Errors
    /// When the header has it already.
    pub fn add(&mut self, normalised: String, field: Field) -> Result<(), InputError> {
        match self.by_name.get(&normalised) {
            Some(first) => Err(InputError::Header {
                place: field.place,
                problem: format!("`{}` stands in line {} already", field.name, first.line),
                remedy: "keep one of the two".to_owned(),
            }),
            None => {
                self.by_name.insert(normalised, field);
                Ok(())
            }
        }
    }

    /// The header's file.
    pub fn file(&self) -> Place {
        Place::file(&self.path)
    }

    pub fn get(&self, normalised: &str) -> Option<&Field> {
        self.by_name.get(normalised)
    }

    /// A field that must be there; `example` is a line that would do.
    ///
    /// # Errors
    /// When it is not.
    pub fn require(&self, normalised: &str, example: &str) -> Result<&Field, InputError> {
        self.get(normalised).ok_or_else(|| self.missing(example))
    }

    /// The error of a missing line.
    pub fn missing(&self, example: &str) -> InputError {
        let name = example.split([':', '=']).next().unwrap_or_default().trim();
        InputError::Header {
            place: Place::file(&self.path),
            problem: format!("the header has no `{name}`"),
            remedy: format!("add a line like `{example}`"),
        }
    }
}

/// Whether a data file's name is a pattern for a series of files: `%03d` followed by numbers.
pub(super) fn is_file_pattern(name: &str) -> bool {
    let mut words = name.split_whitespace();
    let numbers = words.clone().skip(1).count();
    name.contains('%') && numbers >= 2 && words.all(|w| w.contains('%') || w.parse::<i64>().is_ok())
}
