//! Trains a codebook on vectors from a file, for comparison with other programs (docs/benchmarks/codebook.py).
//!
//! `train VECTORS OUT DIMENSION SIZE BITS GAIN ROUNDS integers|reals [pca|pnn|scalar|random]`: VECTORS holds
//! little-endian singles. OUT receives the codewords in the same form. One line of JSON gives CPU and wall seconds,
//! rounds, size and mean squared error per component.

use std::error::Error;
use std::time::{Duration, Instant};

use cvr_codebook::lbg::Stop;
use cvr_codebook::{Initial, Quantiser, Training, Vectors, train};
use cvr_core::codec::Progress;
use cvr_core::volume::ValueRange;
use rustix::time::{ClockId, clock_gettime};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [vectors, out, dimension, size, bits, gain, rounds, kind, initial @ ..] = &arguments[..] else {
        return Err(
            "usage: train VECTORS OUT DIMENSION SIZE BITS GAIN ROUNDS integers|reals [INITIAL]".into()
        );
    };
    let initial = initial.first().map_or("pca", String::as_str);
    let bytes = std::fs::read(vectors)?;
    let values: Vec<f32> = bytemuck::try_cast_slice(&bytes).map_or_else(
        |_| bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect(),
        <[f32]>::to_vec,
    );
    let range = ValueRange::of(values.iter().copied()).ok_or("no vectors")?;
    let vectors = Vectors::of_rows(dimension.parse()?, values);
    let training = Training {
        size: size.parse()?,
        quantiser: Quantiser::over(range, bits.parse()?, kind == "integers")?,
        initial: Initial::named(initial).ok_or("no such initial codebook")?,
        seed: 1,
        stop: Stop { rounds: rounds.parse()?, gain: gain.parse()? },
    };
    let (wall, cpu) = (Instant::now(), cpu_time());
    let trained = train(&vectors, &training, &Progress::silent()).map_err(|_| "cancelled")?;
    let (wall, cpu) = (wall.elapsed().as_secs_f64(), (cpu_time() - cpu).as_secs_f64());
    let codewords: Vec<u8> = trained.codebook.values().iter().flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(out, codewords)?;
    let mse = trained.distortion / vectors.values().len() as f64;
    println!(
        "{{\"cpu_s\": {cpu:.4}, \"wall_s\": {wall:.4}, \"rounds\": {}, \"size\": {}, \"mse\": {mse:.9e}}}",
        trained.rounds,
        trained.codebook.size()
    );
    Ok(())
}

/// CPU time of this process, over all threads.
fn cpu_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(time.tv_sec.unsigned_abs(), time.tv_nsec.unsigned_abs() as u32)
}
