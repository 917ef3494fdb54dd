"""Our residual quantiser against that of FAISS, on the same volumes, in one run, one thread each.

    pip install faiss-cpu numpy
    cargo build --release -p cvr-codec-tests --example measure
    CVR_DATA=folder python docs/benchmarks/rvq.py [VOLUME ...] [STAGESxCODEWORDSxBEAM ...]

FAISS is trained greedily (beam 1, ten rounds of k-means for each stage) on at most 65536 blocks that are not flat and a
twentieth as many that are; with 4096 codewords on up to 262144. It codes all blocks with the beam of the row. Its codewords
are rounded to half precision. Ours has entries of 16 bits, its default training, and no joint training at beam 1 (`rounds`
0), or the default's with a beam. PSNR in dB over max - min, integers rounded. Seconds are CPU seconds of training and
coding; ours also count reading, writing and checking the file. Bits per sample count codes, and codes with codebooks.
"""
import os
import re
import subprocess
import sys
import time

os.environ["OMP_NUM_THREADS"] = "1"
import faiss
import numpy as np

import real_volumes
from real_volumes import blocks

MEASURE = os.path.join(os.environ.get("CARGO_TARGET_DIR", "target"), "release/examples/measure")
VOLUMES = ["bonsai", "mr_vs", "lidc_chest", "vorticity", "viscous_fingers", "pcasl"]
CASES = ["4x256x1", "8x256x1", "8x256x8", "4x4096x1"]
ROUNDS = 10


def rows_of(name):
    volume = getattr(real_volumes, name)()
    frames = volume if volume.ndim == 4 else volume[None]
    return volume, np.concatenate([blocks(frame, 4) for frame in frames]).astype("f4")


def training(rows, limit):
    flat = np.ptp(rows, axis=1) < 1e-6 * (rows.max() - rows.min())
    chance = np.random.default_rng(1)
    busy = chance.permutation(np.flatnonzero(~flat))[:limit]
    others = chance.permutation(np.flatnonzero(flat))[:max(1, len(busy) // 20)]
    return np.ascontiguousarray(rows[np.concatenate([busy, others])])


def peers(volume, rows, stages, codewords, beam):
    bits = codewords.bit_length() - 1
    scale = float(volume.max()) - float(volume.min())
    unit = (rows - float(volume.min())) / scale

    def quantiser(beam):
        made = faiss.ResidualQuantizer(64, stages, bits)
        made.train_type = faiss.ResidualQuantizer.Train_default | faiss.ResidualQuantizer.Skip_codebook_tables
        made.max_beam_size, made.cp.niter = beam, ROUNDS
        made.cp.max_points_per_centroid, made.cp.min_points_per_centroid = 10 ** 9, 1
        return made
    begun = time.process_time()
    trained = quantiser(1)
    trained.train(training(unit, 262144 if codewords > 256 else 65536))
    codebooks = faiss.vector_to_array(trained.codebooks).astype("f2").astype("f4")
    coder = quantiser(beam)
    faiss.copy_array_to_vector(codebooks, coder.codebooks)
    coder.is_trained = True
    codes = np.concatenate([coder.compute_codes(unit[i:i + 16384]) for i in range(0, len(unit), 16384)])
    seconds = time.process_time() - begun
    decoded = coder.decode(codes) * scale + float(volume.min())
    if volume.dtype.kind in "ui":
        decoded = np.clip(np.round(decoded), volume.min(), volume.max())
    # Border blocks are filled up; what lies outside counts for neither.
    inside = inside_of(volume)
    square = float(np.sum(np.square((decoded - rows)[inside].astype("f8"))))
    psnr = 10 * np.log10(scale ** 2 * volume.size / square)
    code_bits = len(rows) * stages * bits / volume.size
    return psnr, seconds, code_bits, code_bits + codebooks.size * 16 / volume.size


def inside_of(volume):
    frames = volume if volume.ndim == 4 else volume[None]

    def mask(shape):
        padded = np.zeros([-(-n // 4) * 4 for n in shape], "f4")
        padded[tuple(slice(0, n) for n in shape)] = 1
        return blocks(padded, 4) > 0
    return np.concatenate([mask(frame.shape) for frame in frames])


def ours(name, stages, codewords, beam):
    options = [f"stages={stages}", f"codewords={codewords}", f"beam={beam}", "entries=16"]
    options.append("refinement=0" if beam == 1 else "refinement=4")
    printed = subprocess.run([MEASURE, "rvq", name, *options], check=True, capture_output=True, text=True,
                             env={**os.environ, "RAYON_NUM_THREADS": "1"}).stdout
    rate, psnr, seconds = re.split(r" *\| *", printed.strip().splitlines()[-1])[3:6]
    return float(psnr), float(seconds), float(rate)


def main():
    names = [a for a in sys.argv[1:] if a in VOLUMES] or VOLUMES
    cases = [a for a in sys.argv[1:] if a not in VOLUMES] or CASES
    print(f"faiss {faiss.__version__}, numpy {np.__version__}", file=sys.stderr)
    print("| volume | stages × codewords | beam | bits of codes | FAISS: bits | PSNR | CPU s | ours: bits | PSNR | CPU s | dB more | time, ratio |")
    print("|" + "---|" * 12)
    for name in names:
        volume, rows = rows_of(name)
        for case in cases:
            stages, codewords, beam = map(int, case.split("x"))
            if len(rows) < 8 * codewords:
                continue
            psnr, seconds, codes, rate = peers(volume, rows, stages, codewords, beam)
            own, own_seconds, own_rate = ours(name, stages, codewords, beam)
            print(f"| {name} | {stages} × {codewords} | {beam} | {codes:.3f} | {rate:.3f} | {psnr:.2f} | {seconds:.2f} | {own_rate:.3f} "
                  f"| {own:.2f} | {own_seconds:.2f} | {own - psnr:+.2f} | {own_seconds / seconds:.2f} |", flush=True)


if __name__ == "__main__":
    main()
