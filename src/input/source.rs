//! From what was asked for to a volume: one file, a folder, a pattern, or several of them, whose frames follow each
//! other.

use std::path::{Path, PathBuf};

use cvr_core::memory;
use cvr_core::pipeline::RawLayout;
use cvr_core::volume::{BrickSource as _, DenseVolume, Samples, VolumeLayout};

use super::format::{layout_one, open_one};
use super::slices::{files_of, sort_naturally};
use super::{InputError, InputVolume, MAX_VOLUME_BYTES, Place, raw};

/// Reads the volume that these files make up. Each may be a pattern (`step*.raw`, matched where no file has that very
/// name, in the order of the numbers in the names); a folder holds slices, or, of headerless files, frames. Where
/// there are several files, they must be alike, and their frames follow each other.
///
/// `raw` is the layout of each file if it has no header. `spacing` stands in for what the files say.
///
/// # Errors
/// When there is no file, one cannot be read, is damaged or hostile, the files are not alike, or together they are
/// larger than [`MAX_VOLUME_BYTES`].
pub fn read(
    files: &[PathBuf],
    raw: Option<&RawLayout>,
    spacing: Option<[f64; 3]>,
) -> Result<InputVolume, InputError> {
    let found = found(files, raw.is_some())?;
    let read_one = |file: &Path| match raw {
        Some(raw) => raw::read(file, raw)?.read(),
        None => open_one(file),
    };
    let Some((first, others)) = found.split_first() else {
        return Err(InputError::NoFiles {
            place: Place::file(Path::new("volume")),
            problem: "no file is given".to_owned(),
            remedy: "give at least one".to_owned(),
        });
    };
    let mut volume = read_one(first)?;
    if !others.is_empty() {
        volume = sequence(volume, first, others, &read_one)?;
    }
    match spacing {
        Some(spacing) => spaced(volume, spacing, first),
        None => Ok(volume),
    }
}

/// The layout of the volume that [`read`] would read, from headers alone: no voxel is read, and files are opened one
/// after the other. `None` of slices, whose number and size show when they are read.
///
/// # Errors
/// When there is no file, one is missing, its header is damaged or hostile, or its length shows that it is cut
/// short. Whether files match each other is checked when they are read.
pub fn layout(
    files: &[PathBuf],
    raw: Option<&RawLayout>,
    spacing: Option<[f64; 3]>,
) -> Result<Option<VolumeLayout>, InputError> {
    let mut whole: Option<VolumeLayout> = None;
    for file in found(files, raw.is_some())? {
        let one = match raw {
            Some(raw) => Some(raw::read(&file, raw)?.checked()?),
            None => layout_one(&file)?,
        };
        let Some(one) = one else { return Ok(None) };
        match &mut whole {
            Some(whole) => whole.frames = whole.frames.saturating_add(one.layout.frames),
            None => whole = Some(one.layout),
        }
    }
    Ok(whole.map(|layout| VolumeLayout { spacing: spacing.unwrap_or(layout.spacing), ..layout }))
}

/// The files, or folders of slices, that these paths name, in the order of reading.
///
/// # Errors
/// When a pattern matches nothing, or a folder of headerless files is empty.
pub fn found(files: &[PathBuf], is_raw: bool) -> Result<Vec<PathBuf>, InputError> {
    let mut found = Vec::new();
    for file in files {
        found.extend(matches(file, is_raw)?);
    }
    Ok(found)
}

/// The files that a path names, at least one.
fn matches(path: &Path, is_raw: bool) -> Result<Vec<PathBuf>, InputError> {
    let none = |problem: &str, remedy: &str| InputError::NoFiles {
        place: Place::file(path),
        problem: problem.to_owned(),
        remedy: remedy.to_owned(),
    };
    if is_raw && path.is_dir() {
        let files = files_of(path)?;
        return if files.is_empty() {
            Err(none("the folder holds no files", "give one with a file per frame"))
        } else {
            Ok(files)
        };
    }
    if !path.to_str().is_some_and(is_pattern) || path.exists() {
        return Ok(vec![path.to_owned()]);
    }
    let mut files = expanded(path)?;
    sort_naturally(&mut files);
    if files.is_empty() { Err(none("no file matches the pattern", "correct it")) } else { Ok(files) }
}

fn is_pattern(text: &str) -> bool {
    text.contains(['*', '?', '['])
}

/// The files that a pattern matches, part by part of the path: a part that is there by that very name is not a pattern, so
/// that folders may be called `run [2]`.
fn expanded(path: &Path) -> Result<Vec<PathBuf>, InputError> {
    let mut found = vec![PathBuf::new()];
    let mut parts = path.components();
    while let Some(part) = parts.next() {
        // `**` matches any number of parts.
        let is_deep = part.as_os_str() == "**";
        let rest = if is_deep { Path::new("**").join(parts.as_path()) } else { part.as_os_str().into() };
        let mut next = Vec::new();
        for base in found {
            let literal = base.join(part);
            match rest.to_str().filter(|rest| is_pattern(rest)) {
                Some(pattern) if !literal.exists() => next.extend(matched(&base, pattern, path)?),
                _ => next.push(literal),
            }
        }
        found = next;
        if is_deep {
            break;
        }
    }
    found.retain(|path| path.exists());
    Ok(found)
}

