//! Tampered containers of every codec with correct checksums: decoders meet data that no encoder wrote. They refuse, or
//! return finite values of the promised size.

use std::collections::BTreeMap;
use std::sync::Arc;

use cvr::registry;
use cvr_core::codec::{Codec, Settings, decode_stages, encode_file};
use cvr_core::container::EncodedVolume;
use cvr_core::volume::{FrameIndex, NoReferences, SampleType};
use serde_json::{Value, json};

use super::super::volumes::varied;
use super::mutate::{self, Dice, campaign};

/// Largest volume that is decoded. A container with a larger one is only opened.
const MOST_SAMPLES: u64 = 1 << 18;
/// Largest volume for which a decoder is made. Some decoders prepare tables of its size.
const MOST_OPENED: u64 = 1 << 24;

/// A container in parts, which can be changed and put together again.
#[derive(Clone)]
struct Parts {
    spec: Value,
    tensors: BTreeMap<String, Vec<u8>>,
}

impl Parts {
    fn of(file: &[u8]) -> Self {
        let length = u64::from_le_bytes(file[..8].try_into().unwrap()) as usize;
        let header: Value = serde_json::from_slice(&file[8..8 + length]).unwrap();
        let spec: Value = serde_json::from_str(header["__metadata__"]["cvr"].as_str().unwrap()).unwrap();
        let mut tensors = BTreeMap::new();
        for (name, entry) in header.as_object().unwrap().iter().filter(|(name, _)| *name != "__metadata__") {
            let offset = |i: usize| 8 + length + entry["data_offsets"][i].as_u64().unwrap() as usize;
            tensors.insert(name.clone(), file[offset(0)..offset(1)].to_vec());
        }
        Self { spec, tensors }
    }

    /// The file. Its checksums and its table of tensors are corrected for its content.
    fn file(mut self) -> Vec<u8> {
        let mut at = 0;
        let (mut table, mut data) = (serde_json::Map::new(), Vec::new());
        for (name, bytes) in &self.tensors {
            if let Some(tensor) = tensor_of(&mut self.spec, name) {
                tensor["crc32c"] = crc32c::crc32c(bytes).into();
                let (dtype, shape) = (tensor["element"].clone(), tensor["shape"].clone());
                let end = at + bytes.len();
                table.insert(
                    name.clone(),
                    json!({ "dtype": dtype, "shape": shape, "data_offsets": [at, end] }),
                );
                data.extend_from_slice(bytes);
                at = end;
            }
        }
        let spec = self.spec.to_string();
        let crc = format!("{:08x}", crc32c::crc32c(spec.as_bytes()));
        table.insert("__metadata__".to_owned(), json!({ "cvr": spec, "cvr_crc32c": crc }));
        let mut header = Value::Object(table).to_string().into_bytes();
        let padded = (8 + header.len()).next_multiple_of(2048) - 8;
        header.resize(padded, b' ');
        [&(padded as u64).to_le_bytes()[..], &header, &data].concat()
    }

    /// One to three edits: of parameters and layout, or of content and length of tensors.
    fn edit(&mut self, dice: &mut Dice) {
        for _ in 0..=dice.below(3) {
            match dice.below(8) {
                0 => mutate::json(dice, &mut self.spec),
                1 => edit_field(dice, &mut self.spec, "layout"),
                2 | 3 => edit_field(dice, &mut self.spec, "parameters"),
                _ => self.edit_tensor(dice),
            }
        }
    }

    fn edit_tensor(&mut self, dice: &mut Dice) {
        let Some(name) = self.tensors.keys().nth(dice.below(self.tensors.len())).cloned() else { return };
        let bytes = self.tensors.get_mut(&name).unwrap();
        if bytes.is_empty() {
            return;
        }
        let word = dice.below(bytes.len()) & !3;
        let end = bytes.len().min(word + 4);
        match dice.below(6) {
            0 => bytes[word] ^= 1 << dice.below(8),
            1 => bytes[word..end].fill(*dice.pick(&[0, 0x7f, 0x80, 0xff])),
            2 => bytes[word..].fill(0xff),
            3 => {
                // Infinity, NaN, and the largest number, as singles.
                let value = dice
                    .pick(&[0x7f80_0000_u32, 0xff80_0000, 0x7fc0_0000, 0x7f7f_ffff, 0xff7f_ffff, 1])
                    .to_le_bytes();
                bytes[word..end].copy_from_slice(&value[..end - word]);
            }
            4 => (0..1 + dice.below(32)).for_each(|_| {
                let at = dice.below(bytes.len());
                bytes[at] = dice.roll() as u8;
            }),
            _ => {
                // Another length, which is also written into the spec.
                let element = self.spec["tensors"][&name]["element"].as_str().unwrap_or("U8");
                let size = match element {
                    "U8" => 1,
                    "U16" => 2,
                    _ => 4,
                };
                let more = size * (1 + dice.below(8));
                let length =
                    if dice.below(2) == 0 { bytes.len().saturating_sub(more) } else { bytes.len() + more };
                bytes.resize(length / size * size, 0xa5);
                let elements = bytes.len() / size;
                if let Some(tensor) = tensor_of(&mut self.spec, &name) {
                    tensor["shape"] = json!([elements]);
                }
            }
        }
    }
}

