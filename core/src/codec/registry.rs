//! The list of codecs. Explicit: whoever assembles an application names what it holds.

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
    /// Two codecs of one id.
    #[error("codec `{id}` is registered twice; known codecs: {known}")]
    Duplicate {
        /// The id.
        id: String,
        /// All ids so far.
        known: String,
    },
    /// The id is no lower-case word of letters and digits, which WGSL names and folders need.
    #[error("codec id `{0}`: use lower-case letters and digits, beginning with a letter")]
    BadId(String),
    /// No codec of that id.
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
    /// When its id is taken or malformed.
    pub fn register(&mut self, codec: Arc<dyn Codec>) -> Result<(), RegistryError> {
        let id = codec.info().id;
        let word = id.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit());
        if !word || !id.starts_with(|c: char| c.is_ascii_lowercase()) {
            return Err(RegistryError::BadId(id.to_owned()));
        }
        if self.codecs.contains_key(id) {
            return Err(RegistryError::Duplicate { id: id.to_owned(), known: self.known() });
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
