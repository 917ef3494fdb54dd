//! Tests of the whole application on a device. Each gets it from `cvr_engine::testing::test_device`, so no test is
//! skipped without a message.

#![allow(clippy::unwrap_used, reason = "helpers of tests, which a failed unwrap fails")]

mod haar;

mod device {
    mod block_texture;
    mod colour;
    mod cut_off;
    mod deferred;
    mod drift;
    mod former_table;
    mod frame_passes;
    mod further_views;
    mod levels;
    mod lost;
    mod own_renderer;
    mod parity;
    mod parity_of_parity;
    mod picture_relations;
    mod picture_twins;
    mod pictures;
    mod ray_pieces;
    mod refusal;
    mod ring;
    mod rounds;
    mod runs;
    mod scenes;
    mod seams;
    mod single;
    mod skipping;
    mod slicing;
    mod splitting;
    mod stages;
    mod subjects;
    mod transfer_function;
}
