//! Results of the conformance tests.

use std::fmt;

use crate::codec::Settings;

/// A property that every codec must have.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Property {
    /// A volume encodes, or is refused with [`crate::codec::EncodeError::Unsupported`].
    Encode,
    /// Two encodings with the same settings and threads give the same bytes.
    Repeat,
    /// One thread and four give the same bytes.
    Threads,
    /// The stream opens and decodes, from nothing but itself.
    Stream,
    /// Decoded values are finite, and within the promised error bound.
    Bound,
    /// Decoded values lie within `value_range`.
    Range,
    /// Any region decodes to the same values as in the whole frame.
    Regions,
    /// More stages never raise the mean squared error. A number above the stream's stages means all stages.
    Stages,
    /// Every resolution that the codec names decodes, to finite values.
    Resolutions,
    /// Regions, frames and levels that do not exist are refused.
    Keys,
    /// Damaged streams are refused, without a panic.
    Damage,
    /// A later stream version gives [`crate::codec::DecodeError::Version`].
    Version,
    /// The snippet is valid WGSL and keeps its contract.
    Module,
    /// Shader and CPU agree, every voxel.
    Parity,
    /// With default settings, no volume comes back worse than its mean. Noise and checkerboards do not come back worse
    /// than from a coarser grid of the same bytes ([`crate::stability`]).
    Trivial,
}

/// One property that did not hold.
#[derive(Clone, Debug)]
pub struct Failure {
    /// What did not hold.
    pub property: Property,
    /// Settings of the encoder.
    pub settings: String,
    /// Name of the adversarial volume.
    pub volume: String,
    /// The expected and the actual result.
    pub message: String,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} [{}] {}: {}", self.property, self.settings, self.volume, self.message)
    }
}

/// Outcome of one run of the conformance tests.
#[derive(Clone, Debug)]
pub struct Report {
    /// Codec id.
    pub codec: String,
    /// Properties checked, all volumes and settings together.
    pub checks: usize,
    /// Volumes that the codec refused.
    pub refused: usize,
    /// Samples that a shader of the codec decoded and that were compared with the CPU decoder. 0 if no shader ran.
    pub shader_samples: u64,
    /// What did not hold.
    pub failures: Vec<Failure>,
    /// Whether the codec has a shader at all.
    pub(super) has_shader: bool,
    settings: String,
    volume: String,
}

impl Report {
    pub(super) fn new(codec: &str) -> Self {
        Self {
            codec: codec.to_owned(),
            checks: 0,
            refused: 0,
            shader_samples: 0,
            failures: Vec::new(),
            has_shader: false,
            settings: String::new(),
            volume: String::new(),
        }
    }

    /// Later checks and failures belong to this volume.
    pub(super) fn begin(&mut self, settings: &Settings, volume: &str) {
        self.settings = settings.to_string();
        volume.clone_into(&mut self.volume);
    }

    pub(super) fn check(&mut self, property: Property, holds: bool, message: impl FnOnce() -> String) {
        self.checks += 1;
        if !holds {
            let (settings, volume) = (self.settings.clone(), self.volume.clone());
            self.failures.push(Failure { property, settings, volume, message: message() });
        }
    }

    pub(super) fn fail(&mut self, property: Property, message: String) {
        self.check(property, false, || message);
    }

    pub(super) fn give_up<T>(&mut self, property: Property, message: String) -> Option<T> {
        self.fail(property, message);
        None
    }

    /// Whether the codec has a shader that no device ran. Such a shader may be wrong although all checks passed.
    #[must_use]
    pub const fn shader_not_run(&self) -> bool {
        self.has_shader && self.shader_samples == 0
    }

    /// Whether some failure concerns this property.
    #[must_use]
    pub fn fails(&self, property: Property) -> bool {
        self.failures.iter().any(|f| f.property == property)
    }

    /// Ends a test. Prints what was checked, and whether a shader was compared.
    ///
    /// # Panics
    /// When a property did not hold, or nothing was checked; the message lists the first twenty failures.
    pub fn assert_ok(&self) {
        println!("{self}");
        assert!(self.checks > 0, "codec `{}`: nothing was checked", self.codec);
        let shown: Vec<String> = self.failures.iter().take(20).map(ToString::to_string).collect();
        assert!(
            self.failures.is_empty(),
            "codec `{}` fails {} of {} checks:\n{}",
            self.codec,
            self.failures.len(),
            self.checks,
            shown.join("\n")
        );
    }
}

/// One sentence: what was checked, and whether a shader was compared.
impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { codec, checks, refused, .. } = self;
        write!(
            f,
            "codec `{codec}`: {} of {checks} checks failed, {refused} volumes refused; ",
            self.failures.len()
        )?;
        match self.shader_samples {
            0 if self.has_shader => {
                f.write_str("shader not run: no device, so that a wrong shader would not be noticed")
            }
            0 => f.write_str("it has no shader"),
            n => write!(f, "{n} samples through the shader compared"),
        }
    }
}
