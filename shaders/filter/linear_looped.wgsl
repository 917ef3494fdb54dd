// The value of filter/linear.wgsl. All eight voxels are fetched at one place of the text, for codecs with long text.
fn volume_sample(x: vec3<f32>) -> Voxel {
    let cell = cell_around(x);
    var c: array<Voxel, 8>;
    var i = 0u;
    // It ends with its last corner, as in optics/gradient_looped.wgsl.
    loop {
        let far = (vec3<u32>(i, i >> 1u, i >> 2u) & vec3<u32>(1u)) == vec3<u32>(1u);
        c[i] = voxel_fetch(select(cell.p, cell.q, far));
        if i >= 7u {
            break;
        }
        i++;
    }
    return trilinear(c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], cell.t);
}
