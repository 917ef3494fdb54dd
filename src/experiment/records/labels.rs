//! Names of cells for readers: codec, and the settings that differ among that codec's cells. Files for programs have
//! all settings.

use std::collections::{BTreeMap, BTreeSet};

use super::record::Record;

/// The settings that differ, by codec, among cells that are shown together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Labels {
    codecs: BTreeMap<String, Of>,
}

/// Of one codec.
#[derive(Clone, Debug, Default, PartialEq)]
struct Of {
    /// Settings that all cells share, as written.
    shared: Vec<String>,
    /// Settings that make another method and have more than one value.
    methods: BTreeSet<String>,
}

impl Labels {
    /// Of these cells.
    pub fn of<'a>(records: impl IntoIterator<Item = &'a Record>) -> Self {
        let mut settings: BTreeMap<&str, Vec<Vec<String>>> = BTreeMap::new();
        let mut series: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
        for r in records {
            let own = settings.entry(&r.codec).or_default();
            let written = split(&r.settings);
            // Most cells have the settings of the one before.
            if own.last() != Some(&written) {
                own.push(written);
            }
            series.entry(&r.codec).or_default().extend(split(&r.series));
        }
        let of = |(codec, all): (&str, Vec<Vec<String>>)| {
            let in_all = |s: &&String| all.iter().all(|own| own.contains(s));
            let shared: Vec<String> = all.first().into_iter().flatten().filter(in_all).cloned().collect();
            let written = series.remove(codec).unwrap_or_default();
            let methods =
                written.iter().filter(|s| !shared.contains(s)).map(|s| name(s).to_owned()).collect();
            (codec.to_owned(), Of { shared, methods })
        };
        Self { codecs: settings.into_iter().map(of).collect() }
    }

    /// The settings that differ, `name=value` separated by spaces. Empty if all cells of the codec have the same.
    #[must_use]
    pub fn settings(&self, record: &Record) -> String {
        let of = self.codecs.get(&record.codec);
        let differs = |s: &String| !of.is_some_and(|of| of.shared.contains(s));
        split(&record.settings).into_iter().filter(differs).collect::<Vec<_>>().join(" ")
    }

    /// The settings that all cells of a codec share, in the same form.
    #[must_use]
    pub fn shared(&self, codec: &str) -> String {
        self.codecs.get(codec).map(|of| of.shared.join(" ")).unwrap_or_default()
    }

    /// Names of curves: the codec, followed by its methods if there are several (`tvq payload=variable`).
    #[must_use]
    pub fn series(&self, record: &Record) -> String {
        let several = self.codecs.get(&record.codec).map(|of| &of.methods);
        let told = |s: &String| several.is_some_and(|several| several.contains(name(s)));
        let methods = split(&record.series).into_iter().filter(told);
        std::iter::once(record.codec.clone()).chain(methods).collect::<Vec<_>>().join(" ")
    }

    /// Codec, differing settings, and number of stages and resolution if it is not the full stream.
    #[must_use]
    pub fn coding(&self, record: &Record) -> String {
        coding(record, &self.settings(record))
    }

    /// The same with site and filter, and whether it skips.
    #[must_use]
    pub fn cell(&self, record: &Record) -> String {
        in_place(record, self.coding(record))
    }
}

/// Codec, all settings, and number of stages and resolution if it is not the full stream.
#[must_use]
pub fn full_coding(record: &Record) -> String {
    coding(record, &record.settings)
}

fn coding(record: &Record, settings: &str) -> String {
    let stages = record.stages.map(|stages| format!("stages {stages}"));
    let resolution = (record.resolution > 0).then(|| format!("resolution {}", record.resolution));
    let level: Vec<String> = stages.into_iter().chain(resolution).collect();
    let level = if level.is_empty() { String::new() } else { format!(" ({})", level.join(", ")) };
    [record.codec.as_str(), settings].join(" ").trim_end().to_owned() + &level
}

/// The same with site and filter, and whether it skips.
#[must_use]
pub fn full_cell(record: &Record) -> String {
    in_place(record, full_coding(record))
}

