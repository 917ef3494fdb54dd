
// What the kit adds to the snippet above (core/src/kit/blocks/fetch.wgsl): records and places of voxels and cells.

fn kit_record(block: vec3<u32>, c: u32) -> u32 {
    return (((block.z * kit_channels + c) * kit_grid.y + block.y) * kit_grid.x + block.x) * kit_record_words;
}

fn kit_place(inside: vec3<u32>) -> u32 {
    return (inside.z * kit_block.y + inside.y) * kit_block.x + inside.x;
}

fn kit_voxel(block: vec3<u32>, inside: vec3<u32>) -> vec4<f32> {
    var out = vec4<f32>(0.0);
    for (var c = 0u; c < kit_channels; c++) {
        out[c] = kit_value(kit_record(block, c), kit_place(inside));
    }
    return out;
}

fn kit_fetch(p: vec3<i32>) -> vec4<f32> {
    let v = vec3<u32>(p);
    let block = v / kit_block;
    return kit_voxel(block, v - block * kit_block);
}

fn kit_fetch_cell(p: vec3<i32>, q: vec3<i32>) -> array<vec4<f32>, 8> {
    let v = vec3<u32>(p);
    let w = vec3<u32>(q);
    let from_block = v / kit_block;
    let to_block = w / kit_block;
    let a = v - from_block * kit_block;
    let b = w - to_block * kit_block;
    return array<vec4<f32>, 8>(
        kit_voxel(from_block, a),
        kit_voxel(vec3<u32>(to_block.x, from_block.yz), vec3<u32>(b.x, a.yz)),
        kit_voxel(vec3<u32>(from_block.x, to_block.y, from_block.z), vec3<u32>(a.x, b.y, a.z)),
        kit_voxel(vec3<u32>(to_block.xy, from_block.z), vec3<u32>(b.xy, a.z)),
        kit_voxel(vec3<u32>(from_block.xy, to_block.z), vec3<u32>(a.xy, b.z)),
        kit_voxel(vec3<u32>(to_block.x, from_block.y, to_block.z), vec3<u32>(b.x, a.y, b.z)),
        kit_voxel(vec3<u32>(from_block.x, to_block.yz), vec3<u32>(a.x, b.yz)),
        kit_voxel(to_block, b),
    );
}
