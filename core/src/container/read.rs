//! Reading a container. Lengths and checksums are checked before the data is used.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::de::DeserializeOwned;

use super::spec::FORMAT_VERSION;
use super::{ContainerError, Element, Spec, header};
use crate::memory::{self, Held};

/// One tensor in memory. Clones share the bytes, so a decoder can keep its tensors at no cost.
#[derive(Clone, Debug)]
pub struct Tensor {
    /// Element type.
    pub element: Element,
    /// Slowest axis first.
    pub shape: Vec<u64>,
    words: Arc<Words>,
    bytes: usize,
}

/// The bytes of a tensor in whole 32-bit words, so that they are aligned. The last word may be padded with zeros.
#[derive(Debug)]
struct Words {
    words: Vec<u32>,
    _held: Held,
}

impl Tensor {
    /// The bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.words.words)[..self.bytes]
    }

    /// The bytes as 32-bit words, the last padded with zero bytes.
    #[must_use]
    pub fn words(&self) -> &[u32] {
        &self.words.words
    }
}

/// An encoded volume in memory, checksums verified.
#[derive(Clone, Debug)]
pub struct EncodedVolume {
    path: PathBuf,
    spec: Spec,
    tensors: BTreeMap<String, Tensor>,
    file_bytes: u64,
}

impl EncodedVolume {
    /// Reads and checks a container.
    ///
    /// # Errors
    /// When the file cannot be read, is not a container, is truncated, or a checksum fails.
    pub fn open(path: &Path) -> Result<Self, ContainerError> {
        let io = |source| ContainerError::Io { path: path.display().to_string(), source };
        let bad = |problem: String| ContainerError::Malformed { path: path.display().to_string(), problem };
        let mut file = File::open(path).map_err(io)?;
        let file_bytes = file.metadata().map_err(io)?.len();
        let (spec, data) = read_header(&mut file, file_bytes).map_err(bad)?;
        let memory = |source| ContainerError::Memory { path: path.display().to_string(), source };
        memory::check(file_bytes.saturating_sub(data), || "the encoded stream".to_owned()).map_err(memory)?;
        let mut tensors = BTreeMap::new();
        let mut at = data;
        for (name, tensor) in &spec.tensors {
            let bytes = header::tensor_bytes(tensor.element, &tensor.shape)
                .filter(|b| at.checked_add(*b).is_some_and(|end| end <= file_bytes))
                .ok_or_else(|| bad(format!("truncated: tensor `{name}` ends beyond the file")))?;
            let what = || format!("tensor `{name}`");
            let mut words: Vec<u32> = memory::zeroed(bytes.div_ceil(4), what).map_err(memory)?;
            let buffer = &mut bytemuck::cast_slice_mut(&mut words)[..bytes as usize];
            file.read_exact(buffer).map_err(io)?;
            let crc = crc32c::crc32c(buffer);
            if crc != tensor.crc32c {
                let problem = format!(
                    "tensor `{name}` is damaged: its checksum is {crc:08x}, the spec says {:08x}; encode the \
                     volume again",
                    tensor.crc32c
                );
                return Err(bad(problem));
            }
            at += bytes;
            let (element, shape) = (tensor.element, tensor.shape.clone());
            let words = Arc::new(Words { _held: Held::of(&words), words });
            tensors.insert(name.clone(), Tensor { element, shape, words, bytes: bytes as usize });
        }
        if at != file_bytes {
            return Err(bad(format!("{} bytes stand behind the last tensor", file_bytes - at)));
        }
        Ok(Self { path: path.to_owned(), spec, tensors, file_bytes })
    }

    /// The spec.
    #[must_use]
    pub const fn spec(&self) -> &Spec {
        &self.spec
    }

    /// The file it was read from.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Length of the file, header and padding included.
    #[must_use]
    pub const fn file_bytes(&self) -> u64 {
        self.file_bytes
    }

