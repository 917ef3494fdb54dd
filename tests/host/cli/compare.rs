//! `cvr compare`: two runs of one experiment, and parts that cannot be compared.

use cvr::experiment::files::results::Results;
use cvr::experiment::files::write_results::to_json;

use super::super::folder::Folder;

const CONFIG: &str = r##"
[experiment]
name = "compare"
seed = 7
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
renderer = "raycasting"
site = ["inline", "host"]
filter = "linear"
[[scene]]
name = "front"
size = [16, 16]
transfer_function = [[60, "#00000000"], [255, "#ffffffff"]]
"##;

fn runs() -> Folder {
    let folder = Folder::new();
    folder.write("x.toml", CONFIG);
    let run = |more: &[&str]| {
        folder.cvr(&[&["run", "x.toml", "--device", "cpu"], more].concat()).exits(0);
    };
    run(&["--out", "a"]);
    run(&["--out", "b", "--set", "codec.s3dc.index_bits=[2, 8]"]);
    folder
}

#[test]
fn what_was_run_twice_is_matched_and_what_was_not_is_listed() {
    let folder = runs();
    let told =
        folder.cvr(&["compare", "a", "b/results.json", "--csv", "change.csv", "--html", "change.html"]);
    let told = told.exits(0).stdout;
    assert!(told.contains("B against A: 4 cells in both"), "{told}");
    for only in
        ["2 cells only in A:\n  rings s3dc index_bits=4", "2 cells only in B:\n  rings s3dc index_bits=8"]
    {
        assert!(told.contains(only), "{only}:\n{told}");
    }
    // The same software on the same machine: everything except times is equal.
    for same in ["bits_per_voxel", "psnr_db", "image_psnr_db"] {
        assert!(told.contains(&format!("{same}: A and B tie in all 4 cells")), "{same}:\n{told}");
    }
    assert!(told.contains(&format!("cvr {}", env!("CARGO_PKG_VERSION"))), "{told}");
    let mut reader = csv::Reader::from_reader(std::io::Cursor::new(folder.read("change.csv")));
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.iter().filter(|r| &r[11] == "psnr_db" && &r[16] == "tie").count(), 4);

    let page = folder.text("change.html");
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"), "{page}");
    for told in ["B against A", "4 cells in both.", "2 cells only in A", "rings s3dc index_bits=8, inline"] {
        assert!(page.contains(told), "{told}: {page}");
    }

    // A run against itself ties everywhere. A machine of half the speed, and a larger file, do not.
    let itself = folder.cvr(&["compare", "a", "a"]).exits(0).stdout;
    assert!(
        !itself.contains(" times A") && itself.contains("frame_ms: A and B tie in all 6 cells"),
        "{itself}"
    );
    let mut results = Results::read(&folder.path("a/results.json")).unwrap();
    for record in &mut results.records {
        record.frame_ms = record.frame_ms.map(|ms| 1000.0 * ms);
        record.bits_per_voxel = record.bits_per_voxel.map(|bits| 1.25 * bits);
    }
    std::fs::write(folder.path("slow.json"), to_json(&results.provenance, &results.records, &[]).unwrap())
        .unwrap();
    let slow = folder.cvr(&["compare", "a", "slow.json", "a"]).exits(0).stdout;
    assert!(
        slow.contains("frame_ms: B is 1000 ×÷ 1.00 times A over 6 cells: 0 less, 0 tie, 6 more"),
        "{slow}"
    );
    assert!(slow.contains("bits_per_voxel: B is 1.250 ×÷ 1.00 times A over 6 cells"), "{slow}");
    assert!(slow.contains("frame_ms: A and C tie in all 6 cells"), "{slow}");
}

#[test]
fn what_cannot_be_compared_is_bad_input_that_names_the_file() {
    let folder = runs();
    folder.write("cut.json", &folder.read("a/results.json")[..900]);
    folder.write("other.toml", CONFIG.replace("dims = [12", "dims = [13"));
    folder.cvr(&["run", "other.toml", "--device", "cpu", "--out", "other"]).exits(0);
    for (words, says) in [
        (&["compare", "a"][..], "a/results.json: is one run on one device"),
        (&["compare", "a", "missing.json"], "missing.json"),
        (&["compare", "a", "cut.json"], "cut.json: EOF"),
        (&["compare", "a", "x.toml"], "x.toml: expected"),
        (&["compare", "a", "other"], "a/results.json: has no cell in common with other/results.json"),
        (&["compare", "a", "b", "--noise=-1"], "--noise -1"),
        (&["compare", "a", "b", "--noise=NaN"], "--noise NaN"),
        (&["compare", "a", "b", "--csv", "b/results.json"], "b/results.json: is compared itself"),
        (&["compare", "a", "b", "--html", "b/results.json"], "b/results.json: is compared itself"),
        (&["compare", "a", "b", "--html", "x.csv", "--csv", "x.csv"], "--csv and --html name one file"),
        (&["compare", "a", "b", "--csv", "no/such/folder.csv"], "no/such/folder.csv"),
    ] {
        let ran = folder.cvr(words).exits(2);
        assert!(ran.stdout.is_empty() && ran.stderr.contains(says), "{words:?}: {}", ran.stderr);
    }
    assert!(
        !folder.names().iter().any(|name| name.ends_with(".csv") && !name.contains('/')),
        "nothing half-written"
    );
}
