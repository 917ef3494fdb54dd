//! Cost of an exact transfer function compared with a table of 1024 entries: the same scene with each, alternately, on
//! this machine's device. `docs/benchmarks/transfer-function.md` gives the command and the figures.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a benchmark may end in a panic")]

use std::sync::Arc;

use cvr::registry::{Names, renderer};
use cvr_core::codec::{Decoder, Settings, encode_temporary};
use cvr_core::render::{ControlPoint, DecodedFrame, Filter, SegmentSearch, TransferFunction, View};
use cvr_core::volume::{
    DenseVolume, Extent, FiniteVolume, FrameIndex, Level, SampleType, Samples, VolumeLayout,
};
use cvr_engine::{Device, DeviceChoice, DrawSource, Drawing, VolumeTexture};

#[path = "../tests/device/former_table.rs"]
#[allow(missing_docs, reason = "a module of the tests")]
mod former_table;

const EDGE: u32 = 96;
const PAIRS: usize = 21;

/// Smooth structures over all of u16.
fn waves() -> FiniteVolume {
    let value = |i: u32| {
        let [x, y, z] = [i % EDGE, i / EDGE % EDGE, i / EDGE / EDGE].map(f64::from);
        let wave = (0.19 * x + 0.06 * z).sin() * (0.14 * y - 0.04 * x).cos() * (0.1 * z + 0.4).sin();
        (32767.5 + 32767.5 * wave) as u16
    };
    let layout = VolumeLayout::scalar(Extent::cube(EDGE).unwrap(), SampleType::U16);
    let samples = Samples::U16((0..EDGE.pow(3)).map(value).collect());
    FiniteVolume::new(DenseVolume::new(layout, samples).unwrap())
}

/// Numbers without a pattern, 0 to 1.
fn noise() -> impl FnMut() -> f32 {
    let mut state = 1_u32;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    }
}

/// So transparent that every ray is followed to its end.
fn faint(mut values: Vec<f32>) -> TransferFunction {
    let mut next = noise();
    values.sort_by(f32::total_cmp);
    let colour = |value| ControlPoint { value, rgba: [next(), next(), next(), 0.02 * next()] };
    TransferFunction::new(values.into_iter().map(colour).collect()).unwrap()
}

/// Points at equal distances, anywhere, and ever farther apart.
fn functions() -> Vec<(String, TransferFunction)> {
    let even = |n: u16| (0..n).map(|i| f32::from(i) * 65535.0 / f32::from(n - 1)).collect();
    let anywhere = |n: usize| {
        let mut next = noise();
        (0..n - 2).map(|_| 65535.0 * next()).chain([0.0, 65535.0]).collect()
    };
    let growing = |n: u16| (0..n).map(|i| 65535.0 * 1e-6_f32.powf(f32::from(i) / f32::from(n - 1))).collect();
    let mut all: Vec<_> =
        [2, 5, 16, 256, 4096].map(|n| (format!("{n} even"), faint(even(n)))).into_iter().collect();
    all.extend([16, 256, 4096].map(|n| (format!("{n} anywhere"), faint(anywhere(n)))));
    all.extend([16, 256, 4096].map(|n| (format!("{n} growing"), faint(growing(n)))));
    all
}

fn search(function: &TransferFunction) -> String {
    match function.search() {
        SegmentSearch::Every { .. } => "every".to_owned(),
        SegmentSearch::Guide { wide } => if wide { "wide guide" } else { "guide" }.to_owned(),
        SegmentSearch::Tree { levels } => format!("tree, {levels} levels"),
    }
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

/// CPU time of a picture if the system reports it, because other work disturbs it least. Else the wall clock.
fn cost(drawing: &Drawing) -> f64 {
    let time = drawing.draw_timed().unwrap();
    time.cpu_ms.unwrap_or(time.wall_ms)
}

fn main() {
    let device = Device::open(&DeviceChoice::Auto).unwrap();
    let names = Names::new().unwrap();
    let raw = names.codecs().get("raw").unwrap();
    let settings = raw.info().complete(&Settings::default()).unwrap();
    let stream = encode_temporary(raw.as_ref(), &settings, &waves()).unwrap();
    let decoder: Box<dyn Decoder> = raw.decoder(Arc::new(stream)).unwrap();
    let frame = DecodedFrame::decode(decoder.as_ref(), FrameIndex::FIRST).unwrap();
    let texture =
        VolumeTexture::upload(&device, decoder.layout(), frame.values(), decoder.decoded_form()).unwrap();
    let host = DrawSource::Texture(Arc::new(texture));
    let inline = DrawSource::Inline {
        codec: "raw",
        decoder: decoder.as_ref(),
        frame: FrameIndex::FIRST,
        level: Level::FULL,
    };
    println!("| points | search | raycasting, host | raycasting, inline | slicing, host | slicing, inline |");
    println!("|---|---|---|---|---|---|");
    for (name, function) in functions() {
        print!("| {name} | {} |", search(&function));
        for renderer in ["raycasting", "slicing"].map(|label| renderer(label).unwrap()) {
            for source in [&host, &inline] {
                let view = View { size: [128, 128], step_voxels: 1.0, ..View::new(function.clone()) };
                let plan = renderer.plan(&view, decoder.layout()).unwrap();
                let former = former_table::with_table(&plan, &function);
                let [now, former] =
                    [plan, former].map(|plan| Drawing::new(&device, &plan, source, Filter::Linear).unwrap());
                for drawing in [&now, &former] {
                    cost(drawing);
                }
                let pairs: Vec<_> = (0..PAIRS).map(|_| (cost(&now), cost(&former))).collect();
                let ratio = median(pairs.iter().map(|(now, former)| now / former));
                print!(" {:.1} ms, {ratio:.2} × |", median(pairs.iter().map(|(now, _)| *now)));
            }
        }
        println!();
    }
}
