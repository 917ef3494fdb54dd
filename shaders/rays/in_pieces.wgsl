// Follows rays piece by piece over several dispatches, for devices that end loops. Between them the picture holds the
// sums of the rays, and `progress` holds the next sample.

struct Pieces {
    // Samples that a ray takes in one piece at most.
    samples: u32,
}

fn walk_so_far(pixel: u32) -> Walk {
    let next = progress[pixel];
    // A ray that has not begun has no sum. The picture then holds an older one.
    return Walk(select(image[pixel], vec4<f32>(0.0), next == 0u), next);
}

fn may_go_on(taken: u32) -> bool {
    return taken < inputs.pieces.samples;
}

fn keep_walk(pixel: u32, walk: Walk) {
    image[pixel] = walk.result;
    progress[pixel] = walk.next;
}
