//! One cell: its frames, and the joint results.

use cvr_core::metrics;
use cvr_core::pipeline::{Cell, FrameRange};
use cvr_core::volume::{BrickSource, FiniteVolume};

use super::encoded::Encoded;
use super::frame_run::FrameRun;
use super::stage::Stage;
use crate::experiment::measured::{error_histogram, frame_figures, pool, surfaces};
use crate::experiment::records::record::Record;
use crate::site::target::Target;

/// A record with everything known of a cell before it runs. `series` comes from the codec. Its status is *failed* until
/// the cell has run.
#[must_use]
pub fn empty_record(
    cell: &Cell,
    series: String,
    frames: FrameRange,
    volume: &FiniteVolume,
    target: &Target,
) -> Record {
    let layout = volume.layout();
    let mut record = Record {
        volume: cell.volume.clone(),
        codec: cell.codec_label(),
        settings: cell.settings.to_string(),
        site: cell.site.name().to_owned(),
        filter: cell.filter.name().to_owned(),
        renderer: cell.renderer.clone(),
        scene: cell.scene.clone(),
        skipping: cell.skipping,
        stages: cell.stages,
        resolution: cell.resolution,
        device: target.name(),
        driver: target.driver(),
        voxels: layout.voxels(),
        frames: layout.frames,
        first_frame: frames.first,
        last_frame: frames.last,
        replaced_samples: volume.replaced().total(),
        series,
        ..Record::default()
    };
    record.flag_replaced(volume.replaced(), layout.samples());
    record
}

/// Enters the results of encoding.
pub fn record_encoding(record: &mut Record, encoded: &Encoded) {
    let voxels = record.voxels as f64;
    record.bits_per_voxel = Some(encoded.file_bytes as f64 * 8.0 / voxels);
    record.file_bytes = Some(encoded.file_bytes);
    record.payload_bytes = Some(encoded.payload_bytes);
    record.encode_seconds = Some(encoded.encode_seconds);
    record.decode_seconds = Some(encoded.decode_seconds);
    record.decode_voxels_per_second = Some(voxels / encoded.decode_seconds.max(1e-9));
    record.psnr_db = Some(encoded.error.psnr_db);
    record.foreground_psnr_db = encoded.error.foreground_psnr_db;
    record.max_abs_error = Some(encoded.error.max_abs_error);
    record.error_bound = encoded.error_bound;
    [record.psnr_red_db, record.psnr_green_db, record.psnr_blue_db] = encoded.error.channel_psnr_db;
    for figure in metrics::figures() {
        record.enter(figure.name, encoded.error.value(figure.name));
    }
    for note in &encoded.notes {
        record.remark(note);
    }
}

/// Draws, compares and times every frame of a cell, and checks the codec's promises.
///
/// # Errors
/// A sentence that says what failed; what was measured before it stands in the record. Once the run is stopped, the
/// step after the running one is such a failure.
pub fn run(record: &mut Record, run: &FrameRun<'_>, stage: &mut Stage<'_>) -> Result<(), String> {
    let range = stage.frames();
    if let Some(remark) = stage.shows_nothing() {
        record.remark(remark);
    }
    let (mut frames, mut errors) = (Vec::new(), Vec::new());
    let mut result = Ok(());
    for frame in range.iter() {
        let mut of_frame = Record { first_frame: frame.0, last_frame: frame.0, ..record.clone() };
        match run.run(&mut of_frame, stage, frame) {
            Ok(of_pictures) => errors.push(of_pictures),
            Err(problem) if range.first == range.last => result = Err(problem),
            Err(problem) => result = Err(format!("frame {}: {problem}", frame.0)),
        }
        frames.push(of_frame);
        if result.is_err() {
            break;
        }
    }
    pool::enter(record, &frames, &errors);
    result?;
    let encoded = run.shared.encoded();
    let path = error_histogram::write(run.out, &run.cell.id(), &encoded.histogram);
    record.error_histogram = Some(path.map_err(|e| e.to_string())?);
    surfaces::enter(record, run.shared.surfaces(), encoded, stage)?;
    if encoded.frame_errors.len() > 1 {
        let figures = frame_figures::figures(&encoded.frame_errors, &frames);
        let path = frame_figures::write(run.out, &run.cell.id(), &figures).map_err(|e| e.to_string())?;
        record.frame_figures = Some(path);
    }
    encoded.check_promises()?;
    run.shared.problem(run.cell.site, range).map_or(Ok(()), Err)
}
