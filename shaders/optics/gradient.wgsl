// Change of the height (the value, or what of a colour decides) per voxel length along x, y, z of the world, by central
// differences one voxel apart.
fn gradient(x: vec3<f32>) -> vec3<f32> {
    var difference: vec3<f32>;
    for (var axis = 0u; axis < 3u; axis++) {
        var unit: vec3<f32>;
        unit[axis] = 1.0;
        difference[axis] = height(volume_sample(x + unit)) - height(volume_sample(x - unit));
    }
    return difference * 0.5 / view.voxel_size;
}
