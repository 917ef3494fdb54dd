//! Colours and frames: each channel of each frame is coded independently.

use std::sync::Arc;

use cvr_core::codec::{Codec as _, SettingValue, Settings, decode_frame, encode_temporary};
use cvr_core::volume::{
    DenseVolume, Extent, FiniteVolume, FrameIndex, NoReferences, SampleType, Samples, VolumeLayout,
};
use cvr_s3dc::S3dc;

const SIZE: [u32; 3] = [13, 6, 5];

fn settings() -> Settings {
    let pairs = [("block", SettingValue::from("4x3x2")), ("index_bits", SettingValue::Integer(2))];
    pairs.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

fn volume(channels: u32, frames: u32, values: Vec<u16>) -> FiniteVolume {
    let extent = Extent::try_from(SIZE).unwrap();
    let layout = VolumeLayout { channels, frames, ..VolumeLayout::scalar(extent, SampleType::U16) };
    FiniteVolume::new(DenseVolume::new(layout, Samples::U16(values)).unwrap())
}

fn decoded(volume: &FiniteVolume, frame: u32) -> Vec<f32> {
    let stream = encode_temporary(&S3dc, &settings(), volume).unwrap();
    let decoder = S3dc.decoder(Arc::new(stream)).unwrap();
    decode_frame(decoder.as_ref(), FrameIndex(frame), &NoReferences).unwrap()
}

/// Noise whose range depends on channel and frame, so that endpoints of another one would be noticed.
fn value(voxel: usize, channel: usize, frame: usize) -> u16 {
    let noise = (voxel as u32 * 3 + channel as u32 + 1000 * frame as u32).wrapping_mul(0x9e37_79b9) >> 22;
    (noise as u16 >> channel) + 5000 * channel as u16 + 20_000 * frame as u16
}

#[test]
fn each_channel_of_each_frame_is_coded_as_if_alone() {
    let voxels: usize = SIZE.iter().product::<u32>() as usize;
    let frame = |f| (0..voxels).flat_map(move |v| (0..3).map(move |c| value(v, c, f)));
    let together = volume(3, 2, (0..2).flat_map(frame).collect());
    for f in 0..2 {
        let all = decoded(&together, f);
        for c in 0..3 {
            let alone = volume(1, 1, (0..voxels).map(|v| value(v, c, f as usize)).collect());
            let channel: Vec<f32> = all.iter().skip(c).step_by(3).copied().collect();
            assert!(channel == decoded(&alone, 0), "channel {c} of frame {f} differs");
        }
    }
}
