//! Runs that are really killed: no file on disk is incomplete, and a resumed run gives the results of a single run.

#![cfg(unix)]

use std::collections::BTreeMap;
use std::os::unix::process::ExitStatusExt as _;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant, SystemTime};

use cvr::experiment::files::results::Results;
use cvr::experiment::records::record::Record;

use super::folder::Folder;

/// Four groups of four cells.
const CONFIG: &str = r##"
[experiment]
name = "killed"
seed = 2
[[volume]]
name = "a"
generate = "turbulence"
dims = [12, 12, 12]
[[volume]]
name = "b"
generate = "shepp-logan"
dims = [12, 12, 12]
[[codec]]
id = "raw"
[[codec]]
id = "s3dc"
block = 4
index_bits = 2
[pipeline]
renderer = "raycasting"
site = ["inline", "host"]
filter = ["nearest", "linear"]
[[scene]]
name = "front"
size = [48, 48]
transfer_function = [[60, "#00000000"], [140, "#d08040c0"], [255, "#ffffffff"]]
"##;

const CELLS: usize = 16;
/// No step of these tests takes this long on any machine. Beyond it, a test fails instead of hanging.
const LIMIT: Duration = Duration::from_secs(120);

fn prepared() -> Folder {
    let folder = Folder::new();
    folder.write("x.toml", CONFIG);
    folder
}

