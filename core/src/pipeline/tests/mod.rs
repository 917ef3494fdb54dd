//! Tests from text to cells. Core has no codecs, so these tests declare some.

mod accepted;
mod configs;
mod optics;
mod overriding;
mod refused_inputs;
mod refused_levels;
mod refused_pictures;
mod refused_structure;
mod resolving;
mod sizes;

use std::sync::Arc;

use super::schema::tests::agrees;
use super::{Document, Experiment, Known};
use crate::codec::{
    Codec, CodecInfo, ConfigError, DecodeError, DecodedBy, Decoder, Encoder, Registry, Setting, SettingKind,
    Settings,
};
use crate::container::EncodedVolume;
use crate::render::RendererInfo;

/// The configuration of the documentation, word for word.
pub(super) const EXAMPLE: &str = include_str!("../../../../docs/example.toml");

#[derive(Debug)]
struct FakeCodec(CodecInfo);

impl Codec for FakeCodec {
    fn info(&self) -> &CodecInfo {
        &self.0
    }

    fn stages(&self, settings: &Settings) -> u8 {
        if settings.integer("index_bits") == Ok(4) { 3 } else { 1 }
    }

    fn resolutions(&self, settings: &Settings) -> u8 {
        if settings.integer("index_bits") == Ok(4) { 2 } else { 1 }
    }

    /// Blocks of 32 are decoded by the CPU alone.
    fn decoded_by(&self, settings: &Settings) -> &'static [DecodedBy] {
        if settings.text("block") == Ok("32") { &[DecodedBy::Cpu] } else { self.0.decoded_by }
    }

    fn encoder(&self, settings: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        #[derive(Debug)]
        struct Never;
        impl Encoder for Never {
            fn encode(
                &mut self,
                _: &dyn crate::volume::BrickSource,
                _: &mut dyn crate::container::StreamWriter,
                _: &crate::codec::Progress<'_>,
            ) -> Result<crate::codec::EncodeReport, crate::codec::EncodeError> {
                Err(crate::codec::EncodeError::Cancelled)
            }
        }
        // A contradiction that no schema can see.
        match (settings.text("block"), settings.integer("index_bits")) {
            (Ok("128"), Ok(1)) => Err(ConfigError::Contradiction("a block of 128 needs 2 bits".to_owned())),
            _ => Ok(Box::new(Never)),
        }
    }

    fn decoder(&self, _: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        Err(DecodeError::Corrupt("fake".to_owned()))
    }
}

pub(super) fn registry() -> Registry {
    let info = CodecInfo {
        id: "raw",
        summary: "",
        stream_version: 1,
        decoded_by: &[DecodedBy::Shader, DecodedBy::Cpu],
        fetch_cell: false,
        paper: None,
        settings: &[],
        methods: &[],
    };
    let raw = CodecInfo {
        settings: &[Setting {
            name: "bits",
            doc: "bits per sample",
            kind: SettingKind::Choice(&["native", "8", "half"]),
            default: "native",
        }],
        ..info.clone()
    };
    let s3dc = CodecInfo {
        id: "s3dc",
        fetch_cell: true,
        settings: &[
            Setting {
                name: "block",
                doc: "voxels of a block",
                kind: SettingKind::Block { max: 128 },
                default: "16",
            },
            Setting {
                name: "index_bits",
                doc: "bits per voxel",
                kind: SettingKind::OneOf(&[1, 2, 4, 8]),
                default: "4",
            },
        ],
        ..info.clone()
    };
    let tape = CodecInfo { id: "tape", decoded_by: &[DecodedBy::Cpu], ..info };
    let mut registry = Registry::default();
    for info in [raw, s3dc, tape] {
        registry.register(Arc::new(FakeCodec(info))).unwrap();
    }
    registry
}

pub(super) fn known(codecs: &Registry) -> Known<'_> {
    Known { codecs, renderers: &[&RAYCASTING, &SLICING], generators: &["shepp-logan", "marschner-lobb"] }
}

const RAYCASTING: RendererInfo = RendererInfo { id: "raycasting", summary: "", settings: &[], layers: None };

const SLICING: RendererInfo = RendererInfo {
    id: "slicing",
    summary: "",
    settings: &[
        Setting {
            name: "geometry",
            doc: "where slices lie",
            kind: SettingKind::Choice(&["planes", "axis", "shells"]),
            default: "planes",
        },
        Setting {
            name: "layers",
            doc: "slices at once",
            kind: SettingKind::Integer { min: 1, max: 9 },
            default: "1",
        },
    ],
    layers: Some(&[("geometry", "axis")]),
};

/// Reads a configuration with overrides. The error is the text that a user would see. The result is also compared with
/// the schema.
fn read(text: &str, overrides: &[&str]) -> Result<Experiment, String> {
    let registry = registry();
    let mut document = Document::parse("x.toml", text).map_err(|e| e.to_string())?;
    for assignment in overrides {
        document.set(assignment).map_err(|e| e.to_string())?;
    }
    let experiment = document.experiment(&known(&registry));
    agrees(&document, experiment.as_ref().err().map(|e| e.0.as_slice()));
    experiment.map_err(|e| e.to_string())
}

/// The example with one piece replaced.
fn edited(from: &str, to: &str) -> String {
    assert_eq!(EXAMPLE.matches(from).count(), 1, "{from:?} must stand once in the example");
    EXAMPLE.replace(from, to)
}

/// The errors of the example after each replacement.
fn errors(edits: &[(&str, &str)]) -> String {
    let error = |(from, to): &(&str, &str)| {
        read(&edited(from, to), &[]).expect_err(&format!("{to:?} in place of {from:?} was accepted"))
    };
    edits.iter().map(error).collect::<Vec<_>>().join("\n\n")
}
