import numpy as np
import pytest

from analysis.identification.pole_residue import CHOICES, EVERY_CHOICE, choices_for, named


@pytest.mark.parametrize("terms", EVERY_CHOICE)
def test_scaled_columns_and_unscaled_coefficients_agree(terms) -> None:
    s, scale = 2j * np.pi * np.linspace(50.0, 900.0, 11), 1234.5
    solved = np.random.default_rng(0).normal(size=(2, terms.parameters))
    by_columns = solved @ terms.columns(s, scale)
    by_powers = terms.coefficients(solved, scale) @ np.array([s**p for p in terms.powers]).reshape(-1, len(s))
    np.testing.assert_allclose(by_powers, by_columns, rtol=1e-12, atol=1e-12)


def test_names_are_distinct_and_found_again() -> None:
    assert len({terms.name for terms in EVERY_CHOICE}) == len(EVERY_CHOICE)
    assert all(named(terms.name) is terms for terms in EVERY_CHOICE)
    with pytest.raises(ValueError, match="E \\+ F/s\\^2"):
        named("E + F")


@pytest.mark.parametrize("quantity", ["displacement", "velocity", "acceleration", "unknown"])
def test_every_quantity_may_have_the_papers_terms(quantity) -> None:
    assert set(CHOICES) <= set(choices_for({quantity}))
