#!/usr/bin/env bash
# wgpu's GL backend copies slices of a 3-D texture to a buffer correctly only if the copy begins at slice 0.
#
# Expected: `copy_texture_to_buffer` with an origin of (0, 0, z) copies slices z, z + 1, ... as other backends do.
# Happens (wgpu-native of wgpu 0.32.0 for Python; wgpu-hal 30.0.1 for Rust as well; Mesa 22.3.6): no slice of such a copy
# equals that of the texture, and no error is reported. A copy of all slices from 0 on is correct. Through Vulkan the
# same program is correct on the same driver. A program that reads a large texture back in pieces reads zeros or wrong
# slices from the second piece on.
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
cat > "$folder/slices.py" <<'PY'
import sys

import numpy
import wgpu

# 64 texels of 4 bytes make rows of 256 bytes, the least that a copy may have.
WIDTH, HEIGHT, DEPTH = 64, 4, 4
ROW_BYTES, SLICE_TEXELS = 4 * WIDTH, WIDTH * HEIGHT
TEXELS = numpy.arange(SLICE_TEXELS * DEPTH, dtype=numpy.float32) + 1
COPIES = [(0, 4), (1, 1), (1, 3), (2, 2)]


def right_slices(adapter, first, count):
    """How many of the slices that are copied hold what the texture holds."""
    device = adapter.request_device_sync()
    usage = wgpu.TextureUsage.COPY_DST | wgpu.TextureUsage.COPY_SRC
    size = (WIDTH, HEIGHT, DEPTH)
    texture = device.create_texture(size=size, dimension="3d", format="r32float", usage=usage)
    rows = {"offset": 0, "bytes_per_row": ROW_BYTES, "rows_per_image": HEIGHT}
    device.queue.write_texture({"texture": texture}, TEXELS, rows, size)
    usage = wgpu.BufferUsage.COPY_DST | wgpu.BufferUsage.COPY_SRC
    buffer = device.create_buffer(size=count * HEIGHT * ROW_BYTES, usage=usage)
    encoder = device.create_command_encoder()
    source = {"texture": texture, "mip_level": 0, "origin": (0, 0, first)}
    encoder.copy_texture_to_buffer(source, {"buffer": buffer, **rows}, (WIDTH, HEIGHT, count))
    device.queue.submit([encoder.finish()])
    copied = numpy.frombuffer(device.queue.read_buffer(buffer), numpy.float32).reshape(count, SLICE_TEXELS)
    wanted = TEXELS.reshape(DEPTH, SLICE_TEXELS)[first : first + count]
    return int((copied == wanted).all(axis=1).sum())


print(f"wgpu (Python) {wgpu.__version__}, numpy {numpy.__version__}")
seen = set()
same = True
for adapter in wgpu.gpu.enumerate_adapters_sync():
    info = adapter.info
    if "llvmpipe" not in info["device"]:
        continue
    backend = info["backend_type"]
    seen.add(backend)
    print(f"{info['device']}, {backend}, {info['description']}")
    for first, count in COPIES:
        right = right_slices(adapter, first, count)
        print(f"  copy from slice {first}: {right} of {count} slices are right")
        same &= right == (0 if backend == "OpenGL" and first > 0 else count)
if "OpenGL" not in seen:
    print("no llvmpipe through GL here")
    sys.exit(2)
print("as described" if same else "CHANGED: no longer as described")
sys.exit(0 if same else 1)
PY
"$folder/venv/bin/python" "$folder/slices.py"
