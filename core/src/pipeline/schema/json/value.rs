//! JSON whose objects keep the order of insertion, with any feature set of `serde_json`.

use serde::ser::{Serialize, SerializeMap as _, Serializer};

/// A value of JSON.
#[derive(Clone)]
pub(super) enum Json {
    Value(serde_json::Value),
    List(Vec<Self>),
    Object(Vec<(String, Self)>),
}

impl Json {
    pub const fn object() -> Self {
        Self::Object(Vec::new())
    }

    /// Adds a member. A value that is not an object becomes one.
    pub fn with(self, name: &str, value: impl Into<Self>) -> Self {
        self.merged(Self::Object(vec![(name.to_owned(), value.into())]))
    }

    /// Appends the members of another object, except those that it already has.
    pub fn merged(self, other: Self) -> Self {
        let members = |value| match value {
            Self::Object(members) => members,
            _ => Vec::new(),
        };
        let mut all = members(self);
        for (name, value) in members(other) {
            if !all.iter().any(|(present, _)| *present == name) {
                all.push((name, value));
            }
        }
        Self::Object(all)
    }

    /// Indented by two spaces.
    pub fn text(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default()
    }
}

impl Serialize for Json {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Value(value) => value.serialize(serializer),
            Self::List(items) => items.serialize(serializer),
            Self::Object(members) => {
                let mut map = serializer.serialize_map(Some(members.len()))?;
                for (name, value) in members {
                    map.serialize_entry(name, value)?;
                }
                map.end()
            }
        }
    }
}

impl From<serde_json::Value> for Json {
    fn from(value: serde_json::Value) -> Self {
        Self::Value(value)
    }
}

impl From<&str> for Json {
    fn from(text: &str) -> Self {
        Self::Value(text.into())
    }
}

impl From<String> for Json {
    fn from(text: String) -> Self {
        Self::Value(text.into())
    }
}

impl From<i64> for Json {
    fn from(number: i64) -> Self {
        Self::Value(number.into())
    }
}

impl From<f64> for Json {
    /// Whole numbers without a fraction.
    fn from(number: f64) -> Self {
        let whole = number as i64;
        if whole as f64 == number && number.abs() < 1e15 { whole.into() } else { Self::Value(number.into()) }
    }
}

impl From<bool> for Json {
    fn from(value: bool) -> Self {
        Self::Value(value.into())
    }
}
