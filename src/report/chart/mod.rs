//! A small chart type: series of marks and lines over two axes, drawn as SVG that follows the page's colours.
//!
//! Axes, grid, ticks and labels are `kuva`'s. Marks are ours: charts here distinguish failures, baselines, beaten cells
//! and filters by shape as well as by colour.

mod axis;
mod draw;
mod mark;
mod standalone;

pub use axis::{Axis, Scale};
pub use draw::SIZE;
pub use mark::{Mark, Shape};

/// Colour of a series: an index into the page's palette (CSS variables `--c0`, `--c1`, …).
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Colour {
    /// Entry of the palette, which repeats.
    Series(usize),
    /// The colour of text.
    Ink,
    /// The colour of failures.
    Failure,
}

impl Colour {
    /// Entries of the palette.
    pub const PALETTE: usize = 8;

    /// As a CSS value.
    #[must_use]
    pub fn css(self) -> String {
        match self {
            Self::Series(i) => format!("var(--c{})", i % Self::PALETTE),
            Self::Ink => "var(--ink)".to_owned(),
            Self::Failure => "var(--failure)".to_owned(),
        }
    }
}

/// One mark.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Horizontal value; `+∞` stands at the axis' last tick, if it has one for it.
    pub x: f64,
    /// Vertical value; `+∞` likewise.
    pub y: f64,
    /// Shape, colour, fill.
    pub mark: Mark,
    /// Shown when pointed at.
    pub title: String,
    /// Number of its record, if it has one.
    pub cell: Option<usize>,
    /// Whether it lies on a line of those that none beats.
    pub unbeaten: bool,
}

/// A line through points.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Points in order; infinite values as in [`Point`].
    pub points: Vec<(f64, f64)>,
    /// Colour.
    pub colour: Colour,
    /// Dashed.
    pub dashed: bool,
}

/// One line of the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct LegendEntry {
    /// The sign.
    pub mark: Mark,
    /// The text.
    pub label: String,
}

/// A chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Describes the chart to those who cannot see it.
    pub description: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Lines, below the marks.
    pub lines: Vec<Line>,
    /// Marks; later ones on top.
    pub points: Vec<Point>,
    /// Legend, which the page sets beside the drawing.
    pub legend: Vec<LegendEntry>,
}
