"""Focusing performance of a field and over temperature: contrast (paper eq. 9), level and phase, spot error."""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_shapes
from analysis.focusing.energy import EnergyForms, FieldSpace
from analysis.focusing.sound_aim import SoundAim


def contrast(forms: EnergyForms, filters: Complex) -> Real:
    """Contrast: energy over the target over energy over the plate, paper eq. (9).

    Parameters
    ----------
    filters : (T, F, N) ndarray
        Or (F, N), for the same filters at every temperature.

    Returns
    -------
    (T, F) ndarray
        0 to 1; 0 where the filters are silent.
    """
    inside = _energy(forms.target, filters)
    whole = _energy(forms.plate, filters)
    # Where the filters are silent contrast is undefined; the tiny floor makes it 0 and not NaN.
    literal: Real = np.clip(inside / np.maximum(whole, np.finfo(float).tiny), 0.0, 1.0)
    return literal


def best_contrast(forms: EnergyForms, floor: float = 1e-6) -> Real:
    """Upper bound of the contrast (T, F): the largest Rᴴ target R over Rᴴ plate R.

    Combinations of actuators that move the plate with less than `floor` of the largest amplitude are left out,
    because they need unlimited drives. The level of the target is not constrained.
    """
    values, vectors = np.linalg.eigh(forms.plate)
    kept = values > floor**2 * values[..., -1:]
    unit = vectors * np.where(kept, 1.0 / np.sqrt(np.where(kept, values, 1.0)), 0.0)[..., None, :]
    bound: Real = np.linalg.eigvalsh(unit.conj().swapaxes(-1, -2) @ forms.target @ unit)[..., -1]
    return bound


def area_normalised(literal: Real, target_share: float) -> Real:
    """Turn a `literal` contrast (...) into d/(d + o), d and o the mean energy densities inside and outside.

    Also 0 to 1; 1/2 for a uniform field whatever the target's size, `target_share` of the plate's area.
    """
    inside = literal / target_share
    outside = (1.0 - literal) / (1.0 - target_share)
    normalised: Real = inside / (inside + outside)
    return normalised


def mean_response(forms: EnergyForms, filters: Complex, asked: float) -> Complex:
    """Mean displacement of the target over the desired one, weighted by the target shape.

    Parameters
    ----------
    filters : (T, F, N) ndarray
        Or (F, N), for the same filters at every temperature.
    asked : float
        φᵀ W φ (`FieldSpace.asked`), m4.

    Returns
    -------
    (T, F) complex ndarray
        1 is the desired level and phase.
    """
    response: Complex = np.sum(forms.aim.conj() * filters, axis=-1) / asked
    return response


def decibels(response: Complex) -> Real:
    """Level (...) of a `response`, dB; silence is -200 dB."""
    level: Real = 20.0 * np.log10(np.maximum(np.abs(response), 1e-10))
    return level


def spot_error(space: FieldSpace, amplitude: Complex, filters: Complex) -> Real:
    """Distance (F,) from the target's centre, the nearest of several, to the largest |U|, over the plate's Lx.

    Parameters
    ----------
    amplitude : (N, F, r) ndarray
        Of one temperature.
    filters : (F, N) ndarray

    Returns
    -------
    (F,) ndarray
        Share of Lx.
    """
    driven = np.einsum("nfr,fn->rf", amplitude, filters)
    # One real product instead of a complex one: the deflection is real.
    parts = space.deflection @ np.concatenate([driven.real, driven.imag], axis=1)
    parts *= parts
    squared = parts[:, : len(filters)] + parts[:, len(filters) :]
    peak = space.grid.points[np.argmax(squared, axis=0)]
    away = np.linalg.norm(peak[:, None] - space.grid.centers, axis=-1)
    distance: Real = away.min(axis=1) / space.grid.length[0]
    return distance


def _energy(form: Complex, filters: Complex) -> Real:
    image = (form @ np.broadcast_to(filters, form.shape[:-1])[..., None])[..., 0]
    energy: Real = np.sum(filters.conj() * image, axis=-1).real
    return energy


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
