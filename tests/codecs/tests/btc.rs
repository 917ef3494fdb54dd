//! Block truncation coding (E. J. Delp, O. R. Mitchell, IEEE Transactions on Communications 27 (9), 1979): a small
//! codec that shows what an author adds to the kit. It is not registered. These tests run it like any other codec.

#![allow(clippy::unwrap_used, reason = "helpers of tests, which a failed unwrap fails")]

use cvr_core::codec::{Block, CodecInfo, ConfigError, DecodedBy, Setting, SettingKind, Settings};
use cvr_core::kit::BlockCodec;

static INFO: CodecInfo = CodecInfo {
    id: "btc",
    summary: "two levels per block that keep its mean and variance, and a bit per voxel",
    stream_version: 1,
    decoded_by: &[DecodedBy::Shader, DecodedBy::Cpu],
    fetch_cell: true,
    paper: None,
    settings: &[Setting {
        name: "block",
        doc: "size of a block in voxels",
        kind: SettingKind::Block { max: 16 },
        default: "4",
    }],
    methods: &[],
};

#[derive(Debug)]
struct Btc(Block);

impl BlockCodec for Btc {
    const INFO: &'static CodecInfo = &INFO;
    const SNIPPET: (&'static str, &'static str) = ("tests/codecs/tests/btc.wgsl", include_str!("btc.wgsl"));

    fn from_settings(settings: &Settings) -> Result<Self, ConfigError> {
        settings.block("block").map(Self)
    }

    fn block(&self) -> Block {
        self.0
    }

    /// Both levels, and the bits.
    fn record_words(&self) -> usize {
        2 + (self.0.0.voxels() as usize).div_ceil(32)
    }

    fn encode(&self, values: &[f32], record: &mut [u32]) {
        let count = values.len() as f64;
        let mean = values.iter().map(|v| f64::from(*v)).sum::<f64>() / count;
        let deviation = (values.iter().map(|v| (f64::from(*v) - mean).powi(2)).sum::<f64>() / count).sqrt();
        let above = values.iter().filter(|v| f64::from(**v) >= mean).count() as f64;
        let (low, high) = values.iter().fold((f32::MAX, f32::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        // Held within the block, and no number that a device may flush.
        let level =
            |level: f64| Some((level as f32).clamp(low, high)).filter(|v| !v.is_subnormal()).unwrap_or(0.0);
        record[0] = level(mean - deviation * (above / (count - above)).min(count).sqrt()).to_bits();
        record[1] = level(mean + deviation * ((count - above) / above).min(count).sqrt()).to_bits();
        for (i, _) in values.iter().enumerate().filter(|(_, v)| f64::from(**v) >= mean) {
            record[2 + i / 32] |= 1 << (i % 32);
        }
    }

    fn decode(&self, record: &[u32], i: usize) -> f32 {
        f32::from_bits(record[(record[2 + i / 32] >> (i % 32) & 1) as usize])
    }
}

mod battery {
    use std::sync::Arc;

    use cvr_codec_tests::{bytes, hash, settings};
    use cvr_core::codec::{Codec as _, Settings, decode_frame, encode_temporary};
    use cvr_core::conformance;
    use cvr_core::container::{ContainerWriter, EncodedVolume, StreamWriter as _};
    use cvr_core::kit::CodecOfBlocks;
    use cvr_core::volume::{FrameIndex, NoReferences};

    use super::Btc;

    const BTC: CodecOfBlocks<Btc> = CodecOfBlocks::new();

    #[test]
    fn blocks_of_all_shapes_pass() {
        let dump = cvr_codec_tests::device::dump("btc::conformance");
        let list = [Settings::default(), settings(&[("block", "3x5x2")]), settings(&[("block", "1")])];
        let report = conformance::run_with(&BTC, &list, dump);
        report.assert_ok();
        assert_eq!(report.refused, 0);
    }

    /// If a device runs the shaders, a wrong shader fails.
    #[test]
    fn a_wrong_snippet_is_noticed() {
        cvr_codec_tests::device::notices(Arc::new(BTC), "i % 32u", "(i ^ 1u) % 32u");
    }

    /// The two levels keep mean and variance of each block (equation 2 of the paper).
    #[test]
    fn moments_are_kept() {
        let volume = bytes([8, 8, 8], 3, 2, |p, c, f| hash(p, c + 3 * f) / 2 + 30);
        let stream = encode_temporary(&BTC, &Settings::default(), &volume).unwrap();
        let decoder = BTC.decoder(Arc::new(stream)).unwrap();
        let moments = |values: &[f32], block: usize, c: usize| {
            let place = |i: usize| {
                let p = [0, 1, 2].map(|a| (block >> a & 1) * 4 + (i >> (2 * a) & 3));
                values[((p[2] * 8 + p[1]) * 8 + p[0]) * 3 + c]
            };
            let of = |power| (0..64).map(|i| f64::from(place(i)).powi(power)).sum::<f64>() / 64.0;
            [of(1), of(2).sqrt()]
        };
        for frame in [0, 1].map(FrameIndex) {
            let decoded = decode_frame(decoder.as_ref(), frame, &NoReferences).unwrap();
            let source = volume.dense().frame_values(frame);
            for (block, c) in (0..8).flat_map(|block| (0..3).map(move |c| (block, c))) {
                let [kept, own] = [&decoded, &source].map(|values| moments(values, block, c));
                assert!((0..2).all(|k| (kept[k] - own[k]).abs() < 1e-4), "block {block}: {kept:?}, {own:?}");
            }
        }
    }

    /// A stream with other parameters, or a level that is no number.
    fn changed(parameters: &str, level: Option<f32>) -> String {
        let volume = bytes([5, 4, 4], 1, 1, |p, _, _| hash(p, 7));
        let stream = encode_temporary(&BTC, &Settings::default(), &volume).unwrap();
        let (spec, folder) = (stream.spec(), tempfile::tempdir().unwrap());
        let path = folder.path().join("changed.cvr");
        let mut writer = ContainerWriter::create(&path).unwrap();
        let tensor = &spec.tensors["blocks"];
        let mut words = stream.tensor("blocks", tensor.element).unwrap().words().to_vec();
        words[4] = level.map_or(words[4], f32::to_bits);
        writer
            .append("blocks", tensor.element, &words.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<_>>())
            .unwrap();
        writer.shape("blocks", &tensor.shape).unwrap();
        writer.parameters(serde_json::from_str(parameters).unwrap());
        writer.finish(BTC.info(), &spec.layout, &spec.settings, &spec.report, spec.replaced).unwrap();
        let stream = EncodedVolume::open(&path).unwrap();
        BTC.decoder(Arc::new(stream)).map_or_else(|e| e.to_string(), |_| "accepted".to_owned())
    }

    /// Parameters are checked against the schema of the settings, and records against what an encoder writes.
    #[test]
    fn what_no_encoder_writes_is_refused() {
        assert_eq!(changed(r#"{"block": "4"}"#, None), "accepted");
        for (parameters, problem) in [
            (r#"{"block": "17"}"#, "expected a block edge"),
            (r#"{"block": "4", "bits": 2}"#, "no setting `bits`"),
            (r#"{"block": "2"}"#, "has the shape"),
        ] {
            assert!(
                changed(parameters, None).contains(problem),
                "{parameters}: {}",
                changed(parameters, None)
            );
        }
        assert!(changed(r#"{"block": "4"}"#, Some(f32::NAN)).contains("record 1 of `blocks`"));
    }
}
