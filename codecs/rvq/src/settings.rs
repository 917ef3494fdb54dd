//! The settings: their schema, and what an encoder makes of them.

use cvr_codebook::settings::{self as training, TrainingSettings, natural};
use cvr_core::codec::{ConfigError, Setting, SettingKind, Settings};

use crate::stream::{Entries, MOST_STAGES};

/// The schema.
pub const SETTINGS: &[Setting] = &[
    Setting {
        name: "stages",
        doc: "codebooks, each trained on what those before it leave; each costs a code per block and a fetch per voxel",
        kind: SettingKind::Integer { min: 1, max: MOST_STAGES as i64 },
        default: "4",
    },
    Setting {
        name: "codewords",
        doc: "size of each codebook; a code takes ceil(log2(codewords)) bits; 0 = chosen from the number of blocks",
        kind: SettingKind::Integer { min: 0, max: 65536 },
        default: "0",
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
    Setting { default: "pnn", ..training::INIT },
    training::SEED,
];

/// What makes another method of it. The others are dials of rate and quality, or of the time that encoding takes.
pub const METHODS: &[&str] = &["entries", "refinement", "tables", "draw", "init"];

/// The settings of one encoder.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Options {
    /// 1 to [`MOST_STAGES`].
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

/// Stages that are asked for.
///
/// # Errors
/// When the setting is missing.
pub fn stages(settings: &Settings) -> Result<u32, ConfigError> {
    natural(settings, "stages")
}

impl Options {
    /// Of complete settings.
    ///
    /// # Errors
    /// When one is missing, or `codewords` is 1.
    pub fn of(settings: &Settings) -> Result<Self, ConfigError> {
        Ok(Self {
            stages: stages(settings)?,
            codewords: Some(natural(settings, "codewords")?).filter(|size| *size > 0),
            entries: Entries::named(settings.text("entries")?),
            beam: natural(settings, "beam")? as usize,
            refinement: natural(settings, "refinement")?,
            training: TrainingSettings::of(settings)?,
        })
    }
}
