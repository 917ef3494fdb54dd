//! What a configuration may name.

use crate::codec::Registry;
use crate::render::RendererInfo;

/// The names that a configuration may use.
#[derive(Copy, Clone, Debug)]
pub struct Known<'a> {
    /// The codecs, with the schemas of their settings.
    pub codecs: &'a Registry,
    /// The renderers, with the schemas of their settings.
    pub renderers: &'a [&'static RendererInfo],
    /// Names of volume generators.
    pub generators: &'a [&'a str],
}
