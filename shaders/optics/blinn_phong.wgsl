// The lit colour of a surface with normal `gradient`, for a sample of colour `rgb`. Both sides are lit. The normal
// fades for very small gradients, whose direction is noise.
fn blinn_phong(rgb: vec3<f32>, gradient: vec3<f32>, towards_viewer: vec3<f32>) -> vec3<f32> {
    // In units of a flat gradient: the squares of data values as they are could leave the range of numbers.
    let steepness = gradient / inputs.lighting.flat_gradient;
    let normal = steepness / sqrt(dot(steepness, steepness) + 1.0);
    let between = inputs.lighting.towards_light + towards_viewer;
    let half = between / max(length(between), 1e-6);
    let upright = abs(dot(normal, inputs.lighting.towards_light));
    let mirrored = clamp(abs(dot(normal, half)), 1e-4, 1.0);
    let highlight = inputs.lighting.specular * pow(mirrored, inputs.lighting.shininess);
    return min(rgb * (inputs.lighting.ambient + inputs.lighting.diffuse * upright) + highlight, vec3<f32>(1.0));
}
