"""Our codebook training against FAISS k-means, on the same vectors, in one run and with as many threads.

    pip install faiss-cpu numpy
    cargo build --release -p cvr-codebook --example train
    CVR_DATA=folder [GAIN=1e-3] python docs/benchmarks/codebook.py [THREADS] [CODEWORDS ...]

For each volume and block: at most 65536 blocks drawn by chance are the training set of both. FAISS takes its default
of 25 rounds from random vectors, ours begins with PCA splits; FAISS keeps single-precision codewords, ours has 8 bits
per value. Each codebook then codes *all* blocks (nearest codeword by faiss.IndexFlatL2 for both); the table gives
their mean squared error, and PSNR over max - min, unrounded. Seconds are of training alone, the median of five runs
taken in turn (one run with 4096 codewords): CPU seconds on one thread, wall-clock seconds on more. Ours ends with the
round that gains less than GAIN of the error.
"""
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

THREADS = int(sys.argv[1]) if len(sys.argv) > 1 else 1
SIZES = [int(a) for a in sys.argv[2:]] or [256, 4096]
GAIN = os.environ.get("GAIN", "1e-3")
os.environ["OMP_NUM_THREADS"] = str(THREADS)
import faiss
import numpy as np

from real_volumes import blocks, bonsai, colours, fingers, lidc_chest, mr_vs, vorticity

TRAIN = os.environ.get("TRAIN") or os.path.join(os.environ.get("CARGO_TARGET_DIR", "target"), "release/examples/train")
TRAINING_BLOCKS = 65536
ROUNDS = 25


def scalar(volume):
    return lambda edge: blocks(volume(), edge)


CASES = [
    ("bonsai", 2, scalar(bonsai), "integers"),
    ("mr_vs", 2, scalar(mr_vs), "integers"),
    ("lidc_chest", 2, scalar(lidc_chest), "integers"),
    ("vorticity", 2, scalar(vorticity), "reals"),
    ("bonsai", 4, scalar(bonsai), "integers"),
    ("mr_vs", 4, scalar(mr_vs), "integers"),
    ("lidc_chest", 4, scalar(lidc_chest), "integers"),
    ("vorticity", 4, scalar(vorticity), "reals"),
    ("dti_rgb, 3 colours", 4, colours, "integers"),
    ("viscous_fingers, 3 frames", 4, fingers, "reals"),
]


def mean_square(rows, codewords):
    """Of all blocks under a codebook; squared distances again in double precision."""
    index = faiss.IndexFlatL2(rows.shape[1])
    index.add(codewords)
    square = 0.0
    for i in range(0, len(rows), 65536):
        part = rows[i:i + 65536]
        chosen = index.search(part, 1)[1][:, 0]
        square += float(np.sum(np.square((part - codewords[chosen]).astype("f8"))))
    return square / rows.size


def faiss_means(vectors, size):
    cpu, wall = time.process_time(), time.perf_counter()
    means = faiss.Kmeans(vectors.shape[1], size, niter=ROUNDS, seed=1,
                         max_points_per_centroid=10 ** 9, min_points_per_centroid=1)
    means.train(vectors)
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    return cpu if THREADS == 1 else wall, means.centroids


def ours(vectors, size, kind, folder):
    source, out = os.path.join(folder, "vectors.f32"), os.path.join(folder, "codewords.f32")
    vectors.astype("<f4").tofile(source)
    told = subprocess.run([TRAIN, source, out, str(vectors.shape[1]), str(size), "8", GAIN, "50", kind], check=True,
                          capture_output=True, text=True, env={**os.environ, "RAYON_NUM_THREADS": str(THREADS)}).stdout
    told = json.loads(told)
    seconds = told["cpu_s"] if THREADS == 1 else told["wall_s"]
    return seconds, np.fromfile(out, "<f4").reshape(-1, vectors.shape[1]), told["rounds"]


def main():
    print(f"faiss {faiss.__version__}, numpy {np.__version__}, {THREADS} thread(s)", file=sys.stderr)
    print("| volume | block | values | vectors | codewords | FAISS: s | MSE | dB | ours: rounds | s | MSE | dB | MSE, ratio | time, ratio |")
    print("|" + "---|" * 14)
    with tempfile.TemporaryDirectory() as folder:
        for size in SIZES:
            for name, edge, rows_of, kind in CASES:
                rows = rows_of(edge).astype("f4")
                if len(rows) < 8 * size:
                    continue
                chosen = np.random.default_rng(1).permutation(len(rows))[:TRAINING_BLOCKS]
                vectors = np.ascontiguousarray(rows[np.sort(chosen)])
                theirs, own = [], []
                for _ in range(5 if size < 4096 else 1):
                    theirs.append(faiss_means(vectors, size))
                    own.append(ours(vectors, size, kind, folder))
                peak = (float(rows.max()) - float(rows.min())) ** 2
                seconds = [statistics.median(r[0] for r in runs) for runs in (theirs, own)]
                error = [mean_square(rows, runs[0][1]) for runs in (theirs, own)]
                text = [f"{s:.3f} | {e:.4g} | {10 * np.log10(peak / e):.2f}" for s, e in zip(seconds, error)]
                print(f"| {name} | {edge}³ | {rows.shape[1]} | {len(vectors)} | {size} | {text[0]} | {own[0][2]} | {text[1]} "
                      f"| {error[1] / error[0]:.3f} | {seconds[1] / seconds[0]:.2f} |", flush=True)


if __name__ == "__main__":
    main()
