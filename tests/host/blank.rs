//! Scenes that show nothing: their pictures are not judged, and all outputs give the reason.

use std::sync::OnceLock;

use cvr::experiment::files::results::Results;
use cvr::experiment::measured::frame_figures::FrameFigures;
use cvr::experiment::records::record::{Record, Status};

use super::folder::Folder;

const EDGE: usize = 12;

/// A volume of three frames: a block of 200 in a corner of the first and the last, and nothing above 50 elsewhere.
const CONFIG: &str = r##"
[experiment]
name = "blank"
seed = 7
[[volume]]
name = "corner"
file = "corner.raw"
dims = [12, 12, 12]
dtype = "u8"
frames = 3
[[codec]]
id = "raw"
[[codec]]
id = "s3dc"
block = 4
index_bits = 2
[pipeline]
renderer = "raycasting"
site = "host"
filter = ["nearest", "linear"]
skipping = [false, true]
"##;

/// Name, further keys, whether frame 0 shows something, and the remark about the scene.
const SCENES: [(&str, &str, bool, Option<&str>); 5] = [
    ("front", "transfer_function = [[100, '#00000000'], [150, '#ffffffff']]", true, None),
    (
        "frames",
        "frame = [0, 2]\ntransfer_function = [[100, '#00000000'], [150, '#ffffffff'], [250, '#00000000']]",
        true,
        Some(
            " in frame 1: its transfer function shows 100 to 250, and the values are 0 to 200, but opacities, clip box, camera and step leave nothing to see",
        ),
    ),
    (
        "beyond",
        "transfer_function = [[1000, '#00000000'], [2000, '#ffffffff']]",
        false,
        Some(": its transfer function shows what is above 1000, and the values are 0 to 200"),
    ),
    (
        "clipped",
        "clip_box = [[0.5, 0.5, 0.5], [1, 1, 1]]\ntransfer_function = [[100, '#00000000'], [150, '#ffffffff']]",
        false,
        Some(
            ": its transfer function shows what is above 100, and the values are 0 to 200, but opacities, clip box, camera and step leave nothing to see",
        ),
    ),
    (
        "zoomed",
        "camera = { zoom = 40.0 }\ntransfer_function = [[100, '#00000000'], [150, '#ffffffff']]",
        false,
        Some(
            ": its transfer function shows what is above 100, and the values are 0 to 200, but opacities, clip box, camera and step leave nothing to see",
        ),
    ),
];

fn folder() -> Folder {
    let folder = Folder::new();
    let value = |frame: usize, i: usize| {
        let block = [i % EDGE, i / EDGE % EDGE, i / EDGE / EDGE].iter().all(|n| *n < 4);
        if block && frame != 1 { 200 } else { (i * 7 % 51) as u8 }
    };
    let samples: Vec<u8> = (0..3).flat_map(|frame| (0..EDGE.pow(3)).map(move |i| value(frame, i))).collect();
    folder.write("corner.raw", samples);
    let scenes =
        SCENES.map(|(name, keys, ..)| format!("[[scene]]\nname = \"{name}\"\nsize = [40, 30]\n{keys}\n"));
    folder.write("blank.toml", format!("{CONFIG}{}", scenes.concat()));
    folder
}

/// The run, and its standard error.
fn run() -> &'static (Folder, Vec<Record>, String) {
    static RUN: OnceLock<(Folder, Vec<Record>, String)> = OnceLock::new();
    RUN.get_or_init(|| {
        let folder = folder();
        let ran = folder.cvr(&["run", "blank.toml", "--device", "cpu", "--out", "out"]).exits(0);
        assert!(ran.stdout.contains("40 cells: 40 ok, 0 failed"), "{}", ran.stdout);
        let records = Results::read(&folder.path("out/results.json")).unwrap().records;
        (folder, records, ran.stderr)
    })
}

