//! Commands that work, that fail, and that nobody asked for.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a failed unwrap fails its test, which is what it is for")]

use std::sync::Arc;

use cvr_core::codec::{
    Codec, DecodeError, EncodeError, SettingValue, Settings, decode_frame, encode_temporary,
};
use cvr_core::container::EncodedVolume;
use cvr_core::metrics::VolumeError;
use cvr_core::volume::{
    BrickSource, DenseVolume, Extent, FiniteVolume, FrameIndex, NoReferences, SampleType, Samples,
    VolumeLayout,
};

fn settings(pairs: &[(&str, &str)]) -> Settings {
    pairs.iter().map(|(name, value)| ((*name).to_owned(), SettingValue::from(*value))).collect()
}

fn encode(
    codec: &dyn Codec,
    pairs: &[(&str, &str)],
    volume: &FiniteVolume,
) -> Result<Arc<EncodedVolume>, EncodeError> {
    encode_temporary(codec, &settings(pairs), volume).map(Arc::new)
}

fn frames(codec: &dyn Codec, stream: Arc<EncodedVolume>) -> Result<Vec<Vec<f32>>, DecodeError> {
    let decoder = codec.decoder(stream)?;
    let frames = (0..decoder.layout().frames).map(FrameIndex);
    frames.map(|frame| decode_frame(decoder.as_ref(), frame, &NoReferences)).collect()
}

