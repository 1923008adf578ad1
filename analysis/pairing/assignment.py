"""Modes measured and computed, and their pairs, one to one in a sweep; whether the twin is a fit at all.

A pair's value is (1 - d**2)(1 + a)/2, with the distance d of both frequencies over half the window, and the
agreement a of both residues, 1 for equal ones and -1 for opposite ones. The pairs of largest total value are found
by linear assignment (Kuhn 1955, as scipy solves it): two close modes are not exchanged because one of them lies a
little nearer, and a weak computed mode takes no strong measured one from its neighbour.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray

from analysis.identification.modes import Damping, Modes, PoleReading, read_poles
from analysis.pairing.points import PointComparison
from analysis.shapes.participation import mac

HEARD = 0.3
"""Peak of a mode over the rms of its FRFs from which on it counts as strong. Smaller ones lie on the flanks of
their neighbours, and what is missing there changes their residues first. Of an aluminium plate with three
accelerometers 13 of 14 modes reach it, of a polypropylene plate with one patch half."""


@dataclass(frozen=True)
class ModeList:
    """Frequencies, damping and residues of the modes of one sweep.

    Attributes
    ----------
    frequency, sigma_frequency : (J,) ndarray
        Hz, ascending; standard deviations are 0 where they are not known.
    damping_ratio, sigma_damping_ratio : (J,) ndarray
    residues : (K, J) complex ndarray
        Per channel, over the rms of the channel's measured FRF, rad/s.
    certain : (J,) bool ndarray
        Modes that are surely there: of measured ones those kept and confirmed.
    """

    frequency: NDArray[np.float64]
    sigma_frequency: NDArray[np.float64]
    damping_ratio: NDArray[np.float64]
    sigma_damping_ratio: NDArray[np.float64]
    residues: NDArray[np.complex128]
    certain: NDArray[np.bool_]

    def __post_init__(self) -> None:
        shape = self.frequency.shape
        for name in ("sigma_frequency", "damping_ratio", "sigma_damping_ratio", "certain"):
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} has shape {getattr(self, name).shape}; {shape} wanted")
        if self.residues.ndim != 2 or self.residues.shape[1:] != shape:
            raise ValueError(f"residues have shape {self.residues.shape}; (K, {len(self.frequency)}) wanted")
        if (np.diff(self.frequency) < 0.0).any() or not (self.frequency > 0.0).all():
            raise ValueError("frequencies must ascend from above 0 Hz")

    @classmethod
    def measured(cls, modes: Modes, rms: NDArray[np.float64]) -> Self:
        """Take the identified modes of a sweep, without poles that are no modes; `rms` (K,) of its FRFs."""
        own = modes.real
        certain = modes.sure & (modes.overlapped < 0)
        return cls._of(modes.reading(), modes.residues / rms[:, None], certain, np.flatnonzero(own))

    @classmethod
    def computed(
        cls,
        poles: NDArray[np.complex128],
        residues: NDArray[np.complex128],
        rms: NDArray[np.float64],
        damping: Damping = "hysteretic",
    ) -> Self:
        """Take poles and residues of a twin, without standard deviations.

        Its material was fitted to these resonances: most of the standard deviation of E, by the thickness, say,
        leaves the frequencies.

        Parameters
        ----------
        poles : (J,) complex ndarray
            rad/s, upper half plane.
        residues : (K, J) complex ndarray
            FRF unit times rad/s, gain included.
        rms : (K,) ndarray
            Of the measured FRFs.
        damping : str
            How poles are read.

        Returns
        -------
        ModeList
        """
        reading = _read(poles, damping)
        return cls._of(reading, residues / rms[:, None], np.ones(len(poles), dtype=bool), np.arange(len(poles)))

    @classmethod
    def _of(
        cls,
        reading: PoleReading,
        residues: NDArray[np.complex128],
        certain: NDArray[np.bool_],
        own: NDArray[np.intp],
    ) -> Self:
        row = _ascending(reading, own)
        return cls(
            reading.frequency_hz[row],
            reading.sigma_frequency_hz[row],
            reading.damping_ratio[row],
            reading.sigma_damping_ratio[row],
            residues[:, row],
            certain[row],
        )

    @property
    def bandwidth(self) -> NDArray[np.float64]:
        """Half-power bandwidths 2 zeta f, Hz, (J,)."""
        return 2.0 * self.damping_ratio * self.frequency

    @property
    def peak(self) -> NDArray[np.float64]:
        """Height of every mode's own resonance over the rms of its FRFs, root mean square over channels: (J,)."""
        width = 2.0 * np.pi * self.frequency * self.damping_ratio
        return np.asarray(np.sqrt((np.abs(self.residues) ** 2).mean(axis=0)) / width)

    @property
    def strong(self) -> NDArray[np.bool_]:
        """Modes that are certain and whose peak stands out of the FRFs, (J,)."""
        return np.asarray(self.certain & (self.peak > HEARD))


