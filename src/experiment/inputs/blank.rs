//! Scenes that show nothing, and the reasons in words. Their pictures cannot be judged.

use cvr_core::metrics::visible;
use cvr_core::pipeline::{FrameRange, Scene};
use cvr_core::render::{ColourOpacity, Filter, Image, TransferFunction, View};
use cvr_core::volume::{FrameIndex, ValueRange};

use crate::experiment::records::record::Record;

/// Beginning of remarks on scenes that show nothing.
const SHOWS_NOTHING: &str = "shows nothing";
/// Most ranges of visible values, and most frames, that a warning lists.
const LISTED: usize = 4;

/// Whether a picture shows nothing.
#[must_use]
pub fn is_blank(image: &Image) -> bool {
    !image.pixels().iter().any(visible)
}

/// The remark on a scene whose reference is blank in frames `blank` of `all`. `None` if it is blank in none.
#[must_use]
pub fn remark(view: &View, channels: u32, blank: &[FrameIndex], all: FrameRange) -> Option<String> {
    let reason = reason(view, channels);
    match blank {
        [] => None,
        _ if blank.len() == all.iter().count() => Some(format!("{SHOWS_NOTHING}: {reason}")),
        [one] => Some(format!("{SHOWS_NOTHING} in frame {}: {reason}", one.0)),
        _ => {
            let frames = listed(blank.iter().map(|frame| frame.0.to_string()).collect(), ", ");
            Some(format!("{SHOWS_NOTHING} in frames {frames}: {reason}"))
        }
    }
}

/// The remark on a scene that shows nothing for any volume with values in this range. `None` if that depends on more.
#[must_use]
pub fn foreseen(scene: &Scene, channels: u32, range: ValueRange) -> Option<String> {
    let View { colour_opacity, transfer_function: function, .. } = scene.view(range, Filter::Linear).ok()?;
    let decides = channels == 1 || by_function(&colour_opacity);
    let blank = decides && function.is_transparent(range);
    blank.then(|| format!("{SHOWS_NOTHING}: {}", ranges(&function, range, "")))
}

/// A warning, as terminals and reports have it.
#[must_use]
pub fn warning(scene: &str, volume: &str, remark: &str) -> String {
    let remark = remark.strip_prefix(SHOWS_NOTHING).unwrap_or(remark);
    format!("scene `{scene}` {SHOWS_NOTHING} of volume `{volume}`{remark}")
}

/// The warnings on the scenes of these records, each once.
#[must_use]
pub fn warnings(records: &[Record]) -> Vec<String> {
    let mut warnings = Vec::new();
    for record in records {
        let remarks = record.notes.iter().flat_map(|notes| notes.split("; "));
        for remark in remarks.filter(|remark| remark.starts_with(SHOWS_NOTHING)) {
            let warning = warning(&record.scene, &record.volume, remark);
            if !warnings.contains(&warning) {
                warnings.push(warning);
            }
        }
    }
    warnings
}

/// Why the scene of a view shows nothing. It states both ranges: of visible values, and of the volume's values.
#[must_use]
pub fn reason(view: &View, channels: u32) -> String {
    let range = view.value_range;
    if channels > 1 && !by_function(&view.colour_opacity) {
        return format!(
            "the values are {} to {}, and its opacity table, clip box, camera and step leave nothing to see",
            number(range.min),
            number(range.max)
        );
    }
    let rest = if view.transfer_function.is_transparent(range) {
        ""
    } else {
        ", but opacities, clip box, camera and step leave nothing to see"
    };
    ranges(&view.transfer_function, range, rest)
}

/// Whether a transfer function decides the opacity of colours.
const fn by_function(opacity: &ColourOpacity) -> bool {
    !matches!(opacity, ColourOpacity::Table(_))
}

fn ranges(function: &TransferFunction, range: ValueRange, rest: &str) -> String {
    let ValueRange { min, max } = range;
    let shown = visible_values(function);
    format!(
        "its transfer function shows {shown}, and the values are {} to {}{rest}",
        number(min),
        number(max)
    )
}

