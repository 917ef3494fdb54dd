//! Coarse resolutions of a registered codec, in the commands and from the configuration to the record.

use std::process::ExitCode;
use std::sync::Arc;

use clap::Command;
use cvr::commands::{decode, render, run};
use cvr::experiment::files::results::Results;
use cvr::experiment::records::record::Status;
use cvr::input::Generator;
use cvr::registry::Names;
use cvr_core::codec::{Decoder, Progress, encode_file};
use cvr_core::render::{DecodedFrame, upsampled};
use cvr_core::volume::{BrickSource as _, FiniteVolume, FrameIndex, Level, SampleType};

use super::folder::Folder;
use super::volumes::{computed, floats, opened};

/// Not a multiple of any power of two.
const SIZE: [u32; 3] = [45, 38, 29];
const GENERATOR: Generator = Generator::AdvectedBlobs;

const CONFIG: &str = r##"
[experiment]
name = "resolutions"
[[volume]]
name = "v"
generate = "advected-blobs"
dims = [45, 38, 29]
[[codec]]
id = "wavelet"
filter = ["cdf-9-7", "haar", "5-3"]
decompositions = 2
[[codec]]
id = "wavelet"
block = 8
filter = "haar"
[pipeline]
renderer = ["raycasting"]
site = ["inline", "deferred", "host"]
filter = ["linear"]
resolution = [0, 1, 2, 3]
[[scene]]
name = "front"
size = [24, 24]
transfer_function = [[0, "#00000000"], [60, "#00000000"], [150, "#ffb04060"], [255, "#ffffffff"]]
"##;

/// The arguments of a command, as a user writes them.
fn args<A: clap::Args + clap::FromArgMatches>(words: &[&str]) -> A {
    let command = A::augment_args(Command::new("cvr"));
    A::from_arg_matches(&command.get_matches_from([&["cvr"], words].concat())).unwrap()
}

/// A volume, and a container of it with three decompositions.
fn container(folder: &Folder, filter: &str) -> FiniteVolume {
    let names = Names::new().unwrap();
    let codec = names.codecs().get("wavelet").unwrap();
    let settings =
        cvr_codec_tests::settings(&[("filter", filter), ("decompositions", "3"), ("max_error", "1")]);
    let dense = computed(GENERATOR, SIZE, SampleType::U8);
    folder.volume("v.nrrd", &dense);
    let volume = FiniteVolume::new(dense);
    let (settings, path) = (codec.info().complete(&settings).unwrap(), folder.path("v.cvr"));
    encode_file(codec.as_ref(), &settings, &volume, volume.replaced(), &path, &Progress::silent()).unwrap();
    volume
}

/// Means over boxes of an edge, those at the border cut.
fn means(volume: &FiniteVolume, edge: usize) -> Vec<f32> {
    let size = SIZE.map(|n| n as usize);
    let values = volume.dense().frame_values(FrameIndex::FIRST);
    let along = |n: usize| (0..n.div_ceil(edge)).map(move |i| edge * i..(edge * (i + 1)).min(n));
    let mut all = Vec::new();
    for zs in along(size[2]) {
        for ys in along(size[1]) {
            for xs in along(size[0]) {
                let rows = zs.clone().flat_map(|z| ys.clone().map(move |y| (z * size[1] + y) * size[0]));
                let samples: Vec<f32> =
                    rows.flat_map(|row| values[row + xs.start..row + xs.end].to_vec()).collect();
                all.push(samples.iter().sum::<f32>() / samples.len() as f32);
            }
        }
    }
    all
}

