// A colour: what of it decides the opacity, and how its numbers become light.
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
