//! The JSON spec in a container's metadata.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::codec::{EncodeReport, Settings};
use crate::volume::{Replaced, VolumeLayout};

/// Version of the container format; see `docs/codec-author/format.md`.
pub const FORMAT_VERSION: u32 = 1;

/// Element type of a tensor.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Element {
    /// Bytes.
    U8,
    /// 16-bit words.
    U16,
    /// 32-bit words.
    U32,
    /// IEEE single.
    F32,
}

impl Element {
    /// Bytes per element.
    #[must_use]
    pub const fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// Name in the safetensors header.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::U8 => "U8",
            Self::U16 => "U16",
            Self::U32 => "U32",
            Self::F32 => "F32",
        }
    }
}

/// One tensor in the spec.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TensorSpec {
    /// Element type.
    pub element: Element,
    /// Slowest axis first, as safetensors has it.
    pub shape: Vec<u64>,
    /// crc32c (Castagnoli) of the tensor's bytes.
    pub crc32c: u32,
}

/// The metadata in a container.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spec {
    /// `FORMAT_VERSION`.
    pub format_version: u32,
    /// Codec id.
    pub codec: String,
    /// Version of the codec's stream.
    pub stream_version: u32,
    /// Shape of the volume.
    pub layout: VolumeLayout,
    /// Settings of the encoder, only for the record. Decoding uses `parameters`.
    pub settings: Settings,
    /// All parameters that the decoder needs. The codec defines their form.
    pub parameters: serde_json::Value,
    /// The encoder's promises.
    pub report: EncodeReport,
    /// Samples replaced before encoding.
    pub replaced: Replaced,
    /// Tensors by name.
    pub tensors: BTreeMap<String, TensorSpec>,
}