def _read(poles: NDArray[np.complex128], damping: Damping) -> PoleReading:
    return read_poles(poles, np.zeros((len(poles), 2, 2)), damping)


def _ascending(reading: PoleReading, own: NDArray[np.intp]) -> NDArray[np.intp]:
    return own[np.argsort(reading.frequency_hz[own], kind="stable")]


SHIFT = 0.02
"""Least half width of the window, relative. Else it is the half-power bandwidth; on lightly damped plates that is
less than masses and supports that nobody declared move modes."""
HALF_POWER = 0.5
"""Distance in the window up to which frequencies agree: where the window is the bandwidth, to where a resonance
falls to half its power."""
ALIKE = 0.5
"""Agreement of residues from which they are alike: 0.8 stands for a factor of two, 0.5 for 60 degrees of phase."""


@dataclass(frozen=True)
class ModePairs:
    """Modes of one sweep, measured and computed, and which belong together.

    Attributes
    ----------
    temperature : float
        Of the sweep, degrees Celsius.
    band : (float, float)
        In which modes were identified, Hz.
    measured, computed : ModeList
    measured_index, computed_index : (N,) int ndarray
        Of every pair, by ascending frequency.
    """

    temperature: float
    band: tuple[float, float]
    measured: ModeList
    computed: ModeList
    measured_index: NDArray[np.int_]
    computed_index: NDArray[np.int_]

    def as_read(
        self,
        modes: Modes,
        poles: NDArray[np.complex128],
        fitted: Callable[[NDArray[np.complex128]], NDArray[np.complex128]],
    ) -> "ModePairs":
        """Add to the measured modes' standard deviations what a fit like theirs misses of the twin's own modes.

        In a lossy plate several modes are one resonance, and one pole fits them to the noise: it lies between
        them, and its standard deviation does not know of it. A pole at 704.4 +- 0.08 Hz was two modes, at 702.9
        and 717.9 Hz.

        Parameters
        ----------
        modes : Modes
            The measured ones.
        poles : (M,) complex ndarray
            Of the twin, rad/s.
        fitted : callable
            Fits as many poles as were measured, from where they begin, to the twin's FRFs; keeps their order.
        """
        own = _ascending(modes.reading(), np.flatnonzero(modes.real))[self.measured_index]
        theirs = _ascending(_read(poles, modes.damping), np.arange(len(poles)))[self.computed_index]
        begun = modes.poles.copy()
        begun[own] = poles[theirs]
        read = _read(fitted(begun), modes.damping).frequency_hz[own]
        sigma = self.measured.sigma_frequency.copy()
        sigma[self.measured_index] = np.hypot(sigma[self.measured_index], read - self._computed("frequency"))
        return replace(self, measured=replace(self.measured, sigma_frequency=sigma))

    @property
    def difference(self) -> NDArray[np.float64]:
        """Computed over measured frequency, less 1, of every pair, (N,)."""
        return np.asarray(self._computed("frequency") / self._measured("frequency") - 1.0)

    @property
    def sigma(self) -> NDArray[np.float64]:
        """Standard deviation of `difference`, (N,)."""
        spread = np.hypot(self._measured("sigma_frequency"), self._computed("sigma_frequency"))
        return np.asarray(spread / self._measured("frequency"))

    @property
    def damping(self) -> NDArray[np.float64]:
        """Measured over computed damping ratio of every pair, (N,)."""
        return np.asarray(self._measured("damping_ratio") / self._computed("damping_ratio"))

    @property
    def distance(self) -> NDArray[np.float64]:
        """Distance of both frequencies over the half width of the window, 0 to 1, (N,)."""
        return distance_of(self.measured, self.computed)[self.measured_index, self.computed_index]

    @property
    def window(self) -> NDArray[np.float64]:
        """Half width of every pair's window, a share of the measured frequency, (N,)."""
        width = half_window(self.measured, self.computed)[self.measured_index, self.computed_index]
        return np.asarray(width / self._measured("frequency"))

    @property
    def mac(self) -> NDArray[np.float64] | None:
        """Modal assurance criterion of every pair, (N,); None for one channel, of which it says nothing."""
        one, other = self._residues
        if len(one) < 2:
            return None
        return np.asarray(np.diagonal(mac(one.T, other.T)))

    @property
    def mac_of_all(self) -> NDArray[np.float64] | None:
        """Modal assurance criterion of all measured and computed modes, (J, M); None for one channel."""
        one, other = self.measured.residues, self.computed.residues
        return None if len(one) < 2 else mac(one.T, other.T)

    @property
    def agreement(self) -> NDArray[np.float64]:
        """Agreement of the residues of every pair, (N,), see `agreement_of`."""
        one, other = self._residues
        return np.asarray(np.diagonal(agreement_of(one, other)))

    @property
    def unpaired_measured(self) -> NDArray[np.int_]:
        """Measured modes without a partner."""
        return np.setdiff1d(np.arange(len(self.measured.frequency)), self.measured_index)

    @property
    def missing(self) -> NDArray[np.int_]:
        """Computed modes that the FRFs should show and that were not measured.

        Not those beyond the band, not those that the instruments hardly see, and not those whose peak a larger one
        of a computed neighbour covers: there the measured mode stands for both.
        """
        alone = np.setdiff1d(np.arange(len(self.computed.frequency)), self.computed_index)
        peak, f, width = self.computed.peak, self.computed.frequency, self.computed.bandwidth
        shown = []
        inside = (f > self.band[0]) & (f < self.band[1])
        for j in alone[(self.computed.strong & inside)[alone]]:
            near = (np.abs(f - f[j]) < np.maximum(width, width[j])) & (peak > peak[j])
            if not near.any():
                shown.append(int(j))
        return np.array(shown, dtype=int)

    @property
    def matched(self) -> NDArray[np.bool_]:
        """Pairs that show one mode: frequencies in the inner half of the window, and residues alike, (N,)."""
        return np.asarray((self.distance < HALF_POWER) & (self.agreement > ALIKE))

    @property
    def count(self) -> tuple[int, int]:
        """Number of strong measured modes that are `matched`, and of all strong ones."""
        strong = self.measured.strong
        return int(strong[self.measured_index[self.matched]].sum()), int(strong.sum())

    @property
    def share(self) -> float:
        """Share of the strong measured modes that are `matched`; NaN where no mode is strong."""
        matched, strong = self.count
        return matched / strong if strong else float("nan")

    @property
    def counted(self) -> str:
        """Say `count` in words."""
        matched, strong = self.count
        return f"{matched} of {strong} strong measured modes where and as they are"

    @property
    def _residues(self) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        return self.measured.residues[:, self.measured_index], self.computed.residues[:, self.computed_index]

    def _measured(self, name: str) -> NDArray[np.float64]:
        return np.asarray(getattr(self.measured, name)[self.measured_index])

    def _computed(self, name: str) -> NDArray[np.float64]:
        return np.asarray(getattr(self.computed, name)[self.computed_index])


