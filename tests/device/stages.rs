//! Levels of a codec with stages on the device: each has its own shader, texture and macrocells.

use cvr::experiment::records::record::Status;
use cvr::registry::Names;
use cvr::site::target::Target;
use cvr_engine::testing::test_device;

use super::runs::{CONFIG, run};

#[test]
fn every_site_draws_the_level_that_is_asked_for() {
    let Some(device) = test_device("stages::sites") else { return };
    let config = CONFIG
        .replace(
            "id = \"s3dc\"\nblock = 8\nindex_bits = 2",
            "id = \"hvq\"\ncoarse_codewords = 8\ndetail_codewords = 8",
        )
        .replace("\"nearest\", \"linear\"", "\"linear\"")
        .replace("[pipeline]", "[pipeline]\nstages = [\"all\", 1, 2]\nskipping = [false, true]");
    let folder = tempfile::tempdir().unwrap();
    let outcome = run(&Names::new().unwrap(), &config, &Target::Device(device.clone()), folder.path());
    let own: Vec<_> = outcome.records.iter().filter(|r| r.codec == "hvq").collect();
    assert_eq!(own.len(), 24, "three sites, and optimised linear inline; each level, skipping or not");
    let mut psnr = Vec::new();
    for stages in [Some(1), Some(2), None] {
        let cells: Vec<_> = own.iter().filter(|r| r.stages == stages).collect();
        for cell in &cells {
            let name = format!("{stages:?} {} {} skipping {}", cell.site, cell.filter, cell.skipping);
            assert_eq!((cell.status, &cell.error), (Status::Ok, &None), "{name}");
            // Texels and fetches are compared with the CPU's values of the same level.
            if cell.site != "host" {
                assert_eq!(cell.parity_mismatches, Some(0), "{name}");
            }
            let (own, first) = (cell.image_psnr_db.unwrap(), cells[0].image_psnr_db.unwrap());
            assert!((own - first).abs() < 0.5, "{name}: {own} dB, inline {first}");
        }
        psnr.push(cells[0].image_psnr_db.unwrap());
    }
    assert!(psnr[0] + 1.0 < psnr[1] && psnr[1] + 1.0 < psnr[2], "the levels differ: {psnr:?}");
}

/// Both payloads of tvq at each of its four levels, at every site.
#[test]
fn every_level_of_every_payload_is_that_of_the_cpu() {
    let Some(device) = test_device("stages::payloads") else { return };
    let config = CONFIG
        .replace(
            "id = \"s3dc\"\nblock = 8\nindex_bits = 2",
            "id = \"tvq\"\npayload = [\"fixed\", \"variable\"]\nindex_bits = 5\nrate = 6.0",
        )
        .replace("\"nearest\", \"linear\"", "\"linear\"")
        .replace("[pipeline]", "[pipeline]\nstages = [\"all\", 1, 2, 3]");
    let folder = tempfile::tempdir().unwrap();
    let outcome = run(&Names::new().unwrap(), &config, &Target::Device(device.clone()), folder.path());
    let own: Vec<_> = outcome.records.iter().filter(|r| r.codec == "tvq").collect();
    assert_eq!(own.len(), 32, "three sites, inline under both linear filters; four levels, two payloads");
    for cell in own {
        let name = format!("{:?} {} {} {}", cell.stages, cell.site, cell.filter, cell.settings);
        assert_eq!((cell.status, &cell.error), (Status::Ok, &None), "{name}");
        if cell.site != "host" {
            assert_eq!(cell.parity_mismatches, Some(0), "{name}");
        }
    }
}
