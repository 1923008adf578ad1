"""Plates drawn by chance: outlines of every kind; patches close to each other, to edges, and across each other."""

from collections.abc import Callable

import numpy as np
import pytest

from analysis.geometry import loop as loops
from analysis.geometry.loop import Loop
from analysis.geometry.relations import gap, leaves, overlap
from simulation.meshing.mesher import Border

RandomPlate = tuple[list[Border], float]
CLEAR = 1e-3
"""Patches of one face, and holes, stand at least this far apart, m, or touch an edge exactly."""


def outline(rng: np.random.Generator) -> tuple[str, Loop, list[Loop]]:
    """Kind, outline and holes of a plate 0.1 to 0.6 m long."""
    length = float(rng.uniform(0.1, 0.6))
    width = length * float(rng.uniform(0.45, 1.0))
    kind = str(rng.choice(["rectangle", "triangle", "L", "ellipse", "polygon", "spline", "trim"]))
    turn = float(rng.uniform(0.0, 2.0 * np.pi))
    holes: list[Loop] = []
    if kind == "rectangle":
        loop = loops.rectangle((0.0, 0.0), (length, width), turn * float(rng.integers(2)))
    elif kind == "triangle":
        loop = loops.polygon([(0.0, 0.0), (length, 0.0), (length * float(rng.uniform(0.1, 0.9)), width)])
    elif kind == "L":
        a, b = length * float(rng.uniform(0.35, 0.65)), width * float(rng.uniform(0.35, 0.65))
        loop = loops.polygon([(0, 0), (length, 0), (length, b), (a, b), (a, width), (0, width)])
    elif kind == "ellipse":
        loop = loops.ellipse((0.0, 0.0), (0.5 * length, 0.5 * width), turn)
    elif kind == "polygon":
        angles = np.sort(rng.uniform(0.0, 0.7, 6)) + np.arange(6) * 2.0 * np.pi / 6.0
        radius = 0.5 * length * rng.uniform(0.6, 1.0, 6)
        corners = np.stack([radius * np.cos(angles), radius * np.sin(angles)], axis=1)
        loop = loops.polygon([(float(x), float(y)) for x, y in corners])
    elif kind == "spline":
        angles = np.arange(10) * 2.0 * np.pi / 10.0
        radius = 0.5 * length * (1.0 + 0.15 * rng.standard_normal(10)).clip(0.7, 1.3)
        loop = loops.closed_spline(np.stack([radius * np.cos(angles), 0.8 * radius * np.sin(angles)], axis=1))
    else:
        cut = float(rng.uniform(0.1, 0.3))
        loop = loops.polygon(
            [(0, 0), (length, 0), (length, (1 - cut) * width), ((1 - cut) * length, width), (0, 0.9 * width)]
        )
        holes.append(loops.ellipse((0.4 * length, 0.45 * width), (0.15 * length, 0.1 * width), turn))
        if rng.integers(2):
            holes.append(loops.circle((0.75 * length, 0.3 * width), 0.05 * width))
    return kind, loop, holes


def patch(rng: np.random.Generator, center: tuple[float, float]) -> Loop:
    """One upright, rotated or round patch of 10 to 30 mm."""
    size = (float(rng.uniform(0.01, 0.03)), float(rng.uniform(0.01, 0.03)))
    form = int(rng.integers(3))
    if form == 2:
        return loops.circle(center, 0.5 * size[0])
    return loops.rectangle(center, size, float(rng.uniform(0.0, np.pi)) if form else 0.0)


def proposal(rng: np.random.Generator, loop: Loop, patches: list[tuple[Loop, int]]) -> tuple[Loop, int]:
    """Draw a patch and its face: anywhere, near or over another one, or flush with a straight edge."""
    face, how = int(rng.integers(2)), int(rng.integers(5))
    low, high = loop.bounds
    x, y = rng.uniform(low, high)
    if patches and how == 0:  # on the other face, at the same place
        other, its = patches[int(rng.integers(len(patches)))]
        return other, 1 - its
    if patches and how in (1, 2):  # near or across another one
        other, its = patches[int(rng.integers(len(patches)))]
        angle, far = float(rng.uniform(0.0, 2 * np.pi)), float(rng.uniform(0.004, 0.035))
        center = other.centroid[0] + far * np.cos(angle), other.centroid[1] + far * np.sin(angle)
        return patch(rng, center), 1 - its if how == 1 else its
    if how == 3:  # flush with an edge, or a little away from it
        curve = loop.curves[int(rng.integers(len(loop.curves)))]
        foot, along = curve.at(float(rng.uniform(0.25, 0.75))), curve.derivative(0.5)
        along = along / np.hypot(*along)
        inward = np.array([-along[1], along[0]])
        away = 0.0 if type(curve).__name__ == "Segment" and rng.integers(2) else float(rng.uniform(0.001, 0.008))
        size = float(rng.uniform(0.01, 0.03))
        x, y = foot + (away + 0.5 * size) * inward
        return loops.rectangle((float(x), float(y)), (size, size), float(np.arctan2(along[1], along[0]))), face
    return patch(rng, (float(x), float(y))), face


def allowed(one: Loop, face: int, loop: Loop, holes: list[Loop], patches: list[tuple[Loop, int]]) -> bool:
    """Whether a plate's declaration takes a patch there."""
    if leaves(one, loop) is not None or any(overlap(one, hole) is not None for hole in holes):
        return False
    if any(gap(one, hole)[0] < CLEAR for hole in holes):
        return False
    same = [other for other, its in patches if its == face]
    return not any(overlap(one, other) is not None or gap(one, other)[0] < CLEAR for other in same)


@pytest.fixture(scope="session")
def random_plate() -> Callable[[int], RandomPlate]:
    """Borders and thickness, m, of the plate of a seed."""

    def drawn(seed: int) -> RandomPlate:
        rng = np.random.default_rng(seed)
        _, loop, holes = outline(rng)
        patches: list[tuple[Loop, int]] = []
        wanted, tries = int(rng.integers(2, 6)), 0
        while len(patches) < wanted and tries < 200:
            tries += 1
            one, face = proposal(rng, loop, patches)
            if allowed(one, face, loop, holes, patches):
                patches.append((one, face))
        borders = [Border("outline", loop, "outline")]
        borders += [Border(f"hole {k + 1}", hole, "hole") for k, hole in enumerate(holes)]
        borders += [Border(f"patch {k + 1}", one) for k, (one, _) in enumerate(patches)]
        return borders, float(rng.uniform(0.001, 0.006))

    return drawn
