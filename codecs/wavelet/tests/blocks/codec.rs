//! A codec of the block mode alone.

use std::sync::Arc;

use cvr_codec_tests::settings;
use cvr_core::codec::{
    Block, Codec, CodecInfo, ConfigError, DecodeError, DecodedBy, Decoder, EncodeError, EncodeReport,
    Encoder, Progress, Setting, SettingKind, Settings, check_stream, decode_frame, encode_temporary,
};
use cvr_core::container::{EncodedVolume, StreamWriter};
use cvr_core::volume::{BrickSource, FiniteVolume, FrameIndex, NoReferences};
use cvr_wavelet::blocks::{Filter, Options, Reader, Target, encode};

const INFO: CodecInfo = CodecInfo {
    id: "wavelet",
    summary: "blocks alone",
    stream_version: 1,
    decoded_by: &[DecodedBy::Shader, DecodedBy::Cpu],
    fetch_cell: true,
    paper: None,
    settings: &[
        Setting { name: "block", doc: "voxels", kind: SettingKind::OneOf(&[8, 16]), default: "8" },
        Setting {
            name: "filter",
            doc: "filters",
            kind: SettingKind::Choice(&["haar", "5-3"]),
            default: "haar",
        },
        Setting {
            name: "target",
            doc: "what to aim at",
            kind: SettingKind::Choice(&["rate", "psnr", "max_error", "lossless"]),
            default: "rate",
        },
        Setting {
            name: "value",
            doc: "bits per voxel, dB, or data units",
            kind: SettingKind::Float { min: 0.0, max: 1e30 },
            default: "4",
        },
    ],
    methods: &[],
};

/// The codec.
#[derive(Debug)]
pub struct Blocks;

#[derive(Debug)]
struct OfOptions(Options);

impl Encoder for OfOptions {
    fn encode(
        &mut self,
        source: &dyn BrickSource,
        out: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        encode(&self.0, source, out, run)
    }
}

impl Codec for Blocks {
    fn info(&self) -> &CodecInfo {
        &INFO
    }

    fn block(&self, settings: &Settings) -> Option<Block> {
        settings.integer("block").ok()?.to_string().parse().ok()
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        let value = settings.float("value")?;
        let target = match settings.text("target")? {
            "rate" => Target::BitsPerVoxel(value),
            "psnr" => Target::Psnr(value),
            "max_error" => Target::MaxError(value),
            _ => Target::Lossless,
        };
        let filter = if settings.text("filter")? == "haar" { Filter::Haar } else { Filter::FiveThree };
        Ok(Box::new(OfOptions(Options { block: settings.integer("block")? as u32, filter, target })))
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        check_stream(&volume, &INFO)?;
        Ok(Box::new(Reader::open(&volume)?))
    }
}

/// Both filters with both block sizes.
pub const METHODS: [(&str, &str); 4] = [("haar", "8"), ("haar", "16"), ("5-3", "8"), ("5-3", "16")];

pub fn of((filter, block): (&str, &str), target: &str, value: &str) -> Settings {
    let value = if target == "lossless" { "0" } else { value };
    settings(&[("filter", filter), ("block", block), ("target", target), ("value", value)])
}

pub fn encoded(volume: &FiniteVolume, settings: &Settings) -> Result<Arc<EncodedVolume>, EncodeError> {
    encode_temporary(&Blocks, settings, volume).map(Arc::new)
}

/// All frames, one after another.
pub fn decoded(stream: &Arc<EncodedVolume>) -> Vec<f32> {
    let decoder = Blocks.decoder(Arc::clone(stream)).unwrap();
    let frames = (0..decoder.layout().frames).map(FrameIndex);
    frames.flat_map(|f| decode_frame(decoder.as_ref(), f, &NoReferences).unwrap()).collect()
}

pub fn source(volume: &FiniteVolume) -> Vec<f32> {
    (0..volume.layout().frames).flat_map(|f| volume.dense().frame_values(FrameIndex(f))).collect()
}
