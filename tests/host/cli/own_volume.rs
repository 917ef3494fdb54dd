//! The shipped comparison on a user's own volume.

use cvr::input::Generator;
use cvr_core::volume::SampleType;

use super::super::folder::Folder;
use super::super::volumes::computed;

fn compare() -> String {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/compare.toml");
    std::fs::read_to_string(path).unwrap()
}

const QUICK: [&str; 6] = ["--device", "cpu", "--set", "scene.size=[16, 16]", "--out", "out"];

#[test]
fn compare_runs_on_any_volume() {
    let folder = Folder::new();
    folder.write("compare.toml", compare());
    folder.volume("head.nrrd", &computed(Generator::SheppLogan, [11, 12, 13], SampleType::I16));
    let arguments = [&["run", "compare.toml", "--volume", "head.nrrd"][..], &QUICK].concat();
    let ran = folder.cvr(&arguments).exits(0);
    assert!(ran.stdout.contains("20 cells: 20 ok, 0 failed"), "{}", ran.stdout);
    let results = folder.json("out/results.json");
    for record in results["records"].as_array().unwrap() {
        assert_eq!((record["volume"].as_str(), record["scene"].as_str()), (Some("head"), Some("any")));
    }
    assert_eq!(results["provenance"]["volumes"][0]["source"], "head.nrrd");
    assert_eq!(results["provenance"]["volumes"][0]["dims"], serde_json::json!([11, 12, 13]));
}

#[test]
fn a_headerless_volume_can_be_brought_along() {
    let folder = Folder::new();
    folder.write("compare.toml", compare());
    let samples: Vec<u8> = (0..6 * 5 * 4_u16).flat_map(|i| (i * 37 % 500).to_be_bytes()).collect();
    folder.write("head.raw", [&[0xff; 3][..], &samples].concat());
    let layout = ["--dims", "6x5x4", "--dtype", "u16", "--byte-order", "big", "--skip-bytes", "3"];
    let one =
        ["--set", "pipeline.site=host", "--set", "pipeline.filter=linear", "--set", "codec.s3dc.block=4"];
    let arguments =
        [&["run", "compare.toml", "--volume", "head.raw", "--spacing", "1,1,2"][..], &QUICK, &layout, &one]
            .concat();
    folder.cvr(&arguments).exits(0);
    let volume = &folder.json("out/results.json")["provenance"]["volumes"][0];
    assert_eq!(volume["spacing"], serde_json::json!([1.0, 1.0, 2.0]));
    assert_eq!(volume["range"], serde_json::json!([0.0, 499.0]), "{volume}");
}

#[test]
fn without_a_scene_for_it_a_volume_is_refused() {
    let folder = Folder::new();
    folder
        .write("compare.toml", compare().replace("name = \"any\"", "name = \"any\"\nvolumes = [\"bonsai\"]"));
    folder.volume("head.nrrd", &computed(Generator::SheppLogan, [4; 3], SampleType::U8));
    let arguments = [&["run", "compare.toml", "--volume", "head.nrrd"][..], &QUICK].concat();
    let message = folder.cvr(&arguments).refused();
    assert!(message.contains("no scene applies to volume `head`"), "{message}");
    assert_eq!(folder.names(), ["compare.toml", "head.nrrd"]);
}
