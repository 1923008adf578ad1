"""Places all over a plate where something may be attached that nobody declared.

The plate without effects represents its answers to patches and transducers, not those modes that they do not
excite. A load at any place excites these, too: answers to a few random patterns of forces over the whole plate
bring them into the space. What is left of the answer at a place to a force there is static and local: it is
computed for places over the plate, and counts as a compliance in series, see `simulation.state.attached`.
"""

from itertools import pairwise
from typing import Any

import numpy as np
from scipy.interpolate import griddata
from scipy.sparse import csr_matrix

from analysis.arrays import Real
from analysis.experiment import Attachment, Plate
from analysis.material import LocalLaws, MaterialBox
from simulation.reduction.vectors.energy_decomposition import middle
from simulation.shell.fineness import shortest_wave
from simulation.shell.points import LARGEST_RADIUS_SHARE, LEAST_RADIUS, attached_discs, footprint_rows
from simulation.shell.rigidity import W
from simulation.shell.unknowns import factorize
from simulation.state.plate_state import PlateState
from simulation.state.state_matrices import FullPlate

SPACING_OVER_WAVE = 0.05
"""Spacing of the places over the shortest bending wave: deflections between them are good to 2e-4 of their rms."""
CORNER = 0.3
"""Angle, rad, from which two sides of a loop meet at a corner; sides along its curves meet at less."""
ROOM = 1.01
"""Distance of places from edges, over what the smallest disc needs."""
PATTERNS = 4
"""Number of random patterns: a mode that one of them hardly excites is excited by the others."""
MOST_PLACES_SOLVED = 300
"""Number of places, at most, at which the local compliance is computed; between them it is interpolated."""
FORCES_AT_ONCE = 60
"""Number of forces answered at a time."""
STIFFNESS_SHIFT = 0.3
"""Of the band's upper end: adds as much inertia as keeps the stiffness of a free plate positive."""


def places(plate: Plate, spacing: float) -> Real:
    """Places (G, 2) on a plate, at most `spacing` apart, m: in the middle of equal cells, and beside all edges."""
    low, high = np.array(plate.bounds)
    counts = np.maximum(np.ceil((high - low) / spacing), 6).astype(int)
    x, y = (low[k] + (np.arange(n) + 0.5) * (high - low)[k] / n for k, n in enumerate(counts))
    grid = np.array([(a, b) for a in x for b in y])
    least = LEAST_RADIUS / LARGEST_RADIUS_SHARE * plate.thickness
    edges = [_beside(plate.loop.polygon, spacing, ROOM * least)]
    edges += [_beside(loop.polygon, spacing, -ROOM * least) for loop in plate.hole_loops]
    return np.vstack([_with_room(plate, grid, 0.5 * plate.thickness), _with_room(plate, np.vstack(edges), least)])


def _with_room(plate: Plate, points: Real, room: float) -> Real:
    """Those of points (K, 2) that are on the plate and further than `room` from its edges."""
    away = np.min([loop.distance(points) for loop in (plate.loop, *plate.hole_loops)], axis=0)
    return np.asarray(points[plate.contains(points) & (away > room)])


def _beside(polygon: Real, spacing: float, away: float) -> Real:
    """Points (K, 2) at `away` to the left of a loop (V, 2), to the right where negative, about `spacing` apart.

    Its corners are among them: within a thickness or two of edges the local compliance is up to five times that
    inside.
    """
    sides = np.roll(polygon, -1, axis=0) - polygon
    length = np.hypot(*sides.T)
    normal = np.stack([-sides[:, 1], sides[:, 0]], axis=1) / length[:, None]
    before = np.roll(normal, 1, axis=0)
    corner = (normal * before).sum(axis=1) < np.cos(CORNER)
    along = np.concatenate([[0.0], np.cumsum(length)])
    ends = np.unique([0.0, *along[:-1][corner], along[-1]])
    at = np.concatenate(
        [np.linspace(a, b, max(1, round((b - a) / spacing)), endpoint=False) for a, b in pairwise(ends)]
    )
    here = np.searchsorted(along, at, side="right") - 1
    inward = normal[here]
    turns = corner[here] & (at == along[here])
    inward[turns] += before[here[turns]]
    size = np.maximum((inward**2).sum(axis=1), 0.1)  # at a cusp there is no room
    inward *= (np.where(turns, 2.0, 1.0) / size)[:, None]
    share = ((at - along[here]) / length[here])[:, None]
    return np.asarray(polygon[here] + share * sides[here] + away * inward)


