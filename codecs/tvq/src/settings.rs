//! The settings: their schema, and their form in the encoder.

use cvr_codebook::Initial;
use cvr_codebook::settings::{TABLES, TrainingSettings, natural};
use cvr_core::codec::{ConfigError, Setting, SettingKind, Settings};

use crate::encode::train::transform::Transform;
use crate::stream::geometry::Payload;

/// The schema.
pub const SETTINGS: &[Setting] = &[
    Setting {
        name: "payload",
        doc: "fixed = a mean and one code per partition for every block; variable = a mean and as many codes as the \
              block needs",
        kind: SettingKind::Choice(&["fixed", "variable"]),
        default: "fixed",
    },
    Setting {
        name: "rate",
        doc: "bits per sample of the whole file, at most; 0 = no such target",
        kind: SettingKind::Float { min: 0.0, max: 16.0 },
        default: "0.0",
    },
    Setting {
        name: "psnr",
        doc: "decibels, at the least rate that reaches them, within `rate` if that is set too; 0 = no such target",
        kind: SettingKind::Float { min: 0.0, max: 100.0 },
        default: "0.0",
    },
    Setting {
        name: "index_bits",
        doc: "bits of a code; 0 = allocated: without a target 24 bits over the three partitions",
        kind: SettingKind::OneOf(&[0, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16]),
        default: "0",
    },
    Setting {
        name: "codes",
        doc: "most codes of a block under the payload variable, each a fetch for every voxel; fewer are longer",
        kind: SettingKind::Integer { min: 1, max: 63 },
        default: "63",
    },
    Setting {
        name: "transform",
        doc: "transform whose octants are the zones: of the data (klt: a basis per axis, klt-full: one of blocks) or given",
        kind: SettingKind::Choice(Transform::NAMES),
        default: "klt",
    },
    Setting {
        name: "codevectors",
        doc: "joint = trained on what the partitions before leave; partition = confined to their own zones",
        kind: SettingKind::Choice(&["joint", "partition"]),
        default: "joint",
    },
    Setting {
        name: "classification",
        doc: "whether classes of blocks train chapters of their own",
        kind: SettingKind::Boolean,
        default: "true",
    },
    Setting {
        name: "threshold",
        doc: "root mean square error, in data units, that a class may leave; 0 = what the quantisers are expected to \
              leave",
        kind: SettingKind::Float { min: 0.0, max: 1e30 },
        default: "0.0",
    },
    Setting {
        name: "subvolume",
        doc: "edge in voxels of sub-volumes with tables of their own",
        kind: SettingKind::Choice(&["none", "128", "160", "192", "224", "256"]),
        default: "none",
    },
    Setting {
        name: "tables",
        doc: "shared = one set of codebooks for all frames; per-frame = one for each",
        kind: TABLES,
        default: "shared",
    },
    Setting {
        name: "entry_bits",
        doc: "bits of one value of a codeword; 0 = 8, or under variable 16 where they leave less at the same rate",
        kind: SettingKind::OneOf(&[0, 8, 16]),
        default: "0",
    },
    Setting {
        name: "init",
        doc: "first codebook: cells cut across their principal axis, pairwise nearest neighbours, scalar grids, chance",
        kind: SettingKind::Choice(Initial::NAMES),
        default: "pca",
    },
    Setting {
        name: "training_blocks",
        doc: "blocks that the codebooks of a table are trained on, drawn by chance; under fixed up to 2.5 times as many for \
              codebooks of more than 1024 codewords; all where there are no more",
        kind: SettingKind::Integer { min: 1, max: 1 << 24 },
        default: "65536",
    },
    Setting {
        name: "iterations",
        doc: "rounds of training of a chapter at most",
        kind: SettingKind::Integer { min: 0, max: 1000 },
        default: "10",
    },
    Setting {
        name: "seed",
        doc: "of the choice of training blocks",
        kind: SettingKind::Integer { min: 0, max: i64::MAX },
        default: "1",
    },
];

/// Settings that make another method: other quantisers, transforms or training. The other settings change rate, quality
/// or encoding time.
pub const METHODS: &[&str] =
    &["payload", "transform", "codevectors", "classification", "subvolume", "tables", "init"];

/// The target of encoding.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Target {
    /// 24 bits of codes and 8 bits of mean per block, and codebooks as large as the number of blocks pays for.
    Codes,
    /// Bits per sample of the whole file.
    Rate(f64),
    /// Decibels.
    Psnr(f64),
    /// Decibels, with at most `rate` bits per sample.
    Both { rate: f64, psnr: f64 },
}

/// Bits of the codes of a block, without a target.
pub const CODE_BITS: u32 = 24;
/// Bits of its mean, without a target.
pub const MEAN_BITS: u32 = 8;

/// The settings of one encoder.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Options {
    pub payload: Payload,
    pub target: Target,
    /// Bits of a code; 0 = allocated.
    pub index_bits: u32,
    /// Codewords of the codebooks of the payload `fixed`, if they are given.
    pub sizes: Option<[usize; 3]>,
    /// Most codes of a block with the payload `variable`.
    pub codes: u32,
    pub transform: Transform,
    pub confined: bool,
    pub classification: bool,
    /// In data units; 0 = automatic.
    pub threshold: f64,
    /// In voxels; 0 = none.
    pub subvolume: u32,
    /// `None`: the encoder chooses.
    pub entry_bits: Option<u32>,
    pub training: TrainingSettings,
}

impl Options {
    /// Reads complete settings.
    ///
    /// # Errors
    /// When one is missing.
    pub fn of(settings: &Settings) -> Result<Self, ConfigError> {
        let incomplete = |name: &str| ConfigError::Incomplete(name.to_owned());
        let (rate, psnr) = (settings.float("rate")?, settings.float("psnr")?);
        let target = if rate > 0.0 && psnr > 0.0 {
            Target::Both { rate, psnr }
        } else if rate > 0.0 {
            Target::Rate(rate)
        } else if psnr > 0.0 {
            Target::Psnr(psnr)
        } else {
            Target::Codes
        };
        Ok(Self {
            payload: if settings.text("payload")? == "fixed" { Payload::Fixed } else { Payload::Variable },
            target,
            index_bits: natural(settings, "index_bits")?,
            sizes: None,
            codes: natural(settings, "codes")?,
            transform: Transform::named(settings.text("transform")?)
                .ok_or_else(|| incomplete("transform"))?,
            confined: settings.text("codevectors")? == "partition",
            classification: settings.boolean("classification")?,
            threshold: settings.float("threshold")?,
            subvolume: settings.text("subvolume")?.parse().unwrap_or(0),
            entry_bits: Some(natural(settings, "entry_bits")?).filter(|bits| *bits > 0),
            training: TrainingSettings::of(settings)?,
        })
    }
}
