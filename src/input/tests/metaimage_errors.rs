//! MetaImage headers with one fault each, and the message that each gives; then headerless files and paths.

use cvr_core::volume::{Extent, SampleType, StoredType};

use super::{Folder, zlib};
use crate::input::{RawLayout, open, open_raw, write_nrrd};

const GOOD: [&str; 6] = [
    "ObjectType = Image",
    "NDims = 3",
    "BinaryDataByteOrderMSB = False",
    "DimSize = 3 4 2",
    "ElementType = MET_SHORT",
    "ElementDataFile = LOCAL",
];
const DATA: [u8; 48] = [0; 48];

fn refusal(lines: &[&str]) -> String {
    Folder::new().refusal("v.mha", &format!("{}\n", lines.join("\n")), &DATA)
}

fn with(at: usize, line: &str) -> String {
    let mut lines = GOOD;
    lines[at - 1] = line;
    refusal(&lines)
}

/// The message with one line more, before `ElementDataFile`, as line 6.
fn plus(line: &str) -> String {
    refusal(&[&GOOD[..5], &[line], &GOOD[5..]].concat())
}

#[test]
fn the_unchanged_header_is_good() {
    let folder = Folder::new();
    assert!(open(&folder.write("v.mha", &format!("{}\n", GOOD.join("\n")), &DATA)).is_ok());
}

#[test]
fn what_is_not_supported() {
    assert_eq!(
        with(1, "ObjectType = Tube"),
        "v.mha, line 1: `ObjectType` `Tube` is not supported; supported: Image"
    );
    assert_eq!(
        with(2, "NDims = 5"),
        "v.mha, line 2: `NDims` `5` is not supported; supported: NDims = 3, or 4 for frames"
    );
    assert_eq!(
        with(5, "ElementType = MET_STRING"),
        "v.mha, line 5: `ElementType` `MET_STRING` is not supported; \
         supported: MET_UCHAR, MET_CHAR, MET_USHORT, MET_SHORT, MET_UINT, MET_INT, MET_ULONG, MET_LONG, \
         MET_ULONG_LONG, MET_LONG_LONG, MET_FLOAT, MET_DOUBLE"
    );
    for series in ["LIST", "slice%03d.raw 1 10 1"] {
        assert_eq!(
            with(6, &format!("ElementDataFile = {series}")),
            format!(
                "v.mha, line 6: `ElementDataFile` `{series}` is not supported; \
                 supported: LOCAL or one data file, not one file per slice; save the volume as a whole"
            )
        );
    }
    assert_eq!(
        plus("ElementNumberOfChannels = 2"),
        "v.mha, line 6: `ElementNumberOfChannels` `2` is not supported; supported: 1 (scalar) or 3 (RGB)"
    );
    assert_eq!(
        plus("BinaryData = False"),
        "v.mha, line 6: `BinaryData` `False` is not supported; supported: BinaryData = True"
    );
}

#[test]
fn malformed_values() {
    assert_eq!(
        with(4, "DimSize = 3 4 0"),
        "v.mha, line 4: `DimSize` is `3 4 0`; \
         wanted: three whole numbers from 1 to 4294967295, the voxels along x, y and z"
    );
    for spacing in ["1 1", "1 NaN 1", "0 1 1", "1 1 -1"] {
        assert_eq!(
            plus(&format!("ElementSpacing = {spacing}")),
            format!(
                "v.mha, line 6: `ElementSpacing` is `{spacing}`; wanted: three positive, finite lengths, \
                 the spacing along x, y and z (without the field: 1 1 1)"
            )
        );
    }
    assert_eq!(
        plus("CompressedData = Maybe"),
        "v.mha, line 6: `CompressedData` is `Maybe`; wanted: `True` or `False`"
    );
    assert_eq!(
        plus("HeaderSize = -2"),
        "v.mha, line 6: `HeaderSize` is `-2`; \
         wanted: a whole number of bytes, or -1 for data at the end of the file"
    );
    assert_eq!(
        plus("HeaderSize = -1\nCompressedData = True"),
        "v.mha, line 6: `HeaderSize` is `-1`; \
         wanted: a whole number of bytes (-1 goes with uncompressed data only)"
    );
    assert_eq!(
        plus("HeaderSize = 9223372036854775807"),
        "v.mha: 3×4×2 voxels of i16 take 48 bytes, but only 0 are there; \
         the file is cut short, or the dimensions, type or skip are wrong"
    );
    assert_eq!(
        with(4, "DimSize = 4096 4096 4096"),
        "v.mha, line 4: 4096×4096×4096 voxels take 137438953472 bytes, \
         more than the limit of 8589934592 (2^33); crop or downsample the volume"
    );
}

#[test]
fn missing_repeated_and_contradicting_keys() {
    for (at, name, example) in [
        (2, "NDims", "NDims = 3"),
        (4, "DimSize", "DimSize = 256 256 128"),
        (5, "ElementType", "ElementType = MET_UCHAR"),
    ] {
        assert_eq!(
            with(at, "Own = 1"),
            format!("v.mha: the header has no `{name}`; add a line like `{example}`")
        );
    }
    assert_eq!(
        Folder::new().refusal("v.mhd", &GOOD[..5].join("\n"), &[]),
        "v.mhd: the header has no `ElementDataFile`; add a line like `ElementDataFile = LOCAL`"
    );
    assert_eq!(
        plus("DimSize = 3 4 2"),
        "v.mha, line 6: `DimSize` stands in line 4 already; keep one of the two"
    );
    assert_eq!(
        plus("ElementByteOrderMSB = True"),
        "v.mha, line 6: `ElementByteOrderMSB` contradicts `BinaryDataByteOrderMSB` of line 3; keep one of the two"
    );
    assert_eq!(
        plus("no sign"),
        "v.mha, line 6: `no sign` is no header line; wanted: `Key = Value`, up to `ElementDataFile = …`"
    );
}

