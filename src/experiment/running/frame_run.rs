//! One frame of a cell: draw, compare, time.

use std::sync::atomic::{AtomicBool, Ordering};

use cvr_core::metrics::{ImageError, error_picture};
use cvr_core::pipeline::Cell;
use cvr_core::render::{Image, to_png};
use cvr_core::volume::FrameIndex;
use cvr_engine::timing::paired;

use super::shared::Shared;
use super::stage::Stage;
use crate::experiment::files::folder::OutFolder;
use crate::experiment::files::names::{IMAGES, of_frame};
use crate::experiment::measured::pairs;
use crate::experiment::measured::picture_errors::PictureErrors;
use crate::experiment::measured::skipping;
use crate::experiment::records::record::Record;
use crate::site::picture::Picture;

/// Data that the frames of a cell share.
pub struct FrameRun<'a> {
    /// The cell.
    pub cell: &'a Cell,
    /// What is decoded.
    pub shared: &'a Shared<'a>,
    /// The report's folder.
    pub out: &'a OutFolder,
    /// Once true, the step after the running one fails.
    pub stop: &'a AtomicBool,
}

impl FrameRun<'_> {
    fn go_on(&self) -> Result<(), String> {
        if self.stop.load(Ordering::Relaxed) { Err("stopped".to_owned()) } else { Ok(()) }
    }

    /// Draws, compares and times one frame.
    ///
    /// # Errors
    /// A sentence that says what failed; what was measured before it stands in the record.
    pub fn run(
        &self,
        record: &mut Record,
        stage: &mut Stage<'_>,
        frame: FrameIndex,
    ) -> Result<PictureErrors, String> {
        let Self { cell, shared, .. } = *self;
        self.go_on()?;
        let encoded = shared.encoded();
        let decoder = encoded.decoder.as_ref();
        let voxels = shared.prepared(cell.site, frame, record)?;
        let baseline = stage.baseline(frame)?;
        let mut view = stage.view(cell.filter)?;
        let unskipped = if cell.skipping { Some(stage.picture(&view, &voxels)?) } else { None };
        if cell.skipping {
            let function = &view.transfer_function;
            let key = (frame, encoded.level);
            view.macrocells = Some(encoded.macrocells.classify(decoder, key, function, self.stop, record)?);
        }
        let picture = stage.picture(&view, &voxels)?;
        record.resident_bytes = picture.resident_bytes();
        record.filtering = Some(picture.filtering().to_owned());
        record.flag_fallbacks(picture.fallback(), baseline.fallback());
        record.flag_blending(picture.blends_in_half(), true);
        if let Some(checked) = picture.check(&shared.expected(frame)?)? {
            record.enter_checked(&checked)?;
        }
        let image = picture.image().map_err(|e| e.to_string())?;

        self.go_on()?;
        let errors = self.compare(record, stage, frame, &image)?;
        if let Some(unskipped) = &unskipped {
            self.go_on()?;
            let without = unskipped.image().map_err(|e| e.to_string())?;
            skipping::check_picture(record, &image, &without)?;
        }

        let draw = |picture: &Picture<'_>| {
            self.go_on()?;
            picture.draw().map_err(|e| e.to_string())
        };
        let timing = paired(|| draw(&baseline), || draw(&picture), pairs::budget())?;
        record.frame_ms = Some(timing.frame_ms);
        record.frame_ms_iqr = Some(timing.frame_ms_iqr);
        record.frame_cpu_ms = timing.frame_cpu_ms;
        record.frame_clock = Some(timing.clock.name().to_owned());
        record.relative_frame_time = Some(timing.relative);
        record.relative_frame_time_iqr = Some(timing.relative_iqr);
        record.frame_pairs = Some(timing.pairs as u32);
        if let Some(unskipped) = &unskipped {
            skipping::time_gain(record, || draw(&picture), || draw(unskipped))?;
        }
        record.flag_ray_pieces(picture.ray_pieces(), baseline.ray_pieces());
        record.flag_noise();
        Ok(errors)
    }

    /// Enters the errors of a picture. Writes it, and a picture of its errors.
    fn compare(
        &self,
        record: &mut Record,
        stage: &mut Stage<'_>,
        frame: FrameIndex,
        image: &Image,
    ) -> Result<PictureErrors, String> {
        let background = stage.background();
        let against =
            |other: &Image| ImageError::compare(other, image, background).map_err(|e| e.to_string());
        let reference = against(stage.reference(frame)?)?;
        let raw = against(stage.raw_image(frame, self.cell.site, self.cell.filter)?)?;
        PictureErrors { reference, raw }.enter(record);

        let id = self.cell.id();
        let first = frame.0 == stage.frames().first;
        let named = |path: String| if first { path } else { of_frame(&path, frame) };
        let (picture, errors) =
            (named(format!("{IMAGES}/{id}.png")), named(format!("{IMAGES}/{id}.error.png")));
        let png = image.to_png(background).map_err(|e| e.to_string())?;
        self.out.write(&picture, &png).map_err(|e| e.to_string())?;
        record.image = Some(picture);
        let colours = error_picture(stage.reference(frame)?, image, background).map_err(|e| e.to_string())?;
        let png = to_png(image.size(), &colours).map_err(|e| e.to_string())?;
        self.out.write(&errors, &png).map_err(|e| e.to_string())?;
        record.error_image = Some(errors);
        Ok(PictureErrors { reference, raw })
    }
}
