//! Payloads that are longer or shorter than what was said, and streams that are not whole.

use std::io::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use cvr_core::volume::Samples;

use super::tiff_files::{Page, tiff};
use super::{Folder, gzip, zlib};
use crate::input::open;

/// Two arrays of 2×2×2 bytes, appended, and what stands before and behind their data.
fn two_arrays(encoding: &str, compressor: &str, offsets: [usize; 2], data: &[u8]) -> Vec<u8> {
    let extent = "0 1 0 1 0 1";
    let array = |name: &str, offset: usize| {
        format!("<DataArray type=\"UInt8\" Name=\"{name}\" format=\"appended\" offset=\"{offset}\"/>")
    };
    let head = format!(
        "<VTKFile type=\"ImageData\" header_type=\"UInt32\"{compressor}><ImageData WholeExtent=\"{extent}\"><Piece \
         Extent=\"{extent}\"><PointData Scalars=\"a\">{}{}</PointData></Piece></ImageData><AppendedData \
         encoding=\"{encoding}\">\n_",
        array("a", offsets[0]),
        array("b", offsets[1])
    );
    [head.as_bytes(), data, b"\n  </AppendedData>\n</VTKFile>\n"].concat()
}

const VOXELS: [u8; 8] = [1, 2, 3, 4, 5, 6, 7, 8];

fn with_length(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u32).to_le_bytes()[..], bytes].concat()
}

#[test]
fn appended_payloads_are_held_against_what_follows() {
    let folder = Folder::new();
    let payload = with_length(&VOXELS);
    let both = [payload.clone(), payload.clone()].concat();
    let read = |bytes: &[u8]| open(&folder.write("v.vti", "", bytes));
    let whole = two_arrays("raw", "", [0, 12], &both);
    assert_eq!(read(&whole).unwrap().samples(), &Samples::U8(VOXELS.to_vec()));
    // Aligned with zeros, as some programs write.
    let aligned = [&payload[..], &[0; 4], &payload].concat();
    assert!(read(&two_arrays("raw", "", [0, 16], &aligned)).is_ok());
    for (what, offsets, data, words) in [
        ("a byte is lost in the first", [0, 12], [&both[..6], &both[7..]].concat(), "</AppendedData>"),
        ("a byte is lost in the second", [0, 12], both[..23].to_vec(), "`</AppendedData>` begins"),
        ("two bytes are lost in the second", [0, 12], both[..22].to_vec(), "`</AppendedData>` begins"),
        ("three bytes are lost in the second", [0, 12], both[..21].to_vec(), "`</AppendedData>` begins"),
        ("four bytes are lost in the second", [0, 12], both[..20].to_vec(), "`</AppendedData>` begins"),
        ("a byte is gained", [0, 12], [&both[..], b"x"].concat(), "`</AppendedData>` begins"),
        ("the second begins within the first", [0, 11], both.clone(), "only 7 are there"),
        ("nothing is there", [0, 12], Vec::new(), "`</AppendedData>`"),
        ("one is left", [0, 12], payload.clone(), "offset 12"),
    ] {
        let message = folder.message(read(&two_arrays("raw", "", offsets, &data)));
        assert!(message.contains(words) && message.contains("array `a`"), "{what}: {message}");
    }
    let open_end = &whole[..whole.len() - 20];
    assert!(folder.message(read(open_end)).contains("`</AppendedData>` does not follow"));
}

