"""The decomposition of answers over a box of materials."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.material import MaterialBox
from simulation.reduction.basis_key import BasisTraining
from simulation.reduction.damped_modes import relative_error
from simulation.reduction.vectors.energy_decomposition import decomposition
from simulation.reduction.vectors.reduce import reduce

BOX = MaterialBox((1e9, 4e9), (0.30, 0.48), (0.005, 0.1))
TOLERANCE = 2e-5


@pytest.fixture(scope="module")
def candidate(coarse_model):
    close = BasisTraining(tolerance=1e-5, poisson_step=0.1)
    return reduce(coarse_model, BOX, (100.0, 900.0), training=close)[0]


@pytest.mark.parametrize("top", [560.0, 640.0])
def test_what_enters_the_band_between_trained_materials_is_kept(candidate, top):
    """Of the softest plate a resonance crosses the band's end at some nu, trained or not."""
    lines, loss = np.linspace(100.0, top, 200), BOX.loss_factor[0]
    within = replace(candidate, band=(100.0, top))
    small = within.restricted(decomposition(within, lines, TOLERANCE))
    assert small.size < 0.8 * candidate.size
    for nu in np.linspace(*BOX.poisson_ratio, 37):
        expected, found = (model.damped_modes(BOX.youngs_modulus[0], nu) for model in (within, small))
        there = expected.lines(loss, lines)
        wrong = relative_error(found.transfers(there, loss), expected.transfers(there, loss), there)
        assert wrong < 2.0 * TOLERANCE, f"nu {nu:g}"
