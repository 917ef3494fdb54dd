//! Written volumes are read back: every format, sample type, byte order and encoding.

use cvr_core::volume::{BrickSource as _, SampleType};

use super::{Folder, gzip, small, stored, zlib};
use crate::input::{ByteOrder, RawLayout, open, open_raw, write_nrrd};

const SPACING: [f64; 3] = [0.41015625, 0.1, 1.5];
const ORDERS: [ByteOrder; 2] = [ByteOrder::Little, ByteOrder::Big];

fn nrrd_type(sample: SampleType) -> &'static str {
    match sample {
        SampleType::U8 => "unsigned char",
        SampleType::I8 => "signed char",
        SampleType::U16 => "unsigned  short int",
        SampleType::I16 => "int16_t",
        _ => "float",
    }
}

fn metaimage_type(sample: SampleType) -> &'static str {
    match sample {
        SampleType::U8 => "MET_UCHAR",
        SampleType::I8 => "MET_CHAR",
        SampleType::U16 => "MET_USHORT",
        SampleType::I16 => "MET_SHORT",
        _ => "MET_FLOAT",
    }
}

#[test]
fn nrrd_of_every_type_order_and_encoding() {
    let folder = Folder::new();
    for sample in SampleType::ALL {
        let volume = small(sample, SPACING);
        for order in ORDERS {
            let raw = stored(&volume, order);
            for (encoding, data) in [("raw", raw.clone()), ("gzip", gzip(&raw)), ("GZ", gzip(&raw))] {
                let header = format!(
                    "NRRD0005\n# a comment\ntype: {}\nDimension: 3\nsizes: 3 4 2\nspacings: 0.41015625 1e-1 1.5\n\
                     kinds: domain domain space\nencoding: {encoding}\nendian: {}\nkey:=a value: with colon\n",
                    nrrd_type(sample),
                    order.name()
                );
                let attached = folder.write("a.nrrd", &format!("{header}\n"), &data);
                assert_eq!(open(&attached).unwrap(), volume, "{sample} {order:?} {encoding} attached");

                folder.write("d.bin", "", &data);
                for end in ["data file: d.bin", "datafile: ./d.bin\r\n\r\n"] {
                    let detached = folder.write("d.nhdr", &format!("{header}{end}"), &[]);
                    assert_eq!(open(&detached).unwrap(), volume, "{sample} {order:?} {encoding} {end}");
                }
            }
        }
    }
}

#[test]
fn nrrd_skips() {
    let folder = Folder::new();
    let volume = small(SampleType::U16, [1.0; 3]);
    let raw = stored(&volume, ByteOrder::Little);
    let header = |rest: &str| {
        format!("NRRD0001\ntype: ushort\ndimension: 3\nsizes: 3 4 2\nendian: little\n{rest}\n\n")
    };
    let front = |front: &[u8], data: &[u8]| [front, data].concat();
    for (fields, data) in [
        ("encoding: raw\nbyte skip: 5", front(b"abcde", &raw)),
        ("encoding: raw\nline skip: 2", front(b"one\ntwo\n", &raw)),
        ("encoding: raw\nlineskip: 1\nbyteskip: 2", front(b"one\nxx", &raw)),
        ("encoding: raw\nbyte skip: -1", front(b"anything at all", &raw)),
        ("encoding: raw\nbyte skip: -1\nline skip: 1", front(b"one\nand more", &raw)),
        // Lines are passed over before decompression, bytes after it.
        ("encoding: gzip\nline skip: 1\nbyte skip: 3", front(b"one\n", &gzip(&front(b"abc", &raw)))),
        // Several gzip members are one stream.
        ("encoding: gzip", front(&gzip(&raw[..7]), &gzip(&raw[7..]))),
    ] {
        let path = folder.write("a.nrrd", &header(fields), &data);
        assert_eq!(open(&path).unwrap(), volume, "{fields}");
        folder.write("d.raw", "", &data);
        let path = folder.write("d.nhdr", &header(&format!("{fields}\ndata file: d.raw")), &[]);
        assert_eq!(open(&path).unwrap(), volume, "{fields}, detached");
    }
}

#[test]
fn nrrd_spacing_from_directions() {
    let folder = Folder::new();
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 3 4 2\n\
                  space directions: (-3,0,4) ( 0 , 0.5, 0 )  (0,0,2)\nencoding: raw\n\n";
    let path = folder.write("a.nrrd", header, &[0; 24]);
    assert_eq!(open(&path).unwrap().layout().spacing, [5.0, 0.5, 2.0]);
}

