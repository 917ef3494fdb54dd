//! Messages are short, and concern the user's input.

use cvr::input::Generator;
use cvr_core::volume::SampleType;

use super::super::folder::Folder;
use super::super::volumes::computed;

/// A configuration of one line of five megabytes: the error quotes a part of it.
#[test]
fn errors_in_a_long_line_are_short() {
    let folder = Folder::new();
    let long = 5_000_000;
    for (what, text) in [
        ("brackets", format!("a = {}", "[".repeat(long))),
        ("tables", format!("a = {}", "{x=".repeat(long / 3))),
        (
            "a list of lists",
            format!("volume = [{}1{}]", "[".repeat(60), "]".repeat(60)) + &",[1]".repeat(long / 4),
        ),
        ("a list", format!("a = [{}]", "1,".repeat(long / 2))),
        ("a string", format!("x = \"{}\"", "y".repeat(long))),
        ("a value of a known key", format!("[experiment]\nname = [\"{}\"]", "y".repeat(long))),
        ("a wrong name", format!("[experiment]\nname = \"x\"\n[[codec]]\nid = \"{}\"", "y".repeat(long))),
        ("a key", format!("{} = 1", "k".repeat(long))),
        ("wrong tables", format!("volume = [{}]", "{name=1},".repeat(long / 9))),
        ("letters", "é".repeat(long / 2)),
    ] {
        folder.write("x.toml", text);
        let ran = folder.cvr(&["check-config", "x.toml"]).exits(2);
        assert!(
            ran.stderr.len() < 4096,
            "{what}: {} bytes: {}",
            ran.stderr.len(),
            &ran.stderr[..ran.stderr.floor_char_boundary(1000)]
        );
        assert!(ran.stderr.contains("x.toml:"), "{what}: {}", ran.stderr);
    }
}

#[test]
fn control_points_may_begin_with_a_minus() {
    let folder = Folder::new();
    folder.volume("v.nrrd", &computed(Generator::Turbulence, [6; 3], SampleType::I16));
    let draw = |points: &str| {
        let draw = [
            "render",
            "v.nrrd",
            "v.png",
            "--device",
            "cpu",
            "--size",
            "16x16",
            "--transfer-function",
            points,
        ];
        folder.cvr(&draw).exits(0);
        folder.read("v.png")
    };
    let picture = draw("-32768:#ffffff10,32767:#ff0000ff");
    assert_ne!(picture, draw("0:#ffffff10,32767:#ff0000ff"), "the first point counts");
    let message = folder
        .cvr(&["render", "v.nrrd", "w.png", "--device", "cpu", "--transfer-function", "--range"])
        .refused();
    assert!(message.contains("write control points"), "{message}");
}

/// Choosing a filter that a codec lacks is the user's error, not an error of the codec's source.
#[test]
fn a_filter_that_a_codec_lacks_is_refused_with_codecs_that_have_it() {
    let folder = Folder::new();
    folder.volume("v.nrrd", &computed(Generator::Turbulence, [6; 3], SampleType::U8));
    let filter = ["--filter", "optimised-linear"];
    for arguments in [&["shader", "--codec", "raw"][..], &["render", "v.nrrd", "v.png", "--device", "cpu"]] {
        let message = folder.cvr(&[arguments, &filter].concat()).refused();
        assert!(message.contains("codec raw has no fetch_cell"), "{message}");
        assert!(message.contains("s3dc") && message.contains("tvq"), "{message}");
        assert!(message.contains("use filter linear") && !message.contains(".wgsl"), "{message}");
    }
    folder.cvr(&[&["shader", "--codec", "s3dc"][..], &filter].concat()).exits(0);
    let message =
        folder.cvr(&[&["shader", "--codec", "s3dc", "--site", "host"][..], &filter].concat()).refused();
    assert!(message.contains("site inline") && !message.contains(".wgsl"), "{message}");
}
