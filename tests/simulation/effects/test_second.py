"""Candidates beside another effect: the second of two alike does what the first does; a spot is widened."""

from types import SimpleNamespace

from simulation.effects.library import LIBRARY, TWICE, seconds
from simulation.effects.local_damage import RADIUS
from simulation.state.plate_state import Disc


def test_the_second_is_the_first_under_another_name(experiment):
    for name, second in zip(TWICE, list(seconds(LIBRARY).values())[: len(TWICE)], strict=True):
        first, card = LIBRARY[name].card(experiment), second.card(experiment)
        assert (card.name, card.after, card.said) == (f"second_{name}", name, f"second {first.said}")
        assert (card.parameters, card.sites) == (first.parameters, first.sites)
        assert second.apply is LIBRARY[name].apply


def test_of_what_a_library_lacks_there_is_no_second():
    assert seconds({}) == {}


def test_a_spot_is_widened_once_there_is_one(experiment):
    size, card = seconds(LIBRARY)["damage_size"], seconds(LIBRARY)["damage_size"].card(experiment)
    assert (card.after, card.zero()) == ("local_damage", {"wider": 0.0})
    plain = SimpleNamespace(discs=(), with_=lambda discs: SimpleNamespace(discs=discs))
    assert size.apply(plain, None, {"wider": 0.004}).discs == ()
    spot = LIBRARY["local_damage"].apply(plain, None, {"x": 0.1, "y": 0.09, "loss": 0.2})
    spot.with_ = plain.with_
    assert size.apply(spot, None, {"wider": 0.004}).discs == (Disc(0.1, 0.09, RADIUS + 0.004, 0.2),)
