//! Properties of an undamaged stream.

use std::sync::Arc;

use super::decoded::{Decoded, difference};
use super::{Case, Property, Report, module};
use crate::codec::{Decoder, FrameStore};
use crate::volume::{
    BrickKey, BrickSource as _, Extent, FrameIndex, Level, Region, ValueRange, VolumeLayout,
};

/// Decodes the stream and checks every property that needs neither damage nor a device.
pub fn check(case: &Case<'_>, report: &mut Report) {
    let decoder = match case.codec.decoder(Arc::clone(&case.stream)) {
        Ok(decoder) => FrameStore::open(decoder.into(), u64::MAX),
        Err(e) => return report.fail(Property::Stream, e.to_string()),
    };
    let layout = case.volume.layout();
    report.check(Property::Stream, decoder.layout() == layout, || "the decoder's layout differs".to_owned());
    let decoded = match Decoded::at(decoder.as_ref(), Level::FULL) {
        Ok(decoded) => decoded,
        Err(e) => return report.fail(Property::Stream, e),
    };
    for frame in (0..layout.frames).map(FrameIndex) {
        bound(case, frame, decoded.values(frame), report);
        regions(decoder.as_ref(), (frame, Level::FULL), &decoded, report);
    }
    stages(case, decoder.as_ref(), &decoded, report);
    resolutions(case, decoder.as_ref(), report);
    keys(case, decoder.as_ref(), &decoded, report);
    if let Some(shader) = decoder.shader() {
        let problem = module::problem(case.codec.info(), decoder.as_ref(), shader);
        report.check(Property::Module, problem.is_none(), || problem.unwrap_or_default());
    }
    if decoder.frame_decode().is_some() {
        let problem = module::frame_problem(case.codec.info(), decoder.as_ref());
        report.check(Property::Module, problem.is_none(), || problem.unwrap_or_default());
    }
}

/// Decoded values are finite and within the bound that the stream states.
fn bound(case: &Case<'_>, frame: FrameIndex, decoded: &[f32], report: &mut Report) {
    let integers = case.volume.layout().sample.is_integer();
    let source = case.volume.dense().frame_values(frame);
    let strange = decoded.iter().position(|v| !v.is_finite());
    report.check(Property::Bound, strange.is_none(), || format!("sample {strange:?} is not finite"));
    let Some(bound) = case.stream.spec().report.error_bound else { return };
    let error = |(d, s): (&f32, &f32)| {
        let shown = if integers { d.round() } else { *d };
        (f64::from(shown) - f64::from(*s)).abs()
    };
    let worst = decoded.iter().zip(&source).map(error).fold(0.0, f64::max);
    report.check(Property::Bound, worst <= bound, || {
        format!("frame {}: an error of {worst}, the promise is {bound}", frame.0)
    });
}

/// Every level with fewer stages: finite, consistent, and no better than the next.
fn stages(case: &Case<'_>, decoder: &dyn Decoder, all: &Decoded, report: &mut Report) {
    let most = case.codec.stages(case.settings);
    let mut better: Option<Vec<f64>> = None;
    for stages in (1..=most).rev() {
        let level = Level { stages, ..Level::FULL };
        let decoded = match Decoded::at(decoder, level) {
            Ok(decoded) => decoded,
            Err(e) => return report.fail(Property::Stages, format!("{stages} stages: {e}")),
        };
        let frames = (0..case.volume.layout().frames).map(FrameIndex);
        let mut errors = Vec::new();
        for frame in frames {
            let values = decoded.values(frame);
            if stages == most {
                let problem = difference(all.values(frame), values);
                report.check(Property::Stages, problem.is_none(), || {
                    format!("{stages} stages are not all: {problem:?}")
                });
            } else {
                let strange = values.iter().position(|v| !v.is_finite());
                report.check(Property::Stages, strange.is_none(), || {
                    format!("{stages} stages: sample {strange:?} is not finite")
                });
                regions(decoder, (frame, level), &decoded, report);
            }
            let source = case.volume.dense().frame_values(frame);
            let square = |(d, s): (&f32, &f32)| (f64::from(*d) - f64::from(*s)).powi(2);
            errors.push(values.iter().zip(&source).map(square).sum::<f64>());
        }
        for (frame, (own, more)) in errors.iter().zip(better.iter().flatten()).enumerate() {
            // The tolerance covers the rounding of the sums of squares.
            report.check(Property::Stages, *more <= own * (1.0 + 1e-9), || {
                format!("frame {frame}: squared error {own} of {stages} stages, {more} of one more")
            });
        }
        better = Some(errors);
    }
}

/// Every lower resolution: right size, finite, consistent.
fn resolutions(case: &Case<'_>, decoder: &dyn Decoder, report: &mut Report) {
    for resolution in 1..case.codec.resolutions(case.settings) {
        let level = Level { resolution, ..Level::FULL };
        let decoded = match Decoded::at(decoder, level) {
            Ok(decoded) => decoded,
            Err(e) => {
                return report.fail(Property::Resolutions, format!("resolution {resolution}: {e}"));
            }
        };
        for frame in (0..case.volume.layout().frames).map(FrameIndex) {
            let strange = decoded.values(frame).iter().position(|v| !v.is_finite());
            report.check(Property::Resolutions, strange.is_none(), || {
                format!("resolution {resolution}: sample {strange:?} is not finite")
            });
            regions(decoder, (frame, level), &decoded, report);
        }
    }
}

