//! The settings: their schema, and their form in the encoder.

use cvr_core::codec::{ConfigError, Setting, SettingKind, Settings};

use crate::coders::Coding;
use crate::quantiser::Scale;
use crate::transform::Filter;

/// Most decompositions: 2¹² voxels become one coefficient.
const MOST_DECOMPOSITIONS: i64 = 12;

/// The schema.
pub const SETTINGS: &[Setting] = &[
    Setting {
        name: "filter",
        doc: "wavelet filter; 5-3 maps integers to integers and is lossless without a target",
        kind: SettingKind::Choice(Filter::NAMES),
        default: "cdf-9-7",
    },
    Setting {
        name: "decompositions",
        doc: "how often the low band is transformed again; each is a coarser resolution",
        kind: SettingKind::Integer { min: 0, max: MOST_DECOMPOSITIONS },
        default: "5",
    },
    Setting {
        name: "coder",
        doc: "entropy coder: contexts of neighbours, parents and other bands; or the paper's: runs of zeros, those through \
              deflate, adaptive arithmetic with a zero mode, zerotrees",
        kind: SettingKind::Choice(Coding::NAMES),
        default: "contexts",
    },
    Setting {
        name: "order",
        doc: "order of coefficients in runs of zeros: line by line, or depth-first through an octree",
        kind: SettingKind::Choice(&["lines", "octree"]),
        default: "lines",
    },
    Setting {
        name: "bits_per_voxel",
        doc: "bits per voxel of the whole file, at most and within 1 %, the same for each frame; 0 = no such target; \
              where nothing is asked for, 5-3 and blocks of integers are lossless, and all others take 1 bit, 4 KB at least",
        kind: SettingKind::Float { min: 0.0, max: 96.0 },
        default: "0.0",
    },
    Setting {
        name: "psnr",
        doc: "decibels that each frame reaches, within 1 %; 0 = no such target",
        kind: SettingKind::Float { min: 0.0, max: 140.0 },
        default: "0.0",
    },
    Setting {
        name: "max_error",
        doc: "largest error of any decoded sample, in data units, integers rounded; 0 = no such target",
        kind: SettingKind::Float { min: 0.0, max: 1e30 },
        default: "0.0",
    },
    Setting {
        name: "quality",
        doc: "the paper's quantiser, from 0 to 255; -1 = not used",
        kind: SettingKind::Integer { min: -1, max: 255 },
        default: "-1",
    },
    Setting {
        name: "quant_scale",
        doc: "quantisation steps over quality: paper = 127 + 128 q / 255; printed = 127 + 128 q, as the paper prints it",
        kind: SettingKind::Choice(&["paper", "printed"]),
        default: "paper",
    },
    Setting {
        name: "block",
        doc: "0 = the whole volume at once; 8 or 16 = blocks of that edge that decode on their own, with filter haar or 5-3",
        kind: SettingKind::OneOf(&[0, 8, 16]),
        default: "0",
    },
];

/// Settings that make another method. The other settings change rate and quality.
pub const METHODS: &[&str] = &["filter", "coder", "order", "quant_scale", "block"];

/// What encoding aims at.
#[derive(Copy, Clone, Debug, PartialEq)]
pub enum Target {
    /// Every sample as it was.
    Lossless,
    /// Bits per voxel of the whole file.
    BitsPerVoxel(f64),
    /// One bit per voxel, and more for a volume so small that the header alone takes that.
    Usual,
    /// Decibels.
    Psnr(f64),
    /// Largest error of a sample, in data units.
    MaxError(f64),
    /// The paper's quantiser: 0 to 255.
    Quality(u8),
}

/// The settings of one encoder.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Options {
    /// Wavelet filter.
    pub filter: Filter,
    /// How often the low band is transformed again.
    pub decompositions: usize,
    /// Entropy coder.
    pub coding: Coding,
    /// What encoding aims at.
    pub target: Target,
    /// Of the paper's quantiser.
    pub scale: Scale,
    /// Edge of blocks that decode on their own, or 0.
    pub block: u32,
}

impl Options {
    /// # Errors
    /// When settings contradict each other.
    pub fn new(settings: &Settings) -> Result<Self, ConfigError> {
        let unknown = |name: &str| ConfigError::Incomplete(name.to_owned());
        let filter = Filter::from_name(settings.text("filter")?).ok_or_else(|| unknown("filter"))?;
        let (coder, order) = (settings.text("coder")?, settings.text("order")?);
        let block = settings.integer("block")? as u32;
        if block > 0 && !matches!(filter, Filter::Haar | Filter::FiveThree) {
            let problem = format!(
                "`block = {block}` needs `filter = \"haar\"` or \"5-3\": {} reaches too far for a block on its own",
                filter.name()
            );
            return Err(ConfigError::Contradiction(problem));
        }
        Ok(Self {
            filter,
            decompositions: settings.integer("decompositions")? as usize,
            coding: Coding::from_names(coder, order).ok_or_else(|| unknown("coder"))?,
            target: target(settings, filter, block)?,
            scale: if settings.text("quant_scale")? == "printed" { Scale::Printed } else { Scale::Paper },
            block,
        })
    }
}

/// The one target.
fn target(settings: &Settings, filter: Filter, block: u32) -> Result<Target, ConfigError> {
    let mut asked = Vec::new();
    for name in ["bits_per_voxel", "psnr", "max_error"] {
        let value = settings.float(name)?;
        if value > 0.0 {
            asked.push((
                name,
                match name {
                    "psnr" => Target::Psnr(value),
                    "max_error" => Target::MaxError(value),
                    _ => Target::BitsPerVoxel(value),
                },
            ));
        }
    }
    if let Ok(quality) = u8::try_from(settings.integer("quality")?) {
        asked.push(("quality", Target::Quality(quality)));
    }
    match asked[..] {
        [] if filter.is_integer() => Ok(Target::Lossless),
        [] => Ok(Target::Usual),
        [("quality", _)] if filter.is_integer() || block > 0 => {
            let problem = "`quality` is the paper's quantiser of whole volumes in floating point: leave out `block`, \
                           and use another filter than 5-3";
            Err(ConfigError::Contradiction(problem.to_owned()))
        }
        [(_, target)] => Ok(target),
        [(first, _), (second, _), ..] => Err(ConfigError::Contradiction(format!(
            "`{first}` and `{second}` are both targets: set one of them"
        ))),
    }
}
