//! The buffers of a snippet.

use std::borrow::Cow;

use super::tokens::mentions;
use crate::codec::{DecodeError, Decoder, References, Resource, ShaderDecode};
use crate::volume::{FrameIndex, Level};

/// All buffers that a snippet reads to decode a frame at a level: the codec's own, and those of the frame's references
/// ([`References::resources`]). One text serves all frames of a stream. A frame that lacks a reference of the text gets
/// an empty buffer, which it does not read.
///
/// # Errors
/// As [`ShaderDecode::resources`] and [`Decoder::references`].
pub fn snippet_resources<'a>(
    codec: &str,
    decoder: &dyn Decoder,
    shader: &'a dyn ShaderDecode,
    (frame, level): (FrameIndex, Level),
) -> Result<Vec<Resource<'a>>, DecodeError> {
    let mut resources = shader.resources(frame)?;
    let references = decoder.references(frame, level)?.resources()?;
    let missing = References::RESOURCES.into_iter().skip(references.len());
    resources.extend(references);
    let source = shader.module().source;
    let asked = missing.filter(|name| mentions(source, &format!("{codec}_{name}")));
    resources.extend(asked.map(|name| Resource { name, words: Cow::Borrowed(&[]) }));
    Ok(resources)
}
