#!/usr/bin/env bash
# HDF5 gives back the original, not what a lossy filter has made of it, until the file is opened again.
#
# Expected: a dataset with a lossy filter (zfp, SZ3, SPERR) reads back as the filter decodes it, once it is written and
# flushed; so the error of a compressor can be measured by writing and reading.
# Happens (HDF5 2.0.0, h5py 3.16.0, hdf5plugin 7.1.0): chunks that fit the chunk cache (8 MiB, 1 MiB before HDF5 2.0)
# stay there as they were before the filter, flushed or not, so that the error reads 0. A chunk beyond the cache shows
# its loss at once. A rate-distortion table measured this way has infinite PSNR for small volumes and true figures for
# large ones.
#
# Runs without cvr: zfp as an HDF5 filter, versions pinned below, in a temporary folder. Needs python3 with venv. Exit
# code 0: it is still so; 1: it has changed; 2: it could not run.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv" || exit 2
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    hdf5plugin==7.1.0 h5py==3.16.0 numpy==2.4.6 || exit 2
cat > "$folder/judge.py" <<'PY'
import sys

import h5py
import hdf5plugin
import numpy

print("hdf5plugin", hdf5plugin.version, "h5py", h5py.__version__, "HDF5", h5py.version.hdf5_version)
path = sys.argv[1] + "/volume.h5"


def errors(side):
    """The largest error as read after a flush, and as read from the file opened again."""
    volume = numpy.random.default_rng(1).standard_normal((side,) * 3).astype(numpy.float32)
    with h5py.File(path, "w") as file:
        dataset = file.create_dataset("v", data=volume, chunks=volume.shape, **hdf5plugin.Zfp(rate=8))
        file.flush()
        stored = dataset.id.get_storage_size()
        flushed = numpy.abs(dataset[...] - volume).max()
    with h5py.File(path) as file:
        anew = numpy.abs(file["v"][...] - volume).max()
    print(f"{side} voxels a side, {volume.nbytes / 2**20:.2f} MiB, {stored / volume.nbytes:.2f} of it stored:"
          f" error {flushed:.3g} after a flush, {anew:.3g} from the file opened anew")
    return flushed, anew


small, large = errors(64), errors(160)
still = small[0] == 0 and small[1] > 0 and large[0] == large[1] and large[0] > 0
sys.exit(0 if still else 1)
PY
"$folder/venv/bin/python" "$folder/judge.py" "$folder"
