//! Shards and their union: every cell once, and unrelated results are refused.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use cvr::experiment::files::cell_file::digest_of;
use cvr::input::Generator;
use cvr_core::volume::SampleType;
use serde_json::Value;

use super::folder::Folder;
use super::volumes::seeded;

/// Three groups of one codec with its settings, four cells each.
const CONFIG: &str = r##"
[experiment]
name = "dealt"
seed = 5
[[volume]]
name = "scan"
file = "scan.nrrd"
[[codec]]
id = "s3dc"
block = 4
index_bits = [4, 2]
[[codec]]
id = "raw"
[pipeline]
renderer = "raycasting"
site = ["inline", "host"]
filter = ["nearest", "linear"]
[[scene]]
name = "front"
size = [16, 16]
transfer_function = [[60, "#00000000"], [140, "#d08040c0"], [255, "#ffffffff"]]
"##;

fn prepared() -> Folder {
    let folder = Folder::new();
    folder.write("x.toml", CONFIG);
    folder.volume("scan.nrrd", &seeded(Generator::Turbulence, [8, 6, 4], SampleType::U8, 3));
    folder
}

fn run<'a>(out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["run", "x.toml", "--device", "cpu", "--out", out][..], more].concat()
}

/// The whole experiment in `whole`, its shards in `s1` to `s4`. Later tests write nothing here.
fn dealt() -> &'static Folder {
    static DEALT: OnceLock<Folder> = OnceLock::new();
    DEALT.get_or_init(|| {
        let folder = prepared();
        folder.cvr(&run("whole", &[])).exits(0);
        for (out, shard) in [("s1", "1/4"), ("s2", "2/4"), ("s3", "3/4"), ("s4", "4/4")] {
            folder.cvr(&run(out, &["--shard", shard])).exits(0);
        }
        folder
    })
}

fn records(folder: &Folder, run: &str) -> Vec<Value> {
    folder.json(&format!("{run}/results.json"))["records"].as_array().unwrap().clone()
}

fn names(records: &[Value]) -> Vec<String> {
    let columns = ["volume", "codec", "settings", "site", "filter", "renderer", "scene"];
    let name = |r: &Value| columns.map(|c| r[c].as_str().unwrap().to_owned()).join(" ");
    records.iter().map(name).collect()
}

/// Copies a run, so that it can be changed.
fn copy(from: &Folder, run: &str, to: &Folder, as_run: &str) {
    for name in from.names().iter().filter(|n| n.starts_with(&format!("{run}/"))) {
        let target = to.path(&name.replacen(run, as_run, 1));
        if from.path(name).is_dir() {
            continue;
        }
        std::fs::create_dir_all(target.parent().unwrap()).unwrap();
        std::fs::copy(from.path(name), target).unwrap();
    }
}

/// Replaces a text in all records of a run and in its provenance. Digests are renewed.
fn edit(folder: &Folder, run: &str, from: &str, to: &str) {
    let files = folder.names().into_iter().filter(|n| n.starts_with(run) && n.ends_with(".json"));
    for name in files {
        let mut text = folder.text(&name).replace(from, to);
        if name.contains("/cells/") {
            let mut value: Value = serde_json::from_str(&text).unwrap();
            value.as_object_mut().unwrap().remove("digest").unwrap();
            value["digest"] = digest_of(&value).into();
            text = serde_json::to_string_pretty(&value).unwrap();
        }
        folder.write(&name, text);
    }
}

#[test]
fn shards_hold_every_cell_once_and_encode_nothing_twice() {
    let folder = dealt();
    let whole = names(&records(folder, "whole"));
    let shards: Vec<Vec<String>> = ["s1", "s2", "s3", "s4"].map(|s| names(&records(folder, s))).to_vec();
    assert_eq!(shards.iter().map(Vec::len).collect::<Vec<_>>(), [4, 4, 4, 0], "more shards than groups");
    let union: BTreeSet<&String> = shards.iter().flatten().collect();
    assert_eq!(union, whole.iter().collect());
    for shard in &shards {
        let codecs: BTreeSet<&str> = shard.iter().map(|n| n.split(" inline ").next().unwrap()).collect();
        let codecs = codecs.iter().filter(|n| !n.contains(" host ")).count();
        assert!(codecs <= 1, "one codec and settings: {shard:?}");
    }
    for i in 1..=4 {
        let listed = folder.cvr(&["run", "x.toml", "--list-cells", "--shard", &format!("{i}/4")]).exits(0);
        assert_eq!(listed.stdout.lines().count(), shards[i - 1].len());
    }
}

