"""Candidates only beside another effect: a second of two alike, and the size of a damaged spot."""

from collections.abc import Mapping
from dataclasses import replace

from analysis.effect_card import EffectCard
from analysis.experiment import Experiment
from simulation.effects import damage_size
from simulation.effects.effect import Effect

TWICE = ("mass_at_place", "spring_at_place")
"""Effects of which a plate may have two. Without a second mass a resonator far above the band stood for it: on an
aluminium L 3 g and 2 g were named a resonator of 2.2 g at 1680 Hz, and 2.1 g."""


def seconds(library: Mapping[str, Effect]) -> dict[str, Effect]:
    """Return what is a candidate once an effect of a library is on, by name."""
    twice = {f"second_{name}": _second(library[name], name) for name in TWICE if name in library}
    return twice | ({"damage_size": damage_size.EFFECT} if "local_damage" in library else {})


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
