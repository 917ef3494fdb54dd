//! A wrong configuration: a caret under the error, on standard error, and exit code 2.

use super::super::configs::COMPARE;
use super::super::folder::Folder;

/// The error for the documentation's configuration with one piece replaced.
fn message(from: &str, to: &str) -> String {
    assert_eq!(COMPARE.matches(from).count(), 1, "{from:?} must stand once in the example");
    let folder = Folder::new();
    folder.write("x.toml", COMPARE.replace(from, to));
    let checked = folder.cvr(&["check-config", "x.toml"]).refused();
    let run = folder.cvr(&["run", "x.toml", "--device", "cpu"]).refused();
    assert_eq!(checked, run, "`run` and `check-config` say the same");
    assert_eq!(folder.names(), ["x.toml"], "nothing is left behind");
    checked
}

#[test]
fn what_is_wrong_has_a_caret_under_it() {
    let messages = [
        ("step_voxels = 0.5", "stepp_voxels = 0.5"),
        ("seed = 1", "seed = \"one\""),
        ("id = \"s3dc\"", "id = \"s3cd\""),
        ("index_bits = [2, 4]", "index_bit = [2, 4]"),
        ("index_bits = [2, 4]", "index_bits = [2, 5]"),
        ("\"8x8x4\"", "\"8x8\""),
        ("site = [\"inline\", \"host\"]", "site = [\"inline\", \"hots\"]"),
        ("filter = [\"nearest\", \"linear\"]", "filter = \"cubic\""),
        ("renderer = [\"raycasting\"]", "renderer = [\"raytracing\"]"),
        ("\"#ffffffff\"", "\"white\""),
        ("[experiment]", "[experiment"),
    ]
    .map(|(from, to)| message(from, to));
    for message in &messages {
        assert!(message.contains("x.toml:") && message.contains('^'), "{message}");
    }
    insta::assert_snapshot!(messages.join("\n"));
}

#[test]
fn a_wrong_override_points_at_the_override() {
    let folder = Folder::new();
    folder.write("x.toml", COMPARE);
    let messages = [
        "scene.step_voxels=-1",
        "scene.back.step_voxels=1.0",
        "codec.s3dc.block=0",
        "codec.s3dc.blok=4",
        "experiment.seed",
        "pipeline.filter=[\"linear\"",
    ]
    .map(|set| folder.cvr(&["check-config", "x.toml", "--set", set]).refused());
    for message in &messages {
        assert!(message.contains("--set"), "{message}");
    }
    insta::assert_snapshot!(messages.join("\n"));
}

#[test]
fn a_missing_configuration_is_named() {
    let folder = Folder::new();
    for command in ["run", "check-config"] {
        let message = folder.cvr(&[command, "none.toml"]).refused();
        assert!(message.starts_with("error: none.toml: "), "{message}");
    }
    folder.write("latin1.toml", b"[experiment]\nname = \"\xe9\"\n");
    let message = folder.cvr(&["run", "latin1.toml"]).refused();
    assert!(message.contains("latin1.toml"), "{message}");
}

#[test]
fn a_run_in_which_nothing_can_run_is_refused() {
    let folder = Folder::new();
    folder.write("x.toml", COMPARE);
    let ran = folder
        .cvr(&[
            "run",
            "x.toml",
            "--device",
            "cpu",
            "--set",
            "pipeline.filter=optimised-linear",
            "--set",
            "pipeline.site=host",
        ])
        .exits(2);
    assert!(ran.stderr.contains("no combination can run"), "{}", ran.stderr);
    assert!(ran.stdout.contains("fetch_cell"), "the reasons are told: {}", ran.stdout);
    assert_eq!(folder.names(), ["x.toml"]);
}
