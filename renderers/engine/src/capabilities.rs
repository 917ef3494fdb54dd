//! Capabilities of a device as plain data. Decisions about textures can be made, and tested, without a device.

use cvr_core::codec::{BlockFormat, DecodedForm, TexelFormat};
use cvr_core::shader::{BindingLimits, TextureSampling};
use cvr_core::volume::Extent;

use crate::EngineError;

/// The limits and optional features on which drawing depends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Capabilities {
    /// Whether 16-bit unorm textures exist and can be filtered.
    pub norm16: bool,
    /// Whether single-precision textures can be filtered.
    pub float32_filterable: bool,
    /// Whether the driver claims to blend single-precision images. [`crate::Device::blends_single`] says whether it
    /// works.
    pub float32_blendable: bool,
    /// Whether 3-D textures can hold blocks of BC formats, or the reason why not.
    pub bc_sliced_3d: Result<(), BlockFallback>,
    /// Whether a copy from a 3-D texture can begin at any slice, or only at the first.
    pub copies_from_any_slice: bool,
    /// Whether a pass can be timed on the device.
    pub timestamps: bool,
    /// Voxels along one axis of a 3-D texture.
    pub texture_edge_voxels: u32,
    /// Pixels along one side of a blended picture.
    pub picture_edge_pixels: u32,
    /// Bytes of one storage binding.
    pub storage_binding_bytes: u64,
    /// Bytes of one buffer.
    pub buffer_bytes: u64,
    /// Storage buffers in one shader stage.
    pub storage_buffers: u32,
    /// Workgroups along one axis of a dispatch.
    pub workgroups_per_axis: u32,
}

/// Why a volume is in a wider texture, or filtered in another way, than its form needs. No bits are lost.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum TextureFallback {
    /// No 16-bit unorm textures: the values lie in a single-precision texture instead.
    Float32ForUnorm16,
    /// Single-precision textures cannot be filtered: the shader filters.
    ManualForFloat32,
    /// Both: no 16-bit unorm textures, and single-precision ones cannot be filtered.
    ManualFloat32ForUnorm16,
}

impl std::fmt::Display for TextureFallback {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Float32ForUnorm16 => "no 16-bit unorm textures: stored in single precision",
            Self::ManualForFloat32 => "single-precision textures cannot be filtered: the shader filters",
            Self::ManualFloat32ForUnorm16 => {
                "no 16-bit unorm textures, and single-precision ones cannot be filtered: stored in single \
                 precision, the shader filters"
            }
        })
    }
}

/// Why the CPU decodes blocks that a texture unit could decode. No bits are lost, but it needs more memory.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum BlockFallback {
    /// The device has no 3-D textures of the format.
    NoFormat,
    /// The device claims 3-D textures of the format, but reads wrong values from them.
    NotDecoded,
    /// Each block has one channel. No texture holds three such blocks in one texel.
    Colour,
}

impl std::fmt::Display for BlockFallback {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::NoFormat => "no 3-D textures of the codec's blocks: uploaded as decoded by the CPU",
            Self::NotDecoded => {
                "the device offers 3-D textures of the codec's blocks, but does not decode them: uploaded as decoded by the CPU"
            }
            Self::Colour => "no texture holds blocks of three channels: uploaded as decoded by the CPU",
        })
    }
}

/// How a device stores a decoded volume in a texture.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct TextureChoice {
    /// Texel format of the texture, and conversion of texels to data values. Shaders are generated with it. With a
    /// fallback, it differs from the decoder's own form.
    pub form: DecodedForm,
    /// Who can filter it.
    pub sampling: TextureSampling,
    /// The fallback, if one is used.
    pub fallback: Option<TextureFallback>,
}

