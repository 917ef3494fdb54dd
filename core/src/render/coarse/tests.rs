use super::*;
use crate::render::{ClipBox, ControlPoint, DecodedFrame, Projection, TransferFunction, View, upsampled};
use crate::volume::SampleType;

fn layout(size: [u32; 3]) -> VolumeLayout {
    let extent = Extent::try_from(size).unwrap();
    VolumeLayout { spacing: [0.5, 1.5, 1.0], ..VolumeLayout::scalar(extent, SampleType::F32) }
}

fn view(projection: Projection) -> View {
    let point = |value| ControlPoint { value, rgba: [1.0; 4] };
    let camera = Camera { projection, roll: 11.0, ..Camera::default() };
    View { camera, ..View::new(TransferFunction::new(vec![point(0.0), point(1.0)]).unwrap()) }
}

/// A ramp that every resolution represents exactly: its values at the voxel centres of a resolution, in voxels of the
/// volume.
fn ramp(volume: &VolumeLayout, resolution: u8, shift: f32) -> DecodedFrame {
    let layout = volume.at_resolution(resolution);
    let scale = Level::scale(resolution) as f32;
    let value = |i| {
        let [x, y, z] = layout.extent.position(i).map(|p| (p as f32 + 0.5 + shift) * scale);
        x + 10.0 * y - 3.0 * z
    };
    let values = (0..layout.samples_per_frame() as usize).map(value).collect();
    DecodedFrame::new(layout, values).unwrap()
}

#[test]
fn rays_of_a_resolution_are_the_volumes_own_in_larger_voxels() {
    for projection in [Projection::Perspective, Projection::Orthographic] {
        let volume = layout([13, 6, 9]);
        let full = view(projection).rays(&volume);
        for resolution in 1..4 {
            let coarse = view(projection).at_resolution(&volume, resolution, 0.0);
            let rays = coarse.rays(&volume.at_resolution(resolution));
            let scale = Level::scale(resolution) as f32;
            assert_eq!(rays.origin * scale, full.origin);
            assert_eq!(rays.direction * scale, full.direction);
            assert_eq!(rays.direction_right * scale, full.direction_right);
            assert_eq!(rays.origin_up * scale, full.origin_up);
            assert_eq!(rays.voxel_size, full.voxel_size * scale);
            assert_eq!((rays.axes(), rays.pixel), (full.axes(), full.pixel));
        }
    }
}

#[test]
fn the_box_is_that_of_the_volume_and_not_of_the_voxels() {
    let volume = layout([13, 6, 8]);
    let coarse = view(Projection::Perspective).at_resolution(&volume, 1, 0.0);
    let extent = volume.extent.at_resolution(1);
    assert_eq!(extent.to_array(), [7, 3, 4]);
    let [low, high] = coarse.bounds(extent);
    assert_eq!((low.to_array(), high.to_array()), ([0.0; 3], [6.5, 3.0, 4.0]));
    assert!(!coarse.draws_whole(extent), "half a voxel sticks out");
    let even = layout([12, 6, 8]);
    let coarse = view(Projection::Perspective).at_resolution(&even, 1, 0.0);
    assert!(coarse.draws_whole(even.extent.at_resolution(1)));
    let clip = ClipBox { low: [0.5, 0.0, 0.0], ..ClipBox::WHOLE };
    let clipped = View { clip: Some(clip), ..coarse };
    assert_eq!(clipped.bounds(even.extent.at_resolution(1))[0].to_array(), [3.0, 0.0, 0.0]);
    assert!(!clipped.draws_whole(even.extent.at_resolution(1)));
    assert_eq!(view(Projection::Perspective).at_resolution(&volume, 0, 0.0), view(Projection::Perspective));
}

/// A shift moves rays and box together, and the box ends with the voxels.
#[test]
fn shifted_voxels_are_drawn_where_they_belong() {
    let volume = layout([12, 8, 16]);
    let [plain, shifted] =
        [0.0, 0.25].map(|shift| view(Projection::Perspective).at_resolution(&volume, 1, shift));
    let coarse = volume.at_resolution(1);
    let [a, b] = [&plain, &shifted].map(|view| view.rays(&coarse));
    assert_eq!((b.origin - a.origin).to_array(), [0.25; 3]);
    assert_eq!(a.direction, b.direction);
    let [low, high] = shifted.bounds(coarse.extent);
    assert_eq!((low.to_array(), high.to_array()), ([0.25; 3], [6.0, 4.0, 8.0]));
    // A ramp sampled a quarter of a voxel of the resolution too early.
    let (full, early) = (ramp(&volume, 0, 0.0), ramp(&volume, 1, -0.25));
    let brought = upsampled(&early, volume.extent, (1, 0.25)).unwrap();
    let inner = |i: usize| {
        let p = volume.extent.position(i);
        (0..3).all(|a| p[a] > 1 && p[a] + 2 < volume.extent.to_array()[a])
    };
    let off = full.values().iter().zip(&brought).enumerate().filter(|(i, _)| inner(*i));
    assert!(off.map(|(_, (a, b))| (a - b).abs()).fold(0.0, f32::max) < 1e-4);
}

/// Between the outermost centres, upsampling restores a ramp. A level that is shifted by half a voxel does not.
#[test]
fn a_ramp_is_brought_back_to_the_volumes_voxels() {
    for (size, resolution) in [([13, 6, 9], 1), ([12, 8, 16], 2), ([5, 3, 7], 1)] {
        let volume = layout(size);
        let (full, scale) = (ramp(&volume, 0, 0.0), Level::scale(resolution) as f32);
        let largest = |shift| {
            let brought =
                upsampled(&ramp(&volume, resolution, shift), volume.extent, (resolution, 0.0)).unwrap();
            let inner = |i: usize| {
                let p = volume.extent.position(i).map(|p| p as f32 + 0.5);
                let e = volume.extent.at_resolution(resolution).to_array();
                (0..3).all(|a| p[a] >= scale / 2.0 && p[a] <= (e[a] as f32 - 0.5) * scale)
            };
            let off = full.values().iter().zip(&brought).enumerate().filter(|(i, _)| inner(*i));
            off.map(|(_, (a, b))| (a - b).abs()).fold(0.0, f32::max)
        };
        assert!(largest(0.0) < 1e-4, "{size:?}: {}", largest(0.0));
        assert!(largest(0.5) > 1.0, "{size:?}: a shift by half a voxel goes unnoticed");
    }
}

#[test]
fn the_full_resolution_is_brought_to_itself() {
    let volume = layout([5, 4, 3]);
    let frame = ramp(&volume, 0, 0.25);
    assert_eq!(upsampled(&frame, volume.extent, (0, 0.0)).unwrap(), frame.values());
}
