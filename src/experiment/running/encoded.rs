//! A volume encoded, decoded and measured. Cells of one codec and setting share it.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use cvr_core::codec::{Block, Codec, Decoder, FrameStore, Progress, Settings, encode_file};
use cvr_core::container::EncodedVolume;
use cvr_core::file::temporary_folder;
use cvr_core::memory;
use cvr_core::metrics::{ErrorHistogram, FrameError, VolumeComparison, VolumeError};
use cvr_core::render::{DecodedFrame, upsampled};
use cvr_core::volume::{BrickKey, BrickSource as _, FiniteVolume, FrameIndex, Level, Region, VolumeLayout};

use super::latest::Latest;
use crate::experiment::measured::skipping::LazyRanges;
use crate::site::coded::CodedFrame;
use crate::site::expected::Expected;

/// A volume decoded from one codec with one set of settings, at one level.
#[derive(Debug)]
pub struct Encoded {
    /// The opened stream. It keeps decoded frames if frames are predicted.
    pub decoder: Arc<dyn Decoder>,
    /// The level at which it was decoded.
    pub level: Level,
    /// Bytes of the file.
    pub file_bytes: u64,
    /// Bytes of its tensors.
    pub payload_bytes: u64,
    /// Wall seconds to encode, file written and synced.
    pub encode_seconds: f64,
    /// Wall seconds to decode all frames on the CPU.
    pub decode_seconds: f64,
    /// Error over all frames. A lower resolution is first resampled to the volume's size.
    pub error: VolumeError,
    /// Error of each frame.
    pub frame_errors: Vec<FrameError>,
    /// Number of samples of all frames by error.
    pub histogram: Arc<ErrorHistogram>,
    /// The codec's block, where it has one.
    block: Option<Block>,
    /// The encoder's bound, which holds for all stages. `None` if not all were decoded.
    pub error_bound: Option<f64>,
    /// Remarks of the encoder.
    pub notes: Vec<String>,
    /// The macrocells of the drawn frame.
    pub macrocells: LazyRanges,
    /// The frame that is drawn, decoded.
    frame: Latest<Arc<DecodedFrame>>,
    /// The first value of a frame outside the range that the decoder promises.
    outside: Option<String>,
}

/// Encodes into a file in `scratch`, reads it back and decodes every frame. For predicted frames, `decoded_frames_mb`
/// megabytes of decoded frames are kept.
///
/// # Errors
/// A sentence, when encoding, reading back or decoding fails.
pub fn encode(
    codec: &dyn Codec,
    settings: &Settings,
    volume: &FiniteVolume,
    (scratch, decoded_frames_mb): (&Path, u32),
    run: &Progress<'_>,
) -> Result<Encoded, String> {
    let folder = temporary_folder(scratch).map_err(|e| format!("{}: {e}", scratch.display()))?;
    let path = folder.path().join("volume.cvr");
    // A decoded frame is compared with the original's at the end. Its memory is checked before the encoder runs.
    let layout = volume.layout();
    let frame_bytes = single_bytes(layout);
    memory::check(2 * frame_bytes, || format!("a frame of {} voxels, decoded and original,", layout.extent))
        .map_err(|e| e.to_string())?;
    let start = Instant::now();
    encode_file(codec, settings, volume, volume.replaced(), &path, run).map_err(|e| e.to_string())?;
    let encode_seconds = start.elapsed().as_secs_f64();
    let stream = Arc::new(EncodedVolume::open(&path).map_err(|e| e.to_string())?);
    let decoder = codec.decoder(stream.clone()).map_err(|e| e.to_string())?;
    let decoder = FrameStore::open_mb(decoder.into(), decoded_frames_mb);
    let report = &stream.spec().report;
    let level = Level::FULL;
    let block = codec.block(settings);
    let Decoded { frame, decode_seconds, error, frame_errors, histogram, outside } =
        decode(decoder.as_ref(), level, volume, block)?;
    Ok(Encoded {
        decoder,
        level,
        file_bytes: stream.file_bytes(),
        payload_bytes: stream.payload_bytes(),
        encode_seconds,
        decode_seconds,
        error,
        frame_errors,
        histogram,
        block,
        error_bound: report.error_bound,
        notes: report.notes.clone(),
        macrocells: LazyRanges::default(),
        frame: Latest::new(FrameIndex::FIRST, frame),
        outside,
    })
}

/// Bytes of a frame in single precision.
const fn single_bytes(layout: &VolumeLayout) -> u64 {
    layout.samples_per_frame() * size_of::<f32>() as u64
}

/// What decoding yields.
struct Decoded {
    /// The first frame.
    frame: Arc<DecodedFrame>,
    decode_seconds: f64,
    error: VolumeError,
    frame_errors: Vec<FrameError>,
    histogram: Arc<ErrorHistogram>,
    outside: Option<String>,
}

