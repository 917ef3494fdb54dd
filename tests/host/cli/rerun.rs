//! A second run into the folder of the first.

use super::super::folder::Folder;

const CONFIG: &str = r##"
[experiment]
name = "twice"
[[volume]]
name = "v"
generate = "shepp-logan"
dims = [8, 8, 8]
[[codec]]
id = "raw"
[pipeline]
renderer = "raycasting"
site = ["inline", "host"]
filter = ["nearest", "linear"]
[[scene]]
name = "s"
size = [8, 8]
transfer_function = [[0, "#00000000"], [255, "#ffffffff"]]
"##;

fn count(folder: &Folder, part: &str) -> usize {
    folder.names().iter().filter(|n| n.starts_with(part)).count()
}

#[test]
fn nothing_of_the_first_run_passes_for_the_second() {
    let folder = Folder::new();
    folder.write("x.toml", CONFIG);
    folder.cvr(&["run", "x.toml", "--device", "cpu"]).exits(0);
    // 4 cells with picture and error picture, and the reference.
    assert_eq!((count(&folder, "results/twice/cells/"), count(&folder, "results/twice/images/")), (4, 9));
    let other = ["run", "x.toml", "--device", "cpu", "--set", "pipeline.site=host"];
    let before = contents(&folder);
    let message = folder.cvr(&other).refused();
    assert!(
        message.contains("4 cell(s) of experiment `twice`") && message.contains("it ran with --set"),
        "{message}"
    );
    assert!(["--resume", "--overwrite", "--out"].iter().all(|way| message.contains(way)), "{message}");
    assert_eq!(contents(&folder), before);
    folder.cvr(&[&other[..], &["--overwrite"]].concat()).exits(0);
    assert_eq!((count(&folder, "results/twice/cells/"), count(&folder, "results/twice/images/")), (2, 5));
    let results = folder.json("results/twice/results.json");
    assert_eq!(results["records"].as_array().unwrap().len(), 2);
    assert_eq!(folder.text("results/twice/results.csv").lines().count(), 3);
}

#[test]
fn bad_input_leaves_the_first_run_as_it_was() {
    let folder = Folder::new();
    folder.write("x.toml", CONFIG);
    folder.cvr(&["run", "x.toml", "--device", "cpu"]).exits(0);
    let before = contents(&folder);
    for wrong in [
        &["--set", "pipeline.site=moon"][..],
        &["--volume", "none.nrrd"],
        &["--device", "no such adapter"],
        &["--set", "volume.v.dims=[100000, 100000, 100]"],
    ] {
        let device: &[&str] = if wrong[0] == "--device" { &[] } else { &["--device", "cpu"] };
        let ran = folder.cvr(&[&["run", "x.toml"][..], device, wrong].concat());
        assert_eq!(ran.code, Some(2), "{wrong:?}: {ran:?}");
        assert_eq!(contents(&folder), before, "{wrong:?}");
    }
}

/// Every file with its bytes.
fn contents(folder: &Folder) -> Vec<(String, Option<Vec<u8>>)> {
    let bytes = |name: &String| std::fs::read(folder.path(name)).ok();
    folder.names().into_iter().map(|name| (name.clone(), bytes(&name))).collect()
}
