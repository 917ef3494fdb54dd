//! Colour volumes: opacity of a colour, and conversion of its numbers to light.

use std::sync::Arc;

use glam::Vec3;

use crate::volume::{SampleType, ValueRange};

/// The origin of a voxel's opacity in a volume with three channels. Scalar volumes ignore it.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum ColourOpacity {
    /// The transfer function of the luminance. The function's colours tint the voxel's own.
    #[default]
    Luminance,
    /// The transfer function of one channel: 0 red, 1 green, 2 blue.
    Channel(usize),
    /// A table over all colours (Parys and Knittel 2009). The transfer function is not used.
    Table(Arc<OpacityTable>),
}

/// Opacities per voxel length over the cube of all colours. Trilinear between entries.
#[derive(Clone, Debug, PartialEq)]
pub struct OpacityTable {
    edge: u32,
    /// The edge as a number, then the entries, red fastest: what the shader binds.
    numbers: Vec<f32>,
}

/// Why numbers make no opacity table.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum OpacityTableError {
    /// An axis has too few or too many entries, or the axes differ in length.
    #[error(
        "an opacity table is a cube of {least} to {most} entries along each of red, green and blue; this has {found:?}",
        least = OpacityTable::EDGES.start(), most = OpacityTable::EDGES.end()
    )]
    Shape {
        /// Entries along each axis.
        found: Vec<usize>,
    },
    /// An entry is not a valid opacity.
    #[error("entry {index} of the opacity table is {value}: opacities run from 0 to 1")]
    Entry {
        /// Its index, red fastest.
        index: usize,
        /// The entry.
        value: f32,
    },
}

impl OpacityTable {
    /// Entries along an axis.
    pub const EDGES: std::ops::RangeInclusive<u32> = 2..=64;

    /// A table of `edge`³ entries, red fastest.
    ///
    /// # Errors
    /// When the edge is out of range, the entries are not so many, or one is no opacity.
    pub fn new(edge: u32, entries: &[f32]) -> Result<Self, OpacityTableError> {
        if !Self::EDGES.contains(&edge) || entries.len() as u64 != u64::from(edge).pow(3) {
            return Err(OpacityTableError::Shape { found: vec![edge as usize; 3] });
        }
        if let Some(index) = entries.iter().position(|entry| !(0.0..=1.0).contains(entry)) {
            return Err(OpacityTableError::Entry { index, value: entries[index] });
        }
        let numbers = std::iter::once(edge as f32).chain(entries.iter().copied()).collect();
        Ok(Self { edge, numbers })
    }

    /// The buffer for the shader: the edge as a number, then the entries, red fastest.
    #[must_use]
    pub fn numbers(&self) -> &[f32] {
        &self.numbers
    }

    /// Opacity of a colour with channels in `0.0..=1.0`, with the arithmetic of `shaders/classify/colour_table.wgsl`.
    #[must_use]
    pub fn opacity(&self, light: Vec3) -> f32 {
        let at = light * (self.edge - 1) as f32;
        let low = at.floor().min(Vec3::splat((self.edge - 2) as f32));
        let t = at - low;
        let p = low.as_uvec3();
        let row = |y: u32, z: u32| {
            let i = (((p.z + z) * self.edge + p.y + y) * self.edge + p.x + 1) as usize;
            self.numbers[i] + (self.numbers[i + 1] - self.numbers[i]) * t.x
        };
        let (c00, c10, c01, c11) = (row(0, 0), row(1, 0), row(0, 1), row(1, 1));
        let c0 = c00 + (c10 - c00) * t.y;
        let c1 = c01 + (c11 - c01) * t.y;
        c0 + (c1 - c0) * t.z
    }
}

impl ColourOpacity {
    /// Names in a configuration, with their meanings.
    pub const NAMED: [(&str, &str, Self); 4] = [
        (
            "luminance",
            "the transfer function of the luminance; its colours tint the voxel's own",
            Self::Luminance,
        ),
        ("red", "the transfer function of red", Self::Channel(0)),
        ("green", "the transfer function of green", Self::Channel(1)),
        ("blue", "the transfer function of blue", Self::Channel(2)),
    ];

    /// Weights of the channels in the number that the transfer function maps and whose gradient is the normal. For the
    /// luminance these are the weights of ITU-R BT.709.
    #[must_use]
    pub fn weights(&self) -> Vec3 {
        match self {
            Self::Luminance | Self::Table(_) => Vec3::new(0.2126, 0.7152, 0.0722),
            Self::Channel(channel) => Vec3::AXES[*channel % 3],
        }
    }
}

/// The values of black and white: the type's range for integers, the range of the volume's values for floats.
#[must_use]
pub fn light_range(sample: SampleType, values: ValueRange) -> ValueRange {
    match sample.integer_range() {
        Some((low, high)) => ValueRange { min: low as f32, max: high as f32 },
        None => values,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_interpolates_between_its_entries() {
        let entries: Vec<f32> = (0..27).map(|i| (i % 3) as f32 / 2.0).collect();
        let table = OpacityTable::new(3, &entries).unwrap();
        for red in [0.0, 0.2, 0.5, 0.9, 1.0] {
            assert!((table.opacity(Vec3::new(red, 0.3, 1.0)) - red).abs() < 1e-6);
        }
    }

    #[test]
    fn what_is_no_table_is_refused_with_its_numbers() {
        let shape = OpacityTable::new(1, &[0.5]).unwrap_err().to_string();
        assert!(shape.contains("2 to 64") && shape.contains("[1, 1, 1]"), "{shape}");
        let entry = OpacityTable::new(2, &[0.0, 0.1, 1.5, 0.0, 0.0, 0.0, 0.0, 0.0]).unwrap_err().to_string();
        assert!(entry.contains("entry 2") && entry.contains("1.5"), "{entry}");
        assert!(OpacityTable::new(2, &[f32::NAN; 8]).is_err());
    }
}
