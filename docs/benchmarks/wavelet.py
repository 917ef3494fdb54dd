"""The codec `wavelet` beside SPERR, SZ3, zfp and JPEG 2000, in one run.

    pip install numpy h5py hdf5plugin zfpy imagecodecs
    cargo build --release -p cvr --bin cvr
    cargo build --release -p cvr-wavelet --example speed
    CVR_DATA=folder python docs/benchmarks/wavelet.py {rates|lossless|speed|zfp|cpu} [VOLUME ...]

rates     PSNR over max - min, integers rounded, at 0.25, 0.5, 1 and 2 bits per voxel. `file`: whole files of `cvr`, in which
          SPERR's stream and two singles take the place of ours. `payload`: SPERR's bits and the singles without the file around
          them, and ours with as many more bits as the header takes. SZ3 has bounds, no rates: its PSNR is interpolated over the
          logarithm of the rate. Files of volumes with frames have one header.
lossless  bits per sample without loss. SZ3 has a bound just below half a unit, and that of the peers' table. JPEG 2000 codes
          slices along z, each on its own, three channels as colours; only the bytes of the codestreams count.
speed     seconds inside the library call, of encoding and decoding at half a bit: the best of five calls, in ROUNDS rounds
          in turn with SPERR. The ratio is the median of the rounds' ratios.
zfp       the same of decoding with the coder `deflate`, and of zfp with a fixed accuracy at the same PSNR.
cpu       CPU seconds of one thread, for a busy machine, the least of five: SPERR and zfp inside the library call; ours of the whole
          commands `cvr encode` and `cvr decode`. The codec `raw` shows what reading and writing files takes of these.

RAYON_NUM_THREADS and OMP_NUM_THREADS set the number of threads.
"""
import os
import re
import resource
import statistics
import subprocess
import sys
import tempfile
import time

import h5py
import hdf5plugin
import numpy as np

import real_volumes

BUILT = os.path.join(os.environ.get("CARGO_TARGET_DIR", "target"), "release")
CVR, SPEED = os.path.join(BUILT, "cvr"), os.path.join(BUILT, "examples/speed")
RATES = [0.25, 0.5, 1.0, 2.0]
ROUNDS = 3
TOLERANCES = [2 ** -3, 2 ** -4, 2 ** -5]
# Bytes of a file of `cvr` around a stream, and SPERR's two singles for each frame.
HEADER, SINGLES = 2048, 8


def frames_of(name):
    """Frames of (z, y, x), or of (z, y, x, channel) of dti_rgb. Of viscous_fingers, one frame."""
    if name == "viscous_fingers":
        volume = real_volumes.viscous_fingers()[44 - 21]
    else:
        volume = getattr(real_volumes, name)()
    return volume if name == "pcasl" else volume[None]


def psnr(frames, decoded):
    span = float(frames.max()) - float(frames.min())
    if frames.dtype.kind in "iu":
        decoded = np.clip(np.rint(decoded), frames.min(), frames.max())
    square = float(np.mean(np.square(decoded.astype("f8") - frames)))
    return 10 * np.log10(span ** 2 / square) if square else np.inf


def h5(frame, filter_):
    """Seconds of encoding and decoding, bytes, and decoded samples, of one chunk without cache."""
    with h5py.File("memory", "w", driver="core", backing_store=False, rdcc_nbytes=0) as file:
        begun = time.perf_counter()
        data = file.create_dataset("d", data=frame, chunks=frame.shape, compression=filter_)
        file.flush()
        encoded = time.perf_counter()
        decoded = data[...]
        done = time.perf_counter()
        return encoded - begun, done - encoded, data.id.get_storage_size(), decoded


def unit(frame):
    low, high = float(frame.min()), float(frame.max())
    return (frame.astype("f4") - np.float32(low)) * np.float32(1 / (high - low)), low, high - low


def peer(frames, filter_):
    """Bytes and PSNR."""
    decoded, size = [], 0
    for frame in frames:
        samples, low, span = unit(frame)
        _, _, own, back = h5(samples, filter_)
        decoded.append(back * np.float32(span) + np.float32(low))
        size += own
    return size, psnr(frames, np.stack(decoded))