#[test]
fn decode_writes_each_resolution() {
    // Voxels of Haar are means of boxes. Those of the others lie half a voxel beside them, and more at each level.
    for (filter, most) in [("haar", 1.5), ("cdf-9-7", 20.0), ("5-3", 20.0)] {
        let folder = Folder::new();
        let volume = container(&folder, filter);
        let decode = |out: &str, resolution: &str| {
            let [container, out] = ["v.cvr", out].map(|name| folder.path(name).display().to_string());
            let words = [container.as_str(), &out, "--resolution", resolution];
            decode::run_with(&args(&words), &Names::new().unwrap())
        };
        for (resolution, size) in [("0", SIZE), ("1", [23, 19, 15]), ("2", [12, 10, 8]), ("3", [6, 5, 4])] {
            let name = format!("{resolution}.nrrd");
            decode(&name, resolution).unwrap();
            let decoded = cvr::input::open(&folder.path(&name)).unwrap();
            let (layout, edge) = (decoded.layout(), 1 << resolution.parse::<u32>().unwrap());
            assert_eq!((layout.extent.to_array(), layout.spacing), (size, [f64::from(edge); 3]), "{filter}");
            let found = decoded.frame_values(FrameIndex::FIRST);
            let errors =
                found.iter().zip(means(&volume, edge as usize)).map(|(a, b)| f64::from((a - b).abs()));
            let mean = errors.sum::<f64>() / found.len() as f64;
            assert!(mean < most, "{filter} {resolution}: off by {mean}");
        }
        let refused = decode("no.nrrd", "4").unwrap_err().0;
        assert_eq!(refused, "resolution 4: codec wavelet has resolutions 0 to 3 with these settings");
        assert!(!folder.path("no.nrrd").exists());
    }
}

#[test]
fn render_draws_each_resolution_at_both_sites() {
    let folder = Folder::new();
    container(&folder, "cdf-9-7");
    let render = |site: &str, resolution: &str| {
        let [file, out] = ["v.cvr", "v.png"].map(|name| folder.path(name).display().to_string());
        let words = [&file, &out, "--device", "cpu", "--size", "40x32", "--site", site];
        render::run_with(
            &args(&[&words[..], &["--resolution", resolution]].concat()),
            &Names::new().unwrap(),
        )?;
        Ok::<_, cvr::exit::BadInput>(std::fs::read(out).unwrap())
    };
    let mut seen: Vec<Vec<u8>> = Vec::new();
    for resolution in ["0", "1", "2", "3"] {
        let [deferred, host] = ["deferred", "host"].map(|site| render(site, resolution).unwrap());
        assert!(deferred == host, "{resolution}");
        assert!(!seen.contains(&host), "{resolution} looks like a finer one");
        seen.push(host);
    }
    let refused = render("inline", "0").unwrap_err().0;
    assert_eq!(refused, "codec wavelet cannot be decoded at site inline; it offers: deferred, host");
}

#[test]
fn a_run_draws_what_settings_offer_and_refuses_the_rest() {
    let folder = Folder::new();
    folder.write("resolutions.toml", CONFIG);
    let [config, out] = ["resolutions.toml", "out"].map(|name| folder.path(name).display().to_string());
    let words = [config.as_str(), "--device", "cpu", "--out", &out];
    let code = run::run_with(&args(&words), &Names::new().unwrap()).unwrap();
    assert_eq!(format!("{code:?}"), format!("{:?}", ExitCode::SUCCESS));
    let records = Results::read(&folder.path("out/results.json")).unwrap().records;
    // Filters × sites × resolutions of whole volumes; sites of blocks, which have one resolution.
    assert_eq!(records.len(), 3 * 2 * 3 + 3);
    for record in &records {
        let name = format!("{} {} {}", record.settings, record.site, record.resolution);
        assert_eq!((record.status, &record.error), (Status::Ok, &None), "{name}");
        let psnr = record.psnr_db.unwrap();
        match record.resolution {
            0 => assert!(psnr > 30.0, "{name}: {psnr} dB"),
            _ => assert!((12.0..60.0).contains(&psnr), "{name}: {psnr} dB"),
        }
    }
    let at = |site: &str, resolution: u8| {
        records.iter().filter(|r| r.site == site && r.resolution == resolution).count()
    };
    assert_eq!([at("inline", 0), at("deferred", 0), at("host", 0)], [1, 4, 4]);
    assert_eq!([at("deferred", 2), at("host", 2), at("host", 3)], [3, 3, 0]);
}

/// Root mean square of the difference between a resolution, brought to the volume's size, and the volume.
fn distance(decoder: &dyn Decoder, volume: &FiniteVolume, resolution: u8) -> f64 {
    let level = Level { resolution, ..Level::FULL };
    let frame: Arc<DecodedFrame> = DecodedFrame::at(decoder, FrameIndex::FIRST, level).unwrap();
    let brought =
        upsampled(&frame, volume.layout().extent, (resolution, decoder.coarse_shift(resolution))).unwrap();
    let squares = brought.iter().zip(volume.dense().frame_values(FrameIndex::FIRST));
    let sum: f64 = squares.map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (sum / brought.len() as f64).sqrt()
}

