"""Declared quantities in words, and the budget of a standard deviation."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.estimates import DeclaredQuantity, budget, doubts, untold


def quantity(name="patch_place S1", parameter="dx", value=2.1e-3, tolerance=3e-4, unit="m"):
    return DeclaredQuantity(name, parameter, unit, "place of patch S1", tolerance, value, 2e-4)


def test_beyond_three_tolerances_the_declaration_is_doubtful():
    assert quantity(value=-9.1e-4).beyond
    assert not quantity(value=8.9e-4).beyond


def test_a_sentence_has_people_s_units():
    assert quantity().sentence == ("place of patch S1 along x: +2.1 ± 0.2 mm from its declaration (tolerance 0.3)")
    contact = quantity("transducer_contact S1", parameter="larger", unit="1", value=5.9, tolerance=1.0)
    found = replace(contact, words="contact area of S1", sigma=1.04).sentence
    assert found == "contact area of S1: +590 ± 104 % from its declaration (tolerance 100)"


def test_what_the_data_do_not_tell_is_named_once():
    """A thickness 3 % off was "confirmed": its sigma was that of its tolerance."""
    told = quantity("plate_thickness", "share", 0.0, 1e-3)
    found = [told, quantity("plate_length_x"), quantity("plate_length_y"), quantity("patch_place S1")]
    assert untold(found) == ("lengths",)
    assert untold([replace(told, sigma=9e-4)]) == ("thickness",)


def test_a_shear_modulus_that_nobody_declared_may_be_a_wrong_thickness():
    shear = quantity("plate_shear", "share", 0.2, 0.03, "1")
    assert doubts([shear])[0].endswith("a thickness declared some per cent wrong looks like this: measure it")
    assert "thickness" not in doubts([quantity(value=-9.1e-4)])[0]


def test_the_squares_of_a_budget_add_up():
    quantities = [quantity("plate_length_x"), quantity("plate_length_y"), quantity("oven_reading")]
    rows = dict(budget(quantities, np.array([0.3, -0.4, 0.7, 0.2]), 0.1))
    assert rows == pytest.approx({"lengths": 0.5, "oven": 0.7, "twin": 0.2, "noise": 0.1})
    assert list(rows) == ["oven", "lengths", "twin", "noise"]


def test_nonsense_is_refused():
    with pytest.raises(ValueError, match="tolerance 0"):
        quantity(tolerance=0.0)
    with pytest.raises(ValueError, match="nan"):
        quantity(value=np.nan)
