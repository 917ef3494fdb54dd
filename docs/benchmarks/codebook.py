"""Our codebook training against FAISS k-means, on the same vectors, in one run and on one thread each.

    pip install faiss-cpu numpy
    cargo build --release -p cvr-codebook --example train
    CVR_DATA=folder python docs/benchmarks/codebook.py

For each volume and block: 65536 blocks drawn by chance are the training set of both. FAISS starts from random
vectors, ours from PCA splits; FAISS keeps single-precision codewords, ours has 8 bits per value. Each codebook then
codes *all* blocks (nearest codeword by faiss.IndexFlatL2 for both); the table gives their mean squared error as PSNR
over max - min, unrounded. Seconds are CPU seconds of training alone, the median of three runs.
"""
import gzip
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
import zlib

os.environ["OMP_NUM_THREADS"] = "1"
import faiss
import numpy as np

DATA = os.environ["CVR_DATA"]
TRAIN = os.path.join(os.environ.get("CARGO_TARGET_DIR", "target"), "release/examples/train")
TRAINING_BLOCKS = 65536
RUNS = 3


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


def psnr(rows, codewords, span):
    """dB of all blocks under a codebook; squared distances again in double precision."""
    index = faiss.IndexFlatL2(rows.shape[1])
    index.add(codewords)
    chosen = index.search(rows, 1)[1][:, 0]
    square = sum(float(np.sum(np.square((rows[i:i + 65536] - codewords[chosen[i:i + 65536]]).astype("f8"))))
                 for i in range(0, len(rows), 65536))
    return 10 * np.log10(span ** 2 * rows.size / square)


def faiss_means(vectors, size, rounds):
    begun = time.process_time()
    means = faiss.Kmeans(vectors.shape[1], size, niter=rounds, seed=1,
                         max_points_per_centroid=10 ** 9, min_points_per_centroid=1)
    means.train(vectors)
    return time.process_time() - begun, means.centroids


def ours(vectors, size, kind, folder):
    source, out = os.path.join(folder, "vectors.f32"), os.path.join(folder, "codewords.f32")
    vectors.astype("<f4").tofile(source)
    told = subprocess.run([TRAIN, source, out, str(vectors.shape[1]), str(size), "8", "1e-3", "50", kind], check=True,
                          capture_output=True, text=True, env={**os.environ, "RAYON_NUM_THREADS": "1"}).stdout
    told = json.loads(told)
    return told["cpu_s"], np.fromfile(out, "<f4").reshape(-1, vectors.shape[1]), told["rounds"]


def main():
    print(f"faiss {faiss.__version__}, numpy {np.__version__}, one thread", file=sys.stderr)
    print("| volume | block | codewords | FAISS, 10 rounds: s | dB | 25 rounds: s | dB | ours: rounds | s | dB | gain, dB | time |")
    print("|" + "---|" * 12)
    with tempfile.TemporaryDirectory() as folder:
        for volume in (bonsai, mr_vs, lidc_chest, vorticity):
            data = volume()
            kind = "integers" if data.dtype.kind == "u" else "reals"
            span = float(data.max()) - float(data.min())
            for edge, size in ((2, 256), (4, 256), (4, 1024)):
                rows = blocks(data, edge)
                chosen = np.random.default_rng(1).permutation(len(rows))[:TRAINING_BLOCKS]
                vectors = np.ascontiguousarray(rows[np.sort(chosen)])
                cells, last = [], None
                for rounds in (10, 25):
                    runs = [faiss_means(vectors, size, rounds) for _ in range(RUNS)]
                    last = statistics.median(r[0] for r in runs), psnr(rows, runs[0][1], span)
                    cells += [f"{last[0]:.2f}", f"{last[1]:.2f}"]
                runs = [ours(vectors, size, kind, folder) for _ in range(RUNS)]
                own = statistics.median(r[0] for r in runs), psnr(rows, runs[0][1], span)
                cells += [str(runs[0][2]), f"{own[0]:.2f}", f"{own[1]:.2f}"]
                cells += [f"{own[1] - last[1]:+.2f}", f"{own[0] / last[0]:.2f}"]
                print(f"| {volume.__name__} | {edge}³ | {size} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
