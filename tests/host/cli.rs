//! The program itself: its output, files and exit codes.

mod bad_configurations;
mod bad_files;
mod bounds;
mod compare;
mod examples;
mod explain;
mod extensions;
mod failing_cell;
mod help;
mod hostile_inputs;
mod inputs;
mod lists;
mod messages;
mod output;
mod own_volume;
mod render;
mod rerun;
mod round_trip;
