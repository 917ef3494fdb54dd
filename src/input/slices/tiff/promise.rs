//! What the description of a page promises: so many pages, and what they are. Pages are slices here, so that a file of
//! channels, frames, or slices without a page must not be read as a stack.

use std::collections::BTreeSet;

use super::super::Slice;
use super::ome;

/// The promise of one description.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Promise {
    /// Who made it, for messages: "ImageJ".
    pub by: &'static str,
    /// Pages that should be there; `None` if that is not said.
    pub pages: Option<u64>,
    /// Time steps.
    pub frames: u64,
    /// Channels in pages of their own.
    pub channels: u64,
    /// Slices, where they are told apart from pages.
    pub slices: Option<u64>,
    /// Spacing along x, y, z, where all three are known; x and y of ImageJ stand in tags.
    pub spacing: Spacing,
    /// Files that it is about, where it names any.
    pub files: BTreeSet<String>,
}

/// What a description says of the spacing.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) enum Spacing {
    Unknown,
    /// Along x, y, z.
    Is([f64; 3]),
    /// Along z; the resolution tags count pixels of the same unit of length.
    Resolution(f64),
}

impl Promise {
    pub fn new(by: &'static str) -> Self {
        Self {
            by,
            pages: None,
            frames: 1,
            channels: 1,
            slices: None,
            spacing: Spacing::Unknown,
            files: BTreeSet::new(),
        }
    }

    /// What is promised, as a noun phrase: "3 frames of 2 channels of 5 slices".
    pub fn words(&self) -> String {
        let part = |n: u64, name: &str| format!("{n} {name}{}", if n == 1 { "" } else { "s" });
        let mut parts = Vec::new();
        if self.frames != 1 {
            parts.push(part(self.frames, "frame"));
        }
        if self.channels != 1 {
            parts.push(part(self.channels, "channel"));
        }
        match (self.slices, self.pages) {
            (Some(slices), _) => parts.push(part(slices, "slice")),
            (None, Some(pages)) if parts.is_empty() => parts.push(part(pages, "image")),
            _ => {}
        }
        parts.join(" of ")
    }
}

/// The promise of a description, if it is one of ImageJ, `tifffile` or OME. `page` is what the page itself holds.
///
/// # Errors
/// A sentence, when what is promised cannot be told.
pub(super) fn read(description: &str, page: Slice) -> Result<Option<Promise>, String> {
    let text = description.trim_matches(|c: char| c == '\0' || c == '\u{feff}' || c.is_whitespace());
    if text.starts_with("ImageJ=") {
        return imagej(text).map(Some);
    }
    if text.starts_with('{') || text.starts_with("shape=") {
        return shaped(text, page);
    }
    if text.starts_with('<') && ome::looks_like(text) {
        return ome::read(text, page).map(Some);
    }
    Ok(None)
}

/// Lines `key=value`.
fn imagej(text: &str) -> Result<Promise, String> {
    let mut promise = Promise::new("ImageJ");
    let (mut depth, mut has_unit) = (None, false);
    for (key, value) in text.lines().filter_map(|line| line.split_once('=')) {
        let (key, value) = (key.trim(), value.trim());
        let count = || match value.parse::<u64>() {
            Ok(n) if n > 0 => Ok(n),
            _ => Err(format!("`{key}` of ImageJ is {}", shown(value))),
        };
        match key {
            "images" => promise.pages = Some(count()?),
            "channels" => promise.channels = count()?,
            "slices" => promise.slices = Some(count()?),
            "frames" => promise.frames = count()?,
            "unit" => has_unit = !value.is_empty() && value != "pixel",
            "spacing" => {
                depth = value.parse::<f64>().ok().map(f64::abs).filter(|z| z.is_finite() && *z > 0.0);
            }
            _ => {}
        }
    }
    // ImageJ leaves a spacing of 1 out.
    let is_stack = promise.pages.is_some_and(|n| n > 1);
    if depth.is_some() || (has_unit && is_stack) {
        promise.spacing = Spacing::Resolution(depth.unwrap_or(1.0));
    }
    let product = promise.channels.saturating_mul(promise.frames).saturating_mul(promise.slices.unwrap_or(1));
    if let Some(pages) = promise.pages
        && pages != product
        && (promise.slices.is_some() || !pages.is_multiple_of(product))
    {
        return Err(format!(
            "ImageJ promises {pages} images, and {}, which contradict each other",
            promise.words()
        ));
    }
    Ok(promise)
}

