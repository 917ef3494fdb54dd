//! A chart with its place in the page and its name as a file, and the lines of its CSV file.

use super::chart::Chart;

/// Longest name of a chart in bytes, before its ending.
const LONGEST: usize = 120;

/// A chart with its place in the page.
#[derive(Debug)]
pub(super) struct Figure {
    /// File name without ending; no two are alike, not even in lower case.
    pub(super) name: String,
    /// The last part of the name. `docs/user/evaluation.md` explains charts under it.
    pub(super) kind: String,
    /// `None` for all together.
    pub(super) volume: Option<String>,
    pub(super) caption: String,
    /// Whether the legend is next to the drawing, not below.
    pub(super) wide: bool,
    pub(super) chart: Chart,
    /// What its CSV file holds, where that is not its marks.
    pub(super) sheet: Option<Sheet>,
    /// How its numbers are defined.
    pub(super) note: Option<String>,
}

/// What charts of no single volume stand under.
pub(super) const ALL_VOLUMES: &str = "All volumes";

/// A name for files from the names of what a chart shows: letters, digits and `._=,-` alone. Where it had to be changed
/// or cut, a checksum of the true names ends it; parts with a `-` of their own could blur the borders.
pub(super) fn file_name(parts: &[&str]) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() || "._=,-".contains(c) { c } else { '_' };
    let written: Vec<&str> = parts.iter().copied().filter(|p| !p.is_empty()).collect();
    let true_name = written.join("-");
    let mut name: String = true_name.chars().map(safe).collect();
    if name.starts_with(['.', '-']) {
        name.replace_range(..1, "_");
    }
    let [.., _] = parts else { return name };
    let blurred = parts[..parts.len() - 1].iter().any(|part| part.contains('-'));
    if blurred || name != true_name || name.len() > LONGEST {
        name.truncate(LONGEST);
        name += &format!("-{:08x}", crc32c::crc32c(parts.join("\0").as_bytes()));
    }
    name
}

/// Lines of a CSV file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sheet {
    pub(super) header: Vec<&'static str>,
    pub(super) rows: Vec<Vec<String>>,
}

impl Sheet {
    pub(super) fn new(header: &[&'static str]) -> Self {
        Self { header: header.to_vec(), rows: Vec::new() }
    }

    pub(super) fn row(&mut self, values: impl Iterator<Item = String>) {
        self.rows.push(values.collect());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_safe_short_and_different() {
        assert_eq!(file_name(&["bonsai", "front", "", "frame-time"]), "bonsai-front-frame-time");
        let names = [
            file_name(&["a-b", "c", "x"]),
            file_name(&["a", "b-c", "x"]),
            file_name(&["../../etc", "c", "x"]),
            file_name(&["..", "/etc-c", "x"]),
            file_name(&[&"ü".repeat(300), "c", "x"]),
        ];
        for (i, name) in names.iter().enumerate() {
            assert!(name.len() < 140 && !name.starts_with('.') && !name.contains('/'), "{name}");
            assert!(names[..i].iter().all(|other| other != name), "{name}");
        }
    }
}
