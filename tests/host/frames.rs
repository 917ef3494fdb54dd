//! Sequences: a frame or a range of frames is drawn, and figures of single frames accompany the records.

use std::sync::OnceLock;

use cvr::experiment::files::results::Results;
use cvr::experiment::measured::frame_figures::FrameFigures;
use cvr::experiment::records::record::Record;

use super::folder::Folder;

/// A moving volume of 5 frames. One scene draws frames 1 to 3, and three others draw one of them each.
const CONFIG: &str = r##"
[experiment]
name = "moving"
seed = 7
[[volume]]
name = "blobs"
generate = "advected-blobs"
dims = [20, 17, 13]
frames = 5
[[codec]]
id = "vq"
codewords = 16
tables = ["shared", "per-frame"]
[pipeline]
renderer = "raycasting"
site = ["inline", "deferred", "host"]
filter = "linear"
skipping = [false, true]
"##;

fn config() -> String {
    let scene = |name: &str, frame: &str| {
        let function = "[[0, \"#00000000\"], [90, \"#d0804010\"], [255, \"#ffffffff\"]]";
        format!(
            "[[scene]]\nname = \"{name}\"\nframe = {frame}\nsize = [40, 30]\ntransfer_function = {function}\n"
        )
    };
    [("range", "[1, 3]"), ("one", "1"), ("two", "2"), ("three", "3")]
        .iter()
        .fold(CONFIG.to_owned(), |text, (name, frame)| text + &scene(name, frame))
}

fn run() -> &'static (Folder, Vec<Record>) {
    static RUN: OnceLock<(Folder, Vec<Record>)> = OnceLock::new();
    RUN.get_or_init(|| {
        let folder = Folder::new();
        folder.write("moving.toml", config());
        let ran = folder.cvr(&["run", "moving.toml", "--device", "cpu", "--out", "out"]).exits(0);
        assert!(ran.stdout.contains("48 cells: 48 ok"), "{}", ran.stdout);
        let records = Results::read(&folder.path("out/results.json")).unwrap().records;
        (folder, records)
    })
}

fn figures(folder: &Folder, record: &Record) -> Vec<FrameFigures> {
    let path = folder.path("out").join(record.frame_figures.as_ref().unwrap());
    csv::Reader::from_path(path).unwrap().deserialize().collect::<Result<_, _>>().unwrap()
}

/// The record of another scene that differs only in the frames.
fn of_scene<'a>(records: &'a [Record], like: &Record, scene: &str) -> &'a Record {
    let same = |r: &&Record| {
        r.scene == scene && (&r.settings, &r.site, r.skipping) == (&like.settings, &like.site, like.skipping)
    };
    records.iter().find(same).unwrap()
}

/// The figures of a picture, without times.
fn picture(r: &Record) -> [Option<f64>; 6] {
    [
        r.image_psnr_db,
        r.image_ssim,
        r.image_psnr_whole_db,
        r.image_ssim_whole,
        r.codec_image_psnr_db,
        r.codec_image_ssim,
    ]
}

fn picture_of(f: &FrameFigures) -> [Option<f64>; 6] {
    [
        f.image_psnr_db,
        f.image_ssim,
        f.image_psnr_whole_db,
        f.image_ssim_whole,
        f.codec_image_psnr_db,
        f.codec_image_ssim,
    ]
}

