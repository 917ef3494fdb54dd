//! The promises of a file held against its pages.

use tiff::decoder::ifd::Value;
use tiff::tags::{Tag, Type};

use super::super::super::{InputError, Place};
use super::super::{Slice, Stack};
use super::description::read;
use super::promise::{Promise, Spacing};
use super::{Pages, broken};

/// Longest description that is looked at. OME-XML of many planes takes some mebibytes.
const MAX_DESCRIPTION_BYTES: u64 = 16 << 20;
const NEW_SUBFILE_TYPE: u16 = 254;
const IMAGE_DEPTH: u16 = 32997;
/// Tags with which microscopes describe axes, and their vendors.
const MICROSCOPES: [(u16, &str); 4] =
    [(33628, "MetaMorph"), (33629, "MetaMorph"), (34361, "FluoView"), (34412, "Zeiss LSM")];

const ONE_SLICE_PER_PAGE: &str = "a page for each slice of one channel and one time step; save each channel, and each time \
                                  step, as a file of its own";

/// Promises of the pages of one file so far.
#[derive(Default)]
pub(super) struct Pledges {
    /// Each promise with the pages from its own on, up to the next one's.
    series: Vec<(Promise, u64)>,
    /// Pages before the first promise.
    before: u64,
    spacing: Option<[f64; 3]>,
}

impl Pledges {
    /// Takes up a page, before its pixels are read.
    ///
    /// # Errors
    /// When the page is not a slice of its own, or something else than slices is promised.
    pub fn page(&mut self, pages: &mut Pages, slice: Slice, place: &Place) -> Result<(), InputError> {
        let unsupported = |found: String| InputError::Unsupported {
            place: place.clone(),
            found,
            supported: ONE_SLICE_PER_PAGE.to_owned(),
        };
        let number = |pages: &mut Pages, tag: u16| {
            let value = pages.find_tag_unsigned::<u32>(Tag::from_u16_exhaustive(tag));
            value.map_err(|e| broken(place, e))
        };
        // Bit 0: a reduced copy; bit 2: a mask.
        if number(pages, NEW_SUBFILE_TYPE)?.is_some_and(|bits| bits & 5 != 0) {
            return Err(unsupported("a page that is a reduced copy or a mask of another".to_owned()));
        }
        if let Some(depth) = number(pages, IMAGE_DEPTH)?.filter(|depth| *depth > 1) {
            return Err(unsupported(format!("a page of {depth} slices (`ImageDepth`)")));
        }
        let ifd = pages.image_ifd();
        let vendor =
            MICROSCOPES.iter().find(|(tag, _)| ifd.find_entry(Tag::from_u16_exhaustive(*tag)).is_some());
        if let Some((tag, vendor)) = vendor {
            return Err(unsupported(format!("a file whose axes {vendor} describes (tag {tag})")));
        }
        let promise = description(pages, place)?.map(|text| read(&text, slice)).transpose();
        let refused = |problem: String| InputError::Data {
            place: Place::Part { file: file_of(place), part: "description of a page".to_owned() },
            problem,
            remedy: format!("supported: {ONE_SLICE_PER_PAGE}"),
        };
        match promise.map_err(refused)?.flatten() {
            None => match self.series.last_mut() {
                Some((_, pages)) => *pages += 1,
                None => self.before += 1,
            },
            Some(promise) => {
                if promise.frames > 1 || promise.channels > 1 {
                    let by = promise.by;
                    return Err(unsupported(format!("a file that promises {} ({by})", promise.words())));
                }
                if self.series.is_empty() {
                    self.spacing = spacing(pages, &promise);
                }
                self.series.push((promise, 1));
            }
        }
        Ok(())
    }

