"""Focusing performance over temperature: contrast, spot error and response of the target."""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_shapes
from analysis.focusing.energy import EnergyForms, FieldSpace
from analysis.focusing.performance import contrast, decibels, mean_response, spot_error
from analysis.focusing.sound_aim import SoundAim

Aimed = tuple[Real, Real, Complex, Complex | None]


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
    sound : (T, L, F) ndarray, optional
        Complex: pressure at the panel's listeners over the wanted one (`SoundAim.relative`), modelling delay
        removed; None where no listener is declared and none is aimed at.
    """

    contrast: Real
    spot_error: Real
    response: Complex
    sound: Complex | None = None

    def __post_init__(self) -> None:
        check_shapes(self, contrast="T F", spot_error="T F", response="T F", sound="T L F")

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


def aim(
    space: FieldSpace,
    forms: EnergyForms,
    amplitude: Complex,
    filters: Complex,
    asked: float,
    sound: SoundAim | None = None,
) -> Aimed:
    """Contrast, spot error and response of filters in the band of one temperature.

    Parameters
    ----------
    forms : EnergyForms
        Of this temperature, at the F lines of the band.
    amplitude : (N, F, r) ndarray
        Generalised coordinates there.
    filters : (F, N) ndarray
    asked : float
        φᵀ W φ (`FieldSpace.asked`), m4.
    sound : SoundAim, optional
        Of the listeners, to be judged too.

    Returns
    -------
    Aimed
        Three arrays (F,), and the sound (L, F) or None.
    """
    spot = spot_error(space, amplitude, filters)
    heard = None if sound is None else sound.relative(space, amplitude, filters, sound.band)
    return contrast(forms, filters)[0], spot, mean_response(forms, filters, asked)[0], heard


def joined(rows: list[Aimed]) -> Aim:
    """Combine the results of `aim` at each temperature into one `Aim`."""
    contrasts, spots, responded, heard = zip(*rows, strict=True)
    sound = None if heard[0] is None else np.array(heard)
    return Aim(np.array(contrasts), np.array(spots), np.array(responded), sound)