/// The values that a transfer function shows, in words.
fn visible_values(function: &TransferFunction) -> String {
    let points = function.points();
    let shows = |i: usize| points[i].rgba[3] > 0.0;
    // A piece before the first point, one between two neighbours, and one behind the last.
    let last = points.len() - 1;
    let ends = |i: usize| {
        let low = if i == 0 { f32::NEG_INFINITY } else { points[i - 1].value };
        [low, points.get(i).map_or(f32::INFINITY, |point| point.value)]
    };
    let mut ranges: Vec<[f32; 2]> = Vec::new();
    for i in 0..=last + 1 {
        if !shows(i.saturating_sub(1)) && !shows(i.min(last)) {
            continue;
        }
        let [low, high] = ends(i);
        match ranges.last_mut() {
            Some(before) if before[1] == low => before[1] = high,
            _ => ranges.push([low, high]),
        }
    }
    let words = ranges.into_iter().map(|[low, high]| match (low.is_finite(), high.is_finite()) {
        (true, true) => format!("{} to {}", number(low), number(high)),
        (true, false) => format!("what is above {}", number(low)),
        (false, true) => format!("what is below {}", number(high)),
        (false, false) => "all values".to_owned(),
    });
    let words: Vec<String> = words.collect();
    if words.is_empty() { "no value at all".to_owned() } else { listed(words, " and ") }
}

/// The first words, and the number of the others.
fn listed(mut words: Vec<String>, between: &str) -> String {
    let more = words.len().saturating_sub(LISTED);
    words.truncate(LISTED);
    let told = words.join(between);
    if more > 0 { format!("{told} and {more} more") } else { told }
}

/// A value as people write it.
fn number(value: f32) -> String {
    let magnitude = value.abs();
    let plain = value == 0.0 || (1e-4..1e7).contains(&magnitude);
    if plain { value.to_string() } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cvr_core::render::ControlPoint;

    fn function(points: &[(f32, f32)]) -> TransferFunction {
        let point = |&(value, alpha): &(f32, f32)| ControlPoint { value, rgba: [1.0, 1.0, 1.0, alpha] };
        TransferFunction::new(points.iter().map(point).collect()).unwrap()
    }

    #[test]
    fn what_a_function_shows_is_told_in_ranges() {
        for (points, told) in [
            (&[(1000.0, 0.0), (2000.0, 1.0)][..], "what is above 1000"),
            (&[(1000.0, 0.5), (2000.0, 0.0)], "what is below 2000"),
            (&[(290.0, 0.0), (300.0, 1.0), (310.0, 0.0)], "290 to 310"),
            (&[(0.0, 1.0), (1.0, 0.0), (2.0, 0.0), (3.0, 1.0)], "what is below 1 and what is above 2"),
            (&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (2.0, 1.0), (2.0, 0.0)], "1 to 2"),
            (&[(0.0, 0.1), (1.0, 0.1)], "all values"),
            (&[(0.0, 0.0), (1.0, 0.0)], "no value at all"),
            (&[(1e30, 0.0), (2e30, 1.0), (3e30, 0.0)], "1e30 to 3e30"),
        ] {
            assert_eq!(visible_values(&function(points)), told);
        }
        let peaks: Vec<(f32, f32)> = (0..7)
            .flat_map(|i| [(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)].map(|(v, a)| (v + 10.0 * i as f32, a)))
            .collect();
        assert_eq!(
            visible_values(&function(&peaks)),
            "0 to 2 and 10 to 12 and 20 to 22 and 30 to 32 and 3 more"
        );
    }

    #[test]
    fn each_scene_is_warned_of_once_and_with_both_ranges() {
        let range = ValueRange { min: 0.0, max: 255.0 };
        let remark = ranges(&function(&[(1000.0, 0.0), (2000.0, 1.0)]), range, "");
        let record = |scene: &str, notes: Option<String>| Record {
            scene: scene.to_owned(),
            volume: "v".to_owned(),
            notes,
            ..Record::default()
        };
        let blank = Some(format!("noisy timing; {SHOWS_NOTHING}: {remark}; more"));
        let later = Some(format!("{SHOWS_NOTHING} in frame 3: {remark}"));
        let records = [record("a", blank.clone()), record("a", blank), record("b", None), record("b", later)];
        let why = "its transfer function shows what is above 1000, and the values are 0 to 255";
        let told = [
            format!("scene `a` shows nothing of volume `v`: {why}"),
            format!("scene `b` shows nothing of volume `v` in frame 3: {why}"),
        ];
        assert_eq!(warnings(&records), told);
    }
}
