// A parallel ray through a point of the image plane, in voxel coordinates.
fn camera_ray(plane: vec2<f32>) -> Ray {
    return Ray(view.origin + view.right * plane.x + view.up * plane.y, view.direction);
}
