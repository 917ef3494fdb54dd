//! The stability of an encoder: how its error depends on the seed, whether its bytes depend on threads, and what is lost
//! when its own output is encoded again and again.

use std::path::Path;

use cvr_core::codec::{Codec, Progress, SettingValue, Settings, encode_file};
use cvr_core::metrics::VolumeError;
use cvr_core::stability::{Trial, Word};
use cvr_core::volume::{BrickSource as _, DenseVolume, FiniteVolume, SampleType, Samples, VolumeLayout};
use rayon::ThreadPoolBuilder;
use serde::{Deserialize, Serialize};

use super::config::Config;
use super::plan::Contestant;
use crate::experiment::files::cell_file::Keyed;

/// Measurements of one encoder over one volume. PSNR is `None` if it is lossless.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EncoderMeasured {
    /// Codec id.
    pub codec: String,
    /// Codec and the settings that are not its defaults.
    pub label: String,
    /// Subject.
    pub subject: String,
    /// Step of its dial, 1 is the easiest.
    pub step: usize,
    /// Why the codec has no figures: it refuses the volume, or breaks its word.
    pub problem: Option<String>,
    /// PSNR of each seed in dB; empty where the codec has none.
    pub seeds: Vec<Option<f64>>,
    /// Numbers of threads.
    pub threads: Vec<usize>,
    /// Whether all files are equal byte by byte.
    pub threads_agree: bool,
    /// PSNR of each generation against the original, in dB; the first is a plain encoding.
    pub generations: Vec<Option<f64>>,
}

impl Keyed for EncoderMeasured {
    fn ended_well(&self) -> bool {
        true
    }
}

impl EncoderMeasured {
    /// Highest minus lowest PSNR over the seeds, in dB. `None` without two seeds. Infinite if only some seeds are
    /// lossless.
    #[must_use]
    pub fn spread_db(&self) -> Option<f64> {
        let lossless = self.seeds.iter().filter(|p| p.is_none()).count();
        match (self.seeds.len(), lossless) {
            (0 | 1, _) => None,
            (all, lossless) if all == lossless => Some(0.0),
            (_, 0) => {
                let values = || self.seeds.iter().flatten().copied();
                Some(values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min))
            }
            _ => Some(f64::INFINITY),
        }
    }

    /// PSNR of the first generation minus that of the last, in dB.
    #[must_use]
    pub fn generation_loss_db(&self) -> Option<f64> {
        match (self.generations.first()?, self.generations.last()?) {
            (None, None) => Some(0.0),
            (Some(first), Some(last)) => Some(first - last),
            (None, Some(_)) => Some(f64::INFINITY),
            (Some(_), None) => Some(f64::NEG_INFINITY),
        }
    }
}

/// Measures one encoder.
///
/// # Errors
/// A sentence, when threads cannot be started or scratch files cannot be written.
pub fn measure(
    contestant: &Contestant,
    (subject, step): (&str, usize),
    volume: &FiniteVolume,
    config: &Config,
) -> Result<EncoderMeasured, String> {
    let (codec, settings) = (contestant.codec.as_ref(), &contestant.settings);
    let mut measured = EncoderMeasured {
        codec: codec.info().id.to_owned(),
        label: contestant.label.clone(),
        subject: subject.to_owned(),
        step: step + 1,
        threads: config.threads.clone(),
        ..EncoderMeasured::default()
    };
    match generations(codec, settings, volume, config.generations) {
        Ok(generations) => measured.generations = generations,
        Err(problem) => {
            measured.problem = Some(problem);
            return Ok(measured);
        }
    }
    measured.threads_agree = threads_agree(codec, settings, volume, &config.threads)?;
    if codec.info().setting("seed").is_some() {
        for seed in 1..=config.seeds {
            let mut settings = settings.clone();
            settings.set("seed", SettingValue::Integer(seed.into()));
            let trial = Trial::of(codec, &settings, volume);
            if let Some(problem) = problem(&trial) {
                measured.problem = Some(format!("seed {seed}: {problem}"));
                break;
            }
            measured.seeds.push(psnr(volume, &trial.frames));
        }
    }
    Ok(measured)
}

fn problem(trial: &Trial) -> Option<String> {
    match &trial.word {
        Word::Kept => None,
        Word::Refused(why) => Some(format!("refused: {why}")),
        Word::Broken(why) => Some(why.clone()),
    }
}

