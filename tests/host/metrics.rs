//! The figures of a run, compared with each other and with a lossless codec.

use cvr::experiment::files::results::Results;
use cvr::experiment::measured::error_histogram::Row;
use cvr::experiment::records::record::{Record, Status};

use super::folder::Folder;

const CONFIG: &str = r##"
[experiment]
name = "errors"
seed = 7
[[volume]]
name = "rings"
generate = "marschner-lobb"
dims = [24, 20, 18]
dtype = "u8"
[[codec]]
id = "raw"
[[codec]]
id = "s3dc"
block = [4, 8]
index_bits = 2
[[codec]]
id = "hvq"
[pipeline]
renderer = "raycasting"
site = "host"
filter = "linear"
[[scene]]
name = "front"
size = [48, 40]
transfer_function = [[110, "#00000000"], [128, "#3060c0ff"], [255, "#f0f0f0ff"]]
[[scene]]
name = "nowhere"
size = [8, 8]
transfer_function = [[900, "#00000000"], [901, "#ffffffff"]]
"##;

fn histogram(folder: &Folder, record: &Record) -> Vec<Row> {
    let path = folder.path(&format!("out/{}", record.error_histogram.as_ref().unwrap()));
    csv::Reader::from_path(path).unwrap().deserialize().collect::<Result<_, _>>().unwrap()
}

#[test]
fn figures_of_a_run_agree_with_each_other() {
    let folder = Folder::new();
    folder.write("errors.toml", CONFIG);
    let ran = folder.cvr(&["run", "errors.toml", "--device", "cpu", "--out", "out"]).exits(0);
    assert!(ran.stdout.contains("8 cells: 8 ok, 0 failed"), "{}", ran.stdout);
    let mut records = Results::read(&folder.path("out/results.json")).unwrap().records;
    for record in &mut records {
        assert_eq!(record.status, Status::Ok);
        let [file, payload] = [record.file_bytes, record.payload_bytes].map(Option::unwrap);
        assert!(file > payload && (file - payload).is_multiple_of(2048), "{file} of {payload} and a header");
        // Two codes and a mean for each of 150 blocks are less than half a kilobyte. The rest is codebooks.
        assert!(record.codec != "hvq" || payload > 4096, "{payload}");
        let rows = histogram(&folder, record);
        assert_eq!(rows.iter().map(|row| row.samples).sum::<u64>(), 24 * 20 * 18);
        assert!((rows.iter().map(|row| row.share).sum::<f64>() - 1.0).abs() < 1e-12);
        // Bins of one integer each: the histogram of the errors is exact.
        let samples = |row: &Row| row.samples as f64 / (24.0 * 20.0 * 18.0);
        let mean: f64 = rows.iter().map(|row| row.from.abs() * samples(row)).sum();
        let square: f64 = rows.iter().map(|row| row.from * row.from * samples(row)).sum();
        let largest = rows.iter().map(|row| row.from.abs()).fold(0.0, f64::max);
        assert!((record.mean_abs_error.unwrap() - mean).abs() < 1e-9, "{}", record.codec);
        assert!((record.rmse.unwrap() - square.sqrt()).abs() < 1e-9, "{}", record.codec);
        assert_eq!(record.max_abs_error, Some(largest));
        assert!(record.p999_abs_error.unwrap() <= largest);
        if record.scene == "nowhere" {
            // No value reaches the ramp.
            assert_eq!((record.isosurface_distance_voxels, record.image_ms_ssim), (None, None));
            assert_eq!(
                (record.image_psnr_db, record.image_ssim, record.visible_pixels),
                (None, None, Some(0))
            );
            continue;
        }
        let (lossless, blocks) = (record.codec == "raw", record.block_discontinuity);
        assert_eq!(blocks.is_none(), lossless, "{}", record.codec);
        if record.codec == "hvq" {
            // Every block has its own codeword here, so errors lie where the scene shows nothing.
            continue;
        }
        let errors = [
            record.mean_abs_error,
            record.gradient_error,
            record.isosurface_distance_voxels,
            record.isosurface_max_distance_voxels,
            record.codec_image_flip,
        ];
        assert!(errors.iter().all(|e| (e.unwrap() == 0.0) == lossless), "{}: {errors:?}", record.codec);
        assert_eq!(record.codec_image_ms_ssim == Some(1.0), lossless, "{}", record.codec);
        assert_eq!(record.error_autocorrelation.is_none(), lossless, "{}", record.codec);
        // Per visible pixel, an error is larger than over the whole picture. Without errors, both are zero.
        let [flip, whole] = [record.image_flip, record.image_flip_whole].map(Option::unwrap);
        let [similar, all] = [record.image_ms_ssim, record.image_ms_ssim_whole].map(Option::unwrap);
        assert!(
            flip > whole && similar < all || lossless && [flip, whole, similar, all] == [0.0, 0.0, 1.0, 1.0]
        );
    }
    let report = folder.text("out/report.html");
    let path = records[0].error_histogram.as_ref().unwrap();
    // As the template escapes it.
    let link = format!("<a href=\"{}\">", path.replace('/', "&#x2f;"));
    assert!(report.contains(&link), "no {link}");
    assert!(report.contains("picture MS-SSIM") && !report.contains("<a href=\"frames"));
}
