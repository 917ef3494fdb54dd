//! `cvr explain`.

use super::super::configs::COMPARE;
use super::super::folder::Folder;

const QUICK: &str = include_str!("../../../configs/quickstart.toml");

#[test]
fn cells_are_counted_as_they_would_run_and_nothing_is_written() {
    let folder = Folder::new();
    folder.write("x.toml", QUICK);
    let text = folder.cvr(&["explain", "x.toml", "--no-estimate"]).exits(0).stdout;
    assert!(text.starts_with("x.toml: 34 cells, 11 combinations refused\n"), "{text}");
    let listed = folder.cvr(&["run", "x.toml", "--list-cells"]).exits(0).stdout;
    let (refused, cells): (Vec<&str>, Vec<&str>) = listed.lines().partition(|l| l.starts_with("refused "));
    // The sum of the column is the number of running cells. The same holds for the reasons.
    let numbers = |from: &str| -> usize {
        let lines = text.split(from).nth(1).unwrap().split("\n\n").next().unwrap().lines();
        lines.filter_map(|l| l.split_whitespace().next()?.parse::<usize>().ok()).sum()
    };
    assert_eq!((numbers("\ncells\n"), numbers("\nrefused ")), (cells.len(), refused.len()), "{text}");
    assert!(text.contains("rings  64×64×64  u8"), "{text}");
    assert!(text.contains("256.0 KiB") && text.contains("fetch_cell"), "{text}");
    assert!(!text.contains("estimate"), "{text}");
    assert_eq!(folder.names(), ["x.toml"]);
    let fewer = ["explain", "x.toml", "--no-estimate", "--set", "pipeline.site=host"];
    assert!(folder.cvr(&fewer).exits(0).stdout.starts_with("x.toml: 10 cells, 5 combinations"));
}

#[test]
fn estimates_say_what_they_are_and_stand_on() {
    let folder = Folder::new();
    folder.write("x.toml", QUICK);
    let one = [
        "--set",
        "codec.s3dc.block=8",
        "--set",
        "codec.s3dc.index_bits=2",
        "--set",
        "pipeline.filter=linear",
    ];
    let ran = folder.cvr(&[&["explain", "x.toml", "--device", "cpu"][..], &one].concat()).exits(0);
    let text = ran.stdout;
    assert!(text.contains("estimate, from a computed volume of 48³ voxels"), "{text}");
    // The original's byte; stream and frame, 5 bytes per voxel, of the baseline and of the cells of raw.
    assert!(text.contains("memory  2.8 MiB in main memory\n") && !text.contains("on the device\n"), "{text}");
    assert!(
        (text.contains("time    about ") || text.contains("time    at least "))
            && text.contains(" to encode and decode, "),
        "{text}"
    );
    let host = "site host, on cpu\n  no texture, the CPU mirror draws from the decoded frame; a device would have texels of \
                8-bit unorm\n    raw: rings\n";
    assert!(text.contains(host), "{text}");
    let inline = ["explain", "x.toml", "--device", "cpu", "--set", "pipeline.site=inline"];
    let inline = folder.cvr(&[&inline[..], &one].concat()).exits(0).stdout;
    assert!(inline.contains("memory  ") && !inline.contains("site host"), "{inline}");
    assert!(text.contains("Counted") && text.contains("Not counted"), "{text}");
    assert_eq!(folder.names(), ["x.toml"]);
}

#[test]
fn missing_volumes_are_told_and_left_out() {
    let folder = Folder::new();
    folder.write("x.toml", COMPARE);
    let text = folder.cvr(&["explain", "x.toml"]).exits(0).stdout;
    assert!(
        text.contains("not known here: volume `bonsai`") && text.contains("CVR_DATA is not set"),
        "{text}"
    );
    assert!(text.starts_with("x.toml: 28 cells") && !text.contains("\nestimate"), "{text}");
    let text = folder.cvr(&["explain", "x.toml", "--volume", "none.nrrd"]).exits(0).stdout;
    assert!(text.contains("not known here: volume `none`: none.nrrd: cannot open the file"), "{text}");
}

