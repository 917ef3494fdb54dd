// The cell of eight voxel centres around a point, clamped at the border, and the position of the point in it.
struct Cell {
    p: vec3<i32>,
    q: vec3<i32>,
    t: vec3<f32>,
}

fn cell_around(x: vec3<f32>) -> Cell {
    let last = vec3<i32>(volume_extent) - 1;
    let base = floor(x - 0.5);
    let p = vec3<i32>(base);
    let zero = vec3<i32>(0);
    return Cell(clamp(p, zero, last), clamp(p + 1, zero, last), (x - 0.5) - base);
}

// Interpolates along x, then y, then z, in the order of the CPU mirror. It uses `a + (b - a) * t`, because the
// specification does not fix the arithmetic of `mix`.
fn trilinear(
    c000: Voxel, c100: Voxel, c010: Voxel, c110: Voxel,
    c001: Voxel, c101: Voxel, c011: Voxel, c111: Voxel,
    t: vec3<f32>,
) -> Voxel {
    let c00 = c000 + (c100 - c000) * t.x;
    let c10 = c010 + (c110 - c010) * t.x;
    let c01 = c001 + (c101 - c001) * t.x;
    let c11 = c011 + (c111 - c011) * t.x;
    let c0 = c00 + (c10 - c00) * t.y;
    let c1 = c01 + (c11 - c01) * t.y;
    return c0 + (c1 - c0) * t.z;
}
