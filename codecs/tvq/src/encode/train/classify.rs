//! Classes of blocks, by the zones that they need (section 4.2.1 of the paper).

use super::transform::{Basis, ZONES};
use crate::stream::geometry::VOXELS;
use crate::stream::table::Partition;

/// A class: a name, and the zones that it keeps, one bit each. Bit `z` is octant `z`. Bit `a` of `z` is set if axis `a`
/// is high.
#[derive(Debug)]
pub struct Class {
    /// As in the paper.
    pub name: &'static str,
    /// Zones kept. The class ZERO keeps the mean alone.
    pub zones: u8,
}

const LLL: u8 = 1;
const BAND: u8 = 1 << 1 | 1 << 2 | 1 << 4;

/// All classes, in the order in which they are tried.
pub const CLASSES: [Class; 10] = [
    Class { name: "ZERO", zones: 0 },
    Class { name: "LP", zones: LLL },
    Class { name: "BPx", zones: LLL | 1 << 1 },
    Class { name: "BPy", zones: LLL | 1 << 2 },
    Class { name: "BPz", zones: LLL | 1 << 4 },
    Class { name: "BPxyz", zones: LLL | BAND },
    Class { name: "HPxy", zones: LLL | BAND | 1 << 3 },
    Class { name: "HPxz", zones: LLL | BAND | 1 << 5 },
    Class { name: "HPyz", zones: LLL | BAND | 1 << 6 },
    Class { name: "HPxyz", zones: 0xff },
];

/// The class that keeps everything.
pub const WHOLE: u8 = 9;

/// Zones of a partition.
#[must_use]
pub const fn zones_of(partition: Partition) -> u8 {
    match partition {
        Partition::Low => LLL,
        Partition::Band => BAND,
        Partition::High => !(LLL | BAND),
    }
}

/// Whether blocks of a class have a code in a partition.
#[must_use]
pub const fn keeps(class: u8, partition: Partition) -> bool {
    CLASSES[class as usize].zones & zones_of(partition) != 0
}

/// Energy of a block's coefficients by zone, without the mean.
#[must_use]
pub fn energies(basis: &Basis, block: &[f32]) -> [f64; ZONES] {
    let mut energies = [0.0; ZONES];
    for (i, c) in basis.forward(block).iter().enumerate().skip(1) {
        energies[basis.zone(i)] += c * c;
    }
    energies
}

/// The first class that omits at most `threshold` (root mean square over the block). The transform is orthonormal: the
/// energy of the omitted coefficients *is* the squared error of the block without them.
#[must_use]
pub fn class_of(energies: &[f64; ZONES], threshold: f64) -> u8 {
    let most = threshold * threshold * VOXELS as f64;
    let left_out = |class: &Class| -> f64 {
        (0..ZONES).filter(|z| class.zones >> z & 1 == 0).map(|z| energies[z]).sum()
    };
    CLASSES.iter().position(|class| left_out(class) <= most).map_or(WHOLE, |class| class as u8)
}

/// The part of a block in some zones, without the mean.
#[must_use]
pub fn projected(basis: &Basis, block: &[f32], zones: u8) -> [f32; VOXELS] {
    let mut coefficients = basis.forward(block);
    coefficients[0] = 0.0;
    for (i, c) in coefficients.iter_mut().enumerate() {
        if zones >> basis.zone(i) & 1 == 0 {
            *c = 0.0;
        }
    }
    basis.inverse(&coefficients)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::train::transform::Transform;

    #[test]
    fn zones_add_up_to_partitions_and_classes() {
        assert_eq!(Partition::ALL.map(|p| zones_of(p).count_ones()), [1, 3, 4]);
        assert_eq!(CLASSES.map(|c| c.zones.count_ones()), [0, 1, 2, 2, 2, 4, 5, 5, 5, 8]);
        assert!(!keeps(0, Partition::Low) && keeps(1, Partition::Low) && !keeps(1, Partition::Band));
        assert!(keeps(2, Partition::Band) && !keeps(5, Partition::High) && keeps(6, Partition::High));
    }

    /// Blocks that vary fast along one axis alone, or two.
    #[test]
    fn a_block_goes_to_the_first_class_that_serves() {
        let basis = Basis::new(Transform::Dct, &[]);
        let block = |value: fn([usize; 3]) -> bool| -> Vec<f32> {
            (0..VOXELS).map(|i| if value([i % 4, i / 4 % 4, i / 16]) { 10.0 } else { -10.0 }).collect()
        };
        let class = |b: &[f32], t| CLASSES[class_of(&energies(&basis, b), t) as usize].name;
        assert_eq!(class(&block(|_| true), 0.1), "ZERO");
        assert_eq!(class(&block(|p| p[0] % 2 == 0), 0.1), "BPx");
        assert_eq!(class(&block(|p| p[2] % 2 == 0), 0.1), "BPz");
        assert_eq!(class(&block(|p| (p[0] + p[2]) % 2 == 0), 0.1), "HPxz");
        assert_eq!(class(&block(|p| p.iter().sum::<usize>() % 2 == 0), 0.1), "HPxyz");
        assert_eq!(class(&block(|p| p.iter().sum::<usize>() % 2 == 0), 10.1), "ZERO");
        // A step is low for the most part.
        assert_eq!(class(&block(|p| p[1] < 2), 4.0), "LP");
    }

    /// The error of a class equals the error of the block without the omitted coefficients.
    #[test]
    fn the_error_is_that_of_the_truncated_block() {
        let block: Vec<f32> = (0..64_u32).map(|i| (i.wrapping_mul(0x9e37_79b9) >> 24) as f32).collect();
        let basis = Basis::new(Transform::Klt, &block);
        let mean = block.iter().sum::<f32>() / 64.0;
        let energies = energies(&basis, &block);
        for class in &CLASSES {
            let kept = projected(&basis, &block, class.zones);
            let error: f64 = block.iter().zip(kept).map(|(b, k)| f64::from(b - mean - k).powi(2)).sum();
            let left: f64 = (0..8).filter(|z| class.zones >> z & 1 == 0).map(|z| energies[z]).sum();
            assert!((error - left).abs() < 1e-3 * energies.iter().sum::<f64>(), "{}", class.name);
        }
    }
}
