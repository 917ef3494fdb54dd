//! The extension of an output decides its format in every command, or the output is refused.

use cvr::input::{Generator, RawLayout, open, open_raw};
use cvr_core::volume::{BrickSource as _, DenseVolume, SampleType, StoredType};

use super::super::folder::Folder;
use super::super::volumes::{computed, spaced};

fn volume() -> DenseVolume {
    spaced(&computed(Generator::Turbulence, [7, 6, 5], SampleType::U16), [0.5, 1.0, 2.0])
}

fn folder() -> Folder {
    let folder = Folder::new();
    folder.volume("v.nrrd", &volume());
    folder.cvr(&["encode", "v.nrrd", "v.cvr", "--codec", "raw"]).exits(0);
    folder
}

#[test]
fn decode_writes_what_the_extension_says() {
    let folder = folder();
    folder.cvr(&["decode", "v.cvr", "a.nrrd"]).exits(0);
    assert_eq!(open(&folder.path("a.nrrd")).unwrap(), volume());
    let told = folder.cvr(&["decode", "v.cvr", "a.NPY"]).exits(0).stdout;
    assert!(folder.read("a.NPY").starts_with(b"\x93NUMPY"));
    assert!(told.contains("--spacing 0.5,1,2"), "{told}");
    assert_eq!(open(&folder.path("a.NPY")).unwrap(), spaced(&volume(), [1.0; 3]));
    let told = folder.cvr(&["decode", "v.cvr", "a.raw"]).exits(0).stdout;
    assert!(told.contains("read it with --dims 7x6x5 --dtype u16 --spacing 0.5,1,2"), "{told}");
    let layout = RawLayout::new(volume().layout().extent, StoredType::U16);
    assert_eq!(open_raw(&folder.path("a.raw"), &layout).unwrap(), spaced(&volume(), [1.0; 3]));
    assert_eq!(folder.read("a.raw").len(), 7 * 6 * 5 * 2);
}

#[test]
fn other_extensions_are_refused_with_what_can_be_written() {
    let folder = folder();
    let before = folder.names();
    let volumes = ".nrrd (NRRD), .npy (a NumPy array) or .raw (samples without a header)";
    for (arguments, words) in [
        (&["decode", "v.cvr", "x.tif"][..], volumes),
        (&["decode", "v.cvr", "x"], volumes),
        (&["decode", "v.cvr", "x.nrrd.gz"], volumes),
        (&["convert", "v.nrrd", "x.nii"], volumes),
        (&["convert", "v.nrrd", "x"], volumes),
        (&["render", "v.cvr", "x.jpg", "--device", "cpu"], ".png (a picture)"),
        (&["render", "v.cvr", "png", "--device", "cpu"], ".png (a picture)"),
        (&["encode", "v.nrrd", "x.nrrd", "--codec", "raw"], ".cvr (an encoded volume)"),
        (&["schema", "--out", "x.toml"], ".json (a JSON Schema)"),
        (&["schema", "--markdown", "--out", "x.json"], ".md (a page of Markdown)"),
    ] {
        let message = folder.cvr(arguments).refused();
        let name = arguments.iter().find(|a| a.starts_with('x') || **a == "png").unwrap();
        assert!(message.contains(words) && message.contains(name), "{arguments:?}: {message}");
    }
    assert_eq!(folder.names(), before);
}

/// The help has the same table.
#[test]
fn the_help_names_what_can_be_written() {
    let folder = Folder::new();
    for (command, words) in [
        ("decode", &[".nrrd (NRRD)", ".npy (a NumPy array)", ".raw (samples"][..]),
        ("convert", &[".nrrd (NRRD)", ".npy (a NumPy array)", ".raw (samples"]),
        ("render", &[".png (a picture)"]),
        ("encode", &[".cvr (an encoded volume)"]),
    ] {
        let help = folder.cvr(&[command, "--help"]).exits(0).stdout;
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        for word in words {
            assert!(help.contains(word), "{command}: no {word} in {help}");
        }
    }
}
