//! A small version of the stability atlas: a few of its volumes at both ends of their dials, with voxel metrics only.
//!
//! They join the other adversarial volumes, so every property is tested on them. Here they are compared with the
//! trivial codec. A weak method is not a flaw of the code: a coarser grid stores smooth data better than any codebook.
//! So this asks less than the atlas. With the codec's default settings, no volume may come back worse than its mean.
//! Detail that a coarser grid cannot hold may not come back worse than from that grid.

use std::sync::Arc;

use super::{Case, Property, Report};
use crate::stability::{Judgement, Observed, Trial, Trivial, Word, judge_voxels};
use crate::volume::{Extent, FiniteVolume};

/// Longest axis of the volumes, in voxels.
const EDGE: u32 = 12;

/// Subjects, their dial steps counted from the easiest, and whether all of the volume is detail beyond a coarser grid.
const STEPS: &[(&str, &[usize], bool)] = &[
    ("ramp", &[0, 4], false),
    ("noise", &[4], true),
    ("checkerboard", &[4], true),
    ("hot-voxel", &[4], false),
    ("offset", &[3], false),
    ("labels", &[4], false),
    ("non-finite", &[3], false),
    ("slab", &[4], false),
    ("scene-cut", &[4], false),
];

/// A volume of the small atlas.
pub struct Step {
    /// `atlas noise, step 5`.
    pub name: String,
    /// The volume.
    pub volume: FiniteVolume,
    /// Whether all of the volume is detail.
    detail: bool,
}

/// The volumes, in their order.
pub fn steps() -> impl Iterator<Item = Step> {
    let subjects = STEPS
        .iter()
        .filter_map(|(name, steps, detail)| Some((crate::stability::Subject::named(name)?, *steps, *detail)));
    subjects.flat_map(|(subject, steps, detail)| {
        steps.iter().map(move |&step| {
            let name = format!("atlas {}, step {}", subject.name, step + 1);
            Step { name, volume: subject.volume(step, EDGE), detail }
        })
    })
}

/// Compares the decoded stream with the trivial codec.
pub fn check(case: &Case<'_>, step: &Step, report: &mut Report) {
    // Only the default settings are judged. Extreme settings (one training block, one bit per index) may do worse.
    let info = case.codec.info();
    if info.complete(&info.default_settings()).is_ok_and(|default| default != *case.settings) {
        return;
    }
    let trial = Trial::of_stream(case.codec, Arc::clone(&case.stream), case.volume);
    // A broken promise is reported under the property that it breaks.
    if trial.word != Word::Kept {
        return;
    }
    let mean = trial.observed(case.volume, Some(&Trivial::of_grid(case.volume, Extent::ONE)), false);
    let same_rate = trial.observed(case.volume, trial.trivial(case.volume).as_ref(), false);
    let problem = problem(&mean, &same_rate, step.detail);
    report.check(Property::Trivial, problem.is_none(), || problem.unwrap_or_default());
}

/// The problem with these errors, if any. The trivial codec is the mean in `mean`, and has the file's size in
/// `same_rate`. A file larger than the uncompressed volume is not judged: these volumes are too small for tables and
/// codebooks.
fn problem(mean: &Observed, same_rate: &Observed, detail: bool) -> Option<String> {
    let fails = |observed: &Observed| {
        let observed = Observed { larger_than_raw: false, ..observed.clone() };
        matches!(judge_voxels(&observed), Judgement { reason: Some(_), .. })
    };
    let told = |observed: &Observed, what: &str| {
        format!("an error of {:.3e}, that of {what} is {:.3e}", observed.voxels, observed.trivial_voxels)
    };
    if fails(mean) {
        return Some(told(mean, "the volume's mean"));
    }
    let judged = detail && !same_rate.larger_than_raw;
    (judged && fails(same_rate)).then(|| told(same_rate, "a coarser grid of the same bytes"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn observed(voxels: f64, trivial_voxels: f64) -> Observed {
        Observed {
            word: Word::Kept,
            larger_than_raw: false,
            voxels,
            trivial_voxels,
            voxel_floor: 1e-6,
            exempt: false,
        }
    }

    #[test]
    fn worse_than_the_mean_is_found_and_so_is_worse_than_a_coarser_grid_of_detail() {
        let (mean, grid) = (observed(3.0, 4.0), observed(3.0, 2.0));
        assert_eq!(problem(&mean, &observed(3.0, 3.5), true), None);
        assert!(problem(&observed(5.0, 4.0), &grid, false).is_some_and(|p| p.contains("mean")));
        assert!(problem(&mean, &grid, true).is_some_and(|p| p.contains("coarser grid")));
        assert_eq!(problem(&mean, &grid, false), None, "smooth data are a matter of the method");
        let large = Observed { larger_than_raw: true, ..grid };
        assert_eq!(problem(&mean, &large, true), None, "a small volume has room for no table");
    }

    #[test]
    fn every_step_of_the_list_exists() {
        assert_eq!(steps().count(), STEPS.iter().map(|(_, steps, _)| steps.len()).sum::<usize>());
    }
}