#[test]
fn base64_ends_where_its_values_do() {
    let folder = Folder::new();
    let encoded = STANDARD.encode(with_length(&VOXELS));
    let apart = format!("{}{}", STANDARD.encode(8_u32.to_le_bytes()), STANDARD.encode(VOXELS));
    let read = |offset: usize, data: &str| {
        open(&folder.write("v.vti", "", &two_arrays("base64", "", [0, offset], data.as_bytes())))
    };
    for one in [&encoded, &apart] {
        assert!(read(one.len(), &format!("{one}{one}")).is_ok(), "{one}");
        let wrapped = format!("{}\n{}", &one[..8], &one[8..]);
        assert!(read(one.len() + 1, &format!("{wrapped}{wrapped}")).is_ok(), "{wrapped}");
        for (offset, data) in [
            (one.len(), format!("{one}{one}AAAA")),
            (one.len(), format!("{}{one}", &one[4..])),
            (one.len() + 4, format!("{one}AAAA{one}")),
            (one.len(), one.clone()),
        ] {
            assert!(read(offset, &data).is_err(), "{data}");
        }
    }
    // In place.
    let inline = |array: &str, text: &str| {
        let array = format!("<DataArray type=\"UInt8\" Name=\"a\" {array}>{text}</DataArray>");
        let extent = "Extent=\"0 1 0 1 0 1\"";
        let text = format!(
            "<VTKFile type=\"ImageData\"><ImageData Whole{extent}><Piece {extent}><PointData>{array}</PointData></Piece>\
             </ImageData></VTKFile>"
        );
        open(&folder.write("v.vti", "", text.as_bytes()))
    };
    assert!(inline("format=\"binary\"", &format!("\n {encoded} \n")).is_ok());
    let message = folder.message(inline("format=\"binary\"", &format!("{encoded}AAAA")));
    assert!(message.contains("more values follow"), "{message}");
    assert!(inline("format=\"ascii\"", " 1 2 3 4 5 6 7 8 \n").is_ok());
    let message = folder.message(inline("format=\"ascii\"", "1 2 3 4 5 6 7 8 9"));
    assert!(message.contains("8 bytes, and more values follow"), "{message}");
}

#[test]
fn blocks_of_vtk_are_whole() {
    let folder = Folder::new();
    let read = |stream: &[u8], claimed: usize| {
        let table = [1, 8, 0, claimed as u32].map(u32::to_le_bytes).concat();
        let payload = [&table[..], stream].concat();
        let data = [payload.clone(), payload.clone()].concat();
        let compressor = " compressor=\"vtkZLibDataCompressor\"";
        open(&folder.write("v.vti", "", &two_arrays("raw", compressor, [0, payload.len()], &data)))
    };
    let stream = zlib(&VOXELS);
    assert_eq!(read(&stream, stream.len()).unwrap().samples(), &Samples::U8(VOXELS.to_vec()));
    let mut other = stream.clone();
    *other.last_mut().unwrap() ^= 1;
    assert!(folder.message(read(&other, other.len())).contains("damaged after"));
    let tail = [&stream[..], b"tail"].concat();
    let message = folder.message(read(&tail, tail.len()));
    assert!(message.contains("4 bytes follow the zlib stream"), "{message}");
    let more = zlib(&[VOXELS, VOXELS].concat());
    assert!(folder.message(read(&more, more.len())).contains("more than its table says"));
    let fewer = zlib(&VOXELS[..7]);
    assert!(folder.message(read(&fewer, fewer.len())).contains("1 bytes too early"));
    let cut = &stream[..stream.len() - 4];
    assert!(read(cut, cut.len()).is_err(), "a stream without its checksum");
}

#[test]
fn time_steps_and_arrays_of_one_name_are_refused() {
    let folder = Folder::new();
    let both = [with_length(&VOXELS), with_length(&VOXELS)].concat();
    let text = String::from_utf8(two_arrays("raw", "", [0, 12], &both)).unwrap();
    let steps = text.replace("<ImageData ", "<ImageData TimeValues=\"\n0\n1\n\" ");
    let message = folder.refusal("v.vti", &steps, &[]);
    assert!(message.contains("2 time steps") && message.contains("a file of its own"), "{message}");
    let one = text.replace("<ImageData ", "<ImageData TimeValues=\"0\" ");
    assert!(open(&folder.write("v.vti", &one, &[])).is_ok());
    let message = folder.refusal("v.vti", &text.replace("Name=\"b\"", "Name=\"a\""), &[]);
    assert!(message.contains("2 arrays called `a`"), "{message}");
    let ghosts = text.replace("Name=\"b\"", "Name=\"vtkGhostType\"").replace(" Scalars=\"a\"", "");
    assert_eq!(open(&folder.write("v.vti", &ghosts, &[])).unwrap().samples(), &Samples::U8(VOXELS.to_vec()));
    let only = ghosts.replace("Name=\"a\"", "Name=\"vtkGhostType\"");
    assert!(folder.refusal("v.vti", &only, &[]).contains("no <DataArray>"));
}

