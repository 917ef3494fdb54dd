//! Tests of the whole application that need no device.

#![allow(clippy::unwrap_used, reason = "a failed unwrap fails its test, which is what it is for")]

mod haar;

mod host {
    mod adversarial;
    mod cli;
    mod combinations;
    mod configs;
    mod folder;
    mod frame_passes;
    mod golden;
    mod golden_files;
    mod kills;
    mod manifest;
    mod real_volumes;
    mod records;
    mod resume;
    mod scene_combinations;
    mod schema;
    mod shader_text;
    mod shards;
    mod spacing;
    mod volumes;
}
