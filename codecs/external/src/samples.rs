//! Samples as they lie in files: little-endian, x fastest.

use cvr_core::volume::{SampleType, Samples};

/// The bytes of values that the type holds.
pub fn bytes(values: impl Iterator<Item = f32>, sample: SampleType) -> Vec<u8> {
    match (sample.integer_range(), sample.bytes()) {
        // The low bytes of two's complement are those of either sign.
        (Some(_), 1) => values.map(|v| v as i32 as u8).collect(),
        (Some(_), _) => values.flat_map(|v| (v as i32 as u16).to_le_bytes()).collect(),
        (None, _) => values.flat_map(f32::to_le_bytes).collect(),
    }
}

/// The values in these bytes; `None` where the last sample is cut.
pub fn values(bytes: &[u8], sample: SampleType) -> Option<Vec<f32>> {
    let samples = Samples::from_bytes(sample, bytes, false)?;
    Some((0..samples.len()).map(|i| samples.get(i)).collect())
}

#[cfg(test)]
mod tests {
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
            assert_eq!(values(&written, sample).unwrap(), all, "{sample}");
        }
        assert_eq!(bytes([258.0].into_iter(), SampleType::U16), [2, 1]);
        assert_eq!(values(&[1, 2, 3], SampleType::I16), None);
    }
}
