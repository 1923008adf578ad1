"""Nodes of another program's geometry, in its own coordinates, placed on a rectangular plate.

The plane through the nodes is turned into that of the plate, the smallest rectangle around them is laid along the
sides, and its middle on the plate's middle. Of the ways left, the one that turns least is taken.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Real

COORDINATE_ROUNDING = 1e-3
"""Share of the plate's longer side by which rounded coordinates may reach beyond an edge, or out of the plane."""
SPAN_TOLERANCE = 0.01
"""Share of a side by which nodes may span more than it: drawings and plates differ by a little."""

Place = tuple[float, ...]


@dataclass(frozen=True)
class PlacedNodes:
    """Nodes on a plate.

    Attributes
    ----------
    places : mapping of str to (float, float, float)
        m, from the plate's corner.
    note : str
        How they were moved, and what remains; empty where they lay on the plate as given.
    """

    places: Mapping[str, Place]
    note: str = ""


def placed_nodes(given: Mapping[str, Sequence[float]], sides: tuple[float, float]) -> PlacedNodes:
    """Place nodes on a plate.

    Parameters
    ----------
    given : mapping of str to (float, float, float)
        Coordinates by node, m.
    sides : (float, float)
        Lengths of the plate along x and y, m.

    Returns
    -------
    PlacedNodes

    Raises
    ------
    ValueError
        For nodes that do not fit the plate, with their size and its own.
    """
    if not given:
        return PlacedNodes({})
    nodes, here = list(given), np.array([tuple(place) for place in given.values()], dtype=float)
    near = COORDINATE_ROUNDING * max(sides)
    flat = np.ptp(here[:, 2]) <= near
    if flat and (here[:, :2] >= -near).all() and (here[:, :2] <= np.array(sides) + near).all():
        return PlacedNodes(dict(zip(nodes, map(tuple, here.tolist()), strict=True)))
    if len(nodes) < 3:
        raise ValueError(
            f"{len(nodes)} nodes that are not on the plate of {sides[0]:g} m x {sides[1]:g} m; three are needed "
            "to place them: give their places from a corner of the plate with --points"
        )
    middle = here.mean(axis=0)
    axes = _plane(here - middle)
    across = (here - middle) @ np.cross(*axes)
    plane = (here - middle) @ axes.T
    turned, angle = _turned(plane, sides)
    low, high = turned.min(axis=0), turned.max(axis=0)
    placed = turned - 0.5 * (low + high) + 0.5 * np.array(sides)
    margin = 0.5 * (np.array(sides) - (high - low))
    shift = placed.mean(axis=0) - middle[:2]
    degrees = 0.0 + round(float(np.degrees(angle)), 1)  # no minus sign before nothing
    note = (
        f"{len(nodes)} nodes were not on the plate as the files give them: turned by {degrees:.1f} degrees in "
        f"their plane and moved by {shift[0]:.4g} and {shift[1]:.4g} m, their middle now on that of the plate; "
        f"off their plane by {np.abs(across).max():.2g} m at most, {margin[0]:.3g} and {margin[1]:.3g} m from the "
        f"edges. Check that node {nodes[0]} is at {placed[0, 0]:.4g}, {placed[0, 1]:.4g} m: a half turn and a "
        "mirror image fit as well"
    )
    rows = [(round(float(x), 6), round(float(y), 6), 0.0) for x, y in placed]
    return PlacedNodes(dict(zip(nodes, rows, strict=True)), note)


def _plane(centred: Real) -> Real:
    """Return the two axes (2, 3) of the plane through nodes: those of x and y, as near as they are in it."""
    normal = np.linalg.svd(centred, full_matrices=False)[2][2]
    one, other = np.delete(np.arange(3), np.argmax(np.abs(normal)))  # a drawing in x and z is seen with z up
    x = np.eye(3)[one] - normal[one] * normal
    x /= np.linalg.norm(x)
    y = np.cross(normal, x)
    return np.array([x, y if y[other] > 0.0 else -y])


def _turned(plane: Real, sides: tuple[float, float]) -> tuple[Real, float]:
    """Turn nodes (N, 2) so that the smallest rectangle around them lies along the sides; also the angle, rad."""
    from scipy.spatial import ConvexHull, QhullError  # slow import

    try:
        hull = plane[ConvexHull(plane).vertices]
    except QhullError as error:
        raise ValueError(
            "the nodes lie on one line, which does not tell where they are on the plate; give their places from a "
            "corner of the plate with --points"
        ) from error
    edges = np.roll(hull, -1, axis=0) - hull
    ways: list[tuple[float, float, float]] = []
    spans = []
    for direction in np.unique(np.round(np.arctan2(edges[:, 1], edges[:, 0]) % (0.5 * np.pi), 9)):
        for angle in (-direction, 0.5 * np.pi - direction):
            span = np.ptp(hull @ _rotation(angle).T, axis=0)
            spans.append(span)
            if (span <= (1.0 + SPAN_TOLERANCE) * np.array(sides)).all():
                ways.append((float(np.prod(span)), abs(float(angle)), float(angle)))
    if not ways:
        smallest = min(spans, key=lambda span: float(np.prod(span)))
        raise ValueError(
            f"the nodes span {smallest[0]:.4g} m x {smallest[1]:.4g} m, the plate {sides[0]:g} m x {sides[1]:g} "
            "m: are they in another unit, or of another plate? Give places on the plate, m, with --points"
        )
    least = min(area for area, _, _ in ways)
    angle = min((size, angle) for area, size, angle in ways if area <= least * (1.0 + 1e-6))[1]
    return plane @ _rotation(angle).T, angle


def _rotation(angle: float) -> Real:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])
