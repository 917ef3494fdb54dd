// Change of the value per voxel length along x, y, z of the world, by central differences one voxel apart.
fn gradient(x: vec3<f32>) -> vec3<f32> {
    var difference: vec3<f32>;
    for (var axis = 0u; axis < 3u; axis++) {
        var unit: vec3<f32>;
        unit[axis] = 1.0;
        difference[axis] = volume_sample(x + unit) - volume_sample(x - unit);
    }
    return difference * 0.5 / view.voxel_size;
}
