"""Protocol of a computed panel: fields, energies and modes.

Responses of a panel at the temperatures of its laws, and the forms by which filters are designed there.

These temperatures are steps over the range that laws and panel have in common.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_finite, check_shapes
from analysis.focusing.energy import EnergyForms, FieldSpace
from analysis.focusing.panel import Panel
from analysis.focusing.sound_aim import SoundAim
from analysis.material import MaterialLaws

Constants = tuple[float, float, float]
"""E, Pa, nu and eta."""


@dataclass(frozen=True)
class PanelModes:
    """Natural modes of a panel, mass-normalised, in the twin's generalised coordinates.

    Attributes
    ----------
    eigenvalues : (m,) ndarray
        Complex ω²(1 + jη), ascending, rad2/s2.
    shapes : (r, m) ndarray
    coupling : (m, N) ndarray
        Modal force of every actuator, N/V or N/N.
    """

    eigenvalues: Complex
    shapes: Real
    coupling: Real

    def __post_init__(self) -> None:
        check_shapes(self, eigenvalues="m", shapes="r m", coupling="m N")
        check_finite(self, "eigenvalues", "shapes", "coupling")


class PanelModel(Protocol):
    """A panel that can be computed: the interface through which `analysis` uses the twin."""

    @property
    def space(self) -> FieldSpace:
        """The deflection shapes on the panel's grid, with their inner products."""

    def amplitudes(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: Real
    ) -> Complex:
        """Generalised coordinates of the field of every actuator.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) ndarray, Hz

        Returns
        -------
        (N, F, r) complex ndarray
            Per volt or newton.

        Raises
        ------
        ValueError
            For a material outside the box of the model.
        """

    def forms(
        self,
        youngs_modulus: float,
        poisson_ratio: float,
        loss_factor: float,
        frequency: Real,
        displacement: float = 1.0,
    ) -> EnergyForms:
        """Energy forms of these fields, computed without the fields where that is faster.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) ndarray, Hz
        displacement : float
            Desired displacement of the target, m per unit of audio signal.

        Returns
        -------
        EnergyForms
            Of one material.

        Raises
        ------
        ValueError
            For a material outside the box of the model.
        """

    def restricted(self, basis: Real) -> "PanelModel":
        """Return the same panel reduced to the orthonormal columns of `basis` (r, s)."""

    def modes(self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, count: int) -> PanelModes:
        """Return the lowest `count` modes.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        """


@dataclass(frozen=True)
class NoModes:
    """A panel of which only the fields are known: enough for STIF, time reversal and no control."""

    space: FieldSpace

    def amplitudes(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: Real
    ) -> Complex:
        """Raise ValueError: the fields at another material are not known.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) ndarray, Hz

        Returns
        -------
        (N, F, r) complex ndarray
            Never reached.

        Raises
        ------
        ValueError
            Always.
        """
        raise ValueError("measured transfers hold for the plate that was measured only")

    def forms(
        self,
        youngs_modulus: float,
        poisson_ratio: float,
        loss_factor: float,
        frequency: Real,
        displacement: float = 1.0,
    ) -> EnergyForms:
        """Raise ValueError, as `amplitudes` does.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) ndarray, Hz
        displacement : float
            Desired displacement of the target, m per unit of audio signal.

        Returns
        -------
        EnergyForms
            Never reached.

        Raises
        ------
        ValueError
            Always.
        """
        raise ValueError("measured transfers hold for the plate that was measured only")

    def restricted(self, basis: Real) -> PanelModel:
        """Raise ValueError: there are no coordinates to restrict to `basis` (r, s)."""
        raise ValueError("measured transfers have no coordinates")

    def modes(self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, count: int) -> PanelModes:
        """Raise ValueError: there is no model.

        Parameters
        ----------
        youngs_modulus : float
            Pa.

        Returns
        -------
        PanelModes
            Never reached.

        Raises
        ------
        ValueError
            Always.
        """
        raise ValueError("measured transfers have no modes")


ROBUST_STEP = 5.0
"""Largest spacing of the temperatures for robust filters, K: in polypropylene, resonances shift by about their
width per step."""


