"""Where else on the plate a sensor may stand that moves like no declared point.

The twin knows its shapes at the declared points only; a coarse model of the same plate knows its own anywhere.
Every mode of the twin is written as a sum of the coarse modes next to it in frequency, fitted at the points
that are sound; the same sum says how the twin moves at any other place. The place at which this resembles the
measured row is offered.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real

NEXT = 3
"""Coarse modes of which a mode of the twin is made: two of nearly one frequency mix, three hardly ever."""
ALIKE = 0.2
"""Relative error at the sound points up to which a mode of the twin counts as represented by coarse ones."""
LEAST_RANK = 5
"""Independent modes from which a place is offered: two coordinates and a sign fit rows of few modes by chance."""
INDEPENDENT = 0.1
"""Singular value, relative to the largest, up to which shapes of one mode at several temperatures are one mode."""
FITS = 0.25
"""Share of the row that may be left at a place: what a hidden mass or noise of some per cent leaves at a sound
point is less."""
AS_WELL = 1.5
"""Times as much as the best place leaves, up to which another place fits as well: mirrored places of a symmetrical
plate."""
MOST = 2
"""Places that are offered; where more fit, none is."""
NEAR = 2.5
"""Steps between places over which shapes are interpolated by a quadratic."""
FINE = np.linspace(-1.0, 1.0, 21)
"""Of a step, where the interpolated shapes are compared."""


@dataclass(frozen=True)
class FittingPlace:
    """A place where the twin moves as was measured.

    Attributes
    ----------
    point : (float, float)
        m.
    away : float
        From the declared place, m.
    left : float
        Share of the measured row that is left there.
    turned : bool
        Whether the sign is the other one.
    near : str
        Declared point that stands there; empty where none does.
    """

    point: tuple[float, float]
    away: float
    left: float
    turned: bool
    near: str = ""

    @property
    def said(self) -> str:
        """The place in words."""
        at = f"at ({self.point[0]:.3f}, {self.point[1]:.3f}) m"
        who = f"at {self.near}'s place, ({self.point[0]:.3f}, {self.point[1]:.3f}) m" if self.near else at
        sign = ", with the other sign" if self.turned else ""
        return f"{who}, {self.away:.2g} m away{sign}"


@dataclass(frozen=True)
class KnownShapes:
    """Modes of the twin at every place of the plate, as far as coarse modes represent them.

    Attributes
    ----------
    places : (G, 2) ndarray
        m.
    shapes : (G, N) ndarray
        NaN columns for modes that are not represented.
    names : tuple of str
        Of the K declared points.
    points : (K, 2) ndarray
        Where they stand, m; NaN for those that are no points.
    """

    places: Real
    shapes: Real
    names: tuple[str, ...]
    points: Real

    def __post_init__(self) -> None:
        if self.places.shape != (len(self.shapes), 2) or self.points.shape != (len(self.names), 2):
            raise ValueError(
                f"places {self.places.shape} of shapes {self.shapes.shape}; points {self.points.shape} of "
                f"{len(self.names)} names"
            )


def represented(
    frequency: Real, computed: Real, sound: NDArray[np.bool_], coarse: tuple[Real, Real, Real]
) -> NDArray[np.float64]:
    """Shapes of a twin's modes at every place.

    Parameters
    ----------
    frequency : (N,) ndarray
        Hz.
    computed : (K, N) ndarray
        Shapes of the twin at its points.
    sound : (K,) bool ndarray
        Points at which coarse modes are fitted.
    coarse : tuple
        Frequencies of the coarse modes (M,), Hz, their shapes at the points (K, M) and at all places (G, M).

    Returns
    -------
    (G, N) ndarray
        NaN in the columns of modes that are not represented.
    """
    own, at_points, anywhere = coarse
    found = np.full((len(anywhere), len(frequency)), np.nan)
    count = min(NEXT, int(sound.sum()) // 3)  # fewer than half as many unknowns as equations
    if count == 0:
        return found
    for n, f in enumerate(frequency):
        near = np.argsort(np.abs(own - f))[:count]
        wanted, rows = computed[sound, n], at_points[np.ix_(sound, near)]
        amounts = np.linalg.lstsq(rows, wanted, rcond=None)[0]
        if np.linalg.norm(rows @ amounts - wanted) <= ALIKE * np.linalg.norm(wanted):
            found[:, n] = anywhere[:, near] @ amounts
    return found


def fitting_places(row: Real, k: int, known: KnownShapes) -> tuple[FittingPlace, ...]:
    """Find where on the plate the twin moves as was measured at a point.

    Parameters
    ----------
    row : (N,) ndarray
        Measured shapes at the point, scaled to those of the twin.
    k : int
        Which point it was declared as.
    known : KnownShapes

    Returns
    -------
    tuple of FittingPlace
        Best first; none where too few modes are known, nothing fits, or more than `MOST` places do.
    """
    some = np.isfinite(known.shapes).all(axis=0) & np.isfinite(row)
    shapes, row = known.shapes[:, some], row[some]
    if min(shapes.shape) < LEAST_RANK or not np.isfinite(known.points[k]).all():
        return ()
    singular = np.linalg.svd(shapes, compute_uv=False)
    size = np.linalg.norm(row)
    # a row that is small against those of other places is noise
    usual = np.median(np.linalg.norm(shapes, axis=1))
    if (singular > INDEPENDENT * singular[0]).sum() < LEAST_RANK or size < FITS * usual:
        return ()
    step = _step(known.places)
    left = np.minimum(np.linalg.norm(shapes - row, axis=1), np.linalg.norm(shapes + row, axis=1)) / size
    chosen: list[int] = []
    for g in np.argsort(left).tolist():
        if left[g] > 4.0 * FITS or len(chosen) == 4 * MOST:  # between places a fit is better than at them
            break
        if all(np.linalg.norm(known.places[g] - known.places[h]) > NEAR * step for h in chosen):
            chosen.append(g)
    tried = sorted((_refined(known.places, shapes, row, g, step) for g in chosen), key=lambda one: one[0])
    best: list[tuple[float, Real, bool]] = []
    for one in tried:
        away = all(np.linalg.norm(one[1] - other[1]) > 2.0 * step for other in best)
        if away and one[0] <= min(FITS, AS_WELL * tried[0][0]):
            best.append(one)
    if not 0 < len(best) <= MOST:
        return ()
    return tuple(_place(one, k, known, step) for one in best)


def _step(places: Real) -> float:
    """Distance between neighbours on the grid; some of its places have none, beside the outline."""
    distance = np.linalg.norm(places[:50, None] - places[None], axis=2)
    return float(np.median(np.partition(distance, 1, axis=1)[:, 1]))


def _refined(places: Real, shapes: Real, row: Real, g: int, step: float) -> tuple[float, Real, bool]:
    """Share of the row left at the best place around one, that place, and whether its sign is turned."""
    around = np.linalg.norm(places - places[g], axis=1) < NEAR * step
    amounts = np.linalg.lstsq(_quadratic((places[around] - places[g]) / step), shapes[around], rcond=None)[0]
    fine = np.stack(np.meshgrid(FINE, FINE, indexing="ij"), axis=-1).reshape(-1, 2)
    # never beyond the places known, where a quadratic runs away
    low, high = (places[around] - places[g]).min(axis=0) / step, (places[around] - places[g]).max(axis=0) / step
    fine = fine[((fine >= low) & (fine <= high)).all(axis=1)]
    there = _quadratic(fine) @ amounts
    plus, minus = np.linalg.norm(there - row, axis=1), np.linalg.norm(there + row, axis=1)
    left = np.minimum(plus, minus)
    best = int(left.argmin())
    place = places[g] + step * fine[best]
    return float(left[best] / np.linalg.norm(row)), place, bool(minus[best] < plus[best])


def _quadratic(at: Real) -> Real:
    x, y = at.T
    return np.column_stack([np.ones_like(x), x, y, x * x, x * y, y * y])


def _place(found: tuple[float, Real, bool], k: int, known: KnownShapes, step: float) -> FittingPlace:
    left, place, turned = found
    distance = np.linalg.norm(known.points - place, axis=1)
    distance[k] = np.inf
    nearest = int(np.nan_to_num(distance, nan=np.inf).argmin())
    near = known.names[nearest] if distance[nearest] < step else ""
    away = float(np.linalg.norm(place - known.points[k]))
    return FittingPlace((float(place[0]), float(place[1])), away, left, turned, near)


def words(places: Sequence[FittingPlace]) -> str:
    """Return the places in words; empty without any."""
    return ", or ".join(one.said for one in places)
