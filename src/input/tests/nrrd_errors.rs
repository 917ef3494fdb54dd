//! NRRD headers with one fault each, and the message that each gives.

use super::{Folder, gzip};

/// A good header whose lines a test replaces, drops or adds to: line 1 is the magic, 2 `type`, …
const GOOD: [&str; 6] =
    ["NRRD0004", "type: int16", "dimension: 3", "sizes: 3 4 2", "endian: little", "encoding: raw"];
const DATA: [u8; 48] = [0; 48];

fn refusal(lines: &[&str]) -> String {
    Folder::new().refusal("v.nrrd", &format!("{}\n\n", lines.join("\n")), &DATA)
}

/// The message when line `at` (from 1) reads `line`.
fn with(at: usize, line: &str) -> String {
    let mut lines = GOOD;
    lines[at - 1] = line;
    refusal(&lines)
}

/// The message without line `at`.
fn without(at: usize) -> String {
    let mut lines = GOOD.to_vec();
    lines.remove(at - 1);
    refusal(&lines)
}

/// The message with one line more.
fn plus(line: &str) -> String {
    refusal(&[&GOOD[..], &[line]].concat())
}

#[test]
fn the_unchanged_header_is_good() {
    let folder = Folder::new();
    let path = folder.write("v.nrrd", &format!("{}\n\n", GOOD.join("\n")), &DATA);
    assert!(crate::input::open(&path).is_ok());
}

#[test]
fn magic() {
    assert_eq!(
        with(1, "NRRD0006"),
        "v.nrrd, line 1: the magic `NRRD0006` is not supported; supported: NRRD0001 to NRRD0005"
    );
    assert_eq!(
        with(1, "NRRD00.01"),
        "v.nrrd, line 1: the magic `NRRD00.01` is not supported; supported: NRRD0001 to NRRD0005"
    );
    assert_eq!(
        with(1, "P5 3 4"),
        "v.nrrd, line 1: the magic `P5 3 4` is not supported; supported: NRRD0001 to NRRD0005"
    );
}

#[test]
fn what_is_not_supported() {
    for name in ["half", "block", "long"] {
        assert_eq!(
            with(2, &format!("type: {name}")),
            format!(
                "v.nrrd, line 2: `type` `{name}` is not supported; \
                 supported: uint8, int8, uint16, int16, uint32, int32, uint64, int64, float, double \
                 (and their synonyms)"
            )
        );
    }
    assert_eq!(
        with(3, "dimension: 6"),
        "v.nrrd, line 3: `dimension` `6` is not supported; \
         supported: 3 axes in space, besides at most one of 3 values and one of frames"
    );
    for name in ["bzip2", "bz2", "ascii", "text", "txt", "hex"] {
        assert_eq!(
            with(6, &format!("encoding: {name}")),
            format!("v.nrrd, line 6: `encoding` `{name}` is not supported; supported: raw, gzip")
        );
    }
    assert_eq!(
        plus("kinds: RGB-color domain domain"),
        "v.nrrd, line 7: `kinds` `RGB-color domain domain` is not supported; \
         supported: three axes of kind domain or space, besides at most one of 1 or 3 values (RGB-color, \
         3-color, 3-vector, vector, …) and at most one of frames (list, time)"
    );
    assert_eq!(
        plus("space directions: none (0,1,0) (0,0,1)"),
        "v.nrrd, line 7: `space directions` `none (0,1,0) (0,0,1)` is not supported; \
         supported: three spatial axes, each with a vector"
    );
    for series in ["LIST 2", "slice%03d.raw 1 10 1"] {
        assert_eq!(
            plus(&format!("data file: {series}")),
            format!(
                "v.nrrd, line 7: `data file` `{series}` is not supported; \
                 supported: one data file; join the files of the series into one"
            )
        );
    }
}

