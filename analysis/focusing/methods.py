"""The four methods to drive a panel, by name: STIF, and those of the paper's Fig. 4 that it is compared with.

These are time reversal, modal control and no control.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_ascending, check_shapes
from analysis.focusing.energy import EnergyForms
from analysis.focusing.inversion import invert, tikhonov
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