/// All columns of pictures.
fn pictures(record: &Record) -> Vec<(String, bool)> {
    let json = serde_json::to_value(Record { image: None, ..record.clone() }).unwrap();
    let fields = json.as_object().unwrap().iter();
    let own = fields.filter(|(name, _)| {
        (name.starts_with("image_") || name.starts_with("codec_image_")) && !name.ends_with("_db")
    });
    let ssim = own.map(|(name, value)| (name.clone(), !value.is_null())).collect::<Vec<_>>();
    // JSON knows no infinity.
    let psnr = [
        ("image_psnr_db", record.image_psnr_db),
        ("image_psnr_whole_db", record.image_psnr_whole_db),
        ("codec_image_psnr_db", record.codec_image_psnr_db),
    ];
    ssim.into_iter().chain(psnr.map(|(name, value)| (name.to_owned(), value.is_some()))).collect()
}

#[test]
fn pictures_of_nothing_have_no_figures_and_all_else_has() {
    let (_, records, _) = run();
    for record in records {
        let (.., shows, said) = SCENES.iter().find(|scene| scene.0 == record.scene).unwrap();
        let told = pictures(record);
        assert_eq!(told.len(), 12, "{told:?}");
        assert!(told.iter().all(|(_, there)| there == shows), "{} {}: {told:?}", record.scene, record.codec);
        assert_eq!(record.visible_pixels.unwrap() > 0, *shows, "{}", record.scene);
        assert_eq!((record.status, record.psnr_db.is_some()), (Status::Ok, true));
        let notes = record.notes.clone().unwrap_or_default();
        match said {
            Some(said) => assert!(notes.contains(&format!("shows nothing{said}")), "{notes}"),
            None => assert!(!notes.contains("shows nothing"), "{notes}"),
        }
    }
}

#[test]
fn a_range_of_frames_is_judged_by_those_that_show_something() {
    let (folder, records, _) = run();
    for record in records.iter().filter(|r| r.scene == "frames") {
        let path = folder.path("out").join(record.frame_figures.as_ref().unwrap());
        let figures: Vec<FrameFigures> =
            csv::Reader::from_path(path).unwrap().deserialize().collect::<Result<_, _>>().unwrap();
        let shown = figures.iter().map(|f| f.visible_pixels.unwrap());
        assert_eq!(shown.clone().map(|n| n > 0).collect::<Vec<_>>(), [true, false, true]);
        assert_eq!(record.visible_pixels, Some(shown.sum()));
        for frame in &figures {
            let told =
                [frame.image_psnr_db, frame.image_ssim, frame.codec_image_ssim, frame.image_ssim_whole];
            assert!(told.iter().all(|v| v.is_some() == (frame.frame != 1)), "{frame:?}");
        }
        if record.codec == "s3dc" && record.filter == "linear" {
            // Frame 1 shows nothing in either picture. Errors and visible pixels are those of the two other frames.
            let squared = |f: &FrameFigures| {
                f.image_psnr_db.map_or(0.0, |db| f.visible_pixels.unwrap() as f64 * 10_f64.powf(-db / 10.0))
            };
            let all = figures.iter().map(squared).sum::<f64>() / record.visible_pixels.unwrap() as f64;
            assert!((record.image_psnr_db.unwrap() + 10.0 * all.log10()).abs() < 1e-6);
        }
    }
}

