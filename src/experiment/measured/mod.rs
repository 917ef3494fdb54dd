//! What is measured of a cell beside what codecs and metrics say, and what it is compared with.

pub mod error_histogram;
pub mod frame_figures;
pub mod pairs;
pub mod picture_errors;
pub mod pool;
pub mod reference;
pub mod skipping;
pub mod surfaces;
