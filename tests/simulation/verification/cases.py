"""All verification cases: those with exact solutions, and those with converged finite-element solutions.

Exact are discs, annuli and rectangles with hard simple supports. The others are shown together with published
values. Published values are those of thin plates or of coarse elements, from 0.5 % below to 1.5 % above the
converged ones: they are shown, but not used in the comparison.
"""

import numpy as np

from analysis.geometry.loop import Loop, circle, ellipse, polygon, rectangle
from tests.simulation.verification.case import Case, CaseMaterial, Support
from tests.simulation.verification.exact_plates import ExactDisc, HardRectangle, LevyPlate

ALUMINIUM = CaseMaterial(youngs_modulus=70e9, poisson_ratio=0.3, density=2700.0)
"""Material of the cases: normalised frequencies depend only on its Poisson's ratio."""
LARGEST_ERROR = 1e-4
"""Largest relative error allowed for the finite-element plate against an exact solution."""
TITLES: dict[Support, str] = {
    "free": "free",
    "clamped": "clamped",
    "soft": "soft simple support",
    "hard": "hard simple support",
}


def disc_case(thickness: float, outer: Support) -> Case:
    """Return the disc of radius 1 m and `thickness` m."""
    return Case(
        name=f"disc-{outer}-{thickness:g}",
        title=f"Disc, {TITLES[outer]}, h/a {thickness:g}",
        outline=circle((0.0, 0.0), 1.0),
        thickness=thickness,
        material=ALUMINIUM,
        supports=(outer,) * 4,
        known=ExactDisc(thickness, ALUMINIUM.poisson_ratio, outer),
        length=1.0,
        kind="exact",
        tolerance=LARGEST_ERROR,
        source="exact, Bessel functions",
        count=10,
    )


def annulus_case(thickness: float, inner: Support, outer: Support, hole: float = 0.3) -> Case:
    """Return the annulus of outer radius 1 m.

    Parameters
    ----------
    thickness : float
        m.
    inner, outer : str
        Supports of the two edges.
    hole : float
        Inner radius, m, below 1.
    """
    return Case(
        name=f"annulus-{inner}-{outer}-{thickness:g}",
        title=f"Annulus b/a {hole:g}, inside {TITLES[inner]}, outside {TITLES[outer]}, h/a {thickness:g}",
        outline=circle((0.0, 0.0), 1.0),
        thickness=thickness,
        material=ALUMINIUM,
        supports=(outer,) * 4,
        known=ExactDisc(thickness, ALUMINIUM.poisson_ratio, outer, hole, inner),
        length=1.0,
        kind="exact",
        tolerance=LARGEST_ERROR,
        source="exact, Bessel functions",
        holes=(circle((0.0, 0.0), hole),),
        hole_supports=((inner,) * 4,),
        count=10,
    )


def rectangle_case(thickness: float, lower: Support, upper: Support, width: float = 0.8) -> Case:
    """Return the rectangle of length 1 m on hard simple supports at its short edges, left and right.

    Parameters
    ----------
    thickness : float
        m.
    lower, upper : str
        Supports of the long edges.
    width : float
        m.
    """
    nu = ALUMINIUM.poisson_ratio
    all_hard = lower == upper == "hard"
    known = HardRectangle(thickness, nu, width) if all_hard else LevyPlate(thickness, nu, width, lower, upper)
    edges = "all edges" if all_hard else f"left and right, {TITLES[lower]} below, {TITLES[upper]} above"
    return Case(
        name=f"rectangle-{lower}-{upper}-{thickness:g}",
        title=f"Rectangle b/a {width:g}, hard simple support at {edges}, h/a {thickness:g}",
        outline=rectangle((0.5, 0.5 * width), (1.0, width)),
        thickness=thickness,
        material=ALUMINIUM,
        supports=(lower, "hard", upper, "hard"),
        known=known,
        length=1.0,
        kind="exact",
        tolerance=LARGEST_ERROR,
        source=f"exact, {'Navier' if all_hard else 'Levy'}",
    )


EXACT: tuple[Case, ...] = (
    *(disc_case(h, "free") for h in (0.01, 0.1, 0.2)),
    *(disc_case(h, "clamped") for h in (0.01, 0.1, 0.2)),
    disc_case(0.1, "soft"),
    disc_case(0.1, "hard"),
    *(annulus_case(h, inner, "free") for h in (0.01, 0.1) for inner in ("free", "clamped")),
    annulus_case(0.1, "soft", "clamped"),
    rectangle_case(0.01, "hard", "hard"),
    rectangle_case(0.1, "hard", "hard"),
    rectangle_case(0.1, "free", "free"),
    rectangle_case(0.1, "clamped", "free"),
    rectangle_case(0.1, "soft", "soft"),
)


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


CASES: tuple[Case, ...] = (*EXACT, *PUBLISHED)
