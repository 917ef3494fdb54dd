//! Verdicts of the stability atlas: when a codec holds, degrades or fails. `docs/user/stability.md` documents the rules;
//! they were settled before anything was run by them.

use serde::{Deserialize, Serialize};

/// The verdict on one codec at one step of a dial: in one scene, or on its voxels.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The codec refuses such volumes and says so: nothing to judge.
    Refused,
    /// Neither of the following.
    Holds,
    /// The picture error is more than twice that at the easiest step of the dial.
    Degrades,
    /// It breaks its own promise, or the trivial codec does better at the same rate.
    Fails,
}

impl Verdict {
    /// Name in tables and records.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Refused => "refused",
            Self::Holds => "holds",
            Self::Degrades => "degrades",
            Self::Fails => "fails",
        }
    }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Why a verdict is not [`Verdict::Holds`]. Of several the first in this order is given.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// The codec does not take such volumes.
    Refused,
    /// An error bound or a value range that was promised does not hold, a decoded value is not a number, or encoding or
    /// decoding ends in an error.
    Promise,
    /// The file is at least as large as the uncompressed one, and yet something is lost.
    LargerThanRaw,
    /// The trivial codec of the same rate is nearer to the voxels.
    TrivialVoxels,
    /// The picture of the trivial codec of the same rate is nearer to the reference.
    TrivialPicture,
    /// More than twice the picture error of the easiest step.
    TwiceEasiest,
}

impl Reason {
    /// Name in tables and records.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Refused => "refused",
            Self::Promise => "promise",
            Self::LargerThanRaw => "larger-than-raw",
            Self::TrivialVoxels => "trivial-voxels",
            Self::TrivialPicture => "trivial-picture",
            Self::TwiceEasiest => "twice-easiest",
        }
    }
}

/// Root mean square errors of pictures up to this count as none: half a step of 8 bits, which no display shows.
pub const PICTURE_FLOOR: f64 = 1.0 / 510.0;

/// How much larger an error must be to be *worse*, as a ratio of root mean squares: two errors within a hundredth are
/// alike.
pub const WORSE: f64 = 1.01;

/// By how much the picture error may grow along a dial, as a ratio of root mean squares.
pub const DEGRADED: f64 = 2.0;

/// Whether the codec kept its promises.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Word {
    /// The codec encoded, decoded, and kept its promises.
    Kept,
    /// It declined the volume; its reason.
    Refused(String),
    /// It did not keep its word; what happened.
    Broken(String),
}

/// Measurements of the voxels of one codec at one dial step. Errors are root mean squares in data units.
#[derive(Clone, Debug, PartialEq)]
pub struct Observed {
    /// What became of its promises.
    pub word: Word,
    /// Whether the file is at least as large as the uncompressed one in the same container.
    pub larger_than_raw: bool,
    /// Error of the decoded voxels.
    pub voxels: f64,
    /// The error of the trivial codec.
    pub trivial_voxels: f64,
    /// Errors up to this count as none: one unit in the last place of the largest magnitude.
    pub voxel_floor: f64,
    /// Whether the codec is the uncompressed one, which only has to keep its promises.
    pub exempt: bool,
}

/// Errors of pictures against the picture of the original volume: root mean squares per visible pixel, full scale 1.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ObservedPicture {
    /// The codec's.
    pub own: f64,
    /// The trivial codec's.
    pub trivial: f64,
    /// The codec's at the easiest step of the dial; `None` where it has no picture there.
    pub easiest: Option<f64>,
}

/// A verdict and why.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Judgement {
    /// The verdict.
    pub verdict: Verdict,
    /// Why it is not *holds*.
    pub reason: Option<Reason>,
}

impl Judgement {
    const HOLDS: Self = Self { verdict: Verdict::Holds, reason: None };

    const fn fails(reason: Reason) -> Self {
        Self { verdict: Verdict::Fails, reason: Some(reason) }
    }
}

/// Whether `own` is larger than `other`, beyond rounding and beyond what counts at all. A value that is not a number is.
fn worse(own: f64, other: f64, floor: f64) -> bool {
    own.is_nan() || own > floor && own > WORSE * other
}

/// The rules that voxels and pictures share.
fn common(observed: &Observed) -> Option<Judgement> {
    match observed.word {
        Word::Refused(_) => {
            return Some(Judgement { verdict: Verdict::Refused, reason: Some(Reason::Refused) });
        }
        Word::Broken(_) => return Some(Judgement::fails(Reason::Promise)),
        Word::Kept if observed.exempt => return Some(Judgement::HOLDS),
        Word::Kept => {}
    }
    let lossy = worse(observed.voxels, 0.0, observed.voxel_floor);
    (observed.larger_than_raw && lossy).then_some(Judgement::fails(Reason::LargerThanRaw))
}

/// The verdict on voxels. They never degrade: that verdict is for pictures only.
#[must_use]
pub fn judge_voxels(observed: &Observed) -> Judgement {
    common(observed).unwrap_or({
        if worse(observed.voxels, observed.trivial_voxels, observed.voxel_floor) {
            Judgement::fails(Reason::TrivialVoxels)
        } else {
            Judgement::HOLDS
        }
    })
}

/// The verdict on one picture.
#[must_use]
pub fn judge_picture(observed: &Observed, picture: ObservedPicture) -> Judgement {
    if let Some(judgement) = common(observed) {
        return judgement;
    }
    let ObservedPicture { own, trivial, easiest } = picture;
    if worse(own, trivial, PICTURE_FLOOR) {
        return Judgement::fails(Reason::TrivialPicture);
    }
    match easiest {
        Some(easiest) if own > DEGRADED * easiest.max(PICTURE_FLOOR) => {
            Judgement { verdict: Verdict::Degrades, reason: Some(Reason::TwiceEasiest) }
        }
        _ => Judgement::HOLDS,
    }
}

