//! Volumes from pictures: each is one slice along z, row by row, x fastest. Spacing is 1 where a file does not say it
//! of all three axes.

mod order;
mod png;
mod tiff;

pub(super) use order::sort_naturally;

use std::path::{Path, PathBuf};

use cvr_core::volume::StoredType;

use super::header::HeaderText;
use super::layout::{Shape, StoredLayout};
use super::samples::{NoMemory, SampleSink};
use super::{ByteOrder, InputError, InputVolume, Place};

/// Content of one picture.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
struct Slice {
    width: u32,
    height: u32,
    channels: u32,
    stored: StoredType,
}

impl Slice {
    /// The layout of a stack of this many slices.
    fn layout(self, place: &Place, depth: u32, spacing: [f64; 3]) -> Result<StoredLayout, InputError> {
        let dims = [self.width, self.height, depth];
        let shape = Shape { channels: self.channels, ..Shape::scalar(dims) };
        StoredLayout::new(place, shape, spacing, self.stored)
    }

    fn words(self) -> String {
        let channels = if self.channels == 1 { "gray" } else { "RGB" };
        format!("{}×{} pixels of {channels} {}", self.width, self.height, self.stored)
    }
}

/// Slices that grow into a volume.
#[derive(Default)]
struct Stack {
    first: Option<Slice>,
    sink: Option<SampleSink>,
    depth: u32,
    /// Spacing that every file states, if it states all axes.
    spacing: Option<Option<[f64; 3]>>,
    /// Slices that a file promised of itself and others together, and where.
    promised: Option<(u64, Place)>,
}

impl Stack {
    /// Checks that a slice fits those before it and that the volume does not grow too large; to be called before any
    /// of its pixels is decoded. Returns its bytes.
    fn expect(&mut self, slice: Slice, place: &Place) -> Result<usize, InputError> {
        let first = *self.first.get_or_insert(slice);
        if first != slice {
            return Err(InputError::Data {
                place: place.clone(),
                problem: format!("a slice of {} after one of {}", slice.words(), first.words()),
                remedy: "all slices of a volume are alike: remove what does not belong to it".to_owned(),
            });
        }
        slice.layout(place, self.depth.saturating_add(1), [1.0; 3])?;
        let bytes = slice.layout(place, 1, [1.0; 3])?.bytes();
        cvr_core::memory::check(bytes, String::new)
            .map_err(|_| InputError::Memory { place: place.clone(), bytes })?;
        usize::try_from(bytes).map_err(|_| InputError::Memory { place: place.clone(), bytes })
    }

    /// Notes what a file says of the spacing.
    fn space(&mut self, spacing: Option<[f64; 3]>, place: &Place) -> Result<(), InputError> {
        match self.spacing {
            None => self.spacing = Some(spacing),
            Some(first) if first == spacing => {}
            Some(first) => {
                let words =
                    |s: Option<[f64; 3]>| s.map_or("none".to_owned(), |[x, y, z]| format!("{x} {y} {z}"));
                return Err(InputError::Data {
                    place: place.clone(),
                    problem: format!("spacing {} after {}", words(spacing), words(first)),
                    remedy: "all slices of a volume are alike: remove what does not belong to it".to_owned(),
                });
            }
        }
        Ok(())
    }

    /// Appends the pixels of a slice that was expected.
    fn push(
        &mut self,
        slice: Slice,
        pixels: &[u8],
        order: ByteOrder,
        place: &Place,
    ) -> Result<(), InputError> {
        let sink = self.sink.get_or_insert_with(|| SampleSink::new(slice.stored, None));
        let count = pixels.len() / slice.stored.bytes();
        // Doubling, so that a thousand slices are not copied a thousand times.
        if sink.room() < count {
            let more = count.max(sink.len());
            let reserved = sink.reserve(more).or_else(|NoMemory| sink.reserve(count));
            reserved.map_err(|NoMemory| InputError::Memory {
                place: place.clone(),
                bytes: pixels.len() as u64,
            })?;
        }
        sink.push(pixels, order);
        self.depth += 1;
        Ok(())
    }

