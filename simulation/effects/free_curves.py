"""Curves over frequency without a formula: a load at a place, a modulus, a gain; they describe what has no name.

No candidates of the gap workflow: with two dozen numbers each of them fits a little of anything. A curve is given
by its values at knots, evenly spaced on a logarithmic scale of frequency, with straight lines between them.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from analysis.arrays import Real
from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects import dashpot_at_place, mass_at_place, resonator_at_place, spring_at_place
from simulation.effects.effect import SITES, Effect, coordinates, sites
from simulation.state.plate_state import Attached, Circumstances, PlateState

LOAD, MODULUS, GAIN = "free_load", "free_modulus", "free_gain"
KNOTS = 12
"""Of a load; a third of an octave apart over four octaves: an unknown resonance is half as wide, and is seen."""
SMOOTH_KNOTS = 6
"""Of a modulus and of a gain, which change slowly."""
FORMS: Mapping[str, Effect] = {
    "load_mass": mass_at_place.EFFECT,
    "load_spring": spring_at_place.EFFECT,
    "load_dashpot": dashpot_at_place.EFFECT,
    "load_resonator": resonator_at_place.EFFECT,
}
"""Effects of the library under other names: they describe what was not explained, whatever library was used."""
Values = Mapping[str, Any]


def free_effects(experiment: Experiment) -> dict[str, Effect]:
    """Return the effects, by name, and loads at any place of the four forms that have one."""
    return {
        **{name: _renamed(name, effect) for name, effect in FORMS.items()},
        LOAD: Effect(_load_card, _loaded),
        MODULUS: Effect(lambda one: _card(MODULUS, "a modulus over frequency", 0.05, 0.1), _stiffened),
        GAIN: Effect(lambda one: _card(GAIN, "a gain over frequency", 0.05, 0.05), _amplified),
    }


def _renamed(name: str, effect: Effect) -> Effect:
    return Effect(lambda one: replace(effect.card(one), name=name), effect.apply)


def knots(band: tuple[float, float], count: int) -> Real:
    """Frequencies (count,) of the knots over a band, Hz."""
    return np.geomspace(band[0], band[1], count)


def hats(frequency: Real, band: tuple[float, float], count: int) -> Real:
    """Weights of the knots: straight lines over log f, level beyond the band.

    Parameters
    ----------
    frequency : (F,) ndarray, Hz
    band : (float, float)
        Hz.
    count : int
        Number of knots.

    Returns
    -------
    (count, F) ndarray
    """
    at = np.interp(np.log(frequency), np.log(knots(band, count)), np.arange(count))
    return np.asarray(np.maximum(1.0 - np.abs(at - np.arange(count)[:, None]), 0.0))


def names(letter: str, count: int) -> tuple[str, ...]:
    """Names of a curve's parameters."""
    return tuple(f"{letter}{k}" for k in range(count))


def _load_card(experiment: Experiment) -> EffectCard:
    places = sites(experiment, SITES)
    amplitudes = tuple(
        Parameter(name, "kg", -0.05, 0.05, 0.002, shown="g") for letter in "ab" for name in names(letter, KNOTS)
    )
    return EffectCard(
        name=LOAD,
        summary="something acts on the normal motion of a place",
        parameters=(*amplitudes, *coordinates(experiment)),
        needs="modes that move the place and others that do not",
        separated_by="look there",
        sites=tuple({"x": float(x), "y": float(y)} for x, y in places),
    )


def _loaded(state: PlateState, circumstances: Circumstances, values: Values) -> PlateState:
    """Add a dynamic stiffness -w**2 (a - j b): a mass of a, and losses b."""
    hat = hats(circumstances.frequency, circumstances.band, KNOTS)
    omega = 2.0 * np.pi * circumstances.frequency
    a, b = _curve(values, "a", hat), _curve(values, "b", hat)
    one = Attached(values["x"], values["y"], -(omega**2) * a, omega**2 * b)
    return state.with_(attached=(*state.attached, one))


def _card(name: str, summary: str, first: float, second: float) -> EffectCard:
    parameters = tuple(
        Parameter(each, "1", -0.8, 0.8, sigma)
        for letter, sigma in (("a", first), ("b", second))
        for each in names(letter, SMOOTH_KNOTS)
    )
    return EffectCard(name, summary, parameters, needs="a wide band", separated_by="another band")


def _stiffened(state: PlateState, circumstances: Circumstances, values: Values) -> PlateState:
    """Multiply the storage modulus by 1 + a, and the loss factor by 1 + b."""
    hat = hats(circumstances.frequency, circumstances.band, SMOOTH_KNOTS)
    stiffer, lossier = 1.0 + _curve(values, "a", hat), 1.0 + _curve(values, "b", hat)
    return state.with_(storage=state.storage * stiffer, loss=state.loss * stiffer * lossier)


def _amplified(state: PlateState, circumstances: Circumstances, values: Values) -> PlateState:
    """Multiply all responses by exp(a + j b)."""
    hat = hats(circumstances.frequency, circumstances.band, SMOOTH_KNOTS)
    return state.with_(
        log_gain=state.log_gain + _curve(values, "a", hat), phase=state.phase + _curve(values, "b", hat)
    )


def _curve(values: Values, letter: str, hat: Real) -> Any:
    return sum(values[name] * row for name, row in zip(names(letter, len(hat)), hat, strict=True))