def agreement_of(one: NDArray[np.complex128], other: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Agreement 2 Re(a* b)/(|a|**2 + |b|**2) of all pairs of residues.

    Parameters
    ----------
    one, other : (K, J) and (K, M) ndarray

    Returns
    -------
    (J, M) ndarray
        -1 for opposite residues, 0 where one is much larger, 1 for equal ones.
    """
    cross = 2.0 * (one.conj().T @ other).real
    size = (np.abs(one) ** 2).sum(axis=0)[:, None] + (np.abs(other) ** 2).sum(axis=0)[None, :]
    found: NDArray[np.float64] = np.divide(cross, size, out=np.zeros_like(cross), where=size > 0.0)
    return found


def half_window(measured: ModeList, computed: ModeList) -> NDArray[np.float64]:
    """Half widths of all pairs' windows, Hz, (J, M): the wider mode's bandwidth, or `SHIFT` if that is more."""
    width = np.maximum(measured.bandwidth[:, None], computed.bandwidth[None, :])
    return np.asarray(np.maximum(width, SHIFT * measured.frequency[:, None]))


def distance_of(measured: ModeList, computed: ModeList) -> NDArray[np.float64]:
    """Distance of all frequencies over the half width of the window, (J, M)."""
    away = np.abs(measured.frequency[:, None] - computed.frequency[None, :])
    return np.asarray(away / half_window(measured, computed))


def pair_modes(temperature: float, band: tuple[float, float], measured: ModeList, computed: ModeList) -> ModePairs:
    """Pair the modes of one sweep.

    Parameters
    ----------
    temperature : float
        Degrees Celsius.
    band : (float, float)
        In which modes were identified, Hz.
    measured, computed : ModeList

    Returns
    -------
    ModePairs
    """
    value = np.maximum(1.0 - distance_of(measured, computed) ** 2, 0.0)
    value *= 0.5 * (1.0 + agreement_of(measured.residues, computed.residues))
    from scipy.optimize import linear_sum_assignment  # slow import

    rows, columns = linear_sum_assignment(value, maximize=True)
    real = value[rows, columns] > 0.0
    return ModePairs(temperature, band, measured, computed, rows[real], columns[real])


POOR = 0.5
"""Misfit from which a twin may be no fit; up to it, it has three quarters of the response's power."""
OVER_NOISE = 2.0
"""Ratio of the misfit to the noise from which the twin is to blame."""
LEAST_SHARE = 0.6
"""Share of the strong measured modes that a twin which fits has where and as they are. Of 13 simulated campaigns
of a polypropylene plate with a side 5 to 20 % or a patch 7 to 17 cm wrong, 0.18 to 0.50; of 51 with an effect of
the library of one, two and four times its prior, 0.85 and more wherever the misfit is `POOR`, but for orthotropy
of 10 % and more (0.33 and 0.47). On aluminium with a loss factor of 0.5 % orthotropy of 5 % and a taper of four
times its prior move modes by more than a bandwidth (0.31 and 0.50): without them that twin is no fit either, and
whether it is one with them is judged after the search."""

Source = Literal["modes.h5", "identified"]


@dataclass(frozen=True)
class PairedSweeps:
    """Measured and computed modes of some sweeps.

    Attributes
    ----------
    sweeps : tuple of ModePairs
    misfit, noise : (S,) ndarray
        Of these sweeps, shares of rms|H|.
    source : str
        ``modes.h5`` of the run folder, or ``identified`` for the comparison.
    points : PointComparison or None
        Of the shapes of all strong pairs, point by point; None for few points or modes.
    """

    sweeps: tuple[ModePairs, ...]
    misfit: NDArray[np.float64]
    noise: NDArray[np.float64]
    source: Source
    points: PointComparison | None = None

    def __post_init__(self) -> None:
        if not (self.misfit.shape == self.noise.shape == (len(self.sweeps),)):
            raise ValueError(f"misfit and noise are wanted of each of {len(self.sweeps)} sweeps")

    @property
    def failing(self) -> NDArray[np.bool_]:
        """Sweeps that the twin does not fit, (S,).

        Misfit and pairing must both fail: a lightly damped plate with a mass that nobody declared has a large
        misfit and modes that pair; modes so damped that they overlap pair by chance with some of any plate's, and
        then the misfit tells.
        """
        share = np.array([one.share for one in self.sweeps])
        poor = (self.misfit > POOR) & (self.misfit > OVER_NOISE * self.noise)
        return np.asarray(poor & ~(share >= LEAST_SHARE))  # NaN, no strong mode at all, pairs nothing

    @property
    def fits(self) -> bool:
        """Whether none of these sweeps fails."""
        return not self.failing.any()

    @property
    def worst(self) -> int:
        """The sweep of largest misfit among those that fail, or among all."""
        among = self.failing if self.failing.any() else np.ones(len(self.sweeps), dtype=bool)
        return int(np.where(among, self.misfit, -1.0).argmax())


@dataclass(frozen=True)
class Pairing:
    """Pairing of a campaign with its twin.

    Attributes
    ----------
    before : PairedSweeps
        With the updated material and no effects but those that were on from the beginning.
    after : PairedSweeps or None
        With the effects that were found, named or hints; None where none was.
    likely : str
        Likely reason where it is no fit, as tried; empty otherwise.
    wrong_declaration : bool
        Whether that reason is a declaration that makes the modes pair.
    """

    before: PairedSweeps
    after: PairedSweeps | None = None
    likely: str = ""
    wrong_declaration: bool = False

    @classmethod
    def of(cls, before: PairedSweeps | None) -> "Pairing | None":
        """Return the pairing without effects found; None where nothing could be paired."""
        return None if before is None else cls(before)

    @property
    def fits(self) -> bool:
        """Whether the twin is a fit, with the effects found or without."""
        return self.before.fits or (self.after is not None and self.after.fits)

    @property
    def wrong_points(self) -> tuple[str, ...]:
        """Sentences on sensors at wrong points or of wrong sign, by the twin with the effects found or without."""
        points = (self.after or self.before).points
        return () if points is None else points.said

    @property
    def said(self) -> str:
        """Sentence on a twin that is no fit; empty for one that is."""
        if self.fits:
            return ""
        sweep, misfit = self.before.sweeps[self.before.worst], self.before.misfit[self.before.worst]
        return (
            f"this is no fit: at {sweep.temperature:.1f} °C the twin misses {100 * misfit:.0f} % of the response, "
            f"and it has {sweep.counted}. E, nu, eta and gain are no estimates, and no effect can be named"
        )
