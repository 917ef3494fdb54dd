// One bit per macrocell: whether any value that a sample inside may have shows anything. Mirror: `render::mirror`.
const macrocell_edge: u32 = 8u;

// The macrocell that holds a point. A point that rounding moved outside the volume counts as inside.
fn macrocell_at(x: vec3<f32>) -> vec3<f32> {
    let last = vec3<f32>((volume_extent - 1u) / macrocell_edge);
    return clamp(floor(x / f32(macrocell_edge)), vec3<f32>(0.0), last);
}

fn may_show(x: vec3<f32>) -> bool {
    let cell = vec3<u32>(macrocell_at(x));
    let grid = (volume_extent - 1u) / macrocell_edge + 1u;
    let i = (cell.z * grid.y + cell.y) * grid.x + cell.x;
    return (macrocells[i >> 5u] >> (i & 31u) & 1u) == 1u;
}
