"""H1, H2 and Hv of one drive or several, with coherence and variance (Bendat and Piersol, Random Data, 2010).

The variance of an FRF from the coherence that came with it.

Windowed segments of a stationary signal, and what they make of a resonance.
"""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_range, check_shapes
from analysis.estimation.spectra import Spectra
from analysis.estimation.windows import Shape, segment_window
from analysis.recordings.noise_power import noise_parts, noise_power, single_repeat_power

Estimator = Literal["h1", "h2", "hv"]

DEPENDENT_EIGENVALUE = 1e-9
"""Smallest over largest eigenvalue of the drives' coherence below which they move as one."""

LEAST_COHERENCE = 1e-6
"""Coherence below which the variances of H2 and Hv grow no further, and a line given with one weighs nothing."""

ENOUGH_AVERAGES = 30.0
"""Averages from which each line's own noise is known well enough; below, that of neighbouring lines counts too."""


@dataclass(frozen=True)
class FrfEstimate:
    """FRFs of every response to every drive.

    Attributes
    ----------
    frequency : (F,) ndarray
        Hz, above zero.
    h : (K, M, F) complex ndarray
        Responses by drives, SI.
    variance : (K, M, F) ndarray or None
        E|h - H|^2; None where no more segments than drives were averaged: the noise is then seen from a fit only.
    coherence : (K, F) ndarray
        Of each response with all drives together, 0 to 1.
    averages : float
        Independent segments.
    """

    frequency: NDArray[np.float64]
    h: NDArray[np.complex128]
    variance: NDArray[np.float64] | None
    coherence: NDArray[np.float64]
    averages: float

    def __post_init__(self) -> None:
        check_shapes(self, frequency="F", h="K M F", variance="K M F", coherence="K F")
        check_range(self, 0.0, np.inf, "frequency", unit="Hz", above=True)


def estimate(spectra: Spectra, estimator: Estimator = "h1") -> FrfEstimate:
    """Estimate FRFs from spectra, the line at 0 Hz left out.

    H1 = G_yu G_uu^-1 has least error where the responses are noisy, H2 = G_yy / G_uy where the drive is (at
    resonances of a shaker test), Hv is total least squares with both scaled to their own power: between the two,
    for any number of drives. In H2 and Hv the noise of the response is subtracted from G_yy, as far as it shows in
    what the drives do not explain (`noise_parts`). With it |H2| would be at least N_yy / |G_uy|, and the smooth
    errors that this makes near antiresonances look like poles.

    Raises
    ------
    ValueError
        Where a drive is silent on all lines, several drives move as one, fewer segments than drives were averaged,
        or H2 is asked for with several drives.
    """
    frequency, drives = spectra.frequency[1:], spectra.g_uu.shape[1]
    g_uu, g_yu, g_yy = spectra.g_uu[1:], spectra.g_yu[1:], spectra.g_yy[1:].T
    if estimator == "h2" and drives > 1:
        raise ValueError(f"H2 of {drives} drives is not defined; choose h1 or hv")
    if spectra.averages < drives:
        raise ValueError(
            f"{spectra.averages:.1f} independent averages of {drives} drives; at least as many averages as drives "
            "are needed: record longer, or take shorter segments"
        )
    inverse = _inverse(g_uu)
    h1 = np.einsum("fki,fij->kjf", g_yu, inverse)
    explained = np.einsum("kjf,fkj->kf", h1, g_yu.conj()).real
    coherence = np.clip(np.divide(explained, g_yy, out=np.zeros_like(g_yy), where=g_yy > 0.0), 0.0, 1.0)
    own = np.zeros_like(g_yy) if estimator == "h1" else _noise_of_responses(h1, g_yy, coherence, spectra.averages)
    signal = g_yy - own
    if estimator == "h1":
        h = h1
    elif estimator == "h2":
        g_uy = g_yu[:, :, 0].conj().T
        h = np.divide(signal, g_uy, out=np.zeros_like(g_uy), where=g_uy != 0.0)[:, None]
    else:
        h = _total_least_squares(g_uu, g_yu, signal)
    variance = _variance(h, g_yy, coherence, inverse, spectra.averages)
    if variance is not None and estimator != "h1":
        left = signal / np.maximum(g_yy, np.finfo(float).tiny)  # at least the coherence
        explained = np.maximum(coherence, LEAST_COHERENCE)
        variance *= _against_h1(estimator, explained / np.maximum(left, explained), drives)[:, None]
        scatter = (1.0 - left) / np.maximum(left, explained) * (1.0 if estimator == "h2" else 0.5)
        variance += np.abs(h) ** 2 * (scatter**2 / spectra.averages)[:, None]
    return FrfEstimate(frequency, h, variance, coherence, spectra.averages)


