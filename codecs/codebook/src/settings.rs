//! The settings of codebook training that all vector quantisers share.

use std::ops::Range;

use cvr_core::codec::{ConfigError, Setting, SettingKind, Settings};

use crate::Initial;
use crate::blocks::Draw;

/// Blocks that a codebook is trained on.
pub const TRAINING_BLOCKS: Setting = Setting {
    name: "training_blocks",
    doc: "blocks that a codebook is trained on, drawn by chance; all where there are no more",
    kind: SettingKind::Integer { min: 1, max: 1 << 24 },
    default: "131072",
};

/// How training blocks are drawn. A codec without this setting draws uniformly.
pub const DRAW: Setting = Setting {
    name: "draw",
    doc: "how training blocks are drawn where there are more: uniform = by chance alone; stratified = half of them \
          evenly over classes of variance, so that rare edges are in it",
    kind: SettingKind::Choice(Draw::NAMES),
    default: "uniform",
};

/// Rounds of training.
pub const ITERATIONS: Setting = Setting {
    name: "iterations",
    doc: "rounds of training at most; it ends before, once a round gains less than a thousandth",
    kind: SettingKind::Integer { min: 0, max: 1000 },
    default: "50",
};

/// The first codebook.
pub const INIT: Setting = Setting {
    name: "init",
    doc: "first codebook, which training refines: pca = cells cut across their principal axis; pnn = pairs of \
          nearest neighbours united; scalar = a grid of scalar quantisers; random = blocks drawn by chance",
    kind: SettingKind::Choice(Initial::NAMES),
    default: "pca",
};

/// What chance decides.
pub const SEED: Setting = Setting {
    name: "seed",
    doc: "of the choice of training blocks, and of what else chance decides",
    kind: SettingKind::Integer { min: 0, max: i64::MAX },
    default: "1",
};

/// Words of a setting `tables`.
pub const TABLES: SettingKind = SettingKind::Choice(&["shared", "per-frame"]);

/// The settings as an encoder uses them.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct TrainingSettings {
    /// Whether each frame has its own codebooks (`tables`).
    pub per_frame: bool,
    /// Blocks that a codebook is trained on, at most.
    pub training_blocks: u64,
    /// How they are drawn.
    pub draw: Draw,
    /// Rounds of training, at most.
    pub iterations: u32,
    /// The first codebook.
    pub initial: Initial,
    /// What chance decides.
    pub seed: u64,
}

impl TrainingSettings {
    /// Reads complete settings.
    ///
    /// # Errors
    /// When one is missing; all but `draw` must be there.
    pub fn of(settings: &Settings) -> Result<Self, ConfigError> {
        let incomplete = |name: &str| ConfigError::Incomplete(name.to_owned());
        let draw = if settings.get(DRAW.name).is_some() { settings.text(DRAW.name)? } else { "uniform" };
        Ok(Self {
            per_frame: settings.text("tables")? == "per-frame",
            training_blocks: u64::from(natural(settings, TRAINING_BLOCKS.name)?),
            draw: Draw::named(draw).ok_or_else(|| incomplete(DRAW.name))?,
            iterations: natural(settings, ITERATIONS.name)?,
            initial: Initial::named(settings.text(INIT.name)?).ok_or_else(|| incomplete(INIT.name))?,
            seed: u64::try_from(settings.integer(SEED.name)?).map_err(|_| incomplete(SEED.name))?,
        })
    }

    /// The frames that each set of codebooks serves.
    #[must_use]
    pub fn served(&self, frames: u32) -> Vec<Range<u32>> {
        let each = if self.per_frame { 1 } else { frames };
        (0..frames).step_by(each as usize).map(|first| first..first + each).collect()
    }
}

/// A non-negative integer of 32 bits.
///
/// # Errors
/// When the setting is absent or another kind of value.
pub fn natural(settings: &Settings, name: &str) -> Result<u32, ConfigError> {
    u32::try_from(settings.integer(name)?).map_err(|_| ConfigError::Incomplete(name.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use cvr_core::codec::SettingValue;

    fn settings(tables: &str) -> Settings {
        let defaults = [TRAINING_BLOCKS, DRAW, ITERATIONS, INIT, SEED].map(|s| (s.name, s.default));
        let all = defaults.into_iter().chain([("tables", tables)]);
        all.map(|(name, value)| (name.to_owned(), SettingValue::from(value))).collect()
    }

    #[test]
    fn defaults_are_read_and_frames_are_served() {
        let shared = TrainingSettings::of(&settings("shared")).unwrap();
        assert_eq!((shared.training_blocks, shared.draw, shared.iterations), (131_072, Draw::Uniform, 50));
        assert_eq!(shared.served(3), std::slice::from_ref(&(0..3)));
        let each = TrainingSettings::of(&settings("per-frame")).unwrap();
        assert_eq!(each.served(3), [0..1, 1..2, 2..3]);
    }

    #[test]
    fn what_is_missing_is_named() {
        let mut settings = settings("shared");
        settings.set("init", "best".into());
        let refused = TrainingSettings::of(&settings).unwrap_err();
        assert_eq!(refused, ConfigError::Incomplete("init".to_owned()));
    }
}