fn start(folder: &Folder, more: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_cvr"))
        .args(["run", "x.toml", "--device", "cpu", "--out", "out"])
        .args(more)
        .current_dir(folder.root())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Waits until something holds, or the process has ended.
fn wait_for(child: &mut Child, what: impl Fn() -> bool) {
    let start = Instant::now();
    while !what() && child.try_wait().unwrap().is_none() {
        assert!(start.elapsed() < LIMIT, "a run that does not come forward");
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn ended(child: &mut Child) -> ExitStatus {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status;
        }
        assert!(start.elapsed() < LIMIT, "a run that does not end");
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn interrupt(child: &Child) {
    let sent = Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status().unwrap();
    assert!(sent.success());
}

fn files(folder: &Folder, part: &str) -> Vec<String> {
    folder.names().into_iter().filter(|n| n.starts_with(part) && folder.path(n).is_file()).collect()
}

fn is_temporary(name: &str) -> bool {
    name.split('/').any(cvr_core::file::is_temporary)
}

/// Number of cells on disk. A run may create and remove files at the same time.
fn finished(folder: &Folder) -> usize {
    let names = std::fs::read_dir(folder.path("out/cells")).into_iter().flatten().flatten();
    names.filter(|n| !is_temporary(&n.file_name().to_string_lossy())).count()
}

type Cells = BTreeMap<String, (Vec<u8>, SystemTime)>;

fn cells(folder: &Folder) -> Cells {
    let whole = files(folder, "out/cells/").into_iter().filter(|n| !is_temporary(n));
    whole
        .map(|n| {
            let changed = std::fs::metadata(folder.path(&n)).unwrap().modified().unwrap();
            let bytes = folder.read(&n);
            (n, (bytes, changed))
        })
        .collect()
}

/// The damage of a file of results, if any. Temporary files do not count.
pub fn damage(name: &str, bytes: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(bytes);
    match name.rsplit('.').next() {
        _ if is_temporary(name) => None,
        // Whatever cuts the list, its last line is not read.
        Some("jsonl") => None,
        Some("json") => serde_json::from_slice::<serde_json::Value>(bytes).err().map(|e| e.to_string()),
        Some("png") => image::load_from_memory(bytes).err().map(|e| e.to_string()),
        Some("csv") => {
            let mut reader = csv::Reader::from_reader(bytes);
            let error = if name.contains("/charts/") || name.contains("/errors/") {
                reader.records().collect::<Result<Vec<_>, _>>().err()
            } else {
                reader.deserialize().collect::<Result<Vec<Record>, _>>().err()
            };
            let whole = bytes.ends_with(b"\n");
            error.map(|e| e.to_string()).or_else(|| (!whole).then(|| "the last row is open".to_owned()))
        }
        Some("svg") => match text {
            Ok(text) if text.ends_with("</svg>\n") => None,
            _ => Some("the drawing is not closed".to_owned()),
        },
        Some("html") => match text {
            Ok(text) if text.trim_end().ends_with("</html>") => None,
            _ => Some("the page is not closed".to_owned()),
        },
        _ => Some("what is this?".to_owned()),
    }
}

#[track_caller]
fn assert_whole(folder: &Folder) {
    for name in files(folder, "out/") {
        assert_eq!(damage(&name, &folder.read(&name)), None, "{name}");
    }
}

/// Every file in the folder of results is temporary, the list itself, or listed.
#[track_caller]
fn assert_listed(folder: &Folder) {
    let names: Vec<_> = files(folder, "out/").into_iter().filter(|n| !is_temporary(n)).collect();
    let list = names.iter().any(|n| n == "out/cvr-files.jsonl").then(|| folder.text("out/cvr-files.jsonl"));
    let listed: Vec<String> = list
        .iter()
        .flat_map(|text| text.lines().skip(1))
        .filter_map(|l| serde_json::from_str(l).ok())
        .collect();
    for name in names.iter().filter_map(|n| n.strip_prefix("out/")).filter(|n| *n != "cvr-files.jsonl") {
        assert!(listed.iter().any(|l| l == name), "{name} is on no list: {listed:?}");
    }
}

#[test]
fn half_a_file_is_noticed() {
    let folder = prepared();
    assert!(ended(&mut start(&folder, &[])).success());
    assert_whole(&folder);
    let mut kinds = 0;
    for name in ["out/results.json", "out/results.csv", "out/report.html"].map(str::to_owned) {
        let bytes = folder.read(&name);
        assert!(damage(&name, &bytes[..bytes.len() - 2]).is_some(), "{name}");
        kinds += 1;
    }
    let charts = files(&folder, "out/charts/");
    for name in &charts {
        let bytes = folder.read(name);
        assert!(damage(name, &bytes[..bytes.len() - 2]).is_some(), "{name}");
    }
    assert!(charts.len() >= 6, "{charts:?}");
    for name in files(&folder, "out/cells/").into_iter().chain(files(&folder, "out/images/")) {
        let bytes = folder.read(&name);
        assert!(damage(&name, &bytes[..bytes.len() / 2]).is_some(), "{name}");
        kinds += 1;
    }
    assert_eq!(kinds, 3 + CELLS + 2 * CELLS + 2);
}

/// The results that do not depend on time.
fn steady(folder: &Folder) -> Vec<String> {
    let results = Results::read(&folder.path("out/results.json")).unwrap();
    assert_eq!(results.provenance.references.len(), 2);
    let text = |r: &Record| {
        let Record {
            volume, codec, settings, site, filter, scene, status, psnr_db, image_ssim, image, ..
        } = r;
        format!(
            "{volume} {codec} {settings} {site} {filter} {scene} {status:?} {psnr_db:?} {image_ssim:?} {image:?}"
        )
    };
    results.records.iter().map(text).collect()
}

/// When to kill: number of finished cells in this run, and milliseconds after that. From a fixed seed, so that a
/// failure can be repeated as far as timing allows.
fn moments() -> Vec<(usize, u64)> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut next = |below: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % below
    };
    (0..7).map(|_| (next(4) as usize, next(70))).collect()
}

#[test]
fn a_killed_run_loses_the_running_cell_alone_and_goes_on() {
    let whole = prepared();
    assert!(ended(&mut start(&whole, &[])).success());

    let folder = prepared();
    let mut kept = Cells::new();
    let mut killed = 0;
    for (count, delay) in moments() {
        let before = finished(&folder);
        // The first time without: there is nothing to go on with.
        let more: &[&str] = if killed == 0 { &[] } else { &["--resume"] };
        let mut child = start(&folder, more);
        wait_for(&mut child, || finished(&folder) >= before + count);
        std::thread::sleep(Duration::from_millis(delay));
        child.kill().unwrap();
        let status = ended(&mut child);
        killed += usize::from(status.signal() == Some(9));
        assert_whole(&folder);
        assert_listed(&folder);
        let now = cells(&folder);
        for (name, cell) in &kept {
            assert_eq!(now.get(name), Some(cell), "{name} was finished, and is run again");
        }
        kept = now;
        if let Ok(results) = Results::read(&folder.path("out/results.json")) {
            assert!(results.records.len() + 1 >= kept.len(), "more than one cell is in no list");
        }
    }
    assert!(killed >= 3, "{killed} runs were killed: too few to tell");
    let output = folder.cvr(&["run", "x.toml", "--device", "cpu", "--out", "out", "--resume"]).exits(0);
    let expected = format!("{} of {CELLS} cells taken over", kept.len());
    assert!(output.stdout.contains(&expected), "{expected}: {}", output.stdout);
    let now = cells(&folder);
    assert!(kept.iter().all(|(name, cell)| now.get(name) == Some(cell)), "finished cells stay as they are");
    assert_whole(&folder);
    assert!(!files(&folder, "out").iter().any(|n| is_temporary(n)), "nothing is left over");
    assert_eq!(steady(&folder), steady(&whole), "the records are those of one run");
    let pictures =
        |f: &Folder| files(f, "out/images").into_iter().map(|n| (f.read(&n), n)).collect::<Vec<_>>();
    assert!(pictures(&folder) == pictures(&whole), "and so are the pictures");
}

#[test]
fn the_first_interrupt_ends_with_a_report_and_says_how_to_go_on() {
    for count in [1, 6] {
        let folder = prepared();
        let mut child = start(&folder, &[]);
        wait_for(&mut child, || finished(&folder) >= count);
        interrupt(&child);
        let output = child.wait_with_output().unwrap();
        let errors = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(130), "{errors}");
        assert!(errors.contains("stopping after the running step"), "{errors}");
        assert!(errors.contains("go on with: cvr run x.toml --device cpu --out out --resume"), "{errors}");
        assert_whole(&folder);
        let results = Results::read(&folder.path("out/results.json")).unwrap();
        let kept = cells(&folder);
        assert_eq!(results.records.len(), kept.len(), "the list is complete");
        assert!((count..CELLS).contains(&kept.len()), "{} cells", kept.len());
        assert!(results.records.iter().all(|r| r.error.is_none()), "a cell that was stopped has not failed");
        assert!(folder.path("out/report.html").is_file());
        assert!(!files(&folder, "out").iter().any(|n| is_temporary(n)), "nothing is left over");

        let resumed = folder.cvr(&["run", "x.toml", "--device", "cpu", "--out", "out", "--resume"]).exits(0);
        let expected = format!("{} of {CELLS} cells taken over", kept.len());
        assert!(resumed.stdout.contains(&expected), "{}", resumed.stdout);
        let now = cells(&folder);
        assert!(kept.iter().all(|(name, cell)| now.get(name) == Some(cell)));
        assert_eq!(steady(&folder).len(), CELLS);
    }
}

#[test]
fn the_second_interrupt_ends_at_once() {
    let folder = prepared();
    // One frame takes minutes.
    let slow = [
        "--set",
        "scene.size=[2048, 2048]",
        "--set",
        "scene.step_voxels=0.01",
        "--set",
        "volume.a.dims=[64, 64, 64]",
    ];
    let mut child = start(&folder, &slow);
    wait_for(&mut child, || folder.path("out/cvr-files.jsonl").is_file());
    std::thread::sleep(Duration::from_millis(300));
    interrupt(&child);
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(child.try_wait().unwrap(), None, "the first lets the running step end");
    interrupt(&child);
    let before = Instant::now();
    assert_eq!(ended(&mut child).code(), Some(130));
    assert!(before.elapsed() < Duration::from_secs(20), "at once");
    assert!(!folder.path("out/report.html").exists());
    assert_whole(&folder);
}
