"""What stands where one effect was found may be another, whose own sites are far from there."""

from dataclasses import replace

import pytest

from analysis.effect_card import EffectCard, Parameter
from analysis.gap.data.preparation import prepare
from analysis.gap.fitting.sites import sites_beside
from analysis.gap.fitting.state import starting_state
from analysis.gap.plan.decision import decided, told
from analysis.gap.search.context import SearchContext
from analysis.gap.search.stepwise import stepwise_search

X, Y = (Parameter(axis, "1", 0.05, 0.95, 0.3, shape=True, typical=0.5) for axis in "xy")
TONE = Parameter("tone", "Hz", 100.0, 2000.0, 500.0, shape=True, typical=500.0)
GRID = tuple({"x": x / 10, "y": y / 10} for x in range(1, 10) for y in range(1, 10))
SPOT = EffectCard("spot", "mass", (Parameter("grams", "g", 0.0, 10.0, 1.0), X, Y), "-", "-", GRID)
CLIP = EffectCard(
    "clip",
    "spring of few sites",
    (Parameter("force", "1", 0.0, 10.0, 1.0), X, Y, TONE),
    "-",
    "-",
    tuple({"x": x, "y": y, "tone": 300.0} for x in (0.1, 0.15) for y in (0.8, 0.9)),
    at_a_place=({"tone": 300.0}, {"tone": 900.0}),
)


def test_an_effect_is_tried_where_another_stands():
    cards = {"spot": SPOT, "clip": CLIP, "second_spot": replace(SPOT, name="second_spot", after="spot")}
    assert sites_beside(cards, {}) == {name: card.sites for name, card in cards.items()}
    sites = sites_beside(cards, {"spot": {"grams": 1.0, "x": 0.3, "y": 0.97}})
    assert set(sites) == {"clip", "second_spot"}
    assert sites["second_spot"] == SPOT.sites  # two at one place are one
    assert sites["clip"][len(CLIP.sites) :] == tuple(
        {"x": 0.3, "y": 0.95, "tone": tone} for tone in (300.0, 900.0)
    )
    sites = sites_beside(cards, {"clip": {"force": 1.0, "x": 0.4, "y": 0.5, "tone": 500.0}})
    assert sites["spot"][len(GRID) :] == ({"x": 0.4, "y": 0.5},)
    notched = {"spot": replace(SPOT, sites=GRID[:45]), "clip": CLIP}
    assert sites_beside(notched, {"spot": {"grams": 1.0, "x": 0.8, "y": 0.5}})["clip"] == CLIP.sites
    with pytest.raises(ValueError, match=r"exactly the shapes \['tone'\]"):
        replace(CLIP, at_a_place=({"x": 0.3, "tone": 300.0},))


def plate_with(toy):
    """Return a plate on which a clip acts like a spot, the less the higher the resonance is."""

    def size(one, frequency):
        return one["grams"] if "grams" in one else one["force"] / (1.0 + (frequency / one["tone"]) ** 2)

    return toy.placed({"spot": SPOT, "clip": CLIP}, size)


def test_it_is_fitted_from_there_before_a_name_is_given(toy, pool):
    plate, true = plate_with(toy), {"force": 0.05, "x": 0.72, "y": 0.33, "tone": 1200.0}
    frf, protocol = toy.record(effects={"clip": true}, temperatures=(18.0, 26.0, 34.0), plate=plate)
    updated = toy.updated(frf)
    sweeps, noise = prepare(frf, protocol, updated)
    context = SearchContext(plate, sweeps, noise, pool)
    found = stepwise_search(context, context.fit(starting_state(updated, sweeps.groups), ()))
    assert found.effects == ("clip",)
    assert [found.fit.state.effects["clip"][axis] for axis in "xy"] == pytest.approx([0.72, 0.33], abs=0.01)


def test_a_later_campaign_decides_from_there_too(toy, pool):
    """A plan that was followed asks which of two it was; from its own sites the right one was fitted elsewhere."""
    plate, true = plate_with(toy), {"force": 0.05, "x": 0.72, "y": 0.33, "tone": 1200.0}
    frf, protocol = toy.record(effects={"clip": true}, temperatures=(18.0, 26.0, 34.0), plate=plate)
    updated = toy.updated(frf)
    sweeps, _ = prepare(frf, protocol, updated)
    found = {"spot": {"grams": 0.03, "x": 0.72, "y": 0.33}}
    base = replace(starting_state(updated, sweeps.groups), effects=found)
    answer = decided(told(plate, sweeps, base, ("spot", "clip"), pool))
    assert answer.settled == "clip"
