// Front to back: adds a sample in the middle of a piece of ray. Mirror: renderers/raycasting/src/mirror.rs.
fn gather(so_far: vec4<f32>, x: vec3<f32>, direction: vec3<f32>, piece: f32) -> Gathered {
    let sample = optical(x, direction);
    if !(sample.a > 0.0) {
        return Gathered(so_far, false);
    }
    let weight = opacity_over(sample.a, piece) * (1.0 - so_far.a);
    // The last sample counts as far as the ray goes: whether it ends here or one sample later, which
    // rounding may decide, is then the same picture.
    let rest = inputs.view.termination - so_far.a;
    return Gathered(so_far + vec4<f32>(sample.rgb, 1.0) * min(weight, rest), weight >= rest);
}
