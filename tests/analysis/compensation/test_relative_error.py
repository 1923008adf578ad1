import numpy as np
import pytest

from analysis.compensation.network import relative_error


def test_it_is_a_ratio_of_energies_in_percent():
    true = np.array([[3.0, 4.0], [1.0, 0.0]])
    off = np.array([[3.0, 4.5], [0.9, 0.0]])
    np.testing.assert_allclose(relative_error(off, true), [100 * 0.25 / 25.0, 1.0])


def test_a_tenth_of_the_amplitude_is_one_percent(rng):
    true = rng.normal(size=(5, 2, 64))
    np.testing.assert_allclose(relative_error(1.1 * true, true), 1.0)
    np.testing.assert_allclose(relative_error(-true, true), 400.0)


def test_nonsense_is_refused():
    with pytest.raises(ValueError, match="differ in shape"):
        relative_error(np.ones((2, 3)), np.ones((3, 3)))
    with pytest.raises(ValueError, match="silent"):
        relative_error(np.ones((2, 3)), np.zeros((2, 3)))
