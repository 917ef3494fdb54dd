//! Commands as codecs in a whole run: their names distinguish them, failures become records, and the run goes on.
#![cfg(unix)]

use super::folder::Folder;

const CONFIG: &str = r##"
[experiment]
name = "commands"
[[volume]]
name = "v"
generate = "turbulence"
dims = [8, 8, 8]
dtype = "u8"
[[codec]]
id = "external"
name = "gzip"
encode = "sh -c 'gzip -{value} -c < {in} > {out}'"
decode = "sh -c 'gzip -dc < {in} > {out}'"
value = [1, 9]
[[codec]]
id = "external"
name = "broken"
decode = "sh -c 'echo this cannot work; false # {in} {out}'"
[[codec]]
id = "external"
name = "slow"
encode = "sh -c 'sleep 60 # {in} {out}'"
timeout_seconds = 1
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
fn commands_that_fail_or_hang_are_records_and_the_run_goes_on() {
    let folder = Folder::new();
    folder.write("commands.toml", CONFIG);
    let ran = folder.cvr(&["run", "commands.toml", "--device", "cpu"]).exits(1);
    assert!(ran.stdout.contains("4 cells: 2 ok, 2 failed"), "{}", ran.stdout);
    let results = folder.json("results/commands/results.json");
    let of = |codec: &str| -> Vec<&serde_json::Value> {
        results["records"].as_array().unwrap().iter().filter(|r| r["codec"] == codec).collect()
    };
    let gzip = of("external:gzip");
    assert_eq!(gzip.len(), 2);
    for record in gzip {
        assert_eq!(record["status"], "ok");
        assert_eq!(record["max_abs_error"], 0.0);
        assert!(
            record["file_bytes"].as_u64().unwrap() > 20 && record["encode_seconds"].as_f64().unwrap() > 0.0
        );
        assert!(record["image"].is_string());
        assert!(record["notes"].as_str().unwrap().contains("whole processes"));
    }
    for (codec, reason) in
        [("external:broken", "this cannot work"), ("external:slow", "was killed after 1 s")]
    {
        let [record] = of(codec)[..] else { panic!("{codec}") };
        assert_eq!(record["status"], "failed");
        assert!(record["error"].as_str().unwrap().contains(reason), "{record}");
    }
    // The cells of a chart's points can be run again by their names.
    let listed = folder.cvr(&["run", "commands.toml", "--list-cells"]).exits(0).stdout;
    let report = folder.text("results/commands/report.html");
    let cells: Vec<&str> = listed.lines().filter(|line| line.contains("gzip")).collect();
    assert_eq!(cells.len(), 2, "{listed}");
    for cell in cells {
        assert!(report.contains(cell), "{cell}");
    }
}

#[test]
fn a_file_that_names_a_command_does_not_run_it() {
    let folder = Folder::new();
    folder.write("v.raw", [7; 64]);
    let made = ["encode", "v.raw", "v.cvr", "--dims", "4x4x4", "--dtype", "u8", "--codec", "external"];
    folder.cvr(&made).exits(0);
    let refused = folder.cvr(&["decode", "v.cvr", "back.nrrd"]).refused();
    assert!(refused.contains("`cp {in} {out}`") && refused.contains("CVR_TRUST_COMMANDS=1"), "{refused}");
    assert!(!folder.path("back.nrrd").exists());
}
