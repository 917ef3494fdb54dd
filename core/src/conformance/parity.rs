//! Every voxel through the real shader, compared with the CPU decoder.

use std::sync::Arc;

use super::decoded::Decoded;
use super::{Case, Property, Report};
use crate::codec::{Parity, Site, VoxelDump};
use crate::volume::FrameIndex;

/// Dumps every frame, through `fetch` and, where there is one, `fetch_cell`; and as the codec's own passes rebuild it.
pub fn check(case: &Case<'_>, dump: &dyn VoxelDump, report: &mut Report) {
    let info = case.codec.info();
    let Ok(decoder) = case.codec.decoder(Arc::clone(&case.stream)) else { return };
    let (voxel, frame) = (decoder.shader(), decoder.frame_decode());
    let lacks_voxel = voxel.is_none() && info.sites.contains(&Site::Inline);
    report.check(Property::Parity, !lacks_voxel, || "site inline, but no shader".to_owned());
    let lacks_frame = voxel.is_none() && frame.is_none() && info.sites.contains(&Site::Deferred);
    report
        .check(Property::Parity, !lacks_frame, || "site deferred, but neither passes nor shader".to_owned());
    // Name, whether by `fetch_cell` if by a snippet at all, and what is stated.
    let mut paths = Vec::new();
    if let Some(shader) = voxel {
        paths.push(("fetch", Some(false), shader.agreement()));
        paths.extend(info.fetch_cell.then(|| ("fetch_cell", Some(true), shader.agreement())));
    }
    paths.extend(frame.map(|shader| ("passes", None, shader.agreement())));
    let Ok(decoded) = Decoded::all(decoder.as_ref()) else { return };
    for frame in (0..decoder.layout().frames).map(FrameIndex) {
        for &(path, use_cell, agreement) in &paths {
            let dumped = match use_cell {
                Some(use_cell) => dump.dump(info.id, decoder.as_ref(), frame, use_cell),
                None => dump.dump_frame(info.id, decoder.as_ref(), frame),
            };
            let problem = match dumped {
                Ok(actual) => {
                    let expected = decoded.values(frame);
                    let parity = Parity::compare(decoder.as_ref(), agreement, frame, expected, &actual);
                    (!parity.holds()).then(|| parity.to_string())
                }
                Err(e) => Some(e),
            };
            report.check(Property::Parity, problem.is_none(), || {
                format!("frame {}, {path}: {}", frame.0, problem.unwrap_or_default())
            });
        }
    }
}