/// Decodes every frame at a level, and compares it with the volume.
fn decode(
    decoder: &dyn Decoder,
    level: Level,
    volume: &FiniteVolume,
    block: Option<Block>,
) -> Result<Decoded, String> {
    let mut comparison = VolumeComparison::new(volume, block);
    let mut frame_errors = Vec::new();
    let (mut first, mut outside) = (None, None);
    let mut decode_seconds = 0.0;
    for frame in (0..decoder.layout().frames).map(FrameIndex) {
        let start = Instant::now();
        let decoded = DecodedFrame::at(decoder, frame, level).map_err(|e| e.to_string())?;
        decode_seconds += start.elapsed().as_secs_f64();
        let layout = decoder.layout();
        memory::check(single_bytes(layout), || format!("the original frame of {} voxels", layout.extent))
            .map_err(|e| e.to_string())?;
        frame_errors.push(comparison.add_frame(&of_full_size(decoder, &decoded, level)?));
        outside = outside.or_else(|| outside_promise(decoder, (frame, level), decoded.values()));
        if frame == FrameIndex::FIRST {
            first = Some(decoded);
        }
    }
    let frame = first.ok_or("the stream holds no frame")?;
    let (error, histogram) = comparison.finish_with_histogram();
    Ok(Decoded { frame, decode_seconds, error, frame_errors, histogram: Arc::new(histogram), outside })
}

/// The values of a frame at a level, resampled to the size of its volume.
fn of_full_size<'a>(
    decoder: &dyn Decoder,
    decoded: &'a DecodedFrame,
    level: Level,
) -> Result<Cow<'a, [f32]>, String> {
    if level.resolution == 0 {
        return Ok(Cow::Borrowed(decoded.values()));
    }
    let place = (level.resolution, decoder.coarse_shift(level.resolution));
    upsampled(decoded, decoder.layout().extent, place).map(Cow::Owned).map_err(|e| e.to_string())
}

/// A message about a value of a frame outside the range that the decoder promises.
fn outside_promise(
    decoder: &dyn Decoder,
    (frame, level): (FrameIndex, Level),
    values: &[f32],
) -> Option<String> {
    let region = Region::whole(decoder.layout().extent.at_resolution(level.resolution));
    let range = decoder.value_range(BrickKey { frame, level, region })?;
    let value = values.iter().find(|v| !range.contains(**v))?;
    Some(format!("a voxel decodes to {value}, promised {} to {}", range.min, range.max))
}

impl Encoded {
    /// A frame, decoded; the one that was asked for last is kept.
    ///
    /// # Errors
    /// A sentence, when it cannot be decoded.
    pub fn frame(&self, frame: FrameIndex) -> Result<Arc<DecodedFrame>, String> {
        let decode = || DecodedFrame::at(self.decoder.as_ref(), frame, self.level);
        self.frame.get(frame, || decode().map_err(|e| e.to_string()))
    }

    /// A decoded frame, resampled to the volume's size if its resolution is lower. Voxels of the volume are compared
    /// with it.
    ///
    /// # Errors
    /// A sentence, when it cannot be decoded.
    pub fn frame_of_full_size(&self, frame: FrameIndex) -> Result<Arc<DecodedFrame>, String> {
        let (decoded, layout) = (self.frame(frame)?, self.decoder.layout());
        match of_full_size(self.decoder.as_ref(), &decoded, self.level)? {
            Cow::Borrowed(_) => Ok(decoded),
            Cow::Owned(values) => {
                let full = DecodedFrame::new(layout.clone(), values);
                full.map(Arc::new).ok_or_else(|| "no whole frame".to_owned())
            }
        }
    }

    /// The same stream decoded at another level.
    ///
    /// # Errors
    /// A sentence, when decoding fails.
    pub fn at(&self, level: Level, volume: &FiniteVolume) -> Result<Self, String> {
        let Decoded { frame, decode_seconds, error, frame_errors, histogram, outside } =
            decode(self.decoder.as_ref(), level, volume, self.block)?;
        Ok(Self {
            decoder: self.decoder.clone(),
            level,
            decode_seconds,
            error,
            frame_errors,
            histogram,
            error_bound: self.error_bound.filter(|_| level == Level::FULL),
            notes: self.notes.clone(),
            macrocells: LazyRanges::default(),
            frame: Latest::new(FrameIndex::FIRST, frame),
            outside,
            ..*self
        })
    }

    /// Checks the decoded values against the encoder's promises.
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
        match &self.outside {
            Some(problem) => Err(format!("broke its value range: {problem}")),
            None => Ok(()),
        }
    }

    /// A frame of this stream before decoding. `codec` is the codec's id.
    #[must_use]
    pub fn coded<'a>(&'a self, codec: &'a str, frame: FrameIndex) -> CodedFrame<'a> {
        CodedFrame { codec, decoder: self.decoder.as_ref(), key: (frame, self.level) }
    }

    /// The CPU's frame for comparisons. `codec` is the codec's id.
    ///
    /// # Errors
    /// A sentence, when it cannot be decoded.
    pub fn expected<'a>(&'a self, codec: &'a str, frame: FrameIndex) -> Result<Expected<'a>, String> {
        let CodedFrame { decoder, key, .. } = self.coded(codec, frame);
        Ok(Expected { codec, decoder, key, frame: self.frame(frame)?, block: self.block })
    }
}