#[test]
fn metaimage_of_every_type_order_and_encoding() {
    let folder = Folder::new();
    for sample in SampleType::ALL {
        let volume = small(sample, SPACING);
        for order in ORDERS {
            let raw = stored(&volume, order);
            let msb = if order == ByteOrder::Big { "True" } else { "False" };
            for (compressed, data) in [("False", raw.clone()), ("True", zlib(&raw))] {
                for key in ["BinaryDataByteOrderMSB", "ElementByteOrderMSB"] {
                    let header = format!(
                        "ObjectType = Image\nNDims = 3\nBinaryData = True\n{key} = {msb}\n\
                         CompressedData = {compressed}\nTransformMatrix = 1 0 0 0 -1 0 0 0 -1\n\
                         MyOwnKey = 3\nMyOwnKey = 4\n\
                         ElementSpacing = 0.41015625 0.1 1.5\nElementSize = 9 9 9\n\
                         DimSize = 3 4 2\nElementType = {}\n",
                        metaimage_type(sample)
                    );
                    let local = folder.write("a.mha", &format!("{header}ElementDataFile = LOCAL\r\n"), &data);
                    assert_eq!(open(&local).unwrap(), volume, "{sample} {order:?} {compressed} {key}");

                    folder.write("a data file.raw", "", &data);
                    let size = if compressed == "True" { data.len() } else { 0 };
                    let header =
                        format!("{header}CompressedDataSize = {size}\nElementDataFile = a data file.raw");
                    let detached = folder.write("d.mhd", &header, &[]);
                    assert_eq!(open(&detached).unwrap(), volume, "{sample} {order:?} {compressed} detached");
                }
            }
        }
    }
}

#[test]
fn metaimage_header_size_and_fallback_spacing() {
    let folder = Folder::new();
    let volume = small(SampleType::I16, [2.0, 3.0, 4.0]);
    let raw = stored(&volume, ByteOrder::Little);
    let header = "NDims = 3\nDimSize = 3 4 2\nElementSize = 2 3 4\nElementType = MET_SHORT\n";
    let with = |rest: &str| format!("{header}{rest}\n");
    folder.write("d.raw", "123456", &raw);
    folder.write("d.zraw", "123456", &zlib(&raw));
    for rest in [
        "HeaderSize = 6\nElementDataFile = d.raw",
        "HeaderSize = -1\nElementDataFile = d.raw",
        "CompressedData = True\nHeaderSize = 6\nElementDataFile = d.zraw",
    ] {
        let path = folder.write("d.mhd", &with(rest), &[]);
        assert_eq!(open(&path).unwrap(), volume, "{rest}");
    }
    for rest in ["HeaderSize = 0\nElementDataFile = LOCAL", "HeaderSize = -1\nElementDataFile = LOCAL"] {
        let path = folder.write("a.mha", &with(rest), &raw);
        assert_eq!(open(&path).unwrap(), volume, "{rest}");
    }
}

/// The highest compression that deflate can reach, over several steps of decoding.
#[test]
fn a_constant_volume_is_not_mistaken_for_a_lie() {
    let folder = Folder::new();
    let header = "NRRD0004\ntype: short\ndimension: 3\nsizes: 128 256 256\nendian: big\nencoding: gzip\n\n";
    let voxels = vec![0; 128 * 256 * 256 * 2];
    let data = gzip(&voxels);
    assert!(data.len() * 1000 < voxels.len(), "{} bytes", data.len());
    let volume = open(&folder.write("a.nrrd", header, &data)).unwrap();
    assert_eq!(volume.samples().as_bytes(), voxels);
}

#[test]
fn absent_spacing_is_one() {
    let folder = Folder::new();
    let nrrd = "NRRD0001\ntype: uint8\ndimension: 3\nsizes: 3 4 2\nencoding: raw\n\n";
    let meta = "NDims = 3\nDimSize = 3 4 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
    for (name, header) in [("a.nrrd", nrrd), ("a.mha", meta)] {
        let path = folder.write(name, header, &[7; 24]);
        assert_eq!(open(&path).unwrap().layout().spacing, [1.0; 3]);
    }
}

#[test]
fn raw_of_every_type_and_order() {
    let folder = Folder::new();
    for sample in SampleType::ALL {
        let volume = small(sample, SPACING);
        for byte_order in ORDERS {
            for front in ["", "a header of 23 bytes..."] {
                let path = folder.write("a.raw", front, &stored(&volume, byte_order));
                let spec = RawLayout {
                    byte_order,
                    spacing: SPACING,
                    skip_bytes: front.len() as u64,
                    ..RawLayout::new(volume.layout().extent, sample.into())
                };
                assert_eq!(open_raw(&path, &spec).unwrap(), volume, "{sample} {byte_order:?}");
            }
        }
    }
}

#[test]
fn written_nrrd_reads_back() {
    let folder = Folder::new();
    for sample in SampleType::ALL {
        let volume = small(sample, [1e-9, 0.1 + 0.2, 1e9]);
        let path = folder.path("w.nrrd");
        write_nrrd(&path, &volume).unwrap();
        assert_eq!(open(&path).unwrap(), volume, "{sample}");
    }
    let left: Vec<_> = std::fs::read_dir(folder.0.path()).unwrap().collect();
    assert_eq!(left.len(), 1, "no temporary file stays: {left:?}");
}

#[test]
fn the_content_decides_where_it_is_recognised() {
    let folder = Folder::new();
    let nrrd = "NRRD0001\ntype: uint8\ndimension: 3\nsizes: 3 4 2\nencoding: raw\n\n";
    let meta =
        "\nComment = x\nNDims = 3\nDimSize = 3 4 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
    let unusual = "DimSize = 3 4 2\nNDims = 3\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
    for (name, header) in [("a.dat", nrrd), ("b.mha", nrrd), ("c", meta), ("d.MHA", unusual)] {
        assert!(open(&folder.write(name, header, &[7; 24])).is_ok(), "{name}");
    }
}
