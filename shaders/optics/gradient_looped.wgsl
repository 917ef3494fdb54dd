// The values of optics/gradient.wgsl. All samples are taken at one place of the text, for codecs with long text.
fn surface_at(x: vec3<f32>) -> Surface {
    var surface: Surface;
    // At the point, then at the neighbours above and below along x, y and z.
    var heights: array<f32, 7>;
    var last = 0u;
    var i = 0u;
    // The loop ends after its last sample. On devices without jumps, a `for` would run its body once more with all
    // lanes masked.
    loop {
        var offset: vec3<f32>;
        if i > 0u {
            offset[(i - 1u) >> 1u] = select(-1.0, 1.0, (i & 1u) == 1u);
        }
        let voxel = volume_sample(x + offset);
        if i == 0u {
            surface.colour = classify(voxel);
            last = select(0u, 6u, surface.colour.a > 0.0);
        }
        heights[i] = height(voxel);
        if i >= last {
            break;
        }
        i++;
    }
    let difference = vec3<f32>(heights[1] - heights[2], heights[3] - heights[4], heights[5] - heights[6]);
    surface.gradient = difference * 0.5 / inputs.view.voxel_size;
    return surface;
}
