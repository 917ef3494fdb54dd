//! Time of the inverse transform on a device, over that of a pass that loads and stores each sample once.
//!
//! `cargo run --release -p cvr-wavelet --example passes -- 256`
//!
//! Every decoder is timed with the packing of its frame into a texture. Decoders of two and of ten copying passes tell
//! what one copying pass takes, and what all else takes, which is subtracted. Runs of all decoders alternate; the
//! medians of seven count.

#![allow(clippy::unwrap_used, reason = "a program of figures, which any failure ends")]

use std::borrow::Cow;
use std::sync::Arc;

use cvr_core::codec::*;
use cvr_core::volume::*;
use cvr_engine::{Device, DeviceChoice, FrameDecoder};
use cvr_wavelet::Wavelet;

const COPY: &str = "
@compute @workgroup_size(64)
fn copies_copy(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = id.y * groups.x * 64u + id.x;
    if i < copies_samples {
        copies_set_to(i, copies_from(i));
    }
}
";

/// A decoder whose passes copy a frame of anything so many times.
#[derive(Debug)]
struct Copies {
    layout: VolumeLayout,
    form: DecodedForm,
    passes: usize,
}

impl Decoder for Copies {
    fn layout(&self) -> &VolumeLayout {
        &self.layout
    }

    fn decode_brick(&self, _: BrickKey, _: &dyn ReferenceFrames, out: &mut [f32]) -> Result<(), DecodeError> {
        out.fill(0.0);
        Ok(())
    }

    fn decoded_form(&self) -> DecodedForm {
        self.form
    }

    fn frame_decode(&self) -> Option<&dyn FrameDecode> {
        Some(self)
    }
}

impl FrameDecode for Copies {
    fn passes(&self, _: FrameIndex, _: Level) -> Result<FramePasses<'_>, DecodeError> {
        let samples = self.layout.samples_per_frame();
        let names = ["a", "b"];
        let pass = |i: usize| FramePass {
            module: WgslModule::new("copy.wgsl", COPY).with("samples", samples as u32),
            entry: "copy",
            workgroups: [1024, samples.div_ceil(64 * 1024) as u32, 1],
            scratch: vec![
                ScratchUse { name: "from", buffer: names[i % 2] },
                ScratchUse { name: "to", buffer: names[(i + 1) % 2] },
            ],
        };
        Ok(FramePasses {
            resources: vec![Resource { name: "nothing", words: Cow::Owned(vec![0]) }],
            scratch: names.map(|name| Scratch { name, words: samples }).to_vec(),
            passes: (0..self.passes).map(pass).collect(),
            result: "a",
        })
    }

    fn agreement(&self) -> Agreement {
        Agreement::Exact
    }
}

/// Smooth waves and some noise.
fn volume(edge: u32) -> FiniteVolume {
    let value = |i: u32| {
        let [x, y, z] = [i % edge, i / edge % edge, i / edge / edge].map(f64::from);
        let wave = (0.19 * x + 0.06 * z).sin() * (0.14 * y - 0.04 * x).cos() * (0.1 * z + 0.4).sin();
        let noise = f64::from(i.wrapping_mul(0x9e37_79b9) >> 28);
        (120.0 + 100.0 * wave + noise) as u8
    };
    let layout = VolumeLayout::scalar(Extent::cube(edge).unwrap(), SampleType::U8);
    FiniteVolume::new(DenseVolume::new(layout, Samples::U8((0..edge.pow(3)).map(value).collect())).unwrap())
}

fn main() {
    let edge = std::env::args().nth(1).map_or(256, |edge| edge.parse().unwrap());
    let device = Device::open(&DeviceChoice::Auto).unwrap();
    println!("{}; {edge}³, five levels", device.info());
    let volume = volume(edge);
    let mut decoders: Vec<(String, Box<dyn Decoder>)> = Vec::new();
    for filter in ["haar", "5-3", "cdf-2-6", "cdf-spline-2-6", "daubechies-4", "coiflet-6", "cdf-9-7"] {
        let mut settings = Settings::from_iter([("filter".to_owned(), SettingValue::from(filter))]);
        if filter != "5-3" {
            settings.set("bits_per_voxel", SettingValue::from("2"));
        }
        let stream = encode_temporary(&Wavelet, &settings, &volume).unwrap();
        decoders.push((filter.to_owned(), Wavelet.decoder(Arc::new(stream)).unwrap()));
    }
    for form in [DecodedForm::FLOAT32, DecodedForm::of(SampleType::U8)] {
        for passes in [2, 10] {
            let copies = Copies { layout: volume.layout().clone(), form, passes };
            decoders.push((format!("{passes}"), Box::new(copies)));
        }
    }
    let made: Vec<FrameDecoder> = decoders
        .iter()
        .map(|(name, decoder)| {
            let id = if name.parse::<usize>().is_ok() { "copies" } else { "wavelet" };
            FrameDecoder::new(&device, id, decoder.as_ref(), FrameIndex::FIRST, Level::FULL).unwrap()
        })
        .collect();
    let mut times: Vec<Vec<f64>> = vec![Vec::new(); made.len()];
    for round in 0..8 {
        for (frame, times) in made.iter().zip(&mut times) {
            let time = frame.decode().unwrap();
            if round > 0 {
                times.push(time.gpu_ms.unwrap_or(time.wall_ms));
            }
        }
    }
    let medians: Vec<f64> = times
        .into_iter()
        .map(|mut times| {
            times.sort_by(f64::total_cmp);
            times[times.len() / 2]
        })
        .collect();
    let copies = medians.len() - 4;
    println!("| filter | ms in all | ms of its passes | ÷ a copying pass |\n|---|---|---|---|");
    for (i, (name, decoder)) in decoders.iter().take(copies).enumerate() {
        let of = copies + if decoder.decoded_form() == DecodedForm::FLOAT32 { 0 } else { 2 };
        let one = (medians[of + 1] - medians[of]) / 8.0;
        let own = medians[i] - (medians[of] - 2.0 * one);
        println!("| {name} | {:.1} | {own:.1} | {:.2} |", medians[i], own / one);
    }
}
