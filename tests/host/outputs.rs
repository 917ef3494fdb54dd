//! Outputs that are not regular files: links, device nodes, FIFOs, standard output by its name.
#![cfg(unix)]

use std::os::unix::fs::{FileTypeExt as _, symlink};
use std::process::{Command, Stdio};

use cvr::input::Generator;
use cvr_core::volume::SampleType;

use super::folder::Folder;
use super::volumes::seeded;

/// Words of a command line: those before the output file, and those behind it.
type Words = [Vec<&'static str>; 2];

/// A volume and its container, and the commands that write a file.
fn prepared() -> (Folder, Vec<Words>) {
    let folder = Folder::new();
    folder.volume("v.nrrd", &seeded(Generator::Turbulence, [9, 8, 7], SampleType::U8, 3));
    folder.cvr(&["encode", "v.nrrd", "v.cvr", "--codec", "raw"]).exits(0);
    let commands = vec![
        [vec!["encode", "v.nrrd"], vec!["--codec", "raw"]],
        [vec!["decode", "v.cvr"], vec![]],
        [vec!["render", "v.nrrd"], vec!["--device", "cpu", "--size", "32x32", "--transfer-function", "heat"]],
        [vec!["schema", "--out"], vec![]],
    ];
    (folder, commands)
}

fn endings() -> [&'static str; 4] {
    ["cvr", "nrrd", "png", "json"]
}

#[test]
fn links_are_followed_and_stay() {
    let (folder, commands) = prepared();
    std::fs::create_dir(folder.path("far")).unwrap();
    for ([before, after], ending) in commands.iter().zip(endings()) {
        let (plain, link, target) =
            (format!("plain.{ending}"), format!("link.{ending}"), format!("far/x.{ending}"));
        let write = |name: &str| folder.cvr(&[&before[..], &[name], &after[..]].concat()).exits(0);
        write(&plain);
        symlink(&target, folder.path(&link)).unwrap();
        // First a link without a target, then one to an older file.
        for _ in 0..2 {
            write(&link);
            assert!(folder.path(&link).symlink_metadata().unwrap().is_symlink(), "{link}");
            assert_eq!(folder.read(&target), folder.read(&plain));
            folder.write(&target, "older");
        }
    }
    assert_eq!(
        folder.names().iter().filter(|n| n.starts_with("far/")).count(),
        4,
        "and nothing is left over"
    );
}

#[test]
fn device_nodes_stay_what_they_are() {
    let (folder, commands) = prepared();
    let before = std::fs::symlink_metadata("/dev/null").unwrap().file_type();
    for ([first, after], ending) in commands.iter().zip(endings()) {
        let link = format!("null.{ending}");
        symlink("/dev/null", folder.path(&link)).unwrap();
        folder.cvr(&[&first[..], &[&*link], &after[..]].concat()).exits(0);
        assert_eq!(std::fs::symlink_metadata("/dev/null").unwrap().file_type(), before);
        assert!(folder.path(&link).symlink_metadata().unwrap().is_symlink());
        #[cfg(target_os = "linux")]
        {
            let full = format!("full.{ending}");
            symlink("/dev/full", folder.path(&full)).unwrap();
            let message = folder.cvr(&[&first[..], &[&*full], &after[..]].concat()).refused();
            assert!(message.contains(&full) && message.contains("No space left"), "{message}");
        }
    }
}

#[test]
fn fifos_and_standard_output_get_the_bytes_of_the_file() {
    let (folder, commands) = prepared();
    for ([before, after], ending) in commands.iter().zip(endings()) {
        let plain = format!("plain.{ending}");
        folder.cvr(&[&before[..], &[&*plain], &after[..]].concat()).exits(0);
        let fifo = format!("fifo.{ending}");
        assert!(Command::new("mkfifo").arg(folder.path(&fifo)).status().unwrap().success());
        let reader = std::thread::spawn({
            let path = folder.path(&fifo);
            move || std::fs::read(path).unwrap()
        });
        folder.cvr(&[&before[..], &[&*fifo], &after[..]].concat()).exits(0);
        assert!(reader.join().unwrap() == folder.read(&plain), "{ending}");
        assert!(folder.path(&fifo).symlink_metadata().unwrap().file_type().is_fifo());
        // Through a link whose name gives the format; into a pipe, and after the existing content of a file.
        let out = format!("out.{ending}");
        symlink("/dev/stdout", folder.path(&out)).unwrap();
        let run = |stdout: Stdio| {
            let words = [&before[..], &[out.as_str()], &after[..]].concat();
            let mut command = Command::new(env!("CARGO_BIN_EXE_cvr"));
            let output = command.args(words).current_dir(folder.root()).stdout(stdout).output().unwrap();
            assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
            output.stdout
        };
        assert!(run(Stdio::piped()) == folder.read(&plain), "{ending}: what is told goes elsewhere");
        folder.write("kept", "before\n");
        let kept = std::fs::OpenOptions::new().append(true).open(folder.path("kept")).unwrap();
        run(kept.into());
        assert!(folder.read("kept") == [b"before\n", &folder.read(&plain)[..]].concat(), "{ending}");
    }
}
