//! The program's help.

use super::super::folder::Folder;

/// Every command, with its own options.
const COMMANDS: [(&str, &[&str]); 17] = [
    (
        "run",
        &[
            "<CONFIG>",
            "--out",
            "--volume",
            "--set",
            "--device",
            "--list-cells",
            "--resume",
            "--shard",
            "--cell",
            "--max-gb",
            "--dims",
            "--dtype",
        ],
    ),
    ("merge", &["<DIR>", "--out"]),
    ("compare", &["<RESULTS>", "--csv", "--noise", "Examples:"]),
    ("check-config", &["<CONFIG>", "--set"]),
    (
        "explain",
        &["<CONFIG>", "--set", "--volume", "--device", "--no-estimate", "--max-gb", "--dims", "Examples:"],
    ),
    ("schema", &["--out", "--markdown", "#:schema", "Examples:"]),
    (
        "encode",
        &[
            "<VOLUME>",
            "<OUT>",
            "--codec",
            "--set",
            "--max-gb",
            "--dims",
            "--dtype",
            "--byte-order",
            "--spacing",
        ],
    ),
    ("decode", &["<CONTAINER>", "<OUT>", "--float", "--max-gb"]),
    (
        "render",
        &[
            "<FILE>",
            "<OUT>",
            "--size",
            "--azimuth",
            "--elevation",
            "--zoom",
            "--orthographic",
            "--range",
            "--transfer-function",
            "--shading",
            "--light",
            "--clip-box",
            "--background",
            "--step-voxels",
            "--early-termination",
            "--filter",
            "--site",
            "--renderer",
            "--device",
            "--skip-bytes",
            "--max-gb",
        ],
    ),
    (
        "stability",
        &[
            "[CODEC]...",
            "--quick",
            "--output",
            "--resume",
            "--config",
            "--edge",
            "--list",
            "--max-gb",
            "Examples:",
        ],
    ),
    ("convert", &["<IN>", "<OUT>", "--max-gb", "--dims", "--dtype", "--frames", "--channels", "--spacing"]),
    ("info", &["<FILE>", "--max-gb", "--dims", "--dtype"]),
    ("codecs", &[]),
    ("renderers", &[]),
    ("presets", &[]),
    ("devices", &["--tsv"]),
    (
        "shader",
        &[
            "[FILE]",
            "--codec",
            "--set",
            "--site",
            "--renderer",
            "--filter",
            "--orthographic",
            "--shading",
            "--clip-box",
            "surface, tissue",
        ],
    ),
];

#[test]
fn every_command_tells_its_options() {
    let folder = Folder::new();
    let overview = folder.cvr(&["--help"]).exits(0).stdout;
    for (command, options) in COMMANDS {
        assert!(overview.contains(&format!("\n  {command} ")), "{command} is missing:\n{overview}");
        let help = folder.cvr(&[command, "--help"]).exits(0).stdout;
        for option in options {
            assert!(help.contains(option), "{command}: no {option} in:\n{help}");
        }
        let told = |word: &str| help.contains(&format!("{word} ")) || help.contains(&format!("{word}\n"));
        assert!(!told("--no-such-option") && told("--help"));
    }
    let commands = overview.lines().skip_while(|l| *l != "Commands:").skip(1).take_while(|l| !l.is_empty());
    assert_eq!(
        commands.count(),
        COMMANDS.len() + 1,
        "this test knows every command, and `help`:\n{overview}"
    );
    assert!(overview.contains("Exit codes: 0"), "{overview}");
}

#[test]
fn the_examples_in_the_help_are_commands() {
    let folder = Folder::new();
    let overview = folder.cvr(&["--help"]).exits(0).stdout;
    let examples: Vec<&str> = overview.lines().filter_map(|l| l.strip_prefix("  cvr ")).collect();
    assert!(examples.len() >= 4, "{overview}");
    for example in examples {
        // Words up to the explanation. The files do not exist: the error must say that, not that the words are wrong.
        let words: Vec<&str> = example.split("   ").next().unwrap().split_whitespace().collect();
        let ran = folder.cvr(&words);
        assert!(!ran.stderr.contains("Usage:"), "{example}:\n{}", ran.stderr);
    }
}

#[test]
fn a_wrong_command_line_is_bad_input() {
    let folder = Folder::new();
    for words in [
        &["dance"][..],
        &[],
        &["run"],
        &["encode", "a.nrrd", "b.cvr"],
        &["info", "a.raw", "--dims", "2x2"],
        &["info", "a.raw", "--dims", "2x2x2"],
        &["info", "a.raw", "--dims", "0x2x2", "--dtype", "u8"],
        &["info", "a.raw", "--dims", "2x2x2", "--dtype", "u64"],
        &["render", "a.nrrd", "b.png", "--site", "moon"],
        &["render", "a.nrrd", "b.png", "--size", "0x9"],
        &["render", "a.nrrd", "b.png", "--filter", "cubic"],
        &["render", "a.nrrd", "b.png", "--light", "0,0,0"],
        &["render", "a.nrrd", "b.png", "--light", "1,2"],
        &["render", "a.nrrd", "b.png", "--light", "sun"],
        &["render", "a.nrrd", "b.png", "--light", "1,nan,2"],
        &["render", "a.nrrd", "b.png", "--clip-box", "0,0,0"],
        &["render", "a.nrrd", "b.png", "--clip-box", "0,0,0:1,1,2"],
        &["render", "a.nrrd", "b.png", "--clip-box", "-1,0,0:1,1,1"],
        &["render", "a.nrrd", "b.png", "--clip-box", "0,0.5,0:1,0.5,1"],
        &["render", "a.nrrd", "b.png", "--background", "#00000000"],
        &["render", "a.nrrd", "b.png", "--background", "black"],
        &["info", "a.nrrd", "--max-gb", "0"],
        &["decode", "a.cvr", "b.nrrd", "--max-gb", "2GB"],
    ] {
        let ran = folder.cvr(words).exits(2);
        assert!(ran.stdout.is_empty() && !ran.stderr.is_empty(), "{words:?}");
    }
    assert_eq!(folder.names(), [""; 0]);
}

#[test]
fn the_version_is_that_of_the_package() {
    let text = Folder::new().cvr(&["--version"]).exits(0).stdout;
    assert_eq!(text.trim(), format!("cvr {}", env!("CARGO_PKG_VERSION")));
}
