// The first sample, from number `first` on, that may show anything. Skipping does not move samples, so the picture is
// that of all samples. Mirror: `render::mirror`.

// Samples are skipped up to this many voxels beyond the face of an empty macrocell. A filter reads half a voxel further
// and stays within the apron. The margin also prevents that a ray along a face tests it at every sample.
const skip_beyond: f32 = 0.25;
// Smallest speed of a ray along an axis. It prevents division by zero. A slower ray skips fewer samples.
const skip_slowest: f32 = 1e-9;
// Most samples skipped at once. Single precision still counts this number.
const skip_most: f32 = 16777216.0;

fn next_sample(first: u32, entry: Ray, end: f32) -> u32 {
    var i = first;
    while f32(i) * inputs.view.step < end {
        let start = f32(i) * inputs.view.step;
        let x = entry.origin + entry.direction * (start + 0.5 * min(inputs.view.step, end - start));
        if may_show(x) {
            break;
        }
        let forward = select(vec3<f32>(0.0), vec3<f32>(1.0), entry.direction >= vec3<f32>(0.0));
        let face = (macrocell_at(x) + forward) * f32(macrocell_edge);
        let away = (abs(face - x) + skip_beyond) / max(abs(entry.direction), vec3<f32>(skip_slowest));
        i += 1u + u32(min(min(min(away.x, away.y), away.z) / inputs.view.step, skip_most));
    }
    return i;
}
