"""Materials at which a reduction's error is measured: inside the box, spread over it, new at every attempt."""

import numpy as np
from scipy.stats import qmc

from analysis.material import MaterialBox
from simulation.reduction.vectors.certification import MATERIALS_DRAWN, held_out

BOX = MaterialBox((0.8e9, 4e9), (0.3, 0.49), (0.005, 0.15))


def drawn(attempt: int) -> np.ndarray:
    """Places of the drawn materials in the unit square."""
    found = held_out(BOX, attempt)
    e, nu = np.array(found[1:-1] if attempt == 0 else found).T
    (e0, e1), (n0, n1) = BOX.youngs_modulus, BOX.poisson_ratio
    return np.stack([np.log(e / e0) / np.log(e1 / e0), (nu - n0) / (n1 - n0)], axis=1)


def test_drawn_materials_are_halton_s_points_shifted() -> None:
    known = qmc.Halton(2, scramble=False).random(MATERIALS_DRAWN + 1)[1:]
    for attempt in range(3):
        off = (drawn(attempt) - known) % 1.0
        np.testing.assert_allclose(off, np.broadcast_to(off[0], off.shape), atol=1e-9)


def test_every_attempt_asks_elsewhere_and_the_first_at_the_box_s_sides_too() -> None:
    assert np.abs(drawn(0)[:, None] - drawn(1)[None]).max(axis=2).min() > 0.01
    first = held_out(BOX, 0)
    assert (first[0][0], first[-1][0]) == BOX.youngs_modulus
    assert len(first) == MATERIALS_DRAWN + 2
    assert len(held_out(BOX, 1)) == MATERIALS_DRAWN
