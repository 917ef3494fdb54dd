//! Time of the steps of training, on generated vectors: `cargo bench -p cvr-codebook`.

#![allow(missing_docs, reason = "criterion's macros write functions")]

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use cvr_codebook::lbg::Stop;
use cvr_codebook::{Codebook, Initial, Quantiser, Search, Training, Vectors, sample, train};
use cvr_core::codec::Progress;
use cvr_core::volume::ValueRange;

const VECTORS: usize = 1 << 14;

/// Blocks of `edge`³ voxels of crossing waves, with values in 0..256.
fn waves(edge: usize) -> Vectors {
    let value = |p: [f32; 3]| {
        let [x, y, z] = p;
        128.0
            + 60.0 * (0.11 * x + 0.03 * y).sin()
            + 50.0 * (0.07 * y - 0.05 * z).cos()
            + 17.0 * (0.9 * z).sin()
    };
    let mut values = Vec::with_capacity(VECTORS * edge.pow(3));
    for corner in 0..VECTORS {
        let corner = [corner % 32 * edge, corner / 32 % 32 * edge, corner / 1024 * edge];
        for i in 0..edge.pow(3) {
            let inside = [i % edge, i / edge % edge, i / edge / edge];
            values.push(value([0, 1, 2].map(|a| (corner[a] + inside[a]) as f32)).round());
        }
    }
    Vectors::of_rows(edge.pow(3), values)
}

fn quantiser() -> Quantiser {
    let range = ValueRange { min: 0.0, max: 255.0 };
    Quantiser::over(range, 8, true).unwrap_or_else(|e| unreachable!("{e}"))
}

fn parts(c: &mut Criterion) {
    let run = Progress::silent();
    for edge in [2, 4] {
        let vectors = waves(edge);
        let mut group = c.benchmark_group(format!("{VECTORS} blocks of {edge}³"));
        group.throughput(Throughput::Elements(VECTORS as u64)).sample_size(10);
        for size in [256, 1024] {
            group.bench_function(BenchmarkId::new("pca", size), |b| {
                b.iter(|| Initial::Pca.codewords(black_box(&vectors), size, 1, &run));
            });
            let Ok(first) = Initial::Pca.codewords(&vectors, size, 1, &run) else { continue };
            let codebook = Codebook::nearest_to(&first, vectors.dimension(), quantiser());
            let search = Search::new(&codebook, None);
            group.bench_function(BenchmarkId::new("search", size), |b| {
                b.iter(|| search.all(black_box(&vectors)));
            });
            let stop = Stop { rounds: 10, gain: 0.0 };
            let training = Training { size, quantiser: quantiser(), initial: Initial::Pca, seed: 1, stop };
            group.bench_function(BenchmarkId::new("train, 10 rounds", size), |b| {
                b.iter(|| train(black_box(&vectors), &training, &run));
            });
        }
        group.finish();
    }
    c.bench_function("choose 2^17 of 2^31", |b| b.iter(|| sample::choose(1 << 31, 1 << 17, black_box(1))));
}

criterion_group!(benches, parts);
criterion_main!(benches);
