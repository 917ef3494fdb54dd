//! A cell: one combination of an experiment, and its name.

use crate::codec::{SettingValue, Settings, Site};
use crate::render::Filter;
use crate::volume::Level;

/// One combination of an experiment. It gives one record.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Volume name.
    pub volume: String,
    /// Codec id.
    pub codec: String,
    /// Complete and canonical settings.
    pub settings: Settings,
    /// Scene name.
    pub scene: String,
    /// Label of the renderer: its id, and the settings that differ from the defaults.
    pub renderer: String,
    /// Decode site.
    pub site: Site,
    /// Filter.
    pub filter: Filter,
    /// Whether empty macrocells are skipped.
    pub skipping: bool,
    /// Number of stages to decode. `None` for all.
    pub stages: Option<u8>,
    /// Resolution to decode. 0 is the full one. Each step halves every axis.
    pub resolution: u8,
}

impl Cell {
    /// Longest [`Cell::id`] in bytes. With file endings it stays within the 255 bytes of common file systems.
    pub const MAX_ID_BYTES: usize = 200;

    /// The level that is decoded.
    #[must_use]
    pub fn level(&self) -> Level {
        Level { resolution: self.resolution, stages: self.stages.unwrap_or(Level::ALL_STAGES) }
    }

    /// Label of the codec in records and charts: its id. If the codec has a setting `name`, a colon and its value
    /// follow (`external:sz3`).
    #[must_use]
    pub fn codec_label(&self) -> String {
        match self.settings.get("name") {
            Some(SettingValue::Text(name)) if !name.is_empty() => format!("{}:{name}", self.codec),
            _ => self.codec.clone(),
        }
    }

    /// The id in a [`Cell::codec_label`].
    #[must_use]
    pub fn codec_of_label(label: &str) -> &str {
        label.split_once(':').map_or(label, |(id, _)| id)
    }

    /// A name for files and for resuming: `bonsai-s3dc-block=4,index_bits=2-front-raycasting-inline-linear`, followed
    /// by `-skipping`, `-stages=2` and `-resolution=1` if they apply.
    ///
    /// It has only letters, digits and `._=,-`. It depends only on the cell, and differs between different cells: a
    /// checksum of the true names follows if a name had to be changed, contains a `-` (the separator), or is too long.
    #[must_use]
    pub fn id(&self) -> String {
        let settings: Vec<String> = self.settings.iter().map(|(n, v)| format!("{n}={v}")).collect();
        let settings = settings.join(",");
        let (site, filter) = (self.site.name(), self.filter.name());
        let stages = self.stages.map(|stages| format!("stages={stages}"));
        let resolution = (self.resolution > 0).then(|| format!("resolution={}", self.resolution));
        let mut parts =
            vec![&*self.volume, &*self.codec, &*settings, &*self.scene, &*self.renderer, site, filter];
        parts.extend(self.skipping.then_some("skipping"));
        parts.extend(stages.as_deref());
        parts.extend(resolution.as_deref());
        let is_safe = |c: char| c.is_ascii_alphanumeric() || "._=,-".contains(c);
        let written: Vec<&str> = parts.iter().copied().filter(|p| !p.is_empty()).collect();
        let mut id: String = written.join("-").chars().map(|c| if is_safe(c) { c } else { '_' }).collect();
        // A leading `.` would hide the file, and a leading `-` would look like an option.
        if id.starts_with(['.', '-']) {
            id.replace_range(..1, "_");
        }
        let blurred = [&self.volume, &self.scene].iter().any(|name| name.contains('-'));
        if blurred || id != written.join("-") || id.len() > Self::MAX_ID_BYTES {
            let checksum = crc32c::crc32c(parts.join("\0").as_bytes());
            id.truncate(Self::MAX_ID_BYTES - 9);
            id.push_str(&format!("-{checksum:08x}"));
        }
        id
    }
}
