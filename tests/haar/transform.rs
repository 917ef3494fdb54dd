//! The integer Haar transform (S-transform) of a box, in three dimensions and several levels, and its inverse.

/// Samples along x, y and z; channels.
pub type Shape = ([u32; 3], u32);

/// The boxes of the levels, the finest first. Each later box holds the sums of the one before.
pub fn boxes(extent: [u32; 3], levels: u32) -> Vec<[u32; 3]> {
    (0..levels).scan(extent, |e, _| Some(std::mem::replace(e, e.map(|n| n.div_ceil(2))))).collect()
}

/// Samples to coefficients.
pub fn forward(samples: &mut [i32], shape: Shape, levels: u32) {
    for of_level in boxes(shape.0, levels) {
        for axis in 0..3 {
            lines(samples, shape, of_level, axis, |line| {
                let half = line.len().div_ceil(2);
                let old = line.to_vec();
                for (k, pair) in old.chunks(2).enumerate() {
                    line[k] = pair[0];
                    if let [a, b] = pair {
                        line[k] = a + ((b - a) >> 1);
                        line[half + k] = b - a;
                    }
                }
            });
        }
    }
}

/// Coefficients to samples.
pub fn inverse(coefficients: &mut [i32], shape: Shape, levels: u32) {
    for of_level in boxes(shape.0, levels).into_iter().rev() {
        for axis in (0..3).rev() {
            lines(coefficients, shape, of_level, axis, |line| {
                let (sums, differences) = line.split_at(line.len().div_ceil(2));
                let (sums, differences) = (sums.to_vec(), differences.to_vec());
                for (k, pair) in line.chunks_mut(2).enumerate() {
                    pair[0] = sums[k];
                    if let [a, b] = pair {
                        // Streams may be damaged. Wrapping gives a wrong value, but no panic.
                        *a = sums[k].wrapping_sub(differences[k] >> 1);
                        *b = a.wrapping_add(differences[k]);
                    }
                }
            });
        }
    }
}

/// The coefficients of a box at the lower corner of a frame.
pub fn low(coefficients: &[i32], (extent, channels): Shape, of: [u32; 3]) -> Vec<i32> {
    let row = |y: u32, z: u32| {
        let first = ((z * extent[1] + y) * extent[0] * channels) as usize;
        &coefficients[first..][..(of[0] * channels) as usize]
    };
    (0..of[2]).flat_map(|z| (0..of[1]).flat_map(move |y| row(y, z).iter().copied())).collect()
}

/// Every line of the box along an axis, for each channel.
fn lines(all: &mut [i32], (extent, channels): Shape, of: [u32; 3], axis: usize, f: impl Fn(&mut [i32])) {
    let [stride_x, stride_y] = [channels as usize, (channels * extent[0]) as usize];
    let strides = [stride_x, stride_y, stride_y * extent[1] as usize];
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut line = vec![0; of[axis] as usize];
    for i in 0..of[u] as usize {
        for j in 0..of[v] as usize {
            for c in 0..channels as usize {
                let first = i * strides[u] + j * strides[v] + c;
                let places = |k: usize| first + k * strides[axis];
                (0..line.len()).for_each(|k| line[k] = all[places(k)]);
                f(&mut line);
                (0..line.len()).for_each(|k| all[places(k)] = line[k]);
            }
        }
    }
}