/// Whole numbers in any type.
fn volume([x, y, z]: [u32; 3], sample: SampleType) -> FiniteVolume {
    let layout = VolumeLayout::scalar(Extent::new(x, y, z).unwrap(), sample);
    let values: Vec<i8> = (0..x * y * z).map(|i| (i * 37 % 101) as i8).collect();
    let samples = match sample {
        SampleType::U8 => Samples::U8(values.iter().map(|v| *v as u8).collect()),
        SampleType::I16 => Samples::I16(values.iter().map(|v| i16::from(*v)).collect()),
        _ => Samples::F32(values.iter().map(|v| f32::from(*v)).collect()),
    };
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

/// Two frames of colour voxels.
fn colours() -> FiniteVolume {
    let layout = VolumeLayout {
        channels: 3,
        frames: 2,
        ..VolumeLayout::scalar(Extent::new(5, 4, 3).unwrap(), SampleType::U8)
    };
    let samples = (0..layout.samples_per_frame() * 2).map(|i| (i * 37 % 251) as u8).collect();
    FiniteVolume::new(DenseVolume::new(layout, Samples::U8(samples)).unwrap())
}

#[test]
fn channels_and_frames_are_files_of_their_own() {
    let codec = cvr_external::codec();
    let volume = colours();
    let pairs = [("encode", "sh -c 'gzip -c < {in} > {out}'"), ("decode", "sh -c 'gzip -dc < {in} > {out}'")];
    let stream = encode(codec.as_ref(), &pairs, &volume).unwrap();
    let decoded = frames(codec.as_ref(), stream).unwrap();
    assert_eq!(VolumeError::compare(&volume, decoded).max_abs_error, 0.0);
    // Tests the test: each file is one channel of one frame.
    let only_of_20 = "sh -c 'test $(wc -c < {in}) -eq 60 && cp {in} {out}'";
    assert!(encode(codec.as_ref(), &[("encode", only_of_20)], &volume).is_ok());
    let other = "sh -c 'test $(wc -c < {in}) -eq 180 && cp {in} {out}'";
    assert!(encode(codec.as_ref(), &[("encode", other)], &volume).is_err());
}

#[test]
fn the_shape_type_and_value_reach_the_command() {
    let volume = volume([7, 5, 2], SampleType::I16);
    let codec = cvr_external::codec();
    let asks = "sh -c 'test \"{x} {y} {z} {type} {value}\" = \"7 5 2 i16 0.5\" && cp {in} {out}'";
    assert!(encode(codec.as_ref(), &[("encode", asks), ("value", "0.5")], &volume).is_ok());
    let problem = encode(codec.as_ref(), &[("encode", asks), ("value", "0.25")], &volume).unwrap_err();
    assert!(problem.to_string().contains("ended with exit status: 1"), "{problem}");
}

#[test]
fn what_goes_wrong_is_told_with_the_command() {
    let volume = volume([4, 4, 4], SampleType::U8);
    let codec = cvr_external::codec();
    let encoding = |pairs: &[(&str, &str)]| encode(codec.as_ref(), pairs, &volume).unwrap_err().to_string();
    for (pairs, said) in [
        ([("encode", "sh -c ': {in} {out}'")], "wrote nothing to {out}"),
        ([("encode", "no-such-program {in} {out}")], "cannot be run"),
        ([("encode", "cp {in} {put}")], "`encode` of codec `external`: `{put}` is no placeholder"),
        ([("decode", "cp {in} x")], "`decode` of codec `external`: it lacks {out}"),
        ([("name", "a b")], "letters, digits"),
    ] {
        let problem = encoding(&pairs);
        assert!(problem.contains(said), "{problem}");
    }
    let slow = encoding(&[("encode", "sh -c 'sleep 30; cp {in} {out}'"), ("timeout_seconds", "1")]);
    assert!(slow.contains("was killed after 1 s"), "{slow}");
    let decoding = |decode: &str| {
        let stream = encode(codec.as_ref(), &[("decode", decode)], &volume).unwrap();
        frames(codec.as_ref(), stream).unwrap_err().to_string()
    };
    let short = decoding("sh -c 'head -c 63 {in} > {out}'");
    assert!(short.contains("wrote 63 bytes to {out}; 4×4×4 voxels of u8 are 64"), "{short}");
    assert!(decoding("sh -c 'echo broken; false # {in} {out}'").contains(": broken"));
}

/// None of these is waited for or read: a FIFO without another end, an endless device, a file of a terabyte.
#[test]
fn outputs_that_are_no_regular_files_of_the_expected_size_are_refused() {
    let volume = volume([4, 4, 4], SampleType::U8);
    let codec = cvr_external::codec();
    let begun = std::time::Instant::now();
    for (leaves, said) in [
        ("mkfifo {out} # {in}", "left a FIFO as {out}, where a regular file belongs"),
        ("ln -s /dev/zero {out} # {in}", "left a device as {out}"),
        ("mkdir {out} # {in}", "left a folder as {out}"),
        ("mkfifo {out}.fifo && ln -s {out}.fifo {out} # {in}", "left a FIFO as {out}"),
        ("truncate -s 1T {out} # {in}", "wrote 1099511627776 bytes to {out}; "),
        (": {in} {out}", "wrote nothing to {out}"),
    ] {
        let command = format!("sh -c '{leaves}'");
        let problem = encode(codec.as_ref(), &[("encode", &command)], &volume).unwrap_err().to_string();
        assert!(problem.contains(said), "{problem}");
        let stream = encode(codec.as_ref(), &[("decode", &command)], &volume).unwrap();
        let problem = frames(codec.as_ref(), stream).unwrap_err().to_string();
        assert!(problem.contains(said), "{problem}");
    }
    let exact =
        encode(codec.as_ref(), &[("decode", "sh -c 'cp {in} {out}; echo >> {out}'")], &volume).unwrap();
    let problem = frames(codec.as_ref(), exact).unwrap_err().to_string();
    assert!(problem.contains("wrote 65 bytes to {out}; 4×4×4 voxels of u8 are 64"), "{problem}");
    assert!(begun.elapsed() < std::time::Duration::from_secs(60), "nothing is waited for");
    // The twin: a link to a regular file is one.
    let linked = "sh -c 'cp {in} {out}.there && ln -s {out}.there {out}'";
    let stream = encode(codec.as_ref(), &[("encode", linked), ("decode", linked)], &volume).unwrap();
    assert_eq!(VolumeError::compare(&volume, frames(codec.as_ref(), stream).unwrap()).max_abs_error, 0.0);
}

/// Files that a command leaves in place of its input and messages must not stop the next command.
#[test]
fn what_lies_around_from_the_command_before_is_not_waited_for() {
    let codec = cvr_external::codec();
    let volume = colours();
    let litters = "sh -c 'cp {in} {out}; d=$(dirname {out}); rm {in} $d/messages; mkfifo {in} $d/messages'";
    let stream = encode(codec.as_ref(), &[("encode", litters), ("decode", litters)], &volume).unwrap();
    assert_eq!(VolumeError::compare(&volume, frames(codec.as_ref(), stream).unwrap()).max_abs_error, 0.0);
}

#[test]
fn samples_that_are_no_numbers_are_refused() {
    let volume = volume([4, 4, 4], SampleType::F32);
    let codec = cvr_external::codec();
    let ones = "sh -c 'head -c 256 /dev/zero | tr \"\\\\0\" \"\\\\377\" > {out} # {in}'";
    let stream = encode(codec.as_ref(), &[("decode", ones)], &volume).unwrap();
    let problem = frames(codec.as_ref(), stream).unwrap_err().to_string();
    assert!(problem.contains("wrote a sample of NaN"), "{problem}");
}

/// Opening a file must not run a program. Only commands that the same process configured are run.
#[test]
fn a_stream_from_elsewhere_runs_nothing() {
    let volume = volume([4, 4, 4], SampleType::U8);
    let (ours, theirs) = (cvr_external::codec(), cvr_external::codec());
    let stream = encode(theirs.as_ref(), &[("decode", "cp -f {in} {out}")], &volume).unwrap();
    let problem = ours.decoder(stream.clone()).unwrap_err();
    assert!(matches!(problem, DecodeError::Refused(_)), "{problem}");
    let said = problem.to_string();
    assert!(said.contains("`cp -f {in} {out}`") && said.contains("CVR_TRUST_COMMANDS=1"), "{said}");
    assert!(frames(theirs.as_ref(), stream).is_ok());
    assert_eq!(volume.layout().channels, 1);
}
