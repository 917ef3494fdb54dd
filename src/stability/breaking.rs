//! Breaking points: where on a dial a codec first fails.

use cvr_core::stability::{Reason, Subject, Verdict, first_at_least};
use serde::Serialize;

use super::row::{Row, VOXELS};

/// Where a codec breaks on a dial.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Breaking {
    /// Codec and the settings that are not its defaults.
    pub label: String,
    /// Subject.
    pub subject: String,
    /// What its dial turns.
    pub dial: String,
    /// Steps that were measured.
    pub steps: usize,
    /// Value of the dial at the first step that fails in voxels.
    pub voxels_fail_at: Option<f64>,
    /// Value of the dial at the first step that fails in any scene or in voxels.
    pub fails_at: Option<f64>,
    /// In which scene, the first in the order of scenes.
    pub fails_in: Option<String>,
    /// Why.
    pub fails_by: Option<Reason>,
    /// Value of the dial at the first step that degrades or fails.
    pub degrades_at: Option<f64>,
    /// Share of all verdicts that fail.
    pub failing: f64,
    /// Whether the codec refuses every step.
    pub refused: bool,
}

/// Codec by codec in alphabetical order, subjects in their own.
pub(super) fn breaking(rows: &[Row]) -> Vec<Breaking> {
    let mut labels: Vec<&str> = rows.iter().map(|r| r.label.as_str()).collect();
    labels.sort_unstable();
    labels.dedup();
    let mut all = Vec::new();
    for label in labels {
        for subject in Subject::all() {
            let own: Vec<&Row> =
                rows.iter().filter(|r| r.label == label && r.subject == subject.name).collect();
            if !own.is_empty() {
                all.push(breaking_of(label, subject, &own));
            }
        }
    }
    all
}

fn breaking_of(label: &str, subject: &Subject, rows: &[&Row]) -> Breaking {
    let mut steps: Vec<usize> = rows.iter().map(|r| r.step).collect();
    steps.sort_unstable();
    steps.dedup();
    let at = |step: usize| rows.iter().filter(move |r| r.step == step);
    let along = |scene: Option<&str>| -> Vec<Verdict> {
        let worst = |step: &usize| {
            let rows = at(*step).filter(|r| scene.is_none_or(|scene| r.scene == scene));
            rows.map(|r| r.verdict).max().unwrap_or(Verdict::Refused)
        };
        steps.iter().map(worst).collect()
    };
    let value = |index: usize| subject.steps[steps[index] - 1];
    let fails = first_at_least(Verdict::Fails, &along(None));
    let first = fails.and_then(|index| at(steps[index]).find(|r| r.verdict == Verdict::Fails));
    let failing = rows.iter().filter(|r| r.verdict == Verdict::Fails).count();
    Breaking {
        label: label.to_owned(),
        subject: subject.name.to_owned(),
        dial: subject.dial.to_owned(),
        steps: steps.len(),
        voxels_fail_at: first_at_least(Verdict::Fails, &along(Some(VOXELS))).map(value),
        fails_at: fails.map(value),
        fails_in: first.map(|r| r.scene.clone()),
        fails_by: first.and_then(|r| r.reason),
        degrades_at: first_at_least(Verdict::Degrades, &along(None)).map(value),
        failing: failing as f64 / rows.len() as f64,
        refused: rows.iter().all(|r| r.verdict == Verdict::Refused),
    }
}