def responses(
    model: PanelModel, laws: MaterialLaws, temperature: Real, frequency: Real
) -> Iterator[tuple[Constants, Complex]]:
    """Material and response of a panel, one temperature after the other.

    Parameters
    ----------
    temperature : (T,) ndarray, °C
    frequency : (F,) ndarray, Hz

    Yields
    ------
    (float, float, float)
        E, Pa, nu and eta.
    (N, F, r) complex ndarray
        Generalised coordinates per volt or newton of every actuator.

    Raises
    ------
    ValueError
        For a material outside the box of the model.
    """
    for constants in constants_at(laws, temperature):
        yield constants, model.amplitudes(*constants, frequency)


def constants_at(laws: MaterialLaws, temperature: Real) -> list[Constants]:
    """E (Pa), nu and eta at each `temperature` (T,), °C."""
    material = laws.at(temperature)
    rows = zip(material.youngs_modulus, material.poisson_ratio, material.loss_factor, strict=True)
    return [(float(e), float(nu), float(eta)) for e, nu, eta in rows]


def design_forms(
    model: PanelModel,
    panel: Panel,
    laws: MaterialLaws,
    temperature: float,
    forms: EnergyForms,
    sound: SoundAim | None = None,
) -> EnergyForms:
    """Quadratic forms of a design: of the field, or of the sound aimed at, for an uncertain temperature.

    With an uncertain temperature, the mean over T ± `thermometer_error` in equal steps, both ends included:
    filters designed with it minimise the mean squared error over these temperatures. With full weight on both ends
    these count more than in a uniform distribution, and it is there that errors are largest.

    Parameters
    ----------
    temperature : float
        T, °C.
    forms : EnergyForms
        Those of the field at T; returned unchanged where the panel declares no error and no sound is aimed at.
    sound : SoundAim, optional
        What is aimed at in place of the field.

    Returns
    -------
    EnergyForms
        Of one temperature.
    """
    width = panel.filters.thermometer_error
    lines, displacement = panel.filters.frequency, panel.target.displacement

    def aimed(constants: Constants, field: EnergyForms) -> EnergyForms:
        if sound is None:
            return field
        return sound.forms(model.space, model.amplitudes(*constants, lines), field)

    if width == 0.0:
        return aimed(constants_at(laws, np.array([temperature]))[0], forms)
    steps = 2 * int(np.ceil(width / ROBUST_STEP))
    around = np.clip(temperature + np.linspace(-width, width, steps + 1), *laws.temperature_range)
    each = [aimed(here, model.forms(*here, lines, displacement)) for here in constants_at(laws, around)]
    found = type(each[0]).joined(each)
    mean = [part.mean(axis=0, keepdims=True) for part in (found.plate, found.target, found.aim)]
    return type(found)(*mean)


def covered(laws: MaterialLaws, wanted: tuple[float, float]) -> tuple[float, float]:
    """Return the part of the `wanted` range that the laws cover, °C; ValueError if there is none."""
    low, high = max(laws.temperature_range[0], wanted[0]), min(laws.temperature_range[1], wanted[1])
    if low >= high:
        raise ValueError(
            f"the laws hold from {laws.temperature_range[0]:g} to {laws.temperature_range[1]:g} °C, the panel is "
            f"wanted from {wanted[0]:g} to {wanted[1]:g} °C: nothing in common"
        )
    return low, high


def reference_temperature(panel: Panel, laws: MaterialLaws) -> float:
    """Return the panel's reference temperature, moved to the end of the laws' range where it lies outside, °C."""
    low, high = covered(laws, panel.filters.operating_range)
    return min(max(panel.filters.reference_temperature, low), high)


def spaced(low: float, high: float, spacing: float) -> Real:
    """Temperatures in even steps, and the upper end itself.

    Parameters
    ----------
    low, high : float
        Ends, °C.
    spacing : float
        K.

    Returns
    -------
    (T,) ndarray, °C
        Ascending.

    Raises
    ------
    ValueError
        For a spacing that is not above 0.
    """
    if not spacing > 0.0:
        raise ValueError(f"{spacing:g} K between temperatures: above 0 wanted")
    steps = np.arange(low, high + 1e-9, spacing)
    return steps if high - steps[-1] < 1e-6 * spacing else np.append(steps, high)