/// The decoder of a volume after two decompositions, with an error of one at most.
fn decoder(filter: &str, volume: &FiniteVolume) -> Box<dyn Decoder> {
    let names = Names::new().unwrap();
    let codec = names.codecs().get("wavelet").unwrap();
    let settings =
        cvr_codec_tests::settings(&[("filter", filter), ("decompositions", "2"), ("max_error", "1")]);
    opened(codec.as_ref(), &codec.info().complete(&settings).unwrap(), volume)
}

/// Resolutions of all filters are about as good as means: they lie where the volume does.
#[test]
fn resolutions_lie_where_the_volume_does() {
    let volume = FiniteVolume::new(computed(GENERATOR, SIZE, SampleType::U8));
    let of = |filter: &str| {
        let decoder = decoder(filter, &volume);
        [1, 2].map(|resolution| distance(decoder.as_ref(), &volume, resolution))
    };
    let haar = of("haar");
    for filter in ["daubechies-4", "coiflet-6", "cdf-2-6", "cdf-spline-2-6", "cdf-9-7", "5-3"] {
        let own = of(filter);
        // Low coefficients of coiflet-6 lie up to six voxels behind the first ones of their lines, so it has none there.
        let most = if filter == "coiflet-6" { 1.4 } else { 1.25 };
        assert!(
            own.iter().zip(haar).all(|(own, haar)| *own < most * haar),
            "{filter}: {own:?}, haar {haar:?}"
        );
    }
}

/// The value of a volume between its voxels.
fn interpolated(volume: &DecodedFrame, p: [f64; 3]) -> f64 {
    let corner = |i: usize| {
        let high = [i & 1, i >> 1 & 1, i >> 2];
        let weight = |a: usize| if high[a] == 1 { p[a].fract() } else { 1.0 - p[a].fract() };
        let at = [0, 1, 2].map(|a| p[a] as u32 + high[a] as u32);
        f64::from(volume.values()[volume.layout().extent.index(at)]) * weight(0) * weight(1) * weight(2)
    };
    (0..8).map(corner).sum()
}

/// Voxel `i` of resolution `r` lies at `2^r · i + offset · (2^r − 1)` of the volume, where the filter says the offset. The
/// decoder's shift brings it there (docs/maintainer/decisions/resolutions.md).
#[test]
fn each_filter_has_its_own_place_of_voxels() {
    let volume = FiniteVolume::new(floats([48, 48, 48], |p| {
        let [x, y, z] = p.map(|n| n as f32);
        100.0 * ((0.16 * x).sin() + (0.13 * y).cos() + (0.15 * z + 0.4).sin())
    }));
    for (filter, own) in [
        ("haar", 0.5),
        ("daubechies-4", 0.634),
        ("coiflet-6", 2.0),
        ("cdf-2-6", 0.5),
        ("cdf-spline-2-6", 0.0),
        ("cdf-9-7", 0.0),
    ] {
        let decoder = decoder(filter, &volume);
        let at = |resolution| {
            DecodedFrame::at(decoder.as_ref(), FrameIndex::FIRST, Level { resolution, ..Level::FULL })
                .unwrap()
        };
        let full = at(0);
        for resolution in [1, 2] {
            // The middle of a box of 2^r voxels, less the shift.
            let told = f64::from(decoder.coarse_shift(resolution)) * f64::from(1 << resolution);
            let first = 0.5 * f64::from((1 << resolution) - 1) - told;
            assert!((first - own * f64::from((1 << resolution) - 1)).abs() < 1e-3, "{filter}: {first}");
            let (frame, step) = (at(resolution), f64::from(1 << resolution));
            let error = |offset: f64| {
                // Away from borders, where filters read what lies beyond.
                let inner = (8 / (1 << resolution) + 1)..(32 / (1 << resolution));
                let place = |i: u32| step * f64::from(i) + offset * (step - 1.0);
                let mut sum = 0.0;
                for (z, y) in inner.clone().flat_map(|z| inner.clone().map(move |y| (z, y))) {
                    for x in inner.clone() {
                        let found = frame.values()[frame.layout().extent.index([x, y, z])];
                        sum += (f64::from(found) - interpolated(&full, [x, y, z].map(place))).abs();
                    }
                }
                sum
            };
            for other in [own - 0.25, own + 0.25].into_iter().filter(|other| *other >= 0.0) {
                let (own, other) = (error(own), error(other));
                assert!(2.0 * own < other, "{filter} {resolution}: {own}, elsewhere {other}");
            }
        }
    }
}
