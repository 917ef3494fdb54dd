//! How a device rebuilds a whole frame: compute passes that a codec brings.

use super::{Agreement, DecodeError, Decoder, Resource, ShaderDecode, WgslModule};
use crate::volume::{FrameIndex, Level};

/// The decode side of a codec whose voxels do not come one by one: passes over scratch buffers, at whose end a whole
/// frame stands. The site *deferred* runs them in place of the snippet of [`ShaderDecode`], which such a codec may
/// have beside them, or not at all.
pub trait FrameDecode: Send + Sync {
    /// The passes that rebuild `frame`, and what they read. What the CPU has to do for it (entropy decoding) is done
    /// here. The frame has the extent of [`Decoder::layout`] at the level's resolution. Passes of a predicted frame read
    /// what it is predicted from beside the stream's own buffers ([`super::References::resources`]).
    ///
    /// # Errors
    /// When the frame or the level does not exist, or the stream lacks what the passes read.
    fn passes(&self, frame: FrameIndex, level: Level) -> Result<FramePasses<'_>, DecodeError>;

    /// How closely the passes follow the CPU decoder.
    fn agreement(&self) -> Agreement;
}

/// Passes, run one after another, each of which sees all that earlier ones wrote.
#[derive(Clone, Debug)]
pub struct FramePasses<'a> {
    /// Buffers that every pass may read, as an inline snippet does.
    pub resources: Vec<Resource<'a>>,
    /// Buffers that passes read and write, of which [`FramePass::scratch`] says.
    pub scratch: Vec<Scratch>,
    /// The passes, at least one.
    pub passes: Vec<FramePass<'a>>,
    /// The scratch buffer that holds the frame in the end: the bits of one `f32` per sample, in data units, x fastest,
    /// channels interleaved. What it holds beyond the frame is ignored.
    pub result: &'static str,
}

/// A buffer of 32-bit words on the device, for as long as a frame is decoded. It begins as zeros or as an earlier
/// decode left it, so that a pass reads nothing that none has written.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Scratch {
    /// Name, by which [`ScratchUse`] and [`FramePasses::result`] speak of it.
    pub name: &'static str,
    /// Its words, at least one. The generator may split it over several bindings; a pass cannot tell.
    pub words: u64,
}

/// One compute pass: `workgroups` times the entry point of a module.
///
/// The module declares one entry point, `@compute @workgroup_size(..) fn <id>_<entry>(..)`, of at most 256 invocations
/// (64 along z), and only names that begin with `<id>_`. It has no `@group`, and at module scope no `var` but
/// `var<workgroup>`, of which there are at most 16 KiB: what every WebGPU device offers. An index beyond the end of a
/// buffer reads or writes any word of it. Invocations of one pass run in any order: none may read what another one
/// writes, except in its own workgroup and behind a barrier.
#[derive(Clone, Debug)]
pub struct FramePass<'a> {
    /// File, text and constants. Passes may share a text and differ in their constants.
    pub module: WgslModule<'a>,
    /// Entry point, without the codec's prefix.
    pub entry: &'static str,
    /// Workgroups along x, y and z, each at least one.
    pub workgroups: [u32; 3],
    /// The scratch buffers at hand, each at most once, under the names that the module has for them: passes that
    /// alternate between two buffers share a text all the same.
    pub scratch: Vec<ScratchUse>,
}

/// A scratch buffer in a pass, read through `<id>_<name>(i: u32) -> u32` and written through
/// `<id>_set_<name>(i: u32, word: u32)`.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct ScratchUse {
    /// Name in the module, without the codec's prefix. A snippet's `frame`, `resolution` and `stages` are at hand in a
    /// pass too, and so are taken.
    pub name: &'static str,
    /// [`Scratch::name`].
    pub buffer: &'static str,
}

/// What a decoder states of the site *deferred*: of its passes if it brings any, else of its snippet; `None` if it has
/// neither.
#[must_use]
pub fn deferred_agreement(decoder: &dyn Decoder) -> Option<Agreement> {
    let passes = decoder.frame_decode().map(FrameDecode::agreement);
    passes.or_else(|| decoder.shader().map(ShaderDecode::agreement))
}
