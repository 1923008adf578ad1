"""Resonator at a place: a mass on a lossy spring that nobody declared rides on the plate."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect, coordinates, sites
from simulation.state.plate_state import Attached, Circumstances, PlateState

PLACES, RESONANCES = 12, 6
"""Places and resonances, about, from which a search starts: at every place one in each part of the band."""
START_LOSS = 0.1  # of the springs from which a search starts: wide enough to be seen from one of the resonances
LOSSES = (0.03, 0.1, 0.4)
"""Of the springs that are tried where another effect stands."""


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; a loose clip, a plug or a length of cable that resonates in the band."""
    low, high = experiment.protocol.band
    middle = float(np.sqrt(low * high))
    places = sites(experiment, PLACES)
    return EffectCard(
        name="resonator_at_place",
        summary="an undeclared mass on a spring resonates somewhere on the plate",
        parameters=(
            Parameter("mass", "kg", 0.0, 0.02, 0.0005, shown="g"),
            *coordinates(experiment),
            Parameter(
                "resonance",
                "Hz",
                0.7 * low,
                1.4 * high,
                0.5 * (high - low),
                shape=True,
                typical=middle,
                only_inside=True,
            ),
            Parameter("loss", "1", 0.005, 1.0, 0.1, shape=True, typical=START_LOSS, shown="%"),
        ),
        needs="lines much closer than the resonance is wide, and modes on both sides of it",
        separated_by="look there; touch what is found: its resonance dies, a mode of the plate hardly changes",
        sites=tuple(
            {"x": float(x), "y": float(y), "resonance": float(f), "loss": START_LOSS}
            for x, y in places
            for f in np.geomspace(low, high, RESONANCES)
        ),
        at_a_place=tuple(
            {"resonance": float(f), "loss": loss}
            for f in np.geomspace(low, 1.3 * high, RESONANCES + 1)
            for loss in LOSSES
        ),
        title="undeclared resonator",
        phrase="a mass of {mass} on a spring (resonance {resonance}, loss factor {loss}) at x {x}, y {y}",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add a mass on a spring k (1 + j loss) to the normal motion of the place.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``mass``, kg, ``x`` and ``y``, m, ``resonance``, Hz, with the plate at rest, and ``loss``, of the spring.

    Returns
    -------
    PlateState
        `state` with the effect.

    Notes
    -----
    The force of a mass m on a spring s = m w_0**2 (1 + j loss) is d = -w**2 m s/(s - w**2 m) times the motion
    (Den Hartog, Mechanical Vibrations, 1956, ch. 3).
    """
    omega = 2.0 * np.pi * circumstances.frequency
    square = (2.0 * np.pi * values["resonance"]) ** 2
    below, late = square - omega**2, values["loss"] * square
    share = values["mass"] * omega**2 / (below**2 + late**2)
    stiffness = -share * square * (below + values["loss"] * late)
    loss = share * square * values["loss"] * omega**2
    one = Attached(values["x"], values["y"], stiffness, loss)
    return state.with_(attached=(*state.attached, one))


EFFECT = Effect(card, apply)
