"""How well a field is focused: contrast (paper eq. 9) and spot error."""

import numpy as np

from analysis.arrays import Complex, Real
from analysis.focusing.energy import EnergyForms, FieldSpace


def contrast(forms: EnergyForms, filters: Complex, target_share: float | None = None) -> Real:
    """Contrast (T, F) of `filters` (T, F, N): energy over the target over energy over the plate.

    Parameters
    ----------
    forms : EnergyForms
    filters : (T, F, N) ndarray, or (F, N) for the same filters at every temperature
    target_share : float, optional
        Area of the target over area of the plate. Left out, the contrast is paper eq. (9) as it
        stands, 0 to 1. Given, it is the area-normalised ratio d/(d + o) of the mean energy densities
        inside (d) and outside (o) the target, also 0 to 1, which a uniform field brings to 1/2.
    """
    inside = _energy(forms.target, filters)
    whole = _energy(forms.plate, filters)
    # A line where the filters are silent has no contrast; the tiny floor makes it 0 and not NaN.
    literal: Real = np.clip(inside / np.maximum(whole, np.finfo(float).tiny), 0.0, 1.0)
    if target_share is None:
        return literal
    density_inside = literal / target_share
    density_outside = (1.0 - literal) / (1.0 - target_share)
    normalised: Real = density_inside / (density_inside + density_outside)
    return normalised


def spot_error(space: FieldSpace, amplitude: Complex, filters: Complex) -> Real:
    """Distance (F,) from the target's centre to the largest |U|, as a share of the plate's length Lx.

    Parameters
    ----------
    space : FieldSpace
    amplitude : (N, F, r) ndarray
        Of one temperature.
    filters : (F, N) ndarray
    """
    field = space.deflection @ np.einsum("nfr,fn->rf", amplitude, filters)
    peak = space.grid.points[np.argmax(np.abs(field), axis=0)]
    distance: Real = np.hypot(*(peak - np.asarray(space.grid.center)).T)
    return distance / space.grid.length[0]


def _energy(form: Complex, filters: Complex) -> Real:
    image = (form @ np.broadcast_to(filters, form.shape[:-1])[..., None])[..., 0]
    energy: Real = np.sum(filters.conj() * image, axis=-1).real
    return energy
