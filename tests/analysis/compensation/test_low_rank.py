import numpy as np
import pytest

from analysis.compensation.network import LowRankBank, relative_error
from analysis.focusing.fir import FirBank


def test_filters_of_two_shapes_need_two_principal_filters_and_are_met_exactly(rng):
    """Shares that are cubics of the temperature: nothing is lost to the rank, nor to the spline."""
    shapes = rng.normal(size=(3, 2, 40))
    temperature = np.linspace(0.0, 60.0, 9)

    def taps(t):
        x = np.asarray(t)[:, None, None] / 60.0
        return shapes[0] + x**2 * shapes[1] + (x - x**3) * shapes[2]

    found = LowRankBank.of(FirBank(taps(temperature), temperature, 8_000.0, 20))
    assert len(found.filters) == 2
    fine = np.linspace(0.0, 60.0, 50)
    np.testing.assert_allclose(found.taps(fine), taps(fine), atol=1e-12)
    np.testing.assert_allclose(found.taps([-5.0, 70.0]), taps([0.0, 60.0]), atol=1e-12)


@pytest.mark.parametrize("left_over", [1e-2, 1e-4, 1e-6])
def test_what_is_left_over_is_as_little_as_asked_and_no_filter_is_spare(thirteen, left_over):
    found = LowRankBank.of(thirteen, left_over)
    missed = ((found.taps(thirteen.temperature) - thirteen.taps) ** 2).sum() / (thirteen.taps**2).sum()
    assert missed <= left_over
    fewer = found.coefficient[:, -1] @ found.coefficient[:, -1] / (thirteen.taps**2).sum()
    assert missed + fewer > left_over


def test_it_is_smaller_than_the_filters_and_near_them(thirteen, tones):
    found, fine = LowRankBank.of(thirteen), np.arange(0.0, 60.1, 0.25)
    assert found.filters.size + found.mean.size < thirteen.taps.size
    assert relative_error(found.taps(fine), tones(fine)).max() < 1.0
