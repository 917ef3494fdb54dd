//! Byte layout: `u64` header length, the JSON header padded with spaces to a reserved width, the tensors.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::spec::Spec;

/// The header is padded to a multiple of this many bytes, length word included. Tensors begin there.
pub const RESERVED: usize = 2048;

/// Largest header that a reader accepts. It guards against a wrong length word.
pub const MAX_HEADER: u64 = 16 << 20;

/// Metadata key of the spec.
pub const SPEC_KEY: &str = "cvr";
/// Metadata key of the spec's crc32c, eight hexadecimal digits.
pub const SPEC_CRC_KEY: &str = "cvr_crc32c";

/// The safetensors header.
#[derive(Serialize, Deserialize)]
pub struct Header {
    /// Free text by safetensors' rules: string to string.
    #[serde(rename = "__metadata__")]
    pub metadata: BTreeMap<String, String>,
    /// Tensors by name.
    #[serde(flatten)]
    pub tensors: BTreeMap<String, Entry>,
}

/// One tensor in the safetensors header.
#[derive(Serialize, Deserialize, PartialEq, Debug)]
pub struct Entry {
    /// Element type name.
    pub dtype: String,
    /// Slowest axis first.
    pub shape: Vec<u64>,
    /// Begin and end in the data section.
    pub data_offsets: [u64; 2],
}

/// Bytes of a tensor. `None` if the shape overflows.
pub fn tensor_bytes(element: super::Element, shape: &[u64]) -> Option<u64> {
    shape.iter().try_fold(element.bytes() as u64, |n, &s| n.checked_mul(s))
}

/// The header bytes, length word included, padded to a multiple of [`RESERVED`]. Tensors are in the order of their
/// names.
pub fn encode(spec: &Spec) -> Result<Vec<u8>, String> {
    let json = serde_json::to_string(spec).map_err(|e| e.to_string())?;
    let crc = format!("{:08x}", crc32c::crc32c(json.as_bytes()));
    let mut at = 0;
    let mut tensors = BTreeMap::new();
    for (name, tensor) in &spec.tensors {
        let bytes = tensor_bytes(tensor.element, &tensor.shape).ok_or("a tensor is too large")?;
        let entry = Entry {
            dtype: tensor.element.name().to_owned(),
            shape: tensor.shape.clone(),
            data_offsets: [at, at + bytes],
        };
        at += bytes;
        tensors.insert(name.clone(), entry);
    }
    let metadata = [(SPEC_KEY.to_owned(), json), (SPEC_CRC_KEY.to_owned(), crc)].into();
    let text = serde_json::to_string(&Header { metadata, tensors }).map_err(|e| e.to_string())?;
    let padded = (8 + text.len()).next_multiple_of(RESERVED);
    let mut bytes = Vec::with_capacity(padded);
    bytes.extend_from_slice(&((padded - 8) as u64).to_le_bytes());
    bytes.extend_from_slice(text.as_bytes());
    bytes.resize(padded, b' ');
    Ok(bytes)
}
