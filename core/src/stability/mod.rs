//! The stability atlas: volumes that are made to break codecs, each with a dial of difficulty, and the rules of the
//! verdicts. The application draws them.

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
