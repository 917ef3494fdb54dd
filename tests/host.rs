//! Tests of the whole application that need no device.

#![allow(clippy::unwrap_used, reason = "a failed unwrap fails its test, which is what it is for")]

mod haar;

mod host {
    mod adversarial;
    mod blank;
    mod cli;
    mod combinations;
    mod configs;
    mod copies;
    mod external;
    mod folder;
    mod forms;
    mod frame_passes;
    mod frames;
    mod full_disk;
    mod golden;
    mod golden_files;
    mod hostile;
    mod imports;
    mod input_cases;
    mod kills;
    mod levels;
    mod links;
    mod manifest;
    mod metrics;
    mod once;
    mod one_cell;
    mod opacity;
    mod other_readers;
    mod out_folder;
    mod outputs;
    mod real_volumes;
    mod records;
    mod report_page;
    mod resolutions;
    mod resume;
    mod scene_combinations;
    mod schema;
    #[cfg(unix)]
    mod setup_scripts;
    mod shader_text;
    mod shards;
    mod skipping;
    mod skipping_runs;
    mod spacing;
    mod stability;
    mod stages;
    mod transfer_function;
    mod volumes;
}
