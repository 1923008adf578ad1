"""Responses of a panel at the temperatures of its laws, and the forms by which filters are designed there."""

from collections.abc import Iterator

import numpy as np

from analysis.arrays import Complex, Real
from analysis.focusing.energy import EnergyForms
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import Constants, PanelModel
from analysis.focusing.sound_aim import SoundAim
from analysis.material import MaterialLaws

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
