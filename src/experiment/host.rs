//! The site *host*: a frame in a texture that the device only reads. Where it holds the codec's blocks, the texture unit
//! decodes them, and is held to what the CPU decodes.

use cvr_core::codec::{Decoder, Parity};
use cvr_core::volume::{FrameIndex, Level};

use super::checked::{Checked, Expected};
use super::record::Record;
use super::target::{DrawError, HostVolume, Target};

/// A frame that was uploaded once for all cells of a codec and its settings and, where it was as blocks, compared.
#[derive(Clone, Debug)]
pub struct SharedUpload {
    volume: HostVolume,
    checked: Option<Checked>,
}

impl SharedUpload {
    /// Uploads a frame at a level as the CPU has decoded it, or the codec's blocks.
    ///
    /// # Errors
    /// As [`Target::upload`], and when the texture cannot be read.
    pub fn new(target: &Target, expected: &Expected<'_>) -> Result<Self, String> {
        let volume = target.upload(expected.decoder, expected.key, expected.frame.clone());
        Self::of(target, expected, volume.map_err(|e| e.to_string())?, true)
    }

    /// What was uploaded, compared where `check` says so.
    ///
    /// # Errors
    /// When the texture cannot be read.
    pub fn of(
        target: &Target,
        expected: &Expected<'_>,
        volume: HostVolume,
        check: bool,
    ) -> Result<Self, String> {
        let checked = if check { expected.host(target, &volume)? } else { None };
        Ok(Self { volume, checked })
    }

    /// The volume, for a cell in whose record mismatches and a fallback are entered.
    ///
    /// # Errors
    /// A sentence, when the texture unit decodes other values than the CPU.
    pub fn enter(&self, record: &mut Record) -> Result<HostVolume, String> {
        if let Some(fallback) = self.volume.fallback {
            record.remark(&fallback.to_string());
        }
        if let Some(checked) = &self.checked {
            checked.enter(record)?;
            if checked.largest > 0.0 {
                let off = checked.largest;
                record.remark(&format!(
                    "the texture unit decodes up to {off:.4} beside the definition of its format"
                ));
            }
        }
        Ok(self.volume.clone())
    }
}

impl HostVolume {
    /// Every voxel as a shader loads it from blocks against what the CPU decoded, at its place in the stream `key`,
    /// within the tolerance of the format; `None` where the texture holds what was decoded.
    ///
    /// # Errors
    /// When the texture cannot be read.
    pub fn parity(
        &self,
        target: &Target,
        decoder: &dyn Decoder,
        key: (FrameIndex, Level),
    ) -> Result<Option<Parity>, DrawError> {
        let (Target::Device(device), Some(texture)) = (target, &self.texture) else { return Ok(None) };
        let Some(Ok(blocks)) = target.blocks(decoder, key) else { return Ok(None) };
        let values = texture.read(device)?;
        Ok(Some(Parity::compare_at(decoder, blocks.agreement(), key, self.frame.values(), &values)))
    }
}
