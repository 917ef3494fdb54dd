//! The examples of `--help`: the program accepts each.

use super::super::folder::Folder;

/// Commands that take files or settings. Their help has examples.
const COMMANDS: [&str; 13] = [
    "run",
    "render",
    "encode",
    "decode",
    "info",
    "convert",
    "shader",
    "merge",
    "compare",
    "explain",
    "schema",
    "check-config",
    "stability",
];

/// The command lines under "Examples:", without their explanations and without environment variables.
fn examples(help: &str) -> Vec<Vec<String>> {
    let below = help.split_once("Examples:\n").map(|(_, below)| below).unwrap_or_default();
    let lines = below.lines().take_while(|line| line.starts_with("  "));
    let words = |line: &str| {
        let command = line.trim().split("   ").next().unwrap_or_default();
        let words = command.split_whitespace().skip_while(|word| *word != "cvr").skip(1);
        words.map(|word| word.trim_matches('\'').to_owned()).collect::<Vec<_>>()
    };
    lines.map(words).collect()
}

#[test]
fn every_example_is_understood() {
    let folder = Folder::new();
    for command in COMMANDS {
        let help = folder.cvr(&[command, "--help"]).exits(0).stdout;
        let examples = examples(&help);
        assert!(!examples.is_empty(), "cvr {command} --help shows no example");
        for example in examples {
            assert_eq!(example[0], command);
            // `--help` comes last: everything before it has then been parsed, and refused if it is wrong.
            let words: Vec<&str> = example.iter().map(String::as_str).chain(["--help"]).collect();
            folder.cvr(&words).exits(0);
        }
    }
    let wrong = folder.cvr(&["render", "a.nrrd", "b.png", "--shadign", "--help"]);
    assert_eq!(wrong.code, Some(2), "an option that does not exist is noticed");
    let wrong = folder.cvr(&["render", "a.nrrd", "b.png", "--size", "large", "--help"]);
    assert_eq!(wrong.code, Some(2), "a value that means nothing is noticed");
}