/// What a pattern matches in a folder, whose name is taken as it is. `whole` is what was asked for.
fn matched(folder: &Path, pattern: &str, whole: &Path) -> Result<Vec<PathBuf>, InputError> {
    let Some(name) = folder.to_str() else { return Ok(Vec::new()) };
    let pattern = Path::new(&glob::Pattern::escape(name)).join(pattern);
    let paths = glob::glob(&pattern.to_string_lossy()).map_err(|e| InputError::NoFiles {
        place: Place::file(whole),
        problem: format!("this is no pattern ({e})"),
        remedy: "write, for instance, `step*.raw`".to_owned(),
    })?;
    let paths = paths.map(|path| {
        path.map_err(|e| {
            let place = Place::file(e.path());
            InputError::Io { place, action: "list the folder", source: e.into() }
        })
    });
    paths.collect()
}

/// One volume of the frames of all files.
fn sequence(
    first: InputVolume,
    first_file: &Path,
    others: &[PathBuf],
    read_one: &dyn Fn(&Path) -> Result<InputVolume, InputError>,
) -> Result<InputVolume, InputError> {
    let InputVolume { volume, stored, mut rounded } = first;
    let mut layout = volume.layout().clone();
    let mut samples = volume.into_samples();
    // Most sequences have a frame per file: then nothing is ever copied.
    let all = layout.samples().saturating_mul(others.len() as u64 + 1);
    let all_bytes = all.saturating_mul(layout.sample.bytes() as u64);
    memory::check(all_bytes, String::new)
        .map_err(|_| InputError::Memory { place: Place::file(first_file), bytes: all_bytes })?;
    if all_bytes <= MAX_VOLUME_BYTES {
        let more = usize::try_from(all).unwrap_or(usize::MAX) - samples.len();
        reserve(&mut samples, more).ok_or_else(|| InputError::Memory {
            place: Place::file(first_file),
            bytes: all * layout.sample.bytes() as u64,
        })?;
    }
    for file in others {
        let place = Place::file(file);
        let next = read_one(file)?;
        let other = next.volume.layout();
        if (VolumeLayout { frames: layout.frames, ..other.clone() }) != layout {
            return Err(InputError::Data {
                place,
                problem: format!(
                    "a frame of {} after {} of {}",
                    words(other),
                    first_file.display(),
                    words(&layout)
                ),
                remedy: "the files of a sequence have one size, spacing and number type: leave out what is no frame \
                         of it"
                    .to_owned(),
            });
        }
        let frames = layout.frames.checked_add(other.frames);
        let bytes = layout.bytes().saturating_add(other.bytes());
        let Some(frames) = frames.filter(|_| bytes <= MAX_VOLUME_BYTES) else {
            let what = format!("the frames up to this one, of {} each,", words(&layout));
            return Err(InputError::TooLarge { place, what, bytes: bytes.into() });
        };
        rounded += next.rounded;
        append(&mut samples, next.volume.samples()).ok_or(InputError::Memory { place, bytes })?;
        layout.frames = frames;
    }
    let place = Place::file(first_file);
    let volume = DenseVolume::new(layout, samples).map_err(|problem| InputError::Data {
        place,
        problem,
        remedy: "this is a fault of the reader".to_owned(),
    })?;
    Ok(InputVolume { volume, stored, rounded })
}

fn words(layout: &VolumeLayout) -> String {
    let [x, y, z] = layout.spacing;
    let channels = if layout.channels == 1 { "scalars" } else { "RGB" };
    format!("{} {channels} of {} spaced {x} {y} {z}", layout.extent, layout.sample)
}

/// `None` without memory.
fn reserve(samples: &mut Samples, more: usize) -> Option<()> {
    match samples {
        Samples::U8(v) => v.try_reserve_exact(more).ok(),
        Samples::I8(v) => v.try_reserve_exact(more).ok(),
        Samples::U16(v) => v.try_reserve_exact(more).ok(),
        Samples::I16(v) => v.try_reserve_exact(more).ok(),
        Samples::F32(v) => v.try_reserve_exact(more).ok(),
        _ => None,
    }
}

/// `None` without memory. Both are of one type, since their layouts are equal.
fn append(samples: &mut Samples, more: &Samples) -> Option<()> {
    fn joined<T: Copy>(to: &mut Vec<T>, from: &[T]) -> Option<()> {
        to.try_reserve(from.len()).ok()?;
        to.extend_from_slice(from);
        Some(())
    }
    match (samples, more) {
        (Samples::U8(to), Samples::U8(from)) => joined(to, from),
        (Samples::I8(to), Samples::I8(from)) => joined(to, from),
        (Samples::U16(to), Samples::U16(from)) => joined(to, from),
        (Samples::I16(to), Samples::I16(from)) => joined(to, from),
        (Samples::F32(to), Samples::F32(from)) => joined(to, from),
        _ => None,
    }
}

fn spaced(input: InputVolume, spacing: [f64; 3], file: &Path) -> Result<InputVolume, InputError> {
    let layout = VolumeLayout { spacing, ..input.volume.layout().clone() };
    let volume =
        DenseVolume::new(layout, input.volume.into_samples()).map_err(|problem| InputError::Header {
            place: Place::file(file),
            problem,
            remedy: "correct the spacing that was given for it".to_owned(),
        })?;
    Ok(InputVolume { volume, ..input })
}
