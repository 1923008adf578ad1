"""Moduli of polypropylene with wrong temperatures."""

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from analysis.arrays import Real
from analysis.plate_temperature.label_check import hysteresis, misplaced

LAW = PchipInterpolator(
    np.arange(-10.0, 71.0, 10.0), np.log([3.30, 3.05, 2.72, 2.30, 1.90, 1.58, 1.33, 1.14, 0.99])
)


def log_modulus(temperature: Real, noise: float = 1e-4) -> Real:
    rng = np.random.default_rng(3)
    return np.asarray(LAW(temperature) + noise * rng.standard_normal(temperature.size))


@pytest.mark.parametrize("spacing", [2.0, 5.0, 10.0])
def test_right_labels_are_left_alone(spacing: float) -> None:
    labels = np.arange(0.0, 61.0, spacing)
    assert misplaced(labels, log_modulus(labels)) == {}
    assert misplaced(labels[::-1], log_modulus(labels[::-1])) == {}


@pytest.mark.parametrize(
    ("spacing", "place", "off"), [(2.0, 10, 1.5), (2.0, 20, -5.0), (5.0, 4, 19.3), (5.0, 6, 5.0), (10.0, 3, 10.0)]
)
def test_the_wrong_label_is_named_with_its_temperature(spacing: float, place: int, off: float) -> None:
    labels = np.arange(0.0, 61.0, spacing)
    true = labels.copy()
    true[place] += off
    found = misplaced(labels, log_modulus(true))
    assert list(found) == [place]
    assert found[place] == pytest.approx(true[place], abs=0.5 * spacing)


@pytest.mark.parametrize("noise", [0.03, 0.1, 0.3])
def test_estimates_that_scatter_tell_nothing(noise: float) -> None:
    labels = np.arange(0.0, 61.0, 5.0)
    assert misplaced(labels, log_modulus(labels, noise)) == {}


def test_labels_that_lead_on_both_ways_differ() -> None:
    labels = np.arange(0.0, 61.0, 5.0)
    up, down = (labels, log_modulus(labels - 1.2)), (labels, log_modulus(labels + 1.2))
    assert hysteresis(up, down) == pytest.approx(2.4, abs=0.2)
    assert hysteresis((labels, log_modulus(labels)), (labels, log_modulus(labels))) is None
    assert hysteresis((labels[:2], log_modulus(labels[:2])), down) is None