    fn finish(self, place: &Place) -> Result<InputVolume, InputError> {
        let (Some(slice), Some(sink)) = (self.first, self.sink) else {
            return Err(InputError::Data {
                place: place.clone(),
                problem: "there is no picture in it".to_owned(),
                remedy: "give a stack of slices".to_owned(),
            });
        };
        if let Some((promised, place)) = self.promised
            && promised != u64::from(self.depth)
        {
            return Err(InputError::Data {
                place,
                problem: format!(
                    "{promised} slices are promised in several files, and {} are there",
                    self.depth
                ),
                remedy: "give the folder that holds all of them".to_owned(),
            });
        }
        let spacing = self.spacing.flatten().unwrap_or([1.0; 3]);
        let layout = slice.layout(place, self.depth, spacing)?;
        InputVolume::new(&layout, sink).map_err(|problem| InputError::Data {
            place: place.clone(),
            problem,
            remedy: "this is a fault of the reader".to_owned(),
        })
    }
}

/// A file of pictures, by its first bytes.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Pictures {
    Tiff,
    Png,
}

impl Pictures {
    /// `None` for files that are none.
    pub fn of(start: &[u8]) -> Option<Self> {
        match start {
            [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => Some(Self::Tiff),
            [0x89, b'P', b'N', b'G', ..] => Some(Self::Png),
            _ => None,
        }
    }

    /// By a file's name.
    fn named(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "tif" | "tiff" => Some(Self::Tiff),
            "png" => Some(Self::Png),
            _ => None,
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Tiff => "TIFF",
            Self::Png => "PNG",
        }
    }

    fn add(self, path: &Path, stack: &mut Stack) -> Result<(), InputError> {
        match self {
            Self::Tiff => tiff::add_pages(path, stack),
            Self::Png => png::add(path, stack),
        }
    }
}

/// Reads the slices of one file.
pub(super) fn read_file(text: &HeaderText, pictures: Pictures) -> Result<InputVolume, InputError> {
    let mut stack = Stack::default();
    pictures.add(text.path(), &mut stack)?;
    stack.finish(&Place::file(text.path()))
}

/// Reads the TIFF or PNG files of a folder as slices, in the order of the numbers in their names. Files of other
/// kinds are passed over.
pub(super) fn read_folder(folder: &Path) -> Result<InputVolume, InputError> {
    let place = Place::file(folder);
    let none = |problem: &str, remedy: &str| InputError::NoFiles {
        place: place.clone(),
        problem: problem.to_owned(),
        remedy: remedy.to_owned(),
    };
    let files: Vec<(PathBuf, Pictures)> =
        files_of(folder)?.into_iter().filter_map(|p| Pictures::named(&p).map(|kind| (p, kind))).collect();
    let Some((_, kind)) = files.first() else {
        return Err(none(
            "the folder holds no slices",
            "give a folder of .tif, .tiff or .png files; headerless files need their layout: dims and dtype",
        ));
    };
    if files.iter().any(|(_, other)| other != kind) {
        return Err(none("the folder holds TIFF files and PNG files", "move one kind elsewhere"));
    }
    let mut stack = Stack::default();
    for (file, kind) in &files {
        kind.add(file, &mut stack)?;
    }
    stack.finish(&place)
}

/// The files of a folder, hidden ones apart, in the order of the numbers in their names.
pub(super) fn files_of(folder: &Path) -> Result<Vec<PathBuf>, InputError> {
    let io = |source| InputError::Io { place: Place::file(folder), action: "list the folder", source };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let entry = entry.map_err(io)?;
        let is_hidden = entry.file_name().to_string_lossy().starts_with('.');
        // Through links, as opening would.
        if !is_hidden && std::fs::metadata(entry.path()).is_ok_and(|m| m.is_file()) {
            files.push(entry.path());
        }
    }
    sort_naturally(&mut files);
    Ok(files)
}

/// Refuses pixels that a file of `available` bytes cannot hold, before memory is reserved for them. `ratio` is the
/// most that a byte of it can become.
fn check_claim(
    place: &Place,
    format: Pictures,
    needed: u64,
    available: u64,
    ratio: u64,
) -> Result<(), InputError> {
    if needed <= available.saturating_mul(ratio) {
        return Ok(());
    }
    Err(InputError::Data {
        place: place.clone(),
        problem: format!(
            "the pixels take {needed} bytes, which a {} file of {available} bytes cannot hold",
            format.name()
        ),
        remedy: "the file is cut short, or its header lies: save it again".to_owned(),
    })
}
