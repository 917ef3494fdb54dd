// A parallel ray through a point of the image plane, in voxel coordinates.
fn camera_ray(plane: vec2<f32>) -> Ray {
    return Ray(inputs.view.origin + inputs.view.right * plane.x + inputs.view.up * plane.y, inputs.view.direction);
}
