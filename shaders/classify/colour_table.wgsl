// A table over all colours gives the opacity, trilinear between its entries. Its first number is its edge (at least 2).
// The entries follow, red fastest.
fn opacity_row(edge: u32, p: vec3<u32>, t: f32) -> f32 {
    let i = (p.z * edge + p.y) * edge + p.x + 1u;
    return opacity_table[i] + (opacity_table[i + 1u] - opacity_table[i]) * t;
}

fn classify(voxel: Voxel) -> vec4<f32> {
    let shown = light(voxel);
    let edge = u32(opacity_table[0]);
    let at = shown * f32(edge - 1u);
    let low = min(floor(at), vec3<f32>(f32(edge - 2u)));
    let t = at - low;
    let p = vec3<u32>(low);
    let c00 = opacity_row(edge, p, t.x);
    let c10 = opacity_row(edge, p + vec3<u32>(0u, 1u, 0u), t.x);
    let c01 = opacity_row(edge, p + vec3<u32>(0u, 0u, 1u), t.x);
    let c11 = opacity_row(edge, p + vec3<u32>(0u, 1u, 1u), t.x);
    let c0 = c00 + (c10 - c00) * t.y;
    let c1 = c01 + (c11 - c01) * t.y;
    return vec4<f32>(shown, c0 + (c1 - c0) * t.z);
}
