//! Requests for more memory, or more cells, than allowed: refused before anything is allocated, with the way out.

use std::path::Path;

use cvr::registry::Names;
use cvr_core::codec::{EncodeReport, Settings};
use cvr_core::container::{ContainerWriter, Element, StreamWriter as _};
use cvr_core::volume::{Extent, Replaced, SampleType, VolumeLayout};

use super::super::folder::Folder;

/// A valid stream of `vq`: blocks of 16³ voxels, one codeword, and a one-bit index per block.
fn promise(path: &Path, edge: u32, sample: SampleType) {
    let names = Names::new().unwrap();
    let vq = names.codecs().get("vq").unwrap();
    let (blocks, grid) = (u64::from(edge / 16).pow(3), edge / 16);
    let mut writer = ContainerWriter::create(path).unwrap();
    writer.append("codebook", Element::U32, &vec![7; 4096]).unwrap();
    writer.shape("codebook", &[1, 1024]).unwrap();
    writer.append("index", Element::U32, &vec![0; blocks.div_ceil(32) as usize * 4]).unwrap();
    writer.shape("index", &[1, blocks.div_ceil(32)]).unwrap();
    writer.parameters(serde_json::json!({
        "block": "16", "grid": [grid, grid, grid], "codeword_bits": 8, "offset": 0.0, "step": 1.0, "tables": [1],
        "training": { "initial": "pca", "generator": "pcg64", "seed": 1, "blocks": [1], "rounds": [1] },
    }));
    let layout = VolumeLayout::scalar(Extent::cube(edge).unwrap(), sample);
    let settings: Settings = vq.info().default_settings();
    writer.finish(vq.info(), &layout, &settings, &EncodeReport::default(), Replaced::default()).unwrap();
}

#[test]
fn a_stream_that_promises_hundreds_of_gigabytes_is_refused() {
    let folder = Folder::new();
    promise(&folder.path("a.cvr"), 4096, SampleType::F32);
    let info = folder.cvr(&["info", "a.cvr"]).exits(0).stdout;
    assert!(
        info.contains("dims       4096×4096×4096") && info.contains("274877906944 uncompressed"),
        "{info}"
    );
    let refused = folder.cvr(&["decode", "a.cvr", "a.nrrd"]).refused();
    for words in ["a.cvr", "4096×4096×4096", "275 GB", "--max-gb"] {
        assert!(refused.contains(words), "{refused}");
    }
    // A frame is drawn as a whole.
    let refused = folder.cvr(&["render", "a.cvr", "a.png", "--device", "cpu", "--max-gb", "20"]).refused();
    assert!(refused.contains("needs 275 GB of memory, and 20.0 GB may be taken (--max-gb)"), "{refused}");
    assert_eq!(folder.names(), ["a.cvr"]);
    // The stream itself takes two megabytes.
    for command in [&["info", "a.cvr"][..], &["decode", "a.cvr", "a.nrrd"]] {
        let refused = folder.cvr(&[command, &["--max-gb", "0.001"]].concat()).refused();
        assert!(refused.contains("a.cvr: the encoded stream needs 2.1 MB of memory"), "{refused}");
    }
}

/// The twin: within the limit it decodes, although a whole frame in single precision would not fit.
#[test]
fn a_stream_is_decoded_in_less_memory_than_a_frame() {
    let folder = Folder::new();
    promise(&folder.path("a.cvr"), 256, SampleType::U8);
    folder.cvr(&["decode", "a.cvr", "a.nrrd", "--max-gb", "0.02"]).exits(0);
    let bytes = folder.read("a.nrrd");
    let voxels = &bytes[bytes.len() - (1 << 24)..];
    assert!(voxels.iter().all(|v| *v == 7) && bytes.starts_with(b"NRRD0004\n"));
    let refused = folder.cvr(&["decode", "a.cvr", "b.nrrd", "--max-gb", "0.01"]).refused();
    assert!(refused.contains("a.cvr: a piece of 256×256×64 voxels needs 16.8 MB of memory"), "{refused}");
    let refused = folder.cvr(&["render", "a.cvr", "a.png", "--device", "cpu", "--max-gb", "0.02"]).refused();
    assert!(refused.contains("a decoded frame of 256×256×256 voxels needs 67.1 MB of memory"), "{refused}");
    assert_eq!(folder.names(), ["a.cvr", "a.nrrd"]);
}

const RUN: &str = r##"
[experiment]
name = "tight"
[[volume]]
name = "v"
generate = "turbulence"
dims = [64, 64, 64]
dtype = "u8"
[[codec]]
id = "raw"
[[codec]]
id = "external"
name = "copy"
encode = "cp {in} {out}"
decode = "cp {in} {out}"
[[codec]]
id = "s3dc"
[pipeline]
renderer = "raycasting"
site = "host"
filter = "linear"
[[scene]]
name = "s"
size = [12, 12]
transfer_function_domain = "range"
transfer_function = [[0.0, "#00000000"], [1.0, "#ffffffff"]]
"##;

