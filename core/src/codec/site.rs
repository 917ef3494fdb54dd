//! Sites: how much of a volume is decoded at once, and who decodes it.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// How much of a volume is decoded at once.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub enum Granularity {
    /// One voxel, whenever a shader fetches it.
    Voxel,
    /// One layer of voxels across an axis of the volume.
    Layer,
    /// A box of voxels.
    Brick,
    /// A whole frame.
    Frame,
}

/// Who decodes.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub enum DecodedBy {
    /// The codec's shader on a device, voxel by voxel ([`super::Decoder::shader`]).
    Shader,
    /// Passes over a whole frame on a device: those of the codec ([`super::Decoder::frame_decode`]), or one pass that
    /// calls the codec's shader for every voxel.
    Passes,
    /// The CPU ([`super::Decoder::decode_brick`]).
    Cpu,
}

impl DecodedBy {
    /// Whether a device decodes.
    #[must_use]
    pub const fn on_device(self) -> bool {
        match self {
            Self::Shader | Self::Passes => true,
            Self::Cpu => false,
        }
    }
}

/// The list of sites: documentation, variant, name in TOML and records, the two properties, and the summary for schema
/// and help.
macro_rules! sites {
    ($($(#[$doc:meta])* $site:ident = $name:literal, $granularity:ident, $by:ident, $summary:literal;)*) => {
        /// Where and when voxels are decoded. A site is a granularity and a decoder under one name.
        #[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        pub enum Site {
            $($(#[$doc])* #[serde(rename = $name)] $site,)*
        }

        impl Site {
            /// All sites that a pipeline may name.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$site),*];

            /// Name used in TOML and in records.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$site => $name,)* }
            }

            /// How much is decoded at once.
            #[must_use]
            pub const fn granularity(self) -> Granularity {
                match self { $(Self::$site => Granularity::$granularity,)* }
            }

            /// Who decodes.
            #[must_use]
            pub const fn decoded_by(self) -> DecodedBy {
                match self { $(Self::$site => DecodedBy::$by,)* }
            }

            /// Summary in a few words.
            #[must_use]
            pub const fn summary(self) -> &'static str {
                match self { $(Self::$site => $summary,)* }
            }
        }
    };
}

sites! {
    /// In the shader, at every fetch.
    Inline = "inline", Voxel, Shader, "in the shader, at every fetch";
    /// On the device, a whole frame at once, into a texture. The CPU mirror, which has no textures, decodes a frame as at
    /// [`Site::Host`].
    Deferred = "deferred", Frame, Passes, "on the device, a whole frame at once, into a texture";
    /// On the device, layer by layer in every picture, into a ring of four layers. Slices are drawn as far as the
    /// decoded layers reach. The CPU mirror draws as at [`Site::Deferred`].
    Ring = "ring", Layer, Shader,
        "on the device, layer by layer in every frame, into a ring of four: of renderer slicing with geometry axis";
    /// On the CPU, into a texture.
    Host = "host", Frame, Cpu, "on the CPU, into a texture";
}

impl Site {
    /// Whether these decoders can decode at this site. A shader that decodes one voxel also decodes a whole frame: a pass
    /// calls it for every voxel.
    #[must_use]
    pub fn offered_by(self, decoders: &[DecodedBy]) -> bool {
        let can = |by| decoders.contains(&by);
        match self.decoded_by() {
            DecodedBy::Shader => can(DecodedBy::Shader),
            DecodedBy::Passes => can(DecodedBy::Passes) || can(DecodedBy::Shader),
            DecodedBy::Cpu => can(DecodedBy::Cpu),
        }
    }
}

impl std::fmt::Display for Site {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Site {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = || Self::ALL.map(Self::name).join(" or ");
        Self::ALL.into_iter().find(|s| s.name() == text).ok_or_else(|| format!("`{text}`: {}", known()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_site_is_one_pair_of_properties_under_one_name() {
        for (i, site) in Site::ALL.into_iter().enumerate() {
            assert_eq!(site.name().parse(), Ok(site));
            assert_eq!(serde_json::to_value(site).unwrap(), site.name());
            for other in &Site::ALL[..i] {
                let pair = |site: Site| (site.granularity(), site.decoded_by());
                assert_ne!(pair(*other), pair(site), "{other} and {site}");
            }
        }
        assert!("nowhere".parse::<Site>().unwrap_err().starts_with("`nowhere`: inline or "));
    }
}
