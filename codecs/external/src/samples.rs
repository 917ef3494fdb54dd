//! Samples as they lie in files: little-endian, x fastest.

use std::io::{ErrorKind, Read};

use cvr_core::volume::{SampleType, Samples};

/// The values as bytes of the type.
pub fn bytes(values: impl Iterator<Item = f32>, sample: SampleType) -> Vec<u8> {
    match (sample.integer_range(), sample.bytes()) {
        // The low byte is the same for signed and unsigned numbers.
        (Some(_), 1) => values.map(|v| v as i32 as u8).collect(),
        (Some(_), _) => values.flat_map(|v| (v as i32 as u16).to_le_bytes()).collect(),
        (None, _) => values.flat_map(f32::to_le_bytes).collect(),
    }
}

/// Bytes of a file in memory at a time: a whole number of samples of any type.
const CHUNK_BYTES: usize = 1 << 20;

/// Reads the first samples of a file, as many as `to` has elements. The file may be as large as the frame, so only one
/// chunk of it is in memory.
pub fn read_values<'a>(
    mut file: impl Read,
    sample: SampleType,
    mut to: impl ExactSizeIterator<Item = &'a mut f32>,
) -> std::io::Result<()> {
    let mut chunk = vec![0; CHUNK_BYTES];
    while to.len() > 0 {
        let bytes = &mut chunk[..CHUNK_BYTES.min(to.len() * sample.bytes())];
        file.read_exact(bytes)?;
        let samples = Samples::from_bytes(sample, bytes, false).ok_or(ErrorKind::InvalidData)?;
        for (i, to) in (0..samples.len()).zip(&mut to) {
            *to = samples.get(i);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fs::File;

    use super::*;

    #[test]
    fn samples_come_back() {
        for sample in SampleType::ALL {
            let all: Vec<f32> = match sample.integer_range() {
                Some((low, high)) => vec![low as f32, high as f32, 1.0, 100.0],
                None => vec![-1e30, 0.1, -0.0, 7.0],
            };
            let written = bytes(all.iter().copied(), sample);
            assert_eq!(written.len(), all.len() * sample.bytes());
            let file = tempfile::NamedTempFile::new().unwrap();
            std::fs::write(file.path(), &written).unwrap();
            let mut read = vec![0.0; all.len()];
            read_values(File::open(file.path()).unwrap(), sample, read.iter_mut()).unwrap();
            assert_eq!(read, all, "{sample}");
            // Every second element of a frame, like a channel.
            let mut read = vec![0.0; 2 * all.len()];
            read_values(File::open(file.path()).unwrap(), sample, read.iter_mut().skip(1).step_by(2))
                .unwrap();
            assert!(read.chunks(2).zip(&all).all(|(pair, value)| pair == [0.0, *value]), "{sample}");
            let short = File::open(file.path()).unwrap();
            assert!(read_values(short, sample, [0.0; 5].iter_mut()).is_err(), "it has four");
        }
        assert_eq!(bytes([258.0].into_iter(), SampleType::U16), [2, 1]);
    }

    #[test]
    fn a_file_of_more_than_a_chunk_is_read_whole() {
        let count = CHUNK_BYTES / 2 + 3;
        let file = tempfile::NamedTempFile::new().unwrap();
        let value = |i: usize| (i % 60_001) as f32;
        std::fs::write(file.path(), bytes((0..count).map(value), SampleType::U16)).unwrap();
        let mut read = vec![0.0; count];
        read_values(File::open(file.path()).unwrap(), SampleType::U16, read.iter_mut()).unwrap();
        assert!(read.iter().enumerate().all(|(i, v)| *v == value(i)));
    }
}
