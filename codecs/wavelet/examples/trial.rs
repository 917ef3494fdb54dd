//! Trial.
use cvr_core::volume::*;
use cvr_wavelet::coders::contexts;
use cvr_wavelet::stream::pyramid::Pyramid;
use cvr_wavelet::transform::{self, Filter, gain};
use std::time::Instant;

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let filter = Filter::from_name(&args[0]).unwrap();
    let volumes = args[1].split(',');
    let targets: Vec<f64> = args[2].split(',').map(|v| v.parse().unwrap()).collect();
    let mu: f32 = args[3].parse().unwrap();
    let slab: usize = args.get(4).map_or(1 << 21, |v| v.parse().unwrap());
    if let Some(w) = args.get(5) {
        let v: Vec<u16> = w.split(',').map(|v| v.parse().unwrap()).collect();
        contexts::band::WEIGHTS.write().unwrap()[..v.len()].copy_from_slice(&v);
    }
    let folder = cvr_codec_tests::real::folder().unwrap();
    for name in volumes {
        let volume = cvr_codec_tests::real::volume_of(&folder, name);
        let layout = volume.layout().clone();
        let [x, y, z] = layout.extent.to_array().map(|n| n as usize);
        let n = x * y * z;
        let mut all = vec![0.0_f32; n * layout.channels as usize];
        volume.read(FrameIndex(0), Region::whole(layout.extent), &mut all).unwrap();
        let samples: Vec<f32> = all.iter().step_by(layout.channels as usize).copied().collect();
        let range = ValueRange::of(samples.iter().copied()).unwrap();
        let peak = f64::from(range.max) - f64::from(range.min);
        let pyramid = Pyramid::new([x, y, z], 5, filter.pads());
        let t = Instant::now();
        let coefficients = transform::forward(filter, &pyramid, samples.clone());
        let forward = t.elapsed().as_secs_f64();
        let norms: Vec<f64> = pyramid
            .bands()
            .iter()
            .map(|b| {
                let depth = 5 - b.level;
                [x, y, z]
                    .iter()
                    .zip(b.high)
                    .map(|(n, h)| gain::of_band(filter, *n, depth, h).synthesis)
                    .product()
            })
            .collect();
        let mut q = vec![0; coefficients.len()];
        for target in &targets {
            let (mut lo, mut hi) = (peak / 1e6, peak);
            let mut best = None;
            for _ in 0..12 {
                let step = (lo * hi).sqrt();
                let scales: Vec<f32> = norms.iter().map(|n| (n / step) as f32).collect();
                let t = Instant::now();
                let (bytes, chunks) =
                    contexts::trial(&pyramid, &coefficients, &scales, mu, slab, &mut q, false);
                let seconds = t.elapsed().as_secs_f64();
                let bpv = bytes as f64 * 8.0 / n as f64;
                if bpv > *target {
                    lo = step
                } else {
                    hi = step;
                    best = Some((step, bpv, chunks, scales, seconds));
                }
                if bpv < *target && bpv > target * 0.997 {
                    break;
                }
            }
            let Some((step, bpv, chunks, scales, seconds)) = best else { continue };
            contexts::trial(&pyramid, &coefficients, &scales, mu, slab, &mut q, false);
            let mut back = vec![0; q.len()];
            let t = Instant::now();
            contexts::read_back(&pyramid, &chunks, slab, &mut back).unwrap();
            let read = t.elapsed().as_secs_f64();
            assert!(back == q);
            // centroids per band and magnitude
            let mut shift = vec![[0.0_f64; 4]; pyramid.bands().len()];
            for (k, b) in pyramid.bands().iter().enumerate() {
                let mut sums = [[0.0_f64; 2]; 4];
                for i in b.range() {
                    let m = q[i].unsigned_abs() as usize;
                    if m > 0 {
                        let s = &mut sums[m.min(3)];
                        s[0] += f64::from(coefficients[i].abs() * scales[k]) - m as f64;
                        s[1] += 1.0;
                    }
                }
                for m in 1..4 {
                    if sums[m][1] > 0.0 {
                        shift[k][m] = sums[m][0] / sums[m][1];
                    }
                }
            }
            let mode = std::env::var("SHIFT").unwrap_or_default();
            if mode == "none" {
                shift.iter_mut().for_each(|s| *s = [0.0; 4]);
            }
            if mode == "all" {
                let mut sums = [[0.0_f64; 2]; 4];
                for (k, b) in pyramid.bands().iter().enumerate().skip(1) {
                    for i in b.range() {
                        let m = q[i].unsigned_abs() as usize;
                        if m > 0 {
                            let w = 1.0;
                            let s = &mut sums[m.min(3)];
                            s[0] += w * (f64::from(coefficients[i].abs() * scales[k]) - m as f64);
                            s[1] += w;
                        }
                    }
                }
                for s in shift.iter_mut().skip(1) {
                    for m in 1..4 {
                        s[m] = sums[m][0] / sums[m][1].max(1.0);
                    }
                }
                println!("{:?}", shift[5]);
            }
            let t = Instant::now();
            let index =
                |b: &cvr_wavelet::stream::pyramid::Band| pyramid.bands().iter().position(|o| o == b).unwrap();
            let table: std::collections::HashMap<usize, (f64, [f64; 4])> = pyramid
                .bands()
                .iter()
                .map(|b| (b.start, (1.0 / f64::from(scales[index(b)]), shift[index(b)])))
                .collect();
            let back: Vec<f32> = transform::inverse(filter, &pyramid, 5, &q, |b, v: i32| {
                let (s, sh) = table[&b.start];
                let m = v.unsigned_abs() as usize;
                s * (f64::from(v) + f64::from(v.signum()) * sh[m.min(3)])
            });
            let inverse = t.elapsed().as_secs_f64();
            let integer = layout.sample.is_integer();
            let mse: f64 = samples
                .iter()
                .zip(&back)
                .map(|(a, b)| {
                    let b = if integer {
                        f64::from(b.round()).clamp(f64::from(range.min), f64::from(range.max))
                    } else {
                        f64::from(*b)
                    };
                    (f64::from(*a) - b).powi(2)
                })
                .sum::<f64>()
                / n as f64;
            println!(
                "{name} {target}: {bpv:.4} bpv, {:.2} dB, step {step:.4}; fwd {forward:.2} enc {seconds:.2} dec {read:.2} inv {inverse:.2}; nonzero {:.3}",
                10.0 * (peak * peak / mse).log10(),
                q.iter().filter(|v| **v != 0).count() as f64 / n as f64
            );
        }
    }
}
