// The first sample from number `first` on that may show anything. The others keep their places: the picture is that of
// all samples. Those up to the face by which the ray leaves a macrocell lie in it, or beyond it by less than its apron.
fn next_sample(first: u32, entry: Ray, end: f32) -> u32 {
    var i = first;
    while f32(i) * view.step < end {
        let start = f32(i) * view.step;
        let x = entry.origin + entry.direction * (start + 0.5 * min(view.step, end - start));
        if may_show(x) {
            return i;
        }
        let forward = select(vec3<f32>(0.0), vec3<f32>(1.0), entry.direction > vec3<f32>(0.0));
        let face = (macrocell_at(x) + forward) * f32(macrocell_edge);
        let along = abs(entry.direction) < vec3<f32>(1e-6);
        let away = select((face - x) / entry.direction, vec3<f32>(1e6), along);
        i += 1u + u32(max(min(min(away.x, away.y), away.z), 0.0) / view.step);
    }
    return i;
}
