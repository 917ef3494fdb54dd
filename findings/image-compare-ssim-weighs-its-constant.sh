#!/usr/bin/env bash
# The SSIM of the Rust crate image-compare differs from the SSIM that papers report.
#
# Expected: `Algorithm::MSSIMSimple` of image-compare gives about the mean SSIM of Wang et al. 2004, as scikit-image and
# other programs do, up to its plain window.
# Happens (image-compare 0.5.0, scikit-image 0.26.0): on a dim object before a black ground its distance from 1 is 29
# times the paper's. Its tiles of 8 x 8 pixels carry variances and covariance as *sums* over the tile. The constant C2
# then weighs 1/64 of what it weighs in the paper, and noise that no eye sees counts as lost structure. Figures of the
# two programs must not be in one table.
#
# Runs without cvr: one small program in Rust and one in Python over the same two pictures, versions pinned below, in a
# temporary folder. Needs cargo and python3 with venv. Exit code 0: it is still so; 1: it has changed; 2: it could not run.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv" || exit 2
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check scikit-image==0.26.0 numpy==2.4.6 || exit 2
cat > "$folder/pictures.py" <<'PY'
# A dim disc before black, and the same with each grey level off by at most one.
import sys

import numpy

side = 128
y, x = numpy.mgrid[0:side, 0:side]
inside = (x - 64) ** 2 + (y - 64) ** 2 < 40**2
first = numpy.where(inside, 40, 0).astype(numpy.uint8)
off = (x * 7 + y * 13) % 3 - 1
second = numpy.clip(first.astype(int) + numpy.where(inside, off, 0), 0, 255).astype(numpy.uint8)
first.tofile(sys.argv[1] + "/first.raw")
second.tofile(sys.argv[1] + "/second.raw")
PY
"$folder/venv/bin/python" "$folder/pictures.py" "$folder"
mkdir -p "$folder/own/src"
cat > "$folder/own/Cargo.toml" <<'TOML'
[package]
name = "own"
version = "0.0.0"
edition = "2021"
[dependencies]
image-compare = "=0.5.0"
[workspace]
TOML
cat > "$folder/own/src/main.rs" <<'RUST'
use image_compare::{gray_similarity_structure, prelude::GrayImage, Algorithm};

fn main() {
    let folder = std::env::args().nth(1).expect("a folder");
    let read = |name: &str| {
        let bytes = std::fs::read(format!("{folder}/{name}.raw")).expect("a picture");
        GrayImage::from_raw(128, 128, bytes).expect("128 x 128 pixels")
    };
    let compared = gray_similarity_structure(&Algorithm::MSSIMSimple, &read("first"), &read("second"));
    println!("{:.4}", compared.expect("equal sizes").score);
}
RUST
own=$(cargo run --quiet --manifest-path "$folder/own/Cargo.toml" -- "$folder") || exit 2
cat > "$folder/judge.py" <<'PY'
import sys

import numpy
import skimage
from skimage.metrics import structural_similarity

folder, own = sys.argv[1], float(sys.argv[2])
first, second = (numpy.fromfile(f"{folder}/{n}.raw", numpy.uint8).reshape(128, 128) for n in ("first", "second"))
paper = structural_similarity(first, second, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=255)
print(f"scikit-image {skimage.__version__}, Gaussian window as in Wang et al. 2004: {paper:.4f}")
print(f"image-compare 0.5.0, MSSIMSimple:                              {own:.4f}")
same = 1 - own > 10 * (1 - paper)
print("as described" if same else "CHANGED: no longer as described")
sys.exit(0 if same else 1)
PY
"$folder/venv/bin/python" "$folder/judge.py" "$folder" "$own"