def sperr(frames, rate):
    # Without `swap` the axes of a box are read in the wrong order.
    return peer(frames, hdf5plugin.Sperr(rate=rate, swap=True))


TYPES = {"u1": "u8", "u2": "u16", "f4": "f32"}


def ours(frames, settings):
    """Bytes of the file and PSNR."""
    with tempfile.TemporaryDirectory() as folder:
        source, coded, out = (os.path.join(folder, name) for name in ("source.raw", "volume.cvr", "decoded.raw"))
        frames.tofile(source)
        channels = frames.shape[4] if frames.ndim == 5 else 1
        shape = ["--dims", "x".join(map(str, reversed(frames.shape[1:4]))), "--frames", str(len(frames)), "--channels", str(channels)]
        options = [part for setting in settings for part in ("--set", setting)]
        subprocess.run([CVR, "encode", source, coded, "--codec", "wavelet", *options, *shape, "--dtype", TYPES[frames.dtype.str[1:]]],
                       check=True, stdout=subprocess.DEVNULL)
        subprocess.run([CVR, "decode", coded, out], check=True, stdout=subprocess.DEVNULL)
        return os.path.getsize(coded), psnr(frames, np.fromfile(out, frames.dtype).reshape(frames.shape))


def at_rate(rows, rate):
    """PSNR at a rate between (rate, PSNR) rows, over the logarithm of the rate; none outside."""
    rows = sorted(row for row in rows if np.isfinite(row[1]))
    if not rows or rate < rows[0][0] or rate > rows[-1][0]:
        return None
    return float(np.interp(np.log(rate), [np.log(r) for r, _ in rows], [p for _, p in rows]))


def show(value):
    return "–" if value is None else "lossless" if not np.isfinite(value) else f"{value:.2f}"


def more(own, other):
    return f"{own - other:+.2f}" if other is not None and np.isfinite(own) and np.isfinite(other) else "–"


def rates(names):
    print("| volume | bits | count | wavelet: bits | PSNR | SPERR: bits | PSNR | difference | SZ3 | difference |")
    print("|" + "---|" * 10)
    for name in names or ["bonsai", "lidc_chest", "mr_vs", "vorticity", "pcasl", "viscous_fingers"]:
        frames = frames_of(name)
        voxels = frames.size / 8
        bounds = [0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005, 0.0002, 0.0001]
        bounded = [peer(frames, hdf5plugin.SZ3(absolute=bound)) for bound in bounds]
        for rate in RATES:
            for count, header in [("payload", 0), ("file", HEADER)]:
                around = SINGLES * len(frames) + header
                size, peers = sperr(frames, rate - around / voxels if header else rate)
                asked = rate if header else (size + HEADER + SINGLES * len(frames)) / voxels
                own_size, own = ours(frames, [f"bits_per_voxel={asked}"])
                own_bits = (own_size - (0 if header else HEADER)) / voxels
                sz3 = at_rate([((n + around) / voxels, p) for n, p in bounded], own_bits)
                print(f"| {name} | {rate} | {count} | {own_bits:.4f} | {show(own)} | {(size + around) / voxels:.4f} | {show(peers)} "
                      f"| {more(own, peers)} | {show(sz3)} | {more(own, sz3)} |", flush=True)


def jpeg2000(frames):
    """Bytes of reversible codestreams of slices."""
    import imagecodecs
    size = 0
    for frame in frames:
        for image in frame:
            coded = imagecodecs.jpeg2k_encode(image, codecformat="j2k", reversible=True, level=0)
            if not np.array_equal(imagecodecs.jpeg2k_decode(coded), image):
                raise SystemExit("JPEG 2000 lost something")
            size += len(coded)
    return size


