// Colour and opacity per voxel length at a point, from the transfer function alone.
fn optical(x: vec3<f32>, direction: vec3<f32>) -> vec4<f32> {
    return classify(volume_sample(x));
}
