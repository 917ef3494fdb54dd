// Opacity of a piece of ray, from the opacity per voxel length.
fn slice_opacity(alpha: f32, piece: f32) -> f32 {
    return opacity_over(alpha, piece);
}
