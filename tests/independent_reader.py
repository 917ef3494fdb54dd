"""Reads volumes with other software than cvr, and prints a line of JSON for each.

Arguments: the folder of real volumes. Its MANIFEST.toml says which there are. A line has `name`, `dims` [x, y, z],
`channels`, `frames`, `spacing`, and of the samples as little-endian single precision (x fastest, channels
interleaved, frame after frame) `sha256`, `min`, `max` and `sum`.

Needs numpy, nibabel, pynrrd and SimpleITK; exits with 3 and says what is missing where one is not there.
"""

import hashlib
import json
import os
import sys

try:
    import tomllib

    import nibabel
    import nrrd
    import numpy as np
    import SimpleITK as sitk
except ImportError as missing:
    print(missing, file=sys.stderr)
    sys.exit(3)


def read_nrrd(path, _):
    data, header = nrrd.read(path)
    directions = header.get("space directions")
    spacing = header["spacings"] if directions is None else np.linalg.norm(directions, axis=1)
    return data.transpose(2, 1, 0)[None, ..., None], spacing


def read_metaimage(path, _):
    image = sitk.ReadImage(path)
    return sitk.GetArrayFromImage(image)[None, ..., None], image.GetSpacing()


def read_raw(path, volume):
    order = {"little": "<", "big": ">"}[volume["endian"]]
    number = np.dtype(volume["dtype"]).newbyteorder(order)
    files = [path]
    if os.path.isdir(path):
        files = [os.path.join(path, name) for name in sorted(os.listdir(path))]
    x, y, z = volume["dims"][:3]
    frames = [np.fromfile(file, number).reshape(z, y, x, 1) for file in files]
    return np.stack(frames), volume["spacing"]


def read_nifti(path, _):
    image = nibabel.load(path)
    data = np.asarray(image.dataobj)
    if data.dtype.names:
        data = np.stack([data[name] for name in data.dtype.names], axis=-1)
        return data.transpose(2, 1, 0, 3)[None], image.header.get_zooms()
    if data.ndim == 3:
        data = data[..., None]
    return data.transpose(3, 2, 1, 0)[..., None], image.header.get_zooms()


READERS = {"nrrd": read_nrrd, "metaimage": read_metaimage, "raw": read_raw, "nifti": read_nifti}


def main():
    folder = sys.argv[1]
    with open(os.path.join(folder, "MANIFEST.toml"), "rb") as file:
        volumes = tomllib.load(file)["volume"]
    for volume in volumes:
        data, spacing = READERS[volume["format"]](os.path.join(folder, volume["file"]), volume)
        frames, z, y, x, channels = data.shape
        samples = np.ascontiguousarray(data, dtype="<f4")
        print(json.dumps({
            "name": volume["name"],
            "dims": [x, y, z],
            "channels": channels,
            "frames": frames,
            "spacing": [float(s) for s in spacing[:3]],
            "sha256": hashlib.sha256(samples.tobytes()).hexdigest(),
            "min": float(samples.min()),
            "max": float(samples.max()),
            "sum": float(samples.sum(dtype=np.float64)),
        }))


main()
