//! Settings of a codec: a schema that is checked before an encoder sees a value.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Block, ConfigError};

/// The values that a setting takes.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum SettingKind {
    /// Whole number within bounds.
    Integer {
        /// Lowest.
        min: i64,
        /// Highest.
        max: i64,
    },
    /// One of these integers.
    OneOf(&'static [i64]),
    /// Number within bounds.
    Float {
        /// Lowest.
        min: f64,
        /// Highest.
        max: f64,
    },
    /// One of these words. A number whose text is listed counts as that word.
    Choice(&'static [&'static str]),
    /// `true` or `false`.
    Boolean,
    /// A [`Block`]: an edge length or `"XxYxZ"`, each axis at most `max`.
    Block {
        /// Longest axis.
        max: u32,
    },
    /// One line of text: no control characters, at most this many bytes.
    Text {
        /// Most bytes.
        max: usize,
    },
}

/// One setting in a codec's schema.
#[derive(Copy, Clone, Debug)]
pub struct Setting {
    /// TOML key, in snake case.
    pub name: &'static str,
    /// Effect of the setting, with its unit.
    pub doc: &'static str,
    /// Allowed values.
    pub kind: SettingKind,
    /// Default, as it would be written in a settings list (`16`, `native`).
    pub default: &'static str,
}

/// Value of a setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum SettingValue {
    /// `true` or `false`.
    Boolean(bool),
    /// A whole number.
    Integer(i64),
    /// A number.
    Float(f64),
    /// A word, or a block size such as `8x8x4`.
    Text(String),
}

impl From<&str> for SettingValue {
    /// Reads a value from the command line: boolean, integer, float, else text.
    fn from(text: &str) -> Self {
        if let Ok(b) = text.parse() {
            Self::Boolean(b)
        } else if let Ok(i) = text.parse() {
            Self::Integer(i)
        } else if let Ok(f) = text.parse() {
            Self::Float(f)
        } else {
            Self::Text(text.to_owned())
        }
    }
}

impl fmt::Display for SettingValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Boolean(b) => write!(f, "{b}"),
            Self::Integer(i) => write!(f, "{i}"),
            Self::Float(x) => write!(f, "{x}"),
            Self::Text(t) => f.write_str(t),
        }
    }
}

impl SettingKind {
    /// Description of the allowed values, such as `an integer from 1 to 8`.
    #[must_use]
    pub fn describe(&self) -> String {
        let list = |items: Vec<String>| match items.as_slice() {
            [.., last] if items.len() > 1 => format!("{} or {last}", items[..items.len() - 1].join(", ")),
            _ => items.concat(),
        };
        match self {
            Self::Integer { min, max } => format!("an integer from {min} to {max}"),
            Self::OneOf(numbers) => list(numbers.iter().map(ToString::to_string).collect()),
            Self::Float { min, max } => format!("a number from {min} to {max}"),
            Self::Choice(words) => list(words.iter().map(|w| format!("\"{w}\"")).collect()),
            Self::Boolean => "true or false".to_owned(),
            Self::Block { max } => {
                format!("a block edge (8) or a block size (\"8x8x4\"), each axis 1 to {max}")
            }
            Self::Text { max } => format!("a text of one line, at most {max} bytes"),
        }
    }

    /// The value in canonical form (a block as text, a listed word as text), so that equal settings compare and print
    /// as equal. `None` if the value is not allowed.
    #[must_use]
    pub fn canonical(&self, value: &SettingValue) -> Option<SettingValue> {
        use SettingValue as V;
        match (self, value) {
            (Self::Integer { min, max }, V::Integer(i)) => (min <= i && i <= max).then_some(V::Integer(*i)),
            (Self::OneOf(numbers), V::Integer(i)) => numbers.contains(i).then_some(V::Integer(*i)),
            (Self::Float { min, max }, V::Float(x)) => (min <= x && x <= max).then_some(V::Float(*x)),
            (Self::Float { min, max }, V::Integer(i)) => {
                let x = *i as f64;
                (*min <= x && x <= *max).then_some(V::Float(x))
            }
            (Self::Choice(words), value) => {
                let text = value.to_string();
                words.contains(&text.as_str()).then_some(V::Text(text))
            }
            (Self::Boolean, V::Boolean(b)) => Some(V::Boolean(*b)),
            (Self::Block { max }, V::Integer(_) | V::Text(_)) => {
                let block: Block = value.to_string().parse().ok()?;
                let fits = block.0.to_array().iter().all(|a| a <= max);
                fits.then(|| V::Text(block.to_string()))
            }
            (Self::Text { max }, V::Text(text)) => {
                let fits = text.len() <= *max && !text.contains(char::is_control);
                fits.then(|| V::Text(text.clone()))
            }
            // On a command line a text may look like a number.
            (Self::Text { .. }, value) => Some(V::Text(value.to_string())),
            _ => None,
        }
    }
}

