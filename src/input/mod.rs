//! Volumes from files and generators.
