import numpy as np
import pytest

from analysis.compensation.network import InputMap, NetworkBank

STRAIGHT = InputMap.of(np.array([0.0, 60.0]), np.array([0.0, 60.0]))


@pytest.fixture
def bank(rng):
    return NetworkBank(STRAIGHT, rng.normal(size=(2, 3)), rng.normal(size=(2, 3)), rng.normal(size=(2, 4, 5)))


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
        InputMap(np.array([60.0, 0.0]), np.array([-1.0, 1.0]))
    with pytest.raises(ValueError, match=r"\(N, H\+1, M\)"):
        NetworkBank(STRAIGHT, bank.slope, bank.bias, bank.output[:, :3])


def test_a_falling_coordinate_is_stretched_over_the_whole_input():
    temperature = np.linspace(0.0, 60.0, 241)
    fed = InputMap.of(temperature, -np.sqrt(1.0 + temperature))
    assert (fed.at(0.0)[0], fed.at(60.0)[0]) == (1.0, -1.0)
    middle = 1.0 - 2.0 * (np.sqrt(31.1) - 1.0) / (np.sqrt(61.0) - 1.0)
    np.testing.assert_allclose(fed.at(30.1), middle, atol=1e-5)
    assert fed.temperature_range == (0.0, 60.0)
