//! What a codec says of itself.

use super::{Setting, SettingValue, Settings};
use serde::{Deserialize, Serialize};

/// Where voxels are decoded.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Site {
    /// In the shader, at every fetch.
    Inline,
    /// On the device, a whole frame at once, into a texture: by passes of the codec's own ([`super::FrameDecode`]) or
    /// by the shader of [`Site::Inline`]. The CPU mirror, which has no textures, decodes a frame as at [`Site::Host`].
    Deferred,
    /// On the device, layer by layer in every frame, into a ring of four layers from which slices are drawn as far as
    /// they reach: by the shader of [`Site::Inline`]. The CPU mirror draws as at [`Site::Deferred`].
    Ring,
    /// On the CPU, into a texture.
    Host,
}

impl Site {
    /// All sites that a pipeline may name.
    pub const ALL: [Self; 4] = [Self::Inline, Self::Deferred, Self::Ring, Self::Host];

    /// Name used in TOML and in records.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Inline => "inline",
            Self::Deferred => "deferred",
            Self::Ring => "ring",
            Self::Host => "host",
        }
    }
}

impl std::fmt::Display for Site {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

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
    /// Version of the stream that the encoder writes; decoders read it and all earlier ones.
    pub stream_version: u32,
    /// Where its volumes can be decoded, apart from what follows by itself: see [`CodecInfo::offers`]. *Inline* asks for
    /// [`super::Decoder::shader`], *deferred* without it for [`super::Decoder::frame_decode`].
    pub sites: &'static [Site],
    /// Whether the snippet declares `<id>_fetch_cell`, which filter `optimised-linear` needs.
    pub fetch_cell: bool,
    /// What it follows.
    pub paper: Option<Paper>,
    /// Its settings with their defaults, in the order in which they are shown.
    pub settings: &'static [Setting],
    /// Names of those settings of which another value makes another method, and not another rate of the same one. Curves of
    /// quality over rate run through cells that agree in all of these, and charts tell them apart.
    pub methods: &'static [&'static str],
}

impl CodecInfo {
    /// The settings with every default.
    #[must_use]
    pub fn default_settings(&self) -> Settings {
        self.settings.iter().map(|s| (s.name.to_owned(), SettingValue::from(s.default))).collect()
    }

    /// Whether its volumes can be decoded there. Whoever decodes one voxel in a shader decodes all of them, so that
    /// *deferred* and *ring* come with *inline*; a codec that only rebuilds whole frames lists *deferred* alone.
    #[must_use]
    pub fn offers(&self, site: Site) -> bool {
        let needed = if matches!(site, Site::Deferred | Site::Ring) { Site::Inline } else { site };
        self.sites.contains(&site) || self.sites.contains(&needed)
    }

    /// All sites where its volumes can be decoded, in the order of [`Site::ALL`].
    pub fn offered(&self) -> impl Iterator<Item = Site> {
        Site::ALL.into_iter().filter(|site| self.offers(*site))
    }

    /// The values of [`CodecInfo::methods`] in these settings, in the order of the schema, as records keep them: `name=value`
    /// separated by spaces. Empty where the codec is one method.
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
