//! A decoder with a wrong shader, for tests that must detect it.

use std::borrow::Cow;
use std::sync::Arc;

use cvr_core::codec::{
    Agreement, Block, BlockTexture, Codec, CodecInfo, ConfigError, DecodeError, DecodedBy, DecodedForm,
    Decoder, Encoder, FrameDecode, FramePasses, Resource, Settings, ShaderDecode, WgslModule,
};
use cvr_core::container::EncodedVolume;
use cvr_core::volume::{
    BrickKey, Dependencies, FrameIndex, Level, ReferenceFrames, ValueRange, VolumeLayout,
};

/// The change of the shader. The CPU decoder is unchanged.
#[derive(Clone, Debug)]
pub enum Mutation {
    /// This text instead of the snippet.
    Snippet(String),
    /// One bit of a resource is flipped.
    Bit {
        /// Index of the resource.
        resource: usize,
        /// Its word.
        word: usize,
        /// The bit.
        bit: u32,
    },
}

/// A decoder with a mutated shader.
#[derive(Debug)]
pub struct Mutated {
    /// The right one.
    pub inner: Box<dyn Decoder>,
    /// The mutation.
    pub mutation: Mutation,
}

/// A codec whose decoders have a wrong snippet, or wrong passes if they have no snippet: `from`, which must occur, is
/// replaced by `to`.
#[derive(Debug)]
pub struct MutatedCodec {
    /// The right one.
    pub inner: Arc<dyn Codec>,
    /// The text to replace.
    pub from: &'static str,
    /// By what.
    pub to: &'static str,
}

impl Codec for MutatedCodec {
    fn info(&self) -> &CodecInfo {
        self.inner.info()
    }

    fn stages(&self, settings: &Settings) -> u8 {
        self.inner.stages(settings)
    }

    fn resolutions(&self, settings: &Settings) -> u8 {
        self.inner.resolutions(settings)
    }

    fn block(&self, settings: &Settings) -> Option<Block> {
        self.inner.block(settings)
    }

    fn decoded_by(&self, settings: &Settings) -> &'static [DecodedBy] {
        self.inner.decoded_by(settings)
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        self.inner.encoder(settings)
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        let inner = self.inner.decoder(volume)?;
        Ok(match inner.shader() {
            Some(_) => Box::new(Mutated::snippet(inner, self.from, self.to)),
            None => Box::new(MutatedPasses { inner, from: self.from, to: self.to }),
        })
    }
}

impl Mutated {
    /// A snippet in which `from`, which must occur, reads `to`.
    #[must_use]
    pub fn snippet(inner: Box<dyn Decoder>, from: &str, to: &str) -> Self {
        let source = inner.shader().unwrap().module().source.to_owned();
        assert!(source.contains(from), "the snippet has changed: it holds no `{from}`");
        Self { inner, mutation: Mutation::Snippet(source.replace(from, to)) }
    }

    fn real(&self) -> &dyn ShaderDecode {
        self.inner.shader().unwrap()
    }
}

impl Decoder for Mutated {
    fn layout(&self) -> &VolumeLayout {
        self.inner.layout()
    }

    fn dependencies(&self, frame: FrameIndex) -> Dependencies {
        self.inner.dependencies(frame)
    }

    fn decode_brick(
        &self,
        key: BrickKey,
        references: &dyn ReferenceFrames,
        out: &mut [f32],
    ) -> Result<(), DecodeError> {
        self.inner.decode_brick(key, references, out)
    }

    fn value_range(&self, key: BrickKey) -> Option<ValueRange> {
        self.inner.value_range(key)
    }

    fn decoded_form(&self) -> DecodedForm {
        self.inner.decoded_form()
    }

    fn shader(&self) -> Option<&dyn ShaderDecode> {
        Some(self)
    }

    fn block_texture(&self, frame: FrameIndex, level: Level) -> Option<BlockTexture<'_>> {
        let blocks = self.inner.block_texture(frame, level)?;
        let words = match self.mutation {
            Mutation::Bit { .. } => self.resources(frame).unwrap().remove(0).words,
            Mutation::Snippet(_) => blocks.words,
        };
        Some(BlockTexture { words, ..blocks })
    }
}

impl ShaderDecode for Mutated {
    fn module(&self) -> WgslModule<'_> {
        let module = self.real().module();
        match &self.mutation {
            Mutation::Snippet(source) => WgslModule { source, ..module },
            Mutation::Bit { .. } => module,
        }
    }

    fn agreement(&self) -> Agreement {
        self.real().agreement()
    }

    fn resources(&self, frame: FrameIndex) -> Result<Vec<Resource<'_>>, DecodeError> {
        let mut resources = self.real().resources(frame)?;
        if let Mutation::Bit { resource, word, bit } = self.mutation {
            let words: &mut Cow<'_, [u32]> = &mut resources[resource].words;
            words.to_mut()[word] ^= 1 << bit;
        }
        Ok(resources)
    }
}

/// A decoder whose passes are wrong: `from`, which must occur in one of them, is replaced by `to`.
#[derive(Debug)]
struct MutatedPasses {
    inner: Box<dyn Decoder>,
    from: &'static str,
    to: &'static str,
}

impl Decoder for MutatedPasses {
    fn layout(&self) -> &VolumeLayout {
        self.inner.layout()
    }

    fn decode_brick(
        &self,
        key: BrickKey,
        references: &dyn ReferenceFrames,
        out: &mut [f32],
    ) -> Result<(), DecodeError> {
        self.inner.decode_brick(key, references, out)
    }

    fn value_range(&self, key: BrickKey) -> Option<ValueRange> {
        self.inner.value_range(key)
    }

    fn decoded_form(&self) -> DecodedForm {
        self.inner.decoded_form()
    }

    fn frame_decode(&self) -> Option<&dyn FrameDecode> {
        Some(self)
    }
}

impl FrameDecode for MutatedPasses {
    fn passes(&self, frame: FrameIndex, level: Level) -> Result<FramePasses<'_>, DecodeError> {
        let mut passes = self.inner.frame_decode().unwrap().passes(frame, level)?;
        let all = passes.passes.iter_mut();
        let changed = all.filter(|pass| pass.module.source.contains(self.from)).map(|pass| {
            // A few texts of a test may stay in memory until it ends.
            pass.module.source = String::leak(pass.module.source.replace(self.from, self.to));
        });
        // Coarse resolutions may need other passes.
        assert!(
            changed.count() > 0 || level.resolution > 0,
            "the passes have changed: none holds `{}`",
            self.from
        );
        Ok(passes)
    }

    fn agreement(&self) -> Agreement {
        self.inner.frame_decode().unwrap().agreement()
    }
}