#[test]
fn a_range_holds_what_its_frames_measure_alone() {
    let (folder, records) = run();
    let mut ranges = 0;
    for range in records.iter().filter(|r| r.scene == "range") {
        ranges += 1;
        assert_eq!((range.frames, range.first_frame, range.last_frame), (5, 1, 3));
        let figures = figures(folder, range);
        assert_eq!(figures.iter().map(|f| f.frame).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
        assert_eq!(picture_of(&figures[0]), [None; 6], "frame 0 is not drawn");
        assert_eq!(picture_of(&figures[4]), [None; 6], "nor frame 4");
        let singles = ["one", "two", "three"].map(|scene| of_scene(records, range, scene));
        for (single, figures) in singles.iter().zip(&figures[1..4]) {
            assert_eq!((single.first_frame, single.last_frame), (figures.frame, figures.frame));
            assert_eq!(picture(single), picture_of(figures), "{}", range.settings);
            assert!(figures.frame_ms.is_some() && figures.relative_frame_time.is_some());
        }
        let psnrs = singles.map(|r| r.image_psnr_db.unwrap());
        let (least, most) =
            (psnrs.iter().copied().fold(f64::MAX, f64::min), psnrs.iter().copied().fold(0.0, f64::max));
        let pooled = range.image_psnr_db.unwrap();
        assert!(least < pooled && pooled < most, "{pooled} within {psnrs:?}");
        // The frames' errors are the volume's.
        let mse = |psnr: f64| 10_f64.powf(-psnr / 10.0);
        let mean = figures.iter().map(|f| mse(f.psnr_db)).sum::<f64>() / 5.0;
        assert!((mean / mse(range.psnr_db.unwrap()) - 1.0).abs() < 1e-9);
        let worst = figures.iter().map(|f| f.max_abs_error).fold(0.0, f64::max);
        assert_eq!(range.max_abs_error, Some(worst));
    }
    assert_eq!(ranges, 12);
}

#[test]
fn every_frame_of_a_range_has_the_picture_that_it_has_alone() {
    let (folder, records) = run();
    for range in records.iter().filter(|r| r.scene == "range") {
        for (suffix, scene) in [("", "one"), (".f0002", "two"), (".f0003", "three")] {
            let single = of_scene(records, range, scene);
            for (first, alone) in [(&range.image, &single.image), (&range.error_image, &single.error_image)] {
                let (first, alone) = (first.as_ref().unwrap(), alone.as_ref().unwrap());
                let ending = if first.ends_with(".error.png") { ".error.png" } else { ".png" };
                let name = format!("out/{}{suffix}{ending}", first.strip_suffix(ending).unwrap());
                assert!(folder.read(&name) == folder.read(&format!("out/{alone}")), "{name}");
            }
        }
    }
    let picture = |(scene, later)| {
        folder.read(&format!("out/images/reference-blobs-{scene}-raycasting-inline-linear{later}.png"))
    };
    assert!(picture(("one", "")) != picture(("two", "")), "the blobs move");
    assert!(
        picture(("range", "")) == picture(("one", ""))
            && picture(("range", ".f0002")) == picture(("two", ""))
    );
}

/// The picture of a later frame, by the name of the first.
fn later(path: &str) -> String {
    path.replace("-raycasting-inline-linear.png", "-raycasting-inline-linear.f0002.png")
}

#[test]
fn what_belongs_to_later_frames_is_kept_and_passed_on() {
    let folder = Folder::new();
    let text = config();
    let cut = text.find("[[scene]]\nname = \"one\"").unwrap();
    folder.write("moving.toml", text[..cut].replace("[\"shared\", \"per-frame\"]", "\"shared\""));
    let command = ["run", "moving.toml", "--device", "cpu", "--out", "out", "--resume"];
    folder.cvr(&command).exits(0);
    let taken = |n| format!("{n} of 6 cells taken over");
    assert!(folder.cvr(&command).exits(0).stdout.contains(&taken(6)));
    let records = Results::read(&folder.path("out/results.json")).unwrap().records;
    let plain = records.iter().find(|r| r.site == "inline" && !r.skipping).unwrap();
    let image = format!("out/{}", later(plain.image.as_ref().unwrap()));
    let figures = format!("out/{}", plain.frame_figures.as_ref().unwrap());
    let histogram = format!("out/{}", plain.error_histogram.as_ref().unwrap());
    for name in [&image, &figures, &histogram] {
        let bytes = folder.read(name);
        folder.write(name, &bytes[..bytes.len() - 1]);
        assert!(folder.cvr(&command).exits(0).stdout.contains(&taken(5)), "{name} was cut short");
    }
    let reference =
        folder.names().into_iter().find(|n| n.contains("reference") && n.contains("f0003")).unwrap();
    let bytes = folder.read(&reference);
    std::fs::remove_file(folder.path(&reference)).unwrap();
    assert!(folder.cvr(&command).exits(0).stdout.contains(&taken(6)));
    assert!(folder.read(&reference) == bytes, "drawn again");

    folder.cvr(&["merge", "out", "--out", "merged"]).exits(0);
    let of = |prefix: &str| {
        let names = folder.names().into_iter();
        let below = names.filter_map(|n| n.strip_prefix(prefix).map(str::to_owned));
        below
            .filter(|n| ["images/", "frames/", "errors/"].iter().any(|f| n.starts_with(f)))
            .collect::<Vec<_>>()
    };
    assert_eq!(of("merged/"), of("out/"));
    assert_eq!(folder.read(&histogram.replace("out/", "merged/")), folder.read(&histogram));
    folder.write(&image, b"changed");
    let refused = folder.cvr(&["merge", "out", "--out", "again"]).exits(2).stderr;
    assert!(refused.contains("f0002.png has changed"), "{refused}");
}

#[test]
fn a_frame_that_a_volume_lacks_is_refused_with_the_way_out() {
    let folder = Folder::new();
    folder.write("moving.toml", config());
    for command in ["run", "explain"] {
        let set = "scene.range.frame=[3, 5]";
        let ran = folder.cvr(&[command, "moving.toml", "--device", "cpu", "--set", set]).exits(2);
        let expected = "scene `range` draws frames 3 to 5, and volume `blobs` has 5 frames, counted from 0";
        assert!(ran.stderr.contains(expected), "{}", ran.stderr);
    }
    assert!(!folder.names().iter().any(|n| n.starts_with("results")), "bad input leaves nothing behind");
}

#[test]
fn one_frame_is_rendered_on_the_command_line() {
    let folder = Folder::new();
    let frame = |f: u8| (0..8_u8).map(move |i| if i == f { 255 } else { 0 });
    folder.write("moving.raw", (0..2).flat_map(frame).collect::<Vec<u8>>());
    let raw = ["--dims", "2x2x2", "--dtype", "u8", "--frames", "2"];
    let draw = |frame: &str, out: &str| {
        let args = ["render", "moving.raw", out, "--size", "24x24", "--device", "cpu", "--frame", frame];
        folder.cvr(&[&args[..], &raw[..]].concat())
    };
    draw("0", "a.png").exits(0);
    draw("1", "b.png").exits(0);
    assert!(folder.read("a.png") != folder.read("b.png"));
    let refused = draw("2", "c.png").refused();
    assert!(refused.contains("--frame 2: moving.raw has 2 frames, counted from 0"), "{refused}");
}
