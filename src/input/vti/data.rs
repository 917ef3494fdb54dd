//! The values of one array.

use std::io::{BufRead, BufReader, Error, ErrorKind, Read, Result, Seek as _, SeekFrom};
use std::path::Path;

use cvr_core::volume::StoredType;

use super::super::header::shown;
use super::super::layout::StoredLayout;
use super::super::payload::open_regular;
use super::super::samples::{ReadFault, SampleSink, read_samples};
use super::super::{ByteOrder, InputError, InputVolume, Place};
use super::appended::{Section, has_more};
use super::base64::Base64;
use super::blocks::{Blocks, word};
use super::header::{Array, Format, Header};

/// Reads the values of `array`.
pub(super) fn read(
    path: &Path,
    header: &Header,
    array: &Array,
    layout: &StoredLayout,
) -> std::result::Result<InputVolume, InputError> {
    let place = Place::part(path, format!("array {}", shown(&array.name)));
    let io = |source| InputError::Io { place: place.clone(), action: "read the values", source };
    let memory = || InputError::Memory { place: place.clone(), bytes: layout.layout.bytes() };
    let wrong = |problem: String, remedy: &str| InputError::Data {
        place: place.clone(),
        problem,
        remedy: remedy.to_owned(),
    };
    let (at, is_base64) = match (array.format, header.appended) {
        (Format::Ascii(at), _) => (at, false),
        (Format::Binary(at), _) => (at, true),
        (Format::Appended(offset), Some(appended)) => {
            (appended.offset.saturating_add(offset), appended.is_base64)
        }
        (Format::Appended(_), None) => {
            return Err(wrong("its values are appended, and there is no <AppendedData>".to_owned(), FETCH));
        }
    };
    let (file, length) = open_regular(path, &place)?;
    let mut file = BufReader::with_capacity(1 << 16, file);
    let section = match (array.format, header.appended) {
        (Format::Appended(_), Some(appended)) => {
            let section = Section::find(&mut file, length, header, appended).map_err(io)?;
            Some(section.ok_or_else(|| {
                wrong("its values are appended, and `</AppendedData>` does not follow them".to_owned(), FETCH)
            })?)
        }
        _ => None,
    };
    let most = section.as_ref().map_or(u64::MAX, |section| section.end_of(at).saturating_sub(at));
    file.seek(SeekFrom::Start(at.min(length))).map_err(io)?;
    let count = usize::try_from(layout.layout.samples()).map_err(|_| memory())?;
    let mut sink = SampleSink::new(layout.stored, None);
    let order = header.byte_order;
    let needed = layout.bytes();
    let mut take = |stream: &mut dyn Read, order| {
        read_samples(&mut sink, stream, order, count, false).map_err(|fault| match fault {
            ReadFault::Short(found) => wrong(
                format!("{}, but only {found} are there", layout.need()),
                "correct the extent, or fetch the file again",
            ),
            ReadFault::Failed(decoded, source) => {
                InputError::Damaged { place: place.clone(), stream: "value", decoded, needed, source }
            }
            ReadFault::Memory => memory(),
        })
    };
    let damaged =
        |source| InputError::Damaged { place: place.clone(), stream: "value", decoded: 0, needed, source };
    // Text ends at the next element, and nothing but white space may be left before it.
    let left = |text: &mut dyn Read| match has_more(text) {
        Ok(false) => Ok(()),
        Ok(true) => Err(wrong(format!("{}, and more values follow", layout.need()), "correct the extent")),
        Err(source) => Err(damaged(source)),
    };
    match (array.format, is_base64, header.is_compressed) {
        (Format::Ascii(_), ..) => {
            let mut text = Ascii { source: &mut file, stored: layout.stored, pending: Vec::new(), given: 0 };
            take(&mut text, ByteOrder::NATIVE)?;
            left(&mut text)?;
        }
        (_, is_base64, true) => {
            let mut source = Source::of((&mut file).take(most), is_base64);
            let mut blocks = Blocks::new(&mut source, header.word_bytes, order, needed).map_err(damaged)?;
            take(&mut blocks, order)?;
            source.left(left)?;
        }
        (_, is_base64, false) => {
            let mut source = Source::of((&mut file).take(most), is_base64);
            let claimed = word(&mut source, header.word_bytes, order).map_err(damaged)?;
            if claimed != needed {
                return Err(wrong(
                    format!("{}, but the array has {claimed}", layout.need()),
                    "correct the extent, the type, the byte order or `header_type`",
                ));
            }
            take(&mut source, order)?;
            source.left(left)?;
        }
    }
    if let Some(section) = section {
        section.check(&mut file).map_err(io)?.map_err(|problem| wrong(problem, FETCH))?;
    }
    InputVolume::new(layout, sink).map_err(|problem| wrong(problem, FETCH))
}

