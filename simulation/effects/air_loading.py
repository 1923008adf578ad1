"""Air loading: added mass and sound radiation of the air around the plate."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState

SUBSONIC = 0.9  # of the speed of sound: nearer to coincidence the added mass of an infinite plate diverges
EDGE_RADIATION = 0.35  # share of the plane-wave resistance that a finite plate radiates at coincidence


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; 1 is the theory of an infinite plate in free air, correct within a factor."""
    return EffectCard(
        name="air_loading",
        summary="the air on both faces adds mass to long bending waves and carries sound away",
        parameters=(
            Parameter("added_mass_factor", "1", 0.0, 3.0, 1.0),
            Parameter("radiation_factor", "1", 0.0, 3.0, 1.0),
        ),
        needs="a light plate with modes over at least two octaves, and a wide temperature range",
        separated_by="a sweep in vacuum or helium; a strip's dynamic mechanical analysis shows the material alone",
        title="load of the surrounding air",
        phrase="air on the plate: mass {added_mass_factor}, sound {radiation_factor} times what theory gives",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add -w**2 m_a + j w r per area to normal motion.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``added_mass_factor`` and ``radiation_factor``, 1 for the formulas below.

    Returns
    -------
    PlateState
        `state` with the effect.

    Notes
    -----
    m_a = 2 rho_a/(k_b sqrt(1 - q**2)) and r = 0.35 rho_a c q**2, each times its factor, with the wavenumber
    k_b = (w**2 rho h/D)**(1/4) of free bending waves and q = w/(c k_b), their speed over that of sound. The first
    is the reactance of air on both faces of an infinite plate below coincidence.
    """
    temperature, plate = state.mean_temperature, circumstances.plate
    omega = 2.0 * np.pi * circumstances.frequency
    density = 1.204 * 293.0 / (273.0 + temperature)
    speed = 331.3 * np.sqrt(1.0 + temperature / 273.15)
    nu = state.laws.poisson_ratio(temperature)
    rigidity = state.laws.youngs_modulus(temperature) * plate.thickness**3 / (12.0 * (1.0 - nu**2))
    wavenumber = (omega**2 * plate.density * plate.thickness / rigidity) ** 0.25
    q = omega / (speed * wavenumber)
    mass = 2.0 * density / (wavenumber * np.sqrt(1.0 - np.minimum(q, SUBSONIC) ** 2))
    resistance = EDGE_RADIATION * density * speed * q**2
    return state.with_(
        area_mass=state.area_mass + values["added_mass_factor"] * mass,
        area_resistance=state.area_resistance + values["radiation_factor"] * resistance,
    )


EFFECT = Effect(card, apply)
