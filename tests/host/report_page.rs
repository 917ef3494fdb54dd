//! The report in a browser, if there is one: `chromium`, `chromium-browser` or `google-chrome`.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use cvr::experiment::files::results::Results;
use cvr::experiment::records::record::Status;

use super::folder::Folder;

const CONFIG: &str = r##"
[experiment]
name = "page"
seed = 7
[[volume]]
name = "noise"
generate = "turbulence"
dims = [12, 12, 12]
[[volume]]
name = "rings"
generate = "marschner-lobb"
dims = [12, 12, 12]
[[codec]]
id = "raw"
[[codec]]
id = "s3dc"
block = 4
index_bits = [2, 4]
[pipeline]
renderer = ["raycasting", "slicing"]
site = ["inline", "host"]
filter = ["nearest", "linear"]
[[scene]]
name = "front"
size = [24, 24]
transfer_function = [[60, "#00000000"], [255, "#ffffffff"]]
"##;

/// A name that no configuration would be given in good faith.
const HOSTILE: &str = "</script><script>alert(1)</script><img src=x onerror=alert(2)>";

/// Charts of the report: two of both volumes; per volume one of voxels, two of each device (encoding, decoding), one of
/// each of two views, the frame time of each view on each device, and one of errors. The mirror has no device memory to
/// show.
const CHARTS: usize = 2 + 2 * (1 + 2 * 2 + 2 + 2 * 2 + 1);

/// A report of two volumes (one with a hostile name), two devices and a failed cell; with its folder.
fn report() -> &'static Folder {
    static REPORT: OnceLock<Folder> = OnceLock::new();
    REPORT.get_or_init(|| {
        let folder = Folder::new();
        folder.write("page.toml", CONFIG);
        folder.cvr(&["run", "page.toml", "--device", "cpu", "--out", "out"]).exits(0);
        let mut results = Results::read(&folder.path("out/results.json")).unwrap();
        for record in results.records.iter_mut().filter(|r| r.volume == "noise") {
            record.volume = HOSTILE.to_owned();
        }
        for volume in results.provenance.volumes.iter_mut().filter(|v| v.name == "noise") {
            volume.name = HOSTILE.to_owned();
        }
        for picture in results.provenance.references.iter_mut().filter(|p| p.volume == "noise") {
            picture.volume = HOSTILE.to_owned();
        }
        let mut elsewhere = results.records.clone();
        elsewhere.iter_mut().for_each(|r| r.device = HOSTILE.to_uppercase());
        results.records.extend(elsewhere);
        let last = results.records.last_mut().unwrap();
        (last.status, last.error) = (Status::Failed, Some(HOSTILE.to_owned()));
        let owner = cvr::experiment::identity::experiment::owner(&results.provenance);
        let out = cvr::experiment::files::folder::OutFolder::adopt(&folder.path("out"), owner).unwrap();
        cvr::report::write(&out, &results.provenance, &results.records, &results.refused).unwrap();
        folder
    })
}

fn browser() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome"];
    std::env::split_paths(&path).flat_map(|dir| names.map(|name| dir.join(name))).find(|p| p.is_file())
}

/// The browser's result for a page.
#[derive(Debug)]
struct Shown {
    /// The page's own findings. `None` if its script did not end.
    found: Option<String>,
    /// Messages in the page's console.
    console: Vec<String>,
    /// Network requests, except the browser's own.
    requests: Vec<String>,
}

impl Shown {
    fn is_well(&self) -> bool {
        self.console.is_empty()
            && self.requests.is_empty()
            && self.found.as_ref().is_some_and(|found| found.starts_with("passed: "))
    }
}

