"""Plates whose natural frequencies are computed as solids: the declaration, and the blocks of the solid's mesh."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from solid_plate import Block, Layer, Place, Solid, straight

from analysis.arrays import Real
from simulation.shell.piezo_material import NCE51

EDGE = 1.5
"""Width of the strips of cells along edges, in thicknesses: the layer in which the stresses of an edge decay."""
STEEL, ALUMINIUM, PLASTIC = (200e9, 0.30, 7850.0), (70e9, 0.33, 2700.0), (2e9, 0.40, 905.0)
"""E [Pa], nu, density [kg/m3]."""


@dataclass(frozen=True)
class SolidCase:
    """A plate as declared and as a solid.

    Attributes
    ----------
    name : str
    plate : dict
        As of `analysis.experiment.Plate`, without its mass.
    material : (float, float, float)
        E [Pa], nu, density [kg/m3].
    blocks : tuple of Block
    modes : int
        Elastic modes to be stored.
    patches : tuple of dict
        As of `analysis.experiment.Patch`.
    solids : dict of str to Solid
        Materials of the layers, where they are not that of the plate alone.
    held : float or None
        x of a face that does not move, m.
    """

    name: str
    plate: dict[str, Any]
    material: tuple[float, float, float]
    blocks: tuple[Block, ...]
    modes: int = 20
    patches: tuple[dict[str, Any], ...] = ()
    solids: dict[str, Solid] = field(default_factory=dict)
    held: float | None = None

    @property
    def materials(self) -> dict[str, Solid]:
        """All materials of the solid by the names of the layers."""
        e, nu, density = self.material
        return {"PLATE": Solid((e, nu), density), **self.solids}


def body(h: float) -> tuple[Layer, ...]:
    """Return the one layer of a plate of thickness h, m."""
    return (Layer(-0.5 * h, 0.5 * h, "PLATE"),)


def lines(
    ends: tuple[float, float], h: float, spacing: float, inner: Sequence[float] = ()
) -> list[tuple[float, int]]:
    """Return ends and cells of the pieces of an axis: strips at both ends, other cells about `spacing` wide, m."""
    places = [ends[0], ends[0] + EDGE * h, *inner, ends[1] - EDGE * h, ends[1]]
    counts = [1, *(max(round((b - a) / spacing), 1) for a, b in pairwise(places[1:-1])), 1]
    return list(zip(places[1:], counts, strict=True))


def grid(x: list[tuple[float, int]], y: list[tuple[float, int]], h: float) -> list[Block]:
    """Rectangular blocks over the pieces of both axes, which begin at 0."""
    found = []
    for k, (right, across) in enumerate(x):
        for j, (top, along) in enumerate(y):
            left, low = x[k - 1][0] if k else 0.0, y[j - 1][0] if j else 0.0
            found.append(Block(straight((left, right), (low, top)), (across, along), body(h)))
    return found


def rectangle(
    name: str, sides: tuple[float, float], h: float, spacing: float, solid: tuple[float, float, float],
    *, modes: int = 20, held: float | None = None, solids: dict[str, Solid] | None = None, **more: Any,
) -> SolidCase:  # fmt: skip
    """Return a rectangular plate; `more` goes into its declaration."""
    x, y = (lines((0.0, side), h, spacing) for side in sides)
    plate = {"length_x": sides[0], "length_y": sides[1], "thickness": h, **more}
    return SolidCase(name, plate, solid, tuple(grid(x, y, h)), modes, solids=solids or {}, held=held)


def middle(block: Block) -> tuple[float, float]:
    """Middle of a block, m."""
    x, y = block.place(np.array([0.5]), np.array([0.5]))
    return float(x[0]), float(y[0])


def with_layers(blocks: Sequence[Block], low: Real, high: Real, layers: tuple[Layer, ...]) -> tuple[Block, ...]:
    """Add layers to the blocks within a rectangle from `low` to `high`, m."""
    found = []
    for block in blocks:
        inside = bool((np.array(middle(block)) > low).all() and (np.array(middle(block)) < high).all())
        found.append(Block(block.place, block.cells, block.layers + layers) if inside else block)
    return tuple(found)


def sector(center: tuple[float, float], quarter: int, inner: float, outer: float, half: float | None) -> Place:
    """Quarter of a ring between two radii, or from the inner radius to a square of half side `half`, m."""
    start = np.deg2rad(-45.0 + 90.0 * quarter)
    ends = np.sqrt(2.0) * np.array([[np.cos(a), np.sin(a)] for a in (start, start + 0.5 * np.pi)])

    def place(s: Real, t: Real) -> tuple[Real, Real]:
        angle = start + 0.5 * np.pi * s
        unit = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        far = outer * unit if half is None else half * ((1.0 - s)[:, None] * ends[0] + s[:, None] * ends[1])
        found = np.array(center) + (1.0 - t)[:, None] * inner * unit + t[:, None] * far
        return found[:, 0], found[:, 1]

    # a place with s along the arc and t outwards is left-handed: exchange them
    return lambda s, t: place(t, s)


HOLE = (0.30, 0.07)
"""Middle of the hole of the L, m; a square of 0.1 m around it is meshed in quarters."""


def l_blocks(x: list[tuple[float, int]], y: list[tuple[float, int]], h: float) -> list[Block]:
    """Return the blocks of the L over the pieces of both axes."""
    e, blocks = EDGE * h, []
    for block in grid(x, y, h):
        at = middle(block)
        if abs(at[0] - HOLE[0]) < 0.05 and abs(at[1] - HOLE[1]) < 0.05:
            for quarter in range(4):
                blocks.append(Block(sector(HOLE, quarter, 0.03, 0.03 + e, None), (1, block.cells[0]), body(h)))
                blocks.append(Block(sector(HOLE, quarter, 0.03 + e, 0.0, 0.05), (1, block.cells[0]), body(h)))
        elif at[1] < 0.14 or at[0] < 0.18:
            blocks.append(block)
    return blocks


def l_with_hole() -> SolidCase:
    """Return the L of aluminium with a round hole."""
    h, spacing, e = 0.004, 0.033, EDGE * 0.004
    x = lines((0.0, 0.40), h, spacing, (0.18 - e, 0.18, 0.25, 0.35))
    y = lines((0.0, 0.30), h, spacing, (0.02, 0.12, 0.14 - e, 0.14))
    corners = [[0.0, 0.0], [0.40, 0.0], [0.40, 0.14], [0.18, 0.14], [0.18, 0.30], [0.0, 0.30]]
    plate = {
        "outline": {"kind": "polygon", "points": corners},
        "hole": [{"kind": "circle", "center": HOLE, "radius": 0.03}],
        "thickness": h,
    }
    return SolidCase("l-with-hole", plate, ALUMINIUM, tuple(l_blocks(x, y, h)), 14)


def step_of_thickness() -> SolidCase:
    """Return a rectangle of 3 mm with a zone of 6 mm, both symmetric about the mid-plane."""
    h, low, high = 0.003, (0.07, 0.05), (0.17, 0.13)
    x = lines(
        (0.0, 0.24), h, 0.026, (low[0] - 0.006, low[0], low[0] + 0.006, high[0] - 0.006, high[0], high[0] + 0.006)
    )
    y = lines(
        (0.0, 0.19), h, 0.026, (low[1] - 0.006, low[1], low[1] + 0.006, high[1] - 0.006, high[1], high[1] + 0.006)
    )
    more = (Layer(-0.003, -0.0015, "PLATE", 0.5), Layer(0.0015, 0.003, "PLATE", 0.5))
    blocks = with_layers(grid(x, y, h), np.array(low), np.array(high), more)
    zone = {"kind": "rectangle", "center": (0.12, 0.09), "size": (0.10, 0.08), "thickness": 0.006}
    plate = {"length_x": 0.24, "length_y": 0.19, "thickness": h, "zone": [zone]}
    return SolidCase("step-of-thickness", plate, STEEL, blocks, 14)


def with_patch() -> SolidCase:
    """Return a rectangle of plastic with a patch of short-circuited ceramic, elastic only."""
    h, t, center, beside = 0.003, 0.0005, (0.04, 0.035), 0.002
    ends = [[place + side * 0.01 + off for side in (-1, 1) for off in (-beside, 0.0, beside)] for place in center]
    x, y = (lines((0.0, side), h, 0.03, inner) for side, inner in zip((0.14, 0.11), ends, strict=True))
    low, high = np.array(center) - 0.01, np.array(center) + 0.01
    blocks = with_layers(grid(x, y, h), low, high, (Layer(0.5 * h, 0.5 * h + t, "CERAMIC"),))
    patch = {"id": "P", "role": "actuator", "center": center, "size": (0.02, 0.02), "thickness": t}
    plate = {"length_x": 0.14, "length_y": 0.11, "thickness": h}
    ceramic = Solid((NCE51.youngs_modulus, NCE51.poisson_ratio), NCE51.density)
    return SolidCase("with-patch", plate, PLASTIC, blocks, 14, (patch,), {"CERAMIC": ceramic})


def orthotropic() -> SolidCase:
    """Return a sheet with a ratio of moduli of 1.5."""
    (e, nu, density), delta, more = PLASTIC, 0.2, 0.1
    ratio, shear = nu * np.sqrt((1.0 - delta) / (1.0 + delta)), 0.5 * e / (1.0 + nu)
    constants = (e * (1.0 - delta), e * (1.0 + delta), e, ratio, nu, nu, shear * (1.0 + more), shear, shear)
    declared = {"orthotropy": {"delta_e": delta, "delta_g": more, "delta_s": 0.0}}
    solids = {"PLATE": Solid(tuple(float(c) for c in constants), density)}
    return rectangle("orthotropic", (0.24, 0.19), 0.006, 0.03, PLASTIC, solids=solids, material=declared)


PANEL = ((0.40, 0.30), 0.004, 0.04, ALUMINIUM)
CLAMPED = [{"kind": "clamped", "edge": "left"}]
CASES: tuple[SolidCase, ...] = (
    rectangle("rectangle-steel", (0.24, 0.19), 0.006, 0.03, STEEL),
    rectangle("rectangle-thick", (0.24, 0.19), 0.012, 0.03, ALUMINIUM),
    rectangle("rectangle-plastic", (0.24, 0.19), 0.008, 0.03, PLASTIC),
    rectangle("cantilever", (0.24, 0.19), 0.006, 0.03, ALUMINIUM, modes=14, held=0.0, support=CLAMPED),
    rectangle("cylinder-0.7", *PANEL, modes=14, curvature={"radius_x": 0.7}),
    rectangle("cylinder-1.5", *PANEL, modes=14, curvature={"radius_x": 1.5}),
    rectangle("sphere-2", *PANEL, modes=14, curvature={"radius": 2.0}),
    rectangle("saddle-2", *PANEL, modes=14, curvature={"radius_x": 2.0, "radius_y": -2.0}),
    orthotropic(),
    l_with_hole(),
    with_patch(),
    step_of_thickness(),
)
