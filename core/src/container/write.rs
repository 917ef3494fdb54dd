//! Writing a container. Tensors of unknown length go to temporary files first. The header is written in front of them
//! at the end. The file gets its name only when it is complete.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::spec::FORMAT_VERSION;
use super::{ContainerError, Element, Spec, TensorSpec, header};
use crate::codec::{CodecInfo, EncodeReport, Settings};
use crate::file::{folder_of, scratch_folder, write_whole};
use crate::volume::{Replaced, VolumeLayout};

/// Where an encoder writes its tensors.
pub trait StreamWriter {
    /// Appends bytes (little-endian elements) to a tensor, which the first call creates.
    ///
    /// # Errors
    /// When the name is malformed, the element type changes, or writing fails.
    fn append(&mut self, tensor: &str, element: Element, bytes: &[u8]) -> Result<(), ContainerError>;

    /// Sets the shape of a tensor, slowest axis first. Without this call it has one axis.
    ///
    /// # Errors
    /// When the tensor does not exist.
    fn shape(&mut self, tensor: &str, shape: &[u64]) -> Result<(), ContainerError>;

    /// Sets the decode parameters.
    fn parameters(&mut self, parameters: serde_json::Value);
}

impl dyn StreamWriter + '_ {
    /// Appends 32-bit words.
    ///
    /// # Errors
    /// As [`StreamWriter::append`].
    pub fn append_words(&mut self, tensor: &str, words: &[u32]) -> Result<(), ContainerError> {
        self.append(tensor, Element::U32, bytemuck::cast_slice(words))
    }

    /// Sets the decode parameters from a serialisable struct.
    ///
    /// # Errors
    /// When it does not serialise to JSON.
    pub fn parameters_of<T: Serialize>(&mut self, parameters: &T) -> Result<(), ContainerError> {
        let value = serde_json::to_value(parameters)
            .map_err(|e| ContainerError::Parameters { codec: String::new(), problem: e.to_string() })?;
        self.parameters(value);
        Ok(())
    }
}

/// What [`ContainerWriter::finish`] has written.
#[derive(Clone, Debug)]
pub struct Written {
    /// The file.
    pub path: PathBuf,
    /// Its length, header and padding included.
    pub file_bytes: u64,
}

/// A tensor while it grows, in an unnamed temporary file.
struct Spool {
    element: Element,
    shape: Option<Vec<u64>>,
    bytes: u64,
    crc32c: u32,
    file: BufWriter<File>,
}

/// Writes one container.
pub struct ContainerWriter {
    path: PathBuf,
    /// Where tensors are spooled.
    folder: PathBuf,
    parameters: serde_json::Value,
    spools: BTreeMap<String, Spool>,
}

impl ContainerWriter {
    /// Starts a container for `path`. No file has that name before [`ContainerWriter::finish`].
    ///
    /// # Errors
    /// When the folder does not exist.
    pub fn create(path: &Path) -> Result<Self, ContainerError> {
        let folder = folder_of(path);
        if !folder.is_dir() {
            let problem = format!("the folder {} does not exist", folder.display());
            return Err(ContainerError::Malformed { path: path.display().to_string(), problem });
        }
        let folder = scratch_folder(path)
            .map_err(|source| ContainerError::Io { path: path.display().to_string(), source })?;
        let parameters = serde_json::Value::Null;
        Ok(Self { path: path.to_owned(), folder, parameters, spools: BTreeMap::new() })
    }

    fn io(&self, source: std::io::Error) -> ContainerError {
        ContainerError::Io { path: self.path.display().to_string(), source }
    }

