import numpy as np
import pytest

from analysis.compensation.network import NetworkBank


@pytest.fixture
def bank(rng):
    return NetworkBank((0.0, 60.0), rng.normal(size=(2, 3)), rng.normal(size=(2, 3)), rng.normal(size=(2, 4, 5)))


def test_taps_are_the_formula_of_the_network(bank):
    temperature = np.array([0.0, 17.5, 60.0])
    found = bank.taps(temperature)
    for t, celsius in enumerate(temperature):
        x = celsius / 30.0 - 1.0
        for n in range(2):
            hidden = np.tanh(bank.slope[n] * x + bank.bias[n])
            np.testing.assert_allclose(found[t, n], hidden @ bank.output[n, :3] + bank.output[n, 3])


def test_outside_the_range_the_end_is_held_and_flagged(bank):
    temperature = [-10.0, 0.0, 30.0, 60.0, 61.0, np.nan]
    np.testing.assert_array_equal(bank.outside(temperature), [True, False, False, False, True, True])
    np.testing.assert_array_equal(bank.taps([-10.0, 61.0]), bank.taps([0.0, 60.0]))


def test_nonsense_is_refused(bank):
    with pytest.raises(ValueError, match="must ascend"):
        NetworkBank((60.0, 0.0), bank.slope, bank.bias, bank.output)
    with pytest.raises(ValueError, match=r"\(N, H\+1, M\)"):
        NetworkBank((0.0, 60.0), bank.slope, bank.bias, bank.output[:, :3])
