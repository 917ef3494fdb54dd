//! Every voxel through the real shader, compared with the CPU decoder.

use std::sync::Arc;

use super::decoded::Decoded;
use super::{Case, Property, Report};
use crate::codec::{Parity, Site, VoxelDump};
use crate::volume::FrameIndex;

/// Dumps every frame, through `fetch` and, where there is one, `fetch_cell`.
pub fn check(case: &Case<'_>, dump: &dyn VoxelDump, report: &mut Report) {
    let info = case.codec.info();
    let Ok(decoder) = case.codec.decoder(Arc::clone(&case.stream)) else { return };
    let Some(shader) = decoder.shader() else {
        let promised = info.sites.contains(&Site::Inline);
        report.check(Property::Parity, !promised, || "site inline, but no shader".to_owned());
        return;
    };
    let Ok(decoded) = Decoded::all(decoder.as_ref()) else { return };
    let paths: &[bool] = if info.fetch_cell { &[false, true] } else { &[false] };
    for frame in (0..decoder.layout().frames).map(FrameIndex) {
        for &use_cell in paths {
            let problem = match dump.dump(info.id, decoder.as_ref(), frame, use_cell) {
                Ok(actual) => {
                    let (agreement, expected) = (shader.agreement(), decoded.values(frame));
                    let parity = Parity::compare(decoder.as_ref(), agreement, frame, expected, &actual);
                    (!parity.holds()).then(|| parity.to_string())
                }
                Err(e) => Some(e),
            };
            report.check(Property::Parity, problem.is_none(), || {
                let path = if use_cell { "fetch_cell" } else { "fetch" };
                format!("frame {}, {path}: {}", frame.0, problem.unwrap_or_default())
            });
        }
    }
}