fn psnr(original: &FiniteVolume, frames: &[Vec<f32>]) -> Option<f64> {
    Some(VolumeError::compare(original, frames).psnr_db).filter(|psnr| psnr.is_finite())
}

/// Encodes the volume, then the decoded values, and so on.
fn generations(
    codec: &dyn Codec,
    settings: &Settings,
    original: &FiniteVolume,
    count: u32,
) -> Result<Vec<Option<f64>>, String> {
    let mut generations = Vec::new();
    let mut volume = original.clone();
    for generation in 1..=count {
        let trial = Trial::of(codec, settings, &volume);
        if let Some(problem) = problem(&trial) {
            return Err(format!("generation {generation}: {problem}"));
        }
        generations.push(psnr(original, &trial.frames));
        volume = as_input(original.layout(), &trial.frames)?;
    }
    Ok(generations)
}

/// Decoded frames as a file of the original's number type would hold them.
#[allow(
    clippy::cast_possible_truncation,
    reason = "values are rounded into the range of the type, as `as` clamps"
)]
fn as_input(layout: &VolumeLayout, frames: &[Vec<f32>]) -> Result<FiniteVolume, String> {
    let values = || frames.iter().flatten().copied();
    let samples = match layout.sample {
        SampleType::U8 => Samples::U8(values().map(|v| v.round() as u8).collect()),
        SampleType::I8 => Samples::I8(values().map(|v| v.round() as i8).collect()),
        SampleType::U16 => Samples::U16(values().map(|v| v.round() as u16).collect()),
        SampleType::I16 => Samples::I16(values().map(|v| v.round() as i16).collect()),
        _ => Samples::F32(values().collect()),
    };
    DenseVolume::new(layout.clone(), samples).map(FiniteVolume::new)
}

/// Whether files are equal for every number of threads.
fn threads_agree(
    codec: &dyn Codec,
    settings: &Settings,
    volume: &FiniteVolume,
    threads: &[usize],
) -> Result<bool, String> {
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let mut first: Option<Vec<u8>> = None;
    for &threads in threads {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| e.to_string())?;
        let path = folder.path().join("volume.cvr");
        let bytes = pool.install(|| bytes(codec, settings, volume, &path))?;
        match &first {
            Some(first) if *first != bytes => return Ok(false),
            Some(_) => {}
            None => first = Some(bytes),
        }
    }
    Ok(true)
}

fn bytes(
    codec: &dyn Codec,
    settings: &Settings,
    volume: &FiniteVolume,
    path: &Path,
) -> Result<Vec<u8>, String> {
    encode_file(codec, settings, volume, volume.replaced(), path, &Progress::silent())
        .map_err(|e| e.to_string())?;
    std::fs::read(path).map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_is_that_of_all_seeds() {
        let of = |seeds: &[Option<f64>]| {
            EncoderMeasured { seeds: seeds.to_vec(), ..Default::default() }.spread_db()
        };
        assert_eq!(of(&[Some(30.0), Some(31.5), Some(29.0)]), Some(2.5));
        assert_eq!((of(&[None, None]), of(&[None, Some(30.0)])), (Some(0.0), Some(f64::INFINITY)));
        assert_eq!((of(&[]), of(&[Some(1.0)])), (None, None));
    }

    #[test]
    fn a_generation_loss_is_first_minus_last() {
        let of = |generations: &[Option<f64>]| {
            EncoderMeasured { generations: generations.to_vec(), ..Default::default() }.generation_loss_db()
        };
        assert_eq!(of(&[Some(40.0), Some(39.0), Some(38.5)]), Some(1.5));
        assert_eq!((of(&[None, None]), of(&[None, Some(9.0)])), (Some(0.0), Some(f64::INFINITY)));
        assert_eq!(of(&[]), None);
    }

    #[test]
    fn what_is_encoded_again_is_of_the_type_of_the_original() {
        let subject = cvr_core::stability::Subject::named("noise").unwrap();
        let volume = subject.volume(2, 12);
        let layout = volume.layout();
        let frames = vec![vec![254.6; layout.samples() as usize]];
        assert_eq!(as_input(layout, &frames).unwrap().range().max, 255.0);
        let beyond = vec![vec![-3.0; layout.samples() as usize]];
        assert_eq!(as_input(layout, &beyond).unwrap().range().min, 0.0);
    }
}