/// The entry of a tensor in the spec, if it is still there.
fn tensor_of<'s>(spec: &'s mut Value, name: &str) -> Option<&'s mut Value> {
    spec.get_mut("tensors")?.get_mut(name).filter(|tensor| tensor.is_object())
}

fn edit_field(dice: &mut Dice, spec: &mut Value, name: &str) {
    if let Some(field) = spec.get_mut(name) {
        mutate::json(dice, field);
    }
}

/// Valid containers: every codec that needs no command, settings with different forms of streams, and several layouts.
fn streams() -> Vec<(Arc<dyn Codec>, Parts)> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.cvr");
    let variants: &[(&str, &[&str])] = &[
        ("bc4", &[""]),
        ("hvq", &["", "codeword_bits=16", "tables=per-frame"]),
        ("raw", &["", "bits=8", "bits=half"]),
        ("rvq", &["codewords=9", "entries=16 stages=2 codewords=16 tables=per-frame"]),
        ("s3dc", &["block=4", "block=3x5x2 index_bits=8"]),
        ("tvq", &["", "payload=variable", "payload=variable psnr=60"]),
        ("vq", &["block=2", "block=4 codeword_bits=16"]),
        (
            "wavelet",
            &[
                "decompositions=2",
                "coder=runs order=octree decompositions=2 quality=200 quant_scale=printed filter=coiflet-6",
                "coder=deflate filter=haar decompositions=3",
                "coder=arithmetic filter=5-3 decompositions=2",
                "coder=zerotree filter=cdf-2-6 decompositions=2",
                "max_error=1.5 decompositions=2",
                "block=8 filter=haar",
                "block=16 filter=5-3 bits_per_voxel=24",
            ],
        ),
        ("zfp", &["", "rate=1.1"]),
    ];
    let codecs = registry::codecs().unwrap();
    let without_command = codecs.iter().filter(|codec| codec.info().id != "external").count();
    assert_eq!(variants.len(), without_command, "a codec has no hostile container");
    let mut all = Vec::new();
    for (id, list) in variants {
        let codec = codecs.get(id).unwrap();
        for (i, text) in list.iter().enumerate() {
            let pairs = text.split_whitespace().map(|pair| pair.split_once('=').unwrap());
            let given: Settings = pairs.map(|(name, value)| (name.to_owned(), value.into())).collect();
            let settings = codec.info().complete(&given).unwrap();
            for (size, sample, channels) in [
                ([9, 7, 6], SampleType::U8, 1),
                ([6, 5, 8], SampleType::F32, 1),
                ([5, 6, 4], SampleType::I16, 3),
            ] {
                if i > 0 && channels > 1 {
                    continue;
                }
                let volume = varied(size, sample, channels);
                let run = cvr_core::codec::Progress::silent();
                match encode_file(codec.as_ref(), &settings, &volume, volume.replaced(), &path, &run) {
                    Ok(_) => all.push((codec.clone(), Parts::of(&std::fs::read(&path).unwrap()))),
                    Err(error) => println!("{id} {text} refuses {size:?} {sample}: {error}"),
                }
            }
        }
    }
    for (_, parts) in &all {
        std::fs::write(&path, parts.clone().file()).unwrap();
        EncodedVolume::open(&path).unwrap();
    }
    all
}

#[test]
fn no_container_panics_or_decodes_to_what_is_not_finite() {
    let (streams, folder) = (streams(), tempfile::tempdir().unwrap());
    let path = folder.path().join("v.cvr");
    campaign("containers", 3000, |mut dice: Dice| {
        let (codec, parts) = dice.pick(&streams);
        let mut parts = parts.clone();
        parts.edit(&mut dice);
        std::fs::write(&path, parts.file()).unwrap();
        decodes(codec.as_ref(), &path).map_err(|problem| format!("{}: {problem}", codec.info().id))
    });
}

/// Whether a container is accepted. The error says which rule its decoded values break.
fn decodes(codec: &dyn Codec, path: &std::path::Path) -> Result<bool, String> {
    let Ok(stream) = EncodedVolume::open(path) else { return Ok(false) };
    if stream.spec().layout.samples() > MOST_OPENED {
        return Ok(false);
    }
    let Ok(decoder) = codec.decoder(Arc::new(stream)) else { return Ok(false) };
    let layout = decoder.layout().clone();
    if let Some(shader) = decoder.shader() {
        let _ = shader.resources(FrameIndex::FIRST);
    }
    if layout.samples() > MOST_SAMPLES {
        return Ok(true);
    }
    for frame in (0..layout.frames).map(FrameIndex) {
        let Ok(values) = decode_stages(decoder.as_ref(), frame, u8::MAX, &NoReferences) else {
            return Ok(false);
        };
        if values.len() as u64 != layout.samples_per_frame() {
            return Err(format!("{} values of {}", values.len(), layout.samples_per_frame()));
        }
        if let Some(i) = values.iter().position(|v| !v.is_finite()) {
            return Err(format!("sample {i} of frame {} is {}", frame.0, values[i]));
        }
    }
    Ok(true)
}
