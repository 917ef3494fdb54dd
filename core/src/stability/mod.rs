//! The stability atlas: volumes that provoke, each with a dial of difficulty, and the verdicts on what codecs make of
//! them. What is drawn, and by what, is the application's.

mod subjects;
mod trial;
mod trivial;
mod verdict;

pub use subjects::Subject;
pub use trial::Trial;
pub use trivial::{Trivial, raw_bytes};
pub use verdict::{
    DEGRADED, Judgement, Observed, ObservedPicture, PICTURE_FLOOR, Reason, Verdict, WORSE, Word,
    first_at_least, judge_picture, judge_voxels,
};
