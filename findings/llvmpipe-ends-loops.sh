#!/usr/bin/env bash
# llvmpipe silently ends the loops of a shader once all its loops together have run 65535 iterations.
#
# Expected: a loop of a compute shader runs as often as its condition says, or the device is lost (a watchdog).
# Happens (Mesa 22.3.6, through Vulkan and through GL): all loops of one invocation share one allowance of 65535
# iterations. The loop that uses it up ends early. Each later loop runs one iteration. The code after them continues
# with unfinished values. No error is reported, and the device is not lost. A long ray through a decoder with many loops
# then gives a wrong picture.
#
# Runs without cvr: wgpu-native through Python, pinned below, in a temporary folder. Needs python3 with venv, and Mesa's
# llvmpipe for Vulkan or GL (Debian: mesa-vulkan-drivers). Exit code 0: it is still so; 1: it has changed; 2: it could
# not run.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-$folder}"
python3 -m venv "$folder/venv" || exit 2
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check wgpu==0.32.0 numpy==2.4.6 || exit 2
cat > "$folder/loops.py" <<'PY'
import sys

import numpy
import wgpu

SHADER = """
@group(0) @binding(0) var<storage, read> wanted: array<u32>;
@group(0) @binding(1) var<storage, read_write> rounds: array<u32>;

@compute @workgroup_size(1)
fn count() {
    // What the loops compute is written, so that no compiler may leave them out.
    var state = 1u;
    for (var loop_index = 0u; loop_index < 2u; loop_index++) {
        rounds[loop_index] = 0u;
    }
    for (var i = 0u; i < wanted[0]; i++) { state = state * 1664525u + 1013904223u; rounds[0]++; }
    for (var i = 0u; i < wanted[1]; i++) { state = state * 1664525u + 1013904223u; rounds[1]++; }
    rounds[2] = state;
}
"""
CASES = [(1000, 1000), (40000, 20000), (40000, 40000), (100000, 10)]


def count(device, wanted):
    """Rounds that two loops run one after the other, which should run `wanted` rounds."""
    asked = device.create_buffer_with_data(data=numpy.array(wanted, numpy.uint32), usage=wgpu.BufferUsage.STORAGE)
    told = device.create_buffer(size=12, usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC)
    module = device.create_shader_module(code=SHADER)
    pipeline = device.create_compute_pipeline(layout="auto", compute={"module": module, "entry_point": "count"})
    buffers = [{"buffer": asked, "size": 8}, {"buffer": told, "size": 12}]
    entries = [{"binding": i, "resource": {"offset": 0, **buffer}} for i, buffer in enumerate(buffers)]
    group = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
    encoder = device.create_command_encoder()
    compute = encoder.begin_compute_pass()
    compute.set_pipeline(pipeline)
    compute.set_bind_group(0, group)
    compute.dispatch_workgroups(1)
    compute.end()
    device.queue.submit([encoder.finish()])
    return tuple(int(n) for n in numpy.frombuffer(device.queue.read_buffer(told), numpy.uint32)[:2])


print(f"wgpu (Python) {wgpu.__version__}, numpy {numpy.__version__}")
seen = 0
same = True
for adapter in wgpu.gpu.enumerate_adapters_sync():
    info = adapter.info
    if "llvmpipe" not in info["device"]:
        continue
    seen += 1
    print(f"{info['device']}, {info['backend_type']}, {info['description']}")
    device = adapter.request_device_sync()
    for wanted in CASES:
        ran = count(device, wanted)
        print(f"  two loops of {wanted[0]:6} and {wanted[1]:5} rounds ran {ran[0]:6} and {ran[1]:5}")
        whole = sum(wanted) < 65000
        same &= (ran == wanted) == whole and (whole or ran[0] <= 65535 and ran[1] < wanted[1])
if seen == 0:
    print("no llvmpipe here")
    sys.exit(2)
print("as described" if same else "CHANGED: no longer as described")
sys.exit(0 if same else 1)
PY
"$folder/venv/bin/python" "$folder/loops.py"
