//! The settings: their schema, and what an encoder makes of them.

use cvr_codebook::settings::{self as training, TrainingSettings, natural};
use cvr_core::codec::{ConfigError, Setting, SettingKind, SettingValue, Settings};

use crate::stream::{Entries, MOST_STAGES, Payload};

/// The schema.
pub const SETTINGS: &[Setting] = &[
    Setting {
        name: "payload",
        doc: "fixed = one code of each stage for every block; variable = a mean, as many codes as pay, and what is left of \
              busy blocks coded directly",
        kind: SettingKind::Choice(&["fixed", "variable"]),
        default: "fixed",
    },
    Setting {
        name: "stages",
        doc: "codebooks, each trained on what those before it leave; each costs a code per block and a fetch per voxel; 0 = \
              4 under fixed, and under variable as many as pay, at most 16",
        kind: SettingKind::Integer { min: 0, max: MOST_STAGES as i64 },
        default: "0",
    },
    Setting {
        name: "codewords",
        doc: "size of each codebook, at most under variable; a code takes ceil(log2(codewords)) bits; 0 = chosen by the \
              encoder: under fixed from the number of blocks, under variable by trials",
        kind: SettingKind::Integer { min: 0, max: 65536 },
        default: "0",
    },
    Setting {
        name: "rate",
        doc: "under variable: bits per sample of the whole file, at most; 0 = no such target, and 0.5 where there is no other",
        kind: SettingKind::Float { min: 0.0, max: 16.0 },
        default: "0.0",
    },
    Setting {
        name: "psnr",
        doc: "under variable: decibels, at about the least rate that reaches them; 0 = no such target",
        kind: SettingKind::Float { min: 0.0, max: 100.0 },
        default: "0.0",
    },
    Setting {
        name: "max_error",
        doc: "under variable: no sample is further from its value than this, in data units, integers rounded; 0 = no such \
              bound",
        kind: SettingKind::Float { min: 0.0, max: 1e30 },
        default: "0.0",
    },
    Setting {
        name: "entries",
        doc: "bits of one value of a codeword; auto = 8, or 11-11-10 for the three colours of a voxel",
        kind: SettingKind::Choice(&["auto", "8", "16"]),
        default: "auto",
    },
    Setting {
        name: "beam",
        doc: "sums of codewords that the encoder keeps from stage to stage; 1 = the nearest codeword of each stage",
        kind: SettingKind::OneOf(&[1, 2, 4, 8, 16]),
        default: "4",
    },
    Setting {
        name: "refinement",
        doc: "rounds in which all codebooks are trained anew, each on what all others leave; 0 = none, as in the paper",
        kind: SettingKind::Integer { min: 0, max: 100 },
        default: "4",
    },
    Setting {
        name: "tables",
        doc: "shared = one set of codebooks for all frames; per-frame = one for each",
        kind: training::TABLES,
        default: "shared",
    },
    training::TRAINING_BLOCKS,
    Setting { default: "stratified", ..training::DRAW },
    Setting { default: "10", ..training::ITERATIONS },
    Setting {
        name: "init",
        doc: "first codebook of a stage; auto = pnn under fixed, pca, which takes less time, under variable",
        kind: SettingKind::Choice(INITIAL),
        default: "auto",
    },
    training::SEED,
];

/// Names of first codebooks.
const INITIAL: &[&str] = &["auto", "pca", "pnn", "scalar", "random"];

/// What makes another method of it. The others are dials of rate and quality, or of the time that encoding takes.
pub const METHODS: &[&str] = &["payload", "entries", "refinement", "tables", "draw", "init"];

/// What the payload `variable` aims at.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Target {
    /// Bits per sample of the whole file, at most.
    Rate(f64),
    /// Decibels.
    Psnr(f64),
    /// Largest error of a sample, in data units.
    MaxError(f64),
}

/// Bits per sample where there is no target.
const RATE: f64 = 0.5;
/// Stages of the payload `fixed` where none are given.
const STAGES: u32 = 4;

/// The settings of one encoder.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Options {
    pub payload: Payload,
    /// Under the payload `variable`.
    pub target: Target,
    /// 1 to [`MOST_STAGES`]; at most so many under the payload `variable`.
    pub stages: u32,
    /// Codewords of each stage; `None` where the encoder chooses.
    pub codewords: Option<u32>,
    /// How a codeword is stored; `None` where the encoder chooses.
    pub entries: Option<Entries>,
    /// Sums of codewords kept from stage to stage.
    pub beam: usize,
    /// Rounds of joint training.
    pub refinement: u32,
    pub training: TrainingSettings,
}

/// The payload that is asked for.
fn payload(settings: &Settings) -> Result<Payload, ConfigError> {
    Ok(if settings.text("payload")? == "fixed" { Payload::Fixed } else { Payload::Variable })
}

/// Stages that there are at most.
///
/// # Errors
/// When a setting is missing.
pub fn stages(settings: &Settings) -> Result<u32, ConfigError> {
    Ok(match (natural(settings, "stages")?, payload(settings)?) {
        (0, Payload::Fixed) => STAGES,
        (0, Payload::Variable) => MOST_STAGES,
        (stages, _) => stages,
    })
}

/// The only target.
fn target(settings: &Settings, payload: Payload) -> Result<Target, ConfigError> {
    let named = ["rate", "psnr", "max_error"];
    let mut given = Vec::new();
    for (name, of) in named.into_iter().zip([Target::Rate, Target::Psnr, Target::MaxError]) {
        let value = settings.float(name)?;
        if value > 0.0 {
            given.push((name, of(value)));
        }
    }
    match (&given[..], payload) {
        ([], _) => Ok(Target::Rate(RATE)),
        ([(name, _), ..], Payload::Fixed) => Err(ConfigError::Contradiction(format!(
            "`{name}` of rvq needs `payload = \"variable\"`; under fixed, `stages` and `codewords` decide"
        ))),
        ([(_, target)], Payload::Variable) => Ok(*target),
        ([(one, _), (other, _), ..], Payload::Variable) => Err(ConfigError::Contradiction(format!(
            "`{one}` and `{other}` of rvq are two targets; set one of them to 0"
        ))),
    }
}

impl Options {
    /// Of complete settings.
    ///
    /// # Errors
    /// When one is missing, or targets contradict each other or the payload.
    pub fn of(settings: &Settings) -> Result<Self, ConfigError> {
        let payload = payload(settings)?;
        Ok(Self {
            payload,
            target: target(settings, payload)?,
            stages: stages(settings)?,
            codewords: Some(natural(settings, "codewords")?).filter(|size| *size > 0),
            entries: Entries::named(settings.text("entries")?),
            beam: natural(settings, "beam")? as usize,
            refinement: natural(settings, "refinement")?,
            training: training(settings, payload)?,
        })
    }
}

/// The settings of training, with the first codebook that suits the payload.
fn training(settings: &Settings, payload: Payload) -> Result<TrainingSettings, ConfigError> {
    if settings.text("init")? != "auto" {
        return TrainingSettings::of(settings);
    }
    let init = if payload == Payload::Fixed { "pnn" } else { "pca" };
    let mut chosen = settings.clone();
    chosen.set("init", SettingValue::from(init));
    TrainingSettings::of(&chosen)
}
