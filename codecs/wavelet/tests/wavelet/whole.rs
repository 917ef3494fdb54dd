//! Streams of whole volumes that a test can tamper with.

use std::ops::Range;
use std::sync::Arc;

use cvr_core::codec::Codec as _;
use cvr_core::container::{ContainerWriter, Element, EncodedVolume, StreamWriter as _};
use cvr_wavelet::Wavelet;

/// Coder and order of all entropy coders.
pub const CODERS: [(&str, &str); 7] = [
    ("contexts", "lines"),
    ("runs", "lines"),
    ("runs", "octree"),
    ("deflate", "lines"),
    ("deflate", "octree"),
    ("arithmetic", "lines"),
    ("zerotree", "lines"),
];

/// A stream's tensors and parameters.
#[derive(Clone)]
pub struct Content {
    /// All chunks and a byte of 0.
    pub chunks: Vec<u8>,
    /// Bytes of each chunk.
    pub lengths: Vec<u32>,
    /// Steps of frames and channels, as bits of singles.
    pub steps: Vec<u32>,
    pub parameters: serde_json::Value,
}

impl Content {
    pub fn of(stream: &EncodedVolume) -> Self {
        let words = |name| stream.tensor(name, Element::U32).unwrap().words().to_vec();
        Self {
            chunks: stream.tensor("chunks", Element::U8).unwrap().bytes().to_vec(),
            lengths: words("lengths"),
            steps: words("steps"),
            parameters: stream.spec().parameters.clone(),
        }
    }

    /// A sound container of it, with the checksums of its own bytes.
    pub fn stream(&self, like: &EncodedVolume) -> Arc<EncodedVolume> {
        let (spec, folder) = (like.spec(), tempfile::tempdir().unwrap());
        let path = folder.path().join("changed.cvr");
        let mut writer = ContainerWriter::create(&path).unwrap();
        writer.append("chunks", Element::U8, &self.chunks).unwrap();
        writer.shape("chunks", &[self.chunks.len() as u64]).unwrap();
        for (name, words) in [("lengths", &self.lengths), ("steps", &self.steps)] {
            let all: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
            writer.append(name, Element::U32, &all).unwrap();
            writer.shape(name, &spec.tensors[name].shape).unwrap();
        }
        writer.parameters(self.parameters.clone());
        writer.finish(Wavelet.info(), &spec.layout, &spec.settings, &spec.report, spec.replaced).unwrap();
        Arc::new(EncodedVolume::open(&path).unwrap())
    }

    /// Places of each chunk's bytes.
    pub fn places(&self) -> Vec<Range<usize>> {
        let mut at = 0;
        let place = |length: &u32| {
            at += *length as usize;
            at - *length as usize..at
        };
        self.lengths.iter().map(place).collect()
    }
}