/// The breaking point of a dial: the first step, from the easiest, whose verdict is at least `verdict`.
#[must_use]
pub fn first_at_least(verdict: Verdict, along: &[Verdict]) -> Option<usize> {
    along.iter().position(|v| *v >= verdict)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn observed() -> Observed {
        Observed {
            word: Word::Kept,
            larger_than_raw: false,
            voxels: 1.0,
            trivial_voxels: 2.0,
            voxel_floor: 1e-6,
            exempt: false,
        }
    }

    const PICTURE: ObservedPicture = ObservedPicture { own: 0.02, trivial: 0.05, easiest: Some(0.015) };

    fn reason(observed: &Observed, picture: ObservedPicture) -> [Option<Reason>; 2] {
        [judge_voxels(observed).reason, judge_picture(observed, picture).reason]
    }

    #[test]
    fn what_is_better_than_trivial_and_steady_holds() {
        assert_eq!(reason(&observed(), PICTURE), [None, None]);
        assert_eq!(judge_picture(&observed(), PICTURE).verdict, Verdict::Holds);
    }

    #[test]
    fn a_broken_promise_fails_whatever_the_errors_are() {
        let broken = Observed { word: Word::Broken("off by 3".to_owned()), voxels: 0.0, ..observed() };
        assert_eq!(reason(&broken, PICTURE), [Some(Reason::Promise); 2]);
        let raw = Observed { exempt: true, ..broken };
        assert_eq!(reason(&raw, PICTURE), [Some(Reason::Promise); 2]);
    }

    #[test]
    fn a_refusal_is_no_failure() {
        let refused = Observed { word: Word::Refused("too thin".to_owned()), ..observed() };
        assert_eq!(judge_voxels(&refused).verdict, Verdict::Refused);
        assert_eq!(judge_picture(&refused, PICTURE).verdict, Verdict::Refused);
    }

    #[test]
    fn larger_than_raw_fails_only_with_a_loss() {
        let larger = Observed { larger_than_raw: true, trivial_voxels: 0.0, ..observed() };
        assert_eq!(reason(&larger, PICTURE), [Some(Reason::LargerThanRaw); 2]);
        let lossless = Observed { voxels: 1e-7, ..larger.clone() };
        assert_eq!(judge_voxels(&lossless), Judgement::HOLDS);
        let raw = Observed { exempt: true, ..larger };
        assert_eq!(judge_voxels(&raw), Judgement::HOLDS);
    }

    #[test]
    fn worse_than_trivial_fails_where_it_is_worse() {
        let voxels = Observed { voxels: 2.1, ..observed() };
        assert_eq!(reason(&voxels, PICTURE), [Some(Reason::TrivialVoxels), None]);
        let picture = ObservedPicture { own: 0.06, ..PICTURE };
        assert_eq!(reason(&observed(), picture), [None, Some(Reason::TrivialPicture)]);
    }

    #[test]
    fn what_cannot_be_seen_or_told_apart_is_not_worse() {
        let alike = Observed { voxels: 2.01, ..observed() };
        assert_eq!(judge_voxels(&alike), Judgement::HOLDS);
        let exact = Observed { voxels: 5e-7, trivial_voxels: 0.0, ..observed() };
        assert_eq!(judge_voxels(&exact), Judgement::HOLDS);
        let faint = ObservedPicture { own: PICTURE_FLOOR, trivial: 0.0, easiest: Some(0.0) };
        assert_eq!(judge_picture(&observed(), faint), Judgement::HOLDS);
        let seen = ObservedPicture { own: PICTURE_FLOOR * 1.001, ..faint };
        assert_eq!(judge_picture(&observed(), seen).reason, Some(Reason::TrivialPicture));
    }

    #[test]
    fn what_is_no_number_is_worse() {
        assert_eq!(
            judge_voxels(&Observed { voxels: f64::NAN, ..observed() }).reason,
            Some(Reason::TrivialVoxels)
        );
        let picture = ObservedPicture { own: f64::INFINITY, ..PICTURE };
        assert_eq!(judge_picture(&observed(), picture).reason, Some(Reason::TrivialPicture));
    }

    #[test]
    fn twice_the_error_of_the_easiest_step_degrades() {
        let at = |own, easiest| judge_picture(&observed(), ObservedPicture { own, trivial: 1.0, easiest });
        assert_eq!(at(0.030, Some(0.015)), Judgement::HOLDS);
        assert_eq!(at(0.031, Some(0.015)).verdict, Verdict::Degrades);
        // An exact first step does not make the faintest error a degradation.
        assert_eq!(at(2.0 * PICTURE_FLOOR, Some(0.0)), Judgement::HOLDS);
        assert_eq!(at(2.1 * PICTURE_FLOOR, Some(0.0)).reason, Some(Reason::TwiceEasiest));
        assert_eq!(at(0.5, None), Judgement::HOLDS);
    }

    #[test]
    fn the_breaking_point_is_the_first_step_that_fails() {
        use Verdict::{Degrades, Fails, Holds, Refused};
        let along = [Holds, Degrades, Holds, Fails, Holds];
        assert_eq!(first_at_least(Fails, &along), Some(3));
        assert_eq!(first_at_least(Degrades, &along), Some(1));
        assert_eq!(first_at_least(Fails, &[Refused, Holds, Degrades]), None);
    }
}
