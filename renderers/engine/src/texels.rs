//! Data values to texels: the inverse of `value = offset + scale · texel`.

use cvr_core::codec::{DecodedForm, TexelFormat};
use half::f16;
use rayon::prelude::*;

/// Channels of a texture for a volume with this many channels. No device filters three.
pub(crate) const fn texture_channels(channels: u32) -> usize {
    if channels == 1 { 1 } else { 4 }
}

/// Texels of whole voxels. RGB is padded with a zero channel.
pub(crate) fn texels(values: &[f32], channels: u32, form: DecodedForm) -> Vec<u8> {
    let texel = |v: f32| (f64::from(v) - f64::from(form.offset)) / f64::from(form.scale);
    // Double precision, so that integer data return to their integers.
    let unorm = |v: f32, top: f64| (texel(v) * top).round().clamp(0.0, top);
    match form.format {
        TexelFormat::Unorm8 => spread(values, channels, |v| [unorm(v, 255.0) as u8]),
        TexelFormat::Unorm16 => spread(values, channels, |v| (unorm(v, 65535.0) as u16).to_le_bytes()),
        TexelFormat::Float16 => spread(values, channels, |v| f16::from_f64(texel(v)).to_le_bytes()),
        // Exact without the conversion if scale is 1 and offset is 0, which is the only form in use.
        TexelFormat::Float32 if form == DecodedForm::FLOAT32 => spread(values, channels, f32::to_le_bytes),
        TexelFormat::Float32 => spread(values, channels, |v| (texel(v) as f32).to_le_bytes()),
    }
}

fn spread<const BYTES: usize>(
    values: &[f32],
    channels: u32,
    texel: impl Fn(f32) -> [u8; BYTES] + Sync,
) -> Vec<u8> {
    /// Voxels per task: large enough that splitting costs nothing.
    const VOXELS: usize = 1 << 14;
    let (from, to) = (channels as usize, texture_channels(channels) * BYTES);
    let mut out = vec![0; values.len() / from * to];
    out.par_chunks_mut(VOXELS * to).zip(values.par_chunks(VOXELS * from)).for_each(|(out, values)| {
        for (out, voxel) in out.chunks_exact_mut(to).zip(values.chunks_exact(from)) {
            for (out, &value) in out.chunks_exact_mut(BYTES).zip(voxel) {
                out.copy_from_slice(&texel(value));
            }
        }
    });
    out
}

/// The inverse: appends the values of whole texels, without the padding of RGB.
pub(crate) fn values(texels: &[u8], channels: u32, form: DecodedForm, out: &mut Vec<f32>) {
    let bytes = form.format.bytes();
    let value = |texel: f64| (f64::from(form.offset) + f64::from(form.scale) * texel) as f32;
    for texel in texels.chunks_exact(texture_channels(channels) * bytes) {
        out.extend(texel.chunks_exact(bytes).take(channels as usize).map(|sample| {
            match (form.format, sample) {
                (TexelFormat::Unorm8, [byte, ..]) => value(f64::from(*byte) / 255.0),
                (TexelFormat::Unorm16, [a, b, ..]) => {
                    value(f64::from(u16::from_le_bytes([*a, *b])) / 65535.0)
                }
                (TexelFormat::Float16, [a, b, ..]) => value(f16::from_le_bytes([*a, *b]).to_f64()),
                (TexelFormat::Float32, [a, b, c, d]) => {
                    value(f64::from(f32::from_le_bytes([*a, *b, *c, *d])))
                }
                _ => f32::NAN,
            }
        }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn form(format: TexelFormat, scale: f32, offset: f32) -> DecodedForm {
        DecodedForm { format, scale, offset }
    }

    fn back(texels: &[u8], channels: u32, form: DecodedForm) -> Vec<f32> {
        let mut out = Vec::new();
        values(texels, channels, form, &mut out);
        out
    }

    #[test]
    fn every_integer_meets_its_own_texel() {
        let bytes: Vec<u8> = (0..=255).collect();
        for offset in [0.0, -128.0] {
            let values: Vec<f32> = bytes.iter().map(|&b| f32::from(b) + offset).collect();
            let form = form(TexelFormat::Unorm8, 255.0, offset);
            assert_eq!(texels(&values, 1, form), bytes);
            assert_eq!(back(&bytes, 1, form), values);
        }
        let words: Vec<u8> = (0..=u16::MAX).flat_map(u16::to_le_bytes).collect();
        for offset in [0.0, -32768.0] {
            let values: Vec<f32> = (0..=u16::MAX).map(|w| f32::from(w) + offset).collect();
            let form = form(TexelFormat::Unorm16, 65535.0, offset);
            assert_eq!(texels(&values, 1, form), words);
            assert_eq!(back(&words, 1, form), values);
        }
    }

    #[test]
    fn what_lies_beyond_the_range_is_clamped() {
        let got = texels(&[-1.0, 0.0, 127.6, 255.0, 999.0], 1, form(TexelFormat::Unorm8, 255.0, 0.0));
        assert_eq!(got, [0, 0, 128, 255, 255]);
    }

    #[test]
    fn colours_are_padded_to_four_channels() {
        let got = texels(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 3, form(TexelFormat::Unorm8, 255.0, 0.0));
        assert_eq!(got, [1, 2, 3, 0, 4, 5, 6, 0]);
        assert_eq!(back(&got, 3, form(TexelFormat::Unorm8, 255.0, 0.0)), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    }

    #[test]
    fn floats_keep_their_bits() {
        let values = [0.1_f32, -1.5e30, f32::MIN_POSITIVE, 16_777_216.0];
        let got = texels(&values, 1, DecodedForm::FLOAT32);
        assert_eq!(got, values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>());
        let halves = [0.5_f32, -65504.0, 1.0 / 1024.0];
        let got = texels(&halves, 1, form(TexelFormat::Float16, 1.0, 0.0));
        assert_eq!(got, halves.iter().flat_map(|&v| f16::from_f32(v).to_le_bytes()).collect::<Vec<_>>());
    }
}
