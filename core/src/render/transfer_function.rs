//! The transfer function: data value → colour and opacity, piecewise linear.

mod search;

use serde::{Deserialize, Serialize};

pub use search::SegmentSearch;

use crate::volume::ValueRange;

/// One point of a transfer function.
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControlPoint {
    /// Data value.
    pub value: f32,
    /// Straight (not premultiplied) RGBA, `0.0..=1.0`. The opacity is per voxel length.
    pub rgba: [f32; 4],
}

/// Piecewise linear, constant beyond its ends, exact however narrow a segment is.
///
/// Two points of one value make a step. At the value itself the later one applies. Of more than two points of one
/// value, the middle ones never show.
///
/// At a point's value the colour equals the point's, bit for bit. Between two points it is within 3 × 2⁻²³ (3 units in
/// the last place of 1) of the straight line. Shader (`shaders/classify/transfer.wgsl`) and CPU read the same numbers
/// and compute in the same order.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    points: Vec<ControlPoint>,
    /// Number of segments before segment k that show anything. Segment k lies between the points k − 1 and k. The first
    /// and the last segment lie beyond the ends.
    shown_before: Vec<u32>,
    search: SegmentSearch,
}

/// Position of a value within a segment, 0 to 1: `share_of` of the shader.
///
/// The scale is a power of two that brings the larger end of the segment to 2 … 4: the biased exponents of both add up
/// to 255. Products with it are exact, and no difference overflows or underflows.
fn share_of(value: f32, [low, high]: [f32; 2]) -> f32 {
    let larger = low.abs().max(high.abs()).max(1e-37);
    let scale = f32::from_bits(!larger.to_bits() & f32::INFINITY.to_bits());
    let first = low * scale;
    ((value.clamp(low, high) * scale - first) / (high * scale - first).max(1e-9)).min(1.0)
}

/// Why control points make no transfer function.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TransferFunctionError {
    /// Fewer than two points.
    #[error("a transfer function needs at least two control points, this has {0}")]
    TooFew(usize),
    /// More points than [`TransferFunction::MAX_POINTS`].
    #[error(
        "a transfer function has at most {most} control points, this has {0}",
        most = TransferFunction::MAX_POINTS
    )]
    TooMany(usize),
    /// Values decrease or are not finite.
    #[error("control point {0}: its value must be finite and not below the one before")]
    Order(usize),
    /// All points at one value.
    #[error("all control points lie at one value")]
    Flat,
}

impl TransferFunction {
    /// Most control points.
    pub const MAX_POINTS: usize = 4096;
    /// Rows of [`TransferFunction::table`].
    pub const TABLE_ROWS: usize = 3;

    /// A function of 2 to [`TransferFunction::MAX_POINTS`] points. Values do not decrease. A subnormal value counts as
    /// 0, as in volumes.
    ///
    /// # Errors
    /// When there are too few or too many points, or their values are out of order or all equal.
    pub fn new(mut points: Vec<ControlPoint>) -> Result<Self, TransferFunctionError> {
        if points.len() < 2 {
            return Err(TransferFunctionError::TooFew(points.len()));
        }
        if points.len() > Self::MAX_POINTS {
            return Err(TransferFunctionError::TooMany(points.len()));
        }
        for point in &mut points {
            point.value = flushed(point.value);
        }
        for (i, point) in points.iter().enumerate() {
            if !point.value.is_finite() || i > 0 && point.value < points[i - 1].value {
                return Err(TransferFunctionError::Order(i + 1));
            }
        }
        let values: Vec<f32> = points.iter().map(|p| p.value).collect();
        if values[0] >= values[values.len() - 1] {
            return Err(TransferFunctionError::Flat);
        }
        let mut function = Self { points, shown_before: vec![0], search: SegmentSearch::of(&values) };
        for segment in 0..=values.len() {
            let before = function.shown_before[segment];
            function.shown_before.push(before + u32::from(function.shows(segment)));
        }
        Ok(function)
    }

    /// First to last control point.
    #[must_use]
    pub fn domain(&self) -> ValueRange {
        ValueRange { min: self.points[0].value, max: self.points[self.points.len() - 1].value }
    }

