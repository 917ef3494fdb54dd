//! A frame decoded piece by piece. A writer of voxels needs one piece at a time.

use rayon::prelude::*;

use super::{DecodeError, DecodedFrame, Decoder, References};
use crate::memory;
use crate::volume::{BrickKey, Extent, FrameIndex, Level, Region};

/// Slices, or rows, that one thread decodes at a time: a multiple of most codecs' block edges.
const AT_ONCE: u32 = 8;

/// Decodes a frame at a level in pieces of at most `max_samples` samples, but at least one row. Hands the values of
/// each piece to `each`, in memory order. If the codec rebuilds or predicts whole frames, the frame is decoded once.
///
/// # Errors
/// As [`Decoder::decode_brick`], those of `each`, and when there is no memory for a piece.
pub fn decode_pieces<E: From<DecodeError>>(
    decoder: &dyn Decoder,
    frame: FrameIndex,
    level: Level,
    max_samples: usize,
    mut each: impl FnMut(&[f32]) -> Result<(), E>,
) -> Result<(), E> {
    let layout = decoder.layout().at_resolution(level.resolution);
    if let Some(whole) = DecodedFrame::if_whole(decoder, frame, level)? {
        return whole.values().chunks(max_samples.max(1)).try_for_each(each);
    }
    let references = decoder.references(frame, level)?;
    let channels = layout.channels as usize;
    let mut buffer: Vec<f32> = Vec::new();
    for piece in pieces(layout.extent, max_samples / channels) {
        let samples = piece.extent.voxels() as usize * channels;
        if buffer.len() < samples {
            drop(std::mem::take(&mut buffer));
            let what = || format!("a piece of {} voxels", piece.extent);
            buffer = memory::zeroed(samples as u64, what).map_err(DecodeError::from)?;
        }
        let values = &mut buffer[..samples];
        decode_piece(decoder, (frame, level, &references), piece, values)?;
        each(values)?;
    }
    Ok(())
}

/// Decodes a box of whole slices, or of rows of one slice, in parallel.
fn decode_piece(
    decoder: &dyn Decoder,
    (frame, level, references): (FrameIndex, Level, &References),
    piece: Region,
    values: &mut [f32],
) -> Result<(), DecodeError> {
    // The axis along which parts of the box lie one after the other in memory.
    let axis = if piece.extent.z() > 1 { 2 } else { 1 };
    let length = piece.extent.to_array()[axis];
    let each = values.len() / length as usize;
    values.par_chunks_mut(each * AT_ONCE as usize).enumerate().try_for_each(|(part, out)| {
        let (mut origin, mut size) = (piece.origin, piece.extent.to_array());
        origin[axis] += part as u32 * AT_ONCE;
        size[axis] = (out.len() / each) as u32;
        let extent = Extent::try_from(size).map_err(|e| DecodeError::Corrupt(e.to_string()))?;
        let key = BrickKey { frame, level, region: Region { origin, extent } };
        decoder.decode_brick(key, references, out)
    })
}