/// The shape of the array that `tifffile` was given, as `{"shape": [6, 7, 11]}` or `shape=(6, 7, 11)`.
fn shaped(text: &str, page: Slice) -> Result<Option<Promise>, String> {
    let (shape, axes): (Vec<u64>, String) = if let Some(list) = text.strip_prefix("shape=") {
        let numbers = list.trim_matches(|c| c == '(' || c == ')' || c == ',').split(',');
        let numbers: Result<_, _> = numbers.map(|n| n.trim().parse()).collect();
        let Ok(numbers) = numbers else { return Ok(None) };
        (numbers, String::new())
    } else {
        let Ok(json) = serde_json::from_str::<serde_json::Value>(text) else { return Ok(None) };
        let Some(shape) = json.get("shape").and_then(serde_json::Value::as_array) else { return Ok(None) };
        let Some(shape) = shape.iter().map(serde_json::Value::as_u64).collect() else { return Ok(None) };
        let axes = json.get("axes").and_then(serde_json::Value::as_str).unwrap_or_default();
        (shape, axes.to_ascii_uppercase())
    };
    let told = shape.iter().map(u64::to_string).collect::<Vec<_>>().join("×");
    let letters = if axes.chars().count() == shape.len() { axes } else { "Q".repeat(shape.len()) };
    let mut leading: Vec<(u64, char)> =
        shape.into_iter().zip(letters.chars()).filter(|(n, _)| *n != 1).collect();
    for n in [page.channels, page.width, page.height].map(u64::from).into_iter().filter(|n| *n != 1) {
        if leading.pop().map(|(n, _)| n) != Some(n) {
            return Err(format!("tifffile promises an array of {told}, and the page is {}", page.words()));
        }
    }
    let mut promise = Promise::new("tifffile");
    let mut slices = Vec::new();
    for (n, letter) in leading {
        match letter {
            'T' => promise.frames = promise.frames.saturating_mul(n),
            'C' | 'S' => promise.channels = promise.channels.saturating_mul(n),
            _ => slices.push(n),
        }
    }
    let product = slices.iter().fold(1_u64, |product, n| product.saturating_mul(*n));
    promise.pages = Some(product.saturating_mul(promise.frames).saturating_mul(promise.channels));
    promise.slices = Some(product);
    if slices.len() > 1 {
        return Err(format!(
            "tifffile promises an array of {told}, and of the axes before rows and columns only one can be that of slices"
        ));
    }
    Ok(Some(promise))
}

/// A quotation of foreign text, safe to print.
fn shown(text: &str) -> String {
    super::super::super::header::shown(text)
}

#[cfg(test)]
mod tests {
    use cvr_core::volume::StoredType;

    use super::*;

    const PAGE: Slice = Slice { width: 11, height: 7, channels: 1, stored: StoredType::U16 };

    /// Pages, frames, channels, slices.
    type Counts = (Option<u64>, u64, u64, Option<u64>);

    fn promised(text: &str) -> Result<Option<Counts>, String> {
        read(text, PAGE).map(|p| p.map(|p| (p.pages, p.frames, p.channels, p.slices)))
    }

    #[test]
    fn descriptions_say_how_many_pages_and_of_what() {
        let stack = "ImageJ=1.11a\nimages=6\nslices=6\nhyperstack=true\n";
        assert_eq!(promised(stack), Ok(Some((Some(6), 1, 1, Some(6)))));
        assert_eq!(promised("ImageJ=1.53t\n\0"), Ok(Some((None, 1, 1, None))));
        let all = "ImageJ=1.53t\nimages=30\nchannels=2\nslices=5\nframes=3\nunit=um";
        assert_eq!(promised(all), Ok(Some((Some(30), 3, 2, Some(5)))));
        assert_eq!(promised("ImageJ=1\nimages=4\nframes=4"), Ok(Some((Some(4), 4, 1, None))));
        assert!(promised("ImageJ=1\nimages=7\nslices=6").unwrap_err().contains("contradict"));
        assert!(promised("ImageJ=1\nimages=-1").unwrap_err().contains("`images`"));

        assert_eq!(promised("{\"shape\": [6, 7, 11]}"), Ok(Some((Some(6), 1, 1, Some(6)))));
        assert_eq!(promised("{\"shape\": [7, 11]}"), Ok(Some((Some(1), 1, 1, Some(1)))));
        assert_eq!(promised("{\"shape\": [1, 6, 1, 7, 11, 1]}"), Ok(Some((Some(6), 1, 1, Some(6)))));
        assert_eq!(promised("shape=(6, 7, 11)"), Ok(Some((Some(6), 1, 1, Some(6)))));
        let axes = "{\"axes\": \"TCYX\", \"shape\": [4, 2, 7, 11]}";
        assert_eq!(promised(axes), Ok(Some((Some(8), 4, 2, Some(1)))));
        assert!(promised("{\"shape\": [4, 6, 7, 11]}").unwrap_err().contains("4×6×7×11"));
        assert!(promised("{\"shape\": [6, 8, 11]}").unwrap_err().contains("11×7 pixels"));
        assert_eq!(promised("{\"shape\": \"large\"}"), Ok(None));
        assert_eq!(promised("{not json"), Ok(None));
        let colours = read("{\"shape\": [6, 7, 11, 3]}", Slice { channels: 3, ..PAGE }).unwrap().unwrap();
        assert_eq!((colours.pages, colours.channels), (Some(6), 1));

        assert_eq!(promised("a letter"), Ok(None));
        assert_eq!(promised(""), Ok(None));
    }

    #[test]
    fn spacing_of_imagej_is_that_of_a_stack_with_a_unit() {
        let spacing = |text: &str| imagej(text).unwrap().spacing;
        assert_eq!(spacing("ImageJ=1\nimages=6\nspacing=2.5\nunit=um"), Spacing::Resolution(2.5));
        assert_eq!(spacing("ImageJ=1\nimages=6\nspacing=-2.5"), Spacing::Resolution(2.5));
        assert_eq!(spacing("ImageJ=1\nimages=6\nunit=um"), Spacing::Resolution(1.0));
        assert_eq!(spacing("ImageJ=1\nunit=um"), Spacing::Unknown);
        assert_eq!(spacing("ImageJ=1\nimages=6\nspacing=nan"), Spacing::Unknown);
    }
}
