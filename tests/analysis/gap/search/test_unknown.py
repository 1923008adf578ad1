"""How much evidence for an unknown discrepancy white noise holds, and how much a discrepancy does."""

import numpy as np
import pytest

from analysis.gap.search.confidence import noise_evidence, unknown_evidence
from analysis.gap.thresholds import NOISE_BELOW

DRAWS = 300


def noise(sweeps, rng):
    shape = sweeps.rows.shape
    return rng.standard_normal(shape) + 1j * rng.standard_normal(shape)


@pytest.mark.parametrize(
    "campaign",
    [
        {"temperatures": (10.0, 20.0, 30.0), "directions": ("up",)},
        {"temperatures": (10.0, 20.0, 30.0), "directions": ("up", "down"), "levels": (5.0, 10.0)},
    ],
)
def test_the_stated_share_of_noise_has_less_evidence(toy, campaign):
    sweeps, _ = toy.prepared(**campaign)
    state, rng = toy.start(sweeps.groups), np.random.default_rng(3)
    drawn = [unknown_evidence(sweeps, noise(sweeps, rng), state) for _ in range(DRAWS)]
    limit = noise_evidence(sweeps)
    above = np.count_nonzero(np.array(drawn) > limit)
    assert above <= (1.0 - NOISE_BELOW) * DRAWS + 5.0  # three standard deviations of that count
    assert limit < 2.0 * np.quantile(drawn, NOISE_BELOW)


def test_more_ramps_and_levels_hold_more_noise(toy):
    one, _ = toy.prepared(temperatures=(10.0, 20.0, 30.0), directions=("up",))
    four, _ = toy.prepared(temperatures=(10.0, 20.0, 30.0), directions=("up", "down"), levels=(5.0, 10.0))
    assert noise_evidence(four) > 1.5 * noise_evidence(one)


def test_a_smooth_discrepancy_of_a_standard_deviation_stands_out(toy):
    sweeps, _ = toy.prepared(temperatures=(10.0, 20.0, 30.0))
    state, rng = toy.start(sweeps.groups), np.random.default_rng(4)
    wave = np.exp(1j * np.linspace(0.0, 6.0 * np.pi, sweeps.nodes.frequency.size))
    assert unknown_evidence(sweeps, noise(sweeps, rng) + wave, state) > 2.0 * noise_evidence(sweeps)
