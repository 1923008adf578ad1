"""The four methods to drive a panel, by name: STIF, and those of the paper's Fig. 4 that it is compared with.

Spatio-temporal inverse filtering (STIF) is R(f, T) = H(f, T)⁺ φ (paper eq. 8), regularised. The others are time
reversal, modal control and no control.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_ascending, check_shapes
from analysis.focusing.energy import EnergyForms
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import Constants, PanelModel
from analysis.focusing.performance import contrast, mean_response, spot_error

Method = Literal["stif", "time-reversal", "modal-control", "none"]
METHODS: tuple[Method, ...] = ("stif", "time-reversal", "modal-control", "none")

Fields = Callable[[], Complex]
"""Computes amplitudes (N, F, r) for the methods that use them."""
Designer = Callable[[Constants, Fields, EnergyForms], Complex]


def time_reversal(response: Complex) -> Complex:
    """Return the time-reversal filters (T, F, N) for a source at the target's centre.

    By reciprocity they are the conjugate of `response` (T, F, N), the deflection that each actuator causes there:
    a matched filter for one point of the plate, without regard to the rest.
    """
    return response.conj()


def modal_control(
    shapes: Real, eigenvalues: Complex, coupling: Real, aim: Real, frequency: Real, count: int | None = None
) -> Complex:
    """Return the filters (F, N) that drive the first modes to the modal amplitudes of the target shape.

    Parameters
    ----------
    shapes : (m, m) ndarray
        Φᵀ W Φ of the m modes: their overlap over the grid, m2 (mass-normalised shapes).
    eigenvalues : (m,) ndarray
        Complex ω²(1 + jη), ascending, rad2/s2.
    coupling : (m, N) ndarray
        Modal force of each actuator, N/V.
    aim : (m,) ndarray
        Φᵀ W φ, overlap of every mode with the target shape.
    frequency : (F,) ndarray, Hz
    count : int, optional
        Number of modes controlled; by default as many as actuators.

    Returns
    -------
    (F, N) complex ndarray
        V per unit of audio signal.

    Raises
    ------
    ValueError
        For a `count` under 1 or over the m modes known.

    Notes
    -----
    The target's modal amplitudes are q = (Φᵀ W Φ)⁻¹ Φᵀ W φ of the controlled modes; the modal forces for them are
    (λ - ω²) q, and the filters B⁺ times these. Modes beyond `count` are not controlled.
    """
    count = coupling.shape[1] if count is None else count
    if not 1 <= count <= len(eigenvalues):
        raise ValueError(f"{count} modes to control; {len(eigenvalues)} are known")
    wanted = np.linalg.solve(shapes[:count, :count], aim[:count])
    force = (eigenvalues[None, :count] - (2.0 * np.pi * frequency[:, None]) ** 2) * wanted
    filters: Complex = force @ np.linalg.pinv(coupling[:count]).T
    return filters


def nearest_actuator(centers: Real, target: tuple[float, float], lines: int) -> Complex:
    """Return filters that drive only the actuator nearest to the target.

    Parameters
    ----------
    centers : (N, 2) ndarray, m
        Of the actuators.
    target : (float, float)
        Centre of the target, m.
    lines : int
        Number F.

    Returns
    -------
    (F, N) complex ndarray
        1 for the nearest actuator, 0 for the others.
    """
    nearest = int(np.argmin(np.sum((centers - np.asarray(target)) ** 2, axis=1)))
    filters = np.zeros((lines, len(centers)), dtype=complex)
    filters[:, nearest] = 1.0
    return filters


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


def designer(method: Method, model: PanelModel, panel: Panel, lines: Real) -> Designer:
    """Return the function that designs the filters of one method.

    Parameters
    ----------
    method : str
        One of `METHODS`.
    lines : (F,) ndarray, Hz

    Returns
    -------
    callable
        Takes (E, nu, eta), a callable that returns the amplitudes (N, F, r), and the energy forms of one
        temperature; returns filters (F, N), V per unit of audio signal. Where the panel declares a level, they are
        scaled to it at every line.

    Raises
    ------
    KeyError
        For a method of another name.
    """
    settings, displacement = panel.filters, panel.target.displacement
    band = settings.in_band(lines)

    def stif(_constants: Constants, _fields: Fields, forms: EnergyForms) -> Complex:
        weighed = forms.weighted(settings.kappa)
        if settings.regularisation == "tikhonov":
            return np.asarray(tikhonov(weighed, settings.tolerance)[0])
        return np.asarray(invert(weighed, settings.tolerance, settings.regularisation).filters[0])

    def reversal(_constants: Constants, fields: Fields, _forms: EnergyForms) -> Complex:
        amplitude = fields()
        return _loud(model, panel, amplitude, band, time_reversal(_at_center(model, panel, amplitude)))

    def modal(constants: Constants, _fields: Fields, _forms: EnergyForms) -> Complex:
        modes = model.modes(*constants, count=len(panel.centers))
        image = model.space.plate @ modes.shapes
        aim = modes.shapes.T @ model.space.aim * displacement
        return modal_control(image.T @ image, modes.eigenvalues, modes.coupling, aim, lines)

    def none(_constants: Constants, fields: Fields, _forms: EnergyForms) -> Complex:
        centers = np.array(panel.centers)
        return _loud(model, panel, fields(), band, nearest_actuator(centers, panel.target_center, len(lines)))

    rule = {"stif": stif, "time-reversal": reversal, "modal-control": modal, "none": none}[method]
    if settings.level is None:
        return rule
    wanted, asked = 10.0 ** (settings.level / 20.0), model.space.asked(displacement)

    def levelled(constants: Constants, fields: Fields, forms: EnergyForms) -> Complex:
        filters = rule(constants, fields, forms)
        reached = mean_response(forms, filters, asked)[0]
        scaled: Complex = filters * (wanted / np.maximum(np.abs(reached), 1e-6))[:, None]
        return scaled

    return levelled


def _at_center(model: PanelModel, panel: Panel, amplitude: Complex) -> Complex:
    centers = [loop.centroid for loop in panel.target_loops]
    response: Complex = np.mean([model.space.at_point(amplitude, center) for center in centers], axis=0).T
    return response


def _loud(
    model: PanelModel, panel: Panel, amplitude: Complex, band: NDArray[np.bool_], filters: Complex
) -> Complex:
    """Scale filters by one number, so that the target's centre moves by the desired displacement on average."""
    moved = np.sum(_at_center(model, panel, amplitude) * filters, axis=1)[band]
    loud: Complex = filters * (panel.target.displacement / np.abs(moved).mean())
    return loud


