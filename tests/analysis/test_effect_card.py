"""Priors of an effect's parameters."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.effect_card import USUAL, Parameter

MASS = Parameter("mass", "kg", 0.0, 0.05, 0.001)
PLACE = Parameter("x", "m", 0.0, 0.3, 0.05, shape=True, typical=0.1)
TOLERANCE = Parameter("share", "1", -0.05, 0.05, 0.005, declared=True)


@pytest.mark.parametrize("parameter", [MASS, PLACE, TOLERANCE], ids=lambda p: p.name)
def test_usual_values_have_a_normal_prior(parameter: Parameter) -> None:
    for away in (0.0, 0.5, -1.5, USUAL):
        value = parameter.centre + away * parameter.sigma
        assert parameter.penalty(value) == pytest.approx(away**2)
        assert parameter.precision(value) == pytest.approx(parameter.sigma**-2)


@pytest.mark.parametrize("parameter", [PLACE, TOLERANCE], ids=lambda p: p.name)
def test_places_and_declared_quantities_have_one_however_far(parameter: Parameter) -> None:
    value = parameter.centre + 6.0 * parameter.sigma
    assert parameter.penalty(value) == pytest.approx(36.0)


def test_an_amplitude_of_ten_deviations_is_unlikely_and_not_impossible() -> None:
    """Beyond the usual the prior falls with the fourth power of the size, and its slope has no step."""
    once, twice = MASS.penalty(0.01), MASS.penalty(0.02)
    assert twice - once == pytest.approx(4.0 * 2.0 * np.log(2.0))
    assert once < 0.2 * 100.0
    edge = USUAL * MASS.sigma
    assert MASS.penalty(edge * (1 + 1e-9)) == pytest.approx(MASS.penalty(edge), rel=1e-6)


@pytest.mark.parametrize("value", [3e-4, 1.9e-3, 2.1e-3, 0.01, 0.04])
def test_the_precision_is_the_slope_of_the_penalty_over_the_value(value: float) -> None:
    step = 1e-6 * value
    slope = (MASS.penalty(value + step) - MASS.penalty(value - step)) / (2.0 * step)
    assert 2.0 * MASS.precision(value) * value == pytest.approx(slope, rel=1e-5)


def test_a_parameter_of_nonsense_is_refused() -> None:
    for changed in ({"low": 0.06}, {"sigma": 0.0}, {"low": 0.001}, {"shown": "km"}):
        with pytest.raises(ValueError, match="parameter mass"):
            replace(MASS, **changed)
