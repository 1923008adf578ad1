"""Measured FRFs of one condition, the weighted lines made from them, their noise, and their principal FRFs.

The noise is estimated from a fit's residual: deviation of every line, correlation of lines and of responses.

A sum of FRFs with real factors has the same poles; with as many sums as there are directions in which the FRFs
differ beyond their errors, nothing about the poles is lost. The directions are the left singular vectors of the
matrix of all FRFs (as in the complex mode indicator function: Shih, Tsuei, Allemang and Brown, Mech. Syst. Signal
Process. 2, 1988). A search on them takes the time of a few FRFs. It also finds more: every pole costs one residue
per FRF, so BIC on two hundred FRFs of a roving hammer, between which peaks move by a line, gives up modes that
thirty of the same FRFs show.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from analysis.checked_fields import check_ascending, check_finite, check_range, check_shapes
from analysis.identification.averaging import roughness
from analysis.identification.lines import Lines, running_median
from analysis.identification.missing import residual
from analysis.identification.modes import Modes
from analysis.identification.pole_search import PoleFit

NOISE_POWER_RATIO = 1.5
"""Largest ratio of mean noise power to the estimate from its median, in a window that holds noise alone."""
LARGEST_SHARE = 1.0
"""Largest error of a line beyond the noise around it, relative to the response, that of the model or measured."""
LONGEST_LAG = 2.0
"""Largest lag at which errors count as correlated, in half widths."""
LEAST_REACH = 8.0
"""The same in lines, at least."""
SAME_SPECTRUM_DIFFERENCE = 0.1
"""Relative rms difference up to which the noise of two responses has the same spectrum: two estimates from the
same noise differ by about as much. Weights with this error cost 2 % of accuracy."""


def deviation_from_residual(
    left: NDArray[np.complex128],
    h: NDArray[np.complex128],
    *,
    smallest_width: int = 41,
) -> NDArray[np.float64]:
    """Estimate the standard deviation of every line: rms of residuals, smoothed along frequency.

    The window holds a sixteenth of the lines, so that the weights carry a few per cent of noise themselves and
    cost under one per cent of variance; noise that changes faster than that is averaged. The model error at a
    resonance (leakage, slight nonlinearity) must not raise the noise of the lines beside it, or BIC would drop its
    pole: beyond a running median, which is robust to it, the mean counts only up to a share of the model.

    Parameters
    ----------
    left, h : (K, F) complex ndarray
        Measured minus model, and measured; rounding of `h` is the smallest deviation.
    smallest_width : int
        Lines in the window at least.

    Returns
    -------
    (K, F) ndarray
        Above zero, in the unit of `h`.
    """
    power = np.abs(left) ** 2
    count = left.shape[1]
    width = min(max(smallest_width, count // 16), count)
    rounding = (1e-14**2) * (np.abs(h) ** 2).mean(axis=1, keepdims=True)
    least = np.maximum(1e-4 * np.median(power, axis=1, keepdims=True), rounding)
    floor = running_median(power, width, "reflect") / np.log(2.0)
    smooth = uniform_filter1d(power, width, axis=1, mode="reflect")
    response = np.minimum(np.abs(h - left), np.abs(h)) ** 2  # a model that overshoots must not excuse itself
    limited = np.minimum(smooth, NOISE_POWER_RATIO * floor + LARGEST_SHARE**2 * response)
    deviation: NDArray[np.float64] = np.sqrt(np.maximum(limited, np.maximum(least, np.finfo(float).tiny)))
    return deviation


def pooled(deviation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Replace noise spectra of the same shape by their mean shape; each response keeps its level.

    Sensors of one kind on one acquisition device have noise spectra of one shape, each at its own level. The mean
    is more accurate than each estimate, and responses with proportional weights share one factorisation in a fit.

    Parameters
    ----------
    deviation : (K, F) ndarray
        Above zero.

    Returns
    -------
    (K, F) ndarray
        The level of each response is its geometric mean over the lines.
    """
    course = np.log(deviation)
    level = course.mean(axis=1, keepdims=True)
    course -= level
    left = list(range(len(course)))
    while left:
        first, *others = left
        apart = np.sqrt(np.square(course[others] - course[first]).mean(axis=1))
        alike = [
            first,
            *(row for row, distance in zip(others, apart, strict=True) if distance <= SAME_SPECTRUM_DIFFERENCE),
        ]
        course[alike] = course[alike].mean(axis=0)
        left = [row for row in left if row not in alike]
    same: NDArray[np.float64] = np.exp(course + level)
    return same


