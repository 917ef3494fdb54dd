//! Adversarial volumes. They are made with integer arithmetic, so they are equal on every platform.

use crate::codec::{Block, Codec, Settings};
use crate::volume::{DenseVolume, Extent, SampleType, Samples, VolumeLayout};

/// One adversarial volume.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Name such as `noise u16 13×17×23`, with channels and frames if they are not 1.
    pub name: String,
    /// The volume; it may hold NaN, infinities and subnormals.
    pub volume: DenseVolume,
    /// Whether its stream is also damaged in every way. One volume of each kind of layout is enough.
    pub tamper: bool,
}

/// A sample as a function of position, channel, frame, extent and number type.
type Pattern = fn(&At) -> f64;

/// Where a sample lies.
struct At {
    p: [u32; 3],
    channel: u32,
    frame: u32,
    extent: [u32; 3],
    /// Lowest and highest value of the number type; ±1000 for floats.
    low: f64,
    high: f64,
}

impl At {
    /// A uniformly distributed hash of position, channel and frame.
    fn hash(&self) -> u32 {
        let mut h = 0x9e37_79b9_u32;
        for v in [self.p[0], self.p[1], self.p[2], self.channel, self.frame] {
            h = (h ^ v).wrapping_mul(0x85eb_ca6b);
            h ^= h >> 13;
            h = h.wrapping_mul(0xc2b2_ae35);
            h ^= h >> 16;
        }
        h
    }

    fn mix(&self, t: f64) -> f64 {
        self.low + (self.high - self.low) * t
    }
}

const PATTERNS: &[(&str, Pattern)] = &[
    ("constant", |a| a.mix(0.3)),
    ("zero", |_| 0.0),
    ("ramp", |a| {
        let [x, y, z] = a.p;
        a.mix(f64::from(x + 2 * y + 3 * z) / f64::from(a.extent[0] + 2 * a.extent[1] + 3 * a.extent[2]))
    }),
    ("step", |a| a.mix(if a.p[0] < a.extent[0] / 2 { 0.0 } else { 1.0 })),
    ("one hot voxel", |a| a.mix(if a.p == a.extent.map(|e| e / 2) { 1.0 } else { 0.1 })),
    ("checkerboard", |a| a.mix(f64::from(a.p.iter().sum::<u32>() % 2))),
    ("noise", |a| a.mix(f64::from(a.hash()) / f64::from(u32::MAX))),
    ("thin sheet", |a| a.mix(if a.p[2] == a.extent[2] / 2 { 0.9 } else { 0.5 })),
    ("huge offset, tiny signal", |a| a.high * 0.9 + f64::from(a.hash() % 2) * (a.high / 2e4).max(1e-3)),
];

/// Patterns that only floats can hold.
const FLOAT_PATTERNS: &[(&str, Pattern)] = &[
    ("2^24 + 1", |a| 16_777_216.0 + f64::from(a.hash() % 5) - 2.0),
    ("zeros of both signs", |a| if a.hash() % 2 == 0 { -0.0 } else { 0.0 }),
    ("NaN, infinities, subnormals", |a| match a.hash() % 7 {
        0 => f64::NAN,
        1 => f64::INFINITY,
        2 => f64::NEG_INFINITY,
        3 => 1e-40,
        4 => -1e-45,
        n => f64::from(n) * 1.5,
    }),
    ("only NaN", |_| f64::NAN),
    ("smallest normals", |a| f64::from(f32::MIN_POSITIVE) * f64::from(a.hash() % 64 + 1)),
    ("tiny", |a| f64::from(a.hash() % 1000) * 1e-25 - 3e-23),
    ("largest", |a| if a.hash() % 2 == 0 { f64::from(f32::MAX) } else { f64::from(f32::MIN) }),
    ("many magnitudes", |a| {
        let scale = 10_f64.powi(i32::try_from(a.hash() >> 8 & 31).unwrap_or(0) - 20);
        (f64::from(a.hash() & 0xff) - 128.0) * scale
    }),
    ("fractions", |a| f64::from(a.hash()) / 1e7 - 123.456),
];

