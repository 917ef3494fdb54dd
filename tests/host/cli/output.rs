//! Outputs: files that cannot be written, and a reader that has gone.

use std::process::{Command, Stdio};

use cvr::input::Generator;
use cvr_core::volume::SampleType;

use super::super::folder::Folder;
use super::super::volumes::computed;

fn folder() -> Folder {
    let folder = Folder::new();
    folder.volume("v.nrrd", &computed(Generator::Turbulence, [6; 3], SampleType::U8));
    folder.cvr(&["encode", "v.nrrd", "v.cvr", "--codec", "raw"]).exits(0);
    folder
}

#[test]
fn the_input_is_never_overwritten() {
    let folder = folder();
    let before = [folder.read("v.nrrd"), folder.read("v.cvr")];
    for arguments in [
        &["encode", "v.nrrd", "v.nrrd", "--codec", "raw"][..],
        &["encode", "v.nrrd", "./v.nrrd", "--codec", "raw"],
        &["decode", "v.cvr", "v.cvr"],
        &["render", "v.nrrd", "v.nrrd", "--device", "cpu"],
    ] {
        let message = folder.cvr(arguments).refused();
        assert!(message.contains("is the input"), "{message}");
        assert_eq!([folder.read("v.nrrd"), folder.read("v.cvr")], before, "{arguments:?}");
    }
    folder.cvr(&["encode", "v.nrrd", "v.cvr", "--codec", "s3dc"]).exits(0);
    assert_ne!(folder.read("v.cvr"), before[1], "an older output is replaced");
}

#[test]
fn an_output_that_cannot_be_written_is_named() {
    let folder = folder();
    for name in ["taken.cvr", "taken.nrrd", "taken.png"] {
        std::fs::create_dir(folder.path(name)).unwrap();
    }
    folder.write("x.toml", super::super::configs::COMPARE);
    for arguments in [
        &["encode", "v.nrrd", "taken.cvr", "--codec", "raw"][..],
        &["decode", "v.cvr", "taken.nrrd"],
        &["render", "v.cvr", "taken.png", "--device", "cpu", "--size", "4x4"],
    ] {
        let message = folder.cvr(arguments).refused();
        assert!(message.contains("taken"), "{arguments:?}: {message}");
    }
    let run = ["run", "x.toml", "--volume", "v.nrrd", "--device", "cpu", "--out", "v.cvr"];
    let message = folder.cvr(&run).refused();
    assert!(message.contains("v.cvr"), "{message}");
    assert_eq!(folder.names(), ["taken.cvr", "taken.nrrd", "taken.png", "v.cvr", "v.nrrd", "x.toml"]);
}

#[test]
fn a_reader_that_has_gone_is_no_error() {
    let folder = folder();
    for arguments in
        [&["codecs"][..], &["renderers"], &["presets"], &["shader"], &["info", "v.cvr"], &["info", "v.nrrd"]]
    {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = Command::new(env!("CARGO_BIN_EXE_cvr"))
            .args(arguments)
            .current_dir(folder.root())
            .stdout(writer)
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), &*said), (Some(0), ""), "{arguments:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_cvr")).arg("codecs").stdout(full).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8(output.stderr).unwrap().starts_with("error: standard output: "));
}

#[test]
fn what_cannot_be_drawn_is_refused_on_the_mirror_too() {
    let folder = folder();
    let draw = |more: &[&str]| {
        let draw = ["render", "v.cvr", "v.png", "--device", "cpu", "--size", "8x8"];
        folder.cvr(&[&draw[..], more].concat())
    };
    let message = draw(&["--filter", "optimised-linear"]).refused();
    assert!(message.contains("codec raw has no fetch_cell"), "{message}");
    for wrong in [
        &["--azimuth", "nan"][..],
        &["--azimuth", "inf"],
        &["--elevation", "91"],
        &["--zoom", "0"],
        &["--step-voxels", "-1"],
        &["--transfer-function", "nan:#ffffffff,1:#ffffffff"],
        &["--transfer-function", "1:#ffffffff"],
        &["--transfer-function", "tisue"],
        &["--transfer-function", "0:#00000000,2:#ffffffff", "--range"],
        &["--early-termination", "0"],
        &["--early-termination", "1.5"],
        &["--early-termination", "nan"],
        &["--renderer", "raytracing"],
        &["--renderer", "slicing,geometry=cones"],
    ] {
        draw(wrong).refused();
    }
    folder.cvr(&["encode", "v.nrrd", "v.cvr", "--codec", "s3dc"]).exits(0);
    draw(&["--filter", "optimised-linear", "--site", "host"]).refused();
    draw(&["--filter", "optimised-linear", "--site", "deferred"]).refused();
    let rays = draw(&["--site", "ring"]).refused();
    assert!(rays.contains("renderers that do: slicing,geometry=axis"), "{rays}");
    draw(&["--site", "ring", "--renderer", "slicing,geometry=shells"]).refused();
    assert!(!folder.path("v.png").exists());
    draw(&["--filter", "optimised-linear"]).exits(0);
}

#[test]
fn each_option_of_a_scene_changes_the_picture() {
    let folder = folder();
    let draw = |more: &[&str]| {
        let draw = ["render", "v.cvr", "v.png", "--device", "cpu", "--size", "24x24"];
        folder.cvr(&[&draw[..], more].concat()).exits(0);
        folder.read("v.png")
    };
    let plain = draw(&[]);
    for same in [
        &["--clip-box", "0,0,0:1,1,1"][..],
        &["--background", "#000000"],
        &["--early-termination", "0.999"],
        &["--renderer", "raycasting"],
    ] {
        assert!(draw(same) == plain, "{same:?}");
    }
    let mut seen = vec![plain];
    for other in [
        &["--shading"][..],
        &["--light", "-1,-2,0.5"],
        &["--clip-box", "0,0,0:1,1,0.5"],
        &["--clip-box", "0.5,0,0:1,1,0.5"],
        &["--background", "#203040"],
        &["--early-termination", "0.2"],
        &["--transfer-function", "heat"],
        &["--transfer-function", "heat", "--shading"],
        &["--transfer-function", "0:#00000000,1:#ff0000ff", "--range"],
        &["--renderer", "slicing,geometry=axis", "--step-voxels", "2"],
    ] {
        let picture = draw(other);
        assert!(!seen.contains(&picture), "{other:?} changes nothing");
        seen.push(picture);
    }
    // A light that follows the camera is the default light of --shading.
    assert!(draw(&["--light", "camera"]) == draw(&["--shading"]));
    assert!(draw(&["--light", "-1,-2,0.5"]) == draw(&["--light", "-1,-2,0.5", "--shading"]));
}
