//! The renderer's own WGSL.

cvr_shaders::modules! { "/../../shaders/", "raycasting/":
    /// What a sample adds to a ray.
    RAYCASTING = "raycasting.wgsl";
}