impl Capabilities {
    /// The capabilities that the driver claims.
    pub(crate) fn of(device: &wgpu::Device) -> Self {
        let (limits, features) = (device.limits(), device.features());
        Self {
            norm16: features.contains(wgpu::Features::TEXTURE_FORMAT_16BIT_NORM),
            float32_filterable: features.contains(wgpu::Features::FLOAT32_FILTERABLE),
            float32_blendable: features.contains(wgpu::Features::FLOAT32_BLENDABLE),
            bc_sliced_3d: features
                .contains(
                    wgpu::Features::TEXTURE_COMPRESSION_BC
                        .union(wgpu::Features::TEXTURE_COMPRESSION_BC_SLICED_3D),
                )
                .then_some(())
                .ok_or(BlockFallback::NoFormat),
            copies_from_any_slice: true,
            timestamps: features.contains(wgpu::Features::TIMESTAMP_QUERY),
            texture_edge_voxels: limits.max_texture_dimension_3d,
            picture_edge_pixels: limits.max_texture_dimension_2d,
            storage_binding_bytes: limits.max_storage_buffer_binding_size,
            buffer_bytes: limits.max_buffer_size,
            storage_buffers: limits.max_storage_buffers_per_shader_stage,
            workgroups_per_axis: limits.max_compute_workgroups_per_dimension,
        }
    }

    /// Limits for the shader generator.
    #[must_use]
    pub fn binding_limits(&self) -> BindingLimits {
        BindingLimits { storage_words: self.storage_bytes() / 4, storage_buffers: self.storage_buffers }
    }

    /// Bytes of the largest buffer that one binding can hold.
    #[must_use]
    pub fn storage_bytes(&self) -> u64 {
        self.storage_binding_bytes.min(self.buffer_bytes)
    }

    /// Whether a 3-D texture can hold blocks of a format, for a volume with this many channels.
    ///
    /// # Errors
    /// The reason why not.
    pub const fn blocks(&self, format: BlockFormat, channels: u32) -> Result<(), BlockFallback> {
        match format {
            BlockFormat::Bc4 if self.bc_sliced_3d.is_ok() && channels != 1 => Err(BlockFallback::Colour),
            BlockFormat::Bc4 => self.bc_sliced_3d,
        }
    }

    /// Checks that no axis is longer than a 3-D texture may be.
    pub(crate) fn check_edges(&self, extent: Extent) -> Result<(), EngineError> {
        let longest = extent.to_array().into_iter().max().unwrap_or(1);
        if longest <= self.texture_edge_voxels {
            return Ok(());
        }
        Err(EngineError::TooLarge {
            what: format!("a 3-D texture of {extent}"),
            requested: u64::from(longest),
            limit: u64::from(self.texture_edge_voxels),
            unit: "voxels along one axis",
        })
    }

    /// How decoded values of this form are stored in a 3-D texture.
    ///
    /// # Errors
    /// [`EngineError::TooLarge`] when the longest axis exceeds the device's 3-D textures;
    /// [`EngineError::Unsupported`] when a form has no scale to divide by.
    pub fn texture(&self, form: DecodedForm, extent: Extent) -> Result<TextureChoice, EngineError> {
        self.check_edges(extent)?;
        if !(form.scale.is_finite() && form.scale != 0.0 && form.offset.is_finite()) {
            return Err(EngineError::Unsupported(format!(
                "texels of scale {} and offset {} hold no values",
                form.scale, form.offset
            )));
        }
        let float32 = |of_unorm16: bool| {
            // The values themselves. Scale and offset are applied before they are stored.
            let form = DecodedForm::FLOAT32;
            let (sampling, fallback) = match (self.float32_filterable, of_unorm16) {
                (true, false) => (TextureSampling::Hardware, None),
                (true, true) => (TextureSampling::Hardware, Some(TextureFallback::Float32ForUnorm16)),
                (false, false) => (TextureSampling::Manual, Some(TextureFallback::ManualForFloat32)),
                (false, true) => (TextureSampling::Manual, Some(TextureFallback::ManualFloat32ForUnorm16)),
            };
            TextureChoice { form, sampling, fallback }
        };
        Ok(match form.format {
            TexelFormat::Unorm16 if !self.norm16 => float32(true),
            TexelFormat::Float32 => float32(false),
            TexelFormat::Unorm8 | TexelFormat::Unorm16 | TexelFormat::Float16 => {
                TextureChoice { form, sampling: TextureSampling::Hardware, fallback: None }
            }
        })
    }
}

