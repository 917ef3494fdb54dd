//! A volume through a codec and back, and whether the codec has kept its word.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use super::trivial::{Trivial, raw_bytes};
use super::verdict::{Observed, Word};
use crate::codec::{
    Codec, ConfigError, Decoded, Decoder, EncodeError, FrameStore, Settings, encode_temporary,
};
use crate::container::EncodedVolume;
use crate::metrics::VolumeError;
use crate::volume::{BrickKey, BrickSource as _, FiniteVolume, FrameIndex, Level, Region};

/// Results of one volume.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Whether the codec kept its word.
    pub word: Word,
    /// Bytes of the file; `None` where there is none.
    pub file_bytes: Option<u64>,
    /// The bound that the encoder stated.
    pub error_bound: Option<f64>,
    /// Notes of the encoder.
    pub notes: Vec<String>,
    /// The decoded frames; none where a sample is not a number, or nothing was decoded.
    pub frames: Vec<Vec<f32>>,
    /// Their error; `None` without them.
    pub error: Option<VolumeError>,
}

/// What an attempt knows so far, and why it has ended.
type Ended = (Option<u64>, Word);

impl Trial {
    /// Encodes with these settings, which may be partial, and decodes on the CPU. A panic breaks the codec's word.
    #[must_use]
    pub fn of(codec: &dyn Codec, settings: &Settings, volume: &FiniteVolume) -> Self {
        let attempt = || Self::attempt(codec, settings, volume);
        let ended = match catch_unwind(AssertUnwindSafe(attempt)) {
            Ok(Ok(trial)) => return trial,
            Ok(Err(ended)) => ended,
            Err(panic) => {
                let text = panic.downcast_ref::<String>().map(String::as_str);
                let text =
                    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("for no reason given");
                (None, Word::Broken(format!("it panics: {text}")))
            }
        };
        Self::ended(ended)
    }

    fn attempt(codec: &dyn Codec, settings: &Settings, volume: &FiniteVolume) -> Result<Self, Ended> {
        let stream = encode_temporary(codec, settings, volume).map_err(|error| match error {
            EncodeError::Unsupported(reason) => (None, Word::Refused(reason)),
            EncodeError::Config(ConfigError::Contradiction(reason)) => (None, Word::Refused(reason)),
            other => (None, Word::Broken(format!("encoding fails: {other}"))),
        })?;
        Self::decoded(codec, Arc::new(stream), volume)
    }

    /// The same from a stream that is there.
    #[must_use]
    pub fn of_stream(codec: &dyn Codec, stream: Arc<EncodedVolume>, volume: &FiniteVolume) -> Self {
        Self::decoded(codec, stream, volume).unwrap_or_else(Self::ended)
    }

    fn ended((file_bytes, word): Ended) -> Self {
        Self { word, file_bytes, error_bound: None, notes: Vec::new(), frames: Vec::new(), error: None }
    }

    fn decoded(codec: &dyn Codec, stream: Arc<EncodedVolume>, volume: &FiniteVolume) -> Result<Self, Ended> {
        let bytes = Some(stream.file_bytes());
        let report = stream.spec().report.clone();
        let broken = |problem: String| (bytes, Word::Broken(problem));
        let decoder = codec.decoder(stream).map_err(|e| broken(format!("decoding fails: {e}")))?;
        let decoder = FrameStore::open_mb(decoder.into(), FrameStore::DEFAULT_MB);
        if decoder.layout() != volume.layout() {
            return Err(broken("the decoded volume has another layout".to_owned()));
        }
        let frames = Decoded::at(decoder.as_ref(), Level::FULL).map_err(broken)?.into_frames();
        if let Some(value) = frames.iter().flatten().find(|v| !v.is_finite()) {
            return Err(broken(format!("a voxel decodes to {value}")));
        }
        let problem = report
            .error_bound
            .and_then(|bound| beyond(volume, &frames, bound))
            .or_else(|| outside(decoder.as_ref(), &frames));
        let error = Some(VolumeError::compare(volume, &frames));
        Ok(Self {
            word: problem.map_or(Word::Kept, Word::Broken),
            file_bytes: bytes,
            error_bound: report.error_bound,
            notes: report.notes,
            frames,
            error,
        })
    }

    /// The trivial codec at the same rate. `None` if there is no file.
    #[must_use]
    pub fn trivial(&self, volume: &FiniteVolume) -> Option<Trivial> {
        self.file_bytes.map(|bytes| Trivial::of_rate(volume, bytes))
    }

    /// What verdicts are made of. `exempt` for the uncompressed codec.
    #[must_use]
    pub fn observed(&self, volume: &FiniteVolume, trivial: Option<&Trivial>, exempt: bool) -> Observed {
        let rms = |error: VolumeError| error.mse.sqrt();
        let trivial_voxels = trivial.map(|t| rms(VolumeError::compare(volume, &t.frames)));
        let range = volume.range();
        Observed {
            word: self.word.clone(),
            larger_than_raw: self.file_bytes.is_some_and(|bytes| bytes >= raw_bytes(volume.layout())),
            voxels: self.error.map_or(f64::INFINITY, rms),
            trivial_voxels: trivial_voxels.unwrap_or(f64::INFINITY),
            voxel_floor: if range.magnitude() > 0.0 { range.ulp() } else { 0.0 },
            exempt,
        }
    }
}

/// A message about a sample outside the stated error bound. Integers are rounded first, as the bound requires.
fn beyond(volume: &FiniteVolume, frames: &[Vec<f32>], bound: f64) -> Option<String> {
    let integer = volume.layout().sample.is_integer();
    let worst = frames.iter().zip(0..).map(|(decoded, frame)| {
        let original = volume.dense().frame_values(FrameIndex(frame));
        let off = |(d, o): (&f32, &f32)| {
            let d = if integer { d.round() } else { *d };
            (f64::from(d) - f64::from(*o)).abs()
        };
        decoded.iter().zip(&original).map(off).fold(0.0, f64::max)
    });
    let worst = worst.fold(0.0, f64::max);
    (worst > bound).then(|| format!("a voxel is off by {worst}, promised {bound}"))
}

/// A message about a sample outside a stated range.
fn outside(decoder: &dyn Decoder, frames: &[Vec<f32>]) -> Option<String> {
    let region = Region::whole(decoder.layout().extent);
    frames.iter().zip(0..).find_map(|(values, frame)| {
        let range = decoder.value_range(BrickKey::full(FrameIndex(frame), region))?;
        let value = values.iter().find(|v| !range.contains(**v))?;
        Some(format!("a voxel decodes to {value}, promised {} to {}", range.min, range.max))
    })
}
