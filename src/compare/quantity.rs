//! Quantities of two cells, and when their difference exceeds noise.

use crate::experiment::records::record::Record;

/// How a quantity is compared.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A median over many frames, with its interquartile range: as a ratio, within the noise of both sides.
    Paired,
    /// A time that was taken once, or a few times: as a ratio, within a noise that the reader names.
    Once,
    /// A size, the same wherever it comes from: as a ratio, without noise.
    Size,
    /// Decibels: as a difference; one that no printed digit shows counts as none.
    Decibels,
}

/// A quantity of records.
#[derive(Copy, Clone, Debug)]
pub struct Quantity {
    /// The record's field.
    pub field: &'static str,
    /// Heading.
    pub name: &'static str,
    /// How it is compared.
    pub kind: Kind,
    value: fn(&Record) -> Option<f64>,
    spread: fn(&Record) -> Option<f64>,
}

const fn quantity(
    field: &'static str,
    name: &'static str,
    kind: Kind,
    value: fn(&Record) -> Option<f64>,
) -> Quantity {
    Quantity { field, name, kind, value, spread: |_| None }
}

/// The compared quantities, in the order of the tables.
pub const QUANTITIES: [Quantity; 9] = [
    quantity("encode_seconds", "encode", Kind::Once, |r| r.encode_seconds),
    quantity("decode_seconds", "decode", Kind::Once, |r| r.decode_seconds),
    quantity("device_decode_ms", "on device", Kind::Once, |r| r.device_decode_ms),
    Quantity { spread: |r| r.frame_ms_iqr, ..quantity("frame_ms", "frame", Kind::Paired, |r| r.frame_ms) },
    Quantity {
        spread: |r| r.relative_frame_time_iqr,
        ..quantity("relative_frame_time", "rel. frame", Kind::Paired, |r| r.relative_frame_time)
    },
    quantity("resident_bytes", "memory", Kind::Size, |r| Some(r.resident_bytes? as f64)),
    quantity("bits_per_voxel", "bits", Kind::Size, |r| r.bits_per_voxel),
    quantity("psnr_db", "PSNR, dB", Kind::Decibels, |r| r.psnr_db),
    quantity("image_psnr_db", "picture, dB", Kind::Decibels, |r| r.image_psnr_db),
];

/// Half of the last digit that decibels are shown with.
const DECIBELS_SHOWN: f64 = 0.005;
/// Rounding error of a size that was divided.
const SIZE_ROUNDING: f64 = 1e-9;

/// Where a value lies against the first.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// Below it by more than noise.
    Less,
    /// Within noise.
    Tie,
    /// Above it by more than noise.
    More,
}

impl Verdict {
    /// As files have it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Less => "less",
            Self::Tie => "tie",
            Self::More => "more",
        }
    }
}

/// A quantity of two matched cells.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Compared {
    /// Value of the first run.
    pub first: f64,
    /// Value of the other.
    pub other: f64,
    /// Other ÷ first, or other − first for decibels.
    pub change: f64,
    /// The noise. A change within it is a tie: a ratio between 1 ÷ (1 + noise) and 1 + noise, a difference of decibels within
    /// ± noise.
    pub noise: f64,
    /// Whether it does.
    pub verdict: Verdict,
}

impl Quantity {
    /// Compares two records; `None` where either has no value, or none that could be divided.
    ///
    /// The noise of a median is half its interquartile range over it, and that of a ratio the sum of both: a tie is where
    /// the middle halves of the two measurements meet. `once` is the noise of times that were taken once.
    #[must_use]
    pub fn compare(&self, first: &Record, other: &Record, once: f64) -> Option<Compared> {
        let (a, b) = ((self.value)(first)?, (self.value)(other)?);
        if a.is_nan() || b.is_nan() {
            return None;
        }
        if self.kind == Kind::Decibels {
            // Two lossless cells do not differ.
            let change = if a == b { 0.0 } else { b - a };
            return Some(Compared {
                first: a,
                other: b,
                change,
                noise: DECIBELS_SHOWN,
                verdict: sign(change, DECIBELS_SHOWN),
            });
        }
        if !(a > 0.0 && b > 0.0 && a.is_finite() && b.is_finite()) {
            return None;
        }
        let noise = match self.kind {
            Kind::Size => SIZE_ROUNDING,
            Kind::Once | Kind::Decibels => once,
            Kind::Paired => match ((self.spread)(first), (self.spread)(other)) {
                (Some(of_a), Some(of_b)) => 0.5 * (of_a / a + of_b / b),
                _ => once,
            },
        };
        let change = b / a;
        Some(Compared { first: a, other: b, change, noise, verdict: sign(change.ln(), noise.ln_1p()) })
    }
}

fn sign(change: f64, noise: f64) -> Verdict {
    if change.abs() <= noise {
        Verdict::Tie
    } else if change < 0.0 {
        Verdict::Less
    } else {
        Verdict::More
    }
}
