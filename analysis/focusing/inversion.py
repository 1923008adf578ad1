"""Spatio-temporal inverse filtering: R(f, T) = H(f, T)⁺ φ (paper eq. 8), regularised."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from analysis.focusing.energy import EnergyForms

Regularisation = Literal["tikhonov", "truncation"]


@dataclass(frozen=True)
class InverseFilters:
    """STIF filters, with rank and condition of the regularised inverse.

    Attributes
    ----------
    filters : (T, F, N) ndarray
        R(f, T), V per unit of audio signal.
    regularisation : str
        ``tikhonov`` or ``truncation``.
    tolerance : float
        Threshold, as a share of the largest singular value of H at each temperature and frequency.
    rank : (T, F) ndarray
        Number of singular values above the tolerance; truncation keeps these.
    condition : (T, F) ndarray
        Largest over smallest singular value.
    """

    filters: NDArray[np.complex128]
    regularisation: Regularisation
    tolerance: float
    rank: NDArray[np.int64]
    condition: NDArray[np.float64]


def tikhonov(forms: EnergyForms, tolerance: float) -> NDArray[np.complex128]:
    """Return the filters (T, F, N) of `invert` with Tikhonov regularisation, without singular values."""
    found = np.linalg.solve(forms.damped(tolerance), forms.aim[..., None])[..., 0]
    return np.asarray(found, dtype=np.complex128)


def invert(
    forms: EnergyForms, tolerance: float = 0.01, regularisation: Regularisation = "tikhonov"
) -> InverseFilters:
    """STIF filters of every temperature and frequency.

    Parameters
    ----------
    forms : EnergyForms
        Of T temperatures, F lines and N actuators.
    tolerance : float
        Share of the largest singular value, 1e-7 to 1.
    regularisation : str
        ``tikhonov`` or ``truncation``.

    Returns
    -------
    InverseFilters
        Filters (T, F, N), V per unit of audio signal, with rank and condition.

    Raises
    ------
    ValueError
        For a tolerance outside 1e-7 to 1 or a regularisation of another name.

    Notes
    -----
    With Hᴴ W H = V diag(s²) Vᴴ and the largest singular value s₁, the filters are
    V diag(g) Vᴴ Hᴴ W φ where g = 1/(s² + tolerance² s₁²) (Tikhonov) or g = 1/s² for
    s > tolerance · s₁ and 0 else (truncation, as the paper and its reference [37] do).
    Forming Hᴴ W H squares the condition number: a tolerance under about 1e-7 would act on rounding.
    """
    if not 1e-7 <= tolerance < 1.0:
        raise ValueError(f"tolerance {tolerance:g} is outside 1e-7 to 1")
    values, vectors = np.linalg.eigh(forms.plate)
    values = np.maximum(values, 0.0)
    largest = values[..., -1:]
    kept = values > tolerance**2 * largest
    if regularisation == "tikhonov":
        gain = 1.0 / (values + tolerance**2 * largest)
    elif regularisation == "truncation":
        gain = np.where(kept, 1.0 / np.where(kept, values, 1.0), 0.0)
    else:
        raise ValueError(f"regularisation {regularisation!r}: tikhonov or truncation")
    coordinates = np.einsum("tfnm,tfn->tfm", vectors.conj(), forms.aim)
    filters = np.einsum("tfnm,tfm->tfn", vectors, gain * coordinates)
    smallest = np.maximum(values[..., 0], np.finfo(float).eps ** 2 * values[..., -1])
    return InverseFilters(
        filters,
        regularisation,
        tolerance,
        np.count_nonzero(kept, axis=-1),
        np.sqrt(values[..., -1] / smallest),
    )