def _noise_of_responses(
    h: NDArray[np.complex128], g_yy: NDArray[np.float64], coherence: NDArray[np.float64], averages: float
) -> NDArray[np.float64]:
    """Noise in the responses' spectra that is no noise of a drive times H, (K, F); 0 where nothing tells."""
    freedom = averages - h.shape[1]
    if freedom < 0.5:
        return np.zeros_like(g_yy)
    unexplained, gains = g_yy * (1.0 - coherence), np.sqrt((np.abs(h) ** 2).sum(1))
    everywhere = np.zeros(g_yy.shape[1], dtype=bool)
    rows = [noise_parts(*one, everywhere)[0] for one in zip(unexplained, gains, strict=True)]
    return np.asarray(np.minimum(np.array(rows) * averages / freedom, unexplained))


def _against_h1(estimator: Estimator, explained: NDArray[np.float64], drives: int) -> NDArray[np.float64]:
    """Variance of an estimator over that of H1, (K, F), to first order of the errors of the cross spectra.

    |H2| is |H1| / c, with c the coherence with what is left of G_yy, and has the same relative variance. Of Hv of
    one drive, |H1| / sqrt(c), the phase has that relative variance, too, and the magnitude c times it.
    """
    inverse = 1.0 / explained
    if estimator == "h2":
        return inverse**2
    return 0.5 * (1.0 + inverse) if drives == 1 else inverse


