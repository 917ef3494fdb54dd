// Rays are followed to their ends at once.

fn walk_so_far(pixel: u32) -> Walk {
    return Walk(vec4<f32>(0.0), 0u);
}

fn may_go_on(taken: u32) -> bool {
    return true;
}

fn keep_walk(pixel: u32, walk: Walk) {
    image[pixel] = walk.result;
}