@dataclass(frozen=True)
class MethodComparison:
    """All methods on one plate, with complex filters (paper Fig. 4).

    Attributes
    ----------
    methods : tuple of str
    constants : (float, float, float)
        E (Pa), nu and eta of the plate.
    frequency : (F,) ndarray
        Hz.
    contrast, spot_error : (methods, F) ndarray
    """

    methods: tuple[str, ...]
    constants: tuple[float, float, float]
    frequency: Real
    contrast: Real
    spot_error: Real

    def __post_init__(self) -> None:
        check_shapes(self, methods="m", constants="3", frequency="F", contrast="m F", spot_error="m F")
        check_ascending(self, "frequency")


def compare(model: PanelModel, panel: Panel, constants: Constants) -> MethodComparison:
    """Contrast and spot error of every method on one plate.

    Parameters
    ----------
    constants : (float, float, float)
        E, Pa, nu and eta.

    Returns
    -------
    MethodComparison
        On the lines of the band.

    Raises
    ------
    ValueError
        For a material outside the box of the model.
    """
    lines = panel.filters.frequency
    band = panel.filters.in_band(lines)
    amplitude = model.amplitudes(*constants, lines)
    forms = model.forms(*constants, lines, panel.target.displacement)
    within, fields = forms.at(slice(None), band), amplitude[:, band]
    contrasts, spots = [], []
    for method in METHODS:
        filters = designer(method, model, panel, lines)(constants, lambda: amplitude, forms)
        contrasts.append(contrast(within, filters[band])[0])
        spots.append(spot_error(model.space, fields, filters[band]))
    return MethodComparison(METHODS, constants, lines[band], np.array(contrasts), np.array(spots))
