//! The text of every error about volumes and codecs.

use super::*;

#[test]
fn volumes() {
    let file = "file = \"$CVR_DATA/bonsai.nrrd\"";
    let text = errors(&[
        (file, "file = \"a\"\ngenerate = \"shepp-logan\""),
        (file, ""),
        (file, "file = \"${CVR_DATA/x\""),
        (file, "generate = \"shep-logan\""),
        (file, "generate = \"shepp-logan\"\nspacing = [1, 1, 1]"),
        (file, "generate = \"shepp-logan\"\ndims = [4, 0, 4]"),
        (file, "generate = \"shepp-logan\"\ndims = [4, 4]"),
        (file, "generate = \"shepp-logan\"\ndims = [99999, 99999, 99999]"),
        (file, "file = \"a.raw\"\ndtype = \"u8\""),
        (file, "file = \"a.raw\"\ndims = [4, 4, 4]\ndtype = \"uint8\""),
        (file, "file = \"a.raw\"\ndims = [4, 4, 4]\ndtype = \"u8\"\nspacing = [1.0, 0, 1.0]"),
        (file, "file = \"a.raw\"\ndims = [4, 4, 4]\ndtype = \"u8\"\nskip_bytes = -1"),
        (file, "file = \"a.raw\"\ndims = [4, 4, 4]\ndtype = \"u8\"\nbyte_order = \"middle\""),
        (file, "file = \"a.raw\"\ndims = [4, 4, 4]\ndtype = \"u8\"\nchannels = 2"),
        (file, "file = \"a.raw\"\ndims = [4, 4, 4]\ndtype = \"u8\"\nframes = 0"),
        (file, "files = []"),
        (file, "files = \"a.nrrd\""),
        (file, "files = [\"a.nrrd\", 3]"),
        (file, "file = \"a\"\nfiles = [\"b\"]"),
        (file, "generate = \"shepp-logan\"\nframes = \"many\""),
        ("name = \"bonsai\"", "name = \"\""),
        (file, "file = \"a\"\n[[volume]]\nname = \"Bonsai\"\nfile = \"b\""),
    ]);
    insta::assert_snapshot!(text, @r#"
    error: volume `bonsai` has both `file` and `generate`
      ┌─ x.toml:8:1
      │
    7 │ file = "a"
      │ ---- here a file
    8 │ generate = "shepp-logan"      # or generate = "shepp-logan", dims = [128, 128, 128]
      │ ^^^^^^^^ here a generator
      │
      = keep one of the two

    error: volume `bonsai` has neither `file` nor `generate`
      ┌─ x.toml:5:1
      │
    5 │ [[volume]]
      │ ^^^^^^^^^^ one is missing here
      │
      = write, for instance, `file = "$CVR_DATA/bonsai.nrrd"`

    error: `${` needs a variable name and a closing `}`
      ┌─ x.toml:7:8
      │
    7 │ file = "${CVR_DATA/x"      # or generate = "shepp-logan", dims = [128, 128, 128]
      │        ^^^^^^^^^^^^^^ not a path
      │
      = `$NAME` and `${NAME}` stand for environment variables, `$$` for `$`

    error: no generator is called `shep-logan`
      ┌─ x.toml:7:12
      │
    7 │ generate = "shep-logan"      # or generate = "shepp-logan", dims = [128, 128, 128]
      │            ^^^^^^^^^^^^ unknown generator
      │
      = did you mean `shepp-logan`?
      = known generators: shepp-logan, marschner-lobb

    error: `spacing` describes a file; this volume is generated
      ┌─ x.toml:8:1
      │
    8 │ spacing = [1, 1, 1]      # or generate = "shepp-logan", dims = [128, 128, 128]
      │ ^^^^^^^ has no meaning here
      │
      = remove this line, or read the volume with `file`

    error: expected a number of voxels, from 1, found `0`
      ┌─ x.toml:8:12
      │
    8 │ dims = [4, 0, 4]      # or generate = "shepp-logan", dims = [128, 128, 128]
      │            ^ expected a number of voxels, from 1

    error: expected three sizes in voxels, [x, y, z], found a list of 2
      ┌─ x.toml:8:8
      │
    8 │ dims = [4, 4]      # or generate = "shepp-logan", dims = [128, 128, 128]
      │        ^^^^^^ expected three sizes in voxels, [x, y, z]

    error: dimensions 99999×99999×99999: more than 2^40 voxels
      ┌─ x.toml:8:8
      │
    8 │ dims = [99999, 99999, 99999]      # or generate = "shepp-logan", dims = [128, 128, 128]
      │        ^^^^^^^^^^^^^^^^^^^^^ too large
      │
      = take smaller sizes

    error: volume `bonsai` has no `dims`
      ┌─ x.toml:5:1
      │
    5 │ [[volume]]
      │ ^^^^^^^^^^ missing here
      │
      = write, for instance, `dims = [256, 256, 128]`

    error: no sample type is called `uint8`
      ┌─ x.toml:9:9
      │
    9 │ dtype = "uint8"      # or generate = "shepp-logan", dims = [128, 128, 128]
      │         ^^^^^^^ unknown sample type
      │
      = known sample types: u8, i8, u16, i16, u32, i32, u64, i64, f32, f64

    error: expected a length above 0, found `0`
       ┌─ x.toml:10:17
       │
    10 │ spacing = [1.0, 0, 1.0]      # or generate = "shepp-logan", dims = [128, 128, 128]
       │                 ^ expected a length above 0

    error: expected a number of bytes, from 0, found `-1`
       ┌─ x.toml:10:14
       │
    10 │ skip_bytes = -1      # or generate = "shepp-logan", dims = [128, 128, 128]
       │              ^^ expected a number of bytes, from 0

    error: no byte order is called `middle`
       ┌─ x.toml:10:14
       │
    10 │ byte_order = "middle"      # or generate = "shepp-logan", dims = [128, 128, 128]
       │              ^^^^^^^^ unknown byte order
       │
       = known byte orders: little, big

    error: expected 1 (scalar) or 3 (RGB), found `2`
       ┌─ x.toml:10:12
       │
    10 │ channels = 2      # or generate = "shepp-logan", dims = [128, 128, 128]
       │            ^ expected 1 (scalar) or 3 (RGB)

    error: expected a number of time steps, from 1, found `0`
       ┌─ x.toml:10:10
       │
    10 │ frames = 0      # or generate = "shepp-logan", dims = [128, 128, 128]
       │          ^ expected a number of time steps, from 1

    error: the list names no file
      ┌─ x.toml:7:9
      │
    7 │ files = []      # or generate = "shepp-logan", dims = [128, 128, 128]
      │         ^^ empty list
      │
      = name at least one, or write `file = "step*.raw"` for all that a pattern matches

    error: expected a list of paths, found a string
      ┌─ x.toml:7:9
      │
    7 │ files = "a.nrrd"      # or generate = "shepp-logan", dims = [128, 128, 128]
      │         ^^^^^^^^ expected a list of paths

    error: expected a string, found an integer
      ┌─ x.toml:7:20
      │
    7 │ files = ["a.nrrd", 3]      # or generate = "shepp-logan", dims = [128, 128, 128]
      │                    ^ expected a string

    error: volume `bonsai` has both `file` and `files`
      ┌─ x.toml:8:1
      │
    7 │ file = "a"
      │ ---- here a file
    8 │ files = ["b"]      # or generate = "shepp-logan", dims = [128, 128, 128]
      │ ^^^^^ here a sequence of files
      │
      = keep one of the two

    error: expected a number of time steps, from 1, found a string
      ┌─ x.toml:8:10
      │
    8 │ frames = "many"      # or generate = "shepp-logan", dims = [128, 128, 128]
      │          ^^^^^^ expected a number of time steps, from 1

    error: expected a name without control characters, found `""`
      ┌─ x.toml:6:8
      │
    6 │ name = ""
      │        ^^ expected a name without control characters

    error: two volumes are called `Bonsai`
      ┌─ x.toml:9:8
      │
    6 │ name = "bonsai"
      │        -------- first
      ·
    9 │ name = "Bonsai"
      │        ^^^^^^^^ again
      │
      = records and files go by this name: choose another
      = upper and lower case do not tell file names apart everywhere
    "#);
}

#[test]
fn codecs() {
    let text = errors(&[
        ("id = \"raw\"", "id = \"row\""),
        ("id = \"raw\"", "bits = 8"),
        ("id = \"raw\"", "id = \"raw\"\nbits = 12"),
        ("index_bits = [2, 4]", "index_bits = [2, 3]"),
        ("index_bits = [2, 4]", "index_bit = 2"),
        ("index_bits = [2, 4]", "index_bits = []"),
        ("index_bits = [2, 4]", "index_bits = [[2]]"),
        ("block = [4, 8, \"8x8x4\"]", "block = 256"),
        ("block = [4, 8, \"8x8x4\"]", "block = \"8x8\""),
        ("id = \"raw\"", "id = \"tape\"\nspeed = 1"),
    ]);
    insta::assert_snapshot!(text, @r#"
    error: no codec is called `row`
       ┌─ x.toml:10:6
       │
    10 │ id = "row"
       │      ^^^^^ unknown codec
       │
       = did you mean `raw`?
       = known codecs: raw, s3dc, tape

    error: the codec has no `id`
      ┌─ x.toml:9:1
      │
    9 │ [[codec]]
      │ ^^^^^^^^^ missing here
      │
      = write, for instance, `id = "raw"`

    error: `bits` of codec `raw` cannot be `12`
       ┌─ x.toml:11:8
       │
    11 │ bits = 12
       │        ^^ expected "native", "8" or "half"
       │
       = bits: bits per sample
       = a list is a sweep: each of its values is tried

    error: `index_bits` of codec `s3dc` cannot be `3`
       ┌─ x.toml:14:18
       │
    14 │ index_bits = [2, 3]
       │                  ^ expected 1, 2, 4 or 8
       │
       = index_bits: bits per voxel
       = a list is a sweep: each of its values is tried

    error: codec `s3dc` has no setting `index_bit`
       ┌─ x.toml:14:1
       │
    14 │ index_bit = 2
       │ ^^^^^^^^^ unknown setting
       │
       = did you mean `index_bits`?
       = known settings: block, index_bits

    error: `index_bits` lists no value to try
       ┌─ x.toml:14:14
       │
    14 │ index_bits = []
       │              ^^ empty list
       │
       = leave the line away for the default, 4

    error: `index_bits` of codec `s3dc` cannot be `[2]`
       ┌─ x.toml:14:15
       │
    14 │ index_bits = [[2]]
       │               ^^^ expected 1, 2, 4 or 8
       │
       = index_bits: bits per voxel
       = a list is a sweep: each of its values is tried

    error: `block` of codec `s3dc` cannot be `256`
       ┌─ x.toml:13:9
       │
    13 │ block = 256             # a list is a sweep; an integer is a cube
       │         ^^^ expected a block edge (8) or a block size ("8x8x4"), each axis 1 to 128
       │
       = block: voxels of a block
       = a list is a sweep: each of its values is tried

    error: `block` of codec `s3dc` cannot be `"8x8"`
       ┌─ x.toml:13:9
       │
    13 │ block = "8x8"             # a list is a sweep; an integer is a cube
       │         ^^^^^ expected a block edge (8) or a block size ("8x8x4"), each axis 1 to 128
       │
       = block: voxels of a block
       = a list is a sweep: each of its values is tried

    error: codec `tape` has no setting `speed`
       ┌─ x.toml:11:1
       │
    11 │ speed = 1
       │ ^^^^^ unknown setting
       │
       = there are no settings
    "#);
}
