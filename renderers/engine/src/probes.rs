//! Probes of drivers on known data. A driver that claims a feature and does not implement it raises no error: texels
//! are zero, or slices keep their old values. So a feature counts only after it has worked.

use std::borrow::Cow;

use cvr_core::codec::{BlockFormat, BlockTexture, DecodedForm};
use cvr_core::shader::TextureSampling;
use cvr_core::volume::{Extent, SampleType, ValueRange, VolumeLayout};

use crate::canvas::{Canvas, blend};
use crate::slabs::Slabs;
use crate::{BlockFallback, Capabilities, Device, EngineError, TextureChoice, VolumeTexture};

/// The claimed capabilities that work. Takes some milliseconds on llvmpipe, and a tenth of a second if its shader was
/// never compiled before. A feature that a probe cannot request is missing.
pub(crate) fn of(claimed: &Device) -> Capabilities {
    let mut found = claimed.capabilities().clone();
    if found.bc_sliced_3d.is_ok() && !decodes_blocks(claimed, &blocks()).unwrap_or(false) {
        found.bc_sliced_3d = Err(BlockFallback::NotDecoded);
    }
    found.copies_from_any_slice = copies_slices(claimed, &SLICES).unwrap_or(false);
    found
}

fn layout(size: [u32; 3]) -> Result<VolumeLayout, EngineError> {
    let extent = Extent::try_from(size).map_err(|e| EngineError::Unsupported(e.to_string()))?;
    Ok(VolumeLayout::scalar(extent, SampleType::U8))
}

/// Endpoints of two blocks in each of two slices, in both modes of BC4.
const ENDS: [[u32; 2]; 4] = [[250, 10], [10, 200], [0, 255], [90, 20]];

/// The words of these blocks. Their voxels have the levels 0 to 7 twice.
fn blocks() -> Vec<u32> {
    let indices = (0..16_u64).map(|i| (i % 8) << (3 * i)).sum::<u64>() << 16;
    ENDS.iter().flat_map(|[a, b]| [a | b << 8 | indices as u32, (indices >> 32) as u32]).collect()
}

/// A level of a block, in 255ths.
fn level([a, b]: [u32; 2], index: usize) -> f32 {
    let [a, b, n] = [a as f32, b as f32, index as f32];
    match index {
        0 => a,
        1 => b,
        _ if a > b => a + (b - a) * (n - 1.0) / 7.0,
        6 => 0.0,
        7 => 255.0,
        _ => a + (b - a) * (n - 1.0) / 5.0,
    }
}

/// Whether these words decode to the known blocks, within the texture unit's tolerance.
fn decodes_blocks(device: &Device, words: &[u32]) -> Result<bool, EngineError> {
    let layout = layout([8, 4, 2])?;
    let (format, words) = (BlockFormat::Bc4, Cow::Borrowed(words));
    let blocks = BlockTexture { format, words, scale: 255.0, offset: 0.0 };
    let read = VolumeTexture::upload_blocks(device, &layout, &blocks)?.read(device)?;
    let agreement = blocks.agreement();
    let held = read.iter().enumerate().all(|(i, &found)| {
        let (x, y, z) = (i % 8, i / 8 % 4, i / 32);
        let ends = ENDS[2 * z + x / 4];
        let between = ends.map(|end| end as f32);
        let between = ValueRange { min: between[0].min(between[1]), max: between[0].max(between[1]) };
        agreement.allows(level(ends, (4 * y + x % 4) % 8), found, Some(between))
    });
    Ok(held && read.len() as u64 == layout.voxels())
}

/// One value in each of some slices.
const SLICES: [f32; 5] = [3.0, 1.0, 4.0, 1.5, 9.0];

