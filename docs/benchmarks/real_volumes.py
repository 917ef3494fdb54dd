"""The real volumes as arrays, and their blocks as rows, for the comparisons with FAISS. CVR_DATA names their folder."""
import gzip
import os
import zlib

import numpy as np

DATA = os.environ["CVR_DATA"]


def whole(name):
    with open(os.path.join(DATA, name), "rb") as f:
        return f.read()


def bonsai():
    packed = whole("bonsai.nrrd")
    return np.frombuffer(gzip.decompress(packed[packed.index(b"\n\n") + 2:]), "u1").reshape(256, 256, 256)


def mr_vs():
    return np.frombuffer(zlib.decompress(whole("mr_vs.zraw")), "<u2").reshape(120, 416, 352)


def lidc_chest():
    packed, mark = whole("lidc_chest.mha"), b"ElementDataFile = LOCAL\n"
    return np.frombuffer(zlib.decompress(packed[packed.index(mark) + len(mark):]), "u1").reshape(133, 256, 256)


def vorticity():
    return np.frombuffer(whole("vorticity.128_128_41"), "<f4").reshape(41, 128, 128)


def blocks(volume, edge):
    """(z, y, x) to rows of edge^3 values; the last voxels are repeated at the border."""
    volume = np.pad(volume.astype("f4"), [(0, -n % edge) for n in volume.shape], mode="edge")
    z, y, x = (n // edge for n in volume.shape)
    rows = volume.reshape(z, edge, y, edge, x, edge).transpose(0, 2, 4, 1, 3, 5)
    return np.ascontiguousarray(rows).reshape(-1, edge ** 3)


def pcasl():
    """Ten frames behind a header, single precision."""
    return np.frombuffer(gzip.decompress(whole("pcasl.nii.gz")), "<f4", offset=352).reshape(10, 20, 68, 52)


def dti_rgb():
    """(z, y, x, channel) behind a header of 352 bytes."""
    return np.frombuffer(gzip.decompress(whole("example_rgb.nii.gz")), "u1", offset=352).reshape(60, 96, 96, 3)


def viscous_fingers():
    """24 frames."""
    return np.stack([np.frombuffer(whole(f"viscous_fingers/step{t:03}.raw"), "<f4").reshape(64, 64, 64) for t in range(21, 45)])


def colours(edge):
    """dti_rgb: the three colours of a block as one row."""
    channels = [blocks(dti_rgb()[..., c], edge) for c in range(3)]
    return np.stack(channels, axis=2).reshape(len(channels[0]), -1)


def fingers(edge):
    """viscous_fingers: blocks of three frames in turn, from each of the first 22."""
    frames = [blocks(step, edge) for step in viscous_fingers()]
    return np.concatenate([np.concatenate(frames[t:t + 3], axis=1) for t in range(22)])
