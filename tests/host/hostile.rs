//! Hostile campaigns: files that somebody has tampered with, thousands of them, the same ones in every run. What they are and
//! how to run a long campaign tells `docs/maintainer/hostile.md`.

mod configurations;
mod containers;
mod mutate;
mod records;
mod volumes;
