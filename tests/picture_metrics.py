"""Reference numbers of metrics of pictures, computed by other programs.

    pip install numpy tensorflow-cpu flip-evaluator
    python tests/picture_metrics.py

MS-SSIM: `tf.image.ssim_multiscale` of TensorFlow 2.21 on luma of full scale 1. FLIP: the authors' own program, as the
package `flip-evaluator` 1.7. The pictures are those of `painted.py`; the numbers stand in the tests beside `ms_ssim.rs`
and `flip.rs`. Those of SSIM are of `picture_ssim.py`.
"""

import flip_evaluator
import numpy as np
import tensorflow as tf
from painted import painted

EXPONENTS = np.array([0.0448, 0.2856, 0.3001, 0.2363, 0.1333])


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
