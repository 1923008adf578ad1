"""Local damage: a round spot of the plate has lost stiffness."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from analysis.experiment import Experiment
from analysis.gap.effect_card import EffectCard, Parameter
from simulation.effects.effect import Effect
from simulation.plate_state import Circumstances, Disc, PlateState

RADIUS = 0.012  # m


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; the search starts from discs side by side over the plate."""
    plate = experiment.plate
    return EffectCard(
        name="local_damage",
        summary="a spot of 24 mm across has lost stiffness",
        parameters=(
            Parameter("loss", "1", 0.0, 0.5, 0.2),
            _coordinate("x", plate.length_x),
            _coordinate("y", plate.length_y),
        ),
        needs="modes whose half-waves are not much longer than the spot, better with several sensors",
        separated_by="a tap test or an ultrasonic scan at the place found",
        sites=tuple({"x": x, "y": y} for y in _sites(plate.length_y) for x in _sites(plate.length_x)),
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Plate modulus times 1 - loss within 12 mm of (x, y)."""
    disc = Disc(x=values["x"], y=values["y"], radius=RADIUS, loss=values["loss"])
    return state.with_(discs=(*state.discs, disc))


def available(experiment: Experiment) -> bool:
    """Whether the plate is larger than the spot."""
    return min(experiment.plate.length_x, experiment.plate.length_y) > 2.0 * RADIUS


def _coordinate(name: str, length: float) -> Parameter:
    """Return the place of a disc that lies wholly on the plate, as likely here as there."""
    spread = length / np.sqrt(12.0)
    return Parameter(name, "m", RADIUS, length - RADIUS, float(spread), shape=True, typical=0.5 * length)


def _sites(length: float) -> list[float]:
    """Places along one edge, about a disc's diameter apart."""
    count = 1 + round((length - 2.0 * RADIUS) / (2.0 * RADIUS))
    if count == 1:
        return [0.5 * length]
    return [float(place) for place in np.linspace(RADIUS, length - RADIUS, count)]


EFFECT = Effect(card, apply, available)
