"""Reference numbers for the tests of this folder: SciPy's PchipInterpolator, and the package `bjontegaard`.

    pip install scipy==1.17.1 bjontegaard
    python src/report/bjontegaard/reference.py > src/report/bjontegaard/reference.json
"""

import json

import bjontegaard
import numpy
from scipy.interpolate import PchipInterpolator

# Knots that meet every case of the slopes: rising, flat, turning, uneven, two and three of them.
KNOTS = [
    [[0.0, 1.0], [1.0, 3.0]],
    [[0.0, 0.0], [1.0, 1.0], [1.5, 1.0]],
    [[-1.0, 5.0], [0.0, 1.0], [4.0, 2.0]],
    [[0.0, 0.0], [0.1, 4.0], [3.0, 4.5], [3.2, 9.0]],
    [[0.0, 1.0], [1.0, 1.0], [2.0, 0.0], [3.0, 0.5], [7.0, 0.4], [7.5, 8.0]],
    [[0.0, 0.0], [1.0, 1.0], [1.2, -9.0]],
    [[-0.86, 28.4], [-0.57, 33.2], [-0.25, 37.0], [0.3, 38.1], [0.6, 46.0], [0.63, 52.0]],
]

# Rate and quality. The first pair is that of the spreadsheet with VCEG-M33; the others are uneven, cross, overlap in
# part, and differ in their numbers of points.
PAIRS = [
    [
        [[686.76, 40.28], [309.58, 37.18], [157.11, 34.24], [85.95, 31.42]],
        [[893.34, 40.39], [407.8, 37.21], [204.93, 34.17], [112.75, 31.24]],
    ],
    [
        [[0.13, 28.4], [0.27, 33.2], [0.56, 37.0], [2.25, 44.0], [4.2, 51.0]],
        [[0.2, 33.0], [0.4, 35.5], [0.9, 38.0], [3.0, 45.5]],
    ],
    [
        [[1.0, 30.0], [2.0, 38.0], [4.0, 39.0], [8.0, 52.0]],
        [[1.1, 33.0], [1.9, 36.0], [4.2, 42.0], [7.9, 50.0], [9.0, 55.0]],
    ],
]


def interpolant(knots):
    x, y = numpy.array(knots).T
    pchip = PchipInterpolator(x, y)
    at = numpy.linspace(x[0], x[-1], 23)
    low, high = at[3], at[17]
    return {
        "knots": knots,
        "values": [[float(a), float(pchip(a))] for a in at],
        "integral": [float(low), float(high), float(pchip.integrate(low, high))],
    }


def difference(pair):
    anchor, test = (sorted(curve) for curve in pair)
    (ra, qa), (rt, qt) = numpy.array(anchor).T, numpy.array(test).T
    a, t = PchipInterpolator(numpy.log10(ra), qa), PchipInterpolator(numpy.log10(rt), qt)
    low, high = max(a.x[0], t.x[0]), min(a.x[-1], t.x[-1])
    decibels = (t.integrate(low, high) - a.integrate(low, high)) / (high - low)
    a, t = PchipInterpolator(qa, numpy.log10(ra)), PchipInterpolator(qt, numpy.log10(rt))
    low, high = max(a.x[0], t.x[0]), min(a.x[-1], t.x[-1])
    percent = 100 * (10 ** ((t.integrate(low, high) - a.integrate(low, high)) / (high - low)) - 1)
    # A program of other authors, by the same interpolation.
    more = {"method": "pchip", "require_matching_points": False, "min_overlap": 0.0}
    others = [bjontegaard.bd_psnr(ra, qa, rt, qt, **more), bjontegaard.bd_rate(ra, qa, rt, qt, **more)]
    assert numpy.allclose([decibels, percent], others, rtol=1e-9), (decibels, percent, others)
    return {"anchor": pair[0], "test": pair[1], "decibels": float(decibels), "percent": float(percent)}


print(json.dumps({"interpolants": [interpolant(k) for k in KNOTS], "differences": [difference(p) for p in PAIRS]}, indent=1))
