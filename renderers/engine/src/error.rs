//! Errors between a plan and its picture.

use cvr_core::codec::DecodeError;
use cvr_core::shader::{DeferredError, ShaderError};

/// Why a device cannot be opened, or a drawing cannot be made or run.
#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    /// No adapter exists, or none is the one asked for.
    #[error("no graphics adapter{}; {}", asked_for(.wanted.as_deref()), known_adapters(.known))]
    NoAdapter {
        /// The requested device. `None` for any.
        wanted: Option<String>,
        /// Adapters that exist, as [`crate::DeviceInfo`] prints them.
        known: Vec<String>,
    },
    /// A resource exceeds what the device offers.
    #[error("{what} needs {requested} {unit}, this device offers {limit}")]
    TooLarge {
        /// The resource.
        what: String,
        /// Size asked for.
        requested: u64,
        /// Size the device offers.
        limit: u64,
        /// Unit of both numbers.
        unit: &'static str,
    },
    /// The generator refused the shader.
    #[error(transparent)]
    Shader(#[from] ShaderError),
    /// The stream lacks data that its shader reads.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// The device or its driver refused a call. The text names the step and the driver's reason.
    #[error("{0}")]
    Gpu(String),
    /// The device ran out of memory.
    #[error("out of device memory: {0}")]
    OutOfMemory(String),
    /// The device is lost (reset, unplugged, destroyed). Every later call on it fails in the same way.
    #[error("the device was lost: {0}")]
    DeviceLost(String),
    /// The device ended loops of a shader early, so there is no picture.
    #[error(
        "the device ended the loops of the shader before they were done, in {pixels} pixels, though each took a single sample \
         at a time (llvmpipe ends them after 65535 rounds in all): decode at the site deferred or host, take a filter \
         that fetches less or no light, or draw on another device"
    )]
    CutOff {
        /// Pixels that show it.
        pixels: usize,
    },
    /// The request is not possible on this device or with this decoder.
    #[error("{0}")]
    Unsupported(String),
}

impl From<DeferredError> for EngineError {
    fn from(error: DeferredError) -> Self {
        match error {
            DeferredError::NoShader(_) => Self::Unsupported(error.to_string()),
            DeferredError::Decode(error) => error.into(),
            DeferredError::Shader(error) => error.into(),
        }
    }
}

fn asked_for(wanted: Option<&str>) -> String {
    wanted.map_or_else(String::new, |name| format!(" matches `{name}`"))
}

fn known_adapters(known: &[String]) -> String {
    if known.is_empty() {
        return "none was found (is a Vulkan, Metal or DX12 driver installed?)".to_owned();
    }
    format!("there are: {}", known.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_adapter_names_those_that_exist() {
        let none = EngineError::NoAdapter { wanted: None, known: Vec::new() };
        assert_eq!(
            none.to_string(),
            "no graphics adapter; none was found (is a Vulkan, Metal or DX12 driver installed?)"
        );
        let other = EngineError::NoAdapter {
            wanted: Some("radeon".to_owned()),
            known: vec!["llvmpipe (vulkan, cpu)".to_owned()],
        };
        assert_eq!(
            other.to_string(),
            "no graphics adapter matches `radeon`; there are: llvmpipe (vulkan, cpu)"
        );
    }
}
