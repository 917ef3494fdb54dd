"""Reference numbers of SSIM, computed by scikit-image and SciPy.

    pip install numpy==2.4.6 scipy==1.17.1 scikit-image==0.26.0
    python tests/picture_ssim.py

The pictures are those of `painted.py`. `whole` is scikit-image's mean over the whole frame. `visible` is of pictures that
show nothing to the right, on black: the reference its left three fifths, the other two columns more; 1 − Σ(1 − s) ÷
visible pixels, with the s of scikit-image's full map, which mirrors pictures at their border. The numbers stand in the
tests of `core/src/metrics/image/ssim.rs`.
"""

import numpy as np
from painted import painted
from scipy.ndimage import gaussian_filter
from skimage.metrics import structural_similarity

WINDOW = dict(gaussian_weights=True, sigma=1.5, use_sample_covariance=False)


def luma(rgb):
    return rgb.astype(np.float64) @ [0.299, 0.587, 0.114]


def small(a, b):
    """The map of pictures smaller than the window, which scikit-image refuses."""
    mean = lambda plane: gaussian_filter(plane, sigma=1.5, truncate=3.5, mode="reflect")
    x, y = mean(a), mean(b)
    variances, covariance = mean(a * a) - x * x + mean(b * b) - y * y, mean(a * b) - x * y
    c1, c2 = 0.01**2, 0.03**2
    return (2 * x * y + c1) * (2 * covariance + c2) / ((x * x + y * y + c1) * (variances + c2))


for width, height in [(192, 180), (100, 90), (31, 11), (7, 5)]:
    a, b = (luma(rgb) for rgb in painted(width, height))
    x = np.arange(width)[None, :] + np.zeros((height, 1), int)
    visible, drawn = 5 * x < 3 * width, 5 * x < 3 * width + 10
    left = (a * visible, b * drawn)
    if min(width, height) >= 11:
        whole = structural_similarity(a, b, data_range=1, **WINDOW)
        full = structural_similarity(*left, data_range=1, full=True, **WINDOW)[1]
        assert np.abs(full - small(*left)).max() < 1e-12
    else:
        whole, full = float("nan"), small(*left)
    shown = 1 - (1 - full).sum() / visible.sum()
    print((width, height), f"whole {whole:.6f}  visible {shown:.6f}")
