//! The terms in which keys are described.

use crate::codec::SettingKind;

/// A table and its keys; it has no others.
pub(in crate::pipeline) struct Table {
    /// Its meaning, in one or two sentences.
    pub doc: String,
    /// Its keys, in the order in which they are shown.
    pub keys: Vec<Key>,
    /// Keys that ask for others: `(key, others)`.
    pub needs: Vec<(&'static str, &'static [&'static str])>,
    /// Relations between keys beyond `needs`.
    pub relation: Option<Relation>,
}

/// A relation between keys of one table.
pub(in crate::pipeline) enum Relation {
    /// A named transfer function lies over `"range"`; so do control points between 0 and 1.
    TransferDomain,
    /// These keys are settings of renderers, `(key, renderers)`. One of the renderers must be named.
    RendererSettings(Vec<(String, Vec<String>)>),
}

/// A key of a table.
pub(in crate::pipeline) struct Key {
    pub name: String,
    /// Its effect: a sentence without a full stop.
    pub doc: String,
    pub shape: Shape,
    pub presence: Presence,
    /// Unit of its numbers. Empty if it has none.
    pub unit: &'static str,
}

/// Whether a key must be there.
pub(in crate::pipeline) enum Presence {
    Required,
    /// Its default, written as TOML.
    Default(String),
    /// The meaning of its absence, in words.
    Absent(&'static str),
}

/// The values that a key takes.
pub(in crate::pipeline) enum Shape {
    /// A name: not blank, no control characters.
    Name,
    /// A path: `$NAME` and `${NAME}` are environment variables.
    Path,
    /// Any text.
    Text,
    Boolean,
    /// A whole number, both ends included.
    Integer {
        min: i64,
        max: i64,
    },
    Number(Bounds),
    /// One of these words, each with its meaning (or an empty string).
    Words(Vec<(String, String)>),
    /// `"#rrggbb"`, or `"#rrggbbaa"` if an opacity is allowed.
    Colour {
        opacity: bool,
    },
    /// A setting of a codec or renderer.
    Setting(SettingKind),
    /// A list of exactly these elements.
    Tuple(Vec<Self>),
    /// A list with a least and perhaps a greatest length, and perhaps names for its elements.
    List {
        item: Box<Self>,
        least: usize,
        most: Option<usize>,
    },
    /// One value, or a list of at least one value without repetition.
    Axis(Box<Self>),
    /// One value, or a list of at least one value. Each is tried.
    Sweep(Box<Self>),
    /// Any of these.
    Any(Vec<Self>),
    Table(Table),
    /// A list of tables. Each has one of these kinds.
    Tables(Vec<(String, Table)>),
}

/// Bounds of a number. `None` means unbounded.
#[derive(Copy, Clone, Debug, Default)]
pub(in crate::pipeline) struct Bounds {
    /// Lowest.
    pub min: Option<f64>,
    /// Greater than this.
    pub above: Option<f64>,
    /// Highest.
    pub max: Option<f64>,
    /// Less than this.
    pub below: Option<f64>,
}

impl Bounds {
    pub const ANY: Self = Self { min: None, above: None, max: None, below: None };
    /// Above 0.
    pub const POSITIVE: Self = Self { above: Some(0.0), ..Self::ANY };
    /// From 0 to 1.
    pub const SHARE: Self = Self::range(0.0, 1.0);
    /// Finite in single precision.
    pub const SINGLE: Self = Self::range(f32::MIN as f64, f32::MAX as f64);

    pub const fn range(min: f64, max: f64) -> Self {
        Self { min: Some(min), max: Some(max), ..Self::ANY }
    }

    /// Whether a number lies within them.
    pub fn hold(&self, number: f64) -> bool {
        self.min.is_none_or(|min| number >= min)
            && self.above.is_none_or(|above| number > above)
            && self.max.is_none_or(|max| number <= max)
            && self.below.is_none_or(|below| number < below)
    }
}

impl Key {
    pub fn new(name: &str, shape: Shape, presence: Presence, doc: impl Into<String>) -> Self {
        Self { name: name.to_owned(), doc: doc.into(), shape, presence, unit: "" }
    }

    pub fn required(name: &str, shape: Shape, doc: impl Into<String>) -> Self {
        Self::new(name, shape, Presence::Required, doc)
    }

    /// `default` is written as in a configuration.
    pub fn with_default(
        name: &str,
        shape: Shape,
        default: impl Into<String>,
        doc: impl Into<String>,
    ) -> Self {
        Self::new(name, shape, Presence::Default(default.into()), doc)
    }

    pub fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }
}

impl Table {
    /// The names of its keys.
    pub fn names(&self) -> Vec<&str> {
        self.keys.iter().map(|key| key.name.as_str()).collect()
    }

    pub fn new(doc: impl Into<String>, keys: Vec<Key>) -> Self {
        Self { doc: doc.into(), keys, needs: Vec::new(), relation: None }
    }
}

impl Shape {
    /// The allowed words at any depth outside tables, each with its meaning or an empty string.
    pub fn words(&self) -> &[(String, String)] {
        match self {
            Self::Words(words) => words,
            Self::Axis(item) | Self::Sweep(item) | Self::List { item, .. } => item.words(),
            Self::Any(shapes) => {
                shapes.iter().map(Self::words).find(|words| !words.is_empty()).unwrap_or(&[])
            }
            _ => &[],
        }
    }
}
