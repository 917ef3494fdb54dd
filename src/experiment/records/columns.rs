//! The table of a record's columns, and the macro that makes the record from it.

/// How a report shows a column.
#[derive(Copy, Clone, Debug)]
pub struct Shown {
    /// Heading.
    pub heading: &'static str,
    /// Name and unit on a chart's axis, if the heading is not enough. Values on the axis are in the record's unit.
    pub axis: Option<&'static str>,
    /// Left out when the report is printed, because paper is narrow.
    pub secondary: bool,
    /// Conversion of its values to text.
    pub format: Format,
}

/// Conversion of a value to text.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Format {
    /// As it is.
    Text,
    /// The settings that differ among the cells of a codec.
    Settings,
    /// Name of the record's curve.
    Series,
    /// A file beside the report, linked.
    File,
    /// A number of stages, or all.
    Stages,
    /// A whole number.
    Count,
    /// A whole number, if a shader ran.
    Parity,
    /// Bytes in binary units.
    Bytes,
    /// Three significant digits.
    Short,
    /// The same, in millions.
    Millions,
    /// So many decimals.
    Fixed(usize),
    /// A figure of the metrics' list: three significant digits.
    Listed,
    /// A picture. The table of a report omits it.
    Picture,
}

impl Format {
    /// Whether its values are numbers.
    #[must_use]
    pub const fn is_numeric(self) -> bool {
        match self {
            Self::Count
            | Self::Parity
            | Self::Bytes
            | Self::Short
            | Self::Millions
            | Self::Fixed(_)
            | Self::Listed => true,
            Self::Text | Self::Settings | Self::Series | Self::File | Self::Stages | Self::Picture => false,
        }
    }
}

impl Shown {
    /// Under this heading, in this format.
    #[must_use]
    pub const fn new(heading: &'static str, format: Format) -> Self {
        Self { heading, axis: None, secondary: false, format }
    }

    /// A figure, whose heading and axis `cvr_core::metrics::figures` has.
    #[must_use]
    pub const fn figure(format: Format) -> Self {
        Self::new("", format)
    }

    /// A figure of the metrics' list.
    pub const LISTED: Self = Self::figure(Format::Listed).secondary();

    /// A picture.
    pub const PICTURE: Self = Self::new("", Format::Picture);

    /// Left out on paper.
    #[must_use]
    pub const fn secondary(self) -> Self {
        Self { secondary: true, ..self }
    }

    /// Under another name on an axis.
    #[must_use]
    pub const fn axis(self, name: &'static str) -> Self {
        Self { axis: Some(name), ..self }
    }
}

/// The value of a column in one record.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Value<'a> {
    /// A text.
    Text(Option<&'a str>),
    /// A whole number.
    Count(Option<u64>),
    /// A number.
    Number(Option<f64>),
    /// Yes or no.
    Switch(bool),
}

impl<'a> From<&'a String> for Value<'a> {
    fn from(text: &'a String) -> Self {
        Self::Text(Some(text))
    }
}

impl<'a> From<&'a Option<String>> for Value<'a> {
    fn from(text: &'a Option<String>) -> Self {
        Self::Text(text.as_deref())
    }
}

impl From<&bool> for Value<'_> {
    fn from(switch: &bool) -> Self {
        Self::Switch(*switch)
    }
}

impl From<&Option<f64>> for Value<'_> {
    fn from(number: &Option<f64>) -> Self {
        Self::Number(*number)
    }
}

macro_rules! counts {
    ($($type:ty)*) => {
        $(
            impl From<&$type> for Value<'_> {
                fn from(count: &$type) -> Self {
                    Self::Count(Some((*count).into()))
                }
            }

            impl From<&Option<$type>> for Value<'_> {
                fn from(count: &Option<$type>) -> Self {
                    Self::Count(count.map(Into::into))
                }
            }
        )*
    };
}

counts!(u8 u32 u64);

/// A column of records `R`.
#[derive(Debug)]
pub struct Column<R> {
    /// The field, as in `results.csv`.
    pub name: &'static str,
    /// How a report shows it.
    pub shown: Shown,
    /// Its value in a record.
    pub value: for<'a> fn(&'a R) -> Value<'a>,
}

impl<R> Copy for Column<R> {}

impl<R> Clone for Column<R> {
    fn clone(&self) -> Self {
        *self
    }
}

/// Writes `Record` from a table of its columns, each `name: type, how frames are pooled, how it is shown;`. Names of
/// the metrics' figures are in brackets at their place.
macro_rules! columns {
    (
        $($(#[$first_says:meta])* $first:ident: $first_type:ty, $first_pooled:ident, $first_shown:expr;)*
        [$($figure:ident)*]
        $($(#[$then_says:meta])* $then:ident: $then_type:ty, $then_pooled:ident, $then_shown:expr;)*
    ) => {
        /// The result of one cell. `None`: not measured or not defined, an empty field in CSV. PSNR of identical data
        /// is infinite: `inf` in CSV, `null` in JSON with `max_abs_error` 0.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        pub struct Record {
            $($(#[$first_says])* pub $first: $first_type,)*
            $(
                #[doc = concat!("`", stringify!($figure), "`, as `cvr_core::metrics::figures` and `docs/user/evaluation.md` define it.")]
                #[serde(default)]
                pub $figure: Option<f64>,
            )*
            $($(#[$then_says])* pub $then: $then_type,)*
        }

        impl Record {
            /// All columns, in the order of the fields.
            pub const COLUMNS: &[Column<Self>] = &[
                $(Column {
                    name: stringify!($first),
                    shown: $first_shown,
                    value: |record| (&record.$first).into(),
                },)*
                $(Column {
                    name: stringify!($figure),
                    shown: Shown::LISTED,
                    value: |record| (&record.$figure).into(),
                },)*
                $(Column {
                    name: stringify!($then),
                    shown: $then_shown,
                    value: |record| (&record.$then).into(),
                },)*
            ];

            /// Pools the values of frames, for each column as the table says.
            pub(crate) fn pool(&mut self, frames: &[Self]) {
                $(pooled::$first_pooled(&mut self.$first, frames.iter().map(|frame| &frame.$first));)*
                $(pooled::$then_pooled(&mut self.$then, frames.iter().map(|frame| &frame.$then));)*
            }

            /// The figures that are listed, with their columns' names.
            pub fn figures_mut(&mut self) -> Vec<(&'static str, &mut Option<f64>)> {
                vec![$((stringify!($figure), &mut self.$figure)),*]
            }
        }
    };
}
pub(super) use columns;
