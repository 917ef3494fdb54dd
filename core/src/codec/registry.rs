//! The list of codecs. It is explicit: each application names the codecs that it holds.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::Codec;

/// Codecs by id.
#[derive(Clone, Debug, Default)]
pub struct Registry {
    codecs: BTreeMap<&'static str, Arc<dyn Codec>>,
}

/// Why a registry refuses.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RegistryError {
    /// Two codecs have the same id.
    #[error("codec `{id}` is registered twice; known codecs: {known}")]
    Duplicate {
        /// The id.
        id: String,
        /// All ids so far.
        known: String,
    },
    /// The id is not a word of lower-case letters and digits. WGSL names and folders need such a word.
    #[error("codec id `{0}`: use lower-case letters and digits, beginning with a letter")]
    BadId(String),
    /// A method that is not one of the codec's settings.
    #[error("codec `{id}` has no setting `{name}`, which it lists among its methods")]
    NoSuchMethod {
        /// The codec.
        id: String,
        /// The listed name.
        name: String,
    },
    /// No codec has that id.
    #[error("no codec `{id}`; known codecs: {known}")]
    Unknown {
        /// The id asked for.
        id: String,
        /// All ids.
        known: String,
    },
}

impl Registry {
    /// Adds a codec.
    ///
    /// # Errors
    /// When its id is taken or malformed, or it lists a method that is none of its settings.
    pub fn register(&mut self, codec: Arc<dyn Codec>) -> Result<(), RegistryError> {
        let info = codec.info();
        let id = info.id;
        let word = id.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit());
        if !word || !id.starts_with(|c: char| c.is_ascii_lowercase()) {
            return Err(RegistryError::BadId(id.to_owned()));
        }
        if self.codecs.contains_key(id) {
            return Err(RegistryError::Duplicate { id: id.to_owned(), known: self.known() });
        }
        if let Some(name) = info.methods.iter().find(|name| info.setting(name).is_none()) {
            return Err(RegistryError::NoSuchMethod { id: id.to_owned(), name: (*name).to_owned() });
        }
        self.codecs.insert(id, codec);
        Ok(())
    }

    /// The codec of this id.
    ///
    /// # Errors
    /// When there is none; the error names the known ones.
    pub fn get(&self, id: &str) -> Result<&Arc<dyn Codec>, RegistryError> {
        self.codecs.get(id).ok_or_else(|| RegistryError::Unknown { id: id.to_owned(), known: self.known() })
    }

    /// All codecs in alphabetical order.
    pub fn iter(&self) -> impl Iterator<Item = &Arc<dyn Codec>> {
        self.codecs.values()
    }

    fn known(&self) -> String {
        self.codecs.keys().copied().collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::{
        CodecInfo, ConfigError, DecodeError, Decoder, Encoder, Setting, SettingKind, SettingValue, Settings,
    };
    use crate::container::EncodedVolume;

    #[derive(Debug)]
    struct Named(CodecInfo);

    impl Codec for Named {
        fn info(&self) -> &CodecInfo {
            &self.0
        }

        fn encoder(&self, _: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
            Err(ConfigError::Contradiction("encodes nothing".to_owned()))
        }

        fn decoder(&self, _: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
            Err(DecodeError::Corrupt("decodes nothing".to_owned()))
        }
    }

    fn named(id: &'static str) -> Arc<dyn Codec> {
        Arc::new(Named(CodecInfo {
            id,
            summary: "",
            stream_version: 1,
            decoded_by: &[],
            fetch_cell: false,
            paper: None,
            settings: &[],
            methods: &[],
        }))
    }

    const PAYLOAD: &[Setting] = &[
        Setting { name: "rate", doc: "", kind: SettingKind::Float { min: 0.0, max: 9.0 }, default: "1" },
        Setting { name: "payload", doc: "", kind: SettingKind::Choice(&["a", "b"]), default: "a" },
        Setting { name: "name", doc: "", kind: SettingKind::Text { max: 9 }, default: "" },
    ];

    #[test]
    fn a_series_is_the_settings_that_the_codec_lists_as_methods() {
        let with = |methods| CodecInfo {
            id: "x",
            summary: "",
            stream_version: 1,
            decoded_by: &[],
            fetch_cell: false,
            paper: None,
            settings: PAYLOAD,
            methods,
        };
        let mut settings = with(&[]).default_settings();
        settings.set("name", SettingValue::Text("two words".to_owned()));
        let series = |methods| with(methods).series(&settings);
        assert_eq!(series(&[]), "");
        assert_eq!(series(&["name", "payload"]), "payload=a name='two words'", "in the order of the schema");
        let mut registry = Registry::default();
        registry.register(Arc::new(Named(with(&["payload"])))).unwrap();
        let refused = registry.register(Arc::new(Named(CodecInfo { id: "y", ..with(&["paylaod"]) })));
        assert!(refused.unwrap_err().to_string().contains("no setting `paylaod`"));
    }

    #[test]
    fn duplicate_unknown_and_malformed_ids_are_refused_with_the_known_ones() {
        let mut registry = Registry::default();
        registry.register(named("raw")).unwrap();
        registry.register(named("s3dc")).unwrap();
        let twice = registry.register(named("raw")).unwrap_err().to_string();
        assert_eq!(twice, "codec `raw` is registered twice; known codecs: raw, s3dc");
        let unknown = registry.get("tvq").unwrap_err().to_string();
        assert_eq!(unknown, "no codec `tvq`; known codecs: raw, s3dc");
        for id in ["", "S3dc", "s3-dc", "3dc", "s3dc_"] {
            assert_eq!(registry.register(named(id)), Err(RegistryError::BadId(id.to_owned())));
        }
        assert_eq!(registry.iter().count(), 2);
    }
}
