//! Blocks are written to a texture and read back as the texture unit decodes them.

use std::borrow::Cow;

use cvr_core::shader::BindingLimits;
use cvr_core::volume::{SampleType, ValueRange};

use super::*;
use crate::testing::{lacking, test_device};

/// A device that supports blocks. Else a line says that this one does not.
fn capable(name: &str) -> Option<&'static Device> {
    let device = test_device(name)?;
    let takes = device.capabilities().blocks(BlockFormat::Bc4, 1);
    if let Err(reason) = takes {
        lacking(name, &reason);
    }
    takes.is_ok().then_some(device)
}

fn layout(size: [u32; 3], channels: u32) -> VolumeLayout {
    let extent = Extent::try_from(size).unwrap();
    VolumeLayout { channels, ..VolumeLayout::scalar(extent, SampleType::U8) }
}

/// Blocks with equal endpoints: all voxels of a block have ten times its number.
fn constant_blocks(layout: &VolumeLayout) -> Vec<u32> {
    let blocks = BlockFormat::Bc4.bytes(layout.extent) / 8;
    (0..blocks as u32).flat_map(|block| [block % 25 * 10 * 0x101, 0]).collect()
}

fn texture(words: &[u32]) -> BlockTexture<'_> {
    BlockTexture { format: BlockFormat::Bc4, words: Cow::Borrowed(words), scale: 510.0, offset: -4.0 }
}

#[test]
fn every_voxel_comes_from_its_block() {
    let Some(device) = capable("block_texture::constant_blocks") else { return };
    for size in [[13, 17, 23], [16, 8, 5], [1, 1, 1], [70, 3, 2]] {
        let layout = layout(size, 1);
        let words = constant_blocks(&layout);
        let volume = VolumeTexture::upload_blocks(device, &layout, &texture(&words)).unwrap();
        assert_eq!((volume.bytes(), volume.blocks()), (words.len() as u64 * 4, Some(BlockFormat::Bc4)));
        let [x, y, _] = size.map(|n| n as usize);
        let (columns, rows) = (x.div_ceil(4), y.div_ceil(4));
        let wanted = |i: usize| {
            let block = (i / (x * y) * rows + i / x % y / 4) * columns + i % x / 4;
            (block % 25 * 10) as f32 * 2.0 - 4.0
        };
        // Also in chunks of one row.
        let small = device.with_binding_limits(BindingLimits { storage_words: 128, storage_buffers: 8 });
        for device in [device, &small] {
            let read = volume.read(device).unwrap();
            assert_eq!(read.len() as u64, layout.voxels());
            for (i, found) in read.into_iter().enumerate() {
                assert!((found - wanted(i)).abs() < 1e-3, "{size:?}, {i}: {found} for {}", wanted(i));
            }
        }
    }
}

/// All levels of all pairs of endpoints, each within the texture unit's tolerance. Prints the largest differences.
#[test]
fn levels_are_within_the_tolerance() {
    let Some(device) = capable("block_texture::levels") else { return };
    let ends: Vec<[u32; 2]> = (0..65536_u32).map(|i| [i & 255, i >> 8]).collect();
    // The indices 0 to 7 twice.
    let indices = (0..16_u64).map(|i| (i % 8) << (3 * i)).sum::<u64>() << 16;
    let words: Vec<u32> =
        ends.iter().flat_map(|[a, b]| [a | b << 8 | indices as u32, (indices >> 32) as u32]).collect();
    let layout = layout([1024, 1024, 1], 1);
    let blocks = BlockTexture { scale: 255.0, offset: 0.0, ..texture(&words) };
    let read = VolumeTexture::upload_blocks(device, &layout, &blocks).unwrap().read(device).unwrap();
    let agreement = blocks.agreement();
    let (mut worst, mut at_ends) = ([0.0_f64; 2], 0.0_f64);
    for (i, found) in read.into_iter().enumerate() {
        let (x, y) = (i % 1024, i / 1024);
        let [a, b] = ends[y / 4 * 256 + x / 4].map(f64::from);
        let index = (y % 4 * 4 + x % 4) % 8;
        let share = |whole: f64| a + (b - a) * (index as f64 - 1.0) / whole;
        let exact = match index {
            0 => a,
            1 => b,
            _ if a > b => share(7.0),
            6 => 0.0,
            7 => 255.0,
            _ => share(5.0),
        };
        let error = (f64::from(found) - exact).abs();
        let between = ValueRange { min: a.min(b) as f32, max: a.max(b) as f32 };
        assert!(
            agreement.allows(exact as f32, found, Some(between)),
            "{index} of {a}, {b}: {found}, {exact}"
        );
        let of_mode = &mut worst[usize::from(a > b)];
        *of_mode = of_mode.max(error);
        if index < 2 || a <= b && index > 5 {
            at_ends = at_ends.max(error);
        }
    }
    let [fifths, sevenths] = worst;
    println!(
        "{}: of 255, fifths are off by {fifths:.6} at most, sevenths by {sevenths:.6}, endpoints by {at_ends:.6}",
        device.info()
    );
    assert!(at_ends < 0.001, "{at_ends}");
}

#[test]
fn what_is_no_such_frame_is_an_error() {
    let Some(device) = capable("block_texture::misfits") else { return };
    let words = constant_blocks(&layout([8, 8, 2], 1));
    let refused = |layout: &VolumeLayout, words: &[u32]| {
        VolumeTexture::upload_blocks(device, layout, &texture(words)).unwrap_err().to_string()
    };
    assert_eq!(refused(&layout([8, 8, 2], 1), &words[2..]), "56 bytes of blocks for a frame of 64");
    assert!(refused(&layout([8, 8, 2], 3), &words).contains("three channels"));
    let edge = device.capabilities().texture_edge_voxels + 1;
    let long = refused(&layout([edge, 1, 1], 1), &words);
    assert!(long.contains("voxels along one axis"), "{long}");
}
