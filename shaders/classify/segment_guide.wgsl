// A guide over the domain. Each cell holds the number of control points below it, the point before it, the point that
// it may contain, and the next. The view holds the ends of the domain, cells per data unit, and the last cell.
fn transfer_segment(value: f32) -> Segment {
    let guide = inputs.view.transfer_keys[0];
    let inside = clamp(value, guide.x, guide.y);
    let cell = u32(min((inside - guide.x) * guide.z, guide.w));
    let named = transfer_texel(cell, 0u);
    let passed = value >= named.z;
    return Segment(
        u32(named.x) + u32(passed),
        select(named.y, named.z, passed),
        select(named.z, named.w, passed),
    );
}
