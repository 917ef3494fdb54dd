// What a fragment adds to the picture.
fn added(colour: vec4<f32>) -> vec4<f32> {
    return colour;
}