def deflections(full: FullPlate, at: Real) -> csr_matrix:
    """Rows (G, n) that give the mean deflection over an attachment's disc at places (G, 2)."""
    discs = attached_discs(full.shell.plate, [Attachment(point=(float(x), float(y))) for x, y in at])
    return csr_matrix(full.unknowns.rows(footprint_rows(full.shell.space, discs), W))


def patterns(full: FullPlate, box: MaterialBox, band: tuple[float, float]) -> Real:
    """Draw random patterns of forces over the whole plate, the same in every run.

    Parameters
    ----------
    box : MaterialBox
        Its softest material gives the spacing of the forces.
    band : (float, float)
        Hz.

    Returns
    -------
    (n, PATTERNS) ndarray
    """
    rows = deflections(
        full, places(full.shell.plate, SPACING_OVER_WAVE * shortest_wave(full.shell.plate, box, band))
    )
    return np.asarray(rows.T @ np.random.default_rng(0).standard_normal((rows.shape[0], PATTERNS)))


def attachable(full: FullPlate, vectors: Real, box: MaterialBox, band: tuple[float, float]) -> dict[str, Any]:
    """Compute the entries of `EffectOperators` whose names begin with ``place``.

    Parameters
    ----------
    vectors : (n, r) ndarray
    band : (float, float)
        Hz.
    """
    spacing = SPACING_OVER_WAVE * shortest_wave(full.shell.plate, box, band)
    at = places(full.shell.plate, spacing)
    few, apart = at, spacing
    while len(few) > MOST_PLACES_SOLVED:
        apart *= 1.2
        few = places(full.shell.plate, apart)
    lost = _lost_compliance(full, vectors, few, box, band)
    if few is not at:
        linear = griddata(few, lost, at, method="linear")
        lost = np.where(np.isnan(linear), griddata(few, lost, at, method="nearest"), linear)
    return {
        "places": at,
        "place_deflection": deflections(full, at) @ vectors,
        "place_compliance": lost,
        "place_spacing": spacing,
    }


def nowhere(size: int) -> dict[str, Any]:
    """Return the same entries without any place, for `size` coordinates."""
    empty = {"places": np.zeros((0, 2)), "place_deflection": np.zeros((0, size)), "place_compliance": np.zeros(0)}
    return {**empty, "place_spacing": 1.0}


def _lost_compliance(
    full: FullPlate, vectors: Real, at: Real, box: MaterialBox, band: tuple[float, float]
) -> Real:
    """Return the static compliance at places (G, 2) that the vectors lack, times Young's modulus, (G,), 1/m."""
    youngs, ratio = middle(box)
    laws = LocalLaws.of_material(youngs, ratio, box.loss_factor[0])
    plain = PlateState.baseline(*full.sampling, laws, laws.reference, np.array([band[1]]))
    matrices = full.matrices(plain, loss=False)
    z = matrices.plate + matrices.patches + (2.0 * np.pi * STIFFNESS_SHIFT * band[1]) ** 2 * matrices.mass
    factors, rows = factorize(csr_matrix(z)), deflections(full, at)
    reduced = np.linalg.inv(vectors.T @ (z @ vectors))
    lost = np.empty(len(at))
    for start in range(0, len(at), FORCES_AT_ONCE):
        part = slice(start, start + FORCES_AT_ONCE)
        force = rows[part].toarray().T
        few = vectors.T @ force
        whole = np.einsum("nk,nk->k", force, factors.solve(force))
        lost[part] = whole - np.einsum("rk,rs,sk->k", few, reduced, few)
    return np.asarray(youngs * np.maximum(lost, 0.0))