#[test]
fn sizes() {
    let wanted = "wanted: three whole numbers from 1 to 4294967295, the voxels along x, y and z";
    for value in ["3 4", "3 4 2 1", "3 4 0", "3 four 2", "3 -4 2", "3 4.0 2", "3 4 4294967296", ""] {
        assert_eq!(
            with(4, &format!("sizes: {value}")),
            format!("v.nrrd, line 4: `sizes` is `{value}`; {wanted}")
        );
    }
    assert_eq!(
        with(4, "sizes: 4294967295 4294967295 4294967295"),
        "v.nrrd, line 4: 4294967295×4294967295×4294967295 voxels take 158456324917848210770600394750 bytes, \
         more than the limit of 8589934592 (2^33); crop or downsample the volume"
    );
    assert_eq!(
        with(4, "sizes: 2048 2048 1024"),
        "v.nrrd: 2048×2048×1024 voxels of i16 take 8589934592 bytes, but only 48 are there; \
         the file is cut short, or the dimensions, type or skip are wrong"
    );
    assert_eq!(
        with(4, "sizes: 2048 2048 1025"),
        "v.nrrd, line 4: 2048×2048×1025 voxels take 8598323200 bytes, \
         more than the limit of 8589934592 (2^33); crop or downsample the volume"
    );
}

#[test]
fn spacings() {
    let wanted =
        "wanted: three positive, finite lengths, the spacing along x, y and z (without the field: 1 1 1)";
    for value in ["1 1", "1 1 nan", "1 0 1", "1 -1 1", "1 inf 1", "1 1 wide", "1e999 1 1"] {
        assert_eq!(
            plus(&format!("spacings: {value}")),
            format!("v.nrrd, line 7: `spacings` is `{value}`; {wanted}")
        );
    }
    for value in [
        "(1,0,0) (0,1,0)",
        "(1,0) (0,1) (1,1)",
        "(0,0,0) (0,1,0) (0,0,1)",
        "1 1 1",
        "(1,0,0",
        "(1,0,0)(0,1,0)(nan,0,1)",
    ] {
        assert_eq!(
            plus(&format!("space directions: {value}")),
            format!(
                "v.nrrd, line 7: `space directions` is `{value}`; \
                 wanted: three vectors of positive, finite length like `(0.5,0,0)`"
            )
        );
    }
    assert_eq!(
        refusal(&[&GOOD[..], &["space directions: (1,0,0) (0,1,0) (0,0,1)", "spacings: 1 1 1"]].concat()),
        "v.nrrd, line 8: `spacings` contradicts `space directions` of line 7; keep one of the two"
    );
}

#[test]
fn missing_repeated_and_unknown_fields() {
    for (at, name, example) in [
        (2, "type", "type: uint8"),
        (3, "dimension", "dimension: 3"),
        (4, "sizes", "sizes: 256 256 128"),
        (5, "endian", "endian: little"),
        (6, "encoding", "encoding: raw"),
    ] {
        assert_eq!(without(at), format!("v.nrrd: the header has no `{name}`; add a line like `{example}`"));
    }
    assert_eq!(plus("Sizes: 3 4 2"), "v.nrrd, line 7: `Sizes` stands in line 4 already; keep one of the two");
    assert_eq!(
        plus("spacing: 2 2 2"),
        "v.nrrd, line 7: NRRD has no field `spacing`; correct its name; keys of your own are written `key:=value`"
    );
    assert_eq!(
        plus("no colon \u{1b}[31m"),
        "v.nrrd, line 7: `no colon \\u{1b}[31m` is no header line; \
         wanted: `field: value`, `key:=value`, or a `# comment`"
    );
    assert_eq!(with(5, "endian: middle"), "v.nrrd, line 5: `endian` is `middle`; wanted: `little` or `big`");
    assert_eq!(
        plus("byte skip: -2"),
        "v.nrrd, line 7: `byte skip` is `-2`; wanted: a whole number of bytes, or -1 for data at the end of the file"
    );
    assert_eq!(
        Folder::new().refusal("v.nhdr", &GOOD.join("\n"), &[]),
        "v.nhdr: the header names no data file, and no empty line ends it; \
         add `data file: NAME`, or an empty line between header and data"
    );
}

