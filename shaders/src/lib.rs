//! The WGSL modules that renderers share, and the table that embeds them.
//!
//! One subject per file. A module names no binding and no codec: the generator in `cvr-core` writes the bindings and
//! adds a codec. It also finds the modules that a text needs, by the names that modules declare and use. If only one
//! module declares a name, it is added automatically. If there are several, a view chooses. A renderer's own modules
//! are in `shaders/<id>/`, and its crate embeds them ([`modules!`]).
//!
//! The functions that modules call from each other:
//!
//! ```text
//! rays/follow.wgsl            → pixel_ray, crossing, next_sample, walk_so_far, may_go_on, keep_walk, loops_run,
//!                               gather (the renderer's)
//! blending/*.wgsl             → loops_run, shown (the renderer's)
//! view/view.wgsl              → camera_ray, bounds_low, bounds_high
//! optics/*.wgsl               → volume_sample, classify, height, surface_at
//! classify/*.wgsl             → transfer, height, transfer_segment (a module, or generated), transfer_texel, keys_passed
//! skipping/next_sample.wgsl   → may_show, macrocell_at
//! filter/*.wgsl               → voxel_fetch, voxel_cell
//! deferred/decode.wgsl        → voxel_fetch, voxel_of_layer, voxel_channel, texel_of
//! deferred/frame.wgsl         → frame_words, voxel_channels
//! */ring.wgsl                 → layered, layered_voxel (generated)
//! source/*.wgsl, deferred/frame.wgsl or a codec's snippet → what voxel_fetch returns
//! ```
//!
//! Uniforms are members of `inputs`, a struct that the generator writes: `inputs.view.step`.

/// A WGSL module. Its text declares no binding: the generator writes them.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Template {
    /// Path below `shaders/`, for error messages and origin comments.
    pub file: &'static str,
    /// The text.
    pub source: &'static str,
}

/// Embeds WGSL modules as constants, and as `ALL`. The first argument is the path from the crate's folder to
/// `shaders/`, the second a folder in it. Both end with a slash.
#[macro_export]
macro_rules! modules {
    ($root:literal, $folder:literal: $($(#[$doc:meta])* $name:ident = $file:literal;)*) => {
        $($(#[$doc])* pub const $name: $crate::Template = $crate::Template {
            file: concat!("shaders/", $folder, $file),
            source: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), $root, $folder, $file)),
        };)*

        /// All of these modules.
        pub const ALL: &[$crate::Template] = &[$($name),*];
    };
}

