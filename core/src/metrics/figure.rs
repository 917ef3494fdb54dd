//! Name, unit and meaning of each figure. Records, reports and `docs/user/evaluation.md` read this one list.

/// Which values of a figure are good.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Better {
    /// Small ones.
    Lower,
    /// Large ones.
    Higher,
    /// Those near a number that is neither the lowest nor the highest possible.
    Near(&'static str),
}

impl std::fmt::Display for Better {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Lower => f.write_str("lower"),
            Self::Higher => f.write_str("higher"),
            Self::Near(value) => write!(f, "near {value}"),
        }
    }
}

/// One figure that a metric yields.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Column of a record.
    pub name: &'static str,
    /// Heading of its column in a report.
    pub heading: &'static str,
    /// Name and unit on the axis of a chart.
    pub axis: &'static str,
    /// Unit; `1` for a ratio.
    pub unit: &'static str,
    /// Which values are good.
    pub better: Better,
    /// The definition in one sentence, without a full stop.
    pub definition: &'static str,
}

impl Figure {
    /// The figure as a row of the table in `docs/user/evaluation.md`.
    #[must_use]
    pub fn row(&self) -> String {
        let Self { name, unit, better, definition, .. } = self;
        format!("| `{name}` | {unit} | {better} | {definition} |")
    }
}
