//! The site *ring*: layers that the device decodes while it draws, held to what the CPU decodes.

use cvr_core::codec::Parity;
use cvr_core::volume::FrameIndex;

use super::encoded::Encoded;
use super::record::Record;
use super::target::Picture;

/// What a record at this site says where the mirror draws.
const OF_MIRROR: &str =
    "the CPU mirror has no ring of layers: drawn from the whole frame, as at site deferred";

/// Reads every voxel back from the ring that a picture is drawn from, and enters how many are not what the CPU decodes.
///
/// # Errors
/// A sentence, when one differs beyond the codec's statement, or the device fails.
pub fn enter(
    record: &mut Record,
    picture: &Picture<'_>,
    encoded: &Encoded,
    frame: FrameIndex,
) -> Result<(), String> {
    let Some(values) = picture.read_layers().map_err(|e| e.to_string())? else {
        record.remark(OF_MIRROR);
        return Ok(());
    };
    let decoder = encoded.decoder.as_ref();
    let shader = decoder.shader().ok_or("a ring of layers without a shader that decodes them")?;
    let (cpu, key) = (encoded.frame(frame)?, (frame, encoded.level));
    let parity = Parity::compare_at(decoder, shader.agreement(), key, cpu.values(), &values);
    record.parity_mismatches = Some(parity.mismatches);
    if parity.holds() {
        return Ok(());
    }
    Err(format!("what came through the ring is not what the CPU decodes: {parity}"))
}
