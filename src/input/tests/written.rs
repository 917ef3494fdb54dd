//! Written volumes are read back bit for bit, with frames and channels, and other software can read them.

use cvr_core::volume::{
    BrickSource as _, DenseVolume, Extent, SampleType, Samples, StoredType, VolumeLayout,
};

use super::Folder;
use crate::input::{ByteOrder, RawLayout};
use crate::input::{InputError, open, open_raw, read, write_npy, write_nrrd};

/// A volume of any shape whose samples all differ.
fn shaped(size: [u32; 3], channels: u32, frames: u32) -> DenseVolume {
    let extent = Extent::try_from(size).unwrap();
    let layout = VolumeLayout { channels, frames, ..VolumeLayout::scalar(extent, SampleType::I16) };
    let samples = Samples::I16((0..layout.samples() as i16).map(|i| i * 7 - 300).collect());
    DenseVolume::new(layout, samples).unwrap()
}

/// Widths of 3 and 1, and three frames: what a reader could mistake for channels.
const SHAPES: [([u32; 3], u32, u32); 9] = [
    ([4, 3, 2], 1, 1),
    ([3, 4, 2], 1, 1),
    ([4, 3, 2], 3, 1),
    ([4, 3, 2], 1, 5),
    ([3, 2, 2], 1, 5),
    ([3, 2, 2], 1, 3),
    ([1, 1, 3], 1, 3),
    ([3, 3, 3], 3, 3),
    ([4, 3, 2], 3, 5),
];

type Write = fn(&std::path::Path, &DenseVolume) -> Result<(), InputError>;

#[test]
fn every_shape_comes_back() {
    let folder = Folder::new();
    let writers: [(&str, Write); 2] = [("v.nrrd", write_nrrd), ("v.npy", write_npy)];
    for (size, channels, frames) in SHAPES {
        let volume = shaped(size, channels, frames);
        for (name, write) in writers {
            let path = folder.path(name);
            write(&path, &volume).unwrap();
            assert_eq!(open(&path).unwrap(), volume, "{name} {size:?} {channels} {frames}");
        }
        let path = folder.write("v.raw", "", volume.samples().as_bytes());
        let raw = RawLayout {
            channels,
            frames,
            byte_order: ByteOrder::NATIVE,
            ..RawLayout::new(volume.layout().extent, StoredType::I16)
        };
        assert_eq!(open_raw(&path, &raw).unwrap(), volume, "raw {size:?} {channels} {frames}");
    }
}

#[test]
fn npy_of_every_type_comes_back() {
    let folder = Folder::new();
    for sample in SampleType::ALL {
        let volume = super::small(sample, [1.0; 3]);
        let path = folder.path("v.npy");
        write_npy(&path, &volume).unwrap();
        assert_eq!(open(&path).unwrap(), volume, "{sample}");
    }
    let missing = write_npy(&folder.path("no/v.npy"), &super::small(SampleType::U8, [1.0; 3])).unwrap_err();
    assert!(missing.to_string().contains("no/v.npy: cannot write the file"), "{missing}");
}

/// The spacing of axes in space stays, that of others is none.
#[test]
fn nrrd_keeps_spacing_beside_frames_and_colours() {
    let folder = Folder::new();
    let volume = shaped([4, 3, 2], 3, 5);
    let spaced = VolumeLayout { spacing: [0.5, 0.1 + 0.2, 1e-9], ..volume.layout().clone() };
    let volume = DenseVolume::new(spaced, volume.samples().clone()).unwrap();
    let path = folder.path("v.nrrd");
    write_nrrd(&path, &volume).unwrap();
    assert_eq!(open(&path).unwrap(), volume);
    let header = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
    assert!(header.contains("spacings: nan 0.5 "), "{header}");
}

