//! Every voxel through the real shader, compared with the CPU decoder.

use std::sync::Arc;

use super::decoded::Decoded;
use super::{Case, Property, Report};
use crate::codec::{Agreement, Decoder, Site, VoxelDump};
use crate::volume::{BrickKey, FrameIndex, Region};

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
            let expected = decoded.values(frame);
            let problem = match dump.dump(info.id, decoder.as_ref(), frame, use_cell) {
                Ok(actual) => disagreement(decoder.as_ref(), shader.agreement(), frame, expected, &actual),
                Err(e) => Some(e),
            };
            report.check(Property::Parity, problem.is_none(), || {
                let path = if use_cell { "fetch_cell" } else { "fetch" };
                format!("frame {}, {path}: {}", frame.0, problem.unwrap_or_default())
            });
        }
    }
}

/// The first sample that breaks the agreement, and how many do.
fn disagreement(
    decoder: &dyn Decoder,
    agreement: Agreement,
    frame: FrameIndex,
    expected: &[f32],
    actual: &[f32],
) -> Option<String> {
    if expected.len() != actual.len() {
        return Some(format!("{} samples instead of {}", actual.len(), expected.len()));
    }
    let layout = decoder.layout();
    let (x, y) = (u64::from(layout.extent.x()), u64::from(layout.extent.y()));
    let allowed = |i: usize, cpu: f32, shader: f32| {
        let voxel = i as u64 / u64::from(layout.channels);
        let p = [(voxel % x) as u32, (voxel / x % y) as u32, (voxel / x / y) as u32];
        agreement.allows(cpu, shader, decoder.value_range(BrickKey::full(frame, Region::voxel(p))))
    };
    let pairs = expected.iter().zip(actual).enumerate();
    let bad: Vec<usize> = pairs.filter(|(i, (e, a))| !allowed(*i, **e, **a)).map(|(i, _)| i).collect();
    let first = *bad.first()?;
    Some(format!(
        "{} of {} samples disagree ({agreement:?}); the first, {first}, is {:e} ({:08x}) and should be {:e} ({:08x})",
        bad.len(),
        expected.len(),
        actual[first],
        actual[first].to_bits(),
        expected[first],
        expected[first].to_bits()
    ))
}