#[test]
fn data_that_do_not_fit() {
    let folder = Folder::new();
    let header = format!("{}\n\n", GOOD.join("\n"));
    assert_eq!(
        folder.refusal("v.nrrd", &header, &DATA[1..]),
        "v.nrrd: 3×4×2 voxels of i16 take 48 bytes, but only 47 are there; \
         the file is cut short, or the dimensions, type or skip are wrong"
    );
    assert_eq!(
        folder.refusal("v.nrrd", &header, &[0; 50]),
        "v.nrrd: 3×4×2 voxels of i16 take 48 bytes, but 50 are there; \
         correct the dimensions or type, or skip what stands in front of the voxels"
    );
    let header = header.replace("raw", "gzip");
    let refusal = |data: &[u8]| folder.refusal("v.nrrd", &header, data);
    assert_eq!(
        refusal(&gzip(&DATA[1..])),
        "v.nrrd: 3×4×2 voxels of i16 take 48 bytes, but the gzip stream holds only 47; \
         correct the header's dimensions or type"
    );
    assert_eq!(
        refusal(&gzip(&[0; 49])),
        "v.nrrd: 3×4×2 voxels of i16 take 48 bytes, but the gzip stream holds more; \
         correct the header's dimensions or type"
    );
    let whole = gzip(&DATA);
    assert_eq!(
        refusal(&whole[..whole.len() - 1]),
        "v.nrrd: the gzip stream is damaged after 48 of 48 bytes (unexpected end of file); fetch the file again"
    );
    let mut flipped = whole.clone();
    flipped[whole.len() - 8] ^= 1;
    assert_eq!(
        refusal(&flipped),
        "v.nrrd: the gzip stream is damaged after 48 of 48 bytes \
         (corrupt gzip stream does not have a matching checksum); fetch the file again"
    );
    assert_eq!(
        refusal(&[&whole[..], b"a tail of no meaning"].concat()),
        "v.nrrd: the gzip stream is damaged after 48 of 48 bytes (invalid gzip header); fetch the file again"
    );
    assert_eq!(
        folder.refusal("v.nrrd", &header.replace("3 4 2", "1024 1024 1024"), &whole),
        format!(
            "v.nrrd: 1024×1024×1024 voxels of i16 take 2147483648 bytes, which {} bytes of gzip cannot hold; \
             the file is cut short, or the dimensions or type are wrong",
            whole.len()
        )
    );
    let lines = header.replace("encoding", "line skip: 3\nencoding");
    assert_eq!(
        folder.refusal("v.nrrd", &lines, b"one\ntwo"),
        "v.nrrd: 3 lines are to be skipped, 2 are there; correct `line skip`"
    );
}

#[test]
fn detached_data_are_named_with_their_header() {
    let folder = Folder::new();
    let header = |file: &str| format!("{}\ndata file: {file}\n", GOOD.join("\n"));
    assert_eq!(
        folder.refusal("v.nhdr", &header("../gone/v.raw"), &[]),
        "../gone/v.raw (data file of v.nhdr, line 7): cannot open the file: \
         No such file or directory (os error 2)"
    );
    folder.write("short.raw", "", &DATA[..9]);
    assert_eq!(
        folder.refusal("v.nhdr", &header("short.raw"), &[]),
        "short.raw (data file of v.nhdr, line 7): 3×4×2 voxels of i16 take 48 bytes, but only 9 are there; \
         the file is cut short, or the dimensions, type or skip are wrong"
    );
    assert_eq!(
        folder.refusal("v.nhdr", &header("."), &[]),
        ". (data file of v.nhdr, line 7): not a regular file; give the path of a file that holds a volume"
    );
}