/// The header is read and the voxels are not. The file's length proves that they exist.
#[test]
fn a_file_is_opened_for_its_header() {
    let folder = Folder::new();
    folder.write("x.toml", COMPARE);
    let header = "NRRD0004\ntype: short\ndimension: 3\nsizes: 20 30 40\nspacings: 1 1 2\nencoding: raw\nendian: little\n\n";
    let explain = ["explain", "x.toml", "--volume", "a.nrrd", "--no-estimate"];
    folder.write("a.nrrd", [header.as_bytes(), &[0; 2 * 20 * 30 * 40][..]].concat());
    let text = folder.cvr(&explain).exits(0).stdout;
    assert!(text.contains("a     20×30×40  i16") && text.contains("46.9 KiB"), "{text}");
    folder.write("a.nrrd", [header.as_bytes(), &[0; 2 * 20 * 30 * 39][..]].concat());
    let text = folder.cvr(&explain).exits(0).stdout;
    assert!(
        text.contains("not known here: volume `a`: a.nrrd") && text.contains("46800 are there"),
        "{text}"
    );
    let raw =
        ["explain", "x.toml", "--no-estimate", "--volume", "b*.raw", "--dims", "4x4x4", "--dtype", "u32"];
    for name in ["b1.raw", "b2.raw", "b10.raw"] {
        folder.write(name, [0; 256]);
    }
    let text = folder.cvr(&raw).exits(0).stdout;
    assert!(text.contains("b     4×4×4   f32             1       3"), "{text}");
}

#[test]
fn what_is_wrong_with_a_configuration_is_bad_input() {
    let folder = Folder::new();
    folder.write("x.toml", COMPARE.replace("step_voxels", "step_voxel"));
    assert!(folder.cvr(&["explain", "x.toml"]).refused().contains("did you mean `step_voxels`?"));
    folder.write("x.toml", COMPARE);
    assert!(folder.cvr(&["explain", "x.toml", "--set", "pipeline.site=moon"]).refused().contains("moon"));
}

/// A command that does not end: its trial is abandoned, and the output says what is missing.
#[cfg(unix)]
#[test]
fn a_trial_that_does_not_end_is_left() {
    let folder = Folder::new();
    let config = |encode: &str| {
        let external = format!(
            "[[codec]]\nid = \"external\"\nname = \"slow\"\nencode = \"{encode}\"\ndecode = \"cp {{in}} {{out}}\"\n"
        );
        let head = QUICK.split("[[codec]]").next().unwrap();
        let tail = QUICK.split("[pipeline]").nth(1).unwrap();
        format!("{head}[[codec]]\nid = \"raw\"\n{external}[pipeline]{tail}")
    };
    let explain =
        ["explain", "x.toml", "--device", "cpu", "--set", "pipeline.site=host", "--set", "scene.size=[8, 8]"];
    folder.write("x.toml", config("sh -c 'sleep 600 # {in} {out}'"));
    let text = folder.cvr(&explain).exits(0).stdout;
    assert!(text.contains("  time    at least ") && text.contains("\nwhat costs\n"), "{text}");
    let row = text.lines().find(|l| l.trim_start().starts_with("external  ")).unwrap_or_default();
    assert!(row.contains("the trial to encode did not end in 2.0 s and was left"), "{text}");
    assert!(text.contains("  memory  at least "), "{text}");
    folder.write("x.toml", config("cp {in} {out}"));
    let text = folder.cvr(&explain).exits(0).stdout;
    let row = text.lines().find(|l| l.trim_start().starts_with("external  ")).unwrap_or_default();
    assert!(!row.contains("encode did not end"), "{text}");
}

/// Seven codecs, four volumes of other kinds and two scenes: more than fit into the time limit. The sum counts each
/// trial until it ended or was abandoned.
#[test]
fn many_codecs_and_volumes_are_explained_in_the_time_that_there_is() {
    let Some(data) = std::env::var_os("CVR_DATA") else {
        return eprintln!("CVR_DATA is not set: no cases");
    };
    let cases = std::path::Path::new(&data).join("../cases/scenes/37-constant-run");
    let Ok(files) = std::fs::read_dir(&cases) else {
        return eprintln!("{} is not there", cases.display());
    };
    let folder = Folder::new();
    for file in files.map(|file| file.unwrap()) {
        folder.write(file.file_name().to_str().unwrap(), std::fs::read(file.path()).unwrap());
    }
    let text = folder.cvr(&["explain", "c.toml", "--device", "cpu"]).exits(0).stdout;
    let rows = text.split("\nwhat costs\n").nth(1).unwrap().split("\n\n").next().unwrap().lines().skip(1);
    // Codec, then three times a number and a unit. The third is the time of trials.
    let tried = |row: &str| -> f64 {
        let words: Vec<&str> = row.split_whitespace().collect();
        assert!(words[6] == "s", "{row}");
        words[5].parse().unwrap()
    };
    let tried: Vec<f64> = rows.map(tried).collect();
    assert!(tried.len() == 7 && tried.iter().sum::<f64>() < 23.0, "{text}");
}
