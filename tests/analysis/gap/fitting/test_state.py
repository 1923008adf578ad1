"""State of a fit: what is left when one of its effects is switched off."""

import numpy as np
import pytest

from analysis.effect_card import EffectCard, Parameter
from analysis.gap.fitting.state import GapState


def card(name: str, after: str = "", unit: str = "kg") -> EffectCard:
    """Return a card of an effect at one place."""
    size = Parameter("size", unit, -1.0, 1.0, 0.1)
    place = Parameter("x", "m", 0.0, 1.0, 0.3, shape=True, typical=0.5)
    return EffectCard(name, "for a test", (size, place), "", "", sites=({"x": 0.5},), after=after)


CARDS = {
    one.name: one
    for one in (
        card("mass"),
        card("second_mass", after="mass"),
        card("lag"),
        card("width", after="mass", unit="m"),
    )
}
HERE, THERE = {"size": 0.1, "x": 0.2}, {"size": 0.2, "x": 0.9}


def state(**effects: dict[str, float]) -> GapState:
    """Return a state of one temperature with effects on."""
    laws = np.zeros((1, 3))
    return GapState(laws, laws, laws, np.zeros(1), np.zeros(1), effects)


@pytest.mark.parametrize(
    ("left_out", "left"),
    [
        ("mass", {"mass": THERE, "lag": HERE}),
        ("second_mass", {"mass": HERE, "lag": HERE}),
        ("lag", {"mass": HERE, "second_mass": THERE}),
    ],
)
def test_a_second_of_two_alike_is_the_first_where_that_is_left_out(left_out, left):
    both = state(mass=HERE, second_mass=THERE, lag=HERE)
    assert both.without(left_out).promoted(CARDS).effects == left


def test_what_is_only_beside_an_effect_goes_with_it():
    assert state(mass=HERE, width=THERE, lag=HERE).without("mass").promoted(CARDS).effects == {"lag": HERE}


def test_other_effects_stay_in_their_order():
    whole = state(lag=HERE, mass=THERE)
    assert tuple(whole.promoted(CARDS).effects) == ("lag", "mass")
