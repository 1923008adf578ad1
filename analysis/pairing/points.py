"""Points of measured and computed shapes compared: CoMAC, sensors of wrong sign, at wrong points or elsewhere.

Coordinate modal assurance criterion of point k over the paired modes n (Lieven and Ewins, IMAC 1988):

    CoMAC_k = |sum_n r_kn* c_kn|**2 / (sum_n |r_kn|**2 sum_n |c_kn|**2)

of the measured residues r and the computed ones c, every mode scaled to the computed shape. Where a sensor stands
at another point's place, its row r_k resembles that point's row c_l: which row belongs to which point is a linear
assignment. Modes are scaled again without the points that were found wrong, because each of these pulls at all.

The twin knows its shapes at the declared points only; a coarse model of the same plate knows its own anywhere.
Every mode of the twin is written as a sum of the coarse modes next to it in frequency, fitted at the points
that are sound; the same sum says how the twin moves at any other place. The place at which this resembles the
measured row is offered.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real

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


LEAST_MODES, LEAST_POINTS = 3, 4
"""Modes and points from which one point is judged by the others: two modes suit a wrong point by chance."""
WRONG = 0.35
"""Relative error of a point's row from which it may be wrong: a hidden mass or a wrong modulus changes shapes by
less, and all points alike."""
AMONG_OTHERS = 3.0
"""The same in medians of all points' errors."""
BETTER = 0.4
"""An explanation counts if it leaves less than this share of the row's error: of a wrong one of two random rows
nine tenths are left."""
ROUNDS = 3
"""Times that modes are scaled without the points found wrong; the second changes nothing on plates tried."""


@dataclass(frozen=True)
class PointComparison:
    """Measured and computed shapes, point by point.

    Attributes
    ----------
    names : tuple of str
        Of the K points.
    comac : (K,) ndarray
        0 to 1.
    error : (K,) ndarray
        Of the measured row against the computed one, relative to the larger of them, or to the median point where
        both are smaller: points that hardly move tell noise.
    stands_at : (K,) int ndarray
        The point at which the twin moves as was measured at this one: itself where nothing is wrong.
    factor : (K,) ndarray
        By which the measured row is larger than the computed one there; 1 where nothing is wrong.
    unexplained : (K,) bool ndarray
        Points that move like no declared one.
    frequency : (N,) ndarray
        Of the measured modes, Hz.
    measured, computed : (K, N) ndarray
        Their shapes and those of the twin, in phase and of one size: the largest motion of the twin is 1.
    fitting : mapping of int to tuple of FittingPlace
        Places where the twin moves as was measured at unexplained points, as far as they were looked for.
    """

    names: tuple[str, ...]
    comac: Real
    error: Real
    stands_at: NDArray[np.int_]
    factor: Real
    unexplained: NDArray[np.bool_]
    frequency: Real
    measured: Real
    computed: Real
    fitting: Mapping[int, tuple[FittingPlace, ...]] = field(default_factory=dict)

    @property
    def wrong(self) -> NDArray[np.bool_]:
        """Points whose sensor is not as declared, (K,)."""
        moved = self.stands_at != np.arange(len(self.names))
        return np.asarray(moved | (self.factor != 1.0) | self.unexplained)

    @property
    def said(self) -> tuple[str, ...]:
        """A sentence on each wrong point, or on those that are exchanged among each other."""
        own = self.stands_at == np.arange(len(self.names))
        return (
            *(self._moved(cycle) for cycle in self._cycles()),
            *(self._scaled(int(k)) for k in np.flatnonzero(own & (self.factor != 1.0))),
            *(self._elsewhere(int(k)) for k in np.flatnonzero(self.unexplained)),
        )

    def _elsewhere(self, k: int) -> str:
        if places := words(self.fitting.get(k, ())):
            return (
                f"point {self.names[k]} does not move as the twin there (CoMAC {self.comac[k]:.2f}), but as the "
                f"twin {places}: wrong node; correct its place or leave it out"
            )
        return (
            f"point {self.names[k]} moves like no declared point (CoMAC {self.comac[k]:.2f}): wrong node, or "
            "a loose sensor; correct its place or leave it out"
        )

    def _cycles(self) -> list[list[int]]:
        """Points that stand at each other's places, each cycle once."""
        found: list[list[int]] = []
        seen: set[int] = set()
        for first in range(len(self.names)):
            cycle = [first]
            while (following := int(self.stands_at[cycle[-1]])) not in cycle:
                cycle.append(following)
            if len(cycle) > 1 and not seen & set(cycle):
                found.append(cycle)
            seen |= set(cycle)
        return found

    def _moved(self, cycle: Sequence[int]) -> str:
        names = [self.names[k] for k in cycle]
        turned = [self.names[k] for k in cycle if self.factor[k] < 0.0]
        sign = f"; the sign of {', '.join(turned)} is turned, too" if turned else ""
        if len(cycle) == 2:
            return (
                f"points {names[0]} and {names[1]} are exchanged: each moves as the twin does at the other{sign}"
            )
        ways = ", ".join(
            f"{one} moves as the twin at {other}" for one, other in zip(names, [*names[1:], names[0]], strict=True)
        )
        return f"points {', '.join(names)} are mixed up: {ways}{sign}"

    def _scaled(self, k: int) -> str:
        size = abs(float(self.factor[k]))
        if self.factor[k] < 0.0:
            larger = "" if size == 1.0 else f", {size:.2g} times as large"
            return (
                f"point {self.names[k]} moves like its mirror{larger}: sign; the sensor is turned round or its "
                "leads are swapped"
            )
        return (
            f"point {self.names[k]} moves {size:.3g} times as much as the twin there, in the right shape: "
            "sensitivity or unit"
        )


