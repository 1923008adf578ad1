"""The modes of one condition: common poles of its FRFs as frequencies and damping, residues and residual terms.

A polymer's damping is hysteretic: with k = -lambda^2 the complex stiffness over mass of the mode, sqrt(Re k)/2 pi
is the frequency from its storage modulus alone, and Im k / Re k its loss factor. The frequency of a
viscous oscillator, |lambda|/2 pi, lies higher by a share of eta^2/4 for the same pole (eta^2/2 in the modulus).

Distribution of the damping ratios of one plate: a prior for modes that overlap with their neighbours.

Two modes that overlap look like one mode with more damping, and where many overlap, the damping of each is hardly
determined. A plate's material damps all its modes by about as much, so the other modes are a prior. Its width is
estimated from the modes themselves; the heavy tails of a Student distribution allow outliers.
"""

from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from analysis.identification.pole_residue import ResidualTerms, synthesis, to_parameters
from analysis.scatter import median_deviation

Damping = Literal["hysteretic", "viscous"]


@dataclass(frozen=True)
class PoleReading:
    """Frequency and damping of poles, each array shaped like the poles.

    Attributes
    ----------
    frequency_hz, sigma_frequency_hz : ndarray, Hz
    damping_ratio, sigma_damping_ratio : ndarray
        -Re lambda / |lambda|, for hysteretic and viscous damping alike.
    loss_factor, sigma_loss_factor : ndarray
        Im k / Re k if hysteretic, twice the damping ratio if viscous.
    """

    frequency_hz: NDArray[np.float64]
    sigma_frequency_hz: NDArray[np.float64]
    damping_ratio: NDArray[np.float64]
    sigma_damping_ratio: NDArray[np.float64]
    loss_factor: NDArray[np.float64]
    sigma_loss_factor: NDArray[np.float64]


STATUSES = ("kept", "weak", "computational", "harmonic")
CONFIRMATIONS = ("confirmed", "unconfirmed")
NOT_ONE = "perhaps not one mode"
"""Words in the reason of a mode which one pole does not describe."""


@dataclass(frozen=True)
class Rejected:
    """A pole that was tried and is not in the model, or a line that was left out of the fit.

    Attributes
    ----------
    pole : complex
        rad/s; purely imaginary for a line.
    reason : str
    status : str
        ``computational`` or ``harmonic``.
    """

    pole: complex
    reason: str
    status: str = "computational"


