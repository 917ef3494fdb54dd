//! The renderer's own WGSL.

cvr_shaders::modules! { "/../../shaders/", "raycasting/":
    /// Adds a sample to a ray.
    RAYCASTING = "raycasting.wgsl";
}
