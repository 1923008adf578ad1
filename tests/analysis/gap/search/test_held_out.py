"""When held-out data speak for what was found elsewhere, and when against it."""

import numpy as np
import pytest

from analysis.gap.search.held_out import HeldOut, closure_deviation

DOF = 5000.0  # one standard deviation of chi2 is 100


@pytest.mark.parametrize(
    ("before", "after", "closure", "holds"),
    [
        (9000.0, 5050.0, 0.99, True),
        (9000.0, 8000.0, 0.25, False),  # most of a gap stays
        (9000.0, 6500.0, 0.62, True),
        (5350.0, 5210.0, 0.40, True),  # less than half, but what stays is noise
        (5350.0, 5340.0, 0.03, False),
        (5150.0, 5100.0, None, True),  # no gap to close, and yet nearer
        (5150.0, 5160.0, None, False),
        (5900.0, 6000.0, 0.0, False),
    ],
)
def test_what_is_left_must_be_noise_or_the_lesser_half(before, after, closure, holds):
    assert HeldOut("", before, after, DOF, 0.05, 0.02, closure, None).holds is holds


@pytest.mark.parametrize(("gap", "closed"), [(1000.0, 0.8), (4000.0, 0.8), (4000.0, 1.0), (40_000.0, 0.3)])
def test_the_deviation_of_a_closure_is_that_of_repeated_noise(gap, closed):
    """5000 lines, a missing signal of which effects explain a part at right angles to the rest."""
    rng = np.random.default_rng(7)
    noise = rng.normal(size=(1000, int(DOF)))
    left, explained = np.zeros(int(DOF)), np.zeros(int(DOF))
    left[::2] = np.sqrt((1.0 - closed) * gap / (DOF / 2))
    explained[1::2] = np.sqrt(closed * gap / (DOF / 2))
    after = ((noise + left) ** 2).sum(axis=1) - DOF
    before = ((noise + left + explained) ** 2).sum(axis=1) - DOF
    assert closure_deviation(closed, gap, DOF) == pytest.approx(np.std(1.0 - after / before), rel=0.15)