#[test]
fn merged_shards_are_the_whole() {
    let folder = dealt();
    let ran = folder.cvr(&["merge", "s3", "s1", "s4", "s2", "--out", "merged"]).exits(0);
    assert!(ran.stdout.contains("12 cells of 4 folders: 12 ok, 0 failed"), "{}", ran.stdout);
    assert!(ran.stderr.is_empty(), "nothing is missing: {}", ran.stderr);
    let (merged, whole) = (folder.json("merged/results.json"), folder.json("whole/results.json"));
    let (ours, theirs) = (records(folder, "merged"), records(folder, "whole"));
    assert_eq!(names(&ours), names(&theirs), "in the order of the configuration");
    for (a, b) in ours.iter().zip(&theirs) {
        for column in ["psnr_db", "image_ssim", "file_bytes", "image", "error_image"] {
            assert_eq!(a[column], b[column]);
        }
        for column in ["image", "error_image"] {
            let name = a[column].as_str().unwrap();
            assert_eq!(folder.read(&format!("merged/{name}")), folder.read(&format!("whole/{name}")));
        }
    }
    for key in ["references", "volumes", "seed", "config", "adapter", "version"] {
        assert_eq!(merged["provenance"][key], whole["provenance"][key], "{key}");
    }
    let reference = merged["provenance"]["references"][0]["image"].as_str().unwrap();
    assert!(folder.path(&format!("merged/{reference}")).is_file());
    let parts = merged["provenance"]["parts"].as_array().unwrap();
    let parts: Vec<(&str, u64)> =
        parts.iter().map(|p| (p["folder"].as_str().unwrap(), p["records"].as_u64().unwrap())).collect();
    assert_eq!(parts, [("s3", 4), ("s1", 4), ("s4", 0), ("s2", 4)]);
    assert!(folder.text("merged/report.html").contains("merged from"));
    assert_eq!(folder.text("merged/results.csv").lines().count(), 13);
    assert!(!folder.text("merged/results.json").contains(folder.root().to_str().unwrap()));

    // A merged folder is a folder of results: it can be merged and resumed.
    folder.cvr(&["merge", "merged", "--out", "twice"]).exits(0);
    assert_eq!(records(folder, "twice"), ours);
    assert_eq!(folder.json("twice/results.json")["provenance"]["parts"].as_array().unwrap().len(), 4);
    let ran = folder.cvr(&run("twice", &["--resume"])).exits(0);
    assert!(ran.stdout.contains("12 of 12 cells taken over; 0 encodings"), "{}", ran.stdout);
}

#[test]
fn a_missing_shard_is_told() {
    let folder = dealt();
    let ran = folder.cvr(&["merge", "s1", "s2", "--out", "part"]).exits(0);
    assert!(ran.stderr.contains("4 of 12 cells of the experiment are in no folder"), "{}", ran.stderr);
}

#[test]
fn shards_that_run_one_after_another_may_share_a_folder() {
    let folder = prepared();
    for shard in ["1/2", "2/2"] {
        folder.cvr(&run("both", &["--shard", shard, "--resume"])).exits(0);
    }
    let cells = folder.names().iter().filter(|n| n.starts_with("both/cells/")).count();
    assert_eq!(cells, 12, "the second removed nothing of the first");
    let ran = folder.cvr(&run("both", &["--resume"])).exits(0);
    assert!(ran.stdout.contains("12 of 12 cells taken over; 0 encodings"), "{}", ran.stdout);
    assert_eq!(records(&folder, "both").len(), 12);
}

#[test]
fn a_cell_that_stands_twice_under_one_key_is_one() {
    let folder = dealt();
    folder.cvr(&["merge", "whole", "s2", "--out", "overlap"]).exits(0);
    assert_eq!(records(folder, "overlap"), records(folder, "whole"), "the first is kept");
    // Unless it failed.
    let own = Folder::new();
    copy(folder, "whole", &own, "a");
    copy(folder, "whole", &own, "b");
    edit(&own, "a", "\"status\": \"ok\"", "\"status\": \"failed\"");
    own.cvr(&["merge", "a", "b", "--out", "c"]).exits(0);
    assert!(records(&own, "c").iter().all(|r| r["status"] == "ok"));
    own.cvr(&["merge", "a", "--out", "c"]).exits(1);
}

#[test]
fn cells_of_several_devices_are_all_kept() {
    let own = Folder::new();
    copy(dealt(), "whole", &own, "a");
    copy(dealt(), "whole", &own, "b");
    edit(&own, "b", "\"device\": \"cpu\"", "\"device\": \"gpu\"");
    edit(&own, "b", "\"adapter\": \"cpu\"", "\"adapter\": \"gpu\"");
    edit(&own, "b", "\"key\": \"", "\"key\": \"0");
    own.cvr(&["merge", "a", "b", "--out", "c"]).exits(0);
    let records = records(&own, "c");
    assert_eq!(records.len(), 24);
    let devices: Vec<&str> = records.iter().map(|r| r["device"].as_str().unwrap()).collect();
    assert_eq!(devices[..4], ["cpu", "gpu", "cpu", "gpu"], "side by side");
    let pictures: BTreeSet<&str> = records.iter().map(|r| r["image"].as_str().unwrap()).collect();
    assert_eq!(pictures.len(), 24, "each has a picture of its own");
    assert!(pictures.iter().all(|p| own.path(&format!("c/{p}")).is_file()));
    assert_eq!(own.json("c/results.json")["provenance"]["adapter"], "cpu; gpu");
    // The twin: another result on the same device.
    edit(&own, "b", "\"device\": \"gpu\"", "\"device\": \"cpu\"");
    let before = own.names();
    let message = own.cvr(&["merge", "a", "b", "--out", "d"]).refused();
    assert!(message.contains("b: cell scan s3dc") && message.contains("same device (cpu)"), "{message}");
    assert_eq!(own.names(), before, "nothing is written");
}