#[test]
fn wide_types_of_the_text_formats_are_counted() {
    let folder = Folder::new();
    let doubles: Vec<u8> = (0..24).flat_map(|i| (f64::from(i) * 0.1).to_be_bytes()).collect();
    let exact =
        (0..24).filter(|i| f64::from((f64::from(*i) * 0.1) as f32) == f64::from(*i) * 0.1).count() as u64;
    let nrrd = "NRRD0004\ntype: double\ndimension: 3\nsizes: 3 4 2\nendian: big\nencoding: raw\n\n";
    let meta = "NDims = 3\nDimSize = 3 4 2\nElementType = MET_DOUBLE\nElementByteOrderMSB = True\nElementDataFile = LOCAL\n";
    for (name, header) in [("v.nrrd", nrrd), ("v.mha", meta)] {
        let input = read(&[folder.write(name, header, &doubles)], None, None).unwrap();
        assert_eq!((input.stored, input.rounded), (StoredType::F64, 24 - exact), "{name}");
        assert_eq!(input.volume.samples().get(1), 0.1, "{name}");
        assert_eq!(input.clone().finite().replaced().rounded, 24 - exact, "{name}");
    }
    let raw = RawLayout {
        byte_order: ByteOrder::Big,
        ..RawLayout::new(Extent::new(3, 4, 2).unwrap(), StoredType::F64)
    };
    let input = read(&[folder.write("v.raw", "", &doubles)], Some(&raw), None).unwrap();
    assert_eq!((input.stored, input.rounded), (StoredType::F64, 24 - exact));
}

#[test]
fn nrrd_axes_that_are_not_said() {
    let folder = Folder::new();
    let header = |rest: &str| format!("NRRD0004\ntype: uint8\nencoding: raw\n{rest}\n\n");
    let shape = |rest: &str, bytes: usize| {
        let volume = open(&folder.write("v.nrrd", &header(rest), &vec![1; bytes])).unwrap();
        let layout = volume.layout();
        (layout.extent.to_array(), layout.channels, layout.frames)
    };
    assert_eq!(shape("dimension: 4\nsizes: 4 5 6 2", 240), ([4, 5, 6], 1, 2));
    assert_eq!(shape("dimension: 5\nsizes: 3 4 5 6 2", 720), ([4, 5, 6], 3, 2));
    assert_eq!(
        shape("dimension: 4\nsizes: 3 4 5 6\nkinds: vector space space space", 360),
        ([4, 5, 6], 3, 1)
    );
    assert_eq!(shape("dimension: 4\nsizes: 3 4 5 6\nkinds: ??? space space space", 360), ([4, 5, 6], 3, 1));
    assert_eq!(shape("dimension: 4\nsizes: 2 4 5 6\nkinds: ??? space space space", 240), ([4, 5, 6], 1, 2));
    assert_eq!(
        shape("dimension: 4\nsizes: 3 4 5 6\nspace directions: none (1,0,0) (0,1,0) (0,0,1)", 360),
        ([4, 5, 6], 3, 1)
    );
    let refusal = |rest: &str| folder.refusal("v.nrrd", &header(rest), &[0; 8]);
    assert_eq!(
        refusal("dimension: 4\nsizes: 3 4 5 6"),
        "v.nrrd, line 5: `sizes` `3 4 5 6` may be colours or frames; \
         add `kinds: RGB-color domain domain domain` or `kinds: domain domain domain list`"
    );
    for (rest, words) in [
        ("dimension: 4\nsizes: 2 4 5 6\nkinds: vector space space space", "line 6: `kinds`"),
        ("dimension: 4\nsizes: 3 4 5 6\nkinds: RGB-color list space space", "line 6: `kinds`"),
        ("dimension: 4\nsizes: 3 4 5 6\nkinds: RGB-color space", "4 kinds, one for each axis"),
        ("dimension: 5\nsizes: 3 4 5 6 2\nkinds: list space space space list", "line 6: `kinds`"),
        ("dimension: 4\nsizes: 4 4 5 6\nspacings: 1 nan 1 1", "each axis in space"),
        ("dimension: 4\nsizes: 4 4 5\n", "4 whole numbers"),
    ] {
        let message = refusal(rest);
        assert!(message.contains(words), "{rest:?}: {message}");
    }
}
