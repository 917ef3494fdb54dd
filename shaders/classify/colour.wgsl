// Parameters of colours: the origin of the opacity, and the conversion to light.
struct Colour {
    // Of luminance, or of one channel.
    weights: vec3<f32>,
    // Light is (voxel - offset) * scale, 0 to 1.
    scale: f32,
    offset: f32,
}

fn light(voxel: Voxel) -> vec3<f32> {
    return clamp((voxel - inputs.colour.offset) * inputs.colour.scale, vec3<f32>(0.0), vec3<f32>(1.0));
}