/// Parts of a frame decode to the same values as the whole frame, and lie in their `value_range`.
fn regions(
    decoder: &dyn Decoder,
    (frame, level): (FrameIndex, Level),
    decoded: &Decoded,
    report: &mut Report,
) {
    let layout = &decoder.layout().at_resolution(level.resolution);
    let whole = decoded.values(frame);
    for region in some_regions(layout.extent) {
        let key = BrickKey { frame, level, region };
        let expected = cut(layout, whole, region);
        let mut part = vec![f32::NAN; expected.len()];
        let problem = match decoder.decode_brick(key, decoded, &mut part) {
            Ok(()) => difference(&expected, &part),
            Err(e) => Some(e.to_string()),
        };
        report.check(Property::Regions, problem.is_none(), || format!("{region:?}: {problem:?}"));
        if let Some(ValueRange { min, max }) = decoder.value_range(key) {
            let range = ValueRange { min, max };
            let proper = min.is_finite() && max.is_finite() && min <= max;
            report.check(Property::Range, proper, || format!("{region:?}: {range:?} is no range"));
            let outside = expected.iter().find(|v| !range.contains(**v));
            report.check(Property::Range, outside.is_none(), || {
                format!("{region:?}: {outside:?} lies outside {range:?}")
            });
        }
    }
}

/// The samples of a region, cut from a whole frame.
fn cut(layout: &VolumeLayout, whole: &[f32], region: Region) -> Vec<f32> {
    let channels = layout.channels as usize;
    let row = region.extent.x() as usize * channels;
    let first = |p| layout.extent.index(p) * channels;
    region.rows().flat_map(|p| whole[first(p)..first(p) + row].iter().copied()).collect()
}

/// The whole frame, corners and edges as single voxels, grid cells, and other boxes.
fn some_regions(extent: Extent) -> Vec<Region> {
    let e = extent.to_array();
    let mut regions = vec![Region::whole(extent)];
    let boxed = |origin: [u32; 3], size: [u32; 3]| {
        let size = [0, 1, 2].map(|a| size[a].min(e[a] - origin[a]).max(1));
        Some(Region { origin, extent: Extent::try_from(size).ok()? })
    };
    for corner in 0..8_u32 {
        let origin = [0, 1, 2].map(|a: usize| if corner >> a & 1 == 1 { e[a] - 1 } else { 0 });
        regions.push(Region::voxel(origin));
    }
    let mut state = 12345_u32;
    let mut below = |n: u32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) % n
    };
    for i in 0..48 {
        let origin = e.map(&mut below);
        let size = match i % 4 {
            0 => [1; 3],
            1 => [2; 3],
            2 => [5, 4, 3],
            _ => [0, 1, 2].map(|a| 1 + below(e[a])),
        };
        regions.extend(boxed(origin, size));
    }
    regions
}

/// A key that does not exist is refused.
fn keys(case: &Case<'_>, decoder: &dyn Decoder, decoded: &Decoded, report: &mut Report) {
    let layout = decoder.layout();
    let [x, y, z] = layout.extent.to_array();
    let voxel = |frame, p| BrickKey::full(FrameIndex(frame), Region::voxel(p));
    let mut keys = vec![
        voxel(layout.frames, [0; 3]),
        voxel(u32::MAX, [0; 3]),
        voxel(0, [x, 0, 0]),
        voxel(0, [0, y, 0]),
        voxel(0, [0, 0, z]),
        voxel(0, [u32::MAX; 3]),
    ];
    let resolutions = case.codec.resolutions(case.settings);
    for resolution in [resolutions, 200] {
        keys.push(BrickKey { level: Level { resolution, stages: 1 }, ..voxel(0, [0; 3]) });
    }
    let mut out = vec![0.0; layout.channels as usize];
    for key in keys {
        let accepted = decoder.decode_brick(key, decoded, &mut out).is_ok();
        report.check(Property::Keys, !accepted, || format!("{key:?} does not exist and was decoded"));
    }
    if let Ok(extent) = Extent::new(x + 1, 1, 1) {
        let key = BrickKey::full(FrameIndex::FIRST, Region { origin: [0; 3], extent });
        let mut out = vec![0.0; (x as usize + 1) * layout.channels as usize];
        let accepted = decoder.decode_brick(key, decoded, &mut out).is_ok();
        report.check(Property::Keys, !accepted, || format!("{key:?} sticks out and was decoded"));
    }
    if let Some(shader) = decoder.shader() {
        let accepted = shader.resources(FrameIndex(layout.frames)).is_ok();
        report.check(Property::Keys, !accepted, || "resources of a frame that does not exist".to_owned());
    }
    if let Some(shader) = decoder.frame_decode() {
        let wrong = Level { resolution: resolutions, stages: 1 };
        for (frame, level) in [(FrameIndex(layout.frames), Level::FULL), (FrameIndex::FIRST, wrong)] {
            let accepted = shader.passes(frame, level).is_ok();
            report.check(Property::Keys, !accepted, || format!("passes of {frame:?}, {level:?}"));
        }
    }
}
