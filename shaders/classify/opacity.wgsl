// Opacity of a piece of ray, `length` voxels long, from the opacity per voxel length: 1 − (1 − α)^length. α stays below
// 1, else a power of zero would hide later differences.
fn opacity_over(alpha: f32, length: f32) -> f32 {
    return 1.0 - pow(1.0 - min(alpha, 0.99999), length);
}
