"""A second of two alike: two masses, or two springs, that nobody declared."""

from collections.abc import Mapping
from dataclasses import replace

from analysis.effect_card import EffectCard
from analysis.experiment import Experiment
from simulation.effects.effect import Effect

TWICE = ("mass_at_place", "spring_at_place")
"""Effects of which a plate may have two. Without a second mass a resonator far above the band stood for it: on an
aluminium L 3 g and 2 g were named a resonator of 2.2 g at 1680 Hz, and 2.1 g."""


def seconds(library: Mapping[str, Effect]) -> dict[str, Effect]:
    """Return the seconds of those effects of a library of which a plate may have two, by name."""
    return {f"second_{name}": _second(library[name], name) for name in TWICE if name in library}


def _second(first: Effect, name: str) -> Effect:
    def card(experiment: Experiment) -> EffectCard:
        known = first.card(experiment)
        return replace(
            known,
            name=f"second_{name}",
            summary=f"beside {name}, a second one: {known.summary}",
            title=f"second {known.said}",
            after=name,
        )

    return replace(first, card=card)
