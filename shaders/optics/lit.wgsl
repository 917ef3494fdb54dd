// Colour and opacity per voxel length at a point, lit. What shows nothing needs no gradient.
struct Lighting {
    // Towards the light in the world, of unit length.
    towards_light: vec3<f32>,
    ambient: f32,
    diffuse: f32,
    specular: f32,
    shininess: f32,
    // Gradients well below this count as none, in data units per voxel length.
    flat_gradient: f32,
}

fn optical(x: vec3<f32>, direction: vec3<f32>) -> vec4<f32> {
    let colour = classify(volume_sample(x));
    if colour.a <= 0.0 {
        return colour;
    }
    return vec4<f32>(blinn_phong(colour.rgb, gradient(x), -direction * view.voxel_size), colour.a);
}
