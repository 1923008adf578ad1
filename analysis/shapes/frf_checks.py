"""What FRFs of one structure must fulfil whatever it is: passive at drive points, reciprocal between two points.

At a drive point the structure takes power from the force at every frequency: the real part of its mobility is not
negative (Ewins, *Modal Testing*, 2000, section 2.8). Between points H_ij = H_ji (Maxwell's theorem). Hits beside
the point, a sensor of the wrong sign or place and cross-talk break one or the other.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Complex, Real
from analysis.estimation.transfer import INTEGRATED, MeasuredTransfer, along_axis, direction_sign

MOST_NEGATIVE = 0.05
"""Share of the drive point's power, in squares, that may have the wrong sign: noise leaves some per mille, a point
elsewhere a quarter and more, a sensor the wrong way round all."""
MOST_APART = 0.1
"""Relative difference of two reciprocal FRFs: hits that are 2 % of a wavelength beside their points make 10 %."""


@dataclass(frozen=True)
class FrfCheck:
    """One check.

    Attributes
    ----------
    names : tuple of str
        Of the FRF, or of the two that should be equal.
    value : float
        Share of power with the wrong sign, in squares, or relative rms difference.
    passed : bool
    """

    names: tuple[str, ...]
    value: float
    passed: bool

    @property
    def sentence(self) -> str:
        """What was found, in words."""
        per_cent = f"{100.0 * self.value:.2g} %"
        if len(self.names) > 1:
            verdict = "" if self.passed else ": a hit or a sensor is beside its point"
            return f"reciprocity with {self.names[1]}: {per_cent} apart{verdict}"
        if self.passed:
            return f"drive point: takes power at all frequencies (wrong sign: {per_cent})"
        return f"no drive point (wrong sign: {per_cent} of the power); check the sensor's sign and place"


def checks(transfers: Sequence[MeasuredTransfer], frequency: Real) -> list[FrfCheck]:
    """Check every drive point and every pair of reciprocal FRFs.

    Parameters
    ----------
    transfers : sequence of MeasuredTransfer
        Those of another quantity than motion over force are left out.
    frequency : (F,) ndarray
        Hz.
    """
    moving = [one for one in transfers if one.quantity in INTEGRATED and one.reference_quantity == "force"]
    ends = {(along_axis(one.response), along_axis(one.reference)): one for one in moving}
    found = []
    for one in moving:
        there, here = along_axis(one.response), along_axis(one.reference)
        if there == here:
            value = _wrong_power(_mobility(one, frequency))
            found.append(FrfCheck((one.name,), value, value <= MOST_NEGATIVE))
        other = ends.get((here, there))
        if other is not None and there < here:
            a, b = _mobility(one, frequency), _mobility(other, frequency)
            value = float(np.linalg.norm(a - b) / np.sqrt(0.5 * (np.linalg.norm(a) ** 2 + np.linalg.norm(b) ** 2)))
            found.append(FrfCheck((one.name, other.name), value, value <= MOST_APART))
    return found


def _mobility(one: MeasuredTransfer, frequency: Real) -> Complex:
    """Return velocity over force, both along the positive axes."""
    sign = direction_sign(one.response) * direction_sign(one.reference)
    w = 2.0 * np.pi * np.maximum(frequency, np.finfo(float).tiny)
    return np.asarray(sign * one.h * (1j * w) ** (1 - INTEGRATED[one.quantity]))


def _wrong_power(mobility: Complex) -> float:
    """Share of the real part that is negative, in squares: they count where the structure moves, not its noise."""
    size = float((mobility.real**2).sum())
    return float((np.minimum(mobility.real, 0.0) ** 2).sum()) / size if size else 0.0