/// Loads a page in a window of this width. `None` without a browser.
fn show(page: &Path, width: u32, more: &[&str]) -> Option<Shown> {
    let Some(browser) = browser() else {
        eprintln!("skipped: no chromium, chromium-browser or google-chrome in PATH");
        return None;
    };
    let scratch = tempfile::tempdir().unwrap();
    let [out, log, net] = ["dom", "log", "net"].map(|name| scratch.path().join(name));
    let mut child = Command::new(browser)
        .args(["--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-sync"])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-quic"])
        .args(["--enable-logging=stderr", "--v=0", "--host-resolver-rules=MAP * ~NOTFOUND"])
        .arg(format!("--user-data-dir={}", scratch.path().join("profile").display()))
        .arg(format!("--log-net-log={}", net.display()))
        .arg(format!("--window-size={width},1000"))
        .args(more)
        .args(["--dump-dom", &format!("file://{}#selftest", page.display())])
        .stdin(Stdio::null())
        .stdout(std::fs::File::create(&out).unwrap())
        .stderr(std::fs::File::create(&log).unwrap())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > Duration::from_secs(120) {
            child.kill().unwrap();
            child.wait().unwrap();
            break;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let dom = String::from_utf8_lossy(&std::fs::read(out).unwrap()).into_owned();
    let log = String::from_utf8_lossy(&std::fs::read(log).unwrap()).into_owned();
    let found =
        dom.rsplit_once("<pre id=\"selftest\" hidden=\"\">").and_then(|(_, rest)| rest.split_once("</pre>"));
    let cut = |text: &str| text.chars().take(600).collect::<String>();
    let net = String::from_utf8_lossy(&std::fs::read(net).unwrap()).into_owned();
    let asked = net.split("\"url\":\"").skip(1).filter(|url| url.starts_with("http"));
    let host = |url: &str| url.split('/').nth(2).unwrap_or_default().to_owned();
    let maker = |host: &str| [".google.com", ".googleapis.com"].iter().any(|name| host.ends_with(name));
    Some(Shown {
        found: found.map(|(found, _)| cut(found)),
        console: log.lines().filter(|line| line.contains("CONSOLE")).map(cut).collect(),
        requests: asked.map(host).filter(|host| !maker(host)).collect(),
    })
}

#[test]
fn the_page_works_at_every_width_and_in_both_colour_schemes() {
    let page = report().path("out/report.html");
    for (width, more) in [(1280, ""), (480, ""), (1280, "--blink-settings=preferredColorScheme=0")] {
        let more: Vec<&str> = Some(more).filter(|m| !m.is_empty()).into_iter().collect();
        if let Some(shown) = show(&page, width, &more) {
            assert!(shown.is_well(), "{width} {more:?}: {shown:?}");
        }
    }
}

/// Broken pages: each must be detected.
#[test]
fn a_broken_page_is_noticed() {
    let folder = report();
    let good = folder.text("out/report.html");
    for (name, from, to) in [
        ("a request", "<main>", "<main><img src=\"https://cvr.invalid/x.png\">"),
        ("a foreign script", "<main>", "<main><script>document.title = 'mine'</script>"),
        ("a changed script", "\"use strict\";", "\"use strict\"; void 0;"),
        ("a missing element", "id=\"slider\"", "id=\"slide\""),
        ("a wide page", "<main>", "<main><div style=\"width:3000px\">x</div>"),
        ("a row too few", "data-cell=\"0\"", "data-cell=\"999\""),
    ] {
        assert!(good.contains(from), "{name}");
        let bad = good.replacen(from, to, if from.starts_with("data") { usize::MAX } else { 1 });
        assert_ne!(bad, good, "{name}");
        folder.write("out/broken.html", bad);
        if let Some(shown) = show(&folder.path("out/broken.html"), 1280, &[]) {
            assert!(!shown.is_well(), "{name} went unnoticed: {shown:?}");
        }
    }
}

/// Without the policy the browser would ask, and the log shows it.
#[test]
fn a_request_that_nothing_stops_is_noticed() {
    let folder = report();
    let good = folder.text("out/report.html");
    let open = good.replacen("Content-Security-Policy", "No-Policy", 1);
    let bad = open.replacen("<main>", "<main><img src=\"https://cvr.invalid/x.png\">", 1);
    folder.write("out/asking.html", bad);
    if let Some(shown) = show(&folder.path("out/asking.html"), 1280, &[]) {
        assert!(shown.requests.iter().any(|host| host == "cvr.invalid"), "{shown:?}");
    }
}

#[test]
fn hostile_names_reach_the_page_as_text_alone() {
    let report = report().text("out/report.html");
    let lower = report.to_lowercase();
    assert_eq!(lower.matches("<script").count(), 2, "data and script");
    assert!(!lower.contains("<img src=x"));
    assert!(report.contains("\\u003c/script\\u003e\\u003cscript\\u003ealert(1)"), "as data");
    assert!(report.contains("&lt;&#x2f;script&gt;&lt;script&gt;alert(1)"), "as text");
}

#[test]
fn without_scripts_everything_is_there_and_nothing_offers_what_does_not_work() {
    let report = report().text("out/report.html");
    let (page, _) = report.split_once("<script type=\"application/json\"").unwrap();
    assert_eq!(page.matches("<svg class=\"chart\"").count(), CHARTS);
    assert_eq!(page.matches("<tr data-cell").count() + page.matches("<tr class=\"failed\"").count(), 96);
    for needs_script in ["<div id=\"explore\" hidden>", "<div id=\"chosen\" role=\"status\" hidden>"] {
        assert_eq!(page.matches(needs_script).count(), 1, "{needs_script}");
    }
    let policy = page.split_once("Content-Security-Policy\" content=\"").unwrap().1;
    assert!(policy.starts_with("default-src &#x27;none&#x27;;"), "{}", &policy[..80]);
}

#[test]
fn every_chart_lies_beside_the_report_and_none_of_an_earlier_one() {
    let folder = report();
    let page = folder.text("out/report.html");
    let mut files: Vec<String> =
        folder.names().iter().filter_map(|n| n.strip_prefix("out/").map(str::to_owned)).collect();
    files.retain(|name| name.starts_with("charts/"));
    assert_eq!(files.len(), 2 * CHARTS, "{files:?}");
    let mut plain = 0;
    for name in &files {
        assert!(page.contains(&format!("href=\"{}\"", name.replace('=', "%3D"))), "{name} is linked");
        let text = folder.text(&format!("out/{name}"));
        if name.ends_with(".svg") {
            assert!(text.starts_with("<svg xmlns=") && !text.contains("var(") && !text.contains("<script"));
        } else {
            let mut reader = csv::Reader::from_reader(text.as_bytes());
            let headers = reader.headers().unwrap().clone();
            let lines: Vec<csv::StringRecord> = reader.records().collect::<Result<_, _>>().unwrap();
            assert!(!lines.is_empty(), "{name}");
            // If a chart's marks are not cells, or have more than two values, its sheet has other columns.
            if headers.len() == 13 {
                plain += 1;
                assert_eq!(
                    [&headers[0], &headers[11], &headers[12]],
                    ["volume", "unbeaten", "series"],
                    "{name}"
                );
                assert!(lines.iter().any(|l| &l[11] == "true"), "{name}");
                assert!(lines.iter().all(|l| l[9].parse::<f64>().is_ok() && l[10].parse::<f64>().is_ok()));
            }
            let at = headers.iter().position(|head| head.ends_with("psnr_db"));
            assert!(at.is_none_or(|at| lines.iter().all(|l| l[at].parse::<f64>().is_ok())), "{name}");
        }
    }
    assert_eq!(
        plain,
        CHARTS - 2 - 2 * 2 - 2,
        "all but means over volumes, decoding on two devices, and errors"
    );
    assert!(!files.iter().any(|name| name.contains("noise")), "the names before they were changed");
}

/// Resuming and merging write the charts. A run of other cells removes only the charts that no longer exist.
#[test]
fn charts_follow_the_run() {
    let folder = Folder::new();
    folder.write("page.toml", CONFIG);
    let run = |more: &[&str]| {
        let always =
            ["run", "page.toml", "--device", "cpu", "--out", "out", "--set", "pipeline.filter=linear"];
        folder.cvr(&[&always[..], more].concat()).exits(0);
    };
    let charts = |of: &str| -> Vec<String> {
        let prefix = format!("{of}/charts/");
        folder.names().iter().filter_map(|n| n.strip_prefix(&prefix).map(str::to_owned)).collect()
    };
    run(&[]);
    let all = charts("out");
    assert!(all.contains(&"rings-front-slicing-frame-time.svg".to_owned()), "{all:?}");
    let frame_time = folder.read("out/charts/rings-front-slicing-frame-time.csv");
    std::fs::remove_file(folder.path("out/charts/rings-front-slicing-frame-time.csv")).unwrap();
    folder.write("out/charts/mine.txt", "mine");
    folder.write("out/charts/gone-voxel-psnr.svg", "a drawing of somebody's own");
    run(&["--resume"]);
    assert_eq!(folder.read("out/charts/rings-front-slicing-frame-time.csv"), frame_time);
    folder.cvr(&["merge", "out", "--out", "merged"]).exits(0);
    assert_eq!(charts("merged"), all);
    assert_eq!(charts("out").len(), all.len() + 2, "files of others stay");
    run(&["--set", "pipeline.renderer=raycasting", "--overwrite"]);
    let charts = charts("out");
    assert!(!charts.iter().any(|name| name.contains("slicing")), "{charts:?}");
    assert!(["mine.txt", "gone-voxel-psnr.svg"].iter().all(|name| charts.contains(&(*name).to_owned())));
}
