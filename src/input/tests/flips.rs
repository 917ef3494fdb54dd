//! One bit of a packed payload turned round: the file is refused, or the voxels are as before. Every format that has a
//! checksum is there.

use std::ops::Range;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use cvr_core::volume::DenseVolume;

use super::tiff_files::{Page, tiff};
use super::{Folder, gzip, lies, zlib};
use crate::input::open;

/// A file, and where its packed payload lies.
struct Packed {
    name: &'static str,
    bytes: Vec<u8>,
    payload: Vec<Range<usize>>,
}

impl Packed {
    /// A payload between a header and a trailer.
    fn between(name: &'static str, header: &str, payload: &[u8], trailer: &str) -> Self {
        let start = header.len();
        let bytes = [header.as_bytes(), payload, trailer.as_bytes()].concat();
        let payload = std::iter::once(start..start + payload.len()).collect();
        Self { name, bytes, payload }
    }
}

const SIZE: [u32; 3] = [12, 11, 10];

fn xorshift(state: &mut u64) -> u64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    *state
}

/// Voxels of 16 bits that pack to about half: a ramp with noise.
fn voxels() -> Vec<u8> {
    let mut state = 0x9e37_79b9_7f4a_7c15;
    let value = |i: u32| (i * 3) as u16 ^ (xorshift(&mut state) % 16) as u16;
    (0..SIZE.iter().product()).map(value).flat_map(u16::to_le_bytes).collect()
}

fn nrrd(encoding: &str) -> String {
    format!("NRRD0004\ntype: uint16\ndimension: 3\nsizes: 12 11 10\nendian: little\nencoding: {encoding}\n\n")
}

/// The table of zlib blocks of VTK, and the blocks.
fn blocks(voxels: &[u8]) -> [Vec<u8>; 2] {
    let blocks: Vec<Vec<u8>> = voxels.chunks(600).map(zlib).collect();
    let last = voxels.len() % 600;
    let head = [blocks.len(), 600, last].into_iter().chain(blocks.iter().map(Vec::len));
    [head.flat_map(|n| (n as u32).to_le_bytes()).collect(), blocks.concat()]
}

/// A VTI file whose payload stands there.
fn vti(name: &'static str, array: &str, before: &str, payload: &[u8], after: &str) -> Packed {
    let extent = "0 11 0 10 0 9";
    let head = format!(
        "<VTKFile type=\"ImageData\" byte_order=\"LittleEndian\" header_type=\"UInt32\" \
         compressor=\"vtkZLibDataCompressor\"><ImageData WholeExtent=\"{extent}\"><Piece Extent=\"{extent}\"><PointData>\
         <DataArray type=\"UInt16\" Name=\"a\" {array}{before}"
    );
    Packed::between(name, &head, payload, after)
}

fn packed() -> Vec<Packed> {
    let voxels = voxels();
    let half = voxels.len() / 2;
    let members = [gzip(&voxels[..half]), gzip(&voxels[half..])].concat();
    let metaimage = "NDims = 3\nDimSize = 12 11 10\nElementType = MET_USHORT\nCompressedData = True\nElementDataFile = LOCAL\n";
    let nifti = gzip(&[lies::nifti(&[3, 12, 11, 10], 512), voxels.clone()].concat());
    let [table, data] = blocks(&voxels);
    let encoded = format!("{}{}", STANDARD.encode(&table), STANDARD.encode(&data));
    let raw = [table, data].concat();
    let closed = "</PointData></Piece></ImageData><AppendedData encoding=";
    let inline = "\n</DataArray></PointData></Piece></ImageData></VTKFile>";
    let tail = "\n  </AppendedData>\n</VTKFile>\n";
    let strips = |pages: Vec<Page>| {
        let (bytes, payload) = tiff(&pages);
        Packed { name: "deflate.tif", bytes, payload }
    };
    let page = |slice: &[u8]| Page {
        bits: 16,
        compression: 8,
        rows_per_strip: 4,
        strips: slice.chunks(4 * 24).map(zlib).collect(),
        ..Page::gray([12, 11], Vec::new())
    };
    vec![
        Packed::between("v.nrrd", &nrrd("gzip"), &gzip(&voxels), ""),
        Packed::between("members.nrrd", &nrrd("gzip"), &members, ""),
        Packed::between("v.mha", metaimage, &zlib(&voxels), ""),
        Packed::between("v.nii.gz", "", &nifti, ""),
        vti("raw.vti", "format=\"appended\" offset=\"0\"/>", &format!("{closed}\"raw\">_"), &raw, tail),
        vti(
            "base64.vti",
            "format=\"appended\" offset=\"0\"/>",
            &format!("{closed}\"base64\">_"),
            encoded.as_bytes(),
            tail,
        ),
        vti("inline.vti", "format=\"binary\">", "\n", encoded.as_bytes(), inline),
        strips(voxels.chunks(264).map(page).collect()),
        picture(&voxels),
    ]
}

/// All voxels as one picture, in several chunks.
fn picture(voxels: &[u8]) -> Packed {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 12, 110);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    let mut writer = encoder.write_header().unwrap();
    let mut stream = writer.stream_writer_with_size(500).unwrap();
    std::io::Write::write_all(&mut stream, voxels).unwrap();
    stream.finish().unwrap();
    writer.finish().unwrap();
    let payload = std::iter::once(0..bytes.len()).collect();
    Packed { name: "v.png", bytes, payload }
}

/// Turns bits round, one at a time, at seeded places of the payload. Says how many files were refused, and which bits
/// gave other voxels.
fn flipped(packed: &Packed, flips: usize) -> (usize, Vec<(usize, u32)>) {
    let folder = Folder::new();
    let read = |bytes: &[u8]| open(&folder.write(packed.name, "", bytes));
    let whole: DenseVolume = read(&packed.bytes).unwrap();
    let places: Vec<usize> = packed.payload.iter().cloned().flatten().collect();
    let mut state = 0x2545_f491_4f6c_dd1d;
    let (mut refused, mut others) = (0, Vec::new());
    for _ in 0..flips {
        let at = places[xorshift(&mut state) as usize % places.len()];
        let bit = (xorshift(&mut state) >> 32) as u32 % 8;
        let mut bytes = packed.bytes.clone();
        bytes[at] ^= 1 << bit;
        match read(&bytes) {
            Err(_) => refused += 1,
            Ok(volume) if volume == whole => {}
            Ok(_) => others.push((at, bit)),
        }
    }
    (refused, others)
}

#[test]
fn no_flipped_bit_of_a_packed_payload_gives_other_voxels() {
    for packed in packed() {
        let (refused, others) = flipped(&packed, 500);
        assert!(others.is_empty(), "{}: other voxels after bits {others:?}", packed.name);
        assert!(refused > 450, "{}: only {refused} of 500 are noticed", packed.name);
    }
}

/// Without a checksum other voxels come, and the comparison sees them.
#[test]
fn the_comparison_sees_other_voxels() {
    let plain = Packed::between("plain.nrrd", &nrrd("raw"), &voxels(), "");
    let (refused, others) = flipped(&plain, 50);
    assert_eq!((refused, others.len()), (0, 50));
}
