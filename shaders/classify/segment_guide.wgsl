// A guide over the domain: each cell says how many control points lie below it, and names the next three. Its uniform
// holds the ends of the domain, cells per data unit, and the last cell.
fn transfer_segment(value: f32) -> u32 {
    let inside = clamp(value, transfer_guide.x, transfer_guide.y);
    let cell = u32(min((inside - transfer_guide.x) * transfer_guide.z, transfer_guide.w));
    let named = transfer_texel(cell, 0u);
    let passed = vec3<u32>(vec3<f32>(value) >= named.yzw);
    return u32(named.x) + passed.x + passed.y + passed.z;
}