#[cfg(test)]
impl Capabilities {
    /// The limits that every WebGPU device offers, without optional features.
    pub(crate) const LEAST: Self = Self {
        norm16: false,
        float32_filterable: false,
        float32_blendable: false,
        bc_sliced_3d: Err(BlockFallback::NoFormat),
        copies_from_any_slice: true,
        timestamps: false,
        texture_edge_voxels: 2048,
        picture_edge_pixels: 8192,
        storage_binding_bytes: 128 << 20,
        buffer_bytes: 256 << 20,
        storage_buffers: 8,
        workgroups_per_axis: 65535,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Capabilities = Capabilities { norm16: true, float32_filterable: true, ..Capabilities::LEAST };
    const UNORM16: DecodedForm =
        DecodedForm { format: TexelFormat::Unorm16, scale: 65535.0, offset: -32768.0 };

    fn cube(edge: u32) -> Extent {
        Extent::cube(edge).unwrap()
    }

    #[test]
    fn a_capable_device_needs_no_fallback() {
        for format in [TexelFormat::Unorm8, TexelFormat::Unorm16, TexelFormat::Float16, TexelFormat::Float32]
        {
            let form = DecodedForm { format, scale: 1.0, offset: 0.0 };
            let choice = ALL.texture(form, cube(4)).unwrap();
            assert_eq!(choice, TextureChoice { form, sampling: TextureSampling::Hardware, fallback: None });
        }
    }

    #[test]
    fn each_missing_feature_has_its_fallback() {
        let no_norm16 = Capabilities { norm16: false, ..ALL };
        let choice = no_norm16.texture(UNORM16, cube(4)).unwrap();
        assert_eq!(choice.form, DecodedForm::FLOAT32);
        assert_eq!(choice.sampling, TextureSampling::Hardware);
        assert_eq!(choice.fallback, Some(TextureFallback::Float32ForUnorm16));

        let choice = Capabilities::LEAST.texture(UNORM16, cube(4)).unwrap();
        assert_eq!((choice.form, choice.sampling), (DecodedForm::FLOAT32, TextureSampling::Manual));
        assert_eq!(choice.fallback, Some(TextureFallback::ManualFloat32ForUnorm16));

        let choice = Capabilities::LEAST.texture(DecodedForm::FLOAT32, cube(4)).unwrap();
        assert_eq!(choice.sampling, TextureSampling::Manual);
        assert_eq!(choice.fallback, Some(TextureFallback::ManualForFloat32));

        for format in [TexelFormat::Unorm8, TexelFormat::Float16] {
            let form = DecodedForm { format, scale: 1.0, offset: 0.0 };
            let choice = Capabilities::LEAST.texture(form, cube(4)).unwrap();
            assert_eq!((choice.sampling, choice.fallback), (TextureSampling::Hardware, None));
        }
    }

    #[test]
    fn blocks_need_their_feature_and_one_channel() {
        let bc4 = BlockFormat::Bc4;
        assert_eq!(Capabilities::LEAST.blocks(bc4, 1), Err(BlockFallback::NoFormat));
        let claims = Capabilities { bc_sliced_3d: Err(BlockFallback::NotDecoded), ..Capabilities::LEAST };
        assert_eq!(claims.blocks(bc4, 1), Err(BlockFallback::NotDecoded));
        let capable = Capabilities { bc_sliced_3d: Ok(()), ..Capabilities::LEAST };
        assert_eq!(capable.blocks(bc4, 1), Ok(()));
        assert_eq!(capable.blocks(bc4, 3), Err(BlockFallback::Colour));
    }

    #[test]
    fn a_volume_that_is_too_long_is_refused_with_both_numbers() {
        let error = ALL.texture(UNORM16, Extent::new(8, 2049, 8).unwrap()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "a 3-D texture of 8×2049×8 needs 2049 voxels along one axis, this device offers 2048"
        );
        assert!(ALL.texture(UNORM16, Extent::new(8, 2048, 8).unwrap()).is_ok());
    }

    #[test]
    fn a_form_without_scale_is_refused() {
        for scale in [0.0, f32::NAN, f32::INFINITY] {
            let form = DecodedForm { scale, ..UNORM16 };
            assert!(matches!(ALL.texture(form, cube(2)), Err(EngineError::Unsupported(_))));
        }
    }

    #[test]
    fn a_binding_is_no_larger_than_a_buffer() {
        let small = Capabilities { buffer_bytes: 1000, ..Capabilities::LEAST };
        assert_eq!(small.binding_limits().storage_words, 250);
    }
}
