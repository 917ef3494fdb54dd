//! What a run leaves on disk, and how an earlier one is found again.

pub mod cell_file;
pub mod flaws;
pub mod folder;
pub mod names;
pub mod results;
pub mod whole_file;
pub mod write_results;
