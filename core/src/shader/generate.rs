//! Putting the text together.

use super::{GeneratedShader, Request, ShaderError};

/// Generates, parses, lints and validates a shader.
///
/// # Errors
/// When a template or snippet does not parse, the snippet breaks its contract, or the device's limits do not
/// suffice.
pub fn generate(_request: &Request<'_>) -> Result<GeneratedShader, ShaderError> {
    Err(ShaderError("not yet".to_owned()))
}
