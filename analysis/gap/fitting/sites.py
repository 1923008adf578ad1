"""Sites from which effects are searched: those of their cards, and the places of effects that were found."""

from collections.abc import Iterable, Mapping

import numpy as np

from analysis.arrays import Real
from analysis.effect_card import PLACE, EffectCard, Values

ON_THE_PLATE = 0.75
"""Distances between neighbouring sites up to which a place is on the plate, which the sites fill: half a diagonal
of their squares."""


def sites_beside(
    cards: Mapping[str, EffectCard], on: Mapping[str, Values], standing: Mapping[str, Values] | None = None
) -> dict[str, tuple[Values, ...]]:
    """Sites of every effect that is off; of one with a place also where those stand that are on.

    What stands there may be another effect, which from its own sites was not found to be there: a resonator of
    27 mg, 40 mm from the nearest of them, was a spot that has lost stiffness, with a probability of 0.93.

    Parameters
    ----------
    cards : mapping of str to EffectCard
    on : mapping of str to mapping
        Values of the effects that are on, by name.
    standing : mapping of str to mapping, optional
        Likewise of those that count as standing somewhere; by default those that are on.

    Returns
    -------
    dict of str to tuple of mapping
    """
    grids = [places(card.closer_sites or card.sites) for card in cards.values() if card.placed]
    finest = max(grids, key=len, default=np.zeros((0, 2)))
    stand = {
        name: values
        for name, values in (on if standing is None else standing).items()
        if name in cards and cards[name].placed and away(finest, values) <= ON_THE_PLATE
    }
    found = {}
    for name, card in cards.items():
        if name not in on:
            there = [one for other, one in stand.items() if card.placed and other not in (name, card.after)]
            found[name] = (*card.sites, *(site for values in there for site in _sites_at(card, values)))
    return found


def _sites_at(card: EffectCard, values: Values) -> Iterable[Values]:
    """Sites of an effect at the place of another one, inside its ranges."""
    ranges = {p.name: p for p in card.parameters if p.name in PLACE}
    place = {name: float(np.clip(values[name], p.low, p.high)) for name, p in ranges.items()}
    others = card.at_a_place or [{k: site[k] for k in site if k not in PLACE} for site in card.sites]
    different = {tuple(sorted(one.items())): one for one in others}
    return [{**one, **place} for one in different.values()]


def places(sites: Iterable[Values]) -> Real:
    """Coordinates (K, 2) of sites, each once, m."""
    return np.array(sorted({(site["x"], site["y"]) for site in sites}))


def away(grid: Real, values: Values) -> float:
    """Distance of an effect from the nearest place (K, 2), over that of neighbours; infinite beside one place."""
    if len(grid) < 2:
        return float("inf")
    spacing = np.median([np.partition(np.hypot(*(grid - one).T), 1)[1] for one in grid])
    return float(np.hypot(*(grid - (values["x"], values["y"])).T).min() / spacing)
