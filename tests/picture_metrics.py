"""Reference numbers of metrics of pictures, computed by other programs.

    pip install numpy tensorflow-cpu flip-evaluator
    python tests/picture_metrics.py

MS-SSIM: `tf.image.ssim_multiscale` of TensorFlow 2.21 on luma of full scale 1. FLIP: the authors' own program, as the
package `flip-evaluator` 1.7. The pictures are painted in integers, as `painted` in `core/src/metrics/image/tests.rs`
does; the numbers stand in the tests beside `ms_ssim.rs` and `flip.rs`.
"""

import flip_evaluator
import numpy as np
import tensorflow as tf

EXPONENTS = np.array([0.0448, 0.2856, 0.3001, 0.2363, 0.1333])


def painted(width, height):
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    wave = lambda n: np.minimum(np.abs(n % 512 - 256), 255)
    fine = np.stack([wave(5 * x + 2 * y), wave(3 * x - 4 * y + 80), wave(x * x // 16 + 9 * y)], axis=-1)
    lift = np.where((x % 40 < 12) & (y % 50 < 20), 24, 0)[..., None]
    coarse = np.minimum(fine // 32 * 32 + 16 + lift, 255)
    return [(rgb / 255).astype(np.float32) for rgb in (fine, coarse)]


def ms_ssim(a, b):
    luma = lambda rgb: tf.constant((rgb.astype(np.float64) @ [0.299, 0.587, 0.114])[..., None])
    sides = [-(-min(a.shape[:2]) // 2**scale) for scale in range(5)]
    exponents = EXPONENTS[: sum(side >= 11 for side in sides)]
    return float(tf.image.ssim_multiscale(luma(a), luma(b), 1.0, list(exponents / exponents.sum())))


def flip(a, b):
    return float(flip_evaluator.evaluate(a, b, "LDR", applyMagma=False)[1])


for size in [(192, 180), (203, 161), (100, 90), (31, 11)]:
    pair = painted(*size)
    print(size, f"MS-SSIM {ms_ssim(*pair):.6f}  FLIP {flip(*pair):.6f}")