def compare_points(
    names: Sequence[str], kinds: Sequence[str], frequency: Real, measured: Complex, computed: Complex
) -> PointComparison | None:
    """Compare the shapes of paired modes point by point.

    Parameters
    ----------
    names, kinds : sequence of str
        Of the K points, and what each measures: points of another kind are no places to be mistaken for.
    frequency : (N,) ndarray
        Of the measured modes of N pairs, Hz.
    measured, computed : (K, N) complex ndarray
        Residues of the pairs, in the units of the FRFs.

    Returns
    -------
    PointComparison or None
        None for fewer than `LEAST_POINTS` points or `LEAST_MODES` modes, and where no majority of points agrees.

    Raises
    ------
    ValueError
        For residues of other shapes.
    """
    if measured.shape != computed.shape or len(measured) != len(names) or len(kinds) != len(names):
        raise ValueError(f"residues {measured.shape} and {computed.shape} of {len(names)} points; (K, N) wanted")
    some = (np.abs(measured).max(axis=0, initial=0.0) > 0.0) & (np.abs(computed).max(axis=0, initial=0.0) > 0.0)
    # kinds differ in size by their units alone: a row counts by its size among those of its kind
    size = np.array([np.linalg.norm(computed[np.array(kinds) == kind]) or 1.0 for kind in kinds])[:, None]
    frequency, measured, computed = frequency[some], measured[:, some] / size, computed[:, some] / size
    count, modes = measured.shape
    if count < LEAST_POINTS or modes < LEAST_MODES:
        return None
    stands_at, factor = np.arange(count), np.ones(count)
    sound = np.ones(count, dtype=bool)
    for _ in range(ROUNDS):
        r, c, weight = _scaled_modes(measured, computed, sound)
        stands_at, factor, unexplained = _explained(np.array(kinds), r * weight, c * weight)
        sound = (stands_at == np.arange(count)) & (factor == 1.0) & ~unexplained
        if 2 * sound.sum() <= count:  # no majority tells what is right
            return None
    error = _error(r * weight, c * weight)
    largest = c[np.abs(c).argmax(axis=0), np.arange(len(weight))]
    return PointComparison(
        names=tuple(names),
        comac=_comac(r, c),
        error=error,
        stands_at=stands_at,
        factor=factor,
        unexplained=unexplained,
        frequency=frequency,
        measured=(r / largest).real,
        computed=(c / largest).real,
    )