fn in_place(record: &Record, coding: String) -> String {
    let skipping = if record.skipping { ", skipping" } else { "" };
    format!("{coding}, {}, {}{skipping}", record.site, record.filter)
}

/// Splits settings. A quoted text is one. A text that cannot be split is a single one.
fn split(settings: &str) -> Vec<String> {
    let quoted = |word: String| match word.split_once('=') {
        Some((name, value)) => {
            shlex::try_quote(value).map_or_else(|_| word.clone(), |value| format!("{name}={value}"))
        }
        None => word,
    };
    match shlex::split(settings) {
        Some(words) => words.into_iter().map(quoted).collect(),
        None => vec![settings.to_owned()],
    }
}

/// The name of a setting as written.
fn name(setting: &str) -> &str {
    setting.split_once('=').map_or(setting, |(name, _)| name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::records::record::tests::record;

    fn with(codec: &str, settings: &str, series: &str) -> Record {
        Record { settings: settings.into(), series: series.into(), ..record("v", codec) }
    }

    #[test]
    fn what_cells_of_a_codec_share_is_left_out() {
        let cells = [
            with("vq", "block=2 seed=1", ""),
            with("vq", "block=4 seed=1", ""),
            with("hvq", "block=2 seed=1", ""),
            with("external:sz3", "decode='sz3 -d {in}' value=1", ""),
            with("external:sz3", "decode='sz3 -d {in}' value=2", ""),
            with("external:zip", "decode='zip {in} -1' name=zip", ""),
            with("external:zip", "decode='zip {in} -2' name=zip", ""),
        ];
        let labels = Labels::of(&cells);
        let names: Vec<String> = cells.iter().map(|r| labels.coding(r)).collect();
        let expected = [
            "vq block=2",
            "vq block=4",
            "hvq",
            "external:sz3 value=1",
            "external:sz3 value=2",
            "external:zip decode='zip {in} -1'",
            "external:zip decode='zip {in} -2'",
        ];
        assert_eq!(names, expected);
        assert_eq!(labels.shared("vq"), "seed=1");
        assert_eq!(labels.shared("external:sz3"), "decode='sz3 -d {in}'");
        assert_eq!(full_coding(&cells[0]), "vq block=2 seed=1");
        // For an unknown cell, or text that is not a list of settings, everything is shown.
        assert_eq!(labels.settings(&with("tvq", "rate=1", "")), "rate=1");
        assert_eq!(labels.settings(&with("vq", "it's broken", "")), "it's broken");
    }

    #[test]
    fn a_setting_that_some_cells_lack_differs() {
        let cells = [with("vq", "block=2 draw=uniform", ""), with("vq", "block=2", "")];
        let labels = Labels::of(&cells);
        assert_eq!(labels.coding(&cells[0]), "vq draw=uniform");
        assert_eq!(labels.coding(&cells[1]), "vq");
    }

    #[test]
    fn a_series_is_told_by_the_methods_of_which_there_are_several() {
        let cells = [
            with("tvq", "payload=fixed rate=1 transform=klt", "payload=fixed transform=klt"),
            with("tvq", "payload=fixed rate=2 transform=klt", "payload=fixed transform=klt"),
            with("tvq", "payload=variable rate=2 transform=klt", "payload=variable transform=klt"),
            with("vq", "init=pca", "init=pca"),
        ];
        let series = |cells: &[Record]| {
            let labels = Labels::of(cells);
            cells.iter().map(|r| labels.series(r)).collect::<Vec<_>>()
        };
        let both = ["tvq payload=fixed", "tvq payload=fixed", "tvq payload=variable", "vq"];
        assert_eq!(series(&cells), both);
        assert_eq!(series(&cells[..2]), ["tvq", "tvq"], "one method alone is the codec");
        let of_old: Vec<Record> =
            cells.iter().map(|r| Record { series: String::new(), ..r.clone() }).collect();
        assert_eq!(series(&of_old), ["tvq", "tvq", "tvq", "vq"]);
    }
}
