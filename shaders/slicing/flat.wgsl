// Slabs between parallel planes: the part of a ray in a slab, counted from the ray's entry into the box.
fn slab_crossing(entry: Ray, travelled: f32, slice: u32) -> Crossing {
    let begin = inputs.slabs.first - dot(inputs.slabs.normal, entry.origin);
    let across = dot(inputs.slabs.normal, entry.direction);
    // A ray within the plane of a slab would divide by zero.
    let speed = select(across, 1e-9, abs(across) < 1e-9);
    let a = (begin + f32(slice) * inputs.view.step) / speed;
    let b = (begin + f32(slice + 1u) * inputs.view.step) / speed;
    return Crossing(min(a, b), max(a, b));
}
