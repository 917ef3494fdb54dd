//! Files that claim gigabytes, read by a program that may have one.

use std::io::Write as _;
use std::process::{Command, Output};

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};

use super::super::folder::Folder;

#[path = "../../../src/input/tests/lies.rs"]
mod lies;

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut out = GzEncoder::new(Vec::new(), Compression::default());
    out.write_all(bytes).unwrap();
    out.finish().unwrap()
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut out = ZlibEncoder::new(Vec::new(), Compression::default());
    out.write_all(bytes).unwrap();
    out.finish().unwrap()
}

/// `cvr info` with an address space of 1 GiB.
fn info(folder: &Folder, arguments: &[&str]) -> Output {
    Command::new("sh")
        .args(["-c", "ulimit -v 1048576; exec \"$0\" info --max-gb 100 \"$@\"", env!("CARGO_BIN_EXE_cvr")])
        .args(arguments)
        .current_dir(folder.root())
        .env("RAYON_NUM_THREADS", "2")
        .output()
        .unwrap()
}

#[test]
fn no_lie_costs_memory() {
    let folder = Folder::new();
    for lie in lies::all() {
        folder.write(lie.name, &lie.bytes);
        let output = info(&folder, &[lie.name]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{}: {message}", lie.name);
        for word in lie.words.iter().chain([&lie.name]) {
            assert!(message.contains(word), "{word:?} is not in {message}");
        }
        assert!(!message.contains("no memory"), "{message}");
    }
}

/// The limit works: a real volume that is too large for it is refused for lack of memory.
#[test]
fn the_limit_is_felt() {
    let folder = Folder::new();
    let file = std::fs::File::create(folder.path("sparse.raw")).unwrap();
    file.set_len(2 << 30).unwrap();
    let output = info(&folder, &["sparse.raw", "--dims", "2048x1024x1024", "--dtype", "u8"]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("sparse.raw: no memory for 2147483648 bytes of voxels"), "{message}");
}