const FETCH: &str = "fetch or save the file again";

/// Binary values.
enum Source<R> {
    Raw(R),
    Base64(Base64<R>),
}

impl<R: BufRead> Source<R> {
    fn of(file: R, is_base64: bool) -> Self {
        if is_base64 { Self::Base64(Base64::new(file)) } else { Self::Raw(file) }
    }

    /// What is left of base64; raw bytes are held against what follows by [`Section::check`].
    fn left<E>(
        &mut self,
        check: impl FnOnce(&mut dyn Read) -> std::result::Result<(), E>,
    ) -> std::result::Result<(), E> {
        match self {
            Self::Raw(_) => Ok(()),
            Self::Base64(text) => check(text),
        }
    }
}

impl<R: BufRead> Read for Source<R> {
    fn read(&mut self, out: &mut [u8]) -> Result<usize> {
        match self {
            Self::Raw(file) => file.read(out),
            Self::Base64(text) => text.read(out),
        }
    }
}

/// Numbers as text, turned into bytes of this machine's order.
struct Ascii<R> {
    source: R,
    stored: StoredType,
    pending: Vec<u8>,
    given: usize,
}

/// Longest number: that of the smallest double, written out in full.
const MAX_NUMBER_CHARACTERS: usize = 1100;

impl<R: BufRead> Ascii<R> {
    /// The next number's characters; none before the next element, or at the end.
    fn token(&mut self) -> Result<Vec<u8>> {
        let mut token = Vec::new();
        loop {
            let Some(&byte) = self.source.fill_buf()?.first() else { return Ok(token) };
            if byte == b'<' || (byte.is_ascii_whitespace() && !token.is_empty()) {
                return Ok(token);
            }
            self.source.consume(1);
            if !byte.is_ascii_whitespace() {
                token.push(byte);
            }
            if token.len() > MAX_NUMBER_CHARACTERS {
                return Err(Error::new(ErrorKind::InvalidData, "a number without end"));
            }
        }
    }
}

impl<R: BufRead> Read for Ascii<R> {
    fn read(&mut self, out: &mut [u8]) -> Result<usize> {
        if self.given == self.pending.len() {
            let token = self.token()?;
            self.given = 0;
            self.pending.clear();
            if token.is_empty() {
                return Ok(0);
            }
            let text = String::from_utf8_lossy(&token);
            self.pending = number(&text, self.stored).ok_or_else(|| {
                Error::new(ErrorKind::InvalidData, format!("{} is no {}", shown(&text), self.stored))
            })?;
        }
        let n = (&self.pending[self.given..]).read(out)?;
        self.given += n;
        Ok(n)
    }
}

fn number(text: &str, stored: StoredType) -> Option<Vec<u8>> {
    Some(match stored {
        StoredType::U8 => text.parse::<u8>().ok()?.to_ne_bytes().to_vec(),
        StoredType::I8 => text.parse::<i8>().ok()?.to_ne_bytes().to_vec(),
        StoredType::U16 => text.parse::<u16>().ok()?.to_ne_bytes().to_vec(),
        StoredType::I16 => text.parse::<i16>().ok()?.to_ne_bytes().to_vec(),
        StoredType::U32 => text.parse::<u32>().ok()?.to_ne_bytes().to_vec(),
        StoredType::I32 => text.parse::<i32>().ok()?.to_ne_bytes().to_vec(),
        StoredType::U64 => text.parse::<u64>().ok()?.to_ne_bytes().to_vec(),
        StoredType::I64 => text.parse::<i64>().ok()?.to_ne_bytes().to_vec(),
        StoredType::F32 => text.parse::<f32>().ok()?.to_ne_bytes().to_vec(),
        StoredType::F64 => text.parse::<f64>().ok()?.to_ne_bytes().to_vec(),
    })
}
