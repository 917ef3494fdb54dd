//! The container opened by other software, with the lines of `docs/codec-author/format.md`.

use std::process::Command;

use super::folder::Folder;

const FORMAT: &str = include_str!("../../docs/codec-author/format.md");

/// The lines of the first Python block.
fn python(document: &str) -> &str {
    let (_, after) = document.split_once("```python\n").unwrap();
    after.split_once("```").unwrap().0
}

#[test]
fn three_lines_of_python_open_a_container() {
    let script = python(FORMAT);
    assert_eq!(script.lines().count(), 3, "{script}");
    let folder = Folder::new();
    folder.write("bonsai.raw", (0..16 * 12 * 8_u32).map(|i| (i * i / 7) as u8).collect::<Vec<u8>>());
    let raw = ["--dims", "16x12x8", "--dtype", "u8"];
    let encode = ["encode", "bonsai.raw", "bonsai.cvr", "--codec", "s3dc", "--set", "block=4"];
    folder.cvr(&[&encode[..], &raw[..]].concat()).exits(0);
    let output = match Command::new("python3").args(["-c", script]).current_dir(folder.root()).output() {
        Err(error) => return println!("skipped: no container is opened by other software: python3: {error}"),
        Ok(output) => output,
    };
    let errors = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() && errors.contains("No module named") {
        let missing = errors.lines().last().unwrap_or_default();
        return println!("skipped: no container is opened by other software: {missing}");
    }
    assert!(output.status.success(), "{errors}");
    let printed = String::from_utf8(output.stdout).unwrap();
    // 4 bits for each of 16 voxels of a row; a minimum and a maximum of 8 bits for each of 24 blocks.
    assert_eq!(printed, "{'index': (1, 8, 12, 2), 'minmax': (1, 12)}\n");
}
