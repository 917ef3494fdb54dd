//! Colours and frames keep every bit, in chunks that end anywhere in a word.

use std::sync::Arc;

use cvr_core::codec::{Settings, decode_frame, encode_temporary};
use cvr_core::volume::{
    DenseVolume, Extent, FiniteVolume, FrameIndex, NoReferences, SampleType, Samples, VolumeLayout,
};

#[test]
fn every_channel_of_every_frame_is_what_it_was() {
    // More slices than a chunk, and an odd number of samples in each frame.
    let extent = Extent::new(5, 3, 19).unwrap();
    let layout = VolumeLayout { channels: 3, frames: 3, ..VolumeLayout::scalar(extent, SampleType::I8) };
    let value = |i: u64| ((i as u32).wrapping_mul(0x9e37_79b9) >> 24) as i8;
    let samples = Samples::I8((0..layout.samples()).map(value).collect());
    let volume = FiniteVolume::new(DenseVolume::new(layout, samples).unwrap());
    let codec = cvr_raw::codec();
    let stream = encode_temporary(codec.as_ref(), &Settings::default(), &volume).unwrap();
    let decoder = codec.decoder(Arc::new(stream)).unwrap();
    for frame in (0..3).map(FrameIndex) {
        let decoded = decode_frame(decoder.as_ref(), frame, &NoReferences).unwrap();
        assert!(decoded == volume.dense().frame_values(frame), "frame {} differs", frame.0);
    }
}
