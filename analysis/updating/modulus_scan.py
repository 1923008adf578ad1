"""Modulus scan: rough modulus from one sweep's resonances, because building a twin for the box takes minutes.

Power spectra of data and plate are smoothed over `WINDOW` of the frequency, so that neither damping nor model
errors of a per cent matter. They are compared as levels over log frequency, where a change of modulus (and nearly
so of thickness or density) is a shift.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.material import MaterialBox

WINDOW = 0.05
"""Width of the smoothing, as a share of the frequency."""
POINTS_PER_WINDOW = 4
STEP = 0.08
"""Step of log E in the scan: shifts frequencies by less than the window."""
REACH = 9.0
"""Smallest factor by which the scan exceeds the declared moduli: half or twice the thickness at equal mass."""
SOFTEST, STIFFEST, FARTHEST = 0.6e9, 300e9, 100.0
"""Moduli of common plates, Pa, which the scan also covers, within this factor of the declared ones."""
AGREES = 0.7
"""Smallest correlation of a credible modulus: the right one reaches 0.93 on polymers, 0.74 on metals."""
DIFFERS, FAR = 0.1, 0.3
"""Excess of its correlation over the best within the declared range, for a warning and for an error."""
FLOOR = 1e-5
"""Smallest power relative to the largest: deeper antiresonances are cut off."""


class CoarseModel(Protocol):
    """Model of a plate, as the scan needs it."""

    def frf(self, youngs_modulus: float, poisson_ratio: float, frequency: Real) -> NDArray[np.complex128]:
        """Transfer of a moderately damped plate.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) ndarray
            Hz.

        Returns
        -------
        (K, F) complex ndarray
            Sensor volts per actuator volt.
        """
        ...


@dataclass(frozen=True)
class ModulusScan:
    """Result of the scan of one sweep.

    Attributes
    ----------
    modulus, inside : float
        Modulus of best agreement, Pa: over the whole scan, and within the declared range.
    agreement, agreement_inside : float
        Correlation of the levels there, -1 to 1.
    """

    modulus: float
    agreement: float
    inside: float
    agreement_inside: float

    @property
    def outside(self) -> bool:
        """Whether a modulus outside the declared range agrees well, and better than those inside."""
        return self.agreement > AGREES and self.agreement > self.agreement_inside + DIFFERS

    @property
    def far_outside(self) -> bool:
        """Whether, in addition, no modulus within the range agrees nearly as well."""
        return self.outside and self.agreement > self.agreement_inside + FAR


def scanned_box(box: MaterialBox) -> MaterialBox:
    """Box of all materials that the scan evaluates."""
    low, high = box.youngs_modulus
    lowest = min(low / REACH, max(low / FARTHEST, SOFTEST))
    highest = max(high * REACH, min(high * FARTHEST, STIFFEST))
    return MaterialBox((lowest, highest), box.poisson_ratio, box.loss_factor)


def scan_modulus(model: CoarseModel, frequency: Real, h: NDArray[np.complex128], box: MaterialBox) -> ModulusScan:
    """Find the modulus at which the levels of one sweep agree best with the plate's.

    Parameters
    ----------
    model : CoarseModel
        Evaluated within `scanned_box`.
    frequency : (F,) ndarray
        Hz, without lines of mains.
    h : (K, F) complex ndarray
        Measured FRF, V/V.
    box : MaterialBox
        As declared.
    """
    grid = scan_grid(frequency)
    seen = levels(smoothed(np.abs(h) ** 2, frequency, grid))
    low, high = scanned_box(box).youngs_modulus
    moduli = np.geomspace(low, high, int(np.ceil(np.log(high / low) / STEP)) + 1)
    nu_low, nu_high = box.poisson_ratio

    def agreement(e: float, nu: float) -> float:
        power = smoothed(np.abs(model.frf(e, nu, grid)) ** 2, grid, grid)
        return float(np.mean((seen * levels(power)).mean(axis=1)))

    found = np.array([agreement(float(e), 0.5 * (nu_low + nu_high)) for e in moduli])
    declared = (moduli >= box.youngs_modulus[0] / np.exp(STEP)) & (moduli <= box.youngs_modulus[1] * np.exp(STEP))
    for chosen in (declared, ~declared):  # the best of both are also tried with other Poisson's ratios
        for k in np.flatnonzero(chosen)[np.argsort(found[chosen])[-4:]]:
            others = (nu_low + share * (nu_high - nu_low) for share in (0.15, 0.85))
            found[k] = max(found[k], *(agreement(float(moduli[k]), nu) for nu in others))
    best, best_inside = int(found.argmax()), int(np.where(declared, found, -np.inf).argmax())
    return ModulusScan(
        float(moduli[best]), float(found[best]), float(moduli[best_inside]), float(found[best_inside])
    )


def scan_grid(frequency: Real) -> Real:
    """Frequencies (G,), Hz, at which levels of FRFs measured at `frequency` (F,) are compared."""
    count = int(np.ceil(np.log(frequency[-1] / frequency[0]) * POINTS_PER_WINDOW / WINDOW)) + 1
    return np.asarray(np.geomspace(frequency[0], frequency[-1], count))


def smoothed(power: Real, frequency: Real, grid: Real) -> Real:
    """Mean of powers over Hann windows of `WINDOW` about every point of a grid.

    Parameters
    ----------
    power : (K, F) ndarray
    frequency : (F,) ndarray
        Hz.
    grid : (G,) ndarray
        Hz.

    Returns
    -------
    (K, G) ndarray
    """
    distance = np.log(frequency[None, :] / grid[:, None]) / WINDOW
    weight = np.where(np.abs(distance) < 1.0, 1.0 + np.cos(np.pi * np.clip(distance, -1.0, 1.0)), 0.0)
    weight *= np.gradient(frequency)
    return np.asarray((power @ weight.T) / weight.sum(axis=1))


def levels(power: Real) -> Real:
    """Logarithms of powers (K, G) without linear trend, of mean 0 and variance 1."""
    level = np.log(np.maximum(power, FLOOR * power.max(axis=1, keepdims=True)))
    place = np.linspace(-1.0, 1.0, level.shape[1])
    trend = np.polynomial.polynomial.polyfit(place, level.T, 1)
    level = level - np.polynomial.polynomial.polyval(place, trend)
    return np.asarray(level / np.maximum(level.std(axis=1, keepdims=True), 1e-12))
