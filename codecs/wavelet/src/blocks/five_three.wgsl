// 5/3: the twin of five_three.rs. Two neighbouring samples along an axis need two low-pass coefficients and three
// high-pass ones. So a window of 2x2x2 samples needs one of a level coarser, and at most 117 coefficients.

// What 5/3 adds to an even sample.
fn wavelet_correction(before: i32, after: i32) -> i32 {
    return (before + after + 2) >> 2u;
}

// Samples `t` and `t + 1` of a line. Each half of the line has `m` coefficients. `low` are low-pass
// coefficients from t / 2 on. `high` are high-pass ones from one before.
fn wavelet_pair(low: vec2<i32>, high: vec3<i32>, t: u32, m: u32) -> vec2<i32> {
    let i = t >> 1u;
    let before = select(high.x, high.y, i == 0u);
    let even = low.x - wavelet_correction(before, high.y);
    let next = select(low.y - wavelet_correction(high.y, high.z), even, i + 1u == m);
    let odd = high.y + ((even + next) >> 1u);
    return select(vec2<i32>(even, odd), vec2<i32>(odd, next), (t & 1u) == 1u);
}

// Samples of a level from `t` on. Along each axis there are `size` of them, one or two. `low` are those of the level
// before, from `from` on.
fn wavelet_window(
    head: wavelet_Head, root: wavelet_Group, level: u32, low: array<i32, 8>, t: vec3<u32>, size: vec3<u32>,
) -> array<i32, 8> {
    var lows = low;
    let m = 1u << level;
    let i = t >> vec3<u32>(1u);
    let from_low = min(i, vec3<u32>(max(m, 2u) - 2u));
    // Along each axis: two low-pass coefficients, then three high-pass ones.
    var c: array<i32, 125>;
    for (var k = 0u; k < 8u; k++) {
        let far = (vec3<u32>(k) >> vec3<u32>(0u, 1u, 2u)) & vec3<u32>(1u);
        let at = min(i + far, vec3<u32>(m - 1u)) - from_low;
        c[far.x + 5u * far.y + 25u * far.z] = lows[at.x + 2u * at.y + 4u * at.z];
    }
    // An even sample alone needs nothing that follows.
    let ahead = select(vec3<u32>(1u), size, (t & vec3<u32>(1u)) == vec3<u32>(0u));
    let first = max(i, vec3<u32>(1u)) - 1u;
    let last = min(i + ahead, vec3<u32>(m - 1u));
    var group = root;
    var child = 8u;
    for (var z = first.z; z <= last.z; z++) {
        for (var y = first.y; y <= last.y; y++) {
            for (var x = first.x; x <= last.x; x++) {
                let p = vec3<u32>(x, y, z);
                if level == 3u && wavelet_child_of(p) != child {
                    child = wavelet_child_of(p);
                    group = wavelet_child(head, child);
                }
                let record = wavelet_record(group, wavelet_place(level, p));
                if record.form == 0u {
                    continue;
                }
                // 0, 1 or 2: the position before, that of the first sample, the one after.
                let nth = p + 1u - i;
                // No low-pass coefficient is needed before the first.
                var wanted = select(0x7fu, 0x59u, nth.x == 0u) & select(0x7fu, 0x6au, nth.y == 0u);
                wanted &= select(0x7fu, 0x74u, nth.z == 0u);
                var high = wavelet_coefficients(head.first, record, level, wanted);
                for (var axes = 1u; axes < 8u; axes++) {
                    let is_high = (vec3<u32>(axes) >> vec3<u32>(0u, 1u, 2u)) & vec3<u32>(1u);
                    let slot = wavelet_slot(axes);
                    if ((wanted >> slot) & 1u) == 1u {
                        let at = nth + 3u * is_high - 1u;
                        c[at.x + 5u * at.y + 25u * at.z] = high[slot];
                    }
                }
            }
        }
    }
    var by_x: array<vec2<i32>, 25>;
    for (var k = 0u; k < 25u; k++) {
        let at = 5u * k;
        by_x[k] = wavelet_pair(
            vec2<i32>(c[at], c[at + 1u]), vec3<i32>(c[at + 2u], c[at + 3u], c[at + 4u]), t.x, m,
        );
    }
    var out: array<i32, 8>;
    for (var x = 0u; x < 2u; x++) {
        var by_y: array<vec2<i32>, 5>;
        for (var k = 0u; k < 5u; k++) {
            let at = 5u * k;
            by_y[k] = wavelet_pair(
                vec2<i32>(by_x[at][x], by_x[at + 1u][x]),
                vec3<i32>(by_x[at + 2u][x], by_x[at + 3u][x], by_x[at + 4u][x]), t.y, m,
            );
        }
        for (var y = 0u; y < 2u; y++) {
            let pair = wavelet_pair(
                vec2<i32>(by_y[0][y], by_y[1][y]), vec3<i32>(by_y[2][y], by_y[3][y], by_y[4][y]), t.z, m,
            );
            out[x + 2u * y] = pair.x;
            out[x + 2u * y + 4u] = pair.y;
        }
    }
    return out;
}

// The integers at the corners of a cell, which reaches one further along the axes of `size`.
fn wavelet_corners(head: wavelet_Head, inside: vec3<u32>, size: vec3<u32>) -> array<i32, 8> {
    var window: array<i32, 8>;
    for (var k = 0u; k < 8u; k++) {
        window[k] = head.low;
    }
    if head.coded {
        let root = wavelet_root(head);
        for (var level = 0u; level < wavelet_levels; level++) {
            let left = wavelet_levels - 1u - level;
            let whole = left > 0u;
            // Windows of coarser levels have two samples along each axis, all inside the block.
            let t = select(inside, min(inside >> vec3<u32>(left), vec3<u32>((2u << level) - 2u)), whole);
            window = wavelet_window(head, root, level, window, t, select(size, vec3<u32>(1u), whole));
        }
    }
    var out: array<i32, 8>;
    for (var k = 0u; k < 8u; k++) {
        let far = (vec3<u32>(k) >> vec3<u32>(0u, 1u, 2u)) & size;
        out[k] = window[far.x + 2u * far.y + 4u * far.z];
    }
    return out;
}

fn wavelet_one(head: wavelet_Head, inside: vec3<u32>) -> i32 {
    return wavelet_corners(head, inside, vec3<u32>(0u))[0];
}
