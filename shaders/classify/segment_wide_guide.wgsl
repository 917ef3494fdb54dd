// A guide over the domain. Each cell holds the number of control points below it, and the next three points. The view
// holds the ends of the domain, cells per data unit, and the last cell.
fn transfer_segment(value: f32) -> Segment {
    let guide = inputs.view.transfer_keys[0];
    let inside = clamp(value, guide.x, guide.y);
    let cell = u32(min((inside - guide.x) * guide.z, guide.w));
    let named = transfer_texel(cell, 0u);
    let passed = vec3<u32>(vec3<f32>(value) >= named.yzw);
    let number = u32(named.x) + passed.x + passed.y + passed.z;
    let ends = transfer_texel(number, 2u);
    return Segment(number, ends.x, ends.y);
}
