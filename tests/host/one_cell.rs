//! A single cell of an experiment, run with the command in the report.

use serde_json::Value;

use super::folder::Folder;

const CONFIG: &str = r##"
[experiment]
name = "several"
seed = 3
[[volume]]
name = "noise"
generate = "turbulence"
dims = [8, 8, 8]
[[volume]]
name = "absent"
file = "absent.nrrd"
[[codec]]
id = "raw"
[[codec]]
id = "s3dc"
block = [4, "8x8x4"]
[pipeline]
renderer = ["raycasting", "slicing"]
site = ["inline", "host"]
filter = ["nearest", "linear", "optimised-linear"]
[[scene]]
name = "front view"
size = [8, 8]
transfer_function = [[0, "#00000000"], [255, "#ffffffff"]]
[[scene]]
name = "s"
size = [8, 8]
transfer_function = [[0, "#00000000"], [255, "#ffffffff"]]
"##;

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("x.toml", CONFIG);
    folder
}

/// The JSON that a report's script reads.
fn data(report: &str) -> Value {
    let (_, rest) = report.split_once("<script type=\"application/json\" id=\"data\">").unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

/// The words of a command, split as `sh` does.
fn words(command: &str) -> Vec<String> {
    let print = format!("for word in {command}; do printf '%s\\n' \"$word\"; done");
    let out = std::process::Command::new("sh").args(["-c", &print]).output().unwrap();
    String::from_utf8(out.stdout).unwrap().lines().map(str::to_owned).collect()
}

#[test]
fn the_reports_command_runs_its_cell_and_no_other() {
    let folder = folder();
    let all = ["run", "x.toml", "--device", "cpu", "--set", "scene.size=[9, 8]", "--out", "all", "--volume"];
    folder.volume(
        "noise.nrrd",
        &super::volumes::seeded(
            cvr::input::Generator::Turbulence,
            [8; 3],
            cvr_core::volume::SampleType::U8,
            3,
        ),
    );
    folder.cvr(&[&all[..], &["noise.nrrd"]].concat()).exits(0);
    let report = folder.text("all/report.html");
    let before = folder.names();
    let cells = data(&report)["cells"].as_array().unwrap().clone();
    let records = folder.json("all/results.json")["records"].as_array().unwrap().clone();
    assert_eq!(cells.len(), records.len());
    let wanted = |r: &Value| r["codec"] == "s3dc" && r["scene"] == "front view" && r["site"] == "inline";
    let at = records.iter().rposition(wanted).unwrap();
    let command = words(cells[at]["command"].as_str().unwrap());
    assert_eq!(command[0], "cvr");
    let words: Vec<&str> = command[1..].iter().map(String::as_str).collect();
    folder.cvr(&words).exits(0);

    let of = |run: &str| -> Vec<String> {
        let prefix = format!("{run}/cells/");
        folder.names().iter().filter_map(|n| n.strip_prefix(&prefix).map(str::to_owned)).collect()
    };
    let [again] = &of("results/one-cell")[..] else { panic!("{:?}", of("results/one-cell")) };
    let first = folder.json(&format!("all/cells/{again}"));
    let second = folder.json(&format!("results/one-cell/cells/{again}"));
    for field in ["key", "settings", "scene", "renderer", "file_bytes", "image_psnr_db", "pictures"] {
        assert_eq!(first[field], second[field], "{field}");
        let same = field == "key" || field == "pictures" || first[field] == records[at][field];
        assert!(same, "{field}");
    }
    assert!(second["relative_frame_time"].as_f64().unwrap() > 0.0, "the baseline ran too");
    assert!(before.iter().all(|name| folder.names().contains(name)), "the first results are still there");
}

#[test]
fn one_cell_needs_no_other_volume_and_a_wrong_name_runs_nothing() {
    let folder = folder();
    let listed = folder.cvr(&["run", "x.toml", "--list-cells"]).exits(0).stdout;
    let name =
        listed.lines().find(|l| l.starts_with("noise-raw-") && l.contains("-s-raycasting-host")).unwrap();
    let run = |name: &str, more: &[&str]| {
        folder.cvr(&[&["run", "x.toml", "--device", "cpu", "--out", "one", "--cell", name], more].concat())
    };
    let absent = name.replace("noise", "absent");
    assert!(run(&absent, &[]).refused().contains("absent.nrrd"));
    assert!(run("moon", &[]).refused().contains("--list-cells prints the names of all"));
    let refused = listed.lines().find_map(|l| l.strip_prefix("refused ")?.split_once(':')).unwrap();
    assert!(run(refused.0, &[]).refused().contains("cannot run: "), "{refused:?}");
    assert!(!folder.path("one").exists());
    run(name, &[]).exits(0);
    assert_eq!(folder.json("one/results.json")["records"].as_array().unwrap().len(), 1);
    assert_eq!(run(name, &["--list-cells"]).exits(0).stdout.trim(), name);
    let sharded = run(name, &["--shard", "1/2"]);
    assert_eq!(sharded.code, Some(2), "{sharded:?}");
}
