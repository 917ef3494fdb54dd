//! Orthonormal transforms of a block, and the zone of each coefficient.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::encode::tuned::codebooks::BASIS_BLOCKS;
use crate::stream::geometry::{EDGE, VOXELS};

/// Which transform.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Transform {
    /// One 4×4 basis per axis, from the data.
    Klt,
    /// Discrete cosines.
    Dct,
    /// Walsh and Hadamard.
    Wht,
    /// Haar.
    Haar,
    /// One 64×64 basis, from the data.
    KltFull,
}

impl Transform {
    /// Names in settings, in the order of the variants.
    pub const NAMES: &'static [&'static str] = &["klt", "dct", "wht", "haar", "klt-full"];

    /// By its name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let all = [Self::Klt, Self::Dct, Self::Wht, Self::Haar, Self::KltFull];
        Self::NAMES.iter().position(|n| *n == name).map(|i| all[i])
    }
}

/// Number of octants of the cube of coefficients. Bit `a` of a zone's number is set if axis `a` is high.
pub const ZONES: usize = 8;

const N: usize = EDGE as usize;

/// An orthonormal basis of blocks. The first vector is constant. Its coefficient is the mean, which is coded
/// separately.
#[derive(Clone, Debug)]
pub struct Basis {
    /// Basis vectors, 64 values each.
    rows: Vec<f64>,
    /// Zone of each coefficient.
    zones: [usize; VOXELS],
}

impl Basis {
    /// The basis of a transform. Data-dependent bases are computed from `blocks`, 64 values each.
    #[must_use]
    pub fn new(transform: Transform, blocks: &[f32]) -> Self {
        match transform {
            Transform::Klt => {
                Self::separable([0, 1, 2].map(|axis| eigenvectors(&line_covariance(blocks, axis))))
            }
            Transform::Dct => Self::separable([(); 3].map(|()| dct())),
            Transform::Wht => Self::separable([(); 3].map(|()| scaled(&WALSH))),
            Transform::Haar => Self::separable([(); 3].map(|()| scaled(&HAAR))),
            Transform::KltFull => Self::full(&eigenvectors(&block_covariance(blocks))),
        }
    }

    /// The product of three bases of lines. Coefficient `i + 4·j + 16·k` belongs to the vectors `i`, `j`, `k` along x,
    /// y, z. Vectors 2 and 3 are high.
    fn separable(axes: [Vec<f64>; 3]) -> Self {
        let place = |i: usize| [i % N, i / N % N, i / N / N];
        let value = |coefficient: usize, voxel: usize| -> f64 {
            let (c, v) = (place(coefficient), place(voxel));
            (0..3).map(|a| axes[a][c[a] * N + v[a]]).product()
        };
        let rows = (0..VOXELS * VOXELS).map(|i| value(i / VOXELS, i % VOXELS)).collect();
        let zone = |i: usize| (0..3).map(|a| usize::from(place(i)[a] >= N / 2) << a).sum();
        Self { rows, zones: std::array::from_fn(zone) }
    }

    /// Zones by rank: 8 coefficients each, largest variance first, in the order LLL, one high axis, two, three.
    fn full(vectors: &[f64]) -> Self {
        const ORDER: [usize; ZONES] = [0, 1, 2, 4, 3, 5, 6, 7];
        Self { rows: vectors.to_vec(), zones: std::array::from_fn(|i| ORDER[i / ZONES]) }
    }

    /// Zone of coefficient `i`.
    #[must_use]
    pub const fn zone(&self, i: usize) -> usize {
        self.zones[i]
    }

    /// The coefficients of a block.
    #[must_use]
    pub fn forward(&self, block: &[f32]) -> [f64; VOXELS] {
        let dot = |row: &[f64]| row.iter().zip(block).map(|(b, v)| b * f64::from(*v)).sum();
        std::array::from_fn(|i| dot(&self.rows[i * VOXELS..(i + 1) * VOXELS]))
    }

    /// The block with these coefficients.
    #[must_use]
    pub fn inverse(&self, coefficients: &[f64; VOXELS]) -> [f32; VOXELS] {
        let mut block = [0.0_f64; VOXELS];
        for (row, c) in self.rows.chunks_exact(VOXELS).zip(coefficients).filter(|(_, c)| **c != 0.0) {
            block.iter_mut().zip(row).for_each(|(v, b)| *v += b * c);
        }
        block.map(|v| v as f32)
    }
}

const WALSH: [[f64; N]; N] =
    [[1.0, 1.0, 1.0, 1.0], [1.0, 1.0, -1.0, -1.0], [1.0, -1.0, -1.0, 1.0], [1.0, -1.0, 1.0, -1.0]];
