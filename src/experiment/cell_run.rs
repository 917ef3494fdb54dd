//! One cell: draw, compare, time, record.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use cvr_core::metrics::{ImageError, error_picture};
use cvr_core::pipeline::Cell;
use cvr_core::render::{Image, write_png};
use cvr_core::volume::{BrickSource, FiniteVolume};
use cvr_engine::timing::{PairBudget, paired};

use super::encoded::Encoded;
use super::record::Record;
use super::skipping;
use super::stage::Stage;
use super::target::{Decoded, Picture, Target, VoxelSource};

/// Folder of the pictures, below the report's.
pub const IMAGES: &str = "images";

/// A record with all that is known of a cell before it runs; it says *failed* until it has run.
#[must_use]
pub fn empty_record(cell: &Cell, volume: &FiniteVolume, target: &Target) -> Record {
    let layout = volume.layout();
    let mut record = Record {
        volume: cell.volume.clone(),
        codec: cell.codec.clone(),
        settings: cell.settings.to_string(),
        site: cell.site.name().to_owned(),
        filter: cell.filter.name().to_owned(),
        renderer: cell.renderer.clone(),
        scene: cell.scene.clone(),
        skipping: cell.skipping,
        stages: cell.stages,
        device: target.name(),
        driver: target.driver(),
        voxels: layout.voxels(),
        frames: layout.frames,
        replaced_samples: volume.replaced().total(),
        ..Record::default()
    };
    let rounded = volume.replaced().rounded;
    if rounded > 0 {
        record.remark(&format!("{rounded} samples of the input were rounded to single precision"));
    }
    record
}

/// Enters what the codec did to the volume.
pub fn record_encoding(record: &mut Record, encoded: &Encoded, parity: Option<u64>) {
    let voxels = record.voxels as f64;
    record.bits_per_voxel = Some(encoded.file_bytes as f64 * 8.0 / voxels);
    record.file_bytes = Some(encoded.file_bytes);
    record.encode_seconds = Some(encoded.encode_seconds);
    record.decode_seconds = Some(encoded.decode_seconds);
    record.decode_voxels_per_second = Some(voxels / encoded.decode_seconds.max(1e-9));
    record.psnr_db = Some(encoded.error.psnr_db);
    record.foreground_psnr_db = encoded.error.foreground_psnr_db;
    record.max_abs_error = Some(encoded.error.max_abs_error);
    record.error_bound = encoded.error_bound;
    record.parity_mismatches = parity;
    for note in &encoded.notes {
        record.remark(note);
    }
}

/// Draws, compares and times one cell; `decoded` is what its site asks for.
///
/// # Errors
/// A sentence that says what failed; what was measured before it stands in the record. Once `stop` is true, the
/// step after the running one is such a failure.
pub fn run(
    record: &mut Record,
    cell: &Cell,
    encoded: &Encoded,
    decoded: Decoded,
    stage: &mut Stage<'_>,
    folder: &Path,
    stop: &AtomicBool,
) -> Result<(), String> {
    let go_on = || if stop.load(Ordering::Relaxed) { Err("stopped".to_owned()) } else { Ok(()) };
    go_on()?;
    let (decoder, level) = (encoded.decoder.as_ref(), encoded.level);
    let voxels = VoxelSource { codec: &cell.codec, decoder, level, decoded };
    debug_assert_eq!(voxels.site(), cell.site);
    let background = stage.background();
    let mut view = stage.view(cell.filter)?;
    let unskipped = if cell.skipping { Some(stage.picture(&view, &voxels)?) } else { None };
    if cell.skipping {
        let function = &view.transfer_function;
        view.macrocells = Some(encoded.macrocells.classify(decoder, level, function, stop, record)?);
    }
    let picture = stage.picture(&view, &voxels)?;
    record.resident_bytes = picture.resident_bytes();
    record.filtering = Some(picture.filtering().to_owned());
    record.flag_fallbacks(picture.fallback(), stage.baseline.fallback());
    record.flag_blending(picture.blends_in_half());
    let image = picture.image().map_err(|e| e.to_string())?;

    go_on()?;
    let error = ImageError::compare(&stage.reference, &image, background).map_err(|e| e.to_string())?;
    record.image_psnr_db = Some(error.psnr_db);
    record.image_ssim = Some(error.ssim);
    record.image_psnr_whole_db = Some(error.psnr_whole_db);
    record.image_ssim_whole = Some(error.ssim_whole);
    let raw = stage.raw_image(cell.site, cell.filter)?;
    let error = ImageError::compare(raw, &image, background).map_err(|e| e.to_string())?;
    record.codec_image_psnr_db = Some(error.psnr_db);
    record.codec_image_ssim = Some(error.ssim);
    record.image = Some(write_picture(folder, &cell.id(), &image, background)?);
    let name = format!("{IMAGES}/{}.error.png", cell.id());
    let colours = error_picture(&stage.reference, &image, background).map_err(|e| e.to_string())?;
    write_png(&folder.join(&name), image.size(), &colours).map_err(|e| e.to_string())?;
    record.error_image = Some(name);
    if let Some(unskipped) = &unskipped {
        go_on()?;
        let without = unskipped.image().map_err(|e| e.to_string())?;
        skipping::check_picture(record, &image, &without)?;
    }

    let draw = |picture: &Picture<'_>| {
        go_on()?;
        picture.draw().map_err(|e| e.to_string())
    };
    let timing = paired(|| draw(&stage.baseline), || draw(&picture), PairBudget::default())?;
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
    record.flag_noise();
    Ok(())
}

/// Writes a picture below the report's folder; returns its path relative to it.
///
/// # Errors
/// When the file cannot be written.
pub fn write_picture(folder: &Path, id: &str, image: &Image, background: [f32; 3]) -> Result<String, String> {
    let name = format!("{IMAGES}/{id}.png");
    image.write_png(&folder.join(&name), background).map_err(|e| e.to_string())?;
    Ok(name)
}
