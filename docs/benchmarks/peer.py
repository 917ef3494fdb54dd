"""SZ3, SPERR and zfp as commands on raw files, for the codec `external`.

usage: peer.py {sz3|sperr|zfp} {encode|decode} IN OUT --shape X Y Z --type TYPE [--value V]
       pip install numpy h5py hdf5plugin zfpy

Samples lie x fastest, little-endian, of TYPE u8, i8, u16, i16 or f32.  They are brought to 0..1 over their own range,
as the peers' own comparisons do, and V is

    sz3    the largest absolute error, as a share of the range
    sperr  bits per voxel
    zfp    bits per voxel (fixed rate)

The compressed file is lowest and highest sample as two single-precision numbers, and then the compressor's own bytes
without the file format around them.
"""
import argparse
import struct

import numpy as np

TYPES = {"u8": "<u1", "i8": "<i1", "u16": "<u2", "i16": "<i2", "f32": "<f4"}


def filter_of(compressor, value):
    import hdf5plugin
    if compressor == "sz3":
        return hdf5plugin.SZ3(absolute=value)
    # Without `swap` the axes of a box are read in the wrong order.
    return hdf5plugin.Sperr(rate=value, swap=True)


def encode(compressor, samples, value):
    if compressor == "zfp":
        import zfpy
        return zfpy.compress_numpy(samples, rate=value, write_header=False)
    import h5py
    with h5py.File("memory", "w", driver="core", backing_store=False) as file:
        data = file.create_dataset("d", data=samples, chunks=samples.shape, compression=filter_of(compressor, value))
        file.flush()
        mask, chunk = data.id.read_direct_chunk((0, 0, 0))
        if mask != 0:
            raise SystemExit(f"{compressor} did not compress")
        return chunk


def decode(compressor, stream, shape, value):
    if compressor == "zfp":
        import zfpy
        return zfpy._decompress(stream, zfpy.dtype_to_ztype(np.dtype("f4")), shape, rate=value)
    import h5py
    with h5py.File("memory", "w", driver="core", backing_store=False, rdcc_nbytes=0) as file:
        data = file.create_dataset("d", shape, "f4", chunks=shape, compression=filter_of(compressor, value))
        data.id.write_direct_chunk((0, 0, 0), stream)
        return data[...]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("compressor", choices=["sz3", "sperr", "zfp"])
    parser.add_argument("direction", choices=["encode", "decode"])
    parser.add_argument("input")
    parser.add_argument("output")
    parser.add_argument("--shape", type=int, nargs=3, required=True, metavar=("X", "Y", "Z"))
    parser.add_argument("--type", choices=TYPES, required=True)
    parser.add_argument("--value", type=float, default=1.0)
    args = parser.parse_args()
    shape, dtype = tuple(reversed(args.shape)), np.dtype(TYPES[args.type])
    if args.direction == "encode":
        samples = np.fromfile(args.input, dtype).reshape(shape).astype("f4")
        low, high = float(samples.min()), float(samples.max())
        # A constant field has no range to be brought to.
        unit = (samples - np.float32(low)) * np.float32(1 / (high - low) if high > low else 1)
        stream = encode(args.compressor, np.ascontiguousarray(unit), args.value)
        with open(args.output, "wb") as file:
            file.write(struct.pack("<2f", low, high) + bytes(stream))
    else:
        with open(args.input, "rb") as file:
            whole = file.read()
        low, high = struct.unpack("<2f", whole[:8])
        unit = decode(args.compressor, whole[8:], shape, args.value)
        samples = unit * np.float32(high - low if high > low else 1) + np.float32(low)
        if dtype.kind in "iu":
            limits = np.iinfo(dtype)
            samples = np.clip(np.rint(samples), limits.min, limits.max)
        samples.astype(dtype).tofile(args.output)


main()