def _inverse(g_uu: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Inverse of the drives' matrix, (F, M, M); lines on which nothing drives get a very small drive."""
    power = np.einsum("fii->fi", g_uu).real
    if not (power.max(axis=0) > 0.0).all():
        silent = int(np.flatnonzero(~(power.max(axis=0) > 0.0))[0])
        raise ValueError(f"drive {silent + 1} is silent on every line; look at its cable")
    floor = 1e-24 * power.max(axis=0)
    size = np.sqrt(np.maximum(power, floor))
    normal = g_uu / (size[:, :, None] * size[:, None, :]) + 1e-15 * np.eye(g_uu.shape[1])
    if g_uu.shape[1] > 1:
        driven = (power > 1e-6 * power.max(axis=0)).all(axis=1)
        smallest = np.linalg.eigvalsh(normal[driven])[:, 0]
        if len(smallest) and np.median(smallest) < DEPENDENT_EIGENVALUE:
            raise ValueError(
                "the drives move as one: their signals are multiples of each other; drive them with independent "
                "signals, or declare one of them unused"
            )
    normal = np.where(power.min(axis=1)[:, None, None] > 0.0, normal, np.eye(g_uu.shape[1]))
    inverse: NDArray[np.complex128] = np.linalg.inv(normal) / (size[:, :, None] * size[:, None, :])
    return inverse


def _total_least_squares(
    g_uu: NDArray[np.complex128], g_yu: NDArray[np.complex128], g_yy: NDArray[np.float64]
) -> NDArray[np.complex128]:
    """Hv: the direction of least power of drives and response, each scaled to its own power; (K, M, F)."""
    lines, responses, drives = g_yu.shape
    h = np.zeros((responses, drives, lines), dtype=complex)
    size = np.sqrt(np.maximum(np.einsum("fii->fi", g_uu).real, np.finfo(float).tiny))
    for k in range(responses):
        own = np.sqrt(np.maximum(g_yy[k], np.finfo(float).tiny))
        whole = np.zeros((lines, drives + 1, drives + 1), dtype=complex)
        whole[:, :drives, :drives] = g_uu
        whole[:, drives, :drives] = g_yu[:, k]
        whole[:, :drives, drives] = g_yu[:, k].conj()
        whole[:, drives, drives] = g_yy[k]
        scale = np.column_stack([size, own])
        _, vectors = np.linalg.eigh(whole / (scale[:, :, None] * scale[:, None, :]))
        least = vectors[:, :, 0].conj() / scale  # least[:M] u + least[M] y = 0
        last = np.where(least[:, drives] == 0.0, np.inf, least[:, drives])
        h[k] = (-least[:, :drives] / last[:, None]).T
    return h


def _variance(
    h: NDArray[np.complex128],
    g_yy: NDArray[np.float64],
    coherence: NDArray[np.float64],
    inverse: NDArray[np.complex128],
    averages: float,
) -> NDArray[np.float64] | None:
    """E|h - H|^2, (K, M, F): what the drives do not explain, by their inverse.

    None for one blow, or as many segments as drives. Roughness along frequency would be no substitute: resonances
    of few lines are rougher than noise.
    """
    drives = h.shape[1]
    freedom = averages - drives
    everywhere = np.zeros(h.shape[2], dtype=bool)
    if freedom < 0.5:
        return None
    noise = g_yy * (1.0 - coherence)
    if freedom < ENOUGH_AVERAGES:
        gains = np.sqrt((np.abs(h) ** 2).sum(1))
        noise = np.array([noise_power(*one, everywhere) for one in zip(noise, gains, strict=True)])
    own = np.einsum("fjj->jf", inverse).real
    variance: NDArray[np.float64] = noise[:, None] * own / freedom
    floored: NDArray[np.float64] = np.maximum(variance, 1e-24 * (np.abs(h) ** 2).mean(axis=2, keepdims=True))
    return floored


def without_information(coherence: NDArray[np.float64]) -> bool:
    """Whether a coherence is 1 on every line: that of a single average, or a program's default."""
    return bool((coherence > 1.0 - 1e-9).all())


def coherence_variance(
    h: NDArray[np.complex128], coherence: NDArray[np.float64], averages: float | None = None
) -> NDArray[np.float64] | None:
    """E|h - H|^2 = |h|^2 (1 - c) / (n c), of H1 (Bendat and Piersol, Random Data, 2010, ch. 9).

    Parameters
    ----------
    h : (F,) complex ndarray
    coherence : (F,) ndarray
        0 to 1.
    averages : float, optional
        n; where it is not given, the level of the noise is taken from the roughness of `h` along
        frequency, and only its course from the coherence.

    Returns
    -------
    (F,) ndarray or None
        In the square of the unit of `h`, above zero; None where there is no information in the
        coherence (`without_information`), or the FRF is zero throughout.

    Raises
    ------
    ValueError
        Where the coherence leaves 0 to 1.
    """
    if not ((coherence >= -1e-6) & (coherence <= 1.0 + 1e-4)).all():
        raise ValueError(f"coherence from {coherence.min():.3g} to {coherence.max():.3g}; 0 to 1 allowed")
    power = float((np.abs(h) ** 2).mean())
    if without_information(coherence) or power == 0.0:
        return None
    known = np.clip(coherence, LEAST_COHERENCE, 1.0 - 1e-9)
    course: NDArray[np.float64] = np.abs(h) ** 2 * (1.0 - known) / known
    course = np.maximum(course, 1e-24 * power)
    largest = max(float(course.max()), power / LEAST_COHERENCE)  # whatever |h| is there
    course = np.where(coherence <= LEAST_COHERENCE, largest, course)
    if averages is not None:
        return course / averages
    level = float(np.median(single_repeat_power(h) / course) / np.log(2.0))
    return course * max(level, 1e-12)


WINDOW_SAMPLES = 1024
"""Samples from which the few cosines that make up a window are taken."""


@dataclass(frozen=True)
class Segments:
    """Windowed segments over which spectra were averaged.

    Attributes
    ----------
    seconds : float
        Length of one, s.
    window : str
    estimator : str
        ``h1``, ``h2`` or ``hv``.
    """

    seconds: float
    window: Shape
    estimator: Estimator = "h1"

    def __post_init__(self) -> None:
        if not (np.isfinite(self.seconds) and self.seconds > 0.0):
            raise ValueError(f"segments of {self.seconds:g} s; above 0 allowed")
        for name, choices in (("window", get_args(Shape)), ("estimator", get_args(Estimator))):
            if getattr(self, name) not in choices:
                raise ValueError(f"{name} {getattr(self, name)!r} of segments; {', '.join(choices)} allowed")

    def changes(self, s: NDArray[np.complex128], poles: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return what the window adds to the expectation of a resonance.

        The spectra of a flat force, averaged over segments with a window w, show H smoothed by |W|^2 (Bendat and
        Piersol, Random Data, 2010, ch. 8): the impulse response is multiplied by the autocorrelation of w. That of
        a sum of cosines is a sum of (A t + B) exp(-j w_m t); its product with a pole's has a closed transform.

        Parameters
        ----------
        s : (F,) complex ndarray
            jw, rad/s.
        poles : (P,) complex ndarray
            Left half plane, rad/s.

        Returns
        -------
        (P, F) complex ndarray
            To be added to 1 / (s - pole).
        """
        cosines = np.fft.fft(segment_window(self.window, WINDOW_SAMPLES)).real / WINDOW_SAMPLES
        place = np.flatnonzero(np.abs(cosines) > 1e-9)
        c, w = (
            cosines[place],
            2.0 * np.pi * np.fft.fftfreq(WINDOW_SAMPLES, 1.0 / WINDOW_SAMPLES)[place] / self.seconds,
        )
        apart = w[:, None] - w + np.eye(len(w))
        cross = (2.0 * np.outer(c, c) / (1j * apart) * (1.0 - np.eye(len(w)))).sum(1)
        changes = np.empty((len(poles), len(s)), dtype=complex)
        for row, pole in enumerate(poles):
            x = (pole - s - 1j * w[:, None]) * self.seconds
            grown = np.expm1(x)
            whole = c[:, None] ** 2 * self.seconds * (grown - x) / x**2 + cross[:, None] * grown / x
            changes[row] = whole.sum(0) / (c**2).sum() - 1.0 / (s - pole)
        return changes
