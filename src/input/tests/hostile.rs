//! Files that lie: no panic, no endless loop, no memory beyond what the file can hold.

use proptest::prelude::*;

use super::{Folder, gzip, zlib};
use crate::input::open;

/// A few KiB that decompress to 64 MiB: the reader stops at the byte count that the header gives.
#[test]
fn a_bomb_is_decoded_no_further_than_the_header_says() {
    let folder = Folder::new();
    let bomb = vec![0; 64 << 20];
    let nrrd = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: gzip\n\n";
    let meta = "NDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\nCompressedData = True\nElementDataFile = LOCAL\n";
    assert!(
        folder.refusal("v.nrrd", nrrd, &gzip(&bomb)).contains("64 bytes, but the gzip stream holds more")
    );
    assert!(folder.refusal("v.mha", meta, &zlib(&bomb)).contains("64 bytes, but the zlib stream holds more"));
}

#[test]
fn a_header_without_end_is_read_only_so_far() {
    let folder = Folder::new();
    let long = "# nothing\n".repeat(1 << 18);
    assert!(folder.refusal("v.nrrd", &format!("NRRD0004\n{long}"), &[]).contains("no `dimension`"));
    let one_line = "x".repeat(3 << 20);
    let message = folder.refusal("v.nrrd", &format!("NRRD0004\n{one_line}"), &[]);
    assert!(message.len() < 300, "{message}");
}

/// Lines that a fuzzer would hardly find.
fn line() -> impl Strategy<Value = String> {
    let number = prop_oneof![
        Just("3".to_owned()),
        Just("-1".to_owned()),
        any::<i64>().prop_map(|n| n.to_string()),
        any::<f64>().prop_map(|n| n.to_string()),
        "[ -~]{0,8}",
    ];
    let field = prop::sample::select(vec![
        "type",
        "dimension",
        "sizes",
        "spacings",
        "space directions",
        "encoding",
        "endian",
        "byte skip",
        "line skip",
        "data file",
        "kinds",
        "NDims",
        "DimSize",
        "ElementType",
        "ElementSpacing",
        "HeaderSize",
        "CompressedData",
        "CompressedDataSize",
        "ElementDataFile",
        "ElementByteOrderMSB",
    ]);
    let word = prop::sample::select(vec![
        "uint8",
        "float",
        "raw",
        "gzip",
        "little",
        "big",
        "LOCAL",
        "MET_UCHAR",
        "MET_FLOAT",
        "True",
        "(1,0,0)",
        "none",
        "1 1 1",
        "2 2 2",
        ".",
        "/dev/zero",
    ]);
    let value = prop_oneof![
        word.prop_map(str::to_owned),
        prop::collection::vec(number, 0..5).prop_map(|n| n.join(" ")),
    ];
    (field, prop::sample::select(vec![": ", " = ", ":=", " "]), value)
        .prop_map(|(field, sign, value)| format!("{field}{sign}{value}"))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn any_bytes_after_a_magic(
        magic in prop::sample::select(vec!["NRRD0004\n", "NRRD", "ObjectType = Image\n", ""]),
        bytes in prop::collection::vec(any::<u8>(), 0..400),
    ) {
        let folder = Folder::new();
        for name in ["v.nrrd", "v.mha"] {
            let _ = open(&folder.write(name, magic, &bytes));
        }
    }

    #[test]
    fn any_lines_after_a_magic(
        magic in prop::sample::select(vec!["NRRD0004\n", "ObjectType = Image\n"]),
        lines in prop::collection::vec(line(), 0..12),
        data in prop::collection::vec(any::<u8>(), 0..64),
    ) {
        let folder = Folder::new();
        let header = format!("{magic}{}\n\n", lines.join("\n"));
        let _ = open(&folder.write("v", &header, &data));
    }

    /// A good file with some bytes replaced: read with the claimed size, or refused.
    #[test]
    fn any_damage_to_a_good_file(
        compressed in any::<bool>(),
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        cut in any::<prop::sample::Index>(),
    ) {
        let folder = Folder::new();
        let voxels: Vec<u8> = (0..64).collect();
        let (encoding, data) = if compressed { ("gzip", gzip(&voxels)) } else { ("raw", voxels) };
        let header = format!("NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: {encoding}\n\n");
        let mut file = [header.as_bytes(), &data].concat();
        for (at, byte) in damage {
            let at = at.index(file.len());
            file[at] = byte;
        }
        let _ = open(&folder.write("v.nrrd", "", &file));
        file.truncate(cut.index(file.len()));
        prop_assert!(open(&folder.write("v.nrrd", "", &file)).is_err());
    }
}
