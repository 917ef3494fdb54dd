use std::sync::Arc;
use std::sync::atomic::Ordering;

use cvr_core::codec::{
    Codec, CodecInfo, ConfigError, DecodeError, Decoder, EncodeError, EncodeReport, Encoder, Progress, Site,
};
use cvr_core::container::{EncodedVolume, StreamWriter};
use cvr_core::volume::{BrickSource, Extent, SampleType};

use super::*;

#[test]
fn a_trial_says_what_a_codec_makes_of_a_voxel() {
    let names = Names::new().unwrap();
    let mut trials = Trials::new(&names, UNBOUNDED);
    let layout = VolumeLayout::scalar(Extent::cube(100).unwrap(), SampleType::U16);
    let raw = names.codecs().get("raw").unwrap().info().default_settings();
    let raw = trials.of("raw", &raw, &layout).unwrap();
    assert!((raw.stream_bytes_per_voxel() - 2.0).abs() < 0.05);
    let raw = raw.coded("raw");
    assert_eq!((raw.texel_bytes(), raw.buffer_bytes_per_voxel().unwrap()), (2, 2.0));
    let colour = VolumeLayout { channels: 3, sample: SampleType::U8, ..layout.clone() };
    let raw = names.codecs().get("raw").unwrap().info().default_settings();
    assert_eq!(trials.of("raw", &raw, &colour).unwrap().coded("raw").texel_bytes(), 4);
    let s3dc = names.codecs().get("s3dc").unwrap().info().default_settings();
    let s3dc = trials.of("s3dc", &s3dc, &layout).unwrap();
    // 4 bits per index, and two endpoints per block of 16³.
    assert!((s3dc.coded("s3dc").buffer_bytes_per_voxel().unwrap() - 0.5).abs() < 0.01);
    assert!(s3dc.encode_seconds_per_voxel() > 0.0 && s3dc.decode_seconds_per_voxel() > 0.0);
    // Half a byte per voxel as blocks, if the target supports them; 16 bits if decoded.
    let bc4 = names.codecs().get("bc4").unwrap().info().default_settings();
    let bc4 = trials.of("bc4", &bc4, &layout).unwrap().coded("bc4");
    assert_eq!(bc4.buffer_bytes_per_voxel().unwrap(), 0.5);
    let host = crate::site::of(Site::Host).device_bytes(bc4, &Target::Cpu { reason: None }, &layout);
    assert_eq!(host, Ok(2.0 * 100.0 * 100.0 * 100.0));
    assert!(trials.of("none", &Settings::default(), &layout).is_err());
}

/// A codec whose encoder runs until it is cancelled and, as a driver does, some time longer.
#[derive(Debug)]
struct Endless {
    info: CodecInfo,
    /// Whether it may end, and whether it has.
    marks: Arc<[AtomicBool; 2]>,
}

impl Codec for Endless {
    fn info(&self) -> &CodecInfo {
        &self.info
    }

    fn encoder(&self, _: &Settings) -> Result<Box<dyn Encoder>, ConfigError> {
        Ok(Box::new(EndlessEncoder(self.marks.clone())))
    }

    fn decoder(&self, _: Arc<EncodedVolume>) -> Result<Box<dyn Decoder>, DecodeError> {
        Err(DecodeError::Corrupt("nothing is encoded".to_owned()))
    }
}

#[derive(Debug)]
struct EndlessEncoder(Arc<[AtomicBool; 2]>);

impl Encoder for EndlessEncoder {
    fn encode(
        &mut self,
        _: &dyn BrickSource,
        _: &mut dyn StreamWriter,
        run: &Progress<'_>,
    ) -> Result<EncodeReport, EncodeError> {
        let [may_end, ended] = &*self.0;
        while run.advance(1).is_ok() || !may_end.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_millis(100));
        ended.store(true, Ordering::Relaxed);
        Err(EncodeError::Cancelled)
    }
}

#[test]
fn no_trial_outlives_the_command_that_asked_for_it() {
    let marks = Arc::<[AtomicBool; 2]>::default();
    let [may_end, ended] = &*marks;
    let info = CodecInfo { id: "endless", settings: &[], methods: &[], ..cvr_raw::codec().info().clone() };
    let codec = Endless { info, marks: marks.clone() };
    let names = Names::new().unwrap().with_codec(Arc::new(codec)).unwrap();
    let short = Allowance { each: Duration::from_millis(50), all: Duration::from_millis(50) };
    let layout = VolumeLayout::scalar(Extent::cube(100).unwrap(), SampleType::U8);
    let mut trials = Trials::new(&names, short);
    let problem = trials.of("endless", &Settings::default(), &layout).unwrap_err();
    assert!(problem.contains("did not end"), "{problem}");
    assert!(!ended.load(Ordering::Relaxed), "it still runs");
    may_end.store(true, Ordering::Relaxed);
    drop(trials);
    assert!(ended.load(Ordering::Relaxed), "it has ended");
}

/// However slow the machine is that runs this test.
const UNBOUNDED: Allowance = Allowance { each: Duration::from_secs(3600), all: Duration::from_secs(3600) };

#[test]
fn without_time_nothing_is_tried_and_that_is_said() {
    let names = Names::new().unwrap();
    let none = Allowance { each: Duration::ZERO, all: Duration::ZERO };
    let mut trials = Trials::new(&names, none);
    let layout = VolumeLayout::scalar(Extent::cube(100).unwrap(), SampleType::U16);
    let raw = names.codecs().get("raw").unwrap().info().default_settings();
    assert_eq!(trials.of("raw", &raw, &layout).unwrap_err(), "no time left to encode");
    assert_eq!(trials.costs().len(), 1);
    assert_eq!(trials.costs()[0].lacks.as_deref(), Some("no time left to encode"));
}