/// Boxes that cover `extent` in memory order. Each is as many whole slices as have `max_voxels`, else rows of one
/// slice, at least one row.
fn pieces(extent: Extent, max_voxels: usize) -> impl Iterator<Item = Region> {
    let [x, y, z] = extent.to_array();
    let fit = |one: u64| {
        let n = (max_voxels as u64 / one).clamp(1, u64::from(u32::MAX)) as u32;
        if n > AT_ONCE { n / AT_ONCE * AT_ONCE } else { n }
    };
    let slices = fit(u64::from(x) * u64::from(y)).min(z);
    let whole = u64::from(x) * u64::from(y) <= max_voxels as u64;
    let rows = if whole { y } else { fit(u64::from(x)).min(y) };
    (0..z.div_ceil(slices)).flat_map(move |slab| {
        (0..y.div_ceil(rows)).map(move |part| {
            let origin = [0, part * rows, slab * slices];
            let size = [x, rows.min(y - origin[1]), slices.min(z - origin[2])];
            Region { origin, extent: Extent::try_from(size).unwrap_or(Extent::ONE) }
        })
    })
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::volume::{ReferenceFrames, SampleType, VolumeLayout};

    /// Every sample is its own number; counts calls, and the largest box.
    #[derive(Debug)]
    struct Counter {
        layout: VolumeLayout,
        rebuilds_frames: bool,
        largest: AtomicUsize,
    }

    impl Decoder for Counter {
        fn layout(&self) -> &VolumeLayout {
            &self.layout
        }

        fn rebuilds_frames(&self) -> bool {
            self.rebuilds_frames
        }

        fn decode_brick(
            &self,
            key: BrickKey,
            _: &dyn ReferenceFrames,
            out: &mut [f32],
        ) -> Result<(), DecodeError> {
            self.largest.fetch_max(out.len(), Ordering::Relaxed);
            let channels = self.layout.channels as usize;
            let row = key.region.extent.x() as usize * channels;
            let frame = key.frame.0 as usize * self.layout.samples_per_frame() as usize;
            for (start, out) in key.region.rows().zip(out.chunks_exact_mut(row)) {
                let first = frame + self.layout.extent.index(start) * channels;
                out.iter_mut().zip(first..).for_each(|(out, i)| *out = i as f32);
            }
            Ok(())
        }
    }

    fn counter(extent: [u32; 3], channels: u32, rebuilds_frames: bool) -> Counter {
        let extent = Extent::try_from(extent).unwrap();
        let layout = VolumeLayout { channels, frames: 2, ..VolumeLayout::scalar(extent, SampleType::U8) };
        Counter { layout, rebuilds_frames, largest: AtomicUsize::new(0) }
    }

    /// Decodes the second frame. Returns its values and the length of the longest piece.
    fn decoded(decoder: &Counter, max_samples: usize) -> (Vec<f32>, usize) {
        let (mut all, mut longest) = (Vec::new(), 0);
        decode_pieces(decoder, FrameIndex(1), Level::FULL, max_samples, |values| {
            all.extend_from_slice(values);
            longest = longest.max(values.len());
            Ok::<_, DecodeError>(())
        })
        .unwrap();
        (all, longest)
    }

    #[test]
    fn pieces_of_any_size_are_the_frame() {
        for extent in [[5, 7, 23], [1, 1, 40], [6, 19, 1], [300, 2, 2], [1, 1, 1]] {
            for channels in [1, 3] {
                let decoder = counter(extent, channels, false);
                let n = decoder.layout.samples_per_frame() as usize;
                let expected: Vec<f32> = (n..2 * n).map(|i| i as f32).collect();
                for max in [1, 10, 60, 400, 100_000] {
                    let (values, longest) = decoded(&decoder, max);
                    assert!(values == expected, "{extent:?} by {max}");
                    let row = (extent[0] * channels) as usize;
                    assert!(longest <= max.max(row), "{extent:?}: {longest} samples at once, {max} allowed");
                }
            }
        }
    }

    #[test]
    fn a_codec_of_whole_frames_is_asked_in_their_order_and_handed_on_in_pieces() {
        let decoder = counter([4, 4, 64], 1, true);
        let (values, longest) = decoded(&decoder, 100);
        assert_eq!((values.len(), values[0], longest), (1024, 1024.0, 100));
    }

    #[test]
    fn a_stop_ends_it() {
        let decoder = counter([4, 4, 64], 1, false);
        let mut pieces = 0;
        let ended = decode_pieces(&decoder, FrameIndex::FIRST, Level::FULL, 64, |_| {
            pieces += 1;
            if pieces == 3 { Err(DecodeError::Failed("stop".to_owned())) } else { Ok(()) }
        });
        assert_eq!((ended.unwrap_err().to_string(), pieces), ("stop".to_owned(), 3));
    }
}
