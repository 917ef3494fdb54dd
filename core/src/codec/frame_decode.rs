//! How a device rebuilds a whole frame: compute passes that a codec brings.

use super::{Agreement, DecodeError, Decoder, Resource, ShaderDecode, WgslModule};
use crate::volume::{FrameIndex, Level};

/// The device decoder of a codec that cannot decode single voxels: passes over scratch buffers. The last pass leaves a
/// whole frame. The site *deferred* runs these passes instead of the snippet of [`ShaderDecode`]. Such a codec may have
/// a snippet as well.
pub trait FrameDecode: Send + Sync {
    /// The passes that rebuild `frame`, and their input. Work of the CPU (entropy decoding) is done here. The frame has
    /// the extent of [`Decoder::layout`] at the level's resolution. Passes of a predicted frame read its references
    /// next to the stream's own buffers ([`super::References::resources`]).
    ///
    /// # Errors
    /// If the frame or the level does not exist, or the stream lacks data of a pass.
    fn passes(&self, frame: FrameIndex, level: Level) -> Result<FramePasses<'_>, DecodeError>;

    /// How closely the passes follow the CPU decoder.
    fn agreement(&self) -> Agreement;
}

/// Passes that run one after another. Each pass sees everything that earlier passes wrote.
#[derive(Clone, Debug)]
pub struct FramePasses<'a> {
    /// Buffers that every pass may read, as an inline snippet does.
    pub resources: Vec<Resource<'a>>,
    /// Buffers that passes read and write. [`FramePass::scratch`] says which pass uses which.
    pub scratch: Vec<Scratch>,
    /// The passes, at least one.
    pub passes: Vec<FramePass<'a>>,
    /// The scratch buffer that holds the frame at the end: the bits of one `f32` per sample, in data units, x fastest,
    /// channels interleaved. Words beyond the frame are ignored.
    pub result: &'static str,
}

/// A buffer of 32-bit words on the device. It exists while a frame is decoded. It begins as zeros or as an earlier
/// decode left it, so a pass must not read words that no pass has written.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Scratch {
    /// Name that [`ScratchUse`] and [`FramePasses::result`] refer to.
    pub name: &'static str,
    /// Number of words, at least one. The generator may split the buffer over several bindings. Passes do not see this.
    pub words: u64,
}

/// One compute pass: `workgroups` workgroups of a module's entry point.
///
/// The module declares one entry point, `@compute @workgroup_size(..) fn <id>_<entry>(..)`, of at most 256 invocations
/// (64 along z). All its names begin with `<id>_`. It has no `@group`. At module scope, its only `var`s are
/// `var<workgroup>`, at most 16 KiB in sum, which every WebGPU device offers. An index beyond the end of a buffer reads
/// or writes an arbitrary word of it. Invocations of one pass run in any order. An invocation may read what another one
/// wrote only in its own workgroup and behind a barrier.
#[derive(Clone, Debug)]
pub struct FramePass<'a> {
    /// File, text and constants. Passes may share a text and differ only in constants.
    pub module: WgslModule<'a>,
    /// Entry point, without the codec's prefix.
    pub entry: &'static str,
    /// Workgroups along x, y and z, each at least one.
    pub workgroups: [u32; 3],
    /// The scratch buffers of this pass, each at most once, under the names that the module uses. Passes that alternate
    /// between two buffers can therefore share a text.
    pub scratch: Vec<ScratchUse>,
}

/// A scratch buffer in a pass. The module reads it with `<id>_<name>(i: u32) -> u32` and writes it with
/// `<id>_set_<name>(i: u32, word: u32)`.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct ScratchUse {
    /// Name in the module, without the codec's prefix. `frame`, `resolution` and `stages` are taken: passes may call
    /// them, as snippets may.
    pub name: &'static str,
    /// [`Scratch::name`].
    pub buffer: &'static str,
}

/// The agreement that a decoder states for the site *deferred*: that of its passes, else that of its snippet, else
/// `None`.
#[must_use]
pub fn deferred_agreement(decoder: &dyn Decoder) -> Option<Agreement> {
    let passes = decoder.frame_decode().map(FrameDecode::agreement);
    passes.or_else(|| decoder.shader().map(ShaderDecode::agreement))
}