modules! { "/", "":
    /// `Voxel` of scalar volumes.
    VOXEL_SCALAR = "voxel/scalar.wgsl";
    /// `Voxel` of RGB volumes.
    VOXEL_RGB = "voxel/rgb.wgsl";
    /// The numbers of a scalar voxel, one by one.
    CHANNEL_SCALAR = "voxel/channel_scalar.wgsl";
    /// The numbers of an RGB voxel, one by one.
    CHANNEL_RGB = "voxel/channel_rgb.wgsl";
    /// The voxel that covers the point.
    FILTER_NEAREST = "filter/nearest.wgsl";
    /// Trilinear interpolation of eight values.
    TRILINEAR = "filter/trilinear.wgsl";
    /// Trilinear over eight fetches.
    FILTER_LINEAR = "filter/linear.wgsl";
    /// The same through one call in a loop.
    FILTER_LINEAR_LOOPED = "filter/linear_looped.wgsl";
    /// Trilinear over one `fetch_cell`.
    FILTER_LINEAR_CELL = "filter/linear_cell.wgsl";
    /// Trilinear by the texture unit.
    FILTER_HARDWARE = "filter/hardware.wgsl";
    /// Trilinear by the texture unit, from a texture that extends beyond the volume.
    FILTER_HARDWARE_PADDED = "filter/hardware_padded.wgsl";
    /// Trilinear by the texture unit, from a ring of layers.
    FILTER_HARDWARE_RING = "filter/hardware_ring.wgsl";
    /// Voxels from a ring of layers.
    SOURCE_RING = "source/ring.wgsl";
    /// Voxels from a texture.
    SOURCE_TEXTURE = "source/texture.wgsl";
    /// The view, the ray of a pixel, and its crossing of the drawn box.
    VIEW = "view/view.wgsl";
    /// Rays from one eye.
    CAMERA_PERSPECTIVE = "camera/perspective.wgsl";
    /// Parallel rays.
    CAMERA_ORTHOGRAPHIC = "camera/orthographic.wgsl";
    /// Everything is drawn.
    BOUNDS_WHOLE = "bounds/whole.wgsl";
    /// Only a box is drawn.
    BOUNDS_CLIP = "bounds/clip.wgsl";
    /// The conversion of a colour to light.
    COLOUR = "classify/colour.wgsl";
    /// The transfer function.
    TRANSFER = "classify/transfer.wgsl";
    /// Classification of scalars.
    CLASSIFY_SCALAR = "classify/scalar.wgsl";
    /// Classification of colours by a transfer function.
    CLASSIFY_COLOUR_TRANSFER = "classify/colour_transfer.wgsl";
    /// Classification of colours by a table over all of them.
    CLASSIFY_COLOUR_TABLE = "classify/colour_table.wgsl";
    /// The number of a scalar voxel that surfaces depend on.
    HEIGHT_SCALAR = "classify/height_scalar.wgsl";
    /// The number of a colour that opacity and surfaces depend on.
    HEIGHT_COLOUR = "classify/height_colour.wgsl";
    /// Opacity of a length of ray.
    OPACITY = "classify/opacity.wgsl";
    /// Samples that show the transfer function's colours.
    OPTICS_UNLIT = "optics/unlit.wgsl";
    /// Samples that are lit.
    OPTICS_LIT = "optics/lit.wgsl";
    /// Central differences.
    GRADIENT = "optics/gradient.wgsl";
    /// The same through one call in a loop.
    GRADIENT_LOOPED = "optics/gradient_looped.wgsl";
    /// The light on a surface.
    BLINN_PHONG = "optics/blinn_phong.wgsl";
    /// Macrocells of a point.
    MACROCELLS = "skipping/macrocells.wgsl";
    /// Rays that leap over macrocells.
    NEXT_SAMPLE = "skipping/next_sample.wgsl";
    /// Rays that take every sample.
    EVERY_SAMPLE = "skipping/every_sample.wgsl";
    /// Points that may always show something.
    EVERY_POINT = "skipping/every_point.wgsl";
    /// The rays of a picture, followed.
    FOLLOW_RAYS = "rays/follow.wgsl";
    /// Rays that are followed at once.
    RAYS_AT_ONCE = "rays/at_once.wgsl";
    /// Rays that are followed piece by piece.
    RAYS_IN_PIECES = "rays/in_pieces.wgsl";
    /// Whether a device has ended loops.
    LOOPS_RUN = "rays/loops.wgsl";
    /// Fragments without a check.
    BLENDED_UNCHECKED = "blending/unchecked.wgsl";
    /// Fragments that mark ended loops.
    BLENDED_CHECKED = "blending/checked.wgsl";
    /// How many of four values a value has passed.
    KEYS_PASSED = "classify/keys_passed.wgsl";
    /// The segment of a value, by a guide over the domain.
    SEGMENT_GUIDE = "classify/segment_guide.wgsl";
    /// The segment of a value, by a guide whose cells hold several points.
    SEGMENT_WIDE_GUIDE = "classify/segment_wide_guide.wgsl";
    /// Every voxel through `voxel_fetch`.
    DUMP = "dump/dump.wgsl";
    /// Every voxel through `voxel_cell`.
    DUMP_CELL = "dump/dump_cell.wgsl";
    /// Rows of some layers through `voxel_fetch`, into the words of a texture: the site *deferred*.
    DEFERRED_DECODE = "deferred/decode.wgsl";
    /// Voxels of a frame that a codec's own passes have rebuilt.
    DEFERRED_FRAME = "deferred/frame.wgsl";
    /// Texels of 8 bits over 0..1.
    TEXEL_UNORM8 = "deferred/texel_unorm8.wgsl";
    /// Texels of 16 bits over 0..1.
    TEXEL_UNORM16 = "deferred/texel_unorm16.wgsl";
    /// Texels in half precision.
    TEXEL_FLOAT16 = "deferred/texel_float16.wgsl";
    /// Texels in single precision.
    TEXEL_FLOAT32 = "deferred/texel_float32.wgsl";
}
