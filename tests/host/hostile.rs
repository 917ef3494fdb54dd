//! Hostile campaigns: thousands of tampered files, equal in every run. `docs/maintainer/hostile.md` describes them, and
//! how to run a long campaign.

mod configurations;
mod containers;
mod mutate;
mod records;
mod volumes;