const HAAR: [[f64; N]; N] =
    [[1.0, 1.0, 1.0, 1.0], [1.0, 1.0, -1.0, -1.0], [1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]];

fn scaled(vectors: &[[f64; N]; N]) -> Vec<f64> {
    let unit = |v: &[f64; N]| {
        let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v.map(|x| x / norm)
    };
    vectors.iter().flat_map(unit).collect()
}

fn dct() -> Vec<f64> {
    let value = |k: usize, n: usize| {
        let scale = if k == 0 { (1.0 / N as f64).sqrt() } else { (2.0 / N as f64).sqrt() };
        scale * (std::f64::consts::PI * (n as f64 + 0.5) * k as f64 / N as f64).cos()
    };
    (0..N * N).map(|i| value(i / N, i % N)).collect()
}

/// Mean product of the values of a line along an axis, less the line's mean.
fn line_covariance(blocks: &[f32], axis: usize) -> DMatrix<f64> {
    let stride = N.pow(axis as u32);
    let mut sums = DMatrix::zeros(N, N);
    for block in blocks.chunks_exact(VOXELS) {
        for first in (0..VOXELS).filter(|i| (i / stride).is_multiple_of(N)) {
            let line: [f64; N] = std::array::from_fn(|i| f64::from(block[first + i * stride]));
            add_products(&mut sums, &line);
        }
    }
    sums
}

fn block_covariance(blocks: &[f32]) -> DMatrix<f64> {
    // Enough blocks for reliable estimates of 64 × 64 products.
    let mut sums = DMatrix::zeros(VOXELS, VOXELS);
    let every = (blocks.len() / VOXELS).div_ceil(BASIS_BLOCKS).max(1);
    for block in blocks.chunks_exact(VOXELS).step_by(every) {
        let block: Vec<f64> = block.iter().map(|v| f64::from(*v)).collect();
        add_products(&mut sums, &block);
    }
    sums
}

fn add_products(sums: &mut DMatrix<f64>, values: &[f64]) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    for (i, a) in values.iter().enumerate() {
        for (j, b) in values.iter().enumerate() {
            sums[(i, j)] += (a - mean) * (b - mean);
        }
    }
}

/// The constant vector, then the eigenvectors orthogonal to it, largest eigenvalue first.
fn eigenvectors(covariance: &DMatrix<f64>) -> Vec<f64> {
    let n = covariance.nrows();
    // The constant vector has eigenvalue 0 and would mix with others of that eigenvalue.
    let trace = covariance.trace().max(f64::MIN_POSITIVE);
    let lifted = covariance / trace + DMatrix::from_element(n, n, 4.0 / n as f64);
    let eigen = SymmetricEigen::new(lifted);
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]).then(a.cmp(b)));
    order[1..].iter().fold(vec![1.0 / (n as f64).sqrt(); n], |mut rows, k| {
        rows.extend(eigen.eigenvectors.column(*k).iter());
        rows
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blocks() -> Vec<f32> {
        let value =
            |i: usize| ((i as u32 / 3).wrapping_mul(0x9e37_79b9) >> 20) as f32 + (i % 64) as f32 * 50.0;
        (0..VOXELS * 200).map(value).collect()
    }

    #[test]
    fn every_basis_is_orthonormal_and_begins_with_the_mean() {
        for name in Transform::NAMES {
            let blocks = blocks();
            let basis = Basis::new(Transform::named(name).unwrap(), &blocks);
            let c = basis.forward(&blocks[..VOXELS]);
            let mean = blocks[..VOXELS].iter().map(|v| f64::from(*v)).sum::<f64>() / 64.0;
            assert!((c[0] - 8.0 * mean).abs() < 1e-6 * mean, "{name}: {} for {mean}", c[0]);
            let back = basis.inverse(&c);
            let worst = back.iter().zip(&blocks).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(worst < 0.01, "{name}: {worst}");
            let count = |zone| (0..VOXELS).filter(|i| basis.zone(*i) == zone).count();
            assert_eq!([0, 1, 2, 3, 4, 5, 6, 7].map(count), [8; 8], "{name}");
        }
    }

    #[test]
    fn data_without_variance_have_a_basis() {
        for name in ["klt", "klt-full"] {
            let basis = Basis::new(Transform::named(name).unwrap(), &[7.0; VOXELS * 2]);
            assert!(basis.forward(&[7.0; VOXELS])[1..].iter().all(|c| c.abs() < 1e-4));
        }
    }
}
