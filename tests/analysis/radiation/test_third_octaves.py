import numpy as np
import pytest

from analysis.radiation.measures import ripple, third_octave_levels, third_octaves


def test_bands_are_those_of_the_standard_and_share_no_line():
    frequency = np.arange(110.0, 540.0, 1.0)
    middle, member = third_octaves(frequency)
    np.testing.assert_allclose(middle, [125.89, 158.49, 199.53, 251.19, 316.23, 398.11, 501.19], rtol=1e-4)
    assert (member.sum(axis=0) <= 1).all()
    assert frequency[member[3]][[0, -1]] == pytest.approx([224.0, 281.0])


def test_ripple_of_lines_between_two_bands_is_that_of_the_lines():
    """Lines of 105 to 118 Hz lie around the middle of no band; it ended in an error of numpy."""
    frequency = np.linspace(105.0, 118.0, 12)
    assert third_octaves(frequency)[0].size == 0
    assert ripple(np.stack([np.full(12, 2.0 + 0j), np.linspace(1.0, 10.0, 12) + 0j]), frequency) == pytest.approx(
        [0.0, 10.0]
    )


def test_levels_are_means_of_squares_and_ripple_half_their_span():
    frequency = np.arange(100.0, 500.0, 0.5)
    middle, member = third_octaves(frequency)
    response = np.ones(len(frequency), dtype=complex)
    response[member[2]] *= 10.0 ** (2.0 / 20.0)
    response[member[4]] *= 10.0 ** (-1.0 / 20.0) * np.exp(1j * np.arange(member[4].sum()))
    level = third_octave_levels(response[None], frequency)[0]
    wanted = np.zeros(len(middle))
    wanted[2], wanted[4] = 2.0, -1.0
    np.testing.assert_allclose(level, wanted, atol=1e-9)
    assert ripple(response, frequency) == pytest.approx(1.5)
