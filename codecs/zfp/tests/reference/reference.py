"""What zfp makes of volumes, through its own Python binding: `reference.json`.

usage: reference.py [FOLDER] > reference.json

Needs numpy and zfpy (written with zfpy 1.0.1). Writes the SHA-256 (its first 128 bits) of the samples of each volume in
single precision, and for each rate of the streams without header and of the decoded values, all little-endian, frame
after frame and channel after channel. The volumes of `GENERATED` come from integer arithmetic, which tests/equal_to_zfp.rs repeats. FOLDER holds
the real volumes; without it they are left out.
"""
import gzip
import hashlib
import json
import os
import sys
import zlib

import numpy as np
import zfpy

RATES = {"generated": [0.25, 1, 1.1, 2, 4, 8, 16, 32], "real": [1, 2, 4, 8]}
SIZES = [(13, 17, 23), (6, 7, 5), (4, 4, 4), (1, 1, 11), (1, 29, 1), (37, 1, 1), (1, 1, 1), (16, 8, 12)]


def generated(kind, size):
    """The volume of a kind, z slowest; every sample follows from integers without rounding."""
    x, y, z = size
    p = np.stack([np.broadcast_to(a, (z, y, x)) for a in np.ogrid[:z, :y, :x]][::-1]).astype(np.uint64)
    h = np.full((z, y, x), 0x9E3779B9, np.uint64)
    for v in p:
        h = ((h ^ v) * 0x85EBCA6B) & 0xFFFFFFFF
        h ^= h >> 13
        h = (h * 0xC2B2AE35) & 0xFFFFFFFF
        h ^= h >> 16
    s, h = p.sum(0).astype(np.int64), h.astype(np.int64)
    if kind == "zero":
        v = s * 0
    elif kind == "constant":
        v = s * 0 + 77
    elif kind == "ramp":
        v = p[0].astype(np.int64) + 2 * p[1].astype(np.int64) + 3 * p[2].astype(np.int64)
    elif kind == "bytes":
        v = h >> 24
    elif kind in ("signed", "tiny", "large"):
        v = (h >> 8) - (1 << 23)
    elif kind == "sparse":
        v = np.where((p[0] // 4 + p[1] // 4 + p[2] // 4) % 3 == 0, (h >> 20) - 2048, 0)
    elif kind == "magnitudes":
        v = (h >> 16) - (1 << 15)
    v = v.astype(np.float64)
    if kind == "tiny":
        v *= 2.0 ** -100
    if kind == "large":
        v *= 2.0 ** 100
    if kind == "magnitudes":
        v *= 2.0 ** ((h & 63) - 40).astype(np.float64)
    return v.astype(np.float32)


KINDS = ["zero", "constant", "ramp", "bytes", "signed", "tiny", "large", "sparse", "magnitudes"]


def real(folder):
    """Names, and the frames of each channel, z slowest."""
    def content(name):
        return open(os.path.join(folder, name), "rb").read()

    def scalar(data, dtype, size):
        return np.frombuffer(data, dtype).reshape(-1, *size[::-1])

    def nifti(name):
        data = gzip.decompress(content(name))
        return data[int(np.frombuffer(data, "<f4", 1, 108)[0]):]

    yield "bonsai", scalar(gzip.decompress(content("bonsai.nrrd").split(b"\n\n", 1)[1]), "u1", (256, 256, 256))
    yield "mr_vs", scalar(zlib.decompress(content("mr_vs.zraw")), "<u2", (352, 416, 120))
    chest = content("lidc_chest.mha").split(b"ElementDataFile = LOCAL\n", 1)[1]
    yield "lidc_chest", scalar(zlib.decompress(chest), "u1", (256, 256, 133))
    yield "vorticity", scalar(content("vorticity.128_128_41"), "<f4", (128, 128, 41))
    steps = sorted(os.listdir(os.path.join(folder, "viscous_fingers")))
    fingers = b"".join(content(os.path.join("viscous_fingers", step)) for step in steps)
    yield "viscous_fingers", scalar(fingers, "<f4", (64, 64, 64))
    yield "pcasl", scalar(nifti("pcasl.nii.gz"), "<f4", (52, 68, 20))
    yield "dti_rgb", np.frombuffer(nifti("example_rgb.nii.gz"), "u1").reshape(60, 96, 96, 3).transpose(3, 0, 1, 2)


def digest(parts):
    return hashlib.sha256(b"".join(parts)).hexdigest()[:32]


def checksums(frames, rates):
    frames = [np.ascontiguousarray(frame, dtype="<f4") for frame in frames]
    # A device may flush subnormal numbers, so that no source of a codec holds any.
    tiny = np.finfo("f4").tiny
    frames = [np.where(np.abs(frame) < tiny, np.float32(0), frame) for frame in frames]
    out = {"samples": digest(frame.tobytes() for frame in frames), "rates": {}}
    for rate in rates:
        streams, decoded = [], []
        for frame in frames:
            coded = zfpy.compress_numpy(frame, rate=rate, write_header=False)
            back = zfpy._decompress(coded, zfpy.dtype_to_ztype(frame.dtype), frame.shape, rate=rate)
            assert np.isfinite(back).all() and not ((back != 0) & (np.abs(back) < tiny)).any()
            streams.append(coded)
            # Zeros of either sign are equal.
            decoded.append((back + np.float32(0)).tobytes())
        out["rates"][f"{rate:g}"] = {"stream": digest(streams), "decoded": digest(decoded)}
    return out


def main():
    volumes = {}
    for kind in KINDS:
        # Every kind at odd sizes, and one at all sizes.
        for size in SIZES if kind == "signed" else SIZES[:2]:
            volumes[f"{kind} {'x'.join(map(str, size))}"] = checksums([generated(kind, size)], RATES["generated"])
    if len(sys.argv) > 1:
        for name, frames in real(sys.argv[1]):
            volumes[name] = checksums(frames, RATES["real"])
    json.dump({"zfpy": zfpy.__version__, "volumes": volumes}, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
