"""Crosstalk: the drive's current couples into the inputs, more the higher the frequency."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState

REFERENCE_FREQUENCY = 500.0  # Hz, at which the gain is given


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; cables side by side couple more the faster the drive's current changes."""
    return EffectCard(
        name="crosstalk",
        summary="the drive couples into every response in quadrature, in proportion to frequency",
        parameters=(Parameter("gain", "V/V", -0.05, 0.05, 0.001, shown="%"),),
        needs="responses between resonances over at least an octave",
        separated_by=(
            "a free patch on the same cables in place of the sensor; a feedthrough is in phase and alike at "
            "all frequencies"
        ),
        title="crosstalk in quadrature",
        phrase="a crosstalk of {gain} of the drive",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add j (f/500) gain to every response that is a voltage for a voltage.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``gain``, V/V at 500 Hz.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    return state.with_(
        crosstalk=state.crosstalk + values["gain"] * (circumstances.frequency / REFERENCE_FREQUENCY)
    )


def available(experiment: Experiment) -> bool:
    """Return whether a voltage is read of a patch while a voltage drives one."""
    driven = any(channel.quantity == "voltage" for channel in experiment.inputs)
    return driven and any(channel.quantity == "voltage" for channel in experiment.outputs)


EFFECT = Effect(card, apply, available, "a patch that drives and one that is read as a voltage")
