//! The site *ring*: layers that the device decodes while it draws, held to what the CPU decodes.

use super::checked::Expected;
use super::record::Record;
use super::target::{Picture, Target};

/// What a record at this site says where the mirror draws.
const OF_MIRROR: &str =
    "the CPU mirror has no ring of layers: drawn from the whole frame, as at site deferred";

/// Remarks on a picture that the mirror draws.
pub fn flag_mirror(target: &Target, record: &mut Record) {
    if matches!(target, Target::Cpu { .. }) {
        record.remark(OF_MIRROR);
    }
}

/// Reads every voxel back from the ring that a picture is drawn from, and enters how many are not what the CPU decodes. The
/// mirror has no ring, and nothing is entered.
///
/// # Errors
/// A sentence, when one differs beyond the codec's statement, or the device fails.
pub fn enter(record: &mut Record, picture: &Picture<'_>, expected: &Expected<'_>) -> Result<(), String> {
    expected.ring(picture)?.map_or(Ok(()), |checked| checked.enter(record))
}