/// A complete or partial set of settings, in alphabetical order. Clones share the data, because thousands of cells may
/// have the same settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "BTreeMap<String, SettingValue>", into = "BTreeMap<String, SettingValue>")]
pub struct Settings(Arc<BTreeMap<String, SettingValue>>);

impl From<BTreeMap<String, SettingValue>> for Settings {
    fn from(values: BTreeMap<String, SettingValue>) -> Self {
        Self(Arc::new(values))
    }
}

impl From<Settings> for BTreeMap<String, SettingValue> {
    fn from(Settings(values): Settings) -> Self {
        Arc::unwrap_or_clone(values)
    }
}

impl Settings {
    /// Sets one value, replacing an earlier one.
    pub fn set(&mut self, name: &str, value: SettingValue) {
        Arc::make_mut(&mut self.0).insert(name.to_owned(), value);
    }

    /// The value of a setting, if it is set.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&SettingValue> {
        self.0.get(name)
    }

    /// Names and values in alphabetical order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &SettingValue)> {
        self.0.iter().map(|(k, v)| (k.as_str(), v))
    }

    /// Fills in the defaults of a schema and brings every value into canonical form. Errors call whose schema it is `owner`.
    ///
    /// # Errors
    /// When the schema has no such setting, or a value is not allowed.
    pub fn complete_by(&self, owner: &str, schema: &[Setting]) -> Result<Self, ConfigError> {
        let is_known = |name: &str| schema.iter().any(|setting| setting.name == name);
        if let Some((name, _)) = self.iter().find(|(name, _)| !is_known(name)) {
            return Err(ConfigError::UnknownSetting {
                owner: owner.to_owned(),
                name: name.to_owned(),
                known: schema.iter().map(|s| s.name).collect::<Vec<_>>().join(", "),
            });
        }
        let mut complete = Self::default();
        for setting in schema {
            let value = self.get(setting.name).cloned().unwrap_or_else(|| setting.default.into());
            let canonical = setting.kind.canonical(&value).ok_or_else(|| ConfigError::Value {
                owner: owner.to_owned(),
                name: setting.name.to_owned(),
                value: value.to_string(),
                expected: setting.kind.describe(),
            })?;
            complete.set(setting.name, canonical);
        }
        Ok(complete)
    }

    /// A whole number.
    ///
    /// # Errors
    /// When the setting is absent or of another kind (settings were not completed).
    pub fn integer(&self, name: &str) -> Result<i64, ConfigError> {
        match self.get(name) {
            Some(SettingValue::Integer(i)) => Ok(*i),
            _ => Err(ConfigError::Incomplete(name.to_owned())),
        }
    }

    /// A number.
    ///
    /// # Errors
    /// As [`Settings::integer`].
    pub fn float(&self, name: &str) -> Result<f64, ConfigError> {
        match self.get(name) {
            Some(SettingValue::Float(x)) => Ok(*x),
            _ => Err(ConfigError::Incomplete(name.to_owned())),
        }
    }

    /// `true` or `false`.
    ///
    /// # Errors
    /// As [`Settings::integer`].
    pub fn boolean(&self, name: &str) -> Result<bool, ConfigError> {
        match self.get(name) {
            Some(SettingValue::Boolean(b)) => Ok(*b),
            _ => Err(ConfigError::Incomplete(name.to_owned())),
        }
    }

    /// A word.
    ///
    /// # Errors
    /// As [`Settings::integer`].
    pub fn text(&self, name: &str) -> Result<&str, ConfigError> {
        match self.get(name) {
            Some(SettingValue::Text(t)) => Ok(t),
            _ => Err(ConfigError::Incomplete(name.to_owned())),
        }
    }

    /// A block size.
    ///
    /// # Errors
    /// As [`Settings::integer`].
    pub fn block(&self, name: &str) -> Result<Block, ConfigError> {
        self.text(name)?.parse().map_err(|_| ConfigError::Incomplete(name.to_owned()))
    }
}

impl FromIterator<(String, SettingValue)> for Settings {
    fn from_iter<I: IntoIterator<Item = (String, SettingValue)>>(iter: I) -> Self {
        Self(Arc::new(iter.into_iter().collect()))
    }
}

impl fmt::Display for Settings {
    /// `block=8 index_bits=4`, as records and labels show it. Text that a shell would split or expand is quoted, so
    /// that the list can be split again.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (name, value)) in self.iter().enumerate() {
            write!(f, "{}{name}=", if i > 0 { " " } else { "" })?;
            match value {
                // Quoting fails on a zero byte alone, which no setting holds.
                SettingValue::Text(text) => f.write_str(&shlex::try_quote(text).map_err(|_| fmt::Error)?)?,
                other => write!(f, "{other}")?,
            }
        }
        Ok(())
    }
}
