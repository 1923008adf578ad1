"""Spring at a place: something that nobody declared holds the plate."""

from collections.abc import Mapping
from typing import Any

from analysis.arrays import Real
from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import CLOSER_SITES, SITES, Effect, coordinates, sites
from simulation.state.plate_state import Attached, Circumstances, PlateState

START_LOSS = 0.05
"""Of the springs from which a search starts: foam, rubber and cables lose some per cent, steel next to nothing."""


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; a cable that touches or a foam block hold by hundreds to thousands of N/m."""
    return EffectCard(
        name="spring_at_place",
        summary="something undeclared holds the plate somewhere by a spring",
        parameters=(
            Parameter("stiffness", "N/m", 0.0, 5e4, 500.0, shown="N/mm"),
            *coordinates(experiment),
            Parameter("loss", "1", 0.0, 1.0, 0.1, shape=True, typical=START_LOSS, shown="%"),
        ),
        needs="modes at the lower end of the band that move the place, better with several sensors",
        separated_by="look there; a spring raises low modes most, a mass lowers high ones most",
        sites=_started(sites(experiment, SITES)),
        closer_sites=_started(sites(experiment, CLOSER_SITES)),
        title="undeclared spring",
        phrase="a spring of {stiffness} (loss factor {loss}) at x {x}, y {y}",
    )


def _started(places: Real) -> tuple[dict[str, float], ...]:
    """Sites from which a search starts."""
    return tuple({"x": float(x), "y": float(y), "loss": START_LOSS} for x, y in places)


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add the spring k (1 + j loss) to the normal motion of the place.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``stiffness``, N/m, ``x`` and ``y``, m, and ``loss`` factor of the spring.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    stiffness = values["stiffness"] + 0.0 * circumstances.frequency
    one = Attached(values["x"], values["y"], stiffness, values["loss"] * stiffness)
    return state.with_(attached=(*state.attached, one))


EFFECT = Effect(card, apply)