/// Whether slices of these values are copied correctly, for any number of slices at once.
fn copies_slices(device: &Device, values: &[f32]) -> Result<bool, EngineError> {
    let layout = layout([1, 1, SLICES.len() as u32])?;
    let choice =
        TextureChoice { form: DecodedForm::FLOAT32, sampling: TextureSampling::Manual, fallback: None };
    let texture = VolumeTexture::upload_as(device, &layout, values, choice)?;
    let row_bytes = u64::from(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    for slices in [1, 2, SLICES.len() as u64] {
        let slabs = Slabs::new(layout.extent, texture.texel_bytes(), row_bytes * slices)?;
        if texture.read_slabs(device, slabs)? != SLICES {
            return Ok(false);
        }
    }
    Ok(true)
}

impl Device {
    /// Whether sums can be blended in single precision: the driver claims it, and a probe at the first call succeeded.
    /// If not, half precision is used.
    #[must_use]
    pub fn blends_single(&self) -> bool {
        *self.known_blending().get_or_init(|| {
            self.capabilities().float32_blendable && blends(self, wgpu::TextureFormat::Rgba32Float)
        })
    }
}

/// Two colours over each other.
const COLOURS: &str = "\
struct Corner { @builtin(position) position: vec4<f32>, @location(0) @interpolate(flat) second: u32 }
@vertex
fn corner(@builtin(vertex_index) n: u32, @builtin(instance_index) second: u32) -> Corner {
    let xy = vec2<f32>(f32(n & 1u), f32(n >> 1u)) * 4.0 - 1.0;
    return Corner(vec4<f32>(xy, 0.0, 1.0), second);
}
@fragment
fn colour(corner: Corner) -> @location(0) vec4<f32> {
    let first = vec4<f32>(1.0, 0.5, 0.25, 0.5);
    return select(first, vec4<f32>(0x1p-20, 0x1p-21, 0x1p-21, 0x1p-12), corner.second == 1u);
}
";

/// Whether a picture of this format sums in full single precision. If not, half precision is used.
fn blends(device: &Device, format: wgpu::TextureFormat) -> bool {
    blended(device, format).is_ok_and(|found| {
        // Twice the rounding of a sum near one.
        let below = |first: f32, second: f32| first * (1.0 - 1.0 / 4096.0) + second;
        let known =
            [below(1.0, 1.0 / 1_048_576.0), below(0.5, 1.0 / 2_097_152.0), below(0.25, 1.0 / 2_097_152.0)];
        let near = |(found, known): (&f32, &f32)| (found - known).abs() <= f32::EPSILON;
        found[..3].iter().zip(&known).all(near) && (found[3] - below(0.5, 1.0 / 4096.0)).abs() <= f32::EPSILON
    })
}

fn blended(device: &Device, format: wgpu::TextureFormat) -> Result<[f32; 4], EngineError> {
    let canvas = Canvas::target(device, [1, 1], format)?;
    let Canvas::Target(texture) = &canvas else {
        return Err(EngineError::Unsupported("a picture that is no target".to_owned()));
    };
    device.guarded("trying to blend", || {
        let source = wgpu::ShaderSource::Wgsl(COLOURS.into());
        let module = device
            .wgpu()
            .create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("blending"), source });
        let blend_state = Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING);
        let target =
            wgpu::ColorTargetState { format, blend: blend_state, write_mask: wgpu::ColorWrites::ALL };
        let compilation_options = wgpu::PipelineCompilationOptions::default();
        let pipeline = device.wgpu().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("blending"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("corner"),
                compilation_options: compilation_options.clone(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("colour"),
                compilation_options,
                targets: &[Some(target)],
            }),
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            multiview_mask: None,
            cache: None,
        });
        let mut encoder = device.wgpu().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut pass = blend(&mut encoder, &view, true, None);
        pass.set_pipeline(&pipeline);
        pass.draw(0..3, 0..2);
        drop(pass);
        device.queue().submit([encoder.finish()]);
        Ok(())
    })?;
    canvas.pixels(device)?.first().copied().ok_or_else(|| EngineError::Gpu("no pixel came back".to_owned()))
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;
    use crate::testing::test_device;

    /// The twins: wrong words and slices, as on devices that do not implement what they claim.
    #[test]
    fn wrong_blocks_and_slices_are_noticed() {
        let Some(device) = test_device("probes::twins") else { return };
        let claimed = device.as_claimed();
        let known = blocks();
        if device.capabilities().bc_sliced_3d.is_ok() {
            assert_eq!(decodes_blocks(&claimed, &known).ok(), Some(true));
            let mut others = vec![vec![0; known.len()], vec![u32::MAX; known.len()]];
            let mut moved = known.clone();
            moved.rotate_left(4);
            others.push(moved);
            for word in 0..known.len() {
                let mut one = known.clone();
                one[word] ^= 1 << 20;
                others.push(one);
            }
            for other in others {
                assert_eq!(decodes_blocks(&claimed, &other).ok(), Some(false), "{other:x?}");
            }
        }
        if device.capabilities().copies_from_any_slice {
            assert_eq!(copies_slices(&claimed, &SLICES).ok(), Some(true));
        }
        for slice in 0..SLICES.len() {
            let mut other = SLICES;
            other[slice] = 0.0;
            assert_eq!(copies_slices(&claimed, &other).ok(), Some(false), "{slice}");
        }
    }

    /// The probe must detect sums in half precision. Every device can make them.
    #[test]
    fn sums_in_half_precision_are_noticed() {
        let Some(device) = test_device("probes::half") else { return };
        let half = wgpu::TextureFormat::Rgba16Float;
        let found = blended(device, half).unwrap();
        let rough =
            [1.0, 0.5, 0.25, 0.5].iter().zip(found).all(|(known, found)| (known - found).abs() < 1e-3);
        assert!(rough, "{found:?}");
        assert!(!blends(device, half), "{found:?}");
    }

    /// A probe gives no false alarm: a feature reported as missing is missing.
    #[test]
    fn what_is_said_to_be_missing_is_missing() {
        let Some(device) = test_device("probes::missing") else { return };
        let start = Instant::now();
        let claimed = device.as_claimed();
        let found = of(&claimed);
        println!("{}: {found:?} in {:.1} ms", device.info(), start.elapsed().as_secs_f64() * 1e3);
        assert_eq!(&found, device.capabilities());
        if found.bc_sliced_3d == Err(BlockFallback::NotDecoded) {
            let layout = layout([4, 4, 1]).unwrap();
            // One block with the value 200 everywhere.
            let words = Cow::Borrowed(&[200 * 0x101, 0][..]);
            let blocks = BlockTexture { format: BlockFormat::Bc4, words, scale: 255.0, offset: 0.0 };
            let read =
                VolumeTexture::upload_blocks(&claimed, &layout, &blocks).and_then(|t| t.read(&claimed));
            assert!(
                read.is_ok_and(|read| read.iter().all(|v| (v - 200.0).abs() > 20.0)),
                "one block is decoded"
            );
        }
        if found.copies_from_any_slice {
            return;
        }
        // Any volume is read all the same.
        let layout = layout([2, 1, 3]).unwrap();
        let values = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let texture = VolumeTexture::upload(device, &layout, &values, DecodedForm::FLOAT32).unwrap();
        assert_eq!(texture.read(device).unwrap(), values);
    }
}