def correlation(normalised: NDArray[np.complex128], reach: float) -> float:
    """Return how many lines carry the information of one independent line: tau = 1 + 2 sum rho_k, at least 1.

    Parameters
    ----------
    normalised : (K, F) complex ndarray
        Residual over the lines' standard deviation. Its autocorrelation rho_k along frequency is summed up to
        the first value that is not positive; windows, interpolation, slow drifts and whatever a model lacks
        correlate neighbouring lines.
    reach : float
        Half width of a resonance, in lines: errors correlated over more than `LONGEST_LAG` half widths bend the
        background and do not look like a resonance.
    """
    count = normalised.shape[1]
    spectrum = np.fft.fft(normalised, 2 * count, axis=1)
    rho = np.fft.ifft((np.abs(spectrum) ** 2).sum(axis=0))[: count // 2].real
    if not rho[0] > 0.0:
        return 1.0
    rho /= rho[0]
    ends = np.flatnonzero(rho <= 0.0)
    last = min(int(ends[0]) if len(ends) else len(rho), int(max(LONGEST_LAG * reach, LEAST_REACH)) + 1)
    return float(1.0 + 2.0 * rho[1:last].sum())


def shared_by_responses(
    normalised: NDArray[np.complex128], h: NDArray[np.complex128], correlation: float
) -> float:
    """Count the responses that carry the information of one independent response.

    Noise of the measured force multiplies all responses by one factor. Divided by the phase of its response, it is
    the same in all of them; noise of the sensors is not. The number is that of equal eigenvalues of the matrix of
    correlations rho_ij with the same sum of squares, 1 + sum |rho_ij|**2 / K over i != j.

    Parameters
    ----------
    normalised : (K, F) complex ndarray
        Residual over the lines' standard deviation.
    h : (K, F) complex ndarray
        The responses.
    correlation : float
        Number of lines that carry the information of one independent line: F of them correlate two independent
        responses by correlation/F, in the mean square.

    Returns
    -------
    float
        1 to K.
    """
    count, lines = normalised.shape
    turned = normalised * np.exp(-1j * np.angle(h))
    power = np.sqrt((np.abs(turned) ** 2).sum(axis=1, keepdims=True))
    turned = turned / np.where(power > 0.0, power, 1.0)
    between = np.abs(turned @ turned.conj().T) ** 2
    np.fill_diagonal(between, 0.0)
    by_chance = (count - 1) * correlation / lines
    return float(np.clip(1.0 + between.sum() / count - by_chance, 1.0, count))


@dataclass(frozen=True)
class Measured:
    """Measured FRFs of one condition.

    Attributes
    ----------
    frequency : (F,) ndarray
        Hz.
    h : (K, F) complex ndarray
        One drive, K responses.
    variance : (K, F) ndarray or None
        E|h - H|^2; None, or not above zero on some line, where it is not known.
    at_rest : bool
        Whether they come from records without a window, at the end of which the response was at rest.
    shift : float
        Relative standard deviation of all frequencies over the repeats, see `analysis.recordings.h1`.
    together : bool
        Whether the FRFs come from the same records, so that the structure is the same in all of them.
    """

    frequency: NDArray[np.float64]
    h: NDArray[np.complex128]
    variance: NDArray[np.float64] | None = None
    at_rest: bool = False
    shift: float = 0.0
    together: bool = False

    def __post_init__(self) -> None:
        check_shapes(self, frequency="F", h="K F", variance="K F")
        check_finite(self, "frequency", "h")
        check_ascending(self, "frequency")
        check_range(self, 0.0, np.inf, "frequency", unit="Hz")

    @property
    def known(self) -> bool:
        """Whether every line has a variance."""
        return self.variance is not None and bool((self.variance > 0.0).all())

    def without(self, spoilt: NDArray[np.bool_]) -> "Measured":
        """Leave out lines (F,)."""
        variance = None if self.variance is None else self.variance[:, ~spoilt]
        return replace(self, frequency=self.frequency[~spoilt], h=self.h[:, ~spoilt], variance=variance)

    def rows(self, which: NDArray[np.bool_]) -> "Measured":
        """Return some of the FRFs (K,)."""
        return replace(self, h=self.h[which], variance=None if self.variance is None else self.variance[which])

    def lines(self) -> Lines:
        """Lines weighted by the variance if it is known, by the roughness along frequency otherwise."""
        deviation = np.sqrt(self.variance) if self.known and self.variance is not None else roughness(self.h)
        return Lines(
            self.frequency,
            self.h,
            pooled(deviation),
            at_rest=self.at_rest,
            shift=self.shift,
            together=self.together,
        )

    def reweighted(self, lines: Lines, fitted: PoleFit) -> Lines:
        """Lines with weights from a fit's residual, unless the variance is known, and with its correlations."""
        return self._weighed(lines, residual(lines, fitted), fitted.poles)

    def weighed(self, left: NDArray[np.complex128], poles: NDArray[np.complex128]) -> Lines:
        """Return the same from a residual (K, F) and the poles that it belongs to."""
        return self._weighed(self.lines(), left, poles)

    def _weighed(self, lines: Lines, left: NDArray[np.complex128], poles: NDArray[np.complex128]) -> Lines:
        deviation = lines.deviation if self.known else pooled(deviation_from_residual(left, lines.h))
        normalised = left / deviation
        tau = correlation(normalised, _reach(poles, lines.spacing))
        return replace(
            lines, deviation=deviation, correlation=tau, shared=shared_by_responses(normalised, lines.h, tau)
        )


def _reach(poles: NDArray[np.complex128], spacing: float) -> float:
    """Typical half width of poles in lines; 0 where there are none."""
    return float(np.median(-poles.real)) / (2.0 * np.pi * spacing) if len(poles) else 0.0


MANY = 32
"""FRFs up to which all of them are searched together."""
PRINCIPAL_FRFS = 16
"""Principal FRFs: with 8 to 20 of 222 measured FRFs of an aeroplane model all 13 modes are found; with 24
one is lost whose neighbour is two half widths away."""
RUNNING_MEDIAN_LINES = 9
"""Lines of the running median in which the size of all FRFs at a line is told: no line of hum counts."""


@dataclass(frozen=True)
class PrincipalFrfs:
    """Sums of FRFs.

    Attributes
    ----------
    factors : (P, K) ndarray
        Of every FRF in every sum.
    measured : Measured
        The P sums.
    """

    factors: NDArray[np.float64]
    measured: Measured

    def modes(self, modes: Modes) -> Modes:
        """Return modes of the FRFs, as those of the sums."""
        return replace(
            modes, residues=self.factors @ modes.residues, coefficients=self.factors @ modes.coefficients
        )


def principal_frfs(measured: Measured) -> PrincipalFrfs:
    """Form the principal FRFs of many FRFs.

    Every FRF counts alike, whatever its level, and so does every line, so that small modes are in the sums, too.
    Variances are not taken over: those of coherences say nothing of peaks that move from one FRF to the next,
    and a fit to the sums finds its noise in its residual.

    Parameters
    ----------
    measured : Measured
        K FRFs on F lines, none of them zero.
    """
    level = np.sqrt((np.abs(measured.h) ** 2).mean(axis=1, keepdims=True))
    scaled = measured.h / level
    size = running_median((np.abs(scaled) ** 2).mean(axis=0)[None], RUNNING_MEDIAN_LINES, "nearest")[0]
    even = scaled / np.sqrt(np.maximum(size, np.finfo(float).tiny))
    parts = np.concatenate([even.real, even.imag], axis=1)
    directions = np.linalg.eigh(parts @ parts.T)[1][:, ::-1][:, :PRINCIPAL_FRFS]
    factors = np.ascontiguousarray((directions / level).T)
    return PrincipalFrfs(factors, replace(measured, h=factors @ measured.h, variance=None))
