//! Targets: a graphics device, or the CPU mirror.

use cvr_core::codec::DecodeError;
use cvr_core::render::RenderError;
use cvr_engine::{Device, DeviceChoice, EngineError};

/// Why nothing was drawn.
#[derive(Debug, thiserror::Error)]
pub enum DrawError {
    /// The device refused.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The renderer or its mirror refused.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A frame that a predicted frame needs does not decode.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// The CPU cannot decode the frame to draw. The text is the reason.
    #[error("{0}")]
    Frame(String),
}

/// A graphics device, or the CPU mirror.
#[derive(Clone, Debug)]
pub enum Target {
    /// The mirror, on all cores.
    Cpu {
        /// Why no device draws, if one was wanted.
        reason: Option<String>,
    },
    /// A device.
    Device(Device),
}

impl Target {
    /// Opens the target of `--device`: `cpu`, `auto`, a backend (`vulkan`, `gl`), or a part of an adapter's name.
    /// `auto` falls back to the mirror if there is no adapter.
    ///
    /// # Errors
    /// When a named adapter does not exist, or an existing one does not open.
    pub fn open(name: &str) -> Result<Self, EngineError> {
        if name.eq_ignore_ascii_case("cpu") {
            return Ok(Self::Cpu { reason: None });
        }
        let choice = name.parse().unwrap_or(DeviceChoice::Auto);
        match Device::open(&choice) {
            Ok(device) => Ok(Self::Device(device)),
            Err(error @ EngineError::NoAdapter { .. }) if choice == DeviceChoice::Auto => {
                Ok(Self::Cpu { reason: Some(error.to_string()) })
            }
            Err(error) => Err(error),
        }
    }

    /// Name in records: the adapter's, or `cpu`.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Cpu { .. } => "cpu".to_owned(),
            Self::Device(device) => device.info().name.clone(),
        }
    }

    /// Driver and its version, in words.
    #[must_use]
    pub fn driver(&self) -> String {
        match self {
            Self::Cpu { .. } => "CPU mirror".to_owned(),
            Self::Device(device) => {
                let info = device.info();
                format!("{} {}", info.driver, info.driver_info).trim().to_owned()
            }
        }
    }

    /// Graphics interface, in words.
    #[must_use]
    pub fn backend(&self) -> String {
        match self {
            Self::Cpu { .. } => "none".to_owned(),
            Self::Device(device) => device.info().backend.to_string(),
        }
    }

    /// Why the device is lost. Every later call on it fails. `None` if it works, and for the mirror.
    #[must_use]
    pub fn lost(&self) -> Option<String> {
        match self {
            Self::Cpu { .. } => None,
            Self::Device(device) => device.lost(),
        }
    }
}