#[test]
fn terminal_and_report_warn_and_nothing_is_ranked() {
    let (folder, _, stderr) = run();
    let page = folder.text("out/report.html");
    let expected = SCENES.iter().filter(|scene| scene.3.is_some()).count();
    assert_eq!(stderr.matches("warning: ").count(), expected, "each once: {stderr}");
    for (name, _, shows, said) in SCENES {
        let start = format!("scene `{name}` shows nothing of volume `corner`");
        if let Some(said) = said {
            let warning = format!("arning: {start}{said}; its pictures are not judged");
            assert!(stderr.contains(&warning), "{warning}\nin {stderr}");
            assert!(page.contains(&warning), "no {warning}");
        } else {
            assert!(!stderr.contains(&start) && !page.contains(&start), "{stderr}");
        }
        // Charts of pictures: frame times over them, rate and SSIM.
        for kind in ["frame-time", "picture-ssim"] {
            let chart = format!("out/charts/corner-{name}-raycasting-{kind}.csv");
            assert_eq!(folder.path(&chart).exists(), shows, "{chart}");
        }
    }
    // Taken-over cells give warnings too.
    let again = folder.cvr(&["run", "blank.toml", "--device", "cpu", "--out", "out", "--resume"]).exits(0);
    assert!(again.stdout.contains("40 of 40 cells taken over"), "{}", again.stdout);
    assert_eq!(again.stderr.matches("warning: ").count(), expected, "{}", again.stderr);
}

#[test]
fn a_configuration_is_held_against_its_data() {
    let folder = folder();
    let checked = folder.cvr(&["check-config", "blank.toml"]).exits(0);
    assert_eq!(checked.stdout, "blank.toml: 40 cells\n");
    let lines: Vec<&str> = checked.stderr.lines().collect();
    let warning =
        |name: &str, said: &str| format!("warning: scene `{name}` shows nothing of volume `corner`{said}");
    let [_, frames, _, clipped, zoomed] =
        SCENES.map(|(name, _, _, said)| warning(name, said.unwrap_or_default()));
    let by_type =
        ": its transfer function shows what is above 1000, and the values are 0 to 255 at most (u8)";
    assert_eq!(lines[0], warning("beyond", by_type));
    for (line, expected) in lines[1..].iter().zip([frames, clipped, zoomed]) {
        assert_eq!(**line, format!("{expected} (seen in 40 × 30 pixels)"));
    }
    assert_eq!(lines.len(), 4);
    // Within the type's range, but outside the data's.
    let set = "scene.front.transfer_function=[[210, '#00000000'], [220, '#ffffffff']]";
    let beside = folder.cvr(&["check-config", "blank.toml", "--set", set]).exits(0).stderr;
    let said = ": its transfer function shows what is above 210, and the values are 0 to 200";
    assert!(beside.contains(&format!("{}\n", warning("front", said))), "{beside}");

    std::fs::remove_file(folder.path("corner.raw")).unwrap();
    let missing = folder.cvr(&["check-config", "blank.toml"]).exits(0);
    assert_eq!(missing.stdout, "blank.toml: 40 cells\n");
    assert!(missing.stderr.starts_with("not held against data: volume `corner`: "), "{}", missing.stderr);
}

#[test]
fn a_picture_of_nothing_is_warned_of() {
    let folder = folder();
    let render = |function: &str, more: &[&str]| {
        let always =
            ["render", "corner.raw", "a.png", "--dims", "12x12x12", "--dtype", "u8", "--frames", "3"];
        let drawn = ["--device", "cpu", "--size", "40x30", "--transfer-function", function];
        folder.cvr(&[&always[..], &drawn, more].concat()).exits(0).stderr
    };
    let said = |stderr: &str| {
        stderr.lines().filter(|l| l.starts_with("warning: ")).map(str::to_owned).collect::<Vec<_>>()
    };
    assert!(said(&render("100:#00000000,150:#ffffffff", &[])).is_empty());
    let beyond = said(&render("1000:#00000000,2000:#ffffffff", &[]));
    let why = "its transfer function shows what is above 1000, and the values are 0 to 200";
    assert_eq!(beyond, [format!("warning: a.png shows nothing: {why}")]);
    let clipped = said(&render("100:#00000000,150:#ffffffff", &["--clip-box", "0.5,0.5,0.5:1,1,1"]));
    assert_eq!(clipped.len(), 1);
    assert!(
        clipped[0].ends_with("but opacities, clip box, camera and step leave nothing to see"),
        "{clipped:?}"
    );
}
