//! Verdicts on what was measured, breaking points, and the tables that hold them.

use cvr_core::metrics::psnr_db;
use cvr_core::stability::{
    Judgement, ObservedPicture, Reason, Subject, Verdict, judge_picture, judge_voxels,
};
use serde::Serialize;

use super::breaking::{Breaking, breaking};
use super::encoder::EncoderMeasured;
use super::measured::{Ended, Measured};
use super::row::{Row, VOXELS};
use crate::experiment::files::folder::OutFolder;
use crate::experiment::files::whole_file::ResultsError;
use crate::experiment::files::write_results::write_rows;
use crate::experiment::measured::reference::RAW;

/// All verdicts.
#[derive(Debug, Default)]
pub struct Atlas {
    /// Verdict by verdict, in the order of what was measured; voxels first, then scenes.
    pub rows: Vec<Row>,
    /// Dial by dial.
    pub breaking: Vec<Breaking>,
}

impl Atlas {
    /// Judges everything that was measured.
    #[must_use]
    pub fn of(measured: &[Measured]) -> Self {
        let rows: Vec<Row> = measured.iter().flat_map(|cell| rows_of(cell, measured)).collect();
        let breaking = breaking(&rows);
        Self { rows, breaking }
    }

    /// Verdicts for which the codec's word is broken.
    pub fn broken(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| row.scene == VOXELS && row.reason == Some(Reason::Promise))
    }

    /// The worst pictures of codecs that decode: those furthest beyond what the trivial codec, or the easiest step, allows;
    /// at most one of each codec and subject.
    #[must_use]
    pub fn worst(&self, count: usize) -> Vec<&Row> {
        let excess = |row: &Row| {
            let own = row.image_rmse.unwrap_or(0.0);
            own - row.trivial_image_rmse.unwrap_or(own).min(own)
        };
        let mut rows: Vec<&Row> = self
            .rows
            .iter()
            .filter(|row| {
                row.verdict == Verdict::Fails && row.image_rmse.is_some() && row.visible_pixels > Some(0)
            })
            .collect();
        rows.sort_by(|a, b| excess(b).total_cmp(&excess(a)));
        let mut kept: Vec<&Row> = Vec::new();
        for row in rows {
            if kept.len() < count && kept.iter().all(|k| (&k.label, &k.subject) != (&row.label, &row.subject))
            {
                kept.push(row);
            }
        }
        kept
    }

    /// Writes `atlas.csv`, `breaking.csv`, `encoders.csv` and `atlas.json`, each whole or not at all.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(
        &self,
        out: &OutFolder,
        provenance: &impl Serialize,
        encoders: &[EncoderMeasured],
    ) -> Result<(), ResultsError> {
        #[derive(Serialize)]
        struct Whole<'a, P> {
            provenance: &'a P,
            verdicts: &'a [Row],
            breaking: &'a [Breaking],
            encoders: &'a [EncoderMeasured],
        }
        write_rows(out, "atlas.csv", &self.rows)?;
        write_rows(out, "breaking.csv", &self.breaking)?;
        let rows: Vec<EncoderRow> = encoders.iter().map(EncoderRow::of).collect();
        write_rows(out, "encoders.csv", &rows)?;
        let whole = Whole { provenance, verdicts: &self.rows, breaking: &self.breaking, encoders };
        // Numbers and strings always serialise.
        let mut text = serde_json::to_vec_pretty(&whole).unwrap_or_default();
        text.push(b'\n');
        out.write("atlas.json", &text)
    }
}

/// An encoder's stability as a line of a table.
#[derive(Serialize)]
struct EncoderRow<'a> {
    label: &'a str,
    subject: &'a str,
    step: usize,
    problem: Option<&'a str>,
    seeds: usize,
    seed_spread_db: Option<f64>,
    threads: String,
    threads_agree: bool,
    generations: usize,
    first_psnr_db: Option<f64>,
    last_psnr_db: Option<f64>,
    generation_loss_db: Option<f64>,
}

impl<'a> EncoderRow<'a> {
    fn of(measured: &'a EncoderMeasured) -> Self {
        let threads: Vec<String> = measured.threads.iter().map(ToString::to_string).collect();
        Self {
            label: &measured.label,
            subject: &measured.subject,
            step: measured.step,
            problem: measured.problem.as_deref(),
            seeds: measured.seeds.len(),
            seed_spread_db: measured.spread_db(),
            threads: threads.join(" "),
            threads_agree: measured.threads_agree,
            generations: measured.generations.len(),
            first_psnr_db: measured.generations.first().copied().flatten(),
            last_psnr_db: measured.generations.last().copied().flatten(),
            generation_loss_db: measured.generation_loss_db(),
        }
    }
}

