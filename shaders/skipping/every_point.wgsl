// Nothing is skipped.
fn may_show(x: vec3<f32>) -> bool {
    return true;
}
