// Haar: the twin of haar.rs. A voxel needs one record of each level.

// One of the two samples of a pair.
fn wavelet_half(low: i32, high: i32, side: u32) -> i32 {
    let second = low - (high >> 1u);
    return select(second, second + high, side == 0u);
}

// One sample of eight: c[0] is low-pass along all axes.
fn wavelet_eighth(c: array<i32, 8>, side: vec3<u32>) -> i32 {
    let near = wavelet_half(
        wavelet_half(c[0], c[1], side.x), wavelet_half(c[2], c[3], side.x), side.y,
    );
    let far = wavelet_half(
        wavelet_half(c[4], c[5], side.x), wavelet_half(c[6], c[7], side.x), side.y,
    );
    return wavelet_half(near, far, side.z);
}

// The integer at a position of a block.
fn wavelet_walk(head: wavelet_Head, root: wavelet_Group, inside: vec3<u32>) -> i32 {
    var value = head.low;
    for (var level = 0u; level < wavelet_levels; level++) {
        let p = inside >> vec3<u32>(wavelet_levels - level);
        let side = (inside >> vec3<u32>(wavelet_levels - 1u - level)) & vec3<u32>(1u);
        var group = root;
        if level == 3u {
            group = wavelet_child(head, wavelet_child_of(p));
        }
        let record = wavelet_record(group, wavelet_place(level, p));
        if record.form == 0u {
            // All differences are 0.
            continue;
        }
        var c: array<i32, 8>;
        c[0] = value;
        var high = wavelet_coefficients(head.first, record, level, 0x7fu);
        for (var axes = 1u; axes < 8u; axes++) {
            c[axes] = high[wavelet_slot(axes)];
        }
        value = wavelet_eighth(c, side);
    }
    return value;
}

fn wavelet_one(head: wavelet_Head, inside: vec3<u32>) -> i32 {
    if !head.coded {
        return head.low;
    }
    return wavelet_walk(head, wavelet_root(head), inside);
}

// The integers at the corners of a cell, which reaches one further along the axes of `size`.
fn wavelet_corners(head: wavelet_Head, inside: vec3<u32>, size: vec3<u32>) -> array<i32, 8> {
    var out: array<i32, 8>;
    var root: wavelet_Group;
    if head.coded {
        root = wavelet_root(head);
    }
    for (var i = 0u; i < 8u; i++) {
        out[i] = head.low;
        if head.coded {
            let far = (vec3<u32>(i) >> vec3<u32>(0u, 1u, 2u)) & size;
            out[i] = wavelet_walk(head, root, inside + far);
        }
    }
    return out;
}
