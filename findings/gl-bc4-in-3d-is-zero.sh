#!/usr/bin/env bash
# wgpu's GL backend offers BC textures in three dimensions, and every texel of a BC4 one reads as 0.
#
# Expected: an adapter that lists the feature `texture-compression-bc-sliced-3d` samples the uploaded texels, or refuses
# the texture. OpenGL has no RGTC (BC4, BC5) in 3-D textures.
# Happens (wgpu-native of wgpu 0.32.0 for Python; wgpu 30 for Rust as well; Mesa 22.3.6): the feature is listed on GL,
# the texture is made, the upload succeeds, no error is reported, and all texels are 0. The same program reads 1 through
# Vulkan on the same driver. A program that trusts the feature draws black.
#
# Runs without cvr: wgpu-native through Python, pinned below, in a temporary folder. Needs python3 with venv, and Mesa's
# llvmpipe for GL (Debian: libegl1 and libgl1-mesa-dri; mesa-vulkan-drivers for the comparison). Exit code 0: it is
# still so; 1: it has changed; 2: it could not run.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-$folder}"
python3 -m venv "$folder/venv" || exit 2
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check wgpu==0.32.0 numpy==2.4.6 || exit 2
cat > "$folder/blocks.py" <<'PY'
import sys

import numpy
import wgpu

FEATURES = ["texture-compression-bc", "texture-compression-bc-sliced-3d"]
SHADER = """
@group(0) @binding(0) var volume: texture_3d<f32>;
@group(0) @binding(1) var<storage, read_write> texels: array<f32>;

@compute @workgroup_size(4, 4, 4)
fn load(@builtin(global_invocation_id) p: vec3<u32>) {
    texels[p.x + 4u * (p.y + 4u * p.z)] = textureLoad(volume, vec3<i32>(p), 0).x;
}
"""
# Endpoints 255 and 0, sixteen indices 0: every texel is the first endpoint, 1.
BLOCK = bytes([255, 0] + 6 * [0])


def texels(adapter):
    """The different values of a texture of 4 x 4 x 4 texels whose four slices are this block."""
    device = adapter.request_device_sync(required_features=FEATURES)
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    texture = device.create_texture(size=(4, 4, 4), dimension="3d", format="bc4-r-unorm", usage=usage)
    layout = {"offset": 0, "bytes_per_row": len(BLOCK), "rows_per_image": 1}
    device.queue.write_texture({"texture": texture}, 4 * BLOCK, layout, (4, 4, 4))
    told = device.create_buffer(size=256, usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC)
    module = device.create_shader_module(code=SHADER)
    pipeline = device.create_compute_pipeline(layout="auto", compute={"module": module, "entry_point": "load"})
    resources = [texture.create_view(), {"buffer": told, "offset": 0, "size": 256}]
    entries = [{"binding": i, "resource": resource} for i, resource in enumerate(resources)]
    group = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
    encoder = device.create_command_encoder()
    compute = encoder.begin_compute_pass()
    compute.set_pipeline(pipeline)
    compute.set_bind_group(0, group)
    compute.dispatch_workgroups(1)
    compute.end()
    device.queue.submit([encoder.finish()])
    return sorted({float(v) for v in numpy.frombuffer(device.queue.read_buffer(told), numpy.float32)})


print(f"wgpu (Python) {wgpu.__version__}, numpy {numpy.__version__}")
seen = {}
for adapter in wgpu.gpu.enumerate_adapters_sync():
    info = adapter.info
    if "llvmpipe" not in info["device"]:
        continue
    backend = info["backend_type"]
    offered = all(feature in adapter.features for feature in FEATURES)
    seen[backend] = texels(adapter) if offered else None
    print(f"{info['device']}, {backend}, {info['description']}")
    print(f"  offers {FEATURES[1]}: {offered}; texels that should all be 1: {seen[backend]}")
if "OpenGL" not in seen:
    print("no llvmpipe through GL here")
    sys.exit(2)
same = seen["OpenGL"] == [0.0] and seen.get("Vulkan", [1.0]) == [1.0]
print("as described" if same else "CHANGED: no longer as described")
sys.exit(0 if same else 1)
PY
"$folder/venv/bin/python" "$folder/blocks.py"
