"""Cases with exact solutions: discs, annuli, rectangles with hard simple supports."""

from analysis.geometry.shapes import circle, rectangle
from simulation.verification.case import Case, CaseMaterial
from simulation.verification.exact_discs import ExactDisc
from simulation.verification.exact_rectangles import HardRectangle, LevyPlate
from simulation.verification.supports import Support

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