def lossless(names):
    print("| volume | wavelet 5-3 | blocks 16, 5-3 | blocks 8, 5-3 | blocks 8, haar | JPEG 2000 | 5-3 ÷ JPEG 2000 | SZ3, < ½ unit | SZ3, peers' bound |")
    print("|" + "---|" * 9)
    for name in names or ["bonsai", "lidc_chest", "mr_vs", "dti_rgb"]:
        frames = frames_of(name)
        voxels, bits = frames.size / 8, []
        for settings in (["filter=5-3"], ["filter=5-3", "block=16"], ["filter=5-3", "block=8"], ["filter=haar", "block=8"]):
            size, quality = ours(frames, settings)
            if np.isfinite(quality):
                raise SystemExit(f"{settings} lost something")
            bits.append(size / voxels)
        span = float(frames.max()) - float(frames.min())
        scalars = frames if frames.ndim == 4 else np.ascontiguousarray(np.moveaxis(frames[0], 3, 0))
        sz3 = [peer(scalars, hdf5plugin.SZ3(absolute=bound)) for bound in (0.49 / span, 0.0005)]
        shown = [f"{size / voxels:.4f}" + ("" if np.isfinite(quality) else f" ({quality:.1f} dB)") for size, quality in sz3]
        jpeg = jpeg2000(frames) / voxels
        print(f"| {name} | {' | '.join(f'{b:.4f}' for b in bits)} | {jpeg:.4f} | {bits[0] / jpeg:.3f} | {shown[0]} | {shown[1]} |", flush=True)


def timed(name, settings):
    """Bits, PSNR, seconds of encoding and of decoding."""
    printed = subprocess.run([SPEED, name, *settings], check=True, capture_output=True, text=True).stdout
    return [float(cell) for cell in re.split(r" *\| *", printed.strip().splitlines()[-1])[3:7]]


def threads():
    return os.environ.get("RAYON_NUM_THREADS", "all")


def speed(names):
    print("| volume | threads | wavelet: bits | PSNR | encode s | decode s | SPERR: PSNR | encode s | decode s | encode, ratio | decode, ratio |")
    print("|" + "---|" * 11)
    for name in names or ["bonsai"]:
        samples, low, span = unit(frames_of(name)[0])
        rounds = []
        for _ in range(ROUNDS):
            own = timed(name, ["bits_per_voxel=0.5"])
            five = [h5(samples, hdf5plugin.Sperr(rate=0.5, swap=True)) for _ in range(5)]
            rounds.append((own, min(f[0] for f in five), min(f[1] for f in five), five[-1][3]))
        quality = psnr(frames_of(name)[0], rounds[-1][3] * np.float32(span) + np.float32(low))
        (bits, own_quality), best = rounds[0][0][:2], [min(r[0][2] for r in rounds), min(r[0][3] for r in rounds)]
        others = [min(r[1] for r in rounds), min(r[2] for r in rounds)]
        ratios = [statistics.median(r[0][2 + i] / r[1 + i] for r in rounds) for i in (0, 1)]
        print(f"| {name} | {threads()} | {bits:.3f} | {own_quality:.2f} | {best[0]:.3f} | {best[1]:.3f} | {quality:.2f} | {others[0]:.3f} "
              f"| {others[1]:.3f} | {ratios[0]:.2f} | {ratios[1]:.2f} |", flush=True)


def zfp(names):
    import zfpy
    print("| volume | threads | wavelet deflate: bits | PSNR | decode s | zfp: bits | PSNR | decode s | decode, ratio |")
    print("|" + "---|" * 9)
    for name in names or ["bonsai"]:
        frame = frames_of(name)[0]
        samples, low, span = unit(frame)
        for tolerance in TOLERANCES:
            coded = zfpy.compress_numpy(samples, tolerance=tolerance)
            quality = psnr(frame, zfpy.decompress_numpy(coded) * np.float32(span) + np.float32(low))
            rounds = []
            for _ in range(ROUNDS):
                own = timed(name, ["coder=deflate", f"psnr={quality - 0.1:.3f}"])
                calls = []
                for _ in range(5):
                    begun = time.perf_counter()
                    zfpy.decompress_numpy(coded)
                    calls.append(time.perf_counter() - begun)
                rounds.append((own, min(calls)))
            own = rounds[0][0]
            print(f"| {name} | {threads()} | {own[0]:.3f} | {own[1]:.2f} | {min(r[0][3] for r in rounds):.3f} | {8 * len(coded) / samples.size:.3f} "
                  f"| {quality:.2f} | {min(r[1] for r in rounds):.3f} | {statistics.median(r[0][3] / r[1] for r in rounds):.2f} |", flush=True)


