// Slabs between spheres around the eye. They have the same thickness along every ray. `travelled` is the distance from
// the eye to the entry.
fn slab_crossing(entry: Ray, travelled: f32, slice: u32) -> Crossing {
    let begin = inputs.slabs.first - travelled;
    return Crossing(begin + f32(slice) * inputs.view.step, begin + f32(slice + 1u) * inputs.view.step);
}
