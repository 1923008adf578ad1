"""Cases with converged finite-element solutions, shown together with published values.

Published values are those of thin plates or of coarse elements, from 0.5 % below to 1.5 % above the converged
ones: they are shown, but not used in the comparison.
"""

import numpy as np

from analysis.geometry.loop import Loop
from analysis.geometry.shapes import ellipse, polygon, rectangle
from simulation.verification.case import Case, CaseMaterial
from simulation.verification.supports import Support

STEEL = CaseMaterial(youngs_modulus=200e9, poisson_ratio=0.3, density=8000.0)
"""Material of the NAFEMS benchmarks."""
CONVERGED = "converged p-version Mindlin solution; coarse and fine mesh agree to 0.002 %"
NAFEMS = "beside it NAFEMS, Selected Benchmarks for Natural Frequency Analysis (1987)"
SMOOTH_ERROR = 1e-4
"""Relative error allowed without re-entrant corners: five times the difference of a value's meshes."""
SINGULAR_ERROR = 4e-4
"""The same with a re-entrant corner, where stresses are singular."""


def plate(
    name: str,
    title: str,
    outline: Loop,
    thickness: float,
    supports: Support | tuple[Support, ...],
    values: str,
    *,
    length: float | None = 1.0,
    tolerance: float = SMOOTH_ERROR,
    source: str = CONVERGED,
    published: str = "",
) -> Case:
    """Return a case of steel, with its frequencies given as text.

    Parameters
    ----------
    thickness : float
        m.
    supports : str or tuple of str
        One for every curve of the outline, or one for all.
    values : str
        Lowest known frequencies, ascending, without rigid motions, separated by spaces.
    length : float, optional
        a, m, where `values` are w a**2 sqrt(rho h / D), without unit; None where they are in Hz.
    tolerance : float
        Largest relative error allowed; not below the accuracy of `values`.
    source : str
        Origin of `values`.
    published : str
        Published values, separated by spaces.

    Raises
    ------
    ValueError
        For values that are no numbers.
    """
    return Case(
        name=name,
        title=title,
        outline=outline,
        thickness=thickness,
        material=STEEL,
        supports=supports if isinstance(supports, tuple) else (supports,) * len(outline.curves),
        known=tuple(float(value) for value in values.split()),
        length=length,
        kind="converged",
        tolerance=tolerance,
        source=source,
        published=tuple(float(value) for value in published.split()),
    )


SQUARE = rectangle((5.0, 5.0), (10.0, 10.0))
COSINE = 10.0 * float(np.sqrt(0.5))
RHOMBUS = polygon([(0.0, 0.0), (10.0, 0.0), (10.0 + COSINE, COSINE), (COSINE, COSINE)])
TRIANGLE = polygon([(0.0, 0.0), (1.0, 0.0), (0.5, float(np.sqrt(0.75)))])
L_SHAPE = polygon([(0.0, 0.0), (1.0, 0.0), (1.0, 0.5), (0.5, 0.5), (0.5, 1.0), (0.0, 1.0)])
ELLIPSE = ellipse((0.0, 0.0), (1.0, 0.5))

PUBLISHED: tuple[Case, ...] = (
    plate(
        "fv12",
        "NAFEMS FV12: free square, 10 x 10 x 0.05 m",
        SQUARE,
        0.05,
        "free",
        "1.6184 2.3592 2.9218 4.1820 4.1820 7.3532",
        length=None,
        source=f"{CONVERGED}; {NAFEMS}",
        published="1.622 2.360 2.922 4.233 4.233 7.416",
    ),
    plate(
        "fv16",
        "NAFEMS FV16: square cantilever, 10 x 10 x 0.05 m",
        SQUARE,
        0.05,
        ("free", "free", "free", "clamped"),
        "0.4179 1.0227 2.5617 3.2720 3.7213 6.5103",
        length=None,
        tolerance=2e-4,
        source=f"{CONVERGED}, printed to 1.2e-4 of the lowest; {NAFEMS}",
        published="0.421 1.029 2.582 3.306 3.753 6.555",
    ),
    plate(
        "fv15",
        "NAFEMS FV15: clamped rhombus of 45°, side 10 m, thickness 0.05 m",
        RHOMBUS,
        0.05,
        "clamped",
        "7.8995 12.812 17.838 18.911 23.660 27.590",
        length=None,
        source=f"{CONVERGED}; {NAFEMS}",
        published="7.938 12.835 17.941 19.133 24.009 27.922",
    ),
    plate(
        "fv22",
        "NAFEMS FV22: thick clamped rhombus of 45°, side 10 m, thickness 1 m",
        RHOMBUS,
        1.0,
        "clamped",
        "133.402 201.912 266.919 280.793 336.119 378.328",
        length=None,
        source=f"{CONVERGED}; {NAFEMS}",
        published="133.95 201.41 265.81 283.68 334.45",
    ),
    plate(
        "triangle-free",
        "Free equilateral triangle, h/a 0.01",
        TRIANGLE,
        0.01,
        "free",
        "34.2086 35.8881 35.8881 84.349 84.349 91.252",
    ),
    plate(
        "triangle-clamped",
        "Clamped equilateral triangle, h/a 0.01",
        TRIANGLE,
        0.01,
        "clamped",
        "98.695 187.955 187.955 292.901 312.502 312.502",
    ),
    plate(
        "l-shape-clamped",
        "Clamped L (unit square less a quadrant), h/a 0.005",
        L_SHAPE,
        0.005,
        "clamped",
        "81.667 105.038 121.970 161.529 182.535 230.950",
        tolerance=SINGULAR_ERROR,
        source="converged p-version Mindlin solution; coarse and fine mesh agree to 0.007 %",
        published="81.88",
    ),
    plate(
        "l-shape-free",
        "Free L (unit square less a quadrant), h/a 0.005",
        L_SHAPE,
        0.005,
        "free",
        "15.6795 16.9647 27.1808 33.4995 60.0745 60.4381",
        tolerance=SINGULAR_ERROR,
    ),
    plate(
        "ellipse-clamped",
        "Clamped ellipse, b/a 0.5, h/a 0.01",
        ELLIPSE,
        0.01,
        "clamped",
        "27.3539 39.4521 55.8924 69.7244 76.8482 87.8421",
        source=f"{CONVERGED}; beside it values of the thin plate",
        published="27.377 39.497 55.985 69.858 77.037",
    ),
    plate(
        "ellipse-free",
        "Free ellipse, b/a 0.5, h/a 0.01",
        ELLIPSE,
        0.01,
        "free",
        "6.6668 10.5246 16.9035 21.9658 27.7373 31.4643",
        source=f"{CONVERGED}; beside it values of the thin plate",
        published="6.6705 10.548 16.923 22.015 27.768",
    ),
)
