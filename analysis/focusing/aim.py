"""Focusing performance over temperature: contrast, spot error and response of the target."""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Complex, Real
from analysis.focusing.energy import EnergyForms, FieldSpace
from analysis.focusing.performance import contrast, decibels, mean_response, spot_error

Aimed = tuple[Real, Real, Complex]


@dataclass(frozen=True)
class Aim:
    """Focusing performance of a set of filters over temperature and the lines of the band.

    Attributes
    ----------
    contrast : (T, F) ndarray
        Paper eq. (9), literal.
    spot_error : (T, F) ndarray
        Share of the plate's length Lx.
    response : (T, F) ndarray
        Complex: mean displacement of the target over the desired one, modelling delay removed.
    """

    contrast: Real
    spot_error: Real
    response: Complex

    @property
    def level(self) -> Real:
        """Level (T, F) of the target, dB relative to the desired displacement."""
        return decibels(self.response)

    @property
    def level_ripple(self) -> Real:
        """Loudest less softest line of the band (T,), dB."""
        return np.asarray(np.ptp(self.level, axis=1))

    @property
    def phase_error(self) -> Real:
        """Largest deviation of the target's phase from a pure delay in the band (T,), degrees."""
        return np.asarray(np.abs(np.angle(self.response, deg=True)).max(axis=1))


def aim(space: FieldSpace, forms: EnergyForms, amplitude: Complex, filters: Complex, asked: float) -> Aimed:
    """Contrast, spot error and response of filters in the band of one temperature.

    Parameters
    ----------
    space : FieldSpace
    forms : EnergyForms
        Of this temperature, at the F lines of the band.
    amplitude : (N, F, r) ndarray
        Generalised coordinates there.
    filters : (F, N) ndarray
    asked : float
        φᵀ W φ (`FieldSpace.asked`), m4.

    Returns
    -------
    Aimed
        Three arrays (F,).
    """
    spot = spot_error(space, amplitude, filters)
    return contrast(forms, filters)[0], spot, mean_response(forms, filters, asked)[0]


def joined(rows: list[Aimed]) -> Aim:
    """Combine the results of `aim` at each temperature into one `Aim`."""
    contrasts, spots, responded = (np.array(part) for part in zip(*rows, strict=True))
    return Aim(contrasts, spots, responded)
