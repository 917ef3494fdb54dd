//! PSNR over rate on real volumes. Skips without `CVR_DATA`.
//!
//! A table: `CVR_DATA=folder cargo test --release -p cvr-wavelet --test blocks real_volumes -- --nocapture --ignored`

use cvr_codec_tests::real::{cpu_time, folder, volume_of};
use cvr_core::metrics::VolumeError;
use cvr_core::volume::{BrickSource as _, FiniteVolume};

use super::codec::{METHODS, decoded, encoded, of};

/// PSNR, and bits per voxel of the whole file.
fn measured(volume: &FiniteVolume, method: (&str, &str), rate: f64) -> (f64, f64) {
    let stream = encoded(volume, &of(method, "rate", &rate.to_string())).unwrap();
    let bits = 8.0 * stream.file_bytes() as f64 / volume.layout().voxels() as f64;
    (VolumeError::compare(volume, [decoded(&stream)]).psnr_db, bits)
}

#[test]
fn a_rate_of_bonsai_is_used_up() {
    let Some(folder) = folder() else { return };
    let volume = volume_of(&folder, "bonsai");
    let (psnr, bits) = measured(&volume, METHODS[0], 1.0);
    assert!((0.99..=1.0).contains(&bits), "{bits}");
    assert!(psnr > 42.0, "{psnr}");
}

#[test]
#[ignore = "takes minutes; prints the table of figures"]
fn psnr_over_rate() {
    let Some(folder) = folder() else { return };
    for name in ["bonsai", "lidc_chest", "mr_vs"] {
        let volume = volume_of(&folder, name);
        for method in METHODS {
            for rate in [0.5, 1.0, 2.0, 4.0] {
                let begun = cpu_time();
                let (psnr, bits) = measured(&volume, method, rate);
                let seconds = (cpu_time() - begun).as_secs_f64();
                println!(
                    "| {name} | {} | {} | {rate} | {bits:.4} | {psnr:.2} | {seconds:.1} |",
                    method.0, method.1
                );
            }
        }
    }
}
