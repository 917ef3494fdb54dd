//! Groups and names of cells, as the parts of the report use them.

use std::collections::BTreeSet;

use cvr_core::codec::Site;

use crate::experiment::records::record::{Record, Status};

/// One volume drawn in one scene by one renderer: what pictures and frame times may be compared within.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct View {
    pub(super) volume: String,
    pub(super) scene: String,
    pub(super) renderer: String,
}

impl View {
    pub(super) fn of(record: &Record) -> Self {
        Self { volume: record.volume.clone(), scene: record.scene.clone(), renderer: record.renderer.clone() }
    }

    /// Name without the volume: the parts that differ from other views.
    pub(super) fn name(&self) -> String {
        let parts = [&self.scene, &self.renderer];
        parts.into_iter().filter(|p| !p.is_empty()).cloned().collect::<Vec<_>>().join(", ")
    }
}

/// All views in the order of their first records.
pub(super) fn views(records: &[Record]) -> Vec<View> {
    distinct(records.iter().map(View::of))
}

/// Volumes in the order of their first records.
pub(super) fn volumes(records: &[Record]) -> Vec<String> {
    distinct(records.iter().map(|r| r.volume.clone()))
}

/// Devices in the order of their first records: what times may be compared within.
pub(super) fn devices<'a>(records: impl Iterator<Item = &'a Record>) -> Vec<String> {
    distinct(records.map(|r| r.device.clone()))
}

/// Values in the order of their first appearance.
pub(super) fn distinct<T: Ord + Clone>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut seen = BTreeSet::new();
    values.filter(|v| seen.insert(v.clone())).collect()
}

/// A yardstick that speed is measured by.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Baseline {
    /// Raw texture, hardware linear filter: relative frame time 1.
    Texture,
    /// Raw buffer, manual linear filter.
    Buffer,
}

impl Baseline {
    /// Which baseline a cell is, if any.
    pub(super) fn of(record: &Record) -> Option<Self> {
        if record.codec != "raw" || record.filter != "linear" || record.skipping {
            return None;
        }
        match (record.site.as_str(), record.filtering.as_deref()) {
            ("host", Some("hardware")) => Some(Self::Texture),
            ("inline", _) => Some(Self::Buffer),
            _ => None,
        }
    }

    pub(super) const fn letter(self) -> char {
        match self {
            Self::Texture => 'A',
            Self::Buffer => 'B',
        }
    }

    pub(super) const fn label(self) -> &'static str {
        match self {
            Self::Texture => "baseline: raw texture, hardware linear filter (= 1)",
            Self::Buffer => "baseline: raw buffer, manual linear filter",
        }
    }
}

/// Whether a cell ran and kept its promises.
pub(super) fn ok(record: &Record) -> bool {
    record.status == Status::Ok
}

/// Whether a cell ran, kept its promises, and shows something: only then do its picture and its frame time say anything.
pub(super) fn shown(record: &Record) -> bool {
    ok(record) && !record.shows_nothing()
}

/// Whether a cell compresses; the uncompressed codec is what others are compared with.
pub(super) fn compressed(record: &Record) -> bool {
    record.codec != "raw"
}

/// Whether a filter blends voxels; the optimised linear filter yields the same values as the linear one.
pub(super) fn blends(record: &Record) -> bool {
    record.filter != "nearest"
}

/// Order in which one site is chosen to represent all: they draw the same values.
pub(super) fn site_rank(site: &str) -> usize {
    Site::ALL.iter().position(|s| s.name() == site).unwrap_or(Site::ALL.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::records::record::tests::record;

    #[test]
    fn baselines_are_told_by_site_filter_and_who_filters() {
        let cell = |codec: &str, site: &str, filter: &str, filtering: &str| {
            Baseline::of(&Record {
                site: site.into(),
                filter: filter.into(),
                filtering: Some(filtering.into()),
                ..record("v", codec)
            })
        };
        assert_eq!(cell("raw", "host", "linear", "hardware"), Some(Baseline::Texture));
        assert_eq!(cell("raw", "inline", "linear", "manual"), Some(Baseline::Buffer));
        assert_eq!(cell("raw", "host", "linear", "manual"), None);
        assert_eq!(cell("raw", "inline", "nearest", "manual"), None);
        let skips =
            Record { site: "inline".into(), filter: "linear".into(), skipping: true, ..record("v", "raw") };
        assert_eq!(Baseline::of(&skips), None);
        assert_eq!(cell("s3dc", "inline", "linear", "manual"), None);
    }
}
