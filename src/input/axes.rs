//! The order of a file's axes, and how samples are reordered.

use cvr_core::volume::{BrickSource as _, DenseVolume, Samples, VolumeLayout};

use super::{InputError, InputVolume, Place};

/// What runs along an axis. The order is that of samples in memory, fastest first.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Axis {
    Channel,
    X,
    Y,
    Z,
    Frame,
}

impl Axis {
    const ALL: [Self; 5] = [Self::Channel, Self::X, Self::Y, Self::Z, Self::Frame];

    /// Elements along it, and the distance between two of them in memory.
    fn of(self, layout: &VolumeLayout) -> (usize, usize) {
        let [x, y, z] = layout.extent.to_array();
        let sizes = [layout.channels, x, y, z, layout.frames].map(|n| n as usize);
        let at = self as usize;
        (sizes[at], sizes[..at].iter().product())
    }
}

/// Brings samples whose axes run as `stored`, fastest first, into the order of memory. Axes that are not named have
/// one element.
///
/// # Errors
/// Without memory for a second copy.
pub(super) fn rearranged(
    mut input: InputVolume,
    stored: &[Axis],
    place: &Place,
) -> Result<InputVolume, InputError> {
    let layout = input.volume.layout().clone();
    let more: Vec<Axis> = stored.iter().copied().filter(|a| a.of(&layout).0 > 1).collect();
    if more.is_sorted() {
        return Ok(input);
    }
    let rest = Axis::ALL.into_iter().filter(|a| !more.contains(a));
    let mut axes = [(1, 0); 5];
    for (axis, of) in axes.iter_mut().zip(more.iter().copied().chain(rest)) {
        *axis = of.of(&layout);
    }
    let memory = || InputError::Memory { place: place.clone(), bytes: layout.bytes() };
    cvr_core::memory::check(layout.bytes(), String::new).map_err(|_| memory())?;
    let samples = match input.volume.samples() {
        Samples::U8(v) => Samples::U8(moved(v, axes).ok_or_else(memory)?),
        Samples::I8(v) => Samples::I8(moved(v, axes).ok_or_else(memory)?),
        Samples::U16(v) => Samples::U16(moved(v, axes).ok_or_else(memory)?),
        Samples::I16(v) => Samples::I16(moved(v, axes).ok_or_else(memory)?),
        Samples::F32(v) => Samples::F32(moved(v, axes).ok_or_else(memory)?),
        _ => return Err(memory()),
    };
    input.volume = DenseVolume::new(layout.clone(), samples).map_err(|problem| InputError::Data {
        place: place.clone(),
        problem,
        remedy: "this is a fault of the reader".to_owned(),
    })?;
    Ok(input)
}

/// Samples in the order of the axes, fastest first, each to its place; `None` without memory.
fn moved<T: Copy>(from: &[T], axes: [(usize, usize); 5]) -> Option<Vec<T>> {
    let mut to = Vec::new();
    to.try_reserve_exact(from.len()).ok()?;
    to.extend_from_slice(from);
    let [(na, sa), (nb, sb), (nc, sc), (nd, sd), (ne, se)] = axes;
    let mut source = from.iter();
    for e in 0..ne {
        for d in 0..nd {
            for c in 0..nc {
                for b in 0..nb {
                    let base = e * se + d * sd + c * sc + b * sb;
                    for (a, v) in (0..na).zip(source.by_ref().take(na)) {
                        to[base + a * sa] = *v;
                    }
                }
            }
        }
    }
    Some(to)
}

#[cfg(test)]
mod tests {
    use super::*;
    use cvr_core::volume::{Extent, SampleType};

    #[test]
    fn every_order_comes_back_to_that_of_memory() {
        let extent = Extent::new(2, 3, 4).unwrap();
        let layout = VolumeLayout { channels: 3, frames: 2, ..VolumeLayout::scalar(extent, SampleType::U8) };
        let n = layout.samples() as usize;
        let ours = DenseVolume::new(layout.clone(), Samples::U8((0..n as u8).collect())).unwrap();
        for stored in [
            [Axis::Frame, Axis::Z, Axis::Y, Axis::X, Axis::Channel],
            [Axis::X, Axis::Y, Axis::Z, Axis::Frame, Axis::Channel],
            [Axis::Z, Axis::Channel, Axis::Frame, Axis::X, Axis::Y],
            Axis::ALL,
        ] {
            // Built from coordinates, not by the code under test.
            let sizes = stored.map(|a| a.of(&layout).0);
            let theirs: Vec<u8> = (0..n)
                .map(|i| {
                    let mut rest = i;
                    let place = stored.iter().zip(sizes).map(|(axis, size)| {
                        let at = rest % size;
                        rest /= size;
                        at * axis.of(&layout).1
                    });
                    place.sum::<usize>() as u8
                })
                .collect();
            let read = DenseVolume::new(layout.clone(), Samples::U8(theirs)).unwrap();
            let place = Place::Part { file: "x".into(), part: String::new() };
            let back = rearranged(InputVolume::exact(read), &stored, &place).unwrap();
            assert_eq!(back.volume, ours, "{stored:?}");
        }
    }
}
