"""Sums over a band of the responses of a plate with proportional damping."""

import numpy as np
import pytest

from simulation.reduction.damped_modes import DampedModes

LINES = np.linspace(20.0, 90.0, 400)


@pytest.mark.parametrize("loss", [1e-4, 0.05])
@pytest.mark.parametrize(
    ("rigid", "within"),
    [([], 1e-10), ([0.0, 1e-9, -1e-9], 1e-5)],  # some damping of motions without stiffness turns them by 1e-6
    ids=["held", "free"],
)
def test_gram_is_that_of_the_responses(loss, rigid, within):
    rng = np.random.default_rng(3)
    squares = np.concatenate([rigid, np.geomspace((2 * np.pi * 8) ** 2, 4e7, 15)])
    q = np.linalg.qr(rng.standard_normal((squares.size, squares.size)))[0]
    modes = DampedModes.of((q * squares) @ q.T, rng.standard_normal((squares.size, 2)))
    responses = modes.responses(LINES, loss)
    expected = responses @ responses.T
    np.testing.assert_allclose(modes.gram(LINES, loss), expected, atol=within * np.abs(expected).max())