def _scaled_modes(measured: Complex, computed: Complex, sound: NDArray[np.bool_]) -> tuple[Complex, Complex, Real]:
    """Scale every mode to unit size, the measured one to the computed one; weigh it by its MAC."""
    c = computed / np.linalg.norm(computed[sound], axis=0)
    cross = (measured[sound].conj() * c[sound]).sum(axis=0)
    power = (np.abs(measured[sound]) ** 2).sum(axis=0)
    power = np.where(power > 0.0, power, 1.0)
    return measured * (cross / power), c, np.abs(cross) ** 2 / power


def _comac(r: Complex, c: Complex) -> Real:
    cross = np.abs((r.conj() * c).sum(axis=1)) ** 2
    size = (np.abs(r) ** 2).sum(axis=1) * (np.abs(c) ** 2).sum(axis=1)
    return np.asarray(np.divide(cross, size, out=np.zeros_like(cross), where=size > 0.0))


def _error(r: Complex, c: Complex) -> Real:
    rows = np.maximum(_norms(r), _norms(c))
    return np.asarray(_norms(r - c) / np.maximum(rows, np.median(rows)))


def _norms(rows: Complex) -> Real:
    return np.asarray(np.linalg.norm(rows, axis=1))


def _explained(
    kinds: NDArray[np.str_], r: Complex, c: Complex
) -> tuple[NDArray[np.int_], Real, NDArray[np.bool_]]:
    """Find where each point stands, its factor there, and which points nothing explains."""
    from scipy.optimize import linear_sum_assignment  # slow import

    count = len(r)
    error, power = _error(r, c), _norms(r - c)
    suspect = error > max(WRONG, AMONG_OTHERS * float(np.median(error)))
    stands_at, factor = np.arange(count), np.ones(count)
    # a point with another's row leaves its own to that one: those of one cycle are all suspect
    here = np.flatnonzero(suspect)
    if here.size:
        plus = np.linalg.norm(r[here, None] - c[None, here], axis=2)
        minus = np.linalg.norm(r[here, None] + c[None, here], axis=2)
        left, size = np.minimum(plus, minus), np.hypot(*np.meshgrid(_norms(c[here]), _norms(r[here])))
        # relative, or one large row would decide where all others stand
        cost = np.where(kinds[here, None] == kinds[None, here], (left / np.maximum(size, 1e-300)) ** 2, 10.0)
        rows, columns = linear_sum_assignment(cost)
        for row, column in zip(rows, columns, strict=True):
            if row != column and left[row, column] < BETTER * power[here[row]]:
                stands_at[here[row]] = here[column]
                factor[here[row]] = -1.0 if minus[row, column] < plus[row, column] else 1.0
        stands_at, factor = _whole_cycles(stands_at, factor)
    inner = (r.conj() * c).sum(axis=1).real
    for k in np.flatnonzero(suspect & (stands_at == np.arange(count))):
        own = inner[k] / (np.linalg.norm(c[k]) ** 2)
        if np.linalg.norm(r[k] - own * c[k]) < BETTER * min(power[k], np.linalg.norm(r[k])):
            factor[k] = -1.0 if np.linalg.norm(r[k] + c[k]) < BETTER * power[k] else own
    moved = stands_at != np.arange(count)
    return stands_at, factor, suspect & ~moved & (factor == 1.0)


def _whole_cycles(stands_at: NDArray[np.int_], factor: Real) -> tuple[NDArray[np.int_], Real]:
    """Keep only points that stand at each other's places: nobody is at a place that a sound point has."""
    count = len(stands_at)
    kept, sign = np.arange(count), np.ones(count)
    for first in range(count):
        cycle = [first]
        while (following := int(stands_at[cycle[-1]])) not in cycle:
            cycle.append(following)
        if following == first:
            kept[cycle], sign[cycle] = stands_at[cycle], factor[cycle]
    return kept, sign


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