    /// The control points.
    #[must_use]
    pub fn points(&self) -> &[ControlPoint] {
        &self.points
    }

    /// How a shader finds the segment of a value.
    #[must_use]
    pub const fn search(&self) -> SegmentSearch {
        self.search
    }

    /// The search's data in the view: all control points, the last one repeated; or the ends of the domain, cells per
    /// data unit, and the last cell of a guide.
    #[must_use]
    pub fn search_keys(&self) -> [[f32; 4]; 2] {
        self.search.keys(&self.values())
    }

    /// The texels of the table for shaders, [`TransferFunction::TABLE_ROWS`] rows of equal length: the search's data;
    /// straight RGBA at the start of each segment; and the two values at the ends of each segment.
    #[must_use]
    pub fn table(&self) -> Vec<[f32; 4]> {
        let last = self.search.last_segment(self.points.len());
        let ends = |segment: usize| {
            let [low, high] = self.ends(segment);
            [low, high, 0.0, 0.0]
        };
        let colours = (0..=last + 1).map(|segment| self.colour(segment)).collect();
        let rows: [Vec<[f32; 4]>; Self::TABLE_ROWS] =
            [self.search.texels(&self.values()), colours, (0..=last).map(ends).collect()];
        let width = rows.iter().map(Vec::len).max().unwrap_or(0);
        let padded = |mut row: Vec<[f32; 4]>| {
            row.resize(width, [0.0; 4]);
            row
        };
        rows.into_iter().flat_map(padded).collect()
    }

    /// Colour and opacity of a data value, with the arithmetic of `transfer` in the shaders.
    #[must_use]
    pub fn classify(&self, value: f32) -> [f32; 4] {
        let segment = self.segment(value);
        let share = share_of(value, self.ends(segment));
        let (low, high) = (self.colour(segment), self.colour(segment + 1));
        std::array::from_fn(|c| low[c] + (high[c] - low[c]) * share)
    }

    /// Whether no value of `range` shows anything. The answer is exact.
    #[must_use]
    pub fn is_transparent(&self, range: ValueRange) -> bool {
        if range.min.is_nan() || range.max.is_nan() {
            return false;
        }
        // A device may take subnormal values for 0.
        let (min, max) = (range.min.min(flushed(range.min)), range.max.max(flushed(range.max)));
        let (first, last) = (self.segment(min), self.segment(max));
        // The range may contain only the first value of the last segment.
        let begins = last > 0 && self.points[last - 1].value == max;
        let end = if begins { last } else { last + 1 };
        let shown = self.shown_before[end.max(first)] - self.shown_before[first];
        shown == 0 && !(begins && self.points[last - 1].rgba[3] > 0.0)
    }

    /// The segment of a value: the number of points at or below it.
    fn segment(&self, value: f32) -> usize {
        self.points.partition_point(|p| p.value <= value)
    }

    /// The colour at the start of a segment: that of the point before it.
    fn colour(&self, segment: usize) -> [f32; 4] {
        self.points[segment.saturating_sub(1).min(self.points.len() - 1)].rgba
    }

    /// The values at the ends of a segment. Beyond the points, both are the same.
    fn ends(&self, segment: usize) -> [f32; 2] {
        let last = self.points.len() - 1;
        [segment.saturating_sub(1), segment].map(|point| self.points[point.min(last)].value)
    }

    /// Whether a segment contains a value that shows. A segment of width zero contains none.
    fn shows(&self, segment: usize) -> bool {
        let is_step = (1..self.points.len()).contains(&segment)
            && self.points[segment - 1].value >= self.points[segment].value;
        !is_step && (self.colour(segment)[3] > 0.0 || self.colour(segment + 1)[3] > 0.0)
    }

    fn values(&self) -> Vec<f32> {
        self.points.iter().map(|p| p.value).collect()
    }
}

fn flushed(value: f32) -> f32 {
    if value.is_subnormal() { 0.0 } else { value }
}

#[cfg(test)]
mod tests;
