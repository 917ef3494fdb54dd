//! The heat map: a field per codec and subject; within it a column per step of the dial, the easiest at the left, and a row
//! for the voxels and for every scene.

use std::fmt::Write as _;

use cvr_core::stability::{Reason, Subject, Verdict};

use crate::stability::atlas::Atlas;
use crate::stability::row::Row;

/// Colours and what they mean, the best first.
pub const LEGEND: [(&str, &str); 6] = [
    ("#9ccdb8", "holds"),
    ("#f2c84b", "degrades"),
    ("#e07b39", "fails: the trivial codec of the same rate is better"),
    ("#8a5fc0", "fails: larger than raw, and yet lossy"),
    ("#b3001b", "fails: breaks its promise"),
    ("#d9d5cc", "refused"),
];

/// Width of a step in pixels at full size.
const STEP: usize = 7;
/// Height of a field, about; rows are as high as that allows.
const FIELD: usize = 48;
/// Between fields.
const GAP: usize = 8;
/// Room for the names of subjects.
const TOP: usize = 86;
/// Width of a letter, at most about.
const LETTER: usize = 6;

fn colour(row: &Row) -> &'static str {
    let index = match (row.verdict, row.reason) {
        (Verdict::Holds, _) => 0,
        (Verdict::Degrades, _) => 1,
        (Verdict::Fails, Some(Reason::LargerThanRaw)) => 3,
        (Verdict::Fails, Some(Reason::Promise)) => 4,
        (Verdict::Fails, _) => 2,
        (Verdict::Refused, _) => 5,
    };
    LEGEND[index].0
}

/// The drawing, which needs no colours of a page. Names in it come from the program, and are escaped all the same.
pub fn svg(atlas: &Atlas) -> String {
    let mut labels: Vec<&str> = atlas.rows.iter().map(|r| r.label.as_str()).collect();
    labels.sort_unstable();
    labels.dedup();
    let mut scenes: Vec<&str> = Vec::new();
    for row in &atlas.rows {
        if !scenes.contains(&row.scene.as_str()) {
            scenes.push(&row.scene);
        }
    }
    let steps_of = |subject: &Subject| {
        let mut steps: Vec<usize> =
            atlas.rows.iter().filter(|r| r.subject == subject.name).map(|r| r.step).collect();
        steps.sort_unstable();
        steps.dedup();
        steps
    };
    let columns: Vec<(&Subject, Vec<usize>)> =
        Subject::all().map(|s| (s, steps_of(s))).filter(|(_, steps)| !steps.is_empty()).collect();
    let row_height = (FIELD / scenes.len().max(1)).clamp(4, 12);
    let field = scenes.len() * row_height;
    let left = 16 + LETTER * labels.iter().map(|l| l.len()).max().unwrap_or(0);
    let width = left + columns.iter().map(|(_, steps)| steps.len() * STEP + GAP).sum::<usize>() + 40;
    let height = TOP + labels.len() * (field + GAP) + 8;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
         height=\"{height}\" font-family=\"Liberation Sans, DejaVu Sans, Helvetica, Arial, sans-serif\" \
         font-size=\"11\"><title>Verdicts by codec and subject</title>\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fdfcfa\"/>"
    );
    let mut x = left;
    for (subject, steps) in &columns {
        let middle = x + steps.len() * STEP / 2;
        let _ = write!(
            svg,
            "<text transform=\"translate({},{}) rotate(-52)\" fill=\"#1d2126\">{}</text>",
            middle + 3,
            TOP - 6,
            escaped(subject.name)
        );
        for (i, label) in labels.iter().enumerate() {
            let y = TOP + i * (field + GAP);
            for (column, step) in steps.iter().enumerate() {
                let cells = || {
                    atlas
                        .rows
                        .iter()
                        .filter(|r| r.label == *label && r.subject == subject.name && r.step == *step)
                };
                add_step(&mut svg, cells, (&scenes, row_height), [x + column * STEP, y]);
            }
        }
        x += steps.len() * STEP + GAP;
    }
    for (i, label) in labels.iter().enumerate() {
        let y = TOP + i * (field + GAP) + field / 2 + 4;
        let _ = write!(
            svg,
            "<text x=\"{}\" y=\"{y}\" text-anchor=\"end\" fill=\"#1d2126\">{}</text>",
            left - 8,
            escaped(label)
        );
    }
    svg + "</svg>"
}

/// One column: all scenes of a step.
fn add_step<'a, I: Iterator<Item = &'a Row>>(
    svg: &mut String,
    rows: impl Fn() -> I,
    (scenes, row_height): (&[&str], usize),
    [x, y]: [usize; 2],
) {
    let Some(first) = rows().next() else { return };
    let mut title = format!("{}, {} at {} ({})", first.label, first.subject, first.value, first.dial);
    for row in rows().filter(|r| r.verdict > Verdict::Holds) {
        let reason = row.reason.map_or("", Reason::name);
        let _ = write!(title, "\n{}: {} {reason}", row.scene, row.verdict);
    }
    let _ = write!(svg, "<g><title>{}</title>", escaped(&title));
    for row in rows() {
        let at = scenes.iter().position(|s| *s == row.scene).unwrap_or(0);
        let _ = write!(
            svg,
            "<rect x=\"{x}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"/>",
            y + at * row_height,
            STEP - 1,
            row_height - 1,
            colour(row)
        );
    }
    svg.push_str("</g>");
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
