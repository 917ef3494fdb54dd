//! The inverse transform on a device: for each level one pass along z, one along y and one along x.

pub mod text;

use std::borrow::Cow;

use cvr_core::codec::{
    Agreement, DecodeError, Decoder as _, FrameDecode, FramePass, FramePasses, Resource, Scratch, ScratchUse,
    WgslModule, check_key_at,
};
use cvr_core::volume::{BrickKey, FrameIndex, Level, Region};

use self::text::PAIRS;
use crate::coders::corrections::Correction;
use crate::decode::integer_step;
use crate::quantiser::Rule;
use crate::reader::Reader;
use crate::transform::{Filter, Shape};

/// Units in the last place of the largest sample by which a device may differ: it sums in single precision what the CPU
/// lifts in double.
const ULP: u32 = 64;

/// A pass, its constants and its workgroups.
fn pass<'a>(
    module: WgslModule<'a>,
    entry: &'static str,
    workgroups: [usize; 3],
    scratch: &[(&'static str, &'static str)],
) -> FramePass<'a> {
    FramePass {
        module,
        entry,
        workgroups: workgroups.map(|n| n as u32),
        scratch: scratch.iter().map(|&(name, buffer)| ScratchUse { name, buffer }).collect(),
    }
}

/// Workgroups of 64 invocations in two dimensions, which have limits of their own.
fn spread(invocations: usize) -> [usize; 3] {
    let groups = invocations.div_ceil(64);
    [groups.min(1024), groups.div_ceil(1024), 1]
}

fn vector(of: [usize; 3]) -> [u32; 3] {
    of.map(|n| n as u32)
}

/// The words of a band's rule.
fn words(filter: Filter, start: usize, rule: Rule) -> [u32; 3] {
    let step = if filter.is_integer() { integer_step(rule) as u32 } else { (rule.step as f32).to_bits() };
    [start as u32, step, (rule.offset as f32).to_bits()]
}

/// The frame, in data units.
const DECODED: &str = "decoded";
/// The buffers that levels alternate between.
const BUFFERS: [&str; 2] = ["a", "b"];

/// One channel of a frame at a resolution.
struct Channel<'a> {
    reader: &'a Reader,
    resolution: usize,
    channel: usize,
}

impl<'a> Channel<'a> {
    /// Constants of what writes to the frame.
    fn framed(&self, module: WgslModule<'a>) -> WgslModule<'a> {
        let shared = &self.reader.shared;
        module
            .with("scale", shared.low_scale(self.resolution) as f32)
            .with("least", shared.range.min)
            .with("most", shared.range.max)
    }

    fn channels(&self) -> usize {
        self.reader.layout().channels as usize
    }

    /// First entry of the bands of a level.
    fn table(&self, level: usize) -> u32 {
        (self.channel * self.reader.shared.pyramid.bands().len() + 7 * level) as u32
    }

    /// The passes of a level. The low band of the level before lies in the first of `buffers`; the samples end in the
    /// second, or in the frame.
    fn level(&self, level: usize, is_last: bool, buffers: [&'static str; 2]) -> [FramePass<'a>; 3] {
        let (shared, texts) = (&self.reader.shared, &self.reader.texts);
        let pyramid = &shared.pyramid;
        let samples = pyramid.extent(pyramid.levels() - 1 - level);
        let [gx, gy, _] = Shape::new(samples, shared.filter.pads()).coefficients;
        let (grid, [sx, sy, sz]) = (Shape::new(samples, shared.filter.pads()).coefficients, samples);
        let low = pyramid.extent(pyramid.levels() - level);
        let runs = |n: usize| n.div_ceil(2 * PAIRS as usize);
        let [held, other] = buffers;
        let of_line = |source: &'a str, n: usize| {
            let file = "codecs/wavelet/src/passes";
            WgslModule::new(file, source).with("samples", n as u32).with("pairs", PAIRS as u32)
        };
        let bands = of_line(&texts.bands, sz)
            .with("grid", vector(grid))
            .with("low_extent", vector(low))
            .with("table", self.table(level))
            .with("first", u32::from(level == 0));
        let along_y = of_line(&texts.axis, sy)
            .with("lines", gx as u32)
            .with("from_strides", vector([gx, 1, gx * gy]))
            .with("to_strides", vector([gx, 1, gx * sy]))
            .with("to_start", 0);
        let (c, text) = if is_last { (self.channels(), &texts.last) } else { (1, &texts.axis) };
        let along_x = of_line(text, sx)
            .with("lines", sy as u32)
            .with("from_strides", vector([1, gx, gx * sy]))
            .with("to_strides", vector([c, c * sx, c * sx * sy]))
            .with("to_start", if is_last { self.channel as u32 } else { 0 });
        let (along_x, to) = if is_last { (self.framed(along_x), DECODED) } else { (along_x, other) };
        [
            pass(bands, "bands_pass", [gx.div_ceil(64), gy, runs(sz)], &[("from", held), ("to", other)]),
            pass(along_y, "axis_pass", [gx.div_ceil(64), sz, runs(sy)], &[("from", other), ("to", held)]),
            pass(along_x, "axis_pass", [sy.div_ceil(64), sz, runs(sx)], &[("from", held), ("to", to)]),
        ]
    }

    /// The pass of a frame without decompositions.
    fn lll(&self, samples: usize) -> FramePass<'a> {
        let module = WgslModule::new("codecs/wavelet/src/passes/lll.wgsl", &self.reader.texts.lll)
            .with("samples", samples as u32)
            .with("table", self.table(0))
            .with("channels", self.channels() as u32)
            .with("channel", self.channel as u32);
        pass(self.framed(module), "lll_pass", spread(samples), &[("to", DECODED)])
    }