/// All volumes of the conformance tests. `block` is the codec's block.
#[must_use]
pub fn subjects(block: Block) -> Vec<Subject> {
    let odd = [13, 17, 23];
    let mut all = Vec::new();
    for sample in SampleType::ALL {
        for (name, pattern) in PATTERNS {
            all.extend(subject(name, *pattern, sample, odd, 1, 1));
        }
        let noise = PATTERNS[6].1;
        for size in sizes(block) {
            all.extend(subject("noise", noise, sample, size, 1, 1));
        }
        all.extend(subject("noise", noise, sample, [7, 6, 5], 3, 1));
        all.extend(subject("ramp", PATTERNS[2].1, sample, [9, 5, 10], 1, 2));
        all.extend(subject("noise", noise, sample, [5, 9, 3], 3, 2));
    }
    for (name, pattern) in FLOAT_PATTERNS {
        all.extend(subject(name, *pattern, SampleType::F32, odd, 1, 1));
    }
    let kind = |s: &Subject| {
        let layout = crate::volume::BrickSource::layout(&s.volume);
        (layout.sample, layout.channels, layout.frames)
    };
    for i in 0..all.len() {
        all[i].tamper = all[..i].iter().all(|s| kind(s) != kind(&all[i]));
    }
    all
}

/// One voxel, lines along each axis, and the block ± 1 (along one axis at a time where the cube would be large).
fn sizes(block: Block) -> Vec<[u32; 3]> {
    let [x, y, z] = block.0.to_array();
    let less = |n: u32| n.saturating_sub(1).max(1);
    let mut sizes = vec![[1, 1, 1], [1, 29, 1], [37, 1, 1], [1, 1, 11]];
    if x * y * z <= 1 << 13 {
        sizes.extend([[x + 1, y + 1, z + 1], [less(x), y, less(z)]]);
    } else {
        sizes.extend([[x + 1, 3, 2], [less(x), 1, 3], [2, y + 1, 3], [3, 2, z + 1]]);
    }
    sizes
}

/// The codec's block, else 4³.
pub(super) fn block_of(codec: &dyn Codec, settings: &Settings) -> Block {
    codec.block(settings).unwrap_or_else(|| Block(Extent::cube(4).unwrap_or(Extent::ONE)))
}

#[allow(clippy::cast_possible_truncation, reason = "values are rounded into the range of the type")]
fn subject(
    name: &str,
    pattern: Pattern,
    sample: SampleType,
    size: [u32; 3],
    channels: u32,
    frames: u32,
) -> Option<Subject> {
    let extent = Extent::try_from(size).ok()?;
    let layout = VolumeLayout { channels, frames, ..VolumeLayout::scalar(extent, sample) };
    let (low, high) = sample.integer_range().map_or((-1000.0, 1000.0), |(l, h)| (l.into(), h.into()));
    let mut values = Vec::with_capacity(layout.samples() as usize);
    for frame in 0..frames {
        for p in crate::volume::Region::whole(extent).rows() {
            for x in 0..size[0] {
                for channel in 0..channels {
                    let at = At { p: [x, p[1], p[2]], channel, frame, extent: size, low, high };
                    values.push(pattern(&at));
                }
            }
        }
    }
    let integers = || values.iter().map(|v| v.round().clamp(low, high));
    let samples = match sample {
        SampleType::U8 => Samples::U8(integers().map(|v| v as u8).collect()),
        SampleType::I8 => Samples::I8(integers().map(|v| v as i8).collect()),
        SampleType::U16 => Samples::U16(integers().map(|v| v as u16).collect()),
        SampleType::I16 => Samples::I16(integers().map(|v| v as i16).collect()),
        SampleType::F32 => Samples::F32(values.iter().map(|&v| v as f32).collect()),
    };
    let more = |n: u32, what: &str| if n == 1 { String::new() } else { format!(", {n} {what}") };
    let name = format!("{name} {sample} {extent}{}{}", more(channels, "channels"), more(frames, "frames"));
    Some(Subject { name, volume: DenseVolume::new(layout, samples).ok()?, tamper: false })
}
