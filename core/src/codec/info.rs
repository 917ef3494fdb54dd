//! Metadata of a codec.

use super::{ConfigError, DecodedBy, Setting, SettingValue, Settings, Site};

/// The publication that a codec follows.
#[derive(Copy, Clone, Debug)]
pub struct Paper {
    /// Authors.
    pub authors: &'static str,
    /// Title.
    pub title: &'static str,
    /// Venue and year.
    pub venue: &'static str,
}

/// Identity, capabilities and settings of a codec.
#[derive(Clone, Debug)]
pub struct CodecInfo {
    /// Folder name, WGSL prefix and TOML name: lower-case letters and digits.
    pub id: &'static str,
    /// One line for lists.
    pub summary: &'static str,
    /// Version of the stream that the encoder writes. Decoders read it and all earlier versions.
    pub stream_version: u32,
    /// Who can decode its volumes, with some settings at least: see [`super::Codec::decoded_by`]. The sites follow from
    /// it: see [`CodecInfo::offers`].
    pub decoded_by: &'static [DecodedBy],
    /// Whether the snippet declares `<id>_fetch_cell`, which filter `optimised-linear` needs.
    pub fetch_cell: bool,
    /// The paper that the codec follows.
    pub paper: Option<Paper>,
    /// Settings with their defaults, in display order.
    pub settings: &'static [Setting],
    /// Names of the settings whose value makes another method, not another rate of the same method. A curve of quality
    /// over rate joins cells that agree in all of these. Charts draw one curve per method.
    pub methods: &'static [&'static str],
}

impl CodecInfo {
    /// The settings with every default.
    #[must_use]
    pub fn default_settings(&self) -> Settings {
        self.settings.iter().map(|s| (s.name.to_owned(), SettingValue::from(s.default))).collect()
    }

    /// These settings with the defaults of all others, every value in canonical form.
    ///
    /// # Errors
    /// When a setting is unknown to the codec, or a value is not allowed.
    pub fn complete(&self, settings: &Settings) -> Result<Settings, ConfigError> {
        settings.complete_by(&format!("codec `{}`", self.id), self.settings)
    }

    /// Whether volumes of this codec can be decoded at `site`, with some settings at least.
    #[must_use]
    pub fn offers(&self, site: Site) -> bool {
        site.offered_by(self.decoded_by)
    }

    /// All sites that this codec offers, in the order of [`Site::ALL`].
    pub fn offered(&self) -> impl Iterator<Item = Site> {
        Site::ALL.into_iter().filter(|site| self.offers(*site))
    }

    /// The values of [`CodecInfo::methods`] in these settings, as records hold them: `name=value`, in the order of the
    /// schema, separated by spaces. Empty if the codec has one method.
    #[must_use]
    pub fn series(&self, settings: &Settings) -> String {
        let own = self.settings.iter().filter(|s| self.methods.contains(&s.name));
        let values = own.filter_map(|s| Some((s.name.to_owned(), settings.get(s.name)?.clone())));
        let written = values.map(|value| Settings::from_iter([value]).to_string());
        written.collect::<Vec<_>>().join(" ")
    }

    /// The setting of this name.
    #[must_use]
    pub fn setting(&self, name: &str) -> Option<&Setting> {
        self.settings.iter().find(|s| s.name == name)
    }
}
