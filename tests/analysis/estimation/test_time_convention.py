"""FRFs of three modes and their conjugates."""

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.estimation.transfer import turns_backward

LINES = {"even": np.arange(20.0, 500.0, 0.5), "logarithmic": np.geomspace(20.0, 500.0, 700)}


def frfs(frequency: NDArray[np.float64], order: int) -> NDArray[np.complex128]:
    s = 2j * np.pi * frequency
    poles = 2 * np.pi * np.array([[60.0], [190.0], [330.0]]) * (-0.01 + 1j)
    modes = s**order / ((s - poles) * (s - poles.conj()))
    return np.array([[1.0, 1.0, 1.0], [0.5, -1.0, 0.7]]) @ modes


@pytest.mark.parametrize("lines", ["even", "logarithmic"])
@pytest.mark.parametrize("order", [0, 1, 2])
def test_conjugates_are_told_from_frfs(lines: str, order: int) -> None:
    h = frfs(LINES[lines], order)
    assert not turns_backward(h)
    assert not turns_backward(-h)
    assert turns_backward(h.conj())


@pytest.mark.parametrize("seed", range(20))
def test_noise_and_nothing_are_no_conjugates(seed: int) -> None:
    rng = np.random.default_rng(seed)
    assert not turns_backward(rng.standard_normal((2, 500)) + 1j * rng.standard_normal((2, 500)))
    assert not turns_backward(np.zeros((2, 500), dtype=complex))


def test_a_sample_of_delay_either_way_is_no_conjugate() -> None:
    delay = np.exp(2j * np.pi * LINES["even"] / 2000.0)
    assert not turns_backward(frfs(LINES["even"], 2) * delay)
