//! A volume through a codec: encoded, decoded again, and measured. What cells of one codec and setting share.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use cvr_core::codec::{Codec, Decoder, Parity, Progress, Settings, VoxelDump, decode_stages, encode_file};
use cvr_core::container::EncodedVolume;
use cvr_core::metrics::{VolumeComparison, VolumeError};
use cvr_core::render::DecodedFrame;
use cvr_core::volume::{BrickKey, FiniteVolume, FrameIndex, Level, NoReferences, Region, VolumeLayout};

use super::skipping::LazyRanges;
use super::target::Target;

/// A volume as one codec with one set of settings gives it back, at one level.
#[derive(Debug)]
pub struct Encoded {
    /// The opened stream.
    pub decoder: Arc<dyn Decoder>,
    /// The level at which it was decoded.
    pub level: Level,
    /// The first frame, decoded.
    pub frame: Arc<DecodedFrame>,
    /// Bytes of the file.
    pub file_bytes: u64,
    /// Wall seconds to encode, file written and synced.
    pub encode_seconds: f64,
    /// Wall seconds to decode all frames on the CPU.
    pub decode_seconds: f64,
    /// Error over all frames.
    pub error: VolumeError,
    /// The encoder's promise, which is for all stages; `None` where not all were decoded.
    pub error_bound: Option<f64>,
    /// Remarks of the encoder.
    pub notes: Vec<String>,
    /// The macrocells of the first frame.
    pub macrocells: LazyRanges,
}

/// Encodes into a file in `scratch`, reads it back and decodes every frame.
///
/// # Errors
/// A sentence, when encoding, reading back or decoding fails.
pub fn encode(
    codec: &dyn Codec,
    settings: &Settings,
    volume: &FiniteVolume,
    scratch: &Path,
    run: &Progress<'_>,
) -> Result<Encoded, String> {
    let folder = tempfile::tempdir_in(scratch).map_err(|e| format!("{}: {e}", scratch.display()))?;
    let path = folder.path().join("volume.cvr");
    let start = Instant::now();
    encode_file(codec, settings, volume, volume.replaced(), &path, run).map_err(|e| e.to_string())?;
    let encode_seconds = start.elapsed().as_secs_f64();
    let stream = Arc::new(EncodedVolume::open(&path).map_err(|e| e.to_string())?);
    let decoder: Arc<dyn Decoder> = codec.decoder(stream.clone()).map_err(|e| e.to_string())?.into();
    let report = &stream.spec().report;
    let level = Level::FULL;
    let Decoded { frame, decode_seconds, error } = decode(decoder.as_ref(), level, volume)?;
    Ok(Encoded {
        decoder,
        level,
        frame,
        file_bytes: stream.file_bytes(),
        encode_seconds,
        decode_seconds,
        error,
        error_bound: report.error_bound,
        notes: report.notes.clone(),
        macrocells: LazyRanges::default(),
    })
}

/// What decoding yields.
struct Decoded {
    frame: Arc<DecodedFrame>,
    decode_seconds: f64,
    error: VolumeError,
}

/// Decodes every frame at a level, and compares it with the volume.
fn decode(decoder: &dyn Decoder, level: Level, volume: &FiniteVolume) -> Result<Decoded, String> {
    let mut comparison = VolumeComparison::new(volume);
    let mut first = None;
    let mut decode_seconds = 0.0;
    for frame in (0..decoder.layout().frames).map(FrameIndex) {
        let start = Instant::now();
        let values = decode_stages(decoder, frame, level.stages, &NoReferences).map_err(|e| e.to_string())?;
        decode_seconds += start.elapsed().as_secs_f64();
        comparison.add_frame(&values);
        if frame == FrameIndex::FIRST {
            first = DecodedFrame::new(decoder.layout().clone(), values);
        }
    }
    let frame = Arc::new(first.ok_or("the stream holds no whole frame")?);
    Ok(Decoded { frame, decode_seconds, error: comparison.finish() })
}

impl Encoded {
    /// The same stream decoded at another level.
    ///
    /// # Errors
    /// A sentence, when decoding fails.
    pub fn at(&self, level: Level, volume: &FiniteVolume) -> Result<Self, String> {
        let Decoded { frame, decode_seconds, error } = decode(self.decoder.as_ref(), level, volume)?;
        let error_bound = self.error_bound.filter(|_| level == Level::FULL);
        let (decoder, notes, macrocells) = (self.decoder.clone(), self.notes.clone(), LazyRanges::default());
        Ok(Self { decoder, level, frame, decode_seconds, error, error_bound, notes, macrocells, ..*self })
    }

    /// Holds what was decoded to the encoder's promises.
    ///
    /// # Errors
    /// A sentence with the figures, when the bound or the promised value range is broken.
    pub fn check_promises(&self) -> Result<(), String> {
        if let Some(bound) = self.error_bound
            && self.error.max_abs_error > bound
        {
            return Err(format!(
                "broke its error bound: a voxel is off by {}, promised {bound}",
                self.error.max_abs_error
            ));
        }
        let layout: &VolumeLayout = self.decoder.layout();
        let (frame, level) = (FrameIndex::FIRST, self.level);
        let key = BrickKey { frame, level, region: Region::whole(layout.extent) };
        if let Some(range) = self.decoder.value_range(key)
            && let Some(value) = self.frame.values().iter().find(|v| !range.contains(**v))
        {
            return Err(format!(
                "broke its value range: a voxel decodes to {value}, promised {} to {}",
                range.min, range.max
            ));
        }
        Ok(())
    }

    /// Samples of the first frame on which `target`'s real generated shader and the CPU decoder disagree beyond
    /// the codec's statement, through `fetch` and, where `use_cell` says so, through `fetch_cell` too; `None` where
    /// there is no device or no shader.
    ///
    /// # Errors
    /// When the device cannot run the shader.
    pub fn parity(&self, codec: &str, target: &Target, use_cell: bool) -> Result<Option<u64>, String> {
        let (Target::Device(device), Some(shader)) = (target, self.decoder.shader()) else {
            return Ok(None);
        };
        let (decoder, agreement) = (self.decoder.as_ref(), shader.agreement());
        let key = (FrameIndex::FIRST, self.level);
        let paths: &[bool] = if use_cell { &[false, true] } else { &[false] };
        let mut mismatches = 0;
        for &use_cell in paths {
            let dump = device.dump_at(codec, decoder, key, use_cell)?;
            mismatches += Parity::compare_at(decoder, agreement, key, self.frame.values(), &dump).mismatches;
        }
        Ok(Some(mismatches))
    }
}
