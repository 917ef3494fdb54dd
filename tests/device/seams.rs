//! Seams between sub-volumes with their own codebooks, in pictures that are filtered across them.

use cvr_core::codec::Decoder;
use cvr_core::render::{Camera, Filter, Image, Projection, View};
use cvr_core::volume::{FiniteVolume, SampleType};
use cvr_engine::Device;
use cvr_engine::testing::test_device;

use super::scenes::{camera, draw, inline, view};
use super::subjects::{codec, decoded, encoded, settings, volume};

/// Two sub-volumes side by side along x.
const EXTENT: [u32; 3] = [176, 40, 16];
const SEAM: u32 = 128;
/// Voxels along an edge of a block.
const BLOCK: u32 = 4;

/// Along z, without perspective: x from left to right.
fn seen() -> View {
    let camera = Camera { zoom: 3.4, ..camera(0.0, 90.0, Projection::Orthographic) };
    View { camera, ..view(SampleType::U8, [600, 120], Filter::Linear) }
}

/// A codec's id and a decoder of it.
type Subject = (&'static str, Box<dyn Decoder>);

fn raw(volume: &FiniteVolume) -> Subject {
    ("raw", encoded(codec("raw").as_ref(), &settings(&[]), volume))
}

fn picture(device: &Device, view: &View, (id, decoder): &Subject) -> Image {
    draw(device, view, &inline(id, decoder.as_ref())).0
}

/// The column of the picture at which the voxels from `x` on begin.
fn column(device: &Device, x: u32) -> usize {
    let behind = volume(EXTENT, [1.0; 3], SampleType::U8, |p| if p[0] < x { 0.0 } else { 255.0 });
    let view = View { filter: Filter::Nearest, ..seen() };
    let image = picture(device, &view, &raw(&behind));
    let width = view.size[0] as usize;
    let lit = image.pixels().iter().position(|p| p[3] > 0.9).unwrap();
    let row = &image.pixels()[lit / width * width..][..width];
    row.iter().position(|p| p[3] > 0.9).unwrap()
}

/// Jump of a picture's error at the seam, averaged over the rows (an eye follows a line), divided by the largest jump
/// at any other block face.
fn standing_out(device: &Device, original: &Subject, coded: &Subject) -> f64 {
    let [from, to] = [32, 160].map(|x| column(device, x) as f64);
    let per_voxel = (to - from) / 128.0;
    assert!(per_voxel >= 2.0, "{per_voxel} columns for a voxel");
    let view = seen();
    let [a, b] = [original, coded].map(|subject| picture(device, &view, subject));
    let width = view.size[0] as usize;
    assert!(a.pixels().iter().filter(|p| p[3] > 0.1).count() > 10_000);
    let rows = || a.pixels().chunks_exact(width).zip(b.pixels().chunks_exact(width));
    // The mean error of a voxel's columns, over red, green and blue.
    let error = |x: f64| {
        let at = from + (x - 32.0) * per_voxel;
        let columns = at.round() as usize..(at + per_voxel).round() as usize;
        let count = (columns.len() * view.size[1] as usize) as f64;
        [0, 1, 2].map(|c| {
            let of_row = |(a, b): (&[[f32; 4]], &[[f32; 4]])| {
                columns.clone().map(|x| f64::from(b[x][c] - a[x][c])).sum::<f64>()
            };
            rows().map(of_row).sum::<f64>() / count
        })
    };
    let jump = |x: u32| {
        let [left, right] = [f64::from(x) - 1.0, f64::from(x)].map(error);
        (0..3).map(|c| (right[c] - left[c]).powi(2)).sum::<f64>().sqrt()
    };
    let faces = (2..EXTENT[0] / BLOCK - 2).map(|i| i * BLOCK).filter(|x| *x != SEAM);
    let most = faces.map(jump).fold(0.0, f64::max);
    assert!(most > 0.0, "no error anywhere");
    jump(SEAM) / most
}

#[test]
fn seams_of_sub_volumes_do_not_stand_out_in_filtered_pictures() {
    let Some(device) = test_device("seams::of_sub_volumes") else { return };
    let original = volume(EXTENT, [1.0; 3], SampleType::U8, |p| {
        let [x, y, z] = p.map(f64::from);
        127.5 + 100.0 * (0.31 * x + 0.2 * z).sin() * (0.23 * y - 0.1 * x).cos() * (0.2 * z + 0.4).sin()
    });
    let whole = raw(&original);
    for payload in ["fixed", "variable"] {
        let pairs = [("payload", payload), ("subvolume", "128"), ("rate", "1")];
        let coded = ("tvq", encoded(codec("tvq").as_ref(), &settings(&pairs), &original));
        // The same values, but higher in one sub-volume.
        let values = decoded(coded.1.as_ref());
        let higher = volume(EXTENT, [1.0; 3], SampleType::U8, |p| {
            let i = (p[2] * EXTENT[1] + p[1]) * EXTENT[0] + p[0];
            let step = if p[0] < SEAM { 0.0 } else { 6.0 };
            (f64::from(values[i as usize]) + step).clamp(0.0, 255.0)
        });
        let twin = raw(&higher);
        let found = standing_out(device, &whole, &coded);
        println!("{payload}: the seam is {found:.3} of the farthest jump between blocks");
        assert!(found <= 1.0, "{payload}: the seam is {found} of the farthest jump between blocks");
        let twin = standing_out(device, &whole, &twin);
        println!("{payload}, one sub-volume higher: {twin:.3}");
        assert!(twin > 1.0, "{payload}: a seam was not found, {twin}");
    }
}
