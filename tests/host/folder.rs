//! A temporary folder, and the program run in it as a user would.

use std::path::{Path, PathBuf};
use std::process::Command;

use cvr::input::write_nrrd;
use cvr_core::volume::DenseVolume;

/// A folder that vanishes with the test.
pub struct Folder(tempfile::TempDir);

/// Result of a run of the program.
#[derive(Debug)]
pub struct Ran {
    /// Exit code; `None` after a signal.
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn root(&self) -> &Path {
        self.0.path()
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).unwrap()
    }

    pub fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&self.read(name)).unwrap()
    }

    pub fn volume(&self, name: &str, volume: &DenseVolume) {
        write_nrrd(&self.path(name), volume).unwrap();
    }

    /// All files and folders in here, at any depth, with `/` as separator, sorted.
    pub fn names(&self) -> Vec<String> {
        let mut names = Vec::new();
        let mut folders = vec![self.root().to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                let name = path.strip_prefix(self.root()).unwrap().to_str().unwrap();
                names.push(name.replace(std::path::MAIN_SEPARATOR, "/"));
                if path.is_dir() {
                    folders.push(path);
                }
            }
        }
        names.sort();
        names
    }

    /// Runs the program in this folder, without `CVR_DATA`, its output in pipes.
    #[track_caller]
    pub fn cvr(&self, args: &[&str]) -> Ran {
        let output = Command::new(env!("CARGO_BIN_EXE_cvr"))
            .args(args)
            .current_dir(self.root())
            .env_remove("CVR_DATA")
            .output()
            .unwrap();
        let ran = Ran {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        };
        for text in [&ran.stdout, &ran.stderr] {
            assert!(!moves_the_cursor(text), "cvr {args:?} wrote control characters into a pipe: {text:?}");
        }
        ran
    }
}

impl Ran {
    /// The run, if it ended with this exit code.
    #[track_caller]
    pub fn exits(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "stdout:\n{}\nstderr:\n{}", self.stdout, self.stderr);
        self
    }

    /// The message of a run with bad input: exit code 2, and nothing on standard output.
    #[track_caller]
    pub fn refused(self) -> String {
        let ran = self.exits(2);
        assert_eq!(ran.stdout, "", "what goes wrong is told on standard error");
        assert!(ran.stderr.starts_with("error: "), "{}", ran.stderr);
        ran.stderr
    }
}

/// Whether a text contains control characters, as progress bars and colours do.
fn moves_the_cursor(text: &str) -> bool {
    text.contains(|c: char| c.is_control() && c != '\n')
}

#[test]
fn progress_bars_and_colours_are_noticed() {
    assert!(moves_the_cursor("\r 3/8 cells"));
    assert!(moves_the_cursor("\u{1b}[31merror"));
    assert!(!moves_the_cursor("one line\nand another: 16×16×16\n"));
}

#[test]
#[should_panic(expected = "stderr")]
fn another_exit_code_is_noticed() {
    let _ = Folder::new().cvr(&["codecs"]).exits(2);
}
