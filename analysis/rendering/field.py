"""How well the field of a piece of sound is focused while the temperature moves."""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Complex, Real
from analysis.focusing.energy import EnergyForms
from analysis.focusing.performance import contrast


@dataclass(frozen=True)
class FieldContrast:
    """Contrast of the field at one moment, paper eq. (9), literal.

    Attributes
    ----------
    mean, worst : float
        Over the lines of the band.
    sound : float
        Of the sound that is played: energies weighted with its spectrum; NaN where it is silent in the band.
    """

    mean: float
    worst: float
    sound: float


def field_contrast(forms: EnergyForms, filters: Complex, spectrum: Real) -> FieldContrast:
    """Judge filters on a plate, line by line and for a sound.

    Parameters
    ----------
    forms : EnergyForms
        Of one temperature, at the F lines.
    filters : (F, N) ndarray
    spectrum : (F,) ndarray
        Power of the sound.
    """
    lines = contrast(forms, filters)[0]
    whole = np.einsum("fn,fnm,fm->f", filters.conj(), forms.plate[0], filters).real * spectrum
    played = float(whole.sum())
    return FieldContrast(
        mean=float(lines.mean()),
        worst=float(lines.min()),
        sound=float(lines @ whole) / played if played > 0.0 else float("nan"),
    )


def power_spectrum(samples: Real, sample_rate: float, frequency: Real) -> Real:
    """Power of a signal about each of some frequencies.

    Sums of the squared Fourier coefficients from half a spacing below to half above.

    Parameters
    ----------
    samples : (n,) ndarray
    sample_rate : float
        Hz.
    frequency : (F,) ndarray, Hz
        Evenly spaced.

    Returns
    -------
    (F,) ndarray
        In the square of the unit of `samples`.
    """
    power = np.abs(np.fft.rfft(samples)) ** 2
    lines = np.arange(len(power)) * sample_rate / len(samples)
    half = 0.5 * (frequency[1] - frequency[0])
    place = np.searchsorted(np.append(frequency - half, frequency[-1] + half), lines, side="right") - 1
    held = (place >= 0) & (place < len(frequency))
    found: Real = np.bincount(place[held], power[held], len(frequency)) / len(samples) ** 2
    return found