/// Voxels, then scenes.
fn rows_of(cell: &Measured, all: &[Measured]) -> Vec<Row> {
    let observed = cell.observed(cell.codec == RAW);
    let same =
        |other: &&Measured| (&other.label, &other.subject, other.step) == (&cell.label, &cell.subject, 1);
    let easiest = all.iter().find(same);
    let finite_psnr = |rmse: f64, peak: f64| Some(psnr_db(rmse * rmse, peak)).filter(|v| v.is_finite());
    let row = |scene: &str, Judgement { verdict, reason }: Judgement| Row {
        codec: cell.codec.clone(),
        label: cell.label.clone(),
        settings: cell.settings.clone(),
        subject: cell.subject.clone(),
        dial: Subject::named(&cell.subject).map_or("", |s| s.dial).to_owned(),
        step: cell.step,
        value: cell.value,
        scene: scene.to_owned(),
        verdict,
        reason,
        sample: cell.sample.clone(),
        voxels: cell.voxels(),
        file_bytes: cell.file_bytes,
        bits_per_voxel: cell.bits_per_voxel(),
        psnr_db: cell.voxel_rmse.and_then(|rmse| finite_psnr(rmse, cell.span)),
        max_abs_error: cell.max_abs_error,
        error_bound: cell.error_bound,
        changed_samples: cell.changed_samples,
        trivial_psnr_db: cell.trivial_voxel_rmse.and_then(|rmse| finite_psnr(rmse, cell.span)),
        image_rmse: None,
        image_psnr_db: None,
        image_ssim: None,
        trivial_image_rmse: None,
        easiest_image_rmse: None,
        visible_pixels: None,
        problem: cell.problem.clone(),
        notes: (!cell.notes.is_empty()).then(|| cell.notes.join("; ")),
    };
    let mut rows = vec![row(VOXELS, judge_voxels(&observed))];
    for picture in &cell.pictures {
        let easiest = easiest.and_then(|cell| cell.picture(&picture.scene)?.rmse);
        // Without a picture the codec's word is broken, or it refuses; that counts first.
        let judged = ObservedPicture {
            own: picture.rmse.unwrap_or(f64::INFINITY),
            trivial: picture.trivial_rmse.unwrap_or(f64::INFINITY),
            easiest,
        };
        rows.push(Row {
            image_rmse: picture.rmse,
            image_psnr_db: picture.rmse.and_then(|rmse| finite_psnr(rmse, 1.0)),
            image_ssim: picture.ssim,
            trivial_image_rmse: picture.trivial_rmse,
            easiest_image_rmse: easiest,
            visible_pixels: Some(picture.visible_pixels),
            ..row(&picture.scene, judge_picture(&observed, judged))
        });
    }
    debug_assert!(cell.word != Ended::Refused || rows.iter().all(|r| r.verdict == Verdict::Refused));
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::measured::Pictured;

    fn cell(step: usize, rmse: f64, trivial: f64) -> Measured {
        Measured {
            codec: "x".to_owned(),
            label: "x".to_owned(),
            subject: "checkerboard".to_owned(),
            step,
            dims: [4; 3],
            frames: 1,
            file_bytes: Some(10),
            raw_bytes: 100,
            span: 2.0,
            voxel_rmse: Some(0.5),
            trivial_voxel_rmse: Some(1.0),
            pictures: vec![Pictured {
                scene: "slope-1".to_owned(),
                visible_pixels: 9,
                rmse: Some(rmse),
                ssim: Some(0.9),
                trivial_rmse: Some(trivial),
            }],
            ..Measured::default()
        }
    }

    #[test]
    fn breaking_points_are_values_of_the_dial() {
        let cells = [cell(1, 0.01, 0.1), cell(2, 0.03, 0.1), cell(3, 0.2, 0.1), cell(4, 0.015, 0.1)];
        let atlas = Atlas::of(&cells);
        let verdicts: Vec<Verdict> =
            atlas.rows.iter().filter(|r| r.scene == "slope-1").map(|r| r.verdict).collect();
        assert_eq!(verdicts, [Verdict::Holds, Verdict::Degrades, Verdict::Fails, Verdict::Holds]);
        let [breaking] = atlas.breaking.as_slice() else { panic!("one dial") };
        assert_eq!((breaking.degrades_at, breaking.fails_at), (Some(8.0), Some(4.0)));
        assert_eq!(
            (breaking.fails_in.as_deref(), breaking.fails_by),
            (Some("slope-1"), Some(Reason::TrivialPicture))
        );
        assert_eq!((breaking.voxels_fail_at, breaking.failing), (None, 1.0 / 8.0));
        assert_eq!(atlas.rows[0].psnr_db, Some(psnr_db(0.25, 2.0)));
        assert_eq!(atlas.worst(5).len(), 1);
    }

    #[test]
    fn broken_words_and_refusals_reach_every_scene() {
        let broken = Measured {
            word: Ended::Broken,
            problem: Some("off".to_owned()),
            voxel_rmse: None,
            ..cell(1, 0.0, 0.0)
        };
        let refused = Measured { word: Ended::Refused, label: "y".to_owned(), ..broken.clone() };
        let atlas = Atlas::of(&[broken, refused]);
        let of = |label: &str| -> Vec<Verdict> {
            atlas.rows.iter().filter(|r| r.label == label).map(|r| r.verdict).collect()
        };
        assert_eq!((of("x"), of("y")), (vec![Verdict::Fails; 2], vec![Verdict::Refused; 2]));
        assert_eq!(atlas.broken().count(), 1);
        assert!(atlas.breaking[1].refused && atlas.breaking[1].fails_at.is_none());
    }

    #[test]
    fn raw_is_exempt() {
        let raw = Measured { codec: RAW.to_owned(), ..cell(1, 0.9, 0.0) };
        assert!(Atlas::of(&[raw]).rows.iter().all(|r| r.verdict == Verdict::Holds));
    }
}