    /// Compares the promises with the pages that were there.
    ///
    /// # Errors
    /// When there were fewer or more, or several series.
    pub fn finish(self, stack: &mut Stack, place: &Place) -> Result<(), InputError> {
        stack.space(self.spacing, place)?;
        let Some((first, _)) = self.series.first() else { return Ok(()) };
        if first.files.len() > 1 {
            // The file is one of several.
            stack.promised = first.pages.map(|pages| (pages, place.clone()));
            return Ok(());
        }
        let all: u64 = self.series.iter().map(|(_, pages)| pages).sum();
        // Some programs repeat the description on every page.
        let is_repeated = self.series.iter().all(|(promise, _)| promise == first);
        if is_repeated && first.pages.is_none_or(|pages| pages == all) && self.before == 0 {
            return Ok(());
        }
        let refused = |problem: String, remedy: &str| InputError::Data {
            place: place.clone(),
            problem,
            remedy: remedy.to_owned(),
        };
        for (promise, pages) in &self.series {
            if promise.pages.is_some_and(|promised| promised != *pages) {
                let is = if *pages == 1 { "1 page is" } else { &format!("{pages} pages are") };
                return Err(refused(
                    format!("{} promises {}, and {is} there", promise.by, promise.words()),
                    "save it with a page for each slice (ImageJ and tifffile write the slices of a large stack behind one \
                     page: OME-TIFF and BigTIFF have one for each), or as NRRD",
                ));
            }
        }
        let is_one = self.series.len() == 1 && self.before == 0;
        if !is_one && (self.before > 1 || self.series.iter().any(|(_, pages)| *pages != 1)) {
            let count = self.series.len() + usize::from(self.before > 0);
            return Err(refused(
                format!("{count} series of pages are in one file"),
                "save each as a file of its own",
            ));
        }
        Ok(())
    }
}

fn file_of(place: &Place) -> std::path::PathBuf {
    match place {
        Place::Part { file, .. } | Place::File(file) | Place::Line { file, .. } => file.clone(),
        Place::Data { data, .. } => data.clone(),
        Place::Generator(_) => std::path::PathBuf::new(),
    }
}

/// The description of the current page, up to its first zero byte. Bytes that are not UTF-8 are replaced: old programs
/// write the sign of micro in their own encoding.
fn description(pages: &mut Pages, place: &Place) -> Result<Option<String>, InputError> {
    let mut ifd = pages.image_ifd();
    let Some(entry) = ifd.find_entry(Tag::ImageDescription) else { return Ok(None) };
    // Other types are not text.
    if !matches!(entry.field_type(), Type::ASCII | Type::BYTE | Type::UNDEFINED) {
        return Ok(None);
    }
    let bytes = entry.count();
    if bytes > MAX_DESCRIPTION_BYTES {
        return Err(InputError::Header {
            place: place.clone(),
            problem: format!(
                "the description takes {bytes} bytes, and more than {MAX_DESCRIPTION_BYTES} are not read"
            ),
            remedy: "save the stack without it".to_owned(),
        });
    }
    let mut text = vec![0; usize::try_from(bytes).unwrap_or(0)];
    let read = ifd.find_tag_bytes(Tag::ImageDescription, &mut text, 0).map_err(|e| broken(place, e))?;
    text.truncate(read.unwrap_or(0));
    let end = text.iter().position(|b| *b == 0).unwrap_or(text.len());
    Ok(Some(String::from_utf8_lossy(&text[..end]).into_owned()))
}

/// Spacing along x, y, z, where it is known of all.
fn spacing(pages: &mut Pages, promise: &Promise) -> Option<[f64; 3]> {
    match promise.spacing {
        Spacing::Unknown => None,
        Spacing::Is(spacing) => Some(spacing),
        Spacing::Resolution(z) => {
            let mut length = |tag| {
                let (pixels, units) = match pages.find_tag(tag).ok()? {
                    Some(Value::Rational(n, d)) => (f64::from(n), f64::from(d)),
                    _ => return None,
                };
                Some(units / pixels).filter(|length| length.is_finite() && *length > 0.0)
            };
            Some([length(Tag::XResolution)?, length(Tag::YResolution)?, z])
        }
    }
}
