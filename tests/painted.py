"""The pictures that reference numbers of metrics are of, in steps of 1/255: painted in integers, as `painted` in
`core/src/metrics/image/tests.rs` does."""

import numpy as np


def painted(width, height):
    """Waves of three frequencies, and the same in fewer steps, with a square that is brighter."""
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    wave = lambda n: np.minimum(np.abs(n % 512 - 256), 255)
    fine = np.stack([wave(5 * x + 2 * y), wave(3 * x - 4 * y + 80), wave(x * x // 16 + 9 * y)], axis=-1)
    lift = np.where((x % 40 < 12) & (y % 50 < 20), 24, 0)[..., None]
    coarse = np.minimum(fine // 32 * 32 + 16 + lift, 255)
    return [(rgb / 255).astype(np.float32) for rgb in (fine, coarse)]
