//! What the description of a page promises: so many pages, and what they are. Pages are slices here, so that a file of
//! channels, frames, or slices without a page must not be read as a stack.

use std::collections::BTreeSet;

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
    /// Slices, if they are counted separately from pages.
    pub slices: Option<u64>,
    /// Spacing along x, y, z, where all three are known; x and y of ImageJ stand in tags.
    pub spacing: Spacing,
    /// Files that it is about, where it names any.
    pub files: BTreeSet<String>,
}

/// Spacing in a description.
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

    /// The promise as a noun phrase: "3 frames of 2 channels of 5 slices".
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
