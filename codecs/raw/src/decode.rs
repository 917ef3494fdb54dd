//! Decodes one sample of a word. The twin of decode.wgsl, function for function. This code defines the codec.

use cvr_core::kit::{FetchVoxels, Voxel};
use cvr_core::volume::{Extent, Region};

use crate::form::{Form, Kind};

/// One frame of a stream.
#[derive(Copy, Clone, Debug)]
pub struct Frame<'a> {
    /// The words of the frame, `words_per_frame` of them.
    pub samples: &'a [u32],
    /// How the words hold codes.
    pub form: Form,
    /// Voxels along x, y, z.
    pub extent: Extent,
    /// Values per voxel: 1 or 3.
    pub channels: u32,
}

/// Code of sample `i` (x fastest, channels interleaved).
///
/// # Panics
/// When `i` lies outside the frame.
#[must_use]
#[inline]
pub fn code(form: &Form, samples: &[u32], i: usize) -> u32 {
    let word = samples[i >> form.lanes_log2];
    let lane = i as u32 & ((1 << form.lanes_log2) - 1);
    (word >> (lane * form.bits)) & (u32::MAX >> (32 - form.bits))
}

/// Value of an IEEE half, with integer arithmetic only. Subnormal halves are normal singles, so no device flushes them.
#[must_use]
#[inline]
pub fn half(code: u32) -> f32 {
    let sign = (code & 0x8000) << 16;
    let exponent = (code >> 10) & 0x1f;
    let mantissa = code & 0x3ff;
    if exponent != 0 {
        return f32::from_bits(sign | ((exponent + 112) << 23) | (mantissa << 13));
    }
    if mantissa == 0 {
        return f32::from_bits(sign);
    }
    let first = mantissa.ilog2();
    f32::from_bits(sign | ((first + 103) << 23) | ((mantissa << (23 - first)) & 0x7f_ffff))
}

/// Value of a code, in data units.
#[must_use]
#[inline]
pub fn value(form: &Form, code: u32) -> f32 {
    match form.kind {
        Kind::Unsigned => code as f32,
        Kind::Signed => ((code << (32 - form.bits)) as i32 >> (32 - form.bits)) as f32,
        Kind::Single => f32::from_bits(code),
        Kind::Half => half(code),
        Kind::Scaled => (form.offset + form.step * code as f32).min(form.high),
    }
}

impl FetchVoxels for Frame<'_> {
    fn channels(&self) -> usize {
        self.channels as usize
    }

    fn fetch(&self, p: [u32; 3]) -> Voxel {
        let first = self.extent.index(p) * self.channels as usize;
        let mut out = [0.0; 4];
        for (c, out) in out.iter_mut().enumerate().take(self.channels as usize) {
            *out = value(&self.form, code(&self.form, self.samples, first + c));
        }
        out
    }

    fn fetch_box(&self, region: Region, out: &mut [f32]) {
        let channels = self.channels();
        let rows = region.rows().zip(out.chunks_exact_mut(region.extent.x() as usize * channels));
        // One loop per kind, so that the inner loop has no branch.
        macro_rules! fill {
            ($value:expr) => {
                for (start, out) in rows {
                    let first = self.extent.index(start) * channels;
                    for (k, out) in out.iter_mut().enumerate() {
                        *out = $value(code(&self.form, self.samples, first + k));
                    }
                }
            };
        }
        match self.form.kind {
            Kind::Unsigned => fill!(|code| code as f32),
            Kind::Single => fill!(f32::from_bits),
            Kind::Half => fill!(half),
            Kind::Signed | Kind::Scaled => fill!(|code| value(&self.form, code)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_finite_half_has_its_value() {
        for bits in (0..=u16::MAX).filter(|b| b & 0x7c00 != 0x7c00) {
            let expected = half::f16::from_bits(bits).to_f32();
            assert_eq!(half(u32::from(bits)).to_bits(), expected.to_bits(), "half {bits:04x}");
        }
    }
}
