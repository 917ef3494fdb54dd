//! Every value goes through a texture of every format and is read back.

use cvr_core::shader::{Binding, BindingKind, Form, GeneratedShader};
use cvr_core::volume::{Extent, SampleType};

use super::*;
use crate::bindings::Supplies;
use crate::testing::test_device;
use crate::{Capabilities, TextureFallback};

/// Loads every texel and undoes scale and offset, as generated shaders do.
fn load_all(device: &Device, volume: &VolumeTexture) -> Vec<f32> {
    let DecodedForm { scale, offset, .. } = volume.choice().form;
    let (channels, extent) = (volume.layout().channels, volume.layout().extent);
    let ([x, y, _], voxels) = (extent.to_array(), extent.voxels());
    let wgsl = format!(
        "@group(0) @binding(0) var<storage, read_write> dump: array<f32>;
         @group(1) @binding(0) var volume: texture_3d<f32>;
         @compute @workgroup_size(64)
         fn load(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {{
             let i = id.x + id.y * groups.x * 64u;
             if i >= {voxels}u {{ return; }}
             let p = vec3<u32>(i % {x}u, i / {x}u % {y}u, i / ({x}u * {y}u));
             let value = f32({offset:?}) + f32({scale:?}) * textureLoad(volume, p, 0);
             for (var c = 0u; c < {channels}u; c++) {{ dump[i * {channels}u + c] = value[c]; }}
         }}"
    );
    let filterable = volume.choice().sampling == TextureSampling::Hardware;
    let shader = GeneratedShader {
        wgsl,
        segments: Vec::new(),
        bindings: vec![
            Binding {
                group: 0,
                binding: 0,
                kind: BindingKind::Storage { name: "dump_values", written: true },
            },
            Binding { group: 1, binding: 0, kind: BindingKind::VolumeTexture { filterable } },
        ],
        entry: "load".to_owned(),
        form: Form::Unrolled,
        inlined_operations: 0,
    };
    let supplies = Supplies { texture: Some(volume), ..Supplies::default() };
    device.run_dump(&shader, supplies, extent, channels).unwrap()
}

fn layout(extent: [u32; 3], channels: u32) -> VolumeLayout {
    let extent = Extent::try_from(extent).unwrap();
    VolumeLayout { channels, ..VolumeLayout::scalar(extent, SampleType::F32) }
}

/// Integers must be equal after rounding, and within one unit in the last place before. The texel k/65535 is itself
/// rounded, and a device may add the same error when it applies the scale.
fn assert_integers(got: &[f32], want: &[f32], steps: f32) {
    for (got, want) in got.iter().zip(want) {
        assert!(got.round() == *want && (got - want).abs() <= steps * f32::EPSILON, "{got} for {want}");
    }
}

#[test]
fn every_integer_of_8_and_16_bits_survives() {
    let Some(device) = test_device("texture::integers") else { return };
    let forms = [(TexelFormat::Unorm8, 255.0, [16, 4, 4]), (TexelFormat::Unorm16, 65535.0, [128, 64, 8])];
    for (format, scale, extent) in forms {
        for offset in [0.0, -(scale + 1.0) / 2.0] {
            let layout = layout(extent, 1);
            let values: Vec<f32> = (0..layout.samples_per_frame()).map(|i| i as f32 + offset).collect();
            let form = DecodedForm { format, scale, offset };
            let volume = VolumeTexture::upload(device, &layout, &values, form).unwrap();
            assert_integers(&load_all(device, &volume), &values, scale + 1.0);
            if volume.choice().fallback.is_none() {
                assert_eq!(volume.bytes(), layout.samples_per_frame() * format.bytes() as u64);
            }
        }
    }
}

#[test]
fn floats_come_back_bit_for_bit() {
    let Some(device) = test_device("texture::floats") else { return };
    let layout = layout([5, 3, 7], 1);
    let values: Vec<f32> = (0..105).map(|i| (i as f32 - 50.0) * 1.0e7 / 3.0).collect();
    let volume = VolumeTexture::upload(device, &layout, &values, DecodedForm::FLOAT32).unwrap();
    assert_eq!(load_all(device, &volume), values);
    let halves: Vec<f32> = (0..105).map(|i| (i as f32 - 50.0) / 8.0).collect();
    let form = DecodedForm { format: TexelFormat::Float16, scale: 1.0, offset: 0.0 };
    let volume = VolumeTexture::upload(device, &layout, &halves, form).unwrap();
    assert_eq!(load_all(device, &volume), halves);
    assert_eq!(volume.bytes(), 210);
}

#[test]
fn colours_keep_their_order() {
    let Some(device) = test_device("texture::colours") else { return };
    let layout = layout([3, 5, 2], 3);
    let values: Vec<f32> = (0..90).map(|i| i as f32).collect();
    for form in [DecodedForm { format: TexelFormat::Unorm8, scale: 255.0, offset: 0.0 }, DecodedForm::FLOAT32]
    {
        let volume = VolumeTexture::upload(device, &layout, &values, form).unwrap();
        assert_integers(&load_all(device, &volume), &values, 256.0);
        assert_eq!(volume.bytes(), 30 * 4 * form.format.bytes() as u64);
    }
}

#[test]
fn fallbacks_lose_no_bits() {
    let Some(device) = test_device("texture::fallbacks") else { return };
    let layout = layout([128, 64, 8], 1);
    let values: Vec<f32> = (0..65536).map(|i| i as f32 - 32768.0).collect();
    let form = DecodedForm { format: TexelFormat::Unorm16, scale: 65535.0, offset: -32768.0 };
    let choice = Capabilities::LEAST.texture(form, layout.extent).unwrap();
    assert_eq!(choice.fallback, Some(TextureFallback::ManualFloat32ForUnorm16));
    let volume = VolumeTexture::upload_as(device, &layout, &values, choice).unwrap();
    assert_eq!(load_all(device, &volume), values);
}

#[test]
fn large_volumes_go_up_in_slabs() {
    let Some(device) = test_device("texture::slabs") else { return };
    // 40 MiB: two slabs, the second one cut.
    let layout = layout([512, 512, 40], 1);
    assert!(layout.samples_per_frame() as usize * 4 > SLAB_BYTES);
    let values: Vec<f32> = (0..layout.samples_per_frame()).map(|i| i as f32).collect();
    let volume = VolumeTexture::upload(device, &layout, &values, DecodedForm::FLOAT32).unwrap();
    assert!(load_all(device, &volume) == values);
}

#[test]
fn what_does_not_fit_is_an_error() {
    let Some(device) = test_device("texture::misfits") else { return };
    let upload = |layout: &VolumeLayout, values: &[f32]| {
        VolumeTexture::upload(device, layout, values, DecodedForm::FLOAT32).unwrap_err()
    };
    assert!(matches!(upload(&layout([4, 4, 4], 1), &[0.0; 63]), EngineError::Unsupported(_)));
    let edge = device.capabilities().texture_edge_voxels + 1;
    let long = upload(&layout([edge, 1, 1], 1), &vec![0.0; edge as usize]);
    assert!(matches!(long, EngineError::TooLarge { .. }), "{long}");
}
