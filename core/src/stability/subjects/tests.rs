//! Tests of the subjects.

use super::Subject;
use crate::volume::{BrickSource as _, FiniteVolume, FrameIndex};

fn at(name: &str, step: usize, edge: u32) -> FiniteVolume {
    Subject::named(name).unwrap().volume(step, edge)
}

fn values(volume: &FiniteVolume, frame: u32) -> Vec<f32> {
    volume.dense().frame_values(FrameIndex(frame))
}

/// The range of steps and sizes that the atlas promises, and names that differ between subjects.
#[test]
fn every_subject_has_a_dial_and_stays_small() {
    let mut names: Vec<&str> = Subject::all().map(|s| s.name).collect();
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!((names.len(), count), (17, 17));
    for subject in Subject::all() {
        assert!(subject.steps.len() >= 5, "{}", subject.name);
        for step in 0..subject.steps.len() {
            for edge in [12, 24, 48] {
                let volume = subject.volume(step, edge);
                let layout = volume.layout();
                assert!(layout.extent.to_array().iter().all(|n| *n <= edge), "{}", subject.name);
                assert!(subject.frame.0 < layout.frames);
            }
        }
    }
}

/// One number per step, so that no subject changes unseen: results of two versions would compare nothing.
#[test]
fn subjects_are_what_they_were() {
    let lines = Subject::all().map(|subject| {
        let sums = (0..subject.steps.len()).map(|step| {
            let volume = subject.volume(step, 16);
            let crc = crc32c::crc32c(volume.dense().samples().as_bytes());
            format!("{crc:08x}")
        });
        format!("{}: {}\n", subject.name, sums.collect::<Vec<_>>().join(" "))
    });
    insta::assert_snapshot!(lines.collect::<String>());
}

#[test]
fn steps_of_a_dial_differ() {
    for subject in Subject::all() {
        let volumes: Vec<FiniteVolume> = (0..subject.steps.len()).map(|s| subject.volume(s, 48)).collect();
        for (i, a) in volumes.iter().enumerate() {
            assert!(volumes[..i].iter().all(|b| a.dense() != b.dense()), "{} {i}", subject.name);
        }
    }
}

#[test]
fn noise_grows_from_nothing() {
    let rough = |step| {
        let values = values(&at("noise", step, 24), 0);
        values.windows(2).map(|w| f64::from((w[1] - w[0]).abs())).sum::<f64>()
    };
    let along: Vec<f64> = (0..5).map(rough).collect();
    assert!(along.windows(2).all(|w| w[0] < w[1]), "{along:?}");
}

#[test]
fn one_voxel_is_hot_and_a_sheet_is_one_voxel_thick() {
    let hot = values(&at("hot-voxel", 4, 24), 0);
    assert_eq!(hot.iter().filter(|v| **v > 40.0).count(), 1);
    assert_eq!(hot.iter().copied().fold(0.0, f32::max), 255.0);
    for step in 0..5 {
        let sheet = at("sheet", step, 24);
        let values = values(&sheet, 0);
        let column = |x: usize, y: usize| (0..24).filter(|z| values[(z * 24 + y) * 24 + x] > 200.0).count();
        assert_eq!(column(12, 12), 1);
        assert!((0..24).all(|x| (0..24).all(|y| column(x, y) <= 1)), "step {step}");
    }
}

/// The dial is the share of blocks: of 1728 at 48³.
#[test]
fn a_front_crosses_as_many_blocks_as_the_dial_says() {
    for (step, blocks) in [(0, 2), (1, 5), (2, 17), (3, 52), (4, 173)] {
        let values = values(&at("front", step, 48), 0);
        let mut crossed: Vec<[usize; 3]> = (0..48_usize.pow(3))
            .filter(|i| values[*i] > 100.0)
            .map(|i| [i % 48 / 4, i / 48 % 48 / 4, i / 48 / 48 / 4])
            .collect();
        crossed.sort_unstable();
        crossed.dedup();
        assert_eq!(crossed.len(), blocks, "step {step}");
    }
}

#[test]
fn phases_move_the_plane_voxel_by_voxel() {
    for (step, border) in [(0, 16), (1, 17), (15, 31)] {
        let row = values(&at("step", step, 48), 0)[..48].to_vec();
        assert_eq!(row.iter().position(|v| *v > 200.0), Some(border));
    }
}

#[test]
fn no_numbers_are_replaced_and_counted() {
    let replaced = |step| at("non-finite", step, 24).replaced().total() as f64 / 13824.0;
    assert_eq!(replaced(0), 0.0);
    assert!((0.08..0.12).contains(&replaced(3)) && (0.45..0.55).contains(&replaced(4)));
    let half = at("non-finite", 4, 24).replaced();
    assert!(half.nan > 0 && half.infinite > 0 && half.subnormal > 0);
}

#[test]
fn there_are_as_many_names_as_the_dial_says() {
    for (step, expected) in [(0, 2), (1, 4), (2, 16)] {
        let mut names: Vec<u32> = values(&at("labels", step, 48), 0).iter().map(|v| *v as u32).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), expected);
    }
}

#[test]
fn magnitudes_span_the_decades_of_the_dial() {
    let range = at("dynamic-range", 4, 48).range();
    assert!(range.min < 1.1e-16 && range.max > 0.9 && range.max <= 1.0, "{range:?}");
    let range = at("offset", 4, 48).range();
    assert!(range.min >= 1.6e7 && range.span() > 10.0, "{range:?}");
}

#[test]
fn frames_differ_only_where_the_dial_says() {
    for name in ["moving-step", "scene-cut"] {
        let still = at(name, 0, 24);
        assert!((1..4).all(|frame| values(&still, frame) == values(&still, 0)), "{name}");
        let changed = at(name, 4, 24);
        assert_ne!(values(&changed, 1), values(&changed, 2), "{name}");
    }
    let quarter = at("scene-cut", 1, 24);
    let (before, after) = (values(&quarter, 1), values(&quarter, 2));
    assert_eq!(before, values(&quarter, 0));
    assert_eq!(after[16 * 16 * 4..], before[16 * 16 * 4..]);
    assert_ne!(after[..16 * 16 * 4], before[..16 * 16 * 4]);
}