    /// The pass that corrects samples. `start` is the first correction of the channel.
    fn corrections(&self, start: usize, count: usize) -> FramePass<'a> {
        let shared = &self.reader.shared;
        let module = WgslModule::new("codecs/wavelet/src/passes/correct.wgsl", include_str!("correct.wgsl"))
            .with("count", count as u32)
            .with("start", start as u32)
            .with("channels", self.channels() as u32)
            .with("channel", self.channel as u32)
            .with("unit", shared.correction.unwrap_or(0.0));
        pass(self.framed(module), "correct_pass", spread(count), &[("to", DECODED)])
    }
}

impl FrameDecode for Reader {
    fn passes(&self, frame: FrameIndex, level: Level) -> Result<FramePasses<'_>, DecodeError> {
        let layout = self.layout().at_resolution(level.resolution);
        let key = BrickKey { frame, level, region: Region::whole(layout.extent) };
        check_key_at(self.layout(), self.resolutions(), key)?;
        let (shared, resolution) = (&self.shared, usize::from(level.resolution));
        let levels = shared.pyramid.levels() - resolution;
        let count = shared.pyramid.coefficients(levels);
        let extent = shared.extent(resolution);
        let (mut coefficients, mut bands, mut corrections) = (Vec::new(), Vec::new(), Vec::new());
        let mut passes = Vec::new();
        for channel in 0..self.layout().channels as usize {
            let number = self.number(frame, channel);
            let chunks = self.chunks(number);
            let own = shared.coefficients(resolution, &chunks)?;
            coefficients.extend(own.into_iter().map(|q| q as u32));
            let rules = shared.rules(self.steps[number]);
            for (band, rule) in shared.pyramid.bands().iter().zip(rules) {
                bands.extend(words(shared.filter, channel * count + band.start, rule));
            }
            let channel = Channel { reader: self, resolution, channel };
            let [mut held, mut other] = BUFFERS;
            for level in 0..levels {
                passes.extend(channel.level(level, level + 1 == levels, [held, other]));
                (held, other) = (other, held);
            }
            if levels == 0 {
                passes.push(channel.lll(extent.iter().product()));
            }
            let own = shared.corrections(resolution, &chunks)?;
            if !own.is_empty() {
                passes.push(channel.corrections(corrections.len() / 2, own.len()));
                let words = |Correction { place, units }: Correction| [place, units as u32];
                corrections.extend(own.into_iter().flat_map(words));
            }
        }
        // Padded lines need more room than samples.
        let room = Shape::new(extent, shared.filter.pads()).count() as u64;
        let named = |name, words: Vec<u32>| Resource { name, words: Cow::Owned(words) };
        let mut scratch = vec![Scratch { name: DECODED, words: layout.samples_per_frame() }];
        scratch.extend(BUFFERS.map(|name| Scratch { name, words: room }));
        Ok(FramePasses {
            resources: vec![
                named("coefficients", coefficients),
                named("bands", bands),
                named("corrections", corrections),
            ],
            scratch,
            passes,
            result: DECODED,
        })
    }

    fn agreement(&self) -> Agreement {
        if self.shared.filter.is_integer() { Agreement::Exact } else { Agreement::Ulp(ULP) }
    }
}
