"""Piezo nonlinearity: domain walls move, so that patches answer more than in proportion to their drive."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState

HYSTERESIS = 4.0 / (3.0 * np.pi)  # imaginary over real part of what the level adds, after Rayleigh


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; soft ceramics gain some per cent per ten volts over half a millimetre."""
    return EffectCard(
        name="piezo_nonlinearity",
        summary="the drive's patches answer more than in proportion to the drive level",
        parameters=(Parameter("beta", "1/V", 0.0, 0.1, 0.01, shown="%/V"),),
        levels=2,
        needs="two drive levels at the same temperatures: with one level it is a gain and a piezo_loss",
        separated_by=(
            "sweeps at half and at twice the level: all lines change alike; an amplitude_softening moves "
            "resonances"
        ),
        title="drive that grows more than in proportion",
        phrase="a drive that grows by {beta} beyond proportion",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Multiply responses by 1 + beta L (1 - 4j/(3 pi)) at the level L, V.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``beta``, 1/V.

    Returns
    -------
    PlateState
        `state` with the effect.

    Notes
    -----
    Rayleigh's law d = d_0 + alpha E - j 4 alpha E/(3 pi) (Damjanovic, J. Appl. Phys. 82, 1997).
    """
    stronger = values["beta"] * circumstances.point.level
    late = HYSTERESIS * stronger
    return state.with_(
        log_gain=state.log_gain + 0.5 * np.log((1.0 + stronger) ** 2 + late**2),
        phase=state.phase - np.arctan(late / (1.0 + stronger)),
    )


def available(experiment: Experiment) -> bool:
    """Return whether a patch drives the plate."""
    return any(channel.patch is not None for channel in experiment.inputs)


EFFECT = Effect(card, apply, available, "a patch that drives")
