"""The plate as its own thermometer: how far its resonances moved, against how far its sensor's reading moved.

Where the modulus changes, every resonance of a plate moves by nearly the same factor, f ~ sqrt(E). On an axis of
ln f the FRFs of two temperatures are shifted copies of one another, and the shift s = ln(f / f_0) that correlates
them best is the mean shift of all resonances. No material is known while a campaign is recorded: how s depends on
the reading is learnt from its own sweeps. Between two sweeps that are trusted, the temperature lies between
theirs; beyond, it has moved in the direction and, within wide bounds, by the amount that those sweeps make likely.

A polymer softens by about 1 % a kelvin in E. A metal hardly does: its resonances tell nothing, and none is told.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_finite, check_shapes
from analysis.recordings.frf import Frf

STEP = 0.002
"""Of the axis of ln f: a fifth of the half-power width of a resonance with a loss factor of 0.01."""
FURTHEST = 0.3
"""Largest shift that is looked for, in ln f: a modulus that has nearly halved."""
OVERLAP = 0.5
"""Share of the band in which two FRFs are compared at least."""
ALIKE = 0.7
"""Least correlation of two FRFs whose shift counts; those of one plate 10 K apart have 0.9 and more."""
AMBIGUOUS = 0.05
"""A second shift whose correlation is as good within this much: resonances that are evenly spaced tell nothing."""
COMPARED = 4
"""Trusted sweeps, the last ones, with which a new one is compared; the best correlation counts."""
FLOOR = 0.02
"""Of the rms of an FRF, added to its magnitude: noise in an antiresonance is no shape."""
LEAST_SWEEPS, LEAST_SPAN = 3, 4.0
"""Trusted sweeps, and the K that they span, from which the dependence is learnt."""
LEAST_SLOPE = 0.001
"""Of ln f by K, below which resonances are no thermometer: E changes by 0.2 % a kelvin. Aluminium and steel have
0.02 to 0.03 %, of E 0.05 %; polymers 0.5 to 1.5 % of E."""
SCATTER = 0.25
"""Of the span, rms of the readings about a straight line over the shift: more is no thermometer either."""
MARGIN = 2.5
"""K that a reading may be off what the resonances say: gradients, lag and hysteresis of a plate on a ramp."""
WIDER = 2.5
"""Factor by which the dependence may be steeper than the steepest, or flatter than the flattest, of sweeps that
are trusted: beyond them a glass transition may begin or end."""
SHIFT_ERROR, SHIFT_SHARE = 0.002, 0.05
"""Of a shift, in ln f and as a share of it: damping changes too, and not all modes move alike."""


@dataclass(frozen=True)
class LogSpectrum:
    """Magnitude of FRFs on an even axis of ln f.

    Attributes
    ----------
    level : (K, N) ndarray
        ln of the magnitude, of each response, `STEP` apart, its mean taken away.
    """

    level: Real

    def __post_init__(self) -> None:
        check_shapes(self, level="K N")
        check_finite(self, "level")


def log_spectrum(frequency: Real, h: Complex) -> LogSpectrum:
    """Return the magnitude of FRFs on an even axis of ln f.

    Parameters
    ----------
    frequency : (F,) ndarray
        Ascending, above 0 Hz.
    h : (K, F) complex ndarray
        In any unit; lines that are not finite are left out.
    """
    rows = []
    for one in h:
        good = np.isfinite(one) & (frequency > 0.0)
        x = np.log(frequency[good])
        power = np.abs(one[good]) ** 2
        level = 0.5 * np.log(power + FLOOR**2 * power.mean() + np.finfo(float).tiny)
        # The mean over each step, by the integral: dense lines are averaged, sparse ones interpolated.
        integral = np.concatenate([[0.0], np.cumsum(0.5 * (level[1:] + level[:-1]) * np.diff(x))])
        edges = np.arange(np.log(frequency[frequency > 0.0][0]), np.log(frequency[-1]), STEP)
        level = np.diff(np.interp(edges, x, integral)) / STEP
        rows.append(level - level.mean())
    return LogSpectrum(np.array(rows))


def shift(before: LogSpectrum, now: LogSpectrum) -> tuple[float, float]:
    """Return by how much resonances moved, in ln f, and the correlation; NaN where no shift stands out.

    Parameters
    ----------
    before, now : LogSpectrum
        Of the same responses and band.
    """
    count = before.level.shape[1]
    furthest = min(round(FURTHEST / STEP), round((1.0 - OVERLAP) * count))
    lags = np.arange(-furthest, furthest + 1)
    alike = _correlation(before.level, now.level, lags)
    best = int(np.argmax(alike))
    if not 0 < best < lags.size - 1 or alike[best] < ALIKE:
        return float("nan"), float(alike[best])
    if _second_peak(alike, best) > alike[best] - AMBIGUOUS:
        return float("nan"), float(alike[best])
    left, middle, right = alike[best - 1 : best + 2]
    curvature = left - 2.0 * middle + right
    part = 0.5 * (left - right) / curvature if curvature < 0.0 else 0.0
    return float((lags[best] + part) * STEP), float(alike[best])


def _correlation(before: Real, now: Real, lags: NDArray[np.int_]) -> Real:
    """Mean over the responses of the correlation in what overlaps, `now` being moved back by `lags` steps (L,)."""
    count = before.shape[1]
    size = 1 << (2 * count - 1).bit_length()  # of a power of two, above twice the length: no lag meets itself
    spectra = np.fft.rfft(now, size) * np.fft.rfft(before, size).conj()
    products = np.fft.irfft(spectra, size)[:, lags % size]
    low, high = np.maximum(lags, 0), count + np.minimum(lags, 0)
    a_sum, a_power = _sums(before, low - lags, high - lags)
    b_sum, b_power = _sums(now, low, high)
    over = high - low
    power = (a_power - a_sum**2 / over) * (b_power - b_sum**2 / over)
    return np.asarray(((products - a_sum * b_sum / over) / np.sqrt(np.maximum(power, 1e-12))).mean(0))


def _sums(level: Real, low: NDArray[np.int_], high: NDArray[np.int_]) -> tuple[Real, Real]:
    """Return the sums (K, L) of values and squares between places."""
    total = np.concatenate([np.zeros((len(level), 1)), np.cumsum(level, axis=1)], axis=1)
    power = np.concatenate([np.zeros((len(level), 1)), np.cumsum(level**2, axis=1)], axis=1)
    return total[:, high] - total[:, low], power[:, high] - power[:, low]


def _second_peak(alike: Real, best: int) -> float:
    """Largest correlation at a maximum beside the best one."""
    inner = np.flatnonzero((alike[1:-1] >= alike[:-2]) & (alike[1:-1] >= alike[2:])) + 1
    others = [place for place in inner if place != best]
    return float(alike[others].max()) if others else -1.0


class FrfThermometer:
    """Judges the readings of a plate's sensors, sweep by sweep, by what the resonances did.

    Sweeps of one drive and level belong together: each group is learnt by itself.
    """

    def __init__(self) -> None:
        self._trusted: dict[object, list[tuple[float, float, LogSpectrum]]] = {}

    def judge(self, group: object, temperature: float, spectrum: LogSpectrum, *, doubted: bool = False) -> str:
        """Judge the reading of one sweep, and learn from it if nothing is wrong.

        Parameters
        ----------
        group : object
            Drive and level.
        temperature : float
            As read, degrees Celsius.
        spectrum : LogSpectrum
        doubted : bool
            Whether the reading is in doubt for another reason: then nothing is learnt from it.

        Returns
        -------
        str
            What does not fit; empty where all does, or the resonances tell nothing.
        """
        trusted = self._trusted.setdefault(group, [])
        moved = _moved(trusted, spectrum)
        if moved is None:
            if not trusted and not doubted:
                trusted.append((temperature, 0.0, spectrum))
            return ""
        place, since = moved
        wrong = _wrong(np.array([one[:2] for one in trusted]), temperature, place, since)
        if not wrong and not doubted:
            trusted.append((temperature, place, spectrum))
        return wrong

    def placed(self, group: object, temperature: float, spectrum: LogSpectrum) -> float | None:
        """Return the shift of a sweep since the first of its group, judging nothing; None where it is unknown."""
        known = self._trusted.setdefault(group, [])
        moved = _moved(known, spectrum)
        if moved is None and known:
            return None
        place = 0.0 if moved is None else moved[0]
        known.append((temperature, place, spectrum))
        return place


def _moved(
    known: list[tuple[float, float, LogSpectrum]], spectrum: LogSpectrum
) -> tuple[float, tuple[float, float]] | None:
    """Return the shift since the first sweep, and temperature and shift of the one compared; None if unknown."""
    found: list[tuple[float, float, tuple[float, float]]] = []
    for temperature, place, other in known[-COMPARED:]:
        by, alike = shift(other, spectrum)
        if np.isfinite(by):
            found.append((alike, place + by, (temperature, by)))
    if not found:
        return None
    _, place, since = max(found)
    return place, since


def _wrong(known: Real, temperature: float, place: float, since: tuple[float, float]) -> str:
    """Return why a reading does not fit the shift; `known` has temperature and shift of every trusted sweep."""
    slopes = _slopes(known)
    if slopes is None:
        return ""
    low, high = _allowed(known, place, slopes)
    if low <= temperature <= high:
        return ""
    return (
        f"the resonances moved by {100.0 * np.expm1(since[1]):+.1f} % since the sweep at {since[0]:.1f} °C, by "
        f"which the plate is at {_between(low, high)} °C, but its sensor reads {temperature:.1f} °C"
    )


def _slopes(known: Real) -> tuple[float, float] | None:
    """Return the flattest and the steepest shift by kelvin, of sweeps (T, 2) with temperature and shift.

    Of pairs of neighbouring sweeps that go the way of the median: a few that are wrong do not turn it. None where
    resonances tell nothing.
    """
    if len(known) < LEAST_SWEEPS or np.ptp(known[:, 0]) < LEAST_SPAN:
        return None
    labels, places = known[np.argsort(known[:, 1], kind="stable")].T
    span = float(np.ptp(labels))
    if float(np.ptp(places)) < LEAST_SLOPE * span:
        return None
    line = np.polyfit(places, labels, 1)
    if float(np.std(labels - np.polyval(line, places))) > SCATTER * span:
        return None
    found = []
    for one in range(len(labels)):
        far = np.flatnonzero(np.abs(labels[one + 1 :] - labels[one]) >= LEAST_SPAN)
        if far.size:
            other = one + 1 + int(far[0])
            found.append((places[other] - places[one]) / (labels[other] - labels[one]))
    usual = float(np.median(found)) if found else 0.0
    if abs(usual) < LEAST_SLOPE:
        return None
    same = sorted((one for one in found if one * usual > 0.0), key=abs)
    return same[0] if abs(same[0]) > LEAST_SLOPE else float(np.copysign(LEAST_SLOPE, usual)), same[-1]


def _allowed(known: Real, place: float, slopes: tuple[float, float]) -> tuple[float, float]:
    """Return between which temperatures the shifts since all sweeps of `known` put the plate, degrees Celsius."""
    label, by = known[:, 0], place - known[:, 1]
    error = SHIFT_ERROR + SHIFT_SHARE * np.abs(by)
    flattest, steepest = slopes
    least = np.maximum(np.abs(by) - error, 0.0) / (WIDER * abs(steepest)) - MARGIN
    most = WIDER * (np.abs(by) + error) / abs(flattest) + MARGIN
    warmer = by * flattest > 0.0
    low, high = np.where(warmer, label + least, label - most), np.where(warmer, label + most, label - least)
    unmoved = np.abs(by) <= error
    low, high = np.where(unmoved, label - most, low), np.where(unmoved, label + most, high)
    return float(low.max()), float(high.min())


def _between(low: float, high: float) -> str:
    """Return two temperatures in words; bounds that sweeps contradict among themselves are exchanged."""
    return f"{min(low, high):.0f} to {max(low, high):.0f}"


def unlike_resonances(frf: Frf, doubted: Iterable[int] = ()) -> dict[int, str]:
    """Return which sweeps of a recorded campaign have a temperature that their resonances contradict.

    Parameters
    ----------
    frf : Frf
        In the order recorded.
    doubted : iterable of int
        Places of sweeps whose temperature is in doubt already: nothing is learnt from them.

    Returns
    -------
    dict of int to str
        By the sweep's place.
    """
    left_out = set(doubted)
    inside = ~frf.excluded
    groups: dict[tuple[int, float], list[int]] = {}
    for one, group in enumerate(zip(frf.driven_by, frf.level, strict=True)):
        groups.setdefault((int(group[0]), float(group[1])), []).append(one)
    found: dict[int, str] = {}
    for members in groups.values():
        thermometer, placed = FrfThermometer(), []
        for one in members:
            spectrum = log_spectrum(frf.frequency[inside], frf.h[one][:, inside])
            place = thermometer.placed(0, float(frf.temperature[one]), spectrum)
            if place is not None and one not in left_out:
                placed.append((one, float(frf.temperature[one]), place))
        found |= _contradicted(placed)
    return dict(sorted(found.items()))


def _contradicted(placed: list[tuple[int, float, float]]) -> dict[int, str]:
    """Return the sweeps that fit others least, one after the other, until those that are left fit one another.

    Parameters
    ----------
    placed : list of (int, float, float)
        Of each sweep, its place in the campaign, its temperature in degrees Celsius, and its shift.
    """
    found: dict[int, str] = {}
    left = list(placed)
    while slopes := _slopes(np.array([one[1:] for one in left]).reshape(-1, 2)):
        conflicts = np.array(
            [[not _fits(one[1:], other[1:], slopes) for other in left] for one in left], dtype=int
        ).sum(1)
        if not conflicts.any():
            break
        worst = int(np.argmax(conflicts))
        one = left.pop(worst)
        low, high = _allowed(np.array([other[1:] for other in left]), one[2], slopes)
        found[one[0]] = (
            f"by the shift of its resonances the plate was at {_between(low, high)} °C, but its sensor read "
            f"{one[1]:.1f} °C"
        )
    return found


def _fits(one: tuple[float, float], other: tuple[float, float], slopes: tuple[float, float]) -> bool:
    low, high = _allowed(np.array([other]), one[1], slopes)
    return low <= one[0] <= high