#[test]
fn volumes_that_do_not_fit_are_bad_input_for_every_command() {
    let folder = Folder::new();
    folder.write("v.raw", vec![3; 64 * 64 * 64]);
    folder.write("x.toml", RUN);
    let raw = ["--dims", "64x64x64", "--dtype", "u8"];
    for command in [
        &["info", "v.raw"][..],
        &["encode", "v.raw", "v.cvr", "--codec", "raw"],
        &["convert", "v.raw", "v.nrrd"],
        &["render", "v.raw", "v.png", "--device", "cpu"],
        &["shader", "v.raw"],
        &["run", "x.toml", "--device", "cpu", "--volume", "v.raw"],
    ] {
        let refused = folder.cvr(&[command, &raw, &["--max-gb", "0.0002"]].concat()).refused();
        let expected =
            if command[0] == "run" { "needs 262.1 kB of memory" } else { "no memory for 262144 bytes" };
        assert!(refused.contains(expected) && refused.contains("--max-gb"), "{command:?}: {refused}");
    }
    let refused = folder.cvr(&["run", "x.toml", "--device", "cpu", "--max-gb", "0.0002"]).refused();
    assert!(refused.contains("tight: holding all volumes of the experiment needs 262.1 kB"), "{refused}");
    assert_eq!(folder.names(), ["v.raw", "x.toml"]);
    folder.cvr(&[&["info", "v.raw"][..], &raw, &["--max-gb", "0.0003"]].concat()).exits(0);
}

/// Bytes per voxel: 1 of the original, 5 of raw as the baseline (stream and frame). Raw's own cell takes 9 more
/// (stream, frame, original in single precision), s3dc's 8.5, and a command's 13, because it keeps its own frame.
#[cfg(unix)]
#[test]
fn a_cell_without_memory_fails_and_the_others_end() {
    let folder = Folder::new();
    folder.write("x.toml", RUN);
    let run = |bytes_per_voxel: f64, code: i32| {
        let gb = (bytes_per_voxel * 262_144.0 / 1e9).to_string();
        let ran = folder.cvr(&["run", "x.toml", "--device", "cpu", "--max-gb", &gb]).exits(code);
        (ran.stdout, folder.json("results/tight/results.json"))
    };
    let (text, results) = run(17.0, 1);
    assert!(text.contains("3 cells: 2 ok, 1 failed"), "{text}");
    for record in results["records"].as_array().unwrap() {
        let error = record["error"].as_str().unwrap_or_default();
        if record["codec"] == "external:copy" {
            assert!(error.contains("the original frame of 64×64×64 voxels needs 1.0 MB of memory, and 4.5 MB may be taken (--max-gb)"), "{error}");
        } else {
            assert_eq!((record["status"].as_str(), error), (Some("ok"), ""), "{}", record["codec"]);
        }
    }
    let (text, _) = run(20.0, 0);
    assert!(text.contains("3 cells: 3 ok, 0 failed"), "{text}");
    // Without room for the baseline, no cell of the volume has one.
    let (text, _) = run(4.0, 1);
    assert!(text.contains("3 cells: 0 ok, 3 failed"), "{text}");
}

/// A configuration of a thousand million cells: three settings of a thousand values each.
fn sweep() -> String {
    let values = |n: u32| (1..=n).map(|i| i.to_string()).collect::<Vec<_>>().join(", ");
    let texts: Vec<String> = (0..1000).map(|i| format!("\"n{i}\"")).collect();
    let codec = format!(
        "id = \"external\"\nname = [{}]\nvalue = [{}]\ntimeout_seconds = [{}]\n",
        texts.join(", "),
        values(1000),
        values(1000)
    );
    RUN.replace("id = \"external\"\nname = \"copy\"\n", &codec)
}

#[test]
fn a_sweep_of_a_thousand_million_cells_is_refused_before_it_is_made() {
    let folder = Folder::new();
    folder.write("x.toml", sweep());
    for command in [
        &["check-config", "x.toml"][..],
        &["explain", "x.toml", "--no-estimate"],
        &["run", "x.toml", "--list-cells"],
    ] {
        let refused = folder.cvr(command).refused();
        let expected = "the experiment has 1000000002 cells, and 100000 are allowed";
        assert!(refused.contains(expected) && refused.contains("max_cells"), "{refused}");
    }
    let fewer = ["--set", "codec.external.value=1", "--set", "codec.external.name=[\"a\", \"b\", \"a\"]"];
    let ran = folder.cvr(&[&["check-config", "x.toml"][..], &fewer].concat()).exits(0);
    assert!(ran.stdout.contains("2002 cells"), "{}", ran.stdout);
    assert!(
        ran.stderr.contains("note: --set:1: `name` of codec `external` lists `a` again"),
        "{}",
        ran.stderr
    );
    let limit = ["--set", "experiment.max_cells=2001"];
    let refused = folder.cvr(&[&["check-config", "x.toml"][..], &fewer, &limit].concat()).refused();
    assert!(refused.contains("has 2002 cells, and 2001 are allowed"), "{refused}");
}
