// Lit colour and opacity per voxel length at a point. No gradient is computed for transparent points.
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

// What light falls on.
struct Surface {
    colour: vec4<f32>,
    // Change of the height (the value, or what of a colour decides) per voxel length along x, y, z of the world, by central
    // differences one voxel apart; zero where nothing shows.
    gradient: vec3<f32>,
}

fn optical(x: vec3<f32>, direction: vec3<f32>) -> vec4<f32> {
    let surface = surface_at(x);
    if surface.colour.a <= 0.0 {
        return surface.colour;
    }
    let rgb = blinn_phong(surface.colour.rgb, surface.gradient, -direction * inputs.view.voxel_size);
    return vec4<f32>(rgb, surface.colour.a);
}
