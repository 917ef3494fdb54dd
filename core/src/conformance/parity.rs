//! Every voxel through the real shader, compared with the CPU decoder.

use std::sync::Arc;

use super::decoded::Decoded;
use super::{Case, Property, Report};
use crate::codec::{Agreement, DecodedBy, Decoder, FrameStore, Parity, VoxelDump};
use crate::volume::{FrameIndex, Level};

/// Dumps every frame through `fetch`, through `fetch_cell` if there is one, and through the codec's own passes if there
/// are any.
pub fn check(case: &Case<'_>, dump: &dyn VoxelDump, report: &mut Report) {
    let (info, by) = (case.codec.info(), case.codec.decoded_by(case.settings));
    let Ok(decoder) = case.codec.decoder(Arc::clone(&case.stream)) else { return };
    let decoder = FrameStore::open(decoder.into(), u64::MAX);
    let (voxel, frame) = (decoder.shader(), decoder.frame_decode());
    let lacks_voxel = voxel.is_none() && by.contains(&DecodedBy::Shader);
    report.check(Property::Parity, !lacks_voxel, || "site inline, but no shader".to_owned());
    let lacks_frame = voxel.is_none() && frame.is_none() && by.contains(&DecodedBy::Passes);
    report
        .check(Property::Parity, !lacks_frame, || "site deferred, but neither passes nor shader".to_owned());
    let mut paths: Vec<Path> = Vec::new();
    if let Some(shader) = voxel {
        paths.push(("fetch", Some(false), shader.agreement()));
        paths.extend(info.fetch_cell.then(|| ("fetch_cell", Some(true), shader.agreement())));
    }
    paths.extend(frame.map(|shader| ("passes", None, shader.agreement())));
    for level in levels(case.codec.stages(case.settings), case.codec.resolutions(case.settings)) {
        at_level(case, decoder.as_ref(), level, &paths, dump, report);
    }
}

/// The levels at which shaders are compared, since each is a shader of its own: the first stages and the last at full
/// resolution, and every coarser resolution at one of both ends in turn.
fn levels(stages: u8, resolutions: u8) -> Vec<Level> {
    let (first, all) = (1.min(stages - 1), Level::ALL_STAGES);
    let mut of_full = vec![first, stages / 2, stages - 1];
    of_full.retain(|stages| *stages > 0);
    of_full.sort_unstable();
    of_full.dedup();
    let full = of_full.into_iter().chain([all]).map(|stages| Level { resolution: 0, stages });
    let end = |resolution: u8| if resolution % 2 == 1 || first == 0 { all } else { first };
    full.chain((1..resolutions).map(|resolution| Level { resolution, stages: end(resolution) })).collect()
}

/// Name of a path; for a snippet, whether it uses `fetch_cell`; and the stated agreement.
type Path = (&'static str, Option<bool>, Agreement);

fn at_level(
    case: &Case<'_>,
    decoder: &dyn Decoder,
    level: Level,
    paths: &[Path],
    dump: &dyn VoxelDump,
    report: &mut Report,
) {
    let Ok(decoded) = Decoded::at(decoder, level) else { return };
    let (codec, block) = (case.codec.info().id, case.codec.block(case.settings));
    for frame in (0..decoder.layout().frames).map(FrameIndex) {
        let key = (frame, level);
        for &(path, use_cell, agreement) in paths {
            let dumped = match use_cell {
                Some(use_cell) => dump.dump_at(codec, decoder, key, use_cell),
                None => dump.dump_frame(codec, decoder, key),
            };
            let problem = match dumped {
                Ok(actual) => {
                    let expected = decoded.values(frame);
                    let parity = Parity::compare_at(decoder, agreement, key, expected, &actual);
                    report.shader_samples += parity.samples;
                    (!parity.holds()).then(|| parity.with_block(block).to_string())
                }
                Err(e) => Some(e),
            };
            report.check(Property::Parity, problem.is_none(), || {
                let problem = problem.unwrap_or_default();
                let Level { resolution, stages } = level;
                format!("frame {}, resolution {resolution}, stages {stages}, {path}: {problem}", frame.0)
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_both_ends_of_stages_and_every_resolution() {
        let of = |stages, resolutions| -> Vec<(u8, u8)> {
            levels(stages, resolutions).into_iter().map(|level| (level.resolution, level.stages)).collect()
        };
        assert_eq!(of(1, 1), [(0, 255)]);
        assert_eq!(of(1, 3), [(0, 255), (1, 255), (2, 255)]);
        assert_eq!(of(4, 1), [(0, 1), (0, 2), (0, 3), (0, 255)]);
        assert_eq!(of(13, 3), [(0, 1), (0, 6), (0, 12), (0, 255), (1, 255), (2, 1)]);
    }
}
