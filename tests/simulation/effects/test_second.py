"""Two of one kind on a plate: the second does what the first does, and is a candidate after it."""

from simulation.effects.library import LIBRARY
from simulation.effects.second import TWICE, seconds


def test_the_second_is_the_first_under_another_name(experiment):
    for name, second in zip(TWICE, seconds(LIBRARY).values(), strict=True):
        first, card = LIBRARY[name].card(experiment), second.card(experiment)
        assert (card.name, card.after, card.said) == (f"second_{name}", name, f"second {first.said}")
        assert (card.parameters, card.sites) == (first.parameters, first.sites)
        assert second.apply is LIBRARY[name].apply


def test_of_what_a_library_lacks_there_is_no_second():
    assert seconds({}) == {}