    /// Writes header and tensors to a temporary file in the same folder, syncs it and renames it into place.
    ///
    /// # Errors
    /// When a shape contradicts its tensor's length, or writing fails; nothing is left behind then.
    pub fn finish(
        mut self,
        codec: &CodecInfo,
        layout: &VolumeLayout,
        settings: &Settings,
        report: &EncodeReport,
        replaced: Replaced,
    ) -> Result<Written, ContainerError> {
        let spec = Spec {
            format_version: FORMAT_VERSION,
            codec: codec.id.to_owned(),
            stream_version: codec.stream_version,
            layout: layout.clone(),
            settings: settings.clone(),
            parameters: std::mem::take(&mut self.parameters),
            report: report.clone(),
            replaced,
            tensors: self.tensor_specs()?,
        };
        let malformed =
            |problem| ContainerError::Malformed { path: self.path.display().to_string(), problem };
        let head = header::encode(&spec).map_err(malformed)?;
        let mut file_bytes = head.len() as u64;
        let spools = std::mem::take(&mut self.spools);
        file_bytes += spools.values().map(|s| s.bytes).sum::<u64>();
        write_whole(&self.path, |out| {
            out.write_all(&head)?;
            for spool in spools.into_values() {
                let mut tensor = spool.file.into_inner().map_err(std::io::IntoInnerError::into_error)?;
                tensor.rewind()?;
                std::io::copy(&mut tensor.take(spool.bytes), out)?;
            }
            Ok(())
        })
        .map_err(|e: std::io::Error| self.io(e))?;
        Ok(Written { path: self.path, file_bytes })
    }

    fn tensor_specs(&self) -> Result<BTreeMap<String, TensorSpec>, ContainerError> {
        let spec = |(name, spool): (&String, &Spool)| {
            let count = spool.bytes / spool.element.bytes() as u64;
            let shape = spool.shape.clone().unwrap_or_else(|| vec![count]);
            if header::tensor_bytes(spool.element, &shape) != Some(spool.bytes) {
                let problem = format!("{count} elements written do not fill the shape {shape:?}");
                return Err(ContainerError::Tensor { name: name.clone(), problem });
            }
            Ok((name.clone(), TensorSpec { element: spool.element, shape, crc32c: spool.crc32c }))
        };
        self.spools.iter().map(spec).collect()
    }
}

impl StreamWriter for ContainerWriter {
    fn append(&mut self, tensor: &str, element: Element, bytes: &[u8]) -> Result<(), ContainerError> {
        let fail = |problem: String| Err(ContainerError::Tensor { name: tensor.to_owned(), problem });
        if !tensor.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
            || tensor.is_empty()
        {
            return fail("tensor names are lower-case letters, digits and `_`".to_owned());
        }
        if !bytes.len().is_multiple_of(element.bytes()) {
            return fail(format!("{} bytes are no whole number of {} elements", bytes.len(), element.name()));
        }
        if !self.spools.contains_key(tensor) {
            let file = BufWriter::new(tempfile::tempfile_in(&self.folder).map_err(|e| self.io(e))?);
            let spool = Spool { element, shape: None, bytes: 0, crc32c: 0, file };
            self.spools.insert(tensor.to_owned(), spool);
        }
        let path = &self.path;
        let Some(spool) = self.spools.get_mut(tensor) else { return fail("vanished".to_owned()) };
        if spool.element != element {
            return fail(format!("is {}, not {}", spool.element.name(), element.name()));
        }
        spool.crc32c = crc32c::crc32c_append(spool.crc32c, bytes);
        spool.bytes += bytes.len() as u64;
        spool
            .file
            .write_all(bytes)
            .map_err(|source| ContainerError::Io { path: path.display().to_string(), source })
    }

    fn shape(&mut self, tensor: &str, shape: &[u64]) -> Result<(), ContainerError> {
        let known = self.spools.keys().cloned().collect::<Vec<_>>().join(", ");
        let missing = ContainerError::MissingTensor { name: tensor.to_owned(), known };
        self.spools.get_mut(tensor).ok_or(missing)?.shape = Some(shape.to_vec());
        Ok(())
    }

    fn parameters(&mut self, parameters: serde_json::Value) {
        self.parameters = parameters;
    }
}