def cpu_of(*command):
    """CPU seconds of a command on one thread."""
    def used():
        now = resource.getrusage(resource.RUSAGE_CHILDREN)
        return now.ru_utime + now.ru_stime
    all_ = []
    for _ in range(5):
        begun = used()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env={**os.environ, "RAYON_NUM_THREADS": "1"})
        all_.append(used() - begun)
    return min(all_)


SETTINGS = [["bits_per_voxel=0.5"], ["filter=5-3"],
            *([f"coder={coder}", f"quality={quality}", "filter=cdf-2-6"]
              for quality in (255, 31) for coder in ("arithmetic", "zerotree", "contexts", "runs", "deflate"))]


def cpu(names):
    import zfpy
    print("| volume | what | bits | PSNR | encode s | decode s |")
    print("|" + "---|" * 6)
    for name in names or ["bonsai"]:
        frame = frames_of(name)[0]
        samples, low, span = unit(frame)
        show_peer = lambda what, bits, decoded, times: print(
            f"| {name} | {what} | {bits:.3f} | {psnr(frame, decoded * np.float32(span) + np.float32(low)):.2f} "
            f"| {min(t[0] for t in times):.2f} | {min(t[1] for t in times):.2f} |", flush=True)
        clock, time.perf_counter = time.perf_counter, time.process_time
        calls = [h5(samples, hdf5plugin.Sperr(rate=0.5, swap=True)) for _ in range(5)]
        time.perf_counter = clock
        show_peer("SPERR, 0.5", 8 * calls[0][2] / samples.size, calls[0][3], calls)
        settings = list(SETTINGS)
        for tolerance in TOLERANCES:
            times = []
            for _ in range(5):
                begun = time.process_time()
                coded = zfpy.compress_numpy(samples, tolerance=tolerance)
                middle = time.process_time()
                decoded = zfpy.decompress_numpy(coded)
                times.append((middle - begun, time.process_time() - middle))
            show_peer(f"zfp, {tolerance}", 8 * len(coded) / samples.size, decoded, times)
            quality = psnr(frame, decoded * np.float32(span) + np.float32(low))
            settings.append(["coder=deflate", f"psnr={quality - 0.1:.2f}"])
        with tempfile.TemporaryDirectory() as folder:
            source, coded, out = (os.path.join(folder, file) for file in ("source.raw", "volume.cvr", "decoded.raw"))
            frame.tofile(source)
            shape = ["--dims", "x".join(map(str, reversed(frame.shape))), "--dtype", TYPES[frame.dtype.str[1:]]]

            def both(codec, *own):
                options = [part for setting in own for part in ("--set", setting)]
                encode = cpu_of(CVR, "encode", source, coded, "--codec", codec, *options, *shape)
                return encode, cpu_of(CVR, "decode", coded, out)
            encode, decode = both("raw")
            print(f"| {name} | raw | {8 * os.path.getsize(coded) / frame.size:.3f} | lossless | {encode:.2f} | {decode:.2f} |", flush=True)
            for own in settings:
                encode, decode = both("wavelet", *own)
                quality = psnr(frame, np.fromfile(out, frame.dtype).reshape(frame.shape))
                print(f"| {name} | {', '.join(own)} | {8 * os.path.getsize(coded) / frame.size:.3f} | {show(quality)} "
                      f"| {encode:.2f} | {decode:.2f} |", flush=True)


def main():
    kinds = {"rates": rates, "lossless": lossless, "speed": speed, "zfp": zfp, "cpu": cpu}
    if len(sys.argv) < 2 or sys.argv[1] not in kinds:
        raise SystemExit(__doc__)
    kinds[sys.argv[1]](sys.argv[2:])


if __name__ == "__main__":
    main()