#[test]
fn results_of_other_experiments_are_refused() {
    let folder = prepared();
    folder.cvr(&run("a", &["--shard", "1/3"])).exits(0);
    let second = |more: &[&str]| {
        folder.cvr(&run("b", &[&["--shard", "2/3", "--overwrite"][..], more].concat())).exits(0);
        folder.cvr(&["merge", "a", "b", "--out", "c"])
    };
    second(&[]).exits(0);
    std::fs::remove_dir_all(folder.path("c")).unwrap();
    let seed = second(&["--set", "experiment.seed=6"]).refused();
    assert!(seed.contains("b: ") && seed.contains("seed"), "{seed}");
    let step = second(&["--set", "scene.step_voxels=0.9"]).refused();
    assert!(step.contains("b: it ran with --set") && step.contains("step_voxels=0.9"), "{step}");
    folder.write("x.toml", CONFIG.replace("[16, 16]", "[16, 17]"));
    let config = second(&[]).refused();
    assert!(config.contains("b: its configuration is not that of a"), "{config}");
    folder.write("x.toml", CONFIG);
    let other = seeded(Generator::Turbulence, [8, 6, 4], SampleType::U8, 4);
    folder.volume("scan.nrrd", &other);
    let volume = second(&[]).refused();
    let hash = blake3::hash(other.samples().as_bytes()).to_hex();
    assert!(volume.contains("b: volume `scan`") && volume.contains(hash.as_str()), "{volume}");
    // A seed of the configuration itself, with the text as it was.
    copy(&folder, "a", &folder, "e");
    edit(&folder, "e", "\"seed\": 5", "\"seed\": 6");
    let seed = folder.cvr(&["merge", "a", "e", "--out", "c"]).refused();
    assert!(seed.contains("e: its seed is 6, that of a 5"), "{seed}");
    assert!(!folder.path("c").exists(), "nothing was written");
}

#[test]
fn a_folder_that_is_not_whole_is_named() {
    let own = Folder::new();
    copy(dealt(), "s1", &own, "a");
    let merge = || own.cvr(&["merge", "a", "--out", "c"]);
    merge().exits(0);
    for (name, what) in [
        ("images/scan-s3dc-block=4,index_bits=4-front-raycasting-host-linear.png", "has changed"),
        ("cells/scan-s3dc-block=4,index_bits=4-front-raycasting-host-linear.json", "lacks the file of cell"),
        ("results.json", "results.json"),
    ] {
        let bytes = own.read(&format!("a/{name}"));
        own.write(&format!("a/{name}"), &bytes[..bytes.len() / 2]);
        // Old results stay. That they would be replaced is said first.
        let before = own.names();
        let message = merge().exits(2).stderr;
        assert_eq!(own.names(), before);
        assert!(message.contains("a: ") && message.contains(what), "{message}");
        own.write(&format!("a/{name}"), bytes);
        merge().exits(0);
    }
    // An edited record, and one without a digest: the first is not trusted, the second is refused.
    let name = "a/cells/scan-s3dc-block=4,index_bits=4-front-raycasting-host-linear.json";
    let text = own.text(name);
    own.write(name, text.replacen("\"psnr_db\": ", "\"psnr_db\": 1", 1));
    let before = own.names();
    let message = merge().refused();
    assert!(
        message.contains("host-linear.json is not as it was written: run it again with --resume"),
        "{message}"
    );
    assert_eq!(own.names(), before);
    own.write(name, text.replace("\"digest\"", "\"another\""));
    let ran = merge().exits(0);
    assert!(ran.stderr.contains("a: 1 record(s) carry no digest"), "{}", ran.stderr);
    assert!(own.json(&name.replacen('a', "c", 1)).get("digest").is_none());
    own.write(name, &text);
    merge().exits(0);
    assert!(own.json(&name.replacen('a', "c", 1)).get("digest").is_some());

    let message = own.cvr(&["merge", "a", "none", "--out", "c"]).refused();
    assert!(message.contains("none"), "{message}");
    let message = own.cvr(&["merge", "a", "--out", "./a"]).refused();
    assert!(message.contains("is merged itself"), "{message}");
    // A record is data: it must not pull other files along.
    own.write("secret.png", "secret");
    edit(&own, "a", "\"image\": \"images/", "\"image\": \"../a/images/");
    let message = merge().exits(2).stderr;
    assert!(message.contains("is no picture of this folder"), "{message}");
}