    /// Bytes of all tensors: the file without its header.
    #[must_use]
    pub fn payload_bytes(&self) -> u64 {
        self.tensors.values().map(|tensor| tensor.bytes as u64).sum()
    }

    /// The tensor of this name. It must have this element type.
    ///
    /// # Errors
    /// When it is absent or of another type.
    pub fn tensor(&self, name: &str, element: Element) -> Result<&Tensor, ContainerError> {
        let tensor = self.tensors.get(name).ok_or_else(|| ContainerError::MissingTensor {
            name: name.to_owned(),
            known: self.tensors.keys().cloned().collect::<Vec<_>>().join(", "),
        })?;
        if tensor.element != element {
            let problem = format!("is {}, the codec reads {}", tensor.element.name(), element.name());
            return Err(ContainerError::Tensor { name: name.to_owned(), problem });
        }
        Ok(tensor)
    }

    /// The tensor of this name. It must have this element type and this shape (slowest axis first), which the caller
    /// computes from the layout and the parameters. A decoder that starts with this call never reads outside its
    /// tensors.
    ///
    /// # Errors
    /// When it is absent, of another type or of another shape.
    pub fn tensor_of_shape(
        &self,
        name: &str,
        element: Element,
        shape: &[u64],
    ) -> Result<&Tensor, ContainerError> {
        let tensor = self.tensor(name, element)?;
        if tensor.shape != shape {
            let problem = format!("has the shape {:?}, layout and parameters need {shape:?}", tensor.shape);
            return Err(ContainerError::Tensor { name: name.to_owned(), problem });
        }
        Ok(tensor)
    }

    /// The codec's decode parameters.
    ///
    /// # Errors
    /// When they do not parse as `T`.
    pub fn parameters<T: DeserializeOwned>(&self) -> Result<T, ContainerError> {
        serde_json::from_value(self.spec.parameters.clone()).map_err(|e| ContainerError::Parameters {
            codec: self.spec.codec.clone(),
            problem: e.to_string(),
        })
    }
}

/// Reads and checks the header. Returns the spec and the position of the tensors.
fn read_header(file: &mut File, file_bytes: u64) -> Result<(Spec, u64), String> {
    const NOT_OURS: &str = "not a cvr container (a safetensors file with a `cvr` spec)";
    let mut length = [0; 8];
    file.read_exact(&mut length).map_err(|_| format!("{NOT_OURS}: shorter than 8 bytes"))?;
    let length = u64::from_le_bytes(length);
    if length > header::MAX_HEADER {
        return Err(format!("{NOT_OURS}: it claims a header of {length} bytes"));
    }
    if 8 + length > file_bytes {
        return Err(format!("truncated: the header claims {length} bytes, the file has {file_bytes}"));
    }
    let mut text = vec![0; length as usize];
    file.read_exact(&mut text).map_err(|e| e.to_string())?;
    let head: header::Header =
        serde_json::from_slice(&text).map_err(|e| format!("{NOT_OURS}: damaged header: {e}"))?;
    let json = head.metadata.get(header::SPEC_KEY).ok_or(NOT_OURS)?;
    let crc = format!("{:08x}", crc32c::crc32c(json.as_bytes()));
    if head.metadata.get(header::SPEC_CRC_KEY) != Some(&crc) {
        return Err("the spec is damaged: its checksum does not fit; encode the volume again".to_owned());
    }
    let spec: Spec = serde_json::from_str(json).map_err(|e| format!("spec: {e}"))?;
    if spec.format_version != FORMAT_VERSION {
        return Err(format!("container format {}, this version reads {FORMAT_VERSION}", spec.format_version));
    }
    spec.layout.validate().map_err(|e| format!("spec: {e}"))?;
    let expected = header::encode(&spec)?;
    let expected: header::Header = serde_json::from_slice(&expected[8..]).map_err(|e| e.to_string())?;
    if head.tensors != expected.tensors {
        return Err("the tensor table contradicts the spec; encode the volume again".to_owned());
    }
    Ok((spec, 8 + length))
}
