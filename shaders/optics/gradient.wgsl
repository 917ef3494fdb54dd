// A point and its neighbours, each sampled at its own place of the text.
fn surface_at(x: vec3<f32>) -> Surface {
    var surface = Surface(classify(volume_sample(x)), vec3<f32>(0.0));
    if surface.colour.a > 0.0 {
        surface.gradient = gradient(x);
    }
    return surface;
}

fn gradient(x: vec3<f32>) -> vec3<f32> {
    var difference: vec3<f32>;
    for (var axis = 0u; axis < 3u; axis++) {
        var unit: vec3<f32>;
        unit[axis] = 1.0;
        difference[axis] = height(volume_sample(x + unit)) - height(volume_sample(x - unit));
    }
    return difference * 0.5 / inputs.view.voxel_size;
}