#[test]
fn gzip_may_have_members_and_nothing_else() {
    let folder = Folder::new();
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: gzip\n\n";
    let read = |data: &[u8]| open(&folder.write("v.nrrd", header, data));
    let members = [gzip(&VOXELS[..3]), gzip(&[]), gzip(&VOXELS[3..])].concat();
    assert_eq!(read(&members).unwrap().samples(), &Samples::U8(VOXELS.to_vec()));
    let one = gzip(&VOXELS);
    for (what, data) in [
        ("garbage", [&one[..], b"garbage"].concat()),
        ("a member too many", [one.clone(), gzip(&[1])].concat()),
        ("no checksum", one[..one.len() - 8].to_vec()),
        ("no length", one[..one.len() - 4].to_vec()),
        ("another length", [&one[..one.len() - 4], &9_u32.to_le_bytes()].concat()),
        ("another checksum", [&one[..one.len() - 8], &[0; 4], &8_u32.to_le_bytes()].concat()),
    ] {
        assert!(read(&data).is_err(), "{what}");
    }
}

fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut crc = flate2::Crc::new();
    crc.update(kind);
    crc.update(data);
    [&(data.len() as u32).to_be_bytes()[..], kind, data, &crc.sum().to_be_bytes()].concat()
}

/// A picture of 2×2 gray bytes around these chunks.
fn png(chunks: &[Vec<u8>]) -> Vec<u8> {
    let header = [0, 0, 0, 2, 0, 0, 0, 2, 8, 0, 0, 0, 0];
    [&b"\x89PNG\r\n\x1a\n"[..], &chunk(b"IHDR", &header), &chunks.concat(), &chunk(b"IEND", &[])].concat()
}

#[test]
fn the_stream_of_a_png_file_is_whole() {
    let folder = Folder::new();
    let read = |chunks: &[Vec<u8>]| open(&folder.write("v.png", "", &png(chunks)));
    let stream = zlib(&[0, 1, 2, 0, 3, 4]);
    let due = Samples::U8(vec![1, 2, 3, 4]);
    assert_eq!(read(&[chunk(b"IDAT", &stream)]).unwrap().samples(), &due);
    let apart = [
        chunk(b"tEXt", b"a\0b"),
        chunk(b"IDAT", &stream[..5]),
        chunk(b"IDAT", &[]),
        chunk(b"IDAT", &stream[5..]),
    ];
    assert_eq!(read(&apart).unwrap().samples(), &due);
    let mut sum = stream.clone();
    *sum.last_mut().unwrap() ^= 1;
    for (what, data, words) in [
        ("another checksum", sum, "deflate stream"),
        ("no checksum", stream[..stream.len() - 4].to_vec(), "no whole PNG"),
        ("a row too many", zlib(&[0, 1, 2, 0, 3, 4, 0, 5, 6]), "its stream holds more"),
        ("bytes behind", [&stream[..], b"tail"].concat(), "4 bytes follow its stream"),
    ] {
        let message = folder.message(read(&[chunk(b"IDAT", &data)]));
        assert!(message.contains(words), "{what}: {message}");
    }
    let control = [0, 0, 0, 2, 0, 0, 0, 0];
    let frame = [&[0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 2][..], &[0; 8], &[0, 1, 0, 1, 0, 0]].concat();
    let second = [&[0, 0, 0, 1][..], &frame[4..]].concat();
    let pixels = [&[0, 0, 0, 2][..], &stream].concat();
    let animation = [
        chunk(b"acTL", &control),
        chunk(b"fcTL", &frame),
        chunk(b"IDAT", &stream),
        chunk(b"fcTL", &second),
        chunk(b"fdAT", &pixels),
    ];
    let message = folder.message(read(&animation));
    assert!(message.contains("an animation of 2 pictures"), "{message}");
}

