//! Cells that skip empty macrocells, and the gain of skipping.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use cvr_core::codec::Decoder;
use cvr_core::render::{Image, MacrocellRanges, Macrocells, TransferFunction};
use cvr_core::volume::{FrameIndex, Level};
use cvr_engine::timing::{FrameTime, paired};

use crate::experiment::records::record::Record;
use crate::experiment::running::latest::Latest;

/// The macrocells of a stream's frame at one level, decoded when a cell first asks for them.
#[derive(Debug, Default)]
pub struct LazyRanges(Latest<Arc<(MacrocellRanges, f64)>>);

impl LazyRanges {
    /// The ranges of all macrocells, and the wall seconds of decoding them.
    ///
    /// # Errors
    /// A sentence, when decoding fails or `stop` turns true.
    pub fn get(
        &self,
        decoder: &dyn Decoder,
        (frame, level): (FrameIndex, Level),
        stop: &AtomicBool,
    ) -> Result<Arc<(MacrocellRanges, f64)>, String> {
        self.0.get(frame, || {
            let start = Instant::now();
            let ranges = MacrocellRanges::decode(decoder, frame, level, stop);
            let ranges = ranges.map_err(|e| e.to_string())?.ok_or("stopped")?;
            Ok(Arc::new((ranges, start.elapsed().as_secs_f64())))
        })
    }

    /// The classified macrocells. Enters their time and the fraction of empty ones into the record.
    ///
    /// # Errors
    /// As [`LazyRanges::get`].
    pub fn classify(
        &self,
        decoder: &dyn Decoder,
        (frame, level): (FrameIndex, Level),
        transfer_function: &TransferFunction,
        stop: &AtomicBool,
        record: &mut Record,
    ) -> Result<Arc<Macrocells>, String> {
        let found = self.get(decoder, (frame, level), stop)?;
        let (ranges, seconds) = &*found;
        let macrocells = ranges.classify(transfer_function);
        record.macrocell_seconds = Some(*seconds);
        record.empty_macrocells = Some(macrocells.empty_share());
        Ok(Arc::new(macrocells))
    }
}

/// Compares the picture of a skipping cell with that of the cell that does not skip.
///
/// # Errors
/// A sentence, when a pixel differs in any bit.
pub fn check_picture(record: &mut Record, with: &Image, without: &Image) -> Result<(), String> {
    let differing = mismatches(with, without);
    record.skipping_mismatches = Some(differing);
    if differing == 0 {
        return Ok(());
    }
    Err(format!(
        "skipping changes the picture: {differing} of {} pixels differ from those without",
        without.pixels().len()
    ))
}

/// Number of pixels that differ in any bit. Pixels that only one picture has count too.
fn mismatches(a: &Image, b: &Image) -> u64 {
    let bits = |pixel: &[f32; 4]| pixel.map(f32::to_bits);
    let differing = a.pixels().iter().zip(b.pixels()).filter(|(a, b)| bits(a) != bits(b)).count();
    (differing + a.pixels().len().abs_diff(b.pixels().len())) as u64
}

/// Times the cell against itself without skipping, in turn.
///
/// # Errors
/// The first of either closure.
pub fn time_gain<E>(
    record: &mut Record,
    with: impl FnMut() -> Result<FrameTime, E>,
    without: impl FnMut() -> Result<FrameTime, E>,
) -> Result<(), E> {
    let timing = paired(with, without, super::pairs::budget())?;
    record.skipping_gain = Some(timing.relative);
    record.skipping_gain_iqr = Some(timing.relative_iqr);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_bit_of_one_pixel_is_a_mismatch_that_fails_the_cell() {
        let image = Image::new([4, 3]);
        let mut record = Record::default();
        assert_eq!(check_picture(&mut record, &image, &image.clone()), Ok(()));
        assert_eq!(record.skipping_mismatches, Some(0));
        let mut other = image.clone();
        other.pixels_mut()[7][2] = f32::from_bits(1);
        // Not a number like any other, and yet the same bits.
        other.pixels_mut()[3][0] = f32::NAN;
        assert_eq!(mismatches(&other, &other.clone()), 0);
        let problem = check_picture(&mut record, &other, &image).unwrap_err();
        assert_eq!(problem, "skipping changes the picture: 2 of 12 pixels differ from those without");
        assert_eq!(record.skipping_mismatches, Some(2));
        assert_eq!(mismatches(&image, &Image::new([4, 4])), 4);
    }

    #[test]
    fn the_gain_is_the_time_without_over_that_with() {
        let frame = |ms| move || Ok::<_, ()>(FrameTime { wall_ms: ms, gpu_ms: None, cpu_ms: None });
        let mut record = Record::default();
        time_gain(&mut record, frame(2.0), frame(5.0)).unwrap();
        assert_eq!((record.skipping_gain, record.skipping_gain_iqr), (Some(2.5), Some(0.0)));
    }
}
