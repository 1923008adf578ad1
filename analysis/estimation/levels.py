"""Whether weak and strong drives give the same FRF: if not, an average over both is the FRF of neither.

The difference of two H1 is compared with the variance that their own scatter gives them. With d degrees of
freedom in that scatter the ratio of both, for one resonance, has the distribution F(2, 2d), of which P(F > x) =
(1 + x/d)^-d.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.estimators import estimate
from analysis.estimation.spectra import Spectra
from analysis.recordings.noise_power import SMOOTHING_LINES, noise_power, rough_power

CHANCE = 1e-3
"""Probability with which a linear structure is called one that is not."""
COMPARED_LEVEL_RATIO = 1.2
"""Ratio of the mean levels of the strong and the weak half from which they are compared."""
NOISE_LINES = 21
"""Lines over which the noise is averaged where it says which lines stand out of it."""
CLEAR = 10.0
"""Power of an FRF, in variances, from which a line stands out of the noise."""
FEWEST_HITS_IN_HALF = 2
"""Hits in each half: one has no scatter."""


@dataclass(frozen=True)
class LevelDifference:
    """FRFs that depend on the level of the drive.

    Attributes
    ----------
    low, high : float
        Levels that were averaged, SI.
    deviations : float
        Difference of the FRFs in standard deviations.
    """

    low: float
    high: float
    deviations: float

    def message(self, unit: str) -> str:
        """Return what was seen and what to do; `unit` is that of the level."""
        return (
            f"drives of {self.low:.3g} to {self.high:.3g} {unit} are averaged, and the FRFs of the weak and "
            f"the strong "
            f"ones differ by {self.deviations:.1f} standard deviations: the structure is not linear, or it "
            f"changed "
            "meanwhile, and modes of the average belong to neither. Make a test of each level"
        )


def of_hits(
    drives: NDArray[np.float64], responses: NDArray[np.float64], levels: NDArray[np.float64]
) -> LevelDifference | None:
    """Compare the weaker half of hits with the stronger one.

    Parameters
    ----------
    drives : (B, 1, N) ndarray
        Blocks, windowed.
    responses : (B, K, N) ndarray
    levels : (B,) ndarray
        Largest forces, N.

    Returns
    -------
    LevelDifference or None
        None where they agree, or their levels do.
    """
    order = np.argsort(levels)
    halves = order[: len(order) // 2], order[len(order) - len(order) // 2 :]
    if (
        len(halves[0]) < FEWEST_HITS_IN_HALF
        or levels[halves[1]].mean() < COMPARED_LEVEL_RATIO * levels[halves[0]].mean()
    ):
        return None
    u, y = np.fft.rfft(drives[:, 0], axis=1)[:, 1:], np.fft.rfft(responses, axis=2)[:, :, 1:]
    found = []
    left = np.zeros(y.shape[1:])
    for half in halves:
        power = np.maximum((np.abs(u[half]) ** 2).sum(axis=0), np.finfo(float).tiny)
        h = np.einsum("bkf,bf->kf", y[half], u[half].conj()) / power
        left += (np.abs(y[half] - h[None] * u[half][:, None]) ** 2).sum(axis=0)
        found.append((h, power))
    freedom = 2 * len(halves[0]) - 2
    (weak, weak_power), (strong, strong_power) = found
    variance = left / freedom * (1.0 / weak_power + 1.0 / strong_power)
    return _judged(weak, strong, variance, freedom, (float(levels.min()), float(levels.max())))


def of_records(parts: Sequence[Spectra], levels: NDArray[np.float64]) -> LevelDifference | None:
    """Compare the weakest with the strongest of several records of one drive.

    Parameters
    ----------
    parts : sequence of Spectra
        Of the same lines.
    levels : (P,) ndarray
        RMS of the drive, SI.

    Returns
    -------
    LevelDifference or None
        None where they agree, their levels do, or one is too short to tell.
    """
    first, last = int(np.argmin(levels)), int(np.argmax(levels))
    if len(parts) < 2 or levels[last] < COMPARED_LEVEL_RATIO * levels[first] or parts[0].g_uu.shape[1] != 1:
        return None
    try:
        weak, strong = estimate(parts[first]), estimate(parts[last])
    except ValueError:  # said of the average
        return None
    between = (float(levels[first]), float(levels[last]))
    if weak.variance is None or strong.variance is None:  # a sweep each: neighbouring lines tell the noise
        variance = _of_one_average(weak.h[:, 0]) + _of_one_average(strong.h[:, 0])
        # line by line: a force that dips at a resonance makes a few lines as noisy as all others together
        scale = 1.0 / np.sqrt(np.maximum(variance, np.finfo(float).tiny))
        clear = np.abs(strong.h[:, 0]) * scale > np.sqrt(CLEAR)
        apart = (np.abs(strong.h[:, 0] - weak.h[:, 0]) * scale)[clear] ** 2
        ratio = float(apart.mean()) if clear.any() else 0.0
        return _named(ratio, float(SMOOTHING_LINES), between)
    freedom = min(weak.averages, strong.averages) - 1.0
    variance = weak.variance[:, 0] + strong.variance[:, 0]
    return _judged(weak.h[:, 0], strong.h[:, 0], variance, freedom, between)


def _of_one_average(h: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return the variance (K, F) of FRFs of one average, from the scatter of neighbouring lines."""
    everywhere = np.zeros(h.shape[1], dtype=bool)
    return np.array([noise_power(rough_power(row), row, everywhere) for row in h])


def _around(variance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Average variances (K, F) over `NOISE_LINES` lines.

    Of two hits in each half, a line's own variance is small by chance where it should not be: of lines of noise
    alone, as beyond the band in which a plate answers, those would be taken that differ most.
    """
    count = min(NOISE_LINES, variance.shape[1])
    weight = np.ones(count)
    number = np.convolve(np.ones(variance.shape[1]), weight, mode="same")
    return np.array([np.convolve(row, weight, mode="same") / number for row in variance])


def _judged(
    weak: NDArray[np.complex128],
    strong: NDArray[np.complex128],
    variance: NDArray[np.float64],
    freedom: float,
    levels: tuple[float, float],
) -> LevelDifference | None:
    """Compare the difference, summed over the lines that stand out of the noise, with its variance."""
    clear = np.abs(strong) ** 2 > CLEAR * np.maximum(variance, _around(variance))
    total = float(variance[clear].sum())
    if not clear.any() or total <= 0.0 or freedom < 1.0:
        return None
    return _named(float((np.abs(strong - weak)[clear] ** 2).sum()) / total, freedom, levels)


def _named(ratio: float, freedom: float, levels: tuple[float, float]) -> LevelDifference | None:
    """Return the difference, unless chance may make a `ratio` of squares to variance as large."""
    if ratio <= freedom * (CHANCE ** (-1.0 / freedom) - 1.0):
        return None
    return LevelDifference(*levels, float(np.sqrt(ratio)))