@dataclass(frozen=True)
class Modes:
    """Poles, residues and residual terms identified from FRFs; `synthesis` rebuilds the FRFs.

    Attributes
    ----------
    poles : (J,) complex ndarray
        rad/s, by rising frequency; all that the model needs, modes of the plate or not. `synthesis` takes these.
    residues : (K, J) complex ndarray
        FRF unit times rad/s.
    covariance : (J, 2, 2) ndarray
        Of log |pole| and log damping ratio, misfit included.
    terms : ResidualTerms
        For the modes out of band, with their `coefficients` (K, P).
    status, reason : tuple of str
        Per pole: ``kept``, ``weak``, ``computational`` or ``harmonic``, and why.
    band : (float, float)
        Hz.
    misfit : float
        rms of the residual, as a share of rms |h|.
    lines : int
        Frequency lines fitted.
    rejected : tuple of Rejected
        Start poles that were dropped, and lines left out of the fit.
    confirmation : tuple of str
        Per pole: ``confirmed`` where refits of parts of the data, or a sweep at a neighbouring temperature, find a
        mode again, ``unconfirmed`` where not, an empty string for poles that are no modes; an empty tuple where no
        refits were made.
    damping : str
        How `reading` reads poles unless it is told: ``hysteretic`` or ``viscous``.
    corrected : (J,) complex ndarray or None
        `poles` at the temperature stated for the sweep, where a sine on a ramp is known to have passed them at
        another one. `covariance` is then that of these.
    """

    poles: NDArray[np.complex128]
    residues: NDArray[np.complex128]
    covariance: NDArray[np.float64]
    terms: ResidualTerms
    coefficients: NDArray[np.complex128]
    status: tuple[str, ...]
    reason: tuple[str, ...]
    band: tuple[float, float]
    misfit: float
    lines: int
    rejected: tuple[Rejected, ...] = ()
    confirmation: tuple[str, ...] = ()
    damping: Damping = "hysteretic"
    corrected: NDArray[np.complex128] | None = None

    def __post_init__(self) -> None:
        count, responses = len(self.poles), self.residues.shape[0]
        wanted = {
            "residues": (responses, count),
            "covariance": (count, 2, 2),
            "coefficients": (responses, len(self.terms.powers)),
            "stated_poles": (count,),
        }
        for name, shape in wanted.items():
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} has shape {getattr(self, name).shape}; {shape} wanted")
        if len(self.status) != count or len(self.reason) != count:
            raise ValueError(f"{count} poles need as many statuses and reasons")
        unknown = sorted(set(self.status) - set(STATUSES))
        if unknown:
            raise ValueError(f"status {unknown[0]!r} is not one of {STATUSES}")
        if self.confirmation and (
            len(self.confirmation) != count or set(self.confirmation) - {"", *CONFIRMATIONS}
        ):
            raise ValueError(f"{count} poles need as many confirmations, of {CONFIRMATIONS} or nothing")
        if self.damping not in get_args(Damping):
            raise ValueError(f"damping {self.damping!r}: {' or '.join(get_args(Damping))}")
        for poles in (self.poles, self.stated_poles):
            if (poles.real >= 0.0).any() or (poles.imag <= 0.0).any():
                raise ValueError("poles must be stable and in the upper half plane")

    @property
    def stated_poles(self) -> NDArray[np.complex128]:
        """Poles at the temperature stated for the sweep, (J,), rad/s: `corrected`, or `poles` as fitted."""
        return self.poles if self.corrected is None else self.corrected

    @property
    def real(self) -> NDArray[np.bool_]:
        """Poles that are modes of the plate, kept or weak: (J,) ndarray."""
        return np.array([status in ("kept", "weak") for status in self.status], dtype=bool)

    @property
    def sure(self) -> NDArray[np.bool_]:
        """Modes that are kept and, where refits were made, confirmed: (J,) ndarray."""
        words = [self.confirmed_word(n) for n in range(len(self.poles))]
        sure = [s == "kept" and w != "unconfirmed" for s, w in zip(self.status, words, strict=True)]
        return np.array(sure, dtype=bool)

    def of_rows(self, which: NDArray[np.bool_]) -> "Modes":
        """Return the modes of some of the FRFs (K,)."""
        return replace(self, residues=self.residues[which], coefficients=self.coefficients[which])

    def left_out(self, frequency: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which lines (F,), Hz, were left out of the fit: tones and mains hum among `rejected`."""
        gone = np.array([abs(r.pole) / (2.0 * np.pi) for r in self.rejected if complex(r.pole).real == 0.0])
        near: NDArray[np.bool_] = np.isclose(frequency[:, None], gone, rtol=1e-9, atol=0.0).any(axis=1)
        return near

    def confirmed_word(self, pole: int) -> str:
        """Return ``confirmed`` or ``unconfirmed``; empty for a pole that is no mode, or without refits."""
        return self.confirmation[pole] if self.confirmation else ""

    def standing(self, pole: int) -> str:
        """Status of a pole, and whether refits confirm it: ``kept, confirmed``."""
        return ", ".join(word for word in (self.status[pole], self.confirmed_word(pole)) if word)

    @property
    def overlapped(self) -> NDArray[np.int_]:
        """Index of the mode that each mode overlaps, (J,); -1 for none, and for poles that are no modes.

        Two modes closer than half of the half-power bandwidth are not determined separately: the stated standard
        deviations cover noise, but not other ways to split the sum of the two.
        """
        circular = np.abs(self.poles)
        nearest = np.full(len(self.poles), -1)
        for j in np.flatnonzero(self.real):
            away = np.where(self.real, np.abs(circular - circular[j]), np.inf)
            away[j] = np.inf
            if away.min() < -self.poles[j].real:
                nearest[j] = int(away.argmin())
        return nearest

    def explanation(self) -> tuple[str, ...]:
        """`reason` of every pole, and with which other mode it overlaps."""
        frequency = self.reading().frequency_hz
        return tuple(
            reason
            if other < 0
            else f"{reason}; overlaps {frequency[other]:.1f} Hz: their damping is known together, not singly"
            for reason, other in zip(self.reason, self.overlapped, strict=True)
        )

    def reading(self, damping: Damping | None = None) -> PoleReading:
        """Frequency, damping ratio and loss factor of every pole, with standard deviations."""
        return read_poles(self.stated_poles, self.covariance, damping or self.damping)

    def read_as(self, damping: Damping) -> "Modes":
        """Return the same modes, read in another way."""
        return replace(self, damping=damping)

    def synthesis(self, frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Rebuild the FRFs, (K, F), at `frequency` [Hz]."""
        return synthesis(frequency, self.poles, self.residues, self.terms, self.coefficients)


def read_poles(
    poles: NDArray[np.complex128], covariance: NDArray[np.float64], damping: Damping = "hysteretic"
) -> PoleReading:
    """Read frequency and damping off poles.

    Parameters
    ----------
    poles : (...) complex ndarray
        rad/s, upper half plane.
    covariance : (..., 2, 2) ndarray
        Of log |lambda| and log damping ratio of each pole.
    damping : str
        ``hysteretic`` or ``viscous``.

    Returns
    -------
    PoleReading
        Frequency, Hz, damping ratio and loss factor, (...), with standard deviations.

    Raises
    ------
    ValueError
        For another word.
    """
    if damping not in get_args(Damping):
        raise ValueError(f"damping {damping!r}: {' or '.join(get_args(Damping))}")
    w = np.abs(poles)
    zeta = -poles.real / w
    spread_w, spread_zeta = covariance[..., 0, 0], covariance[..., 1, 1]
    if damping == "viscous":
        f, eta = w / (2.0 * np.pi), 2.0 * zeta
        sigma_f, sigma_eta = f * np.sqrt(spread_w), eta * np.sqrt(spread_zeta)
    else:
        storage = 1.0 - 2.0 * zeta**2
        f = w * np.sqrt(storage) / (2.0 * np.pi)
        eta = 2.0 * zeta * np.sqrt(1.0 - zeta**2) / storage
        slope_f = -2.0 * zeta**2 / storage  # d log f / d log zeta
        slope_eta = 1.0 - zeta**2 / (1.0 - zeta**2) + 4.0 * zeta**2 / storage
        cross = covariance[..., 0, 1]
        sigma_f = f * np.sqrt(np.maximum(spread_w + 2.0 * slope_f * cross + slope_f**2 * spread_zeta, 0.0))
        sigma_eta = eta * np.abs(slope_eta) * np.sqrt(spread_zeta)
    return PoleReading(f, sigma_f, zeta, zeta * np.sqrt(spread_zeta), eta, sigma_eta)


STUDENT_FREEDOM = 4.0
"""Degrees of freedom of the Student distribution: with few, an outlier is hardly pulled to the others."""

FEWEST_MODES = 8
"""Modes needed at least to estimate the distribution."""

LEAST_DEVIATION = 0.02
"""Smallest standard deviation of the distribution of the log damping ratio."""

HARDLY_KNOWN = 0.5
"""A prior is used only if some mode's log damping ratio is known worse than this share of the scatter of all."""

DOUBLE_MODE_SIGMA = 3.0
"""Standard deviations above the median from which a pole may represent two modes."""

SHARED = (1.4, 6.0)
"""Damping ratio over the median, and standard deviations above it, from which a pole is reported as possibly two
modes: where forty modes overlap, poles that represent two have 1.5 to 2 and 9 to 30."""

NEIGHBOURHOOD, OVERLAPPING_MODES = 3.0, 2
"""Modes overlap where this many half-power bandwidths to either side hold at least this many other modes."""


@dataclass(frozen=True)
class DampingPrior:
    """Distribution of log damping ratios of the modes in a band.

    Attributes
    ----------
    middle, deviation : float
    band : (float, float)
        rad/s.
    """

    middle: float
    deviation: float
    band: tuple[float, float]

    @classmethod
    def estimated(
        cls, poles: NDArray[np.complex128], deviations: NDArray[np.float64], band: tuple[float, float]
    ) -> "DampingPrior | None":
        """Estimate the distribution from poles.

        Parameters
        ----------
        poles : (J,) complex ndarray
            rad/s.
        deviations : (J,) ndarray
            Standard deviations of their log damping ratios.
        band : (float, float)
            rad/s.

        Returns
        -------
        DampingPrior or None
            None where there are too few poles, or the prior would add nothing to what is known of each.
        """
        inside = (poles.imag > band[0]) & (poles.imag < band[1])
        if inside.sum() < FEWEST_MODES:
            return None
        damping = to_parameters(poles)[inside, 1]
        middle = float(np.median(damping))
        away = np.abs(damping - middle)
        deviation = max(float(median_deviation(damping)[0]), LEAST_DEVIATION)
        if not ((deviations[inside] > HARDLY_KNOWN * deviation) | (away > DOUBLE_MODE_SIGMA * deviation)).any():
            return None
        return cls(middle, deviation, band)

    def above(self, poles: NDArray[np.complex128]) -> NDArray[np.float64]:
        """How many deviations each pole's log damping ratio lies above the middle, (J,); 0 outside the band."""
        inside = (poles.imag > self.band[0]) & (poles.imag < self.band[1])
        return np.where(inside, (to_parameters(poles)[:, 1] - self.middle) / self.deviation, 0.0)

    def shared(self, poles: NDArray[np.complex128]) -> NDArray[np.float64]:
        """Damping ratio over the median, (J,), of poles that may represent two overlapping modes; 0 for others."""
        above, width = self.above(poles), 2.0 * np.exp(self.middle) * np.abs(poles)
        near = np.abs(poles.imag[:, None] - poles.imag) < NEIGHBOURHOOD * width[:, None]
        crowded = (near & (np.abs(above) < DOUBLE_MODE_SIGMA)).sum(axis=1) >= OVERLAPPING_MODES
        times = np.exp(above * self.deviation)
        return np.where(crowded & (above > SHARED[1]) & (times > SHARED[0]), times, 0.0)

    def departure(
        self, poles: NDArray[np.complex128]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Twice the negative log probability of each pole's damping ratio, less its minimum, with derivatives.

        Parameters
        ----------
        poles : (J,) complex ndarray
            rad/s.

        Returns
        -------
        value : (J,) ndarray
        slope, bend : (J,) ndarray
            Half the first derivative with respect to the log damping ratio, and half the second, taken as
            constant.
        """
        inside = (poles.imag > self.band[0]) & (poles.imag < self.band[1])
        away = self.above(poles)
        bend = np.where(inside, (STUDENT_FREEDOM + 1.0) / (STUDENT_FREEDOM + away**2) / self.deviation**2, 0.0)
        return (STUDENT_FREEDOM + 1.0) * np.log1p(away**2 / STUDENT_FREEDOM), away * bend * self.deviation, bend
