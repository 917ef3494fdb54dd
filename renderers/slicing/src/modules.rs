//! The renderer's own WGSL.

cvr_shaders::modules! { "/../../shaders/", "slicing/":
    /// The slices.
    SLICING = "slicing.wgsl";
    /// Slices that are drawn at once.
    SLICES_AT_ONCE = "proxy.wgsl";
    /// Slices that are drawn layer by layer.
    SLICES_BY_LAYERS = "layers.wgsl";
    /// Slabs between planes.
    SLABS_FLAT = "flat.wgsl";
    /// Slabs between spheres.
    SLABS_SHELLS = "shells.wgsl";
    /// Opacity of a slice, exactly.
    OPACITY_EXACT = "opacity_exact.wgsl";
    /// Opacity of a slice, approximated.
    OPACITY_LERP = "opacity_lerp.wgsl";
}