#[test]
fn data_that_do_not_fit() {
    let folder = Folder::new();
    let header = format!("CompressedData = True\n{}\n", GOOD.join("\n"));
    let refusal = |data: &[u8]| folder.refusal("v.mha", &header, data);
    let whole = zlib(&DATA);
    assert_eq!(
        refusal(&zlib(&DATA[1..])),
        "v.mha: 3×4×2 voxels of i16 take 48 bytes, but the zlib stream holds only 47; \
         correct the header's dimensions or type"
    );
    assert_eq!(
        refusal(&zlib(&[0; 49])),
        "v.mha: 3×4×2 voxels of i16 take 48 bytes, but the zlib stream holds more; \
         correct the header's dimensions or type"
    );
    assert_eq!(
        refusal(&whole[..whole.len() - 1]),
        "v.mha: the zlib stream is damaged after 48 of 48 bytes (incomplete deflate stream); fetch the file again"
    );
    assert_eq!(refusal(&[&whole[..], b"tail"].concat()), "v.mha: bytes follow the zlib stream; remove them");
    let claimed = header.replace("DimSize", "CompressedDataSize = 5\nDimSize");
    assert_eq!(
        folder.refusal("v.mha", &claimed, &whole),
        format!(
            "v.mha: the compressed data take {} bytes, the header says 5; \
             fetch the file again, or correct the header",
            whole.len()
        )
    );
    assert_eq!(
        folder.refusal("v.mhd", &GOOD.join("\n").replace("LOCAL", "gone.raw"), &[]),
        "gone.raw (data file of v.mhd, line 6): cannot open the file: No such file or directory (os error 2)"
    );
}

#[test]
fn headerless_files() {
    let folder = Folder::new();
    let path = folder.write("v.raw", "", &DATA);
    let spec = RawLayout::new(Extent::new(3, 4, 2).unwrap(), StoredType::F32);
    let refusal = |spec: &RawLayout| folder.message(open_raw(&path, spec));
    assert_eq!(
        refusal(&spec),
        "v.raw: 3×4×2 voxels of f32 take 96 bytes, but only 48 are there; \
         the file is cut short, or the dimensions, type or skip are wrong"
    );
    assert_eq!(
        refusal(&RawLayout { stored: StoredType::U8, skip_bytes: 3, ..spec }),
        "v.raw: 3×4×2 voxels of u8 take 24 bytes, but 45 are there; \
         correct the dimensions or type, or skip what stands in front of the voxels"
    );
    assert_eq!(
        refusal(&RawLayout { skip_bytes: u64::MAX, ..spec }),
        "v.raw: 3×4×2 voxels of f32 take 96 bytes, but only 0 are there; \
         the file is cut short, or the dimensions, type or skip are wrong"
    );
    assert_eq!(
        refusal(&RawLayout { spacing: [1.0, f64::NAN, 1.0], ..spec }),
        "v.raw: spacing [1.0, NaN, 1.0]: each must be a positive, finite length; \
         correct the spacing, or leave it out for 1"
    );
    assert_eq!(
        refusal(&RawLayout { extent: Extent::cube(2048).unwrap(), ..spec }),
        "v.raw: 2048×2048×2048 voxels take 34359738368 bytes, \
         more than the limit of 8589934592 (2^33); crop or downsample the volume"
    );
}

#[test]
fn files_of_no_known_format() {
    let folder = Folder::new();
    assert_eq!(
        folder.refusal("v.xyz", "<VTK \"x\">", &[0, 200]),
        "v.xyz: neither the extension \"xyz\" nor the first bytes \"<VTK \\\"x\\\">\\x00\\xc8\" identify a format; \
         supported: NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), NIfTI-1 (.nii, .nii.gz), VTK image data (.vti), \
         NumPy arrays (.npy), TIFF stacks (.tif), folders of TIFF or PNG slices, and headerless raw files, whose \
         dimensions, sample type and byte order must be given"
    );
    assert_eq!(
        folder.message(open(&folder.path("gone.nrrd"))),
        "gone.nrrd: cannot open the file: No such file or directory (os error 2)"
    );
    assert!(folder.message(open(folder.0.path())).ends_with(
        ": the folder holds no slices; give a folder of .tif, .tiff or .png files; \
         headerless files need their layout: dims and dtype"
    ));
    assert!(folder.refusal("empty.nrrd", "", &[]).starts_with("empty.nrrd, line 1: the magic ``"));
}

#[test]
fn what_cannot_be_written_leaves_nothing() {
    let folder = Folder::new();
    let volume = super::small(SampleType::U8, [1.0; 3]);
    assert!(write_nrrd(&folder.path("no/such/folder.nrrd"), &volume).is_err());
    std::fs::create_dir(folder.path("taken.nrrd")).unwrap();
    assert!(write_nrrd(&folder.path("taken.nrrd"), &volume).is_err());
    assert_eq!(std::fs::read_dir(folder.0.path()).unwrap().count(), 1, "only the folder that was there");
}
