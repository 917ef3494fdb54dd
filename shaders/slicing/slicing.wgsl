// A stack of slices, blended back to front. A slice stands for the slab around it. A fragment stands for the piece of
// its ray within slab and box, sampled in the middle. So nothing jumps where a slice leaves the volume or the view
// turns. The proxy polygons only cover the visible part of a slab. What a fragment shows is decided here. Mirror:
// renderers/slicing/src/mirror.rs.

struct Slabs {
    // Distance across the slabs is dot(normal, x) for x in voxel coordinates, in voxel lengths.
    normal: vec3<f32>,
    // Where slab 0 begins.
    first: f32,
}

fn shown(proxy: Proxy) -> vec4<f32> {
    let ray = pixel_ray(vec2<u32>(proxy.position.xy));
    let inside = crossing(ray);
    let entry = Ray(ray.origin + ray.direction * inside.near, ray.direction);
    let slab = slab_crossing(entry, inside.near, proxy.slice);
    let near = max(slab.near, 0.0);
    let piece = min(slab.far, inside.far - inside.near) - near;
    if piece <= 0.0 {
        discard;
    }
    let x = entry.origin + entry.direction * (near + 0.5 * piece);
    if !drawn_now(proxy, x) || !may_show(x) {
        discard;
    }
    let sample = optical(x, entry.direction);
    let opacity = slice_opacity(sample.a, piece);
    return vec4<f32>(sample.rgb * opacity, opacity);
}
