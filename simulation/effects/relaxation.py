"""Relaxation: a process with one relaxation time makes the plate stiffer above its frequency and lossy at it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; relaxations from an octave below the band to one above are told apart."""
    low, high = experiment.protocol.band
    middle = float(np.sqrt(low * high))
    return EffectCard(
        name="relaxation",
        summary="one relaxation within the band: stiffer above its frequency, lossier at it",
        parameters=(
            Parameter("strength", "1", 0.0, 0.5, 0.03, shown="%"),
            Parameter(
                "frequency",
                "Hz",
                0.25 * low,
                4.0 * high,
                2.0 * middle,
                shape=True,
                typical=middle,
                only_inside=True,
            ),
        ),
        needs="modes over at least two octaves around the relaxation",
        separated_by="a dynamic mechanical analysis of a strip: a peak of the loss factor over frequency",
        sites=tuple({"frequency": float(f)} for f in np.geomspace(0.5 * low, 2.0 * high, 5)),
        title="relaxation within the band",
        phrase="a relaxation of strength {strength} at {frequency}",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add strength j s/(1 + j s) to the relative complex modulus, s = f/frequency.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``strength``, the modulus relaxed, relative, and ``frequency``, Hz.

    Returns
    -------
    PlateState
        `state` with the effect.

    Notes
    -----
    The standard linear solid (Zener, Elasticity and Anelasticity of Metals, 1948): causal by itself, whatever the
    laws' loss factor.
    """
    s = circumstances.frequency / values["frequency"]
    rise = values["strength"] * s / (1.0 + s**2)
    eta = state.laws.loss_factor(state.mean_temperature)
    return state.with_(storage=state.storage + rise * s, loss=state.loss + rise / eta)


EFFECT = Effect(card, apply)
