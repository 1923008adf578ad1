"""Whether FRFs that are averaged agree: those of several runs, and those of weak and strong drives.

With one H for all runs, and with an H of its own for each, the drives explain of the responses' energy

    E_1 = sum_f G_yu G_uu^-1 G_uy,    E_n = sum_f sum_i w_i G_yu,i G_uu,i^-1 G_uy,i,

where G = sum_i w_i G_i. Of FRFs that have nothing to do with each other, E_1 keeps on average what each run
gives by itself, E_0 = sum_f sum_i w_i^2 G_yu,i G_uu^-1 G_uy,i. The agreement (E_1 - E_0) / (E_n - E_0) is
therefore 1 for the same FRF and 0 for unrelated ones. Of two runs of equal drive it
is 2 Re(H_1 H_2*) / (|H_1|^2 + |H_2|^2), summed over lines (compare the coherence, Bendat and Piersol, Random Data,
2010, ch. 9).

Of weak and strong drives, the difference of two H1 is compared with the variance that their own scatter gives
them. With d degrees of freedom in that scatter the ratio of both, for one resonance, has the distribution F(2,
2d), of which P(F > x) = (1 + x/d)^-d.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.estimators import estimate
from analysis.estimation.spectra import Spectra, pooled
from analysis.recordings.noise_power import SMOOTHING_LINES, noise_power, rough_power

LEAST_AGREEMENT = 0.5
"""Runs that agree less are no averages of one FRF: five points of a free beam agree by -0.2, two of them by -0.9
to 0.85, hits at one point by more than 0.9."""
GOOD_AGREEMENT = 0.9
"""Runs that agree less are worth a note."""
NOISY_COHERENCE = 0.5
"""Coherence within the runs below which noise, and not another point, may be why they do not agree."""


@dataclass(frozen=True)
class RunsAgreement:
    """How far runs agree, for each response.

    Attributes
    ----------
    between : (K,) ndarray
        About 0 for unrelated FRFs, 1 for the same.
    within : (K,) ndarray
        Coherence within the runs, weighted by energy; NaN where no run has more averages than drives.
    runs : int
    """

    between: NDArray[np.float64]
    within: NDArray[np.float64]
    runs: int

    @property
    def different(self) -> NDArray[np.intp]:
        """Responses of which the runs measured different FRFs, not one with much noise."""
        noisy = np.nan_to_num(self.within, nan=1.0) < NOISY_COHERENCE
        return np.flatnonzero((self.between < LEAST_AGREEMENT) & ~noisy)

    @property
    def doubtful(self) -> NDArray[np.intp]:
        """Further responses of which they do not agree well."""
        return np.setdiff1d(np.flatnonzero(self.between < GOOD_AGREEMENT), self.different)


def agreement(parts: Sequence[Spectra]) -> RunsAgreement | None:
    """Return how far the runs of one average agree.

    Parameters
    ----------
    parts : sequence of Spectra
        One for each run, of the same lines.

    Returns
    -------
    RunsAgreement or None
        None for a single run, and where a run alone has fewer averages than drives.
    """
    drives = parts[0].g_uu.shape[1]
    if len(parts) < 2 or any(part.averages < drives for part in parts):
        return None
    whole = pooled(list(parts))
    share = [part.averages / whole.averages for part in parts]
    together = _explained(whole, whole.g_uu)
    apart = np.sum([s * _explained(part, part.g_uu) for s, part in zip(share, parts, strict=True)], axis=0)
    chance = np.sum([s**2 * _explained(part, whole.g_uu) for s, part in zip(share, parts, strict=True)], axis=0)
    between = np.divide(together - chance, apart - chance, out=np.ones_like(apart), where=apart > chance)
    several = [part for part in parts if part.averages > drives]
    within = np.full(len(between), np.nan)
    if several:
        weight = np.array([part.averages for part in several])
        answered = np.sum([w * part.g_yy[1:].sum(0) for w, part in zip(weight, several, strict=True)], axis=0)
        explained = np.sum(
            [w * _explained(part, part.g_uu) for w, part in zip(weight, several, strict=True)], axis=0
        )
        within = np.divide(explained, answered, out=np.zeros_like(explained), where=answered > 0.0)
    return RunsAgreement(between, within, len(parts))


def _explained(part: Spectra, drives: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Sum G_yu G^-1 G_uy of each response over all lines but 0 Hz, (K,); G are the spectra `drives`, (F, M, M)."""
    g_uu, g_yu = drives[1:], part.g_yu[1:]
    power = np.einsum("fii->fi", g_uu).real
    size = np.sqrt(np.maximum(power, 1e-12 * power.max(axis=0, initial=0.0)))  # unplayed lines explain nothing
    size = np.where(size > 0.0, size, 1.0)
    normal = g_uu / (size[:, :, None] * size[:, None, :]) + 1e-12 * np.eye(g_uu.shape[1])
    scaled = g_yu / size[:, None, :]
    solved = np.linalg.solve(normal, np.swapaxes(scaled.conj(), 1, 2))
    return np.asarray(np.einsum("fkm,fmk->k", scaled, solved).real)


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
