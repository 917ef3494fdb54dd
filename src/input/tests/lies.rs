//! Files that claim what they have not: small ones of each format, with the words that their errors must hold.

/// A file, its name, and the text that the message must contain.
pub struct Lie {
    pub name: &'static str,
    pub bytes: Vec<u8>,
    pub words: &'static [&'static str],
}

fn lie(name: &'static str, bytes: Vec<u8>, words: &'static [&'static str]) -> Lie {
    Lie { name, bytes, words }
}

/// A NIfTI-1 header with these dimensions and number type, little-endian, and nothing behind it.
pub fn nifti(dim: &[i16], datatype: i16) -> Vec<u8> {
    let mut bytes = vec![0; 352];
    bytes[..4].copy_from_slice(&348_i32.to_le_bytes());
    for (i, n) in dim.iter().enumerate() {
        bytes[40 + 2 * i..][..2].copy_from_slice(&n.to_le_bytes());
    }
    bytes[70..72].copy_from_slice(&datatype.to_le_bytes());
    for i in 0..8 {
        bytes[76 + 4 * i..][..4].copy_from_slice(&1_f32.to_le_bytes());
    }
    bytes[108..112].copy_from_slice(&352_f32.to_le_bytes());
    bytes[344..348].copy_from_slice(b"n+1\0");
    bytes
}

/// The same with one field overwritten.
fn nifti_with(at: usize, field: &[u8]) -> Vec<u8> {
    let mut bytes = nifti(&[3, 2, 2, 2], 2);
    bytes[at..at + field.len()].copy_from_slice(field);
    bytes.extend([0; 8]);
    bytes
}

pub fn npy(dictionary: &str, claimed: Option<u32>) -> Vec<u8> {
    let length = claimed.unwrap_or(dictionary.len() as u32 + 1);
    [b"\x93NUMPY\x02\x00", &length.to_le_bytes()[..], dictionary.as_bytes(), b"\n"].concat()
}

fn array(descr: &str, shape: &str) -> Vec<u8> {
    npy(&format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}"), None)
}

/// A little-endian TIFF of one page with these tags: number, type (3 short, 4 long), value.
fn tiff(tags: &[(u16, u16, u32)], next: u32) -> Vec<u8> {
    let mut bytes = [&b"II*\0"[..], &8_u32.to_le_bytes(), &(tags.len() as u16).to_le_bytes()].concat();
    for (tag, kind, value) in tags {
        bytes.extend(tag.to_le_bytes());
        bytes.extend(kind.to_le_bytes());
        bytes.extend(1_u32.to_le_bytes());
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend(next.to_le_bytes());
    bytes.extend([0; 64]);
    bytes
}

/// A page of that size and compression whose strip lies at the end of the file.
fn page(width: u32, height: u32, compression: u32, photometric: u32) -> [(u16, u16, u32); 9] {
    [
        (256, 4, width),
        (257, 4, height),
        (258, 3, 8),
        (259, 3, compression),
        (262, 3, photometric),
        (273, 4, 122),
        (277, 3, 1),
        (278, 4, height),
        (279, 4, 64),
    ]
}

/// A PNG header of that size, colour type and bit depth, and a stream of no pixels.
fn png(width: u32, height: u32, depth: u8, colour: u8) -> Vec<u8> {
    let chunk = |kind: &[u8; 4], data: &[u8]| {
        let mut crc = flate2::Crc::new();
        crc.update(kind);
        crc.update(data);
        [&(data.len() as u32).to_be_bytes()[..], kind, data, &crc.sum().to_be_bytes()].concat()
    };
    let header = [&width.to_be_bytes()[..], &height.to_be_bytes(), &[depth, colour, 0, 0, 0]].concat();
    let pixels = super::zlib(&[0; 64]);
    [&b"\x89PNG\r\n\x1a\n"[..], &chunk(b"IHDR", &header), &chunk(b"IDAT", &pixels), &chunk(b"IEND", &[])]
        .concat()
}

/// A VTI file around these elements of the piece, with appended raw data.
fn vti(extent: &str, attributes: &str, arrays: &str, appended: &[u8]) -> Vec<u8> {
    let head = format!(
        "<VTKFile type=\"ImageData\" byte_order=\"LittleEndian\" header_type=\"UInt64\"{attributes}>\
         <ImageData WholeExtent=\"{extent}\"><Piece Extent=\"{extent}\"><PointData>{arrays}</PointData></Piece>\
         </ImageData><AppendedData encoding=\"raw\">_"
    );
    [head.as_bytes(), appended, b"</AppendedData></VTKFile>"].concat()
}

const ARRAY: &str = "<DataArray type=\"UInt8\" Name=\"a\" format=\"appended\" offset=\"0\"/>";
const ZLIB: &str = " compressor=\"vtkZLibDataCompressor\"";

fn words(numbers: &[u64]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

pub fn all() -> Vec<Lie> {
    let mut lies = nifti_lies();
    lies.extend(npy_lies());
    lies.extend(picture_lies());
    lies.extend(vti_lies());
    lies
}

fn nifti_lies() -> Vec<Lie> {
    let huge = nifti(&[3, 2000, 2000, 1000], 2);
    vec![
        lie("huge.nii", huge.clone(), &["take 4000000000 bytes, but only 0 are there"]),
        lie("huge.nii.gz", super::gzip(&huge), &["take 4000000000 bytes, which", "of gzip cannot hold"]),
        lie("absurd.nii", nifti(&[7, 32767, 32767, 32767, 32767, 3, 1, 1], 64), &["field `dim`", "limit"]),
        lie("negative.nii", nifti(&[3, -5, 4, 4], 2), &["field `dim`", "[-5, 4, 4]"]),
        lie("short.nii", nifti(&[3, 4, 4, 4], 2)[..100].to_vec(), &["takes 348 bytes, but only 100"]),
        lie("complex.nii", nifti(&[3, 4, 4, 4], 32), &["field `datatype`", "`datatype` 32", "RGB24 (128)"]),
        lie("offset.nii", nifti_with(108, &1e30_f32.to_le_bytes()), &["field `vox_offset`", "usually 352"]),
        lie(
            "spacing.nii",
            nifti_with(80, &f32::NAN.to_le_bytes()),
            &["field `pixdim`", "`pixdim[1]` is NaN"],
        ),
        lie("inter.nii", nifti_with(112, &[0, 0, 0, 64, 0, 0, 128, 127]), &["field `scl_inter`"]),
        lie("detached.nii", nifti_with(344, b"ni1\0"), &["field `magic`", ".nii.gz"]),
        lie("magic.nii", nifti_with(344, b"abcd"), &["header", "NIfTI-1"]),
        lie("two.nii", nifti_with(4, b"n+2\0"), &["NIfTI-2", "NIfTI-1"]),
        lie("size.nii", nifti_with(0, &[1, 2, 3, 4]), &["field `sizeof_hdr`", "348"]),
        lie("many.nii", [nifti(&[3, 2, 2, 2], 2), vec![0; 9]].concat(), &["take 8 bytes, but 9 are there"]),
        lie("broken.nii.gz", super::gzip(&huge)[..30].to_vec(), &["348 bytes, but only"]),
        lie("other.gz", super::gzip(b"a letter"), &["348 bytes, but only 8"]),
    ]
}

fn npy_lies() -> Vec<Lie> {
    let deep = format!("{{'descr': {}'<f4'", "(".repeat(60_000));
    vec![
        lie(
            "huge.npy",
            array("'|u1'", "(2000, 2000, 1000)"),
            &["take 4000000000 bytes, but only 0 are there"],
        ),
        lie("absurd.npy", array("'<f8'", "(9999999999, 9999999999, 9999999999)"), &["`shape`", "limit"]),
        lie("overflow.npy", array("'<f8'", "(99999999999999999999999, 1, 1)"), &["header"]),
        lie("long.npy", npy("{}", Some(u32::MAX)), &["claims 4294967295 bytes"]),
        lie("cut.npy", npy("{}", Some(100)), &["claims 100 bytes, but only"]),
        lie("deep.npy", npy(&deep, None), &["too many brackets"]),
        lie("object.npy", array("'|O'", "(2, 2, 2)"), &["`descr`", "|O"]),
        lie("record.npy", array("[('a', '<f4')]", "(2, 2, 2)"), &["`descr`", "u1, i1"]),
        lie("flat.npy", array("'<f4'", "(2, 2)"), &["`shape`", "[z, y, x]"]),
        lie(
            "rgba.npy",
            array("'|u1'", "(6, 7, 11, 4)"),
            &["`shape`", "may be 4 channels", "[frame, z, y, x, 1]"],
        ),
        lie("empty.npy", array("'<f4'", "(2, 0, 2)"), &["`shape`", "none of them 0"]),
        lie("version.npy", b"\x93NUMPY\x09\x00\x10\x00".to_vec(), &["version 9"]),
        lie("nothing.npy", b"\x93NUMPY".to_vec(), &["ends within its header"]),
        lie("words.npy", npy("import os", None), &["header", "numpy.save"]),
    ]
}

fn picture_lies() -> Vec<Lie> {
    let gray = page(60_000, 60_000, 1, 1);
    let own = page(8, 8, 1, 1);
    vec![
        lie("huge.tif", tiff(&gray, 0), &["page 1", "take 3600000000 bytes, which a TIFF file of"]),
        lie("deflate.tif", tiff(&page(60_000, 60_000, 8, 1), 0), &["page 1", "cannot hold"]),
        lie("lzw.tif", tiff(&page(60_000, 60_000, 5, 1), 0), &["page 1", "cannot hold"]),
        lie("absurd.tif", tiff(&page(u32::MAX, u32::MAX, 1, 1), 0), &["page 1", "limit"]),
        // The first page again and again.
        lie("circle.tif", tiff(&own, 8), &["circle.tif", "cycle"]),
        lie("jpeg.tif", tiff(&page(8, 8, 7, 1), 0), &["compression 7", "LZW"]),
        lie("white.tif", tiff(&page(8, 8, 1, 0), 0), &["white as zero"]),
        lie("no-tags.tif", tiff(&[], 0), &["no-tags.tif"]),
        lie("short.tif", b"II*\0".to_vec(), &["no whole TIFF"]),
        lie("far.tif", b"II*\0\xff\xff\xff\x7f".to_vec(), &["far.tif"]),
        lie("huge.png", png(60_000, 60_000, 8, 0), &["take 3600000000 bytes, which a PNG file of"]),
        lie("absurd.png", png(0x7fff_ffff, 0x7fff_ffff, 16, 2), &["limit"]),
        lie("zero.png", png(0, 4, 8, 0), &["no whole PNG"]),
        lie("cut.png", png(8, 8, 8, 0)[..40].to_vec(), &["no whole PNG"]),
        lie("few.png", png(8, 9, 8, 0), &["no whole PNG"]),
        lie("alpha.png", png(8, 8, 8, 6), &["colour type", "alpha"]),
        lie("bits.png", png(8, 8, 1, 0), &["bit depth of 1"]),
    ]
}

fn vti_lies() -> Vec<Lie> {
    let small = "0 1 0 1 0 1";
    let huge = "0 1999 0 1999 0 999";
    let table = |numbers: &[u64]| vti(huge, ZLIB, ARRAY, &words(numbers));
    let bomb = super::zlib(&vec![0; 16 << 20]);
    let laugh = "<!DOCTYPE x [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\">]><VTKFile>&b;</VTKFile>";
    let text = |value: &str| {
        let array = format!("<DataArray type=\"UInt8\" Name=\"a\" format=\"ascii\">{value}</DataArray>");
        vti(small, "", &array, &[])
    };
    vec![
        lie("huge.vti", vti(huge, "", ARRAY, &words(&[4_000_000_000])), &["array `a`", "but only"]),
        lie("other.vti", vti(huge, "", ARRAY, &words(&[8])), &["but the array has 8", "header_type"]),
        lie(
            "absurd.vti",
            vti("0 4294967294 0 4294967294 0 4294967294", "", ARRAY, &[]),
            &["<DataArray>", "limit"],
        ),
        lie(
            "extent.vti",
            vti("0 1 0 1 9 1", "", ARRAY, &[]),
            &["<ImageData>", "`WholeExtent`", "six whole numbers"],
        ),
        lie(
            "overflow.vti",
            vti("-9223372036854775808 9223372036854775807 0 1 0 1", "", ARRAY, &[]),
            &["six whole"],
        ),
        lie("blocks.vti", table(&[u64::MAX, u64::MAX, u64::MAX]), &["array `a`", "blocks make"]),
        lie("many.vti", table(&[4_000_000_000, 1, 1]), &["array `a`"]),
        lie("block.vti", table(&[1, 4_000_000_000, 0, u64::MAX]), &["array `a`", "a block takes"]),
        lie(
            "bomb.vti",
            vti(small, ZLIB, ARRAY, &[words(&[1, 8, 0, bomb.len() as u64]), bomb].concat()),
            &["array `a`", "more than its table says"],
        ),
        lie("laughs.vti", laugh.as_bytes().to_vec(), &["document type"]),
        lie(
            "deep.vti",
            format!("<VTKFile type=\"ImageData\">{}", "<a>".repeat(99)).into_bytes(),
            &["more than 16"],
        ),
        lie(
            "attribute.vti",
            format!("<VTKFile type=\"ImageData\" x=\"{}\">", "x".repeat(3 << 20)).into_bytes(),
            &["a mebibyte of XML"],
        ),
        lie("poly.vti", b"<VTKFile type=\"PolyData\">".to_vec(), &["`type` `PolyData`", "ImageData"]),
        lie(
            "lz4.vti",
            vti(small, " compressor=\"vtkLZ4DataCompressor\"", ARRAY, &[]),
            &["`compressor`", "ZLib"],
        ),
        lie(
            "open.vti",
            b"<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 1 0 1\">".to_vec(),
            &["ends within"],
        ),
        lie("none.vti", vti(small, "", "", &[]), &["no <DataArray>"]),
        lie("two.vti", vti(small, "", &ARRAY.repeat(2), &[]), &["<PointData>", "Scalars=\"NAME\""]),
        lie("offset.vti", vti(small, "", &ARRAY.replace("\"0\"", "\"-1\""), &[]), &["`offset` is `-1`"]),
        lie(
            "string.vti",
            vti(small, "", &ARRAY.replace("UInt8", "String"), &[]),
            &["`type` `String`", "Float64"],
        ),
        lie("few.vti", text("1 2 3"), &["but only 3 are there"]),
        lie("letters.vti", text("1 2 three 4 5 6 7 8"), &["`three` is no u8"]),
        lie("large.vti", text("1 2 300 4 5 6 7 8"), &["`300` is no u8"]),
        lie("number.vti", text(&"1".repeat(1 << 20)), &["a number without end"]),
        lie(
            "base64.vti",
            vti(small, "", "<DataArray type=\"UInt8\" Name=\"a\" format=\"binary\">?</DataArray>", &[]),
            &["base64 is damaged"],
        ),
    ]
}
