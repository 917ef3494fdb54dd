//! S3Dc: one minimum and one maximum per block, and a short index per voxel between them.
//!
//! After H. Yela, I. Navazo and P.-P. Vázquez, CEIG 2008. This crate's README.md specifies the stream and the
//! equations, and lists the differences from the paper.

pub mod decode;
mod encode;
mod endpoint;
mod geometry;
mod reader;

use std::sync::Arc;

use cvr_core::codec::{
    Codec, CodecInfo, ConfigError, DecodeError, DecodedBy, Decoder, Encoder, Paper, Setting, SettingKind,
    Settings,
};
use cvr_core::container::EncodedVolume;

pub use endpoint::Endpoint;
pub use geometry::Geometry;

/// Tensor and shader resource: the MinMax volume.
const MINMAX: &str = "minmax";
/// Tensor and shader resource: the Index volume.
const INDEX: &str = "index";

static INFO: CodecInfo = CodecInfo {
    id: "s3dc",
    summary: "block minimum and maximum, and 1, 2, 4 or 8 bits per voxel between them",
    stream_version: 1,
    decoded_by: &[DecodedBy::Shader, DecodedBy::Cpu],
    fetch_cell: true,
    paper: Some(Paper {
        authors: "H. Yela, I. Navazo, P.-P. Vázquez",
        title: "S3Dc: A 3Dc-based Volume Compression Algorithm",
        venue: "CEIG 2008",
    }),
    settings: &[
        Setting {
            name: "block",
            doc: "size in voxels of the block that shares one minimum and one maximum",
            kind: SettingKind::Block { max: 128 },
            default: "16",
        },
        Setting {
            name: "index_bits",
            doc: "bits of the index per voxel: 2^index_bits levels between minimum and maximum",
            kind: SettingKind::OneOf(&[1, 2, 4, 8]),
            default: "4",
        },
    ],
    methods: &[],
};

/// The codec `s3dc`.
#[derive(Copy, Clone, Debug, Default)]
pub struct S3dc;

/// The codec, as a registry takes it.
#[must_use]
pub fn codec() -> Arc<dyn Codec> {
    Arc::new(S3dc)
}

impl Codec for S3dc {
    fn info(&self) -> &CodecInfo {
        &INFO
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        let index_bits = settings.integer("index_bits")?;
        let index_bits =
            u32::try_from(index_bits).map_err(|_| ConfigError::Incomplete("index_bits".to_owned()))?;
        Ok(Box::new(encode::S3dcEncoder { block: settings.block("block")?, index_bits }))
    }

    fn decoder(&self, volume: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        Ok(Box::new(reader::Reader::open(&volume)?))
    }
}