/// The bytes of rows of an interlaced picture are counted pass by pass.
#[test]
fn interlaced_pictures_are_read() {
    let folder = Folder::new();
    for size in [1_u32, 2, 3, 5, 9] {
        // By hand: each pass has its rows of a filter byte and pixels.
        let passes = [
            [0, 0, 8, 8],
            [4, 0, 8, 8],
            [0, 4, 4, 8],
            [2, 0, 4, 4],
            [0, 2, 2, 4],
            [1, 0, 2, 2],
            [0, 1, 1, 2],
        ];
        let mut rows = Vec::new();
        for [x0, y0, dx, dy] in passes {
            let [dx, dy] = [dx as usize, dy as usize];
            let columns: Vec<u32> = (x0..size).step_by(dx).collect();
            if columns.is_empty() {
                continue;
            }
            for y in (y0..size).step_by(dy) {
                rows.push(0);
                rows.extend(columns.iter().map(|x| (y * size + x) as u8));
            }
        }
        let header = [&size.to_be_bytes()[..], &size.to_be_bytes(), &[8, 0, 0, 0, 1]].concat();
        let chunks = [chunk(b"IHDR", &header), chunk(b"IDAT", &zlib(&rows)), chunk(b"IEND", &[])].concat();
        let volume = open(&folder.write("v.png", "", &[b"\x89PNG\r\n\x1a\n", &chunks[..]].concat())).unwrap();
        assert_eq!(volume.samples(), &Samples::U8((0..size * size).map(|i| i as u8).collect()), "{size}");
    }
}

type Pack<'a> = &'a dyn Fn(&[u8]) -> Vec<u8>;

#[test]
fn strips_of_tiff_hold_their_rows() {
    let folder = Folder::new();
    let rows: Vec<u8> = (1..=6).collect();
    let lzw = |bytes: &[u8]| {
        weezl::encode::Encoder::with_tiff_size_switch(weezl::BitOrder::Msb, 8).encode(bytes).unwrap()
    };
    let packbits = |bytes: &[u8]| [&[bytes.len() as u8 - 1], bytes].concat();
    let read = |compression: u32, strip: Vec<u8>| {
        let page = Page { compression, strips: vec![strip], ..Page::small(1) };
        open(&folder.write("v.tif", "", &tiff(&[page]).0))
    };
    let longer = [&rows[..], &[7]].concat();
    let packings: [(u32, Pack<'_>); 4] = [(1, &<[u8]>::to_vec), (5, &lzw), (8, &zlib), (32773, &packbits)];
    for (compression, pack) in packings {
        assert_eq!(
            read(compression, pack(&rows)).unwrap().samples(),
            &Samples::U8(rows.clone()),
            "{compression}"
        );
        let message = folder.message(read(compression, pack(&longer)));
        assert!(
            message.contains("page 1: strip 1 holds") && message.contains("take 6"),
            "{compression}: {message}"
        );
        let message = folder.message(read(compression, pack(&rows[..5])));
        assert!(message.contains("page 1"), "{compression}: {message}");
        if compression != 1 {
            assert!(read(compression, [&pack(&rows)[..], &[0]].concat()).is_ok(), "{compression}: padded");
            let message = folder.message(read(compression, [&pack(&rows)[..], b"tail"].concat()));
            assert!(message.contains("bytes follow its stream"), "{compression}: {message}");
        }
    }
    // The last strip may be stored whole.
    let mut page =
        Page { rows_per_strip: 4, strips: vec![zlib(&[&rows[..], &[0; 6]].concat())], ..Page::small(1) };
    page.compression = 8;
    let volume = open(&folder.write("v.tif", "", &tiff(&[page]).0)).unwrap();
    assert_eq!(volume.samples(), &Samples::U8(rows));
}

/// A raw payload that is longer than promised.
#[test]
fn bytes_behind_raw_voxels_are_refused() {
    let folder = Folder::new();
    let mut npy = Vec::new();
    npy.write_all(b"\x93NUMPY\x01\x00\x76\x00{'descr': '|u1', 'fortran_order': False, 'shape': (2, 2, 2)}")
        .unwrap();
    npy.resize(10 + 0x75, b' ');
    npy.push(b'\n');
    let nrrd = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n".to_vec();
    let metaimage =
        b"NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n".to_vec();
    let nifti = super::lies::nifti(&[3, 2, 2, 2], 2);
    for (name, header) in [("v.nrrd", nrrd), ("v.mha", metaimage), ("v.nii", nifti), ("v.npy", npy)] {
        let read = |more: &[u8]| open(&folder.write(name, "", &[&header[..], &VOXELS, more].concat()));
        assert_eq!(read(&[]).unwrap().samples(), &Samples::U8(VOXELS.to_vec()), "{name}");
        assert!(folder.message(read(b"x")).contains("take 8 bytes, but 9 are there"), "{name}");
    }
}
