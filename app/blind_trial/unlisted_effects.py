"""Effects that are not in the library, hidden in a trial to test the verdict unknown.

They act on the simulated plate only, through the same states as the library's effects.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.arrays import Real
from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, Disc, PlateState

Values = Mapping[str, Any]

STIFFENER_RADIUS = 0.015
"""m."""


def _card(name: str, summary: str, *parameters: Parameter) -> EffectCard:
    site = {p.name: p.typical for p in parameters if p.shape}
    return EffectCard(name, summary, parameters, needs="", separated_by="", sites=(site,))


def _stiffener_card(experiment: Experiment) -> EffectCard:
    low, high = experiment.plate.bounds
    return _card(
        "stiffener",
        "a disc glued on makes a spot stiffer",
        Parameter("gain", "1", 0.0, 2.0, 0.3),
        Parameter("x", "m", low[0] + STIFFENER_RADIUS, high[0] - STIFFENER_RADIUS, 0.1, shape=True),
        Parameter("y", "m", low[1] + STIFFENER_RADIUS, high[1] - STIFFENER_RADIUS, 0.1, shape=True),
    )


def _stiffened(state: PlateState, circumstances: Circumstances, values: Values) -> PlateState:
    disc = Disc(values["x"], values["y"], STIFFENER_RADIUS, -values["gain"])
    return state.with_(discs=(*state.discs, disc))


def _resonance(name: str, experiment: Experiment) -> Parameter:
    """Frequency somewhere in the band."""
    low, high = experiment.protocol.band
    return Parameter(name, "Hz", low, high, 100.0, shape=True, typical=0.5 * (low + high))


def _oscillator(ratio: Real, quality: float) -> tuple[Real, Real]:
    """Real part of 1/(1 - s**2 + j s/Q), and minus its imaginary part."""
    below, lost = 1.0 - ratio**2, ratio / quality
    size = below**2 + lost**2
    return below / size, lost / size


def _cavity_card(experiment: Experiment) -> EffectCard:
    return _card(
        "cavity",
        "the air between plate and table resonates",
        Parameter("mass", "kg/m2", 0.0, 0.5, 0.02),
        _resonance("resonance", experiment),
    )


def _above_cavity(state: PlateState, circumstances: Circumstances, values: Values) -> PlateState:
    """Impedance per area of a mass that follows through a spring: j w m / (1 - s**2 + j s/Q), Q = 12."""
    real, lost = _oscillator(circumstances.frequency / values["resonance"], 12.0)
    omega = 2.0 * np.pi * circumstances.frequency
    return state.with_(
        area_mass=state.area_mass + values["mass"] * real,
        area_resistance=state.area_resistance + values["mass"] * omega * lost,
    )


def _filter_card(experiment: Experiment) -> EffectCard:
    return _card(
        "filter_ripple",
        "a conditioner's second-order filter rings inside the band",
        Parameter("height", "1", 0.0, 0.5, 0.02),
        _resonance("corner", experiment),
    )


def _filtered(state: PlateState, circumstances: Circumstances, values: Values) -> PlateState:
    """Multiply responses by 1 + height s j/Q / (1 - s**2 + j s/Q), Q = 4."""
    s = circumstances.frequency / values["corner"]
    through, lost = _oscillator(s, 4.0)
    height = values["height"] * s / 4.0
    real, imaginary = 1.0 + height * lost, height * through
    return state.with_(
        log_gain=state.log_gain + 0.5 * np.log(real**2 + imaginary**2),
        phase=state.phase + np.arctan(imaginary / real),
    )


UNLISTED_EFFECTS: Mapping[str, Effect] = {
    "stiffener": Effect(_stiffener_card, _stiffened),
    "cavity": Effect(_cavity_card, _above_cavity),
    "filter_ripple": Effect(_filter_card, _filtered),
}
